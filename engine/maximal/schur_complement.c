/* schur_complement.c - Schur complement S = Cq M^-1 Cq^T of all joints, its sparse block factorisation L D L^T, and the multipliers.
 *
 * The elimination order and the fill-in are constants of the model. S_kl is the sum of V_k^T V_l + C_k gram C_l^T over common bodies.
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "friction/friction.h"

/* share of the diagonal of S that is added to S if rows are redundant; about the root of round-off */
#define JO_SCHUR_REGULARISATION 1e-8
enum { JO_REFINEMENTS = 2 };   /* number of iterative refinements; each reduces the error due to the regularisation by a factor of 1e-8 */

/* L_k weight L_l^T of a pair of joint sides on one flexible body: constant without stiffening */
static void pair_gram(const jo_model *m, jo_data *d, int i, int set)
{
    const jo_pair *p = &m->pair[i];
    const int k = m->joint[p->joint_k].side[p->side_k], l = m->joint[p->joint_l].side[p->side_l];
    const jo_marker_work *mk = &d->marker[k], *ml = &d->marker[l];
    const int np = m->body[m->marker[k].body].np;
    const jo_real *weight = d->body[m->marker[k].body].maximal.set[set].weight;
    jo_real *gram = d->schur.gram[set] + 36 * i;
    for (int r = 0; r < 6 && np; r++)
        for (int c = 0; c < 6; c++) {
            const jo_real *x = r < 3 ? mk->Phi : mk->Psi, *y = c < 3 ? ml->Phi : ml->Psi;
            jo_real s = {0.0};
            if (x && y)
                for (int j = 0; j < np; j++) s += x[(r % 3) * np + j] * weight[j] * y[(c % 3) * np + j];
            gram[6 * r + c] = s;
        }
}

void jo_joint_setup(const jo_model *m, jo_data *d, int set)
{
    for (int i = 0; i < m->npair; i++) pair_gram(m, d, i, set);
}

/* kernel for a block of `rows` rows and n columns: common sizes are compile-time constants, rows mostly padded */
static int kind_of(int rows, int n)
{
    if (rows <= 4) return n == 3 ? 0 : 5;
    if (rows == 5 && n == 5) return 4;
    return n == 3 ? 1 : n == 5 ? 2 : n == 6 ? 3 : 5;
}
#define JO_BY_KIND(kind, rows, n, call) \
    switch (kind) {                     \
    case 0: call(4, 3); break;          \
    case 1: call(8, 3); break;          \
    case 2: call(8, 5); break;          \
    case 3: call(8, 6); break;          \
    case 4: call(5, 5); break;          \
    default: call(rows, n); break;      \
    }

/* whether row l is the only one in its vector (the fifth row), which is then processed along its columns */
static inline int is_single_row(const int rows, const int l) { return JO_WIDTH > 1 && rows - l == 1; }

/* address of the flag whether a joint is active; 0 if it is always active */
static const int *lock_of(const jo_model *m, const jo_data *d, int joint)
{
    if (m->joint[joint].release >= 0) return &d->joint[joint].maximal.present;
    return m->joint[joint].lock < 0 ? 0 : d->locked + m->joint[joint].lock;
}

static inline int is_switched_off(const int *lock) { return lock && !*lock; }

/* bodies, markers, factors and tangent operators of all joint sides */
static void plan_sides(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->njoint; i++)
        for (int s = 0; s < m->joint[i].nside; s++) {
            jo_side_work *w = &d->joint[i].maximal.side[s];
            const jo_marker *k = &m->marker[m->joint[i].side[s]];
            w->marker = &d->marker[m->joint[i].side[s]];
            w->body = k->body < 0 ? 0 : &d->body[k->body];
            w->L = k->body < 0 || !(m->body[k->body].n || w->body->maximal.carried) ? 0 : w->body->maximal.L;
            w->T = k->Psi ? w->marker->T : 0;
        }
}

