/* marker.c - position, velocity and acceleration of a frame on a body, and its rows with modal coordinates eliminated.
 *
 * r = R + A (u0 + Phi p), orientation A exp((Psi p)~) A0. The angular velocity relative to the body is
 * T(theta) theta', theta = Psi p; position, velocity, acceleration and virtual work all use the same T.
 */
#include "valid.h"
#include "maximal/maximal.h"

/* C = M N^T for (3 x np) arrays */
static inline void modal33(jo_real *restrict C, const jo_real *restrict M, const jo_real *restrict N, int np)
{
    for (int i = 0; i < 3; i++) jo_modal3(C + 3 * i, N, M + i * np, np);
}

/* Phi weight, Psi weight and their products with I3^T */
static void weigh(const jo_body *b, const jo_real *weight, const jo_marker_work *k, jo_marker_set *w)
{
    const int np = b->np;
    for (int c = 0; c < 3; c++)
        for (int j = 0; j < np; j++) {
            if (k->Phi) w->Phiw[c * np + j] = k->Phi[c * np + j] * weight[j];
            if (k->Psi) w->Psiw[c * np + j] = k->Psi[c * np + j] * weight[j];
        }
    if (k->Phi) modal33(w->PhiI3, w->Phiw, b->I3, np);
    if (k->Psi) modal33(w->PsiI3, w->Psiw, b->I3, np);
}

/* Xt = [E, -u~]: translation rows without elimination of modal coordinates */
static inline void unreduced(jo_real *Xt, const jo_real *u)
{
    const jo_real o = jo_same(0.0), e = jo_same(1.0);
    const jo_real rigid[18] = {e, o, o, o, u[2], -u[1], o, e, o, -u[2], o, u[0], o, o, e, u[1], -u[0], o};
    for (int j = 0; j < 18; j++) Xt[j] = rigid[j];
}

/* Xt and Xr of a marker on a rigid body, constant; times L^-T unless L is 0 */
static void rigid_rows(const jo_marker *k, const jo_real *L, jo_marker_work *w)
{
    jo_set3(w->u, k->u0);
    unreduced(w->maximal.Xt, w->u);
    for (int j = 0; j < 18; j++) w->maximal.Xr[j] = j == 3 || j == 10 || j == 17 ? jo_same(1.0) : jo_same(0.0);
    for (int r = 0; L && r < 3; r++) {
        jo_body_forward(L, w->maximal.Xt + 6 * r);
        jo_body_forward(L, w->maximal.Xr + 6 * r);
    }
}

/* constants of the active markers for a set of modal masses */
void jo_marker_setup(const jo_model *m, jo_data *d, int set)
{
    for (int i = 0; i < m->nactive; i++) {
        const jo_marker *k = &m->marker[i];
        if (k->body < 0) continue;
        if (!m->body[k->body].n) {
            rigid_rows(k, d->body[k->body].maximal.carried ? 0 : d->body[k->body].maximal.L, &d->marker[i]);
            continue;
        }
        weigh(&m->body[k->body], d->body[k->body].maximal.set[set].weight, &d->marker[i], &d->marker[i].maximal.set[set]);
    }
}

/* shapes = Phi + chi p, Psi + chi p: with geometric stiffening the displacement is Phi p + chi(p, p)/2, rotations likewise */
static void shapes_at(const jo_body *b, const jo_marker *k, const jo_real *p, jo_real *shapes)
{
    const int n = b->n, np = b->np;
    for (int c = 0; c < 6; c++) {
        const jo_real *first = c < 3 ? k->Phi : k->Psi, *chi = k->chi + c * n * np;
        jo_real *y = shapes + c * np;
        if (!first) continue;
        for (int j = 0; j < np; j++) y[j] = first[(c % 3) * np + j];
        for (int i = 0; i < n; i++, chi += np) {
            const jo_real pi = p[i];
            JO_EACH(j, np) JO_STORE(y + j) += pi * JO_LOAD(chi + j);
        }
    }
}

