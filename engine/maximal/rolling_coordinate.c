/* rolling_coordinate.c - coordinates of a disc b of radius R, axle n (its z axis), on a plane a with the normal k (its z axis).
 *
 *   c = k . n, s = |k x n|,  r = r_b - r_a,  e = -(k - c n) / s: from the centre to the lowest point of the rim
 *   RIM:    k . r - R s, height of the lowest point above the plane
 *   ROLLED: velocity of that point of the disc on the plane, along t = n x k / s, in which a disc rolls
 *   ACROSS: the same along u = (n - c k) / s, across it
 *   SLIP:   velocity of the point r_b - R k of a sphere of radius R about b on the plane, along an axis t of a; no axle
 * The last three are no functions of the position (nonholonomic): their value is 0, their rate the velocity. Géradin, Cardona, Flexible
 * Multibody Dynamics, 2001, section 8. */
#include "maximal/maximal.h"

/* vectors of a disc on a plane */
typedef struct { jo_real k[3], n[3], r[3], c, s; } disc;

static disc disc_of(const jo_marker_work *a, const jo_marker_work *b)
{
    disc y;
    jo_real w[3];
    jo_axis(y.k, a->A, 2);
    jo_axis(y.n, b->A, 2);
    jo_set3(y.r, b->r);
    jo_sub3(y.r, a->r);
    y.c = jo_dot3(y.k, y.n);
    jo_cross(w, y.k, y.n);
    y.s = jo_sqrt(jo_dot3(w, w));
    return y;
}

/* y += f x */
static void add(jo_real *y, jo_real f, const jo_real *x)
{
    for (int i = 0; i < 3; i++) y[i] += f * x[i];
}

/* y = f x */
static void scaled(jo_real *y, jo_real f, const jo_real *x)
{
    for (int i = 0; i < 3; i++) y[i] = f * x[i];
}

/* e, and the direction t or u */
static void directions(const disc *x, int across, jo_real *e, jo_real *d)
{
    for (int i = 0; i < 3; i++) e[i] = (x->c * x->n[i] - x->k[i]) / x->s;
    if (across) {
        for (int i = 0; i < 3; i++) d[i] = (x->n[i] - x->c * x->k[i]) / x->s;
    } else {
        jo_cross(d, x->n, x->k);
        scaled(d, 1.0 / x->s, d);
    }
}

/* w: gradients of the velocity along w->along of the point of b at e from its origin */
static void point_gradients(const jo_real *r, const jo_real *e, jo_coordinate_work *w)
{
    jo_real p[3];
    w->value = jo_same(0.0);
    jo_cross(w->turn_b, e, w->along);
    jo_set3(p, r);
    jo_add3(p, e);
    jo_cross(w->turn_a, w->along, p);
}

/* their changes by dr, de and that of t, `along` */
static void point_gradients_change(const jo_real *r, const jo_real *dr, const jo_real *e, const jo_real *de, const jo_real *t, const jo_real *along,
                                   jo_real *turn_a, jo_real *turn_b)
{
    jo_real p[3], dp[3], y[3];
    /* (e x t)' and (t x (r + e))' */
    jo_cross(turn_b, de, t);
    jo_cross(y, e, along);
    jo_add3(turn_b, y);
    jo_set3(p, r);
    jo_add3(p, e);
    jo_set3(dp, dr);
    jo_add3(dp, de);
    jo_cross(turn_a, along, p);
    jo_cross(y, t, dp);
    jo_add3(turn_a, y);
}

/* SLIP: value and gradient */
static void slip_value(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, jo_coordinate_work *w)
{
    jo_real e[3], r[3];
    jo_axis(e, a->A, 2);
    scaled(e, jo_same(-q->radius), e);
    jo_axis(w->along, a->A, q->axis_a);
    jo_set3(r, b->r);
    jo_sub3(r, a->r);
    point_gradients(r, e, w);
}