/* blocks and sides of the pairs; first: whether the pair is the first to write its block. S[0] remains 1 in blocks without a pair */
static void plan_pairs(const jo_model *m, jo_data *d)
{
    for (int b = 0; b < m->nblock; b++) d->schur.S[JO_BLOCK * b] = jo_same(1.0);
    for (int i = 0; i < m->npair; i++) {
        const jo_pair *p = &m->pair[i];
        jo_pair_plan *w = &d->schur.pairs[i];
        w->S = d->schur.S + JO_BLOCK * p->block;
        w->k = &d->joint[p->joint_k].maximal.side[p->side_k];
        w->l = &d->joint[p->joint_l].maximal.side[p->side_l];
        w->flexible = m->body[m->marker[m->joint[p->joint_k].side[p->side_k]].body].n > 0;
        w->kind = kind_of(m->joint[p->joint_k].nrow, m->joint[p->joint_l].nrow);
        w->first = JO_COMMON(w->S[0]) != 0.0;
        w->lock_k = lock_of(m, d, p->joint_k);
        w->lock_l = lock_of(m, d, p->joint_l);
        w->S[0] = jo_same(0.0);
    }
}

/* blocks below the diagonal of a column; those without a pair are fill-in */
static void plan_below(const jo_model *m, jo_data *d, const jo_column *col)
{
    for (int i = col->first; i < col->first + col->count; i++) {
        const int row = m->below[i].joint;
        jo_below_plan *x = &d->schur.belows[i];
        x->X = d->schur.S + JO_BLOCK * m->below[i].block;
        x->x = d->joint[row].x;
        x->rows = m->joint[row].nrow;
        x->kind = kind_of(x->rows, m->joint[col->joint].nrow);
        x->lock = lock_of(m, d, row);
        if (JO_COMMON(x->X[0]) != 0.0) d->schur.fills[d->schur.nfill++] = x->X;
    }
}

/* update T -= X D^-1 Y^T of a later block by the elimination of a column */
static void plan_update(const jo_model *m, jo_data *d, const jo_column *col, int u)
{
    const jo_update *up = &m->update[u];
    const int n = m->joint[col->joint].nrow;
    jo_update_plan *x = &d->schur.updates[u];
    x->T = d->schur.S + JO_BLOCK * up->target;
    x->X = d->schur.S + JO_BLOCK * up->left;
    x->Y = d->schur.S + JO_BLOCK * up->right;
    x->rows = up->left_rows;
    x->ny = up->right_rows;
    x->kind = up->right_rows == n ? kind_of(x->rows, n) : 5;
    for (int i = col->first; i < col->first + col->count; i++) {
        if (m->below[i].block == up->left) x->lock_x = d->schur.belows[i].lock;
        if (m->below[i].block == up->right) x->lock_y = d->schur.belows[i].lock;
    }
}

/* hybrid mode: the joints of trees have the first columns and the last pairs */
static void plan_hybrid(const jo_model *m, jo_data *d)
{
    jo_schur *s = &d->schur;
    while (s->first_column < m->ncolumn && jo_joint_in_tree(d, m->column[s->first_column].joint)) s->first_column++;
    while (s->npair < m->npair && !jo_joint_in_tree(d, m->pair[s->npair].joint_k) && !jo_joint_in_tree(d, m->pair[s->npair].joint_l))
        s->npair++;
}

/* plan of assembly and factorisation */
void jo_joint_plan(const jo_model *m, jo_data *d)
{
    if (jo_mixed(m)) plan_hybrid(m, d);
    plan_sides(m, d);
    plan_pairs(m, d);
    jo_hub_plan(m, d);
    for (int c = 0; c < m->ncolumn; c++) {
        if (c == d->schur.first_column) d->schur.first_fill = d->schur.nfill;
        const jo_column *col = &m->column[c];
        jo_joint_work *joint = &d->joint[col->joint];
        jo_column_plan *w = &d->schur.columns[c];
        w->S = d->schur.S + JO_BLOCK * c;
        w->x = joint->x;
        w->scale = joint->maximal.scale;
        w->sign = col->joint < m->njoint ? 1.0 : -1.0;
        w->n = m->joint[col->joint].nrow;
        w->first = col->first;
        w->count = col->count;
        w->update = m->update_first[c];
        w->updates = m->update_first[c + 1] - w->update;
        w->lock = lock_of(m, d, col->joint);
        if (JO_COMMON(w->S[0]) != 0.0) d->schur.fills[d->schur.nfill++] = w->S;   /* no pair, since all sides are on ground */
        plan_below(m, d, col);
        for (int u = w->update; u < w->update + w->updates; u++) plan_update(m, d, col, u);
    }
}

