/* force.h - kinds of forces, their table, and signals; functions for other rooms. */
#ifndef JO_FORCE_H
#define JO_FORCE_H

#include "newton/newton.h"

/* value of a signal and its derivatives with respect to time */
typedef struct { jo_real value, rate, second; } jo_signal_work;

/* A state x' = f of a force F along a coordinate s, as a Rosenbrock method has it in its matrix: dF/dx, -df/dx, df/ds, df/ds'. */
typedef struct jo_slopes_of_state { jo_real force, decay, value, rate; } jo_slopes_of_state;
static inline const jo_slopes_of_state *jo_force_slopes(const jo_data *d, int state) { return d->forces.slopes + state; }

/* How a gap may close within a step of length `within`, s, or a shorter one, at its start or, `at_end`, its end; these are given: gap, m, its rate and the highest one if points of a
 * body that turns have several, m/s, velocity of the point whose distance it is, m/s, the largest curvature of the surfaces of constant
 * distance, 1/m, and the face over which the point is: on the way from one face to another the distance is not smooth.
 * spin: angular velocity times the distance of the farthest point, m/s. convex: whether the distance is a convex function of the place.
 * seen: first state of the force, for jo_see_speed. clear: gap of everything beside this face, m. What a kind does not set is the rate, 0 or
 * INFINITY. */
typedef struct jo_approach { double within, gap, rate, highest, v[3], spin[3], curvature, clear; int at_end, face, convex, seen; } jo_approach;
static inline double jo_approach_speed(const jo_approach *y) { return sqrt(y->v[0] * y->v[0] + y->v[1] * y->v[1] + y->v[2] * y->v[2]); }

enum { JO_MAX_TOUCHES = 8 };    /* points of a force */
enum { JO_TOUCH_SUMS = 3 };     /* sums over points: energies of normal forces and of bristles, J; normal forces, N */

/* forces that a method treats as an explicit one: none; all; those that are never in the matrix of ROS2 */
enum { JO_EXPLICIT_NONE = 0, JO_EXPLICIT_ALL = 1, JO_EXPLICIT_OUTSIDE = 2 };

/* smallest and largest components of the velocity of an open gap in the stages of a step, see jo_see_speed */
static inline double *jo_seen_speeds(const jo_data *d, int first) { return d->forces.seen + first; }

struct jo_strike;

/* Kinds whose force depends on the motion before: their states are constant within a step and change at its end. */
typedef struct {
    /* states at the present coordinates; returns the energy dissipated in the step, J */
    jo_real (*update)(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x);
    /* < 0: its branch has changed within the step */
    jo_real (*margin)(const jo_model *m, const jo_data *d, const jo_force *f);
    int (*jumps)(const jo_force *f, const jo_real *before, const jo_real *after);   /* whether the force jumps with a change of its states; NULL: never */
    /* step that resolves its motion, s, and with which an explicit method is stable; NULL: any */
    double (*longest_step)(const jo_model *m, const jo_data *d, const jo_force *f, int explicit_method);
    /* states from which the step of an implicit method converges, after one that did not; whether they are others; NULL: never */
    int (*ease)(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x);
    /* 0 if there is no gap; NULL: never one */
    int (*approach)(const jo_model *m, const jo_data *d, const jo_force *f, jo_approach *y);
    /* points that strike with an impulse, or are closed; their number, up to `room`, see contact/impulses.h; NULL: never any */
    int (*strikes)(const jo_model *m, const jo_data *d, const jo_force *f, struct jo_strike *list, int room);
    /* its points with the states x, at most JO_MAX_TOUCHES, and sums (JO_TOUCH_SUMS), to which it adds; returns their number; NULL: none */
    int (*touches)(const jo_model *m, const jo_data *d, const jo_force *f, const jo_real *x, jo_touch *y, jo_real *sums);
    /* a second update, when the states of all forces have changed: to what they jump at the end of the step; NULL: none */
    jo_real (*follow)(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x);
} jo_yielding;

/* functions that the file of each kind of force defines; the rows of the kinds are in jousto.h. */
typedef struct {
    /* forces on the bodies, result in y; adds dissipated power to d->power.damping and power of forces to d->power.forces, W */
    int (*apply)(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *y);
    jo_real (*stored)(const jo_data *d, const jo_force *f);   /* stored energy, J; NULL: none */
    /* adds the derivatives of the force y to Newton's matrix, and y to the loads of its markers */
    int (*tangent)(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *y);
    /* kinds with states: initial values, and nominal values for error control in a run of `duration` seconds; NULL: no states */
    void (*start)(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x);
    void (*nominals)(const jo_model *m, const jo_force *f, double duration, double *x);
    const jo_yielding *yielding;   /* NULL: the force does not depend on the motion before */
} jo_force_kind;

