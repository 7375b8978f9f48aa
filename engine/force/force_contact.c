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
 * States: phase (0 apart, 1 sticks, 2 slips, 3 eased), approach speed v_in at the touch, time of the touch, s. Steps end where a phase ends
 * (margin below); within a step the phase is constant. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"
#include "contact/contact.h"

enum { PHASE, APPROACH, SINCE, STRETCH, STATES = STRETCH + 3 };
enum { APART, STICKS, SLIPS, EASED };
#define JO_CONTACT_PARTS 20.0   /* steps in which a short contact is resolved */
#define JO_CONTACT_LASTS 4.0    /* age of a contact over its duration without loss, from which on it is not short: also with large mass and loss */
#define JO_CONTACT_STABLE 0.5   /* step of an explicit method times the rate of a contact */

/* x^y, x > 0 */
static jo_real power(jo_real x, jo_real y)
{
    if (JO_RE(y) == 1.0) return x;
    if (JO_RE(y) == 1.5) return x * jo_sqrt(x);
#ifdef JO_COMPLEX
    return cpow(x, y);
#else
    return pow(x, y);
#endif
}

static jo_real length3(const jo_real *x)
{
    const jo_real square = jo_dot3(x, x);
    return JO_RE(square) > 0.0 ? jo_sqrt(square) : 0.0;
}

/* The contact at the present positions and velocities, resolved in a. */
typedef struct {
    jo_real w[3], arm[3];           /* relative angular velocity; centre of the sphere from the origin of b */
    jo_real axis[3], out[3], along, sine;   /* of a ring: its axis z, direction u of its lowest point, n . z, |n - (n . z) z| */
    jo_distance from;               /* distance of the centre from the shape */
    jo_real depth, rate;            /* d, d' */
    jo_real lever[3];               /* contact point from the origin of b */
    jo_real v[3], slip[3];          /* velocity of b on a there, and its part in the contact plane */
    jo_real stretch[3];             /* s in the contact plane */
    jo_real elastic, normal, by_depth, by_rate;   /* K d^n; N and its derivatives */
    jo_real shear, shear_rate;      /* k_t and its derivative with respect to d */
    jo_real loss;                   /* c_t */
    jo_real force[3], size;         /* force of the bristle before its limit: -(k_t s + c_t v_t), and its length */
} contact;

static const jo_contact_data *numbers(const jo_force *f) { return (const jo_contact_data *)f->data; }
static jo_real *states(const jo_data *d, const jo_force *f) { return d->w + (d->nw - d->forces.nstate) + f->state; }
static int follows(int phase) { return phase == STICKS || phase == EASED; }   /* whether the bristle moves within a step */
static int phase_of(const jo_real *x) { return (int)JO_RE(x[PHASE]); }

/* step of Adams: cubic from 0 to 1, and its derivative */
static jo_real cubic_step(jo_real x, jo_real *slope)
{
    *slope = jo_same(0.0);
    if (JO_RE(x) >= 1.0) return jo_same(1.0);
    if (JO_RE(x) <= 0.0) return jo_same(0.0);
    *slope = 6.0 * x * (1.0 - x);
    return x * x * (3.0 - 2.0 * x);
}

/* vector from the centre of a ring to its lowest point, in direction -n: ring u, u = -(n - (n . z) z) / |n - (n . z) z|, z its axis */
static void lowest(const jo_contact_data *x, const jo_real *R, const jo_real *n, contact *y)
{
    jo_axis(y->axis, R, 2);
    y->along = jo_dot3(n, y->axis);
    for (int i = 0; i < 3; i++) y->out[i] = y->along * y->axis[i] - n[i];
    y->sine = length3(y->out);
    for (int i = 0; i < 3; i++) {
        y->out[i] = JO_RE(y->sine) > 0.0 ? y->out[i] / y->sine : R[3 * i];   /* flat on the plane: along x */
        y->arm[i] += x->ring * y->out[i];
    }
}

