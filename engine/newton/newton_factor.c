/* newton_factor.c - sparse block LU of Newton's matrix [M^ Cq^T; Cq 0] of the implicit methods.
 *
 * Elimination order and fill-in are constants of the model. A node is a body with the joints to its parent, which makes its pivot block
 * regular; rows are exchanged within a node only. After the factorisation a diagonal block contains its LU factors (of six unknowns:
 * its inverse), the block to its right A_cc^-1 A_cj, the block below it A_ic; all by columns between nodes of six unknowns.
 */
#include "valid.h"
#include "newton/newton.h"
#include "friction/friction.h"

#define JO_SCHUR_REGULARISATION 1e-8    /* share of the scale of a joint row that is subtracted from its diagonal if rows are redundant */
/* pivot relative to (unit of its row x unit of its column) below which the row depends on other rows */
#define JO_DEPENDENT_PIVOT 1e-14

/* y -= s x, padded length */
static inline void subtract_row(jo_real *restrict y, const jo_real s, const jo_real *restrict x, const int padded)
{
    JO_EACH(j, padded) JO_STORE(y + j) -= s * JO_LOAD(x + j);
}

static void swap_rows(jo_real *x, jo_real *y, int count)
{
    for (int j = 0; j < count; j++) {
        const jo_real t = x[j];
        x[j] = y[j];
        y[j] = t;
    }
}

static void swap(double *x, double *y)
{
    const double t = *x;
    *x = *y;
    *y = t;
}

/* LU factors with partial pivoting and the inverse of the diagonal. Unit of A_ij: row[i] column[j]. Returns the row whose pivot is below
 * `vanished` units, or -1 */
static inline int factor_dense(jo_real *restrict A, const int n, const int stride, int *pivot, const double *column, double *row,
                               const double vanished)
{
    for (int k = 0; k < n; k++) {
        int best = k;
        double value = 0.0;
        for (int i = k; i < n; i++) {
            const double x = fabs(JO_RE(A[i * stride + k]));
            if (!(x <= value)) { value = x; best = i; }
        }
        pivot[k] = best;
        if (best != k) {
            swap_rows(A + k * stride, A + best * stride, stride);
            swap(row + k, row + best);
        }
        if (!(value > vanished * row[k] * column[k])) return k;
        const jo_real inverse = 1.0 / A[k * stride + k];
        A[k * stride + k] = inverse;
        const int from = (k + 1) & ~(JO_PAD - 1);
        for (int i = k + 1; i < n; i++) {
            jo_real *row = A + i * stride;
            const jo_real s = row[k] * inverse;
            if (s == 0.0) continue;
            jo_real kept[JO_PAD];   /* entries of L in the first lanes */
            for (int j = 0; j < JO_PAD; j++) kept[j] = row[from + j];
            subtract_row(row + from, s, A + k * stride + from, stride - from);
            for (int j = from; j <= k; j++) row[j] = kept[j - from];
            row[k] = s;
        }
    }
    return -1;
}

/* Kernels for blocks of six unknowns (rigid bodies, nodes of beams), with unrolled loops. The diagonal block becomes its inverse: products
 * with it have shorter dependency chains than substitutions. */

/* unit vectors, and ones elsewhere, padded */
static const jo_real units[JO_SIX][JO_ROW] = {{1, 0, 0, 0, 0, 0}, {0, 1, 0, 0, 0, 0}, {0, 0, 1, 0, 0, 0},
                                              {0, 0, 0, 1, 0, 0}, {0, 0, 0, 0, 1, 0}, {0, 0, 0, 0, 0, 1}};
static const jo_real others[JO_SIX][JO_ROW] = {{0, 1, 1, 1, 1, 1}, {1, 0, 1, 1, 1, 1}, {1, 1, 0, 1, 1, 1},
                                               {1, 1, 1, 0, 1, 1}, {1, 1, 1, 1, 0, 1}, {1, 1, 1, 1, 1, 0}};

