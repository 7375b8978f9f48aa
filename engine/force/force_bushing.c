/* force_bushing.c - stiffness and damping in six directions between two markers, for relative rotations up to pi.
 *
 * [F, T] on b, resolved in a: springs by the energy of [r_b - r_a, rotation vector], dampers -D [relative velocity, relative angular
 * velocity]: isotropic ones give T = -c omega at any attitude. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"

#define JO_SMALL_TANGENT2 1e-3  /* tan^2 of half the angle below which atan is computed by a series, with an error below 1e-17 */
#define JO_SMALL_ANGLE2 0.01    /* square of the angle, rad2, below which (1 - x cot x) / x^2 is computed by a series */

/* theta = 2 atan(|v| / e0) v / |v|: rotation vector of R, |theta| <= pi, from its quaternion [e0, v] */
static void rotation_vector(jo_real *theta, const jo_real *R)
{
    jo_real e[4];
    jo_quaternion(e, R);
    const jo_real square = jo_dot3(e + 1, e + 1), x = square / (e[0] * e[0]);
    const jo_mask small = JO_LESS(square, JO_SMALL_TANGENT2 * (e[0] * e[0]));
    jo_real factor = jo_same(0.0);
    if (jo_some(small))   /* series of 2 atan(|v| / e0) / |v| */
        factor = 2.0 / e[0] * (1.0 - x * (1.0 / 3.0 - x * (0.2 - x * (1.0 / 7.0 - x * (1.0 / 9.0 - x / 11.0)))));
    if (!jo_every(small)) {
        const jo_real sine = jo_sqrt(square);
        factor = jo_choose(small, factor, 2.0 * jo_arc_tangent(sine, e[0]) / sine);
    }
    for (int i = 0; i < 3; i++) theta[i] = factor * e[1 + i];
}

/* y = x + sign theta x x / 2 + c theta x (theta x x): sign -1: theta' for the angular velocity x in frame a; sign +1:
 * torque for the force x conjugate to theta; c = (1 - (t/2) cot(t/2)) / t^2, t = |theta| */
static void conjugate(jo_real *y, const jo_real *theta, const jo_real *x, double sign)
{
    const jo_real s = jo_dot3(theta, theta);
    const jo_mask small = JO_LESS(s, JO_SMALL_ANGLE2);
    jo_real c = jo_same(0.0), one[3], two[3];
    if (jo_some(small))
        c = 1.0 / 12.0 + s * (1.0 / 720.0 + s * (1.0 / 30240.0 + s * (1.0 / 1209600.0 + s / 47900160.0)));
    if (!jo_every(small)) {
        const jo_real half = 0.5 * jo_sqrt(s);
        c = jo_choose(small, c, (1.0 - half * jo_cos(half) / jo_sin(half)) / s);
    }
    jo_cross(one, theta, x);
    jo_cross(two, theta, one);
    for (int i = 0; i < 3; i++) y[i] = x[i] + sign * 0.5 * one[i] + c * two[i];
}

/* y = K x; returns U = x^T K x / 2 - x . preload, x = [r_b - r_a, rotation vector], resolved in a */
static jo_real energy(const jo_force *f, const jo_real *x, jo_real *y)
{
    const jo_bushing_data *c = (const jo_bushing_data *)f->data;
    jo_real U = {0.0};
    for (int i = 0; i < 6; i++) {
        y[i] = jo_same(0.0);
        for (int j = 0; j < 6; j++) y[i] += c->K[6 * i + j] * x[j];
        U += x[i] * (0.5 * y[i] - c->preload[i]);
    }
    return U;
}

static jo_real stored(const jo_data *d, const jo_force *f)
{
    jo_real x[6], R[9], unused[6];
    jo_relative_pose(d, f, x, R);
    rotation_vector(x + 3, R);
    return energy(f, x, unused);
}

/* F = preload - K x, torque conjugate to the rotation vector, -D times relative velocity */
static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *out)
{
    (void)stage;
    const jo_bushing_data *c = (const jo_bushing_data *)f->data;
    jo_real x[6], rate[6], R[9], w[3], y[6], g[6];
    jo_relative_pose(d, f, x, R);
    rotation_vector(x + 3, R);
    jo_relative_velocity(m, d, f, rate, w);
    jo_set3(rate + 3, w);
    out->stored = energy(f, x, g);
    for (int i = 0; i < 6; i++) g[i] = c->preload[i] - g[i];
    jo_set3(y, g);
    conjugate(y + 3, x + 3, g + 3, 1.0);
    for (int i = 0; i < 6; i++) {
        jo_real damping = {0.0};
        for (int j = 0; j < 6; j++) damping += c->D[6 * i + j] * rate[j];
        d->power.damping += damping * rate[i];
        y[i] -= damping;
    }
    jo_push_between(m, d, f, y, out);
    return JO_OK;
}

