/* separation.c - signed distance of two convex polytopes: closest points, or the direction in which they overlap least.
 *
 * s(n) = min over b of n . y - max over a of n . y is at most the distance, for every unit vector n; two polytopes are apart if and only if
 * s > 0 for the normal of a face or the product of two edges (Gottschalk, Lin, Manocha, SIGGRAPH 1996). Where they overlap, its largest value
 * is the signed distance. It is looked for near the closest points of smaller copies of both. */
#include "contact/mesh.h"
#include "contact/round.h"

enum { JO_SMALLER = 5 };
static const double smaller[JO_SMALLER] = {0.98, 0.9, 0.6, 0.2, 0.0};   /* scales about the centres, until the copies are apart */
#define JO_APART 1e-10        /* distance over size from which on the closest points are well defined */
#define JO_SAME_AXIS 1e-9     /* difference of distances over size up to which a face of a is taken rather than one of b */
#define JO_SAME_NORMAL 0.995  /* cosine of the angle up to which a face is taken rather than two edges: these are then corners of its area */
#define JO_SAME_GAP 1e-13     /* difference of distances over the distance that is round-off */
#define JO_PARALLEL 1e-12     /* square of the sine of the angle of two edges that are parallel */

static double size_of(const jo_polytope *p)
{
    double c[3], v[3];
    if (!p->vertices) return 0.0;
    jo_polytope_vertex(p, -1, c);
    jo_polytope_vertex(p, 0, v);
    jo_minus3d(v, v, c);
    return sqrt(jo_dot3d(v, v));
}

/* The best axis so far, with supports in its direction; b lies above a. */
typedef struct { const jo_polytope *a, *b; int va, vb; double low[3], high[3]; jo_separated *best; } search;

/* tries the axis n: first with the supports of the best one, which cannot be exceeded */
static void try_axis(search *t, const double *n, int kind, const int *of)
{
    double p[3], q[3], d[3];
    jo_minus3d(d, t->high, t->low);
    if (!(jo_dot3d(n, d) > t->best->gap)) return;
    const double back[3] = {-n[0], -n[1], -n[2]};
    const int va = jo_polytope_support(t->a, n, t->va), vb = jo_polytope_support(t->b, back, t->vb);
    jo_polytope_vertex(t->a, va, p);
    jo_polytope_vertex(t->b, vb, q);
    jo_minus3d(d, q, p);
    const double gap = jo_dot3d(n, d);
    if (!(gap > t->best->gap)) return;
    t->best->gap = gap;
    t->best->kind = kind;
    t->va = va;
    t->vb = vb;
    for (int i = 0; i < 3; i++) {
        t->best->normal[i] = n[i];
        t->low[i] = p[i];
        t->high[i] = q[i];
    }
    for (int i = 0; i < 4; i++) t->best->of[i] = of[i];
}

/* axis of a face of a, or against one of b */
static void try_face(search *t, int face, int of_b)
{
    const int of[4] = {face, 0, 0, 0};
    double n[3];
    jo_polytope_face(of_b ? t->b : t->a, face, n);
    for (int i = 0; of_b && i < 3; i++) n[i] = -n[i];
    try_axis(t, n, of_b ? JO_FACE_B : JO_FACE_A, of);
}

static void try_faces(search *t, int of_b)
{
    const jo_polytope *p = of_b ? t->b : t->a;
    for (int k = 0; k < p->faces; k++) {
        double d[3], local[3];   /* support of the other one, in the frame of the face: s(n) is at most its height above the face */
        jo_minus3d(d, of_b ? t->low : t->high, p->r);
        for (int i = 0; i < 3; i++) local[i] = p->R[i] * d[0] + p->R[3 + i] * d[1] + p->R[6 + i] * d[2];
        for (; k < p->faces; k++) {
            const jo_real *n = p->plane + 4 * k;
            if (local[0] * JO_RE(n[0]) + local[1] * JO_RE(n[1]) + local[2] * JO_RE(n[2]) - JO_RE(n[3]) > t->best->gap) break;
        }
        if (k < p->faces) try_face(t, k, of_b);
    }
}

