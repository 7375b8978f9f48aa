/* contact_tip.c - where the sphere, circle of spheres, or ellipsoid of b touches a shape of a, and how this place changes. */
#include "newton/newton.h"
#include "contact/contact.h"
#include "force/contact_tip.h"

/* tilt of a cylinder, rad, below which the points of its rim do not follow its lowest one: it stands, and that is not defined */
#define JO_STANDS 1e-9

static jo_real sine_of(const jo_contact_data *x) { return JO_RE(x->around) > 0.0 ? sin(JO_RE(x->around) - 1.0) : 0.0; }

/* y = u cos a + z x u sin a */
static void turned(const jo_contact_data *x, const jo_real *axis, const jo_real *u, jo_real *y)
{
    jo_set3(y, u);
    if (!(JO_RE(x->around) > 0.0)) return;
    jo_real t[3];
    const double c = cos(JO_RE(x->around) - 1.0);
    jo_cross(t, axis, u);
    for (int i = 0; i < 3; i++) y[i] = c * u[i] + sine_of(x) * t[i];
}

/* Vector from the centre of a ring to one of its points: ring (u cos a + z x u sin a), z its axis, u towards its lowest point, in direction -n:
 * u = x / |x|, x = (n . z) z - n. The points of a rim of a cylinder (around > 0, a = around - 1) have x + JO_STANDS e, e: first axis of b. */
static void lowest(const jo_contact_data *x, const jo_real *R, const jo_real *n, jo_contact_tip *tip)
{
    const int stands = JO_RE(x->around) > 0.0;
    jo_axis(tip->axis, R, 2);
    jo_axis(tip->first, R, 0);
    tip->along = jo_dot3(n, tip->axis);
    for (int i = 0; i < 3; i++) tip->down[i] = tip->along * tip->axis[i] - n[i] + (stands ? JO_STANDS * tip->first[i] : jo_same(0.0));
    tip->sine = jo_length3(tip->down);
    for (int i = 0; i < 3; i++) tip->down[i] = JO_RE(tip->sine) > 0.0 ? tip->down[i] / tip->sine : tip->first[i];   /* flat on the plane */
    turned(x, tip->axis, tip->down, tip->out);
    jo_axpy3(tip->arm, x->ring, tip->out);
}

/* change of ring u with a rotation e */
static void lowest_change(const jo_contact_data *x, const jo_contact_tip *tip, const jo_real *e, jo_real *c)
{
    if (!(JO_RE(tip->sine) > 0.0)) return;
    const jo_real *n = tip->from.normal, *u = tip->down;
    jo_real dz[3], de[3], du[3], out[3], t[3];
    jo_cross(dz, e, tip->axis);
    jo_cross(de, e, tip->first);
    const jo_real dalong = jo_dot3(n, dz);
    for (int i = 0; i < 3; i++) {
        du[i] = dalong * tip->axis[i] + tip->along * dz[i];
        if (JO_RE(x->around) > 0.0) du[i] += JO_STANDS * de[i];
    }
    const jo_real along = jo_dot3(u, du);
    for (int i = 0; i < 3; i++) du[i] = (du[i] - along * u[i]) / tip->sine;
    turned(x, tip->axis, du, out);
    if (JO_RE(x->around) > 0.0) {
        jo_cross(t, dz, u);
        jo_axpy3(out, sine_of(x), t);
    }
    jo_axpy3(c, x->ring, out);
}

/* Vector from the centre of an ellipsoid with the half axes D to its lowest point over a half-space: p = -D^2 m / |D m|, m = R^T n. */
static void support(const jo_contact_data *x, const jo_real *R, const jo_real *n, jo_contact_tip *tip)
{
    jo_real p[3], arm[3], square = jo_same(0.0);
    for (int i = 0; i < 9; i++) tip->R[i] = R[i];
    jo_mul3t(tip->up, R, n);
    for (int i = 0; i < 3; i++) {
        p[i] = -x->axes[i] * x->axes[i] * tip->up[i];
        square -= p[i] * tip->up[i];
    }
    tip->below = jo_sqrt(square);
    for (int i = 0; i < 3; i++) p[i] /= tip->below;
    jo_mul3(arm, R, p);
    jo_add3(tip->arm, arm);
}

