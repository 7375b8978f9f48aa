/* newton_factor.c - sparse block LU of Newton's matrix [M^ Cq^T; Cq 0] of the implicit methods.
 *
 * Elimination order and fill-in are constants of the model. A node is a body with the joints to its parent, which makes its pivot block
 * regular; rows are exchanged within a node only. After the factorisation a diagonal block contains its LU factors (of six unknowns:
 * their inverses), the block to its right A_cc^-1 A_cj, the block below it A_ic.
 */
#include "valid.h"
#include "newton/newton.h"

#define JO_SCHUR_REGULARISATION 1e-8    /* share of the scale of a joint row that is subtracted from its diagonal if rows are redundant */
/* pivot relative to (unit of its row x unit of its column) below which the row depends on other rows */
#define JO_DEPENDENT_PIVOT 1e-14

/* block with the rows of item x and the columns of item y (bodies, then joints); address 0 if it is structurally zero */
jo_block jo_newton_find(const jo_model *m, jo_data *d, int x, int y)
{
    const jo_place *p = &m->place[x], *q = &m->place[y];
    const int early = p->node < q->node ? p->node : q->node, late = p->node < q->node ? q->node : p->node;
    const jo_node *node = &m->node[early];
    jo_block block = {d->newton.N + node->diagonal, jo_pad(node->size)};
    if (early != late) {
        const jo_branch *branch = &m->branch[node->first], *end = branch + node->count;
        while (branch < end && branch->node != late) branch++;
        if (branch == end) {
            const jo_block none = {0, 0};
            return none;
        }
        if ((p->node == late ? p->local : q->local) >= branch->width) {
            const jo_block none = {0, 0};
            return none;
        }
        if (p->node == late) {
            block.at = d->newton.N + branch->lower;
        } else {
            block.at = d->newton.N + branch->upper;
            block.stride = jo_pad(branch->width);
        }
    }
    block.at += p->local * block.stride + q->local;
    return block;
}

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

/* Kernels for blocks of six unknowns (rigid bodies, nodes of beams), with unrolled loops. L and U are replaced by their inverses: products
 * with these have shorter dependency chains than substitutions. */
enum { JO_SIX = 6, JO_ROW = 8 };

/* L and U of a 6 x 6 block replaced by L^-1 and U^-1 */
static void invert_six(jo_real *restrict A)
{
    jo_real x[JO_SIX];
    for (int i = 1; i < JO_SIX; i++) {
        jo_real *row = A + i * JO_ROW;
        for (int j = 0; j < i; j++) {
            x[j] = -row[j];
            for (int k = j + 1; k < i; k++) x[j] -= row[k] * A[k * JO_ROW + j];
        }
        for (int j = 0; j < i; j++) row[j] = x[j];
    }
    for (int i = JO_SIX - 2; i >= 0; i--) {
        jo_real *row = A + i * JO_ROW;
        for (int j = i + 1; j < JO_SIX; j++) {
            x[j] = 0.0;
            for (int k = i + 1; k <= j; k++) x[j] -= row[k] * A[k * JO_ROW + j];
        }
        for (int j = i + 1; j < JO_SIX; j++) row[j] = row[i] * x[j];
    }
}

/* B = A^-1 B for `padded` columns */
static inline void solve_six_rows(const jo_real *restrict A, const int *pivot, jo_real *restrict B, const int padded)
{
    for (int k = 0; k < JO_SIX; k++)
        if (pivot[k] != k) swap_rows(B + k * padded, B + pivot[k] * padded, padded);
    JO_EACH(j, padded) {
        jo_lanes b[JO_SIX];
        for (int i = 0; i < JO_SIX; i++) b[i] = JO_LOAD(B + i * padded + j);
        for (int i = JO_SIX - 1; i > 0; i--)
            for (int k = 0; k < i; k++) b[i] += A[i * JO_ROW + k] * b[k];
        for (int i = 0; i < JO_SIX; i++) {
            b[i] *= A[i * JO_ROW + i];
            for (int k = i + 1; k < JO_SIX; k++) b[i] += A[i * JO_ROW + k] * b[k];
            JO_STORE(B + i * padded + j) = b[i];
        }
    }
}

/* x = A^-1 x */
static void solve_six(const jo_real *restrict A, const int *pivot, jo_real *restrict x)
{
    jo_real b[JO_SIX];
    for (int k = 0; k < JO_SIX; k++)
        if (pivot[k] != k) swap_rows(x + k, x + pivot[k], 1);
    for (int i = 0; i < JO_SIX; i++) {
        b[i] = x[i];
        for (int k = 0; k < i; k++) b[i] += A[i * JO_ROW + k] * x[k];
    }
    for (int i = 0; i < JO_SIX; i++) {
        jo_real sum = A[i * JO_ROW + i] * b[i];
        for (int k = i + 1; k < JO_SIX; k++) sum += A[i * JO_ROW + k] * b[k];
        x[i] = sum;
    }
}

/* y -= A x */
static inline void subtract_six(jo_real *restrict y, const jo_real *restrict A, const jo_real *restrict x)
{
    for (int i = 0; i < JO_SIX; i++) {
        jo_real sum = y[i];
        for (int k = 0; k < JO_SIX; k++) sum -= A[i * JO_ROW + k] * x[k];
        y[i] = sum;
    }
}

