/* round_separation.c - signed distance of two convex shapes of which one is round: the direction n with the largest
 *   s(n) = min over b of n . y - max over a of n . y,
 * which is at most the distance for every n. Candidates are the normals of all faces, and those of parts near the closest points (part.c). */
#include "contact/round.h"

enum { JO_SMALLER_COPIES = 5, JO_NEAR_PARTS = 24, JO_PASSES = 8 };
static const double copies[JO_SMALLER_COPIES] = {0.98, 0.9, 0.6, 0.2, 0.0};   /* scales about the centres, until the copies are apart */
#define JO_WELL_APART 1e-3    /* distance over size from which on the closest points show the direction */
#define JO_BESIDE_EDGE 0.7    /* sine of the angle of an edge with the plane across the direction up to which it is near */
#define JO_ABOUT_SIDE 0.8     /* cosine of the angle of the direction with the axis of a cylinder up to which its side is near */
#define JO_ABOUT_RIMS 0.2     /* the same for both rims */
#define JO_DEEP 0.02          /* depth over size from which on all directions are tried */
#define JO_NO_FACE 1e-10      /* difference of distances over size up to which the face of a, or of any shape, is taken */

typedef struct { int kind, of[2]; } near_part;
typedef struct { const jo_polytope *a, *b; jo_real r[3], R[9]; double size; jo_separated *best, face; double low[3], high[3]; } search;

static double size_of(const jo_polytope *p)
{
    double c[3], v[3];
    if (p->round) return jo_polytope_reach(p);
    jo_polytope_vertex(p, -1, c);
    jo_polytope_vertex(p, 0, v);
    jo_minus3d(v, v, c);
    return sqrt(jo_dot3d(v, v)) + JO_RE(p->radius);
}

/* s(n), and the places of both that make it */
static double apart_along(const search *t, const double *n, double *low, double *high)
{
    const double back[3] = {-n[0], -n[1], -n[2]};
    double d[3];
    jo_polytope_extreme(t->a, n, 0, low);
    jo_polytope_extreme(t->b, back, 0, high);
    jo_minus3d(d, high, low);
    return jo_dot3d(n, d);
}

static void keep(search *t, jo_separated *y, const double *n, double gap, const double *low, const double *high)
{
    y->gap = gap;
    for (int i = 0; i < 3; i++) {
        y->normal[i] = n[i];
        t->low[i] = low[i];
        t->high[i] = high[i];
    }
}

/* the faces of one of both; not those over which a place of the other one is not high enough */
static void try_faces(search *t, int of_b)
{
    const jo_polytope *p = of_b ? t->b : t->a;
    const double more = of_b ? JO_NO_FACE * t->size : 0.0;
    for (int k = 0; k < p->faces; k++) {
        double n[3], low[3], high[3];
        const double offset = jo_polytope_face(p, k, n);
        if (!(jo_dot3d(n, of_b ? t->low : t->high) - offset > t->face.gap + more)) continue;
        for (int i = 0; of_b && i < 3; i++) n[i] = -n[i];
        const double gap = apart_along(t, n, low, high);
        if (!(gap > t->face.gap + more)) continue;
        t->face.kind = of_b ? JO_FACE_B : JO_FACE_A;
        t->face.of[0] = k;
        keep(t, &t->face, n, gap, low, high);
    }
}

static int add_part(near_part *list, int count, int kind, int first, int second)
{
    const near_part x = {kind, {first, second}};
    if (count == JO_NEAR_PARTS) return count;
    list[count] = x;
    return count + 1;
}

/* parts of a shape that may be the farthest ones along n, but for faces; their number */
static int near_parts(const jo_polytope *p, const double *n, near_part *list)
{
    int count = 0;
    if (p->round == JO_ROUND_ELLIPSOID) return add_part(list, 0, JO_PART_WHOLE, 0, 0);
    if (p->round) {
        const double up = p->R[2] * n[0] + p->R[5] * n[1] + p->R[8] * n[2];
        if (fabs(up) < JO_ABOUT_SIDE) count = add_part(list, count, JO_PART_EDGE, 0, 0);
        for (int end = 0; end < 2; end++)
            if ((end ? up : -up) > -JO_ABOUT_RIMS) count = add_part(list, count, JO_PART_RIM, end, 0);
        return count;
    }
    const int v = jo_polytope_support(p, n, 0);
    double x[3], y[3];
    count = add_part(list, count, JO_PART_VERTEX, v, 0);
    jo_polytope_vertex(p, v, x);
    for (int k = jo_whole(p->near[v]); k < jo_whole(p->near[v + 1]); k++) {
        const int w = jo_whole(p->neighbour[k]);
        jo_polytope_vertex(p, w, y);
        jo_minus3d(y, x, y);
        if (jo_dot3d(n, y) < JO_BESIDE_EDGE * sqrt(jo_dot3d(y, y))) count = add_part(list, count, JO_PART_EDGE, v < w ? v : w, v < w ? w : v);
    }
    return count;
}

