/* body_tangent.c - derivatives of body_residual() of newton_residual.c in Newton's matrix: inertia, gyroscopic and elastic forces. */
#include "newton/newton.h"

/* Common data of the parts of the block of a body. */
typedef struct {
    const jo_body *b;
    const jo_body_work *w;
    jo_real *Dd, *H;                /* (6 x np), (3 x np) ED p', EB p'' */
    jo_block N;
    double alpha;
    jo_real ca, cv, cq;             /* weights of accelerations, velocities and positions */
    const jo_real *wd, *pdd;
    jo_real acc[3];                 /* acceleration of the origin - g, local */
    jo_real Ip[3], Bp[3], Jd[6];    /* I3 p', B p', D p' */
} inertia;

/* One pass over ED or EB (symmetric, sign 1, or antisymmetric, sign -1): modal block N += sum of coef_c E_c, y_c = E_c x. */
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
                const jo_real factor = sign * coef[c];   /* E_jk = sign E_kj, so rows are read as rows */
                for (int k = 0; k < n; k++, e += rows)
                    for (int i = 0; i < JO_PAD; i += JO_WIDTH) {   /* padding: zeros are added */
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

/* block of the modal coordinates; Ip = I3 p', Bp = B p', Jd = D p' */
static inline void modal_block(const jo_weights *c, inertia *x)
{
    const jo_body *b = x->b;
    const jo_body_work *w = x->w;
    const int n = b->n, np = b->np;
    const jo_real *om = w->w;
    const jo_real ww[6] = {om[0] * om[0], om[1] * om[1], om[2] * om[2], 2 * om[1] * om[2], 2 * om[0] * om[2], 2 * om[0] * om[1]};
    const jo_block P = {x->N.at + 6 * x->N.stride + 6, x->N.stride};
    jo_real coef[6];
    for (int i = 0; i < 6; i++) coef[i] = -x->cq * ww[i];
    modal_sums(b, b->ED, 6, JO_ROW_D, 1.0, coef, w->pd, x->Dd, P);
    for (int i = 0; i < 3; i++) coef[i] = x->cq * x->wd[i] + 2.0 * x->cv * om[i];
    modal_sums(b, b->EB, 3, JO_ROW_B, -1.0, coef, x->pdd, x->H, P);
    for (int j = 0; j < n; j++) P.at[j * (P.stride + 1)] += x->ca + c->v * b->D[j] + c->q * b->K[j];
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < 3; i++) { x->Ip[i] += b->I3[i * np + j] * w->pd[j]; x->Bp[i] += w->B[i * np + j] * w->pd[j]; }
        for (int i = 0; i < 6; i++) x->Jd[i] += w->D[i * np + j] * w->pd[j];
    }
}

/* F - m acc = w' x S + I3 p'' + w x (w x S + 2 I3 p'), local: columns of translations and rotations */
static inline void force_block(const inertia *x)
{
    const jo_body *b = x->b;
    const jo_body_work *w = x->w;
    const jo_block N = x->N;
    const jo_real *om = w->w;
    jo_real turning[3], y[3], F[3], t[3], FF[9] = {0.0}, M[9] = {0.0}, Q[9];
    jo_cross(turning, om, w->S);
    for (int i = 0; i < 3; i++) y[i] = turning[i] + 2.0 * x->Ip[i];
    jo_cross(F, om, y);
    jo_cross(t, x->wd, w->S);
    jo_add3(F, t);
    jo_axpy3(F, x->alpha, turning);
    for (int j = 0; j < b->n; j++)
        for (int i = 0; i < 3; i++) F[i] += b->I3[i * b->np + j] * x->pdd[j];
    for (int i = 0; i < 3; i++) N.at[i * (N.stride + 1)] += x->ca * b->mass[0];
    jo_add_skew(FF, -x->ca, w->S);
    jo_add_skew(FF, -x->cv, y);
    jo_add_skew_skew(FF, -x->cv, om, w->S);
    jo_add_skew(M, -x->cq, F);
    jo_mul33(Q, M, w->turn);
    for (int i = 0; i < 9; i++) FF[i] += Q[i];
    jo_mul33(M, w->A, FF);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) N.at[i * N.stride + 3 + j] += M[3 * i + j];
}

