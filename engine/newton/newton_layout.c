/* newton_layout.c - memory of Newton's matrix and of the accelerations of coupled masses. */
#include "newton/newton.h"

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
    w->pivot = jo_take_ints(a, count);
    w->unit = jo_take_doubles(a, count);
    w->unit_of_row = jo_take_doubles(a, count);
}
