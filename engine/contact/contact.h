/* contact.h - signed distance of shapes. */
#ifndef JO_CONTACT_H
#define JO_CONTACT_H

#include "small.h"

/* Shapes in the frame of their marker, with their sizes, m. Axes of revolution: z. */
typedef enum {
    JO_SHAPE_HALF_SPACE = 0,    /* below z = 0 */
    JO_SHAPE_SPHERE = 1,        /* radius; 0: a point */
    JO_SHAPE_HOLLOW_SPHERE = 2, /* outside of the radius */
    JO_SHAPE_CAPSULE = 3,       /* radius, half the distance of its centres */
    JO_SHAPE_BOX = 4,           /* half the lengths along x, y, z */
    JO_SHAPE_CYLINDER = 5,      /* radius, half the length */
    JO_SHAPE_BORE = 6,          /* radius of an endless hole */
    JO_SHAPE_TORUS = 7          /* radius of the circle of centres, radius of the tube */
} jo_shape_type;

/* Signed distance of a point outside of a shape (inside: negative), m; its gradient, the outward normal; its second derivatives, 1/m. */
typedef struct { jo_real gap, normal[3], hessian[9]; } jo_distance;

void jo_shape_distance(int shape, const jo_real *size, const jo_real *x, jo_distance *y);

#endif
