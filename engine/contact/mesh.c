/* mesh.c - closest point of a surface of triangles, by its neighbours, and the feature on which it lies.
 *
 * The closest point of a convex or flat part is unique; where the surface is concave, each of its parts has one. A point of contact descends
 * from the triangle of the last step to the local minimum of the distance: it passes edges and corners without a step in the distance. The
 * triangles of one plane have one normal, so that their edges are not felt; on other edges and corners the normal is the direction from
 * the closest point, which lies within the cone of the normals of the triangles that meet there. */
#include "contact/mesh.h"

/* data: mark, numbers of vertices, triangles and groups, radius (half the thickness), whether it is closed, number of leaves (a power of 2);
 * vertices (3 each), planes of the groups (4 each: normal, offset), corners (3 each, counterclockwise in front), neighbours (3 each: triangle
 * beyond the edge from corner i to i + 1, -1 none), group and patch of each triangle, first triangle about each vertex and the end, these
 * triangles, boxes of the tree (6 each: least and largest x, y, z; of node i those of nodes 2 i, 2 i + 1; leaves have JO_MESH_LEAF triangles) */
const jo_real *jo_mesh_read(const jo_real *data, jo_mesh *m, jo_real *radius)
{
    m->vertices = jo_whole(data[1]);
    m->triangles = jo_whole(data[2]);
    m->groups = jo_whole(data[3]);
    *radius = data[4];
    m->closed = jo_whole(data[5]);
    m->leaves = jo_whole(data[6]);
    m->vertex = data + 7;
    m->plane = m->vertex + 3 * m->vertices;
    m->corner = m->plane + 4 * m->groups;
    m->neighbour = m->corner + 3 * m->triangles;
    m->group = m->neighbour + 3 * m->triangles;
    m->patch = m->group + m->triangles;
    m->first = m->patch + m->triangles;
    m->fan = m->first + m->vertices + 1;
    m->box = m->fan + 3 * m->triangles;
    return m->box + 12 * m->leaves;
}

static void mesh_corner(const jo_mesh *m, int triangle, int i, double *x)
{
    const jo_real *v = m->vertex + 3 * jo_whole(m->corner[3 * triangle + i % 3]);
    for (int k = 0; k < 3; k++) x[k] = JO_RE(v[k]);
}

/* normal of a triangle; returns the height of c above its plane */
static double mesh_plane(const jo_mesh *m, int triangle, const double *c, double *n)
{
    const jo_real *x = m->plane + 4 * jo_whole(m->group[triangle]);
    for (int k = 0; k < 3; k++) n[k] = JO_RE(x[k]);
    return jo_dot3d(n, c) - JO_RE(x[3]);
}

/* on the edge from corner i, at the share t of its length */
static void on_mesh_edge(const jo_mesh *m, jo_mesh_foot *y, int i, double t, const double *c)
{
    double p[3], q[3], d[3];
    mesh_corner(m, y->triangle, i, p);
    mesh_corner(m, y->triangle, i + 1, q);
    y->part = t <= 0.0 ? JO_ON_CORNER + i : t >= 1.0 ? JO_ON_CORNER + (i + 1) % 3 : JO_ON_EDGE + i;
    for (int k = 0; k < 3; k++) y->at[k] = t <= 0.0 ? p[k] : t >= 1.0 ? q[k] : p[k] + t * (q[k] - p[k]);
    jo_minus3d(d, c, y->at);
    y->square = jo_dot3d(d, d);
}

/* Regions of Ericson, Real-Time Collision Detection (2005), section 5.1.5: c lies beyond an edge if it is on the outer side of the plane through
 * the edge and the normal. Of the edges beyond which it lies the nearest counts. */
void jo_mesh_closest(const jo_mesh *m, int triangle, const double *c, jo_mesh_foot *y)
{
    double n[3], p[3][3], e[3][3], r[3], out[3];
    int beyond = 0;
    const double height = mesh_plane(m, triangle, c, n);
    y->triangle = triangle;
    for (int i = 0; i < 3; i++) mesh_corner(m, triangle, i, p[i]);
    for (int i = 0; i < 3; i++) {
        jo_minus3d(e[i], p[(i + 1) % 3], p[i]);
        jo_minus3d(r, c, p[i]);
        jo_cross3d(out, e[i], n);
        if (!(jo_dot3d(out, r) > 0.0)) continue;
        jo_mesh_foot other = *y;
        on_mesh_edge(m, &other, i, jo_dot3d(e[i], r) / jo_dot3d(e[i], e[i]), c);
        if (!beyond++ || other.square < y->square) *y = other;
    }
    if (beyond) return;
    y->part = JO_ON_FACE;
    y->square = height * height;
    for (int k = 0; k < 3; k++) y->at[k] = c[k] - height * n[k];
}

