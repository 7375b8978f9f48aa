/* impulses.c - touches that are not resolved in time: all velocities jump in an instant.
 *
 *   v+ = v- + W p,   W = J M^-1 J^T,   n.v+ = -e n.v- where a point strikes,   |p_t| <= mu p_n
 * (J. J. Moreau, in: Nonsmooth Mechanics and Applications, CISM 302, 1988, 1-82). v: velocities of the points, p: impulses on b there. Rows of
 * joints, locks and stops that hold act in M^-1; friction of joints has no impulse. Points that are closed take part without rebound: their
 * speed of approach does not grow, and what sticks keeps its slip velocity. Impulses p do the work p (v- + v+) / 2; a collision that would
 * gain energy, as Newton's law with friction may, gets the largest restitution with which it does not.
 *
 * Columns of W are differences of accelerations with and without a force at a point, in both cores. */
#include "valid.h"
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"
#include "friction/friction.h"
#include "contact/contact.h"

#define JO_BLOW_RATE 1e6        /* forces that stand for impulses over these, 1/s: other forces are small beside them */
#define JO_AT_ONCE 1e-10        /* time, s, within which points strike together at an instant that is located */
#define JO_LEFT 1e-6            /* smallest share of its depth that a point that comes to rest keeps, so that its law begins */
enum { JO_GAIN_HALVINGS = 20, JO_PLACING = 50 };

/* work space of one machine */
typedef struct jo_struck {
    jo_strike point[JO_STRUCK];
    jo_real *W, *p, *v;         /* (n x n), (n), (n) velocities after */
    jo_real *pull;              /* (n) accelerations of the points along their rows */
    jo_real *before, *base, *change;   /* (nw) velocities, accelerations without a blow, changes */
    int points, rows, striking;
    int number[JO_STRUCK], forces;   /* forces that have struck last, their number, and the normal impulse of each, N s */
    double impulse[JO_STRUCK];
} jo_struck;

static int resolves_by_impulse(const jo_force *f)
{
    switch (f->type) {
    case JO_FORCE_contact: return JO_RE(((const jo_contact_data *)f->data)->resolve) == JO_RESOLVE_IMPULSE;
    case JO_FORCE_contact_pair: return JO_RE(((const jo_contact_pair_data *)f->data)->resolve) == JO_RESOLVE_IMPULSE;
    case JO_FORCE_contact_set: return JO_RE(((const jo_contact_set_data *)f->data)->resolve) == JO_RESOLVE_IMPULSE;
    default: return 0;
    }
}

void jo_impulse_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    int any = 0;
    for (int i = 0; i < m->nforce && !any; i++) any = resolves_by_impulse(&m->force[i]);
    const int nw = any ? (m->nv > m->nu ? m->nv : m->nu) + m->nstate : 0, n = any ? JO_STRUCK_ROWS : 0;
    jo_struck spare, *w = jo_take_many(a, any, sizeof *w);
    d->contacts.blow = jo_take_reals(a, any ? m->nstate : 0);
    if (!a->base) w = &spare;
    else d->contacts.struck = any ? w : 0;
    if (!any) return;
    w->W = jo_take_reals(a, n * n);
    w->p = jo_take_reals(a, n);
    w->v = jo_take_reals(a, n);
    w->pull = jo_take_reals(a, n);
    w->before = jo_take_reals(a, nw);
    w->base = jo_take_reals(a, nw);
    w->change = jo_take_reals(a, nw);
    d->contacts.struck_points = 1;
}

/* velocities of the machine: those before, plus a share of a change */
static int set_velocities(const jo_model *m, jo_data *d, const jo_struck *w, const jo_real *change, double share)
{
    for (int i = 0; i < d->nw - m->nstate; i++) d->w[i] = w->before[i] + share * change[i];
    jo_state_changed(d);
    jo_positions_moved(d);
    return jo_yielding_ready(m, d);
}

/* velocity of a point along its rows */
static void point_velocity(const jo_model *m, const jo_data *d, const jo_strike *s, jo_real *y)
{
    jo_real v[3], omega[3], turn[3];
    jo_relative_velocity(m, d, s->force, v, omega);
    jo_cross(turn, omega, s->lever);
    jo_add3(v, turn);
    for (int i = 0; i < s->rows; i++) y[i] = jo_dot3(s->axis + 3 * i, v);
}

