/* beam_tangent.c - derivatives of the forces of a beam element in Newton's matrix.
 *
 * All quantities are resolved in the middle frame first. With x = [r_b - r_a, beta_a, beta_b] (a step of the difference of the
 * origins of the bodies, and spins of the ends) strains change by B x, generalised forces [n, T_a, T_b] are L B^T s, and
 *   d[n, T_a, T_b] = L B^T C (B + beta E) x + L beta B^T C B x' + (dB^T) s x,  e' changes by E x with the position.
 * Torques are resolved in the frames of the bodies, which rotate. Finally rows and columns are transformed to those of the bodies.
 *
 * A row of an operator has three blocks of three columns, each padded to four for vector registers.
 */
#include "newton/newton.h"
#include "beam/beam.h"

enum { ROW = 12, BLOCK = 4 };   /* reals of a row and of a block in it */

/* Y += s a~ X, three rows each */
static inline void add_cross(jo_real *restrict Y, const jo_real s, const jo_real *a, const jo_real *restrict X)
{
    const jo_real a0 = s * a[0], a1 = s * a[1], a2 = s * a[2];
    JO_EACH(j, ROW) {
        const jo_lanes x0 = JO_LOAD(X + j), x1 = JO_LOAD(X + ROW + j), x2 = JO_LOAD(X + 2 * ROW + j);
        JO_STORE(Y + j) += a1 * x2 - a2 * x1;
        JO_STORE(Y + ROW + j) += a2 * x0 - a0 * x2;
        JO_STORE(Y + 2 * ROW + j) += a0 * x1 - a1 * x0;
    }
}

/* Y += s X, three rows each */
static inline void add(jo_real *restrict Y, const jo_real s, const jo_real *restrict X)
{
    JO_EACH(j, 3 * ROW) JO_STORE(Y + j) += s * JO_LOAD(X + j);
}

static inline void zero(jo_real *Y, const int rows)
{
    for (int j = 0; j < rows * ROW; j++) Y[j] = 0.0;
}

/* block of Y += s a~ */
static inline void add_skew(jo_real *Y, const int block, const jo_real s, const jo_real *a)
{
    jo_real *y = Y + BLOCK * block;
    y[1] -= s * a[2]; y[2] += s * a[1];
    y[ROW] += s * a[2]; y[ROW + 2] -= s * a[0];
    y[2 * ROW] -= s * a[1]; y[2 * ROW + 1] += s * a[0];
}

static inline void add_unit(jo_real *Y, const int block, const jo_real s)
{
    for (int i = 0; i < 3; i++) Y[(ROW + 1) * i + BLOCK * block] += s;
}

/* Y += H X */
static inline void add_h(jo_real *restrict Y, const jo_beam_work *w, const jo_real *restrict X)
{
    jo_real T[3 * ROW];
    zero(T, 3);
    add_cross(T, 1.0, w->tau, X);
    add(Y, 1.0, X);
    add_cross(Y, -w->mu, w->tau, T);
}

/* Y += (d(H x) / d beta_d + s a~) (beta_b - beta_a) */
static void add_h_rate(jo_real *Y, const jo_beam_work *w, const jo_real *x, const jo_real s, const jo_real *a)
{
    const jo_real quarter = 0.25 * (1.0 + w->square), f = quarter * w->mu, g = -2.0 * quarter * w->dmu, tx = jo_dot3(w->tau, x);
    jo_real one[3], two[3], M[9], z[3];
    jo_cross(one, w->tau, x);
    jo_cross(two, w->tau, one);
    for (int i = 0; i < 3; i++) z[i] = f * one[i] + s * a[i];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) M[3 * i + j] = g * two[i] * w->tau[j] + f * (x[i] * w->tau[j] - (i == j ? tx : 0.0));
    M[1] -= z[2]; M[2] += z[1]; M[3] += z[2]; M[5] -= z[0]; M[6] -= z[1]; M[7] += z[0];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            Y[ROW * i + BLOCK + j] -= M[3 * i + j];
            Y[ROW * i + 2 * BLOCK + j] += M[3 * i + j];
        }
}

