/* body.c - mass matrix, velocity-dependent and elastic forces of one modal body, and elimination of its modal coordinates.
 *
 * With [R'' (resolved in the body frame), w', p''] the mass matrix is
 *   [ m E   -S~   I3 ]
 *   [       J     B  ]     J(p), B(p): Rantalainen 2007, eq. 3.49-3.67
 *   [             E  ]
 * D_j is half the derivative of J with respect to p_j; all p-dependence is one product E p.
 */
#include "maximal/maximal.h"

/* A, its columns and p from q */
void jo_body_pose(const jo_body *b, jo_body_work *w, const jo_real *q)
{
    jo_rotation(w->A, q + 3);
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < 3; i++) w->At[4 * j + i] = w->A[3 * i + j];
    for (int j = 0; j < b->n; j++) w->p[j] = q[7 + j];
}

/* part of a block of rows; the accumulators of a part fit into the registers */
#if defined(JO_VECTOR) && !defined(__AVX512F__)
enum { JO_SHARES = 2 };
#else
enum { JO_SHARES = 1 };
#endif

/* y = y0 + E p by blocks of rows, with the accumulators in registers */
static void contract_d(int blocks, int n, const jo_real *restrict E, const jo_real *restrict p,
                       const jo_real *restrict y0, jo_real *restrict y)
{
    enum { COUNT = JO_ROW_D / JO_WIDTH / JO_SHARES, ROWS = COUNT * JO_WIDTH };
    for (int k = 0; k < blocks * JO_SHARES; k++) {
        const jo_real *e = E + k / JO_SHARES * n * JO_ROW_D + k % JO_SHARES * ROWS;
        jo_lanes acc[COUNT];
        for (int i = 0; i < COUNT; i++) acc[i] = JO_LOAD(y0 + i * JO_WIDTH);
        for (int j = 0; j < n; j++) {
            const jo_real pj = p[j];
            for (int i = 0; i < COUNT; i++) acc[i] += pj * JO_LOAD(e + i * JO_WIDTH);
            e += JO_ROW_D;
        }
        for (int i = 0; i < COUNT; i++) JO_STORE(y + i * JO_WIDTH) = acc[i];
        y0 += ROWS;
        y += ROWS;
    }
}

/* y = y0 + E p and z = E r in one pass over E */
static void contract_b(int blocks, int n, const jo_real *restrict E, const jo_real *restrict p,
                       const jo_real *restrict r, const jo_real *restrict y0, jo_real *restrict y,
                       jo_real *restrict z)
{
    enum { COUNT = JO_ROW_B / JO_WIDTH / JO_SHARES, ROWS = COUNT * JO_WIDTH };
    for (int k = 0; k < blocks * JO_SHARES; k++) {
        const jo_real *e = E + k / JO_SHARES * n * JO_ROW_B + k % JO_SHARES * ROWS;
        jo_lanes acc[COUNT], dot[COUNT];
        for (int i = 0; i < COUNT; i++) { acc[i] = JO_LOAD(y0 + i * JO_WIDTH); dot[i] = acc[i] - acc[i]; }
        for (int j = 0; j < n; j++) {
            const jo_real pj = p[j], rj = r[j];
            for (int i = 0; i < COUNT; i++) {
                const jo_lanes x = JO_LOAD(e + i * JO_WIDTH);
                acc[i] += pj * x;
                dot[i] += rj * x;
            }
            e += JO_ROW_B;
        }
        for (int i = 0; i < COUNT; i++) { JO_STORE(y + i * JO_WIDTH) = acc[i]; JO_STORE(z + i * JO_WIDTH) = dot[i]; }
        y0 += ROWS;
        y += ROWS;
        z += ROWS;
    }
}

/* y[v] += E p[v] for a symmetric (sign 1) or antisymmetric (sign -1) matrix E (np x np), stored as its 4 x 4 tiles on and below the
 * diagonal: half the memory traffic, which limits the speed of large bodies */
