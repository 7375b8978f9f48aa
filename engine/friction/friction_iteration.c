/* friction_iteration.c - friction forces f that agree with the multipliers which they change: fixed point f = F(lam(f)).
 *
 * The multipliers are linear in f. With few forces the changes of the reactions by unit forces are computed once, and an iteration needs
 * products only; with more forces each iteration solves for the change of the multipliers with the factors. In trees the latter costs one
 * pass over the links back and forth for all forces together, so that only a single force has its unit response computed.
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "friction/friction_law.h"
#include "tree/tree.h"

enum { JO_MAX_ITERATIONS = 60 };
enum { JO_MAX_STAGNANT = 3 };   /* iterations without reduction by JO_MIN_REDUCTION after which the accuracy JO_NEARLY suffices */
#define JO_AGREED 1e-12         /* |F(lam(f)) - f| / |F| at convergence */
#define JO_NEARLY 1e-6          /* the same ratio that suffices if round-off prevents JO_AGREED */
#define JO_FAST 0.1             /* ratio of successive residuals below which the next residual is predicted from this ratio */
#define JO_MIN_REDUCTION 0.5    /* residual relative to the smallest previous residual, below which an iteration counts as progress */
#define JO_DERIVATIVE_WEIGHT 1e-2   /* weight of the residual of derivatives (imaginary part) against that of values */
/* square of the part of a vector orthogonal to others, relative to the square of the vector, below which it is dependent */
#define JO_INDEPENDENT 1e-12
#define JO_SHORT_START 1e-2     /* share of the first change in the second attempt, which approaches the smallest solution from f = 0 */

static inline jo_real dot(const jo_real *x, const jo_real *y, const int n)
{
    jo_lanes products = {0.0};
    jo_real s = 0.0;
    int i = 0;
    for (; i + JO_WIDTH <= n; i += JO_WIDTH) products += JO_LOAD(x + i) * JO_LOAD(y + i);
    for (; i < n; i++) s += x[i] * y[i];
    return n < JO_WIDTH ? s : s + jo_sum(products);
}

/* y (2): largest magnitude of the real and imaginary parts of x (n) */
static inline void largest(const jo_real *x, const int n, double *y)
{
    y[0] = y[1] = 0.0;
    for (int i = 0; i < n; i++) {
        const double re = fabs(JO_RE(x[i]));
        if (!(re <= y[0])) y[0] = re;
#ifdef JO_COMPLEX
        const double im = fabs(cimag(x[i]));
        if (!(im <= y[1])) y[1] = im;
#endif
    }
}

/* relative size of the residual; imaginary parts (derivatives) with weight JO_DERIVATIVE_WEIGHT */
static double relative_size(const double *r, const double *f)
{
    const double re = r[0] > 0.0 ? r[0] / f[0] : 0.0, im = r[1] > 0.0 ? JO_DERIVATIVE_WEIGHT * r[1] / f[1] : 0.0;
    return re > im ? re : im;
}

/* whether the changes of the reactions by unit forces are computed in advance, for n forces */
static inline int has_reach(const jo_data *d, int n) { return n <= (jo_tree_active(d) ? 1 : JO_REACH); }

/* ---- change of the multipliers by friction forces ------------------------------------------------ */

/* joint[].x = change of the multipliers by friction forces f; in trees the response of the links instead */
static void change_multipliers(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_real *f)
{
    if (jo_tree_active(d)) {
        jo_tree_friction_response(m, d, d->friction.n, d->friction.coordinate, f);
        return;
    }
    jo_clear_changes(m, d);
    for (int c = 0; c < d->friction.n; c++)
        if (f[c] != 0.0) jo_push_change(m, d, d->friction.coordinate[c], f[c]);
    if (jo_couples(m, stage)) {
        jo_coupled_respond(m, d);
        return;
    }
    jo_joint_force_change(m, d, stage->set);
    jo_joint_solve(m, d);
}

/* lam = joint[].x, or lam += joint[].x if `add` */
static void store_multipliers(const jo_model *m, const jo_data *d, jo_real *lam, int add)
{
    if (jo_tree_active(d)) return;
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++, lam++) *lam = d->joint[i].x[r] + (add ? *lam : 0.0);
}

