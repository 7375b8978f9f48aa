/* shape_distance.c - signed distance of a point from a shape, with first and second derivatives.
 *
 * Each shape is solved in the plane of its section or in an octant: the vector e of distances from its bounding planes or circles. Outside
 * of several bounds at once the distance is the length of the positive part of e, elsewhere the largest component of e.
 */
#include "contact/contact.h"

enum { JO_ELLIPSOID_STEPS = 60 };   /* of Newton's method; some 6 outside, one more for each halving of the distance from a centre of curvature */

/* hessian += factor u u^T */
static void add_product(jo_distance *y, jo_real factor, const jo_real *u)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) y->hessian[3 * i + j] += factor * u[i] * u[j];
}

/* distance from the point c less r, or r less this distance (sign -1): normal (x - c) / |x - c|, hessian (E - n n^T) / |x - c| */
static void from_point(jo_distance *y, const jo_real *x, jo_real c, jo_real r, double sign)
{
    const jo_real at[3] = {x[0], x[1], x[2] - c}, square = jo_dot3(at, at);
    if (!(JO_RE(square) > 0.0)) {   /* in the centre every direction is the normal */
        y->gap = -sign * r;
        y->normal[2] = jo_same(1.0);
        return;
    }
    const jo_real length = jo_sqrt(square);
    y->gap = sign * (length - r);
    for (int i = 0; i < 3; i++) y->normal[i] = sign * at[i] / length;
    add_product(y, -sign / length, y->normal);
    for (int i = 0; i < 3; i++) y->hessian[4 * i] += sign / length;
}

/* Shape of revolution about z from its section: distance `gap` with the gradient (across, along), curvature `bend` of the distance along the
 * section's own tangent; `radius` is the distance of the point from the axis, in direction `out`. */
static void revolve(jo_distance *y, const jo_real *out, jo_real radius, jo_real gap, jo_real across, jo_real along, jo_real bend)
{
    const jo_real tangent[3] = {-along * out[0], -along * out[1], across}, round[3] = {-out[1], out[0], jo_same(0.0)};
    y->gap = gap;
    y->normal[0] = across * out[0];
    y->normal[1] = across * out[1];
    y->normal[2] = along;
    add_product(y, bend, tangent);
    if (JO_RE(radius) > 0.0) add_product(y, across / radius, round);
}

/* direction (2) from the axis z and distance from it; on the axis x */
static jo_real from_axis(const jo_real *x, jo_real *out)
{
    const jo_real square = x[0] * x[0] + x[1] * x[1];
    const jo_real radius = JO_RE(square) > 0.0 ? jo_sqrt(square) : 0.0;
    out[0] = JO_RE(radius) > 0.0 ? x[0] / radius : 1.0;
    out[1] = JO_RE(radius) > 0.0 ? x[1] / radius : 0.0;
    return radius;
}

/* section: a circle of radius r about (centre, 0) */
static void torus(jo_distance *y, const jo_real *x, jo_real centre, jo_real r)
{
    jo_real out[2];
    const jo_real radius = from_axis(x, out), e = radius - centre, square = e * e + x[2] * x[2];
    if (!(JO_RE(square) > 0.0)) {
        revolve(y, out, radius, -r, jo_same(1.0), jo_same(0.0), jo_same(0.0));
        return;
    }
    const jo_real length = jo_sqrt(square);
    revolve(y, out, radius, length - r, e / length, x[2] / length, 1.0 / length);
}

/* section: a rectangle of half sides r, h */
static void cylinder(jo_distance *y, const jo_real *x, jo_real r, jo_real h)
{
    jo_real out[2];
    const jo_real none = jo_same(0.0), side = jo_same(JO_RE(x[2]) < 0.0 ? -1.0 : 1.0);
    const jo_real radius = from_axis(x, out), e = radius - r, k = side * x[2] - h;
    if (JO_RE(e) > 0.0 && JO_RE(k) > 0.0) {
        const jo_real length = jo_sqrt(e * e + k * k);
        revolve(y, out, radius, length, e / length, side * k / length, 1.0 / length);
    } else if (JO_RE(e) > JO_RE(k)) {
        revolve(y, out, radius, e, jo_same(1.0), none, none);
    } else {
        revolve(y, out, radius, k, none, side, none);
    }
}

static void bore(jo_distance *y, const jo_real *x, jo_real r)
{
    jo_real out[2];
    const jo_real radius = from_axis(x, out);
    revolve(y, out, radius, r - radius, jo_same(-1.0), jo_same(0.0), jo_same(0.0));
}

static void capsule(jo_distance *y, const jo_real *x, jo_real r, jo_real h)
{
    if (JO_RE(x[2]) > JO_RE(h)) from_point(y, x, h, r, 1.0);
    else if (JO_RE(x[2]) < -JO_RE(h)) from_point(y, x, -h, r, 1.0);
    else {
        jo_real out[2];
        const jo_real radius = from_axis(x, out);
        revolve(y, out, radius, radius - r, jo_same(1.0), jo_same(0.0), jo_same(0.0));
    }
}

static void box(jo_distance *y, const jo_real *x, const jo_real *half)
{
    jo_real e[3], square = jo_same(0.0);
    int outside = 0, nearest = 0;
    for (int i = 0; i < 3; i++) {
        e[i] = jo_size(x[i]) - half[i];
        if (JO_RE(e[i]) > JO_RE(e[nearest])) nearest = i;
        if (!(JO_RE(e[i]) > 0.0)) continue;
        outside++;
        square += e[i] * e[i];
    }
    if (outside < 2) {   /* beside a face, or inside */
        y->gap = e[nearest];
        y->normal[nearest] = jo_same(JO_RE(x[nearest]) < 0.0 ? -1.0 : 1.0);
        return;
    }
    y->gap = jo_sqrt(square);
    for (int i = 0; i < 3; i++)
        if (JO_RE(e[i]) > 0.0) y->normal[i] = (JO_RE(x[i]) < 0.0 ? -e[i] : e[i]) / y->gap;
    add_product(y, -1.0 / y->gap, y->normal);
    for (int i = 0; i < 3; i++)
        if (JO_RE(e[i]) > 0.0) y->hessian[4 * i] += 1.0 / y->gap;
}