/* y = Phi p + chi(p, p)/2, from Phi and Phi + chi p */
static inline void displacement(jo_real *y, const jo_real *first, const jo_real *shape, const jo_real *p, int np)
{
    jo_real t[3];
    jo_modal3(y, shape, p, np);
    if (shape == first) return;
    jo_modal3(t, first, p, np);
    for (int c = 0; c < 3; c++) y[c] = 0.5 * (y[c] + t[c]);
}

/* y = chi(p', p') of the translation or the rotation */
static void quadratic(jo_real *y, const jo_real *chi, const jo_real *pd, int n, int np)
{
    for (int c = 0; c < 3; c++) {
        y[c] = jo_same(0.0);
        for (int i = 0; i < n; i++, chi += np) {
            jo_lanes s = {0};
            JO_EACH(j, np) s += JO_LOAD(chi + j) * JO_LOAD(pd + j);
            y[c] += pd[i] * jo_sum(s);
        }
    }
}

/* A = exp(theta~) A0 and the tangent operator T = E + f1 theta~ + f2 theta~ theta~ */
static void elastic_rotation(jo_real *A, jo_real *T, const jo_real *theta, const jo_real *A0)
{
    const jo_real s = jo_dot3(theta, theta);
    jo_real f[3], R[9];
    jo_sinc(s, f);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            jo_real square = theta[i] * theta[j];   /* theta~ theta~ = theta theta^T - s E */
            R[3 * i + j] = f[1] * square;
            T[3 * i + j] = f[2] * square;
        }
    for (int i = 0; i < 3; i++) {
        R[4 * i] += 1.0 - f[1] * s;
        T[4 * i] += 1.0 - f[2] * s;
    }
    const jo_real x = theta[0], y = theta[1], z = theta[2];
    R[1] -= f[0] * z; R[2] += f[0] * y; R[3] += f[0] * z; R[5] -= f[0] * x; R[6] -= f[0] * y; R[7] += f[0] * x;
    T[1] -= f[1] * z; T[2] += f[1] * y; T[3] += f[1] * z; T[5] -= f[1] * x; T[6] -= f[1] * y; T[7] += f[1] * x;
    jo_mul33(A, R, A0);
}

/* u = u0 + Phi p, r = R + A u, A_marker = A exp((Psi p)~) A0 of the first `count` markers */
void jo_marker_position(const jo_model *m, jo_data *d, int count)
{
    for (int i = 0; i < count; i++) {
        const jo_marker *k = &m->marker[i];
        jo_marker_work *w = &d->marker[i];
        if (k->body < 0 || jo_marker_inactive(d, i)) continue;   /* constant on ground */
        const jo_body *b = &m->body[k->body];
        const jo_body_work *bw = &d->body[k->body];
        if (k->chi) shapes_at(b, k, bw->p, w->maximal.shapes);
        jo_set3(w->u, k->u0);
        if (k->Phi) {
            jo_real t[3];
            displacement(t, k->Phi, w->Phi, bw->p, b->np);
            jo_add3(w->u, t);
        }
        jo_mul3(w->r, bw->A, w->u);
        jo_add3(w->r, d->q + b->iq);
        if (!k->turns && i < m->nactive && count == m->nactive) continue;
        if (k->Psi) {
            jo_real local[9];
            displacement(w->theta, k->Psi, w->Psi, bw->p, b->np);
            elastic_rotation(local, w->T, w->theta, k->A0);
            jo_mul33(w->A, bw->A, local);
        } else {
            jo_mul33(w->A, bw->A, k->A0);
        }
    }
}

