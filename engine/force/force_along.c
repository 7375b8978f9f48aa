/* force_along.c - force along a coordinate: springs, dampers, servos and actuators. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"

/* signal at `time`; 0 if there is no signal (-1) */
static jo_signal_work optional(const jo_model *m, const jo_data *d, int signal, jo_real time)
{
    const jo_signal_work none = {0.0, 0.0, 0.0};
    return signal < 0 ? none : jo_signal_at(m, d, signal, time);
}

/* f = stiffness (free + r - s) + damping (r' - s') + preload signal + spring(s) + damper(s'), within +-limit, at `time` */
static jo_real along_at(const jo_model *m, const jo_data *d, const jo_force *f, jo_real time)
{
    const jo_coordinate_work *w = &d->coordinate[f->coordinate];
    const jo_along_data *x = (const jo_along_data *)f->data;
    const jo_signal_work reference = optional(m, d, f->reference, time);
    jo_real y = x->stiffness * (x->free + reference.value - w->value) + x->damping * (reference.rate - w->rate);
    y += x->preload * (f->signal >= 0 ? jo_signal_at(m, d, f->signal, time).value : jo_same(1.0));
    y += optional(m, d, f->spring, w->value).value + optional(m, d, f->damper, w->rate).value;
    const jo_mask limited = JO_LESS(jo_same(0.0), x->limit);
    y = jo_choose(limited & JO_LESS(x->limit, y), x->limit, y);
    return jo_choose(limited & JO_LESS(y, -x->limit), -x->limit, y);
}

/* energy of the linear part of a passive spring, U = k (s - free)^2 / 2 - preload (s - free) */
static jo_real stored(const jo_data *d, const jo_force *f)
{
    const jo_along_data *x = (const jo_along_data *)f->data;
    const jo_real s = d->coordinate[f->coordinate].value - x->free;
    return f->active ? jo_same(0.0) : 0.5 * x->stiffness * s * s - x->preload * s;
}

/* force at the present time + lead; power of the damper, spring signal and active force */
static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *y)
{
    const jo_coordinate_work *w = &d->coordinate[f->coordinate];
    const jo_real damping = ((const jo_along_data *)f->data)->damping;
    const jo_real later = along_at(m, d, f, d->time[0] + stage->lead);
    if (f->active) {
        const jo_real now = stage->lead != 0.0 ? along_at(m, d, f, d->time[0]) : later;
        d->power.forces += now * w->rate;
    } else {
        d->power.damping += w->rate * (damping * w->rate - optional(m, d, f->damper, w->rate).value);
        d->power.forces += w->rate * optional(m, d, f->spring, w->value).value;
    }
    y->y[0] = later;
    y->stored = stored(d, f);
    jo_push_along(m, d, f->coordinate, later);
    return JO_OK;
}

/* df/ds = -stiffness + spring', df/ds' = -damping + damper'; 0 at the limit */
static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *y)
{
    (void)stage;
    const jo_along_data *x = (const jo_along_data *)f->data;
    const jo_coordinate_work *w = &d->coordinate[f->coordinate];
    jo_real fs = -x->stiffness, frate = -x->damping;
    jo_element e;
    jo_gradients g;
    if (f->spring >= 0) fs += jo_signal_at(m, d, f->spring, w->value).rate;
    if (f->damper >= 0) frate += jo_signal_at(m, d, f->damper, w->rate).rate;
    if (JO_COMMON(x->limit) > 0.0 && jo_most(jo_magnitude(y->y[0])) >= JO_COMMON(x->limit)) fs = frate = jo_same(0.0);
    jo_element_gradients(m, d, f->coordinate, &g);
    jo_element_start(&e, m->coordinate[f->coordinate].a, m->coordinate[f->coordinate].b);
    jo_element_along(d, &e, f->coordinate, &g, y->y[0], fs, frate);
    jo_element_finish(m, d, &e);
    return JO_OK;
}

const jo_force_kind jo_force_along = {apply, stored, tangent, 0, 0, 0};
