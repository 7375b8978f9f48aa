/* body_loads.c - loads of every force, friction and joint on one body at the present state, one row each.
 *
 * A row is [force, moment about the origin of the body frame, modal forces], all in the body frame. Rows: forces, frictions, joints (with
 * couplings, drives, and the optional joints of sticking friction).
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"
#include "friction/friction.h"

/* row = forces on the body, which become 0; returns the next row */
static jo_real *take(const jo_body *b, jo_body_work *w, jo_real *row)
{
    for (int j = 0; j < 6; j++) row[j] = w->fr[j];
    for (int j = 0; j < b->n; j++) row[6 + j] = w->fp[j];
    jo_clear_forces(b, w);
    return row + 6 + b->n;
}

/* loads at time, q, v, lam; without joints and forces that an event has released */
int jo_body_loads(const jo_model *m, jo_data *d, int body, jo_real *out)
{
    const jo_body *b = &m->body[body];
    jo_body_work *w = &d->body[body];
    /* kinematics and friction forces (rub) at the present state */
    const int status = jo_residual_at(m, d, &jo_now, d->rate);
    if (status != JO_OK) return status;
    jo_clear_forces(b, w);
    for (int i = 0; i < m->nforce; i++) {
        const int applied = jo_apply_force(m, d, &jo_now, i);
        if (applied != JO_OK) {
            d->error_index = i;
            return applied;
        }
        out = take(b, w, out);
    }
    for (int i = 0; i < m->nfriction; i++) {
        jo_friction_apply_force(m, d, i);
        out = take(b, w, out);
    }
    for (int i = 0; i < m->njoint; i++) {
        if (!jo_joint_inactive(d, i)) jo_apply_reaction(m, d, i);
        out = take(b, w, out);
    }
    return JO_OK;
}
