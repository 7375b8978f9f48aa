/* coupled_mass.c - accelerations and multipliers of mechanisms whose bodies have coupled masses (beams, contacts), by the LU of newton_factor.c.
 *
 *   [M^ Cq^T; Cq 0] [a; lam] = [Q; -(Cq)' v],  M^ = M or, in a Rosenbrock method, M + g h D + (g h)^2 K of beams, contacts, modes
 * solved for the change from `base`, `base_lam`: free fall, or in stage 2 of ROS2 the solution of stage 1, with its factors. Masses and
 * accelerations change by O(h) between the stages: the error of a is O(h^2), and the order of the method remains 2.
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"
#include "beam/beam.h"
#include "contact/contact.h"
#include "network/network.h"

enum { JO_REFINEMENTS = 2 };   /* number of iterative refinements; each reduces the error due to the regularisation by a factor of 1e-8 */

/* whether masses of bodies are coupled: in a Rosenbrock method by the stiffness of beams, else by their consistent mass */
int jo_couples(const jo_model *m, const jo_stage *stage)
{
    if (stage->set && (m->nbeam || (stage->contacts && !stage->separate))) return 1;
    for (int i = 0; i < m->nbeam; i++)
        if (jo_beam_inertial(&m->beam[i])) return 1;
    return 0;
}

/* Newton's matrix with M^ and the joint rows Cq */
static void assemble(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    const double gh = stage->gh;
    const jo_stage masses = {.set = stage->set, .earlier = stage->earlier, .weights = {1.0, gh, gh * gh, 1.0, 0, 1}}, rows = {.weights = {1.0, 1.0, 0.0, 1.0, 0, 1}};
    jo_newton_outdated(d);
    for (int i = 0; i < m->nrow; i++) d->lam[i] = 0.0;
    jo_newton_masses(m, d, &masses);
    jo_newton_rows(m, d, &rows);
    if (!stage->contacts) return;
    jo_contact_add_to_newton(m, d);
    jo_networks_add_to_newton(m, d);
}

static jo_real *part_of(const jo_model *m, jo_data *d, int item) { return d->newton.x + jo_newton_place(m, item); }

/* d->newton.x = N^-1 d->newton.x; with regularised factors by iterative refinement: multipliers of least norm */
static void solve(const jo_model *m, jo_data *d)
{
    jo_newton_solve(m, d);
    if (!jo_newton_soft(d)) return;
    for (int i = 0; i < m->nv; i++) d->newton.sum[i] = 0.0;
    for (int i = 0; i < m->nrow; i++) d->newton.sum_lam[i] = 0.0;
    for (int k = 0;; k++) {
        for (int i = 0; i < m->nbody; i++) {
            jo_real *x = part_of(m, d, i), *sum = d->newton.sum + m->body[i].iv;
            for (int j = 0; j < 6 + m->body[i].n; j++) {
                sum[j] += x[j];
                x[j] = k < JO_REFINEMENTS ? 0.0 : sum[j];
            }
        }
        for (int i = 0; i < m->njoint; i++) {
            jo_real *x = part_of(m, d, m->nbody + i), *sum = d->newton.sum_lam + m->joint[i].row;
            const jo_real *soft = d->newton.soft + m->joint[i].row;
            for (int r = 0; r < m->joint[i].nrow; r++) {
                const jo_real left = jo_absent(d, &m->joint[i]) ? 0.0 : -soft[r] * x[r];
                sum[r] += x[r];
                x[r] = k < JO_REFINEMENTS ? left : sum[r];
            }
        }
        if (k == JO_REFINEMENTS) return;
        jo_newton_solve(m, d);
    }
}

