/* event_effects.c - what happens at events and at the transitions of frictions, and its log. */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"
#include "friction/friction.h"
#include "contact/contact.h"
#include "integrate/event_parts.h"
#include <limits.h>
#include <string.h>

enum { JO_LOG_ENTRIES = 32, JO_LOG_ENTRIES_EACH = 8 };   /* log entries of one step: constant part, and part per watched value */
enum { JO_LOG_ENTRIES_SWITCHED = 128 };   /* further ones per stop: several stops that strike in turn come to rest in a row of impacts */
enum { JO_LOG_STEPS = 4 };      /* number of steps for which the log has room */
#define JO_JUMP 1e-6        /* jump of a value at an event, relative to its change in the step, below which the jump is round-off */

/* largest number of log entries of one step; more entries indicate an endless chain of events */
static int max_entries(const jo_model *m)
{
    return JO_LOG_ENTRIES + JO_LOG_ENTRIES_EACH * jo_watched(m) + JO_LOG_ENTRIES_SWITCHED * m->nswitched;
}

int jo_log_entry(const jo_model *m, jo_data *d, int i, double value, int *chain)
{
    double *entry = d->events.log + 3 * d->events.logged;
    if (++*chain > max_entries(m)) {
        d->error_index = i;
        return JO_ENDLESS;
    }
    d->events.logged++;
    entry[0] = JO_RE(d->time[0]);
    entry[1] = i;
    entry[2] = value;
    return JO_OK;
}

/* occurrence of event i; the energy of springs that it releases is dissipated */
static void apply_event(const jo_model *m, jo_data *d, int i)
{
    jo_energies before, after;
    int loses = 0;
    for (int j = 0; j < m->nforce; j++) loses |= m->force[j].release == i && !d->happened[i];
    if (loses) jo_energy(m, d, &before);
    d->happened[i]++;
    jo_switched_event(m, d, i);
    d->events.side[i] = jo_sign(d->events.above[i]);
    if (!loses) return;
    jo_energy(m, d, &after);
    d->work.damping += before.springs - after.springs;
    jo_record_release(m, d);
}

/* handle the events at the present state and, repeatedly, the events that they cause, at most `rounds` times; *stop: first event that ends
 * the run, or -1 */
int jo_events_happen(const jo_model *m, jo_data *d, int rounds, int *stop, int *chain)
{
    for (int round = 0; round < rounds; round++) {
        const int before = d->events.logged;
        for (int i = 0; i < m->nevent; i++) {
            if (!jo_crosses(m, d, i, d->events.above[i])) continue;
            const int status = jo_log_entry(m, d, i, jo_sign(d->events.above[i]), chain);
            if (status != JO_OK) return status;
            apply_event(m, d, i);
            if (m->event[i].stop && *stop < 0) *stop = i;
        }
        if (d->events.logged == before) break;
        jo_state_changed(d);   /* forces have changed */
        jo_forces_jumped(d);
        memcpy(d->events.below, d->events.above, (size_t)m->nevent * sizeof *d->events.below);
        const int status = jo_watched_values(m, d, d->events.above);
        if (status != JO_OK) return status;
        for (int i = 0; i < m->nevent; i++) {   /* changes by round-off do not count as crossings */
            const double jump = fabs(d->events.above[i] - d->events.below[i]), small = JO_JUMP * d->events.scale[i];
            if (jo_crosses(m, d, i, d->events.above[i]) && !(fabs(d->events.above[i]) > small && jump > small)) d->events.above[i] = 0.0;
        }
    }
    return JO_OK;
}

