/* maximal.h - maximal coordinates: bodies, markers, coordinates, constraints, Schur complement; functions for other rooms. */
#ifndef JO_MAXIMAL_H
#define JO_MAXIMAL_H

#include "arena.h"
#include "data.h"

/* smallest ratio of a pivot of an inertia and its value before elimination; 45 units of round-off of a double */
#define JO_MIN_PIVOT 1e-14

/* ratio of a pivot of S = J M^-1 J^T and its value before elimination, below which the row depends on others */
#define JO_SINGULAR_PIVOT 1e-12

/* rows of a joint in memory: columns of its blocks are padded with 0 */
static inline int jo_padded(int rows) { return rows <= 4 ? 4 : 8; }

/* number of velocities of the body of a marker; 0: ground */
static inline int jo_marker_velocities(const jo_model *m, int marker)
{
    const int body = m->marker[marker].body;
    return body < 0 ? 0 : 6 + m->body[body].n;
}

/* whether a body carries trees of hybrid mode; whether y and yp contain a change of the forces */
static inline int jo_carries(const jo_body_work *b) { return b->maximal.carried != 0; }
static inline int jo_force_changed(const jo_body_work *b) { return b->maximal.changed; }

/* forces on a body = 0 */
static inline void jo_clear_forces(const jo_body *b, jo_body_work *w)
{
    for (int j = 0; j < 6; j++) w->fr[j] = jo_same(0.0);
    for (int j = 0; j < b->np; j++) w->fp[j] = jo_same(0.0);
}

/* the constants of set 1 become invalid; the next jo_use_step computes them */
static inline void jo_forget_step(jo_data *d) { d->schur.gh = -1.0; }

/* maximal_layout.c */
void jo_maximal_layout(const jo_model *m, jo_data *d, jo_arena *a);

/* body.c */
void jo_body_setup(const jo_body *b, jo_body_work *w, int set, double gh);
void jo_body_pose(const jo_body *b, jo_body_work *w, const jo_real *q);
void jo_body_twist(const jo_body *b, jo_body_work *w, const jo_real *v);
void jo_body_inertia(const jo_body *b, jo_body_work *w, jo_real *power);
int jo_body_factor(const jo_body *b, jo_body_work *w, int set);
int jo_body_factor_carried(const jo_body *b, jo_body_work *w);   /* of a body that carries trees; requires jo_body_carry */
void jo_body_carry(jo_body_work *w, jo_real (*M)[3], jo_real (*H)[3], jo_real (*J)[3]);   /* inertia of the trees on the body */
void jo_body_free(const jo_body *b, jo_body_work *w, int set);
void jo_body_reduce(const jo_body *b, const jo_body_work *w, int set, const jo_real *fr, const jo_real *fp, jo_real *z);
void jo_body_forward(const jo_real *L, jo_real *x);
void jo_body_backward(const jo_real *L, jo_real *x);
void jo_body_modal(const jo_body *b, jo_body_work *w, int set);

/* marker.c */
void jo_marker_setup(const jo_model *m, jo_data *d, int set);
void jo_marker_position(const jo_model *m, jo_data *d, int count);
void jo_marker_velocity(const jo_model *m, jo_data *d, int count);
void jo_marker_bias(const jo_model *m, jo_data *d, int count);
void jo_marker_reduce(const jo_model *m, jo_data *d, int set, int count);

/* Motion of a marker, world frame. */
typedef struct {
    jo_real r[3], v[3], a[3];      /* position, velocity, acceleration */
    jo_real om[3], al[3];          /* angular velocity and acceleration */
} jo_motion;
/* requires jo_marker_bias; `accelerations` 0: without accelerations */
void jo_marker_motion(const jo_model *m, const jo_data *d, int marker, int accelerations, jo_motion *y);
void jo_marker_acceleration(const jo_model *m, const jo_data *d, int marker, jo_real *y);

/* arc_tangent.c */
jo_real jo_arc_tangent(jo_real y, jo_real x);   /* atan2 */

