/* force_pid.c - PID controller along a coordinate with filtered derivative and back-calculation (anti-windup).
 *
 * Reference r, measured value y (coordinate or its rate) (Astrom and Hagglund, Advanced PID Control,
 * 2006, ch. 3):
 *   u = kp (b r - y) + I - kd cut (y - yf) + feedforward, f = u within lower .. upper
 *   I' = ki (r - y) + unwind (f - u), yf' = cut (y - yf)
 * cut = 1 / filter, or 1 / (filter_share kd / kp) if filter is 0; unwind = 1 / tracking, or 1 / (tracking_share kp / ki) if tracking is 0;
 * both are 0 if there is no such time. States: I, yf.
 */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"

#define JO_SLOW_SHARE 1e-3  /* rates below this share of size of the mechanism / duration of the run do not count (step_control.c) */

typedef struct {
    jo_real y, r, rest;     /* measured value, reference, u - I */
} parts;

static const jo_pid_data *numbers(const jo_force *f) { return (const jo_pid_data *)f->data; }

/* 1 / time, or 1 / (share gain / by) if time is 0; 0 if both times are 0 */
static jo_real rate_of(jo_real time, jo_real share, jo_real gain, jo_real by)
{
    const jo_real none = jo_same(0.0), usual = jo_choose(JO_LESS(none, share), share * gain / by, none);
    const jo_real taken = jo_choose(JO_LESS(none, time), time, usual);
    return jo_choose(JO_LESS(none, taken), 1.0 / taken, none);
}

static jo_real cut_of(const jo_pid_data *x) { return rate_of(x->filter, x->filter_share, x->derivative, x->proportional); }
static jo_real unwind_of(const jo_pid_data *x) { return rate_of(x->tracking, x->tracking_share, x->proportional, x->integral); }

static jo_real measured(const jo_data *d, const jo_force *f)
{
    const jo_coordinate_work *w = &d->coordinate[f->coordinate];
    return jo_choose(JO_LESS(jo_same(0.0), numbers(f)->speed), w->rate, w->value);
}

static parts parts_at(const jo_model *m, const jo_data *d, const jo_force *f, jo_real filtered, jo_real time)
{
    const jo_pid_data *x = numbers(f);
    parts p;
    p.y = measured(d, f);
    p.r = jo_signal_at(m, d, f->reference, time).value;
    p.rest = x->proportional * (x->weight * p.r - p.y) - x->derivative * cut_of(x) * (p.y - filtered);
    if (f->signal >= 0) p.rest += jo_signal_at(m, d, f->signal, time).value;
    return p;
}

static jo_real limited(const jo_pid_data *x, jo_real u)
{
    u = jo_choose(JO_LESS(x->upper, u), x->upper, u);
    return jo_choose(JO_LESS(u, x->lower), x->lower, u);
}

/* whether u > upper or u < lower */
static jo_mask beyond(const jo_pid_data *x, jo_real u)
{
    return JO_LESS(x->upper, u) | JO_LESS(u, x->lower);
}

/* States of an implicit step at the present position and velocity. If u without limits is beyond a limit, the rate of I includes the
 * back-calculation; this rate decreases with I, so that the solution is unique and beyond the same limit. */
static void condense(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f)
{
    const jo_pid_data *x = numbers(f);
    const jo_real time = d->time[0], none = jo_same(0.0), cut = cut_of(x), *s = jo_states(m, d) + f->state;
    const jo_real filtered = jo_condense_state(m, d, stage, f->state + 1, cut * (measured(d, f) - s[1]), cut);
    const parts p = parts_at(m, d, f, filtered, time);
    const jo_real rate = x->integral * (p.r - p.y);
    const jo_real u = p.rest + jo_condense_state(m, d, stage, f->state, rate, none);
    if (!jo_some(beyond(x, u))) return;
    const jo_real unwind = jo_choose(beyond(x, u), unwind_of(x), none);
    jo_condense_state(m, d, stage, f->state, rate + unwind * (limited(x, u) - u), unwind);
}

