/* tree.h - rigid trees in joint coordinates: what other rooms may use. */
#ifndef JO_TREE_H
#define JO_TREE_H

#include "data.h"

/* tree_force_response.c */
void jo_tree_respond_clear(const jo_model *m, jo_data *d);
void jo_tree_respond(const jo_model *m, jo_data *d, jo_real *rate);   /* (nu) changes of the joints' accelerations */

/* tree_friction.c */
void jo_tree_slips(const jo_model *m, jo_data *d);    /* coordinates along which frictions slide, and their rates */
jo_real jo_tree_second(const jo_model *m, const jo_data *d, int coordinate);   /* and its acceleration */
void jo_tree_bears(const jo_model *m, const jo_data *d, const jo_friction *f, int change, jo_real *y);
void jo_tree_held(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *y);
void jo_tree_locks(const jo_model *m, jo_data *d);
void jo_tree_hold(const jo_model *m, jo_data *d);
void jo_tree_friction_respond(const jo_model *m, jo_data *d, const jo_real *f);
void jo_tree_friction_act(const jo_model *m, jo_data *d);
void jo_tree_stop(const jo_model *m, jo_data *d);     /* what is held comes to rest */

/* tree_position.c */
void jo_tree_setup(const jo_model *m, jo_data *d);
void jo_tree_kinematics(const jo_model *m, jo_data *d);
void jo_tree_read(const jo_model *m, jo_data *d);     /* x and u from q and v */
void jo_tree_spread(const jo_model *m, jo_data *d, const jo_real *rate, jo_real *v);   /* (nv) of the bodies at (nu) of the joints */

/* tree_to_maximal.c */
int jo_tree_stands(const jo_model *m, jo_data *d);    /* whether q and v are those of x and u, to the last digit */
void jo_mirror(const jo_model *m, jo_data *d, jo_mirrored how);

/* tree_integrate_position.c */
void jo_tree_displace(const jo_model *m, jo_real *x, const jo_real *x0, const jo_real *increment);
void jo_tree_increment_rate(const jo_model *m, jo_real *rate, const jo_real *x, const jo_real *u);
void jo_turn_between(jo_real *theta, const jo_real *e0, const jo_real *e);   /* below half a turn, in the frame of e0 */
void jo_tree_drives(const jo_model *m, jo_data *d);   /* what is prescribed has its value and rate of this time */
int jo_tree_check(const jo_model *m, jo_data *d);
double jo_tree_turned(const jo_model *m, jo_data *d);   /* largest turn of a body by the increments dq, about */

/* tree_forces.c */
void jo_tree_bodies(const jo_model *m, jo_data *d);    /* the bodies of all links, as jo_refresh leaves them */
void jo_tree_markers(const jo_model *m, jo_data *d, const int *list, int count);   /* the same of markers, with their velocities */
int jo_tree_forces(const jo_model *m, jo_data *d, const jo_stage *stage);
void jo_tree_states(const jo_model *m, jo_data *d, const jo_stage *stage);   /* rates of states that answer to the accelerations */

/* tree_loop_closure.c */
size_t jo_loop_bytes(void);
size_t jo_reach_bytes(void);
int jo_loop_rows(const jo_model *m, int i);   /* of the group of the loop, if it is the last one in it; else 0 */
void jo_loop_setup(const jo_model *m, jo_data *d);
int jo_loop_evaluate(const jo_model *m, jo_data *d, const jo_stage *stage);   /* multipliers, and the links bear them */
void jo_loop_solve(const jo_model *m, jo_data *d);   /* multipliers of the right-hand sides, with the factors of that */
void jo_loop_push(const jo_model *m, jo_data *d);    /* they act in jo_tree_respond */
jo_real jo_loop_power(const jo_model *m, const jo_data *d);

/* tree.c */
size_t jo_link_bytes(void);
size_t jo_link_constant_bytes(void);
size_t jo_link_change_bytes(void);
int jo_tree_load(const jo_model *m, jo_data *d, const jo_stage *stage);   /* forces and articulated inertias */
void jo_tree_follow(const jo_model *m, jo_data *d);   /* accelerations of the joints after that */
jo_real jo_tree_drive(const jo_model *m, jo_data *d); /* forces of what is prescribed; their power */
int jo_tree_evaluate(const jo_model *m, jo_data *d, const jo_stage *stage);

/* tree_on_flexible_bodies.c */
void jo_ports_setup(const jo_model *m, jo_data *d);
void jo_ports_place(const jo_model *m, jo_data *d);   /* bodies that run by rows and their markers are at x and u */
void jo_ports_accept(const jo_model *m, jo_data *d);  /* x and u of these are q and v, where the markers are */
int jo_ports_load(const jo_model *m, jo_data *d, const jo_stage *stage);   /* all forces, and the inertia of what is carried */
int jo_ports_factor(const jo_body *b, jo_body_work *w);
void jo_ports_follow(const jo_model *m, jo_data *d);  /* accelerations of what is carried */

/* tree_loop_projection.c */
/* Loops are closed in the metric of the masses, with the factors of the last evaluation; whether they are then. */
int jo_tree_close(const jo_model *m, jo_data *d);
void jo_tree_increments(const jo_model *m, jo_real *dq, const jo_real *x0, const jo_real *x);

/* tree_from_maximal.c */
int jo_tree_enter(const jo_model *m, jo_data *d);     /* the state of the caller becomes x and u */
void jo_tree_leave(const jo_model *m, jo_data *d);    /* and is the caller's again */
void jo_tree_count_turns(const jo_model *m, jo_data *d);
void jo_tree_drives_end(const jo_model *m, jo_data *d);   /* what is prescribed at the end of a step, and dq */

#endif
