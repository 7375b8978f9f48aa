/* schur.c - the block matrix S = Cq M^-1 Cq^T of all joints, its sparse Cholesky factor and the multipliers.
 *
 * The order of elimination and the fill are fixed when the model is compiled.
 */
#include "internal.h"

#define JO_REGULAR 1e-9    /* added to the diagonal of S, relative, where rows repeat one another */
enum { JO_REFINE = 2 };    /* steps of refinement, each closing what the addition left open */

/* L_k weight L_l^T of a pair of joint sides on one flexible body: constant without stiffening */
static void pair_gram(const jo_model *m, jo_data *d, int i, int set)
{
    const jo_pair *p = &m->pair[i];
    const int k = m->joint[p->joint_k].side[p->side_k], l = m->joint[p->joint_l].side[p->side_l];
    const jo_marker_work *mk = &d->marker[k], *ml = &d->marker[l];
    const int np = m->body[m->marker[k].body].np;
    const jo_real *weight = d->body[m->marker[k].body].set[set].weight;
    jo_real *gram = d->gram[set] + 36 * i;
    for (int r = 0; r < 6; r++)
        for (int c = 0; c < 6; c++) {
            const jo_real *x = r < 3 ? mk->Phi : mk->Psi, *y = c < 3 ? ml->Phi : ml->Psi;
            jo_real s = 0.0;
            if (x && y)
                for (int j = 0; j < np; j++) s += x[(r % 3) * np + j] * weight[j] * y[(c % 3) * np + j];
            gram[6 * r + c] = s;
        }
}

void jo_joint_setup(const jo_model *m, jo_data *d, int set)
{
    for (int i = 0; i < m->npair; i++) pair_gram(m, d, i, set);
}

/* S += X^T Y, six rows */
static inline void add_product(jo_real *restrict S, const jo_real *restrict X, const int nx,
                               const jo_real *restrict Y, const int ny)
{
    for (int i = 0; i < nx; i++)
        for (int j = 0; j < ny; j++) {
            jo_real s = 0.0;
            for (int c = 0; c < 6; c++) s += X[6 * c + i] * Y[6 * c + j];
            S[6 * i + j] += s;
        }
}

/* S += C_k gram C_l^T for the translations of two coincidences */
static inline void add_gram_translation(jo_real *restrict S, const jo_real *restrict Ck,
                                        const jo_real *restrict Cl, const jo_real *restrict gram)
{
    for (int i = 0; i < 3; i++) {
        jo_real h[3];
        for (int j = 0; j < 3; j++)
            h[j] = Ck[6 * i] * gram[j] + Ck[6 * i + 1] * gram[6 + j] + Ck[6 * i + 2] * gram[12 + j];
        for (int j = 0; j < 3; j++) S[6 * i + j] += jo_dot3(h, Cl + 6 * j);
    }
}

/* the same for all rows; the first rows see translations only, the others rotations only */
static void add_gram(jo_real *S, const jo_joint *k, const jo_real *Ck, const jo_joint *l, const jo_real *Cl,
                     const jo_real *gram)
{
    const int tk = k->coincident ? 3 : 0, tl = l->coincident ? 3 : 0;
    for (int i = 0; i < k->nrow; i++) {
        const int o = i < tk ? 0 : 3;
        const jo_real *c = Ck + 6 * i + o, *g = gram + 6 * o;
        jo_real h[6];
        for (int j = 0; j < 6; j++) h[j] = c[0] * g[j] + c[1] * g[6 + j] + c[2] * g[12 + j];
        for (int j = 0; j < tl; j++) S[6 * i + j] += jo_dot3(h, Cl + 6 * j);
        for (int j = tl; j < l->nrow; j++) S[6 * i + j] += jo_dot3(h + 3, Cl + 6 * j + 3);
    }
}