/* y = C'' of one joint at the accelerations a, plus Baumgarte terms 2 alpha C' + beta^2 C */
static void row_accelerations(const jo_model *m, const jo_data *d, const jo_stage *stage, int i, jo_real *y)
{
    const jo_joint *k = &m->joint[i];
    const jo_joint_work *w = &d->joint[i];
    jo_real a[6], b[6], t[3];
    int row = 0;
    if (k->coincident || k->nperp) {
        jo_marker_acceleration(m, d, k->side[0], a);
        jo_marker_acceleration(m, d, k->side[1], b);
    }
    for (; row < (k->coincident ? 3 : 0); row++) y[row] = b[row] - a[row];
    if (k->nperp) {
        jo_real oma[3], omb[3];
        jo_to_world(oma, m, d, k->side[0], d->marker[k->side[0]].om);
        jo_to_world(omb, m, d, k->side[1], d->marker[k->side[1]].om);
        for (int r = 0; r < k->nperp; r++, row++) {
            const jo_real *A = d->marker[k->side[0]].A + k->perp_a[r], *B = d->marker[k->side[1]].A + k->perp_b[r];
            const jo_real f[3] = {A[0], A[3], A[6]}, h[3] = {B[0], B[3], B[6]};
            jo_real fd[3], hd[3], fdd[3], hdd[3];
            jo_cross(fd, oma, f);
            jo_cross(hd, omb, h);
            jo_cross(fdd, oma, fd);
            jo_cross(t, a + 3, f);
            jo_add3(fdd, t);
            jo_cross(hdd, omb, hd);
            jo_cross(t, b + 3, h);
            jo_add3(hdd, t);
            y[row] = jo_dot3(fdd, h) + 2.0 * jo_dot3(fd, hd) + jo_dot3(f, hdd);
        }
    }
    for (int l = 0; l < k->nline; l++, row++) {
        const jo_line *line = &m->line[k->line + l];
        y[row] = 0.0;
        for (int j = 0; j < line->count; j++)
            y[row] += line->data->factor[j] * jo_coordinate_acceleration(m, d, line->coordinate[j]);
        if (line->signal >= 0) y[row] -= jo_signal_at(m, d, line->signal, d->time[0] + stage->lead).second;
    }
    if (jo_stabilised(stage))
        for (int r = 0; r < k->nrow; r++) y[r] += 2.0 * stage->alpha * w->cdot[r] + stage->beta * stage->beta * w->c[r];
}

/* a and joint[].x for the forces fr, fp with the last factors: x = N^-1 [Q - M base + lag; -C'' at base], a = base + x */
void jo_coupled_solve(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    const double gh = stage->gh;
    for (int i = 0; i < m->nv; i++) d->a[i] = d->newton.base[i];
    /* right-hand side of the bodies: lag - (M base - Q), modes also - g h (D + g h K) base */
    jo_equations_residual(m, d, d->newton.sum);
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        const jo_real *r = d->newton.sum + b->iv, *a = d->newton.base + b->iv, *f = d->newton.lag + b->iv;
        jo_real *x = part_of(m, d, i);
        for (int j = 0; j < 6; j++) x[j] = (stage->set ? f[j] : 0.0) - r[j];
        for (int j = 0; j < b->n; j++) x[6 + j] = -r[6 + j] - gh * (b->D[j] + gh * b->K[j]) * a[6 + j];
    }
    if (stage->contacts) {
        jo_contact_subtract(m, d, d->newton.base);
        jo_networks_subtract(m, d, d->newton.base);
    }
    for (int i = 0; i < m->njoint; i++) {
        jo_real *x = part_of(m, d, m->nbody + i), y[JO_MAX_ROWS] = {0.0};
        if (!jo_absent(d, &m->joint[i])) row_accelerations(m, d, stage, i, y);
        for (int r = 0; r < m->joint[i].nrow; r++) x[r] = -y[r];
    }
    solve(m, d);
    for (int i = 0; i < m->nbody; i++) {
        const jo_real *x = part_of(m, d, i);
        jo_real *a = d->a + m->body[i].iv;
        for (int j = 0; j < 6 + m->body[i].n; j++) a[j] += x[j];
    }
    for (int i = 0; i < m->njoint; i++) {
        const jo_real *x = part_of(m, d, m->nbody + i);
        for (int r = 0; r < m->joint[i].nrow; r++)
            d->joint[i].x[r] = x[r] + (stage->second ? d->newton.base_lam[m->joint[i].row + r] : 0.0);
    }
}

