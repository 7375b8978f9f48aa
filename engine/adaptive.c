/* adaptive.c - the pair of orders 5 and 4 of Dormand and Prince with error control and dense output.
 *
 * Dormand, Prince, J. Comp. Appl. Math. 6 (1980); control and dense output as in Hairer, Norsett, Wanner, Solving
 * Ordinary Differential Equations I (1993), II.4 to II.6. The method runs in the increments of step.c, so that a state is
 * moved on its group. A step is projected before its last stage is evaluated there: what the error is estimated
 * with is the first stage of the next step.
 */
#include "internal.h"
#include <float.h>

enum { JO_STAGES = 7 };
#define JO_TURN 1.0     /* rad, largest turn of a body in a step */

static const double NODE[JO_STAGES] = {0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0};
static const double WEIGHT[JO_STAGES][JO_STAGES - 1] = {   /* the last row is the step itself */
    {0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0},
    {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0},
    {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0},
    {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0},
    {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0}};
/* the step of order 5 less that of order 4 */
static const double ERROR[JO_STAGES] = {71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0,
                                        22.0 / 525.0, -1.0 / 40.0};
/* dense output of order 4 (Shampine 1986): the part that vanishes twice at both ends */
static const double DENSE[JO_STAGES] = {-12715105075.0 / 11282082432.0, 0.0, 87487479700.0 / 32700410799.0,
                                        -10690763975.0 / 1880347072.0, 701980252875.0 / 199316789632.0,
                                        -1453857185.0 / 822651844.0, 69997945.0 / 29380423.0};

static int width(const jo_model *m) { return 2 * m->nv + 3; }

static double largest(double a, double b) { return a > b ? a : b; }

static double length(const jo_real *x, int n)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += JO_RE(x[i]) * JO_RE(x[i]);
    return sqrt(sum);
}

/* sum of the first `count` stages at place i */
static jo_real blend(const jo_data *d, const double *weight, int count, int nk, int i)
{
    jo_real sum = 0.0;
    for (int k = 0; k < count; k++) sum += weight[k] * d->stage[k * nk + i];
    return sum;
}

/* rotation vector of the turn from e0 to e, below half a turn, in the frame of e0 */
static void turn_between(jo_real *theta, const jo_real *e0, const jo_real *e)
{
    const jo_real c = e0[0] * e[0] + e0[1] * e[1] + e0[2] * e[2] + e0[3] * e[3];
    jo_real x[3];
    x[0] = e0[0] * e[1] - e0[1] * e[0] - e0[2] * e[3] + e0[3] * e[2];
    x[1] = e0[0] * e[2] - e0[2] * e[0] - e0[3] * e[1] + e0[1] * e[3];
    x[2] = e0[0] * e[3] - e0[3] * e[0] - e0[1] * e[2] + e0[2] * e[1];
    const jo_real s = jo_dot3(x, x), sine = jo_sqrt(s);
    /* 2 asin(u) / u for small angles */
    const jo_real f = JO_RE(s) < 1e-5 ? 2.0 + s * (1.0 / 3.0 + s * (3.0 / 20.0 + s * (5.0 / 56.0)))
                                      : 2.0 * jo_arc_tangent(sine, c) / sine;
    for (int i = 0; i < 3; i++) theta[i] = f * x[i];
}

/* increments from q0 to q; returns the largest turn */
static double increments(const jo_model *m, jo_real *x, const jo_real *q0, const jo_real *q)
{
    double turn = 0.0;
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        const jo_real *p0 = q0 + b->iq, *p = q + b->iq;
        jo_real *y = x + b->iv;
        for (int j = 0; j < 3; j++) y[j] = p[j] - p0[j];
        turn_between(y + 3, p0 + 3, p + 3);
        for (int j = 0; j < b->n; j++) y[6 + j] = p[7 + j] - p0[7 + j];
        turn = largest(turn, length(y + 3, 3));
    }
    return turn;
}

static void keep_stage(const jo_model *m, jo_data *d, int k, const jo_real *rate)
{
    jo_real *x = d->stage + k * width(m);
    for (int i = 0; i < m->nv; i++) {
        x[i] = rate[i];
        x[m->nv + i] = d->a[i];
    }
    for (int i = 0; i < 3; i++) x[2 * m->nv + i] = d->power[i];
}

