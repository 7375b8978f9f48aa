/* blocks.c - Newton's matrix: kinematics of the markers and inertia of the bodies, differentiated.
 *
 * An unknown is an acceleration [R'' (world), w' (local), p'']; it changes the accelerations by weights.a, the
 * velocities by weights.v and the increments [dR, dtheta (local), dp] of the position by weights.q, where a change
 * of the increment turns the body by `turn` times itself (the tangent operator of the exponential).
 * Changes of markers are [dr, dphi, dv, dom], all in the world frame, with dA = dphi~ A.
 */
#include "internal.h"

/* M = d(T x)/dtheta or, with sign -1, d(T^T x)/dtheta of T = E + f1 theta~ + f2 theta~ theta~ */
static void operator_rate(jo_real *M, const jo_real *theta, const jo_real *x, double sign)
{
    const jo_real s = jo_dot3(theta, theta);
    jo_real f[3], df1, df2, one[3], two[3];
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

/* Y (3 x row, from column 6) += M X for X (3 x np) */
static void add_modal(jo_real *Y, int row, const jo_real *M, const jo_real *X, int np, int n)
{
    for (int i = 0; i < 3; i++) {
        const jo_real a = M[3 * i], b = M[3 * i + 1], c = M[3 * i + 2];
        jo_real *y = Y + i * row + 6;
        for (int j = 0; j < n; j++) y[j] += a * X[j] + b * X[np + j] + c * X[2 * np + j];
    }
}

/* the columns of rotations of Y (3 x row) */
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

/* L and W of one marker: the motion of a marker by that of its body */
static void marker_motion(const jo_model *m, jo_data *d, int marker)
{
    const jo_marker *k = &m->marker[marker];
    jo_marker_work *w = &d->marker[marker];
    const jo_body *b = &m->body[k->body];
    const jo_body_work *bw = &d->body[k->body];
    const int n = b->n, np = b->np, row = jo_pad(6 + n);
    const jo_weights *c = &d->weights;
    const jo_real *A = bw->A;
    jo_real *L = w->L, *W = w->W, M[9], Q[9], x[3], t[3];
    for (int i = 0; i < 6 * row; i++) L[i] = 0.0;
    for (int i = 0; i < 12 * row; i++) W[i] = 0.0;
    /* L, and in the last rows of W the change of [v, om] with the position */
    for (int i = 0; i < 3; i++) L[i * row + i] = 1.0;
    for (int i = 0; i < 9; i++) Q[i] = 0.0;
    jo_add_skew(Q, -1.0, w->u);
    jo_mul33(M, A, Q);
    set_turn(L, row, M);
    if (k->Phi) add_modal(L, row, A, w->Phi, np, n);
    set_turn(L + 3 * row, row, A);
    jo_set3(x, w->v);
    jo_sub3(x, bw->V);
    for (int i = 0; i < 9; i++) Q[i] = 0.0;
    jo_add_skew(Q, -1.0, x);
    jo_mul33(M, A, Q);
    set_turn(W + 6 * row, row, M);
    if (k->Phi) {
        for (int i = 0; i < 9; i++) Q[i] = 0.0;
        jo_add_skew(Q, 1.0, bw->w);
        jo_mul33(M, A, Q);
        add_modal(W + 6 * row, row, M, w->Phi, np, n);
    }
    for (int i = 0; i < 9; i++) Q[i] = 0.0;
    jo_add_skew(Q, -1.0, w->om);
    jo_mul33(M, A, Q);
    set_turn(W + 9 * row, row, M);
    if (k->Psi && k->turns) {
        jo_real AT[9];
        jo_mul33(AT, A, w->T);
        add_modal(L + 3 * row, row, AT, w->Psi, np, n);
        for (int i = 0; i < 3; i++) {
            x[i] = 0.0;
            for (int j = 0; j < n; j++) x[i] += w->Psi[i * np + j] * bw->pd[j];
        }
        operator_rate(Q, w->theta, x, 1.0);
        jo_mul33(M, A, Q);
        add_modal(W + 9 * row, row, M, w->Psi, np, n);
        if (k->chi) {
            second_order(d->body[k->body].Bw, k->chi + 3 * n * np, bw->pd, n, np);
            add_modal(W + 9 * row, row, AT, d->body[k->body].Bw, np, n);
        }
    }
    if (k->chi && k->Phi) {
        second_order(d->body[k->body].Bw, k->chi, bw->pd, n, np);
        add_modal(W + 6 * row, row, A, d->body[k->body].Bw, np, n);
    }
    /* with the unknowns: positions change by q turn, velocities by v, too */
    for (int i = 0; i < 6; i++) {
        jo_real *position = W + i * row, *velocity = W + (6 + i) * row;
        const jo_real *l = L + i * row;
        jo_mul3t(t, bw->turn, l + 3);
        jo_mul3t(x, bw->turn, velocity + 3);
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

/* A change of the pose of a body moves the lever of the force F, T (world) on a marker: r -= d(L^T) [F, T] */
static void marker_stress(const jo_model *m, jo_data *d, int marker)
{
    const jo_marker *k = &m->marker[marker];
    const jo_marker_work *w = &d->marker[marker];
    const jo_body *b = &m->body[k->body];
    const jo_body_work *bw = &d->body[k->body];
    const int n = b->n, np = b->np;
    const jo_real q = d->weights.q;
    jo_real f[3], t[3], M[9] = {0.0}, Q[9], x[3];
    jo_mul3t(f, bw->A, w->load);
    jo_mul3t(t, bw->A, w->load + 3);
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

/* Four entries E[j..j+3] of row c and column k of ED or EB in the layout of the body: symmetric or antisymmetric.
 * N (modal block) += sum of coef_c E_c, and y_c += E_c x in the same pass. */
static void modal_sums(const jo_body *b, const jo_real *E, int components, int rows, double sign, const jo_real *coef,
                       const jo_real *x, jo_real *y, jo_block N)
{
    const int n = b->n, np = b->np;
    for (int i = 0; i < components * np; i++) y[i] = 0.0;
    if (np <= JO_DENSE) {
        for (int c = 0; c < components; c++)
            for (int j = 0; j < np; j += JO_PAD) {
                const int at = c * np + j;
                const jo_real *e = E + (at / rows) * n * rows + at % rows;
                const jo_real factor = sign * coef[c];   /* E_jk = sign E_kj: rows stay rows */
                for (int k = 0; k < n; k++, e += rows)
                    for (int i = 0; i < JO_PAD; i += JO_WIDTH) {   /* beyond n zeros are added */
                        JO_STORE(y + at + i) += JO_LOAD(e + i) * x[k];
                        JO_STORE(N.at + k * N.stride + j + i) += factor * JO_LOAD(e + i);
                    }
            }
        return;
    }
    for (int c = 0; c < components; c++)
        for (int k = 0; k < np; k += 4)
            for (int j = k; j < np; j += 4, E += 16)
                for (int kk = k; kk < k + 4 && kk < n; kk++)
                    for (int jj = j; jj < j + 4 && jj < n; jj++) {
                        const jo_real e = E[4 * (kk - k) + jj - j];   /* E_jj,kk */
                        y[c * np + jj] += e * x[kk];
                        N.at[kk * N.stride + jj] += sign * coef[c] * e;
                        if (j == k) continue;
                        y[c * np + kk] += sign * e * x[jj];
                        N.at[jj * N.stride + kk] += coef[c] * e;
                    }
}

/* the inertia of a body, its gyroscopic and elastic forces: balance() of tangent.c, differentiated */
static void inertia(const jo_model *m, jo_data *d, int body)
{
    const jo_body *b = &m->body[body];
    jo_body_work *w = &d->body[body];
    const jo_weights *c = &d->weights;
    /* damping of the momenta: alpha M and how M v turns; ROS2, which keeps the stiffness, leaves it explicit */
    const double alpha = d->keeping ? 0.0 : b->alpha;
    const jo_real ca = c->a + alpha * c->v, cv = c->plain ? 0.0 : c->v, cq = c->plain ? 0.0 : c->q;
    const jo_real *a = d->a + b->iv, *wd = a + 3, *pdd = a + 6, *om = w->w, *A = w->A;
    const int n = b->n, np = b->np;
    const jo_block N = jo_newton_find(m, d, body, body);
    jo_real acc[3], t[3], x[3], y[3], FF[9] = {0.0}, M[9], Q[9], Ip[3] = {0.0}, Bp[3] = {0.0}, Jd[6] = {0.0}, F[3];
    jo_set3(t, a);
    jo_sub3(t, m->gravity);
    jo_mul3t(acc, A, t);
    jo_axpy3(acc, alpha, w->V);
    const jo_real ww[6] = {om[0] * om[0], om[1] * om[1], om[2] * om[2], 2 * om[1] * om[2], 2 * om[0] * om[2], 2 * om[0] * om[1]};
    if (n) {
        const jo_block P = {N.at + 6 * N.stride + 6, N.stride};
        jo_real coef[6];
        for (int i = 0; i < 6; i++) coef[i] = -cq * ww[i];
        modal_sums(b, b->ED, 6, JO_ROW_D, 1.0, coef, w->pd, w->Dd, P);
        for (int i = 0; i < 3; i++) coef[i] = cq * wd[i] + 2.0 * cv * om[i];
        modal_sums(b, b->EB, 3, JO_ROW_B, -1.0, coef, pdd, w->H, P);
        for (int j = 0; j < n; j++) P.at[j * (P.stride + 1)] += ca + c->v * b->D[j] + c->q * b->K[j];
        for (int j = 0; j < n; j++) {
            for (int i = 0; i < 3; i++) { Ip[i] += b->I3[i * np + j] * w->pd[j]; Bp[i] += w->B[i * np + j] * w->pd[j]; }
            for (int i = 0; i < 6; i++) Jd[i] += w->D[i * np + j] * w->pd[j];
        }
    }
    /* force on the origin, local: F - m acc = w' x S + I3 p'' + w x (w x S + 2 I3 p') */
    jo_cross(x, om, w->S);
    for (int i = 0; i < 3; i++) y[i] = x[i] + 2.0 * Ip[i];
    jo_cross(F, om, y);
    jo_cross(t, wd, w->S);
    jo_add3(F, t);
    jo_axpy3(F, alpha, x);
    for (int j = 0; j < n; j++)
        for (int i = 0; i < 3; i++) F[i] += b->I3[i * np + j] * pdd[j];
    for (int i = 0; i < 3; i++) N.at[i * (N.stride + 1)] += ca * b->mass[0];
    jo_add_skew(FF, -ca, w->S);
    jo_add_skew(FF, -cv, y);
    jo_add_skew_skew(FF, -cv, om, w->S);
    for (int i = 0; i < 9; i++) M[i] = 0.0;
    jo_add_skew(M, -cq, F);
    jo_mul33(Q, M, w->turn);
    for (int i = 0; i < 9; i++) FF[i] += Q[i];
    jo_mul33(M, A, FF);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) N.at[i * N.stride + 3 + j] += M[3 * i + j];
    /* torque: S x acc + J w' + B p'' + w x (J w + B p') + 2 Jd w */
    jo_real T[9] = {0.0}, J[9] = {w->J[0], w->J[5], w->J[4], w->J[5], w->J[1], w->J[3], w->J[4], w->J[3], w->J[2]};
    jo_add_skew(T, ca, w->S);
    for (int i = 0; i < 3; i++)   /* S~ A^T in the columns of R */
        for (int j = 0; j < 3; j++)
            N.at[(3 + i) * N.stride + j] += T[3 * i] * A[3 * j] + T[3 * i + 1] * A[3 * j + 1] + T[3 * i + 2] * A[3 * j + 2];
    jo_sym3(t, w->J, om);
    jo_add3(t, Bp);
    for (int i = 0; i < 9; i++) M[i] = 0.0;
    jo_add_skew(M, 1.0, om);
    jo_mul33(T, M, J);
    const jo_real JJ[9] = {Jd[0], Jd[5], Jd[4], Jd[5], Jd[1], Jd[3], Jd[4], Jd[3], Jd[2]};
    for (int i = 0; i < 9; i++) T[i] = ca * J[i] + cv * (T[i] + 2.0 * JJ[i]);
    jo_add_skew(T, -cv, t);
    for (int i = 0; i < 9; i++) M[i] = 0.0;
    jo_add_skew_skew(M, cq, w->S, acc);
    jo_mul33(Q, M, w->turn);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) N.at[(3 + i) * N.stride + 3 + j] += T[3 * i + j] + Q[3 * i + j];
    /* modal columns and rows */
    for (int k = 0; k < n; k++) {
        jo_real I3[3], B[3], D[6], Dd[6], G[3], H[3], f[3], g[3], h[3], Dw[3];
        for (int i = 0; i < 3; i++) {
            I3[i] = b->I3[i * np + k]; B[i] = w->B[i * np + k]; G[i] = w->G[i * np + k]; H[i] = w->H[i * np + k];
        }
        for (int i = 0; i < 6; i++) { D[i] = w->D[i * np + k]; Dd[i] = w->Dd[i * np + k]; }
        jo_cross(f, om, I3);
        jo_cross(g, om, f);
        jo_cross(h, wd, I3);
        for (int i = 0; i < 3; i++) x[i] = ca * I3[i] + 2.0 * cv * f[i] + cq * (g[i] + h[i]);
        jo_mul3(x, A, x);
        for (int i = 0; i < 3; i++) N.at[i * N.stride + 6 + k] += x[i];
        jo_sym3(Dw, D, om);
        jo_cross(f, om, B);
        for (int i = 0; i < 3; i++) x[i] = ca * B[i] + cv * (f[i] + 2.0 * Dw[i]);
        jo_cross(f, I3, acc);
        for (int i = 0; i < 3; i++) g[i] = 2.0 * Dw[i] - G[i];
        jo_cross(h, om, g);
        jo_sym3(g, D, wd);
        jo_sym3(t, Dd, om);
        for (int i = 0; i < 3; i++) x[i] += cq * (f[i] + 2.0 * g[i] - H[i] + h[i] + 2.0 * t[i]);
        for (int i = 0; i < 3; i++) N.at[(3 + i) * N.stride + 6 + k] += x[i];
        jo_mul3(x, A, I3);
        jo_mul3t(g, w->turn, f);   /* I3 . (acc x dtheta) = (I3 x acc) . dtheta */
        for (int i = 0; i < 3; i++) {
            N.at[(6 + k) * N.stride + i] += ca * x[i];
            N.at[(6 + k) * N.stride + 3 + i] += ca * B[i] + 2.0 * cv * (G[i] - Dw[i]) + cq * g[i];
        }
    }
}

void jo_newton_masses(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nnewton; i++) d->N[i] = 0.0;
    for (int i = 0; i < m->nbody; i++) inertia(m, d, i);
    if (m->nbeam) jo_newton_beams(m, d);
}

void jo_newton_rows(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        for (int s = 0; s < k->nside; s++)
            if (m->marker[k->side[s]].body >= 0) marker_motion(m, d, k->side[s]);
        jo_newton_joint(m, d, i);
    }
}

