/* force_contact.c - a sphere or point fixed to b touches a shape fixed to a: normal force with restitution, friction by a bristle.
 *
 * d = -gap, s: stretch of the bristle, v_t: slip velocity of b on a. Resolved in frame a, on b, at a common point in the middle of the overlap:
 *   N = K d^n (1 + (u / v_in) d') + c step(d / d1) d' >= 0          (Hunt, Crossley, Journal of Applied Mechanics 42 (1975), 440-445)
 *   sticks: F_t = -(k_t s + c_t v_t), s' = v_t - s max(0, k_t'/k_t),   k_t = shear dN/dd, c_t = shear (u / v_in) K d^n
 *   slips:  F_t = -mu_k N v_t / |v_t|
 * u follows from the restitution e: u (1 + e) = log((1 + u) / (1 - e u)), for any K, n and mass. While k_t grows, the force of a bristle
 * changes by its new stretch only; while it falls, the force falls with it: no energy appears.
 *
 * The direction of a slip is not smooth where it stops. A step of an implicit method that therefore does not converge is repeated with a
 * bristle that slips at mu_k N within the step (eased), as in plasticity.
 *
 * Resistance to rolling and drilling: see contact_turn.c.
 *
 * States: phase (0 apart, 1 sticks, 2 slips, 3 eased), approach speed v_in at the touch, time of the touch, s. Steps end where a phase ends
 * (margin); within a step the phase is constant. See contact_tip.c, contact_law.c and contact_phase.c. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/contact_tip.h"
#include "force/contact_turn.h"
#include "friction/friction.h"

static const jo_contact_data *numbers(const jo_force *f) { return (const jo_contact_data *)f->data; }
static jo_real *states(const jo_data *d, const jo_force *f) { return d->w + (d->nw - d->forces.nstate) + f->state; }

/* the point in motion; `state`: NULL for one whose force is not needed */
static void present(const jo_model *m, const jo_data *d, const jo_force *f, const jo_real *state, jo_contact_tip *tip, jo_contact_point *y)
{
    jo_contact_place(d, f, tip, y);
    jo_relative_velocity(m, d, f, y->v, y->w);
    jo_contact_slide(y);
    if (!state) return;
    jo_contact_press(jo_contact_law_of(f), state, y);
    jo_contact_stretched(state + JO_CONTACT_STRETCH, y);
}

int jo_contact_touches(const jo_data *d, const jo_force *f)
{
    return jo_contact_phase(states(d, f)) != JO_CONTACT_APART && !jo_released(d, f->release);
}

jo_real jo_contact_normal_force(const jo_model *m, const jo_data *d, const jo_force *f)
{
    jo_contact_tip tip;
    jo_contact_point y;
    if (!jo_contact_touches(d, f)) return jo_same(0.0);
    present(m, d, f, states(d, f), &tip, &y);
    return y.N;
}

static jo_real stored(const jo_data *d, const jo_force *f)
{
    const jo_contact_law *x = jo_contact_law_of(f);
    const jo_real *state = states(d, f);
    jo_contact_tip tip;
    jo_contact_point y;
    jo_contact_place(d, f, &tip, &y);
    jo_contact_press(x, state, &y);
    jo_contact_stretched(state + JO_CONTACT_STRETCH, &y);
    return jo_contact_energy(jo_contact_phase(state), &y) + (jo_contact_turns(f) ? jo_turn_energy(numbers(f), state, &y) : jo_same(0.0));
}

