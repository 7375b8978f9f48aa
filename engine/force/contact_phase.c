/* contact_phase.c - states of a point of contact: within a step its bristle follows the slip, at the end of a step its phase may change. */
#include "force/contact_point.h"
#include "contact/contact.h"

#define JO_CONTACT_PARTS 20.0   /* steps in which a short contact is resolved */
#define JO_CONTACT_LASTS 4.0    /* age of a contact over its duration without loss, from which on it is not short: also with large mass and loss */
#define JO_HARD_STOP 5.0        /* damping u above which an approach is stopped much earlier than without loss: restitutions below 0.2 */
#define JO_NO_SLIP 1e-8     /* slip over the slowest approach of the law below which it is the round-off of an impulse or of a stop: none */
#define JO_BEYOND_REASON 1e3    /* force of a bristle over its limit that no motion has, only round-off of a depth near 0 */
#define JO_DRIVEN 2.0     /* speed of approach of a slip over that of its touch, from which on it is driven in */
#define JO_STEEPEST 1.875         /* mu' velocity / mu_static of the smooth law at rest */

/* A slip has no direction where it is round-off: friction of mu N along it would push anywhere, and its tangent mu N / |slip| has no end. */
static int slides(const jo_contact_law *x, const jo_contact_point *y) { return JO_RE(jo_length3(y->slip)) > JO_NO_SLIP * JO_RE(x->slowest); }

/* whether the bristle is beyond its limit, and is stretched further */
static int breaks(const jo_contact_law *x, const jo_contact_point *y)
{
    return slides(x, y) && JO_RE(y->size) > JO_RE(x->mu_static * y->N) && JO_RE(jo_dot3(y->force, y->slip)) < 0.0;
}

/* Shorten a stretch s beyond all reason to the limit of the bristle. At a depth of round-off, with no speed of approach, the rate d' / d at which the
 * bristle is shortened is arbitrary in the stages of an explicit step. */
static void shorten(const jo_contact_law *x, const jo_contact_point *y, jo_real *s)
{
    const jo_real limit = x->mu_static * y->N;
    if (!(JO_RE(limit) > 0.0 && JO_RE(y->size) > JO_BEYOND_REASON * JO_RE(limit))) return;
    for (int i = 0; i < 3; i++) s[i] *= limit / y->size;
}

/* stretch at which the bristle has the force mu_k N in the direction of a slip e, not longer than `longest` */
static void full_stretch(const jo_contact_law *x, const jo_contact_point *y, const jo_real *e, jo_real longest, jo_real *s)
{
    const jo_real length = jo_length3(e);
    jo_real full = JO_RE(y->shear) > 0.0 ? x->mu_kinetic * y->N / y->shear : 0.0;
    if (JO_RE(full) > JO_RE(longest)) full = longest;
    for (int i = 0; i < 3; i++) s[i] = JO_RE(length) > 0.0 ? full * e[i] / length : 0.0;
}

/* The contact begins with the present speed of approach, or with that of `state` if it is larger. Its bristle follows the slip unless this
 * would stretch it beyond its limit from the first instant on. */
static void touch(const jo_contact_law *x, jo_real time, jo_contact_point *y, jo_real *state)
{
    if (JO_RE(y->rate) > JO_RE(state[JO_CONTACT_SPEED])) state[JO_CONTACT_SPEED] = y->rate;
    state[JO_CONTACT_SINCE] = time;
    jo_contact_press(x, state, y);
    const int smooth = jo_contact_is_smooth(x);
    const int slips = smooth || (slides(x, y) && JO_RE(x->shear * x->exponent * jo_length3(y->slip)) > JO_RE(x->mu_static * y->rate));
    const jo_real none[3] = {0.0, 0.0, 0.0};
    state[JO_CONTACT_PHASE] = jo_same(slips ? JO_CONTACT_SLIPS : JO_CONTACT_STICKS);
    full_stretch(x, y, slips && !smooth ? y->slip : none, jo_same(INFINITY), state + JO_CONTACT_STRETCH);
}

