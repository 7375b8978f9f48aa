/* force_states.c - first-order states x' = f(t, q, v, x) of forces, as the methods integrate them.
 *
 * They follow the velocities in what is integrated. RK4 and DormandPrince take f as it is; so does ROS2, but for forces along joint
 * coordinates, whose states it has in its matrix (tree_forces.c). The implicit methods take the generalised alpha method for
 * equations of first order, of the same coefficients, and solve for the state at every position and velocity that Newton's method
 * tries: a force with states is then one of q and v, and its tangent has what the states answer.
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