/* A = A^-1 by Gauss-Jordan elimination with partial pivoting, arguments and result as of factor_dense */
static int invert_six(jo_real *restrict A, int *pivot, const double *column, double *row, const double vanished)
{
    for (int k = 0; k < JO_SIX; k++) {
        jo_real *pivot_row = A + k * JO_ROW;
        int best = k;
        double value = 0.0;
        for (int i = k; i < JO_SIX; i++) {
            const double x = fabs(JO_RE(A[i * JO_ROW + k]));
            if (!(x <= value)) { value = x; best = i; }
        }
        pivot[k] = best;
        if (best != k) {
            swap_rows(pivot_row, A + best * JO_ROW, JO_SIX);
            swap(row + k, row + best);
        }
        if (!(value > vanished * row[k] * column[k])) return k;
        /* column k becomes that of the inverse, without stores of single numbers, for which the loads of rows would wait */
        const jo_real inverse = 1.0 / pivot_row[k];
        JO_EACH(j, JO_SIX)
            JO_STORE(pivot_row + j) = inverse * (JO_LOAD(others[k] + j) * JO_LOAD(pivot_row + j) + JO_LOAD(units[k] + j));
        for (int i = 0; i < JO_SIX; i++) {
            if (i == k) continue;
            jo_real *x = A + i * JO_ROW;
            const jo_real s = x[k];
            JO_EACH(j, JO_SIX) JO_STORE(x + j) = JO_LOAD(others[k] + j) * JO_LOAD(x + j) - s * JO_LOAD(pivot_row + j);
        }
    }
    for (int k = JO_SIX - 1; k >= 0; k--)   /* exchanges of rows are exchanges of columns of the inverse */
        for (int i = 0; i < JO_SIX && pivot[k] != k; i++) {
            const jo_real t = A[i * JO_ROW + k];
            A[i * JO_ROW + k] = A[i * JO_ROW + pivot[k]];
            A[i * JO_ROW + pivot[k]] = t;
        }
    return -1;
}

/* B = A B for `padded` columns, A (6 x 6) */
static inline void multiply_six_rows(const jo_real *restrict A, jo_real *restrict B, const int padded)
{
    JO_EACH(j, padded) {
        jo_lanes b[JO_SIX];
        for (int i = 0; i < JO_SIX; i++) b[i] = JO_LOAD(B + i * padded + j);
        for (int i = 0; i < JO_SIX; i++) {
            jo_lanes sum = A[i * JO_ROW] * b[0];
            for (int k = 1; k < JO_SIX; k++) sum += A[i * JO_ROW + k] * b[k];
            JO_STORE(B + i * padded + j) = sum;
        }
    }
}

enum { TOGETHER = JO_WIDTH == 4 ? 2 : 1 };   /* vectors of columns whose sums of six rows fit into the registers */

/* sum = X Y for TOGETHER vectors of columns, X and Y (6 x 6) with padded rows */
static inline void product_of_six(jo_lanes sum[JO_SIX][TOGETHER], const jo_real *X, const jo_real *Y)
{
    for (int k = 0; k < JO_SIX; k++) {
        jo_lanes y[TOGETHER];
        for (int c = 0; c < TOGETHER; c++) y[c] = JO_LOAD(Y + k * JO_ROW + c * JO_WIDTH);
        for (int i = 0; i < JO_SIX; i++)
            for (int c = 0; c < TOGETHER; c++) {
                if (k) sum[i][c] += X[i * JO_ROW + k] * y[c];
                else sum[i][c] = X[i * JO_ROW] * y[c];
            }
    }
}

/* B = A B, 6 x 6, padded rows */
static void multiply_six(const jo_real *A, jo_real *B)
{
    for (int j = 0; j < JO_SIX; j += TOGETHER * JO_WIDTH) {
        jo_lanes sum[JO_SIX][TOGETHER];
        product_of_six(sum, A, B + j);
        for (int i = 0; i < JO_SIX; i++)
            for (int c = 0; c < TOGETHER; c++) JO_STORE(B + i * JO_ROW + j + c * JO_WIDTH) = sum[i][c];
    }
}