/* change of ring u with a rotation e */
static void lowest_change(const jo_contact_data *x, const contact *y, const jo_real *e, jo_real *c)
{
    if (!(JO_RE(y->sine) > 0.0)) return;
    const jo_real *n = y->from.normal;
    jo_real dz[3], da[3];
    jo_cross(dz, e, y->axis);
    const jo_real dalong = jo_dot3(n, dz), dsine = -y->along * dalong / y->sine;
    for (int i = 0; i < 3; i++) da[i] = (dalong * y->axis[i] + y->along * dz[i] - dsine * y->out[i]) / y->sine;
    jo_axpy3(c, x->ring, da);
}

/* depth and contact point; at rest */
static void place(const jo_data *d, const jo_force *f, contact *y)
{
    const jo_contact_data *x = numbers(f);
    jo_real R[9], at[3];
    jo_relative_pose(d, f, at, R);
    jo_mul3(y->arm, R, x->centre);
    if (JO_RE(x->ring) > 0.0) {   /* its lowest point above a half-space */
        static const jo_real up[3] = {0.0, 0.0, 1.0};
        lowest(x, R, up, y);
    }
    jo_add3(at, y->arm);
    jo_shape_distance((int)JO_COMMON(x->shape), x->size, at, &y->from);
    y->depth = x->radius - y->from.gap;
    y->rate = jo_same(0.0);
    for (int i = 0; i < 3; i++) {
        y->lever[i] = y->arm[i] - (x->radius - 0.5 * y->depth) * y->from.normal[i];
        y->slip[i] = jo_same(0.0);
    }
}

/* rate of the depth and slip velocity */
static void move(const jo_model *m, const jo_data *d, const jo_force *f, contact *y)
{
    jo_real at[3];
    jo_relative_velocity(m, d, f, y->v, y->w);
    jo_cross(at, y->w, y->lever);
    jo_add3(y->v, at);
    y->rate = -jo_dot3(y->from.normal, y->v);
    jo_set3(y->slip, y->v);
    jo_axpy3(y->slip, y->rate, y->from.normal);
}

/* N and its derivatives, for the approach speed of the states; 0 without overlap */
static void press(const jo_contact_data *x, const jo_real *state, contact *y)
{
    const jo_real none = jo_same(0.0);
    y->elastic = y->normal = y->by_depth = y->by_rate = y->shear = y->shear_rate = y->loss = none;
    if (!(JO_RE(y->depth) > 0.0)) return;
    const jo_real once = x->stiffness * power(y->depth, x->exponent - 1.0), a = x->damping / state[APPROACH];
    jo_real steepness, c = x->viscous;
    y->elastic = once * y->depth;
    jo_real dc = none;
    if (JO_RE(x->full) > 0.0) {
        c = x->viscous * cubic_step(y->depth / x->full, &steepness);
        dc = x->viscous * steepness / x->full;
    }
    y->by_rate = a * y->elastic + c;
    y->normal = y->elastic + y->by_rate * y->rate;
    y->by_depth = x->exponent * once * (1.0 + a * y->rate) + dc * y->rate;
    y->shear = x->shear * x->exponent * once;
    y->shear_rate = y->shear * (x->exponent - 1.0) / y->depth;
    y->loss = x->shear * a * y->elastic;
    if (JO_RE(y->normal) < 0.0) y->normal = y->by_depth = y->by_rate = none;   /* it never pulls */
}

/* bristle in the contact plane, with its force before the limit */
static void stretch(const jo_real *s, contact *y)
{
    const jo_real out = jo_dot3(s, y->from.normal);
    for (int i = 0; i < 3; i++) {
        y->stretch[i] = s[i] - out * y->from.normal[i];
        y->force[i] = -(y->shear * y->stretch[i] + y->loss * y->slip[i]);
    }
    y->size = length3(y->force);
}

