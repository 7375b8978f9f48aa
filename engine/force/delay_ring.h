/* delay_ring.h - points of a quantity in the last time, for the files of this room. x: states of a delay. */
#ifndef JO_DELAY_RING_H
#define JO_DELAY_RING_H

#include "force/force.h"

enum { JO_DELAY_COUNT = 0, JO_DELAY_JUMPS = 1, JO_DELAY_FIRST = 2, JO_DELAY_RING = 3 };   /* places among the states */

/* a point of the ring: time, u, u' */
typedef struct { jo_real t, u, s; } jo_delay_point;

/* delay_ring.c */
/* add a point at the end of a step, or change that of the same time; sloped: whether u' is known */
void jo_ring_add(const jo_force *f, jo_real *x, const jo_delay_point *p, int sloped);
int jo_ring_jumps(const jo_force *f, const jo_real *x);   /* whether the output jumps at the time of the last point */
/* error of the interpolation over the last step at a point p within it, relative to the largest value; states before and after the step */
double jo_ring_error(const jo_force *f, const jo_real *before, const jo_real *after, const jo_delay_point *p);
int jo_ring_full(const jo_force *f, const jo_real *x, double now);   /* whether a point that is still needed is lost */
double jo_ring_longest_step(const jo_force *f, const jo_real *x, double now);   /* up to the next jump of the output or a derivative, at most tau, s */

#endif
