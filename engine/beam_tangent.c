/* beam_tangent.c - Newton's matrix: the beam element, differentiated.
 *
 * Everything is resolved in the middle frame first. With x = [r_b - r_a, beta_a, beta_b] (a step of the difference of the
 * origins of the bodies, and spins of the ends) strains change by B x, generalised forces [n, T_a, T_b] are L B^T s, and
 *   d[n, T_a, T_b] = L B^T C (B + beta E) x + L beta B^T C B x' + (dB^T) s x,  e' changes by E x with the position.
 * Torques stay with their bodies when these turn. Then rows and columns are turned into those of the bodies.
 */
#include "beam.h"

static void skew(jo_real *M, const jo_real *x)
{
    M[0] = M[4] = M[8] = 0.0;
    M[1] = -x[2]; M[2] = x[1]; M[3] = x[2]; M[5] = -x[0]; M[6] = -x[1]; M[7] = x[0];
}

/* M += s a~ */
static void add_skew(jo_real *M, jo_real s, const jo_real *a)
{
    M[1] -= s * a[2]; M[2] += s * a[1];
    M[3] += s * a[2]; M[5] -= s * a[0];
    M[6] -= s * a[1]; M[7] += s * a[0];
}

/* M += s a~ b~ = s (b a^T - (a . b) E) */
static void add_skew_skew(jo_real *M, jo_real s, const jo_real *a, const jo_real *b)
{
    const jo_real ab = jo_dot3(a, b);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) M[3 * i + j] += s * b[i] * a[j];
        M[4 * i] -= s * ab;
    }
}

static void add(jo_real *restrict M, jo_real s, const jo_real *restrict X)
{
    for (int i = 0; i < 9; i++) M[i] += s * X[i];
}

/* M += s A B */
static void add_product(jo_real *restrict M, const jo_real s, const jo_real *restrict A, const jo_real *restrict B)
{
    for (int i = 0; i < 3; i++) {
        const jo_real a = s * A[3 * i], b = s * A[3 * i + 1], c = s * A[3 * i + 2];
        for (int j = 0; j < 3; j++) M[3 * i + j] += a * B[j] + b * B[3 + j] + c * B[6 + j];
    }
}

/* M += s A^T B */
static void add_transposed(jo_real *restrict M, const jo_real s, const jo_real *restrict A, const jo_real *restrict B)
{
    for (int i = 0; i < 3; i++) {
        const jo_real a = s * A[i], b = s * A[3 + i], c = s * A[6 + i];
        for (int j = 0; j < 3; j++) M[3 * i + j] += a * B[j] + b * B[3 + j] + c * B[6 + j];
    }
}

/* M = d(H x) / d beta_d */
static void h_rate(jo_real *M, const jo_beam_work *w, const jo_real *x)
{
    const jo_real quarter = 0.25 * (1.0 + w->square);
    jo_real one[3], two[3];
    jo_cross(one, w->tau, x);
    jo_cross(two, w->tau, one);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) M[3 * i + j] = -2.0 * quarter * w->dmu * two[i] * w->tau[j];
    add_skew(M, quarter * w->mu, one);
    add_skew_skew(M, quarter * w->mu, w->tau, x);
}

/* what the spins of the ends make of that of the middle frame: beta_m = M_a beta_a + M_b beta_b, M_a = M_b^T */
typedef struct { jo_real M[2][9], H[9]; } spins;

static void spins_of(spins *p, const jo_beam_work *w)
{
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < 9; i++) p->M[k][i] = i % 4 ? 0.0 : 0.5;
        add_skew(p->M[k], k ? -0.5 : 0.5, w->tau);
    }
    for (int i = 0; i < 9; i++) p->H[i] = i % 4 == 0;
    add_skew_skew(p->H, -w->mu, w->tau, w->tau);
}

/* how the strains change: G rows of Gamma for the columns [r_b - r_a, beta_a, beta_b], H / L rows of kappa */
static void strain_operator(jo_real G[3][9], const jo_beam_work *w, const spins *p, const jo_real L)
{
    jo_real d[9];
    skew(d, w->d);
    for (int i = 0; i < 9; i++) G[0][i] = i % 4 ? 0.0 : 1.0 / L;
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < 9; i++) G[1 + k][i] = 0.0;
        add_product(G[1 + k], 1.0, d, p->M[k]);
        if (w->offset) add_skew(G[1 + k], (k ? -1.0 : 1.0) / L, w->U[k]);
    }
}