static contact present(const jo_model *m, const jo_data *d, const jo_force *f)
{
    contact y;
    place(d, f, &y);
    move(m, d, f, &y);
    press(numbers(f), states(d, f), &y);
    stretch(states(d, f) + STRETCH, &y);
    return y;
}

/* whether the bristle is beyond its limit, and is stretched further */
static int breaks(const jo_contact_data *x, const contact *y)
{
    return JO_RE(y->size) > JO_RE(x->mu_static * y->normal) && JO_RE(jo_dot3(y->force, y->slip)) < 0.0;
}

static jo_real energy_of(const jo_contact_data *x, int phase, const contact *y)
{
    if (phase == APART) return jo_same(0.0);
    const jo_real U = y->elastic * y->depth / (x->exponent + 1.0);
    return follows(phase) ? U + 0.5 * y->shear * jo_dot3(y->stretch, y->stretch) : U;
}

static jo_real stored(const jo_data *d, const jo_force *f)
{
    contact y;
    place(d, f, &y);
    press(numbers(f), states(d, f), &y);
    stretch(states(d, f) + STRETCH, &y);
    return energy_of(numbers(f), phase_of(states(d, f)), &y);
}

/* Friction force F = -mu N z / |z|: z is the slip velocity, or minus the force of the bristle. A slip that has turned within the step keeps
 * the direction of the end of the last step, so that the force is smooth up to the end of the phase, which is located. */
typedef struct { jo_real z[3], length, mu; int kept; } limited;

/* 0 if the bristle is within its limit */
static int is_limited(const jo_contact_data *x, int phase, const contact *y, limited *l)
{
    l->mu = phase == STICKS ? x->mu_static : x->mu_kinetic;
    l->kept = phase == SLIPS && JO_RE(jo_dot3(y->slip, y->stretch)) < 0.0;
    for (int i = 0; i < 3; i++) l->z[i] = l->kept ? y->stretch[i] : phase == SLIPS ? y->slip[i] : -y->force[i];
    l->length = length3(l->z);
    return phase == SLIPS || JO_RE(y->size) > JO_RE(l->mu * y->normal);
}

static void friction(const jo_contact_data *x, int phase, const contact *y, jo_real *F)
{
    limited l;
    if (!is_limited(x, phase, y, &l)) {
        jo_set3(F, y->force);
        return;
    }
    const jo_real share = JO_RE(l.length) > 0.0 ? l.mu * y->normal / l.length : 0.0;
    for (int i = 0; i < 3; i++) F[i] = -share * l.z[i];
}

/* relative rate of the shear stiffness while it grows */
static jo_real growth(const contact *y)
{
    const jo_real g = JO_RE(y->depth) > 0.0 ? y->shear_rate * y->rate / y->shear : 0.0;
    return JO_RE(g) > 0.0 ? g : 0.0;
}

/* rates of the states: only a bristle that sticks moves within a step */
static void move_states(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, int phase, contact *y)
{
    static const jo_slopes_of_state none = {0.0, 0.0, 0.0, 0.0};
    const int moves = follows(phase) && JO_RE(numbers(f)->shear) > 0.0;
    const jo_real decay = moves ? growth(y) : 0.0;
    for (int i = 0; i < STATES; i++) {
        const int k = f->state + i;
        const jo_real rate = moves && i >= STRETCH ? y->slip[i - STRETCH] - decay * jo_states(m, d)[k] : 0.0;
        if (jo_condenses(stage)) {
            jo_condense_state(m, d, stage, k, rate, i >= STRETCH ? decay : jo_same(0.0));
            continue;
        }
        jo_state_rates(m, d)[k] = rate;
        if (stage->set && !stage->earlier) d->forces.slopes[k] = none;
    }
    if (moves && jo_condenses(stage)) stretch(jo_states(m, d) + f->state + STRETCH, y);
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *out)
{
    static const jo_force_work none = {{0.0}, 0.0, 0.0, 0.0};
    const jo_contact_data *x = numbers(f);
    const int phase = phase_of(states(d, f));
    contact y = present(m, d, f);
    move_states(m, d, stage, f, phase, &y);
    *out = none;
    if (phase == APART || !(JO_RE(y.depth) > 0.0)) return JO_OK;
    jo_real F[6], tangential[3];
    friction(x, phase, &y, tangential);
    for (int i = 0; i < 3; i++) F[i] = y.normal * y.from.normal[i] + tangential[i];
    jo_cross(F + 3, y.lever, F);
    out->stored = energy_of(x, phase, &y);
    d->power.damping += (y.normal - y.elastic) * y.rate;
    d->power.friction -= jo_dot3(tangential, y.slip);
    if (follows(phase)) {   /* less what the bristle stores */
        const jo_real s2 = jo_dot3(y.stretch, y.stretch);
        d->power.friction -= y.shear * jo_dot3(y.stretch, y.slip) + (0.5 * y.shear_rate * y.rate - y.shear * growth(&y)) * s2;
    }
    jo_push_between(m, d, f, F, out);
    return JO_OK;
}