/* change of R p with a rotation e, less e x R p: R dp, with dm = -R^T (e x n) */
static void support_change(const jo_contact_data *x, const jo_contact_tip *tip, const jo_real *e, jo_real *c)
{
    jo_real t[3], dm[3], dp[3], out[3], along = jo_same(0.0);
    jo_cross(t, tip->from.normal, e);
    jo_mul3t(dm, tip->R, t);
    for (int i = 0; i < 3; i++) along += x->axes[i] * x->axes[i] * tip->up[i] * dm[i];
    along /= tip->below * tip->below;
    for (int i = 0; i < 3; i++) dp[i] = x->axes[i] * x->axes[i] * (along * tip->up[i] - dm[i]) / tip->below;
    jo_mul3(out, tip->R, dp);
    jo_add3(c, out);
}

/* whether another point of b touches as b turns */
static int is_moving(const jo_contact_data *x) { return JO_RE(x->ring) > 0.0 || JO_RE(x->axes[0]) > 0.0; }

void jo_contact_place(const jo_data *d, const jo_force *f, jo_contact_tip *tip, jo_contact_point *y)
{
    const jo_contact_data *x = (const jo_contact_data *)f->data;
    jo_real R[9], at[3];
    jo_relative_pose(d, f, at, R);
    jo_mul3(tip->arm, R, x->centre);
    static const jo_real up[3] = {0.0, 0.0, 1.0};   /* of a half-space */
    if (JO_RE(x->ring) > 0.0) lowest(x, R, up, tip);
    if (JO_RE(x->axes[0]) > 0.0) support(x, R, up, tip);
    jo_add3(at, tip->arm);
    jo_shape_distance((int)JO_COMMON(x->shape), x->size, at, &tip->from);
    jo_set3(y->normal, tip->from.normal);
    y->depth = x->radius - tip->from.gap;
    y->rate = jo_same(0.0);
    for (int i = 0; i < 3; i++) {
        y->lever[i] = tip->arm[i] - (x->radius - 0.5 * y->depth) * y->normal[i];
        y->slip[i] = jo_same(0.0);
    }
}

jo_contact_change jo_contact_tip_change(const jo_contact_data *x, const jo_contact_tip *tip, const jo_contact_point *y, int k)
{
    jo_contact_change c = {0.0, 0.0, {0.0}, {0.0}, {0.0}};
    jo_real e[3] = {0.0, 0.0, 0.0};
    e[k % 3] = 1.0;
    if (k < 6) {
        jo_real centre[3] = {0.0, 0.0, 0.0};
        if (k < 3) jo_set3(centre, e);
        else jo_cross(centre, e, tip->arm);
        if (k >= 3 && JO_RE(x->ring) > 0.0) {   /* the axis carries the centre, not the lowest point */
            jo_real fixed[3];
            jo_set3(fixed, tip->arm);
            jo_axpy3(fixed, -x->ring, tip->out);
            jo_cross(centre, e, fixed);
            lowest_change(x, tip, e, centre);
        }
        if (k >= 3 && JO_RE(x->axes[0]) > 0.0) support_change(x, tip, e, centre);
        c.depth = -jo_dot3(y->normal, centre);
        jo_mul3(c.normal, tip->from.hessian, centre);
        if (k >= 3) jo_set3(c.lever, centre);
        for (int i = 0; i < 3; i++) c.lever[i] += 0.5 * c.depth * y->normal[i] - (x->radius - 0.5 * y->depth) * c.normal[i];
    }
    jo_contact_rates(y, k, &c);
    return c;
}