/* Blocks are stored by columns, S[ld s + r], with rows r of the joint that is eliminated later. The kernels process four rows at a time
 * with the number of columns as a constant, so that loops unroll. */

/* four rows of S = V_k^T V_l if `first`, else S += V_k^T V_l */
static inline void add_rows(jo_real *restrict S, const int ld, const jo_real *restrict Vk, const jo_real *restrict Vl,
                            const int ldl, const int n, const int first)
{
    for (int l = 0; l < 4; l += JO_WIDTH) {
        jo_lanes v[6];
        for (int c = 0; c < 6; c++) v[c] = JO_LOAD(Vk + c * ld + l);
        for (int s = 0; s < n; s++) {
            jo_lanes x = Vl[s] * v[0];
            if (!first) x += JO_LOAD(S + ld * s + l);
            for (int c = 1; c < 6; c++) x += Vl[c * ldl + s] * v[c];
            JO_STORE(S + ld * s + l) = x;
        }
    }
}

/* y = M x, M (ld x n), x with stride `step` */
static inline void multiply(jo_real *restrict y, const jo_real *restrict M, const int ld, const int n,
                            const jo_real *restrict x, const int step)
{
    for (int l = 0; l < ld; l += JO_WIDTH) {
        jo_lanes s = JO_LOAD(M + l) * x[0];
        for (int j = 1; j < n; j++) s += JO_LOAD(M + ld * j + l) * x[step * j];
        JO_STORE(y + l) = s;
    }
}

/* S = V_k^T V_l if `first`, else S += V_k^T V_l */
static inline void add_product(jo_real *restrict S, const int rows, const jo_real *restrict Vk, const jo_real *restrict Vl,
                               const int n, const int first)
{
    const int ld = jo_padded(rows), ldl = jo_padded(n);
    int r = 0;
    for (; r < rows && !is_single_row(rows, r); r += 4) add_rows(S + r, ld, Vk + r, Vl, ldl, n, first);
    if (r < rows) {
        jo_real row[8];
        multiply(row, Vl, ldl, 6, Vk + r, ld);
        for (int s = 0; s < n; s++) S[ld * s + r] = first ? row[s] : S[ld * s + r] + row[s];
    }
}

/* four rows of S += C_k gram C_l^T. Rows of k depend on the coordinates from .. to - 1; the first `moving` rows of l on translations, the
 * others on rotations, or all rows on both if `both` */
static inline void add_gram_rows(jo_real *restrict S, const int ld, const jo_real *restrict Ck, const int from, const int to,
                                 const jo_real *restrict Cl, const int ldl, const int n, const int moving, const int both,
                                 const jo_real *restrict gram)
{
    const int last = n > moving || both ? 6 : 3;
    for (int l = 0; l < 4; l += JO_WIDTH) {
        jo_lanes g[6];
        for (int j = 0; j < last; j++) {
            const jo_lanes zero = {0};
            g[j] = zero;
            for (int a = from; a < to; a++) g[j] += gram[6 * a + j] * JO_LOAD(Ck + ld * a + l);
        }
        for (int s = 0; s < n; s++) {
            jo_lanes x = JO_LOAD(S + ld * s + l);
            if (s < moving || both)
                for (int j = 0; j < 3; j++) x += Cl[ldl * j + s] * g[j];
            if (s >= moving || both)
                for (int j = 3; j < 6; j++) x += Cl[ldl * j + s] * g[j];
            JO_STORE(S + ld * s + l) = x;
        }
    }
}

