/* force_tyre.c - a tyre of the wheel b, axle n (its z axis), on the plane of a, normal k (its z axis): load, slip forces, aligning moment.
 *
 *   c = k . n, s = |k x n|, z = k . (r_b - r_a);   e = (c n - k) / s to the lowest point, t = n x k / s along, u = (n - c k) / s across
 *   deflection D = R s - z, load N = max(0, kz D + cz D'), at the point l = R e + D k of the plane, from the centre
 *   Vx = t . (v + (w - W n) x l), W = w . n;   slip velocities Vsx = Vx - Re W, Vsy = u . (v + w x l);   Re = R - share D
 * Slip follows with a delay, as the deflection x of the contact patch over the relaxation length (Pacejka 2012, section 7.2):
 *   x' = -Vs - V x / length,   slip = (x + lead x') / length
 * V = |Vx|, for the brush |Re W|. At rest x is a spring of stiffness C / length: a parked wheel does not creep, and nothing is divided by V. Below
 * the speed `slow` x' damps this spring. A wheel that slides as a whole stretches x no further: V >= |Vs| / (full slip + V / slow).
 *
 * The longitudinal force has the lever Re about the axle, as the wheel rolls V = Re W: the slip alone dissipates. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/tyre_law.h"
#include "force/wheel_motion.h"

#define JO_TYRE_FLAT 1e-3       /* sine of the angle between axle and normal below which a wheel lies on its side */
#define JO_TYRE_RELAXES 100.0   /* rate at which the deflection of a tyre in the air vanishes, 1/s */
#define JO_TYRE_TURNS 0.1       /* speed relative to `slow` at which half of the rolling resistance acts */

static const jo_tyre_data *numbers(const jo_force *f) { return (const jo_tyre_data *)f->data; }

/* A wheel in motion, resolved in a. */
typedef struct {
    int touches;
    jo_dual3 n, t, u, lever;
    jo_dual defl, rate, load, camber, effective, spin, speed, forward, turn;   /* D, D', N; Re, W, V, |Vx|, w . k */
    jo_dual slide[2];           /* Vs along and across */
    jo_dual arm;                /* Re - (R - s D): lever that the point l lacks about the axle */
} wheel;

static const jo_real up[3] = {0.0, 0.0, 1.0}, zero[3] = {0.0, 0.0, 0.0};

static wheel wheel_of(const jo_tyre_data *x, const jo_wheel_motion *m)
{
    wheel y;
    const jo_dual3 k = jo_dual3_of(up, zero);
    const jo_dual none = jo_dual_constant(0.0), one = jo_dual_constant(1.0);
    const jo_dual c = jo_dual3_dot(k, m->n), s = jo_dual_sqrt(jo_dual_sub(one, jo_dual_mul(c, c)));
    y.touches = JO_RE(s.v) > JO_TYRE_FLAT;
    y.n = m->n;
    y.load = none;
    if (!y.touches) return y;
    const jo_dual by = jo_dual_div(one, s);
    const jo_dual3 e = jo_dual3_times(by, jo_dual3_sub(jo_dual3_times(c, m->n), k));
    y.t = jo_dual3_times(by, jo_dual3_cross(m->n, k));
    y.u = jo_dual3_times(by, jo_dual3_sub(m->n, jo_dual3_times(c, k)));
    /* deflection and its rate: s' = -c c' / s */
    const jo_dual turning = jo_dual3_dot(k, jo_dual3_cross(m->w, m->n));
    y.defl = jo_dual_sub(jo_dual_times(x->radius, s), jo_dual_of(m->r.v[2], m->r.d[2]));
    y.rate = jo_dual_sub(jo_dual_times(-x->radius, jo_dual_mul(jo_dual_mul(c, turning), by)), jo_dual_of(m->v.v[2], m->v.d[2]));
    y.touches = JO_RE(y.defl.v) > 0.0;
    if (y.touches) y.load = jo_dual_add(jo_dual_times(x->stiffness, y.defl), jo_dual_times(x->damping, y.rate));
    if (!(JO_RE(y.load.v) > 0.0)) y.load = none;
    y.camber = jo_dual_of(-jo_arc_tangent(c.v, s.v), -c.d / s.v);
    /* speeds */
    y.lever = jo_dual3_axpy(jo_dual3_times(jo_dual_of(x->radius, jo_same(0.0)), e), y.defl, k);
    y.effective = jo_dual_sub(jo_dual_of(x->radius, jo_same(0.0)), jo_dual_times(x->sink, y.defl));
    y.spin = jo_dual3_dot(m->w, m->n);
    y.turn = jo_dual_of(m->w.v[2], m->w.d[2]);
    const jo_dual3 carried = jo_dual3_sub(m->w, jo_dual3_times(y.spin, m->n));
    const jo_dual vx = jo_dual3_dot(y.t, jo_dual3_add(m->v, jo_dual3_cross(carried, y.lever)));
    const jo_dual rolled = jo_dual_mul(y.effective, y.spin);
    y.slide[0] = jo_dual_sub(vx, rolled);
    y.slide[1] = jo_dual3_dot(y.u, jo_dual3_add(m->v, jo_dual3_cross(m->w, y.lever)));
    y.forward = jo_dual_size(vx);
    y.speed = (int)JO_RE(x->law) == JO_TYRE_BRUSH ? jo_dual_size(rolled) : y.forward;
    y.arm = jo_dual_add(jo_dual_sub(y.effective, jo_dual_of(x->radius, jo_same(0.0))), jo_dual_mul(s, y.defl));
    /* a wheel that slides as a whole */
    const jo_dual sliding = jo_dual_sqrt(jo_dual_add(jo_dual_mul(y.slide[0], y.slide[0]), jo_dual_mul(y.slide[1], y.slide[1])));
    const jo_dual full = jo_dual_plus(jo_dual_times(1.0 / x->slow, y.speed), jo_tyre_full_slip(x));
    const jo_dual least = jo_dual_div(sliding, full);
    if (JO_RE(least.v) > JO_RE(y.speed.v)) y.speed = least;
    return y;
}