/* derivatives of y = x + sign theta x x / 2 + c theta x (theta x x) of conjugate(): M = dy/dtheta, P = dy/dx */
static void conjugate_rate(jo_real *M, jo_real *P, const jo_real *theta, const jo_real *x, double sign)
{
    const jo_real s = jo_dot3(theta, theta);
    jo_real c, dc, one[3], two[3];
    if (JO_COMMON(s) < JO_SMALL_ANGLE2) {
        c = 1.0 / 12.0 + s * (1.0 / 720.0 + s * (1.0 / 30240.0 + s * (1.0 / 1209600.0 + s / 47900160.0)));
        dc = 1.0 / 720.0 + s * (1.0 / 15120.0 + s * (1.0 / 403200.0 + s * (1.0 / 11975040.0 + s * 5.0 * 5.2840e-10)));
    } else {
        const jo_real h = 0.5 * jo_sqrt(s), sine = jo_sin(h), cot = jo_cos(h) / sine;
        c = (1.0 - h * cot) / s;
        dc = (h / (sine * sine) - cot) / (8.0 * h * s) - c / s;
    }
    jo_cross(one, theta, x);
    jo_cross(two, theta, one);
    const jo_real tx = jo_dot3(theta, x);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            /* c (e x one + theta x (e x x)), theta x (e x x) = e (theta . x) - x (theta . e) */
            M[3 * i + j] = 2.0 * dc * two[i] * theta[j] - c * x[i] * theta[j] + (i == j ? c * tx : jo_same(0.0));
            P[3 * i + j] = c * theta[i] * theta[j] + (i == j ? 1.0 - c * s : jo_same(0.0));
        }
    const double half = 0.5 * sign;
    const jo_real u[3] = {-half * x[0] - c * one[0], -half * x[1] - c * one[1], -half * x[2] - c * one[2]};
    M[1] -= u[2]; M[2] += u[1]; M[3] += u[2]; M[5] -= u[0]; M[6] -= u[1]; M[7] += u[0];
    P[1] -= half * theta[2]; P[2] += half * theta[1]; P[3] += half * theta[2];
    P[5] -= half * theta[0]; P[6] -= half * theta[1]; P[7] += half * theta[0];
}

static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *unused)
{
    (void)stage;
    const jo_bushing_data *c = (const jo_bushing_data *)f->data;
    jo_real x[6], rate[6], R[9], w[3], g[6], y[6], X[6][12], Z[6][12] = {{0.0}};
    jo_real P[9], Pi[9], M[9], Q[9];   /* dtheta = P dphi; torque = Q g */
    (void)unused;
    jo_relative_pose(d, f, x, R);
    rotation_vector(x + 3, R);
    jo_relative_velocity(m, d, f, rate, w);
    jo_set3(rate + 3, w);
    for (int p = 0; p < 6; p++) {
        g[p] = c->preload[p];
        for (int q = 0; q < 6; q++) g[p] -= c->K[6 * p + q] * x[q];
    }
    /* Z: changes of g with dr and dphi */
    conjugate_rate(M, P, x + 3, w, -1.0);
    for (int p = 0; p < 6; p++)
        for (int q = 0; q < 3; q++) {
            const jo_real *K = c->K + 6 * p;
            Z[p][q] -= K[q];
            for (int s = 0; s < 3; s++) Z[p][3 + q] -= K[3 + s] * P[3 * s + q];
        }
    jo_set3(y, g);
    conjugate(y + 3, x + 3, g + 3, 1.0);
    conjugate_rate(M, Q, x + 3, g + 3, 1.0);
    jo_mul33(Pi, M, P);
    for (int p = 0; p < 3; p++)
        for (int q = 0; q < 12; q++) {
            X[p][q] = Z[p][q];
            X[3 + p][q] = Q[3 * p] * Z[3][q] + Q[3 * p + 1] * Z[4][q] + Q[3 * p + 2] * Z[5][q];
            if (q >= 3 && q < 6) X[3 + p][q] += Pi[3 * p + q - 3];
        }
    for (int p = 0; p < 6; p++)
        for (int q = 0; q < 6; q++) {
            y[p] -= c->D[6 * p + q] * rate[q];
            X[p][6 + q] -= c->D[6 * p + q];
        }
    jo_newton_between(m, d, f, y, X);
    return JO_OK;
}

const jo_force_kind jo_force_bushing = {apply, stored, tangent, 0, 0, 0};
