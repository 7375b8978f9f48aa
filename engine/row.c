/* row.c - one row of results: the state, its energies and residuals, counts, sensors and what methods remember. */
#include "internal.h"

int jo_row_size(const jo_model *m)
{
    return 1 + m->nq + m->nv + m->nrow + JO_BALANCE + m->nout + m->nturn + 3 * m->nlock + 3 * m->nfriction
           + m->nevent + m->ninput + m->nmemory;
}

int jo_write_row(const jo_model *m, jo_data *d, jo_real *row)
{
    int status = d->fresh ? JO_OK : jo_accelerations(m, d);
    if (status != JO_OK) return status;
    jo_add_work(d);
    *row++ = d->time[0];
    for (int i = 0; i < m->nq; i++) *row++ = d->q[i];
    for (int i = 0; i < m->nv; i++) *row++ = d->v[i];
    for (int i = 0; i < m->nrow; i++) *row++ = d->lam[i];
    jo_energy(m, d, row);
    for (int i = 0; i < 3; i++) row[4 + i] = d->work[i];
    jo_residuals(m, d, row + 7);
    row[9] = (double)d->counts[0];
    row[10] = (double)d->counts[1];
    row[11] = (double)d->counts[5];
    row[12] = (double)d->counts[3];
    row[13] = d->control.length;
    jo_sensors(m, d, row + JO_BALANCE);
    row += JO_BALANCE + m->nout;
    for (int i = 0; i < m->nturn; i++) *row++ = d->turn[i];
    for (int i = 0; i < m->nlock; i++) *row++ = d->locked[i];
    for (int i = 0; i < m->nfriction; i++) *row++ = d->slip[i];
    for (int i = 0; i < 2 * m->nlock; i++) *row++ = d->held[i];
    for (int i = 0; i < 2 * m->nfriction; i++) *row++ = d->direction[i];
    for (int i = 0; i < m->nevent; i++) *row++ = d->happened[i];
    for (int i = 0; i < m->ninput; i++) *row++ = d->input[i];
    for (int i = 0; i < m->nmemory; i++) *row++ = d->memory[i];
    return JO_OK;
}

int jo_row(const jo_model *m, jo_data *d, jo_real *row)
{
    d->current = d->fresh = 0;
    int status = m->nlock ? jo_friction_settle(m, d) : JO_OK;
    if (status == JO_OK) status = jo_measure(m, d);
    return status == JO_OK ? jo_write_row(m, d, row) : status;
}
