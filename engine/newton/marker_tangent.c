/* marker_tangent.c - derivatives of the motion of markers with respect to their bodies, and geometric stiffness of loads on them. */
#include "newton/newton.h"

/* M = d(T x)/dtheta or, with sign -1, d(T^T x)/dtheta of T = E + f1 theta~ + f2 theta~ theta~ */
static void operator_rate(jo_real *M, const jo_real *theta, const jo_real *x, double sign)
{
    const jo_real s = jo_dot3(theta, theta);
    jo_real f[3], df1 = 0.0, df2 = 0.0, one[3], two[3];
    jo_sinc(s, f);
    jo_sinc_rate(s, f, &df1, &df2);
    jo_cross(one, theta, x);
    jo_cross(two, theta, one);
    for (int i = 0; i < 9; i++) M[i] = 0.0;
    jo_add_skew(M, -sign * f[1], x);          /* f1 dtheta x x */
    jo_add_skew(M, -f[2], one);               /* f2 dtheta x (theta x x) */
    jo_add_skew_skew(M, -f[2], theta, x);     /* f2 theta x (dtheta x x) */
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) M[3 * i + j] += 2.0 * (sign * df1 * one[i] + df2 * two[i]) * theta[j];
}

/* columns 6.. of Y (3 x row) += M X, X (3 x np) */
static void add_modal(jo_real *Y, int row, const jo_real *M, const jo_real *X, int np, int n)
{
    for (int i = 0; i < 3; i++) {
        const jo_real a = M[3 * i], b = M[3 * i + 1], c = M[3 * i + 2];
        jo_real *y = Y + i * row + 6;
        for (int j = 0; j < n; j++) y[j] += a * X[j] + b * X[np + j] + c * X[2 * np + j];
    }
}

/* columns 3..5 of Y (3 x row) = M */
static void set_turn(jo_real *Y, int row, const jo_real *M)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) Y[i * row + 3 + j] = M[3 * i + j];
}

/* shapes (3 x np) = sum over k of x_k chi_jk */
static void second_order(jo_real *Y, const jo_real *chi, const jo_real *x, int n, int np)
{
    for (int c = 0; c < 3; c++) {
        for (int j = 0; j < np; j++) Y[c * np + j] = 0.0;
        for (int k = 0; k < n; k++, chi += np)
            for (int j = 0; j < np; j++) Y[c * np + j] += x[k] * chi[j];
    }
}

/* M = s A x~ */
static inline void turned(jo_real *M, const jo_real *A, jo_real s, const jo_real *x)
{
    jo_real Q[9] = {0.0};
    jo_add_skew(Q, s, x);
    jo_mul33(M, A, Q);
}

/* rotation shapes: columns of T Psi in L and derivatives of T Psi p' in W */
static void turn_by_shapes(const jo_model *m, jo_data *d, int marker)
{
    const jo_marker *k = &m->marker[marker];
    const jo_marker_work *w = &d->marker[marker];
    const jo_marker_tangent *y = &d->newton.marker[marker];
    const jo_body *b = &m->body[k->body];
    const jo_body_work *bw = &d->body[k->body];
    const int n = b->n, np = b->np, row = jo_pad(6 + n);
    jo_real *chi_pd = d->newton.chi_pd;
    jo_real AT[9], M[9], Q[9], x[3];
    jo_mul33(AT, bw->A, w->T);
    add_modal(y->L + 3 * row, row, AT, w->Psi, np, n);
    for (int i = 0; i < 3; i++) {
        x[i] = 0.0;
        for (int j = 0; j < n; j++) x[i] += w->Psi[i * np + j] * bw->pd[j];
    }
    operator_rate(Q, w->theta, x, 1.0);
    jo_mul33(M, bw->A, Q);
    add_modal(y->W + 9 * row, row, M, w->Psi, np, n);
    if (!k->chi) return;
    second_order(chi_pd, k->chi + 3 * n * np, bw->pd, n, np);
    add_modal(y->W + 9 * row, row, AT, chi_pd, np, n);
}

/* L, and in rows 6..11 of W the derivatives of [v, om] with respect to positions */
static void motion_by_body(const jo_model *m, jo_data *d, int marker)
{
    const jo_marker *k = &m->marker[marker];
    const jo_marker_work *w = &d->marker[marker];
    const jo_marker_tangent *y = &d->newton.marker[marker];
    const jo_body *b = &m->body[k->body];
    const jo_body_work *bw = &d->body[k->body];
    const int n = b->n, np = b->np, row = jo_pad(6 + n);
    const jo_real *A = bw->A;
    jo_real *L = y->L, *W = y->W, *chi_pd = d->newton.chi_pd, M[9], x[3];
    for (int i = 0; i < 6 * row; i++) L[i] = 0.0;
    for (int i = 0; i < 12 * row; i++) W[i] = 0.0;
    for (int i = 0; i < 3; i++) L[i * row + i] = 1.0;
    turned(M, A, -1.0, w->u);
    set_turn(L, row, M);
    if (k->Phi) add_modal(L, row, A, w->Phi, np, n);
    set_turn(L + 3 * row, row, A);
    jo_set3(x, w->v);
    jo_sub3(x, bw->V);
    turned(M, A, -1.0, x);
    set_turn(W + 6 * row, row, M);
    if (k->Phi) {
        turned(M, A, 1.0, bw->w);
        add_modal(W + 6 * row, row, M, w->Phi, np, n);
    }
    turned(M, A, -1.0, w->om);
    set_turn(W + 9 * row, row, M);
    if (k->Psi && k->turns) turn_by_shapes(m, d, marker);
    if (k->chi && k->Phi) {
        second_order(chi_pd, k->chi, bw->pd, n, np);
        add_modal(W + 6 * row, row, A, chi_pd, np, n);
    }
}