/* factors (those of stage 1 in stage 2 of ROS2), then a and joint[].x. Redundant rows are detected by the factorisation of S, whose pivots
 * have a scale */
int jo_coupled_accelerations(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    int status = JO_OK;
    if (stage->second) {   /* reactions of stage 1 as forces */
        for (int i = 0; i < m->nrow; i++) d->lam[i] = d->newton.base_lam[i];
        jo_apply_reactions(m, d);
    } else {
        for (int i = 0; i < m->nbody; i++) {
            jo_real *a = d->newton.base + m->body[i].iv;
            for (int j = 0; j < 6 + m->body[i].n; j++) a[j] = j < 3 ? m->gravity[j] : 0.0;
        }
        jo_schur_softened(d, m->redundant > 0);
        if (m->njoint && !jo_schur_soft(d)) status = jo_joint_factor(m, d, stage->set);
        if (status != JO_OK) return status;
        assemble(m, d, stage);
        status = jo_newton_factor(m, d, jo_schur_soft(d));
        d->counts.factorisations--;   /* counted as a part of the evaluation */
        if (status != JO_OK) return status;
        if (stage->set && !stage->earlier) {   /* first stage only; see jo_coupled_lag for later stages */
            for (int i = 0; i < m->nv; i++) {
                d->newton.sum[i] = -stage->gh * d->v[i];
                d->newton.lag[i] = 0.0;
            }
            jo_beam_lag(d, d->newton.sum, 0, d->newton.lag);
        }
    }
    jo_coupled_solve(m, d, stage);
    return JO_OK;
}

void jo_coupled_lag(const jo_model *m, jo_data *d, const jo_real *x, const jo_real *z)
{
    for (int i = 0; i < m->nv; i++) d->newton.lag[i] = jo_same(0.0);
    jo_beam_lag(d, x, z, d->newton.lag);
}

void jo_coupled_second(const jo_model *m, jo_data *d, const jo_real *a, const jo_real *x, const jo_real *z)
{
    for (int i = 0; i < m->nv; i++) d->newton.base[i] = a[i];
    for (int i = 0; i < m->nrow; i++) d->newton.base_lam[i] = d->lam[i];
    jo_coupled_lag(m, d, x, z);
}

/* joint[].x = the change of the multipliers due to the changes of force in y and yp of the bodies */
void jo_coupled_respond(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        const jo_body_work *w = &d->body[i];
        jo_real *x = part_of(m, d, i);
        for (int j = 0; j < 6 + b->n; j++) x[j] = 0.0;
        if (!jo_force_changed(w)) continue;
        jo_mul3(x, w->A, w->y);
        jo_set3(x + 3, w->y + 3);
        for (int j = 0; j < b->n; j++) x[6 + j] = w->yp[j];
    }
    for (int i = 0; i < m->njoint; i++) {
        jo_real *x = part_of(m, d, m->nbody + i);
        for (int r = 0; r < m->joint[i].nrow; r++) x[r] = 0.0;
    }
    solve(m, d);
    for (int i = 0; i < m->njoint; i++) {
        const jo_real *x = part_of(m, d, m->nbody + i);
        for (int r = 0; r < m->joint[i].nrow; r++) d->joint[i].x[r] = x[r];
    }
}

/* increment of least norm in M^ with Cq increment = -x of the joints */
void jo_coupled_correction(const jo_model *m, jo_data *d, jo_real *increment)
{
    for (int i = 0; i < m->nbody; i++) {
        jo_real *x = part_of(m, d, i);
        for (int j = 0; j < 6 + m->body[i].n; j++) x[j] = 0.0;
    }
    for (int i = 0; i < m->njoint; i++) {
        jo_real *x = part_of(m, d, m->nbody + i);
        for (int r = 0; r < m->joint[i].nrow; r++) x[r] = -d->joint[i].x[r];
    }
    solve(m, d);
    for (int i = 0; i < m->nbody; i++) {
        const jo_real *x = part_of(m, d, i);
        for (int j = 0; j < 6 + m->body[i].n; j++) increment[m->body[i].iv + j] = x[j];
    }
}
