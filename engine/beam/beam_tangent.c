/* beam_tangent.c - beam elements in Newton's matrix: from the middle frames of the elements to the coordinates of the bodies. */
#include "newton/newton.h"
#include "beam/beam.h"
#include "beam/beam_lanes.h"

/* columns of an operator, from increments of the bodies to the middle frame: [Q^T, G_a^T, G_b^T] s, with rotations times their `turn` */
static void columns(const jo_data *d, const jo_beam_group *w, const jo_lanes s, const int turned, jo_lanes R[3][JO_BEAM_BLOCK])
{
    for (int k = 0; k < 3; k++) {
        const jo_lanes *A = k ? w->G[k - 1] : w->Q;
        jo_lanes At[JO_BEAM_BLOCK], turn[JO_BEAM_BLOCK];
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) At[3 * i + j] = s * A[3 * j + i];
        if (!k || !turned) {
            jo_lanes_copy(R[k], At, JO_BEAM_BLOCK);
            continue;
        }
        for (int part = 0; part < 3; part++) {   /* entries 0 to 3, 4 to 7, 5 to 8 */
            const jo_real *at[JO_WIDTH];
            const int first = part == 2 ? 5 : 4 * part;
            JO_EACH_PLACE(l) at[l] = d->body[w->body[k - 1][l]].turn + first;
            jo_lanes_gather(turn + first, at);
        }
        jo_lanes_product(R[k], At, turn);
    }
}

/* Y = [Q, G_a, G_b] (K R + V P); V NULL: none */
static void rotate(const jo_beam_group *w, jo_lanes *Y, const jo_lanes *K, jo_lanes R[3][JO_BEAM_BLOCK], const jo_lanes *V, jo_lanes P[3][JO_BEAM_BLOCK])
{
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            const int at = JO_BEAM_BLOCK * (3 * r + c);
            jo_lanes X[JO_BEAM_BLOCK];
            jo_lanes_product(X, K + at, R[c]);
            if (V) jo_lanes_add_product(X, V + at, P[c]);
            jo_lanes_product(Y + at, r ? w->G[r - 1] : w->Q, X);
        }
}

/* Y into the blocks of the two bodies: n on b, -n on a */
static void scatter(const jo_beam_group *w, const jo_lanes *Y)
{
    for (int r = 0; r < 2; r++)
        for (int s = 0; s < 2; s++) {
            const double sign = r == s ? 1.0 : -1.0, row = r ? 1.0 : -1.0, column = s ? 1.0 : -1.0;
            const jo_lanes *n = Y, *nt = Y + JO_BEAM_BLOCK * (1 + s), *t = Y + JO_BEAM_BLOCK * 3 * (1 + r), *tt = t + JO_BEAM_BLOCK * (1 + s);
            jo_real *at[JO_WIDTH];
            JO_EACH_PLACE(l) at[l] = w->newton[r][s][l].at;
            for (int i = 0; i < 6; i++) {
                const int of = 3 * (i % 3);
                jo_lanes left[3], right[3];
                for (int j = 0; j < 3; j++) {
                    left[j] = i < 3 ? sign * n[of + j] : column * t[of + j];
                    right[j] = i < 3 ? row * nt[of + j] : 1.0 * tt[of + j];
                }
                jo_lanes_scatter_six(at, w->count, left, right);
                JO_EACH_PLACE(l) at[l] += w->newton[r][s][l].stride;
            }
        }
}

/* stiffness and damping of a Rosenbrock method, stored without weights in the first stage, for [r_b - r_a, rotations of a and b] */
static jo_lanes *stored(const jo_data *d, int group) { return d->beams.stiff + 2 * JO_BEAM_KEPT * group; }

