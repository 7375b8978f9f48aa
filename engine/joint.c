/* joint.c - constraint rows between markers, the block matrix S = Cq M^-1 Cq^T and its factor.
 *
 * Rows (Rantalainen 2007, eq. 3.90-3.96): r_b - r_a = 0, (axis of a) . (axis of b) = 0 and lines, relations
 * sum f_i s_i - offset - signal(t) = 0 of coordinates, whose right-hand side may depend on time (eq. 3.84-3.89).
 * Multipliers: M a + Cq^T lam = Q, so the joint acts with -Cq^T lam on the bodies.
 */
#include "internal.h"

#define JO_REGULAR 1e-9    /* added to the diagonal of S, relative, where rows repeat one another */
enum { JO_REFINE = 2 };    /* steps of refinement, each closing what the addition left open */

static void axis(jo_real *x, const jo_real *A, int i) { x[0] = A[i]; x[1] = A[3 + i]; x[2] = A[6 + i]; }

/* whether the rows of an optional joint are switched off */
static int absent(const jo_data *d, const jo_joint *k) { return k->lock >= 0 && !d->locked[k->lock]; }

static int first_line(const jo_joint *k) { return (k->coincident ? 3 : 0) + k->nperp; }

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

static void clear(jo_real *x, int count)
{
    for (int i = 0; i < count; i++) x[i] = 0.0;
}

static double largest(const jo_real *c, int count)
{
    double x = 0.0;
    for (int r = 0; r < count; r++) {
        const double y = fabs(JO_RE(c[r]));
        if (!(y <= x)) x = y;   /* a NaN stays */
    }
    return x;
}

double jo_joint_residual(const jo_model *m, jo_data *d)
{
    double worst = 0.0;
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        const jo_marker_work *a = &d->marker[k->side[0]], *b = &d->marker[k->side[1]];
        jo_real *c = d->joint[i].c, x[3], y[3];
        if (k->coincident) {
            jo_set3(c, b->r);
            jo_sub3(c, a->r);
            c += 3;
        }
        for (int r = 0; r < k->nperp; r++) {
            axis(x, a->A, k->perp_a[r]);
            axis(y, b->A, k->perp_b[r]);
            c[r] = jo_dot3(x, y);
        }
        for (int l = 0; l < k->nline; l++) {
            const jo_line *line = &m->line[k->line + l];
            jo_real value = -line->data[0];
            for (int j = 0; j < line->count; j++) value += line->data[1 + j] * d->coordinate[line->coordinate[j]].value;
            if (line->signal >= 0) value -= jo_signal_at(m, d, line->signal, d->time[0]).value;
            c[k->nperp + l] = value;
        }
        if (absent(d, k)) clear(d->joint[i].c, k->nrow);
        const double gap = largest(d->joint[i].c, k->nrow);
        if (!(gap <= worst)) worst = gap;
    }
    return worst;
}

double jo_joint_residual_rate(const jo_model *m, jo_data *d)
{
    double worst = 0.0;
    if (m->nline) jo_coordinates_rate(m, d, m->ncoordinate);
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        const jo_marker_work *a = &d->marker[k->side[0]], *b = &d->marker[k->side[1]];
        jo_real *c = d->joint[i].cdot, x[3], y[3], s[3];
        if (k->coincident) {
            jo_to_world(x, m, d, k->side[0], a->v);
            jo_to_world(c, m, d, k->side[1], b->v);
            jo_sub3(c, x);
            c += 3;
        }
        jo_real rel[3] = {0};
        if (k->nperp) {
            jo_to_world(rel, m, d, k->side[0], a->om);
            jo_to_world(y, m, d, k->side[1], b->om);
            jo_sub3(rel, y);
        }
        for (int r = 0; r < k->nperp; r++) {   /* (om_a - om_b) . (x_a x y_b) */
            axis(x, a->A, k->perp_a[r]);
            axis(y, b->A, k->perp_b[r]);
            jo_cross(s, x, y);
            c[r] = jo_dot3(rel, s);
        }
        for (int l = 0; l < k->nline; l++) {   /* Cq v + C_t */
            const jo_line *line = &m->line[k->line + l];
            jo_real rate = 0.0;
            for (int j = 0; j < line->count; j++) rate += line->data[1 + j] * d->coordinate[line->coordinate[j]].rate;
            if (line->signal >= 0) rate -= jo_signal_at(m, d, line->signal, d->time[0]).rate;
            c[k->nperp + l] = rate;
        }
        if (absent(d, k)) clear(d->joint[i].cdot, k->nrow);
        const double rate = largest(d->joint[i].cdot, k->nrow);
        if (!(rate <= worst)) worst = rate;
    }
    return worst;
}

