/* force_table.c - table of the kinds of force, and loops over all forces: force, energy, tangent, states. */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"
#include "contact/contact.h"

#define JO_FORCE_ENTRY(name, ...) &jo_force_##name,
static const jo_force_kind *const table[] = {JO_FORCES(JO_FORCE_ENTRY)};

const jo_yielding *jo_yielding_of(const jo_force *f) { return table[f->type]->yielding; }

/* force of one element; 0 after its release */
int jo_apply_force(const jo_model *m, jo_data *d, const jo_stage *stage, int force)
{
    static const jo_force_work none = {{0.0}, 0.0, 0.0, 0.0};
    const jo_force *f = &m->force[force];
    if (!jo_released(d, f->release)) return table[f->type]->apply(m, d, stage, f, &d->force[force]);
    d->force[force] = none;
    if (f->state >= 0) jo_keep_states(m, d, stage, f);
    return JO_OK;
}

/* forces of all elements; on failure error_index is the number of the force */
int jo_apply_forces(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    for (int i = 0; i < m->nforce; i++) {
        const int status = jo_apply_force(m, d, stage, i);
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

/* points of a force at which it touches, with the states x; 0 after its release */
int jo_touches_of(const jo_model *m, const jo_data *d, int force, const jo_real *x, jo_touch *y, jo_real *sums)
{
    const jo_force *f = &m->force[force];
    const jo_yielding *kind = table[f->type]->yielding;
    return kind && kind->touches && !jo_released(d, f->release) ? kind->touches(m, d, f, x, y, sums) : 0;
}

/* of these, the energy of contacts */
jo_real jo_stored_in_contacts(const jo_model *m, const jo_data *d)
{
    jo_real U = {0.0};
    for (int k = 0; k < m->nyielding; k++) {
        const jo_force *f = &m->force[jo_yielding_force(d, k)];
        const jo_force_kind *kind = table[f->type];
        if (kind->yielding->touches && kind->stored && !jo_released(d, f->release)) U += kind->stored(d, f);
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

void jo_start_force(const jo_model *m, jo_data *d, int force)
{
    const jo_force *f = &m->force[force];
    if (f->state >= 0) table[f->type]->start(m, d, f, jo_states(m, d) + f->state);
}

void jo_state_nominals(const jo_model *m, double duration, double *x)
{
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        if (f->state >= 0) table[f->type]->nominals(m, f, duration, x + f->state);
    }
}

void jo_force_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    int most = 0;
    for (int i = 0; i < m->nforce && m->nyielding; i++)
        if (jo_yielding_of(&m->force[i]) && m->force[i].states > most) most = m->force[i].states;
    d->forces.yielding = jo_take_ints(a, m->nyielding);
    d->forces.follower = jo_take_ints(a, m->nyielding);
    d->forces.next = jo_take_reals(a, most);
    d->forces.seen = jo_take_doubles(a, m->nyielding ? m->nstate : 0);
    d->forces.slopes = jo_take_many(a, m->nstate, sizeof *d->forces.slopes);
    jo_contact_sets_layout(m, d, a);
}
