/* step_dormand_prince.c - one step of the Runge-Kutta pair of orders 5 and 4 of Dormand and Prince, error estimate, dense output.
 *
 * Dormand, Prince, J. Comp. Appl. Math. 6 (1980); dense output as in Hairer, Norsett, Wanner, Solving Ordinary
 * Differential Equations I (1993), II.6. The method integrates the increments of state.c (Lie group of poses). The new state is
 * projected before the last stage is evaluated, so that this stage is also the first one of the next step.
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "tree/tree.h"
#include "integrate/integrate.h"

enum { JO_STAGES = 7 };

static const double NODE[JO_STAGES] = {0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0};
static const double WEIGHT[JO_STAGES][JO_STAGES - 1] = {   /* last row: weights of the step */
    {0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0},
    {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0},
    {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0},
    {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0},
    {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0}};
/* weights of order 5 - weights of order 4 */
static const double ERROR[JO_STAGES] = {71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0,
                                        22.0 / 525.0, -1.0 / 40.0};
/* dense output of order 4 (Shampine 1986): coefficients of the term with double zeros at both ends */
static const double DENSE[JO_STAGES] = {-12715105075.0 / 11282082432.0, 0.0, 87487479700.0 / 32700410799.0,
                                        -10690763975.0 / 1880347072.0, 701980252875.0 / 199316789632.0,
                                        -1453857185.0 / 822651844.0, 69997945.0 / 29380423.0};

static int width(const jo_data *d) { return 2 * d->nw + 3; }

/* sum of weight_k stage_k at entry i over the first `count` stages */
static jo_real blend(const jo_data *d, const double *weight, int count, int nk, int i)
{
    jo_real sum = 0.0;
    for (int k = 0; k < count; k++) sum += weight[k] * d->adaptive.stages[k * nk + i];
    return sum;
}

/* x = increments from q0 to q; returns the largest rotation, rad */
double jo_increment_between(const jo_model *m, jo_real *x, const jo_real *q0, const jo_real *q)
{
    double turn = 0.0;
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        const jo_real *p0 = q0 + b->iq, *p = q + b->iq;
        jo_real *y = x + b->iv;
        for (int j = 0; j < 3; j++) y[j] = p[j] - p0[j];
        jo_rotation_vector_between(y + 3, p0 + 3, p + 3);
        for (int j = 0; j < b->n; j++) y[6 + j] = p[7 + j] - p0[7 + j];
        turn = jo_larger(turn, jo_length(y + 3, 3));
    }
    return turn;
}

/* work: the last entries of a stage or of a change */
static jo_work *work_of(const jo_data *d, jo_real *x) { return (jo_work *)(x + 2 * d->nw); }

static void store_stage(jo_data *d, int k, const jo_real *rate)
{
    jo_real *x = d->adaptive.stages + k * width(d);
    for (int i = 0; i < d->nw; i++) {
        x[i] = rate[i];
        x[d->nw + i] = d->wd[i];
    }
    *work_of(d, x) = d->power;
}

/* make the accelerations and power stored in a stage valid for the present state; bodies and markers remain invalid */
void jo_restore_stage(jo_data *d, int last)
{
    jo_real *x = d->adaptive.stages + (last ? JO_STAGES - 1 : 0) * width(d);
    for (int i = 0; i < d->nw; i++) d->wd[i] = x[d->nw + i];
    d->power = *work_of(d, x);
    jo_stage_recalled(d, 1);
}

/* end of a step of a tree: drives, projection of the loops, resulting increments */
static void close_tree(const jo_model *m, jo_data *d, const jo_solver *s)
{
    jo_tree_prescribe_end_of_step(m, d);
    if (!m->nloop || !s->projection) return;
    jo_tree_close_loops(m, d);
    jo_tree_increment_between(m, d->dq, d->q0, d->y);
}

