/* contact.h - signed distance of shapes, corners of the area in which two of them touch, contacts in the matrix of a Rosenbrock method, and
 * sets of shapes whose pairs are found at run time; functions for other rooms. */
#ifndef JO_CONTACT_H
#define JO_CONTACT_H

#include "arena.h"
#include "data.h"

/* Shapes in the frame of their marker, with their sizes, m. Axes of revolution: z. */
typedef enum {
    JO_SHAPE_HALF_SPACE = 0,    /* below z = 0 */
    JO_SHAPE_SPHERE = 1,        /* radius; 0: a point */
    JO_SHAPE_HOLLOW_SPHERE = 2, /* outside of the radius */
    JO_SHAPE_CAPSULE = 3,       /* radius, half the distance of its centres */
    JO_SHAPE_BOX = 4,           /* half the lengths along x, y, z */
    JO_SHAPE_CYLINDER = 5,      /* radius, half the length */
    JO_SHAPE_BORE = 6,          /* radius of an endless hole */
    JO_SHAPE_TORUS = 7,         /* radius of the circle of centres, radius of the tube */
    JO_SHAPE_ELLIPSOID = 8,     /* half the lengths along x, y, z */
    JO_SHAPE_HULL = 9,          /* of points, in sets of shapes only: its polytope */
    JO_SHAPE_SURFACE = 10       /* of triangles, in sets of shapes only: its numbers, then those of its hull if there is a half-space */
} jo_shape_type;

/* Signed distance of a point outside of a shape (inside: negative), m; its gradient, the outward normal; its second derivatives, 1/m. */
typedef struct { jo_real gap, normal[3], hessian[9]; } jo_distance;

enum { JO_PAIR_STATES = 8 };      /* states of a point of a contact_pair */
enum { JO_SLOT_STATES = 2 };      /* states of a slot before those of its contact: shape that is touched + 1, tip or other shape + 1; 0: free */
/* numbers that trees in joint coordinates take at most: rows of contacts of known pairs, three each, and of networks; closed contacts, with those
 * of sets; free bodies beside a set */
enum { JO_TREE_ROWS = 48, JO_TREE_CLOSED = 32, JO_TREE_BODIES = 8 };

/* A contact in the matrix M + J^T G J of a step, G = g h D + (g h)^2 (K + B): derivatives of its force F on b with respect to the position
 * and velocity of b on a at the contact point and to the stretch s of its bristle, as in the first stage; resolved in a, (3 x 3) by rows. */
typedef struct jo_contact_matrix {
    int declared;           /* in m->force */
    const jo_force *force;  /* the same, or the contact of a slot, with the markers a and b */
    int first, state;       /* first one of its states, which is its phase, 0 apart; first one of s */
    int turns;              /* the same for the moment of a resistance: F is a moment, x a turn, v the angular velocity, s the turn of its bristle */
    int closed;             /* whether the matrix of the present step contains it */
    int follows;            /* whether s follows the slip velocity */
    int at[2], count[2];    /* of the velocities on which that of the contact point depends: the first, and their number */
    jo_real *room[2];       /* for J in maximal coordinates */
    jo_real *J[2];          /* (3 x count) velocity of b on a at the contact point: sum of J[i] times these */
    jo_real point[3], normal[3];   /* contact point, m, world; normal of a */
    jo_real K[9], D[9], B[9], G[9];   /* -dF/dx, -dF/dv, -dF/ds; G */
    jo_real u[3], w[3], S[3];   /* J times the arguments of stiffness and damping in this stage, sum s_ij s_j' of the earlier stages */
} jo_contact_matrix;

