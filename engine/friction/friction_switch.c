/* friction_switch.c - transitions between sticking and sliding of stick-slip frictions. */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"
#include "friction/friction_law.h"
#include "tree/tree.h"

/* slip speed / scale of the slip, 1/s, above which slip along two coordinates changes direction without a stop */
#define JO_PASSING_SPEED 1e-7
#define JO_BACK_ACCELERATION 1e-9   /* acceleration against the slip / scale of the slip, 1/s2, above which the slip ends */
enum { JO_ROUNDS = 8, JO_ROUNDS_EACH = 4 };   /* largest number of rounds of release(): constant part, and part per friction */

#define JO_STOPS_TOO 1e-8   /* slip speed / size of the mechanism, 1/s, up to which other points stop with one that stops */

static int *lock_of(const jo_model *m, jo_data *d, const jo_friction *f) { return &d->locked[m->joint[f->lock].lock]; }

/* friction i starts to slide, in the direction opposite to its holding force */
void jo_friction_start_sliding(const jo_model *m, jo_data *d, int i)
{
    const jo_friction *f = &m->friction[i];
    jo_real y[2], *e = d->direction + 2 * i;
    if (f->contact >= 0) {
        jo_friction_let_go(m, d, i);
        return;
    }
    jo_friction_sticking_force(m, d, f, y);
    for (int k = 0; k < jo_slips(f); k++) y[k] /= jo_slip_arm(m, f, k);
    const jo_real whole = jo_length2(y[0], y[1]);
    for (int k = 0; k < 2; k++) e[k] = JO_RE(whole) > 0.0 ? -y[k] / whole : (k ? 0.0 : 1.0);
    d->slip[i] = jo_slips(f) == 2 || JO_RE(e[0]) > 0.0 ? 1 : -1;
    *lock_of(m, d, f) = 0;
    jo_forces_jumped(d);
}

/* friction i holds the present coordinates */
void jo_friction_hold(const jo_model *m, jo_data *d, int i)
{
    const jo_friction *f = &m->friction[i];
    for (int k = 0; k < jo_slips(f); k++)
        d->held[2 * m->joint[f->lock].lock + k] = d->coordinate[jo_slip_of(f, k)].value;
}

/* friction i starts to stick at the present coordinates */
void jo_friction_start_sticking(const jo_model *m, jo_data *d, int i)
{
    const jo_friction *f = &m->friction[i];
    jo_friction_hold(m, d, i);
    *lock_of(m, d, f) = 1;
    d->slip[i] = 0;
    jo_forces_jumped(d);
}

/* Points of contacts that slide as slowly as round-off stop together with one that stops: friction of the others along their last slip would
 * push the body back. */
static void stop_contacts(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++) {
        const jo_friction *f = &m->friction[i];
        jo_real s[2];
        if (f->contact < 0 || jo_sticks(m, d, f) || jo_friction_apart(m, d, f)) continue;
        jo_friction_slip(m, d, f, s);
        if (JO_RE(jo_length2(s[0], s[1])) <= JO_STOPS_TOO * m->size) jo_friction_start_sticking(m, d, i);
    }
}

/* velocities that satisfy the lock rows; the loss of kinetic energy is work of friction */
static int stop_sliding(const jo_model *m, jo_data *d)
{
    jo_energies before, after;
    int status = jo_accelerations(m, d);
    if (status != JO_OK) return status;
    jo_energy(m, d, &before);
    if (jo_tree_active(d)) jo_tree_stop_sticking(m, d);
    else jo_project(m, d, &jo_now);
    jo_energy(m, d, &after);
    d->work.friction += before.kinetic - after.kinetic;
    return jo_accelerations(m, d);
}

/* whether friction i, which slides from rest along one coordinate, is accelerated against its slip */
int jo_friction_accelerated_back(const jo_model *m, const jo_data *d, int i)
{
    const jo_friction *f = &m->friction[i];
    jo_real s[2];
    if (!f->law || jo_sticks(m, d, f) || !d->slip[i] || jo_slips(f) == 2) return 0;
    jo_friction_slip(m, d, f, s);
    if (fabs(JO_RE(s[0])) > 2.0 * JO_REST * jo_slip_scale(m, f)) return 0;
    const jo_real second = jo_tree_active(d) ? jo_tree_slip_acceleration(m, d, f->coordinate) : jo_coordinate_acceleration(m, d, f->coordinate);
    return d->slip[i] * JO_RE(jo_slip_arm(m, f, 0) * second) < -JO_BACK_ACCELERATION * jo_slip_scale(m, f);
}

