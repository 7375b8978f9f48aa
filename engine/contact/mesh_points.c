/* mesh_points.c - points at which spheres about the vertices of a polytope touch a surface of triangles.
 *
 * A point keeps its identity by descent from the triangle on which it was; points that come to the same place are one. Others appear where a
 * sphere overlaps the surface at another local minimum of the distance, which is found from outside alone: what has been in front of a thin
 * plate stays in front of it, however deep it is. */
#include "contact/mesh.h"

#define JO_MESH_FAR 1.5     /* search distance for further contacts over the radii: steps of up to the radius over the speed are proven at once */
#define JO_SAME_POINT 0.99984770   /* cosine of 1 degree, below which two points of one sphere are one */

/* the points among `code` of one vertex: their closest points; their number */
static int known_feet(const jo_mesh *m, const double *code, int count, int vertex, const double *c, jo_mesh_foot *known)
{
    int n = 0;
    for (int i = 0; i < count; i++) {
        const jo_mesh_point p = jo_mesh_point_of(code[i]);
        if (p.vertex == vertex) jo_mesh_descend(m, p.triangle, c, &known[n++]);
    }
    return n;
}

/* whether the closest point y of c is one of the known ones, seen from c */
static int is_known(const jo_mesh *m, const double *c, const jo_mesh_foot *y, const jo_mesh_foot *known, int count)
{
    double n[3], k[3];
    jo_mesh_direction(m, y, c, n);
    for (int i = 0; i < count; i++) {
        jo_mesh_direction(m, known + i, c, k);
        if (fabs(jo_dot3d(n, k)) > JO_SAME_POINT) return 1;   /* also behind the surface */
    }
    return 0;
}

/* signed distance of c from its closest point; an open surface has no inside */
static double signed_distance(const jo_mesh *m, const double *c, const jo_mesh_foot *y)
{
    const double d = sqrt(y->square);
    return m->closed && jo_mesh_outside(m, y, c) < 0.0 ? -d : d;
}

/* largest distance of a vertex of b from its centre */
static double size_about_centre(const jo_polytope *b, const double *centre)
{
    double most = 0.0, x[3];
    for (int i = 0; i < b->vertices; i++) {
        jo_polytope_vertex(b, i, x);
        jo_minus3d(x, x, centre);
        most = fmax(most, jo_dot3d(x, x));
    }
    return sqrt(most);
}

/* a bound of the distance of a polytope that is far away: that of its centre less its size; 0: it is not */
static int is_far(const jo_mesh *m, const jo_polytope *b, double radius, jo_mesh_gap *y)
{
    double c[3];
    jo_mesh_foot foot;
    if (b->vertices < 2) return 0;
    jo_polytope_vertex(b, -1, c);
    const double size = size_about_centre(b, c);
    if (!jo_mesh_nearest(m, c, -1, INFINITY, &foot)) return 0;
    y->gap = signed_distance(m, c, &foot) - size - radius;
    jo_mesh_direction(m, &foot, c, y->normal);
    return y->gap > size;
}

static void no_gap(jo_mesh_gap *y)
{
    y->gap = y->clear = y->curvature = INFINITY;
    y->part = 0;
    for (int i = 0; i < 3; i++) y->normal[i] = 0.0;
}

void jo_mesh_distance(const jo_mesh *m, const jo_polytope *b, double radius, jo_mesh_gap *y)
{
    no_gap(y);
    if (is_far(m, b, radius, y)) return;
    y->gap = INFINITY;
    for (int i = 0; i < b->vertices; i++) {
        double c[3];
        jo_mesh_foot foot;
        jo_polytope_vertex(b, i, c);
        if (!jo_mesh_nearest(m, c, -1, INFINITY, &foot)) continue;
        const double gap = signed_distance(m, c, &foot) - radius;
        if (!(gap < y->gap)) continue;
        y->gap = gap;
        jo_mesh_direction(m, &foot, c, y->normal);
        for (int k = 0; k < 3 && gap + radius < 0.0; k++) y->normal[k] = -y->normal[k];
    }
}

