/* force.c - what pushes the bodies: loads at markers, springs, bushings, modal loads, user functions.
 *
 * Force F and torque T (world) at a marker: Q_R = F, Q_w = u x A^T F + A^T T, Q_p = Phi^T A^T F + (T(theta) Psi)^T A^T T
 * (Rantalainen 2007, eq. 3.68-3.83, corrected).
 */
#include "internal.h"

/* add force F and torque T, resolved in the body frame, to the body of the marker */
static void push(const jo_model *m, jo_data *d, int marker, const jo_real *F, const jo_real *T)
{
    const jo_marker *k = &m->marker[marker];
    if (k->body < 0) return;
    const jo_marker_work *w = &d->marker[marker];
    jo_body_work *bw = &d->body[k->body];
    const int np = m->body[k->body].np;
    jo_real t[3];
    jo_add3(bw->fr, F);
    jo_cross(t, w->u, F);
    jo_add3(bw->fr + 3, t);
    jo_add3(bw->fr + 3, T);
    if (k->Phi)
        for (int j = 0; j < np; j++)
            bw->fp[j] += w->Phi[j] * F[0] + w->Phi[np + j] * F[1] + w->Phi[2 * np + j] * F[2];
    if (k->Psi) {
        jo_mul3t(t, w->T, T);
        for (int j = 0; j < np; j++)
            bw->fp[j] += w->Psi[j] * t[0] + w->Psi[np + j] * t[1] + w->Psi[2 * np + j] * t[2];
    }
}

/* the same from the world frame */
void jo_push(const jo_model *m, jo_data *d, int marker, const jo_real *F, const jo_real *T)
{
    const int body = m->marker[marker].body;
    jo_real f[3], t[3];
    if (body < 0) return;
    jo_mul3t(f, d->body[body].A, F);
    jo_mul3t(t, d->body[body].A, T);
    push(m, d, marker, f, t);
}

static void load(const jo_model *m, jo_data *d, const jo_force *f, jo_force_work *y)
{
    const jo_marker_work *w = &d->marker[f->b];
    jo_real F[3], T[3], v[3], om[3], factor = 1.0, now = 1.0;
    if (f->signal >= 0) {
        factor = jo_signal_at(m, d, f->signal, d->time[0] + d->lead).value;
        now = d->lead != 0.0 ? jo_signal_at(m, d, f->signal, d->time[0]).value : factor;
    }
    jo_set3(F, f->data);
    jo_set3(T, f->data + 3);
    if (f->follow) {
        jo_mul3(F, w->A, F);
        jo_mul3(T, w->A, T);
    }
    jo_to_world(v, m, d, f->b, w->v);
    d->power[2] += now * jo_dot3(F, v);
    if (m->marker[f->b].turns) {
        jo_to_world(om, m, d, f->b, w->om);
        d->power[2] += now * jo_dot3(T, om);
    }
    for (int j = 0; j < 3; j++) {
        y->y[j] = F[j] *= factor;
        y->y[3 + j] = T[j] *= factor;
    }
    jo_push(m, d, f->b, F, T);
}

int jo_apply_forces(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        switch (f->type) {
        case JO_LOAD: load(m, d, f, &d->force[i]); break;
        default: break;
        }
    }
    return JO_OK;
}