/* excess of the holding force of friction i over its static limit, relative to that force; 0 while it slides or holds */
double jo_friction_overload(const jo_model *m, const jo_data *d, int i)
{
    jo_real y[2];
    if (!jo_sticks(m, d, &m->friction[i])) return 0.0;
    const double margin = JO_RE(jo_friction_margin(m, d, i));
    if (!(margin < 0.0)) return 0.0;
    if (m->friction[i].contact >= 0) return -margin;   /* relative, see jo_friction_margin */
    jo_friction_sticking_force(m, d, &m->friction[i], y);
    return -margin / (fabs(JO_RE(y[0])) + fabs(JO_RE(y[1])));
}

/* Frictions above their static limit start to slide, the one with the largest relative overload first; frictions that are accelerated against
 * their slip stick again. Repeated until no state changes, at most JO_ROUNDS + JO_ROUNDS_EACH n times. */
static int release(const jo_model *m, jo_data *d)
{
    for (int round = 0; round < JO_ROUNDS + JO_ROUNDS_EACH * m->nfriction; round++) {
        int weakest = -1, back = -1;
        double most = 0.0;
        for (int i = 0; i < m->nfriction; i++) {
            if (jo_friction_accelerated_back(m, d, i)) back = i;
            const double overload = jo_friction_overload(m, d, i);
            if (overload > most) {
                most = overload;
                weakest = i;
            }
        }
        if (weakest >= 0) jo_friction_start_sliding(m, d, weakest);
        else if (back >= 0) jo_friction_start_sticking(m, d, back);
        else break;
        if (jo_tree_active(d)) jo_tree_hold_sticking(m, d);   /* locked coordinates exactly at rest */
        const int status = jo_accelerations(m, d);
        if (status != JO_OK) return status;
    }
    return JO_OK;
}

/* end of the state of friction i, after jo_evaluate: sticking to sliding; sliding to sticking and, above the static limit, to sliding
 * in the opposite direction */
int jo_friction_switch(const jo_model *m, jo_data *d, int i)
{
    const jo_friction *f = &m->friction[i];
    if (!f->law || jo_friction_apart(m, d, f)) return JO_OK;
    int status;
    if (jo_sticks(m, d, f)) {
        jo_friction_start_sliding(m, d, i);
        status = jo_accelerations(m, d);
    } else {
        jo_real e[2];
        jo_friction_slip(m, d, f, e);
        const jo_real speed = jo_length2(e[0], e[1]);
        if (jo_slips(f) == 2 && JO_RE(speed) > JO_PASSING_SPEED * jo_slip_scale(m, f)) {   /* new direction of slip without a stop */
            for (int k = 0; k < 2; k++) d->direction[2 * i + k] = e[k] / speed;
            jo_forces_jumped(d);
            return jo_accelerations(m, d);
        }
        jo_friction_start_sticking(m, d, i);
        if (f->contact >= 0) stop_contacts(m, d);
        status = stop_sliding(m, d);
    }
    return status == JO_OK ? release(m, d) : status;
}

/* initial states of undetermined frictions: sliding if the joint moves, else sticking up to the static limit */
int jo_friction_initialise_states(const jo_model *m, jo_data *d)
{
    int undecided = 0, resting = 0, status = JO_OK;
    for (int i = 0; i < m->nfriction; i++)
        undecided += m->friction[i].law && !d->slip[i] && !jo_sticks(m, d, &m->friction[i]) && !jo_friction_apart(m, d, &m->friction[i]);
    if (!undecided) return JO_OK;
    status = jo_accelerations(m, d);
    for (int i = 0; i < m->nfriction && status == JO_OK; i++) {
        const jo_friction *f = &m->friction[i];
        jo_real e[2];
        if (!f->law || d->slip[i] || jo_sticks(m, d, f) || jo_friction_apart(m, d, f)) continue;
        jo_friction_direction(m, d, i, e);
        if (e[0] == 0.0 && e[1] == 0.0) {
            jo_friction_start_sticking(m, d, i);
            resting = 1;
        } else {
            for (int k = 0; k < 2; k++) d->direction[2 * i + k] = e[k];
            d->slip[i] = jo_slips(f) == 2 || JO_RE(e[0]) > 0.0 ? 1 : -1;
        }
    }
    if (status == JO_OK) status = resting ? stop_sliding(m, d) : jo_accelerations(m, d);
    return status == JO_OK ? release(m, d) : status;
}

/* States after the touches of a step: a contact that has opened has none, and of one that has begun it is found. */
int jo_friction_follow_contacts(const jo_model *m, jo_data *d)
{
    int opened = 0;
    for (int i = 0; i < m->nfriction; i++) {
        const jo_friction *f = &m->friction[i];
        if (!jo_friction_apart(m, d, f) || !(d->slip[i] || jo_sticks(m, d, f))) continue;
        *lock_of(m, d, f) = d->slip[i] = 0;
        opened = 1;
    }
    if (opened) {
        jo_state_changed(d);
        jo_forces_jumped(d);
    }
    return jo_friction_initialise_states(m, d);
}