/* rolling_coordinate.c */
void jo_rolling_value(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, jo_coordinate_work *w);
void jo_rolling_change(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, const jo_real *dr, const jo_real *pa,
                       const jo_real *pb, jo_real *along, jo_real *turn_a, jo_real *turn_b);

/* rail_coordinate.c */
void jo_rail_value(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, jo_coordinate_work *w);
void jo_rail_change(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, const jo_real *dr, const jo_real *pa, const jo_real *pb,
                    jo_real *along, jo_real *turn_a, jo_real *turn_b);

/* rope_coordinate.c */
void jo_rope_value(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, jo_coordinate_work *w);
void jo_rope_change(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, const jo_real *dr, const jo_real *pa, const jo_real *pb,
                    jo_real *along, jo_real *turn_a, jo_real *turn_b);

/* coordinate.c */
void jo_coordinate_value(const jo_model *m, jo_data *d, int coordinate);   /* computes value, gradient */
void jo_coordinate_rate(const jo_model *m, jo_data *d, int coordinate);    /* rate, bias */
void jo_coordinates(const jo_model *m, jo_data *d, int count);     /* value, gradient of the first `count` */
void jo_coordinates_rate(const jo_model *m, jo_data *d, int count);   /* rate, bias */
jo_real jo_coordinate_acceleration(const jo_model *m, const jo_data *d, int coordinate);
void jo_count_turns(const jo_model *m, jo_data *d);                /* counted angles at the present state */
/* change of the gradient of a coordinate of a disc, a rail wheel or a rope with changes of r_b - r_a and rotations of a and b */
void jo_gradient_change(const jo_coordinate *c, const jo_marker_work *a, const jo_marker_work *b, const jo_real *dr, const jo_real *pa,
                        const jo_real *pb, jo_real *along, jo_real *turn_a, jo_real *turn_b);

/* constraints.c */
jo_real jo_largest_residual(const jo_model *m, jo_data *d);         /* c of all joints; returns the largest one, m (jo_row_metres) */
jo_real jo_largest_residual_rate(const jo_model *m, jo_data *d);    /* cdot of all joints; returns the largest one, m/s */
jo_real jo_constraint_residual(const jo_model *m, jo_data *d, int joint);        /* c of one joint; returns the largest one, m */
jo_real jo_constraint_residual_rate(const jo_model *m, jo_data *d, int joint);   /* cdot likewise, m/s */
void jo_joint_rows(const jo_model *m, jo_data *d);
/* (nrow x 3) derivatives f, g of the row rates with respect to velocity and angular velocity (world) of a side; side 0 first */
void jo_constraint_jacobian(const jo_model *m, jo_data *d, int joint, int side, jo_real (*f)[3], jo_real (*g)[3]);
/* x: second derivatives of the rows for the given angular velocities and accelerations of the sides */
void jo_constraint_acceleration(const jo_model *m, const jo_data *d, int joint, const jo_motion *side, double lead, jo_real *x);
void jo_joint_acceleration(const jo_model *m, jo_data *d, const jo_stage *stage);
jo_real jo_joint_power(const jo_model *m, const jo_data *d);     /* power of all drives, W */
jo_real jo_joint_drive(const jo_model *m, const jo_data *d, int joint, const jo_real *lam);   /* power of the drives of one joint, W */
void jo_joint_force_change(const jo_model *m, jo_data *d, int set);   /* right-hand sides x for the changes of jo_push_change */
void jo_joint_apply(const jo_model *m, jo_data *d, int set);