/* T -= X Y, 6 x 6, padded rows */
static void subtract_six(jo_real *T, const int target, const jo_real *X, const jo_real *Y)
{
    for (int j = 0; j < JO_SIX; j += TOGETHER * JO_WIDTH) {
        jo_lanes sum[JO_SIX][TOGETHER];
        product_of_six(sum, X, Y + j);
        for (int i = 0; i < JO_SIX; i++)
            for (int c = 0; c < TOGETHER; c++) JO_STORE(T + i * target + j + c * JO_WIDTH) -= sum[i][c];
    }
}

/* B = A^-1 B for count JO_WIDTH columns, with the sums in registers */
static inline void solve_panel(const jo_real *restrict A, const int n, const int stride, jo_real *restrict B,
                               const int padded, const int count)
{
    for (int i = 1; i < n; i++) {
        jo_lanes sum[4];
        for (int c = 0; c < count; c++) sum[c] = JO_LOAD(B + i * padded + c * JO_WIDTH);
        for (int k = 0; k < i; k++)
            for (int c = 0; c < count; c++) sum[c] -= A[i * stride + k] * JO_LOAD(B + k * padded + c * JO_WIDTH);
        for (int c = 0; c < count; c++) JO_STORE(B + i * padded + c * JO_WIDTH) = sum[c];
    }
    for (int i = n - 1; i >= 0; i--) {
        jo_lanes sum[4];
        for (int c = 0; c < count; c++) sum[c] = JO_LOAD(B + i * padded + c * JO_WIDTH);
        for (int k = i + 1; k < n; k++)
            for (int c = 0; c < count; c++) sum[c] -= A[i * stride + k] * JO_LOAD(B + k * padded + c * JO_WIDTH);
        for (int c = 0; c < count; c++) JO_STORE(B + i * padded + c * JO_WIDTH) = A[i * stride + i] * sum[c];
    }
}

/* B = A^-1 B for `padded` columns */
static void solve_rows(const jo_real *A, const int n, const int stride, const int *pivot, jo_real *B, const int padded)
{
    for (int k = 0; k < n; k++)
        if (pivot[k] != k) swap_rows(B + k * padded, B + pivot[k] * padded, padded);
    int j = 0;
    for (; j + 4 * JO_WIDTH <= padded; j += 4 * JO_WIDTH) solve_panel(A, n, stride, B + j, padded, 4);
    for (; j + 2 * JO_WIDTH <= padded; j += 2 * JO_WIDTH) solve_panel(A, n, stride, B + j, padded, 2);
    for (; j < padded; j += JO_WIDTH) solve_panel(A, n, stride, B + j, padded, 1);
}

/* T -= X Y, X (rows x n), Y (n x padded), four rows at a time */
static void subtract_product(jo_real *T, const int target, const jo_real *X, const int stride, const int rows, const int n,
                             const jo_real *Y, const int padded)
{
    int i = 0;
    for (; i + 4 <= rows; i += 4)
        JO_EACH(j, padded) {
            jo_lanes s0 = {0}, s1 = {0}, s2 = {0}, s3 = {0};
            const jo_real *x = X + i * stride, *y = Y + j;
            for (int k = 0; k < n; k++, y += padded) {
                const jo_lanes yk = JO_LOAD(y);
                s0 += x[k] * yk;
                s1 += x[stride + k] * yk;
                s2 += x[2 * stride + k] * yk;
                s3 += x[3 * stride + k] * yk;
            }
            JO_STORE(T + i * target + j) -= s0;
            JO_STORE(T + (i + 1) * target + j) -= s1;
            JO_STORE(T + (i + 2) * target + j) -= s2;
            JO_STORE(T + (i + 3) * target + j) -= s3;
        }
    for (; i < rows; i++)
        for (int k = 0; k < n; k++) subtract_row(T + i * target, X[i * stride + k], Y + k * padded, padded);
}

