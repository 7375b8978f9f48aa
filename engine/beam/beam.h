/* beam.h - geometrically exact beam elements: forces, energy, sections, tangents; functions for other rooms. */
#ifndef JO_BEAM_H
#define JO_BEAM_H

#include "arena.h"
#include "data.h"

/* Operator H of the forces and tangents of the element. With Rodrigues' parameters tau = tan(phi/4) n of the rotation phi n between the
 * ends and the spins beta_a, beta_b of the ends, all in the middle frame:
 *   d tau = (1 + tau^2)/4 dbeta,  d(phi n) = H dbeta,  H = E - mu tau~ tau~,  dbeta = beta_b - beta_a */
/* y = H x */
static inline void jo_beam_h(jo_real *y, const jo_beam_work *w, const jo_real *x)
{
    jo_real t[3];
    jo_cross(t, w->tau, x);
    jo_cross(t, w->tau, t);
    y[0] = x[0] - w->mu * t[0]; y[1] = x[1] - w->mu * t[1]; y[2] = x[2] - w->mu * t[2];
}

/* whether the element has consistent mass or damping of this mass */
static inline int jo_beam_inertial(const jo_beam *b)
{
    return JO_COMMON(b->data->share) != 0.0;
}

/* beam_fibre.c */
void jo_beam_fibre(const jo_model *m, const jo_data *d, int i);
void jo_beam_fibre_rate(const jo_data *d, int i);
void jo_beam_fibre_force(const jo_data *d, int i);
void jo_beam_fibre_tangent(const jo_model *m, const jo_data *d, int i, jo_real *C, jo_real *X);

/* beam_helix.c */
void jo_beam_helix(const jo_model *m, const jo_data *d, int i);
void jo_beam_helix_rate(const jo_model *m, const jo_data *d, int i);
void jo_beam_helix_force(const jo_model *m, const jo_data *d, int i);
void jo_beam_helix_tangent(const jo_model *m, const jo_data *d, int i, const jo_real *C, jo_real *effective, jo_real *X);

/* beam_inertia.c */
void jo_beam_inertia(const jo_model *m, jo_data *d, int i, const jo_real *a);
jo_real jo_beam_kinetic(const jo_model *m, const jo_data *d);
void jo_beam_newton_inertia(const jo_model *m, jo_data *d, int i, const jo_weights *c);

/* beam.c */
void jo_beam_layout(const jo_model *m, jo_data *d, jo_arena *a);
static inline double *jo_beam_bent(jo_data *d) { return d->beams.bent; }   /* (nbeam x 2), see jo_data_bent */
void jo_beam_setup(const jo_model *m, jo_data *d);
/* with inertial forces at accelerations a, where NULL stands for a = 0 */
int jo_beam_forces(const jo_model *m, jo_data *d, const jo_real *a);
double jo_beam_force_norm(const jo_model *m, const jo_data *d, int i);
jo_real jo_beam_stored(const jo_model *m, const jo_data *d);
void jo_beam_section(const jo_model *m, const jo_data *d, int i, jo_real *y);
void jo_beam_accept(const jo_model *m, jo_data *d);
void jo_beam_reset_history(jo_data *d);

/* beam_tangent.c */
void jo_newton_beams(const jo_model *m, jo_data *d, const jo_stage *stage);
void jo_beam_lag(const jo_model *m, const jo_data *d, const jo_real *x, const jo_real *z, jo_real *lag);   /* (nv) lag += K x + D z, z may be 0 */

#endif
