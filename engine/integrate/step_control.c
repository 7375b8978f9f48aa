/* step_control.c - runs with error control: lengths of the steps of step_dormand_prince.c, and rows between the steps.
 *
 * Control as in Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), II.4.
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"
#include "contact/contact.h"
#include "beam/beam.h"
#include "friction/friction.h"
#include "tree/tree.h"
#include "integrate/integrate.h"
#include "fatigue/fatigue.h"
#include <float.h>

#define JO_MAX_ROTATION 1.0     /* planned largest rotation of a body in a step, rad; a step with twice this rotation is rejected */
/* motion of a body relative to the motion of the mechanism, below which its errors are relative to the latter */
#define JO_SMALL_SHARE 1e-3
#define JO_MIN_RATE 1e-6        /* smallest rate, 1/s, from which the first step is computed as its inverse */
/* exponent of the error: 1 / 5, since the error of the pair is proportional to the fifth power of the step length */
#define JO_ERROR_ORDER 0.2
/* constants of the code DOPRI5 of Hairer, Norsett and Wanner: SAFE, BETA, FAC1, FAC2, FACOLD, and the stretch of the last step */
#define JO_SAFETY 0.9           /* factor on the step length that the error allows */
#define JO_PI_BETA 0.04         /* exponent of the previous error in the PI controller (Gustafsson 1991) */
#define JO_PI_SHARE 0.75        /* share of JO_PI_BETA by which the exponent of the error is reduced */
#define JO_MIN_FACTOR 0.2       /* smallest ratio of a step length and the previous one */
#define JO_MAX_FACTOR 10.0      /* largest ratio of a step length and the previous one */
#define JO_MIN_LAST_ERROR 1e-4  /* smallest previous error in the PI controller */
#define JO_STRETCH 1.01         /* ratio of step length and planned length up to which a step is stretched to the end of the interval */
#define JO_MIN_ERROR 1e-10      /* smallest error in the factor of the next step, which prevents division by 0 */
#define JO_ROTATED_FACTOR 0.5   /* factor on the step length after a rotation beyond twice JO_MAX_ROTATION */
#define JO_FAILED_FACTOR 0.25   /* factor on the step length after a failed evaluation */
#define JO_MIN_STEP (16.0 * DBL_EPSILON)   /* smallest step length, relative to the time or to the distance of the rows */

/* projection with the factors of the end of the step; returns whether the residuals are within JO_CLOSED */
static int close_joints(const jo_model *m, jo_data *d)
{
    if (jo_tree_active(d)) {
        jo_tree_prescribe_motion(m, d);   /* in place of their interpolated values */
        return jo_tree_close_loops(m, d);
    }
    jo_project(m, d, &jo_now);
    return jo_most(jo_largest_residual(m, d)) <= JO_CLOSED * m->size
           && jo_most(jo_largest_residual_rate(m, d)) <= JO_CLOSED * jo_most(jo_speed(m, d));
}

/* state at time t within the last step, by dense output; that at its end is kept */
static void move_between(const jo_model *m, jo_data *d, double t)
{
    for (int i = 0; i < d->ny; i++) d->adaptive.q1[i] = d->y[i];
    for (int i = 0; i < d->nw; i++) d->adaptive.v1[i] = d->w[i];
    for (int i = 0; i < m->nrow; i++) d->adaptive.lam1[i] = d->lam[i];
    jo_interpolate(m, d, (t - d->control.from) / d->control.length);
    d->time[0] = t;
    jo_state_changed(d);
}

/* the state at the end of the step again */
static void move_back(const jo_model *m, jo_data *d, jo_real time, int known)
{
    for (int i = 0; i < d->ny; i++) d->y[i] = d->adaptive.q1[i];
    for (int i = 0; i < d->nw; i++) d->w[i] = d->adaptive.v1[i];
    jo_positions_moved(d);
    for (int i = 0; i < m->nrow; i++) d->lam[i] = d->adaptive.lam1[i];
    d->time[0] = time;
    jo_restore_stage(d, 1);
    jo_stage_recalled(d, known);
}