/* products of the edges at the vertices of the closest points */
static void try_edges(search *t, int va, int vb, const double *towards)
{
    const jo_polytope *a = t->a, *b = t->b;
    double p[3], q[3], x[3], u[3], v[3], n[3];
    jo_polytope_vertex(a, va, p);
    jo_polytope_vertex(b, vb, q);
    for (int i = jo_whole(a->near[va]); i < jo_whole(a->near[va + 1]); i++) {
        jo_polytope_vertex(a, jo_whole(a->neighbour[i]), x);
        jo_minus3d(u, x, p);
        for (int k = jo_whole(b->near[vb]); k < jo_whole(b->near[vb + 1]); k++) {
            const int of[4] = {va, jo_whole(a->neighbour[i]), vb, jo_whole(b->neighbour[k])};
            jo_polytope_vertex(b, of[3], x);
            jo_minus3d(v, x, q);
            jo_cross3d(n, u, v);
            const double square = jo_dot3d(n, n);
            if (!(square > JO_PARALLEL * jo_dot3d(u, u) * jo_dot3d(v, v))) continue;
            const double sign = jo_dot3d(n, towards) < 0.0 ? -1.0 : 1.0, length = sqrt(square);
            for (int j = 0; j < 3; j++) n[j] *= sign / length;
            try_axis(t, n, JO_EDGES, of);
        }
    }
}

/* the edge at a vertex that is most nearly across n: its other end */
static int edge_across(const jo_polytope *p, int vertex, const double *n)
{
    double x[3], u[3], least = INFINITY;
    int found = vertex;
    for (int i = jo_whole(p->near[vertex]); i < jo_whole(p->near[vertex + 1]); i++) {
        const int end = jo_whole(p->neighbour[i]);
        jo_polytope_vertex(p, vertex, x);
        jo_polytope_vertex(p, end, u);
        jo_minus3d(u, u, x);
        const double along = fabs(jo_dot3d(n, u)) / sqrt(jo_dot3d(u, u));
        if (!(along < least)) continue;
        least = along;
        found = end;
    }
    return found;
}

/* An axis of two edges may have been tried with edges that are parallel to those at its supports: it is the latter that touch. */
static void name_edges(const search *t, jo_separated *y)
{
    if (y->kind != JO_EDGES) return;
    y->of[0] = t->va;
    y->of[1] = edge_across(t->a, t->va, y->normal);
    y->of[2] = t->vb;
    y->of[3] = edge_across(t->b, t->vb, y->normal);
}

/* starts with the supports in direction n */
static void start_along(search *t, const double *n, int va, int vb)
{
    const double back[3] = {-n[0], -n[1], -n[2]};
    t->va = jo_polytope_support(t->a, n, va);
    t->vb = jo_polytope_support(t->b, back, vb);
    jo_polytope_vertex(t->a, t->va, t->low);
    jo_polytope_vertex(t->b, t->vb, t->high);
}

/* largest s(n) among the faces of both, and the edges near the closest points s and the supports of the best axis */
static void overlap(search *t, double size, const jo_simplex *s)
{
    jo_separated *y = t->best, other;
    try_faces(t, 0);
    other = *y;
    t->best = &other;
    other.gap += JO_SAME_AXIS * size;
    try_faces(t, 1);
    if (other.kind == JO_FACE_B) *y = other;
    other = *y;
    for (int i = 0; i < s->count; i++)
        for (int k = 0; k < s->count; k++) try_edges(t, s->a[i], s->b[k], s->v);
    for (int i = -1, k = -1; i != t->va || k != t->vb;) {
        i = t->va;
        k = t->vb;
        try_edges(t, i, k, other.normal);
    }
    name_edges(t, &other);
    const int same = y->gap > -INFINITY && jo_dot3d(y->normal, other.normal) > JO_SAME_NORMAL;
    y->gap = other.gap;
    if (other.kind == JO_EDGES && !same) *y = other;
    y->edges = other.kind == JO_EDGES;
    for (int i = 0; i < 4; i++) y->edge[i] = other.of[i];
    for (int i = 0; i < 3; i++) y->across[i] = other.normal[i];
    y->vertex[0] = t->va;
    y->vertex[1] = t->vb;
}

/* from the closest points of the largest smaller copies that are apart */
static void overlap_anywhere(const jo_polytope *a, const jo_polytope *b, double size, jo_separated *y)
{
    jo_simplex s;
    search t = {a, b, 0, 0, {0.0}, {0.0}, y};
    double d = 0.0;
    for (int k = 0; k < JO_SMALLER && !(d > JO_APART * size); k++) d = jo_closest_points(a, b, smaller[k], &s);
    if (!(jo_unit3d(s.v) > 0.0)) s.v[2] = 1.0;   /* in each other's centre */
    start_along(&t, s.v, s.a[0], s.b[0]);
    y->gap = -INFINITY;
    overlap(&t, size, &s);
}