static void keep_closer(const jo_mesh *m, int triangle, const double *c, jo_mesh_foot *best)
{
    jo_mesh_foot next;
    jo_mesh_closest(m, triangle, c, &next);
    if (next.square < best->square) *best = next;
}

/* the closest point of the triangles that meet at y */
static void look_around(const jo_mesh *m, const jo_mesh_foot *y, const double *c, jo_mesh_foot *best)
{
    *best = *y;
    if (y->part >= JO_ON_CORNER) {
        const int v = jo_whole(m->corner[3 * y->triangle + y->part - JO_ON_CORNER]);
        for (int k = jo_whole(m->first[v]); k < jo_whole(m->first[v + 1]); k++) {
            const int other = jo_whole(m->fan[k]);
            if (other != y->triangle) keep_closer(m, other, c, best);
        }
    } else if (y->part >= JO_ON_EDGE) {
        const int other = jo_whole(m->neighbour[3 * y->triangle + y->part - JO_ON_EDGE]);
        if (other >= 0) keep_closer(m, other, c, best);
    }
}

int jo_mesh_is_minimum(const jo_mesh *m, const jo_mesh_foot *y, const double *c)
{
    jo_mesh_foot best;
    look_around(m, y, c, &best);
    return !(best.square < y->square);
}

void jo_mesh_descend(const jo_mesh *m, int triangle, const double *c, jo_mesh_foot *y)
{
    jo_mesh_foot best;
    jo_mesh_closest(m, triangle, c, y);
    for (look_around(m, y, c, &best); best.square < y->square; look_around(m, y, c, &best)) *y = best;   /* ends, as the distance falls */
}

/* angle of a triangle at its corner i */
static double mesh_angle(const jo_mesh *m, int triangle, int i)
{
    double p[3], u[3], v[3], n[3];
    mesh_corner(m, triangle, i, p);
    mesh_corner(m, triangle, i + 1, u);
    mesh_corner(m, triangle, i + 2, v);
    jo_minus3d(u, u, p);
    jo_minus3d(v, v, p);
    jo_cross3d(n, u, v);
    return atan2(sqrt(jo_dot3d(n, n)), jo_dot3d(u, v));
}

/* corner of a triangle at vertex v */
static int mesh_corner_at(const jo_mesh *m, int triangle, int v)
{
    for (int i = 0; i < 2; i++)
        if (jo_whole(m->corner[3 * triangle + i]) == v) return i;
    return 2;
}

/* Mean normal at y, at a corner weighted by the angles of its triangles (Baerentzen and Aanaes, IEEE Transactions on Visualization and Computer
 * Graphics 11 (2005), 243-253): the side of the surface on which c lies is that of this normal. */
static void mean_normal(const jo_mesh *m, const jo_mesh_foot *y, double *N)
{
    double n[3];
    mesh_plane(m, y->triangle, y->at, N);
    if (y->part >= JO_ON_CORNER) {
        const int v = jo_whole(m->corner[3 * y->triangle + y->part - JO_ON_CORNER]);
        for (int k = 0; k < 3; k++) N[k] = 0.0;
        for (int k = jo_whole(m->first[v]); k < jo_whole(m->first[v + 1]); k++) {
            const int other = jo_whole(m->fan[k]);
            const double angle = mesh_angle(m, other, mesh_corner_at(m, other, v));
            mesh_plane(m, other, y->at, n);
            for (int i = 0; i < 3; i++) N[i] += angle * n[i];
        }
    } else if (y->part >= JO_ON_EDGE) {
        const int other = jo_whole(m->neighbour[3 * y->triangle + y->part - JO_ON_EDGE]);
        if (other < 0) return;
        mesh_plane(m, other, y->at, n);
        for (int i = 0; i < 3; i++) N[i] += n[i];
    }
}