static inline void contract_tiles(const int np, const double sign, const int vectors, const jo_real *restrict E,
                                  const jo_real *const *p, jo_real *const *y)
{
    /* column block k: diagonal tile, then tiles below it, which also act transposed on rows k */
    for (int k = 0; k < np; k += 4) {
        jo_lanes column[2][4];
        jo_real pk[2][4];
        for (int v = 0; v < vectors; v++)
            for (int c = 0; c < 4; c++) {
                const jo_lanes zero = {0};
                column[v][c] = zero;
                pk[v][c] = p[v][k + c];
            }
        for (int v = 0; v < vectors; v++)
            for (int l = 0; l < 4; l += JO_WIDTH)
                for (int c = 0; c < 4; c++) JO_STORE(y[v] + k + l) += pk[v][c] * JO_LOAD(E + 4 * c + l);
        E += 16;
        for (int j = k + 4; j < np; j += 4, E += 16)
            for (int l = 0; l < 4; l += JO_WIDTH)
                for (int v = 0; v < vectors; v++) {
                    const jo_lanes pj = JO_LOAD(p[v] + j + l);
                    jo_lanes yj = JO_LOAD(y[v] + j + l);
                    for (int c = 0; c < 4; c++) {
                        const jo_lanes e = JO_LOAD(E + 4 * c + l);
                        yj += pk[v][c] * e;
                        column[v][c] += e * pj;
                    }
                    JO_STORE(y[v] + j + l) = yj;
                }
        for (int v = 0; v < vectors; v++) {
            jo_real sums[4];
            jo_sums(sums, column[v][0], column[v][1], column[v][2], column[v][3]);
            for (int c = 0; c < 4; c++) y[v][k + c] += sign * sums[c];
        }
    }
}

/* D = D0 + ED p, B = B0 + EB p, G = EB p' in the layout of the body */
static void contract(const jo_body *b, jo_body_work *w)
{
    const int np = b->np;
    if (np <= JO_DENSE) {
        contract_d(6 * np / JO_ROW_D, b->n, b->ED, w->p, b->D0, w->D);
        contract_b(3 * np / JO_ROW_B, b->n, b->EB, w->p, w->pd, b->B0, w->B, w->G);
        return;
    }
    const int tiles = np * (np + 4) / 2;   /* reals of one component */
    const jo_real *const p[2] = {w->p, w->pd};
    for (int i = 0; i < 6 * np; i++) w->D[i] = b->D0[i];
    for (int i = 0; i < 3 * np; i++) { w->B[i] = b->B0[i]; w->G[i] = jo_same(0.0); }
    for (int c = 0; c < 6; c++) {
        jo_real *const y[1] = {w->D + c * np};
        contract_tiles(np, 1.0, 1, b->ED + c * tiles, p, y);
    }
    for (int c = 0; c < 3; c++) {
        jo_real *const y[2] = {w->B + c * np, w->G + c * np};
        contract_tiles(np, -1.0, 2, b->EB + c * tiles, p, y);
    }
}

/* V = A^T R', w and p' from v */
void jo_body_twist(const jo_body *b, jo_body_work *w, const jo_real *v)
{
    jo_mul3t(w->V, w->A, v);
    jo_set3(w->w, v + 3);
    for (int j = 0; j < b->n; j++) w->pd[j] = v[6 + j];
}

/* J += sum (D0_j + D_j) p_j; Jd = sum D_j p'_j = J' / 2 */
static inline void inertia(const int np, const jo_real *restrict D0, const jo_real *restrict D,
                           const jo_real *restrict p, const jo_real *restrict pd, jo_real *restrict J,
                           jo_real *restrict Jd)
{
    for (int c = 0; c < 6; c += 2, D0 += 2 * np, D += 2 * np) {
        const jo_lanes zero = {0};
        jo_lanes s[2] = {zero, zero}, sd[2] = {zero, zero};
        jo_real sums[4];
        JO_EACH(j, np)
            for (int k = 0; k < 2; k++) {
                const jo_lanes x = JO_LOAD(D + k * np + j);
                s[k] += (JO_LOAD(D0 + k * np + j) + x) * JO_LOAD(p + j);
                sd[k] += x * JO_LOAD(pd + j);
            }
        jo_sums(sums, s[0], s[1], sd[0], sd[1]);
        for (int k = 0; k < 2; k++) { J[c + k] += sums[k]; Jd[c + k] += sums[2 + k]; }
    }
}