/* number of points of a slot for two polytopes; 0: it is one for a tip, with 6 or 9 states of a contact */
static inline int jo_slot_pair_points(const jo_force *f)
{
    const int states = f->states - JO_SLOT_STATES;
    return states % JO_PAIR_STATES ? 0 : states / JO_PAIR_STATES;
}
/* number of points of a force at which two bodies touch */
static inline int jo_contact_points(const jo_force *f)
{
    if (f->type == JO_FORCE_contact_slot) return jo_slot_pair_points(f) > 0 ? jo_slot_pair_points(f) : 1;
    return f->type == JO_FORCE_contact ? 1 : f->type == JO_FORCE_contact_pair ? f->states / JO_PAIR_STATES : 0;
}
/* first state of a point */
static inline int jo_contact_first(const jo_force *f, int point)
{
    return f->state + (f->type == JO_FORCE_contact_slot ? JO_SLOT_STATES : 0) + JO_PAIR_STATES * point;
}

/* whether a contact, or that of a slot, may resist rolling and drilling: it has JO_TURN_STATES states of a turn from JO_TURN_FIRST on; and the
 * number of its blocks in a matrix */
enum { JO_TURN_FIRST = 6, JO_TURN_STATES = 3 };
#ifndef JO_VECTOR
static inline int jo_contact_turns(const jo_force *f)
{
    const jo_contact_data *x = (const jo_contact_data *)f->data;
    if (f->type == JO_FORCE_contact_slot) return f->states == JO_SLOT_STATES + JO_TURN_FIRST + JO_TURN_STATES;
    return f->type == JO_FORCE_contact && (JO_RE(x->rolling) > 0.0 || JO_RE(x->drilling) > 0.0);
}
static inline int jo_contact_blocks(const jo_force *f) { return jo_contact_points(f) + jo_contact_turns(f); }
#endif

/* the contact with this first state */
static inline jo_contact_matrix *jo_contact_in_matrix(const jo_data *d, int first) { return &d->contacts.matrix[d->contacts.of_state[first]]; }

/* y (3) = J z */
static inline void jo_contact_velocity(const jo_contact_matrix *c, const jo_real *z, jo_real *y)
{
    for (int i = 0; i < 3; i++) {
        y[i] = jo_same(0.0);
        for (int s = 0; s < 2; s++) {
            const int n = c->count[s];
            const jo_real *row = c->J[s] + i * n, *x = z + c->at[s];
            for (int j = 0; j < n; j++) y[i] += row[j] * x[j];
        }
    }
}

/* whether the matrix of a step takes contacts, the number of closed ones, and the i-th of them */
static inline int jo_matrix_takes_contacts(const jo_data *d) { return d->contacts.fit; }
static inline int jo_closed_contacts(const jo_data *d) { return d->contacts.closed; }
static inline jo_contact_matrix *jo_closed_contact(const jo_data *d, int i) { return &d->contacts.matrix[d->contacts.list[i]]; }

/* Convex polytope with rounded edges: all points within a radius of it. A half-space has one face and no vertices, a point one vertex, a
 * segment two, without faces. Round shapes are no polytopes: a cylinder, whose ends are faces, with vertices on both rims; an ellipsoid without
 * vertices. r, R: its origin and axes in the frame in which two of them meet. */
typedef enum { JO_NOT_ROUND, JO_ROUND_CYLINDER, JO_ROUND_ELLIPSOID } jo_roundness;
typedef struct {
    int vertices, faces, round;
    const jo_real *size;    /* (3) of a round shape: radius and half the length along z; half axes */
    const jo_real *centre, *vertex, *plane, *first, *corner, *near, *neighbour;   /* see polytope.c */
    jo_real radius;
    double r[3], R[9];
} jo_polytope;

/* Features of a and of b that touch; kind: 3 times the dimension of that of a, plus that of b. Vertices, or a face. */
typedef enum { JO_VERTEX_VERTEX = 0, JO_VERTEX_EDGE = 1, JO_VERTEX_FACE = 2, JO_EDGE_VERTEX = 3, JO_EDGE_EDGE = 4, JO_FACE_VERTEX = 6 } jo_feature_kind;
/* Where one of the shapes is round, JO_ROUND_PAIR plus JO_PARTS times the part of a plus that of b. An edge with equal vertices is the side of a
 * cylinder; the second number of a rim is its quarter from the lowest point over a face, else free numbers name a direction, see part.c. */