/* in the matrix of a Rosenbrock method */
static void add_implicit(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_contact_tip *tip, const jo_contact_point *y)
{
    jo_contact_change moves[6];   /* with position and velocity of b */
    for (int k = 0; k < 6 && !stage->earlier; k++) moves[k] = jo_contact_tip_change(numbers(f), tip, y, k < 3 ? k : k + 3);
    jo_contact_implicit(m, d, stage, f, f->state, y, moves);
    if (jo_contact_turns(f)) jo_turn_implicit(m, d, stage, f, y);
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *out)
{
    static const jo_force_work none = {{0.0}, 0.0, 0.0, 0.0};
    const jo_contact_law *x = jo_contact_law_of(f);
    const int phase = jo_contact_phase(states(d, f));
    jo_contact_tip tip;
    jo_contact_point y;
    present(m, d, f, states(d, f), &tip, &y);
    jo_contact_move_states(m, d, stage, x, f->state, &y);
    if (jo_contact_turns(f)) jo_turn_move_states(m, d, stage, f, &y);
    else jo_contact_hold_states(m, d, stage, f->state + JO_CONTACT_STATES, f->states - JO_CONTACT_STATES);   /* of a slot */
    if (stage->contacts) add_implicit(m, d, stage, f, &tip, &y);
    *out = none;
    if (phase == JO_CONTACT_APART) {
        jo_real v[3];
        jo_contact_tip_velocity(&tip, &y, v);
        jo_see_speed(d, f->state, v);
    }
    const int acts = phase != JO_CONTACT_APART && JO_RE(y.depth) > 0.0;
    if (!acts && !jo_blows(d)) return JO_OK;
    jo_real F[6] = {0.0};
    if (acts) {
        jo_contact_force(x, phase, &y, F, &d->power);
        out->stored = jo_contact_energy(phase, &y);
        if (jo_contact_turns(f)) {
            jo_turn_moment(numbers(f), states(d, f), &y, F + 3, &d->power);
            out->stored += jo_turn_energy(numbers(f), states(d, f), &y);
        }
    }
    if (jo_blows(d)) jo_add_blow(d, f->state, y.lever, F);
    jo_push_between(m, d, f, F, out);
    return JO_OK;
}

static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *unused)
{
    (void)unused;
    const jo_contact_law *x = jo_contact_law_of(f);
    const jo_real *state = states(d, f);
    jo_contact_tip tip;
    jo_contact_point y;
    jo_work power = {0.0, 0.0, 0.0};
    present(m, d, f, state, &tip, &y);
    if (jo_contact_phase(state) == JO_CONTACT_APART || !(JO_RE(y.depth) > 0.0)) return JO_OK;
    jo_real F[6], dF[6], X[6][12];
    jo_contact_force(x, jo_contact_phase(state), &y, F, &power);
    if (jo_contact_turns(f)) jo_turn_moment(numbers(f), state, &y, F + 3, &power);
    for (int k = 0; k < 12; k++) {
        const jo_contact_change c = jo_contact_tip_change(numbers(f), &tip, &y, k);
        jo_contact_response(x, stage, state, &y, &c, k, F, dF);
        if (jo_contact_turns(f)) jo_turn_response(numbers(f), stage, state, &y, &c, k, dF + 3);
        for (int i = 0; i < 6; i++) X[i][k] = dF[i];
    }
    jo_newton_between(m, d, f, F, X);
    return JO_OK;
}

static void start(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    jo_contact_tip tip;
    jo_contact_point y;
    present(m, d, f, 0, &tip, &y);
    jo_contact_start(jo_contact_law_of(f), d->time[0], &y, state);
    if (jo_contact_turns(f)) jo_turn_start(numbers(f), &y, state);
}

/* no error control by the stretch: it follows the positions */
static void nominals(const jo_model *m, const jo_force *f, double duration, double *x)
{
    (void)m; (void)duration;
    for (int i = 0; i < f->states; i++) x[i] = 1.0;
}

static jo_real update(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    jo_contact_tip tip;
    jo_contact_point y;
    const int apart = jo_contact_phase(state) == JO_CONTACT_APART;
    present(m, d, f, states(d, f), &tip, &y);
    const int turns = jo_contact_turns(f);
    const jo_real before = turns ? jo_turn_energy(numbers(f), state, &y) : jo_same(0.0);
    jo_real lost = jo_contact_update(jo_contact_law_of(f), jo_touches_wait(d), d->time[0], &y, state);
    if (turns) {
        if (apart) jo_turn_start(numbers(f), &y, state);
        else jo_turn_update(numbers(f), &y, state);
        lost += before - jo_turn_energy(numbers(f), state, &y);
    }
    if (apart) jo_contact_begun(d, jo_contact_law_of(f), f->state, state);
    return lost;
}

