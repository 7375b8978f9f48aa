/* run.c - runs of steps of fixed length with events and rows of results. */
#include "valid.h"
#include "maximal/maximal.h"
#include "tree/tree.h"
#include "contact/contact.h"
#include "integrate/integrate.h"
#include "fatigue/fatigue.h"

static int step(const jo_model *m, jo_data *d, const jo_solver *s)
{
    return jo_watched(m) ? jo_event_step(m, d, s) : jo_one_step(m, d, s);
}

/* start of a call: the caller may have changed the state, so results of the last evaluation are invalid */
static void invalidate(jo_data *d)
{
    jo_call_begins(d);
    d->events.logged = 0;
    jo_contact_list_begins(d);
    if (JO_COMMON(d->time[0]) != d->run.left) jo_restart(d);
}

/* joint coordinates for models with trees and explicit methods; with error control only without bodies in maximal coordinates */
static int select_coordinates(const jo_model *m, jo_data *d, const jo_solver *s)
{
    return jo_takes_tree(m, s) ? jo_tree_from_maximal(m, d) : JO_OK;
}

int jo_step(const jo_model *m, jo_data *d, const jo_solver *s)
{
    invalidate(d);
    int status = select_coordinates(m, d, s);
    if (status == JO_OK) status = step(m, d, s);
    if (status == JO_OK) status = jo_measure(m, d);
    jo_tree_to_maximal(m, d);
    d->run.left = JO_COMMON(d->time[0]);
    return status;
}

/* count step, rounded before the addition to the start (no FMA): time must not depend on how a run is split into calls */
static double instant(long long count, double step)
{
    volatile double product = (double)count * step;
    return product;
}

/* nsteps steps, with rows at multiples of `every` and at events that stop */
static int run(const jo_model *m, jo_data *d, const jo_solver *s, long long nsteps, long long every,
               long long *count, int *written, jo_real *rows)
{
    const size_t size = (size_t)jo_row_size(m);
    if (!jo_grid_valid(d) || d->run.count != *count || d->run.step != s->step)
        d->run.start = d->time[0] - instant(*count, s->step);
    for (long long i = 0; i < nsteps && (!jo_watched(m) || (jo_log_has_room(m, d) && jo_contact_list_has_room(m, d))); i++) {
        int status = step(m, d, s);
        if (status == JO_EVENT) {
            const int event = d->error_index;
            int failed = jo_measure(m, d);
            if (failed == JO_OK) failed = jo_write_row(m, d, rows + (size_t)*written * size);
            if (failed != JO_OK) return failed;
            d->error_index = event;
            ++*written;
        }
        if (status != JO_OK) return status;
        ++*count;
        d->time[0] = d->run.start + instant(*count, s->step);
        status = jo_measure(m, d);
        if (status != JO_OK) return status;
        if (*count % every == 0) {
            status = jo_write_row(m, d, rows + (size_t)*written * size);
            if (status != JO_OK) return status;
            ++*written;
        }
    }
    return JO_OK;
}

int jo_run(const jo_model *m, jo_data *d, const jo_solver *s, long long nsteps, long long every,
           long long *count, int *written, jo_real *rows)
{
    *written = 0;
    invalidate(d);
    int status = select_coordinates(m, d, s);
    if (status == JO_OK) status = run(m, d, s, nsteps, every, count, written, rows);
    jo_tree_to_maximal(m, d);
    d->run.left = JO_COMMON(d->time[0]);
    jo_grid_left(d, status == JO_OK);
    d->run.count = *count;
    d->run.step = s->step;
    return status;
}