/* y = change of the reaction of a sliding joint by the last change_multipliers, whose multipliers are lam */
static void reaction_change(const jo_model *m, const jo_data *d, const jo_sliding_friction *s, const jo_real *lam, jo_real *y)
{
    if (jo_tree_active(d)) jo_tree_joint_reaction(m, d, &m->friction[s->friction], 1, y);
    else jo_friction_reaction(m, d, &m->friction[s->friction], lam, y);
}

/* list of sliding frictions, their reactions without friction, and changes of these by unit forces */
static void find_sliding(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    jo_anderson *w = &d->friction;
    w->nsliding = w->n = 0;
    store_multipliers(m, d, d->lam, 0);
    if (jo_tree_active(d)) jo_tree_update_slips(m, d);
    for (int i = 0; i < m->nfriction; i++) {
        const jo_friction *f = &m->friction[i];
        jo_sliding_friction *s = &w->sliding[w->nsliding];
        if (f->contact >= 0 || jo_sticks(m, d, f)) continue;
        if (!jo_friction_weights(m, d, i, s->press, s->collar)) continue;
        s->friction = i;
        s->first = w->n;
        s->count = jo_slips(f);
        for (int k = 0; k < s->count; k++) w->coordinate[w->n++] = jo_slip_of(f, k);
        jo_friction_joint_reaction(m, d, f, s->start);
        w->nsliding++;
    }
    if (!has_reach(d, w->n)) {
        for (int i = 0; i < m->nrow && !jo_tree_active(d); i++) w->lam[i] = d->lam[i];
        return;
    }
    for (int c = 0; c < w->n; c++) w->f[c] = 0.0;
    for (int c = 0; c < w->n; c++) {
        jo_real *lam = w->reach + c * m->nrow;
        w->f[c] = 1.0;
        change_multipliers(m, d, stage, w->f);
        w->f[c] = 0.0;
        store_multipliers(m, d, lam, 0);
        for (int i = 0; i < w->nsliding; i++) reaction_change(m, d, &w->sliding[i], lam, w->sliding[i].reach[c]);
    }
}

/* reactions y with friction forces f, after the change w->change of f */
static inline void update_reactions(const jo_model *m, jo_data *d, const jo_stage *stage, const int n, const int nsliding)
{
    jo_anderson *w = &d->friction;
    if (has_reach(d, n)) {
        for (int i = 0; i < nsliding; i++) {
            jo_sliding_friction *s = &w->sliding[i];
            for (int j = 0; j < 6; j++) s->y[j] = s->start[j];
            for (int c = 0; c < n; c++)
                for (int j = 0; j < 6; j++) s->y[j] += w->f[c] * s->reach[c][j];
        }
        return;
    }
    change_multipliers(m, d, stage, jo_tree_active(d) ? w->f : w->change);
    store_multipliers(m, d, d->lam, 1);
    for (int i = 0; i < w->nsliding; i++) {
        jo_sliding_friction *s = &w->sliding[i];
        reaction_change(m, d, s, d->lam, s->y);
        for (int j = 0; j < 6 && jo_tree_active(d); j++) s->y[j] += s->start[j];   /* in trees y is only the change by f */
    }
}

/* ---- fixed-point iteration ----------------------------------------------------------------------- */

/* change (n) = r - sum_j gamma_j (dF_j + dR_j) with dR gamma = r in least squares, by orthogonalisation, newest pair first
 * (Anderson, J. ACM 12, 1965); for one unknown the secant method, see iterate() */
static void anderson_step(jo_anderson *w, int n, jo_real *change)
{
    jo_real gamma[JO_PAIRS] = {0.0}, R[JO_PAIRS][JO_PAIRS] = {{0.0}};
    int used[JO_PAIRS], count = 0;
    for (int i = 0; i < n; i++) change[i] = w->r[i];
    for (int j = 0; j < w->pairs; j++) {
        const int p = (w->newest - j + JO_PAIRS) % JO_PAIRS;
        jo_real *q = w->Q[count];
        for (int i = 0; i < n; i++) q[i] = w->dR[p][i];
        const double before = JO_RE(dot(q, q, n));
        for (int k = 0; k < count; k++) {
            R[k][count] = dot(w->Q[k], q, n);
            for (int i = 0; i < n; i++) q[i] -= R[k][count] * w->Q[k][i];
        }
        const jo_real square = dot(q, q, n);
        if (!(JO_RE(square) > JO_INDEPENDENT * before)) continue;
        R[count][count] = jo_sqrt(square);
        const jo_real inverse = 1.0 / R[count][count];
        for (int i = 0; i < n; i++) q[i] *= inverse;
        used[count++] = p;
    }
    for (int k = count - 1; k >= 0; k--) {
        gamma[k] = dot(w->Q[k], w->r, n);
        for (int j = k + 1; j < count; j++) gamma[k] -= R[k][j] * gamma[j];
        gamma[k] /= R[k][k];
    }
    for (int k = 0; k < count; k++)
        for (int i = 0; i < n; i++) change[i] -= gamma[k] * (w->dF[used[k]][i] + w->dR[used[k]][i]);
}