/* Changes with one of [position, rotation, velocity, angular velocity] of b against a. */
typedef struct { jo_real depth, rate, normal[3], lever[3], slip[3]; } change;

/* unit change k (0..11) of the motion of b */
static change changes(const contact *y, const jo_contact_data *x, int k)
{
    change c = {0.0, 0.0, {0.0}, {0.0}, {0.0}};
    jo_real e[3] = {0.0, 0.0, 0.0}, v[3] = {0.0, 0.0, 0.0};
    const jo_real *n = y->from.normal;
    e[k % 3] = 1.0;
    if (k < 6) {
        jo_real centre[3] = {0.0, 0.0, 0.0};
        if (k < 3) jo_set3(centre, e);
        else jo_cross(centre, e, y->arm);
        if (k >= 3 && JO_RE(x->ring) > 0.0) {   /* the axis carries the centre, not the lowest point */
            jo_real fixed[3];
            jo_set3(fixed, y->arm);
            jo_axpy3(fixed, -x->ring, y->out);
            jo_cross(centre, e, fixed);
            lowest_change(x, y, e, centre);
        }
        c.depth = -jo_dot3(n, centre);
        jo_mul3(c.normal, y->from.hessian, centre);
        if (k >= 3) jo_set3(c.lever, centre);
        for (int i = 0; i < 3; i++) c.lever[i] += 0.5 * c.depth * n[i] - (x->radius - 0.5 * y->depth) * c.normal[i];
        jo_cross(v, y->w, c.lever);
    } else if (k < 9) {
        jo_set3(v, e);
    } else {
        jo_cross(v, e, y->lever);
    }
    c.rate = -jo_dot3(c.normal, y->v) - jo_dot3(n, v);
    for (int i = 0; i < 3; i++) c.slip[i] = v[i] + c.rate * n[i] + y->rate * c.normal[i];
    return c;
}

/* change of the friction force, for the changes c of the contact, dN of the normal force and ds of the stretch */
static void friction_change(const jo_contact_data *x, int phase, const contact *y, const change *c, jo_real dN, const jo_real *ds, jo_real *dF)
{
    limited l;
    jo_real z[3];
    const int cut = is_limited(x, phase, y, &l);
    const jo_real dk = y->shear_rate * c->depth, dloss = JO_RE(y->elastic) > 0.0 ? y->loss * x->exponent * c->depth / y->depth : 0.0;
    for (int i = 0; i < 3; i++)
        z[i] = l.kept ? ds[i] : phase == SLIPS ? c->slip[i] : dk * y->stretch[i] + y->shear * ds[i] + dloss * y->slip[i] + y->loss * c->slip[i];
    if (!cut) {
        for (int i = 0; i < 3; i++) dF[i] = -z[i];
        return;
    }
    if (!(JO_RE(l.length) > 0.0)) {
        for (int i = 0; i < 3; i++) dF[i] = 0.0;
        return;
    }
    const jo_real along = jo_dot3(l.z, z) / l.length, limit = l.mu * y->normal;
    for (int i = 0; i < 3; i++) {
        const jo_real e = l.z[i] / l.length;
        dF[i] = -l.mu * dN * e - limit * (z[i] - along * e) / l.length;
    }
}

