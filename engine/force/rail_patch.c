/* rail_patch.c - a wheel, a body of revolution about its axle n, on a rail, straight along x: geometry, Hertz's load, creep forces.
 *
 * Geometry: the head of the rail is an arc of radius Q about the line p(s) = c - r_b across and up, s along x. The section of the wheel has the slope l and the
 * curvature h at the point (y0, r0), y along the axle; the distance of a point (y, rho) from it, outside positive, is, with w = (y - y0, rho - r0),
 *   D = g / (1 + sqrt(1 + h g)),   g = 2 w . n0 + h w . w,   n0 = (-l, 1) / sqrt(1 + l^2);   grad D = (n0 + h w) / sqrt(1 + h g)
 * The contact is where D(p(s)) is smallest, dD/ds = 0 (Newton's method); depth d = Q - D, normal m = grad D from the wheel to the rail, m . x = 0,
 * point P = p - Q m. A turned wheel touches ahead of or behind its axle.
 *
 * Load: N = K d^1.5 (1 + damping d'), never pulling (H. Hertz; K. H. Hunt, F. R. E. Crossley 1975).
 *
 * Creep (J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, 1990): V = rolling speed, the mean of travel and circumference;
 * creepages nu = v_P / V, phi = w . (-m) / V; t = x x m across; half axes a, b of Hertz
 *   Fx = -G a b C11 nu_x,   Fy = -G a b (C22 nu_y + sqrt(a b) C23 phi),   M = G a b (sqrt(a b) C23 nu_y - a b C33 phi)
 * C23 changes its sign with that of V. Saturation with e = |F| / (mu N) (Z. Y. Shen, J. K. Hedrick, J. A. Elkins, 1983; P. J. Vermeulen,
 * K. L. Johnson, 1964): F and M times 1 - e/3 + e^2/27 up to e = 3, from there 1/e. The linear law dissipates, since C23 enters skew-symmetrically, and
 * a common factor keeps that. Below the speed `slow` V is (slow + V^2 / slow) / 2: nothing is divided by 0. */
#include "maximal/maximal.h"
#include "force/rail_patch.h"

#define JO_RAIL_SEARCH 20       /* steps of Newton's method; 3 are usual */
#define JO_RAIL_FOUND 1e-14     /* change of the place along the rail over the radius at which it is found */

static const jo_real rail_way[3] = {1.0, 0.0, 0.0};
static const jo_real rail_none[3] = {0.0, 0.0, 0.0};

/* the line in the middle of the head at s: distance D, its derivatives along the line, normal and place */
typedef struct { jo_dual distance, slope; jo_real second; jo_dual3 normal, p; } section_at;

static section_at section_of(const jo_rail_patch *c, const jo_wheel_motion *m, jo_dual s)
{
    section_at y;
    const jo_real middle[3] = {jo_same(0.0), c->y, c->z};
    const jo_dual3 x = jo_dual3_of(rail_way, rail_none);
    const jo_dual one = jo_dual_constant(1.0), bend = jo_dual_of(c->curvature, jo_same(0.0));
    y.p = jo_dual3_sub(jo_dual3_of(middle, rail_none), m->r);
    y.p.v[0] = s.v;
    y.p.d[0] = s.d;
    /* place along the axle, distance from it */
    const jo_dual place = jo_dual3_dot(y.p, m->n);
    const jo_dual3 q = jo_dual3_sub(y.p, jo_dual3_times(place, m->n));
    const jo_dual rho = jo_dual3_length(q);
    /* distance from the section and its gradient */
    const jo_real lean = 1.0 / jo_sqrt(1.0 + c->slope * c->slope);
    const jo_dual w0 = jo_dual_plus(place, -c->place), w1 = jo_dual_plus(rho, -c->radius);
    const jo_dual out = jo_dual_sub(jo_dual_times(lean, w1), jo_dual_times(lean * c->slope, w0));
    const jo_dual square = jo_dual_add(jo_dual_mul(w0, w0), jo_dual_mul(w1, w1));
    const jo_dual g = jo_dual_add(jo_dual_times(jo_same(2.0), out), jo_dual_mul(bend, square));
    const jo_dual root = jo_dual_root(jo_dual_plus(jo_dual_mul(bend, g), jo_same(1.0)));
    y.distance = jo_dual_div(g, jo_dual_add(one, root));
    const jo_dual dy = jo_dual_div(jo_dual_plus(jo_dual_mul(bend, w0), -lean * c->slope), root);
    const jo_dual dr = jo_dual_div(jo_dual_plus(jo_dual_mul(bend, w1), lean), root);
    /* along the line: y' = c, rho' = q . x / rho, rho'' = (1 - c^2 - rho'^2) / rho */
    const jo_dual along = jo_dual3_dot(x, m->n), rises = jo_dual_div(jo_dual3_dot(q, x), rho);
    y.slope = jo_dual_add(jo_dual_mul(dy, along), jo_dual_mul(dr, rises));
    const jo_real both = along.v * along.v + rises.v * rises.v;
    y.second = c->curvature / root.v * (both - y.slope.v * y.slope.v) + dr.v * (1.0 - both) / rho.v;
    y.normal = jo_dual3_add(jo_dual3_times(jo_dual_div(dr, rho), q), jo_dual3_times(dy, m->n));
    return y;
}

/* where the line is nearest to the wheel */
static section_at nearest(const jo_rail_patch *c, const jo_wheel_motion *m, jo_real *s)
{
    section_at y = section_of(c, m, jo_dual_of(*s, jo_same(0.0)));
    for (int i = 0; i < JO_RAIL_SEARCH; i++) {
        const jo_real change = y.slope.v / y.second;
        *s -= change;
        y = section_of(c, m, jo_dual_of(*s, jo_same(0.0)));
        if (fabs(JO_RE(change)) <= JO_RAIL_FOUND * JO_RE(c->radius)) break;
    }
    return section_of(c, m, jo_dual_of(*s - y.slope.v / y.second, -y.slope.d / y.second));
}