void jo_contact_start(const jo_contact_law *x, jo_real time, jo_contact_point *y, jo_real *state)
{
    for (int i = 0; i < JO_CONTACT_STATES; i++) state[i] = jo_same(0.0);
    state[JO_CONTACT_SPEED] = x->slowest;
    if (!(JO_RE(y->depth) > 0.0)) return;
    const jo_real speed = jo_contact_speed_of_depth(x, y->depth);   /* as if it had come to this depth by itself */
    if (JO_RE(speed) > JO_RE(state[JO_CONTACT_SPEED])) state[JO_CONTACT_SPEED] = speed;
    touch(x, time, y, state);
}

/* v_t, the rate of a bristle that sticks. One that slips is stretched by the slip in its own direction e only, e max(0, e . v_t), and cut at
 * the end of the step: it stores no more than friction has done, and its direction is kept. */
static void stretching(int phase, const jo_real *s, const jo_contact_point *y, jo_real *rate)
{
    const jo_real length = jo_length3(s), along = JO_RE(length) > 0.0 ? jo_dot3(s, y->slip) / length : 0.0;
    jo_set3(rate, y->slip);
    for (int i = 0; i < 3 && phase == JO_CONTACT_SLIPS && JO_RE(length) > 0.0; i++) rate[i] = JO_RE(along) > 0.0 ? along * s[i] / length : 0.0;
}

/* rates of the states from index `state` on: only a bristle moves within a step; it is shortened as its stiffness grows */
void jo_contact_move_states(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_contact_law *x, int state, jo_contact_point *y)
{
    static const jo_slopes_of_state none = {0.0, 0.0, 0.0, 0.0};
    const int phase = jo_contact_phase(d->w + (d->nw - d->forces.nstate) + state), moves = phase != JO_CONTACT_APART && JO_RE(x->shear) > 0.0;
    const jo_real decay = moves ? jo_contact_growth(y) : 0.0;
    jo_real stretch[3] = {0.0};
    if (moves) stretching(phase, jo_states(m, d) + state + JO_CONTACT_STRETCH, y, stretch);
    for (int i = 0; i < JO_CONTACT_STATES; i++) {
        const int k = state + i, bristle = i - JO_CONTACT_STRETCH;
        const jo_real rate = moves && bristle >= 0 ? stretch[bristle] - decay * jo_states(m, d)[k] : 0.0;
        if (jo_condenses(stage)) {
            jo_condense_state(m, d, stage, k, rate, bristle >= 0 ? decay : jo_same(0.0));
            continue;
        }
        jo_state_rates(m, d)[k] = rate;
        if (stage->set && !stage->earlier) d->forces.slopes[k] = none;
    }
    if (moves && jo_condenses(stage)) jo_contact_stretched(jo_states(m, d) + state + JO_CONTACT_STRETCH, y);
}

void jo_contact_hold_states(const jo_model *m, jo_data *d, const jo_stage *stage, int first, int count)
{
    static const jo_slopes_of_state none = {0.0, 0.0, 0.0, 0.0};
    for (int k = first; k < first + count; k++) {
        if (jo_condenses(stage)) {
            jo_condense_state(m, d, stage, k, jo_same(0.0), jo_same(0.0));
            continue;
        }
        jo_state_rates(m, d)[k] = jo_same(0.0);
        if (stage->set && !stage->earlier) d->forces.slopes[k] = none;
    }
}

/* Friction that drives bodies into each other, as a rod that jams, makes them far faster than they touched: beside the speed of the touch the damper
 * would hold like a wall, and explicit methods would follow it by steps of nanoseconds. Such a slip has the loss of its own speed. What sticks,
 * as parts at rest that are struck, keeps its law. */