/* Newton's matrix of the elements of one group */
static void elastic(jo_data *d, const jo_stage *stage, const int i)
{
    const jo_beam_group *w = &d->beams.group[i];
    const jo_weights *c = &stage->weights;
    const int damped = w->kind & JO_BEAM_DAMPED;
    jo_lanes K[JO_BEAM_KEPT], V[JO_BEAM_KEPT], Y[JO_BEAM_KEPT], R[3][JO_BEAM_BLOCK], P[3][JO_BEAM_BLOCK];
    if (!stage->set) {
        jo_beam_stiffness(w, K, V);
        columns(d, w, jo_lanes_of(c->q), 1, R);
        if (damped) columns(d, w, jo_lanes_of(c->v), 0, P);
        rotate(w, Y, K, R, damped ? V : 0, P);
    } else {
        jo_lanes *kept = stored(d, i), *loss = kept + JO_BEAM_KEPT;
        if (!stage->earlier) {
            jo_beam_stiffness(w, K, V);
            columns(d, w, jo_lanes_of(1.0), 0, R);
            rotate(w, kept, K, R, 0, P);
            if (damped) rotate(w, loss, V, R, 0, P);
        }
        for (int j = 0; j < JO_BEAM_KEPT; j++) Y[j] = damped ? c->q * kept[j] + c->v * loss[j] : c->q * kept[j];
    }
    scatter(w, Y);
}

/* lag += [n, T_a, T_b] of the group, n on b, -n on a */
static void add_lag(const jo_beam_group *w, const jo_lanes *f, jo_real *lag)
{
    for (int k = 0; k < 2; k++) {
        jo_lanes F[3];
        jo_real *at[JO_WIDTH];
        for (int j = 0; j < 3; j++) F[j] = (k ? 1.0 : -1.0) * f[j];
        JO_EACH_PLACE(l) at[l] = lag + w->iv[k][l];
        jo_lanes_scatter_six(at, w->count, F, f + 3 * (1 + k));
    }
}

/* lag += K x + D z with the stored K and D */
void jo_beam_lag(const jo_data *d, const jo_real *x, const jo_real *z, jo_real *lag)
{
    for (int i = 0; i < d->beams.groups; i++) {
        const jo_beam_group *w = &d->beams.group[i];
        for (int v = 0; v < (z && w->kind & JO_BEAM_DAMPED ? 2 : 1); v++) {
            const jo_real *in = v ? z : x;
            const jo_lanes *kept = stored(d, i) + JO_BEAM_KEPT * v;
            jo_lanes move[2][4], turn[2][4], y[9], f[9];
            for (int k = 0; k < 2; k++) {
                const jo_real *at[JO_WIDTH], *rest[JO_WIDTH];
                JO_EACH_PLACE(l) {
                    at[l] = in + w->iv[k][l];
                    rest[l] = at[l] + 2;
                }
                jo_lanes_gather(move[k], at);
                jo_lanes_gather(turn[k], rest);
            }
            for (int j = 0; j < 3; j++) {
                y[j] = move[1][j] - move[0][j];
                y[3 + j] = turn[0][1 + j];
                y[6 + j] = turn[1][1 + j];
            }
            for (int r = 0; r < 9; r++) {
                f[r] = jo_lanes_of(0.0);
                for (int c = 0; c < 9; c++) f[r] += kept[JO_BEAM_BLOCK * (3 * (r / 3) + c / 3) + 3 * (r % 3) + c % 3] * y[c];
            }
            add_lag(w, f, lag);
        }
    }
}

void jo_newton_beams(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    const jo_weights *c = &stage->weights;
    jo_weights inertia = *c;
    if (stage->set) inertia.v = 0.0;   /* a Rosenbrock method: mass-proportional damping is explicit */
    for (int i = 0; i < m->nbeam; i++)
        if (jo_beam_inertial(&m->beam[i])) jo_beam_newton_inertia(m, d, i, &inertia);
    if (c->q == 0.0 && c->v == 0.0) return;
    for (int i = 0; i < d->beams.groups; i++) elastic(d, stage, i);
}
