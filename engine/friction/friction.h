/* friction.h - friction in joints: forces, sticking, tangents; functions for other rooms. */
#ifndef JO_FRICTION_H
#define JO_FRICTION_H

#include "arena.h"
#include "data.h"
#include "force/force.h"

#define JO_LEAST_SHARE 1e4      /* largest regularisation of a row, relative to the usual one */

/* number of coordinates along which a joint slides, and coordinate k of these */
static inline int jo_slips(const jo_friction *f) { return f->other >= 0 ? 2 : 1; }
static inline int jo_slip_of(const jo_friction *f, int k) { return k ? f->other : f->coordinate; }

/* whether a joint with static friction sticks */
static inline int jo_sticks(const jo_model *m, const jo_data *d, const jo_friction *f)
{
    return f->law && d->locked[m->joint[f->lock].lock];
}

/* whether it belongs to a contact that does not touch: then it has no state */
static inline int jo_friction_apart(const jo_model *m, const jo_data *d, const jo_friction *f)
{
    return f->contact >= 0 && !jo_contact_touches(d, &m->force[f->contact]);
}

#ifndef JO_VECTOR
/* index of the friction of a contact, -1: none; they come last, in the order of their forces */
static inline int jo_friction_of_contact(const jo_model *m, const jo_force *f)
{
    const int force = (int)(f - m->force);
    int low = 0, high = m->nfriction;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (m->friction[middle].contact < force) low = middle + 1;
        else high = middle;
    }
    return low < m->nfriction && m->friction[low].contact == force ? low : -1;
}
#endif

/* body that bears on a contact, of which several points may stick */
static inline int jo_bearing_body(const jo_model *m, const jo_friction *f)
{
    const jo_joint *k = &m->joint[f->lock];
    const int body = m->marker[k->side[1]].body;
    return body >= 0 ? body : m->marker[k->side[0]].body;
}

/* Regularisation of a row of this joint, for which `size` is the usual one: of contacts that stick by their share. */
static inline jo_real jo_friction_softness(const jo_model *m, const jo_data *d, int joint, jo_real size)
{
#ifdef JO_VECTOR
    (void)m; (void)d; (void)joint;   /* machines with friction run alone */
#else
    const double share = m->nfriction ? d->friction.share[joint] : 0.0;
    if (share > 0.0) return jo_same(fmin(share, JO_LEAST_SHARE * JO_RE(size)));
#endif
    return size;
}

/* friction.c */
void jo_friction_push_contacts(const jo_model *m, jo_data *d);
void jo_friction_apply_force(const jo_model *m, jo_data *d, int i);
void jo_friction_apply_forces(const jo_model *m, jo_data *d);
void jo_friction_update_direction(const jo_model *m, jo_data *d);
/* Derivatives of the two friction forces with respect to the rates of the coordinates and to force and moment (world) of the reaction. */
typedef struct { jo_real rate[2][2], force[2][3], moment[2][3]; } jo_slopes;
void jo_friction_slopes(const jo_model *m, const jo_data *d, int i, jo_slopes *y);

/* friction_contacts.c */
void jo_friction_layout_contacts(const jo_model *m, jo_data *d, jo_arena *a);
void jo_friction_share(const jo_model *m, jo_data *d);

/* friction_margin.c */
jo_real jo_friction_margin(const jo_model *m, const jo_data *d, int i);

/* friction_tangent.c */
void jo_newton_frictions(const jo_model *m, jo_data *d);

/* friction_iteration.c */
void jo_friction_layout(const jo_model *m, jo_data *d, jo_arena *a);
int jo_friction_solve(const jo_model *m, jo_data *d, const jo_stage *stage);

/* friction_switch.c */
int jo_friction_switch(const jo_model *m, jo_data *d, int i);
int jo_friction_initialise_states(const jo_model *m, jo_data *d);
int jo_friction_follow_contacts(const jo_model *m, jo_data *d);

/* friction_step_end.c */
int jo_friction_end_slips(const jo_model *m, jo_data *d, const int *reversed, double late);
void jo_friction_keep_accelerations(jo_data *d);
int jo_friction_catch_up(const jo_model *m, jo_data *d, double late);
int jo_friction_release_all(const jo_model *m, jo_data *d, int *changed);
int jo_friction_unsettled(const jo_model *m, const jo_data *d);

#endif
