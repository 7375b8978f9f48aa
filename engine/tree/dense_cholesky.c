/* dense_cholesky.c - factorisation S = U^T D^-1 U of a small dense positive semidefinite matrix, with pivoting for dependent rows. */
#include "tree/tree_links.h"

static void swap_reals(jo_real *a, jo_real *b)
{
    const jo_real t = *a;
    *a = *b;
    *b = t;
}

/* S_ij -= S_ki S_kj / S_kk for i > k, j >= i, or j > k if `whole` */
static inline void eliminate(jo_gram *g, int k, int whole)
{
    const jo_real inverse = 1.0 / g->S[k * g->ld + k], *row = g->S + k * g->ld;
    g->inverse[k] = inverse;
    for (int i = k + 1; i < g->n; i++) {
        jo_real *y = g->S + i * g->ld;
        const jo_real f = row[i] * inverse;
        for (int j = whole ? k + 1 : i; j < g->n; j += JO_WIDTH) JO_STORE(y + j) -= f * JO_LOAD(row + j);
    }
}

/* factors without pivoting; 0 if a pivot is below JO_SINGULAR_PIVOT times the scale of its row, -1 if it is not finite */
int jo_gram_factor(jo_gram *g, int *row)
{
    g->rank = g->n;
    for (int k = 0; k < g->n; k++) {
        const jo_real pivot = g->S[k * g->ld + k];
        *row = g->order[k] = k;
        if (!(JO_RE(pivot) > JO_SINGULAR_PIVOT * g->scale[k])) return isfinite(JO_RE(pivot)) ? 0 : -1;
        eliminate(g, k, 0);
    }
    return 1;
}

/* exchange of rows and columns i and j */
static void exchange(jo_gram *g, int i, int j)
{
    const int t = g->order[i];
    if (i == j) return;
    for (int c = 0; c < g->n; c++) swap_reals(g->S + i * g->ld + c, g->S + j * g->ld + c);
    for (int r = 0; r < g->n; r++) swap_reals(g->S + r * g->ld + i, g->S + r * g->ld + j);
    g->order[i] = g->order[j];
    g->order[j] = t;
}

/* factors with the largest pivot / scale first; rank = number of pivots above `least` */
int jo_gram_factor_pivoted(jo_gram *g, double least)
{
    for (int i = 0; i < g->n; i++) {
        g->order[i] = i;
        for (int j = 0; j < i; j++) g->S[i * g->ld + j] = g->S[j * g->ld + i];
    }
    for (g->rank = 0; g->rank < g->n; g->rank++) {
        const int k = g->rank;
        int best = -1;
        double most = least;
        for (int i = k; i < g->n; i++) {
            const double x = JO_RE(g->S[i * g->ld + i]) / g->scale[g->order[i]];
            if (!isfinite(x)) return -1;
            if (!(x > most)) continue;
            most = x;
            best = i;
        }
        if (best < 0) return 1;
        exchange(g, k, best);
        eliminate(g, k, 1);
    }
    return 1;
}

/* x = S^-1 x by forward elimination and back substitution of the first `rank` rows; 0 in the others */
void jo_gram_solve(const jo_gram *g, jo_real *x)
{
    jo_real *y = g->y;
    for (int i = 0; i < g->n; i++) y[i] = x[g->order[i]];
    for (int k = 0; k < g->rank; k++) {
        const jo_real *row = g->S + k * g->ld;
        y[k] *= g->inverse[k];
        for (int i = k + 1; i < g->rank; i++) y[i] -= row[i] * y[k];
    }
    for (int k = g->rank - 1; k >= 0; k--) {
        const jo_real *row = g->S + k * g->ld;
        jo_real sum = 0.0;
        for (int i = k + 1; i < g->rank; i++) sum += row[i] * y[i];
        y[k] -= g->inverse[k] * sum;
    }
    for (int i = 0; i < g->n; i++) x[g->order[i]] = i < g->rank ? y[i] : 0.0;
}