/* accelerations with the blows that are set, less `base` if it is given */
static int accelerations(const jo_model *m, jo_data *d, const jo_real *base, jo_real *y)
{
    /* an impulse is not limited by friction of joints */
    jo_model bare = *m;
    bare.nfriction = 0;
    d->contacts.blows = base != 0;
    const int status = jo_accelerations(&bare, d);
    d->contacts.blows = 0;
    for (int i = 0; i < d->nw - m->nstate && status == JO_OK; i++) y[i] = base ? d->wd[i] - base[i] : d->wd[i];
    jo_state_changed(d);
    return status;
}

/* Points that strike now, and the closed ones. At a located instant these are the points that touch within JO_AT_ONCE of it; at the end of a
 * step of bounded work all that overlap. */
static void gather(const jo_model *m, jo_data *d, jo_struck *w, int bounded)
{
    int found = 0;
    for (int k = 0; k < m->nyielding; k++) {
        const jo_force *f = &m->force[jo_yielding_force(d, k)];
        const jo_yielding *kind = jo_yielding_of(f);
        if (!kind->strikes || jo_released(d, f->release)) continue;
        const int more = kind->strikes(m, d, f, w->point + found, JO_STRUCK - found);
        for (int i = found; i < found + more; i++) w->point[i].number = jo_yielding_force(d, k);
        found += more;
    }
    w->points = w->rows = w->striking = 0;
    for (int i = 0; i < found; i++) {
        jo_strike *s = &w->point[i];
        point_velocity(m, d, s, s->v);
        const int now = bounded ? JO_RE(s->gap) < 0.0 : -JO_RE(s->v[0]) > JO_RE(s->slowest) && JO_RE(s->gap) < -JO_AT_ONCE * JO_RE(s->v[0]);
        if (!now && !s->closed) continue;
        w->striking += !s->closed;
        w->rows += s->rows;
        if (w->points != i) w->point[w->points] = *s;
        w->points++;
    }
}

/* columns of W by unit impulses in turn */
static int influence(const jo_model *m, jo_data *d, jo_struck *w)
{
    const int n = w->rows;
    for (int i = 0, column = 0; i < w->points; i++) {
        const jo_strike *s = &w->point[i];
        for (int r = 0; r < s->rows; r++, column++) {
            const jo_real size = s->mass * JO_BLOW_RATE * (JO_RE(s->v[0]) < -JO_RE(s->slowest) ? -s->v[0] : s->slowest);
            int status = set_velocities(m, d, w, w->before, 0.0);
            for (int j = 0; j < 3; j++) d->contacts.blow[s->first + j] = size * s->axis[3 * r + j];
            if (status == JO_OK) status = accelerations(m, d, w->base, w->change);
            for (int j = 0; j < 3; j++) d->contacts.blow[s->first + j] = jo_same(0.0);
            for (int j = 0; j < d->nw - m->nstate; j++) w->change[j] /= size;
            if (status == JO_OK) status = set_velocities(m, d, w, w->change, 1.0);
            if (status != JO_OK) return status;
            for (int k = 0, row = 0; k < w->points; row += w->point[k++].rows) {
                jo_real v[3];
                point_velocity(m, d, &w->point[k], v);
                for (int c = 0; c < w->point[k].rows; c++) w->W[(row + c) * n + column] = v[c] - w->point[k].v[c];
            }
        }
    }
    return JO_OK;
}

/* impulses with a share of the restitution of all points; returns the energy that they add, J */
static double collide(const jo_struck *w, jo_strike *point, double share, int *settled)
{
    const int n = w->rows;
    for (int i = 0; i < w->points; i++) {
        jo_strike *s = &point[i];
        for (int r = 0; r < s->rows; r++) s->target[r] = s->closed ? s->v[r] : jo_same(0.0);
        if (JO_RE(s->v[0]) > 0.0) s->target[0] = jo_same(0.0);
        else if (!s->closed) s->target[0] = -share * s->restitution * s->v[0];
    }
    *settled = jo_impulse_solve(point, w->points, n, w->W, w->p);
    double gain = 0.0;
    for (int i = 0, at = 0; i < w->points; at += point[i++].rows)
        for (int r = 0; r < point[i].rows; r++) {
            jo_real change = {0.0};
            for (int c = 0; c < n; c++) change += w->W[(at + r) * n + c] * w->p[c];
            w->v[at + r] = point[i].v[r] + change;
            gain += JO_RE(w->p[at + r] * (point[i].v[r] + 0.5 * change));
        }
    return gain;
}

/* joints do not stick in a collision; jo_friction_initialise_states decides afterwards */
static void release_frictions(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++)
        if (jo_sticks(m, d, &m->friction[i])) d->locked[m->joint[m->friction[i].lock].lock] = d->slip[i] = 0;
}