/* The work on small blocks is compiled for the row counts that occur, so that loops unroll. */
#define JO_BY_ROWS(n, call)        \
    switch (n) {                   \
    case 3: call(3); break;        \
    case 5: call(5); break;        \
    case 6: call(6); break;        \
    default: call(n); break;       \
    }

/* V = L^-1 V for n columns */
static inline void forward(const jo_real *restrict L, jo_real *restrict V, const int n)
{
    for (int i = 0; i < 6; i++)
        for (int r = 0; r < n; r++) {
            jo_real x = V[6 * i + r];
            for (int k = 0; k < i; k++) x -= L[6 * i + k] * V[6 * k + r];
            V[6 * i + r] = x * L[7 * i];
        }
}

/* the rows of lines on one side, which see translations and rotations */
static void line_rows(const jo_model *m, jo_data *d, const jo_joint *k, jo_joint_work *w, int side)
{
    const int marker = k->side[side];
    const jo_marker_work *mw = &d->marker[marker];
    const jo_real *A = d->body[m->marker[marker].body].A;
    const int first = first_line(k);
    for (int l = 0; l < k->nline; l++) {
        const jo_line *line = &m->line[k->line + l];
        const int r = first + l;
        jo_real *C = w->C[side] + 6 * r, f[3] = {0.0, 0.0, 0.0}, g[3] = {0.0, 0.0, 0.0}, t[3];
        for (int j = 0; j < line->count; j++) {
            const jo_coordinate_work *s = &d->coordinate[line->coordinate[j]];
            const jo_real factor = line->data[1 + j];
            if (side == line->side[j]) {
                jo_axpy3(f, -factor, s->along);
                jo_axpy3(g, factor, s->turn_a);
            } else if (side == line->side[j] + 1) {
                jo_axpy3(f, factor, s->along);
                jo_axpy3(g, factor, s->turn_b);
            }
        }
        jo_mul3t(C, A, f);
        jo_mul3t(t, A, g);
        if (m->marker[marker].Psi) jo_mul3t(C + 3, mw->T, t);
        else jo_set3(C + 3, t);
        const jo_real *X = mw->Xt, *Y = mw->Xr;
        for (int j = 0; j < 6; j++)
            w->V[side][6 * j + r] = C[0] * X[j] + C[1] * X[6 + j] + C[2] * X[12 + j]
                                    + t[0] * Y[j] + t[1] * Y[6 + j] + t[2] * Y[12 + j];
    }
}

/* rows C of both sides in body coordinates, V = L^-1 (reduced rows)^T */
void jo_joint_rows(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        jo_joint_work *w = &d->joint[i];
        for (int r = 0; r < k->nperp; r++) {
            jo_real x[3], y[3];
            axis(x, d->marker[k->side[0]].A, k->perp_a[r]);
            axis(y, d->marker[k->side[1]].A, k->perp_b[r]);
            jo_cross(w->axes[r], x, y);
        }
        for (int side = 0; side < k->nside; side++) {
            const int marker = k->side[side];
            const int body = m->marker[marker].body;
            if (body < 0) continue;
            const jo_marker_work *mw = &d->marker[marker];
            const jo_real sign = side ? 1.0 : -1.0, *A = d->body[body].A;
            jo_real *C = w->C[side], *V = w->V[side];
            int first = 0;
            if (absent(d, k)) {
                clear(C, 36);
                clear(V, 36);
                continue;
            }
            if (k->coincident) {
                const jo_real *X = mw->Xt;
                for (int r = 0; r < 3; r++) {
                    const jo_real c0 = sign * A[3 * r], c1 = sign * A[3 * r + 1], c2 = sign * A[3 * r + 2];
                    C[6 * r] = c0; C[6 * r + 1] = c1; C[6 * r + 2] = c2;
                    C[6 * r + 3] = C[6 * r + 4] = C[6 * r + 5] = 0.0;
                    for (int j = 0; j < 6; j++) V[6 * j + r] = c0 * X[j] + c1 * X[6 + j] + c2 * X[12 + j];
                }
                first = 3;
            }
            for (int r = first; r < first + k->nperp; r++) {
                const jo_real *X = mw->Xr;
                jo_real t[3];
                jo_mul3t(t, A, w->axes[r - first]);
                for (int j = 0; j < 3; j++) t[j] *= -sign;
                C[6 * r] = C[6 * r + 1] = C[6 * r + 2] = 0.0;
                if (m->marker[marker].Psi) jo_mul3t(C + 6 * r + 3, mw->T, t);
                else jo_set3(C + 6 * r + 3, t);
                for (int j = 0; j < 6; j++) V[6 * j + r] = t[0] * X[j] + t[1] * X[6 + j] + t[2] * X[12 + j];
            }
            if (k->nline) line_rows(m, d, k, w, side);
#define CALL(n) forward(d->body[body].L, V, n)
            JO_BY_ROWS(k->nrow, CALL)
#undef CALL
        }
    }
}