#define JO_FORCE_DECLARED(name, ...) extern const jo_force_kind jo_force_##name;
JO_FORCES(JO_FORCE_DECLARED)

/* number of the k-th force that yields */
static inline int jo_yielding_force(const jo_data *d, int k) { return d->forces.yielding[k]; }

/* force_contact_slot.c: states of a slot that has got a pair */
void jo_start_slot(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state);

/* force_rail.c: values of a patch of a wheel on its rail: N, forces along and across on the wheel, moment about the normal, three creepages,
 * largest pressure, half axes, rolling radius, place across the rail */
enum { JO_RAIL_REPORT = 12 };
void jo_rail_report(const jo_model *m, const jo_data *d, const jo_force *f, int patch, jo_real *y);

/* force_states.c */
int jo_condenses(const jo_stage *stage);   /* whether an implicit stage solves for the states within the forces */
jo_real jo_condense_state(const jo_model *m, jo_data *d, const jo_stage *stage, int state, jo_real rate, jo_real decay);
void jo_keep_states(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f);   /* constant in the step */

/* delay_ring.c */
jo_signal_work jo_delayed(const jo_model *m, const jo_data *d, int force, jo_real time);   /* value of a signal of the kind DELAY */

/* force_delay.c */
int jo_delay_count(const jo_data *d);
void jo_delay_keep(const jo_model *m, jo_data *d, int k);   /* what the end of a step would add to the k-th delay, for jo_delay_error */
double jo_delay_error(const jo_model *m, const jo_data *d, int k);   /* of the interpolation within this step, at the present state; relative */

/* signal.c */
jo_signal_work jo_signal_at(const jo_model *m, const jo_data *d, int signal, jo_real time);

/* force_contact.c */
int jo_contact_touches(const jo_data *d, const jo_force *f);   /* whether a contact of one point touches */
jo_real jo_contact_normal_force(const jo_model *m, const jo_data *d, const jo_force *f);   /* at the present state, N */

/* force_table.c */
void jo_start_force(const jo_model *m, jo_data *d, int force);   /* initial values of its states */
int jo_apply_force(const jo_model *m, jo_data *d, const jo_stage *stage, int force);
int jo_apply_forces(const jo_model *m, jo_data *d, const jo_stage *stage);
int jo_newton_forces(const jo_model *m, jo_data *d, const jo_stage *stage);
jo_real jo_stored(const jo_model *m, const jo_data *d);   /* energy of springs at the present coordinates */
/* points of a force with the states x, after jo_yielding_ready; 0 after its release */
int jo_touches_of(const jo_model *m, const jo_data *d, int force, const jo_real *x, jo_touch *y, jo_real *sums);
jo_real jo_stored_in_contacts(const jo_model *m, const jo_data *d);
void jo_state_nominals(const jo_model *m, double duration, double *x);   /* (nstate) nominal values for error control */
const jo_yielding *jo_yielding_of(const jo_force *f);   /* NULL: it does not yield */
void jo_force_layout(const jo_model *m, jo_data *d, jo_arena *a);

/* yielding.c */
/* states at the end of a step, after jo_yielding_ready; records: whether the step is accepted, so that contacts are recorded; whether forces
 * jump */
int jo_accept_yielding(const jo_model *m, jo_data *d, int records);
int jo_follow_jumps(const jo_model *m, jo_data *d);   /* second updates; whether forces jump */
void jo_force_state(const jo_model *m, const jo_data *d, int force, int state, jo_real *y);   /* one state at present */
jo_real jo_yielding_margin(const jo_model *m, const jo_data *d, int k);   /* of force d->forces.yielding[k] */
int jo_yielding_ready(const jo_model *m, jo_data *d);   /* coordinates of the forces that yield, at the present state */
int jo_yielding_approach(const jo_model *m, const jo_data *d, int k, jo_approach *y);   /* of force d->forces.yielding[k] */
int jo_ease_yielding(const jo_model *m, jo_data *d);   /* at the start of a step that did not converge; whether any state has changed */
double jo_yielding_longest_step(const jo_model *m, const jo_data *d, int explicit_method);   /* of all of them, s; INFINITY: any */
jo_real jo_yielding_loss(const jo_model *m, const jo_data *d);   /* dissipated since the start of the step, but for contacts, J */
jo_real jo_bristles_at_end(const jo_model *m, const jo_data *d);   /* energy that bristles will store if the step ends here, J */
void jo_force_setup(const jo_model *m, jo_data *d);

#endif
