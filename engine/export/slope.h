/* slope.h - directional derivatives of outputs and rates of a machine; doubles only, for both builds of the sources. */
#ifndef JO_SLOPE_H
#define JO_SLOPE_H

enum { JO_SLOPE_TIME, JO_SLOPE_INPUT, JO_SLOPE_OUTPUT, JO_SLOPE_PARAMETER, JO_SLOPE_STATE, JO_SLOPE_RATE };
typedef struct { int kind, index; } jo_slope_ref;

/* change[j]: derivative of `unknown` (outputs, rates) along the direction `seed` of `known` (time, inputs, parameters, states) at a state of
 * jo_machine_save; in_bodies: after jo_machine_in_bodies; rate: Baumgarte, 1/s. Returns 0, or not 0 without a finite value. */
int jo_slope(const double *state, int in_bodies, double rate, const jo_slope_ref *known, const double *seed, int nknown,
             const jo_slope_ref *unknown, double *change, int nunknown);

#endif