/* change of the stretch: within the contact plane, with the response of its state to the slip velocity in a step, or with the displacement */
static void stretch_change(const jo_stage *stage, const jo_real *state, const contact *y, const change *c, int k, jo_real *ds)
{
    const double ca = stage->weights.a, cv = stage->weights.v;
    const jo_real *n = y->from.normal, g = growth(y);
    const int steps = ca != 0.0 && cv != 0.0;
    jo_real raw[3];
    const int moves = follows(phase_of(state));
    for (int i = 0; i < 3; i++) {
        raw[i] = 0.0;
        if (steps && moves) {
            const jo_real dg = JO_RE(g) > 0.0 ? g * (c->rate / y->rate - c->depth / y->depth) : 0.0;
            raw[i] = cv / (ca + cv * g) * (c->slip[i] - dg * state[STRETCH + i]);
        }
    }
    if (!steps && moves && k < 6) {   /* displacement of b on a at the contact point */
        jo_real e[3] = {0.0, 0.0, 0.0};
        e[k % 3] = 1.0;
        if (k < 3) jo_set3(raw, e);
        else jo_cross(raw, e, y->lever);
    }
    const jo_real out = jo_dot3(state + STRETCH, n), dout = jo_dot3(state + STRETCH, c->normal) + jo_dot3(raw, n);
    for (int i = 0; i < 3; i++) ds[i] = raw[i] - dout * n[i] - out * c->normal[i];
}

static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *unused)
{
    (void)unused;
    const jo_contact_data *x = numbers(f);
    const jo_real *state = states(d, f);
    const int phase = phase_of(state);
    const contact y = present(m, d, f);
    if (phase == APART || !(JO_RE(y.depth) > 0.0)) return JO_OK;
    jo_real F[6], X[6][12], ds[3], dF[3], t[3];
    friction(x, phase, &y, F + 3);
    for (int i = 0; i < 3; i++) F[i] = y.normal * y.from.normal[i] + F[3 + i];
    for (int k = 0; k < 12; k++) {
        const change c = changes(&y, x, k);
        const jo_real dN = y.by_depth * c.depth + y.by_rate * c.rate;
        stretch_change(stage, state, &y, &c, k, ds);
        friction_change(x, phase, &y, &c, dN, ds, dF);
        for (int i = 0; i < 3; i++) X[i][k] = dF[i] += dN * y.from.normal[i] + y.normal * c.normal[i];
        jo_cross(t, y.lever, dF);
        jo_cross(dF, c.lever, F);
        for (int i = 0; i < 3; i++) X[3 + i][k] = t[i] + dF[i];
    }
    jo_cross(F + 3, y.lever, F);
    jo_newton_between(m, d, f, F, X);
    return JO_OK;
}

/* stretch at which the bristle has the force mu_k N in the direction of a slip e */
static void full_stretch(const jo_contact_data *x, const contact *y, const jo_real *e, jo_real *s)
{
    const jo_real length = length3(e);
    const jo_real share = JO_RE(length) > 0.0 && JO_RE(y->shear) > 0.0 ? x->mu_kinetic * y->normal / (y->shear * length) : 0.0;
    for (int i = 0; i < 3; i++) s[i] = share * e[i];
}

/* speed of approach, m/s, from which a contact without loss would have reached the present depth */
static jo_real speed_of_depth(const jo_contact_data *x, const contact *y)
{
    const jo_real n = x->exponent + 1.0;
    const jo_real square = 2.0 * x->stiffness * power(y->depth, n) / (n * x->mass);
    return jo_sqrt(square);
}

/* The contact begins with the present speed of approach, or with that of `state` if it is larger. Its bristle follows the slip unless this
 * would stretch it beyond its limit from the first instant on. */
