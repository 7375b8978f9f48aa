/* force.c - the table of forces: what the file of each kind defines; see force.h. */
#include "force.h"

#define JO_FORCE_ENTRY(name, ...) &jo_force_##name,
static const jo_force_kind *const table[] = {JO_FORCES(JO_FORCE_ENTRY)};

int jo_apply_forces(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    static const jo_force_work none = {{0.0}, 0.0};
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        if (jo_released(d, f->release)) {
            d->force[i] = none;
            continue;
        }
        const int status = table[f->type]->apply(m, d, stage, f, &d->force[i]);
        if (status != JO_OK) {
            d->error_index = i;
            return status;
        }
    }
    return JO_OK;
}

jo_real jo_stored(const jo_model *m, const jo_data *d)
{
    jo_real U = {0.0};
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        if (table[f->type]->stored && !jo_released(d, f->release)) U += table[f->type]->stored(d, f);
    }
    return U;
}

int jo_newton_forces(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        if (jo_released(d, f->release)) continue;
        const int status = table[f->type]->tangent(m, d, stage, f, &d->force[i]);
        if (status != JO_OK) {
            d->error_index = i;
            return status;
        }
    }
    return JO_OK;
}