/* modal force Q_p,j = w . D_j w - 2 w . int phi' x phi_j dm - K p - D p' + extra; returns the power of the damping, W */
static inline jo_real modal_force(const jo_body *b, const jo_real *om, const jo_real *restrict D,
                                  const jo_real *restrict G, const jo_real *restrict p, const jo_real *restrict pd,
                                  const jo_real *restrict extra, jo_real *restrict fp)
{
    const int np = b->np;
    const jo_real w0 = om[0], w1 = om[1], w2 = om[2];
    const jo_real xx = w0 * w0, yy = w1 * w1, zz = w2 * w2;
    const jo_real yz = 2.0 * w1 * w2, xz = 2.0 * w0 * w2, xy = 2.0 * w0 * w1;
    const jo_real v0 = 2.0 * w0, v1 = 2.0 * w1, v2 = 2.0 * w2;
    jo_lanes loss = {0};
    JO_EACH(j, np) {
        const jo_real *x = D + j, *g = G + j;
        const jo_lanes damping = JO_LOAD(b->D + j) * JO_LOAD(pd + j);
        JO_STORE(fp + j) = JO_LOAD(extra + j) - JO_LOAD(b->K + j) * JO_LOAD(p + j) - damping
            + xx * JO_LOAD(x) + yy * JO_LOAD(x + np) + zz * JO_LOAD(x + 2 * np) + yz * JO_LOAD(x + 3 * np)
            + xz * JO_LOAD(x + 4 * np) + xy * JO_LOAD(x + 5 * np)
            - v0 * JO_LOAD(g) - v1 * JO_LOAD(g + np) - v2 * JO_LOAD(g + 2 * np);
        loss += damping * JO_LOAD(pd + j);
    }
    return jo_sum(loss);
}

/* fr -= alpha [m V + w x S, J w + S x V], the momenta; returns the power of this damping, W */
static jo_real damp(const jo_body *b, jo_body_work *w, const jo_real *wS, const jo_real *Jw)
{
    jo_real power = {0.0}, SV[3];
    jo_cross(SV, w->S, w->V);
    for (int j = 0; j < 3; j++) {
        const jo_real p = b->mass[0] * w->V[j] + wS[j], h = Jw[j] + SV[j];
        w->fr[j] -= b->alpha * p;
        w->fr[3 + j] -= b->alpha * h;
        power += b->alpha * (p * w->V[j] + h * w->w[j]);
    }
    return power;
}

/* S, J, B, D at p; velocity-dependent and elastic forces fr, fp; power += power of the damping */
void jo_body_inertia(const jo_body *b, jo_body_work *w, jo_real *power)
{
    const int np = b->np;
    const jo_real *om = w->w;
    jo_real Ip[3] = {0}, Jd[6] = {0}, Bp[3] = {0}, t[3];
    if (!b->n) {   /* rigid: fr = [-w x (w x S), -w x J w] */
        jo_cross(t, om, w->S);
        jo_cross(w->fr, t, om);
        jo_sym3(Jd, w->J, om);
        jo_cross(w->fr + 3, Jd, om);
        if (b->alpha != 0.0) *power += damp(b, w, t, Jd);
        return;
    }
    /* S = S0 + I3 p, J = J0 + sum (D0_j + D_j) p_j, Ip = I3 p', Bp = B p' */
    jo_set3(w->S, b->S0);
    for (int c = 0; c < 6; c++) w->J[c] = b->J0[c];
    contract(b, w);
    jo_modal3(t, b->I3, w->p, np);
    jo_add3(w->S, t);
    jo_modal3(Ip, b->I3, w->pd, np);
    jo_modal3(Bp, w->B, w->pd, np);
    inertia(np, b->D0, w->D, w->p, w->pd, w->J, Jd);
    *power += modal_force(b, om, w->D, w->G, w->p, w->pd, w->maximal.extra, w->fp);
    /* Q_R = -w x (w x S) - 2 w x I3 p' */
    jo_cross(t, om, w->S);
    for (int i = 0; i < 3; i++) t[i] += 2.0 * Ip[i];
    jo_cross(w->fr, t, om);
    /* Q_w = -w x (J w + B p') - J' w */
    jo_sym3(t, w->J, om);
    jo_add3(t, Bp);
    jo_cross(w->fr + 3, t, om);
    jo_sym3(t, Jd, om);
    jo_axpy3(w->fr + 3, jo_same(-2.0), t);
}

/* x = L^-1 x, L (6 x 6) with the inverse of its diagonal */
void jo_body_forward(const jo_real *L, jo_real *x)
{
    for (int i = 0; i < 6; i++) {
        jo_real s = x[i];
        for (int k = 0; k < i; k++) s -= L[6 * i + k] * x[k];
        x[i] = s * L[7 * i];
    }
}

/* x = L^-T x */
void jo_body_backward(const jo_real *L, jo_real *x)
{
    for (int i = 5; i >= 0; i--) {
        jo_real s = x[i];
        for (int k = i + 1; k < 6; k++) s -= L[6 * k + i] * x[k];
        x[i] = s * L[7 * i];
    }
}