/* T = S x acc + J w' + B p'' + w x (J w + B p') + 2 Jd w: columns of translations and rotations */
static inline void torque_block(const inertia *x)
{
    const jo_body_work *w = x->w;
    const jo_block N = x->N;
    const jo_real *A = w->A, *om = w->w, *Jd = x->Jd;
    const jo_real J[9] = {w->J[0], w->J[5], w->J[4], w->J[5], w->J[1], w->J[3], w->J[4], w->J[3], w->J[2]};
    const jo_real JJ[9] = {Jd[0], Jd[5], Jd[4], Jd[5], Jd[1], Jd[3], Jd[4], Jd[3], Jd[2]};
    jo_real T[9] = {0.0}, M[9] = {0.0}, Q[9], t[3];
    jo_add_skew(T, x->ca, w->S);
    for (int i = 0; i < 3; i++)   /* S~ A^T in the columns of R */
        for (int j = 0; j < 3; j++)
            N.at[(3 + i) * N.stride + j] += T[3 * i] * A[3 * j] + T[3 * i + 1] * A[3 * j + 1] + T[3 * i + 2] * A[3 * j + 2];
    jo_sym3(t, w->J, om);
    jo_add3(t, x->Bp);
    jo_add_skew(M, 1.0, om);
    jo_mul33(T, M, J);
    for (int i = 0; i < 9; i++) T[i] = x->ca * J[i] + x->cv * (T[i] + 2.0 * JJ[i]);
    jo_add_skew(T, -x->cv, t);
    for (int i = 0; i < 9; i++) M[i] = 0.0;
    jo_add_skew_skew(M, x->cq, w->S, x->acc);
    jo_mul33(Q, M, w->turn);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) N.at[(3 + i) * N.stride + 3 + j] += T[3 * i + j] + Q[3 * i + j];
}

/* row and column of modal coordinate k, with I3, B, D, Dd, G, H of this coordinate */
static inline void modal_column(const inertia *s, int k)
{
    const jo_body *b = s->b;
    const jo_body_work *w = s->w;
    const jo_block N = s->N;
    const int np = b->np;
    const jo_real ca = s->ca, cv = s->cv, cq = s->cq, *om = w->w, *wd = s->wd, *A = w->A;
    jo_real I3[3], B[3], D[6], Dd[6], G[3], H[3], f[3], g[3], h[3], Dw[3], x[3], t[3];
    for (int i = 0; i < 3; i++) {
        I3[i] = b->I3[i * np + k]; B[i] = w->B[i * np + k]; G[i] = w->G[i * np + k]; H[i] = s->H[i * np + k];
    }
    for (int i = 0; i < 6; i++) { D[i] = w->D[i * np + k]; Dd[i] = s->Dd[i * np + k]; }
    jo_cross(f, om, I3);
    jo_cross(g, om, f);
    jo_cross(h, wd, I3);
    for (int i = 0; i < 3; i++) x[i] = ca * I3[i] + 2.0 * cv * f[i] + cq * (g[i] + h[i]);
    jo_mul3(x, A, x);
    for (int i = 0; i < 3; i++) N.at[i * N.stride + 6 + k] += x[i];
    jo_sym3(Dw, D, om);
    jo_cross(f, om, B);
    for (int i = 0; i < 3; i++) x[i] = ca * B[i] + cv * (f[i] + 2.0 * Dw[i]);
    jo_cross(f, I3, s->acc);
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

/* F = m acc, T = J w' + w x J w of a rigid body with its mass centre at the origin of its frame; ca, cv: weights with damping */
static void centred_block(const jo_body *b, const jo_body_work *w, jo_block N, jo_real ca, jo_real cv)
{
    const jo_real *x = w->J, J[9] = {x[0], x[5], x[4], x[5], x[1], x[3], x[4], x[3], x[2]};
    jo_real T[9];
    for (int i = 0; i < 9; i++) T[i] = ca * J[i];
    if (cv != 0.0) {
        jo_real W[9] = {0.0}, WJ[9], t[3];
        jo_sym3(t, w->J, w->w);
        jo_add_skew(W, cv, w->w);
        jo_mul33(WJ, W, J);
        for (int i = 0; i < 9; i++) T[i] += WJ[i];
        jo_add_skew(T, -cv, t);
    }
    for (int i = 0; i < 3; i++) {
        jo_real *row = N.at + (3 + i) * N.stride + 3;
        N.at[i * (N.stride + 1)] += ca * b->mass[0];
        for (int j = 0; j < 3; j++) row[j] += T[3 * i + j];
    }
}

void jo_newton_body(const jo_model *m, jo_data *d, const jo_stage *stage, int body)
{
    const jo_body *b = &m->body[body];
    const jo_weights *c = &stage->weights;
    const jo_real *a = d->a + b->iv;
    /* mass-proportional damping: alpha M and derivatives of M v; explicit in a Rosenbrock method */
    const double alpha = stage->set ? 0.0 : b->alpha;
    inertia x = {b, &d->body[body], d->newton.Dd, d->newton.H, jo_newton_find(m, d, body, body), alpha, c->a + alpha * c->v,
                 c->plain ? 0.0 : c->v, c->plain ? 0.0 : c->q, a + 3, a + 6, {0.0}, {0.0}, {0.0}, {0.0}};
    jo_real t[3];
    if (jo_newton_centred(m, d, body)) {
        centred_block(b, x.w, x.N, x.ca, x.cv);
        return;
    }
    jo_set3(t, a);
    jo_sub3(t, m->gravity);
    jo_mul3t(x.acc, x.w->A, t);
    jo_axpy3(x.acc, alpha, x.w->V);
    if (b->n) modal_block(c, &x);
    force_block(&x);
    torque_block(&x);
    for (int k = 0; k < b->n; k++) modal_column(&x, k);
}