/* Scale of a joint row: diagonal of S = Cq M^-1 Cq^T for the diagonal of the mass matrix. The moments of inertia enter with their geometric
 * mean with the largest one: the rotation of a slender body about its axis, which other joints may prevent, would dominate the scale. */
static double row_size(const jo_model *m, jo_data *d, int joint, int row)
{
    const jo_joint *k = &m->joint[joint];
    double sum = 0.0;
    for (int side = 0; side < k->nside; side++) {
        const int body = m->marker[k->side[side]].body;
        if (body < 0) continue;
        const jo_block C = jo_newton_find(m, d, m->nbody + joint, body), M = jo_newton_find(m, d, body, body);
        double turn = 0.0;
        for (int j = 3; j < 6; j++) turn = jo_larger(turn, fabs(JO_RE(M.at[j * (M.stride + 1)])));
        for (int j = 0; j < 6 + m->body[body].n; j++) {
            const double c = fabs(JO_RE(C.at[row * C.stride + j])), x = fabs(JO_RE(M.at[j * (M.stride + 1)]));
            if (x > 0.0) sum += c * c / (j < 3 || j > 5 ? x : sqrt(x * turn));
        }
    }
    return sum;
}

/* Units of the unknowns, for which the diagonal of the matrix is 1: square roots of masses and inertias, and of the scales of joint rows.
 * To be called before the elimination. */
static void set_units(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nbody + m->njoint; i++) {
        const jo_block D = jo_newton_find(m, d, i, i);
        const int joint = i - m->nbody, count = joint < 0 ? 6 + m->body[i].n : m->joint[joint].nrow;
        double *unit = d->newton.unit + m->node[m->place[i].node].at + m->place[i].local;
        for (int r = 0; r < count; r++)
            unit[r] = sqrt(joint < 0 ? fabs(JO_RE(D.at[r * (D.stride + 1)])) : row_size(m, d, joint, r));
    }
}

/* redundant rows: diagonal -= soft, for multipliers of least norm */
static void regularise(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->njoint; i++) {
        if (jo_absent(d, &m->joint[i])) continue;
        const jo_block D = jo_newton_find(m, d, m->nbody + i, m->nbody + i);
        jo_real *soft = d->newton.soft + m->joint[i].row;
        for (int r = 0; r < m->joint[i].nrow; r++) {
            soft[r] = JO_SCHUR_REGULARISATION * JO_RE(jo_friction_softness(m, d, i, jo_same(row_size(m, d, i, r))));
            D.at[r * (D.stride + 1)] -= soft[r];
        }
    }
}

/* first joint of a node; -1 for none */
static int node_joint(const jo_model *m, int node)
{
    for (int i = 0; i < m->njoint; i++)
        if (m->place[m->nbody + i].node == node) return i;
    return -1;
}

/* transpose of a 6 x 6 block with padded rows */
static void transpose_six(jo_real *A)
{
    for (int i = 1; i < JO_SIX; i++)
        for (int j = 0; j < i; j++) {
            const jo_real t = A[i * JO_ROW + j];
            A[i * JO_ROW + j] = A[j * JO_ROW + i];
            A[j * JO_ROW + i] = t;
        }
}

/* blocks of a node of six unknowns and its branches of this width by columns, for jo_newton_solve */
static void transpose_node(const jo_model *m, jo_data *d, const jo_node *node)
{
    transpose_six(d->newton.N + node->diagonal);
    for (int b = node->first; b < node->first + node->count; b++) {
        if (m->branch[b].width != JO_SIX || jo_newton_empty(d, b)) continue;
        transpose_six(d->newton.N + m->branch[b].lower);
        transpose_six(d->newton.N + m->branch[b].upper);
    }
}