double jo_mesh_outside(const jo_mesh *m, const jo_mesh_foot *y, const double *c)
{
    double n[3], r[3];
    if (y->part == JO_ON_FACE) return mesh_plane(m, y->triangle, c, n);
    mean_normal(m, y, n);
    jo_minus3d(r, c, y->at);
    return jo_dot3d(n, r);
}

int jo_mesh_is_rim(const jo_mesh *m, const jo_mesh_foot *y)
{
    if (y->part == JO_ON_FACE || m->closed) return 0;
    if (y->part < JO_ON_CORNER) return jo_whole(m->neighbour[3 * y->triangle + y->part - JO_ON_EDGE]) < 0;
    const int v = jo_whole(m->corner[3 * y->triangle + y->part - JO_ON_CORNER]);
    for (int k = jo_whole(m->first[v]); k < jo_whole(m->first[v + 1]); k++) {
        const int t = jo_whole(m->fan[k]), i = mesh_corner_at(m, t, v);
        if (jo_whole(m->neighbour[3 * t + i]) < 0 || jo_whole(m->neighbour[3 * t + (i + 2) % 3]) < 0) return 1;
    }
    return 0;
}

int jo_mesh_is_flat(const jo_mesh *m, const jo_mesh_foot *y)
{
    const int group = jo_whole(m->group[y->triangle]);
    if (y->part == JO_ON_FACE) return 1;
    if (jo_mesh_is_rim(m, y)) return 0;
    if (y->part < JO_ON_CORNER) return jo_whole(m->group[jo_whole(m->neighbour[3 * y->triangle + y->part - JO_ON_EDGE])]) == group;
    const int v = jo_whole(m->corner[3 * y->triangle + y->part - JO_ON_CORNER]);
    for (int k = jo_whole(m->first[v]); k < jo_whole(m->first[v + 1]); k++)
        if (jo_whole(m->group[jo_whole(m->fan[k])]) != group) return 0;
    return 1;
}

void jo_mesh_direction(const jo_mesh *m, const jo_mesh_foot *y, const double *c, double *n)
{
    jo_minus3d(n, c, y->at);
    if (jo_mesh_is_flat(m, y) || !(jo_unit3d(n) > 0.0)) {
        const double height = mesh_plane(m, y->triangle, c, n);
        for (int k = 0; k < 3 && height < 0.0; k++) n[k] = -n[k];
    }
}

/* The feature of the closest point `foot` to the centre c of a sphere. */
void jo_mesh_feature(const jo_mesh *m, const jo_mesh_foot *foot, int side, const jo_real *c, jo_feature *y)
{
    const double at[3] = {JO_RE(c[0]), JO_RE(c[1]), JO_RE(c[2])}, out = jo_mesh_outside(m, foot, at);
    const double front = m->closed || side == JO_MESH_FRONT ? 1.0 : side == JO_MESH_BEHIND || out < 0.0 ? -1.0 : 1.0;
    const jo_real *plane = m->plane + 4 * jo_whole(m->group[foot->triangle]);
    if (jo_mesh_is_flat(m, foot) || !(foot->square > 0.0)) {
        const jo_real n[3] = {front * plane[0], front * plane[1], front * plane[2]};
        jo_feature_above(y, n, jo_dot3(n, c) - front * plane[3], c);
        return;
    }
    /* from an edge or a corner; behind it the distance is negative */
    const int i = foot->part >= JO_ON_CORNER ? foot->part - JO_ON_CORNER : foot->part - JO_ON_EDGE;
    const jo_real *p = m->vertex + 3 * jo_whole(m->corner[3 * foot->triangle + i]), *q = m->vertex + 3 * jo_whole(m->corner[3 * foot->triangle + (i + 1) % 3]);
    const double sign = jo_mesh_is_rim(m, foot) || front * out >= 0.0 ? 1.0 : -1.0;
    jo_real e[3], w[3];
    for (int k = 0; k < 3; k++) {
        e[k] = q[k] - p[k];
        w[k] = c[k] - p[k];
    }
    jo_feature_around(y, w, foot->part >= JO_ON_CORNER ? 0 : e, sign, c);
}