/* depth, rate, normal load */
static void press(const jo_rail_data *x, const jo_rail_patch *c, const jo_dual3 *velocity, jo_rail_touch *y)
{
    const jo_dual none = jo_dual_constant(0.0);
    y->rate = jo_dual3_dot(*velocity, y->down);
    y->elastic = y->load = none;
    if (!(JO_RE(y->depth.v) > 0.0)) return;
    y->elastic = jo_dual_times(c->stiffness, jo_dual_mul(y->depth, jo_dual_root(y->depth)));
    y->load = jo_dual_mul(y->elastic, jo_dual_plus(jo_dual_times(x->damping, y->rate), jo_same(1.0)));
    y->touches = JO_RE(y->load.v) > 0.0;
    if (!y->touches) y->load = none;
}

/* creepages, forces and moment by the linear theory, and their saturation */
static void creep(const jo_rail_data *x, const jo_rail_patch *c, jo_rail_touch *y)
{
    const jo_dual none = jo_dual_constant(0.0), one = jo_dual_constant(1.0);
    jo_dual size = jo_dual_size(y->speed);
    if (JO_RE(size.v) < JO_RE(x->slow))
        size = jo_dual_times(jo_same(0.5), jo_dual_plus(jo_dual_times(1.0 / x->slow, jo_dual_mul(size, size)), x->slow));
    const jo_dual by = jo_dual_div(one, size), way = jo_dual_mul(y->speed, by);
    for (int i = 0; i < 2; i++) y->creep[i] = jo_dual_mul(by, y->slide[i]);
    y->creep[2] = jo_dual_mul(by, y->spin);
    /* linear theory; half axes grow with the root of the depth */
    const jo_dual root = jo_dual_root(y->depth), deeper = jo_dual_mul(root, y->depth);
    const jo_dual twist = jo_dual_mul(way, jo_dual_times(c->creep[2], deeper));
    y->force[0] = jo_dual_sub(none, jo_dual_times(c->creep[0], jo_dual_mul(y->depth, y->creep[0])));
    y->force[1] = jo_dual_sub(none, jo_dual_add(jo_dual_times(c->creep[1], jo_dual_mul(y->depth, y->creep[1])), jo_dual_mul(twist, y->creep[2])));
    const jo_dual drill = jo_dual_times(c->creep[3], jo_dual_mul(y->depth, y->depth));
    y->moment = jo_dual_sub(jo_dual_mul(twist, y->creep[1]), jo_dual_mul(drill, y->creep[2]));
    /* saturation */
    const jo_dual whole = jo_dual_sqrt(jo_dual_add(jo_dual_mul(y->force[0], y->force[0]), jo_dual_mul(y->force[1], y->force[1])));
    const jo_dual e = jo_dual_div(whole, jo_dual_times(x->mu, y->load));
    const jo_dual part = JO_RE(e.v) < 3.0 ? jo_dual_plus(jo_dual_mul(e, jo_dual_plus(jo_dual_times(jo_same(1.0 / 27.0), e), jo_same(-1.0 / 3.0))), jo_same(1.0))
                                          : jo_dual_div(one, e);
    for (int i = 0; i < 2; i++) y->force[i] = jo_dual_mul(part, y->force[i]);
    y->moment = jo_dual_mul(part, y->moment);
}

jo_rail_touch jo_rail_touch_of(const jo_rail_data *x, const jo_rail_patch *c, const jo_wheel_motion *m, jo_real along)
{
    jo_rail_touch y;
    const jo_dual none = jo_dual_constant(0.0);
    const jo_dual3 front = jo_dual3_of(rail_way, rail_none);
    y.along = along;
    y.touches = 0;
    section_at near = nearest(c, m, &y.along);
    const jo_dual head = jo_dual_of(c->head, jo_same(0.0));
    y.depth = jo_dual_sub(head, near.distance);
    /* a wheel so far across the rail that a steep cone has no nearest place touches elsewhere than here */
    if (!(fabs(JO_RE(y.along)) < JO_RE(c->radius))) {
        y.along = jo_same(0.0);
        near = section_of(c, m, none);
        y.depth = jo_dual_constant(-JO_RE(c->radius));
    }
    y.down = near.normal;
    y.across = jo_dual3_cross(front, y.down);
    y.at = jo_dual3_sub(near.p, jo_dual3_times(head, y.down));
    /* velocities of the wheel on the rail at the point of contact */
    const jo_dual3 velocity = jo_dual3_add(m->v, jo_dual3_cross(m->w, y.at));
    press(x, c, &velocity, &y);
    y.slide[0] = jo_dual3_dot(velocity, front);
    y.slide[1] = jo_dual3_dot(velocity, y.across);
    y.spin = jo_dual_sub(none, jo_dual3_dot(m->w, y.down));
    /* rolling speed: travel of the contact less half of the slip */
    const jo_dual turns = jo_dual3_dot(m->w, m->n);
    const jo_dual rolled = jo_dual_mul(turns, jo_dual3_dot(front, jo_dual3_cross(m->n, y.at)));
    y.speed = jo_dual_sub(jo_dual_times(jo_same(0.5), y.slide[0]), rolled);
    for (int i = 0; i < 3; i++) y.creep[i] = none;
    for (int i = 0; i < 2; i++) y.force[i] = none;
    y.moment = none;
    if (y.touches) creep(x, c, &y);
    return y;
}
