/* friction.h - friction in joints: forces, sticking, tangents; functions for other rooms. */
#ifndef JO_FRICTION_H
#define JO_FRICTION_H

#include "arena.h"
#include "data.h"

/* number of coordinates along which a joint slides, and coordinate k of these */
static inline int jo_slips(const jo_friction *f) { return f->other >= 0 ? 2 : 1; }
static inline int jo_slip_of(const jo_friction *f, int k) { return k ? f->other : f->coordinate; }

/* whether a joint with static friction sticks */
static inline int jo_sticks(const jo_model *m, const jo_data *d, const jo_friction *f)
{
    return f->law && d->locked[m->joint[f->lock].lock];
}

/* friction.c */
void jo_friction_apply_force(const jo_model *m, jo_data *d, int i);
void jo_friction_apply_forces(const jo_model *m, jo_data *d);
jo_real jo_friction_margin(const jo_model *m, const jo_data *d, int i);
void jo_friction_update_direction(const jo_model *m, jo_data *d);
/* Derivatives of the two friction forces with respect to the rates of the coordinates and to force and moment (world) of the reaction. */
typedef struct { jo_real rate[2][2], force[2][3], moment[2][3]; } jo_slopes;
void jo_friction_slopes(const jo_model *m, const jo_data *d, int i, jo_slopes *y);

/* friction_tangent.c */
void jo_newton_frictions(const jo_model *m, jo_data *d);

/* friction_iteration.c */
void jo_friction_layout(const jo_model *m, jo_data *d, jo_arena *a);
int jo_friction_solve(const jo_model *m, jo_data *d, const jo_stage *stage);

/* friction_switch.c */
int jo_friction_switch(const jo_model *m, jo_data *d, int i);
int jo_friction_initialise_states(const jo_model *m, jo_data *d);

/* friction_step_end.c */
int jo_friction_end_slips(const jo_model *m, jo_data *d, const int *reversed, double late);
void jo_friction_keep_accelerations(jo_data *d);
int jo_friction_catch_up(const jo_model *m, jo_data *d, double late);
int jo_friction_release_all(const jo_model *m, jo_data *d, int *changed);
int jo_friction_unsettled(const jo_model *m, const jo_data *d);

#endif