/* one step of length h; forces at its end are evaluated at time `seen`, just before a jump at the end */
int jo_step_pair(const jo_model *m, jo_data *d, const jo_solver *s, double h, double seen)
{
    const int nv = d->nw, nk = width(d);
    const jo_real t0 = d->time[0];
    jo_control *c = &d->control;
    if (!jo_accelerations_known(d)) {
        const int status = jo_accelerations(m, d);
        if (status != JO_OK) return status;
    }
    jo_stage_forgotten(d);
    for (int i = 0; i < d->ny; i++) d->q0[i] = d->y[i];
    for (int i = 0; i < nv; i++) d->v0[i] = d->w[i];
    c->work = d->work;
    c->from = JO_RE(t0);
    c->length = h;
    store_stage(d, 0, d->w);
    for (int k = 1; k < JO_STAGES; k++) {
        for (int i = 0; i < nv; i++) {
            d->dq[i] = h * blend(d, WEIGHT[k], k, nk, i);
            d->w[i] = d->v0[i] + h * blend(d, WEIGHT[k], k, nk, nv + i);
        }
        jo_integrate_positions(m, d, d->dq);
        d->time[0] = k < 5 ? t0 + NODE[k] * h : seen + (t0 - JO_RE(t0));
        jo_state_changed(d);
        if (k == JO_STAGES - 1) {   /* new state: projection, increments */
            int status = jo_check(m, d);
            if (status != JO_OK) return status;
            if (s->projection && !jo_tree_active(d)) {
                jo_project(m, d, &jo_now);
                status = jo_check(m, d);
                if (status != JO_OK) return status;
            }
            if (jo_tree_active(d)) close_tree(m, d, s);
            else jo_increment_between(m, d->dq, d->q0, d->q);
        }
        const int status = jo_evaluate(m, d, &jo_now);
        if (status != JO_OK) return status;
        jo_position_rate(m, d, d->rate, d->dq);
        store_stage(d, k, d->rate);
    }
    for (int i = 2 * nv; i < nk; i++) d->adaptive.change[i] = blend(d, WEIGHT[JO_STAGES - 1], JO_STAGES - 1, nk, i);
    jo_add_work(&d->work, h, work_of(d, d->adaptive.change));
    for (int i = 0; i < nv; i++) {
        d->adaptive.change[i] = d->dq[i];
        d->adaptive.change[nv + i] = d->w[i] - d->v0[i];
    }
    *work_of(d, d->adaptive.change) = d->work;
    jo_add_work(work_of(d, d->adaptive.change), -1.0, &c->work);
    d->time[0] = t0 + h;
    jo_accelerations_found(d, 1);
    return JO_OK;
}

/* change of entry i at share u of the last step, by dense output */
static jo_real changed(const jo_data *d, double u, int nk, int i)
{
    const double h = d->control.length;
    const jo_real y = d->adaptive.change[i], r3 = h * d->adaptive.stages[i] - y, r4 = y - h * d->adaptive.stages[(JO_STAGES - 1) * nk + i] - r3;
    const jo_real r5 = h * blend(d, DENSE, JO_STAGES, nk, i);
    return u * (y + (1.0 - u) * (r3 + u * (r4 + (1.0 - u) * r5)));
}

/* state and work at share u of the last step */
void jo_interpolate(const jo_model *m, jo_data *d, double u)
{
    const int nv = d->nw, nk = width(d);
    const jo_work *start = &d->control.work;
    for (int i = 0; i < nv; i++) {
        d->dq[i] = changed(d, u, nk, i);
        d->w[i] = d->v0[i] + changed(d, u, nk, nv + i);
    }
    d->work.damping = start->damping + changed(d, u, nk, 2 * nv);
    d->work.friction = start->friction + changed(d, u, nk, 2 * nv + 1);
    d->work.forces = start->forces + changed(d, u, nk, 2 * nv + 2);
    jo_integrate_positions(m, d, d->dq);
}

/* error estimates of increments and velocities (nv) of the bodies of a tree */
void jo_tree_error_estimate(const jo_model *m, jo_data *d, jo_real *increment, jo_real *velocity)
{
    jo_real *const out[2] = {increment, velocity};
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < d->nw; i++) d->rate[i] = d->control.length * blend(d, ERROR, JO_STAGES, width(d), k * d->nw + i);
        jo_tree_body_rates(m, d, d->rate, out[k]);
    }
}

/* norm of the error estimate of entries i .. i + n - 1 */
double jo_error_estimate(const jo_data *d, int i, int n)
{
    double sum = 0.0;
    for (int j = i; j < i + n; j++) {
        const double e = JO_RE(blend(d, ERROR, JO_STAGES, width(d), j));
        sum += e * e;
    }
    return fabs(d->control.length) * sqrt(sum);
}

int jo_step_dopri(const jo_model *m, jo_data *d, const jo_solver *s)
{
    return jo_step_pair(m, d, s, s->step, JO_COMMON(d->time[0]) + s->step);
}
