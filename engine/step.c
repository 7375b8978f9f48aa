/* step.c - time integration with a fixed step and fixed work.
 *
 * Positions move by increments [R' h, theta, p' h] from the start of the step; orientations are e o exp(theta).
 */
#include "internal.h"

#define JO_LARGEST 1e15   /* no coordinate of a machine is as large, in any unit: the run has diverged */

/* rate of the increments x at the velocities v */
void jo_increment_rate(const jo_model *m, jo_real *rate, const jo_real *x, const jo_real *v)
{
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        const int o = b->iv;
        jo_set3(rate + o, v + o);
        jo_rotation_rate(rate + o + 3, x + o + 3, v + o + 3);
        for (int j = 6; j < 6 + b->n; j++) rate[o + j] = v[o + j];
    }
}

/* classical Runge-Kutta (Rantalainen 2007, chapter 4) on the index-1 equations */
static int step_rk4(const jo_model *m, jo_data *d, const jo_solver *s)
{
    static const double node[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    const double h = s->step;
    const jo_real t0 = d->time[0];
    const int baumgarte = s->alpha != 0.0 || s->beta != 0.0;
    for (int i = 0; i < m->nq; i++) d->q0[i] = d->q[i];
    for (int i = 0; i < m->nv; i++) {
        d->v0[i] = d->v[i];
        d->dq[i] = d->dv[i] = d->rate[i] = d->acc[i] = 0.0;
    }
    for (int k = 0; k < 4; k++) {
        if (k) {   /* rate and acc hold the previous stage */
            const double c = node[k] * h;
            for (int i = 0; i < m->nv; i++) {
                d->rate[i] *= c;
                d->v[i] = d->v0[i] + c * d->acc[i];
            }
            jo_displace(m, d->q, d->q0, d->rate);
            d->time[0] = t0 + c;
        }
        if (k || !d->fresh || baumgarte) {
            int status = jo_evaluate(m, d, s, 0);
            if (status != JO_OK) return status;
            if (!k && d->again && !baumgarte) d->counts[0]--;   /* counts do not tell how a run is cut into calls */
        }
        d->again = 0;
        jo_increment_rate(m, d->rate, d->rate, d->v);
        for (int i = 0; i < m->nv; i++) {
            d->acc[i] = d->a[i];
            d->dq[i] += weight[k] * h * d->rate[i];
            d->dv[i] += weight[k] * h * d->a[i];
        }
        for (int i = 0; i < 3; i++) d->work[i] += weight[k] * h * d->power[i];
    }
    jo_displace(m, d->q, d->q0, d->dq);
    for (int i = 0; i < m->nv; i++) d->v[i] = d->v0[i] + d->dv[i];
    return JO_OK;
}

/* the last step's work by the trapezoidal rule between states, now that the power at its end is known; the
 * stages in between say little about modes that the step does not resolve */
void jo_add_work(jo_data *d)
{
    d->work[0] += 0.5 * d->waiting * (d->power0[0] + d->power[0]);
    d->work[2] += 0.5 * d->waiting * (d->power0[2] + d->power[2] - d->drive);   /* drives and friction: stage by stage */
    d->waiting = 0.0;
}

static void no_extra(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nbody; i++)
        for (int j = 0; j < m->body[i].n; j++) d->body[i].extra[j] = 0.0;
}

/* the second stage starts from accelerations and multipliers of the first; beams lag by
 * g h K (2 v0 - x' + 4 g h a1) + 2 g h D a1 less M^ - M times a1, which is gone already */
static void second_stage(const jo_model *m, jo_data *d, double gh)
{
    jo_increment_rate(m, d->rate, d->dq, d->v);
    for (int i = 0; i < m->nv; i++) {
        d->base[i] = d->acc[i];
        d->rate[i] = gh * (2.0 * d->v0[i] - d->rate[i] + 3.0 * gh * d->acc[i]);
        d->dv[i] = gh * d->acc[i];
        d->lag[i] = 0.0;
    }
    for (int i = 0; i < m->nrow; i++) d->base_lam[i] = d->lam[i];
    jo_beam_lag(m, d, d->rate, d->dv);
    d->second = 1;
}

/* ROS2 (Verwer, Spee, Blom, Hundsdorfer 1999), a W-method of order 2: modal stiffness and damping implicit.
 * With k2 = k2' - 2 k1 the step is y + (k1 + k2')/2. Beams lag like modes, with the stiffness of the first stage. */