/* x += V^T z, six rows */
static inline void add_columns(jo_real *restrict x, const jo_real *restrict V, const jo_real *restrict z, const int n)
{
    for (int r = 0; r < n; r++) {
        jo_real s = x[r];
        for (int c = 0; c < 6; c++) s += V[6 * c + r] * z[c];
        x[r] = s;
    }
}

/* second derivatives of the lines while R'' = w' = 0, minus those of their signals */
static void line_acceleration(const jo_model *m, const jo_data *d, const jo_joint *k, jo_real *x)
{
    for (int l = 0; l < k->nline; l++) {
        const jo_line *line = &m->line[k->line + l];
        x[l] = 0.0;
        for (int j = 0; j < line->count; j++) {
            const jo_coordinate *c = &m->coordinate[line->coordinate[j]];
            const jo_coordinate_work *s = &d->coordinate[line->coordinate[j]];
            const jo_marker_work *a = &d->marker[c->a], *b = &d->marker[c->b];
            jo_real aa[3], ab[3], ta[3], tb[3];
            jo_to_world(aa, m, d, c->a, a->a);
            jo_to_world(ab, m, d, c->b, b->a);
            jo_to_world(ta, m, d, c->a, a->a + 3);
            jo_to_world(tb, m, d, c->b, b->a + 3);
            jo_sub3(ab, aa);
            x[l] += line->data[1 + j] * (jo_dot3(s->along, ab) + jo_dot3(s->turn_a, ta) + jo_dot3(s->turn_b, tb) + s->bias);
        }
        /* the matrix of ROS2 knows the time derivative of the right-hand side as that of the forces */
        if (line->signal >= 0) x[l] -= jo_signal_at(m, d, line->signal, d->time[0] + d->lead).second;
    }
}

/* rate of the work of the drives, -lam signal' */
jo_real jo_joint_power(const jo_model *m, const jo_data *d)
{
    jo_real power = 0.0;
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        for (int l = 0; l < k->nline; l++) {
            const jo_line *line = &m->line[k->line + l];
            if (line->signal >= 0)
                power -= d->joint[i].x[first_line(k) + l] * jo_signal_at(m, d, line->signal, d->time[0]).rate;
        }
    }
    return power;
}