/* S += C_k gram C_l^T with the zero blocks of C left out */
static void add_gram(jo_real *S, const jo_joint *k, const jo_real *Ck, const jo_joint *l, const jo_real *Cl, const jo_real *gram)
{
    const int ld = jo_padded(k->nrow), ldl = jo_padded(l->nrow), n = l->nrow;
    if (k->nrow == 3 && k->coincident && n == 3 && l->coincident) {
        add_gram_rows(S, 4, Ck, 0, 3, Cl, 4, 3, 3, 0, gram);
        return;
    }
    if (k->nrow == 5 && k->coincident && !k->nline && n == 5 && l->coincident && !l->nline) {
        add_gram_rows(S, 8, Ck, 0, 6, Cl, 8, 5, 3, 0, gram);
        add_gram_rows(S + 4, 8, Ck + 4, 3, 6, Cl, 8, 5, 3, 0, gram);
        return;
    }
    const int moving = l->coincident ? 3 : 0, both = l->nline > 0;
    for (int r = 0; r < ld; r += 4) add_gram_rows(S + r, ld, Ck + r, 0, 6, Cl, ldl, n, moving, both, gram);
}

/* S = L D L^T of a diagonal block in place: unit lower triangle L, diagonal D^-1, D of the given sign. Returns 1; 0: pivot below
 * JO_SINGULAR_PIVOT times the diagonal before elimination, that is, a dependent row; -1: not finite */
static inline int factor_diagonal(jo_real *restrict S, const int n, const jo_real *scale, const double sign)
{
    const int ld = jo_padded(n);
    int regular = 1;
    for (int k = 0; k < n; k++) {
        jo_real *column = S + ld * k;
        jo_real x = column[k];
        if (jo_spoil(&x, JO_LESS(JO_SINGULAR_PIVOT * sign * scale[k], sign * x)) && regular == 1) regular = isfinite(jo_most(x)) ? 0 : -1;
        const jo_real inverse = 1.0 / x;
        for (int j = k + 1; j < n; j++) {
            const jo_real y = column[j] * inverse;
            for (int i = j; i < n; i++) S[ld * j + i] -= column[i] * y;
        }
        for (int j = k + 1; j < n; j++) column[j] *= inverse;
        column[k] = inverse;
    }
    return regular;
}

/* X = X D^-1 L^-1 after the updates: shortens the dependency chain of the solution */
static inline void multiply_inverse(jo_real *restrict X, const int ld, const jo_real *restrict L, const int n)
{
    const int ldl = jo_padded(n);
    for (int l = 0; l < ld; l += JO_WIDTH) {
        jo_lanes x[6];
        for (int j = n - 1; j >= 0; j--) {
            x[j] = L[(ldl + 1) * j] * JO_LOAD(X + ld * j + l);
            for (int k = j + 1; k < n; k++) x[j] -= L[ldl * j + k] * x[k];
            JO_STORE(X + ld * j + l) = x[j];
        }
    }
}

/* X = X L^-T, ld rows */
static inline void divide_by_factor(jo_real *restrict X, const int ld, const jo_real *restrict L, const int n)
{
    const int ldl = jo_padded(n);
    for (int l = 0; l < ld; l += JO_WIDTH) {
        jo_lanes x[6];
        for (int j = 0; j < n; j++) {
            x[j] = JO_LOAD(X + ld * j + l);
            for (int k = 0; k < j; k++) x[j] -= L[ldl * k + j] * x[k];
            JO_STORE(X + ld * j + l) = x[j];
        }
    }
}

/* T -= X D^-1 Y^T over n columns, ny rows of Y */
static inline void subtract_product(jo_real *restrict T, const jo_real *restrict X, const int rows,
                                    const jo_real *restrict Y, const int ny, const jo_real *restrict D, const int n)
{
    const int ld = jo_padded(rows), ldy = jo_padded(ny), step = jo_padded(n) + 1;
    int l = 0;
    for (; l < rows && !is_single_row(rows, l); l += JO_WIDTH) {
        jo_lanes x[6];
        for (int j = 0; j < n; j++) x[j] = D[step * j] * JO_LOAD(X + ld * j + l);
        for (int s = 0; s < ny; s++) {
            jo_lanes t = JO_LOAD(T + ld * s + l);
            for (int j = 0; j < n; j++) t -= Y[ldy * j + s] * x[j];
            JO_STORE(T + ld * s + l) = t;
        }
    }
    if (l < rows) {
        jo_real x[6] = {0}, row[8];
        for (int j = 0; j < n; j++) x[j] = D[step * j] * X[ld * j + l];
        multiply(row, Y, ldy, n, x, 1);
        for (int s = 0; s < ny; s++) T[ld * s + l] -= row[s];
    }
}

