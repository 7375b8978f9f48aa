/* pushes.c - Newton's matrix: the forces of force.c, differentiated. */
#include "element.h"

/* a spring, damper, servo or actuator */
static void along(const jo_model *m, jo_data *d, int i)
{
    const jo_force *f = &m->force[i];
    const jo_coordinate_work *w = &d->coordinate[f->coordinate];
    const double limit = JO_RE(f->data[4]);
    const jo_real y = d->force[i].y[0];
    jo_real fs = -f->data[0], frate = -f->data[1];
    jo_element e;
    jo_gradients g;
    if (f->spring >= 0) fs += jo_signal_at(m, d, f->spring, w->value).rate;
    if (f->damper >= 0) frate += jo_signal_at(m, d, f->damper, w->rate).rate;
    if (limit > 0.0 && fabs(JO_RE(y)) >= limit) fs = frate = 0.0;
    jo_element_gradients(m, d, f->coordinate, &g);
    jo_element_start(&e, m->coordinate[f->coordinate].a, m->coordinate[f->coordinate].b);
    jo_element_along(d, &e, f->coordinate, &g, y, fs, frate);
    jo_element_finish(m, d, &e);
}

/* y (6) on b, resolved in a, depends on the relative motion; X (6 x 12): its derivatives with respect to the changes
 * [position, rotation, velocity, angular velocity] of b against a, resolved in a */
static void between(const jo_model *m, jo_data *d, const jo_force *f, const jo_real *y, jo_real (*X)[12])
{
    const jo_marker_work *a = &d->marker[f->a], *b = &d->marker[f->b];
    jo_real K[12][24] = {{0.0}}, r[3], va[3], vb[3], oma[3], omb[3], t[3], M[9];
    jo_element e;
    jo_element_start(&e, f->a, f->b);
    jo_set3(r, b->r);
    jo_sub3(r, a->r);
    jo_to_world(va, m, d, f->a, a->v);
    jo_to_world(vb, m, d, f->b, b->v);
    jo_to_world(oma, m, d, f->a, a->om);
    jo_to_world(omb, m, d, f->b, b->om);
    jo_cross(t, oma, r);
    jo_sub3(vb, va);
    jo_sub3(vb, t);      /* relative velocity */
    jo_sub3(omb, oma);
    /* changes of the relative motion, first in the world frame: e.Y serves as scratch */
    for (int p = 0; p < 3; p++) {
        e.Y[p][JO_DR + p] = e.Y[3 + p][JO_DPHI + p] = e.Y[6 + p][JO_DV + p] = e.Y[9 + p][JO_DOM + p] = -1.0;
        e.Y[p][JO_OF_B + JO_DR + p] = e.Y[3 + p][JO_OF_B + JO_DPHI + p] = e.Y[6 + p][JO_OF_B + JO_DV + p] = e.Y[9 + p][JO_OF_B + JO_DOM + p] = 1.0;
    }
    jo_element_skew(&e, 0, JO_DPHI, 1.0, r);         /* -phi_a x r */
    jo_element_skew(&e, 6, JO_DOM, 1.0, r);          /* -dom_a x r */
    jo_element_skew(&e, 6, JO_DR, 1.0, oma);         /* -om_a x dr */
    jo_element_skew(&e, 6, JO_OF_B + JO_DR, -1.0, oma);
    jo_element_skew(&e, 6, JO_DPHI, 1.0, vb);
    jo_element_skew(&e, 9, JO_DPHI, 1.0, omb);
    for (int p = 0; p < 12; p++)
        for (int q = 0; q < 24; q++)
            for (int s = 0; s < 3; s++) K[p][q] += a->A[3 * s + p % 3] * e.Y[3 * (p / 3) + s][q];
    jo_element_start(&e, f->a, f->b);
    jo_mul3(e.y + 6, a->A, y);
    jo_mul3(e.y + 9, a->A, y + 3);
    for (int p = 0; p < 6; p++)
        for (int q = 0; q < 24; q++) {
            jo_real x = 0.0;
            for (int s = 0; s < 12; s++) x += X[p][s] * K[s][q];
            for (int s = 0; s < 3; s++) e.Y[6 + 3 * (p / 3) + s][q] += a->A[3 * s + p % 3] * x;
        }
    jo_element_skew(&e, 6, JO_DPHI, -1.0, e.y + 6);
    jo_element_skew(&e, 9, JO_DPHI, -1.0, e.y + 9);
    /* on a: -F, -T - r x F */
    jo_cross(t, r, e.y + 6);
    for (int i = 0; i < 9; i++) M[i] = 0.0;
    M[1] = -r[2]; M[2] = r[1]; M[3] = r[2]; M[5] = -r[0]; M[6] = -r[1]; M[7] = r[0];
    for (int p = 0; p < 3; p++) {
        e.y[p] = -e.y[6 + p];
        e.y[3 + p] = -e.y[9 + p] - t[p];
        for (int q = 0; q < 24; q++) {
            e.Y[p][q] = -e.Y[6 + p][q];
            e.Y[3 + p][q] = -e.Y[9 + p][q] - (M[3 * p] * e.Y[6][q] + M[3 * p + 1] * e.Y[7][q] + M[3 * p + 2] * e.Y[8][q]);
        }
    }
    jo_element_skew(&e, 3, JO_DR, -1.0, e.y + 6);    /* -dr x F = F x dr, dr = dr_b - dr_a */
    jo_element_skew(&e, 3, JO_OF_B + JO_DR, 1.0, e.y + 6);
    jo_element_finish(m, d, &e);
}

