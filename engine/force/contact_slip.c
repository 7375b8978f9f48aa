/* contact_slip.c - friction of a point of contact as a smooth function of its slip velocity v: F = -mu(|v|) N v / |v|.
 *
 * mu = mu_static w (15 - 10 w^2 + 3 w^4) / 8, w = |v| / velocity, for w < 1, then a quintic down to mu_kinetic at w = 2, as friction.c has it
 * for joints; twice continuously differentiable. No state, no events; a body that would stick creeps. */
#include "force/contact_point.h"

/* mu / |v| and its derivative with respect to v^2 */
static jo_real smooth(const jo_contact_law *x, jo_real square, jo_real *rate)
{
    const jo_real velocity = x->velocity, top = x->mu_static, fall = x->mu_kinetic - x->mu_static, w2 = square / (velocity * velocity);
    if (JO_RE(w2) < 1.0) {
        *rate = top * (6.0 * w2 - 10.0) / (8.0 * velocity * velocity * velocity);
        return top * (15.0 - w2 * (10.0 - 3.0 * w2)) / (8.0 * velocity);
    }
    const jo_real speed = jo_sqrt(square), s = speed / velocity - 1.0, left = 1.0 - s;
    jo_real mu = x->mu_kinetic, slope = jo_same(0.0);
    if (JO_RE(s) < 1.0) {
        mu = top + fall * s * s * s * (10.0 - s * (15.0 - 6.0 * s));
        slope = 30.0 * fall * s * s * left * left / velocity;
    }
    *rate = (slope - mu / speed) / (2.0 * square);
    return mu / speed;
}

jo_real jo_contact_smooth(const jo_contact_law *x, jo_real square)
{
    jo_real rate;
    return smooth(x, square, &rate);
}

void jo_contact_smooth_change(const jo_contact_law *x, const jo_contact_point *y, const jo_real *dv, jo_real dN, jo_real *dF)
{
    const jo_real *v = y->slip;
    jo_real rate;
    const jo_real g = smooth(x, jo_dot3(v, v), &rate), along = 2.0 * rate * y->N * jo_dot3(v, dv);
    for (int i = 0; i < 3; i++) dF[i] = -(g * dN + along) * v[i] - g * y->N * dv[i];
}
