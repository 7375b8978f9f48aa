/* rope_coordinate.c - length of rope between two sheaves along their common tangent, with the arcs from fixed directions of both.
 *
 * The axle of a sheave is the axis z = n of its marker; its radius R has the sign of the sense in which the rope runs about n from a to b, 0 is
 * a point. With the direction e of the rope, w = r_b - r_a and the angles A(e) = atan2(e . y, e . x) of e about the axle in each frame
 *   s = e . w + R_a A_a(e) - R_b A_b(e),   stationary in e:   w + R_a k_a - R_b k_b = l e,   k = n x e / |n x e|^2
 * so that the rope leaves the rim along its tangent and ds follows from the motion at constant e alone:
 *   ds / dw = e,   ds / dphi = -R m of a and R m of b,   m = (n - (n . e) e) / |n x e|^2
 * In the plane of the sheaves this is the common tangent. Where the rope leaves this plane by an angle f, the radius counts as R / cos f. The
 * sum of s along a rope over several sheaves is its length but for a constant, since the arc on a sheave is between A of both neighbours. */
#include "maximal/maximal.h"

enum { JO_ROPE_SEARCH = 30 };      /* largest number of iterations for the direction of the rope */
#define JO_ROPE_FOUND 1e-12        /* change of a unit vector after which one iteration more would be rounding */

/* a sheave: radius with its sign, axle; rope: ends, w, e, l */
typedef struct { double radius; jo_real n[3]; } sheave;
typedef struct { sheave end[2]; jo_real w[3], e[3], length; } rope;

static void copy(jo_real *y, jo_real s, const jo_real *x)
{
    for (int i = 0; i < 3; i++) y[i] = s * x[i];
}

/* y -= (y . e) e */
static void remove_along(jo_real *y, const jo_real *e)
{
    jo_axpy3(y, -jo_dot3(y, e), e);
}

/* k = n x e / |n x e|^2, and its change dk by dn and de */
static void lever(const jo_real *n, const jo_real *dn, const jo_real *e, const jo_real *de, jo_real *k, jo_real *dk)
{
    jo_real h[3], t[3];
    jo_cross(h, n, e);
    const jo_real square = jo_dot3(h, h);
    copy(k, 1.0 / square, h);
    jo_cross(dk, dn, e);
    jo_cross(t, n, de);
    jo_add3(dk, t);
    const jo_real by = 2.0 * jo_dot3(k, dk);
    for (int i = 0; i < 3; i++) dk[i] = (dk[i] - by * h[i]) / square;
}

/* y = R_a dk_a - R_b dk_b by the changes of both axles and of e; *out: w + R_a k_a - R_b k_b, without its part along e */
static void balance(const rope *x, const jo_real (*dn)[3], const jo_real *de, jo_real *out, jo_real *y)
{
    jo_real k[3], dk[3];
    jo_set3(out, x->w);
    for (int i = 0; i < 3; i++) y[i] = jo_same(0.0);
    for (int i = 0; i < 2; i++) {
        if (x->end[i].radius == 0.0) continue;
        const double R = i ? -x->end[i].radius : x->end[i].radius;
        lever(x->end[i].n, dn[i], x->e, de, k, dk);
        jo_axpy3(out, jo_same(R), k);
        jo_axpy3(y, jo_same(R), dk);
    }
    remove_along(out, x->e);
}

/* change de of the direction, across e, for which l de - (R_a dk_a - R_b dk_b) = right */
static void turn_direction(const rope *x, const jo_real *right, jo_real *de)
{
    static const jo_real none[2][3] = {{JO_CONSTANT(0.0)}};
    jo_real p[2][3], y[2][3], unused[3], M[2][2], f[2];
    const int one = x->end[0].radius == 0.0;
    if (one && x->end[1].radius == 0.0) {
        copy(de, 1.0 / x->length, right);
        remove_along(de, x->e);
        return;
    }
    /* two unit vectors across e */
    jo_cross(p[0], x->end[one].n, x->e);
    copy(p[0], 1.0 / jo_sqrt(jo_dot3(p[0], p[0])), p[0]);
    jo_cross(p[1], x->e, p[0]);
    for (int j = 0; j < 2; j++) balance(x, none, p[j], unused, y[j]);
    for (int i = 0; i < 2; i++) {
        f[i] = jo_dot3(p[i], right);
        for (int j = 0; j < 2; j++) M[i][j] = (i == j ? x->length : jo_same(0.0)) - jo_dot3(p[i], y[j]);
    }
    const jo_real det = M[0][0] * M[1][1] - M[0][1] * M[1][0];
    const jo_real u = (f[0] * M[1][1] - f[1] * M[0][1]) / det, v = (f[1] * M[0][0] - f[0] * M[1][0]) / det;
    for (int i = 0; i < 3; i++) de[i] = u * p[0][i] + v * p[1][i];
}

/* direction of the common tangent as if both axles were parallel: in the plane of the sheave its angle against w has the sine
 * (R_a - R_b) / |w|; not a number where one sheave is inside the other */
