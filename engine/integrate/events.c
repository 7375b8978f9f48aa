/* events.c - zero crossings: detected at the end of a step, located in time by repetition of the step with other lengths. */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"
#include "friction/friction.h"
#include "contact/contact.h"
#include "integrate/event_parts.h"
#include <float.h>
#include <string.h>

enum { JO_MAX_TRIALS = 120 };   /* largest number of steps tried for one crossing: three times the 40 bisections from 1 s to 1e-12 s */

#define JO_TIME_RESOLUTION 1e-12    /* largest error of the time of an event, s */
#define JO_TIME_ROUNDING (8.0 * DBL_EPSILON)   /* the same relative to the time, for times whose round-off is larger */
/* part of the planned step below which a step is not shortened any more to find a gap that closes for a moment */
#define JO_TOUCH_RESOLUTION 1e-9
#define JO_SHORTEST_PART 1e-4   /* part of the step below which a step without convergence is not shortened any more */
#define JO_VALUE_ROUNDING (2.0 * DBL_EPSILON)   /* distance from the threshold, relative to the threshold, that is round-off */

static double time_resolution(const jo_data *d) { return fmax(JO_TIME_RESOLUTION, JO_TIME_ROUNDING * fabs(JO_RE(d->time[0]))); }

/* -- saved state at the start of a step --------------------------------------------------- */

static void save_state(jo_data *d)
{
    jo_step_start *k = &d->events.start;
    memcpy(k->state, d->state, d->state_bytes);
    k->time = d->time[0];
    k->work = d->work;
    k->power = d->power;
    k->power0 = d->power0;
    k->drive = d->drive;
    k->waiting = d->waiting;
    k->valid = jo_valid_now(d);
}

static void restore_state(jo_data *d)
{
    const jo_step_start *k = &d->events.start;
    memcpy(d->state, k->state, d->state_bytes);
    d->time[0] = k->time;
    d->work = k->work;
    d->power = k->power;
    d->power0 = k->power0;
    d->drive = k->drive;
    d->waiting = k->waiting;
    jo_step_repeated(d, &k->valid);
}

/* -- location in time ------------------------------------------------------------------------- */

/* earliest crossing between a and b by linear interpolation of the weighted values (regula falsi); a, if a value is beyond its threshold there */
static double estimate_crossing(const jo_model *m, const jo_data *d, double a, double b, double wa, double wb)
{
    double first = b;
    for (int i = 0; i < jo_watched(m); i++) {
        if (!jo_crosses(m, d, i, d->events.above[i])) continue;
        const double ga = wa * d->events.side[i] * d->events.below[i], gb = wb * fabs(d->events.above[i]);
        const double x = ga > 0.0 ? a + (b - a) * (ga / (ga + gb)) : ga < 0.0 ? a : 0.5 * (a + b);
        if (x < first) first = x;
    }
    return first;
}

/* whether all crossing values equal their thresholds to round-off */
static int at_threshold(const jo_model *m, const jo_data *d)
{
    for (int i = 0; i < jo_watched(m); i++) {
        const double small = JO_VALUE_ROUNDING * fmax(jo_is_event(m, i) ? fabs(m->event[i].threshold) : 0.0, d->events.scale[i]);
        if (jo_crosses(m, d, i, d->events.above[i]) && !(fabs(d->events.above[i]) <= small)) return 0;
    }
    return 1;
}

static int try_step(const jo_model *m, jo_data *d, const jo_solver *s, double length, double *g)
{
    jo_solver part = *s;
    part.step = length;
    restore_state(d);
    if (m->nyielding) jo_forget_speeds(m, d);
    const int status = jo_one_step(m, d, &part);
    return status == JO_OK ? jo_watched_values(m, d, g) : status;
}

/* Length of the step from the saved state to just after the first crossing: Illinois method in the bracket [a, b], with bisection if three
 * trials do not halve it. Values at the start: level, at the end: above. */
