/* event_parts.h - watched values of events and their effects, for the files of this folder. */
#ifndef JO_EVENT_PARTS_H
#define JO_EVENT_PARTS_H

#include "integrate/integrate.h"

static inline int jo_sign(double x) { return (x > 0.0) - (x < 0.0); }

/* whether watched value i belongs to an event */
static inline int jo_is_event(const jo_model *m, int i) { return i < m->nevent; }

/* first watched value of the forces that yield: the values of events precede it and, if any friction can stick, those of frictions */
static inline int jo_first_yielding(const jo_model *m) { return m->nevent + (m->nlock ? m->nfriction : 0); }

/* first watched value of the rows that are switched */
static inline int jo_first_switched(const jo_model *m) { return jo_first_yielding(m) + m->nyielding; }

/* event_values.c */
int jo_watched_values(const jo_model *m, jo_data *d, double *g);   /* g = watched values at the present state */
int jo_crosses(const jo_model *m, const jo_data *d, int i, double g);
int jo_any_crosses(const jo_model *m, const jo_data *d, const double *g);
int jo_accept_yielding_states(const jo_model *m, jo_data *d, double *g);
void jo_accept_values(const jo_model *m, jo_data *d, const double *g);
void jo_locate_no_yielding(const jo_model *m, jo_data *d);   /* in this step the laws of forces that yield hold across ends of branches */
int jo_events_start(const jo_model *m, jo_data *d);
void jo_set_first_sides(const jo_model *m, jo_data *d, const double *g);

/* event_effects.c */
int jo_log_entry(const jo_model *m, jo_data *d, int i, double value, int *chain);
int jo_events_happen(const jo_model *m, jo_data *d, int rounds, int *stop, int *chain);
int jo_all_happen(const jo_model *m, jo_data *d, int *stop, int *chain);

int jo_contacts_strike(const jo_model *m, jo_data *d, double late, int *chain);

/* event_step_ends.c */
int jo_step_to_end(const jo_model *m, jo_data *d, const jo_solver *s);   /* one step, with all events at its end */

#endif
