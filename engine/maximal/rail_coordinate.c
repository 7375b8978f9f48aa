/* rail_coordinate.c - coordinates of a conical wheel b on a straight rail a.
 *
 * The rail: direction x and top z = k of a; its head is a cylinder of radius Q along x, whose top is the origin of a. The wheel: axle n (z of b);
 * its radius is R + l y at the distance y along n from the origin of b. The line in the middle of the head, p(s) = r_a - Q k - r_b + s x, is nearest
 * to the tread where |q| - l y, q = p - (p . n) n, is least: with c = x . n, e^2 = 1 - c^2, u = (x - c n) / e, h = q - (q . u) u,
 *   q . u / |q| = l c / e,   |q| = |h| / sqrt(1 - (l c / e)^2)
 *   GAP: (|q| - R - l y) / sqrt(1 + l^2) - Q;   m = (q / |q| - l n) / sqrt(1 + l^2) from the wheel to the rail, m . x = 0, at P = p - Q m
 *   ROLLED, ACROSS: velocity of the point P of the wheel on the rail along x and along x x m (nonholonomic, value 0)
 * A. H. Wickens, Fundamentals of Rail Vehicle Dynamics, 2003, chapter 2. */
#include "maximal/maximal.h"
#include "dual.h"

/* gradient of a coordinate, changed by dr, pa, pb = changes of r_b - r_a and rotations of a and b; value of the gap */
typedef struct { jo_dual3 along, turn_a, turn_b; jo_real gap; } rail_contact;

/* axis i of A, which turns by p */
static jo_dual3 turning_axis(const jo_real *A, int i, const jo_real *p)
{
    jo_real x[3], dx[3];
    jo_axis(x, A, i);
    jo_cross(dx, p, x);
    return jo_dual3_of(x, dx);
}

static jo_dual3 minus(jo_dual3 a) { return jo_dual3_times(jo_dual_constant(-1.0), a); }

static rail_contact contact_of(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, const jo_real *dr, const jo_real *pa,
                               const jo_real *pb)
{
    const double slope = q->cone, lean = 1.0 / sqrt(1.0 + slope * slope);
    const jo_dual one = jo_dual_constant(1.0), head = jo_dual_constant(q->head);
    const jo_dual3 x = turning_axis(a->A, 0, pa), k = turning_axis(a->A, 2, pa), n = turning_axis(b->A, 2, pb);
    jo_real apart[3];
    jo_set3(apart, b->r);
    jo_sub3(apart, a->r);
    const jo_dual3 r = jo_dual3_of(apart, dr), start = minus(jo_dual3_axpy(r, head, k));
    /* nearest point of the line to the tread */
    const jo_dual c = jo_dual3_dot(x, n), e = jo_dual_root(jo_dual_sub(one, jo_dual_mul(c, c)));
    const jo_dual3 u = jo_dual3_times(jo_dual_div(one, e), jo_dual3_sub(x, jo_dual3_times(c, n)));
    const jo_dual at = jo_dual3_dot(start, u);
    const jo_dual3 h = jo_dual3_sub(jo_dual3_sub(start, jo_dual3_times(jo_dual3_dot(start, n), n)), jo_dual3_times(at, u));
    const jo_dual share = jo_dual_times(jo_same(slope), jo_dual_div(c, e));
    const jo_dual far = jo_dual_div(jo_dual_root(jo_dual3_dot(h, h)), jo_dual_root(jo_dual_sub(one, jo_dual_mul(share, share))));
    const jo_dual s = jo_dual_div(jo_dual_sub(jo_dual_mul(far, share), at), e);
    const jo_dual3 p = jo_dual3_axpy(start, s, x);
    const jo_dual y = jo_dual3_dot(p, n);
    const jo_dual3 out = jo_dual3_times(jo_dual_div(one, far), jo_dual3_sub(p, jo_dual3_times(y, n)));
    const jo_dual3 m = jo_dual3_times(jo_dual_constant(lean), jo_dual3_sub(out, jo_dual3_times(jo_dual_constant(slope), n)));
    /* gradient: the velocity of P of the wheel on the rail along a direction */
    const jo_dual3 P = jo_dual3_sub(p, jo_dual3_times(head, m));
    rail_contact w;
    w.gap = lean * (far.v - q->radius - slope * y.v) - q->head;
    w.along = q->type == JO_COORDINATE_RAIL_GAP ? minus(m) : q->type == JO_COORDINATE_RAIL_ROLLED ? x : jo_dual3_cross(x, m);
    w.turn_b = jo_dual3_cross(P, w.along);
    w.turn_a = jo_dual3_cross(w.along, jo_dual3_add(P, r));
    return w;
}

void jo_rail_value(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, jo_coordinate_work *w)
{
    jo_real none[3];
    for (int i = 0; i < 3; i++) none[i] = jo_same(0.0);
    const rail_contact y = contact_of(q, a, b, none, none, none);
    w->value = q->type == JO_COORDINATE_RAIL_GAP ? y.gap : jo_same(0.0);
    jo_set3(w->along, y.along.v);
    jo_set3(w->turn_a, y.turn_a.v);
    jo_set3(w->turn_b, y.turn_b.v);
}

void jo_rail_change(const jo_coordinate *q, const jo_marker_work *a, const jo_marker_work *b, const jo_real *dr, const jo_real *pa, const jo_real *pb,
                    jo_real *along, jo_real *turn_a, jo_real *turn_b)
{
    const rail_contact y = contact_of(q, a, b, dr, pa, pb);
    jo_set3(along, y.along.d);
    jo_set3(turn_a, y.turn_a.d);
    jo_set3(turn_b, y.turn_b.d);
}