static int locate(const jo_model *m, jo_data *d, const jo_solver *s, double *length)
{
    const double narrow = time_resolution(d);
    double a = 0.0, b = *length, at = b, wa = 1.0, wb = 1.0, before = 4.0 * b;
    int last = 0;
    memcpy(d->events.below, d->events.level, (size_t)jo_watched(m) * sizeof *d->events.below);
    for (int k = 0; k < JO_MAX_TRIALS && b - a > narrow && !(at == b && at_threshold(m, d)); k++) {
        double x = estimate_crossing(m, d, a, b, wa, wb);
        if (k % 3 == 2) {   /* bisection if the last three trials did not halve the bracket */
            if (b - a > 0.5 * before) x = 0.5 * (a + b);
            before = b - a;
        }
        x = fmin(fmax(x, a + 0.5 * narrow), b - 0.5 * narrow);
        const int status = try_step(m, d, s, x, d->events.trial);
        if (status != JO_OK) return status;
        at = x;
        const int side = jo_any_crosses(m, d, d->events.trial) ? 1 : -1;
        double **end = side > 0 ? &d->events.above : &d->events.below, *values_at = *end;
        *end = d->events.trial;
        d->events.trial = values_at;
        if (side > 0) b = x;
        else a = x;
        if (side == last) {   /* the same end was replaced twice: halve the weight of the other end */
            if (side > 0) wa *= 0.5;
            else wb *= 0.5;
        } else {
            wa = wb = 1.0;
        }
        last = side;
    }
    *length = b;
    return at == b ? JO_OK : try_step(m, d, s, b, d->events.above);
}

/* Shorten a step of *length to its first crossing, and then until no gap can have closed within it; *found: whether it ends at a crossing */
static int first_crossing(const jo_model *m, jo_data *d, const jo_solver *s, double *length, int *found)
{
    for (int halved = 0;; halved++) {
        *found = jo_any_crosses(m, d, d->events.above);
        if (*found) {
            for (int i = 0; i < jo_watched(m); i++) d->events.scale[i] = fabs(d->events.above[i] - d->events.level[i]);
            const int status = locate(m, d, s, length);
            if (status != JO_OK) return status;
        }
        if (!m->nyielding) return JO_OK;
        jo_measure_gaps(m, d, 1, *length);
        const int doubtful = jo_doubtful_gap(m, d, 1, *length);
        if (doubtful < 0) {
            jo_note_proof(d, halved, *found);
            return JO_OK;
        }
        if (*length < JO_TOUCH_RESOLUTION * s->step) {
            if (!jo_closed_at_end(m, d, doubtful)) jo_note_doubt(m, d, doubtful);   /* else that is the touch at its end */
            return JO_OK;
        }
        *length *= 0.5;
        restore_state(d);
        int status = jo_yielding_ready(m, d);
        if (status == JO_OK) jo_measure_gaps(m, d, 0, *length);   /* what may turn within the shorter step */
        if (status == JO_OK) status = try_step(m, d, s, *length, d->events.above);
        if (status != JO_OK) return status;
    }
}

/* -- steps of fixed length --------------------------------------------------------------------- */

/* longest step from the present state that resolves the forces that yield, s */
double jo_resolved(const jo_model *m, jo_data *d, int explicit_method)
{
    return jo_yielding_ready(m, d) == JO_OK ? jo_yielding_longest_step(m, d, explicit_method) : INFINITY;
}

/* One part of a step, of *length at most, up to the first event in it; *found: whether it ends at an event. */
static int part_step(const jo_model *m, jo_data *d, const jo_solver *s, int first, double *length, int *found, int *chain)
{
    jo_solver part = *s;
    int status = jo_has_contact_sets(d) ? jo_seek_contacts(m, d, length) : JO_OK;
    if (status != JO_OK) return status;
    part.step = *length;
    save_state(d);
    if (m->nyielding) jo_measure_gaps(m, d, 0, *length);
    status = jo_one_step(m, d, &part);
    if (status == JO_OK) status = jo_watched_values(m, d, d->events.above);
    if (status != JO_OK) return status;
    if (first) jo_set_first_sides(m, d, d->events.above);
    status = first_crossing(m, d, s, length, found);
    if (status != JO_OK || *found) return status;
    if (m->nyielding) status = jo_accept_yielding_states(m, d, d->events.above);
    if (status == JO_OK && jo_has_impulses(d)) status = jo_contacts_strike(m, d, 0.0, chain);
    if (status == JO_OK) jo_accept_values(m, d, d->events.above);
    return status;
}