/* row at time t within the last step */
static int write_between(const jo_model *m, jo_data *d, const jo_solver *s, double t, jo_real *row)
{
    const int known = jo_accelerations_known(d);
    const jo_real time = d->time[0];
    const jo_work work = d->work;
    move_between(m, d, t);
    int status = JO_OK;
    if (s->projection && m->njoint && !close_joints(m, d)) {
        status = jo_accelerations(m, d);
        if (status == JO_OK) close_joints(m, d);
    }
    if (status == JO_OK && m->nyielding) status = jo_yielding_ready(m, d);
    if (status == JO_OK) jo_accept_yielding(m, d, 0);
    double losses[2] = {0.0, 0.0};
    jo_place_contact_losses(d, (t - d->control.from) / d->control.length, jo_bristles_at_end(m, d), losses);
    if (status == JO_OK) status = jo_write_row(m, d, row);
    jo_place_contact_losses(d, 1.0, jo_same(0.0), losses);
    d->work = work;
    move_back(m, d, time, known);
    return status;
}

/* error of the interpolation of delayed values / tolerance, in the middle of the step */
static double delay_error(const jo_model *m, jo_data *d, const jo_solver *s)
{
    const int known = jo_accelerations_known(d);
    const jo_real time = d->time[0];
    const jo_work work = d->work;
    double error = 0.0;
    for (int k = 0; k < jo_delay_count(d); k++) {
        if (jo_yielding_ready(m, d) != JO_OK) return 0.0;
        jo_delay_keep(m, d, k);
        move_between(m, d, d->control.from + 0.5 * d->control.length);
        if (jo_yielding_ready(m, d) == JO_OK)
            error = jo_larger(error, jo_delay_error(m, d, k) / s->tolerance);
        d->work = work;
        move_back(m, d, time, known);
    }
    return error;
}

static double size_of(const jo_model *m) { return m->size > 0.0 ? m->size : 1.0; }

/* out (3): largest speed, m/s, modal coordinates and their rates of a body until now */
static void extent_of(const jo_model *m, const jo_data *d, int body, double *out)
{
    const jo_body *b = &m->body[body];
    const jo_real *v = d->v + b->iv;
    const double *so_far = d->adaptive.extent + 3 * body;
    out[0] = jo_larger(so_far[0], jo_larger(jo_length(v, 3), size_of(m) * jo_length(v + 3, 3)));
    out[1] = jo_larger(so_far[1], jo_length(d->q + b->iq + 7, b->n));
    out[2] = jo_larger(so_far[2], jo_length(v + 6, b->n));
}

static double largest_speed(const jo_model *m, const jo_data *d)
{
    double top = 0.0, out[3];
    for (int i = 0; i < m->nbody; i++) {
        extent_of(m, d, i, out);
        top = jo_larger(top, out[0]);
    }
    return top;
}

/* error of the states of forces / tolerance, relative to their largest and nominal values */
static double state_error(const jo_model *m, jo_data *d, const jo_solver *s)
{
    double error = 0.0;
    for (int i = 0; i < m->nstate; i++) {
        const double largest = jo_larger(d->adaptive.extent[3 * m->nbody + i], fabs(JO_RE(jo_states(m, d)[i])));
        const double defect = jo_error_estimate(d, 2 * d->nw - m->nstate + i, 1);
        if (defect == 0.0) continue;   /* a state without a scale, such as an unused one */
        const double ratio = defect / (s->tolerance * jo_larger(largest, d->adaptive.nominal[i]));
        if (ratio > error || ratio != ratio) error = ratio;
        if (error != error) return error;
    }
    return error;
}

/* error of the step / tolerance, the largest one of: positions / size of the mechanism, rotations / 1 rad, modal coordinates / their largest
 * values, velocities / largest speeds. Lower limits of these references: JO_SMALL_SHARE of the reference of the mechanism; for speeds
 * also JO_SMALL_SHARE of the size of the mechanism / duration of the run. */
static double step_error(const jo_model *m, jo_data *d, const jo_solver *s)
{
    jo_real *const defect[2] = {d->adaptive.defect[0], d->adaptive.defect[1]};
    if (jo_tree_active(d)) jo_tree_error_estimate(m, d, defect[0], defect[1]);
    const double size = size_of(m), top = jo_larger(largest_speed(m, d), size / d->control.duration);
    double error = 0.0;
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        const double root = sqrt(JO_RE(b->mass[0]));
        double e[6], scale[6], x[3];
        extent_of(m, d, i, x);
        const double speed = jo_larger(jo_larger(x[0], JO_SMALL_SHARE * top), DBL_MIN);
        for (int k = 0; k < 2; k++) {   /* increments, velocities */
            const int at = k * d->nw + b->iv;
            e[3 * k] = jo_tree_active(d) ? jo_length(defect[k] + b->iv, 3) : jo_error_estimate(d, at, 3);
            e[3 * k + 1] = jo_tree_active(d) ? jo_length(defect[k] + b->iv + 3, 3) : jo_error_estimate(d, at + 3, 3);
            e[3 * k + 2] = jo_tree_active(d) ? 0.0 : jo_error_estimate(d, at + 6, b->n);
        }
        scale[0] = jo_larger(s->tolerance * size, s->absolute);
        scale[1] = scale[0] / size;
        scale[2] = jo_larger(s->tolerance * jo_larger(x[1], JO_SMALL_SHARE * size * root), s->absolute * root);
        scale[3] = jo_larger(s->tolerance * speed, s->absolute);
        scale[4] = scale[3] / size;
        scale[5] = jo_larger(s->tolerance * jo_larger(x[2], JO_SMALL_SHARE * speed * root), s->absolute * root);
        for (int k = 0; k < 6; k++) {
            const double ratio = e[k] / scale[k];
            if (ratio > error || ratio != ratio) {
                error = ratio;
                d->control.worst = i;
            }
            if (error != error) return error;
        }
    }
    return jo_larger(jo_larger(error, state_error(m, d, s)), delay_error(m, d, s));
}