/* parts near the direction n: whether a better one is found */
static int try_parts(search *t, const double *n)
{
    near_part A[JO_NEAR_PARTS], B[JO_NEAR_PARTS];
    const double back[3] = {-n[0], -n[1], -n[2]};
    const jo_real start[3] = {n[0], n[1], n[2]};
    const int count_a = near_parts(t->a, n, A), count_b = near_parts(t->b, back, B);
    int found = 0;
    for (int i = 0; i < count_a; i++) {
        const jo_part a = jo_part_of(t->a, A[i].kind, A[i].of, 0, 0, 0);
        for (int k = 0; k < count_b; k++) {
            const jo_part b = jo_part_of(t->b, B[k].kind, B[k].of, 0, t->r, t->R);
            double low[3], high[3];
            jo_meeting y;
            if (!jo_part_closest(&a, &b, start, &y)) continue;
            const double m[3] = {JO_RE(y.n[0]), JO_RE(y.n[1]), JO_RE(y.n[2])}, gap = apart_along(t, m, low, high);
            if (!(gap > t->best->gap)) continue;
            found = 1;
            t->best->kind = JO_ROUND_PARTS;
            t->best->part[0] = A[i].kind;
            t->best->part[1] = B[k].kind;
            for (int j = 0; j < 2; j++) {
                t->best->of[j] = A[i].of[j];
                t->best->of[2 + j] = B[k].of[j];
            }
            keep(t, t->best, m, gap, low, high);
        }
    }
    return found;
}

/* the direction between the closest points, of smaller copies where they overlap or nearly touch */
static void first_direction(const jo_polytope *a, const jo_polytope *b, double size, double *n)
{
    jo_simplex s;
    double d = jo_closest_points(a, b, 1.0, &s);
    for (int k = 0; k < JO_SMALLER_COPIES && !(d > JO_WELL_APART * size); k++) d = jo_closest_points(a, b, copies[k], &s);
    for (int i = 0; i < 3; i++) n[i] = s.v[i];
    if (jo_unit3d(n) > 0.0) return;
    n[0] = 0.6;
    n[1] = 0.64;
    n[2] = 0.48;   /* in each other's centre */
}

/* the best direction of those that are reached from n: those of the parts near it, and near the better one that they show */
static void search_from(search *t, const double *n)
{
    for (int pass = 0; pass < JO_PASSES && try_parts(t, pass ? t->best->normal : n); pass++) {}
}

/* of shapes that overlap deeply, s has several largest values: from the directions of the sides, edges and corners of a cube */
static void search_everywhere(search *t)
{
    for (int i = 0; i < 27; i++) {
        double n[3] = {i % 3 - 1.0, i / 3 % 3 - 1.0, i / 9 - 1.0};
        if (jo_unit3d(n) > 0.0) search_from(t, n);
    }
}

void jo_round_separation(const jo_polytope *a, const jo_polytope *b, jo_separated *y)
{
    search t;
    double n[3];
    t.a = a;
    t.b = b;
    t.best = y;
    t.size = size_of(a) + size_of(b);
    for (int i = 0; i < 3; i++) t.r[i] = jo_same(b->r[i]);
    for (int i = 0; i < 9; i++) t.R[i] = jo_same(b->R[i]);
    first_direction(a, b, t.size, n);
    t.face.gap = -INFINITY;
    t.face.kind = JO_CLOSEST_POINTS;
    t.face.of[0] = 0;
    apart_along(&t, n, t.low, t.high);
    try_faces(&t, 0);
    try_faces(&t, 1);
    y->gap = -INFINITY;
    search_from(&t, n);
    if (fmax(y->gap, t.face.gap) < -JO_DEEP * t.size) search_everywhere(&t);
    y->round = 1;
    y->near = JO_CLOSEST_POINTS;
    y->vertex[0] = y->vertex[1] = y->count[0] = y->count[1] = 0;
    if (t.face.gap > y->gap - JO_NO_FACE * t.size) {
        y->kind = t.face.kind;
        y->of[0] = t.face.of[0];
        if (t.face.gap > y->gap) y->gap = t.face.gap;
        for (int i = 0; i < 3; i++) y->normal[i] = t.face.normal[i];
    } else if (t.face.gap > -INFINITY && jo_dot3d(t.face.normal, y->normal) > JO_NEAR_FACE) {
        y->near = t.face.kind;
        y->near_face = t.face.of[0];
    }
}
