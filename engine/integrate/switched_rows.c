/* switched_rows.c - rows that hold a coordinate s at times: rigid stops at two limits, and locks from one event to another.
 *
 * A stop that is reached at the speed u changes all velocities in an instant:
 *   v+ = v- + (1 + e) (v0 - v-),   L = (1 + e) u / (j M^-1 j^T)
 * v0: velocities with s' = 0 of least change in the norm of the mass matrix, where joints and the rows that hold already are satisfied too;
 * j: row of s; e: restitution, 0 below the speed `slowest` (Newton's law of impact; Pfeiffer, Glocker, Multibody Dynamics with Unilateral
 * Contacts, 1996, chapter 8). The change D = v0 - v- has the kinetic energy T = u^2 / (2 j M^-1 j^T), so the impulse is
 * L = (1 + e) 2 T / u, and (1 - e^2) T is dissipated. With e = 0 the row holds s at the limit until its force would pull. A lock holds the
 * value of s at its event; e = 0. */
#include "valid.h"
#include "maximal/maximal.h"
#include "friction/friction.h"
#include "tree/tree.h"
#include "integrate/integrate.h"

/* impacts of a stop in one instant, from which on it does not rebound: several stops that strike in turn do so infinitely often */
enum { JO_REBOUNDS = 5 };
#define JO_INSTANT 1e-2     /* time between two impacts of a stop, relative to the step, below which they count as one instant */
enum { JO_PIVOTS = 8, JO_PIVOTS_EACH = 4 };   /* largest number of pivots of an impact: constant part, and part per row */
#define JO_TOUCHES 1e-10    /* distance from a limit, rad or relative to the size of the mechanism, at which a stop is at it */
/* speed, relative to the slowest of a stop, below which a coordinate does not approach its limit */
#define JO_NO_APPROACH 1e-9
/* speed, relative to the slowest, up to which a coordinate at its limit is at rest there: stops that open each other in turn come to rest */
#define JO_AT_REST 1e-3

static const jo_line *line_of(const jo_model *m, const jo_switched *s) { return &m->line[m->joint[s->joint].line]; }
static int coordinate_of(const jo_model *m, const jo_switched *s) { return line_of(m, s)->coordinate[0]; }
static int *lock_of(const jo_model *m, jo_data *d, const jo_switched *s) { return &d->locked[m->joint[s->joint].lock]; }
static jo_real *held_of(const jo_model *m, jo_data *d, const jo_switched *s) { return &d->held[2 * m->joint[s->joint].lock]; }
static int is_stop(const jo_switched *s) { return s->begin < 0; }
static int holds(const jo_model *m, const jo_data *d, const jo_switched *s) { return d->locked[m->joint[s->joint].lock]; }

/* 1 above the middle of the limits, else -1 */
static int side_of(const jo_switched *s, jo_real value)
{
    return JO_RE(value - s->data->lower) > JO_RE(s->data->upper - value) ? 1 : -1;
}

/* distance from the nearer limit, and the speed of approach to it */
typedef struct { int side; jo_real limit, gap, approach; } nearest;
static nearest nearest_limit(const jo_model *m, const jo_data *d, const jo_switched *s)
{
    const jo_coordinate_work *w = &d->coordinate[coordinate_of(m, s)];
    nearest y;
    y.side = side_of(s, w->value);
    y.limit = y.side > 0 ? s->data->upper : s->data->lower;
    y.gap = y.side * (y.limit - w->value);
    y.approach = y.side * w->rate;
    return y;
}

static int approaches(const jo_switched *s, const nearest *y) { return JO_RE(y->approach) > JO_NO_APPROACH * JO_RE(s->data->slowest); }

/* force of the row along its coordinate, N or N m */
static jo_real force_of(const jo_model *m, const jo_data *d, const jo_switched *s)
{
    if (jo_tree_active(d)) return jo_tree_row_force(m, d, coordinate_of(m, s));
    return -d->lam[m->joint[s->joint].row] * line_of(m, s)->data->factor[0];
}

/* values and rates of the coordinates, after the markers of the present state */
void jo_switched_ready(const jo_model *m, jo_data *d)
{
    jo_marker_position(m, d, m->nactive);
    jo_marker_velocity(m, d, m->nactive);
    for (int k = 0; k < m->nswitched; k++) {
        const int c = coordinate_of(m, &m->switched[k]);
        jo_coordinate_value(m, d, c);
        jo_coordinate_rate(m, d, c);
    }
}