static jo_real margin(const jo_model *m, const jo_data *d, const jo_force *f)
{
    jo_contact_tip tip;
    jo_contact_point y;
    present(m, d, f, states(d, f), &tip, &y);
    return jo_contact_margin(jo_contact_law_of(f), states(d, f), &y);
}

static double longest_step(const jo_model *m, const jo_data *d, const jo_force *f, int explicit_method)
{
    jo_contact_tip tip;
    jo_contact_point y;
    const int touches = jo_contact_phase(states(d, f)) != JO_CONTACT_APART;
    const int moves = touches && (explicit_method || jo_contact_is_smooth(jo_contact_law_of(f)));
    if (moves) present(m, d, f, states(d, f), &tip, &y);
    const double longest = jo_contact_longest_step(jo_contact_law_of(f), states(d, f), d->time[0], explicit_method, moves ? &y : 0);
    if (!explicit_method || !jo_contact_turns(f) || !touches) return longest;
    return fmin(longest, JO_CONTACT_STABLE / jo_turn_rate(numbers(f), &y));
}

static int ease(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    (void)m; (void)d; (void)f;
    return jo_contact_ease(state);
}

static int approach(const jo_model *m, const jo_data *d, const jo_force *f, jo_approach *to)
{
    jo_contact_tip tip;
    jo_contact_point y;
    if (jo_contact_phase(states(d, f)) != JO_CONTACT_APART) return 0;
    present(m, d, f, 0, &tip, &y);
    jo_contact_tip_approach(numbers(f), &tip, &y, to);
    to->seen = f->state;
    return 1;
}

static int strikes(const jo_model *m, const jo_data *d, const jo_force *f, jo_strike *list, int room)
{
    jo_contact_tip tip;
    jo_contact_point y;
    if (!room || !jo_contact_may_strike(jo_contact_law_of(f))) return 0;
    present(m, d, f, 0, &tip, &y);
    return jo_contact_strike(jo_contact_law_of(f), jo_touches_wait(d), f, f->state, states(d, f), &y, list);
}

/* a bristle that breaks changes mu_static to mu_kinetic */
static int jumps(const jo_force *f, const jo_real *before, const jo_real *after)
{
    (void)f;
    return jo_contact_phase(before) != jo_contact_phase(after);
}

/* friction by rows: state, force on b, power */
static void add_sticking(const jo_model *m, const jo_data *d, const jo_force *f, jo_touch *t)
{
    const int i = m->nfriction ? jo_friction_of_contact(m, f) : -1;
    if (i < 0 || t->phase == JO_CONTACT_APART) return;
    const jo_friction *rub = &m->friction[i];
    t->phase = jo_sticks(m, d, rub) ? JO_CONTACT_STICKS : JO_CONTACT_SLIPS;
    for (int k = 0; k < 2; k++) {
        const jo_coordinate_work *w = &d->coordinate[jo_slip_of(rub, k)];
        const double force = JO_RE(d->rub[2 * i + k]);
        for (int j = 0; j < 3; j++) t->friction[j] += force * JO_RE(w->along[j]);
        t->power[1] -= force * JO_RE(w->rate);
    }
}

static int touches(const jo_model *m, const jo_data *d, const jo_force *f, const jo_real *state, jo_touch *t, jo_real *sums)
{
    jo_contact_tip tip;
    jo_contact_point y;
    present(m, d, f, state, &tip, &y);
    jo_contact_touch(d->marker[f->a].A, d->marker[f->b].r, jo_contact_law_of(f), state, &y, t, sums);
    if (jo_contact_turns(f)) jo_turn_touch(numbers(f), state, &y, t, sums);
    add_sticking(m, d, f, t);
    return 1;
}

static const jo_yielding yielding = {update, margin, jumps, longest_step, ease, approach, strikes, touches, 0};
const jo_force_kind jo_force_contact = {apply, stored, tangent, start, nominals, &yielding};
