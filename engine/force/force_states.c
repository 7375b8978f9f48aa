/* force_states.c - first-order states x' = f(t, q, v, x) of forces, as the methods integrate them.
 *
 * The states are the last entries of the integrated velocities. RK4 and DormandPrince evaluate f; so does a Rosenbrock method, except for forces along
 * joint coordinates, whose states are in its matrix (tree_forces.c). The implicit methods use the generalised alpha method for first-order
 * equations with the same coefficients and solve for x at each position and velocity of Newton's method: the force is then a function
 * of q and v, and its tangent includes the response of x.
 */
#include "force/force.h"

int jo_condenses(const jo_stage *stage) { return stage->weights.a != 0.0; }

/* x' + ca y = rate - decay (cv y) for the change y of the algorithmic rate, where `rate` is f at the present x; returns the new x */
jo_real jo_condense_state(const jo_model *m, jo_data *d, const jo_stage *stage, int state, jo_real rate, jo_real decay)
{
    const int i = m->nv + state;
    const double ca = stage->weights.a, cv = stage->weights.v;
    const jo_real y = (rate - d->a[i]) / (ca + cv * decay);
    d->rate[i] += y;
    d->a[i] += ca * y;
    d->v[i] += cv * y;
    return d->v[i];
}

/* states of a released force, and of a memory: constant */
void jo_keep_states(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f)
{
    const jo_real none = jo_same(0.0);
    for (int k = f->state; k < f->state + f->states; k++) {
        if (jo_condenses(stage)) jo_condense_state(m, d, stage, k, none, none);
        else jo_state_rates(m, d)[k] = none;
    }
}