/* the accelerations and the power of a stage, kept, belong to the present state again, bodies and markers do not */
static void recall_stage(const jo_model *m, jo_data *d, int k)
{
    const jo_real *x = d->stage + k * width(m);
    for (int i = 0; i < m->nv; i++) d->a[i] = x[m->nv + i];
    for (int i = 0; i < 3; i++) d->power[i] = x[2 * m->nv + i];
    d->fresh = d->current = 0;
    d->control.known = 1;
}

/* one step of length h; forces that jump at its end are `seen` as they are at that time */
int jo_step_dopri(const jo_model *m, jo_data *d, const jo_solver *s, double h, double seen)
{
    const int nv = m->nv, nk = width(m);
    const jo_real t0 = d->time[0];
    jo_control *c = &d->control;
    if (!d->fresh && !c->known) {
        const int status = jo_accelerations(m, d);
        if (status != JO_OK) return status;
    }
    c->known = 0;
    for (int i = 0; i < m->nq; i++) d->q0[i] = d->q[i];
    for (int i = 0; i < nv; i++) d->v0[i] = d->v[i];
    for (int i = 0; i < 3; i++) c->work[i] = d->work[i];
    c->from = JO_RE(t0);
    c->length = h;
    keep_stage(m, d, 0, d->v);
    for (int k = 1; k < JO_STAGES; k++) {
        for (int i = 0; i < nv; i++) {
            d->dq[i] = h * blend(d, WEIGHT[k], k, nk, i);
            d->v[i] = d->v0[i] + h * blend(d, WEIGHT[k], k, nk, nv + i);
        }
        jo_displace(m, d->q, d->q0, d->dq);
        d->time[0] = k < 5 ? t0 + NODE[k] * h : seen + (t0 - JO_RE(t0));
        d->fresh = d->current = 0;
        if (k == JO_STAGES - 1) {   /* the new state */
            int status = jo_check(m, d);
            if (status != JO_OK) return status;
            if (s->projection) {
                jo_project(m, d);
                status = jo_check(m, d);
                if (status != JO_OK) return status;
            }
            increments(m, d->dq, d->q0, d->q);
        }
        const int status = jo_evaluate(m, d, 0, 0);
        if (status != JO_OK) return status;
        jo_increment_rate(m, d->rate, d->dq, d->v);
        keep_stage(m, d, k, d->rate);
    }
    for (int i = 0; i < 3; i++) d->work[i] += h * blend(d, WEIGHT[JO_STAGES - 1], JO_STAGES - 1, nk, 2 * nv + i);
    for (int i = 0; i < nv; i++) {
        d->change[i] = d->dq[i];
        d->change[nv + i] = d->v[i] - d->v0[i];
    }
    for (int i = 0; i < 3; i++) d->change[2 * nv + i] = d->work[i] - c->work[i];
    d->time[0] = t0 + h;
    d->fresh = 1;
    return JO_OK;
}

/* the state at the part `u` of the last step */
static void interpolate(const jo_model *m, jo_data *d, double u)
{
    const int nv = m->nv, nk = width(m);
    const double h = d->control.length;
    const jo_real *first = d->stage, *last = d->stage + (JO_STAGES - 1) * nk;
    for (int i = 0; i < nk; i++) {
        const jo_real y = d->change[i], r3 = h * first[i] - y, r4 = y - h * last[i] - r3;
        const jo_real r5 = h * blend(d, DENSE, JO_STAGES, nk, i);
        const jo_real x = u * (y + (1.0 - u) * (r3 + u * (r4 + (1.0 - u) * r5)));
        if (i < nv) d->dq[i] = x;
        else if (i < 2 * nv) d->v[i - nv] = d->v0[i - nv] + x;
        else d->work[i - 2 * nv] = d->control.work[i - 2 * nv] + x;
    }
    jo_displace(m, d->q, d->q0, d->dq);
}