/* S (6 rows) += s C B */
static inline void add_product(jo_real *restrict S, const jo_real s, const jo_real *restrict C, const jo_real *restrict B)
{
    for (int i = 0; i < 6; i++) {
        const jo_real c0 = s * C[6 * i], c1 = s * C[6 * i + 1], c2 = s * C[6 * i + 2], c3 = s * C[6 * i + 3],
                      c4 = s * C[6 * i + 4], c5 = s * C[6 * i + 5];
        JO_EACH(j, ROW)
            JO_STORE(S + ROW * i + j) += c0 * JO_LOAD(B + j) + c1 * JO_LOAD(B + ROW + j) + c2 * JO_LOAD(B + 2 * ROW + j)
                                         + c3 * JO_LOAD(B + 3 * ROW + j) + c4 * JO_LOAD(B + 4 * ROW + j)
                                         + c5 * JO_LOAD(B + 5 * ROW + j);
    }
}

/* Spins as operators on x: of the middle frame, and of the ends relative to it. */
typedef struct { jo_real middle[3 * ROW], end[2][3 * ROW]; } spins;

static void spins_of(spins *p, const jo_beam_work *w)
{
    zero(p->middle, 3);
    for (int k = 0; k < 2; k++) {
        add_unit(p->middle, 1 + k, 0.5);
        add_skew(p->middle, 1 + k, k ? -0.5 : 0.5, w->tau);
    }
    for (int k = 0; k < 2; k++) {
        zero(p->end[k], 3);
        add(p->end[k], -1.0, p->middle);
        add_unit(p->end[k], 1 + k, 1.0);
    }
}

/* B: derivative of the strains */
static void strain_operator(jo_real *B, const jo_beam_work *w, const spins *p, const jo_real L)
{
    const jo_real mu = w->mu / L, *tau = w->tau, diagonal = 1.0 / L + mu * w->square;
    zero(B, 6);
    add_unit(B, 0, 1.0 / L);
    add_cross(B, 1.0, w->d, p->middle);
    if (w->offset)
        for (int k = 0; k < 2; k++) add_skew(B, 1 + k, (k ? -1.0 : 1.0) / L, w->U[k]);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {   /* H / L */
            const jo_real h = (i == j ? diagonal : 0.0) - mu * tau[i] * tau[j];
            B[ROW * (3 + i) + BLOCK + j] = -h;
            B[ROW * (3 + i) + 2 * BLOCK + j] = h;
        }
}

/* E: derivative of the rates of the strains with respect to positions */
static void rate_operator(jo_real *E, const jo_real *B, const jo_beam_work *w, const spins *p, const jo_real L)
{
    jo_real O[2][3 * ROW], om[3 * ROW], difference[3 * ROW], x[3], t[3];
    for (int j = 0; j < 3; j++) x[j] = w->om[1][j] - w->om[0][j];
    for (int k = 0; k < 2; k++) {   /* derivatives of the angular velocities of the ends and of the middle */
        zero(O[k], 3);
        add_cross(O[k], -1.0, w->om[k], p->end[k]);
    }
    JO_EACH(j, 3 * ROW) {
        JO_STORE(om + j) = 0.5 * (JO_LOAD(O[0] + j) + JO_LOAD(O[1] + j));
        JO_STORE(difference + j) = JO_LOAD(O[1] + j) - JO_LOAD(O[0] + j);
    }
    add_cross(om, -0.5, w->tau, difference);
    add_skew(om, 1, -0.125 * (1.0 + w->square), x);
    add_skew(om, 2, 0.125 * (1.0 + w->square), x);
    zero(E, 6);
    add_cross(E, 1.0 / L, w->dv, p->middle);
    add_cross(E, -1.0, w->om_m, B);
    add_cross(E, 1.0, w->d, om);
    if (w->offset)
        for (int k = 0; k < 2; k++) {
            jo_cross(t, w->om[k], w->U[k]);
            add_skew(E, 1 + k, (k ? -1.0 : 1.0) / L, t);
        }
    add_h_rate(E + 3 * ROW, w, x, 0.0, x);
    add_h(E + 3 * ROW, w, difference);
    for (int j = 3 * ROW; j < 6 * ROW; j++) E[j] /= L;
}

