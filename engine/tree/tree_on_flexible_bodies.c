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
        if (!jo_carries(b)) continue;
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

/* I^A of the trees to the inertia of the body that carries them, fr -= p^A */
static void add_carried_inertia(const jo_link_work *w, jo_body_work *b)
{
    jo_real M[3][3], H[3][3], J[3][3], f[3], t[3];
    rotate_to_body(M, w->A, w->M);
    rotate_to_body(H, w->A, w->H);
    rotate_to_body(J, w->A, w->J);
    jo_body_carry(b, M, H, J);
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
        if (jo_carries(b)) add_carried_inertia(&d->tree.link[i + 1], b);
    }
    return status;
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
        if (!jo_carries(w)) continue;
        link->a = jo_vec_mat_mul(link->A, w->y);
        link->alpha = jo_vec_mat_mul(link->A, w->y + 3);
    }
    jo_tree_forward_pass_2(m, d);
    const jo_real power = jo_tree_drive_forces(m, d);
    d->drive += power;
    d->power.forces += power;
}
