/* closest_points.c - closest points of two convex polytopes.
 *
 * Method of Gilbert, Johnson and Keerthi (IEEE Journal of Robotics and Automation 4 (1988), 193-203): the point of the difference b - a that is
 * closest to the origin, by simplices whose corners are supports. */
#include "contact/polytope.h"

enum { JO_MAX_SUPPORTS = 128 };       /* iterations; some 10 are usual */
#define JO_CLOSEST 1e-15              /* error of the distance, relative to it and to the size, at which the search ends */
#define JO_CLOSEST_START 1e-7         /* the same of round shapes, whose closest points Newton's method finds from there */

/* closest point of the segment of corners i, j to the origin: shares (2) */
static void on_segment(const jo_simplex *s, int i, int j, double *x)
{
    double d[3];
    jo_minus3d(d, s->w[j], s->w[i]);
    const double length = jo_dot3d(d, d), t = length > 0.0 ? -jo_dot3d(s->w[i], d) / length : 0.0;
    x[1] = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
    x[0] = 1.0 - x[1];
}

static double distance_of(const jo_simplex *s, const int *of, const double *x, int n)
{
    double v[3] = {0.0, 0.0, 0.0};
    for (int k = 0; k < n; k++)
        for (int i = 0; i < 3; i++) v[i] += x[k] * s->w[of[k]][i];
    return jo_dot3d(v, v);
}

/* closest point of the triangle `of`: shares (3) */
static double on_triangle(const jo_simplex *s, const int *of, double *x)
{
    double u[3], v[3], n[3], c[3][3];
    jo_minus3d(u, s->w[of[1]], s->w[of[0]]);
    jo_minus3d(v, s->w[of[2]], s->w[of[0]]);
    jo_cross3d(n, u, v);
    const double area = jo_dot3d(n, n);
    for (int k = 0; k < 3; k++) {   /* share of corner k: area of the origin's projection with the other two */
        jo_cross3d(c[k], s->w[of[(k + 1) % 3]], s->w[of[(k + 2) % 3]]);
        x[k] = area > 0.0 ? jo_dot3d(c[k], n) / area : -1.0;
    }
    if (x[0] > 0.0 && x[1] > 0.0 && x[2] > 0.0) return distance_of(s, of, x, 3);
    double least = INFINITY;
    for (int k = 0; k < 3; k++) {
        const int pair[2] = {of[k], of[(k + 1) % 3]};
        double y[2];
        on_segment(s, pair[0], pair[1], y);
        const double d = distance_of(s, pair, y, 2);
        if (d >= least) continue;
        least = d;
        x[k] = y[0];
        x[(k + 1) % 3] = y[1];
        x[(k + 2) % 3] = 0.0;
    }
    return least;
}

/* whether the origin is on the inner side of the face opposite of corner k of a tetrahedron, or the tetrahedron is flat */
static int inside_of(const jo_simplex *s, int k)
{
    const double *a = s->w[(k + 1) & 3];
    double u[3], v[3], n[3], d[3];
    jo_minus3d(u, s->w[(k + 2) & 3], a);
    jo_minus3d(v, s->w[(k + 3) & 3], a);
    jo_minus3d(d, s->w[k], a);
    jo_cross3d(n, u, v);
    return jo_dot3d(n, d) * -jo_dot3d(n, a) > 0.0;
}

/* shares of the closest point; 1 if the origin is inside */
static int on_tetrahedron(jo_simplex *s, double *x)
{
    double least = INFINITY, y[3];
    int outside = 0;
    for (int k = 0; k < 4; k++) {
        if (inside_of(s, k)) continue;
        outside = 1;
        const int of[3] = {(k + 1) & 3, (k + 2) & 3, (k + 3) & 3};
        const double d = on_triangle(s, of, y);
        if (d >= least) continue;
        least = d;
        x[k] = 0.0;
        for (int i = 0; i < 3; i++) x[of[i]] = y[i];
    }
    return !outside;
}

