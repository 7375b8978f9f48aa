/* polytope.h - convex polytopes in double precision: what is found here are whole numbers, and starts of closed forms. */
#ifndef JO_POLYTOPE_H
#define JO_POLYTOPE_H

#include "contact/contact.h"

/* Vertices of a point of two polytopes a, b that is closest to the other: v = sum share (b - a), up to 4 */
typedef struct { int count, a[4], b[4]; double w[4][3], share[4], v[3]; } jo_simplex;

static inline double jo_dot3d(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static inline void jo_cross3d(double *y, const double *a, const double *b)
{
    const double y0 = a[1] * b[2] - a[2] * b[1], y1 = a[2] * b[0] - a[0] * b[2], y2 = a[0] * b[1] - a[1] * b[0];
    y[0] = y0; y[1] = y1; y[2] = y2;
}
static inline void jo_minus3d(double *y, const double *a, const double *b)
{
    for (int i = 0; i < 3; i++) y[i] = a[i] - b[i];
}
/* n = n / |n|; returns |n| */
static inline double jo_unit3d(double *n)
{
    const double length = sqrt(jo_dot3d(n, n));
    if (length > 0.0)
        for (int i = 0; i < 3; i++) n[i] /= length;
    return length;
}

/* polytope.c: resolved in the frame of the first shape of a pair */
void jo_polytope_vertex(const jo_polytope *p, int i, double *y);
double jo_polytope_face(const jo_polytope *p, int i, double *n);   /* outward normal n; returns n . y of its plane */
int jo_polytope_support(const jo_polytope *p, const double *n, int from);   /* vertex with the largest n . y; climbs from a vertex */
int jo_polytope_corners(const jo_polytope *p, int face);   /* number of corners of a face */
int jo_polytope_corner(const jo_polytope *p, int face, int i);   /* its vertex; i is taken in turn */

/* closest_points.c */
double jo_closest_points(const jo_polytope *a, const jo_polytope *b, double share, jo_simplex *s);

/* corners.c: of the face of a polytope and another polytope; of_b: own is b. Their number */
int jo_face_corners(const jo_polytope *own, const jo_polytope *other, int face, int of_b, jo_corner *list);

/* feature.c: of a fixed surface a and the centre c of a sphere */
void jo_feature_above(jo_feature *y, const jo_real *normal, jo_real gap, const jo_real *c);   /* over a plane */
/* about a vertex, or an edge along e (NULL: none), from which c is displaced by w; sign of the gap */
void jo_feature_around(jo_feature *y, jo_real *w, jo_real *e, double sign, const jo_real *c);

#endif