/* sum (a_i x_i / (a_i^2 + t))^2 - 1 and its derivative with respect to t */
static jo_real ellipsoid_excess(const jo_real *x, const jo_real *a, jo_real t, jo_real *slope)
{
    jo_real sum = jo_same(-1.0);
    *slope = jo_same(0.0);
    for (int i = 0; i < 3; i++) {
        const jo_real k = a[i] * a[i] + t, e = a[i] * x[i] / k;
        if (JO_RE(x[i]) == 0.0) continue;
        sum += e * e;
        *slope -= 2.0 * e * e / k;
    }
    return sum;
}

/* in the plane across the shortest axis, beyond the centres of curvature: y_i = a_i^2 x_i / (a_i^2 - a_least^2), and above or below this plane */
static void ellipsoid_inside(jo_distance *y, const jo_real *x, const jo_real *a, int least)
{
    jo_real left = jo_same(1.0), square = jo_same(0.0);
    for (int i = 0; i < 3; i++) {
        if (i == least || JO_RE(x[i]) == 0.0) continue;
        const jo_real k = a[i] * a[i] - a[least] * a[least], share = a[i] * x[i] / k;
        y->normal[i] = a[least] * a[least] * x[i] / k;   /* y - x */
        left -= share * share;
    }
    y->normal[least] = a[least] * (JO_RE(left) > 0.0 ? jo_sqrt(left) : jo_same(0.0));
    for (int i = 0; i < 3; i++) square += y->normal[i] * y->normal[i];
    y->gap = -jo_sqrt(square);
    for (int i = 0; i < 3; i++) y->normal[i] /= -y->gap;
}

/* The closest point is y_i = a_i^2 x_i / (a_i^2 + t), x - y = t g with the gradient g_i = y_i / a_i^2 (Eberly, Distance from a point to an
 * ellipse, an ellipsoid, 2013). The excess falls and is convex in t: Newton's method ascends from where one of its parts is 1. Its last step is
 * in jo_real, so that derivatives are exact. Inside, beyond the centres of curvature, the shortest axis is the direction. */
static void ellipsoid(jo_distance *y, const jo_real *x, const jo_real *a)
{
    int least = 0;
    for (int i = 1; i < 3; i++)
        if (JO_RE(a[i]) < JO_RE(a[least])) least = i;
    const double lowest = -JO_RE(a[least] * a[least]);
    jo_real t = {lowest}, slope, g[3], square = jo_same(0.0), weight = jo_same(0.0), along[3];
    for (int i = 0; i < 3; i++) {
        const double start = JO_RE(a[i]) * (fabs(JO_RE(x[i])) - JO_RE(a[i]));
        if (start > JO_RE(t)) t = jo_same(start);
    }
    if (!(JO_RE(t) > lowest)) {
        ellipsoid_inside(y, x, a, least);
        return;
    }
    for (int k = 0; k < JO_ELLIPSOID_STEPS; k++) {
        const jo_real excess = ellipsoid_excess(x, a, t, &slope), next = t - excess / slope;
        const int still = !(JO_RE(next) > JO_RE(t));
        t = next;
        if (still) break;
    }
    for (int i = 0; i < 3; i++) {
        g[i] = x[i] / (a[i] * a[i] + t);
        square += g[i] * g[i];
        along[i] = a[i] * a[i] * g[i] / (a[i] * a[i] + t);
        weight += along[i] * g[i];
    }
    const jo_real size = jo_sqrt(square);
    y->gap = t * size;
    for (int i = 0; i < 3; i++) y->normal[i] = g[i] / size;
    /* dg = (dx - g dt) / (a^2 + t), with dt = along . dx / weight; the part along the normal falls out */
    for (int j = 0; j < 3; j++) {
        jo_real dg[3];
        for (int i = 0; i < 3; i++) dg[i] = ((i == j) - g[i] * along[j] / weight) / (a[i] * a[i] + t);
        const jo_real out = jo_dot3(y->normal, dg);
        for (int i = 0; i < 3; i++) y->hessian[3 * i + j] = (dg[i] - out * y->normal[i]) / size;
    }
}

void jo_shape_distance(int shape, const jo_real *size, const jo_real *x, jo_distance *y)
{
    static const jo_distance none;
    *y = none;
    switch (shape) {
    case JO_SHAPE_SPHERE: from_point(y, x, jo_same(0.0), size[0], 1.0); break;
    case JO_SHAPE_HOLLOW_SPHERE: from_point(y, x, jo_same(0.0), size[0], -1.0); break;
    case JO_SHAPE_CAPSULE: capsule(y, x, size[0], size[1]); break;
    case JO_SHAPE_BOX: box(y, x, size); break;
    case JO_SHAPE_CYLINDER: cylinder(y, x, size[0], size[1]); break;
    case JO_SHAPE_BORE: bore(y, x, size[0]); break;
    case JO_SHAPE_ELLIPSOID: ellipsoid(y, x, size); break;
    case JO_SHAPE_TORUS: torus(y, x, size[0], size[1]); break;
    default:   /* half-space */
        y->gap = x[2];
        y->normal[2] = jo_same(1.0);
    }
}
