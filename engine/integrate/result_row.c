/* result_row.c - one row of results: state, energies, residuals, counts, sensors, and discrete states. */
#include "valid.h"
#include "maximal/maximal.h"
#include "friction/friction.h"
#include "force/force.h"
#include "contact/contact.h"
#include "tree/tree.h"
#include "integrate/integrate.h"
#include "fatigue/fatigue.h"

enum { JO_DIAGNOSTICS = sizeof(jo_diagnostics) / sizeof(jo_real) };

/* number of reals of a row, in the order of jo_write_row */
int jo_row_size(const jo_model *m)
{
    return 1 + m->nq + m->nv + m->nrow + JO_DIAGNOSTICS + m->nout + m->nstate + m->nturn + 3 * m->nlock + 3 * m->nfriction
           + m->nevent + m->ninput + m->nmemory + m->nx + m->nu + jo_contact_energy_size(m);
}

/* energies, work, residuals and counts */
static void diagnose(const jo_model *m, jo_data *d, jo_diagnostics *y)
{
    jo_energies energy;
    jo_real largest[2];
    jo_energy(m, d, &energy);
    y->kinetic = energy.kinetic;
    y->strain = energy.strain;
    y->potential = energy.potential;
    y->springs = energy.springs;
    y->dissipated = d->work.damping;
    y->friction = d->work.friction;
    y->work = d->work.forces;
    jo_residuals(m, d, largest);
    y->position_residual = largest[0];
    y->velocity_residual = largest[1];
    y->evaluations = jo_same((double)d->counts.evaluations);
    y->iterations = jo_same((double)d->counts.iterations);
    y->steps = jo_same((double)d->counts.steps);
    y->rejected = jo_same((double)d->counts.rejected);
    y->step = jo_same(d->control.length);
}

/* row [time q v lam diagnostics sensors states turn locked slip held direction happened input memory joint contacts] */
int jo_write_row(const jo_model *m, jo_data *d, jo_real *row)
{
    int status = jo_accelerations_valid(d) ? JO_OK : jo_accelerations(m, d);
    if (status != JO_OK) return status;
    jo_add_step_work(d);
    jo_sync_all(m, d);
    if (m->nlink && !jo_tree_active(d) && !jo_tree_matches_maximal_state(m, d)) jo_tree_read_maximal_state(m, d);
    *row++ = d->time[0];
    for (int i = 0; i < m->nq; i++) *row++ = d->q[i];
    for (int i = 0; i < m->nv; i++) *row++ = d->v[i];
    for (int i = 0; i < m->nrow; i++) *row++ = d->lam[i];
    diagnose(m, d, (jo_diagnostics *)row);
    jo_sensors(m, d, row + JO_DIAGNOSTICS);
    row += JO_DIAGNOSTICS + m->nout;
    for (int i = 0; i < m->nstate; i++) *row++ = jo_states(m, d)[i];
    for (int i = 0; i < m->nturn; i++) *row++ = d->turn[i];
    for (int i = 0; i < m->nlock; i++) *row++ = jo_same(d->locked[i]);
    for (int i = 0; i < m->nfriction; i++) *row++ = jo_same(d->slip[i]);
    for (int i = 0; i < 2 * m->nlock; i++) *row++ = d->held[i];
    for (int i = 0; i < 2 * m->nfriction; i++) *row++ = d->direction[i];
    for (int i = 0; i < m->nevent; i++) *row++ = jo_same(d->happened[i]);
    for (int i = 0; i < m->ninput; i++) *row++ = d->input[i];
    for (int i = 0; i < m->nmemory; i++) *row++ = jo_same(d->memory[i]);
    for (int i = 0; i < m->nx + m->nu; i++) *row++ = d->x[i];
    const int energies = jo_contact_energy_size(m);
    if (energies) d->contact_energy[0] = jo_stored_in_contacts(m, d);
    for (int i = 0; i < energies; i++) *row++ = d->contact_energy[i];
    return JO_OK;
}

int jo_row(const jo_model *m, jo_data *d, jo_real *row)
{
    jo_state_changed(d);
    int status = m->nlink && jo_tree_matches_maximal_state(m, d) ? jo_tree_from_maximal(m, d) : JO_OK;
    if (status == JO_OK && m->nlock) status = jo_friction_initialise_states(m, d);
    if (status == JO_OK) status = jo_measure(m, d);
    if (status == JO_OK) status = jo_write_row(m, d, row);
    jo_tree_to_maximal(m, d);
    return status;
}