/* the same where rows see translations and rotations */
static void add_gram_lines(jo_real *S, const jo_joint *k, const jo_real *Ck, const jo_joint *l, const jo_real *Cl,
                           const jo_real *gram)
{
    for (int i = 0; i < k->nrow; i++) {
        jo_real h[6];
        for (int j = 0; j < 6; j++) {
            h[j] = 0.0;
            for (int c = 0; c < 6; c++) h[j] += Ck[6 * i + c] * gram[6 * c + j];
        }
        for (int j = 0; j < l->nrow; j++) S[6 * i + j] += jo_dot3(h, Cl + 6 * j) + jo_dot3(h + 3, Cl + 6 * j + 3);
    }
}

/* S = L L^T of a diagonal block, in place, inverse diagonal; a pivot that vanishes against the diagonal
 * that the row had before elimination means that the row repeats others. 1, 0: singular, -1: not finite */
static inline int factor_diagonal(jo_real *restrict S, const int n, const double *scale)
{
    int regular = 1;
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++) {
            jo_real x = S[6 * i + k];
            for (int j = 0; j < k; j++) x -= S[6 * i + j] * S[6 * k + j];
            S[6 * i + k] = x * S[7 * k];
        }
        jo_real x = S[7 * i];
        for (int j = 0; j < i; j++) x -= S[6 * i + j] * S[6 * i + j];
        if (regular == 1 && !(JO_RE(x) > 1e-12 * scale[i])) regular = isfinite(JO_RE(x)) ? 0 : -1;
        S[7 * i] = 1.0 / jo_sqrt(x);
    }
    return regular;
}

/* X = X L^-T */
static inline void divide(jo_real *restrict X, const int rows, const jo_real *restrict L, const int n)
{
    for (int j = 0; j < n; j++)
        for (int r = 0; r < rows; r++) {
            jo_real x = X[6 * r + j];
            for (int k = 0; k < j; k++) x -= L[6 * j + k] * X[6 * r + k];
            X[6 * r + j] = x * L[7 * j];
        }
}

/* T -= X Y^T over n columns */
static inline void subtract_product(jo_real *restrict T, const jo_real *restrict X, const int nx,
                                    const jo_real *restrict Y, const int ny, const int n)
{
    for (int r = 0; r < nx; r++)
        for (int s = 0; s < ny; s++) {
            jo_real x = T[6 * r + s];
            for (int j = 0; j < n; j++) x -= X[6 * r + j] * Y[6 * s + j];
            T[6 * r + s] = x;
        }
}

static void assemble(const jo_model *m, jo_data *d)
{
    jo_real *S = d->S;
    for (int i = 0; i < 36 * m->nblock; i++) S[i] = 0.0;
    for (int i = 0; i < m->npair; i++) {
        const jo_pair *p = &m->pair[i];
        const jo_joint *k = &m->joint[p->joint_k], *l = &m->joint[p->joint_l];
        const jo_joint_work *wk = &d->joint[p->joint_k], *wl = &d->joint[p->joint_l];
        const jo_real *X = wk->V[p->side_k], *Y = wl->V[p->side_l];
        jo_real *block = S + 36 * p->block;
        const int body = m->marker[k->side[p->side_k]].body;
        if (k->nrow == l->nrow) {
#define CALL(n) add_product(block, X, n, Y, n)
            JO_BY_ROWS(k->nrow, CALL)
#undef CALL
        } else {
            add_product(block, X, k->nrow, Y, l->nrow);
        }
        if (!m->body[body].n) continue;
        if (m->marker[k->side[p->side_k]].chi) pair_gram(m, d, i, d->set);
        const jo_real *gram = d->gram[d->set] + 36 * i;
        if (k->nline || l->nline) add_gram_lines(block, k, wk->C[p->side_k], l, wl->C[p->side_l], gram);
        else if (k->nperp || l->nperp) add_gram(block, k, wk->C[p->side_k], l, wl->C[p->side_l], gram);
        else add_gram_translation(block, wk->C[p->side_k], wl->C[p->side_l], gram);
    }
}

/* S + eps diag(S), which is regular; S itself is kept for the refinement */
static void regularise(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < 36 * m->nblock; i++) d->S0[i] = d->S[i];
    for (int c = 0; c < m->ncolumn; c++)
        for (int r = 0; r < JO_MAX_ROWS; r++) d->S[36 * c + 7 * r] *= 1.0 + JO_REGULAR;
}

