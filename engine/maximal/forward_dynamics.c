/* forward_dynamics.c - accelerations and multipliers of a mechanism, projection onto its constraints, and its assembly. */
#include "valid.h"
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"
#include "beam/beam.h"
#include "contact/contact.h"
#include "network/network.h"
#include "friction/friction.h"
#include "tree/tree.h"

/* ratio of successive residuals above which a projection ends, since the factors do not reduce the residual further */
#define JO_MIN_REDUCTION 0.5

/* constants of set 1 for the effective modal mass E + g h D + (g h)^2 K */
void jo_use_step(const jo_model *m, jo_data *d, double gh)
{
    if (d->schur.gh == gh) return;
    for (int i = 0; i < m->nbody; i++) jo_body_setup(&m->body[i], &d->body[i], 1, gh);
    jo_marker_setup(m, d, 1);
    jo_joint_setup(m, d, 1);
    d->schur.gh = gh;
}

/* poses, velocities, inertia and forces at time, q, v */
static int update_forces(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    if (jo_in_hybrid(d)) {
        jo_hybrid_update_bodies(m, d);
    } else if (!jo_kinematics_valid(d)) {
        jo_update_positions(m, d);
        jo_marker_velocity(m, d, m->nactive);
    }
    jo_kinematics_used(d);
    for (int i = 0; i < m->nbody; i++)
        if (!jo_body_inactive(d, i)) jo_body_inertia(&m->body[i], &d->body[i], &d->power.damping);
    if (m->ncoordinate) jo_coordinates_rate(m, d, m->ncoordinate);
    if (jo_in_hybrid(d)) return jo_hybrid_condense(m, d, stage);
    const int status = m->nforce ? jo_apply_forces(m, d, stage) : JO_OK;
    if (m->nfriction && !stage->smooth) jo_friction_push_contacts(m, d);
    if (status != JO_OK || !m->nbeam) return status;
    return jo_beam_forces(m, d, stage->second ? jo_coupled_base(d) : 0);
}

/* Cholesky factors of the bodies, accelerations without joints, rows of the joints */
static int factor_masses(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    for (int i = 0; i < m->nbody; i++) {
        if (jo_body_inactive(d, i)) continue;
        const int carries = jo_in_hybrid(d) && jo_carries(&d->body[i]);
        const int status = carries ? jo_body_factor_carried(&m->body[i], &d->body[i]) : jo_body_factor(&m->body[i], &d->body[i], stage->set);
        if (status != JO_OK) {
            d->error_index = i;
            return status;
        }
        jo_body_free(&m->body[i], &d->body[i], stage->set);
    }
    jo_marker_bias(m, d, m->nactive);
    jo_marker_reduce(m, d, stage->set, m->nactive);
    if (jo_stabilised(stage)) {
        jo_largest_residual(m, d);
        jo_largest_residual_rate(m, d);
    }
    jo_joint_rows(m, d);
    return JO_OK;
}

/* multipliers joint[].x of S lam = Cq a_free + (Cq)' v, with dry friction */
static int solve_multipliers(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    int status;
    if (m->nfriction && m->redundant > 0) jo_friction_share(m, d);
    if (jo_couples(m, stage)) {
        status = jo_coupled_accelerations(m, d, stage);
    } else {
        jo_joint_acceleration(m, d, stage);
        status = jo_joint_factor(m, d, stage->set);
        if (status == JO_OK) jo_joint_solve(m, d);
    }
    if (status == JO_OK && m->nfriction && !stage->smooth) status = jo_friction_solve(m, d, stage);
    return status;
}

/* a and lam in maximal coordinates: forces, factors, multipliers, then a = M^-1 (Q - Cq^T lam) */
static int evaluate(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    static const jo_work none = {0.0, 0.0, 0.0};
    d->power = none;
    d->counts.evaluations++;
    int status = update_forces(m, d, stage);
    if (status == JO_OK) status = factor_masses(m, d, stage);
    if (status == JO_OK) status = solve_multipliers(m, d, stage);
    if (status != JO_OK) return status;
    const int couples = jo_couples(m, stage);
    if (!couples) {
        jo_apply_multipliers(m, d, stage->set, m->gravity, d->a);
        if (stage->separate) jo_networks_respond(m, d, stage);
    }
    d->drive = m->nline ? jo_joint_power(m, d) : jo_same(0.0);
    d->power.forces += d->drive;
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow && !jo_joint_inactive(d, i); r++) d->lam[m->joint[i].row + r] = d->joint[i].x[r];
    if (jo_in_hybrid(d) && !couples) jo_hybrid_forward_pass_2(m, d);
    return JO_OK;
}