/* v = V + w x u + Phi p', om = w + T Psi p' */
void jo_marker_velocity(const jo_model *m, jo_data *d, int count)
{
    for (int i = 0; i < count; i++) {
        const jo_marker *k = &m->marker[i];
        jo_marker_work *w = &d->marker[i];
        if (k->body < 0 || jo_marker_inactive(d, i)) continue;
        const int np = m->body[k->body].np;
        const jo_body_work *bw = &d->body[k->body];
        jo_real t[3];
        jo_cross(w->v, bw->w, w->u);
        jo_add3(w->v, bw->V);
        jo_set3(w->om, bw->w);
        if (k->Phi) {
            jo_modal3(t, w->Phi, bw->pd, np);
            jo_add3(w->v, t);
        }
        if (k->Psi) {
            jo_modal3(t, w->Psi, bw->pd, np);
            jo_mul3(t, w->T, t);
            jo_add3(w->om, t);
        }
    }
}

/* bv, bom: accelerations for R'' = w' = p'' = 0 */
void jo_marker_bias(const jo_model *m, jo_data *d, int count)
{
    for (int i = 0; i < count; i++) {
        const jo_marker *k = &m->marker[i];
        jo_marker_work *w = &d->marker[i];
        if (k->body < 0 || jo_marker_inactive(d, i)) continue;
        const jo_body *b = &m->body[k->body];
        const jo_body_work *bw = &d->body[k->body];
        jo_real t[3], c[3];
        /* w x (w x u) + 2 w x Phi p' = w x (v - V + Phi p') */
        jo_set3(t, w->v);
        jo_sub3(t, bw->V);
        if (k->Phi) {
            jo_cross(c, bw->w, w->u);   /* Phi p' = (v - V) - w x u */
            for (int j = 0; j < 3; j++) t[j] = 2.0 * t[j] - c[j];
        }
        jo_cross(w->maximal.bv, bw->w, t);
        if (k->chi && k->Phi) {
            quadratic(t, k->chi, bw->pd, b->n, b->np);
            jo_add3(w->maximal.bv, t);
        }
        if (!k->turns) continue;
        w->maximal.bom[0] = w->maximal.bom[1] = w->maximal.bom[2] = jo_same(0.0);
        if (k->Psi) {
            /* w x T theta' + T' theta', T' = f1' theta~ + f1 theta'~ + f2' theta~^2 + f2 (theta'~ theta~ + theta~ theta'~) */
            jo_real rate[3], f[3], df1, df2, tt[3], ttt[3];
            jo_modal3(rate, w->Psi, bw->pd, b->np);
            const jo_real s = jo_dot3(w->theta, w->theta), ds = 2.0 * jo_dot3(w->theta, rate);
            jo_sinc(s, f);
            jo_sinc_rate(s, f, &df1, &df2);
            jo_cross(tt, w->theta, rate);         /* theta x theta' */
            jo_cross(ttt, w->theta, tt);          /* theta x (theta x theta') */
            jo_cross(c, rate, tt);                /* theta' x (theta x theta') */
            for (int j = 0; j < 3; j++) w->maximal.bom[j] = ds * (df1 * tt[j] + df2 * ttt[j]) + f[2] * c[j];
            jo_set3(t, w->om);
            jo_sub3(t, bw->w);
            jo_cross(c, bw->w, t);
            jo_add3(w->maximal.bom, c);
            if (k->chi) {
                quadratic(t, k->chi + 3 * b->n * b->np, bw->pd, b->n, b->np);
                jo_mul3(t, w->T, t);
                jo_add3(w->maximal.bom, t);
            }
        }
    }
}