typedef enum { JO_PART_VERTEX, JO_PART_EDGE, JO_PART_FACE, JO_PART_RIM, JO_PART_WHOLE, JO_PARTS } jo_part_kind;
enum { JO_ROUND_PAIR = 9 };
typedef struct { int kind, a[2], b[2]; } jo_feature_pair;
enum { JO_MAX_VERTICES = 1024 };    /* vertices or faces of a polytope that a code can name */
static inline double jo_feature_code(const jo_feature_pair *f)
{
    return 1.0 + (((f->kind * (double)JO_MAX_VERTICES + f->a[0]) * JO_MAX_VERTICES + f->a[1]) * JO_MAX_VERTICES + f->b[0]) * JO_MAX_VERTICES + f->b[1];
}
static inline jo_feature_pair jo_feature_of(double code)
{
    long long x = (long long)code - 1;
    int part[4];
    for (int i = 3; i >= 0; i--, x /= JO_MAX_VERTICES) part[i] = (int)(x % JO_MAX_VERTICES);
    const jo_feature_pair f = {(int)x, {part[0], part[1]}, {part[2], part[3]}};
    return f;
}

/* Gap of two features, m, less both radii; normal from a to b; foot point on a; how the normal turns, see feature.c */
typedef struct {
    int kind, rule[2];
    jo_real gap, normal[3], foot[3], u[2][3], dual[2][3], edge[3], across[3];
    jo_real bend[2][9];     /* of round shapes, see round_feature.c */
} jo_feature;

/* Gap of two polytopes, m, without their radii, normal, and how it was found: face of a or b, vertices of two edges, closest points. vertex: of a
 * and of b, one of the closest points where they are apart. Of round shapes: `part` of each with the
 * numbers in `of`, or a face; else the face near the direction, if there is one. edges: the gap is that along the normal across two edges, which is
 * near that of the face whose corners touch. */
typedef enum { JO_CLOSEST_POINTS, JO_FACE_A, JO_FACE_B, JO_EDGES, JO_ROUND_PARTS } jo_separation_kind;
typedef struct {
    int kind, of[4], count[2], vertex[2], round, part[2], near, near_face, edges, edge[4];
    double gap, normal[3], across[3];
} jo_separated;

/* Corner of the area in which two faces touch: code of its features, share of a stiffness of a corner, place */
typedef struct { double code, weight, at[3]; } jo_corner;
enum { JO_CORNERS = 8, JO_MOST_SLOT_STATES = 66 };    /* largest number; then the states of a slot */

/* Surface of triangles in the frame of its marker. closed: it has an inside, else two sides. group: triangles of one plane; patch: triangles
 * joined by edges that are not concave. */
enum { JO_MESH_MARK = -1 };       /* first number of a surface, where a polytope has the number of its vertices */
enum { JO_MESH_POINTS = 8 };      /* largest number of points at which a polytope touches a surface, or a sphere has local minima */

typedef struct {
    int vertices, triangles, groups, leaves, closed;
    const jo_real *vertex, *plane, *corner, *neighbour, *group, *patch, *first, *fan, *box;   /* see mesh.c */
} jo_mesh;

#ifndef JO_VECTOR
static inline int jo_is_mesh(const jo_real *data) { return (int)JO_RE(data[0]) == JO_MESH_MARK; }
#endif

/* Distance of a polytope from a surface, less both radii: normal at the nearest place. For the proof of a gap: part of the surface there, > 0 a
 * plane, < 0 a patch, 0 unknown; curvature of the distance above it, 1/m; distance of everything else. */
typedef struct { double gap, normal[3], clear, curvature; int part; } jo_mesh_gap;

