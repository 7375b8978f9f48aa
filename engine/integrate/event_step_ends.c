/* event_step_ends.c - steps of bounded work: events and transitions of frictions take effect at the ends of steps.
 *
 * An event-capturing scheme (Acary and Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, 2008): no step is shortened or repeated.
 * A slip that has reversed within a step sticks at its end, and a friction that has overcome its static limit slides, both as if they had
 * done so since the instant at which their margin vanished, by linear interpolation; the errors are in friction_step_end.c. Thus friction
 * never drives a slip. Work of a step: one step of the method, one evaluation at its end and, if a state changes, at most two evaluations to
 * stop slips, JO_END_PASSES to find which frictions hold, and one to catch up. What is then still open changes at the end of the next step,
 * and is counted.
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"
#include "friction/friction.h"
#include "contact/contact.h"
#include "integrate/event_parts.h"

/* Mark the slips that have reversed in the step, and compute for each friction that leaves its state the time since then, s, by linear
 * interpolation of its margin. Returns the largest time of the marked ones, 0 if there are none. */
static double find_reversed(const jo_model *m, jo_data *d, double h)
{
    double latest = 0.0;
    for (int i = 0; i < m->nfriction; i++) {
        const int value = m->nevent + i, crosses = jo_crosses(m, d, value, d->events.above[value]);
        const double start = d->events.level[value], end = d->events.above[value];
        double *since = d->events.since + i;
        *since = crosses ? (start > 0.0 ? h * end / (end - start) : h) : 0.0;
        d->events.reversed[i] = crosses && !jo_sticks(m, d, &m->friction[i]);
        if (d->events.reversed[i]) latest = fmax(latest, *since);
    }
    return latest;
}

/* time since which the only friction slides that did not slide in this direction in the step; 0: there is none, or several */
static double only_slide(const jo_model *m, const jo_data *d)
{
    int count = 0;
    double since = 0.0;
    for (int i = 0; i < m->nfriction; i++)
        if (d->slip[i] && (d->events.reversed[i] || !d->events.slip[i])) {
            since = d->events.since[i];
            count++;
        }
    return count == 1 ? since : 0.0;
}

/* transitions of the frictions at the present state; *changed: whether there are any */
static int change_states(const jo_model *m, jo_data *d, double h, int *changed)
{
    const double stopped = find_reversed(m, d, h);
    int status = JO_OK, open = 1;
    *changed = stopped > 0.0;
    if (*changed) status = jo_friction_end_slips(m, d, d->events.reversed, stopped);
    if (status == JO_OK) jo_friction_keep_accelerations(d);
    for (int pass = 0; pass < JO_END_PASSES && open && status == JO_OK; pass++) {
        status = jo_friction_release_all(m, d, &open);
        *changed |= open;
    }
    if (status != JO_OK || !*changed) return status;
    if (open && jo_friction_unsettled(m, d)) d->counts.deferred++;
    const double sliding = only_slide(m, d);
    return sliding > 0.0 ? jo_friction_catch_up(m, d, sliding) : JO_OK;
}

/* the same with the work of friction, which is the energy that is missing, and entries in the log */
static int frictions_settle(const jo_model *m, jo_data *d, double h, int *chain)
{
    jo_energies before, after;
    const jo_work work = d->work;
    int changed;
    for (int i = 0; i < m->nfriction; i++) d->events.slip[i] = d->slip[i];
    jo_energy(m, d, &before);
    int status = change_states(m, d, h, &changed);
    if (!changed || status != JO_OK) return status;
    jo_energy(m, d, &after);
    d->work.friction += before.kinetic - after.kinetic + before.strain - after.strain + before.potential - after.potential
                        + before.springs - after.springs + d->work.forces - work.forces + work.damping - d->work.damping;
    jo_forces_jumped(d);
    for (int i = 0; i < m->nfriction && status == JO_OK; i++)
        if (d->slip[i] != d->events.slip[i]) status = jo_log_entry(m, d, m->nevent + i, d->slip[i], chain);
    return status == JO_OK ? jo_watched_values(m, d, d->events.above) : status;
}

/* events and transitions of frictions at the end of a step of length h */
static int settle(const jo_model *m, jo_data *d, double h, int *stop)
{
    int chain = 0, status = jo_accelerations_valid(d) ? JO_OK : jo_accelerations(m, d);
    if (status != JO_OK) return status;
    jo_add_step_work(d);   /* with the power just before the forces jump */
    for (int i = 0; i < jo_watched(m); i++) d->events.scale[i] = fabs(d->events.above[i] - d->events.level[i]);
    status = jo_events_happen(m, d, JO_END_PASSES, stop, &chain);
    for (int i = 0; i < m->nevent; i++)
        if (status == JO_OK && jo_crosses(m, d, i, d->events.above[i])) {
            d->counts.deferred++;
            break;
        }
    return status == JO_OK && m->nlock ? frictions_settle(m, d, h, &chain) : status;
}

/* a gap that may have closed and opened again within the step stays unresolved, and is reported */
static void note_doubts(const jo_model *m, jo_data *d, double h)
{
    jo_measure_gaps(m, d, 1, h);
    const int doubtful = jo_doubtful_gap(m, d, 0, h);
    if (doubtful >= 0) jo_note_doubt(m, d, doubtful);
}

int jo_step_to_end(const jo_model *m, jo_data *d, const jo_solver *s)
{
    const int first = !jo_levels_valid(d);
    int stop = -1, status = m->nlock ? jo_friction_initialise_states(m, d) : JO_OK;
    jo_locate_no_yielding(m, d);
    if (first && status == JO_OK) status = jo_events_start(m, d);
    double length = s->step;
    if (status == JO_OK && jo_has_contact_sets(d)) status = jo_seek_contacts(m, d, &length);
    if (status == JO_OK && length < s->step) status = JO_TOO_MANY_CONTACTS;
    if (m->nyielding && status == JO_OK) {
        status = jo_yielding_ready(m, d);
        jo_measure_gaps(m, d, 0, s->step);
    }
    if (status == JO_OK) status = jo_one_step(m, d, s);
    if (status == JO_OK) status = jo_watched_values(m, d, d->events.above);
    if (status != JO_OK) return status;
    if (first) jo_set_first_sides(m, d, d->events.above);
    if (m->nyielding) note_doubts(m, d, s->step);
    int chain = 0;
    jo_let_touches_wait(d, 1);
    if (m->nyielding) status = jo_accept_yielding_states(m, d, d->events.above);
    jo_let_touches_wait(d, 0);
    if (status == JO_OK && jo_has_impulses(d)) status = jo_contacts_strike(m, d, s->step, &chain);
    if (status == JO_OK && jo_any_crosses(m, d, d->events.above)) status = settle(m, d, s->step, &stop);
    if (status != JO_OK) return status;
    jo_accept_values(m, d, d->events.above);
    if (stop < 0) return JO_OK;
    d->error_index = stop;
    return JO_EVENT;
}