/* hybrid mode skips the columns of joints in trees, which come first */
static int first_column(const jo_data *d) { return jo_in_hybrid(d) ? d->schur.first_column : 0; }

/* S of all active joints; fill-in blocks and blocks of inactive joints are 0 */
static void assemble(const jo_model *m, jo_data *d, int set)
{
    const int npair = jo_in_hybrid(d) ? d->schur.npair : m->npair;
    for (int i = 0; i < npair; i++) {
        const jo_pair_plan *p = &d->schur.pairs[i];
        if (is_switched_off(p->lock_k) || is_switched_off(p->lock_l)) {
            for (int j = 0; j < JO_BLOCK && p->first; j++) p->S[j] = jo_same(0.0);
            continue;
        }
        const jo_joint *k = &m->joint[m->pair[i].joint_k], *l = &m->joint[m->pair[i].joint_l];
#define FIRST(rows, n) add_product(p->S, rows, p->k->V, p->l->V, n, 1)
#define CALL(rows, n) add_product(p->S, rows, p->k->V, p->l->V, n, 0)
        if (p->first) JO_BY_KIND(p->kind, k->nrow, l->nrow, FIRST)
        else JO_BY_KIND(p->kind, k->nrow, l->nrow, CALL)
#undef CALL
#undef FIRST
        if (!p->flexible) continue;
        if (m->marker[k->side[m->pair[i].side_k]].chi) pair_gram(m, d, i, set);
        add_gram(p->S, k, p->k->C, l, p->l->C, d->schur.gram[set] + 36 * i);
    }
    jo_hub_assemble(m, d);
    for (int i = jo_in_hybrid(d) ? d->schur.first_fill : 0; i < d->schur.nfill; i++)
        for (int j = 0; j < JO_BLOCK; j++) d->schur.fills[i][j] = jo_same(0.0);
}

/* sqrt(smallest / largest moment of inertia) of the bodies of a joint. The rotation of a slender body about its axis dominates the diagonal
 * of S; if another joint prevents this rotation, the pivot is smaller by about the ratio of the moments. The root of this ratio is the
 * geometric mean of the ratio and 1. */
static double slenderness(const jo_model *m, const jo_data *d, const jo_joint *joint)
{
    double least = 1.0;
    for (int i = 0; i < joint->nside; i++) {
        const int body = m->marker[joint->side[i]].body;
        if (body < 0) continue;
        const jo_real *J = d->body[body].J;
        const double x = jo_most(J[0]), y = jo_most(J[1]), z = jo_most(J[2]);
        const double low = x < y ? (x < z ? x : z) : (y < z ? y : z), high = jo_larger(jo_larger(x, y), z);
        if (low > 0.0 && low < least * high) least = low / high;
    }
    return sqrt(least);
}

/* S += eps diag(S), which makes S regular; copy of S in S0 for the refinement */
static void regularise(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < JO_BLOCK * m->nblock; i++) d->schur.S0[i] = d->schur.S[i];
    for (int c = first_column(d); c < m->ncolumn; c++) {
        const jo_joint *joint = &m->joint[m->column[c].joint];
        const int step = jo_padded(joint->nrow) + 1;
        const double share = slenderness(m, d, joint);
        for (int r = 0; r < joint->nrow; r++) {
            d->schur.columns[c].scale[r] *= share;
            d->schur.S[JO_BLOCK * c + step * r] += JO_SCHUR_REGULARISATION * jo_friction_softness(m, d, m->column[c].joint, d->schur.columns[c].scale[r]);
        }
    }
}

