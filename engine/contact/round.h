/* round.h - vertices, edges and faces of polytopes beside rims, sides and whole surfaces of round shapes. */
#ifndef JO_ROUND_H
#define JO_ROUND_H

#include "contact/polytope.h"

/* A part of a shape, resolved in a: a vertex, a place on an edge or face, or a centre; direction of an edge, normal of a face, axis of a rim; first
 * axis and radius of a rim, radius about an edge, from the middle of a polytope to its edge; cosine and sine of the quarter of a rim over a face
 * (stands); axes and half axes of an ellipsoid */
typedef struct { int kind, stands; jo_real at[3], along[3], first[3], out[3], radius, R[9], size[3]; double cosine, sine; } jo_part;

/* Two parts that face each other along the normal n from a to b: their places, how these change with the normals of their own, dp = bend dm, and
 * p_b - p_a, which is n gap where they are closest */
typedef struct { jo_real n[3], a[3], b[3], bend[2][9], apart[3], gap; } jo_meeting;

#define JO_NEAR_FACE 0.995   /* cosine of the angle of a direction with the normal of a face, or of an axis, from which on they are nearly parallel */

/* part.c */
/* code of two parts that face each other along n, in a */
double jo_part_code(const jo_polytope *a, const jo_polytope *b, const int *part, const int *of, const double *n);
jo_part jo_part_of(const jo_polytope *p, int kind, const int *of, int over_face, const jo_real *r, const jo_real *R);
/* the direction that a code names, in which two parts have been closest, in a; b: the present pose */
void jo_part_direction(const jo_feature_pair *f, const jo_part *a, const jo_part *b, const jo_real *R, jo_real *n);
/* the closest places of both from the direction n on; 0: there are none */
int jo_part_closest(const jo_part *a, const jo_part *b, const jo_real *start, jo_meeting *y);

/* round_feature.c */
void jo_round_feature_at(const jo_polytope *A, const jo_polytope *B, const jo_real *r, const jo_real *R, const jo_feature_pair *f, jo_feature *y);
void jo_round_feature_change(const jo_feature *y, const jo_real *r, const jo_real *x, const jo_real *phi, jo_real *gap, jo_real *normal, jo_real *foot);

/* round_separation.c */
void jo_round_separation(const jo_polytope *a, const jo_polytope *b, jo_separated *y);

#endif
