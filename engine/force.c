/* force.c - signals of time, and forces and torques at markers (Rantalainen 2007, eq. 3.68-3.83). */
#include "internal.h"

static jo_real evaluate_signal(const jo_signal *s, jo_real time)
{
    const jo_real *x = s->data;
    const double t = JO_RE(time);
    switch (s->type) {
    case JO_HARMONIC:
        return x[0] + x[1] * jo_sin(x[2] * time + x[3]);
    case JO_STEP:
        return t < JO_RE(x[0]) ? x[1] : x[2];
    case JO_TABLE: {
        const jo_real *f = x + s->count;
        int low = 0, high = s->count - 1;
        if (t <= JO_RE(x[low])) return f[low];
        if (t >= JO_RE(x[high])) return f[high];
        while (high - low > 1) {
            int middle = (low + high) / 2;
            if (t < JO_RE(x[middle])) high = middle;
            else low = middle;
        }
        return f[low] + (f[high] - f[low]) * (time - x[low]) / (x[high] - x[low]);
    }
    default:
        return 1.0;
    }
}

void jo_apply_forces(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        const jo_marker *k = &m->marker[f->marker];
        if (k->body < 0) continue;
        const jo_marker_work *w = &d->marker[f->marker];
        jo_body_work *bw = &d->body[k->body];
        const int np = m->body[k->body].np;
        const jo_signal *signal = f->signal < 0 ? 0 : &m->signal[f->signal];
        const jo_real factor = signal ? evaluate_signal(signal, d->time[0] + d->lead) : 1.0;
        const jo_real now = signal && d->lead != 0.0 ? evaluate_signal(signal, d->time[0]) : factor;
        jo_real F[3], T[3], t[3], power;
        jo_set3(F, f->force);
        jo_set3(T, f->torque);
        if (f->follow) {
            jo_mul3(F, w->A, F);
            jo_mul3(T, w->A, T);
        }
        jo_mul3t(F, bw->A, F);
        jo_mul3t(T, bw->A, T);
        power = jo_dot3(F, w->v);
        if (k->turns) power += jo_dot3(T, w->om);
        d->power[1] += now * power;
        for (int j = 0; j < 3; j++) { F[j] *= factor; T[j] *= factor; }
        jo_add3(bw->fr, F);
        jo_cross(t, w->u, F);
        jo_add3(bw->fr + 3, t);
        jo_add3(bw->fr + 3, T);
        if (k->Phi)
            for (int j = 0; j < np; j++)
                bw->fp[j] += k->Phi[j] * F[0] + k->Phi[np + j] * F[1] + k->Phi[2 * np + j] * F[2];
        if (k->Psi) {
            jo_mul3t(T, w->T, T);
            for (int j = 0; j < np; j++)
                bw->fp[j] += k->Psi[j] * T[0] + k->Psi[np + j] * T[1] + k->Psi[2 * np + j] * T[2];
        }
    }
}
