/* tree.h - rigid trees in joint coordinates: functions for other rooms. */
#ifndef JO_TREE_H
#define JO_TREE_H

#include "arena.h"
#include "data.h"

/* f along the joint coordinate of a link with one degree of freedom, in the direction of the joint */
static inline void jo_tree_push(const jo_model *m, jo_data *d, int link, jo_real f)
{
    d->tree.tau[m->link[link].u] += m->link[link].reversed ? -f : f;
}

/* link of the body of a marker; -1: none, or the ground */
static inline int jo_marker_link(const jo_model *m, const jo_data *d, int marker)
{
    const int body = m->marker[marker].body;
    return body < 0 || !m->nlink ? -1 : d->tree.of_body[body];
}

/* tree_force_response.c */
void jo_tree_clear_added_forces(const jo_model *m, jo_data *d);
void jo_tree_force_response(const jo_model *m, jo_data *d, jo_real *rate);   /* rate (nu): change of qdd by the added forces */
void jo_tree_add_response(const jo_model *m, jo_data *d, jo_real part);   /* part of it to the accelerations and forces of the links */

/* tree_friction.c */
void jo_tree_update_slips(const jo_model *m, jo_data *d);   /* value and rate of the coordinates with friction */
jo_real jo_tree_slip_acceleration(const jo_model *m, const jo_data *d, int coordinate);
void jo_tree_joint_reaction(const jo_model *m, const jo_data *d, const jo_friction *f, int change, jo_real *y);
void jo_tree_sticking_force(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *y);
jo_real jo_tree_row_force(const jo_model *m, const jo_data *d, int coordinate);   /* along a locked coordinate */
void jo_tree_lock_sticking(const jo_model *m, jo_data *d);   /* multipliers of the rows that lock joints */
void jo_tree_hold_sticking(const jo_model *m, jo_data *d);   /* coordinates of locked joints at their locked values, rates 0 */
void jo_tree_friction_response(const jo_model *m, jo_data *d, int n, const int *coordinate, const jo_real *f);
void jo_tree_apply_friction(const jo_model *m, jo_data *d, int n, const int *coordinate, const jo_real *f);
void jo_tree_stop_sticking(const jo_model *m, jo_data *d);   /* impulses that stop the locked joints */

/* tree_position.c */
void jo_tree_setup(const jo_model *m, jo_data *d);
void jo_tree_kinematics(const jo_model *m, jo_data *d);
void jo_tree_read_maximal_state(const jo_model *m, jo_data *d);   /* x and u from q and v */
void jo_tree_body_rates(const jo_model *m, jo_data *d, const jo_real *rate, jo_real *v);   /* v (nv) of the bodies from joint rates (nu) */

/* maximal_state.c */
int jo_tree_matches_maximal_state(const jo_model *m, jo_data *d);   /* whether q and v equal those of x and u bit for bit */
void jo_sync_maximal_state(const jo_model *m, jo_data *d, jo_sync_level level);

/* tree_integrate_position.c */
void jo_tree_add_increment(const jo_model *m, jo_real *x, const jo_real *x0, const jo_real *increment);
void jo_tree_increment_rate(const jo_model *m, jo_real *rate, const jo_real *x, const jo_real *u);
void jo_tree_prescribe_motion(const jo_model *m, jo_data *d);   /* coordinate, rate and acceleration of drives at the present time */
int jo_tree_check_state(const jo_model *m, jo_data *d);

/* tree_increments.c */
void jo_rotation_vector_between(jo_real *theta, const jo_real *e0, const jo_real *e);   /* theta (3), |theta| < pi, in the frame of e0 */
void jo_tree_increment_between(const jo_model *m, jo_real *dq, const jo_real *x0, const jo_real *x);
double jo_tree_largest_rotation(const jo_model *m, jo_data *d);   /* estimate of the largest rotation of a body by the increments dq, rad */

/* tree_forces.c */
void jo_tree_update_bodies(const jo_model *m, jo_data *d);   /* pose and velocity of the bodies of all links, as after jo_update_positions */
void jo_tree_update_markers(const jo_model *m, jo_data *d, const int *list, int count);   /* pose and velocity of the markers in list */
int jo_tree_apply_forces(const jo_model *m, jo_data *d, const jo_stage *stage);
void jo_tree_implicit_state_rates(const jo_model *m, jo_data *d, const jo_stage *stage);   /* state rates of the W-method */

/* tree_loop_closure.c */
int jo_loop_rows(const jo_model *m, int i);   /* rows of the group of loop i if i is the last loop of the group, else 0 */
void jo_loop_setup(const jo_model *m, jo_data *d);
int jo_loop_evaluate(const jo_model *m, jo_data *d, const jo_stage *stage);   /* multipliers, and their forces on the links */
void jo_loop_solve(const jo_model *m, jo_data *d);   /* multipliers for the right-hand sides x, with the last factors */
void jo_loop_add_multiplier_forces(const jo_model *m, jo_data *d);   /* forces of the multipliers as added forces */
jo_real jo_loop_power(const jo_model *m, const jo_data *d);   /* power of drives in loops, W */

/* tree_networks.c */
void jo_tree_network_jacobian(const jo_model *m, jo_data *d, struct jo_network *w, int k);
void jo_tree_push_network(const jo_model *m, jo_data *d, const struct jo_network *w, int k, jo_real F);   /* added force F along coordinate k */

/* tree_contacts.c */
int jo_tree_takes_contacts(const jo_model *m);   /* whether steps in joint coordinates have contacts in their matrix */
void jo_tree_contact_layout(const jo_model *m, jo_data *d, jo_arena *a);
void jo_tree_contact_jacobian(const jo_model *m, jo_data *d, struct jo_contact_matrix *c);
void jo_tree_contacts(const jo_model *m, jo_data *d, const jo_stage *stage);   /* accelerations with the matrix of the method */

/* tree_layout.c */
void jo_tree_layout(const jo_model *m, jo_data *d, jo_arena *a);

/* tree.c */
int jo_tree_articulated_inertias(const jo_model *m, jo_data *d, const jo_stage *stage);   /* forward pass 1, forces, backward pass */
void jo_tree_forward_pass_2(const jo_model *m, jo_data *d);   /* accelerations of joints and links */
jo_real jo_tree_drive_forces(const jo_model *m, jo_data *d);   /* forces of drives; returns their power, W */
int jo_tree_evaluate(const jo_model *m, jo_data *d, const jo_stage *stage);

/* tree_on_flexible_bodies.c */
void jo_hybrid_update_bodies(const jo_model *m, jo_data *d);   /* bodies in maximal coordinates and their markers from x and u */
void jo_hybrid_accept_state(const jo_model *m, jo_data *d);   /* x and u of these bodies from q and v */
int jo_hybrid_condense(const jo_model *m, jo_data *d, const jo_stage *stage);   /* forces, and inertia of the carried trees */
void jo_hybrid_forward_pass_2(const jo_model *m, jo_data *d);   /* accelerations of the carried trees */

/* tree_loop_projection.c */
int jo_tree_close_loops(const jo_model *m, jo_data *d);   /* returns whether the loops are closed afterwards */

/* tree_conversion.c */
int jo_tree_from_maximal(const jo_model *m, jo_data *d);   /* convert q, v to joint coordinates */
void jo_tree_to_maximal(const jo_model *m, jo_data *d);    /* convert back */
void jo_tree_count_turns(const jo_model *m, jo_data *d);
void jo_tree_prescribe_end_of_step(const jo_model *m, jo_data *d);   /* drives at the end of a step, and their increments dq */

#endif