static void update_extent(const jo_model *m, jo_data *d)
{
    double x[3];
    for (int i = 0; i < m->nbody; i++) {
        extent_of(m, d, i, x);
        for (int j = 0; j < 3; j++) d->adaptive.extent[3 * i + j] = x[j];
    }
    for (int i = 0; i < m->nstate; i++) {
        double *largest = d->adaptive.extent + 3 * m->nbody + i;
        *largest = jo_larger(*largest, fabs(JO_RE(jo_states(m, d)[i])));
    }
}

/* first step: tolerance^(1/5) / largest rate of velocities, accelerations and vibrations */
static double first_step(const jo_model *m, const jo_data *d, const jo_solver *s)
{
    const double size = size_of(m);
    double rate = 0.0;
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        const jo_real *v = d->v + b->iv, *a = d->a + b->iv;
        rate = jo_larger(rate, jo_larger(jo_length(v, 3) / size, jo_length(v + 3, 3)));
        rate = jo_larger(rate, sqrt(jo_larger(jo_length(a, 3) / size, jo_length(a + 3, 3))));
        for (int j = 0; j < b->n; j++) rate = jo_larger(rate, sqrt(JO_RE(b->K[j])));
    }
    return pow(s->tolerance, JO_ERROR_ORDER) / jo_larger(rate, JO_MIN_RATE);
}

/* first time of m->breaks after t; infinity if there is none */
static double next_break(const jo_model *m, double t)
{
    int low = 0, high = m->nbreak;   /* breaks below `low` are not after t; breaks from `high` on are after t */
    while (low < high) {
        const int middle = (low + high) / 2;
        if (JO_RE(m->breaks[middle]) > t) high = middle;
        else low = middle + 1;
    }
    return low < m->nbreak ? JO_RE(m->breaks[low]) : HUGE_VAL;
}

static double fastest_turn(const jo_model *m, const jo_data *d)
{
    double w = 0.0;
    for (int i = 0; i < m->nbody; i++) w = jo_larger(w, jo_length(d->v + m->body[i].iv + 3, 3));
    return w;
}

/* reject the last step: state at its start, next length `shorter` */
static void reject_step(jo_data *d, double shorter)
{
    for (int i = 0; i < d->ny; i++) d->y[i] = d->q0[i];
    for (int i = 0; i < d->nw; i++) d->w[i] = d->v0[i];
    jo_positions_moved(d);
    d->work = d->control.work;
    d->time[0] = d->control.from;
    jo_restore_stage(d, 0);
    d->control.next = shorter;
    d->control.shortened = 1;
    d->counts.rejected++;
}

static int failure_status(jo_data *d)
{
    if (d->control.status != JO_OK) return d->control.status;
    d->error_index = d->control.worst;
    return JO_STEP_TOO_SMALL;
}

/* Length of a step. */
typedef struct {
    double h, wanted;       /* length, s; length without the limit, s */
    double limit, seen;     /* latest end, s; time for the evaluation of forces at the end, s */
    int whole, broken;      /* whether the step ends at the limit; whether forces may jump there */
} planned_step;