/* A step of bounded work ends after the touches in it. Of each point: its accelerations; the time since its touch, from v late - a late^2 / 2 =
 * depth; its velocity then. Points that are slow, or whose rebound would be over within two steps, come to rest. */
static int go_back(const jo_model *m, jo_data *d, jo_struck *w, double h)
{
    const int status = set_velocities(m, d, w, w->base, h);
    for (int i = 0, at = 0; i < w->points && status == JO_OK; at += w->point[i++].rows) {
        jo_strike *s = &w->point[i];
        jo_real now[3];
        point_velocity(m, d, s, now);
        for (int r = 0; r < s->rows; r++) w->pull[at + r] = (now[r] - s->v[r]) / h;
        if (s->closed) continue;
        const double v = -JO_RE(s->v[0]), a = -JO_RE(w->pull[at]), root = v * v + 2.0 * a * JO_RE(s->gap);
        s->rests = v <= JO_RE(s->slowest) || h * a >= JO_RE(s->restitution) * v;
        if (s->rests) s->restitution = jo_same(0.0);
        if (s->rests || !(v > 0.0)) continue;
        s->late = fmin(h, -2.0 * JO_RE(s->gap) / (v + sqrt(fmax(root, 0.0))));
        for (int r = 0; r < s->rows; r++) s->v[r] -= s->late * w->pull[at + r];
    }
    return status;
}

/* y = M^-1 J^T p by the difference of accelerations */
static int respond(const jo_model *m, jo_data *d, jo_struck *w, const jo_real *p, jo_real *y)
{
    int status = set_velocities(m, d, w, w->before, 0.0);
    for (int i = 0, at = 0; i < w->points; at += w->point[i++].rows)
        for (int j = 0; j < 3; j++) {
            jo_real *x = &d->contacts.blow[w->point[i].first + j];
            *x = jo_same(0.0);
            for (int r = 0; r < w->point[i].rows; r++) *x += JO_BLOW_RATE * p[at + r] * w->point[i].axis[3 * r + j];
        }
    if (status == JO_OK) status = accelerations(m, d, w->base, y);
    for (int i = 0; i < w->points; i++)
        for (int j = 0; j < 3; j++) d->contacts.blow[w->point[i].first + j] = jo_same(0.0);
    for (int i = 0; i < d->nw - m->nstate; i++) y[i] /= JO_BLOW_RATE;
    return status;
}

/* forces of the points at rest, by which their depths follow from their laws: into w->v */
static void rest_depths(jo_struck *w, const jo_real *pull)
{
    for (int i = 0, at = 0; i < w->points; at += w->point[i++].rows) {
        jo_strike *s = &w->point[i];
        for (int r = 0; r < s->rows; r++) {
            s->v[r] = pull[at + r];
            s->target[r] = s->closed ? s->v[r] : jo_same(0.0);
        }
    }
    (void)jo_impulse_solve(w->point, w->points, w->rows, w->W, w->v);
    for (int i = 0, at = 0; i < w->points; at += w->point[i++].rows) {
        const jo_strike *s = &w->point[i];
        w->v[at] = pow(JO_RE(w->v[at] / s->stiffness), 1.0 / JO_RE(s->exponent));
    }
}

/* Displacements by M^-1 J^T q: those of impulses that have acted for a time, and the least ones such that no point is deeper than the law of a
 * point that rests, and no closed one gets deeper. w->p: impulses, then q. */
static void displacements(jo_struck *w)
{
    const int n = w->rows;
    jo_real *q = w->p, *more = w->v;
    rest_depths(w, w->pull);
    for (int i = 0, at = 0; i < w->points; at += w->point[i++].rows) {
        const jo_strike *s = &w->point[i];
        const double depth = fmax(s->rests ? JO_RE(w->v[at]) : 0.0, JO_LEFT * fabs(JO_RE(s->gap)));
        w->pull[at] = s->closed ? jo_same(0.0) : -depth - s->gap;   /* least displacement */
        more[at] = jo_same(0.0);
        for (int r = 0; r < s->rows; r++) q[at + r] *= s->late;
    }
    for (int sweep = 0; sweep < JO_PLACING; sweep++)
        for (int i = 0, at = 0; i < w->points; at += w->point[i++].rows) {
            jo_real moved = {0.0};
            for (int k = 0; k < n; k++) moved += w->W[at * n + k] * q[k];
            jo_real push = more[at] + (w->pull[at] - moved) / w->W[at * n + at];
            if (JO_RE(push) < 0.0) push = jo_same(0.0);
            q[at] += push - more[at];
            more[at] = push;
        }
}