/* store the last changes of f and r; returns whether, for a single unknown, the slope of F(lam(f)) is 1 or more */
static inline int store_pair(jo_anderson *w, const int n, int unknowns, int steep)
{
    w->newest = (w->newest + 1) % JO_PAIRS;
    if (w->pairs < JO_PAIRS) w->pairs++;
    for (int i = 0; i < n; i++) {
        w->dF[w->newest][i] = w->change[i];
        w->dR[w->newest][i] = w->r[i] - w->before[i];
    }
    if (unknowns == 1 && JO_RE(dot(w->change, w->change, n)) > JO_INDEPENDENT * JO_RE(dot(w->f, w->f, n)))
        steep = JO_RE(dot(w->change, w->dR[w->newest], n)) >= 0.0;
    return steep;
}

/* Iteration for f = F(lam(f)) from f = 0 with the first change `first` times the residual. Returns 0 without convergence and, for one sliding
 * coordinate, if the slope of F(lam(f)) is 1 or more. */
static inline int iterate(const jo_model *m, jo_data *d, const jo_stage *stage, double first, const int n,
                         const int nsliding)
{
    jo_anderson *w = &d->friction;
    double off[2], all[2], best = INFINITY, last = 0.0;
    int steep = 0, stagnant = 0;
    w->pairs = 0;
    w->newest = JO_PAIRS - 1;
    for (int i = 0; i < n; i++) w->f[i] = 0.0;
    for (int i = 0; i < m->nrow && !has_reach(d, n) && !jo_tree_active(d); i++) d->lam[i] = w->lam[i];
    for (int i = 0; i < nsliding; i++)
        for (int j = 0; j < 6; j++) w->sliding[i].y[j] = w->sliding[i].start[j];
    for (int k = 0;; k++) {
        /* g = press N + collar torque, r = g - f */
        int unknowns = 0;
        for (int i = 0; i < nsliding; i++) {
            const jo_sliding_friction *s = &w->sliding[i];
            jo_real collar;
            const jo_real N = jo_friction_normal_force(m, &m->friction[s->friction], s->y, &collar);
            for (int k = 0; k < s->count; k++) w->g[s->first + k] = s->press[k] * N + s->collar[k] * collar;
        }
        for (int i = 0; i < n; i++) {
            w->r[i] = w->g[i] - w->f[i];
            unknowns += w->g[i] != 0.0;
        }
        largest(w->r, n, off);
        largest(w->g, n, all);
        if (!isfinite(off[0])) return !k;   /* the first residual is not finite: the step reports divergence */
        const double apart = relative_size(off, all);
        stagnant = apart < JO_MIN_REDUCTION * best ? 0 : stagnant + 1;
        if (apart < best) best = apart;
        if (apart <= JO_AGREED || (stagnant >= JO_MAX_STAGNANT && apart <= JO_NEARLY)) return !steep;
        if (k == JO_MAX_ITERATIONS) return 0;
        /* next change: secant method or Anderson */
        if (k) steep = store_pair(w, n, unknowns, steep);
        if (n == 1) {
            const int p = w->newest, known = w->pairs && w->dR[p][0] != 0.0;
            w->change[0] = known ? -w->r[0] * w->dF[p][0] / w->dR[p][0] : w->r[0];
        } else {
            anderson_step(w, n, w->change);
        }
        for (int i = 0; i < n; i++) {
            if (!k) w->change[i] *= first;
            w->before[i] = w->r[i];
            w->f[i] += w->change[i];
        }
        /* the next residual, if it decreases by the same ratio as the last one; the ratio itself decreases */
        const int done = apart < JO_FAST * last && apart * apart <= JO_AGREED * last;
        if (!done || !jo_tree_active(d)) update_reactions(m, d, stage, n, nsliding);   /* in trees apply_friction updates the links */
        if (done) return !steep;
        last = apart;
    }
}