/* frictions whose margin is exceeded at the present state */
static int frictions_switch(const jo_model *m, jo_data *d, int *chain)
{
    const int *before = (const int *)(d->events.start.state + ((char *)d->slip - d->state));
    const int logged = d->events.logged;
    int last = -1, status = JO_OK;
    for (int i = m->nevent; i < jo_first_yielding(m) && status == JO_OK; i++)
        if (jo_crosses(m, d, i, d->events.above[i])) {
            status = jo_friction_switch(m, d, i - m->nevent);
            last = i;
        }
    if (last < 0 || status != JO_OK) return status;
    jo_forces_jumped(d);
    for (int k = 0; k < m->nfriction && status == JO_OK; k++)
        if (d->slip[k] != before[k]) status = jo_log_entry(m, d, m->nevent + k, d->slip[k], chain);
    if (d->events.logged == logged && status == JO_OK && ++*chain > max_entries(m)) {   /* the state is unchanged after a transition */
        d->error_index = last;
        status = JO_ENDLESS;
    }
    return status == JO_OK ? jo_watched_values(m, d, d->events.above) : status;
}

/* rows that are switched at the present state, one after the other */
static int rows_switch(const jo_model *m, jo_data *d, int *chain)
{
    /* place in the log: after the events and the frictions */
    const int first = m->nevent + m->nfriction, logged = d->events.logged;
    int status = JO_OK, which = 0;
    jo_switched_ready(m, d);
    while (status == JO_OK) {
        double impulse;
        status = jo_switch_next(m, d, &which, &impulse);
        if (status != JO_OK || which < 0) break;
        status = jo_log_entry(m, d, first + which, impulse, chain);
    }
    return status == JO_OK && d->events.logged != logged ? jo_watched_values(m, d, d->events.above) : status;
}

/* bodies strike each other at the present state: at a located instant until none strikes, or once at the end of a step of bounded work of
 * length h */
int jo_contacts_strike(const jo_model *m, jo_data *d, double h, int *chain)
{
    const int first = m->nevent + m->nfriction + m->nswitched;
    int status = JO_OK, struck = 1, any = 0, which = 0;
    jo_let_touches_wait(d, h > 0.0);
    while (status == JO_OK && struck && !(any && h > 0.0)) {
        double impulse;
        status = jo_strike_all(m, d, h, &struck);
        if (status != JO_OK || !struck) break;
        any = 1;
        jo_forces_jumped(d);
        if (m->nfriction) status = jo_friction_initialise_states(m, d);
        for (int k = 0; status == JO_OK && (which = jo_struck_force(d, k, &impulse)) >= 0; k++)
            status = jo_log_entry(m, d, first + which, impulse, chain);
    }
    jo_let_touches_wait(d, 0);
    if (!any || status != JO_OK) return status;
    status = jo_accept_yielding_states(m, d, d->events.above);
    return status == JO_OK ? jo_watched_values(m, d, d->events.above) : status;
}

/* events, friction transitions and rows that are switched at the present state */
int jo_all_happen(const jo_model *m, jo_data *d, int *stop, int *chain)
{
    *stop = -1;
    /* work of the step, with the power just before the forces jump */
    int status = jo_accelerations_valid(d) ? JO_OK : jo_accelerations(m, d);
    if (status != JO_OK) return status;
    jo_add_step_work(d);
    d->events.yields++;
    if (m->nyielding) status = jo_accept_yielding_states(m, d, d->events.above);
    if (status == JO_OK && jo_has_impulses(d)) status = jo_contacts_strike(m, d, 0.0, chain);
    if (status == JO_OK) status = jo_events_happen(m, d, INT_MAX, stop, chain);
    if (status == JO_OK && m->nlock) {
        const int before = d->events.logged;
        status = frictions_switch(m, d, chain);
        if (status == JO_OK && d->events.logged != before) status = jo_events_happen(m, d, INT_MAX, stop, chain);
    }
    if (status == JO_OK && m->nswitched) {
        const int before = d->events.logged;
        status = rows_switch(m, d, chain);
        if (status == JO_OK && d->events.logged != before) status = jo_events_happen(m, d, INT_MAX, stop, chain);
    }
    if (status == JO_OK) jo_accept_values(m, d, d->events.above);
    return status;
}

int jo_log_room(const jo_model *m) { return jo_watched(m) ? JO_LOG_STEPS * max_entries(m) : 0; }

/* whether the log has room for the entries of another step */
int jo_log_has_room(const jo_model *m, const jo_data *d) { return d->events.logged + max_entries(m) <= jo_log_room(m); }