/* a new point at y */
static double new_point(const jo_mesh *m, const jo_mesh_foot *y, const double *c, int vertex)
{
    jo_mesh_point p = {y->triangle, vertex, JO_MESH_FRONT};
    if (jo_mesh_is_rim(m, y)) p.side = JO_MESH_FREE;
    else if (!m->closed && jo_mesh_outside(m, y, c) < 0.0) p.side = JO_MESH_BEHIND;
    return jo_mesh_code(&p);
}

/* Depth of the point with a code, whose sphere is about c; `code` becomes that of its present place. */
static double follow(const jo_mesh *m, const double *c, double radius, double *code, jo_mesh_foot *y)
{
    jo_mesh_point p = jo_mesh_point_of(*code);
    jo_mesh_descend(m, p.triangle, c, y);
    const double out = jo_mesh_outside(m, y, c), d = sqrt(y->square);
    p.triangle = y->triangle;
    if (jo_mesh_is_rim(m, y)) p.side = JO_MESH_FREE;
    else if (p.side == JO_MESH_FREE) p.side = out < 0.0 ? JO_MESH_BEHIND : JO_MESH_FRONT;
    *code = jo_mesh_code(&p);
    const int inside = p.side == JO_MESH_FREE ? 0 : p.side == JO_MESH_BEHIND ? out > 0.0 : out < 0.0;
    return radius - (inside ? -d : d);
}

/* The points that overlap: those of `code` that still do, then new ones. from[i]: the old one, or -1. Returns their number. */
int jo_mesh_points(const jo_mesh *m, const jo_polytope *b, double radius, const double *code, int count, double *found, int *from)
{
    int n = 0;
    double c[3];
    jo_mesh_foot known[JO_MESH_POINTS], list[JO_MESH_POINTS];
    for (int i = 0; i < count && n < JO_MESH_POINTS; i++) {   /* first the old ones of all vertices: they keep their places */
        const int vertex = jo_mesh_point_of(code[i]).vertex;
        double next = code[i];
        int same = 0;
        jo_polytope_vertex(b, vertex, c);
        if (!(follow(m, c, radius, &next, &known[0]) > 0.0)) continue;
        for (int k = 0; k < n && !same; k++) {
            const jo_mesh_point p = jo_mesh_point_of(found[k]);
            if (p.vertex != vertex) continue;
            jo_mesh_descend(m, p.triangle, c, &list[0]);
            same = is_known(m, c, &known[0], &list[0], 1);
        }
        if (same) continue;
        from[n] = i;
        found[n++] = next;
    }
    const int old = n;
    for (int i = 0; i < b->vertices && n < JO_MESH_POINTS; i++) {
        jo_polytope_vertex(b, i, c);
        const int knows = known_feet(m, found, old, i, c, known);
        int minima = jo_mesh_minima(m, c, radius, list);
        if (!knows && !minima && m->closed && jo_mesh_nearest(m, c, -1, INFINITY, list)) minima = signed_distance(m, c, list) < 0.0;
        for (int k = 0; k < minima && n < JO_MESH_POINTS; k++) {
            if (is_known(m, c, list + k, known, knows)) continue;
            from[n] = -1;
            found[n++] = new_point(m, list + k, c, i);
        }
    }
    return n;
}

double jo_mesh_unlisted(const jo_mesh *m, const jo_polytope *b, double radius, const double *code, int count)
{
    double least = INFINITY, c[3];
    jo_mesh_foot known[JO_MESH_POINTS], list[JO_MESH_POINTS];
    for (int i = 0; i < b->vertices; i++) {
        jo_polytope_vertex(b, i, c);
        const int knows = known_feet(m, code, count, i, c, known);
        if (!knows) {
            if (jo_mesh_nearest(m, c, -1, INFINITY, list)) least = fmin(least, signed_distance(m, c, list) - radius);
            continue;
        }
        const int minima = jo_mesh_minima(m, c, radius, list);
        for (int k = 0; k < minima; k++)
            if (!is_known(m, c, list + k, known, knows)) least = fmin(least, sqrt(list[k].square) - radius);
    }
    return least;
}