/* block factorisation in the fixed elimination order, column by column: diagonal block, blocks below it, updates of later blocks */
static int factor(const jo_model *m, jo_data *d, int set)
{
    assemble(m, d, set);
    for (int c = first_column(d); c < m->ncolumn; c++) {
        jo_column_plan *w = &d->schur.columns[c];
        const int n = w->n, step = jo_padded(n) + 1;
        if (is_switched_off(w->lock)) continue;
        for (int r = 0; r < n; r++) w->scale[r] = w->S[step * r];
    }
    /* scale of a row: its diagonal entry before elimination */
    jo_hub_scales(m, d);
    if (jo_schur_soft(d)) regularise(m, d);
    for (int c = first_column(d); c < m->ncolumn; c++) {
        const jo_column_plan *w = &d->schur.columns[c];
        int regular;
        if (is_switched_off(w->lock)) continue;
#define CALL(n) regular = factor_diagonal(w->S, n, w->scale, w->sign)
        JO_BY_ROWS(w->n, CALL)
#undef CALL
        if (regular != 1) {
            const int joint = m->column[c].joint;
            const jo_joint *k = &m->joint[joint];
            const int body = m->marker[k->side[1]].body;
            d->error_index = regular == 0 ? joint : body < 0 ? m->marker[k->side[0]].body : body;
            return regular == 0 ? JO_SINGULAR_JOINT : JO_NOT_FINITE;
        }
        /* L_ik = S_ik L_kk^-T */
        for (int i = w->first; i < w->first + w->count; i++) {
            const jo_below_plan *x = &d->schur.belows[i];
            if (is_switched_off(x->lock)) continue;
#define CALL(rows, n) divide_by_factor(x->X, jo_padded(rows), w->S, n)
            JO_BY_KIND(x->kind, x->rows, w->n, CALL)
#undef CALL
        }
        /* S_ij -= L_ik D_k^-1 L_jk^T */
        for (int i = w->update; i < w->update + w->updates; i++) {
            const jo_update_plan *u = &d->schur.updates[i];
            if (is_switched_off(u->lock_x) || is_switched_off(u->lock_y)) continue;
            if (u->kind == 5) {
                subtract_product(u->T, u->X, u->rows, u->Y, u->ny, w->S, w->n);
            } else {
#define CALL(rows, n) subtract_product(u->T, u->X, rows, u->Y, n, w->S, n)
                JO_BY_KIND(u->kind, u->rows, w->n, CALL)
#undef CALL
            }
        }
        for (int i = w->first; i < w->first + w->count; i++) {
            const jo_below_plan *x = &d->schur.belows[i];
            if (is_switched_off(x->lock)) continue;
#define CALL(rows, n) multiply_inverse(x->X, jo_padded(rows), w->S, n)
            JO_BY_KIND(x->kind, x->rows, w->n, CALL)
#undef CALL
        }
    }
    return JO_OK;
}

/* factors of S; in a singular position of a model without redundant rows S is regularised, and the position is counted */
int jo_joint_factor(const jo_model *m, jo_data *d, int set)
{
    jo_schur_softened(d, m->redundant > 0);
    int status = factor(m, d, set);
    if (status == JO_SINGULAR_JOINT && m->redundant == 0) {
        d->counts.singular++;
        jo_schur_softened(d, 1);
        status = factor(m, d, set);
    }
    return status;
}

/* x = L^-T D^-1 L^-1 x */
static inline void solve_diagonal(const jo_real *restrict L, jo_real *restrict x, const int n)
{
    const int ld = jo_padded(n);
    jo_real y[6];
    for (int i = 0; i < n; i++) y[i] = x[i];
    for (int k = 0; k < n; k++)
        for (int i = k + 1; i < n; i++) y[i] -= L[ld * k + i] * y[k];
    for (int i = 0; i < n; i++) y[i] *= L[(ld + 1) * i];
    for (int i = n - 1; i >= 0; i--)
        for (int k = 0; k < i; k++) y[k] -= L[ld * k + i] * y[i];
    for (int i = 0; i < n; i++) x[i] = y[i];
}

/* y -= X x, padded */
static inline void subtract_left(jo_real *restrict y, const jo_real *restrict X, const jo_real *restrict x,
                                 const int ld, const int n)
{
    for (int l = 0; l < ld; l += JO_WIDTH) {
        jo_lanes s = JO_LOAD(y + l);
        for (int k = 0; k < n; k++) s -= x[k] * JO_LOAD(X + ld * k + l);
        JO_STORE(y + l) = s;
    }
}

