/* step_runge_kutta.c - one step of an explicit Runge-Kutta method, whose tableau is a row of JO_METHODS in jousto.h.
 *
 *   k_i = f(t + c_i h, y + h sum_j<i a_ij k_j),   y + h sum_i b_i k_i
 * of the index-1 equations (Rantalainen 2007, chapter 4), y being increments [R' h, theta, p' h] from the start of the step and
 * velocities; orientations are e o exp(theta).
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "integrate/integrate.h"

/* whether the rates of stage k are still needed after the next stage */
static JO_INLINE int lasting(const jo_tableau *t, const int k)
{
    int needed = 0;
    for (int i = k + 2; i < t->stages; i++) needed |= jo_tableau_row(t, i)[k] != 0.0;
    return needed;
}

/* Add stage k with its weight to the sums of increments and velocities, and compute both for the next stage. In the first stage the
 * increments are zero and their rates are the velocities. */
static JO_INLINE void gather(jo_data *d, const jo_tableau *t, const int k, double h)
{
    jo_real *const rate = d->rate, *const dq = d->dq, *const dv = d->dv, *const w = d->w, *const v0 = d->v0, *const wd = d->wd;
    const int n = d->nw, last = k == t->stages - 1;
    const double *a = jo_tableau_row(t, k + 1);   /* row of the next stage; not used in the last stage */
    const double share = jo_tableau_weights(t)[k] * h, next = last ? 0.0 : a[k] * h;
    if (lasting(t, k)) jo_keep_rates(d, k, k ? rate : w);
    JO_EACH(i, n) {
        const jo_lanes r = k ? JO_LOAD(rate + i) : JO_LOAD(w + i), x = JO_LOAD(wd + i);
        JO_STORE(dq + i) = k ? JO_LOAD(dq + i) + share * r : share * r;
        JO_STORE(dv + i) = k ? JO_LOAD(dv + i) + share * x : share * x;
        JO_STORE(rate + i) = next * r;
        JO_STORE(w + i) = JO_LOAD(v0 + i) + next * x;
    }
    for (int j = 0; j < k && !last; j++) {
        if (a[j] == 0.0) continue;
        const double before = a[j] * h;
        const jo_real *r = jo_kept_rates(d, j), *x = jo_kept_accelerations(d, j);
        JO_EACH(i, n) {
            JO_STORE(rate + i) += before * JO_LOAD(r + i);
            JO_STORE(w + i) += before * JO_LOAD(x + i);
        }
    }
}

/* stage k: state, accelerations, weighted sums */
static JO_INLINE int stage_of(const jo_model *m, jo_data *d, const jo_tableau *t, const int k, double h, jo_real t0, const jo_stage *stage)
{
    const int baumgarte = jo_stabilised(stage);
    if (k) {
        jo_integrate_positions(m, d, d->rate);
        d->time[0] = t0 + jo_tableau_node(t, k) * h;
    }
    if (k || !jo_accelerations_valid(d) || baumgarte) {
        const int status = jo_evaluate(m, d, stage);
        if (status != JO_OK) {
            jo_state_changed(d);
            return status;
        }
        if (!k && jo_valid_before_call(d) && !baumgarte) d->counts.evaluations--;   /* evaluation counts must not depend on how a run is split into calls */
    }
    jo_first_stage_done(d);
    if (k) jo_position_rate(m, d, d->rate, d->rate);
    gather(d, t, k, h);
    jo_add_work(&d->work, jo_tableau_weights(t)[k] * h, &d->power);
    return JO_OK;
}

/* compiled for each tableau, so that its coefficients are constants of the code */
static JO_INLINE int step(const jo_model *m, jo_data *d, const jo_solver *s, const jo_tableau *t)
{
    const jo_real t0 = d->time[0];
    const jo_stage stage = {.alpha = s->alpha, .beta = s->beta};
    JO_EACH(i, d->ny) JO_STORE(d->q0 + i) = JO_LOAD(d->y + i);
    JO_EACH(i, d->nw) JO_STORE(d->v0 + i) = JO_LOAD(d->w + i);
    int status = stage_of(m, d, t, 0, s->step, t0, &stage);
    if (t->stages > 1 && status == JO_OK) status = stage_of(m, d, t, 1, s->step, t0, &stage);
    if (t->stages > 2 && status == JO_OK) status = stage_of(m, d, t, 2, s->step, t0, &stage);
    if (t->stages > 3 && status == JO_OK) status = stage_of(m, d, t, 3, s->step, t0, &stage);
    if (status != JO_OK) return status;
    jo_integrate_positions(m, d, d->dq);
    JO_EACH(i, d->nw) JO_STORE(d->w + i) = JO_LOAD(d->v0 + i) + JO_LOAD(d->dv + i);
    d->time[0] = t0 + s->step;
    return jo_close_step(m, d, s, &stage);
}

/* cases of the methods of this family */
#define JO_RK_runge_kutta(name, order, stages, ...) \
    case JO_METHOD_##name: { \
        static const double coefficient[] = {__VA_ARGS__}; \
        const jo_tableau t = {0, order, stages, coefficient}; \
        return step(m, d, s, &t); \
    }
#define JO_RK_rosenbrock(...)
#define JO_RK_generalized_alpha(...)
#define JO_RK_dormand_prince(...)
#define JO_RK_ROW(name, family, ...) JO_RK_##family(name, __VA_ARGS__)

int jo_step_runge_kutta(const jo_model *m, jo_data *d, const jo_solver *s)
{
    switch (s->method) {
    JO_METHODS(JO_RK_ROW)
    default: return JO_NO_CONVERGENCE;   /* a method of another family */
    }
}