/* rate x' of deflection i; *decay = -dx'/dx */
static jo_dual rate_of(const jo_tyre_data *x, const wheel *y, int i, jo_dual deflection, jo_real *decay)
{
    const jo_dual none = jo_dual_constant(0.0);
    if (!(JO_RE(y->load.v) > 0.0)) {
        *decay = jo_same(JO_TYRE_RELAXES);
        return jo_dual_times(-*decay, deflection);
    }
    const jo_dual falls = jo_dual_times(1.0 / x->relaxation[i], y->speed);
    *decay = falls.v;
    return jo_dual_sub(jo_dual_sub(none, y->slide[i]), jo_dual_mul(falls, deflection));
}

/* slip from deflection and rate */
static jo_dual slip_of(const jo_tyre_data *x, const wheel *y, int i, jo_dual deflection, jo_dual rate)
{
    const jo_dual slow = jo_dual_sub(jo_dual_constant(1.0), jo_dual_times(1.0 / x->slow, y->forward));
    if (JO_RE(slow.v) > 0.0) deflection = jo_dual_add(deflection, jo_dual_mul(jo_dual_times(x->lead, jo_dual_mul(slow, slow)), rate));
    return jo_dual_times(1.0 / x->relaxation[i], deflection);
}

/* force and torque on b, resolved in a, for the deflections; *slips: the forces of the law */
static void force_of(const jo_tyre_data *x, const wheel *y, const jo_dual *deflection, jo_dual3 *F, jo_dual3 *T, jo_tyre_force *slips, jo_dual *resistance)
{
    jo_dual slip[2];
    jo_real decay;
    const jo_dual3 k = jo_dual3_of(up, zero);
    for (int i = 0; i < 2; i++) slip[i] = slip_of(x, y, i, deflection[i], rate_of(x, y, i, deflection[i], &decay));
    *slips = jo_tyre_law(x, slip[0], slip[1], y->load, y->camber);
    *F = jo_dual3_axpy(jo_dual3_axpy(jo_dual3_times(y->load, k), slips->x, y->t), slips->y, y->u);
    *T = jo_dual3_axpy(jo_dual3_cross(y->lever, *F), slips->z, k);
    /* rolling resistance about the axle, and the lever of the longitudinal force */
    const jo_dual rolled = jo_dual_mul(y->effective, y->spin);
    const jo_dual way = jo_dual_div(rolled, jo_dual_plus(jo_dual_size(rolled), JO_TYRE_TURNS * x->slow));
    *resistance = jo_dual_mul(jo_dual_times(x->resistance * x->radius, y->load), way);
    *T = jo_dual3_axpy(*T, jo_dual_sub(jo_dual_constant(0.0), jo_dual_add(*resistance, jo_dual_mul(slips->x, y->arm))), y->n);
}

static void present(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *r, jo_real *R, jo_real *v, jo_real *w)
{
    jo_relative_pose(d, f, r, R);
    jo_relative_velocity(m, d, f, v, w);
}

