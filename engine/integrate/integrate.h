/* integrate.h - integrators, step control, events, rows of results; functions for other rooms. */
#ifndef JO_INTEGRATE_H
#define JO_INTEGRATE_H

#include "arena.h"
#include "data.h"

/* result_row.c */
int jo_write_row(const jo_model *m, jo_data *d, jo_real *row);

/* step_generalized_alpha.c */
int jo_step_alpha(const jo_model *m, jo_data *d, const jo_solver *s);

/* step_dormand_prince.c */
int jo_step_dopri(const jo_model *m, jo_data *d, const jo_solver *s, double h, double seen);
double jo_increment_between(const jo_model *m, jo_real *x, const jo_real *q0, const jo_real *q);
void jo_restore_stage(jo_data *d, int last);   /* accelerations and power of the first or last stage */
void jo_interpolate(const jo_model *m, jo_data *d, double u);
double jo_error_estimate(const jo_data *d, int i, int n);
void jo_tree_error_estimate(const jo_model *m, jo_data *d, jo_real *increment, jo_real *velocity);   /* (nv) each */

/* step_explicit.c */
int jo_one_step(const jo_model *m, jo_data *d, const jo_solver *s);   /* one step of length s->step */

/* events.c */
int jo_event_step(const jo_model *m, jo_data *d, const jo_solver *s);   /* the same, with location of events */
void jo_event_setup(const jo_model *m, jo_data *d);
int jo_watched(const jo_model *m);
int jo_event_keep(const jo_model *m, jo_data *d);   /* saves the state for repetition of a step */
int jo_event_find(const jo_model *m, jo_data *d, const jo_solver *s, int first, double *length, int *found);   /* first crossing in the step */
int jo_event_happen(const jo_model *m, jo_data *d, int *chain);
int jo_log_room(const jo_model *m);
int jo_log_has_room(const jo_model *m, const jo_data *d);

/* what happened in the last call, see jo_data_log */
static inline const double *jo_log_entries(const jo_data *d) { return d->events.log; }
static inline int jo_log_count(const jo_data *d) { return d->events.logged; }

/* integrate_layout.c */
void jo_integrate_layout_state(const jo_model *m, jo_data *d, jo_arena *a);   /* the part of it that is state */
void jo_integrate_layout(const jo_model *m, jo_data *d, jo_arena *a);

#endif