/* K (9 rows) = L B^T S; if B is given, plus (dB^T) s, the geometric stiffness */
static void moments(jo_real *K, const jo_beam_work *w, const spins *p, const jo_real L, const jo_real *S, const jo_real *B)
{
    jo_real t[3 * ROW], h[3 * ROW];
    zero(t, 3);
    zero(h, 3);
    add_cross(t, -L, w->d, S);
    if (B) {
        add_cross(t, L, w->f, B);
        add_h_rate(h, w, w->f + 3, -0.125 * (1.0 + w->square), w->t);
    }
    add_h(h, w, S + 3 * ROW);
    add_cross(h, 0.5, w->tau, t);
    JO_EACH(j, 3 * ROW) {
        const jo_lanes half = 0.5 * JO_LOAD(t + j), other = JO_LOAD(h + j);
        JO_STORE(K + j) = JO_LOAD(S + j);
        JO_STORE(K + 3 * ROW + j) = half - other;
        JO_STORE(K + 6 * ROW + j) = half + other;
    }
    if (w->offset)
        for (int k = 0; k < 2; k++) add_cross(K + 3 * ROW * (1 + k), k ? 1.0 : -1.0, w->U[k], S);
    if (!B) return;
    add_cross(K, -1.0, w->f, p->middle);
    for (int k = 0; k < 2; k++) {
        add_cross(K + 3 * ROW * (1 + k), 1.0, w->M[k], p->end[k]);
        if (!w->offset) continue;
        zero(t, 3);
        add_cross(t, 1.0, w->f, p->end[k]);
        add_cross(K + 3 * ROW * (1 + k), k ? 1.0 : -1.0, w->U[k], t);
    }
}

/* X += K times a matrix (3 x BLOCK) for each block of columns */
static inline void add_right(jo_real *restrict X, const jo_real *restrict K, jo_real right[3][3 * BLOCK])
{
    for (int r = 0; r < 9; r++)
        for (int j = 0; j < 3; j++) {
            const jo_real *k = K + ROW * r + BLOCK * j, *R = right[j];
            jo_real *x = X + ROW * r + BLOCK * j;
            JO_EACH(l, BLOCK)
                JO_STORE(x + l) += k[0] * JO_LOAD(R + l) + k[1] * JO_LOAD(R + BLOCK + l) + k[2] * JO_LOAD(R + 2 * BLOCK + l);
        }
}

/* Y = rows of X in the axes of the forces (world) and torques (bodies) */
static inline void turn_left(jo_real *restrict Y, const jo_beam_work *w, const jo_real *restrict X)
{
    for (int i = 0; i < 3; i++) {
        const jo_real *A = i ? w->G[i - 1] : w->Q, *x = X + 3 * ROW * i;
        for (int r = 0; r < 3; r++)
            JO_EACH(j, ROW)
                JO_STORE(Y + ROW * (3 * i + r) + j) = A[3 * r] * JO_LOAD(x + j) + A[3 * r + 1] * JO_LOAD(x + ROW + j)
                                                      + A[3 * r + 2] * JO_LOAD(x + 2 * ROW + j);
    }
}

/* R = s A^T turn: from increments of the bodies to the middle frame; turn NULL stands for E */
static inline void columns_of(jo_real *R, const jo_real *A, const jo_real s, const jo_real *turn)
{
    for (int i = 0; i < 3; i++) {
        R[BLOCK * i + 3] = 0.0;
        for (int j = 0; j < 3; j++)
            R[BLOCK * i + j] = s * (turn ? A[i] * turn[j] + A[3 + i] * turn[3 + j] + A[6 + i] * turn[6 + j] : A[3 * j + i]);
    }
}

/* Y into the blocks of the two bodies: n on b, -n on a */
static void scatter(const jo_model *m, jo_data *d, const jo_beam *b, const jo_real *Y)
{
    const int body[2] = {b->a, b->b};
    for (int r = 0; r < 2; r++)
        for (int s = 0; s < 2; s++) {
            const jo_block N = jo_newton_find(m, d, body[r], body[s]);
            const double sign = r == s ? 1.0 : -1.0, row = r ? 1.0 : -1.0, column = s ? 1.0 : -1.0;
            const jo_real *torque = Y + 3 * ROW * (1 + r);
            for (int i = 0; i < 3; i++) {
                jo_real *at = N.at + i * N.stride, *below = at + 3 * N.stride;
                const jo_real *y = Y + ROW * i, *t = torque + ROW * i;
                for (int j = 0; j < 3; j++) {
                    at[j] += sign * y[j];
                    at[3 + j] += row * y[BLOCK * (1 + s) + j];
                    below[j] += column * t[j];
                    below[3 + j] += t[BLOCK * (1 + s) + j];
                }
            }
        }
}

