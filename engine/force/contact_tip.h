/* contact_tip.h - the sphere, circle of spheres, or ellipsoid of b that touches a shape of a. */
#ifndef JO_CONTACT_TIP_H
#define JO_CONTACT_TIP_H

#include "force/contact_point.h"

typedef struct {
    jo_real arm[3];                 /* centre of the sphere from the origin of b, resolved in a */
    /* of a ring: its axis z, first axis of b, direction u of its lowest point and of the one that touches, n . z, length before u is a unit */
    jo_real axis[3], first[3], down[3], out[3], along, sine;
    jo_real R[9], up[3], below;     /* of an ellipsoid: axes of b in a, n in these axes, its lowest point below its centre */
    jo_distance from;               /* distance of the centre from the shape */
} jo_contact_tip;

/* contact_tip.c */
void jo_contact_place(const jo_data *d, const jo_force *f, jo_contact_tip *tip, jo_contact_point *y);   /* at rest */
jo_contact_change jo_contact_tip_change(const jo_contact_data *x, const jo_contact_tip *tip, const jo_contact_point *y, int k);
void jo_contact_tip_velocity(const jo_contact_tip *tip, const jo_contact_point *y, jo_real *v);   /* of the centre of the sphere */
void jo_contact_tip_approach(const jo_contact_data *x, const jo_contact_tip *tip, const jo_contact_point *y, jo_approach *to);

#endif
