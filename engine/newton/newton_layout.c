/* newton_layout.c - memory of Newton's matrix and of the accelerations of coupled masses. */
#include "newton/newton.h"

/* derivatives of one body and of all active markers; derivatives of a spare marker while bytes are only counted */
static void lay_tangents(const jo_model *m, jo_newton *w, jo_arena *a)
{
    int np = 0;
    for (int i = 0; i < m->nbody; i++) np = m->body[i].np > np ? m->body[i].np : np;
    w->Dd = jo_take_reals(a, 6 * np);
    w->H = jo_take_reals(a, 3 * np);
    w->chi_pd = jo_take_reals(a, 3 * np);
    w->marker = jo_take_many(a, m->nactive, sizeof *w->marker);
    for (int i = 0; i < m->nactive; i++) {
        jo_marker_tangent spare, *y = a->base ? &w->marker[i] : &spare;
        const int body = m->marker[i].body, row = body < 0 ? 0 : jo_pad(6 + m->body[body].n);
        y->L = jo_take_reals(a, 6 * row);
        y->W = jo_take_reals(a, 12 * row);
    }
}

void jo_newton_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    jo_newton *w = &d->newton;
    const int count = m->nv + m->nrow;
    w->N = jo_take_reals(a, m->nnewton + JO_PAD);
    w->x = jo_take_reals(a, count);
    w->base = jo_take_reals(a, m->nv);
    w->base_lam = jo_take_reals(a, m->nrow);
    w->lag = jo_take_reals(a, m->nv);
    w->sum = jo_take_reals(a, m->nv);
    w->sum_lam = jo_take_reals(a, m->nrow);
    w->soft = jo_take_reals(a, m->nrow);
    w->pivot = jo_take_ints(a, count);
    w->sparse = 0;
    for (int i = 0; i < m->nforce; i++) w->sparse |= m->nnode && m->force[i].type == JO_FORCE_contact_set;
    w->used = jo_take_ints(a, w->sparse ? jo_newton_branches(m) : 0);
    w->row = jo_take_ints(a, w->sparse ? jo_newton_branches(m) : 0);
    w->unit = jo_take_doubles(a, count);
    w->unit_of_row = jo_take_doubles(a, count);
    lay_tangents(m, w, a);
}
