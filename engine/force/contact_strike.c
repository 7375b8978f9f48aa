/* contact_strike.c - a point of contact that strikes by an impulse, see contact/impulses.c. */
#include "force/contact_point.h"

int jo_contact_may_strike(const jo_contact_law *x) { return JO_RE(x->resolve) == JO_RESOLVE_IMPULSE; }

/* two tangents of a normal n */
static void tangents(const jo_real *n, jo_real *t, jo_real *b)
{
    jo_real e[3] = {0.0, 0.0, 0.0};
    int least = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(JO_RE(n[i])) < fabs(JO_RE(n[least]))) least = i;
    e[least] = jo_same(1.0);
    jo_cross(t, n, e);
    const jo_real size = jo_length3(t);
    for (int i = 0; i < 3; i++) t[i] /= size;
    jo_cross(b, n, t);
}

int jo_contact_strike(const jo_contact_law *x, int waits, const jo_force *f, int first, const jo_real *state, const jo_contact_point *y, jo_strike *s)
{
    const int closed = jo_contact_phase(state) != JO_CONTACT_APART && JO_RE(y->depth) > 0.0;
    if (!closed && !(JO_RE(y->depth + y->rate * JO_CONTACT_SOON) > 0.0 && (waits || JO_RE(y->rate) > 0.0))) return 0;
    s->force = f;
    s->first = first;
    s->approach = first + JO_CONTACT_SPEED;
    s->since = first + JO_CONTACT_SINCE;
    s->closed = closed;
    s->rows = JO_RE(x->mu_kinetic) > 0.0 ? 3 : 1;
    jo_set3(s->lever, y->lever);
    jo_set3(s->axis, y->normal);
    tangents(y->normal, s->axis + 3, s->axis + 6);
    s->gap = -y->depth;
    s->mass = x->mass;
    s->slowest = x->slowest;
    s->restitution = x->restitution;
    s->mu = x->mu_kinetic;
    s->stiffness = x->stiffness;
    s->exponent = x->exponent;
    s->rests = 0;
    s->late = 0.0;
    return 1;
}