/* lag += K x + D z with the stored K and D */
void jo_beam_lag(const jo_model *m, const jo_data *d, const jo_real *x, const jo_real *z, jo_real *lag)
{
    for (int i = 0; i < m->nbeam; i++) {
        const int a = m->body[m->beam[i].a].iv, b = m->body[m->beam[i].b].iv;
        for (int v = 0; v < (z && d->beams.work[i].damped ? 2 : 1); v++) {
            const jo_real *in = v ? z : x, *kept = d->beams.stiff + JO_BEAM_KEPT * i + 9 * ROW * v;
            jo_real y[ROW] = {0.0}, out[9];
            for (int j = 0; j < 3; j++) {
                y[j] = in[b + j] - in[a + j];
                y[BLOCK + j] = in[a + 3 + j];
                y[2 * BLOCK + j] = in[b + 3 + j];
            }
            for (int r = 0; r < 9; r++) {
                jo_lanes sum = {0};
                JO_EACH(j, ROW) sum += JO_LOAD(kept + ROW * r + j) * JO_LOAD(y + j);
                out[r] = jo_sum(sum);
            }
            for (int j = 0; j < 3; j++) {
                lag[a + j] -= out[j];
                lag[b + j] += out[j];
                lag[a + 3 + j] += out[3 + j];
                lag[b + 3 + j] += out[6 + j];
            }
        }
    }
}

/* Newton's matrix of one element: S = C B (+ damping), K = L B^T S + (dB^T) s, columns and rows of the bodies */
static void elastic(const jo_model *m, jo_data *d, const jo_stage *stage, const int i)
{
    const jo_beam *b = &m->beam[i];
    const jo_beam_work *w = &d->beams.work[i];
    const jo_weights *c = &stage->weights;
    const jo_real L = b->data->length, beta = b->data->beta, *C = b->data->C;
    jo_real fibrous[36], effective[36], changing[36] = {0.0}, right[3][3 * BLOCK];
    jo_real B[6 * ROW], S[6 * ROW], K[9 * ROW], V[9 * ROW], X[9 * ROW], Y[9 * ROW];
    spins p;
    spins_of(&p, w);
    strain_operator(B, w, &p, L);
    if (w->fibrous) {
        jo_beam_fibre_tangent(m, d, i, fibrous, changing);
        C = fibrous;
    }
    if (w->helical) {
        jo_beam_helix_tangent(m, d, i, C, effective, changing);
        C = effective;
    }
    zero(S, 6);
    add_product(S, 1.0, C, B);
    if (w->damped) {
        jo_real E[6 * ROW], Z[6 * ROW];
        for (int j = 0; j < 6 * ROW; j++) Z[j] = beta * S[j];
        moments(V, w, &p, L, Z, 0);
        rate_operator(E, B, w, &p, L);
        add_product(S, beta, C, E);
    }
    if (w->helical || w->fibrous) add_product(S, 1.0, changing, B);
    moments(K, w, &p, L, S, B);
    if (stage->set) {   /* a Rosenbrock method: K and D are stored without weights, for [r_b - r_a, rotations of a and b] */
        for (int v = 0; v < (w->damped ? 2 : 1) && !stage->earlier; v++) {
            zero(X, 9);
            for (int j = 0; j < 3; j++) columns_of(right[j], j ? w->G[j - 1] : w->Q, 1.0, 0);
            add_right(X, v ? V : K, right);
            turn_left(d->beams.stiff + JO_BEAM_KEPT * i + 9 * ROW * v, w, X);
        }
        const jo_real *kept = d->beams.stiff + JO_BEAM_KEPT * i;
        for (int j = 0; j < 9 * ROW; j++) Y[j] = c->q * kept[j] + (w->damped ? c->v * kept[9 * ROW + j] : 0.0);
    } else {
        zero(X, 9);
        for (int j = 0; j < 3; j++) columns_of(right[j], j ? w->G[j - 1] : w->Q, c->q, j ? d->body[j > 1 ? b->b : b->a].turn : 0);
        add_right(X, K, right);
        if (w->damped) {
            for (int j = 0; j < 3; j++) columns_of(right[j], j ? w->G[j - 1] : w->Q, c->v, 0);
            add_right(X, V, right);
        }
        turn_left(Y, w, X);
    }
    scatter(m, d, b, Y);
}

void jo_newton_beams(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    const jo_weights *c = &stage->weights;
    jo_weights inertia = *c;
    if (stage->set) inertia.v = 0.0;   /* a Rosenbrock method: mass-proportional damping is explicit */
    for (int i = 0; i < m->nbeam; i++) {
        if (jo_beam_inertial(&m->beam[i])) jo_beam_newton_inertia(m, d, i, &inertia);
        if (c->q != 0.0 || c->v != 0.0) elastic(m, d, stage, i);
    }
}
