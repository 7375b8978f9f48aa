/* contact_touch.c - a point at which two bodies touch, for reports: in the world, with its energies and powers. */
#include "maximal/maximal.h"
#include "force/contact_point.h"

static void copy3(double *y, const jo_real *x)
{
    for (int i = 0; i < 3; i++) y[i] = JO_RE(x[i]);
}

void jo_contact_touch(const jo_real *A, const jo_real *origin, const jo_contact_law *x, const jo_real *state, const jo_contact_point *y, jo_touch *t,
                      jo_real *sums)
{
    const int phase = jo_contact_phase(state);
    jo_real place[3], normal[3], tangential[3] = {0.0}, F[6];
    t->phase = phase != JO_CONTACT_APART && !(JO_RE(x->mu_static) > 0.0) ? JO_CONTACT_GLIDES : phase;
    t->force = t->number = t->shapes[0] = t->shapes[1] = -1.0;
    t->feature = 0.0;
    t->gap = -JO_RE(y->depth);
    t->rate = JO_RE(y->rate);
    t->speed = JO_RE(state[JO_CONTACT_SPEED]);
    t->since = JO_RE(state[JO_CONTACT_SINCE]);
    t->pressure = t->N = t->stored[0] = t->stored[1] = t->power[0] = t->power[1] = 0.0;
    /* contact point and normal in the world */
    jo_mul3(place, A, y->lever);
    jo_add3(place, origin);
    jo_mul3(normal, A, y->normal);
    if (phase != JO_CONTACT_APART && JO_RE(y->depth) > 0.0) {
        jo_work power = {0.0, 0.0, 0.0};
        jo_contact_force(x, phase, y, F, &power);
        jo_set3(tangential, F);
        jo_axpy3(tangential, -y->N, y->normal);
        const jo_real elastic = y->energy, bristle = jo_contact_energy(phase, y) - elastic;
        t->N = JO_RE(y->N);
        sums[0] += elastic;
        sums[1] += bristle;
        sums[2] += y->N;
        t->stored[0] = JO_RE(elastic);
        t->stored[1] = JO_RE(bristle);
        t->power[0] = JO_RE((y->N - y->elastic) * y->rate);
        t->power[1] = -JO_RE(jo_dot3(tangential, y->slip));
        jo_mul3(tangential, A, tangential);
    }
    copy3(t->place, place);
    copy3(t->normal, normal);
    copy3(t->friction, tangential);
}