static void touch(const jo_contact_data *x, const jo_data *d, contact *y, jo_real *state)
{
    if (JO_RE(y->rate) > JO_RE(state[APPROACH])) state[APPROACH] = y->rate;
    state[SINCE] = d->time[0];
    press(x, state, y);
    const int slips = JO_RE(x->shear * x->exponent * length3(y->slip)) > JO_RE(x->mu_static * y->rate);
    const jo_real none[3] = {0.0, 0.0, 0.0};
    state[PHASE] = jo_same(slips ? SLIPS : STICKS);
    full_stretch(x, y, slips ? y->slip : none, state + STRETCH);
}

static void start(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    contact y;
    place(d, f, &y);
    move(m, d, f, &y);
    for (int i = 0; i < STATES; i++) state[i] = jo_same(0.0);
    state[APPROACH] = numbers(f)->slowest;
    if (!(JO_RE(y.depth) > 0.0)) return;
    const jo_real speed = speed_of_depth(numbers(f), &y);   /* as if it had come to this depth by itself */
    if (JO_RE(speed) > JO_RE(state[APPROACH])) state[APPROACH] = speed;
    touch(numbers(f), d, &y, state);
}

/* no error control by the stretch: it follows the positions */
static void nominals(const jo_model *m, const jo_force *f, double duration, double *x)
{
    (void)m; (void)f; (void)duration;
    for (int i = 0; i < STATES; i++) x[i] = 1.0;
}

/* states at the end of a step; returns the energy that its change of phase dissipates */
static jo_real update(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    const jo_contact_data *x = numbers(f);
    const int phase = phase_of(state);
    contact y = present(m, d, f);
    const jo_real before = energy_of(x, phase, &y), *old = states(d, f) + STRETCH;
    const int overlaps = JO_RE(y.depth) > 0.0;
    if (phase == APART && overlaps) {
        state[APPROACH] = x->slowest;
        touch(x, d, &y, state);
    }
    if (phase != APART && !overlaps) {
        state[PHASE] = jo_same(APART);
        for (int i = 0; i < 3; i++) state[STRETCH + i] = jo_same(0.0);
    }
    if (phase == STICKS && overlaps) {
        for (int i = 0; i < 3; i++) state[STRETCH + i] = y.stretch[i];
        if (breaks(x, &y)) {
            state[PHASE] = jo_same(SLIPS);
            full_stretch(x, &y, y.slip, state + STRETCH);
        }
    }
    if (phase == EASED && overlaps) {
        const int slips = JO_RE(y.size) > JO_RE(x->mu_kinetic * y.normal);
        const jo_real along[3] = {-y.force[0], -y.force[1], -y.force[2]};
        state[PHASE] = jo_same(slips ? SLIPS : STICKS);
        if (slips) full_stretch(x, &y, along, state + STRETCH);
        else jo_set3(state + STRETCH, y.stretch);
    }
    if (phase == SLIPS && overlaps) {
        const int turned = JO_RE(jo_dot3(old, y.slip)) < 0.0;
        if (turned) state[PHASE] = jo_same(STICKS);
        full_stretch(x, &y, turned ? old : y.slip, state + STRETCH);
    }
    stretch(state + STRETCH, &y);
    return before - energy_of(x, phase_of(state), &y);
}

/* negative: the phase has ended within the step */
static jo_real margin(const jo_model *m, const jo_data *d, const jo_force *f)
{
    const jo_contact_data *x = numbers(f);
    const jo_real *state = states(d, f);
    const contact y = present(m, d, f);
    const int phase = phase_of(state);
    if (phase == APART) return -y.depth;
    jo_real left = y.depth;
    if (phase == STICKS && breaks(x, &y)) {
        const jo_real beyond = (x->mu_static * y.normal - y.size) / y.shear;
        if (JO_RE(beyond) < JO_RE(left)) left = beyond;
    }
    if (phase == SLIPS) {
        const jo_real along = jo_dot3(state + STRETCH, y.slip);
        if (JO_RE(along) < JO_RE(left)) left = along;
    }
    return left;
}

