/* coordinate.c - scalar functions of two frames for joints, drives, springs and friction: value, gradient, rate, acceleration.
 *
 * s' = along . (v_b - v_a) + turn_a . om_a + turn_b . om_b and s'' = the same with accelerations + bias, exact;
 * position, velocity, acceleration and virtual work follow from the same formula.
 */
#include "valid.h"
#include "maximal/maximal.h"

/* angle of (x, y) nearest to the last accepted one */
static jo_real unwrapped(const jo_model *m, const jo_data *d, const jo_coordinate *c, jo_real y, jo_real x)
{
    (void)m;
    jo_real angle = jo_arc_tangent(y, x);
    if (c->turn >= 0) angle += 2.0 * JO_PI * jo_floor((d->turn[c->turn] - angle) / (2.0 * JO_PI) + 0.5);
    return angle;
}

static void negative(jo_real *y, const jo_real *x) { y[0] = -x[0]; y[1] = -x[1]; y[2] = -x[2]; }

/* value and gradient along, turn_a, turn_b of a coordinate at the present markers */
void jo_coordinate_value(const jo_model *m, jo_data *d, int i)
{
    const jo_coordinate *c = &m->coordinate[i];
    const jo_marker_work *a = &d->marker[c->a], *b = &d->marker[c->b];
    jo_coordinate_work *w = &d->coordinate[i];
    jo_real f[3], h[3], r[3];
    for (int j = 0; j < 3; j++) w->along[j] = w->turn_a[j] = w->turn_b[j] = jo_same(0.0);
    jo_set3(r, b->r);
    jo_sub3(r, a->r);
    switch (c->type) {
    case JO_COORDINATE_AXES:
        jo_axis(f, a->A, c->axis_a);
        jo_axis(h, b->A, c->axis_b);
        w->value = jo_dot3(f, h);
        jo_cross(w->turn_a, f, h);
        jo_cross(w->turn_b, h, f);
        break;
    case JO_COORDINATE_ALONG:
        jo_axis(f, a->A, c->axis_a);
        w->value = jo_dot3(f, r);
        jo_set3(w->along, f);
        jo_cross(w->turn_a, f, r);
        break;
    case JO_COORDINATE_DISTANCE:
        w->value = jo_sqrt(jo_dot3(r, r));
        for (int j = 0; j < 3; j++) w->along[j] = r[j] / w->value;
        break;
    case JO_COORDINATE_RIM:
    case JO_COORDINATE_ROLLED:
    case JO_COORDINATE_SLIP:
    case JO_COORDINATE_ACROSS: jo_rolling_value(c, a, b, w); break;
    case JO_COORDINATE_RAIL_GAP:
    case JO_COORDINATE_RAIL_ROLLED:
    case JO_COORDINATE_RAIL_ACROSS: jo_rail_value(c, a, b, w); break;
    case JO_COORDINATE_ROPE: jo_rope_value(c, a, b, w); break;
    default: {   /* ANGLE: atan2(f_b . g_a, f_b . f_a) */
        jo_real g[3], u[3], v[3];
        jo_axis(f, a->A, 0);
        jo_axis(g, a->A, 1);
        jo_axis(h, b->A, 0);
        const jo_real x = jo_dot3(h, f), y = jo_dot3(h, g), s = 1.0 / (x * x + y * y);
        w->value = unwrapped(m, d, c, y, x);
        jo_cross(u, h, g);
        jo_cross(v, h, f);
        for (int j = 0; j < 3; j++) w->turn_b[j] = s * (x * u[j] - y * v[j]);
        negative(w->turn_a, w->turn_b);
        break;
    }
    }
}

/* value and gradient of the first `count` coordinates */
void jo_coordinates(const jo_model *m, jo_data *d, int count)
{
    for (int i = 0; i < count; i++)
        if (!jo_coordinate_inactive(d, i)) jo_coordinate_value(m, d, i);
}

void jo_gradient_change(const jo_coordinate *c, const jo_marker_work *a, const jo_marker_work *b, const jo_real *dr, const jo_real *pa,
                        const jo_real *pb, jo_real *along, jo_real *turn_a, jo_real *turn_b)
{
    if (c->type == JO_COORDINATE_ROPE) jo_rope_change(c, a, b, dr, pa, pb, along, turn_a, turn_b);
    else if (c->type < JO_COORDINATE_RAIL_GAP || c->type == JO_COORDINATE_SLIP) jo_rolling_change(c, a, b, dr, pa, pb, along, turn_a, turn_b);
    else jo_rail_change(c, a, b, dr, pa, pb, along, turn_a, turn_b);
}

