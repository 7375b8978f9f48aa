/* tree_on_flexible_bodies.c - hybrid mode: rigid trees in joint coordinates on bodies in maximal coordinates, such as modal bodies.
 *
 * The backward pass condenses each tree to the articulated inertia I^A (6x6) and the bias force p^A at the body that carries the tree.
 * The maximal-coordinate solver adds I^A to the inertia of the carrier and -p^A to its forces, and solves for its acceleration a. Forward
 * pass 2 starts from a. The first nmaximal links are the bodies in maximal coordinates; their joint coordinates are q and v, so that
 * x, u is the state of all bodies.
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "tree/tree_links.h"

/* q, v = x, u of the bodies in maximal coordinates; pose and velocity of these bodies and of their markers */
void jo_hybrid_update_bodies(const jo_model *m, jo_data *d)
{
    const int hybrid = jo_in_hybrid(d);
    if (jo_sync_is_hybrid(d)) return;
    for (int i = 0; i < jo_nmaximal(d); i++) {
        const jo_link *k = &m->link[i];
        const jo_body *b = &m->body[k->body];
        for (int j = 0; j < 7 + b->n; j++) d->q[b->iq + j] = d->x[k->x + j];
        for (int j = 0; j < 6 + b->n; j++) d->v[b->iv + j] = d->u[k->u + j];
    }
    jo_hybrid_begins(d);
    jo_update_positions(m, d);
    jo_marker_velocity(m, d, m->nactive);
    if (!hybrid) jo_hybrid_ends(d);
    jo_sync_reached(d, JO_SYNC_HYBRID);
}

/* x, u = q, v of the bodies in maximal coordinates */
void jo_hybrid_accept_state(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < jo_nmaximal(d); i++) {
        const jo_link *k = &m->link[i];
        const jo_body *b = &m->body[k->body];
        for (int j = 0; j < 7 + b->n; j++) d->x[k->x + j] = d->q[b->iq + j];
        for (int j = 0; j < 6 + b->n; j++) d->u[k->u + j] = d->v[b->iv + j];
    }
    jo_sync_reached(d, JO_SYNC_HYBRID);
}

/* links of the carriers: orientation, angular velocity, accelerations 0, accumulators 0 */
static void reset_carriers(const jo_model *m, jo_data *d)
{
    const jo_vec zero = jo_vec_zero();
    for (int i = 0; i < jo_nmaximal(d); i++) {
        const jo_link *k = &m->link[i];
        const jo_body_work *b = &d->body[k->body];
        jo_link_work *w = &d->tree.link[i + 1];
        if (!b->carried) continue;
        for (int j = 0; j < 3; j++) {
            w->A[j] = jo_vec_load(b->At + 4 * j);
            w->M[j] = w->H[j] = w->J[j] = zero;
        }
        w->w = jo_vec_mat_mul(w->A, b->w);
        w->l = jo_vec_load(d->x + k->x);
        w->bias_alpha = w->bias_a = w->f = w->t = w->joint_f = w->joint_t = zero;
    }
}

/* y = A^T M A, by columns */
static void rotate_to_body(jo_real (*y)[3], const jo_vec *A, const jo_vec *M)
{
    for (int j = 0; j < 3; j++) jo_vec_store(y[j], jo_vec_mat_tmul(A, jo_vec_mat_mul_at(M, &A[j])));
}

/* carried = [M H; H^T J] of the trees in the body frame + [0 -S~; S~ J] of the body, fr -= p^A */
static void add_carried_inertia(const jo_link_work *w, jo_body_work *b)
{
    jo_real M[3][3], H[3][3], J[3][3], f[3], t[3];
    const jo_real *S = b->S, *Jb = b->J;
    rotate_to_body(M, w->A, w->M);
    rotate_to_body(H, w->A, w->H);
    rotate_to_body(J, w->A, w->J);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            b->carried[6 * i + k] = M[k][i];
            b->carried[6 * (3 + i) + k] = H[i][k];
            b->carried[6 * (3 + i) + 3 + k] = J[k][i];
        }
    /* inertia of the body itself, except for its mass */
    const jo_real own[9] = {0.0, -S[2], S[1], S[2], 0.0, -S[0], -S[1], S[0], 0.0};
    const jo_real full[9] = {Jb[0], Jb[5], Jb[4], Jb[5], Jb[1], Jb[3], Jb[4], Jb[3], Jb[2]};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            b->carried[6 * (3 + i) + k] += own[3 * i + k];
            b->carried[6 * (3 + i) + 3 + k] += full[3 * i + k];
        }
    jo_vec_store(f, jo_vec_mat_tmul(w->A, w->f));
    jo_vec_store(t, jo_vec_mat_tmul(w->A, w->t));
    jo_sub3(b->fr, f);
    jo_sub3(b->fr + 3, t);
}

/* forward pass 1, forces, backward pass of all trees; I^A and p^A to their carriers */
int jo_hybrid_condense(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    reset_carriers(m, d);
    const int status = jo_tree_articulated_inertias(m, d, stage);
    for (int i = 0; i < jo_nmaximal(d) && status == JO_OK; i++) {
        jo_body_work *b = &d->body[m->link[i].body];
        if (b->carried) add_carried_inertia(&d->tree.link[i + 1], b);
    }
    return status;
}

/* Cholesky factor L of the 6x6 inertia of a rigid carrier, as in body.c; recomputed in every evaluation because I^A depends on x */
int jo_hybrid_factor_body(const jo_body *b, jo_body_work *w)
{
    for (int i = 0; i < 6; i++) {
        jo_real *x = w->L + 6 * i;
        const jo_real diagonal = w->carried[7 * i] + (i < 3 ? b->mass[0] : jo_same(0.0));
        for (int k = 0; k <= i; k++) {
            const jo_real *y = w->L + 6 * k;
            jo_real t = k < i ? w->carried[6 * i + k] : diagonal;
            for (int j = 0; j < k; j++) t -= x[j] * y[j];
            if (k < i) {
                x[k] = t * y[k];
                continue;
            }
            if (jo_spoil(&t, JO_LESS(JO_MIN_PIVOT * diagonal, t))) return isfinite(jo_most(t)) ? JO_SINGULAR_BODY : JO_NOT_FINITE;
            x[i] = 1.0 / jo_sqrt(t);
        }
    }
    return JO_OK;
}

/* ud of the bodies in maximal coordinates; accelerations of the carriers at their links; forward pass 2; power of the drives */
void jo_hybrid_forward_pass_2(const jo_model *m, jo_data *d)
{
    jo_tree *t = &d->tree;
    for (int i = 0; i < jo_nmaximal(d); i++) {
        const jo_link *k = &m->link[i];
        const jo_body *b = &m->body[k->body];
        const jo_body_work *w = &d->body[k->body];
        jo_link_work *link = &t->link[i + 1];
        for (int j = 0; j < 6 + b->n; j++) d->ud[k->u + j] = d->a[b->iv + j];
        if (!w->carried) continue;
        link->a = jo_vec_mat_mul(link->A, w->y);
        link->alpha = jo_vec_mat_mul(link->A, w->y + 3);
    }
    jo_tree_forward_pass_2(m, d);
    const jo_real power = jo_tree_drive_forces(m, d);
    d->drive += power;
    d->power.forces += power;
}