static jo_real stored(const jo_data *d, const jo_force *f)
{
    const jo_tyre_data *x = numbers(f);
    jo_real r[3], R[9];
    jo_relative_pose(d, f, r, R);
    const jo_wheel_motion at = jo_wheel_motion_of(r, R, zero, zero, -1);
    const wheel y = wheel_of(x, &at);
    return y.touches ? 0.5 * x->stiffness * y.defl.v * y.defl.v : jo_same(0.0);
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *out)
{
    static const jo_force_work none = {{0.0}, 0.0, 0.0, 0.0};
    static const jo_slopes_of_state flat = {0.0, 0.0, 0.0, 0.0};
    const jo_tyre_data *x = numbers(f);
    jo_real r[3], R[9], v[3], w[3], decay;
    present(m, d, f, r, R, v, w);
    const jo_wheel_motion at = jo_wheel_motion_of(r, R, v, w, -1);
    const wheel y = wheel_of(x, &at);
    jo_dual deflection[2];
    for (int i = 0; i < 2; i++) {
        const int k = f->state + i;
        jo_real *s = jo_states(m, d) + k;
        const jo_real rate = rate_of(x, &y, i, jo_dual_of(*s, jo_same(0.0)), &decay).v;
        if (jo_condenses(stage)) {
            jo_condense_state(m, d, stage, k, rate, decay);
        } else {
            jo_state_rates(m, d)[k] = rate;
            if (stage->set && !stage->earlier) d->forces.slopes[k] = flat;
        }
        deflection[i] = jo_dual_of(*s, jo_same(0.0));
    }
    *out = none;
    if (!y.touches) return JO_OK;
    out->stored = 0.5 * x->stiffness * y.defl.v * y.defl.v;
    if (!(JO_RE(y.load.v) > 0.0)) {   /* it does not pull: the spring relaxes by itself */
        d->power.damping -= x->stiffness * y.defl.v * y.rate.v;
        return JO_OK;
    }
    jo_dual3 F, T;
    jo_tyre_force slips;
    jo_dual resistance;
    force_of(x, &y, deflection, &F, &T, &slips, &resistance);
    jo_real load[6];
    jo_set3(load, F.v);
    jo_set3(load + 3, T.v);
    d->power.damping += x->damping * y.rate.v * y.rate.v;
    d->power.friction += resistance.v * y.spin.v - slips.x.v * y.slide[0].v - slips.y.v * y.slide[1].v - slips.z.v * y.turn.v;
    jo_push_between(m, d, f, load, out);
    return JO_OK;
}

/* change of a deflection: by its response in a step; for equilibria and vibrations by the displacement of the wheel at the plane */
static jo_real response(const jo_tyre_data *x, const jo_stage *stage, const wheel *y, int i, jo_real deflection, int k)
{
    const double ca = stage->weights.a, cv = stage->weights.v;
    jo_real decay, e[3] = {0.0, 0.0, 0.0}, moved[3];
    const jo_dual rate = rate_of(x, y, i, jo_dual_of(deflection, jo_same(0.0)), &decay);
    if (ca != 0.0 && cv != 0.0) return cv * rate.d / (ca + cv * decay);
    if (k >= 6) return jo_same(0.0);
    e[k % 3] = 1.0;
    if (k < 3) jo_set3(moved, e);
    else jo_cross(moved, e, y->lever.v);
    return -jo_dot3(moved, i ? y->u.v : y->t.v);
}

static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *unused)
{
    (void)unused;
    const jo_tyre_data *x = numbers(f);
    const jo_real *s = jo_states(m, d) + f->state;
    jo_real r[3], R[9], v[3], w[3], load[6], X[6][12];
    present(m, d, f, r, R, v, w);
    for (int k = 0; k < 12; k++) {
        const jo_wheel_motion at = jo_wheel_motion_of(r, R, v, w, k);
        const wheel y = wheel_of(x, &at);
        if (!y.touches || !(JO_RE(y.load.v) > 0.0)) return JO_OK;
        jo_dual deflection[2], resistance;
        jo_dual3 F, T;
        jo_tyre_force slips;
        for (int i = 0; i < 2; i++) deflection[i] = jo_dual_of(s[i], response(x, stage, &y, i, s[i], k));
        force_of(x, &y, deflection, &F, &T, &slips, &resistance);
        for (int i = 0; i < 3; i++) {
            load[i] = F.v[i];
            load[3 + i] = T.v[i];
            X[i][k] = F.d[i];
            X[3 + i][k] = T.d[i];
        }
    }
    jo_newton_between(m, d, f, load, X);
    return JO_OK;
}

static void start(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x)
{
    jo_real r[3], R[9], v[3], w[3], decay;
    present(m, d, f, r, R, v, w);
    const jo_wheel_motion at = jo_wheel_motion_of(r, R, v, w, -1);
    const wheel y = wheel_of(numbers(f), &at);
    /* steady slip; 0 at rest */
    for (int i = 0; i < 2; i++) {
        const jo_dual rate = y.touches ? rate_of(numbers(f), &y, i, jo_dual_constant(0.0), &decay) : jo_dual_constant(0.0);
        x[i] = y.touches && JO_RE(decay) > 0.0 ? rate.v / decay : jo_same(0.0);
    }
}

static void nominals(const jo_model *m, const jo_force *f, double duration, double *x)
{
    (void)m; (void)duration;
    for (int i = 0; i < 2; i++) x[i] = JO_RE(numbers(f)->relaxation[i]) * JO_RE(jo_tyre_full_slip(numbers(f)));
}

const jo_force_kind jo_force_tyre = {apply, stored, tangent, start, nominals, 0};