static int step_ros2(const jo_model *m, jo_data *d, const jo_solver *s)
{
    const double h = s->step, gh = (1.0 - 0.70710678118654752440) * h;
    const jo_real t0 = d->time[0];
    jo_use_step(m, d, gh);
    for (int i = 0; i < m->nbody; i++) {   /* stage 1: extra = -g h K p' */
        const jo_body *b = &m->body[i];
        for (int j = 0; j < b->n; j++) d->body[i].extra[j] = -gh * b->K[j] * d->v[b->iv + 6 + j];
    }
    d->lead = gh;   /* the matrix of the W-method knows the time derivative of the forces */
    int status = jo_evaluate(m, d, s, 1);
    d->lead = 0.0;
    if (status != JO_OK) {
        no_extra(m, d);
        return status;
    }
    for (int i = 0; i < m->nq; i++) d->q0[i] = d->q[i];
    for (int i = 0; i < m->nv; i++) {
        d->v0[i] = d->v[i];
        d->acc[i] = d->a[i];
        d->dq[i] = h * (d->v[i] + gh * d->a[i]);
        d->v[i] += h * d->a[i];
    }
    jo_add_work(d);
    d->waiting = h;
    for (int i = 0; i < 3; i++) d->power0[i] = d->power[i];
    d->power0[2] -= d->drive;
    d->work[1] += 0.5 * h * d->power[1];
    d->work[2] += 0.5 * h * d->drive;   /* multipliers lead in stage 1 as they lag in stage 2 */
    jo_displace(m, d->q, d->q0, d->dq);
    d->time[0] = t0 + h;
    for (int i = 0; i < m->nbody; i++) {   /* stage 2: extra = -g h K (p' - 2 g h a1) + 2 g h (K (p0' + g h a1) + D a1) */
        const jo_body *b = &m->body[i];
        const jo_real *a1 = d->acc + b->iv + 6, *v0 = d->v0 + b->iv + 6, *v = d->v + b->iv + 6;
        for (int j = 0; j < b->n; j++)
            d->body[i].extra[j] = gh * (b->K[j] * (2.0 * v0[j] - v[j] + 4.0 * gh * a1[j]) + 2.0 * b->D[j] * a1[j]);
    }
    d->lead = -gh;
    if (m->nbeam) second_stage(m, d, gh);
    status = jo_evaluate(m, d, s, 1);
    d->lead = 0.0;
    d->second = 0;
    no_extra(m, d);
    if (status != JO_OK) return status;
    d->work[1] += 0.5 * h * d->power[1];
    d->work[2] += 0.5 * h * d->drive;
    jo_increment_rate(m, d->rate, d->dq, d->v);
    for (int i = 0; i < m->nv; i++) {
        d->dq[i] = 0.5 * h * (d->v0[i] + d->rate[i] + gh * (d->a[i] - d->acc[i]));
        d->v[i] = d->v0[i] + 0.5 * h * (d->acc[i] + d->a[i]);
    }
    jo_displace(m, d->q, d->q0, d->dq);
    return JO_OK;
}

int jo_check(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        double sum = 0.0;
        for (int j = 0; j < 6 + b->n; j++) sum += fabs(JO_RE(d->v[b->iv + j]));
        for (int j = 0; j < 7 + b->n; j++) sum += fabs(JO_RE(d->q[b->iq + j]));
        if (!(sum < JO_LARGEST)) {
            d->error_index = i;
            return JO_NOT_FINITE;
        }
    }
    return JO_OK;
}

int jo_one_step(const jo_model *m, jo_data *d, const jo_solver *s)
{
    int status;
    d->counts[5]++;
    d->control.known = 0;
    d->control.length = s->step;
    if (s->method == JO_DOPRI) status = jo_step_dopri(m, d, s, s->step, JO_RE(d->time[0]) + s->step);
    else {
        const int implicit = s->method == JO_ALPHA;
        status = implicit ? jo_step_alpha(m, d, s) : s->method == JO_RK4 ? step_rk4(m, d, s) : step_ros2(m, d, s);
        d->fresh = d->current = 0;
        if (implicit) d->fresh = status == JO_OK && m->redundant <= 0;   /* it knows a and lam, but not those of least norm */
        else if (status == JO_OK && s->projection) jo_project(m, d);
    }
    if (status != JO_OK) return status;
    if (m->nturn) {   /* without projection the coordinates are those of the last stage, near enough to count */
        if (!s->projection) jo_coordinates(m, d, m->ncoordinate);
        jo_count_turns(m, d);
    }
    if (m->nbeam) jo_beam_accept(m, d);
    return jo_check(m, d);
}

