/* force_stop.c - stops at the limits of a coordinate: contact force with dissipation by a given coefficient of restitution.
 *
 *   F = k d (1 + loss s(d'/speed)),   d: penetration beyond the limit, d' its rate,
 *   s(x) = x (3 - x^2)/2 for |x| < 1, else the sign of x
 *
 * loss = (1 - e^2)/(1 + e^2) gives the coefficient of restitution e for any mass and stiffness: with phi = 1 + loss s the equation
 * m v dv = -k d phi(v) dd separates, so that int_0^in v/phi(v) dv = int_0^out v/phi(-v) dv. F >= 0 as loss <= 1. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"

typedef struct {
    jo_real beyond, out, share, slope;   /* d, 1 or -1 for the side, loss s and its derivative with respect to d' */
} jo_stop_state;

/* penetration, side, loss s(d'/speed) and its derivative with respect to d', at the present coordinate */
static jo_stop_state state_of(const jo_data *d, const jo_force *f)
{
    const jo_coordinate_work *w = &d->coordinate[f->coordinate];
    const jo_stop_data *x = (const jo_stop_data *)f->data;
    const jo_real below = x->lower - w->value, above = w->value - x->upper;
    const jo_mask low = JO_LESS(jo_same(0.0), below), high = JO_LESS(jo_same(0.0), above);
    jo_stop_state y;
    y.beyond = jo_choose(high, above, jo_choose(low, below, jo_same(0.0)));
    y.out = jo_choose(high, jo_same(1.0), jo_same(-1.0));
    const jo_real r = y.out * w->rate / x->speed;
    const jo_mask slow = JO_LESS(jo_magnitude(r), jo_same(1.0));
    const jo_real sign = jo_choose(JO_LESS(r, jo_same(0.0)), jo_same(-1.0), jo_same(1.0));
    y.share = x->loss * jo_choose(slow, 0.5 * r * (3.0 - r * r), sign);
    y.slope = jo_choose(slow, 1.5 * x->loss * (1.0 - r * r) / x->speed, jo_same(0.0));
    return y;
}

/* energy k d^2 / 2 of the elastic part */
static jo_real stored(const jo_data *d, const jo_force *f)
{
    const jo_stop_state s = state_of(d, f);
    return 0.5 * ((const jo_stop_data *)f->data)->stiffness * s.beyond * s.beyond;
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *y)
{
    (void)stage;
    const jo_stop_state s = state_of(d, f);
    const jo_real elastic = -s.out * ((const jo_stop_data *)f->data)->stiffness * s.beyond;
    y->y[0] = elastic * (1.0 + s.share);
    y->stored = stored(d, f);
    d->power.damping -= elastic * s.share * d->coordinate[f->coordinate].rate;
    jo_push_along(m, d, f->coordinate, y->y[0]);
    return JO_OK;
}

static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *y)
{
    (void)stage;
    const jo_real k = ((const jo_stop_data *)f->data)->stiffness;
    const jo_stop_state s = state_of(d, f);
    const jo_real fs = jo_choose(JO_LESS(jo_same(0.0), s.beyond), -k * (1.0 + s.share), jo_same(0.0));
    jo_element e;
    jo_gradients g;
    jo_element_gradients(m, d, f->coordinate, &g);
    jo_element_start(&e, m->coordinate[f->coordinate].a, m->coordinate[f->coordinate].b);
    jo_element_along(d, &e, f->coordinate, &g, y->y[0], fs, -k * s.beyond * s.slope);
    jo_element_finish(m, d, &e);
    return JO_OK;
}

const jo_force_kind jo_force_stop = {apply, stored, tangent, 0, 0, 0};
