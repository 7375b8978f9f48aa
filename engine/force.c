/* force.c - the table of forces: a row for each kind, which its own file fills; see force.h. */
#include "force.h"

static const jo_force_kind *const table[] = {
    [JO_FORCE_LOAD] = &jo_force_load,
    [JO_FORCE_ALONG] = &jo_force_along,
    [JO_FORCE_BUSHING] = &jo_force_bushing,
    [JO_FORCE_MODAL_LOAD] = &jo_force_modal,
    [JO_FORCE_USER] = &jo_force_user,
    [JO_FORCE_MOVING_LOAD] = &jo_force_moving,
};

int jo_apply_forces(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        const int status = table[f->type]->apply(m, d, f, &d->force[i]);
        if (status != JO_OK) {
            d->error_index = i;
            return status;
        }
    }
    return JO_OK;
}

jo_real jo_stored(const jo_model *m, const jo_data *d)
{
    jo_real U = 0.0;
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        if (table[f->type]->stored) U += table[f->type]->stored(d, f);
    }
    return U;
}

int jo_newton_forces(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        const int status = table[f->type]->tangent(m, d, f, &d->force[i]);
        if (status != JO_OK) {
            d->error_index = i;
            return status;
        }
    }
    return JO_OK;
}