/* sparse block Cholesky in the fixed elimination order */
static int factor(const jo_model *m, jo_data *d)
{
    jo_real *S = d->S;
    assemble(m, d);
    for (int c = 0; m->nlock && c < m->ncolumn; c++)
        if (jo_absent(d, &m->joint[m->column[c].joint]))
            for (int r = 0; r < JO_MAX_ROWS; r++) S[36 * c + 7 * r] = 1.0;
    for (int c = 0; c < m->ncolumn; c++)
        for (int r = 0; r < JO_MAX_ROWS; r++) d->joint[m->column[c].joint].scale[r] = JO_RE(S[36 * c + 7 * r]);
    if (d->regular) regularise(m, d);
    for (int c = 0; c < m->ncolumn; c++) {
        const jo_column *col = &m->column[c];
        const int n = m->joint[col->joint].nrow;
        jo_real *diag = S + 36 * c;
        const double *scale = d->joint[col->joint].scale;
        int regular;
#define CALL(n) regular = factor_diagonal(diag, n, scale)
        JO_BY_ROWS(n, CALL)
#undef CALL
        if (regular != 1) {
            const jo_joint *k = &m->joint[col->joint];
            const int body = m->marker[k->side[1]].body;
            d->error_index = regular == 0 ? col->joint : body < 0 ? m->marker[k->side[0]].body : body;
            return regular == 0 ? JO_SINGULAR_JOINT : JO_NOT_FINITE;
        }
        for (int i = col->first; i < col->first + col->count; i++) {
            jo_real *X = S + 36 * m->below[i].block;
            const int rows = m->joint[m->below[i].joint].nrow;
            if (rows == n) {
#define CALL(n) divide(X, n, diag, n)
                JO_BY_ROWS(n, CALL)
#undef CALL
            } else {
                divide(X, rows, diag, n);
            }
        }
        for (int u = m->update_first[c]; u < m->update_first[c + 1]; u++) {
            const jo_update *up = &m->update[u];
            jo_real *T = S + 36 * up->target;
            const jo_real *X = S + 36 * up->left, *Y = S + 36 * up->right;
            if (up->left_rows == n && up->right_rows == n) {
#define CALL(n) subtract_product(T, X, n, Y, n, n)
                JO_BY_ROWS(n, CALL)
#undef CALL
            } else {
                subtract_product(T, X, up->left_rows, Y, up->right_rows, n);
            }
        }
    }
    return JO_OK;
}

/* A pivot that vanishes although no rows repeat one another belongs to a singular position: it is passed with the
 * multipliers of least norm and counted. */
int jo_joint_factor(const jo_model *m, jo_data *d)
{
    d->regular = m->redundant > 0;
    int status = factor(m, d);
    if (status == JO_SINGULAR_JOINT && m->redundant == 0) {
        d->counts[4]++;
        d->regular = 1;
        status = factor(m, d);
    }
    return status;
}

static inline void solve_forward(const jo_real *restrict L, jo_real *restrict x, const int n)
{
    for (int i = 0; i < n; i++) {
        jo_real s = x[i];
        for (int k = 0; k < i; k++) s -= L[6 * i + k] * x[k];
        x[i] = s * L[7 * i];
    }
}

static inline void solve_backward(const jo_real *restrict L, jo_real *restrict x, const int n)
{
    for (int i = n - 1; i >= 0; i--) {
        jo_real s = x[i];
        for (int k = i + 1; k < n; k++) s -= L[6 * k + i] * x[k];
        x[i] = s * L[7 * i];
    }
}

/* y -= X x */
static inline void subtract_left(jo_real *restrict y, const jo_real *restrict X, const jo_real *restrict x,
                                 const int rows, const int n)
{
    for (int r = 0; r < rows; r++) {
        jo_real s = y[r];
        for (int k = 0; k < n; k++) s -= X[6 * r + k] * x[k];
        y[r] = s;
    }
}

