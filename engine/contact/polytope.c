/* polytope.c - vertices, faces and supports of a convex polytope in a frame. */
#include "contact/polytope.h"

enum { JO_FEW_VERTICES = 12 };   /* up to which the support is found by looking at all of them */

/* data: numbers of vertices, faces, corners of faces and neighbours, radius, centre (3), roundness and its sizes (3); vertices (3 each), planes (4
 * each: normal, offset), first corner of each face and the end, corners (vertices, counterclockwise from outside), first neighbour of each vertex
 * and the end, neighbours */
const jo_real *jo_polytope_read(const jo_real *data, jo_polytope *p)
{
    p->vertices = jo_whole(data[0]);
    p->faces = jo_whole(data[1]);
    p->radius = data[4];
    p->centre = data + 5;
    p->round = jo_whole(data[8]);
    p->size = data + 9;
    p->vertex = data + 12;
    p->plane = p->vertex + 3 * p->vertices;
    p->first = p->plane + 4 * p->faces;
    p->corner = p->first + p->faces + 1;
    p->near = p->corner + jo_whole(data[2]);
    p->neighbour = p->near + p->vertices + 1;
    return p->neighbour + jo_whole(data[3]);
}

void jo_polytope_place(jo_polytope *p, const jo_real *r, const jo_real *R)
{
    for (int i = 0; i < 3; i++) p->r[i] = r ? JO_RE(r[i]) : 0.0;
    for (int i = 0; i < 9; i++) p->R[i] = R ? JO_RE(R[i]) : i % 4 == 0;
}

static void moved(const jo_polytope *p, const jo_real *x, double *y)
{
    for (int i = 0; i < 3; i++) y[i] = p->r[i] + p->R[3 * i] * JO_RE(x[0]) + p->R[3 * i + 1] * JO_RE(x[1]) + p->R[3 * i + 2] * JO_RE(x[2]);
}

void jo_polytope_vertex(const jo_polytope *p, int i, double *y) { moved(p, i < 0 ? p->centre : p->vertex + 3 * i, y); }

double jo_polytope_face(const jo_polytope *p, int i, double *n)
{
    const jo_real *x = p->plane + 4 * i;
    for (int k = 0; k < 3; k++) n[k] = p->R[3 * k] * JO_RE(x[0]) + p->R[3 * k + 1] * JO_RE(x[1]) + p->R[3 * k + 2] * JO_RE(x[2]);
    return JO_RE(x[3]) + jo_dot3d(n, p->r);
}

static double along(const jo_polytope *p, const double *n, int i)
{
    const jo_real *x = p->vertex + 3 * i;
    return n[0] * JO_RE(x[0]) + n[1] * JO_RE(x[1]) + n[2] * JO_RE(x[2]);
}

int jo_polytope_support(const jo_polytope *p, const double *n, int from)
{
    double local[3];
    for (int i = 0; i < 3; i++) local[i] = p->R[i] * n[0] + p->R[3 + i] * n[1] + p->R[6 + i] * n[2];
    int best = from > 0 ? from : 0;
    double most = along(p, local, best);
    if (p->vertices <= JO_FEW_VERTICES) {
        for (int i = 0; i < p->vertices; i++) {
            const double x = along(p, local, i);
            if (x > most) {
                most = x;
                best = i;
            }
        }
        return best;
    }
    for (int at = -1; at != best;) {   /* climb along edges */
        at = best;
        for (int k = jo_whole(p->near[at]); k < jo_whole(p->near[at + 1]); k++) {
            const int i = jo_whole(p->neighbour[k]);
            const double x = along(p, local, i);
            if (x > most) {
                most = x;
                best = i;
            }
        }
    }
    return best;
}

int jo_polytope_corners(const jo_polytope *p, int face) { return jo_whole(p->first[face + 1]) - jo_whole(p->first[face]); }

