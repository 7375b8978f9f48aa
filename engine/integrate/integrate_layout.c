/* integrate_layout.c - memory of the methods of integration and of events. */
#include "integrate/integrate.h"
#include "force/force.h"
#include "contact/contact.h"

/* the history of generalised alpha is part of the state */
void jo_integrate_layout_state(const jo_model *m, jo_data *d, jo_arena *a)
{
    jo_alpha *w = &d->alpha;
    w->algorithmic = jo_take_reals(a, m->nv + m->nstate);
    w->end_a = jo_take_reals(a, m->nv + m->nstate);
    w->end_q = jo_take_reals(a, m->nq);
    w->end_v = jo_take_reals(a, m->nv + m->nstate);
    w->end_lam = jo_take_reals(a, m->nrow);
    w->end_time = jo_take_reals(a, 1);
    w->change = jo_take_reals(a, m->nv + m->nstate);
    w->first_change = jo_take_reals(a, m->nv + m->nstate);
    w->change_lam = jo_take_reals(a, m->nrow);
    w->estimate = jo_take_reals(a, 4);
}

static void lay_adaptive(const jo_model *m, jo_adaptive *w, jo_arena *a)
{
    const int nw = m->nv + m->nstate;
    w->stages = jo_take_reals(a, 7 * (2 * nw + 3));
    w->change = jo_take_reals(a, 2 * nw + 3);
    w->q1 = jo_take_reals(a, m->nq);
    w->v1 = jo_take_reals(a, nw);
    w->lam1 = jo_take_reals(a, m->nrow);
    for (int i = 0; i < 2; i++) w->defect[i] = jo_take_reals(a, m->nv);
    w->extent = jo_take_doubles(a, 3 * m->nbody + m->nstate);
    w->nominal = jo_take_doubles(a, m->nstate);
}

static void lay_events(const jo_model *m, jo_data *d, jo_arena *a)
{
    jo_events *w = &d->events;
    const int watched = jo_watched(m);
    double **values[] = {&w->level, &w->below, &w->above, &w->trial, &w->scale};
    w->start.state = jo_take(a, watched ? d->state_bytes : 0);
    for (int i = 0; i < 5; i++) *values[i] = jo_take_doubles(a, watched);
    w->struck = jo_take_doubles(a, 2 * m->nswitched);
    w->rates = jo_take_reals(a, m->nswitched ? 2 * (m->nv + m->nu) : 0);
    w->side = jo_take_ints(a, watched);
    w->slip = jo_take_ints(a, m->nfriction);
    w->reversed = jo_take_ints(a, m->nfriction);
    w->since = jo_take_doubles(a, m->nfriction);
    w->near = jo_take_many(a, 2 * m->nyielding, sizeof *w->near);
    w->log = jo_take_doubles(a, 3 * jo_log_room(m));
    w->measured = jo_take_reals(a, m->nevent ? m->nout : 0);
    w->list = jo_take_many(a, m->nevent ? m->nsensor : 0, sizeof *w->list);
}

void jo_integrate_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    lay_adaptive(m, &d->adaptive, a);
    lay_events(m, d, a);
    jo_brief_layout(m, d, a);
    jo_impulse_layout(m, d, a);
    d->alpha.whole = jo_take_reals(a, m->nv + m->nrow);
}