/* derivatives for the matrix of a Rosenbrock method; 0 if the force is limited */
static void slopes(jo_data *d, const jo_force *f, jo_real u, jo_force_work *y)
{
    const jo_pid_data *x = numbers(f);
    const jo_real none = jo_same(0.0), one = jo_same(1.0), cut = cut_of(x), steep = x->derivative * cut;
    const jo_mask out = beyond(x, u), speed = JO_LESS(none, x->speed);
    const jo_real slope = jo_choose(out, none, x->proportional + steep), windup = jo_choose(out, none, -x->integral);
    jo_slopes_of_state *s = d->forces.slopes + f->state;
    y->stiffness = jo_choose(speed, none, slope);
    y->damping = jo_choose(speed, slope, none);
    s[0].force = jo_choose(out, none, one);
    s[0].decay = jo_choose(out, unwind_of(x), none);
    s[0].value = jo_choose(speed, none, windup);
    s[0].rate = jo_choose(speed, windup, none);
    s[1].force = jo_choose(out, none, steep);
    s[1].decay = cut;
    s[1].value = jo_choose(speed, none, cut);
    s[1].rate = jo_choose(speed, cut, none);
}

/* u = rest + I, f = u within the limits, rates of I and yf; power */
static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *y)
{
    const jo_pid_data *x = numbers(f);
    const jo_real none = jo_same(0.0), *s = jo_states(m, d) + f->state;
    if (jo_condenses(stage)) condense(m, d, stage, f);
    const parts p = parts_at(m, d, f, s[1], d->time[0] + stage->lead);
    const jo_real u = p.rest + s[0], force = limited(x, u);
    if (!jo_condenses(stage)) {
        const jo_real unwind = jo_choose(beyond(x, u), unwind_of(x), none);
        jo_real *rate = jo_state_rates(m, d) + f->state;
        rate[0] = x->integral * (p.r - p.y) + unwind * (force - u);
        rate[1] = cut_of(x) * (p.y - s[1]);
        if (stage->set && !stage->earlier) slopes(d, f, u, y);
    }
    const jo_real now = stage->lead != 0.0 ? limited(x, parts_at(m, d, f, s[1], d->time[0]).rest + s[0]) : force;
    d->power.forces += now * d->coordinate[f->coordinate].rate;
    y->y[0] = force;
    y->stored = none;
    jo_push_along(m, d, f->coordinate, force);
    return JO_OK;
}

/* derivatives of the force: in a step with the response of the states; for equilibria and vibrations with constant I and yf = y */
static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *y)
{
    const jo_pid_data *x = numbers(f);
    const double ca = stage->weights.a, cv = stage->weights.v;
    const jo_real none = jo_same(0.0), u = parts_at(m, d, f, jo_states(m, d)[f->state + 1], d->time[0]).rest + jo_states(m, d)[f->state];
    const jo_mask free = JO_LESS_OR_EQUAL(jo_magnitude(limited(x, u) - u), none);
    const jo_real cut = cut_of(x);
    jo_real slope = -x->proportional, damping = none;
    if (ca != 0.0 && cv != 0.0) slope -= x->integral * (cv / ca) + x->derivative * cut * ca / (ca + cv * cut);
    else damping = -x->derivative;
    const jo_mask speed = JO_LESS(none, x->speed);
    const jo_real fs = jo_choose(free, jo_choose(speed, none, slope), none);
    const jo_real frate = jo_choose(free, jo_choose(speed, slope, damping), none);
    jo_element e;
    jo_gradients g;
    jo_element_gradients(m, d, f->coordinate, &g);
    jo_element_start(&e, m->coordinate[f->coordinate].a, m->coordinate[f->coordinate].b);
    jo_element_along(d, &e, f->coordinate, &g, y->y[0], fs, frate);
    jo_element_finish(m, d, &e);
    return JO_OK;
}

static void start(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x)
{
    (void)m;
    x[0] = numbers(f)->start;
    x[1] = measured(d, f);
}

/* nominal values of the states: of yf the size of the mechanism or 1 rad (for rates JO_SLOW_SHARE of it / duration), of I this value times
 * kp + ki duration */
static void nominals(const jo_model *m, const jo_force *f, double duration, double *x)
{
    const jo_pid_data *p = numbers(f);
    const int angle = m->coordinate[f->coordinate].type == JO_COORDINATE_ANGLE;
    double y = angle || !(m->size > 0.0) ? 1.0 : m->size;
    if (JO_COMMON(p->speed) > 0.0) y *= JO_SLOW_SHARE / duration;
    x[0] = (jo_most(p->proportional) + jo_most(p->integral) * duration) * y;
    x[1] = y;
}

const jo_force_kind jo_force_pid = {apply, 0, tangent, start, nominals, 0};