static void drive_in(const jo_contact_law *x, jo_contact_point *y, jo_real *state)
{
    const int phase = jo_contact_phase(state);
    if ((phase != JO_CONTACT_SLIPS && phase != JO_CONTACT_EASED) || jo_contact_is_smooth(x)) return;
    if (!(JO_RE(y->rate) > JO_DRIVEN * JO_RE(state[JO_CONTACT_SPEED]))) return;
    state[JO_CONTACT_SPEED] = y->rate / JO_DRIVEN;
    jo_contact_press(x, state, y);
    jo_contact_stretched(state + JO_CONTACT_STRETCH, y);
}

/* states of a point that overlaps, by its phase */
static void change_phase(const jo_contact_law *x, const jo_contact_point *y, jo_real *state)
{
    jo_real *s = state + JO_CONTACT_STRETCH;
    const jo_real old[3] = {s[0], s[1], s[2]}, along[3] = {-y->force[0], -y->force[1], -y->force[2]};
    int slips, turned;
    if (jo_contact_is_smooth(x)) return;   /* it has no bristle */
    switch (jo_contact_phase(state)) {
    case JO_CONTACT_STICKS:
        jo_set3(s, y->stretch);
        if (!breaks(x, y)) {
            shorten(x, y, s);
            break;
        }
        state[JO_CONTACT_PHASE] = jo_same(JO_CONTACT_SLIPS);
        full_stretch(x, y, y->slip, jo_length3(y->stretch), s);
        break;
    case JO_CONTACT_EASED:
        slips = JO_RE(y->size) > JO_RE(x->mu_kinetic * y->N);
        state[JO_CONTACT_PHASE] = jo_same(slips ? JO_CONTACT_SLIPS : JO_CONTACT_STICKS);
        if (slips) full_stretch(x, y, along, jo_length3(y->stretch), s);
        else jo_set3(s, y->stretch);
        break;
    case JO_CONTACT_SLIPS:
        turned = JO_RE(jo_dot3(old, y->slip)) < 0.0 || !slides(x, y);
        if (turned) state[JO_CONTACT_PHASE] = jo_same(JO_CONTACT_STICKS);
        full_stretch(x, y, turned ? old : y->slip, jo_length3(y->stretch), s);
        break;
    default: break;
    }
}

jo_real jo_contact_update(const jo_contact_law *x, int waits, jo_real time, jo_contact_point *y, jo_real *state)
{
    const int phase = jo_contact_phase(state), overlaps = JO_RE(y->depth) > 0.0;
    const jo_real before = jo_contact_energy(phase, y);
    const int bounces = jo_contact_may_strike(x) && (waits || fabs(JO_RE(y->rate)) > JO_RE(x->slowest));   /* by an impulse */
    if (phase == JO_CONTACT_APART && bounces) {   /* stays apart */
        state[JO_CONTACT_PHASE] = jo_same(overlaps && JO_RE(y->rate) < 0.0 ? JO_CONTACT_OPENS : JO_CONTACT_APART);
    } else if (phase == JO_CONTACT_APART && overlaps) {
        state[JO_CONTACT_SPEED] = x->slowest;
        touch(x, time, y, state);
    } else if (overlaps) {
        drive_in(x, y, state);
        change_phase(x, y, state);
    } else if (phase != JO_CONTACT_APART) {
        state[JO_CONTACT_PHASE] = jo_same(JO_CONTACT_APART);
        for (int i = 0; i < 3; i++) state[JO_CONTACT_STRETCH + i] = jo_same(0.0);
    }
    jo_contact_stretched(state + JO_CONTACT_STRETCH, y);
    return before - jo_contact_energy(jo_contact_phase(state), y);
}

jo_real jo_contact_margin(const jo_contact_law *x, const jo_real *state, const jo_contact_point *y)
{
    const int phase = jo_contact_phase(state);
    if (phase == JO_CONTACT_APART) return jo_contact_opens(state) && JO_RE(y->rate) < 0.0 ? jo_size(y->depth) : -y->depth;
    jo_real left = y->depth;
    if (phase == JO_CONTACT_STICKS && JO_RE(y->shear) > 0.0 && (breaks(x, y) || JO_RE(y->size) < JO_RE(x->mu_static * y->N))) {
        const jo_real beyond = (x->mu_static * y->N - y->size) / y->shear;
        if (JO_RE(beyond) < JO_RE(left)) left = beyond;
    }
    if (phase == JO_CONTACT_SLIPS && !jo_contact_is_smooth(x)) {
        const jo_real along = jo_dot3(state + JO_CONTACT_STRETCH, y->slip);
        if (JO_RE(along) < JO_RE(left)) left = along;
    }
    return left;
}

