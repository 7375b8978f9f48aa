/* force_load.c - force and torque at a marker, constant in the world or in the marker frame, times a signal. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"

/* force and torque times the signal at the present time + lead; power with the signal at the present time */
static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *y)
{
    const jo_load_data *x = (const jo_load_data *)f->data;
    const jo_marker_work *w = &d->marker[f->b];
    jo_real F[3], T[3], v[3], om[3], factor = jo_same(1.0), now = factor;
    if (f->signal >= 0) {
        factor = jo_signal_at(m, d, f->signal, d->time[0] + stage->lead).value;
        now = stage->lead != 0.0 ? jo_signal_at(m, d, f->signal, d->time[0]).value : factor;
    }
    jo_set3(F, x->force);
    jo_set3(T, x->torque);
    if (f->follow) {
        jo_mul3(F, w->A, F);
        jo_mul3(T, w->A, T);
    }
    jo_to_world(v, m, d, f->b, w->v);
    d->power.forces += now * jo_dot3(F, v);
    if (m->marker[f->b].turns) {
        jo_to_world(om, m, d, f->b, w->om);
        d->power.forces += now * jo_dot3(T, om);
    }
    for (int j = 0; j < 3; j++) {
        y->y[j] = F[j] *= factor;
        y->y[3 + j] = T[j] *= factor;
    }
    jo_push(m, d, f->b, F, T);
    return JO_OK;
}

/* derivatives: 0 for loads in the world; dF = dphi x F, dT = dphi x T for loads in the marker frame */
static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *y)
{
    (void)stage;
    jo_element e;
    jo_element_start(&e, -1, f->b);
    for (int j = 0; j < 6; j++) e.y[6 + j] = y->y[j];
    if (f->follow) {
        jo_element_skew(&e, 6, JO_OF_B + JO_DPHI, jo_same(-1.0), e.y + 6);
        jo_element_skew(&e, 9, JO_OF_B + JO_DPHI, jo_same(-1.0), e.y + 9);
    }
    jo_element_finish(m, d, &e);
    return JO_OK;
}

const jo_force_kind jo_force_load = {apply, 0, tangent, 0, 0, 0};