/* x -= X^T y */
static inline void subtract_right(jo_real *restrict x, const jo_real *restrict X, const jo_real *restrict y,
                                  const int rows, const int n)
{
    const int ld = jo_padded(rows);
    for (int k = 0; k < n; k++) {
        jo_real s = x[k];
        for (int r = 0; r < rows; r++) s -= X[ld * k + r] * y[r];
        x[k] = s;
    }
}

/* x = S^-1 x for all joints: forward elimination, diagonal blocks, back substitution */
static void solve_factored(const jo_model *m, jo_data *d)
{
    for (int c = first_column(d); c < m->ncolumn; c++) {
        const jo_column_plan *w = &d->schur.columns[c];
        if (is_switched_off(w->lock)) continue;
        for (int i = w->first; i < w->first + w->count; i++) {
            const jo_below_plan *x = &d->schur.belows[i];
            if (is_switched_off(x->lock)) continue;
#define CALL(rows, n) subtract_left(x->x, x->X, w->x, jo_padded(rows), n)
            JO_BY_KIND(x->kind, x->rows, w->n, CALL)
#undef CALL
        }
#define CALL(n) solve_diagonal(w->S, w->x, n)
        JO_BY_ROWS(w->n, CALL)
#undef CALL
    }
    for (int c = m->ncolumn - 1; c >= first_column(d); c--) {
        const jo_column_plan *w = &d->schur.columns[c];
        if (is_switched_off(w->lock)) continue;
        for (int i = w->first; i < w->first + w->count; i++) {
            const jo_below_plan *x = &d->schur.belows[i];
            if (is_switched_off(x->lock)) continue;
            if (x->rows == w->n) {
#define CALL(n) subtract_right(w->x, x->X, x->x, n, n)
                JO_BY_ROWS(w->n, CALL)
#undef CALL
            } else {
                subtract_right(w->x, x->X, x->x, x->rows, w->n);
            }
        }
    }
}

/* x = right - S0 sum: residual for the refinement */
static void residual(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->njoint + m->nhub; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) d->joint[i].x[r] = d->joint[i].maximal.right[r];
    for (int c = first_column(d); c < m->ncolumn; c++) {
        const jo_column *col = &m->column[c];
        jo_joint_work *w = &d->joint[col->joint];
        const int n = m->joint[col->joint].nrow, own = jo_padded(n);
        for (int i = 0; i < n; i++)   /* product with S from its lower triangle */
            for (int j = 0; j < n; j++)
                w->x[i] -= d->schur.S0[JO_BLOCK * c + (j <= i ? own * j + i : own * i + j)] * w->maximal.sum[j];
        for (int i = col->first; i < col->first + col->count; i++) {
            const jo_real *X = d->schur.S0 + JO_BLOCK * m->below[i].block;
            jo_joint_work *v = &d->joint[m->below[i].joint];
            const int rows = m->joint[m->below[i].joint].nrow;
            subtract_left(v->x, X, w->maximal.sum, jo_padded(rows), n);
            subtract_right(w->x, X, v->maximal.sum, rows, n);
        }
    }
}

/* x = S^-1 x for all joints. With redundant rows, whose right-hand sides are consistent, iterative refinement with the regularised factors
 * converges to the solution of least norm in the scale of the diagonal. */
void jo_joint_solve(const jo_model *m, jo_data *d)
{
    for (int h = 0; h < m->nhub; h++)   /* no forces on the hubs other than those of joints */
        for (int r = 0; r < 6; r++) d->joint[m->njoint + h].x[r] = jo_same(0.0);
    if (!jo_schur_soft(d)) {
        solve_factored(m, d);
        return;
    }
    for (int i = 0; i < m->njoint + m->nhub; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) {
            d->joint[i].maximal.right[r] = d->joint[i].x[r];
            d->joint[i].maximal.sum[r] = jo_same(0.0);
        }
    for (int k = 0; k <= JO_REFINEMENTS; k++) {
        if (k) residual(m, d);
        solve_factored(m, d);
        for (int i = 0; i < m->njoint + m->nhub; i++)
            for (int r = 0; r < m->joint[i].nrow; r++) d->joint[i].maximal.sum[r] += d->joint[i].x[r];
    }
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) d->joint[i].x[r] = d->joint[i].maximal.sum[r];
}
