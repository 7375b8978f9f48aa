/* force.h - kinds of forces and signals: what other rooms may use. */
#ifndef JO_FORCE_H
#define JO_FORCE_H

#include "newton/newton.h"

/* what the file of each kind of force defines; the rows of the kinds stand in jousto.h. */
typedef struct {
    /* pushes on the bodies, fills y and adds to the power that is lost (d->power.damping) or done by forces (d->power.forces) */
    int (*apply)(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *y);
    jo_real (*stored)(const jo_data *d, const jo_force *f);   /* energy, J; 0: none */
    /* adds how the force that stands in y changes to Newton's matrix, and y to the loads of its markers */
    int (*tangent)(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *y);
    /* of kinds with states: these where a run begins, and the sizes of them whose errors matter in a run of so many seconds; 0: none */
    void (*start)(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x);
    void (*nominals)(const jo_model *m, const jo_force *f, double duration, double *x);
} jo_force_kind;

#define JO_FORCE_DECLARED(name, ...) extern const jo_force_kind jo_force_##name;
JO_FORCES(JO_FORCE_DECLARED)

/* force_states.c */
int jo_condenses(const jo_stage *stage);   /* whether the states are solved for within the forces */
jo_real jo_condense_state(const jo_model *m, jo_data *d, const jo_stage *stage, int state, jo_real rate, jo_real decay);

/* signal.c */
jo_signal_work jo_signal_at(const jo_model *m, const jo_data *d, int signal, jo_real time);

/* force_table.c */
int jo_apply_forces(const jo_model *m, jo_data *d, const jo_stage *stage);
int jo_newton_forces(const jo_model *m, jo_data *d, const jo_stage *stage);
jo_real jo_stored(const jo_model *m, const jo_data *d);   /* in springs, where markers and coordinates stand */
void jo_state_nominals(const jo_model *m, jo_data *d, double duration);

#endif