/* a row at a time within the last step; the state stays at its end */
static int write_between(const jo_model *m, jo_data *d, const jo_solver *s, double t, jo_real *row)
{
    const int known = d->fresh || d->control.known;
    const jo_real time = d->time[0], work[3] = {d->work[0], d->work[1], d->work[2]};
    for (int i = 0; i < m->nq; i++) d->q1[i] = d->q[i];
    for (int i = 0; i < m->nv; i++) d->v1[i] = d->v[i];
    for (int i = 0; i < m->nrow; i++) d->lam1[i] = d->lam[i];
    interpolate(m, d, (t - d->control.from) / d->control.length);
    d->time[0] = t;
    d->fresh = d->current = 0;
    int status = JO_OK;
    if (s->projection && m->njoint) {
        jo_project(m, d);   /* with the factors of the end of the step; with those of this state if they differ too much */
        if (jo_joint_residual(m, d) > 1e-12 * m->size || jo_joint_residual_rate(m, d) > 1e-10 * m->size) {
            status = jo_accelerations(m, d);
            if (status == JO_OK) jo_project(m, d);
        }
    }
    if (status == JO_OK) status = jo_write_row(m, d, row);
    for (int i = 0; i < m->nq; i++) d->q[i] = d->q1[i];
    for (int i = 0; i < m->nv; i++) d->v[i] = d->v1[i];
    for (int i = 0; i < m->nrow; i++) d->lam[i] = d->lam1[i];
    for (int i = 0; i < 3; i++) d->work[i] = work[i];
    d->time[0] = time;
    recall_stage(m, d, JO_STAGES - 1);
    d->control.known = known;
    return status;
}

static double size_of(const jo_model *m) { return m->size > 0.0 ? m->size : 1.0; }

/* largest speed (m/s), modal coordinates and their speed of a body, up to now and at present */
static void extent_of(const jo_model *m, const jo_data *d, int body, double *out)
{
    const jo_body *b = &m->body[body];
    const jo_real *v = d->v + b->iv;
    const double *so_far = d->extent + 3 * body;
    out[0] = largest(so_far[0], largest(length(v, 3), size_of(m) * length(v + 3, 3)));
    out[1] = largest(so_far[1], length(d->q + b->iq + 7, b->n));
    out[2] = largest(so_far[2], length(v + 6, b->n));
}

static double fastest(const jo_model *m, const jo_data *d)
{
    double top = 0.0, out[3];
    for (int i = 0; i < m->nbody; i++) {
        extent_of(m, d, i, out);
        top = largest(top, out[0]);
    }
    return top;
}

/* length of the estimated error of n entries from place i on */
static double defect(const jo_model *m, const jo_data *d, int i, int n)
{
    double sum = 0.0;
    for (int j = i; j < i + n; j++) {
        const double e = JO_RE(blend(d, ERROR, JO_STAGES, width(m), j));
        sum += e * e;
    }
    return fabs(d->control.length) * sqrt(sum);
}

/* error of the step against the tolerance, the largest over the bodies of: position against the size of the mechanism,
 * turn against 1 rad, modal coordinates against their largest; speeds against their largest. What moves less than a
 * thousandth of the whole mechanism is measured against that, and what is slower than a thousandth of the size of the
 * mechanism in the time of the run, against that. */
static double step_error(const jo_model *m, jo_data *d, const jo_solver *s)
{
    const double size = size_of(m), top = largest(fastest(m, d), size / d->control.duration);
    double error = 0.0;
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        const double root = sqrt(JO_RE(b->mass[0]));
        double e[6], scale[6], x[3];
        extent_of(m, d, i, x);
        const double speed = largest(largest(x[0], 1e-3 * top), DBL_MIN);
        for (int k = 0; k < 2; k++) {   /* increments, velocities */
            const int at = k * m->nv + b->iv;
            e[3 * k] = defect(m, d, at, 3);
            e[3 * k + 1] = defect(m, d, at + 3, 3);
            e[3 * k + 2] = defect(m, d, at + 6, b->n);
        }
        scale[0] = largest(s->tolerance * size, s->absolute);
        scale[1] = scale[0] / size;
        scale[2] = largest(s->tolerance * largest(x[1], 1e-3 * size * root), s->absolute * root);
        scale[3] = largest(s->tolerance * speed, s->absolute);
        scale[4] = scale[3] / size;
        scale[5] = largest(s->tolerance * largest(x[2], 1e-3 * speed * root), s->absolute * root);
        for (int k = 0; k < 6; k++) {
            const double ratio = e[k] / scale[k];
            if (ratio > error || ratio != ratio) {
                error = ratio;
                d->control.worst = i;
            }
            if (error != error) return error;
        }
    }
    return error;
}