/* Bw = B weight, IB = I3 Bw^T, BB = B Bw^T (lower triangle) */
static inline void weigh(const int np, const jo_real *restrict B, const jo_real *restrict I3,
                         const jo_real *restrict weight, jo_real *restrict Bw, jo_real *restrict IB,
                         jo_real *restrict BB)
{
    for (int i = 0; i < 3; i++) {
        jo_lanes ib0 = {0}, ib1 = {0}, ib2 = {0}, bb0 = {0}, bb1 = {0}, bb2 = {0};
        JO_EACH(j, np) {
            const jo_lanes x = JO_LOAD(B + i * np + j) * JO_LOAD(weight + j);
            JO_STORE(Bw + i * np + j) = x;
            ib0 += JO_LOAD(I3 + j) * x;
            ib1 += JO_LOAD(I3 + np + j) * x;
            ib2 += JO_LOAD(I3 + 2 * np + j) * x;
            bb0 += JO_LOAD(B + j) * x;
            bb1 += JO_LOAD(B + np + j) * x;
            bb2 += JO_LOAD(B + 2 * np + j) * x;
        }
        jo_real ib[4], bb[4];
        jo_sums(ib, ib0, ib1, ib2, ib2);
        jo_sums(bb, bb0, bb1, bb2, bb2);
        for (int c = 0; c < 3; c++) { IB[3 * c + i] = ib[c]; BB[3 * c + i] = bb[c]; }
    }
}

/* Z = M_rr - M_rp weight M_pr = L L^T for [R'', w'], by rows; JO_SINGULAR_BODY if a pivot is below JO_MIN_PIVOT */
static int factor(const jo_body *b, jo_body_work *w, int set)
{
    const int np = b->np;
    const jo_body_set *s = &w->maximal.set[set];
    jo_real IB[9] = {0}, BB[9] = {0}, *L = w->maximal.L;
    if (b->n) weigh(np, w->B, b->I3, s->weight, w->maximal.Bw, IB, BB);
    /* rows w, columns R of Z: (-S~)^T - (I3 weight B^T)^T; the block RR is constant and factored */
    const jo_real *S = w->S, *J = w->J;
    const jo_real Y[9] = {-IB[0], -S[2] - IB[3], S[1] - IB[6],
                          S[2] - IB[1], -IB[4], -S[0] - IB[7],
                          -S[1] - IB[2], S[0] - IB[5], -IB[8]};
    const jo_real zero = {0.0};
    const jo_real W[9] = {J[0] - BB[0], zero, zero, J[5] - BB[3], J[1] - BB[4], zero,
                          J[4] - BB[6], J[3] - BB[7], J[2] - BB[8]};
    const jo_real *K = s->L11;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k <= i; k++) L[6 * i + k] = K[3 * i + k];
    /* L_wR = Y L_RR^-T */
    for (int i = 0; i < 3; i++) {
        jo_real *x = L + 6 * (3 + i);
        x[0] = Y[3 * i] * K[0];
        x[1] = (Y[3 * i + 1] - K[3] * x[0]) * K[4];
        x[2] = (Y[3 * i + 2] - K[6] * x[0] - K[7] * x[1]) * K[8];
    }
    /* L_ww L_ww^T = J - B weight B^T - L_wR L_wR^T */
    for (int i = 0; i < 3; i++) {
        jo_real *x = L + 6 * (3 + i);
        for (int k = 0; k <= i; k++) {
            const jo_real *y = L + 6 * (3 + k);
            jo_real t = W[3 * i + k];
            for (int j = 0; j < 3 + k; j++) t -= x[j] * y[j];
            if (k < i) {
                x[3 + k] = t * y[3 + k];
            } else {
                if (jo_spoil(&t, JO_LESS(JO_MIN_PIVOT * W[4 * i], t)))
                    return isfinite(jo_most(t)) ? JO_SINGULAR_BODY : JO_NOT_FINITE;
                x[3 + i] = 1.0 / jo_sqrt(t);
            }
        }
    }
    return JO_OK;
}

int jo_body_factor(const jo_body *b, jo_body_work *w, int set) { return b->n || w->maximal.carried ? factor(b, w, set) : w->maximal.status; }

/* carried = [M H; H^T J] of the trees on a body, in its frame, + [0 -S~; S~ J] of the body */
void jo_body_carry(jo_body_work *w, jo_real (*M)[3], jo_real (*H)[3], jo_real (*J)[3])
{
    const jo_real *S = w->S, *Jb = w->J, zero = jo_same(0.0);
    jo_real *carried = w->maximal.carried;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            carried[6 * i + k] = M[k][i];
            carried[6 * (3 + i) + k] = H[i][k];
            carried[6 * (3 + i) + 3 + k] = J[k][i];
        }
    /* inertia of the body itself, except for its mass */
    const jo_real own[9] = {zero, -S[2], S[1], S[2], zero, -S[0], -S[1], S[0], zero};
    const jo_real full[9] = {Jb[0], Jb[5], Jb[4], Jb[5], Jb[1], Jb[3], Jb[4], Jb[3], Jb[2]};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            carried[6 * (3 + i) + k] += own[3 * i + k];
            carried[6 * (3 + i) + 3 + k] += full[3 * i + k];
        }
}