/* a and lam at time, q, v, or ud at time, x, u; stage->set selects the modal mass */
int jo_evaluate(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    int status;
    if (jo_tree_active(d) && !jo_nmaximal(d)) status = jo_tree_evaluate(m, d, stage);
    else {
        jo_hybrid_begins(d);
        status = evaluate(m, d, stage);
        jo_hybrid_ends(d);
    }
    if (m->nstate && stage->set && jo_tree_active(d) && status == JO_OK) jo_tree_implicit_state_rates(m, d, stage);
    if (stage->contacts && status == JO_OK) {
        jo_contact_state_rates(m, d, stage);
        jo_networks_state_rates(m, d, stage);
    }
    return status;
}

/* q, v, a, lam of a tree. With redundant rows lam is the solution of least norm for all joints, computed in maximal coordinates. */
void jo_sync_all(const jo_model *m, jo_data *d)
{
    const int known = !jo_tree_active(d) || jo_sync_valid(d, JO_SYNC_ALL);
    jo_sync_maximal_state(m, d, JO_SYNC_ALL);
    if (known || !(m->nloop || jo_nmaximal(d)) || m->redundant <= 0) return;
    const jo_work power = d->power;
    const jo_real drive = d->drive;
    const jo_counts counts = d->counts;
    const jo_valid before = jo_detour_begins(d);
    jo_evaluate(m, d, &jo_now);
    d->power = power;
    d->drive = drive;
    d->counts = counts;
    jo_detour_ends(d, &before);
}

int jo_accelerations(const jo_model *m, jo_data *d)
{
    jo_state_changed(d);
    int status = jo_evaluate(m, d, &jo_now);
    jo_accelerations_found(d, status == JO_OK);
    return status;
}

/* q' for integrators of the caller, and a, lam with Baumgarte terms: R' = v, e' = e o (0, w) / 2, p' */
int jo_rates(const jo_model *m, jo_data *d, double alpha, double beta, jo_real *qdot)
{
    const jo_stage stage = {.alpha = alpha, .beta = beta};
    jo_state_changed(d);
    const int status = jo_evaluate(m, d, &stage);
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        const jo_real *e = d->q + b->iq + 3, *v = d->v + b->iv, *w = v + 3;
        jo_real *y = qdot + b->iq, turned[3];
        jo_set3(y, v);
        jo_cross(turned, e + 1, w);
        y[3] = -0.5 * jo_dot3(e + 1, w);
        for (int j = 0; j < 3; j++) y[4 + j] = 0.5 * (e[0] * w[j] + turned[j]);
        for (int j = 0; j < b->n; j++) y[7 + j] = v[6 + j];
    }
    return status;
}

/* state for sensors: poses and velocities; with `demanding` also accelerations, multipliers and the work of the last step */
int jo_ready_sensors(const jo_model *m, jo_data *d, int demanding)
{
    if (demanding && !jo_accelerations_valid(d)) {
        const int status = jo_accelerations(m, d);
        if (status != JO_OK) return status;
        jo_add_step_work(d);
    } else if (!jo_kinematics_valid(d) && !(demanding && jo_tree_active(d))) {
        jo_real unused[2];
        jo_residuals(m, d, unused);   /* poses and velocities at q, v */
        jo_kinematics_placed(d);
    }
    if (demanding) jo_sync_all(m, d);
    else jo_sync_maximal_state(m, d, JO_SYNC_STATE);
    return JO_OK;
}

/* increment = -M^-1 Cq^T S^-1 x with x of the joints and the factors of the last evaluation */
static void correction(const jo_model *m, jo_data *d, const jo_stage *stage, jo_real *increment)
{
    if (jo_couples(m, stage)) {
        jo_coupled_correction(m, d, increment);
        return;
    }
    for (int i = 0; i < m->nbody; i++) {
        jo_body_work *w = &d->body[i];
        if (jo_body_inactive(d, i)) continue;
        for (int j = 0; j < 6; j++) w->maximal.z[j] = jo_same(0.0);
        for (int j = 0; j < m->body[i].np; j++) w->fp[j] = jo_same(0.0);
    }
    jo_joint_solve(m, d);
    jo_apply_multipliers(m, d, stage->set, 0, increment);
}

