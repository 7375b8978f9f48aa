/* force.h - what the file of each kind of force defines; the rows of the kinds stand in jousto.h. */
#ifndef JO_FORCE_H
#define JO_FORCE_H

#include "element.h"

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

/* state_rate.c */
int jo_condenses(const jo_stage *stage);   /* whether the states are solved for within the forces */
jo_real jo_condense_state(const jo_model *m, jo_data *d, const jo_stage *stage, int state, jo_real rate, jo_real decay);

/* relative.c: motion of b against a, resolved in a */
void jo_relative_pose(const jo_data *d, const jo_force *f, jo_real *r, jo_real *R);
void jo_relative_velocity(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *v, jo_real *w);
void jo_push_between(const jo_model *m, jo_data *d, const jo_force *f, const jo_real *y, jo_force_work *out);
void jo_newton_between(const jo_model *m, jo_data *d, const jo_force *f, const jo_real *y, jo_real (*X)[12]);

#endif