/* how a touch is resolved: by short steps, by an impulse, not at all */
enum { JO_RESOLVE_CUT = 0, JO_RESOLVE_IMPULSE = 1, JO_RESOLVE_REPORT = 2 };
enum { JO_STRUCK = 32 };    /* largest number of points that exchange impulses in an instant */
enum { JO_STRUCK_ROWS = 3 * JO_STRUCK };

/* A point that strikes, or that is closed and takes part. */
typedef struct jo_strike {
    const jo_force *force;  /* whose markers it is on */
    int number;             /* in m->force, of a slot that of the slot */
    int first, approach, since;   /* first state of the point; its states of the speed and of the time of the touch */
    int closed, rows;       /* whether it has touched before; 1 row along the normal, or 3 with friction */
    jo_real lever[3];       /* from the origin of b, resolved in a */
    jo_real axis[9];        /* rows: normal of a, two tangents */
    jo_real v[3];           /* velocity of b on a along these, before */
    jo_real gap, mass, slowest, restitution, mu, stiffness, exponent;
    int rests;              /* at the end of a step of bounded work: it strikes without rebound, so that its law begins */
    double late;            /* time since its touch there, s */
    jo_real target[3];      /* with these velocities subtracted the laws are homogeneous */
} jo_strike;

/* adds the force of an impulse at the point with this first state to F (6) */
static inline void jo_add_blow(const jo_data *d, int first, const jo_real *lever, jo_real *F)
{
    jo_real T[3];
    jo_cross(T, lever, d->contacts.blow + first);
    jo_add3(F, d->contacts.blow + first);
    jo_add3(F + 3, T);
}
static inline int jo_has_impulses(const jo_data *d) { return d->contacts.struck_points != 0; }
static inline int jo_blows(const jo_data *d) { return d->contacts.blows; }
/* whether touches that strike wait for their impulse, which comes at the end of a step of bounded work */
static inline int jo_touches_wait(const jo_data *d) { return d->contacts.waits; }
static inline void jo_let_touches_wait(jo_data *d, int wait) { d->contacts.waits = wait; }

/* shape_distance.c */
void jo_shape_distance(int shape, const jo_real *size, const jo_real *x, jo_distance *y);

static inline jo_real *jo_slot_states(const jo_data *d, const jo_force *f) { return d->w + (d->nw - d->contact_sets.nstate) + f->state; }
static inline int jo_has_contact_sets(const jo_data *d) { return d->contact_sets.count > 0; }

/* polytope.c */
const jo_real *jo_polytope_read(const jo_real *data, jo_polytope *p);   /* returns the end of its data */
void jo_polytope_place(jo_polytope *p, const jo_real *r, const jo_real *R);   /* NULL: at the origin */
double jo_polytope_height(const jo_polytope *p, const double *n);   /* largest n . y, resolved in its own frame */
/* smallest sine of the angle by which edges that begin at an end of the edge (i, k), or at the vertex i = k, rise from the plane across n there */
double jo_polytope_rises(const jo_polytope *p, int i, int k, const double *n);
double jo_polytope_room(const jo_polytope *p, int i, int k, const double *x);   /* of the edge (i, k), on the shorter side of its place nearest to x */
int jo_polytope_extreme(const jo_polytope *p, const double *n, int from, double *y);   /* place farthest along n, and its vertex */
double jo_polytope_reach(const jo_polytope *p);   /* largest distance of a place from its origin, m, less its radius */

/* part.c */
int jo_part_pair(const jo_feature_pair *f, int *part);   /* parts of both (2); 0: no shape is round */
int jo_part_is_quarter(const jo_feature_pair *f);   /* whether it is a place of a rim beside the lowest one */
double jo_part_height(const jo_polytope *p, int kind, const int *of, const double *n);   /* largest n . y of a part of a shape, in its own frame */
int jo_same_parts(double code, double other);   /* whether two codes name the same features, but for the direction of a normal */