/* length of the next step, up to the next break or `end` */
static planned_step plan_step(const jo_model *m, const jo_data *d, const jo_solver *s, double end)
{
    const double t = JO_RE(d->time[0]), kink = next_break(m, t), turn = fastest_turn(m, d);
    planned_step x;
    x.limit = kink < end ? kink : end;
    x.h = d->control.next;
    if (s->largest > 0.0 && x.h > s->largest) x.h = s->largest;
    if (turn * x.h > JO_MAX_ROTATION) x.h = JO_MAX_ROTATION / turn;
    x.wanted = x.h;
    x.whole = t + JO_STRETCH * x.h >= x.limit;
    if (x.whole) x.h = x.limit - t;
    else if (t + 2.0 * x.h > x.limit) x.h = 0.5 * (x.limit - t);   /* two equal steps to the limit */
    x.broken = x.whole && kink <= end;
    x.seen = x.broken ? nextafter(x.limit, t) : x.whole ? x.limit : t + x.h;
    return x;
}

/* whether the rotations and the error of the step are small enough; length of the next step. Otherwise the step is rejected */
static int control_error(const jo_model *m, jo_data *d, const jo_solver *s, const planned_step *x, double *error)
{
    jo_control *c = &d->control;
    if ((jo_tree_active(d) ? jo_tree_largest_rotation(m, d) : jo_increment_between(m, d->dq, d->q0, d->q)) > 2.0 * JO_MAX_ROTATION) {
        reject_step(d, JO_ROTATED_FACTOR * x->h);
        return 0;
    }
    *error = step_error(m, d, s);
    /* factor of the next step: 0.9 error^-(1/5 - 0.75 beta) error_before^beta, within 0.2 .. 10 */
    const double plain = JO_SAFETY / pow(jo_larger(*error, JO_MIN_ERROR), JO_ERROR_ORDER - JO_PI_SHARE * JO_PI_BETA);
    if (!(*error <= 1.0)) {
        c->status = JO_OK;
        reject_step(d, x->h * (plain > JO_MIN_FACTOR ? plain : JO_MIN_FACTOR));
        return 0;
    }
    double factor = plain * pow(c->error, JO_PI_BETA);
    factor = factor < JO_MIN_FACTOR ? JO_MIN_FACTOR : factor > JO_MAX_FACTOR ? JO_MAX_FACTOR : factor;
    if (c->shortened && factor > 1.0) factor = 1.0;
    c->next = x->h * factor;
    if (x->h < x->wanted && c->next < x->wanted) c->next = x->wanted;   /* step shortened by the limit only */
    return 1;
}

/* accept the step up to the first event in it */
static int accept_step(const jo_model *m, jo_data *d, const jo_solver *s, planned_step *x, double error)
{
    jo_control *c = &d->control;
    int found = 0;
    if (jo_watched(m)) {   /* shorten to the first event */
        double shorter = x->h;
        const int status = jo_event_find(m, d, s, c->first, &shorter, &found);
        if (status != JO_OK) return status;
        c->first = 0;
        if (shorter < x->h) x->whole = x->broken = 0;
    }
    c->error = jo_larger(error, JO_MIN_LAST_ERROR);
    c->shortened = 0;
    c->status = JO_OK;
    if (x->whole) d->time[0] = x->limit + (d->time[0] - JO_RE(d->time[0]));
    if (x->broken) jo_forces_break(d);
    d->counts.steps++;
    if (m->nturn && jo_tree_active(d)) jo_tree_count_turns(m, d);
    else if (m->nturn) jo_count_turns(m, d);
    jo_sync_maximal_state(m, d, JO_SYNC_STATE);   /* needed after the location of an event */
    update_extent(m, d);
    if (m->nbeam) jo_beam_accept(d);
    jo_damage_outdated(d);
    c->found = found;
    if (!found) c->chain = 0;
    return JO_OK;
}

/* bind the contacts of the next step, which is shortened if they are too many */
static int near_contacts(const jo_model *m, jo_data *d, const jo_solver *s, double end)
{
    jo_sync_maximal_state(m, d, JO_SYNC_STATE);
    d->control.next = fmin(d->control.next, jo_resolved(m, d, 1));
    double length = plan_step(m, d, s, end).h;
    const double planned = length;
    const int status = jo_seek_contacts(m, d, &length);
    if (length < planned) d->control.next = length;
    return status == JO_OK && !jo_accelerations_known(d) ? jo_accelerations(m, d) : status;
}