static int solve_forces(const jo_model *m, jo_data *d, const jo_stage *stage, double first)
{
    const jo_anderson *w = &d->friction;
    /* with a single force the loops are unrolled */
    return w->n == 1 ? iterate(m, d, stage, first, 1, 1) : iterate(m, d, stage, first, w->n, w->nsliding);
}

/* error_index = number of the friction with the largest residual */
static int report_failure(jo_data *d)
{
    const jo_anderson *w = &d->friction;
    double worst = -1.0;
    for (int i = 0; i < w->nsliding; i++)
        for (int k = 0; k < w->sliding[i].count; k++) {
            const double off = fabs(JO_RE(w->r[w->sliding[i].first + k]));
            if (off <= worst) continue;
            worst = off;
            d->error_index = w->sliding[i].friction;
        }
    return JO_FRICTION_FAILED;
}

/* apply the converged friction forces to the bodies, and compute the multipliers with friction */
static void apply_friction(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    const jo_anderson *w = &d->friction;
    if (jo_tree_active(d)) {
        jo_tree_apply_friction(m, d, w->n, w->coordinate, w->f);
        return;
    }
    jo_clear_changes(m, d);
    for (int c = 0; c < w->n; c++) jo_push_late(m, d, w->coordinate[c], w->f[c]);
    if (jo_couples(m, stage)) {
        jo_coupled_solve(m, d, stage);
        store_multipliers(m, d, d->lam, 0);
        return;
    }
    jo_free_changed(m, d, stage->set);
    for (int c = 0; c < w->n && has_reach(d, w->n); c++)
        for (int i = 0; i < m->nrow; i++) d->lam[i] += w->f[c] * w->reach[c * m->nrow + i];
    const jo_real *lam = d->lam;
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) d->joint[i].x[r] = *lam++;
}

/* Friction forces and multipliers, from the multipliers without friction in joint[].x. The normal force is a convex function of the
 * friction force: for one sliding coordinate the secant method with a short first change stays between f = 0 and the smallest solution, if
 * a solution exists. A larger solution is not physical, since its friction increases the normal force by more than the friction requires
 * (Painleve). */
int jo_friction_solve(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    const jo_anderson *w = &d->friction;
    jo_real *f = d->rub;
    find_sliding(m, d, stage);
    if (w->n && !solve_forces(m, d, stage, 1.0) && !solve_forces(m, d, stage, JO_SHORT_START)) return report_failure(d);
    if (w->n) apply_friction(m, d, stage);
    for (int i = 0; i < m->nfriction; i++)   /* those of contacts are known, see jo_friction_push_contacts */
        if (m->friction[i].contact < 0) f[2 * i] = f[2 * i + 1] = 0.0;
    for (int i = 0; i < w->nsliding; i++) {
        const jo_sliding_friction *s = &w->sliding[i];
        for (int k = 0; k < s->count; k++) {
            const int c = s->first + k;
            f[2 * s->friction + k] = w->f[c];
            d->power.friction -= w->f[c] * d->coordinate[w->coordinate[c]].rate;
        }
    }
    for (int i = 0; i < m->nfriction; i++)
        if (jo_sticks(m, d, &m->friction[i])) jo_friction_sticking_force(m, d, &m->friction[i], f + 2 * i);
    return JO_OK;
}

void jo_friction_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    jo_anderson *x = &d->friction;
    jo_real **forces[5] = {&x->f, &x->g, &x->r, &x->before, &x->change};
    x->sliding = jo_take_many(a, m->nfriction, sizeof *x->sliding);
    x->coordinate = jo_take_ints(a, 2 * m->nfriction);
    x->turns = jo_take_ints(a, m->nfriction);
    jo_friction_layout_contacts(m, d, a);
    x->lam = jo_take_reals(a, m->nfriction ? m->nrow : 0);
    x->reach = jo_take_reals(a, m->nfriction ? JO_REACH * m->nrow : 0);
    for (int i = 0; i < 5; i++) *forces[i] = jo_take_reals(a, 2 * m->nfriction);
    for (int i = 0; i < JO_PAIRS; i++) {
        x->dF[i] = jo_take_reals(a, 2 * m->nfriction);
        x->dR[i] = jo_take_reals(a, 2 * m->nfriction);
        x->Q[i] = jo_take_reals(a, 2 * m->nfriction);
    }
}