/* round_feature.c */
/* sum of the mean curvatures of two shapes at a point with this code, 1/m; 0: of no round shape. edge: that of edges and corners of each (2) */
double jo_round_curvature(const jo_polytope *A, const jo_polytope *B, const jo_real *r, const jo_real *R, double code, const jo_real *edge);

/* feature.c */
void jo_feature_at(const jo_polytope *A, const jo_polytope *B, const jo_real *r, const jo_real *R, jo_real code, jo_feature *y);
void jo_feature_change(const jo_feature *y, const jo_real *r, const jo_real *x, const jo_real *phi, jo_real *gap, jo_real *normal, jo_real *foot);

/* mesh.c */
const jo_real *jo_mesh_read(const jo_real *data, jo_mesh *m, jo_real *radius);   /* returns the end of its data */

/* mesh_points.c */
/* b is placed, `radius` is the sum of both radii, `code` those of the points that touch */
void jo_mesh_distance(const jo_mesh *m, const jo_polytope *b, double radius, jo_mesh_gap *y);
int jo_mesh_points(const jo_mesh *m, const jo_polytope *b, double radius, const double *code, int count, double *found, int *from);
double jo_mesh_unlisted(const jo_mesh *m, const jo_polytope *b, double radius, const double *code, int count);   /* gap of further points */
void jo_mesh_clearance(const jo_mesh *m, const jo_polytope *b, double radius, const double *code, int count, jo_mesh_gap *y);
void jo_mesh_point_feature(const jo_mesh *m, const jo_polytope *b, const jo_real *r, const jo_real *R, double code, jo_feature *y);

/* separation.c */
void jo_separation(const jo_polytope *a, const jo_polytope *b, const jo_separated *before, jo_separated *y);   /* before: where it was found, or NULL */

/* whether the planes and lines of two features, of this code, separate both polytopes; y->gap is then not larger than their distance */
int jo_still_separated(const jo_polytope *a, const jo_polytope *b, double code, const jo_real *r, const jo_real *R, jo_separated *y);
/* code of the closest features of polytopes that are apart; 0: none */
double jo_separation_code(const jo_separated *s);
/* a number up to which they are apart, m, less both radii, at least: in the direction of their centres */
double jo_separation_at_least(const jo_polytope *a, const jo_polytope *b);

/* corners.c */
int jo_corners(const jo_polytope *a, const jo_polytope *b, const jo_separated *s, jo_corner *list);   /* their number, up to JO_CORNERS */

/* round_corners.c */
int jo_round_corners(const jo_polytope *a, const jo_polytope *b, const jo_separated *s, jo_corner *list);   /* the same where one is round */

/* contact_rows.c */
int jo_is_contact_set(const jo_force *f);
int jo_shape_count(const jo_force *set);
int jo_shape_marker(const jo_force *set, int shape);   /* marker of a shape of a set; -1 beyond the last one */
const jo_force *jo_bound_force(const jo_data *d, const jo_force *f);   /* the contact of a slot; 0 if the slot is free */
void jo_contact_sets_layout(const jo_model *m, jo_data *d, jo_arena *a);

double jo_slot_pressure(const jo_data *d, const jo_force *slot, double N);   /* largest pressure by Hertz, Pa; 0 for other laws */
void jo_slot_shapes(const jo_data *d, const jo_force *slot, int *shapes);   /* that is touched, and the other one; -1: free */

/* contact_sensor.c */
void jo_contact_sensor(const jo_model *m, const jo_data *d, const jo_sensor *s, jo_real *y);   /* after jo_yielding_ready */