/* positive while a stop does not change: the gap, or the force that pushes away from the limit. A gap that is closed by rounding, or that
 * opens, does not count. */
jo_real jo_switched_margin(const jo_model *m, const jo_data *d, int k)
{
    const jo_switched *s = &m->switched[k];
    if (!is_stop(s)) return jo_same(1.0);
    if (holds(m, d, s)) return -side_of(s, d->held[2 * m->joint[s->joint].lock]) * force_of(m, d, s);
    const nearest y = nearest_limit(m, d, s);
    return JO_RE(y.gap) < 0.0 && !approaches(s, &y) ? -y.gap : y.gap;
}

void jo_switched_step(jo_data *d, double length) { d->events.instant = JO_INSTANT * length; }

/* an event begins or ends locks; the second held number of a lock says whether it shall hold */
void jo_switched_event(const jo_model *m, jo_data *d, int event)
{
    for (int k = 0; k < m->nswitched; k++) {
        const jo_switched *s = &m->switched[k];
        if (s->begin == event) held_of(m, d, s)[1] = jo_same(1.0);
        if (s->end == event) held_of(m, d, s)[1] = jo_same(0.0);
    }
}

/* ---- changes ------------------------------------------------------------------------------------------ */

static jo_real *velocities(jo_data *d) { return jo_tree_active(d) ? d->u : d->v; }

/* v += factor change, and the kinetic energy then */
static jo_real kinetic_at(const jo_model *m, jo_data *d, double factor, const jo_real *change)
{
    jo_real *v = velocities(d);
    const int n = jo_tree_active(d) ? m->nu : m->nv;
    for (int i = 0; i < n; i++) v[i] += factor * change[i];
    jo_state_changed(d);
    if (jo_tree_active(d)) jo_positions_moved(d);
    jo_energies y;
    jo_energy(m, d, &y);
    return y.kinetic;
}

/* velocities v0 that satisfy all rows that hold, from `before` */
static int project(const jo_model *m, jo_data *d, const jo_real *before)
{
    const int n = jo_tree_active(d) ? m->nu : m->nv;
    for (int i = 0; i < n; i++) velocities(d)[i] = before[i];
    jo_state_changed(d);
    if (jo_tree_active(d)) jo_positions_moved(d);
    const int status = jo_accelerations(m, d);   /* the factors of the rows that hold now */
    if (status != JO_OK) return status;
    if (jo_tree_active(d)) {
        jo_tree_stop_sticking(m, d);
        jo_tree_hold_sticking(m, d);
    } else {
        jo_project(m, d, &jo_now);
    }
    return JO_OK;
}

/* whether a stop is at a limit */
static int touches(const jo_model *m, const jo_data *d, const jo_switched *s)
{
    const int angle = m->coordinate[coordinate_of(m, s)].type == JO_COORDINATE_ANGLE;
    if (!is_stop(s)) return 0;
    return holds(m, d, s) || fabs(JO_RE(nearest_limit(m, d, s).gap)) <= JO_TOUCHES * (angle ? 1.0 : m->size);
}

static int leaves(const jo_switched *s, const nearest *y) { return JO_RE(y->approach) < -JO_AT_REST * JO_RE(s->data->slowest); }

/* The first stop at a limit, other than the one that is struck, that is on the wrong side: it is free and approaches at the velocities v0, or
 * it holds and leaves as soon as it is free, since its impulse would pull; -1: none. *disturbed: whether v0 has to be computed again. */
static int wrong_side(const jo_model *m, jo_data *d, const jo_switched *struck, const jo_real *before, int *disturbed, int *status)
{
    int found = m->nswitched;
    *disturbed = 0;
    (void)jo_ready_sensors(m, d, 0);
    jo_switched_ready(m, d);
    for (int k = m->nswitched - 1; k >= 0; k--) {
        const jo_switched *s = &m->switched[k];
        if (s == struck || !touches(m, d, s) || holds(m, d, s)) continue;
        const nearest y = nearest_limit(m, d, s);
        if (approaches(s, &y)) found = k;
    }
    for (int k = 0; k < found; k++) {
        const jo_switched *s = &m->switched[k];
        if (s == struck || !is_stop(s) || !holds(m, d, s)) continue;
        *lock_of(m, d, s) = 0;
        *disturbed = 1;
        *status = project(m, d, before);
        if (*status != JO_OK) return -1;
        (void)jo_ready_sensors(m, d, 0);
        jo_switched_ready(m, d);
        const nearest y = nearest_limit(m, d, s);
        *lock_of(m, d, s) = 1;
        if (leaves(s, &y)) return k;
    }
    return found < m->nswitched ? found : -1;
}

