/* newton_residual.c - residual of the equations of motion at given accelerations and multipliers (inverse dynamics).
 *
 * r = M a + Cq^T lam - Q on [dR (world), dtheta (local), dp] of each body. The complex build gives its exact derivatives.
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"
#include "beam/beam.h"
#include "friction/friction.h"

/* r = M a - [fr, fp] of one body: F = m A + w' x S + I3 p'', T = S x A + J w' + B p'', r_p = p'' + I3^T A + B^T w', A = R'' - g */
static void body_residual(const jo_model *m, const jo_data *d, int body, jo_real *r)
{
    const jo_body *b = &m->body[body];
    const jo_body_work *w = &d->body[body];
    const jo_real *a = d->a + b->iv, *wd = a + 3, *pdd = a + 6;
    const int np = b->np;
    jo_real A[3], F[3], T[3], t[3];
    jo_set3(t, a);
    jo_sub3(t, m->gravity);   /* A = A_body^T (R'' - g) */
    jo_mul3t(A, w->A, t);
    jo_cross(F, wd, w->S);
    jo_axpy3(F, b->mass[0], A);
    jo_cross(T, w->S, A);
    jo_sym3(t, w->J, wd);
    jo_add3(T, t);
    for (int j = 0; j < b->n; j++) {
        r[6 + j] = pdd[j] - w->fp[j];
        for (int i = 0; i < 3; i++) {
            F[i] += b->I3[i * np + j] * pdd[j];
            T[i] += w->B[i * np + j] * pdd[j];
            r[6 + j] += b->I3[i * np + j] * A[i] + w->B[i * np + j] * wd[i];
        }
    }
    jo_sub3(F, w->fr);
    jo_sub3(T, w->fr + 3);
    jo_mul3(r, w->A, F);
    jo_set3(r + 3, T);
}

int jo_newton_centred(const jo_model *m, const jo_data *d, int body)
{
    const jo_real *S = d->body[body].S;
    return !m->body[body].n && S[0] == 0.0 && S[1] == 0.0 && S[2] == 0.0;
}

/* the same of a rigid body with its mass centre at the origin of its frame: F = m (R'' - g), T = J w' */
static void centred_residual(const jo_model *m, const jo_data *d, int body, jo_real *r)
{
    const jo_body_work *w = &d->body[body];
    const jo_real *a = d->a + m->body[body].iv, mass = m->body[body].mass[0];
    jo_real F[3], T[3];
    jo_mul3(F, w->A, w->fr);
    jo_sym3(T, w->J, a + 3);
    for (int i = 0; i < 3; i++) {
        r[i] = mass * (a[i] - m->gravity[i]) - F[i];
        r[3 + i] = T[i] - w->fr[3 + i];
    }
}

void jo_equations_residual(const jo_model *m, const jo_data *d, jo_real *r)
{
    for (int i = 0; i < m->nbody; i++) {
        if (jo_newton_centred(m, d, i)) centred_residual(m, d, i, r + m->body[i].iv);
        else body_residual(m, d, i, r + m->body[i].iv);
    }
}

/* r at time, q, v, a, lam: kinematics, inertia, forces, beams, friction, reactions, M a */
int jo_residual_at(const jo_model *m, jo_data *d, const jo_stage *stage, jo_real *r)
{
    static const jo_work none = {0.0, 0.0, 0.0};
    jo_real largest[2];
    jo_state_changed(d);
    d->power = none;
    jo_residuals(m, d, largest);   /* poses, velocities, markers and coordinates at q, v */
    for (int i = 0; i < m->nbody; i++) jo_body_inertia(&m->body[i], &d->body[i], &d->power.damping);
    if (m->ncoordinate) jo_coordinates_rate(m, d, m->ncoordinate);
    if (m->nforce) {
        const int applied = jo_apply_forces(m, d, stage);
        if (applied != JO_OK) return applied;
    }
    if (m->nbeam) {
        const int status = jo_beam_forces(m, d, d->a);
        if (status != JO_OK) return status;
    }
    if (m->nfriction) jo_friction_apply_forces(m, d);
    jo_apply_reactions(m, d);
    jo_equations_residual(m, d, r);
    return JO_OK;
}

int jo_residual(const jo_model *m, jo_data *d, jo_real *r) { return jo_residual_at(m, d, &jo_now, r); }