/* apply_force.c */
void jo_push(const jo_model *m, jo_data *d, int marker, const jo_real *F, const jo_real *T);
void jo_push_along(const jo_model *m, jo_data *d, int coordinate, jo_real f);
void jo_clear_changes(const jo_model *m, jo_data *d);
void jo_push_change(const jo_model *m, jo_data *d, int coordinate, jo_real f);   /* change of force, into y and yp of the bodies */
void jo_push_body_change(const jo_model *m, jo_data *d, int body, const jo_real *Q);   /* the same by Q along the velocities of a body */
void jo_body_change(const jo_model *m, const jo_data *d, int body, jo_real *Q);       /* Q = the change along the velocities of a body */
void jo_push_late(const jo_model *m, jo_data *d, int coordinate, jo_real f);     /* jo_push_along after jo_body_free, before jo_free_changed */
void jo_free_changed(const jo_model *m, jo_data *d, int set);
void jo_push_modes(const jo_model *m, jo_data *d, const jo_stage *stage);   /* implicit part of modal forces, until jo_clear_modes */
void jo_clear_modes(const jo_model *m, jo_data *d);

/* state.c */
void jo_select_coordinates(const jo_model *m, jo_data *d, int tree);   /* integrate x, u or q, v */
void jo_integrate_positions(const jo_model *m, jo_data *d, const jo_real *increment);   /* positions = q0 o increment */
void jo_position_rate(const jo_model *m, const jo_data *d, jo_real *rate, const jo_real *x);
void jo_update_positions(const jo_model *m, jo_data *d);
void jo_body_add_increment(const jo_body *b, jo_real *q, const jo_real *q0, const jo_real *increment);
void jo_add_increment(const jo_model *m, jo_real *q, const jo_real *q0, const jo_real *increment);
void jo_increment_rate(const jo_model *m, jo_real *rate, const jo_real *x, const jo_real *v);
jo_real jo_speed(const jo_model *m, const jo_data *d);   /* largest speed of the bodies, m/s; angular: times size of the mechanism */
int jo_check(const jo_model *m, jo_data *d);   /* JO_OK if the state is below JO_MAX_STATE */

/* hubs.c */
void jo_hub_plan(const jo_model *m, jo_data *d);      /* to be called after the plan of the pairs */
void jo_hub_assemble(const jo_model *m, jo_data *d);
void jo_hub_scales(const jo_model *m, jo_data *d);    /* adds V V^T of the hubs to the scales of the diagonal of S */

/* schur_complement.c */
void jo_joint_plan(const jo_model *m, jo_data *d);    /* once */
void jo_joint_setup(const jo_model *m, jo_data *d, int set);
int jo_joint_factor(const jo_model *m, jo_data *d, int set);
void jo_joint_solve(const jo_model *m, jo_data *d);

/* reactions.c */
void jo_reaction(const jo_model *m, const jo_data *d, int joint, jo_real *y);   /* force and moment on side 1, world */
void jo_reaction_of(const jo_model *m, const jo_data *d, int joint, const jo_real *lam, jo_real *y);   /* for given lam */
void jo_apply_reaction(const jo_model *m, jo_data *d, int joint);    /* -Cq^T lam of one joint */
void jo_apply_reactions(const jo_model *m, jo_data *d);   /* adds -Cq^T lam to the forces on the bodies */

/* energy.c */
void jo_add_step_work(jo_data *d);

/* responses.c */
void jo_apply_multipliers(const jo_model *m, jo_data *d, int set, const jo_real *fall, jo_real *a);
void jo_respond(const jo_model *m, jo_data *d, int set, jo_real *a);   /* changes of a and of joint[].x by those of jo_push_change */

/* forward_dynamics.c */
int jo_evaluate(const jo_model *m, jo_data *d, const jo_stage *stage);
void jo_sync_all(const jo_model *m, jo_data *d);    /* q, v, a and lam of the last evaluation */
void jo_use_step(const jo_model *m, jo_data *d, double gh);
/* position residual / size of the mechanism, and velocity residual / its speed, up to which joints are closed */
#define JO_CLOSED 1e-12
void jo_project(const jo_model *m, jo_data *d, const jo_stage *stage);   /* with the factors of the last evaluation */
int jo_ready_sensors(const jo_model *m, jo_data *d, int demanding);

/* load_sensor.c */
void jo_load_sensor(const jo_model *m, jo_data *d, const jo_sensor *s, jo_real *y);   /* of type BODY_LOAD or MODAL_LOAD */

/* sensors.c */
int jo_needs_accelerations(const jo_sensor *s);

#endif