/* d->rate = -M^-1 Cq^T S^-1 c, or with cdot if `velocity` */
static void residual_correction(const jo_model *m, jo_data *d, const jo_stage *stage, int velocity)
{
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++)
            d->joint[i].x[r] = velocity ? d->joint[i].cdot[r] : d->joint[i].c[r];
    correction(m, d, stage, d->rate);
}

/* NaN into the velocities of the bodies of joints whose residual exceeds the size of the mechanism: jo_check reports divergence */
static void mark_diverged(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->njoint; i++) {
        if (jo_joint_inactive(d, i)) continue;
        const jo_mask closed = JO_LESS_OR_EQUAL(jo_constraint_residual(m, d, i), jo_same(m->size));
        for (int s = 0; s < 2; s++) {
            const int body = m->marker[m->joint[i].side[s]].body;
            if (body >= 0) d->v[m->body[body].iv] = jo_choose(closed, d->v[m->body[body].iv], jo_same(NAN));
        }
    }
}

/* Projection: Newton's method in the norm of the mass matrix for C(q) = 0, then for Cq v = 0, with the factors of the last evaluation.
 * Usually one correction each; at most JO_MAX_CORRECTIONS. */
void jo_project(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    enum { JO_MAX_CORRECTIONS = 4 };   /* of positions and of velocities; the limit bounds the work of a step */
    if (!m->njoint) return;
    const double small = JO_CLOSED * m->size;   /* m */
    jo_hybrid_begins(d);
    if (jo_in_hybrid(d)) jo_hybrid_update_bodies(m, d);
    else jo_update_positions(m, d);
    /* positions: q = q o -M^-1 Cq^T S^-1 c */
    jo_real residual = jo_largest_residual(m, d);
    jo_mask open = JO_ALL;
    for (int k = 0; k < JO_MAX_CORRECTIONS && jo_some(open); k++) {
        const jo_real before = residual;
        residual_correction(m, d, stage, 0);
        jo_only(open, d->rate, m->nv);
        for (int i = 0; i < m->nbody; i++)
            if (!jo_body_inactive(d, i)) jo_body_add_increment(&m->body[i], d->q, d->q, d->rate);
        jo_update_positions(m, d);
        residual = jo_largest_residual(m, d);
        open &= JO_LESS(jo_same(small), residual) & JO_LESS(residual, JO_MIN_REDUCTION * before);
    }
    const int far = jo_some(JO_LESS(jo_same(m->size), residual));   /* diverged if the residual is too large in any lane */
    /* velocities: v -= M^-1 Cq^T S^-1 cdot */
    jo_marker_velocity(m, d, m->nactive);
    const jo_real small_rate = JO_CLOSED * jo_speed(m, d);   /* m/s */
    residual = jo_largest_residual_rate(m, d);
    open = JO_ALL;
    for (int k = 0; k < JO_MAX_CORRECTIONS && jo_some(open); k++) {
        const jo_real before = residual;
        residual_correction(m, d, stage, 1);
        jo_only(open, d->rate, m->nv);
        for (int i = 0; i < m->nbody; i++) {
            const jo_body *b = &m->body[i];
            if (jo_body_inactive(d, i)) continue;
            for (int j = b->iv; j < b->iv + 6 + b->n; j++) d->v[j] += d->rate[j];
            jo_body_twist(b, &d->body[i], d->v + b->iv);
        }
        jo_marker_velocity(m, d, m->nactive);
        residual = jo_largest_residual_rate(m, d);
        open &= JO_LESS(small_rate, residual) & JO_LESS(residual, JO_MIN_REDUCTION * before);
    }
    if (far) mark_diverged(m, d);
    jo_state_projected(d);
    if (jo_in_hybrid(d)) jo_hybrid_accept_state(m, d);
    jo_hybrid_ends(d);
}

/* sum of squares of the position residuals, which decreases along Newton's direction */
static double sum_of_squares(const jo_model *m, const jo_data *d)
{
    jo_real sum = {0.0};
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) sum += jo_magnitude(d->joint[i].c[r]) * jo_magnitude(d->joint[i].c[r]);
    return jo_most(sum);
}

