/* friction_contacts.c - friction of contacts, spheres and points on planes, whose normal forces follow from the state: lists and shares. */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"
#include "friction/friction_law.h"

void jo_friction_layout_contacts(const jo_model *m, jo_data *d, jo_arena *a)
{
    jo_anderson *x = &d->friction;
    x->share = jo_take_doubles(a, m->nfriction ? m->njoint : 0);
    x->press = jo_take_doubles(a, m->nfriction ? m->nbody : 0);
    x->first = jo_take_ints(a, m->nfriction ? m->nbody : 0);
    x->next = jo_take_ints(a, m->nfriction);
    if (!a->base || !m->nfriction) return;
    for (int i = 0; i < m->nbody; i++) x->first[i] = -1;
    for (int i = m->nfriction - 1; i >= 0; i--) {
        x->next[i] = -1;
        if (m->friction[i].contact < 0) continue;
        int *first = &x->first[jo_bearing_body(m, &m->friction[i])];
        x->next[i] = *first;
        *first = i;
    }
}

/* Several points of a body that stick share a force that their rows do not determine: in proportion to their normal forces, so that a body that is
 * pushed without turning slips at all points at once. The solution of redundant rows has the least sum of share * lam^2. */
void jo_friction_share(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nbody; i++) d->friction.press[i] = 0.0;
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < m->nfriction; i++) {
            const jo_friction *f = &m->friction[i];
            if (f->contact < 0 || !f->law) continue;
            double *share = &d->friction.share[f->lock], *sum = &d->friction.press[jo_bearing_body(m, f)];
            if (!pass) {
                *share = jo_sticks(m, d, f) ? JO_RE(jo_contact_normal_force(m, d, &m->force[f->contact])) : 0.0;
                *sum += *share;
            } else if (*share > 0.0) {
                *share = *sum / *share / JO_RE(f->data->mass);
            }
        }
}