/* largest curvature of the surfaces of constant distance outside of a shape, 1/m; INFINITY over edges. *face: the side or the end of a box
 * or cylinder over which the sphere is, known by the normal; each of these regions is convex */
static double curvature_over(const jo_contact_data *x, const jo_real *normal, int *face)
{
    const double r = JO_RE(x->size[0]);
    const int shape = (int)JO_COMMON(x->shape);
    *face = 0;
    if (shape == JO_SHAPE_HALF_SPACE) return is_moving(x) ? INFINITY : 0.0;
    if (shape == JO_SHAPE_ELLIPSOID) {   /* of the end of its longest axis, across the shortest */
        const double p = JO_RE(x->size[1]), q = JO_RE(x->size[2]), least = fmin(r, fmin(p, q));
        return fmax(r, fmax(p, q)) / (least * least);
    }
    if (shape == JO_SHAPE_TORUS) return 1.0 / JO_RE(x->size[1]);
    if (shape != JO_SHAPE_BOX && shape != JO_SHAPE_CYLINDER) return 1.0 / r;
    for (int i = shape == JO_SHAPE_BOX ? 0 : 2; i < 3; i++)
        if (fabs(JO_RE(normal[i])) == 1.0) {
            *face = 1 + 2 * i + (JO_RE(normal[i]) > 0.0);
            return 0.0;
        }
    return shape == JO_SHAPE_CYLINDER && JO_RE(normal[2]) == 0.0 ? 1.0 / r : INFINITY;
}

/* whether the distance from the shape is a convex function of the place: that from a convex body is */
static int is_convex(const jo_contact_data *x)
{
    switch ((int)JO_COMMON(x->shape)) {
    case JO_SHAPE_HALF_SPACE:
    case JO_SHAPE_SPHERE:
    case JO_SHAPE_CAPSULE:
    case JO_SHAPE_BOX:
    case JO_SHAPE_CYLINDER:
    case JO_SHAPE_ELLIPSOID: return !is_moving(x);
    default: return 0;
    }
}

/* that of the contact point less w x (lever - arm) */
void jo_contact_tip_velocity(const jo_contact_tip *tip, const jo_contact_point *y, jo_real *v)
{
    jo_real arm[3], turn[3];
    jo_set3(arm, y->lever);
    jo_sub3(arm, tip->arm);
    jo_cross(turn, y->w, arm);
    jo_set3(v, y->v);
    jo_sub3(v, turn);
}

/* The lowest point of an ellipsoid moves on it by at most its largest radius of curvature, times the angle by which it turns, so that the rate of
 * the gap changes by that times w^2 h beside what the acceleration changes. Returned is the curvature 1/m for which v^2 h gives twice that. */
static double curvature_of_support(const jo_contact_data *x, const jo_approach *to, const jo_contact_point *y)
{
    double longest = 0.0, least = INFINITY;
    for (int i = 0; i < 3; i++) {
        longest = fmax(longest, JO_RE(x->axes[i]));
        least = fmin(least, JO_RE(x->axes[i]));
    }
    const double speed = jo_approach_speed(to), spin = jo_length(y->w, 3);
    return speed > 0.0 ? 2.0 * longest * longest / least * spin * spin / (speed * speed) : INFINITY;
}

/* the centre of the sphere in frame a; of a ring its lowest point, which moves on the ring no faster than the ring turns */
void jo_contact_tip_approach(const jo_contact_data *x, const jo_contact_tip *tip, const jo_contact_point *y, jo_approach *to)
{
    jo_real v[3];
    jo_contact_tip_velocity(tip, y, v);
    to->gap = -JO_RE(y->depth);
    to->rate = -JO_RE(y->rate);
    for (int i = 0; i < 3; i++) to->v[i] = JO_RE(v[i]);
    to->convex = is_convex(x);
    to->curvature = curvature_over(x, y->normal, &to->face);
    if (JO_RE(x->axes[0]) > 0.0) to->curvature = curvature_of_support(x, to, y);
}
