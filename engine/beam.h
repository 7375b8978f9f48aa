/* beam.h - small operators that the beam element's forces and tangents share.
 *
 * With Rodrigues' parameters tau = tan(phi/4) n of the relative rotation phi n of the ends, seen in the middle frame:
 *   d tau = (1 + tau^2)/4 dbeta,  d(phi n) = H dbeta,  H = E - mu tau~ tau~,  dbeta = beta_b - beta_a (spins, middle frame)
 */
#ifndef JO_BEAM_H
#define JO_BEAM_H

#include "internal.h"

/* where the data of an element lie */
#define JO_BEAM_AT(field) ((int)(offsetof(jo_beam_data, field) / sizeof(jo_real)))
enum {
    JO_BEAM_LENGTH = JO_BEAM_AT(length), JO_BEAM_UA = JO_BEAM_AT(u_a), JO_BEAM_BA = JO_BEAM_AT(B_a),
    JO_BEAM_UB = JO_BEAM_AT(u_b), JO_BEAM_BB = JO_BEAM_AT(B_b), JO_BEAM_C = JO_BEAM_AT(C),
    JO_BEAM_E0 = JO_BEAM_AT(e0), JO_BEAM_BETA = JO_BEAM_AT(beta), JO_BEAM_ALPHA = JO_BEAM_AT(alpha),
    JO_BEAM_SHARE = JO_BEAM_AT(share), JO_BEAM_MASS = JO_BEAM_AT(mass), JO_BEAM_J = JO_BEAM_AT(J),
    JO_BEAM_LIMIT = JO_BEAM_AT(limit), JO_BEAM_HELICAL = JO_BEAM_AT(helical),
    JO_BEAM_POLAR = JO_BEAM_AT(polar)
};

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
    return b->data[JO_BEAM_SHARE] != 0.0;
}

#endif
