/* friction_margin.c - how far stick-slip frictions are from the end of their state.
 *
 * Points of one body that stick are a group. Their rows are dependent: a force on the body may be shared in many ways, of which the body holds if
 * one keeps to all limits. The share that is least loaded,
 *   rho = min max_i |f_i| / L_i,   sum C_i f_i = w,   L_i = mu_static N_i,
 * w: force and moment of all points, C_i: those of unit forces at a point, is found by Lawson's weights (C. L. Lawson, Contributions to the
 * theory of linear least maximum approximation, UCLA 1961): least squares of weights v_i, sum v_i L_i^2 = 1, v_i <- v_i |f_i| / L_i. For any
 * weights sqrt(sum v_i |f_i|^2) <= rho <= max |f_i| / L_i. The body slips where rho > 1, at the points that are at their limit. */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"
#include "friction/friction_law.h"

#define JO_LEAST_PULL 1e-9  /* acceleration that a holding force may give its mass / size of the mechanism, 1/s2: round-off at a touch */
#define JO_SHARE_CLOSE 1e-12    /* gap between both bounds of rho at which the weights have converged */
#define JO_AT_LIMIT 1e-3    /* load of a point below rho, relative to it, up to which it slips with the others */
#define JO_NO_DIRECTION 1e-11   /* pivot over the largest one below which no force of the points has this direction */
enum { JO_POINTS = 32, JO_WEIGHTS = 400 };  /* largest number of points of a group; of changes of the weights */

static int *lock_of(const jo_model *m, jo_data *d, const jo_friction *f) { return &d->locked[m->joint[f->lock].lock]; }

/* Points of a body that stick: force f and limit L of each, force and moment (over the size of the mechanism) C of unit forces, sum w of all */
typedef struct {
    int count, friction[JO_POINTS];
    double C[JO_POINTS][2][6], f[JO_POINTS][2], L[JO_POINTS], w[6], limits;
} group;

static void add_point(const jo_model *m, const jo_data *d, int i, int body, const jo_real *about, group *g)
{
    const jo_friction *f = &m->friction[i];
    const jo_joint *k = &m->joint[f->lock];
    const int n = g->count++, of_b = m->marker[k->side[1]].body == body;
    jo_real y[2], arm[3], t[3];
    jo_friction_sticking_force(m, d, f, y);
    g->friction[n] = i;
    g->L[n] = JO_RE(f->data->mu_static * jo_contact_normal_force(m, d, &m->force[f->contact]));
    g->limits += g->L[n];
    jo_set3(arm, d->marker[k->side[of_b]].r);
    jo_sub3(arm, about);
    for (int c = 0; c < 2; c++) {
        const jo_coordinate_work *w = &d->coordinate[jo_slip_of(f, c)];
        const double sign = of_b ? 1.0 : -1.0;
        jo_cross(t, arm, w->along);
        for (int j = 0; j < 3; j++) {
            g->C[n][c][j] = sign * JO_RE(w->along[j]);
            g->C[n][c][3 + j] = (sign * JO_RE(t[j]) + JO_RE(of_b ? w->turn_b[j] : w->turn_a[j])) / m->size;
        }
        g->f[n][c] = JO_RE(y[c]);
        for (int j = 0; j < 6; j++) g->w[j] += g->C[n][c][j] * g->f[n][c];
    }
}

/* the group of friction i, if i is its first point that sticks; else no points */
static void gather(const jo_model *m, const jo_data *d, int i, group *g)
{
    const int body = jo_bearing_body(m, &m->friction[i]);
    int k = d->friction.first[body];
    g->count = 0;
    g->limits = 0.0;
    for (int j = 0; j < 6; j++) g->w[j] = 0.0;
    while (k >= 0 && !(jo_sticks(m, d, &m->friction[k]) && !jo_friction_apart(m, d, &m->friction[k]))) k = d->friction.next[k];
    if (k != i) return;
    const jo_real *about = d->marker[m->joint[m->friction[i].lock].side[1]].r;
    for (; k >= 0 && g->count < JO_POINTS; k = d->friction.next[k])
        if (jo_sticks(m, d, &m->friction[k]) && !jo_friction_apart(m, d, &m->friction[k])) add_point(m, d, k, body, about, g);
}

/* y of A y = w, A (6 x 6) symmetric and semidefinite, w in its range: elimination with the largest diagonal entry next */
static void solve6(double A[6][6], const double *w, double *y)
{
    int order[6], rank = 0, used[6] = {0};
    double b[6], largest = 0.0;
    for (int j = 0; j < 6; j++) {
        b[j] = w[j];
        y[j] = 0.0;
        largest = fmax(largest, A[j][j]);
    }
    for (; rank < 6; rank++) {
        int p = -1;
        for (int j = 0; j < 6; j++)
            if (!used[j] && (p < 0 || A[j][j] > A[p][p])) p = j;
        if (!(A[p][p] > JO_NO_DIRECTION * largest)) break;
        used[p] = 1;
        order[rank] = p;
        for (int i = 0; i < 6; i++) {
            if (used[i]) continue;
            const double x = A[i][p] / A[p][p];
            for (int j = 0; j < 6; j++)
                if (!used[j]) A[i][j] -= x * A[p][j];
            b[i] -= x * b[p];
            A[i][p] = x;   /* not used again */
        }
    }
    for (int r = rank - 1; r >= 0; r--) {
        const int p = order[r];
        double x = b[p];
        for (int s = r + 1; s < rank; s++) x -= A[p][order[s]] * y[order[s]];
        y[p] = x / A[p][p];
    }
}

