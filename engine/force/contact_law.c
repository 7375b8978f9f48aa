/* contact_law.c - force of two bodies on each other at a point, and its derivatives. See force_contact.c for the equations. */
#include "force/contact_point.h"

enum { JO_CURVE_HALVINGS = 20 };    /* of the largest depth of a touch */
#define JO_SLOWEST_TURN 1e-5    /* slip over the slowest approach of the law below which its turn is that of a slip of this size */

/* force without loss, its derivatives and its energy */
static void press_without_loss(const jo_contact_law *x, jo_contact_point *y)
{
    if (JO_RE(x->curve) != JO_CURVE_POWER) {
        jo_contact_curve(x, y);
        return;
    }
    const jo_real once = x->stiffness * jo_raised(y->depth, x->exponent - 1.0);
    y->elastic = once * y->depth;
    y->slope = x->exponent * once;
    y->bend = y->slope * (x->exponent - 1.0) / y->depth;
    y->energy = y->elastic * y->depth / (x->exponent + 1.0);
}

/* speed of approach, m/s, from which a contact without loss would have reached the present depth */
jo_real jo_contact_speed_of_depth(const jo_contact_law *x, jo_real depth)
{
    jo_contact_point y;
    y.depth = depth;
    press_without_loss(x, &y);
    return jo_sqrt(2.0 * y.energy / x->mass);
}

/* step of Adams: cubic from 0 to 1, and its derivative */
static jo_real cubic_step(jo_real x, jo_real *slope)
{
    *slope = jo_same(0.0);
    if (JO_RE(x) >= 1.0) return jo_same(1.0);
    if (JO_RE(x) <= 0.0) return jo_same(0.0);
    *slope = 6.0 * x * (1.0 - x);
    return x * x * (3.0 - 2.0 * x);
}

/* duration of a touch on a curve: that of a spring with the same largest depth and force, within 5 % for powers up to 1.5 */
static double curve_lasts(const jo_contact_law *x, double speed)
{
    jo_contact_point y;
    double low = 0.0, high = JO_RE(x->duration) * speed;
    for (int i = 0; i < 2 * JO_CURVE_HALVINGS; i++, low = high, high *= 2.0)
        if (JO_RE(jo_contact_speed_of_depth(x, jo_same(high))) >= speed) break;
    for (int i = 0; i < JO_CURVE_HALVINGS; i++) {
        const double middle = 0.5 * (low + high);
        if (JO_RE(jo_contact_speed_of_depth(x, jo_same(middle))) < speed) low = middle;
        else high = middle;
    }
    y.depth = jo_same(high);
    jo_contact_curve(x, &y);
    return JO_PI * sqrt(JO_RE(x->mass) * high / JO_RE(y.elastic));
}

double jo_contact_lasts(const jo_contact_law *x, double speed)
{
    const double n = JO_RE(x->exponent);
    if (JO_RE(x->curve) != JO_CURVE_POWER) return curve_lasts(x, speed);
    return n == 1.0 ? JO_RE(x->duration) : JO_RE(x->duration) * pow(speed, (1.0 - n) / (1.0 + n));
}

/* Damper of a contact whose touches are impulses, N s/m: what is left for the law is rest. It has the restitution by a spring of the duration of
 * the slowest touch; `damping` is c T / m, see rest_damping() in contacts/laws.py. Unlike u d' K d^n / v_in it is linear, so that steps longer
 * than T stay stable. */
static jo_real rest_damper(const jo_contact_law *x) { return x->damping * x->mass / x->duration; }