static void remember_extent(const jo_model *m, jo_data *d)
{
    double x[3];
    for (int i = 0; i < m->nbody; i++) {
        extent_of(m, d, i, x);
        for (int j = 0; j < 3; j++) d->extent[3 * i + j] = x[j];
    }
}

/* a first step well below the times in which bodies move, accelerate and vibrate */
static double first_step(const jo_model *m, const jo_data *d, const jo_solver *s)
{
    const double size = size_of(m);
    double rate = 0.0;
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        const jo_real *v = d->v + b->iv, *a = d->a + b->iv;
        rate = largest(rate, largest(length(v, 3) / size, length(v + 3, 3)));
        rate = largest(rate, sqrt(largest(length(a, 3) / size, length(a + 3, 3))));
        for (int j = 0; j < b->n; j++) rate = largest(rate, sqrt(JO_RE(b->K[j])));
    }
    return pow(s->tolerance, 0.2) / largest(rate, 1e-6);
}

/* the first break after t, or infinity */
static double next_break(const jo_model *m, double t)
{
    int low = 0, high = m->nbreak;   /* breaks below `low` are not after t, those from `high` on are */
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
    for (int i = 0; i < m->nbody; i++) w = largest(w, length(d->v + m->body[i].iv + 3, 3));
    return w;
}

/* back to the start of a step that is not taken */
static void withdraw(const jo_model *m, jo_data *d, double shorter)
{
    for (int i = 0; i < m->nq; i++) d->q[i] = d->q0[i];
    for (int i = 0; i < m->nv; i++) d->v[i] = d->v0[i];
    for (int i = 0; i < 3; i++) d->work[i] = d->control.work[i];
    d->time[0] = d->control.from;
    recall_stage(m, d, 0);
    d->control.next = shorter;
    d->control.shortened = 1;
    d->counts[3]++;
}

static int give_up(jo_data *d)
{
    if (d->control.status != JO_OK) return d->control.status;
    d->error_index = d->control.worst;
    return JO_STEP_TOO_SMALL;
}