/* rows with modal coordinates eliminated, X = L_r - L_p weight M_pr, and acceleration a = bias + L_p weight f_p for R'' = w' = 0 */
void jo_marker_reduce(const jo_model *m, jo_data *d, int set, int count)
{
    for (int i = 0; i < count; i++) {
        const jo_marker *k = &m->marker[i];
        jo_marker_work *w = &d->marker[i];
        if (k->body < 0 || jo_marker_inactive(d, i)) continue;
        const int np = m->body[k->body].np;
        const jo_body_work *bw = &d->body[k->body];
        const jo_marker_set *s = &w->maximal.set[set];
        jo_set3(w->a, w->maximal.bv);
        if (!np) continue;
        if (k->chi) weigh(&m->body[k->body], bw->maximal.set[set].weight, w, &w->maximal.set[set]);
        jo_real *X = w->maximal.Xt, Q[9], t[3];
        unreduced(X, w->u);
        if (k->Phi) {
            modal33(Q, s->Phiw, bw->B, np);
            for (int r = 0; r < 3; r++)
                for (int c = 0; c < 3; c++) {
                    X[6 * r + c] -= s->PhiI3[3 * r + c];
                    X[6 * r + 3 + c] -= Q[3 * r + c];
                }
            jo_modal3(t, s->Phiw, bw->fp, np);
            jo_add3(w->a, t);
        }
        if (!k->turns) continue;
        X = w->maximal.Xr;
        for (int j = 0; j < 18; j++) X[j] = jo_same(0.0);
        jo_set3(w->a + 3, w->maximal.bom);
        if (k->Psi) {
            jo_real P[9];
            modal33(Q, s->Psiw, bw->B, np);
            jo_mul33(P, w->T, Q);
            jo_mul33(Q, w->T, s->PsiI3);
            for (int r = 0; r < 3; r++)
                for (int c = 0; c < 3; c++) {
                    X[6 * r + c] = -Q[3 * r + c];
                    X[6 * r + 3 + c] = -P[3 * r + c];
                }
            jo_modal3(t, s->Psiw, bw->fp, np);
            jo_mul3(t, w->T, t);
            jo_add3(w->a + 3, t);
        }
        X[3] += 1.0; X[10] += 1.0; X[17] += 1.0;
    }
}

/* y += M x, M (3 x np), x (n) without padding */
static void add_modal(jo_real *y, const jo_real *M, const jo_real *x, int n, int np)
{
    for (int c = 0; c < 3; c++)
        for (int j = 0; j < n; j++) y[c] += M[c * np + j] * x[j];
}

/* motion in the world frame; accelerations a = R'' + A (w' x u + Phi p'' + bv), al = A (w' + T Psi p'' + bom) */
void jo_marker_motion(const jo_model *m, const jo_data *d, int marker, int accelerations, jo_motion *y)
{
    const jo_marker *k = &m->marker[marker];
    const jo_marker_work *w = &d->marker[marker];
    jo_set3(y->r, w->r);
    jo_to_world(y->v, m, d, marker, w->v);
    jo_to_world(y->om, m, d, marker, w->om);
    for (int j = 0; j < 3; j++) y->a[j] = y->al[j] = jo_same(0.0);
    if (k->body < 0 || !accelerations) return;
    const jo_body *b = &m->body[k->body];
    const jo_real *a = d->a + b->iv, *A = d->body[k->body].A;
    jo_real t[3];
    jo_cross(t, a + 3, w->u);
    jo_add3(t, w->maximal.bv);
    if (k->Phi) add_modal(t, w->Phi, a + 6, b->n, b->np);
    jo_mul3(y->a, A, t);
    jo_add3(y->a, a);
    if (!k->turns) return;
    for (int j = 0; j < 3; j++) t[j] = jo_same(0.0);
    if (k->Psi) add_modal(t, w->Psi, a + 6, b->n, b->np);
    if (k->Psi) jo_mul3(t, w->T, t);
    jo_add3(t, w->maximal.bom);
    jo_add3(t, a + 3);
    jo_mul3(y->al, A, t);
}

/* y (6): acceleration and angular acceleration, world, after jo_evaluate */
void jo_marker_acceleration(const jo_model *m, const jo_data *d, int marker, jo_real *y)
{
    jo_motion of;
    jo_marker_motion(m, d, marker, 1, &of);
    jo_set3(y, of.a);
    jo_set3(y + 3, of.al);
}
