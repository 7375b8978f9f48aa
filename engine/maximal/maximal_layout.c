/* maximal_layout.c - memory of bodies, markers, joints and the matrix of multipliers. */
#include "maximal/maximal.h"

/* arrays of the bodies; arrays of a spare body while bytes are only counted */
static void lay_bodies(const jo_model *m, jo_data *d, jo_arena *a)
{
    for (int i = 0; i < m->nbody; i++) {
        jo_body_work spare, *w = a->base ? &d->body[i] : &spare;
        const int np = m->body[i].np;
        w->p = jo_take_reals(a, np);
        w->pd = jo_take_reals(a, np);
        w->D = jo_take_reals(a, 6 * np);
        w->B = jo_take_reals(a, 3 * np);
        w->G = jo_take_reals(a, 3 * np);
        w->maximal.Bw = jo_take_reals(a, 3 * np);
        w->fp = jo_take_reals(a, np);
        w->yp = jo_take_reals(a, np);
        w->maximal.extra = jo_take_reals(a, np);
        w->maximal.carried = jo_carries_trees(m, i) ? jo_take_reals(a, 36) : 0;
        for (int s = 0; s < 2; s++) {
            w->maximal.set[s].weight = jo_take_reals(a, np);
            w->maximal.set[s].I3w = jo_take_reals(a, 3 * np);
        }
    }
}

/* arrays of the markers */
static void lay_markers(const jo_model *m, jo_data *d, jo_arena *a)
{
    for (int i = 0; i < m->nmarker; i++) {
        jo_marker_work spare, *w = a->base ? &d->marker[i] : &spare;
        const jo_marker *k = &m->marker[i];
        w->maximal.shapes = k->chi ? jo_take_reals(a, 6 * m->body[k->body].np) : 0;
        w->Phi = k->chi && k->Phi ? w->maximal.shapes : k->Phi;
        w->Psi = k->chi && k->Psi && w->maximal.shapes ? w->maximal.shapes + 3 * m->body[k->body].np : k->Psi;
    }
    for (int i = 0; i < m->nactive; i++) {
        jo_marker_work spare, *w = a->base ? &d->marker[i] : &spare;
        const int np = m->marker[i].body < 0 ? 0 : m->body[m->marker[i].body].np;
        for (int s = 0; s < 2; s++) {
            w->maximal.set[s].Phiw = jo_take_reals(a, 3 * np);
            w->maximal.set[s].Psiw = jo_take_reals(a, 3 * np);
        }
    }
}

/* joints, and the matrix of their multipliers with its plan */
static void lay_joints(const jo_model *m, jo_data *d, jo_arena *a)
{
    d->schur.S = jo_take_reals(a, JO_BLOCK * m->nblock);
    d->schur.S0 = jo_take_reals(a, m->redundant >= 0 ? JO_BLOCK * m->nblock : 0);
    for (int s = 0; s < 2; s++) d->schur.gram[s] = jo_take_reals(a, 36 * m->npair);
    d->joint = jo_take(a, (size_t)(m->njoint + m->nhub) * sizeof(jo_joint_work));
    for (int i = 0; i < m->njoint; i++) {
        jo_joint_work spare, *w = a->base ? &d->joint[i] : &spare;
        w->maximal.side = jo_take(a, (size_t)m->joint[i].nside * sizeof *w->maximal.side);
    }
    const int nbelow = m->nblock - m->ncolumn, nupdate = m->ncolumn ? m->update_first[m->ncolumn] : 0;
    d->schur.pairs = jo_take(a, (size_t)m->npair * sizeof *d->schur.pairs);
    d->schur.pulls = jo_take(a, (size_t)m->npull * sizeof *d->schur.pulls);
    d->schur.hubs = jo_take(a, (size_t)m->nhub * sizeof *d->schur.hubs);
    d->schur.columns = jo_take(a, (size_t)m->ncolumn * sizeof *d->schur.columns);
    d->schur.belows = jo_take(a, (size_t)nbelow * sizeof *d->schur.belows);
    d->schur.updates = jo_take(a, (size_t)nupdate * sizeof *d->schur.updates);
    d->schur.fills = jo_take(a, (size_t)nbelow * sizeof *d->schur.fills);
}

void jo_maximal_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    d->body = jo_take_many(a, m->nbody, sizeof *d->body);
    d->marker = jo_take_many(a, m->nmarker, sizeof *d->marker);
    d->coordinate = jo_take_many(a, m->ncoordinate, sizeof *d->coordinate);
    lay_joints(m, d, a);
    lay_bodies(m, d, a);
    lay_markers(m, d, a);
}