/* contact_record.c */
/* k is the number of a force that yields, at the end of an accepted step */
int jo_has_contacts(const jo_model *m);
int jo_contact_energy_size(const jo_model *m);   /* numbers of jo_data_contact_energy; 0 without contacts */
void jo_contact_record_layout(const jo_model *m, jo_data *d, jo_arena *a);
void jo_record_start(const jo_model *m, jo_data *d);   /* at the start of a run, after jo_yielding_ready: contacts that touch */
void jo_record_step(const jo_model *m, jo_data *d, int k);   /* before its states change */
/* with its states x from then on; jumped: whether they make the force jump. Books what is lost */
void jo_record_change(const jo_model *m, jo_data *d, int k, const jo_real *x, int jumped);
void jo_record_release(const jo_model *m, jo_data *d);   /* contacts that are switched off lose what they store */
jo_real jo_bristles(const jo_model *m, const jo_data *d);   /* energy that bristles stored at the end of the last step, J */
void jo_keep_contact_losses(const jo_model *m, jo_data *d);   /* at the start of an adaptive step */
/* within it, after a share of the step; exchanges `losses` (2) with those of its end, and books that bristles store `bristles`, J */
void jo_place_contact_losses(jo_data *d, double share, jo_real bristles, double *losses);
void jo_contact_list_begins(jo_data *d);
int jo_contact_list_has_room(const jo_model *m, const jo_data *d);   /* for the events of another step */

/* contact_search.c */
/* Bind the pairs that may touch within a step of *length, s, from the present state to slots, and release those that are apart. *length is
 * shortened to one for which the slots suffice. *jumped: whether a pair overlaps already. To be called after jo_yielding_ready */
int jo_find_contacts(const jo_model *m, jo_data *d, double *length, int *jumped);
/* at the end of a step of length h: whether no shape can have moved farther than the search has assumed */
int jo_found_all_contacts(const jo_model *m, const jo_data *d, double h);

/* contact_matrix.c */
void jo_contact_layout(const jo_model *m, jo_data *d, jo_arena *a);
int jo_contacts_fit(const jo_model *m, jo_data *d);   /* whether the matrix of a step has room for all contacts that act at its start */
int jo_contacts_begin(const jo_model *m, jo_data *d);   /* start of a step: whether any contact acts, and all fit */
void jo_contact_place_in_matrix(const jo_model *m, jo_data *d, const jo_stage *stage, jo_contact_matrix *c);   /* J and G */
void jo_contact_carry(const jo_model *m, jo_data *d);   /* u, w, S of a later stage, from dv and acc */
void jo_contact_push(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_contact_matrix *c, const jo_real *lever);
void jo_contact_state_rates(const jo_model *m, jo_data *d, const jo_stage *stage);   /* s' with the accelerations of the stage */
void jo_contact_add_to_newton(const jo_model *m, jo_data *d);   /* J^T G J */
void jo_contact_subtract(const jo_model *m, jo_data *d, const jo_real *a);   /* J^T G J a from the right-hand side of Newton's matrix */

/* brief_touches.c */
void jo_brief_layout(const jo_model *m, jo_data *d, jo_arena *a);
void jo_brief_step(jo_data *d, double step, int counts);   /* length of the step that begins, s, 0: as before; whether touches count from here on */
void jo_note_touch(const jo_data *d, int state, double duration);   /* a touch begins that will last for a duration, s */

/* impulse_solver.c */
/* Impulses p (n) with v + W p, W (n x n), of k points, by block Gauss-Seidel sweeps; returns whether they have converged. */
int jo_impulse_solve(const jo_strike *s, int k, int n, const jo_real *W, jo_real *p);

/* impulses.c */
void jo_impulse_layout(const jo_model *m, jo_data *d, jo_arena *a);
/* All velocities jump where points strike at the present state: at a located instant, or at the end of a step of bounded work of length h.
 * *struck: their number. */
int jo_strike_all(const jo_model *m, jo_data *d, double h, int *struck);
int jo_struck_force(const jo_data *d, int k, double *impulse);   /* k-th force that has struck last, with its normal impulse, N s; -1: no more */

#endif