/* hold a stop at its limit, or open it */
static void flip(const jo_model *m, jo_data *d, const jo_switched *s)
{
    if (!holds(m, d, s)) *held_of(m, d, s) = nearest_limit(m, d, s).limit;
    *lock_of(m, d, s) ^= 1;
}

/* Velocities v0 and the stops that hold: no stop at a limit approaches it, and none pulls, by principal pivots of least index (K. G. Murty,
 * Linear Complementarity, Linear and Nonlinear Programming, 1988, section 4.3). */
static int least_change(const jo_model *m, jo_data *d, const jo_switched *struck, const jo_real *before)
{
    int status = project(m, d, before), disturbed = 0;
    for (int round = 0; status == JO_OK && round < JO_PIVOTS + JO_PIVOTS_EACH * m->nswitched; round++) {
        const int k = wrong_side(m, d, struck, before, &disturbed, &status);
        if (k < 0) break;
        flip(m, d, &m->switched[k]);
        status = project(m, d, before);
        disturbed = 0;
    }
    return status == JO_OK && disturbed ? project(m, d, before) : status;
}

/* The row of s is held at a value: all velocities jump, with the restitution e. The kinetic energy of the change D = v0 - v- follows from
 * those at v0 - D, v0 and v0 + D. What the kinetic energy changes besides the loss is work of drives, whose speeds do not jump. */
static int impact(const jo_model *m, jo_data *d, const jo_switched *s, jo_real value, jo_real speed, jo_real e, double *impulse)
{
    const int n = jo_tree_active(d) ? m->nu : m->nv;
    jo_real *before = d->events.rates, *change = before + n;
    for (int i = 0; i < n; i++) {
        before[i] = velocities(d)[i];
        change[i] = jo_same(0.0);
    }
    /* friction has no impulse, so that no joint sticks in an impact; jo_friction_initialise_states decides afterwards */
    for (int i = 0; i < m->nfriction; i++)
        if (jo_sticks(m, d, &m->friction[i])) d->locked[m->joint[m->friction[i].lock].lock] = d->slip[i] = 0;
    *held_of(m, d, s) = value;
    *lock_of(m, d, s) = 1;
    const jo_real T = kinetic_at(m, d, 0.0, change);
    const int status = least_change(m, d, s, before);
    if (status != JO_OK) return status;
    for (int i = 0; i < n; i++) change[i] = velocities(d)[i] - before[i];
    const jo_real least = kinetic_at(m, d, 0.0, change), mirrored = kinetic_at(m, d, 1.0, change);
    const jo_real moved = 0.5 * (T + mirrored) - least, loss = (1.0 - e * e) * moved;
    const jo_real after = kinetic_at(m, d, JO_RE(e) - 1.0, change);
    if (JO_RE(e) > 0.0) *lock_of(m, d, s) = 0;
    jo_switched_ready(m, d);
    for (int k = 0; k < m->nswitched && JO_RE(e) > 0.0; k++) {   /* stops that were reached in the same instant rebound too */
        const jo_switched *other = &m->switched[k];
        if (!is_stop(other) || !holds(m, d, other)) continue;
        const nearest y = nearest_limit(m, d, other);
        if (leaves(other, &y)) *lock_of(m, d, other) = 0;
    }
    d->work.damping += loss;
    d->work.forces += after - T + loss;
    *impulse = JO_RE(speed) > 0.0 ? JO_RE(2.0 * (1.0 + e) * moved / speed) : 0.0;
    return JO_OK;
}