/* Cholesky factor L of `carried` and the mass of a body without modes; recomputed in every evaluation because I^A of the trees depends on x */
int jo_body_factor_carried(const jo_body *b, jo_body_work *w)
{
    const jo_real *carried = w->maximal.carried;
    jo_real *L = w->maximal.L;
    for (int i = 0; i < 6; i++) {
        jo_real *x = L + 6 * i;
        const jo_real diagonal = carried[7 * i] + (i < 3 ? b->mass[0] : jo_same(0.0));
        for (int k = 0; k <= i; k++) {
            const jo_real *y = L + 6 * k;
            jo_real t = k < i ? carried[6 * i + k] : diagonal;
            for (int j = 0; j < k; j++) t -= x[j] * y[j];
            if (k < i) {
                x[k] = t * y[k];
                continue;
            }
            if (jo_spoil(&t, JO_LESS(JO_MIN_PIVOT * diagonal, t))) return isfinite(jo_most(t)) ? JO_SINGULAR_BODY : JO_NOT_FINITE;
            x[i] = 1.0 / jo_sqrt(t);
        }
    }
    return JO_OK;
}

/* constants of a set: weight = 1 / (1 + g h D + (g h)^2 K), I3 weight, Cholesky factor of m E - I3 weight I3^T */
void jo_body_setup(const jo_body *b, jo_body_work *w, int set, double gh)
{
    jo_body_set *s = &w->maximal.set[set];
    int np = b->np;
    for (int j = 0; j < np; j++) s->weight[j] = 1.0 / (1.0 + gh * b->D[j] + gh * gh * b->K[j]);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < np; j++) s->I3w[i * np + j] = b->I3[i * np + j] * s->weight[j];
    jo_real *L = s->L11;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k <= i; k++) {
            jo_real x = i == k ? b->mass[0] : jo_same(0.0);
            for (int j = 0; j < np; j++) x -= s->I3w[i * np + j] * b->I3[k * np + j];
            for (int j = 0; j < k; j++) x -= L[3 * i + j] * L[3 * k + j];
            L[3 * i + k] = i == k ? 1.0 / jo_sqrt(x) : x * L[4 * k];
        }
    if (!b->n) {   /* rigid: constant inertia and factor */
        jo_set3(w->S, b->S0);
        for (int c = 0; c < 6; c++) w->J[c] = b->J0[c];
        w->maximal.status = factor(b, w, set);
    }
}

/* z = L^-1 (f_r - M_rp weight f_p) */
void jo_body_reduce(const jo_body *b, const jo_body_work *w, int set, const jo_real *fr, const jo_real *fp, jo_real *z)
{
    const int np = b->np;
    jo_real t[6] = {0};
    if (b->n) {
        jo_modal3(t, w->maximal.set[set].I3w, fp, np);
        jo_modal3(t + 3, w->maximal.Bw, fp, np);
    }
    for (int i = 0; i < 6; i++) z[i] = fr[i] - t[i];
    jo_body_forward(w->maximal.L, z);
}

/* z of the present forces: L^-T z is the rigid acceleration without joints */
void jo_body_free(const jo_body *b, jo_body_work *w, int set) { jo_body_reduce(b, w, set, w->fr, w->fp, w->maximal.z); }

/* yp = weight (fp - I3^T y_R - B^T y_w) */
static inline void modal(const int np, const jo_real *restrict I3, const jo_real *restrict B, const jo_real *y,
                         const jo_real *restrict weight, const jo_real *restrict fp, jo_real *restrict yp)
{
    const jo_real y0 = y[0], y1 = y[1], y2 = y[2], y3 = y[3], y4 = y[4], y5 = y[5];
    JO_EACH(j, np)
        JO_STORE(yp + j) = JO_LOAD(weight + j)
            * (JO_LOAD(fp + j) - y0 * JO_LOAD(I3 + j) - y1 * JO_LOAD(I3 + np + j) - y2 * JO_LOAD(I3 + 2 * np + j)
               - y3 * JO_LOAD(B + j) - y4 * JO_LOAD(B + np + j) - y5 * JO_LOAD(B + 2 * np + j));
}

/* y_p = weight (f_p - M_pr y) */
void jo_body_modal(const jo_body *b, jo_body_work *w, int set)
{
    modal(b->np, b->I3, w->B, w->y, w->maximal.set[set].weight, w->fp, w->yp);
}