/* T -= X Y, 6 x 6, padded rows */
static void subtract_six_rows(jo_real *restrict T, const int target, const jo_real *restrict X, const jo_real *restrict Y)
{
    JO_EACH(j, JO_ROW) {
        jo_lanes sum[JO_SIX];
        for (int i = 0; i < JO_SIX; i++) sum[i] = JO_LOAD(T + i * target + j);
        for (int k = 0; k < JO_SIX; k++) {
            const jo_lanes y = JO_LOAD(Y + k * JO_ROW + j);
            for (int i = 0; i < JO_SIX; i++) sum[i] -= X[i * JO_ROW + k] * y;
        }
        for (int i = 0; i < JO_SIX; i++) JO_STORE(T + i * target + j) = sum[i];
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

static inline jo_real dot(const jo_real *restrict a, const jo_real *restrict b, const int n)
{
    jo_lanes sum = {0}, other = {0};
    int k = 0;
    for (; k + 2 * JO_WIDTH <= n; k += 2 * JO_WIDTH) {
        sum += JO_LOAD(a + k) * JO_LOAD(b + k);
        other += JO_LOAD(a + k + JO_WIDTH) * JO_LOAD(b + k + JO_WIDTH);
    }
    jo_real s = jo_sum(sum + other);
    for (; k < n; k++) s += a[k] * b[k];
    return s;
}

/* x = A^-1 x with LU factors */
static void solve_column(const jo_real *A, const int n, const int stride, const int *pivot, jo_real *x)
{
    for (int k = 0; k < n; k++)
        if (pivot[k] != k) swap_rows(x + k, x + pivot[k], 1);
    for (int i = 1; i < n; i++) x[i] -= dot(A + i * stride, x, i);
    for (int i = n - 1; i >= 0; i--) x[i] = A[i * stride + i] * (x[i] - dot(A + i * stride + i + 1, x + i + 1, n - i - 1));
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
            soft[r] = JO_SCHUR_REGULARISATION * row_size(m, d, i, r);
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
        double sum = 0.0;
        for (int i = 0; i < node->size * stride; i++) sum += fabs(JO_RE(A[i]));
        if (!isfinite(sum)) {
            d->error_index = node->body < 0 ? 0 : node->body;
            return JO_NOT_FINITE;
        }
        const int six = node->size == JO_SIX;
        int *pivot = d->newton.pivot + node->at;
        const double *column = d->newton.unit + node->at;
        double *row = d->newton.unit_of_row + node->at;
        for (int i = 0; i < node->size; i++) row[i] = column[i];
        const int failed = six ? factor_dense(A, JO_SIX, JO_ROW, pivot, column, row, vanished)
                               : factor_dense(A, node->size, stride, pivot, column, row, vanished);
        if (failed >= 0) {
            const int joint = node_joint(m, c);
            d->error_index = joint >= 0 ? joint : node->body;
            return joint >= 0 ? JO_SINGULAR_JOINT : JO_SINGULAR_BODY;
        }
        /* blocks to the right: A_cj = A_cc^-1 A_cj */
        if (six) invert_six(A);
        for (int b = node->first; b < node->first + node->count; b++) {
            jo_real *Y = d->newton.N + m->branch[b].upper;
            const int padded = jo_pad(m->branch[b].width);
            if (six && padded == JO_ROW)
                solve_six_rows(A, pivot, Y, JO_ROW);
            else if (six)
                solve_six_rows(A, pivot, Y, padded);
            else
                solve_rows(A, node->size, stride, pivot, Y, padded);
        }
        /* later blocks: A_ij -= A_ic A_cj */
        for (int f = m->fill_first[c]; f < m->fill_first[c + 1]; f++) {
            const jo_fill *fill = &m->fill[f];
            const jo_branch *left = &m->branch[fill->left], *right = &m->branch[fill->right];
            const int padded = jo_pad(right->width);
            jo_real *T = d->newton.N + fill->target;
            const jo_real *X = d->newton.N + left->lower, *Y = d->newton.N + right->upper;
            if (six && left->width == JO_SIX && padded == JO_ROW)
                subtract_six_rows(T, fill->stride, X, Y);
            else
                subtract_product(T, fill->stride, X, stride, left->width, node->size, Y, padded);
        }
    }
    return JO_OK;
}

/* d->newton.x = N^-1 d->newton.x: forward elimination, then back substitution */
void jo_newton_solve(const jo_model *m, jo_data *d)
{
    for (int c = 0; c < m->nnode; c++) {
        const jo_node *node = &m->node[c];
        const int stride = jo_pad(node->size);
        jo_real *x = d->newton.x + node->at;
        const int six = node->size == JO_SIX;
        if (six)
            solve_six(d->newton.N + node->diagonal, d->newton.pivot + node->at, x);
        else
            solve_column(d->newton.N + node->diagonal, node->size, stride, d->newton.pivot + node->at, x);
        for (int b = node->first; b < node->first + node->count; b++) {
            const jo_branch *branch = &m->branch[b];
            const jo_real *X = d->newton.N + branch->lower;
            jo_real *y = d->newton.x + m->node[branch->node].at;
            if (six && branch->width == JO_SIX)
                subtract_six(y, X, x);
            else
                for (int i = 0; i < branch->width; i++) y[i] -= dot(X + i * stride, x, node->size);
        }
    }
    for (int c = m->nnode - 1; c >= 0; c--) {
        const jo_node *node = &m->node[c];
        jo_real *x = d->newton.x + node->at;
        for (int b = node->first; b < node->first + node->count; b++) {
            const jo_branch *branch = &m->branch[b];
            const int stride = jo_pad(branch->width);
            const jo_real *Y = d->newton.N + branch->upper, *y = d->newton.x + m->node[branch->node].at;
            if (node->size == JO_SIX && branch->width == JO_SIX)
                subtract_six(x, Y, y);
            else
                for (int i = 0; i < node->size; i++) x[i] -= dot(Y + i * stride, y, branch->width);
        }
    }
}
