/* event_values.c - watched values: sensor value - threshold of the events, then the margins of stick-slip frictions (jo_friction_margin), of
 * forces that yield (jo_yielding_margin) and of rows that are switched (jo_switched_margin). side: sign of each value; of margins 1. */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"
#include "friction/friction.h"
#include "contact/contact.h"
#include "integrate/event_parts.h"

/* ends of branches per step that are located for each force that yields; further ones are not located, and the law holds across them */
enum { JO_YIELDS_EACH = 16 };

/* distance from the threshold, relative to the change in the step, below which a value starts at the threshold */
#define JO_TOUCH 1e-9

/* number of watched values */
int jo_watched(const jo_model *m) { return jo_first_switched(m) + m->nswitched; }

void jo_locate_no_yielding(const jo_model *m, jo_data *d) { d->events.yields = JO_YIELDS_EACH * m->nyielding; }

/* model d->events.watch with the sensors of events only */
void jo_event_setup(const jo_model *m, jo_data *d)
{
    jo_sensor *list = d->events.list;
    d->events.watch = *m;
    d->events.watch.sensor = list;
    d->events.watch.nsensor = 0;
    d->events.demanding = m->nlock > 0;
    for (int i = 0; i < m->nsensor; i++) {
        const jo_sensor *s = &m->sensor[i];
        int used = 0;
        for (int j = 0; j < m->nevent; j++) {
            const int output = m->event[j].output;
            used |= output >= s->offset && output < s->offset + s->count;
        }
        if (!used) continue;
        list[d->events.watch.nsensor++] = *s;
        d->events.demanding |= jo_needs_accelerations(s);
    }
}

/* g = margins of the forces that yield; 1 if their branches have already ended too often in the step */
static int yielding_margins(const jo_model *m, jo_data *d, double *g)
{
    const int status = jo_yielding_ready(m, d);
    if (status != JO_OK) return status;
    const int located = d->events.yields < JO_YIELDS_EACH * m->nyielding;
    for (int k = 0; k < m->nyielding; k++) g[k] = located ? JO_RE(jo_yielding_margin(m, d, k)) : 1.0;
    return JO_OK;
}

/* watched value of an event: that of the sensor, or the size sqrt(sum x^2) of several of its components */
static double measured_value(const jo_event *e, const jo_real *x)
{
    const double first = JO_RE(x[e->output]);
    if (!e->others) return first;
    double sum = first * first;
    for (int k = 0, rest = e->others; rest; k++, rest >>= 1)
        if (rest & 1) sum += JO_RE(x[e->output + 1 + k]) * JO_RE(x[e->output + 1 + k]);
    return sqrt(sum);
}

/* g = watched values at the present state */
int jo_watched_values(const jo_model *m, jo_data *d, double *g)
{
    const int status = jo_ready_sensors(m, d, d->events.demanding);
    if (status != JO_OK) return status;
    if (m->nevent) jo_sensors(&d->events.watch, d, d->events.measured);
    const int first = jo_first_yielding(m);
    for (int i = 0; i < first; i++)
        g[i] = jo_is_event(m, i) ? measured_value(&m->event[i], d->events.measured) - m->event[i].threshold
                              : JO_RE(jo_friction_margin(m, d, i - m->nevent));
    if (m->nswitched) jo_switched_ready(m, d);
    for (int k = 0; k < m->nswitched; k++) g[jo_first_switched(m) + k] = JO_RE(jo_switched_margin(m, d, k));
    return m->nyielding ? yielding_margins(m, d, g + first) : JO_OK;
}

/* whether value i has changed its side in a direction that counts */
int jo_crosses(const jo_model *m, const jo_data *d, int i, double g)
{
    const int now = jo_sign(g), direction = jo_is_event(m, i) ? m->event[i].direction : -1;
    return now && now == -d->events.side[i] && (direction == 0 || direction == now);
}

int jo_any_crosses(const jo_model *m, const jo_data *d, const double *g)
{
    for (int i = 0; i < jo_watched(m); i++)
        if (jo_crosses(m, d, i, g[i])) return 1;
    return 0;
}

/* states at the end of a step of forces that yield, and their margins from then on */
int jo_accept_yielding_states(const jo_model *m, jo_data *d, double *g)
{
    int status = jo_yielding_ready(m, d);
    if (status != JO_OK) return status;
    jo_brief_step(d, 0.0, 1);
    const int jumped = jo_accept_yielding(m, d, 1);
    jo_brief_step(d, 0.0, 0);
    if (jumped) {
        jo_state_changed(d);
        jo_stage_forgotten(d);
        jo_forces_jumped(d);
    }
    /* generalised alpha continues from these states */
    for (int i = 0; i < m->nstate; i++) d->alpha.end_v[m->nv + i] = jo_states(m, d)[i];
    if (m->nlock) {
        status = jo_friction_follow_contacts(m, d);
        if (status != JO_OK) return status;
        for (int i = 0; i < m->nfriction; i++)
            if (m->friction[i].contact >= 0) g[m->nevent + i] = JO_RE(jo_friction_margin(m, d, i));
    }
    return yielding_margins(m, d, g + jo_first_yielding(m));
}

/* accept the values g of the present state: sides, levels, directions of slip; an event that has not yet happened keeps its side */
void jo_accept_values(const jo_model *m, jo_data *d, const double *g)
{
    for (int i = 0; i < jo_watched(m); i++) {
        if (jo_is_event(m, i) && jo_sign(g[i]) && !jo_crosses(m, d, i, g[i])) d->events.side[i] = jo_sign(g[i]);
        d->events.level[i] = g[i];
    }
    if (m->nlock) jo_friction_update_direction(m, d);
}

int jo_events_start(const jo_model *m, jo_data *d)
{
    const int status = jo_watched_values(m, d, d->events.level);
    if (status == JO_OK) jo_record_start(m, d);
    for (int i = 0; i < jo_watched(m); i++) d->events.side[i] = jo_is_event(m, i) ? jo_sign(d->events.level[i]) : 1;
    jo_levels_measured(d);
    return status;
}

/* values that start at their threshold get the side of their first change */
void jo_set_first_sides(const jo_model *m, jo_data *d, const double *g)
{
    for (int i = 0; i < m->nevent; i++)
        if (fabs(d->events.level[i]) <= JO_TOUCH * fabs(g[i] - d->events.level[i])) d->events.side[i] = jo_sign(g[i]);
}

/* contacts that may begin in a step of *length, which is shortened if they are too many */
int jo_seek_contacts(const jo_model *m, jo_data *d, double *length)
{
    int jumped, status = jo_yielding_ready(m, d);
    if (status == JO_OK) status = jo_find_contacts(m, d, length, &jumped);
    if (status != JO_OK) return status;
    if (jumped) {
        jo_state_changed(d);
        jo_forces_jumped(d);
    }
    for (int i = 0; i < m->nstate; i++) d->alpha.end_v[m->nv + i] = jo_states(m, d)[i];
    return jo_watched_values(m, d, d->events.level);
}