int jo_polytope_corner(const jo_polytope *p, int face, int i)
{
    return jo_whole(p->corner[jo_whole(p->first[face]) + i % jo_polytope_corners(p, face)]);
}

/* place of a round shape that is farthest along m, and its height there; resolved in its own frame */
static double round_extreme(const jo_polytope *p, const double *m, double *y)
{
    const double a = JO_RE(p->size[0]), b = JO_RE(p->size[1]), c = JO_RE(p->size[2]);
    if (p->round == JO_ROUND_ELLIPSOID) {
        const double D[3] = {a * a, b * b, c * c}, h = sqrt(D[0] * m[0] * m[0] + D[1] * m[1] * m[1] + D[2] * m[2] * m[2]);
        for (int i = 0; i < 3; i++) y[i] = D[i] * m[i] / h;
        return h;
    }
    const double across = sqrt(m[0] * m[0] + m[1] * m[1]);
    y[0] = across > 0.0 ? a * m[0] / across : a;
    y[1] = across > 0.0 ? a * m[1] / across : 0.0;
    y[2] = m[2] < 0.0 ? -b : b;
    return a * across + y[2] * m[2];
}

int jo_polytope_extreme(const jo_polytope *p, const double *n, int from, double *y)
{
    if (!p->round) {
        const int i = jo_polytope_support(p, n, from);
        jo_polytope_vertex(p, i, y);
        return i;
    }
    double m[3], x[3];
    for (int i = 0; i < 3; i++) m[i] = p->R[i] * n[0] + p->R[3 + i] * n[1] + p->R[6 + i] * n[2];
    round_extreme(p, m, x);
    for (int i = 0; i < 3; i++) y[i] = p->r[i] + p->R[3 * i] * x[0] + p->R[3 * i + 1] * x[1] + p->R[3 * i + 2] * x[2];
    return 0;
}

double jo_polytope_height(const jo_polytope *p, const double *n)
{
    double x[3], most = -INFINITY;
    if (p->round) return round_extreme(p, n, x);
    for (int i = 0; i < p->vertices; i++) most = fmax(most, along(p, n, i));
    return most;
}

double jo_polytope_reach(const jo_polytope *p)
{
    double most = 0.0;
    if (p->round == JO_ROUND_CYLINDER) return hypot(JO_RE(p->size[0]), JO_RE(p->size[1]));
    for (int i = 0; i < 3 && p->round; i++) most = fmax(most, JO_RE(p->size[i]));
    for (int i = 0; i < p->vertices && !p->round; i++) most = fmax(most, jo_length(p->vertex + 3 * i, 3));
    return most;
}

/* smallest -n . u of the edges u at an end of the edge (i, k), or at the vertex i = k, but for the edge itself */
double jo_polytope_rises(const jo_polytope *p, int i, int k, const double *n)
{
    const int ends[2] = {i, k};
    double least = 1.0, x[3], u[3];
    for (int e = 0; e < 1 + (i != k); e++) {
        jo_polytope_vertex(p, ends[e], x);
        for (int j = jo_whole(p->near[ends[e]]); j < jo_whole(p->near[ends[e] + 1]); j++) {
            const int other = jo_whole(p->neighbour[j]);
            if (other == ends[1 - e]) continue;
            jo_polytope_vertex(p, other, u);
            jo_minus3d(u, u, x);
            jo_unit3d(u);
            least = fmin(least, -jo_dot3d(n, u));
        }
    }
    return least;
}

/* length of the edge (i, k) on both sides of the place of it that is nearest to x: the shorter one */
double jo_polytope_room(const jo_polytope *p, int i, int k, const double *x)
{
    double at[3], e[3];
    jo_polytope_vertex(p, i, at);
    jo_polytope_vertex(p, k, e);
    jo_minus3d(e, e, at);
    const double length = jo_unit3d(e);
    jo_minus3d(at, x, at);
    return fmin(jo_dot3d(at, e), length - jo_dot3d(at, e));
}