/* N and its derivatives, for the approach speed of the states; 0 without overlap */
void jo_contact_press(const jo_contact_law *x, const jo_real *state, jo_contact_point *y)
{
    const jo_real none = jo_same(0.0);
    y->elastic = y->slope = y->bend = y->energy = y->lag = y->lag_rate = none;
    y->N = y->by_depth = y->by_rate = y->shear = y->shear_rate = y->loss = none;
    if (!(JO_RE(y->depth) > 0.0)) return;
    press_without_loss(x, y);
    const int rests = jo_contact_may_strike(x);
    const jo_real a = rests ? none : x->damping / state[JO_CONTACT_SPEED];
    jo_real steepness, c = x->viscous, dc = none;
    if (JO_RE(x->full) > 0.0) {
        c = x->viscous * cubic_step(y->depth / x->full, &steepness);
        dc = x->viscous * steepness / x->full;
    }
    y->lag = rests ? rest_damper(x) : a * y->elastic;
    y->lag_rate = a * y->slope;
    y->by_rate = y->lag + c;
    y->N = y->elastic + y->by_rate * y->rate;
    y->by_depth = y->slope + (y->lag_rate + dc) * y->rate;
    y->shear = x->shear * y->slope;
    y->shear_rate = x->shear * y->bend;
    y->loss = x->shear * y->lag;
    if (JO_RE(y->N) < 0.0) y->N = y->by_depth = y->by_rate = none;   /* it never pulls */
}

/* bristle in the contact plane, with its force before the limit */
void jo_contact_stretched(const jo_real *s, jo_contact_point *y)
{
    const jo_real out = jo_dot3(s, y->normal);
    for (int i = 0; i < 3; i++) {
        y->stretch[i] = s[i] - out * y->normal[i];
        y->force[i] = -(y->shear * y->stretch[i] + y->loss * y->slip[i]);
    }
    y->size = jo_length3(y->force);
}

jo_real jo_contact_energy(int phase, const jo_contact_point *y)
{
    if (phase == JO_CONTACT_APART) return jo_same(0.0);
    return y->energy + 0.5 * y->shear * jo_dot3(y->stretch, y->stretch);
}

/* Friction force F = -mu N z / |z|: z is the slip velocity, or minus the force of the bristle. A slip that has turned within the step keeps
 * the direction of the end of the last step, so that the force is smooth up to the end of the phase, which is located. */
typedef struct { jo_real z[3], length, mu; int kept; } limited;

/* 0 if the bristle is within its limit */
static int is_limited(const jo_contact_law *x, int phase, const jo_contact_point *y, limited *l)
{
    l->mu = phase == JO_CONTACT_STICKS ? x->mu_static : x->mu_kinetic;
    l->kept = phase == JO_CONTACT_SLIPS && JO_RE(jo_dot3(y->slip, y->stretch)) < 0.0;
    for (int i = 0; i < 3; i++) l->z[i] = l->kept ? y->stretch[i] : phase == JO_CONTACT_SLIPS ? y->slip[i] : -y->force[i];
    l->length = jo_length3(l->z);
    return phase == JO_CONTACT_SLIPS || JO_RE(y->size) > JO_RE(l->mu * y->N);
}

static void friction(const jo_contact_law *x, int phase, const jo_contact_point *y, jo_real *F)
{
    limited l;
    if (jo_contact_is_smooth(x)) {
        const jo_real g = jo_contact_smooth(x, jo_dot3(y->slip, y->slip)) * y->N;
        for (int i = 0; i < 3; i++) F[i] = -g * y->slip[i];
        return;
    }
    if (!is_limited(x, phase, y, &l)) {
        jo_set3(F, y->force);
        return;
    }
    const jo_real share = JO_RE(l.length) > 0.0 ? l.mu * y->N / l.length : 0.0;
    for (int i = 0; i < 3; i++) F[i] = -share * l.z[i];
}

/* relative rate of the shear stiffness while it grows */
jo_real jo_contact_growth(const jo_contact_point *y)
{
    const jo_real g = JO_RE(y->depth) > 0.0 ? y->shear_rate * y->rate / y->shear : 0.0;
    return JO_RE(g) > 0.0 ? g : 0.0;
}

void jo_contact_force(const jo_contact_law *x, int phase, const jo_contact_point *y, jo_real *F, jo_work *power)
{
    jo_real tangential[3];
    friction(x, phase, y, tangential);
    for (int i = 0; i < 3; i++) F[i] = y->N * y->normal[i] + tangential[i];
    jo_cross(F + 3, y->lever, F);
    power->damping += (y->N - y->elastic) * y->rate;
    power->friction -= jo_dot3(tangential, y->slip);   /* of which bristles store a part, see contact_record.c */
}