/* x -= X^T y */
static inline void subtract_right(jo_real *restrict x, const jo_real *restrict X, const jo_real *restrict y,
                                  const int rows, const int n)
{
    for (int k = 0; k < n; k++) {
        jo_real s = x[k];
        for (int r = 0; r < rows; r++) s -= X[6 * r + k] * y[r];
        x[k] = s;
    }
}

/* x = (L L^T)^-1 x for all joints */
static void solve_factored(const jo_model *m, jo_data *d)
{
    for (int c = 0; c < m->ncolumn; c++) {
        const jo_column *col = &m->column[c];
        const int n = m->joint[col->joint].nrow;
        jo_real *x = d->joint[col->joint].x;
#define CALL(n) solve_forward(d->S + 36 * c, x, n)
        JO_BY_ROWS(n, CALL)
#undef CALL
        for (int i = col->first; i < col->first + col->count; i++) {
            const jo_real *X = d->S + 36 * m->below[i].block;
            jo_real *y = d->joint[m->below[i].joint].x;
            const int rows = m->joint[m->below[i].joint].nrow;
            if (rows == n) {
#define CALL(n) subtract_left(y, X, x, n, n)
                JO_BY_ROWS(n, CALL)
#undef CALL
            } else {
                subtract_left(y, X, x, rows, n);
            }
        }
    }
    for (int c = m->ncolumn - 1; c >= 0; c--) {
        const jo_column *col = &m->column[c];
        const int n = m->joint[col->joint].nrow;
        jo_real *x = d->joint[col->joint].x;
        for (int i = col->first; i < col->first + col->count; i++) {
            const jo_real *X = d->S + 36 * m->below[i].block, *y = d->joint[m->below[i].joint].x;
            const int rows = m->joint[m->below[i].joint].nrow;
            if (rows == n) {
#define CALL(n) subtract_right(x, X, y, n, n)
                JO_BY_ROWS(n, CALL)
#undef CALL
            } else {
                subtract_right(x, X, y, rows, n);
            }
        }
#define CALL(n) solve_backward(d->S + 36 * c, x, n)
        JO_BY_ROWS(n, CALL)
#undef CALL
    }
}

/* residual = right - S0 sum, into x */
static void residual(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) d->joint[i].x[r] = d->joint[i].right[r];
    for (int c = 0; c < m->ncolumn; c++) {
        const jo_column *col = &m->column[c];
        jo_joint_work *w = &d->joint[col->joint];
        const int n = m->joint[col->joint].nrow;
        for (int i = 0; i < n; i++)   /* the lower triangle counts */
            for (int j = 0; j < n; j++) w->x[i] -= d->S0[36 * c + (j <= i ? 6 * i + j : 6 * j + i)] * w->sum[j];
        for (int i = col->first; i < col->first + col->count; i++) {
            const jo_real *X = d->S0 + 36 * m->below[i].block;
            jo_joint_work *v = &d->joint[m->below[i].joint];
            const int rows = m->joint[m->below[i].joint].nrow;
            subtract_left(v->x, X, w->sum, rows, n);
            subtract_right(w->x, X, v->sum, rows, n);
        }
    }
}

/* S x = x for all joints. Where rows repeat one another the right-hand sides agree, so that refinement with the
 * regularised factor converges to a solution, the one of least norm in the scale of the diagonal */
void jo_joint_solve(const jo_model *m, jo_data *d)
{
    if (!d->regular) {
        solve_factored(m, d);
        return;
    }
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) {
            d->joint[i].right[r] = d->joint[i].x[r];
            d->joint[i].sum[r] = 0.0;
        }
    for (int k = 0; k <= JO_REFINE; k++) {
        if (k) residual(m, d);
        solve_factored(m, d);
        for (int i = 0; i < m->njoint; i++)
            for (int r = 0; r < m->joint[i].nrow; r++) d->joint[i].sum[r] += d->joint[i].x[r];
    }
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) d->joint[i].x[r] = d->joint[i].sum[r];
}
