/* iteration_limit.c - start and end of the iteration of generalised alpha, from the accelerations of earlier steps.
 *
 * The velocities of a step have the error c h^3 v''' with c near 1/12, and h^2 v''' is the second difference of the algorithmic
 * accelerations. An iteration that leaves an error e in these adds g h e to the velocities. Both accumulate from step to step, so that the
 * iteration is not visible if e is small beside the second difference, at any length of the step.
 *
 * Vibrations that the step does not resolve have large second differences, which cancel over many steps, while the error of the motion
 * below them accumulates. The present second difference therefore counts up to a multiple of the mean one of a window of steps,
 * (first difference at its end - first difference at its start) / number of its steps.
 *
 * In the first steps after a start or a change of the step nothing is known: the tolerance alone ends the iteration.
 */
#include "integrate/integrate.h"
#include "integrate/acceleration_size.h"

enum { JO_WINDOW = 16 };        /* steps of a window */
#define JO_OF_MEAN 30.0         /* largest present second difference that counts, relative to the mean one */
#define JO_SMOOTH 0.3           /* ratio of second to first differences below which accelerations are extrapolated */

/* The numbers of jo_alpha.estimate. */
enum {
    JO_STEPS,                   /* steps of equal length since the estimate began */
    JO_LENGTH,                  /* their length, s */
    JO_MEAN,                    /* norm of the mean second difference of the last window; 0: unknown */
    JO_AHEAD                    /* 1 if the accelerations were smooth at the end of the last window, else 0 */
};

/* after a start, or without estimates */
void jo_iteration_limit_forget(jo_data *d)
{
    d->alpha.estimate[JO_STEPS] = d->alpha.estimate[JO_MEAN] = d->alpha.estimate[JO_AHEAD] = 0.0;
}

/* norm of accelerations x of all bodies in the metric of the masses */
static double norm(const jo_model *m, const jo_data *d, const jo_real *x)
{
    double sum = 0.0;
    for (int i = 0; i < m->nbody; i++) sum += jo_acceleration_size(m, d, i, x + m->body[i].iv);
    return sqrt(sum);
}

/* norm of the second difference with the accelerations in `rate`; overwrites dv */
static double second_difference(const jo_model *m, jo_data *d)
{
    const jo_real *present = d->rate, *old = d->alpha.algorithmic, *change = d->alpha.change;
    jo_real *y = d->dv;
    const int n = d->nw;
    JO_EACH(i, n) JO_STORE(y + i) = JO_LOAD(present + i) - JO_LOAD(old + i) - JO_LOAD(change + i);
    return norm(m, d, y);
}

/* share of the last change of accelerations and multipliers that the prediction adds: 1, or 0 for those of the last step. Redundant rows
 * have multipliers of least norm, which the factors in use determine. */
double jo_iteration_ahead(const jo_model *m, const jo_data *d, const jo_solver *s)
{
    if (s->error_share == 0.0 || m->redundant > 0 || JO_RE(d->alpha.estimate[JO_LENGTH]) != s->step) return 0.0;
    return JO_RE(d->alpha.estimate[JO_AHEAD]);
}

/* largest increment of the algorithmic accelerations, in the metric of the masses, that does not matter beside the error of the step with
 * the accelerations in `rate`; 0 if the error is unknown. Overwrites dv. */
double jo_iteration_limit(const jo_model *m, jo_data *d, const jo_solver *s)
{
    const double mean = JO_RE(d->alpha.estimate[JO_MEAN]);
    if (s->error_share == 0.0 || mean == 0.0 || JO_RE(d->alpha.estimate[JO_LENGTH]) != s->step) return 0.0;
    const double present = second_difference(m, d);
    return s->error_share * (present < JO_OF_MEAN * mean ? present : JO_OF_MEAN * mean);
}

/* the step is accepted with the accelerations in `rate` and the multipliers in lam; those of the last step are still in d->alpha */
void jo_iteration_limit_update(const jo_model *m, jo_data *d, const jo_solver *s)
{
    jo_real *e = d->alpha.estimate;
    if (s->error_share == 0.0) return;
    if (JO_RE(e[JO_LENGTH]) != s->step) {
        jo_iteration_limit_forget(d);
        e[JO_LENGTH] = s->step;
    }
    e[JO_STEPS] += 1.0;
    const int steps = (int)JO_RE(e[JO_STEPS]) - 2;   /* the first difference contains the guess of a start */
    const int due = steps >= 0 && steps % JO_WINDOW == 0;
    const double second = due && steps ? second_difference(m, d) : 0.0;
    for (int i = 0; i < m->nrow; i++) d->alpha.change_lam[i] = d->lam[i] - d->alpha.end_lam[i];
    const jo_real *present = d->rate, *old = d->alpha.algorithmic;
    jo_real *change = d->alpha.change;
    const int n = d->nw;
    JO_EACH(i, n) JO_STORE(change + i) = JO_LOAD(present + i) - JO_LOAD(old + i);
    if (!due) return;
    if (steps) {
        for (int i = 0; i < d->nw; i++) d->dv[i] = d->alpha.change[i] - d->alpha.first_change[i];
        e[JO_MEAN] = norm(m, d, d->dv) / JO_WINDOW;
        e[JO_AHEAD] = second < JO_SMOOTH * norm(m, d, d->alpha.change) ? 1.0 : 0.0;
    }
    for (int i = 0; i < d->nw; i++) d->alpha.first_change[i] = d->alpha.change[i];
}
