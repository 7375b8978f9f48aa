/* contact_rows.h - shapes whose pairs are not known: their numbers, and the slots that hold the pairs that are near. */
#ifndef JO_CONTACT_ROWS_H
#define JO_CONTACT_ROWS_H

#include "contact/contact.h"

enum { JO_SHAPE_TYPES = 11 };   /* types of jo_shape_type */

/* Rows after the numbers of a set. Markers, types and other whole numbers are stored as numbers.
 * reach: distance from the marker to the farthest place, m, < 0 for a shape without end; curvature, 1/m, and largest inverse mass, 1/kg, of a
 * shape that is touched and of one with tips; angular: largest inverse moment of inertia, 1/(kg m^2); the tips of a shape follow one another; polytope: place of its numbers, see polytope.c */
typedef struct { jo_real marker, type, size[3], reach, first, tips, curvature[2], mobility[2], angular, polytope, surface, group; } jo_shape_row;
typedef struct { jo_real shape, centre[3], radius, ring, around, axes[3]; } jo_tip_row;
/* law of a pair of surfaces, as in jo_contact_data; hertz 1: the stiffness is divided by the root of the sum of both curvatures; span: the
 * duration is span (mass / stiffness)^(1 / (exponent + 1)) */
typedef struct {
    jo_real hertz, stiffness, exponent, damping, slowest, viscous, full, mu_static, mu_kinetic, shear, span, restitution;
    jo_real velocity, curve, extent, rolling, drilling, impedance[5];
} jo_law_row;

typedef struct {
    int shapes, tips, surfaces, groups, excluded, resolve;
    int slots[2];               /* numbers of slots for tips and for pairs of polytopes, in this order */
    const jo_shape_row *shape;
    const jo_tip_row *tip;
    const jo_law_row *law;      /* (surfaces x surfaces) */
    const jo_real *touching;    /* (JO_SHAPE_TYPES x JO_SHAPE_TYPES) 1: tips of the second touch the first; 2: the reverse; 3: as polytopes; 0: neither */
    const jo_real *meets;       /* (groups x groups) whether shapes of two groups touch */
    const jo_real *apart;       /* (excluded) pairs of shapes i < j that never touch, as i shapes + j, ascending */
    const jo_real *polytope;    /* numbers of the polytopes */
} jo_contact_rows;

/* A shape at the start of a step: centre, m, largest distance of a place from it, and by how much it may be displaced, m, and turned, rad,
 * within the step; its velocities then. */
typedef struct { double centre[3], reach, shift, turn, v[3], w[3]; int cell[3], next; } jo_swept;
/* a tip, or a polytope with this number less that of all tips, that is near a shape, and the slot that holds it; -1: none */
typedef struct { int on, tip, slot; } jo_near;

/* Work space of the search in one set. */
typedef struct jo_contact_search {
    int set;                /* force of the set */
    jo_swept *swept;        /* (shapes) */
    int *head, heads;       /* first shape of each cell of the grid, by its hash; their number, a power of 2 */
    int *wide, nwide;       /* shapes that are not in the grid */
    jo_near *near;          /* (slots) */
    int nnear[2], full;     /* for tips and for polytopes; whether there are more than slots */
    int *place, places;     /* slots by the hash of their pair */
} jo_contact_search;

/* The contact of a slot: its pair, the force that computes it, and, to which force.user points, the numbers of both polytopes
 * and, for Hertz's law, the curvatures that it has (2), else 0. */
typedef struct jo_bound { int on, tip; jo_force force; jo_contact_data data; const jo_real *polytope[3]; jo_real curvature[2]; } jo_bound;

jo_contact_rows jo_contact_rows_of(const jo_force *set);
double jo_shape_gap(const jo_contact_rows *y, const jo_data *d, int on, const jo_real *place);   /* distance of a place, world, from a shape, m */
double jo_tip_gap(const jo_contact_rows *y, const jo_data *d, int on, int tip);   /* distance of a tip from a shape, m */
/* signed distance of two polytopes, m, or any number above `most` if it is larger than that */
double jo_polytope_gap(const jo_contact_rows *y, const jo_data *d, int on, int of, double most);
static inline int jo_slots(const jo_contact_rows *y) { return y->slots[0] + y->slots[1]; }


#endif
