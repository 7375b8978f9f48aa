/* tyre_law.h - force of a tyre in the contact patch from its slip: brush with parabolic pressure, and magic formula. */
#ifndef JO_TYRE_LAW_H
#define JO_TYRE_LAW_H

#include "dual.h"
#include "force/force.h"

enum { JO_TYRE_BRUSH = 0, JO_TYRE_MAGIC = 1 };

/* Fx, Fy, N, along and across the wheel, and the moment Mz about the normal, N m */
typedef struct { jo_dual x, y, z; } jo_tyre_force;

/* slip: practical for the magic formula (longitudinal kappa, lateral tan alpha), theoretical for the brush; load Fz, N; camber angle, rad */
jo_tyre_force jo_tyre_law(const jo_tyre_data *x, jo_dual along, jo_dual across, jo_dual load, jo_dual camber);
/* slip from which on a tyre that stands slides as a whole, so that its deflection grows no further */
jo_real jo_tyre_full_slip(const jo_tyre_data *x);

#endif