static int step(const jo_model *m, jo_data *d, const jo_solver *s)
{
    return jo_watched(m) ? jo_event_step(m, d, s) : jo_one_step(m, d, s);
}

/* the caller may have changed the state: what hangs on it is computed again */
static void enter(jo_data *d)
{
    d->again = d->fresh;
    d->current = d->fresh = 0;
    d->logged = 0;
    if (JO_RE(d->time[0]) != d->left) jo_restart(d);
}

void jo_restart(jo_data *d)
{
    d->restart = 1;
    d->watching = d->grid.valid = 0;
    jo_beam_forget(d);
}

int jo_step(const jo_model *m, jo_data *d, const jo_solver *s)
{
    enter(d);
    int status = step(m, d, s);
    if (status == JO_OK) status = jo_measure(m, d);
    d->left = JO_RE(d->time[0]);
    return status;
}

int jo_row_size(const jo_model *m)
{
    return 1 + m->nq + m->nv + m->nrow + JO_BALANCE + m->nout + m->nturn + 3 * m->nlock + 3 * m->nfriction
           + m->nevent + m->ninput + m->nmemory;
}

int jo_write_row(const jo_model *m, jo_data *d, jo_real *row)
{
    int status = d->fresh ? JO_OK : jo_accelerations(m, d);
    if (status != JO_OK) return status;
    jo_add_work(d);
    *row++ = d->time[0];
    for (int i = 0; i < m->nq; i++) *row++ = d->q[i];
    for (int i = 0; i < m->nv; i++) *row++ = d->v[i];
    for (int i = 0; i < m->nrow; i++) *row++ = d->lam[i];
    jo_energy(m, d, row);
    for (int i = 0; i < 3; i++) row[4 + i] = d->work[i];
    jo_residuals(m, d, row + 7);
    row[9] = (double)d->counts[0];
    row[10] = (double)d->counts[1];
    row[11] = (double)d->counts[5];
    row[12] = (double)d->counts[3];
    row[13] = d->control.length;
    jo_sensors(m, d, row + JO_BALANCE);
    row += JO_BALANCE + m->nout;
    for (int i = 0; i < m->nturn; i++) *row++ = d->turn[i];
    for (int i = 0; i < m->nlock; i++) *row++ = d->locked[i];
    for (int i = 0; i < m->nfriction; i++) *row++ = d->slip[i];
    for (int i = 0; i < 2 * m->nlock; i++) *row++ = d->held[i];
    for (int i = 0; i < 2 * m->nfriction; i++) *row++ = d->direction[i];
    for (int i = 0; i < m->nevent; i++) *row++ = d->happened[i];
    for (int i = 0; i < m->ninput; i++) *row++ = d->input[i];
    for (int i = 0; i < m->nmemory; i++) *row++ = d->memory[i];
    return JO_OK;
}

int jo_row(const jo_model *m, jo_data *d, jo_real *row)
{
    d->current = d->fresh = 0;
    int status = m->nlock ? jo_friction_settle(m, d) : JO_OK;
    if (status == JO_OK) status = jo_measure(m, d);
    return status == JO_OK ? jo_write_row(m, d, row) : status;
}

/* rounded before it is added, so that time does not depend on how a run is cut into calls */
static double instant(long long count, double step)
{
    volatile double product = (double)count * step;
    return product;
}

static int run(const jo_model *m, jo_data *d, const jo_solver *s, long long nsteps, long long every,
               long long *count, int *written, jo_real *rows)
{
    const size_t size = (size_t)jo_row_size(m);
    if (!d->grid.valid || d->grid.count != *count || d->grid.step != s->step)
        d->grid.start = d->time[0] - instant(*count, s->step);
    for (long long i = 0; i < nsteps && (!jo_watched(m) || jo_log_has_room(m, d)); i++) {
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
        d->time[0] = d->grid.start + instant(*count, s->step);
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
    enter(d);
    const int status = run(m, d, s, nsteps, every, count, written, rows);
    d->left = JO_RE(d->time[0]);
    d->grid.valid = status == JO_OK;
    d->grid.count = *count;
    d->grid.step = s->step;
    return status;
}