/* forces f of least sum v |f|^2 with the same force and moment, for weights v; returns their largest load |f| / L */
static double share_out(group *g, const double *v)
{
    double A[6][6] = {{0.0}}, y[6], most = 0.0;
    for (int i = 0; i < g->count; i++)
        for (int c = 0; c < 2 && v[i] > 0.0; c++)
            for (int j = 0; j < 6; j++)
                for (int k = 0; k < 6; k++) A[j][k] += g->C[i][c][j] * g->C[i][c][k] / v[i];
    solve6(A, g->w, y);
    for (int i = 0; i < g->count; i++) {
        for (int c = 0; c < 2; c++) {
            g->f[i][c] = 0.0;
            for (int j = 0; j < 6 && v[i] > 0.0; j++) g->f[i][c] += g->C[i][c][j] * y[j] / v[i];
        }
        if (v[i] > 0.0) most = fmax(most, hypot(g->f[i][0], g->f[i][1]) / g->L[i]);
    }
    return most;
}

/* rho, and the forces of the least loaded share; without `all` only as far as is needed to see whether it exceeds 1 */
static double least_load(group *g, int all)
{
    double v[JO_POINTS], high = INFINITY, low = 0.0;
    if (g->count == 1) return g->L[0] > 0.0 ? hypot(g->f[0][0], g->f[0][1]) / g->L[0] : INFINITY;
    for (int i = 0; i < g->count; i++) v[i] = g->L[i] > 0.0 ? 1.0 / (g->L[i] * g->limits) : 0.0;
    for (int k = 0; k < JO_WEIGHTS; k++) {
        double square = 0.0, sum = 0.0;
        high = share_out(g, v);
        for (int i = 0; i < g->count; i++) square += v[i] * (g->f[i][0] * g->f[i][0] + g->f[i][1] * g->f[i][1]);
        low = sqrt(square);
        if (high - low <= JO_SHARE_CLOSE * high || (!all && (high <= 1.0 || low > 1.0 + JO_OVERLOAD))) break;
        for (int i = 0; i < g->count; i++) {
            if (v[i] > 0.0) v[i] *= hypot(g->f[i][0], g->f[i][1]) / g->L[i];
            sum += v[i] * g->L[i] * g->L[i];
        }
        for (int i = 0; i < g->count; i++) v[i] /= sum;
    }
    return high <= 1.0 ? high : low;
}

/* 1 less the load of the group, of which friction i is the first that sticks; positive while it holds, relative to the sum of the limits */
static double hold_margin(const jo_model *m, const jo_data *d, int i)
{
    group g;
    double whole = 0.0;
    gather(m, d, i, &g);
    if (!g.count) return 1.0;
    for (int k = 0; k < g.count; k++) whole += hypot(g.f[k][0], g.f[k][1]);
    const double least = JO_LEAST_PULL * m->size * JO_RE(m->friction[i].data->mass);
    if (whole <= least) return 1.0;
    if (!(g.limits > 0.0)) return -1.0;
    return 1.0 + JO_OVERLOAD + least / g.limits - least_load(&g, 0);
}

/* The points of the group of friction i that are at their limit start to slide, against their forces. */
void jo_friction_let_go(const jo_model *m, jo_data *d, int i)
{
    group g;
    gather(m, d, i, &g);
    const double load = g.limits > 0.0 ? least_load(&g, 1) : 0.0;
    for (int k = 0; k < g.count; k++) {
        const jo_friction *f = &m->friction[g.friction[k]];
        jo_real *e = d->direction + 2 * g.friction[k];
        const double size = hypot(g.f[k][0], g.f[k][1]);
        if (size < (1.0 - JO_AT_LIMIT) * fmin(load, 1e300) * g.L[k]) continue;
        for (int c = 0; c < 2; c++) e[c] = jo_same(size > 0.0 ? -g.f[k][c] / size : c ? 0.0 : 1.0);
        d->slip[g.friction[k]] = 1;
        *lock_of(m, d, f) = 0;
    }
    jo_forces_jumped(d);
}

/* margin of friction i after jo_evaluate, positive while its state persists. It is the static limit minus the holding force, N or N m,
 * while sticking, and the slip speed along its direction, m/s, while sliding. JO_OVERLOAD and JO_REST are added to exclude round-off. */
jo_real jo_friction_margin(const jo_model *m, const jo_data *d, int i)
{
    const jo_friction *f = &m->friction[i];
    jo_real y[2], collar;
    if (jo_friction_apart(m, d, f)) return jo_same(1.0);
    if (jo_sticks(m, d, f) && f->contact >= 0) return jo_same(hold_margin(m, d, i));
    if (jo_sticks(m, d, f)) {
        jo_real reaction[6];
        jo_friction_joint_reaction(m, d, f, reaction);
        const jo_real N = jo_friction_normal_force(m, f, reaction, &collar), limit = (1.0 + JO_OVERLOAD) * f->data->mu_static;
        jo_friction_sticking_force(m, d, f, y);
        if (jo_slips(f) == 1) return limit * (jo_slip_arm(m, f, 0) * N + collar) - jo_size(y[0]);
        return limit * N - jo_length2(y[0] / jo_slip_arm(m, f, 0), y[1] / jo_slip_arm(m, f, 1));
    }
    if (!f->law || !d->slip[i]) return 1.0;
    jo_friction_slip(m, d, f, y);
    const jo_real *e = d->direction + 2 * i;
    return JO_REST * jo_slip_scale(m, f) + (jo_slips(f) == 1 ? d->slip[i] * y[0] : e[0] * y[0] + e[1] * y[1]);
}
