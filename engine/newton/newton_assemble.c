/* newton_assemble.c - assembly of Newton's matrix from bodies, beams, joints, frictions and forces.
 *
 * Unknowns: accelerations [R'' (world), w' (local), p'']. A change x of them changes accelerations by weights.a x, velocities by
 * weights.v x and increments [dR, dtheta (local), dp] of the positions by weights.q x; a change of dtheta rotates the body by `turn` times
 * this change (tangent operator of the exponential map). Changes of markers: [dr, dphi, dv, dom], world frame, with dA = dphi~ A.
 */
#include "valid.h"
#include "newton/newton.h"
#include "force/force.h"
#include "beam/beam.h"
#include "friction/friction.h"

void jo_newton_masses(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    jo_newton_clear(m, d);
    for (int i = 0; i < m->nbody; i++) jo_newton_body(m, d, stage, i);
    if (m->nbeam) jo_newton_beams(m, d, stage);
}

void jo_newton_rows(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        for (int s = 0; s < k->nside; s++)
            if (m->marker[k->side[s]].body >= 0) jo_newton_marker(m, d, stage, k->side[s]);
        jo_newton_joint(m, d, stage, i);
    }
}

/* matrix of bodies, beams, joints, frictions, forces, and the geometric stiffness of all loads */
int jo_newton_assemble(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    jo_newton_clear(m, d);
    for (int i = 0; i < m->nbody; i++) jo_newton_body(m, d, stage, i);
    if (m->nbeam) jo_newton_beams(m, d, stage);
    for (int i = 0; i < m->nactive; i++) {
        for (int j = 0; j < 6; j++) d->newton.marker[i].load[j] = 0.0;
        if (m->marker[i].body >= 0) jo_newton_marker(m, d, stage, i);
    }
    for (int i = 0; i < m->njoint; i++) jo_newton_joint(m, d, stage, i);
    if (m->nfriction) jo_newton_frictions(m, d);
    const int status = jo_newton_forces(m, d, stage);
    if (status != JO_OK) return status;
    if (stage->weights.q != 0.0)
        for (int i = 0; i < m->nactive; i++)
            if (m->marker[i].body >= 0) jo_newton_stress(m, d, stage, i);
    return JO_OK;
}

/* matrix with given weights, for tests and analyses */
static int assemble_with(const jo_model *m, jo_data *d, double ca, double cv, double cq)
{
    const jo_stage stage = {.weights = {ca, cv, cq, 1.0, 0, 0}};
    for (int i = 0; i < m->nbody; i++)
        for (int j = 0; j < 9; j++) d->body[i].turn[j] = j % 4 == 0;
    const int status = jo_residual(m, d, d->rate);
    jo_newton_outdated(d);
    return status == JO_OK ? jo_newton_assemble(m, d, &stage) : status;
}

int jo_newton_values(const jo_model *m, jo_data *d, double ca, double cv, double cq, jo_real *out)
{
    const int status = assemble_with(m, d, ca, cv, cq);
    for (int i = 0; i < m->nnewton && status == JO_OK; i++) out[i] = d->newton.N[i];
    return status;
}

/* dense matrix in the order [v, lam] */
int jo_newton_matrix(const jo_model *m, jo_data *d, double ca, double cv, double cq, jo_real *out)
{
    const int count = m->nv + m->nrow;
    const int status = assemble_with(m, d, ca, cv, cq);
    if (status != JO_OK) return status;
    for (int i = 0; i < count * count; i++) out[i] = 0.0;
    for (int x = 0; x < m->nbody + m->njoint; x++)
        for (int y = 0; y < m->nbody + m->njoint; y++) {
            const int nx = x < m->nbody ? 6 + m->body[x].n : m->joint[x - m->nbody].nrow;
            const int ny = y < m->nbody ? 6 + m->body[y].n : m->joint[y - m->nbody].nrow;
            const int ix = x < m->nbody ? m->body[x].iv : m->nv + m->joint[x - m->nbody].row;
            const int iy = y < m->nbody ? m->body[y].iv : m->nv + m->joint[y - m->nbody].row;
            jo_block block = jo_newton_find(m, d, x, y);
            if (!block.at) continue;
            for (int i = 0; i < nx; i++)
                for (int j = 0; j < ny; j++) out[(ix + i) * count + iy + j] = block.at[i * block.stride + j];
        }
    return JO_OK;
}