/* S_n, S_m = C [G, H / L]: how the resultants change */
static void resultants(jo_real Sn[3][9], jo_real Sm[3][9], const jo_real *C, jo_real G[3][9], const jo_real *kb)
{
    jo_real block[4][9];
    for (int i = 0; i < 9; i++)
        for (int k = 0; k < 4; k++) block[k][i] = C[6 * (3 * (k / 2) + i / 3) + 3 * (k % 2) + i % 3];
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < 9; i++) Sn[c][i] = Sm[c][i] = 0.0;
        add_product(Sn[c], 1.0, block[0], G[c]);
        add_product(Sm[c], 1.0, block[2], G[c]);
        if (c == 0) continue;
        add_product(Sn[c], c == 1 ? -1.0 : 1.0, block[1], kb);
        add_product(Sm[c], c == 1 ? -1.0 : 1.0, block[3], kb);
    }
}

/* K[r][c] += factor L B^T S */
static void material(jo_real K[3][3][9], const jo_real factor, jo_real G[3][9], const spins *p, const jo_real L,
                     jo_real Sn[3][9], jo_real Sm[3][9])
{
    for (int c = 0; c < 3; c++) {
        add(K[0][c], factor, Sn[c]);
        for (int k = 0; k < 2; k++) {
            add_transposed(K[1 + k][c], factor * L, G[1 + k], Sn[c]);
            add_product(K[1 + k][c], k ? factor : -factor, p->H, Sm[c]);
        }
    }
}

/* K[r][c] += (dB^T) s with torques that stay with their bodies */
static void geometric(jo_real K[3][3][9], jo_real G[3][9], const jo_beam_work *w, const spins *p, const jo_real L)
{
    jo_real n[9], X[9], Y[9];
    skew(n, w->f);
    for (int c = 0; c < 2; c++) add_product(K[0][1 + c], -1.0, n, p->M[c]);
    h_rate(Y, w, w->f + 3);
    add_skew(Y, -0.125 * (1.0 + w->square), w->t);
    for (int k = 0; k < 2; k++) {
        const double sign = k ? 1.0 : -1.0;
        jo_real Z[9] = {0.0};
        add_skew(Z, 1.0, w->M[k]);
        if (w->offset) add_skew_skew(Z, sign, w->U[k], w->f);
        for (int i = 0; i < 9; i++) X[i] = 0.0;
        add_transposed(X, L, p->M[k], n);
        for (int c = 0; c < 3; c++) add_product(K[1 + k][c], 1.0, X, G[c]);
        for (int i = 0; i < 9; i++) X[i] = sign * Y[i];
        add_product(X, sign, Z, p->M[1 - k]);   /* beta_b - beta_m = M_a beta_d, beta_a - beta_m = -M_b beta_d */
        add(K[1 + k][1], -1.0, X);
        add(K[1 + k][2], 1.0, X);
    }
}