int jo_newton_assemble(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nnewton; i++) d->N[i] = 0.0;
    for (int i = 0; i < m->nbody; i++) inertia(m, d, i);
    if (m->nbeam) jo_newton_beams(m, d);
    for (int i = 0; i < m->nactive; i++) {
        for (int j = 0; j < 6; j++) d->marker[i].load[j] = 0.0;
        if (m->marker[i].body >= 0) marker_motion(m, d, i);
    }
    for (int i = 0; i < m->njoint; i++) jo_newton_joint(m, d, i);
    if (m->nfriction) jo_newton_frictions(m, d);
    const int status = jo_newton_forces(m, d);
    if (status != JO_OK) return status;
    if (d->weights.q != 0.0)
        for (int i = 0; i < m->nactive; i++)
            if (m->marker[i].body >= 0) marker_stress(m, d, i);
    return JO_OK;
}

/* the matrix at any weights, for tests and analyses */
static int assemble_with(const jo_model *m, jo_data *d, double ca, double cv, double cq)
{
    const jo_weights weights = {ca, cv, cq, 1.0, 0, 0};
    for (int i = 0; i < m->nbody; i++)
        for (int j = 0; j < 9; j++) d->body[i].turn[j] = j % 4 == 0;
    const int status = jo_residual(m, d, d->rate);
    d->weights = weights;
    d->factored = 0;
    return status == JO_OK ? jo_newton_assemble(m, d) : status;
}