/* M (3x3) = d(x + sign theta x x / 2 + c theta x (theta x x)) / dtheta of jo_conjugate, and the same with respect to x in P */
static void conjugate_rate(jo_real *M, jo_real *P, const jo_real *theta, const jo_real *x, double sign)
{
    const jo_real s = jo_dot3(theta, theta);
    jo_real c, dc, one[3], two[3];
    if (JO_RE(s) < 0.01) {
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
            M[3 * i + j] = 2.0 * dc * two[i] * theta[j] - c * x[i] * theta[j] + (i == j ? c * tx : 0.0);
            P[3 * i + j] = c * theta[i] * theta[j] + (i == j ? 1.0 - c * s : 0.0);
        }
    const jo_real half = 0.5 * sign;
    const jo_real u[3] = {-half * x[0] - c * one[0], -half * x[1] - c * one[1], -half * x[2] - c * one[2]};
    M[1] -= u[2]; M[2] += u[1]; M[3] += u[2]; M[5] -= u[0]; M[6] -= u[1]; M[7] += u[0];
    P[1] -= half * theta[2]; P[2] += half * theta[1]; P[3] += half * theta[2];
    P[5] -= half * theta[0]; P[6] -= half * theta[1]; P[7] += half * theta[0];
}

static void bushing(const jo_model *m, jo_data *d, int i)
{
    const jo_force *f = &m->force[i];
    jo_real x[6], rate[6], R[9], w[3], g[6], y[6], X[6][12], Z[6][12] = {{0.0}};
    jo_real P[9], Pi[9], M[9], Q[9];   /* theta' = P omega; torque = Q g */
    jo_relative_pose(d, f, x, R);
    jo_rotation_vector(x + 3, R);
    jo_relative_velocity(m, d, f, rate, w);
    jo_conjugate(rate + 3, x + 3, w, -1.0);
    for (int p = 0; p < 6; p++) {
        g[p] = f->data[72 + p];
        for (int q = 0; q < 6; q++) g[p] -= f->data[6 * p + q] * x[q] + f->data[36 + 6 * p + q] * rate[q];
    }
    /* Z: changes of g; dtheta = P dphi, dtheta' = P dom + M dtheta */
    conjugate_rate(M, P, x + 3, w, -1.0);
    jo_mul33(Pi, M, P);
    for (int p = 0; p < 6; p++)
        for (int q = 0; q < 3; q++) {
            const jo_real *K = f->data + 6 * p, *D = f->data + 36 + 6 * p;
            Z[p][q] -= K[q];
            Z[p][6 + q] -= D[q];
            for (int s = 0; s < 3; s++) {
                Z[p][3 + q] -= K[3 + s] * P[3 * s + q] + D[3 + s] * Pi[3 * s + q];
                Z[p][9 + q] -= D[3 + s] * P[3 * s + q];
            }
        }
    jo_set3(y, g);
    jo_conjugate(y + 3, x + 3, g + 3, 1.0);
    conjugate_rate(M, Q, x + 3, g + 3, 1.0);
    jo_mul33(Pi, M, P);
    for (int p = 0; p < 3; p++)
        for (int q = 0; q < 12; q++) {
            X[p][q] = Z[p][q];
            X[3 + p][q] = Q[3 * p] * Z[3][q] + Q[3 * p + 1] * Z[4][q] + Q[3 * p + 2] * Z[5][q];
            if (q >= 3 && q < 6) X[3 + p][q] += Pi[3 * p + q - 3];
        }
    between(m, d, f, y, X);
}

/* the derivatives of a user's function by forward differences: Newton's method converges still, no longer quadratically */
static int user(const jo_model *m, jo_data *d, int i)
{
    const jo_force *f = &m->force[i];
    const double relative = 1e-7;
    jo_real x[18], y[6], X[6][12];
    jo_relative_pose(d, f, x, x + 3);
    jo_relative_velocity(m, d, f, x + 12, x + 15);
    int status = jo_ask(f, d->time[0], x, y);
    for (int j = 0; j < 12 && status == JO_OK; j++) {
        jo_real moved[18], z[6];
        double step = relative;
        for (int k = 0; k < 18; k++) moved[k] = x[k];
        if (j >= 3 && j < 6) {
            jo_real angle[3] = {0.0}, q[4] = {1.0, 0.0, 0.0, 0.0}, E[9];
            angle[j - 3] = step;
            jo_rotate(q, angle);
            jo_rotation(E, q);
            jo_mul33(moved + 3, E, x + 3);
        } else {
            const int k = j < 3 ? j : 6 + j;
            const int group = j < 3 ? 0 : j < 9 ? 12 : 15;
            const double size = sqrt(JO_RE(jo_dot3(x + group, x + group)));
            step *= j < 3 ? (size > 1e-3 * m->size ? size : 1e-3 * m->size) : (size > 1.0 ? size : 1.0);
            moved[k] += step;
        }
        status = jo_ask(f, d->time[0], moved, z);
        for (int p = 0; p < 6; p++) X[p][j] = (z[p] - y[p]) / step;
    }
    if (status == JO_OK) between(m, d, f, y, X);
    return status;
}

