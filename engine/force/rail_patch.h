/* rail_patch.h - one place where a wheel may touch its rail: geometry, Hertz's load, creep forces. */
#ifndef JO_RAIL_PATCH_H
#define JO_RAIL_PATCH_H

#include "dual.h"
#include "force/wheel_motion.h"

/* Numbers of a patch, after those of the force. */
typedef struct {
    jo_real y, z, head;         /* centre of the arc of the rail in the frame of a, and its radius, m */
    jo_real place, radius;      /* a point of the section of the wheel: along the axle, and its radius, m */
    jo_real slope, curvature;   /* dr/dy of the section there; its curvature, 1/m, > 0: convex, 0: a cone */
    jo_real stiffness;          /* K of N = K d^1.5, N/m^1.5 */
    jo_real creep[4];           /* G a b C11, G a b C22 per depth, G (a b)^1.5 C23 per depth^1.5, G (a b)^2 C33 per depth^2 */
    jo_real hertz[3];           /* largest pressure, Pa, and half axes along and across, m, under 1 N */
} jo_rail_patch;

/* A patch in motion. */
typedef struct {
    jo_real along;              /* place of the contact along the rail, from the wheel: start of the next search */
    int touches;                /* whether it carries a load */
    jo_dual depth, rate, elastic, load;   /* d, d', K d^1.5, N */
    jo_dual3 down, across, at;  /* normal to the rail; across = x x down; point of contact from the origin of b */
    jo_dual slide[2], spin, speed;   /* velocities of the wheel on the rail along and across, about -down; rolling speed */
    jo_dual creep[3];           /* slide and spin over the rolling speed */
    jo_dual force[2], moment;   /* creep forces along and across on the wheel, moment about -down */
} jo_rail_touch;

/* the patch p at a motion; along: start of the search */
jo_rail_touch jo_rail_touch_of(const jo_rail_data *x, const jo_rail_patch *p, const jo_wheel_motion *m, jo_real along);

#endif
