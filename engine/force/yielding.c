/* yielding.c - forces that yield: their states at the start and at the ends of steps, margins and dissipated energy. */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"
#include "contact/contact.h"
#include "network/network.h"

int jo_yielding_ready(const jo_model *m, jo_data *d)
{
    const int status = jo_ready_sensors(m, d, 0);
    if (status != JO_OK || !m->nyielding) return status;
    jo_marker_position(m, d, m->nactive);
    jo_marker_velocity(m, d, m->nactive);
    for (int k = 0; k < m->nyielding; k++) {
        const int c = m->force[d->forces.yielding[k]].coordinate;
        const jo_network *w = jo_network_of_memory(d, &m->force[d->forces.yielding[k]]);
        if (w) jo_network_coordinates(m, d, w);
        if (c < 0) continue;
        jo_coordinate_value(m, d, c);
        jo_coordinate_rate(m, d, c);
    }
    return JO_OK;
}

jo_real jo_yielding_margin(const jo_model *m, const jo_data *d, int k)
{
    const jo_force *f = &m->force[d->forces.yielding[k]];
    return jo_released(d, f->release) ? jo_same(1.0) : jo_yielding_of(f)->margin(m, d, f);
}

int jo_yielding_approach(const jo_model *m, const jo_data *d, int k, jo_approach *y)
{
    const jo_force *f = &m->force[d->forces.yielding[k]];
    const jo_yielding *kind = jo_yielding_of(f);
    y->clear = INFINITY;
    y->highest = -INFINITY;
    for (int i = 0; i < 3; i++) y->spin[i] = 0.0;
    if (!kind->approach || jo_released(d, f->release) || !kind->approach(m, d, f, y)) return 0;
    y->highest = fmax(y->highest, y->rate);
    return 1;
}

int jo_ease_yielding(const jo_model *m, jo_data *d)
{
    int changed = 0;
    for (int k = 0; k < m->nyielding; k++) {
        const jo_force *f = &m->force[d->forces.yielding[k]];
        const jo_yielding *kind = jo_yielding_of(f);
        if (kind->ease && !jo_released(d, f->release)) changed |= kind->ease(m, d, f, jo_states(m, d) + f->state);
    }
    return changed;
}

double jo_yielding_longest_step(const jo_model *m, const jo_data *d, int explicit_method)
{
    double longest = INFINITY;
    for (int k = 0; k < m->nyielding; k++) {
        const jo_force *f = &m->force[d->forces.yielding[k]];
        const jo_yielding *kind = jo_yielding_of(f);
        if (!kind->longest_step || jo_released(d, f->release)) continue;
        const int own = explicit_method == JO_EXPLICIT_OUTSIDE ? f->type == JO_FORCE_contact_track : explicit_method;
        longest = fmin(longest, kind->longest_step(m, d, f, own));
    }
    return longest;
}

/* states of the k-th force that yields, at the present coordinates; returns the energy dissipated in the step */
static jo_real update_of(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x)
{
    for (int i = 0; i < f->states; i++) x[i] = jo_states(m, d)[f->state + i];
    return jo_released(d, f->release) ? jo_same(0.0) : jo_yielding_of(f)->update(m, d, f, x);
}

/* what follows jumps of the other forces at the same time; whether forces jump */
int jo_follow_jumps(const jo_model *m, jo_data *d)
{
    int jumped = 0;
    for (int k = 0; k < d->forces.following; k++) {
        const jo_force *f = &m->force[d->forces.follower[k]];
        const jo_yielding *kind = jo_yielding_of(f);
        kind->follow(m, d, f, jo_states(m, d) + f->state);
        jumped |= kind->jumps(f, jo_states(m, d) + f->state, jo_states(m, d) + f->state);
    }
    return jumped;
}