/* right-hand side x = Cq a_free + (Cq)' v, plus Baumgarte terms if asked for */
void jo_joint_acceleration(const jo_model *m, jo_data *d, const jo_solver *solver)
{
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        const jo_marker_work *a = &d->marker[k->side[0]], *b = &d->marker[k->side[1]];
        jo_joint_work *w = &d->joint[i];
        jo_real *x = w->x;
        if (absent(d, k)) {
            clear(x, k->nrow);
            continue;
        }
        if (k->coincident) {
            jo_real t[3];
            jo_to_world(t, m, d, k->side[0], a->a);
            jo_to_world(x, m, d, k->side[1], b->a);
            jo_sub3(x, t);
            x += 3;
        }
        if (k->nperp) {
            jo_real oma[3], omb[3], aa[3], ab[3];
            jo_to_world(oma, m, d, k->side[0], a->om);
            jo_to_world(omb, m, d, k->side[1], b->om);
            jo_to_world(aa, m, d, k->side[0], a->a + 3);
            jo_to_world(ab, m, d, k->side[1], b->a + 3);
            jo_sub3(aa, ab);
            for (int r = 0; r < k->nperp; r++) {
                jo_real f[3], h[3], fd[3], hd[3], fdd[3], hdd[3];
                axis(f, a->A, k->perp_a[r]);
                axis(h, b->A, k->perp_b[r]);
                jo_cross(fd, oma, f);
                jo_cross(hd, omb, h);
                jo_cross(fdd, oma, fd);
                jo_cross(hdd, omb, hd);
                x[r] = jo_dot3(aa, w->axes[r]) + jo_dot3(fdd, h) + 2.0 * jo_dot3(fd, hd) + jo_dot3(f, hdd);
            }
        }
        if (k->nline) line_acceleration(m, d, k, x + k->nperp);
        for (int side = 0; side < k->nside; side++) {   /* rigid coordinates: C X Z^-1 z = V^T z */
            const int body = m->marker[k->side[side]].body;
            if (body < 0) continue;
#define CALL(n) add_columns(w->x, w->V[side], d->body[body].z, n)
            JO_BY_ROWS(k->nrow, CALL)
#undef CALL
        }
        if (solver && (solver->alpha != 0.0 || solver->beta != 0.0))
            for (int r = 0; r < k->nrow; r++)
                w->x[r] += 2.0 * solver->alpha * w->cdot[r] + solver->beta * solver->beta * w->c[r];
    }
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
        if (absent(d, &m->joint[m->column[c].joint]))
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

/* subtract P^T f from the modal forces */
static inline void subtract_modal(jo_real *restrict fp, const jo_real *restrict P, const jo_real *f, int np)
{
    const jo_real f0 = f[0], f1 = f[1], f2 = f[2];
    JO_EACH(j, np) JO_STORE(fp + j) -= f0 * JO_LOAD(P + j) + f1 * JO_LOAD(P + np + j) + f2 * JO_LOAD(P + 2 * np + j);
}

/* y -= V x, six rows */
static inline void subtract_rows(jo_real *restrict y, const jo_real *restrict V, const jo_real *restrict x,
                                 const int n)
{
    for (int j = 0; j < 6; j++) {
        jo_real s = y[j];
        for (int r = 0; r < n; r++) s -= V[6 * j + r] * x[r];
        y[j] = s;
    }
}

/* the joint forces act: f_p -= L_p^T C^T x, y = L^-T (z - V x), then the modal accelerations */
void jo_joint_apply(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nbody; i++)
        for (int j = 0; j < 6; j++) d->body[i].y[j] = d->body[i].z[j];
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        const jo_joint_work *w = &d->joint[i];
        for (int side = 0; side < k->nside; side++) {
            const jo_marker *mk = &m->marker[k->side[side]];
            if (mk->body < 0) continue;
            jo_body_work *bw = &d->body[mk->body];
            const jo_real *C = w->C[side], *V = w->V[side];
            const int np = m->body[mk->body].np;
#define CALL(n) subtract_rows(bw->y, V, w->x, n)
            JO_BY_ROWS(k->nrow, CALL)
#undef CALL
            if (mk->Phi && k->coincident) {
                jo_real f[3];
                for (int j = 0; j < 3; j++) f[j] = C[j] * w->x[0] + C[6 + j] * w->x[1] + C[12 + j] * w->x[2];
                subtract_modal(bw->fp, d->marker[k->side[side]].Phi, f, np);
            }
            if (mk->Psi && k->nperp) {
                jo_real f[3] = {0.0, 0.0, 0.0};
                for (int r = first_line(k) - k->nperp; r < first_line(k); r++) jo_axpy3(f, w->x[r], C + 6 * r + 3);
                subtract_modal(bw->fp, d->marker[k->side[side]].Psi, f, np);
            }
            for (int r = first_line(k); r < k->nrow; r++) {
                jo_real f[6];
                for (int j = 0; j < 6; j++) f[j] = w->x[r] * C[6 * r + j];
                if (mk->Phi) subtract_modal(bw->fp, d->marker[k->side[side]].Phi, f, np);
                if (mk->Psi) subtract_modal(bw->fp, d->marker[k->side[side]].Psi, f + 3, np);
            }
        }
    }
    for (int i = 0; i < m->nbody; i++) {
        jo_body_work *bw = &d->body[i];
        jo_body_backward(bw->L, bw->y);
        if (m->body[i].n) jo_body_modal(&m->body[i], bw, d->set);
    }
}