static void start_direction(rope *x)
{
    const int one = x->end[0].radius == 0.0;
    const double apart = x->end[1].radius - x->end[0].radius;
    const jo_real *n = x->end[one].n, height = jo_dot3(n, x->w);
    jo_set3(x->e, x->w);
    if (apart != 0.0) {
        jo_real flat[3], across[3];
        jo_set3(flat, x->w);
        jo_axpy3(flat, -height, n);
        jo_cross(across, n, flat);
        const jo_real sine = -apart / jo_sqrt(jo_dot3(flat, flat)), cosine = jo_sqrt(1.0 - sine * sine);
        for (int i = 0; i < 3; i++) x->e[i] = cosine * (cosine * flat[i] + sine * across[i]) + height * n[i];
    }
    copy(x->e, 1.0 / jo_sqrt(jo_dot3(x->e, x->e)), x->e);
}

/* the rope at present: Newton's method for its direction */
static rope rope_of(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b)
{
    static const jo_real none[2][3] = {{JO_CONSTANT(0.0)}}, still[3] = {JO_CONSTANT(0.0)};
    rope x;
    x.end[0].radius = q->radius;
    x.end[1].radius = q->head;
    jo_axis(x.end[0].n, a->A, 2);
    jo_axis(x.end[1].n, b->A, 2);
    jo_set3(x.w, b->r);
    jo_sub3(x.w, a->r);
    start_direction(&x);
    for (int i = 0; i < JO_ROPE_SEARCH; i++) {
        jo_real off[3], unused[3], de[3];
        x.length = jo_dot3(x.e, x.w);
        balance(&x, none, still, off, unused);
        turn_direction(&x, off, de);
        jo_add3(x.e, de);
        copy(x.e, 1.0 / jo_sqrt(jo_dot3(x.e, x.e)), x.e);
        if (!jo_some(JO_LESS(jo_same(JO_ROPE_FOUND * JO_ROPE_FOUND), jo_magnitude(jo_dot3(de, de))))) break;
    }
    x.length = jo_dot3(x.e, x.w);
    return x;
}

/* m = (n - (n . e) e) / |n x e|^2, and its change by dn and de */
static void axle_share(const jo_real *n, const jo_real *dn, const jo_real *e, const jo_real *de, jo_real *m, jo_real *dm)
{
    const jo_real c = jo_dot3(n, e), dc = jo_dot3(dn, e) + jo_dot3(n, de), square = 1.0 - c * c, by = 2.0 * c * dc / square;
    for (int i = 0; i < 3; i++) {
        m[i] = (n[i] - c * e[i]) / square;
        dm[i] = (dn[i] - dc * e[i] - c * de[i]) / square + by * m[i];
    }
}

/* angle of e about the axle in the frame of a marker */
static jo_real angle_in(const jo_marker_work *k, const jo_real *e)
{
    jo_real x[3], y[3];
    jo_axis(x, k->A, 0);
    jo_axis(y, k->A, 1);
    return jo_arc_tangent(jo_dot3(e, y), jo_dot3(e, x));
}

void jo_rope_value(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, jo_coordinate_work *w)
{
    static const jo_real none[3] = {JO_CONSTANT(0.0)};
    const rope x = rope_of(q, a, b);
    jo_real unused[3];
    w->value = x.length;
    jo_set3(w->along, x.e);
    if (x.end[0].radius != 0.0) {
        w->value += x.end[0].radius * angle_in(a, x.e);
        axle_share(x.end[0].n, none, x.e, none, w->turn_a, unused);
        copy(w->turn_a, jo_same(-x.end[0].radius), w->turn_a);
    }
    if (x.end[1].radius != 0.0) {
        w->value -= x.end[1].radius * angle_in(b, x.e);
        axle_share(x.end[1].n, none, x.e, none, w->turn_b, unused);
        copy(w->turn_b, jo_same(x.end[1].radius), w->turn_b);
    }
}

void jo_rope_change(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, const jo_real *dr, const jo_real *pa, const jo_real *pb,
                    jo_real *along, jo_real *turn_a, jo_real *turn_b)
{
    static const jo_real still[3] = {JO_CONSTANT(0.0)};
    const rope x = rope_of(q, a, b);
    jo_real dn[2][3], off[3], right[3], unused[3];
    jo_cross(dn[0], pa, x.end[0].n);
    jo_cross(dn[1], pb, x.end[1].n);
    balance(&x, (const jo_real (*)[3])dn, still, off, right);
    jo_add3(right, dr);
    turn_direction(&x, right, along);
    axle_share(x.end[0].n, dn[0], x.e, along, unused, turn_a);
    copy(turn_a, jo_same(-x.end[0].radius), turn_a);
    axle_share(x.end[1].n, dn[1], x.e, along, unused, turn_b);
    copy(turn_b, jo_same(x.end[1].radius), turn_b);
}