/* positions += share change */
static void move(const jo_model *m, jo_data *d, const jo_real *change, double share)
{
    for (int i = 0; i < d->ny; i++) d->q0[i] = d->y[i];
    for (int i = 0; i < d->nw; i++) d->dq[i] = i < d->nw - m->nstate ? share * change[i] : jo_same(0.0);
    jo_integrate_positions(m, d, d->dq);
    jo_state_changed(d);
    jo_positions_moved(d);
}

/* All velocities jump by the impulses; in a step of bounded work positions move, too. */
static int jump(const jo_model *m, jo_data *d, jo_struck *w, int bounded)
{
    int status = respond(m, d, w, w->p, w->change);
    if (status == JO_OK && bounded) {
        displacements(w);
        status = respond(m, d, w, w->p, w->base);
        if (status == JO_OK) move(m, d, w->base, 1.0);
    }
    return status == JO_OK ? set_velocities(m, d, w, w->change, 1.0) : status;
}

static jo_real friction_work(const jo_struck *w)
{
    jo_real rubbed = {0.0};
    for (int i = 0, at = 0; i < w->points; at += w->point[i++].rows)
        for (int r = 1; r < w->point[i].rows; r++) rubbed -= 0.5 * w->p[at + r] * (w->point[i].v[r] + w->v[at + r]);
    return rubbed;
}

/* work of the impulses; that of drives, whose speeds do not jump, is the other part of the change of the energy */
static void book(const jo_model *m, jo_data *d, const jo_energies *before, double gain, jo_real rubbed, int bounded)
{
    jo_energies after;
    jo_energy(m, d, &after);
    d->work.friction += rubbed;
    if (bounded) {   /* with the change of the positions */
        d->work.damping += before->kinetic - after.kinetic + before->strain - after.strain + before->potential - after.potential
                           + before->springs - after.springs - rubbed;
        return;
    }
    d->work.damping -= gain + rubbed;
    d->work.forces += after.kinetic - before->kinetic - gain;
}

/* speed and time of the touch of each point that strikes, and the normal impulses of each force */
static void note_touches(const jo_model *m, jo_data *d, jo_struck *w)
{
    w->forces = 0;
    for (int i = 0, at = 0; i < w->points; at += w->point[i++].rows) {
        const jo_strike *s = &w->point[i];
        if (s->closed) continue;
        jo_states(m, d)[s->approach] = JO_RE(s->v[0]) < -JO_RE(s->slowest) ? -s->v[0] : s->slowest;
        jo_states(m, d)[s->since] = d->time[0] - s->late;
        if (!w->forces || w->number[w->forces - 1] != s->number) {   /* points of a force follow one another */
            w->number[w->forces] = s->number;
            w->impulse[w->forces++] = 0.0;
        }
        w->impulse[w->forces - 1] += JO_RE(w->p[at]);
    }
}

int jo_struck_force(const jo_data *d, int k, double *impulse)
{
    const jo_struck *w = d->contacts.struck;
    if (k >= w->forces) return -1;
    *impulse = w->impulse[k];
    return w->number[k];
}

int jo_strike_all(const jo_model *m, jo_data *d, double h, int *struck)
{
    jo_struck *w = d->contacts.struck;
    jo_energies before;
    *struck = 0;
    int status = jo_yielding_ready(m, d), settled = 1;
    if (status != JO_OK) return status;
    gather(m, d, w, h > 0.0);
    if (!w->striking) return JO_OK;
    jo_energy(m, d, &before);
    for (int i = 0; i < d->nw - m->nstate; i++) w->before[i] = d->w[i];
    release_frictions(m, d);
    status = accelerations(m, d, 0, w->base);
    if (status == JO_OK) status = influence(m, d, w);
    if (status == JO_OK && h > 0.0) status = go_back(m, d, w, h);
    if (status != JO_OK) return status;
    double gain = collide(w, w->point, 1.0, &settled), share = 1.0;
    for (int i = 0; gain > 0.0 && i < JO_GAIN_HALVINGS; i++) gain = collide(w, w->point, share *= 0.5, &settled);
    d->counts.deferred += !settled;
    note_touches(m, d, w);
    *struck = w->striking;
    const jo_real rubbed = friction_work(w);
    status = jump(m, d, w, h > 0.0);
    if (status == JO_OK) book(m, d, &before, gain, rubbed, h > 0.0);
    return status;
}