/* E: how the rates of the strains change with the position; their rows of kappa' in F beta_d */
static void rate_operator(jo_real E[3][9], jo_real *F, jo_real G[3][9], const jo_beam_work *w, const spins *p, const jo_real L)
{
    jo_real d[9], om[3][9], dv[9], W[9] = {0.0}, X[9] = {0.0}, x[3], t[3];
    skew(d, w->d);
    for (int k = 0; k < 2; k++) skew(om[k], w->om[k]);
    skew(om[2], w->om_m);
    skew(dv, w->dv);
    for (int j = 0; j < 3; j++) x[j] = w->om[1][j] - w->om[0][j];
    /* d om_m = W beta_d, d(om_b - om_a) = X beta_d */
    add_product(X, -1.0, om[1], p->M[0]);
    add_product(X, -1.0, om[0], p->M[1]);
    jo_real P[9] = {0.0};
    add_product(P, 1.0, om[0], p->M[1]);
    add_product(W, 1.0, p->M[0], P);
    for (int i = 0; i < 9; i++) P[i] = 0.0;
    add_product(P, 1.0, om[1], p->M[0]);
    add_product(W, -1.0, p->M[1], P);
    add_skew(W, 0.125 * (1.0 + w->square), x);
    for (int i = 0; i < 9; i++) P[i] = 0.0;
    add_product(P, 1.0, d, W);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < 9; i++) E[c][i] = 0.0;
        add_product(E[c], -1.0, om[2], G[c]);
        if (c == 0) continue;
        const int k = c - 1;
        const double sign = k ? 1.0 : -1.0;
        add(E[c], sign, P);
        add_product(E[c], 1.0 / L, dv, p->M[k]);
        if (!w->offset) continue;
        jo_cross(t, w->om[k], w->U[k]);
        add_skew(E[c], -sign / L, t);
    }
    h_rate(F, w, x);
    add_product(F, 1.0, p->H, X);
    for (int i = 0; i < 9; i++) F[i] /= L;
}

static void add_block(jo_block N, int row, int column, jo_real s, const jo_real *M)
{
    jo_real *at = N.at + row * N.stride + column;
    for (int i = 0; i < 3; i++, at += N.stride)
        for (int j = 0; j < 3; j++) at[j] += s * M[3 * i + j];
}

/* blocks of the two bodies */
static void scatter(const jo_model *m, jo_data *d, const jo_beam *b, jo_real K[3][3][9], jo_real V[3][3][9])
{
    const jo_beam_work *w = &d->beam[b - m->beam];
    const jo_weights *c = &d->weights;
    const int body[2] = {b->a, b->b};
    jo_block N[2][2];
    jo_real right[3][2][9];   /* of the columns: with the position, with the velocity */
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++) N[i][j] = jo_newton_find(m, d, body[i], body[j]);
    for (int i = 0; i < 9; i++) {
        right[0][0][i] = c->q * w->Q[3 * (i % 3) + i / 3];
        right[0][1][i] = c->v * w->Q[3 * (i % 3) + i / 3];
    }
    for (int k = 0; k < 2; k++) {
        jo_real *r = right[1 + k][0];
        for (int i = 0; i < 9; i++) {
            r[i] = 0.0;
            right[1 + k][1][i] = c->v * w->G[k][3 * (i % 3) + i / 3];
        }
        add_transposed(r, c->q, w->G[k], d->body[body[k]].turn);
    }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            jo_real X[9] = {0.0}, Y[9] = {0.0};
            add_product(X, 1.0, K[i][j], right[j][0]);
            if (w->damped) add_product(X, 1.0, V[i][j], right[j][1]);
            add_product(Y, 1.0, i ? w->G[i - 1] : w->Q, X);
            for (int r = i ? i - 1 : 0; r < (i ? i : 2); r++)   /* n pulls b, and a back */
                for (int s = j ? j - 1 : 0; s < (j ? j : 2); s++)
                    add_block(N[r][s], i ? 3 : 0, j ? 3 : 0, (i || r ? 1.0 : -1.0) * (j || s ? 1.0 : -1.0), Y);
        }
}

/* the same with both kept: for [r_b - r_a, turn of a, turn of b] of the bodies, without weights */
static void keep(const jo_model *m, jo_data *d, const jo_beam *b, jo_real K[3][3][9], jo_real V[3][3][9])
{
    const jo_beam_work *w = &d->beam[b - m->beam];
    jo_real *kept = d->stiff + 162 * (b - m->beam);
    const jo_weights *c = &d->weights;
    const int body[2] = {b->a, b->b};
    jo_block N[2][2];
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++) N[i][j] = jo_newton_find(m, d, body[i], body[j]);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++, kept += 9) {
            jo_real X[9] = {0.0}, Y[9];
            const jo_real *left = i ? w->G[i - 1] : w->Q, *right = j ? w->G[j - 1] : w->Q;
            for (int v = 0; v < 2; v++) {
                jo_real t[9], *out = kept + 81 * v;
                if (v && !w->damped) break;
                jo_mul33(t, left, v ? V[i][j] : K[i][j]);
                for (int r = 0; r < 3; r++)
                    for (int s = 0; s < 3; s++) out[3 * r + s] = jo_dot3(t + 3 * r, right + 3 * s);
                for (int k = 0; k < 9; k++) X[k] += (v ? c->v : c->q) * out[k];
            }
            for (int k = 0; k < 9; k++) Y[k] = -X[k];
            for (int r = i ? i - 1 : 0; r < (i ? i : 2); r++)
                for (int s = j ? j - 1 : 0; s < (j ? j : 2); s++)
                    add_block(N[r][s], i ? 3 : 0, j ? 3 : 0, 1.0, (i || r) == (j || s) ? X : Y);
        }
}