/* from the axis of a face that was the best one before; whether they overlap */
static int overlap_again(const jo_polytope *a, const jo_polytope *b, double size, const jo_separated *before, jo_separated *y)
{
    jo_simplex none;
    search t = {a, b, 0, 0, {0.0}, {0.0}, y};
    const int of_b = before->kind == JO_FACE_B;
    double n[3];
    jo_polytope_face(of_b ? b : a, before->of[0], n);
    for (int i = 0; of_b && i < 3; i++) n[i] = -n[i];
    start_along(&t, n, 0, 0);
    y->gap = -INFINITY;
    try_face(&t, before->of[0], of_b);
    none.count = 0;
    overlap(&t, size, &none);
    return y->gap <= 0.0;
}

/* above a half-space: its only face */
static void above(const jo_polytope *a, const jo_polytope *b, jo_separated *y)
{
    double q[3];
    const double offset = jo_polytope_face(a, 0, y->normal), back[3] = {-y->normal[0], -y->normal[1], -y->normal[2]};
    jo_polytope_vertex(b, jo_polytope_support(b, back, 0), q);
    y->gap = jo_dot3d(y->normal, q) - offset;
    y->kind = JO_FACE_A;
    y->of[0] = 0;
    y->vertex[0] = 0;
    y->vertex[1] = jo_polytope_support(b, back, 0);
}

/* the face of p whose normal is n, or -1 */
static int face_along(const jo_polytope *p, const double *n, double sign)
{
    double m[3];
    for (int i = 0; i < p->faces; i++) {
        jo_polytope_face(p, i, m);
        if (sign * jo_dot3d(m, n) > 1.0 - JO_PARALLEL) return i;
    }
    return -1;
}

/* vertices that differ, in v (2); their number, 3 for more */
static int differing(const int *of, int count, int *v)
{
    int found = 0;
    for (int k = 0; k < count; k++) {
        if (found > 0 && of[k] == v[0]) continue;
        if (found > 1 && of[k] == v[1]) continue;
        if (found == 2) return 3;
        v[found++] = of[k];
    }
    if (found == 1) v[1] = v[0];
    return found;
}

void jo_separation(const jo_polytope *a, const jo_polytope *b, const jo_separated *before, jo_separated *y)
{
    jo_simplex s;
    y->edges = 0;
    if (a->round || b->round) {
        jo_round_separation(a, b, y);
        return;
    }
    y->kind = JO_CLOSEST_POINTS;
    y->round = 0;
    for (int i = 0; i < 4; i++) y->of[i] = 0;
    for (int i = 0; i < 2; i++) y->count[i] = y->vertex[i] = 0;
    if (!a->vertices) {
        above(a, b, y);
        return;
    }
    const double size = size_of(a) + size_of(b);
    if (before && (before->kind == JO_FACE_A || before->kind == JO_FACE_B) && overlap_again(a, b, size, before, y)) return;
    y->kind = JO_CLOSEST_POINTS;
    y->gap = jo_closest_points(a, b, 1.0, &s);
    if (!(y->gap > JO_APART * size) && (a->vertices > 1 || b->vertices > 1)) {
        overlap_anywhere(a, b, size, y);
        return;
    }
    y->vertex[0] = s.a[0];
    y->vertex[1] = s.b[0];
    for (int i = 0; i < 3; i++) y->normal[i] = s.v[i];
    if (!(jo_unit3d(y->normal) > 0.0)) y->normal[2] = 1.0;
    const int face_a = face_along(a, y->normal, 1.0), face_b = face_along(b, y->normal, -1.0);
    if (face_a >= 0) {
        y->kind = JO_FACE_A;
        y->of[0] = face_a;
    } else if (face_b >= 0) {
        y->kind = JO_FACE_B;
        y->of[0] = face_b;
    } else {
        y->count[0] = differing(s.a, s.count, y->of);
        y->count[1] = differing(s.b, s.count, y->of + 2);
    }
}

/* vertex from which a support is looked for: one of a feature of dimension up to 1, or a corner of a face */
static int vertex_of(const jo_polytope *p, int dimension, int of)
{
    return dimension < 2 ? of : p->vertices ? jo_polytope_corner(p, of, 0) : 0;
}