/* the closest point, and only the corners that have a share; 1 if the origin is inside */
static int reduce(jo_simplex *s)
{
    static const int all[3] = {0, 1, 2};
    double x[4] = {1.0, 0.0, 0.0, 0.0};
    int kept = 0, inside = 0;
    if (s->count == 2) on_segment(s, 0, 1, x);
    if (s->count == 3) on_triangle(s, all, x);
    if (s->count == 4) inside = on_tetrahedron(s, x);
    for (int i = 0; i < 3; i++) s->v[i] = 0.0;
    if (inside) return 1;
    for (int k = 0; k < s->count; k++) {
        if (!(x[k] > 0.0)) continue;
        for (int i = 0; i < 3; i++) {
            s->w[kept][i] = s->w[k][i];
            s->v[i] += x[k] * s->w[k][i];
        }
        s->a[kept] = s->a[k];
        s->b[kept] = s->b[k];
        s->share[kept++] = x[k];
    }
    s->count = kept;
    return 0;
}

/* vertex i, or the place of a round shape farthest along n; scaled about the centre */
static void scaled(const jo_polytope *p, int i, const double *n, double share, double *y)
{
    double c[3];
    if (p->round) jo_polytope_extreme(p, n, 0, y);
    else jo_polytope_vertex(p, i, y);
    if (share == 1.0) return;
    jo_polytope_vertex(p, -1, c);
    for (int k = 0; k < 3; k++) y[k] = c[k] + share * (y[k] - c[k]);
}

static int known(const jo_simplex *s, int a, int b)
{
    for (int k = 0; k < s->count; k++)
        if (s->a[k] == a && s->b[k] == b) return 1;
    return 0;
}

/* supports of a along n, of b against n */
static void add(const jo_polytope *a, const jo_polytope *b, const double *n, double share, jo_simplex *s, int ia, int ib)
{
    const double back[3] = {-n[0], -n[1], -n[2]};
    double p[3], q[3];
    scaled(a, ia, n, share, p);
    scaled(b, ib, back, share, q);
    s->a[s->count] = ia;
    s->b[s->count] = ib;
    jo_minus3d(s->w[s->count++], q, p);
}

/* distance of the polytopes, scaled by `share` about their centres; 0 if they overlap. s: the closest points */
double jo_closest_points(const jo_polytope *a, const jo_polytope *b, double share, jo_simplex *s)
{
    double size = 0.0, least = INFINITY;
    const int round = a->round || b->round;   /* their supports have no number, and approach the closest points step by step */
    const double enough = round ? JO_CLOSEST_START : JO_CLOSEST;
    static const double first[3] = {0.6, 0.64, 0.48};
    jo_simplex best;
    s->count = 0;
    add(a, b, first, share, s, 0, 0);
    best = *s;
    for (int k = 0; k < JO_MAX_SUPPORTS; k++) {
        if (reduce(s)) return 0.0;
        const double square = jo_dot3d(s->v, s->v), distance = sqrt(square);
        if (!(distance < least)) break;   /* no progress: round-off */
        least = distance;
        best = *s;
        for (int i = 0; i < s->count; i++) size = fmax(size, sqrt(jo_dot3d(s->w[i], s->w[i])));
        if (!(distance > JO_CLOSEST * size)) return 0.0;
        const double back[3] = {-s->v[0], -s->v[1], -s->v[2]};
        const int ia = a->round ? 0 : jo_polytope_support(a, s->v, s->a[0]), ib = b->round ? 0 : jo_polytope_support(b, back, s->b[0]);
        if (!round && known(s, ia, ib)) break;
        add(a, b, s->v, share, s, ia, ib);
        const double gain = square - jo_dot3d(s->v, s->w[s->count - 1]);
        if (!(gain > enough * (square + size * distance))) break;
    }
    *s = best;
    return least;
}