/* d->lag += K x + D z with what was kept */
void jo_beam_lag(const jo_model *m, jo_data *d, const jo_real *x, const jo_real *z)
{
    for (int i = 0; i < m->nbeam; i++) {
        const jo_real *kept = d->stiff + 162 * i;
        const int a = m->body[m->beam[i].a].iv, b = m->body[m->beam[i].b].iv;
        for (int v = 0; v < (z && d->beam[i].damped ? 2 : 1); v++) {
            const jo_real *in = v ? z : x;
            jo_real y[9], out[9] = {0.0};
            for (int j = 0; j < 3; j++) { y[j] = in[b + j] - in[a + j]; y[3 + j] = in[a + 3 + j]; y[6 + j] = in[b + 3 + j]; }
            for (int r = 0; r < 3; r++)
                for (int s = 0; s < 3; s++) {
                    const jo_real *B = kept + 81 * v + 9 * (3 * r + s);
                    for (int j = 0; j < 3; j++) out[3 * r + j] += jo_dot3(B + 3 * j, y + 3 * s);
                }
            for (int j = 0; j < 3; j++) {
                d->lag[a + j] -= out[j];
                d->lag[b + j] += out[j];
                d->lag[a + 3 + j] += out[3 + j];
                d->lag[b + 3 + j] += out[6 + j];
            }
        }
    }
}

static void elastic(const jo_model *m, jo_data *d, const int i)
{
    const jo_beam *b = &m->beam[i];
    const jo_beam_work *w = &d->beam[i];
    const jo_real L = b->data[0], beta = b->data[JO_BEAM_BETA], *C = b->data + JO_BEAM_C;
    jo_real effective[36], changing[36];
    jo_real G[3][9], kb[9], Sn[3][9], Sm[3][9], K[3][3][9], V[3][3][9];
    spins p;
    for (int k = 0; k < 81; k++) K[k / 27][k / 9 % 3][k % 9] = 0.0;
    spins_of(&p, w);
    strain_operator(G, w, &p, L);
    for (int k = 0; k < 9; k++) kb[k] = p.H[k] / L;
    if (w->helical) {
        jo_beam_helix_tangent(m, d, i, effective, changing);
        C = effective;
    }
    resultants(Sn, Sm, C, G, kb);
    material(K, 1.0, G, &p, L, Sn, Sm);
    if (w->damped) {
        jo_real E[3][9], F[9];
        for (int k = 0; k < 81; k++) V[k / 27][k / 9 % 3][k % 9] = beta * K[k / 27][k / 9 % 3][k % 9];
        rate_operator(E, F, G, w, &p, L);
        resultants(Sn, Sm, C, E, F);
        material(K, beta, G, &p, L, Sn, Sm);
    }
    if (w->helical) {
        resultants(Sn, Sm, changing, G, kb);
        material(K, 1.0, G, &p, L, Sn, Sm);
    }
    geometric(K, G, w, &p, L);
    if (d->keeping) keep(m, d, b, K, V);
    else scatter(m, d, b, K, V);
}

void jo_newton_beams(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nbeam; i++) {
        if (jo_beam_inertial(&m->beam[i])) {
            const double v = d->weights.v;
            if (d->keeping) d->weights.v = 0.0;   /* ROS2: damping of the mass is not stiff */
            jo_beam_newton_inertia(m, d, i);
            d->weights.v = v;
        }
        if (d->weights.q != 0.0 || d->weights.v != 0.0) elastic(m, d, i);
    }
}
