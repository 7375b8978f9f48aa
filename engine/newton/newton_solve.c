/* newton_solve.c - solution of Newton's equations with the factors of newton_factor.c. */
#include "newton/newton.h"

/* Six numbers as vectors, without the two numbers behind them: a load that overlaps an earlier store in part would wait for it. */
#if defined(JO_PICK)
typedef double pair __attribute__((vector_size(16), aligned(8), may_alias));
typedef struct { jo_lanes first; pair rest; } six;
static inline six load_six(const jo_real *x) { return (six){JO_LOAD(x), *(const pair *)(x + 4)}; }
static inline void store_six(jo_real *x, const six y) { JO_STORE(x) = y.first; *(pair *)(x + 4) = y.rest; }
/* y - s x */
static inline six subtract(const six y, const jo_real s, const six x) { return (six){y.first - s * x.first, y.rest - s * x.rest}; }
#else
typedef struct { jo_lanes part[JO_SIX / JO_WIDTH]; } six;
static inline six load_six(const jo_real *x)
{
    six y;
    for (int j = 0; j < JO_SIX / JO_WIDTH; j++) y.part[j] = JO_LOAD(x + j * JO_WIDTH);
    return y;
}
static inline void store_six(jo_real *x, const six y)
{
    for (int j = 0; j < JO_SIX / JO_WIDTH; j++) JO_STORE(x + j * JO_WIDTH) = y.part[j];
}
static inline six subtract(six y, const jo_real s, const six x)
{
    for (int j = 0; j < JO_SIX / JO_WIDTH; j++) y.part[j] -= s * x.part[j];
    return y;
}
#endif

/* y -= A x, A (6 x 6) by columns */
static inline void subtract_six(jo_real *y, const jo_real *A, const jo_real *x)
{
    six sum = load_six(y);
    for (int k = 0; k < JO_SIX; k++) sum = subtract(sum, x[k], load_six(A + k * JO_ROW));
    store_six(y, sum);
}

/* x = A x */
static inline void multiply_six(const jo_real *A, jo_real *x)
{
    static const jo_real none[JO_SIX] = {0};
    six sum = load_six(none);
    for (int k = 0; k < JO_SIX; k++) sum = subtract(sum, -x[k], load_six(A + k * JO_ROW));
    store_six(x, sum);
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
        if (pivot[k] != k) {
            const jo_real t = x[k];
            x[k] = x[pivot[k]];
            x[pivot[k]] = t;
        }
    for (int i = 1; i < n; i++) x[i] -= dot(A + i * stride, x, i);
    for (int i = n - 1; i >= 0; i--) x[i] = A[i * stride + i] * (x[i] - dot(A + i * stride + i + 1, x + i + 1, n - i - 1));
}

/* d->newton.x = N^-1 d->newton.x: forward elimination, then back substitution */
void jo_newton_solve(const jo_model *m, jo_data *d)
{
    for (int c = 0; c < m->nnode; c++) {
        const jo_node *node = &m->node[c];
        const int stride = jo_pad(node->size), six = node->size == JO_SIX;
        jo_real *x = d->newton.x + node->at;
        if (six) multiply_six(d->newton.N + node->diagonal, x);
        else solve_column(d->newton.N + node->diagonal, node->size, stride, d->newton.pivot + node->at, x);
        for (int b = node->first; b < node->first + node->count; b++) {
            const jo_branch *branch = &m->branch[b];
            if (jo_newton_empty(d, b)) continue;
            const jo_real *X = d->newton.N + branch->lower;
            jo_real *y = d->newton.x + m->node[branch->node].at;
            if (six && branch->width == JO_SIX) subtract_six(y, X, x);
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
            if (jo_newton_empty(d, b)) continue;
            const jo_real *Y = d->newton.N + branch->upper, *y = d->newton.x + m->node[branch->node].at;
            if (node->size == JO_SIX && branch->width == JO_SIX) subtract_six(x, Y, y);
            else
                for (int i = 0; i < node->size; i++) x[i] -= dot(Y + i * stride, y, branch->width);
        }
    }
}