/* The place that a sphere about c touches next, beside those that it touches: signed distance, or the search distance if there is none. */
typedef struct { double c[3], distance; jo_mesh_foot known[JO_MESH_POINTS + 1], foot; int knows, any; } mesh_next;

static void find_next(const jo_mesh *m, double radius, mesh_next *t)
{
    const double limit = t->knows ? JO_MESH_FAR * radius : INFINITY;
    t->any = t->knows ? jo_mesh_other(m, t->c, t->known, t->knows, limit, &t->foot) : jo_mesh_nearest(m, t->c, -1, limit, &t->foot);
    t->distance = !t->any ? limit : t->knows ? sqrt(t->foot.square) : signed_distance(m, t->c, &t->foot);
}

/* part of the surface of the next place */
static int part_of(const jo_mesh *m, const mesh_next *t)
{
    if (!t->any) return 0;
    return !t->knows && jo_mesh_is_flat(m, &t->foot) ? 1 + jo_whole(m->group[t->foot.triangle]) : -1 - jo_whole(m->patch[t->foot.triangle]);
}

/* distance of what is neither touched nor of this part */
static double beside(const jo_mesh *m, mesh_next *t, int part)
{
    jo_mesh_foot y;
    if (!t->any || part_of(m, t) != part) return t->distance;
    if (part > 0) return jo_mesh_nearest(m, t->c, part - 1, INFINITY, &y) ? sqrt(y.square) : INFINITY;
    const double limit = JO_MESH_FAR * sqrt(t->foot.square);
    t->known[t->knows] = t->foot;
    return jo_mesh_other(m, t->c, t->known, t->knows + 1, limit, &y) ? sqrt(y.square) : limit;
}

/* The distance from a plane has no curvature, from a part that is not concave at most the inverse of the distance. A gap of another sphere, and
 * one of another part, is in `clear`. */
void jo_mesh_clearance(const jo_mesh *m, const jo_polytope *b, double radius, const double *code, int count, jo_mesh_gap *y)
{
    mesh_next t;
    no_gap(y);
    if (!count && is_far(m, b, radius, y)) return;
    y->gap = INFINITY;
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < b->vertices; i++) {
            if (b->vertices > 1 || !pass) {
                jo_polytope_vertex(b, i, t.c);
                t.knows = known_feet(m, code, count, i, t.c, t.known);
                if (t.knows && !(radius > 0.0)) continue;
                find_next(m, radius, &t);
            }
            if (pass) {
                y->clear = fmin(y->clear, beside(m, &t, y->part) - radius);
            } else if (t.distance - radius < y->gap) {
                y->gap = t.distance - radius;
                y->part = part_of(m, &t);
                y->curvature = y->part > 0 ? 0.0 : t.any && t.distance > 0.0 ? 1.0 / t.distance : INFINITY;
                if (t.any) jo_mesh_direction(m, &t.foot, t.c, y->normal);
            }
        }
}

/* vertex of a point in the frame of the surface */
void jo_mesh_point_feature(const jo_mesh *m, const jo_polytope *b, const jo_real *r, const jo_real *R, double code, jo_feature *y)
{
    const jo_mesh_point p = jo_mesh_point_of(code);
    jo_mesh_foot foot;
    jo_real x[3];
    jo_mul3(x, R, b->vertex + 3 * p.vertex);
    jo_add3(x, r);
    const double c[3] = {JO_RE(x[0]), JO_RE(x[1]), JO_RE(x[2])};
    jo_mesh_descend(m, p.triangle, c, &foot);
    jo_mesh_feature(m, &foot, p.side, x, y);
}
