/* polytope.c - vertices, faces and supports of a convex polytope in a frame. */
#include "contact/polytope.h"

enum { JO_FEW_VERTICES = 12 };   /* up to which the support is found by looking at all of them */

/* data: numbers of vertices, faces, corners of faces and neighbours, radius, centre (3); vertices (3 each), planes (4 each: normal,
 * offset), first corner of each face and the end, corners (vertices, counterclockwise from outside), first neighbour of each vertex and the
 * end, neighbours */
const jo_real *jo_polytope_read(const jo_real *data, jo_polytope *p)
{
    p->vertices = jo_whole(data[0]);
    p->faces = jo_whole(data[1]);
    p->radius = data[4];
    p->centre = data + 5;
    p->vertex = data + 8;
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