/* After a part that did not converge, or led to no finite state: back to its start with eased forces or, if there are none, with half of its
 * length: forces have kinks where a contact begins and where a slip ends, over which Newton's iteration may oscillate. 0 if the part is too
 * short already. */
static int try_again(const jo_model *m, jo_data *d, const jo_solver *s, double *longest, double length)
{
    if (!m->nyielding || !(length > JO_SHORTEST_PART * s->step)) return 0;
    restore_state(d);
    if (jo_ease_yielding(m, d)) {
        jo_state_changed(d);
        jo_forces_jumped(d);
    } else {
        *longest = 0.5 * length;
    }
    return 1;
}

/* forces that the next step of a method treats as an explicit one: contacts are in the matrix of ROS2 if all of them fit */
static int explicit_forces(const jo_model *m, jo_data *d, const jo_solver *s)
{
    if (s->method == JO_METHOD_alpha) return JO_EXPLICIT_NONE;
    return jo_contacts_in_matrix(jo_method_tableau(s->method)) && jo_contacts_fit(m, d) ? JO_EXPLICIT_OUTSIDE : JO_EXPLICIT_ALL;
}

/* step of length s->step in parts that end at events */
int jo_event_step(const jo_model *m, jo_data *d, const jo_solver *s)
{
    if (s->step_ends) return jo_step_to_end(m, d, s);
    const double end = s->step;
    double done = 0.0, longest = end;
    int chain = 0, first = !jo_levels_valid(d), found;
    d->events.yields = 0;
    jo_switched_step(d, end);
    jo_brief_step(d, end, 0);
    int status = m->nlock ? jo_friction_initialise_states(m, d) : JO_OK;
    if (first && status == JO_OK) status = jo_events_start(m, d);
    while (status == JO_OK && end - done > time_resolution(d)) {
        double length = fmin(end - done, longest);
        if (m->nyielding) length = fmin(length, jo_resolved(m, d, explicit_forces(m, d, s)));
        const double wanted = length;
        status = part_step(m, d, s, first, &length, &found, &chain);
        if ((status == JO_NO_CONVERGENCE || status == JO_NOT_FINITE) && try_again(m, d, s, &longest, wanted)) {
            status = JO_OK;
            continue;
        }
        if (status != JO_OK) break;
        first = 0;
        longest = end;
        done += length;
        int stop;
        if (!found) continue;
        status = jo_all_happen(m, d, &stop, &chain);
        if (status == JO_OK && stop >= 0) {
            d->error_index = stop;
            return JO_EVENT;
        }
    }
    return status;
}

/* -- steps of variable length ------------------------------------------------------------------- */

int jo_event_keep(const jo_model *m, jo_data *d)
{
    int status = jo_levels_valid(d) ? JO_OK : jo_events_start(m, d);
    save_state(d);
    jo_keep_contact_losses(m, d);
    if (status == JO_OK && m->nyielding) status = jo_yielding_ready(m, d);
    if (status == JO_OK && m->nyielding) jo_measure_gaps(m, d, 0, INFINITY);
    return status;
}

/* shorten the step of *length from the saved state to its first crossing; *found: whether there is one */
int jo_event_find(const jo_model *m, jo_data *d, const jo_solver *s, int first, double *length, int *found)
{
    *found = 0;
    jo_switched_step(d, *length);
    jo_brief_step(d, *length, 0);
    int status = jo_watched_values(m, d, d->events.above);
    if (status != JO_OK) return status;
    if (first) jo_set_first_sides(m, d, d->events.above);
    const long long steps = d->counts.steps;
    status = first_crossing(m, d, s, length, found);
    d->counts.steps = steps;
    if (status != JO_OK || *found) return status;
    d->events.yields = 0;
    int chain = 0;
    if (m->nyielding) status = jo_accept_yielding_states(m, d, d->events.above);
    if (status == JO_OK && jo_has_impulses(d)) status = jo_contacts_strike(m, d, 0.0, &chain);
    if (status == JO_OK) jo_accept_values(m, d, d->events.above);
    return status;
}

int jo_event_happen(const jo_model *m, jo_data *d, int *chain)
{
    int stop;
    const int status = jo_all_happen(m, d, &stop, chain);
    if (status != JO_OK || stop < 0) return status;
    d->error_index = stop;
    return JO_EVENT;
}
