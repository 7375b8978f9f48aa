/* beam.h - geometrically exact beam elements: forces, energy, sections, tangents; functions for other rooms. */
#ifndef JO_BEAM_H
#define JO_BEAM_H

#include "arena.h"
#include "data.h"

/* whether the element has consistent mass or damping of this mass */
static inline int jo_beam_inertial(const jo_beam *b)
{
    return JO_COMMON(b->data->share) != 0.0;
}

/* beam_fibre.c */
void jo_beam_fibre(jo_beam_group *w);
void jo_beam_fibre_rate(jo_beam_group *w);
void jo_beam_fibre_force(jo_beam_group *w);
void jo_beam_fibre_tangent(const jo_beam_group *w, jo_lanes *C, jo_lanes *X);

/* beam_helix.c */
void jo_beam_helix(jo_beam_group *w);
void jo_beam_helix_rate(jo_beam_group *w);
void jo_beam_helix_force(jo_beam_group *w);
void jo_beam_helix_tangent(const jo_beam_group *w, const jo_lanes *C, jo_lanes *effective, jo_lanes *X);

/* beam_group.c */
int jo_beam_kind(const jo_beam_data *x);
void jo_beam_layout(const jo_model *m, jo_data *d, jo_arena *a);
void jo_beam_setup(const jo_model *m, jo_data *d);

/* beam_strain.c */
void jo_beam_strain(const jo_data *d, jo_beam_group *w);
int jo_beam_sound(const jo_beam_group *w, int lane);
int jo_beam_resultants(const jo_data *d, jo_beam_group *w);   /* first lane without valid strains, or -1 */

/* beam_stiffness.c */
void jo_beam_stiffness(const jo_beam_group *w, jo_lanes *K, jo_lanes *V);   /* JO_BEAM_KEPT each; V only of damped elements */

/* beam_inertia.c */
void jo_beam_inertia(const jo_model *m, jo_data *d, int i, const jo_real *a);
jo_real jo_beam_kinetic(const jo_model *m, const jo_data *d);
void jo_beam_newton_inertia(const jo_model *m, jo_data *d, int i, const jo_weights *c);

/* beam.c */
static inline double *jo_beam_bent(jo_data *d) { return d->beams.bent; }   /* (nbeam x 2), see jo_data_bent */
/* with inertial forces at accelerations a, where NULL stands for a = 0 */
int jo_beam_forces(const jo_model *m, jo_data *d, const jo_real *a);
double jo_beam_force_norm(const jo_data *d);
jo_real jo_beam_stored(const jo_data *d);
void jo_beam_section(const jo_data *d, int i, jo_real *y);
void jo_beam_accept(jo_data *d);
void jo_beam_reset_history(jo_data *d);

/* beam_tangent.c */
void jo_newton_beams(const jo_model *m, jo_data *d, const jo_stage *stage);
void jo_beam_lag(const jo_data *d, const jo_real *x, const jo_real *z, jo_real *lag);   /* (nv) lag += K x + D z, z may be 0 */

#endif
