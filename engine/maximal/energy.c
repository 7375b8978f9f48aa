/* energy.c - energies of the present state, and work of the last step. */
#include "maximal/maximal.h"
#include "force/force.h"
#include "beam/beam.h"
#include "tree/tree.h"

/* kinetic energy of a body: half of m V.V + 2 V.(w x S + I3 p') + w.(J w + 2 B p') + p'.p' */
static jo_real kinetic(const jo_body *b, const jo_body_work *w)
{
    jo_real t[3], Jw[3], x = b->mass[0] * jo_dot3(w->V, w->V);
    jo_cross(t, w->w, w->S);
    jo_sym3(Jw, w->J, w->w);
    for (int j = 0; j < b->n; j++) {
        for (int i = 0; i < 3; i++) {
            t[i] += b->I3[i * b->np + j] * w->pd[j];
            Jw[i] += 2.0 * w->B[i * b->np + j] * w->pd[j];
        }
        x += w->pd[j] * w->pd[j];
    }
    return 0.5 * (x + 2.0 * jo_dot3(w->V, t) + jo_dot3(w->w, Jw));
}

/* kinetic energy T, strain energy U, potential energy P = -g . (m R + A S), energy of springs */
void jo_energy(const jo_model *m, jo_data *d, jo_energies *out)
{
    jo_real T = {0.0}, U = {0.0}, P = {0.0}, unused = {0.0};
    jo_sync_maximal_state(m, d, JO_SYNC_STATE);
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        jo_body_work *w = &d->body[i];
        jo_real centre[3];
        jo_body_pose(b, w, d->q + b->iq);
        jo_body_twist(b, w, d->v + b->iv);
        jo_body_inertia(b, w, &unused);
        T += kinetic(b, w);
        for (int j = 0; j < b->n; j++) U += 0.5 * b->K[j] * w->p[j] * w->p[j];
        /* P = -g . (m R + A S) */
        jo_mul3(centre, w->A, w->S);
        jo_axpy3(centre, b->mass[0], d->q + b->iq);
        P -= jo_dot3(m->gravity, centre);
    }
    if (m->nbeam) {
        T += jo_beam_kinetic(m, d);
        U += jo_beam_stored(d);
    }
    out->kinetic = T;
    out->strain = U;
    out->potential = P;
    out->springs = jo_same(0.0);
    if (m->nforce) {
        jo_marker_position(m, d, m->nactive);
        if (m->ncoordinate) jo_coordinates(m, d, m->ncoordinate);
        out->springs = jo_stored(m, d);
    }
}

/* work of the last step by the trapezoidal rule, with the power at its start and end. Powers of the stages are not used: for modes that
 * the step does not resolve they are inaccurate. */
void jo_add_step_work(jo_data *d)
{
    d->work.damping += 0.5 * d->waiting * (d->power0.damping + d->power.damping);
    d->work.forces += 0.5 * d->waiting * (d->power0.forces + d->power.forces - d->drive);   /* drives: added in the stages */
    d->waiting = 0.0;
}
