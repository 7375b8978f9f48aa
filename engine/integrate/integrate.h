/* integrate.h - integrators, step control, events, rows of results; functions for other rooms. */
#ifndef JO_INTEGRATE_H
#define JO_INTEGRATE_H

#include "arena.h"
#include "data.h"

/* coefficients of a tableau: explicit and implicit coefficients of stage i (j < i), weights, node of stage i */
static inline const double *jo_tableau_row(const jo_tableau *t, int i) { return t->coefficient + t->implicit + i * (i - 1) / 2; }
static inline const double *jo_tableau_implicit(const jo_tableau *t, int i)
{
    return jo_tableau_row(t, i) + t->stages * (t->stages - 1) / 2;
}
static inline const double *jo_tableau_weights(const jo_tableau *t)
{
    return jo_tableau_row(t, t->stages) + t->implicit * t->stages * (t->stages - 1) / 2;
}
static inline double jo_tableau_node(const jo_tableau *t, int i)
{
    double c = 0.0;
    for (int j = 0; j < i; j++) c += jo_tableau_row(t, i)[j];
    return c;
}

/* whether a method has closed contacts in its matrix */
static inline int jo_contacts_in_matrix(const jo_tableau *t) { return t->implicit && t->order == 2; }

/* stored rates of stage j: of the increments and of the velocities, (nw) each, padded to whole vectors */
static inline jo_real *jo_kept_rates(const jo_data *d, int j)
{
    return d->adaptive.stages + 2 * j * ((d->nw + JO_WIDTH - 1) / JO_WIDTH * JO_WIDTH);
}
static inline jo_real *jo_kept_accelerations(const jo_data *d, int j)
{
    return d->adaptive.stages + (2 * j + 1) * ((d->nw + JO_WIDTH - 1) / JO_WIDTH * JO_WIDTH);
}
static inline void jo_keep_rates(const jo_data *d, int j, const jo_real *rate)
{
    jo_real *const r = jo_kept_rates(d, j), *const x = jo_kept_accelerations(d, j);
    const jo_real *const wd = d->wd;
    const int n = d->nw;
    JO_EACH(i, n) {
        JO_STORE(r + i) = JO_LOAD(rate + i);
        JO_STORE(x + i) = JO_LOAD(wd + i);
    }
}

/* result_row.c */
int jo_write_row(const jo_model *m, jo_data *d, jo_real *row);

/* alpha_motion.c */
int jo_alpha_continues(const jo_model *m, const jo_data *d, double h);
void jo_alpha_update(const jo_model *m, jo_data *d, const jo_solver *s);
void jo_alpha_tangents(const jo_model *m, jo_data *d);
void jo_alpha_add(const jo_model *m, jo_data *d, const jo_weights *c, const jo_real *x, double share);
void jo_alpha_predict(const jo_model *m, jo_data *d, const jo_solver *s, double ahead);

/* iteration_limit.c */
void jo_iteration_limit_forget(jo_data *d);
double jo_iteration_ahead(const jo_model *m, const jo_data *d, const jo_solver *s);
double jo_iteration_limit(const jo_model *m, jo_data *d, const jo_solver *s);
void jo_iteration_limit_update(const jo_model *m, jo_data *d, const jo_solver *s);

/* step_generalized_alpha.c */
int jo_step_alpha(const jo_model *m, jo_data *d, const jo_solver *s);   /* one step of length s->step */

/* step_dormand_prince.c */
int jo_step_pair(const jo_model *m, jo_data *d, const jo_solver *s, double h, double seen);
int jo_step_dopri(const jo_model *m, jo_data *d, const jo_solver *s);   /* one step of length s->step */
double jo_increment_between(const jo_model *m, jo_real *x, const jo_real *q0, const jo_real *q);
void jo_restore_stage(jo_data *d, int last);   /* accelerations and power of the first or last stage */
void jo_interpolate(const jo_model *m, jo_data *d, double u);
double jo_error_estimate(const jo_data *d, int i, int n);
void jo_tree_error_estimate(const jo_model *m, jo_data *d, jo_real *increment, jo_real *velocity);   /* (nv) each */

/* step_closure.c */
int jo_close_step(const jo_model *m, jo_data *d, const jo_solver *s, const jo_stage *stage);

/* step_runge_kutta.c */
int jo_step_runge_kutta(const jo_model *m, jo_data *d, const jo_solver *s);

/* step_rosenbrock.c */
int jo_step_rosenbrock(const jo_model *m, jo_data *d, const jo_solver *s);

/* method_table.c */
int jo_takes_tree(const jo_model *m, const jo_solver *s);   /* whether the method runs in joint coordinates */
int jo_one_step(const jo_model *m, jo_data *d, const jo_solver *s);   /* one step of length s->step */

/* switched_rows.c */
void jo_switched_ready(const jo_model *m, jo_data *d);
jo_real jo_switched_margin(const jo_model *m, const jo_data *d, int k);
void jo_switched_step(jo_data *d, double length);   /* a step of this length begins */
void jo_switched_event(const jo_model *m, jo_data *d, int event);   /* what locks shall do from an event on */
int jo_switch_next(const jo_model *m, jo_data *d, int *which, double *impulse);

/* event_values.c */
void jo_event_setup(const jo_model *m, jo_data *d);
int jo_watched(const jo_model *m);
int jo_seek_contacts(const jo_model *m, jo_data *d, double *length);   /* pairs that may touch in a step of *length or less */

/* event_effects.c */
int jo_log_room(const jo_model *m);
int jo_log_has_room(const jo_model *m, const jo_data *d);

/* gap_proof.c */
void jo_measure_gaps(const jo_model *m, jo_data *d, int at_end, double h);   /* at the start or end of a step of length h at most; INFINITY for forces without a gap */
void jo_forget_speeds(const jo_model *m, jo_data *d);   /* of stages, before a step is repeated */
/* index in d->forces.yielding of a force whose open gap may have closed in a step of length h; nyielding: of a pair that was not searched; -1.
 * located: the step ends at the first crossing, so that gaps which are closed at its end must have been open until then */
int jo_doubtful_gap(const jo_model *m, const jo_data *d, int located, double h);
int jo_closed_at_end(const jo_model *m, const jo_data *d, int k);   /* whether the gap of this index is closed at the end of the step */
void jo_note_proof(jo_data *d, int halved, int found);   /* a part of a step is proven, after halvings of its length; whether it ends at an event */
void jo_note_doubt(const jo_model *m, jo_data *d, int k);   /* into the list of steps that are not proven */

/* events.c */
int jo_event_step(const jo_model *m, jo_data *d, const jo_solver *s);   /* the same, with events located in time or at its end */
/* longest step from here that resolves the forces that yield, s; INFINITY: any */
double jo_resolved(const jo_model *m, jo_data *d, int explicit_method);
int jo_event_keep(const jo_model *m, jo_data *d);   /* saves the state for repetition of a step */
int jo_event_find(const jo_model *m, jo_data *d, const jo_solver *s, int first, double *length, int *found);   /* first crossing in the step */
int jo_event_happen(const jo_model *m, jo_data *d, int *chain);

/* events of the last call, see jo_data_log */
static inline const double *jo_log_entries(const jo_data *d) { return d->events.log; }
static inline int jo_log_count(const jo_data *d) { return d->events.logged; }

/* integrate_layout.c */
void jo_integrate_layout_state(const jo_model *m, jo_data *d, jo_arena *a);   /* the arrays that belong to the state */
void jo_integrate_layout(const jo_model *m, jo_data *d, jo_arena *a);

#endif