/* W for the unknowns: positions q turn L, velocities q turn W + v L */
static void motion_by_unknowns(const jo_weights *c, const jo_real *turn, const jo_real *L, jo_real *W, int row)
{
    for (int i = 0; i < 6; i++) {
        jo_real *position = W + i * row, *velocity = W + (6 + i) * row, x[3], t[3];
        const jo_real *l = L + i * row;
        jo_mul3t(t, turn, l + 3);
        jo_mul3t(x, turn, velocity + 3);
        for (int j = 0; j < row; j++) {
            position[j] = c->q * l[j];
            velocity[j] = c->q * velocity[j] + c->v * l[j];
        }
        for (int j = 0; j < 3; j++) {
            position[3 + j] = c->q * t[j];
            velocity[3 + j] = c->q * x[j] + c->v * l[3 + j];
        }
    }
}

/* L and W of one marker */
void jo_newton_marker(const jo_model *m, jo_data *d, const jo_stage *stage, int marker)
{
    const int body = m->marker[marker].body;
    const jo_marker_tangent *y = &d->newton.marker[marker];
    motion_by_body(m, d, marker);
    motion_by_unknowns(&stage->weights, d->body[body].turn, y->L, y->W, jo_pad(6 + m->body[body].n));
}

/* Geometric stiffness of a load F, T (world) on a marker: r -= d(L^T) [F, T], as rotations and modes change its lever */
void jo_newton_stress(const jo_model *m, jo_data *d, const jo_stage *stage, int marker)
{
    const jo_marker *k = &m->marker[marker];
    const jo_marker_work *w = &d->marker[marker];
    const jo_body *b = &m->body[k->body];
    const jo_body_work *bw = &d->body[k->body];
    const int n = b->n, np = b->np;
    const jo_real q = stage->weights.q;
    jo_real f[3], t[3], M[9] = {0.0}, Q[9], x[3];
    jo_mul3t(f, bw->A, d->newton.marker[marker].load);
    jo_mul3t(t, bw->A, d->newton.marker[marker].load + 3);
    const jo_block N = jo_newton_find(m, d, k->body, k->body);
    const int turns = k->Psi && k->turns;
    jo_add_skew_skew(M, 1.0, w->u, f);
    jo_add_skew(M, 1.0, t);
    jo_mul33(Q, M, bw->turn);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) N.at[(3 + i) * N.stride + 3 + j] -= q * Q[3 * i + j];
    if (k->Phi)
        for (int j = 0; j < n; j++) {
            const jo_real phi[3] = {w->Phi[j], w->Phi[np + j], w->Phi[2 * np + j]};
            jo_cross(x, phi, f);   /* du x f for the torque; Phi . (f x dtheta) = (Phi x f) . dtheta */
            for (int i = 0; i < 3; i++) N.at[(3 + i) * N.stride + 6 + j] -= q * x[i];
            jo_mul3t(x, bw->turn, x);
            for (int i = 0; i < 3; i++) N.at[(6 + j) * N.stride + 3 + i] -= q * x[i];
        }
    if (turns) {
        jo_real Tt[9], y[3];
        operator_rate(M, w->theta, t, -1.0);   /* T^T t */
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) Tt[3 * i + j] = w->T[3 * j + i];
        jo_mul3(y, Tt, t);
        for (int i = 0; i < 9; i++) Q[i] = 0.0;
        jo_add_skew(Q, 1.0, t);
        jo_real X[9], Z[9];
        jo_mul33(X, Tt, Q);
        jo_mul33(Z, X, bw->turn);
        for (int j = 0; j < n; j++) {
            const jo_real psi[3] = {w->Psi[j], w->Psi[np + j], w->Psi[2 * np + j]};
            jo_mul3t(x, Z, psi);
            for (int i = 0; i < 3; i++) N.at[(6 + j) * N.stride + 3 + i] -= q * x[i];
            jo_mul3t(x, M, psi);   /* psi^T M Psi */
            for (int l = 0; l < n; l++)
                N.at[(6 + j) * N.stride + 6 + l] -= q * (x[0] * w->Psi[l] + x[1] * w->Psi[np + l] + x[2] * w->Psi[2 * np + l]);
        }
        if (k->chi)
            for (int c = 0; c < 3; c++)
                for (int j = 0; j < n; j++)
                    for (int l = 0; l < n; l++)
                        N.at[(6 + j) * N.stride + 6 + l] -= q * y[c] * k->chi[((3 + c) * n + j) * np + l];
    }
    if (k->chi && k->Phi)
        for (int c = 0; c < 3; c++)
            for (int j = 0; j < n; j++)
                for (int l = 0; l < n; l++) N.at[(6 + j) * N.stride + 6 + l] -= q * f[c] * k->chi[(c * n + j) * np + l];
}