/* change of the friction force, for the changes c of the contact, dN of the normal force and ds of the stretch */
static void friction_change(const jo_contact_law *x, int phase, const jo_contact_point *y, const jo_contact_change *c, jo_real dN, const jo_real *ds, jo_real *dF)
{
    limited l;
    jo_real z[3];
    if (jo_contact_is_smooth(x)) {
        jo_contact_smooth_change(x, y, c->slip, dN, dF);
        return;
    }
    const int cut = is_limited(x, phase, y, &l);
    const jo_real dk = y->shear_rate * c->depth, dloss = x->shear * y->lag_rate * c->depth;
    for (int i = 0; i < 3; i++)
        z[i] = l.kept ? ds[i] : phase == JO_CONTACT_SLIPS ? c->slip[i] : dk * y->stretch[i] + y->shear * ds[i] + dloss * y->slip[i] + y->loss * c->slip[i];
    if (!cut) {
        for (int i = 0; i < 3; i++) dF[i] = -z[i];
        return;
    }
    if (!(JO_RE(l.length) > 0.0)) {
        for (int i = 0; i < 3; i++) dF[i] = 0.0;
        return;
    }
    /* the turn of a slip that is all but 0 has no end: beside it a mass would vanish in the matrix */
    const double shortest = phase == JO_CONTACT_SLIPS && !l.kept ? JO_SLOWEST_TURN * JO_RE(x->slowest) : 0.0;
    const jo_real along = jo_dot3(l.z, z) / l.length, limit = l.mu * y->N, length = JO_RE(l.length) > shortest ? l.length : jo_same(shortest);
    for (int i = 0; i < 3; i++) {
        const jo_real e = l.z[i] / l.length;
        dF[i] = -l.mu * dN * e - limit * (z[i] - along * e) / length;
    }
}

/* change of the stretch s: within the contact plane, with the response of its state to the slip velocity in a step, or with the displacement */
static void stretch_change(const jo_stage *stage, const jo_real *s, int moves, const jo_contact_point *y, const jo_contact_change *c, int k, jo_real *ds)
{
    const double ca = stage->weights.a, cv = stage->weights.v;
    const jo_real *n = y->normal, g = jo_contact_growth(y);
    const int steps = ca != 0.0 && cv != 0.0;
    jo_real raw[3];
    for (int i = 0; i < 3; i++) {
        raw[i] = 0.0;
        if (steps && moves) {
            const jo_real dg = JO_RE(g) > 0.0 ? g * (c->rate / y->rate - c->depth / y->depth) : 0.0;
            raw[i] = cv / (ca + cv * g) * (c->slip[i] - dg * s[i]);
        }
    }
    if (!steps && moves && k < 6) {   /* displacement of b on a at the contact point */
        jo_real e[3] = {0.0, 0.0, 0.0};
        e[k % 3] = 1.0;
        if (k < 3) jo_set3(raw, e);
        else jo_cross(raw, e, y->lever);
    }
    const jo_real out = jo_dot3(s, n), dout = jo_dot3(s, c->normal) + jo_dot3(raw, n);
    for (int i = 0; i < 3; i++) ds[i] = raw[i] - dout * n[i] - out * c->normal[i];
}

void jo_contact_force_change(const jo_contact_law *x, int phase, const jo_contact_point *y, const jo_contact_change *c, const jo_real *ds, jo_real *dF)
{
    const jo_real dN = y->by_depth * c->depth + y->by_rate * c->rate;
    friction_change(x, phase, y, c, dN, ds, dF);
    for (int i = 0; i < 3; i++) dF[i] += dN * y->normal[i] + y->N * c->normal[i];
}

void jo_contact_response(const jo_contact_law *x, const jo_stage *stage, const jo_real *state, const jo_contact_point *y, const jo_contact_change *c,
                         int k, const jo_real *F, jo_real *dF)
{
    const int phase = jo_contact_phase(state);
    jo_real ds[3], t[3];
    stretch_change(stage, state + JO_CONTACT_STRETCH, jo_contact_follows(phase), y, c, k, ds);
    jo_contact_force_change(x, phase, y, c, ds, dF);
    jo_cross(dF + 3, y->lever, dF);
    jo_cross(t, c->lever, F);
    jo_add3(dF + 3, t);
}