/* (u_a . h_b)'' without angular accelerations, u an axis of a: u'' . h + 2 u' . h' + u . h'' */
static jo_real second_order(const jo_real *u, const jo_real *oma, const jo_real *h, const jo_real *omb)
{
    jo_real ud[3], udd[3], hd[3], hdd[3];
    jo_cross(ud, oma, u);
    jo_cross(udd, oma, ud);
    jo_cross(hd, omb, h);
    jo_cross(hdd, omb, hd);
    return jo_dot3(udd, h) + 2.0 * jo_dot3(ud, hd) + jo_dot3(u, hdd);
}

/* rate s' and velocity-dependent part `bias` of s'', after jo_coordinate_value and jo_marker_velocity */
void jo_coordinate_rate(const jo_model *m, jo_data *d, int i)
{
    const jo_coordinate *c = &m->coordinate[i];
    const jo_marker_work *a = &d->marker[c->a], *b = &d->marker[c->b];
    jo_coordinate_work *w = &d->coordinate[i];
    jo_real v[3], t[3], oma[3], omb[3], f[3], h[3];
    jo_to_world(t, m, d, c->a, a->v);
    jo_to_world(v, m, d, c->b, b->v);
    jo_sub3(v, t);
    jo_to_world(oma, m, d, c->a, a->om);
    jo_to_world(omb, m, d, c->b, b->om);
    w->rate = jo_dot3(w->along, v) + jo_dot3(w->turn_a, oma) + jo_dot3(w->turn_b, omb);
    switch (c->type) {
    case JO_COORDINATE_AXES:
        jo_axis(f, a->A, c->axis_a);
        jo_axis(h, b->A, c->axis_b);
        w->bias = second_order(f, oma, h, omb);
        break;
    case JO_COORDINATE_ALONG: {   /* 2 f' . v + (om x f') . r */
        jo_real fd[3], fdd[3], r[3];
        jo_set3(r, b->r);
        jo_sub3(r, a->r);
        jo_axis(f, a->A, c->axis_a);
        jo_cross(fd, oma, f);
        jo_cross(fdd, oma, fd);
        w->bias = 2.0 * jo_dot3(fd, v) + jo_dot3(fdd, r);
        break;
    }
    case JO_COORDINATE_DISTANCE:
        w->bias = (jo_dot3(v, v) - w->rate * w->rate) / w->value;
        break;
    case JO_COORDINATE_RIM:
    case JO_COORDINATE_ROLLED:
    case JO_COORDINATE_ACROSS:
    case JO_COORDINATE_RAIL_GAP:
    case JO_COORDINATE_RAIL_ROLLED:
    case JO_COORDINATE_RAIL_ACROSS:
    case JO_COORDINATE_SLIP: case JO_COORDINATE_ROPE: {   /* change of the gradient with the motion */
        jo_real along[3], turn_a[3], turn_b[3];
        jo_gradient_change(c, a, b, v, oma, omb, along, turn_a, turn_b);
        w->bias = jo_dot3(along, v) + jo_dot3(turn_a, oma) + jo_dot3(turn_b, omb);
        break;
    }
    default: {   /* (x y'' - y x'' - 2 s' (x x' + y y')) / (x^2 + y^2) */
        jo_real g[3], hd[3], fd[3], gd[3];
        jo_axis(f, a->A, 0);
        jo_axis(g, a->A, 1);
        jo_axis(h, b->A, 0);
        jo_cross(fd, oma, f);
        jo_cross(gd, oma, g);
        jo_cross(hd, omb, h);
        const jo_real x = jo_dot3(h, f), y = jo_dot3(h, g);
        const jo_real xd = jo_dot3(hd, f) + jo_dot3(h, fd), yd = jo_dot3(hd, g) + jo_dot3(h, gd);
        const jo_real xdd = second_order(f, oma, h, omb), ydd = second_order(g, oma, h, omb);
        w->bias = (x * ydd - y * xdd - 2.0 * w->rate * (x * xd + y * yd)) / (x * x + y * y);
        break;
    }
    }
}

/* rate and bias of the first `count` coordinates */
void jo_coordinates_rate(const jo_model *m, jo_data *d, int count)
{
    for (int i = 0; i < count; i++)
        if (!jo_coordinate_inactive(d, i)) jo_coordinate_rate(m, d, i);
}

/* counted angles = present values */
void jo_count_turns(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->ncoordinate; i++)
        if (m->coordinate[i].turn >= 0) d->turn[m->coordinate[i].turn] = d->coordinate[i].value;
}

/* s'' after jo_evaluate */
jo_real jo_coordinate_acceleration(const jo_model *m, const jo_data *d, int coordinate)
{
    const jo_coordinate *c = &m->coordinate[coordinate];
    const jo_coordinate_work *w = &d->coordinate[coordinate];
    jo_real a[6], b[6];
    jo_marker_acceleration(m, d, c->a, a);
    jo_marker_acceleration(m, d, c->b, b);
    for (int i = 0; i < 3; i++) b[i] -= a[i];
    return jo_dot3(w->along, b) + jo_dot3(w->turn_a, a + 3) + jo_dot3(w->turn_b, b + 3) + w->bias;
}