/* Newton's method in the norm of the mass matrix for C(q) = 0, with increments halved until the sum of squares decreases, then for
 * Cq v = 0 */
static int close_joints(const jo_model *m, jo_data *d, int iterations, double tolerance)
{
    /* largest number of halvings of a step; iterations for derivatives and velocities */
    enum { JO_MAX_HALVINGS = 10, JO_FINAL_ITERATIONS = 2 };
    static const jo_stage geometry = {.smooth = 1};
    jo_state_changed(d);
    jo_update_positions(m, d);
    double residual = jo_most(jo_largest_residual(m, d));
    for (int k = 0; k < iterations && residual > tolerance; k++) {
        const double before = residual, merit = sum_of_squares(m, d);
        jo_kinematics_used(d);
        int status = jo_evaluate(m, d, &geometry);
        if (status != JO_OK) return status;
        jo_largest_residual(m, d);
        residual_correction(m, d, &geometry, 0);
        for (int i = 0; i < m->nq; i++) d->q0[i] = d->q[i];
        double part = 1.0;
        for (int l = 0; l < JO_MAX_HALVINGS; l++, part *= 0.5) {
            for (int i = 0; i < m->nv; i++) d->dq[i] = part * d->rate[i];
            jo_add_increment(m, d->q, d->q0, d->dq);
            jo_update_positions(m, d);
            residual = jo_most(jo_largest_residual(m, d));
            if (sum_of_squares(m, d) < merit) break;
        }
        if (residual > JO_MIN_REDUCTION * before && residual < JO_CLOSED * m->size) break;   /* round-off */
    }
#ifdef JO_COMPLEX
    for (int k = 0; k < JO_FINAL_ITERATIONS; k++) {   /* derivatives converge one iteration later than values: full steps without halving */
        jo_kinematics_used(d);
        int status = jo_evaluate(m, d, &geometry);
        if (status != JO_OK) return status;
        jo_largest_residual(m, d);
        residual_correction(m, d, &geometry, 0);
        for (int i = 0; i < m->nq; i++) d->q0[i] = d->q[i];
        jo_add_increment(m, d->q, d->q0, d->rate);
        jo_update_positions(m, d);
    }
#endif
    for (int k = 0; k < 2; k++) {
        jo_kinematics_used(d);
        int status = jo_evaluate(m, d, &geometry);
        if (status != JO_OK) return status;
        jo_largest_residual_rate(m, d);
        residual_correction(m, d, &geometry, 1);
        for (int i = 0; i < m->nv; i++) d->v[i] += d->rate[i];
    }
    jo_update_positions(m, d);
    if (m->nturn) jo_count_turns(m, d);
    jo_state_changed(d);
    return JO_OK;
}

int jo_assemble(const jo_model *m, jo_data *d, int iterations, double tolerance)
{
    return close_joints(m, d, iterations, tolerance);
}

/* mass matrix of one body for [R'' (body frame), w', p''] at the present q */
void jo_mass_matrix(const jo_model *m, jo_data *d, int body, jo_real *M)
{
    const jo_body *b = &m->body[body];
    jo_body_work *w = &d->body[body];
    const int n = 6 + b->n;
    jo_real unused = {0.0};
    jo_body_pose(b, w, d->q + b->iq);
    jo_body_twist(b, w, d->v + b->iv);
    jo_body_inertia(b, w, &unused);
    for (int i = 0; i < n * n; i++) M[i] = jo_same(0.0);
    for (int i = 0; i < 3; i++) M[i * n + i] = b->mass[0];
    const jo_real *S = w->S, *J = w->J;
    M[4] = S[2]; M[5] = -S[1]; M[n + 3] = -S[2]; M[n + 5] = S[0]; M[2 * n + 3] = S[1]; M[2 * n + 4] = -S[0];
    M[3 * n + 3] = J[0]; M[4 * n + 4] = J[1]; M[5 * n + 5] = J[2];
    M[3 * n + 4] = J[5]; M[3 * n + 5] = J[4]; M[4 * n + 5] = J[3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < b->n; j++) {
            M[i * n + 6 + j] = b->I3[i * b->np + j];
            M[(3 + i) * n + 6 + j] = w->B[i * b->np + j];
        }
    for (int j = 0; j < b->n; j++) M[(6 + j) * n + 6 + j] = jo_same(1.0);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++) M[i * n + j] = M[j * n + i];
}