/* try one step up to `end`; JO_OK also if the step was rejected */
static int try_step(const jo_model *m, jo_data *d, const jo_solver *s, double end)
{
    jo_control *c = &d->control;
    if (!(c->next > JO_MIN_STEP * jo_larger(fabs(JO_RE(d->time[0])), s->step)) || c->tries >= s->iterations)
        return failure_status(d);
    c->tries++;
    int status = jo_accelerations_known(d) ? JO_OK : jo_accelerations(m, d);
    if (status == JO_OK && jo_has_contact_sets(d)) status = near_contacts(m, d, s, end);
    if (status == JO_OK && jo_watched(m)) status = jo_event_keep(m, d);
    if (status != JO_OK) return status;
    jo_sync_maximal_state(m, d, JO_SYNC_STATE);
    if (m->nyielding) c->next = fmin(c->next, jo_resolved(m, d, 1));
    planned_step x = plan_step(m, d, s, end);
    status = jo_step_pair(m, d, s, x.h, x.seen);
    if (status != JO_OK) {
        c->status = status;
        reject_step(d, JO_FAILED_FACTOR * x.h);
        return JO_OK;
    }
    jo_sync_maximal_state(m, d, JO_SYNC_STATE);
    double error;
    return control_error(m, d, s, &x, &error) ? accept_step(m, d, s, &x, error) : JO_OK;
}

/* start of a run: accelerations, references of the error, first step */
static int begin(const jo_model *m, jo_data *d, const jo_solver *s, long long last)
{
    static const jo_control clean = {0};
    jo_control *c = &d->control;
    *c = clean;
    jo_control_begins(d);
    jo_restart(d);
    int status = m->nlock ? jo_friction_initialise_states(m, d) : JO_OK;
    if (status == JO_OK && !jo_accelerations_valid(d)) status = jo_accelerations(m, d);
    if (status != JO_OK) return status;
    jo_sync_all(m, d);
    for (int i = 0; i < 3 * m->nbody + m->nstate; i++) d->adaptive.extent[i] = 0.0;
    jo_state_nominals(m, (double)last * s->step, d->adaptive.nominal);
    update_extent(m, d);
    c->start = JO_RE(d->time[0]);
    c->first = 1;
    c->duration = (double)last * s->step;
    c->error = JO_MIN_LAST_ERROR;
    c->next = s->first > 0.0 ? s->first : first_step(m, d, s);
    return JO_OK;
}

/* events and damage meters at the end of a step, after all rows within the step */
static int process_arrival(const jo_model *m, jo_data *d)
{
    jo_control *c = &d->control;
    const int found = c->found;
    c->found = 0;
    if (found) {
        jo_state_changed(d);
        jo_stage_forgotten(d);   /* rows were written */
        const int status = jo_event_happen(m, d, &c->chain);
        if (status != JO_OK && status != JO_EVENT) return status;
        const int event = d->error_index, failed = jo_measure(m, d);
        jo_damage_counted(d);
        d->error_index = failed == JO_OK ? event : d->error_index;
        return failed == JO_OK ? status : failed;
    }
    if (jo_damage_valid(d)) return JO_OK;
    jo_damage_counted(d);
    return jo_measure(m, d);
}

/* steps and rows until row `last`, `tries` steps or `room` rows */
static int follow_rows(const jo_model *m, jo_data *d, const jo_solver *s, long long last, long long tries, int room,
                  long long *count, int *written, jo_real *rows)
{
    jo_control *c = &d->control;
    const size_t size = (size_t)jo_row_size(m);
    const double end = c->start + (double)last * s->step;
    while (*written < room && (!jo_watched(m) || (jo_log_has_room(m, d) && jo_contact_list_has_room(m, d)))) {
        const double now = JO_RE(d->time[0]), t = c->start + (double)*count * s->step;
        jo_real *row = rows + (size_t)*written * size;
        int status = t < now ? write_between(m, d, s, t, row) : process_arrival(m, d);
        if (t == now || status == JO_EVENT) {
            const int written_too = jo_write_row(m, d, row);
            if (written_too != JO_OK) return written_too;
        }
        if (t <= now || status == JO_EVENT) ++*written;
        if (status != JO_OK) return status;
        if (t <= now) {
            c->tries = 0;
            if (++*count > last) return JO_OK;
            continue;
        }
        if (tries-- <= 0) return JO_OK;
        status = try_step(m, d, s, end);
        if (status != JO_OK) return status;
    }
    return JO_OK;
}

int jo_follow(const jo_model *m, jo_data *d, const jo_solver *s, long long last, long long tries, int room,
              long long *count, int *written, jo_real *rows)
{
    *written = 0;
    d->events.logged = 0;
    jo_contact_list_begins(d);
    int status = m->nlink && !jo_mixed(m) ? jo_tree_from_maximal(m, d) : JO_OK;
    if (status == JO_OK && *count == 0) status = begin(m, d, s, last);
    if (status == JO_OK) status = follow_rows(m, d, s, last, tries, room, count, written, rows);
    jo_tree_to_maximal(m, d);
    d->run.left = JO_RE(d->time[0]);
    return status;
}
