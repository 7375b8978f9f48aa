/* wheel_motion.h - motion of a wheel on the ground, and how it changes. */
#ifndef JO_WHEEL_MOTION_H
#define JO_WHEEL_MOTION_H

#include "dual.h"

/* of the wheel b, axle n, on a, resolved in a */
typedef struct { jo_dual3 r, n, v, w; } jo_wheel_motion;

/* the motion r, v, w of b on a, with the z axis of R as axle, changed by the k-th of [position, rotation, velocity, angular velocity]; k -1:
 * unchanged */
static inline jo_wheel_motion jo_wheel_motion_of(const jo_real *r, const jo_real *R, const jo_real *v, const jo_real *w, int k)
{
    static const jo_real still[3] = {0.0, 0.0, 0.0};
    jo_wheel_motion y;
    jo_real n[3], e[3] = {0.0, 0.0, 0.0}, turned[3];
    if (k >= 0) e[k % 3] = 1.0;
    jo_axis(n, R, 2);
    jo_cross(turned, e, n);
    y.r = jo_dual3_of(r, k / 3 == 0 && k >= 0 ? e : still);
    y.n = jo_dual3_of(n, k / 3 == 1 ? turned : still);
    y.v = jo_dual3_of(v, k / 3 == 2 ? e : still);
    y.w = jo_dual3_of(w, k / 3 == 3 ? e : still);
    return y;
}

#endif
