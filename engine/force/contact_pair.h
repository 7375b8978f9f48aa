/* contact_pair.h - two shapes that touch at several points: their pose, and the states of a point. */
#ifndef JO_CONTACT_PAIR_H
#define JO_CONTACT_PAIR_H

#include "contact/contact.h"
#include "force/contact_point.h"

/* States of a point after those of contact_point.h: code of the features (0: none), share of the stiffness */
enum { JO_PAIR_CODE = JO_CONTACT_STATES, JO_PAIR_WEIGHT };

typedef struct {
    jo_polytope a, b;
    jo_mesh mesh;               /* in place of a, if it has triangles */
    jo_real r[3], R[9];         /* origin and axes of b, resolved in a */
    jo_real v[3], w[3];         /* velocity of this origin on a, and angular velocity; 0 at rest */
} jo_contact_pair_pose;

static inline int jo_pair_points(const jo_force *f) { return f->states / JO_PAIR_STATES; }
static inline int jo_pair_is_listed(const jo_real *state) { return JO_RE(state[JO_PAIR_CODE]) > 0.0; }
static inline int jo_pair_touches(const jo_real *state) { return jo_pair_is_listed(state) && jo_contact_phase(state) != JO_CONTACT_APART; }
static inline double jo_pair_radii(const jo_contact_pair_pose *p) { return JO_RE(p->a.radius + p->b.radius); }

/* contact_apart.c */
/* largest distance of a vertex of b from its origin, or of one of a from there if that is similar, m: how far turns are taken into account */
double jo_pair_reach(const jo_contact_pair_pose *p);
double jo_pair_round_off(const jo_contact_pair_pose *p);   /* of the gap, m */
void jo_pair_approach_speeds(const jo_contact_pair_pose *p, double reach, jo_approach *to);   /* velocities that no point within reach exceeds */
/* and rates above a plane with the normal n */
void jo_pair_approach_along(const jo_contact_pair_pose *p, const double *n, double reach, jo_approach *to);
/* of a point with this code between parts of which one is round, but for a quarter of a rim */
void jo_pair_approach_part(const jo_contact_pair_pose *p, double code, const double *n, jo_approach *to);
void jo_pair_approach_apart(const jo_contact_pair_pose *p, const jo_separated *s, double gap, double reach, jo_approach *to);   /* of two polytopes */

/* contact_mesh.c */
/* the points on a surface of triangles with the states that continue those in `state` */
void jo_pair_list_on_mesh(const jo_force *f, jo_contact_pair_pose *p, const jo_real *state, jo_real *next);
double jo_pair_further_gap(const jo_force *f, jo_contact_pair_pose *p, const jo_real *state);   /* of points that are not listed */
int jo_pair_approach_mesh(const jo_force *f, jo_contact_pair_pose *p, const jo_real *state, double reach, jo_approach *to);   /* of what does not touch yet */

#endif