/* locks as their events say; 1 if any has changed */
static int locks_follow(const jo_model *m, jo_data *d, int *which, double *impulse, int *status)
{
    for (int k = 0; k < m->nswitched; k++) {
        const jo_switched *s = &m->switched[k];
        if (is_stop(s)) continue;
        const int wanted = JO_RE(held_of(m, d, s)[1]) != 0.0;
        if (wanted == holds(m, d, s)) continue;
        *which = k;
        *impulse = -1.0;
        if (!wanted) {
            *lock_of(m, d, s) = 0;
            return 1;
        }
        const jo_coordinate_work w = d->coordinate[coordinate_of(m, s)];
        *status = impact(m, d, s, w.value, jo_size(w.rate), jo_same(0.0), impulse);
        return 1;
    }
    return 0;
}

/* the stop whose limit is reached at the largest speed, in units of its slowest one; -1: none */
static int fastest(const jo_model *m, const jo_data *d)
{
    int found = -1;
    double most = 0.0;
    for (int k = 0; k < m->nswitched; k++) {
        const jo_switched *s = &m->switched[k];
        if (!is_stop(s) || holds(m, d, s)) continue;
        const nearest y = nearest_limit(m, d, s);
        const double speed = JO_RE(y.approach) / JO_RE(s->data->slowest);
        if (JO_RE(y.gap) > 0.0 || !approaches(s, &y) || speed <= most) continue;
        most = speed;
        found = k;
    }
    return found;
}

static jo_real acceleration_of(const jo_model *m, const jo_data *d, const jo_switched *s)
{
    const int c = coordinate_of(m, s);
    return jo_tree_active(d) ? jo_tree_slip_acceleration(m, d, c) : jo_coordinate_acceleration(m, d, c);
}

/* The first stop at rest at a limit on the wrong side: it holds and pulls, or it is free and accelerated towards the limit; -1: none. */
static int unsettled(const jo_model *m, const jo_data *d)
{
    for (int k = 0; k < m->nswitched; k++) {
        const jo_switched *s = &m->switched[k];
        const double slow = JO_NO_APPROACH * JO_RE(s->data->slowest);
        if (!touches(m, d, s)) continue;
        if (holds(m, d, s)) {
            if (JO_RE(jo_switched_margin(m, d, k)) < 0.0) return k;
            continue;
        }
        const nearest y = nearest_limit(m, d, s);
        if (fabs(JO_RE(y.approach)) <= JO_AT_REST * JO_RE(s->data->slowest) && y.side * JO_RE(acceleration_of(m, d, s)) > slow) return k;
    }
    return -1;
}

/* One change of a row at the present state, after jo_switched_ready: *which, or -1 if there is none; its impulse, N s or N m s, or -1 for a
 * row that opens. */
int jo_switch_next(const jo_model *m, jo_data *d, int *which, double *impulse)
{
    int status = JO_OK;
    *which = -1;
    *impulse = -1.0;
    if (!locks_follow(m, d, which, impulse, &status)) {
        *which = fastest(m, d);
        if (*which >= 0) {
            const jo_switched *s = &m->switched[*which];
            const nearest y = nearest_limit(m, d, s);
            double *last = d->events.struck + 2 * *which;   /* time of its last impact, and number of impacts in this instant */
            last[1] = JO_RE(d->time[0]) - last[0] < d->events.instant ? last[1] + 1.0 : 1.0;
            last[0] = JO_RE(d->time[0]);
            const int rebounds = last[1] <= JO_REBOUNDS && JO_RE(y.approach) > JO_RE(s->data->slowest);
            const jo_real e = rebounds ? s->data->restitution : jo_same(0.0);
            status = impact(m, d, s, y.limit, y.approach, e, impulse);
        } else {
            *which = unsettled(m, d);
            if (*which >= 0 && !holds(m, d, &m->switched[*which])) {
                const jo_switched *s = &m->switched[*which];
                status = impact(m, d, s, nearest_limit(m, d, s).limit, jo_same(0.0), jo_same(0.0), impulse);
            } else if (*which >= 0) {
                flip(m, d, &m->switched[*which]);
            }
        }
    }
    if (*which < 0 || status != JO_OK) return status;
    jo_state_changed(d);
    jo_forces_jumped(d);
    if (m->nfriction) status = jo_friction_initialise_states(m, d);
    if (status == JO_OK) status = jo_ready_sensors(m, d, 1);
    if (status == JO_OK) jo_switched_ready(m, d);
    return status;
}
