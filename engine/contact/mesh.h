/* mesh.h - places on surfaces of triangles that are closest to others, in double precision. */
#ifndef JO_MESH_H
#define JO_MESH_H

#include "contact/polytope.h"

enum { JO_MESH_LEAF = 4 };        /* triangles of a leaf of the tree of boxes */
/* Point of a triangle that is closest to a place, and on what it lies: JO_ON_FACE, JO_ON_EDGE + i from corner i to i + 1, JO_ON_CORNER + i */
enum { JO_ON_FACE = 0, JO_ON_EDGE = 1, JO_ON_CORNER = 4 };
typedef struct { int triangle, part; double at[3], square; } jo_mesh_foot;

/* A point of contact: vertex of the polytope, triangle from which the closest point is looked for, and the side of an open surface; on its
 * rim that side is free. As a number: jo_mesh_code. */
enum { JO_MESH_FRONT = 0, JO_MESH_BEHIND = 1, JO_MESH_FREE = 2, JO_MESH_SIDES = 3 };
typedef struct { int triangle, vertex, side; } jo_mesh_point;

static inline double jo_mesh_code(const jo_mesh_point *p)
{
    return 1.0 + (p->triangle * (double)JO_MAX_VERTICES + p->vertex) * JO_MESH_SIDES + p->side;
}
static inline jo_mesh_point jo_mesh_point_of(double code)
{
    const long long x = (long long)code - 1, y = x / JO_MESH_SIDES;
    const jo_mesh_point p = {(int)(y / JO_MAX_VERTICES), (int)(y % JO_MAX_VERTICES), (int)(x % JO_MESH_SIDES)};
    return p;
}

/* mesh.c */
void jo_mesh_closest(const jo_mesh *m, int triangle, const double *c, jo_mesh_foot *y);
int jo_mesh_is_minimum(const jo_mesh *m, const jo_mesh_foot *y, const double *c);   /* whether no triangle that meets y is closer to c */
void jo_mesh_descend(const jo_mesh *m, int triangle, const double *c, jo_mesh_foot *y);   /* nearest local minimum of the distance */
double jo_mesh_outside(const jo_mesh *m, const jo_mesh_foot *y, const double *c);   /* >= 0: c is in front of its closest point y */
int jo_mesh_is_flat(const jo_mesh *m, const jo_mesh_foot *y);   /* whether all triangles that meet at y are in one plane */
int jo_mesh_is_rim(const jo_mesh *m, const jo_mesh_foot *y);
void jo_mesh_direction(const jo_mesh *m, const jo_mesh_foot *y, const double *c, double *n);   /* from y to c; of c on the surface its normal */
void jo_mesh_feature(const jo_mesh *m, const jo_mesh_foot *foot, int side, const jo_real *c, jo_feature *y);

/* mesh_search.c */
int jo_mesh_nearest(const jo_mesh *m, const double *c, int but_group, double limit, jo_mesh_foot *y);   /* 0: none within the limit */
int jo_mesh_minima(const jo_mesh *m, const double *c, double limit, jo_mesh_foot *list);   /* in front; their number, nearest first */
/* nearest place that is not on the surface about the local minima `known`: on another patch, or another local minimum; 0: none */
int jo_mesh_other(const jo_mesh *m, const double *c, const jo_mesh_foot *known, int count, double limit, jo_mesh_foot *y);

#endif
