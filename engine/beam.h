/* beam.h - small operators that the beam element's forces and tangents share.
 *
 * With Rodrigues' parameters tau = tan(phi/4) n of the relative rotation phi n of the ends, seen in the middle frame:
 *   d tau = (1 + tau^2)/4 dbeta,  d(phi n) = H dbeta,  H = E - mu tau~ tau~,  dbeta = beta_b - beta_a (spins, middle frame)
 */
#ifndef JO_BEAM_H
#define JO_BEAM_H

#include "internal.h"

/* y = H x */
static inline void jo_beam_h(jo_real *y, const jo_beam_work *w, const jo_real *x)
{
    jo_real t[3];
    jo_cross(t, w->tau, x);
    jo_cross(t, w->tau, t);
    y[0] = x[0] - w->mu * t[0]; y[1] = x[1] - w->mu * t[1]; y[2] = x[2] - w->mu * t[2];
}

/* whether it has inertia of its own, and damping of that */
static inline int jo_beam_inertial(const jo_beam *b)
{
    return JO_COMMON(b->data->share) != 0.0;
}

#endif