/* loads in the world do not change, those that follow turn with the marker */
static void load(const jo_model *m, jo_data *d, int i)
{
    const jo_force *f = &m->force[i];
    jo_element e;
    (void)m;
    jo_element_start(&e, -1, f->b);
    for (int j = 0; j < 6; j++) e.y[6 + j] = d->force[i].y[j];
    if (f->follow) {
        jo_element_skew(&e, 6, JO_OF_B + JO_DPHI, -1.0, e.y + 6);
        jo_element_skew(&e, 9, JO_OF_B + JO_DPHI, -1.0, e.y + 9);
    }
    jo_element_finish(m, d, &e);
}

/* the force on the origin turns with the body: r_R -= A f */
static void modal_load(const jo_model *m, jo_data *d, int i)
{
    const jo_force *f = &m->force[i];
    const jo_block N = jo_newton_find(m, d, f->body, f->body);
    const jo_body_work *w = &d->body[f->body];
    jo_real x[3], M[9] = {0.0}, Q[9], P[9];
    jo_mul3t(x, w->A, d->force[i].y);
    M[1] = -x[2]; M[2] = x[1]; M[3] = x[2]; M[5] = -x[0]; M[6] = -x[1]; M[7] = x[0];
    jo_mul33(Q, w->A, M);
    jo_mul33(P, Q, w->turn);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) N.at[r * N.stride + 3 + c] += d->weights.q * P[3 * r + c];
}

/* a force that travels along a body, fixed in the world or in the body */
static void moving_load(const jo_model *m, jo_data *d, int i)
{
    const jo_force *f = &m->force[i];
    const jo_block N = jo_newton_find(m, d, f->body, f->body);
    const jo_body_work *w = &d->body[f->body];
    const jo_real q = d->weights.q, *data = f->data;
    const int n = (int)JO_RE(data[1]);
    jo_real power[4], F[3], u[3], phi[3], t[3], M[9] = {0.0}, P[9], Q[9];
    const jo_real *c = jo_moving_piece(data, jo_signal_at(m, d, f->reference, d->time[0]).value, power);
    if (!c) return;
    jo_mul3t(F, w->A, d->force[i].y);
    jo_moving_shape(u, c, power);
    for (int j = 0; j < n; j++) {
        jo_moving_shape(phi, c + 12 * (1 + j), power);
        for (int k = 0; k < 3; k++) u[k] += phi[k] * w->p[j];
        jo_cross(t, phi, F);
        for (int k = 0; k < 3; k++) N.at[(3 + k) * N.stride + 6 + j] -= q * t[k];   /* du x F */
        if (f->follow) continue;
        jo_mul3t(t, w->turn, t);   /* phi . (F x dtheta) */
        for (int k = 0; k < 3; k++) N.at[(6 + j) * N.stride + 3 + k] -= q * t[k];
    }
    M[1] = -F[2]; M[2] = F[1]; M[3] = F[2]; M[5] = -F[0]; M[6] = -F[1]; M[7] = F[0];
    if (f->follow) {   /* the force turns: A (dtheta x F) */
        jo_mul33(Q, w->A, M);
        jo_mul33(P, Q, w->turn);
        for (int r = 0; r < 3; r++)
            for (int k = 0; k < 3; k++) N.at[r * N.stride + 3 + k] += q * P[3 * r + k];
        return;
    }
    jo_mul33(Q, M, w->turn);
    for (int k = 0; k < 3; k++) {   /* u x (F x dtheta) */
        const jo_real column[3] = {Q[k], Q[3 + k], Q[6 + k]};
        jo_cross(t, u, column);
        for (int r = 0; r < 3; r++) N.at[(3 + r) * N.stride + 3 + k] -= q * t[r];
    }
}

int jo_newton_forces(const jo_model *m, jo_data *d)
{
    int status = JO_OK;
    for (int i = 0; i < m->nforce && status == JO_OK; i++) {
        switch (m->force[i].type) {
        case JO_LOAD: load(m, d, i); break;
        case JO_ALONG_COORDINATE: along(m, d, i); break;
        case JO_BUSHING: bushing(m, d, i); break;
        case JO_MODAL_LOAD: modal_load(m, d, i); break;
        case JO_MOVING_LOAD: moving_load(m, d, i); break;
        case JO_USER: status = user(m, d, i); break;
        default: break;
        }
        if (status != JO_OK) d->error_index = i;
    }
    return status;
}