/* SLIP: change of the gradient; along and e turn with a */
static void slip_change(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, const jo_real *dr, const jo_real *pa,
                        jo_real *along, jo_real *turn_a, jo_real *turn_b)
{
    jo_real e[3], t[3], de[3], r[3];
    jo_axis(e, a->A, 2);
    scaled(e, jo_same(-q->radius), e);
    jo_axis(t, a->A, q->axis_a);
    jo_cross(de, pa, e);
    jo_cross(along, pa, t);
    jo_set3(r, b->r);
    jo_sub3(r, a->r);
    point_gradients_change(r, dr, e, de, t, along, turn_a, turn_b);
}

/* value and gradient along, turn_a, turn_b */
void jo_rolling_value(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, jo_coordinate_work *w)
{
    if (q->type == JO_COORDINATE_SLIP) {
        slip_value(q, a, b, w);
        return;
    }
    const disc x = disc_of(a, b);
    const double R = q->radius;
    if (q->type == JO_COORDINATE_RIM) {
        w->value = jo_dot3(x.k, x.r) - R * x.s;
        jo_real kn[3];
        jo_cross(kn, x.k, x.n);
        jo_set3(w->along, x.k);
        jo_cross(w->turn_a, x.k, x.r);
        add(w->turn_a, R * x.c / x.s, kn);
        scaled(w->turn_b, -R * x.c / x.s, kn);
        return;
    }
    jo_real e[3];
    directions(&x, q->type == JO_COORDINATE_ACROSS, e, w->along);
    scaled(e, jo_same(R), e);
    point_gradients(x.r, e, w);
}

/* change of the gradient by dr, pa, pb = changes of r_b - r_a and rotations of a and b */
void jo_rolling_change(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, const jo_real *dr, const jo_real *pa,
                       const jo_real *pb, jo_real *along, jo_real *turn_a, jo_real *turn_b)
{
    if (q->type == JO_COORDINATE_SLIP) {
        slip_change(q, a, b, dr, pa, along, turn_a, turn_b);
        return;
    }
    const disc x = disc_of(a, b);
    const double R = q->radius;
    jo_real dk[3], dn[3], t[3], u[3];
    jo_cross(dk, pa, x.k);
    jo_cross(dn, pb, x.n);
    const jo_real dc = jo_dot3(dk, x.n) + jo_dot3(x.k, dn), ds = -x.c * dc / x.s;
    if (q->type == JO_COORDINATE_RIM) {
        jo_real kn[3], dkn[3];
        const jo_real g = R * x.c / x.s, dg = R * dc / (x.s * x.s * x.s);
        jo_cross(kn, x.k, x.n);
        jo_cross(dkn, dk, x.n);
        jo_cross(t, x.k, dn);
        jo_add3(dkn, t);
        jo_set3(along, dk);
        jo_cross(turn_a, dk, x.r);
        jo_cross(t, x.k, dr);
        jo_add3(turn_a, t);
        add(turn_a, dg, kn);
        add(turn_a, g, dkn);
        scaled(turn_b, -dg, kn);
        add(turn_b, -g, dkn);
        return;
    }
    const int across = q->type == JO_COORDINATE_ACROSS;
    jo_real e[3], d[3], de[3];
    directions(&x, across, e, d);
    for (int i = 0; i < 3; i++) de[i] = R * ((dc * x.n[i] + x.c * dn[i] - dk[i] - ds * e[i]) / x.s);
    if (across) {
        for (int i = 0; i < 3; i++) along[i] = (dn[i] - dc * x.k[i] - x.c * dk[i] - ds * d[i]) / x.s;
    } else {
        jo_cross(t, dn, x.k);
        jo_cross(u, x.n, dk);
        for (int i = 0; i < 3; i++) along[i] = (t[i] + u[i] - ds * d[i]) / x.s;
    }
    scaled(e, jo_same(R), e);
    point_gradients_change(x.r, dr, e, de, d, along, turn_a, turn_b);
}
