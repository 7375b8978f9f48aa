/* force_gear_spring.c - spring and damper between two coordinates with a gear ratio: an elastic gear between a joint and its motor.
 *
 * e = s - s_2 / N - free, f = -k e - c e' + spring(e). The virtual work f de gives the force f along s and -f / N along s_2.
 */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"

static const jo_gear_spring_data *numbers(const jo_force *f) { return (const jo_gear_spring_data *)f->data; }

/* deformation e, m or rad, on the side of s */
static jo_real deformation(const jo_data *d, const jo_force *f)
{
    const jo_gear_spring_data *x = numbers(f);
    return d->coordinate[f->coordinate].value - d->coordinate[f->other].value / x->ratio - x->free;
}

static jo_real deformation_rate(const jo_data *d, const jo_force *f)
{
    return d->coordinate[f->coordinate].rate - d->coordinate[f->other].rate / numbers(f)->ratio;
}

/* force of the function of e and its slope; 0 without a function */
static jo_signal_work table(const jo_model *m, const jo_data *d, const jo_force *f, jo_real e)
{
    const jo_signal_work none = {0.0, 0.0, 0.0};
    return f->spring < 0 ? none : jo_signal_at(m, d, f->spring, e);
}

/* energy of the linear part, k e^2 / 2; the function counts as work */
static jo_real stored(const jo_data *d, const jo_force *f)
{
    const jo_real e = deformation(d, f);
    return 0.5 * numbers(f)->stiffness * e * e;
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *y)
{
    (void)stage;   /* the force does not depend on time */
    const jo_gear_spring_data *x = numbers(f);
    const jo_real e = deformation(d, f), rate = deformation_rate(d, f);
    const jo_signal_work more = table(m, d, f, e);
    const jo_real force = more.value - x->stiffness * e - x->damping * rate;
    y->y[0] = force;
    y->y[1] = -force / x->ratio;
    y->stiffness = x->stiffness - more.rate;   /* for the matrix of a Rosenbrock method */
    y->damping = x->damping;
    y->stored = stored(d, f);
    d->power.damping += x->damping * rate * rate;
    d->power.forces += rate * more.value;
    jo_push_along(m, d, f->coordinate, y->y[0]);
    jo_push_along(m, d, f->other, y->y[1]);
    return JO_OK;
}

/* Derivatives of the force y along `row` with respect to the motion of the coordinate `column`, with the slopes ys, yrate. The element of
 * the coordinate itself has the derivative of its gradient as well. */
static void add_slopes(const jo_model *m, jo_data *d, int row, int column, const jo_gradients *g, jo_real y, jo_real ys, jo_real yrate)
{
    const jo_coordinate *r = &m->coordinate[row], *c = &m->coordinate[column];
    jo_element e;
    jo_element_start(&e, r->a, r->b);
    if (row == column) jo_element_along(d, &e, row, g, y, ys, yrate);
    else jo_element_cross(d, &e, row, c->a, c->b, g, ys, yrate);
    jo_element_finish(m, d, &e);
}

/* df/de = -k + spring', df/de' = -c; de = ds - ds_2 / N */
static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *y)
{
    (void)stage;
    const jo_gear_spring_data *x = numbers(f);
    const int at[2] = {f->coordinate, f->other};
    const jo_real share[2] = {jo_same(1.0), -1.0 / x->ratio};
    const jo_real slope = table(m, d, f, deformation(d, f)).rate - x->stiffness;
    for (int c = 0; c < 2; c++) {
        jo_gradients g;
        jo_element_gradients(m, d, at[c], &g);
        for (int r = 0; r < 2; r++)
            add_slopes(m, d, at[r], at[c], &g, y->y[r], share[r] * share[c] * slope, -share[r] * share[c] * x->damping);
    }
    return JO_OK;
}

const jo_force_kind jo_force_gear_spring = {apply, stored, tangent, 0, 0, 0};