/* whether n numbers, a multiple of the padding, are finite: else x - x is not 0 */
static int all_finite(const jo_real *x, const int n)
{
    jo_lanes sum = {0};
    JO_EACH(i, n) sum += JO_LOAD(x + i) - JO_LOAD(x + i);
    return JO_RE(jo_sum(sum)) == 0.0;
}

/* A_ij -= A_ic A_cj */
static void update_later(const jo_model *m, jo_data *d, const jo_node *node, const jo_fill *fill, int six)
{
    const jo_branch *left = &m->branch[fill->left], *right = &m->branch[fill->right];
    const int padded = jo_pad(right->width);
    jo_real *T = d->newton.N + fill->target;
    const jo_real *X = d->newton.N + left->lower, *Y = d->newton.N + right->upper;
    if (six && left->width == JO_SIX && padded == JO_ROW)
        subtract_six(T, fill->stride, X, Y);
    else
        subtract_product(T, fill->stride, X, jo_pad(node->size), left->width, node->size, Y, padded);
}

/* blocks right of a pivot, A_cj = A_cc^-1 A_cj, and later blocks, without those that are zero */
static void eliminate(const jo_model *m, jo_data *d, int c, int six)
{
    const jo_node *node = &m->node[c];
    const jo_real *A = d->newton.N + node->diagonal;
    for (int b = node->first; b < node->first + node->count; b++) {
        jo_real *Y = d->newton.N + m->branch[b].upper;
        const int padded = jo_pad(m->branch[b].width);
        if (jo_newton_empty(d, b)) continue;
        if (six && padded == JO_ROW)
            multiply_six(A, Y);
        else if (six)
            multiply_six_rows(A, Y, padded);
        else
            solve_rows(A, node->size, jo_pad(node->size), d->newton.pivot + node->at, Y, padded);
    }
    if (!d->newton.sparse) {
        for (int f = m->fill_first[c]; f < m->fill_first[c + 1]; f++) update_later(m, d, node, &m->fill[f], six);
        return;
    }
    const int count = jo_newton_fill_in(m, d, c), *row = d->newton.row;   /* the fills of a node are those of all pairs of its branches */
    for (int i = 0; i < count; i++)
        for (int j = 0; j < count; j++) update_later(m, d, node, &m->fill[m->fill_first[c] + row[i] * node->count + row[j]], six);
}

/* factors of d->newton.N in place, node by node: LU of the diagonal block, A_cc^-1 A_cj, updates of later blocks. redundant: regularised */
int jo_newton_factor(const jo_model *m, jo_data *d, int redundant)
{
    d->counts.factorisations++;
    jo_newton_softened(d, redundant);
    const double vanished = redundant ? 0.0 : JO_DEPENDENT_PIVOT;
    set_units(m, d);
    if (redundant) regularise(m, d);
    for (int c = 0; c < m->nnode; c++) {
        const jo_node *node = &m->node[c];
        const int stride = jo_pad(node->size);
        jo_real *A = d->newton.N + node->diagonal;
        if (!all_finite(A, node->size * stride)) {
            d->error_index = node->body < 0 ? 0 : node->body;
            return JO_NOT_FINITE;
        }
        const int six = node->size == JO_SIX;
        int *pivot = d->newton.pivot + node->at;
        const double *column = d->newton.unit + node->at;
        double *row = d->newton.unit_of_row + node->at;
        for (int i = 0; i < node->size; i++) row[i] = column[i];
        const int failed = six ? invert_six(A, pivot, column, row, vanished)
                               : factor_dense(A, node->size, stride, pivot, column, row, vanished);
        if (failed >= 0) {
            const int joint = node_joint(m, c);
            d->error_index = joint >= 0 ? joint : node->body;
            return joint >= 0 ? JO_SINGULAR_JOINT : JO_SINGULAR_BODY;
        }
        if (node->count) eliminate(m, d, c, six);
        if (six) transpose_node(m, d, node);
    }
    return JO_OK;
}