int jo_newton_values(const jo_model *m, jo_data *d, double ca, double cv, double cq, jo_real *out)
{
    const int status = assemble_with(m, d, ca, cv, cq);
    for (int i = 0; i < m->nnewton && status == JO_OK; i++) out[i] = d->N[i];
    return status;
}

/* in the order of [v, lam] */
int jo_newton_matrix(const jo_model *m, jo_data *d, double ca, double cv, double cq, jo_real *out)
{
    const int count = m->nv + m->nrow;
    const int status = assemble_with(m, d, ca, cv, cq);
    if (status != JO_OK) return status;
    for (int i = 0; i < count * count; i++) out[i] = 0.0;
    for (int x = 0; x < m->nbody + m->njoint; x++)
        for (int y = 0; y < m->nbody + m->njoint; y++) {
            const int nx = x < m->nbody ? 6 + m->body[x].n : m->joint[x - m->nbody].nrow;
            const int ny = y < m->nbody ? 6 + m->body[y].n : m->joint[y - m->nbody].nrow;
            const int ix = x < m->nbody ? m->body[x].iv : m->nv + m->joint[x - m->nbody].row;
            const int iy = y < m->nbody ? m->body[y].iv : m->nv + m->joint[y - m->nbody].row;
            jo_block block = jo_newton_find(m, d, x, y);
            if (!block.at) continue;
            for (int i = 0; i < nx; i++)
                for (int j = 0; j < ny; j++) out[(ix + i) * count + iy + j] = block.at[i * block.stride + j];
        }
    return JO_OK;
}