/* A short contact is resolved in JO_CONTACT_PARTS steps. An explicit method is stable up to some 2 / (omega + c / mass), omega^2 = k / mass;
 * several contacts of one body add up. */
static double longest_step(const jo_model *m, const jo_data *d, const jo_force *f, int explicit_method)
{
    const jo_contact_data *x = numbers(f);
    const jo_real *state = states(d, f);
    double longest = INFINITY;
    if (phase_of(state) == APART) return longest;
    const double n = JO_RE(x->exponent), T = JO_RE(x->duration) * pow(JO_RE(state[APPROACH]), (1.0 - n) / (1.0 + n));
    if (JO_RE(d->time[0] - state[SINCE]) < JO_CONTACT_LASTS * T) longest = T / JO_CONTACT_PARTS;
    if (explicit_method) {
        const contact y = present(m, d, f);
        const double rate = sqrt(fabs(JO_RE(y.by_depth / x->mass))) + JO_RE(y.by_rate / x->mass);
        longest = fmin(longest, JO_CONTACT_STABLE / rate);
    }
    return longest;
}

static int ease(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    (void)m; (void)d; (void)f;
    if (phase_of(state) == APART || phase_of(state) == EASED) return 0;
    state[PHASE] = jo_same(EASED);
    return 1;
}

/* largest curvature of the surfaces of constant distance outside of a shape, 1/m; INFINITY over edges. *face: the side or the end of a box
 * or cylinder over which the sphere is, known by the normal; each of these regions is convex */
static double curvature_over(const jo_contact_data *x, const contact *y, int *face)
{
    const double r = JO_RE(x->size[0]);
    const int shape = (int)JO_COMMON(x->shape);
    *face = 0;
    if (shape == JO_SHAPE_HALF_SPACE) return JO_RE(x->ring) > 0.0 ? INFINITY : 0.0;
    if (shape == JO_SHAPE_TORUS) return 1.0 / JO_RE(x->size[1]);
    if (shape != JO_SHAPE_BOX && shape != JO_SHAPE_CYLINDER) return 1.0 / r;
    for (int i = shape == JO_SHAPE_BOX ? 0 : 2; i < 3; i++)
        if (fabs(JO_RE(y->from.normal[i])) == 1.0) {
            *face = 1 + 2 * i + (JO_RE(y->from.normal[i]) > 0.0);
            return 0.0;
        }
    return shape == JO_SHAPE_CYLINDER && JO_RE(y->from.normal[2]) == 0.0 ? 1.0 / r : INFINITY;
}

/* the centre of the sphere in frame a; of a ring its lowest point, which moves on the ring no faster than the ring turns */
static int approach(const jo_model *m, const jo_data *d, const jo_force *f, jo_approach *y)
{
    const jo_contact_data *x = numbers(f);
    if (phase_of(states(d, f)) != APART) return 0;
    contact c;
    jo_real v[3];
    place(d, f, &c);
    move(m, d, f, &c);
    y->gap = -JO_RE(c.depth);
    y->rate = -JO_RE(c.rate);
    /* velocity of the centre: that of the contact point less w x (lever - arm) */
    jo_set3(v, c.lever);
    jo_sub3(v, c.arm);
    jo_cross(v, c.w, v);
    for (int i = 0; i < 3; i++) y->v[i] = JO_RE(c.v[i] - v[i]);
    y->curvature = curvature_over(x, &c, &y->face);
    return 1;
}

/* a bristle that breaks changes mu_static to mu_kinetic */
static int jumps(const jo_real *before, const jo_real *after) { return phase_of(before) != phase_of(after); }

static const jo_yielding yielding = {update, margin, jumps, longest_step, ease, approach};
const jo_force_kind jo_force_contact = {apply, stored, tangent, start, nominals, &yielding};