/* duration of the touch without loss, s */
static double lasts(const jo_contact_law *x, const jo_real *state) { return jo_contact_lasts(x, JO_RE(state[JO_CONTACT_SPEED])); }

void jo_contact_begun(const jo_data *d, const jo_contact_law *x, int first, const jo_real *state)
{
    if (jo_contact_phase(state) != JO_CONTACT_APART && JO_RE(x->resolve) == JO_RESOLVE_REPORT) jo_note_touch(d, first, lasts(x, state));
}

/* Smooth friction stops a slip in parts that halve it, until it is below the velocity of the law: a linearly implicit step from a large slip
 * does not see that the friction turns, and would jump across. */
static double slowing_step(const jo_contact_law *x, const jo_contact_point *y)
{
    const double slip = JO_RE(jo_length3(y->slip)), force = JO_RE(x->mu_static * y->N);
    return slip > JO_RE(x->velocity) && force > 0.0 ? 0.5 * slip * JO_RE(x->mass) / force : INFINITY;
}

/* Share of the duration without loss after which the approach has been stopped by a damping u: of m v dv/dd = -K d^n (1 + u v / v_in) the second
 * term is the larger one, and d = d_max (2 / u)^(1/(n+1)) then. 1 up to JO_HARD_STOP. */
static double stopping_share(const jo_contact_law *x)
{
    const double u = jo_contact_may_strike(x) ? 0.0 : JO_RE(x->damping);
    return u > JO_HARD_STOP ? pow(JO_HARD_STOP / u, 1.0 / (JO_RE(x->exponent) + 1.0)) : 1.0;
}

/* longest step of a contact in which it is resolved */
static double resolved_step(const jo_contact_law *x, const jo_real *state, double age)
{
    const double T = lasts(x, state), share = stopping_share(x);
    if (age < share * T) return share * T / JO_CONTACT_PARTS;
    return age < JO_CONTACT_LASTS * T ? T / JO_CONTACT_PARTS : INFINITY;
}

/* A short contact is resolved in JO_CONTACT_PARTS steps, and in as many until a strong damping has stopped the approach. An explicit method is
 * stable up to some 2 / (omega + c / mass), omega^2 = k / mass; several contacts of one body add up. */
double jo_contact_longest_step(const jo_contact_law *x, const jo_real *state, jo_real time, int explicit_method, const jo_contact_point *y)
{
    double longest = INFINITY;
    if (jo_contact_phase(state) == JO_CONTACT_APART) return longest;
    if (JO_RE(x->resolve) != JO_RESOLVE_REPORT) longest = resolved_step(x, state, JO_RE(time - state[JO_CONTACT_SINCE]));
    if (y && jo_contact_is_smooth(x)) longest = fmin(longest, slowing_step(x, y));
    if (explicit_method) {
        double rate = sqrt(fabs(JO_RE(y->by_depth / x->mass))) + JO_RE(y->by_rate / x->mass);
        if (jo_contact_is_smooth(x)) rate += JO_STEEPEST * JO_RE(x->mu_static * y->N / (x->velocity * x->mass));
        longest = fmin(longest, JO_CONTACT_STABLE / rate);
    }
    return longest;
}

int jo_contact_ease(jo_real *state)
{
    if (jo_contact_phase(state) == JO_CONTACT_APART || jo_contact_phase(state) == JO_CONTACT_EASED) return 0;
    state[JO_CONTACT_PHASE] = jo_same(JO_CONTACT_EASED);
    return 1;
}