/* try one step, not beyond `end`; JO_OK if it was taken or has to be tried again with a shorter one */
static int try_step(const jo_model *m, jo_data *d, const jo_solver *s, double end)
{
    jo_control *c = &d->control;
    const double t = JO_RE(d->time[0]), kink = next_break(m, t), limit = kink < end ? kink : end;
    if (!(c->next > 16.0 * DBL_EPSILON * largest(fabs(t), s->step)) || c->tries >= s->iterations) return give_up(d);
    c->tries++;
    if (!d->fresh && !c->known) {
        const int status = jo_accelerations(m, d);
        if (status != JO_OK) return status;
    }
    if (jo_watched(m)) {
        const int status = jo_event_keep(m, d);
        if (status != JO_OK) return status;
    }
    const double turn = fastest_turn(m, d);
    double h = c->next;
    if (s->largest > 0.0 && h > s->largest) h = s->largest;
    if (turn * h > JO_TURN) h = JO_TURN / turn;
    const double wanted = h;
    int whole = t + 1.01 * h >= limit;   /* up to the limit */
    if (whole) h = limit - t;
    else if (t + 2.0 * h > limit) h = 0.5 * (limit - t);   /* two steps of one length */
    int broken = whole && kink <= end;   /* forces of the next step may differ at once */
    const double seen = broken ? nextafter(limit, t) : whole ? limit : t + h;
    int status = jo_step_dopri(m, d, s, h, seen), found = 0;
    if (status != JO_OK) {
        c->status = status;
        withdraw(m, d, 0.25 * h);
        return JO_OK;
    }
    if (increments(m, d->dq, d->q0, d->q) > 2.0 * JO_TURN) {
        withdraw(m, d, 0.5 * h);
        return JO_OK;
    }
    const double error = step_error(m, d, s);
    const double plain = 0.9 / pow(largest(error, 1e-10), 0.2 - 0.75 * 0.04);   /* factor of the next step */
    if (!(error <= 1.0)) {
        c->status = JO_OK;
        withdraw(m, d, h * (plain > 0.2 ? plain : 0.2));
        return JO_OK;
    }
    double factor = plain * pow(c->error, 0.04);   /* proportional and integral */
    factor = factor < 0.2 ? 0.2 : factor > 10.0 ? 10.0 : factor;
    if (c->shortened && factor > 1.0) factor = 1.0;
    c->next = h * factor;
    if (h < wanted && c->next < wanted) c->next = wanted;   /* the limit made it short */
    if (jo_watched(m)) {   /* the step may end earlier */
        double shorter = h;
        status = jo_event_find(m, d, s, c->first, &shorter, &found);
        if (status != JO_OK) return status;
        c->first = 0;
        if (shorter < h) whole = broken = 0;
    }
    c->error = largest(error, 1e-4);
    c->shortened = 0;
    c->status = JO_OK;
    if (whole) d->time[0] = limit + (d->time[0] - JO_RE(d->time[0]));
    if (broken) d->fresh = 0;
    d->counts[5]++;
    if (m->nturn) jo_count_turns(m, d);
    remember_extent(m, d);
    if (m->nbeam) jo_beam_accept(m, d);
    c->measured = 0;
    c->found = found;
    if (!found) c->chain = 0;
    return JO_OK;
}

static int begin(const jo_model *m, jo_data *d, const jo_solver *s, long long last)
{
    static const jo_control clean = {0};
    jo_control *c = &d->control;
    *c = clean;
    d->fresh = 0;
    jo_restart(d);
    int status = m->nlock ? jo_friction_settle(m, d) : JO_OK;
    if (status == JO_OK && !d->fresh) status = jo_accelerations(m, d);
    if (status != JO_OK) return status;
    for (int i = 0; i < 3 * m->nbody; i++) d->extent[i] = 0.0;
    remember_extent(m, d);
    c->start = JO_RE(d->time[0]);
    c->first = 1;
    c->duration = (double)last * s->step;
    c->error = 1e-4;
    c->next = s->first > 0.0 ? s->first : first_step(m, d, s);
    return JO_OK;
}

/* what changes at the state that a step has reached, once all rows before it are written */
static int arrive(const jo_model *m, jo_data *d)
{
    jo_control *c = &d->control;
    const int found = c->found;
    c->found = 0;
    if (found) {
        d->fresh = d->current = c->known = 0;   /* rows were written */
        const int status = jo_event_happen(m, d, &c->chain);
        if (status != JO_OK && status != JO_EVENT) return status;
        const int event = d->error_index, failed = jo_measure(m, d);
        c->measured = 1;
        d->error_index = failed == JO_OK ? event : d->error_index;
        return failed == JO_OK ? status : failed;
    }
    if (c->measured) return JO_OK;
    c->measured = 1;
    return jo_measure(m, d);
}

static int follow(const jo_model *m, jo_data *d, const jo_solver *s, long long last, long long tries, int room,
                  long long *count, int *written, jo_real *rows)
{
    jo_control *c = &d->control;
    const size_t size = (size_t)jo_row_size(m);
    const double end = c->start + (double)last * s->step;
    while (*written < room && (!jo_watched(m) || jo_log_has_room(m, d))) {
        const double now = JO_RE(d->time[0]), t = c->start + (double)*count * s->step;
        jo_real *row = rows + (size_t)*written * size;
        int status = t < now ? write_between(m, d, s, t, row) : arrive(m, d);
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
    d->logged = 0;
    int status = *count == 0 ? begin(m, d, s, last) : JO_OK;
    if (status == JO_OK) status = follow(m, d, s, last, tries, room, count, written, rows);
    d->left = JO_RE(d->time[0]);
    return status;
}
