/* force_modal_load.c - distributed load on a body: force and torque on its frame and modal forces, times a signal. */
#include "newton/newton.h"
#include "force/force.h"

/* forces on the rigid and modal coordinates times the signal; power */
static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *out)
{
    jo_body_work *w = &d->body[f->body];
    const int np = m->body[f->body].np;
    const jo_modal_load_data *x = (const jo_modal_load_data *)f->data;
    const jo_real *modes = (const jo_real *)(x + 1);
    jo_real factor = jo_same(1.0), now = factor, power = jo_dot3(x->force, w->V) + jo_dot3(x->torque, w->w);
    if (f->signal >= 0) {
        factor = jo_signal_at(m, d, f->signal, d->time[0] + stage->lead).value;
        now = stage->lead != 0.0 ? jo_signal_at(m, d, f->signal, d->time[0]).value : factor;
    }
    for (int j = 0; j < np; j++) {
        power += modes[j] * w->pd[j];
        w->fp[j] += factor * modes[j];
    }
    for (int j = 0; j < 3; j++) w->fr[j] += factor * x->force[j];
    for (int j = 0; j < 3; j++) w->fr[3 + j] += factor * x->torque[j];
    jo_mul3(out->y, w->A, x->force);
    jo_mul3(out->y + 3, w->A, x->torque);
    for (int j = 0; j < 6; j++) out->y[j] *= factor;
    d->power.forces += now * power;
    return JO_OK;
}

/* derivative of the force A f on the origin, which rotates with the body: r_R -= A (dtheta x f) */
static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *y)
{
    const jo_block N = jo_newton_find(m, d, f->body, f->body);
    const jo_body_work *w = &d->body[f->body];
    jo_real x[3], M[9] = {0.0}, Q[9], P[9];
    jo_mul3t(x, w->A, y->y);
    M[1] = -x[2]; M[2] = x[1]; M[3] = x[2]; M[5] = -x[0]; M[6] = -x[1]; M[7] = x[0];
    jo_mul33(Q, w->A, M);
    jo_mul33(P, Q, w->turn);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) N.at[r * N.stride + 3 + c] += stage->weights.q * P[3 * r + c];
    return JO_OK;
}

const jo_force_kind jo_force_modal_load = {apply, 0, tangent, 0, 0, 0};