int jo_still_separated(const jo_polytope *a, const jo_polytope *b, double code, const jo_real *r, const jo_real *R, jo_separated *y)
{
    const jo_feature_pair f = jo_feature_of(code);
    jo_feature g;
    double p[3], q[3], back[3];
    jo_feature_at(a, b, r, R, jo_same(code), &g);
    const double gap = JO_RE(g.gap);
    if (!(gap > 0.0 && gap < INFINITY)) return 0;
    for (int i = 0; i < 3; i++) back[i] = -(y->normal[i] = JO_RE(g.normal[i]));
    y->round = y->edges = 0;
    y->kind = f.kind == JO_FACE_VERTEX ? JO_FACE_A : f.kind == JO_VERTEX_FACE ? JO_FACE_B : JO_CLOSEST_POINTS;
    for (int i = 0; i < 2; i++) {
        y->of[i] = f.a[i];
        y->of[2 + i] = f.b[i];
    }
    if (y->kind == JO_FACE_B) y->of[0] = f.b[0];
    y->count[0] = 1 + f.kind / 3;
    y->count[1] = 1 + f.kind % 3;
    y->vertex[0] = a->vertices ? jo_polytope_support(a, y->normal, vertex_of(a, f.kind / 3, f.a[0])) : 0;
    y->vertex[1] = jo_polytope_support(b, back, vertex_of(b, f.kind % 3, f.b[0]));
    if (a->vertices) jo_polytope_vertex(a, y->vertex[0], p);
    else for (int i = 0; i < 3; i++) p[i] = 0.0;   /* a half-space: its plane z = 0 */
    jo_polytope_vertex(b, y->vertex[1], q);
    jo_minus3d(q, q, p);
    y->gap = jo_dot3d(y->normal, q);
    return y->gap >= gap - JO_SAME_GAP * gap;
}

double jo_separation_code(const jo_separated *s)
{
    if (s->round) return 0.0;
    jo_feature_pair f = {3 * (s->count[0] > 1) + (s->count[1] > 1), {s->of[0], s->of[1]}, {s->of[2], s->of[3]}};
    if (s->kind == JO_CLOSEST_POINTS) return s->count[0] > 2 || s->count[1] > 2 ? 0.0 : jo_feature_code(&f);
    const int of_b = s->kind == JO_FACE_B;
    const jo_feature_pair face = {of_b ? JO_VERTEX_FACE : JO_FACE_VERTEX, {s->vertex[0], 0}, {s->vertex[1], 0}};
    if (s->kind == JO_EDGES) return 0.0;
    f = face;
    (of_b ? f.b : f.a)[0] = s->of[0];
    return jo_feature_code(&f);
}

double jo_separation_at_least(const jo_polytope *a, const jo_polytope *b)
{
    double n[3], p[3], q[3];
    if (!a->vertices) {
        jo_separated y;
        above(a, b, &y);
        return y.gap;
    }
    jo_polytope_vertex(a, -1, p);
    jo_polytope_vertex(b, -1, q);
    jo_minus3d(n, q, p);
    if (!(jo_unit3d(n) > 0.0)) return -INFINITY;
    const double back[3] = {-n[0], -n[1], -n[2]};
    jo_polytope_extreme(a, n, 0, p);
    jo_polytope_extreme(b, back, 0, q);
    jo_minus3d(p, q, p);
    return jo_dot3d(n, p);
}

/* the same for a surface of triangles in place of a */
static void mesh_distance(const jo_real *data, const jo_real *r, const jo_real *R, double *y)
{
    jo_mesh m;
    jo_polytope b;
    jo_mesh_gap found;
    jo_real radius;
    jo_polytope_read(jo_mesh_read(data, &m, &radius), &b);
    jo_polytope_place(&b, r, R);
    jo_mesh_distance(&m, &b, JO_RE(radius + b.radius), &found);
    for (int i = 0; i < 3; i++) y[i] = found.normal[i];
    y[3] = found.gap;
}

void jo_pair_distance(const jo_real *data, const jo_real *r, const jo_real *R, double *y)
{
    jo_polytope a, b;
    jo_separated s;
    if (jo_is_mesh(data)) {
        mesh_distance(data, r, R, y);
        return;
    }
    jo_polytope_read(jo_polytope_read(data, &a), &b);
    jo_polytope_place(&a, 0, 0);
    jo_polytope_place(&b, r, R);
    jo_separation(&a, &b, 0, &s);
    for (int i = 0; i < 3; i++) y[i] = s.normal[i];
    y[3] = s.gap - JO_RE(a.radius + b.radius);
}