/* The states of the end of a step, and its dissipated energy; for that of contacts see contact_record.c. */
int jo_accept_yielding(const jo_model *m, jo_data *d, int records)
{
    jo_real *x = d->forces.next;
    int jumped = 0;
    for (int k = 0; k < m->nyielding; k++) {
        const jo_force *f = &m->force[d->forces.yielding[k]];
        const jo_yielding *kind = jo_yielding_of(f);
        const int recorded = records && kind->touches;
        if (recorded) jo_record_step(m, d, k);
        const jo_real lost = update_of(m, d, f, x);
        const int jumps = kind->jumps && kind->jumps(f, jo_states(m, d) + f->state, x);
        if (recorded) jo_record_change(m, d, k, x, jumps);
        if (!kind->touches) d->work.damping += lost;
        jumped |= jumps;
        for (int i = 0; i < f->states; i++) jo_states(m, d)[f->state + i] = x[i];
    }
    return jumped | jo_follow_jumps(m, d);
}

void jo_yield(const jo_model *m, jo_data *d)
{
    if (!m->nyielding) return;
    jo_state_changed(d);
    double none = 0.0;
    int overlap;
    if (jo_yielding_ready(m, d) == JO_OK && jo_find_contacts(m, d, &none, &overlap) == JO_OK)   /* needs no accelerations */
        jo_accept_yielding(m, d, 0);
    jo_state_changed(d);
}

jo_real jo_yielding_loss(const jo_model *m, const jo_data *d)
{
    jo_real sum = {0.0}, *x = d->forces.next;
    for (int k = 0; k < m->nyielding; k++) {
        const jo_force *f = &m->force[d->forces.yielding[k]];
        if (!jo_yielding_of(f)->touches) sum += update_of(m, d, f, x);
    }
    return sum;
}

jo_real jo_bristles_at_end(const jo_model *m, const jo_data *d)
{
    jo_real sums[JO_TOUCH_SUMS] = {0.0}, *x = d->forces.next;
    jo_touch unused[JO_MAX_TOUCHES];
    for (int k = 0; k < m->nyielding; k++) {
        const int force = d->forces.yielding[k];
        if (!jo_yielding_of(&m->force[force])->touches) continue;
        update_of(m, d, &m->force[force], x);
        jo_touches_of(m, d, force, x, unused, sums);
    }
    return sums[1];
}

void jo_force_state(const jo_model *m, const jo_data *d, int force, int state, jo_real *y)
{
    const jo_force *f = &m->force[force];
    jo_real *x = d->forces.next;
    y[0] = jo_states(m, d)[f->state + state];
    if (!jo_yielding_of(f)) return;
    update_of(m, d, f, x);
    y[0] = x[state];
}

void jo_start_states(const jo_model *m, jo_data *d)
{
    if (!m->nstate) return;
    jo_real unused[2];
    jo_residuals(m, d, unused);   /* kinematics of markers and coordinates at q, v */
    jo_coordinates_rate(m, d, m->ncoordinate);
    jo_state_changed(d);
    for (int i = 0; i < m->nforce; i++) jo_start_force(m, d, i);
    for (int k = 0; k < m->nyielding; k++) {   /* samples that are due at the start, when all values are the initial ones */
        const jo_force *f = &m->force[d->forces.yielding[k]];
        if (f->type == JO_FORCE_memory) jo_yielding_of(f)->update(m, d, f, jo_states(m, d) + f->state);
    }
    for (int k = 0; k < 2 * d->forces.following; k++) jo_follow_jumps(m, d);   /* values, then rates, of which each may need those of others */
    double none = 0.0;
    int overlap;
    jo_find_contacts(m, d, &none, &overlap);   /* pairs that touch at the start; the first step reports a failure */
}

/* the list of the forces that yield, and their states if there is no model */
void jo_force_setup(const jo_model *m, jo_data *d)
{
    int k = 0;
    d->forces.nstate = m->nstate;
    for (int i = 0; i < m->nforce && k < m->nyielding; i++)
        if (jo_yielding_of(&m->force[i])) d->forces.yielding[k++] = i;
    d->forces.following = 0;
    for (int k = 0; k < m->nyielding; k++)
        if (jo_yielding_of(&m->force[d->forces.yielding[k]])->follow) d->forces.follower[d->forces.following++] = d->forces.yielding[k];
}
