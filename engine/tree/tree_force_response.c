/* tree_force_response.c - change of the accelerations of a tree by added forces, with the factors of the last evaluation.
 *
 * Backward pass and forward pass 2 of tree.c for another right-hand side, with I^A, U and D^-1 unchanged. Input: response.f, response.t at
 * the links and added_tau along the joints. Output: response.alpha, response.a of the links and the change `rate` of qdd.
 */
#include "tree/tree_links.h"

void jo_tree_clear_added_forces(const jo_model *m, jo_data *d)
{
    for (int i = 0; i <= m->nlink; i++) d->tree.response[i].f = d->tree.response[i].t = jo_vec_zero();
    for (int i = 0; i < m->nu; i++) d->tree.added_tau[i] = 0.0;
}

/* u of a joint less the shares c D^-1 u of its motors, which come before it in the backward pass */
static inline void pass_to_joint(jo_data *d, const jo_link_work *w, jo_link_response *c, int link)
{
    const jo_link_coupling *g = &d->tree.coupling[link];
    c->u -= g->added_u;
    if (g->to >= 0) d->tree.coupling[g->to].added_u += g->c * w->Dinv * c->u;
}

/* f^a = f^A - U D^-1 u, added to the parent, with u = added_tau + S^T f^A; a parent i - 1 receives it in registers */
static void backward_pass(const jo_model *m, jo_data *d)
{
    jo_vec f = jo_vec_zero(), t = f;   /* f^a of link i + 1 if that is a child of link i, else 0 */
    for (int i = 0; i < m->nlink && d->tree.coupled; i++) d->tree.coupling[i].added_u = jo_same(0.0);
    for (int i = m->nlink - 1; i >= 0; i--) {
        const jo_link *k = &m->link[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        jo_link_response *c = &d->tree.response[i + 1], *p = &d->tree.response[k->parent + 1];
        f = c->f = jo_vec_add(c->f, f);
        t = c->t = jo_vec_add(c->t, t);
        if (k->type == JO_LINK_FREE) {
            f = t = jo_vec_zero();
            continue;
        }
        if (k->type == JO_LINK_BALL) {   /* f - H J^-1 t; no moment remains */
            f = jo_vec_sub(f, jo_vec_mat_mul_lanes(w->HJinv, t));
            t = jo_vec_cross(w->l, f);
        } else {
            t = jo_vec_add(t, jo_vec_cross(w->l, f));
        }
        if (jo_link_has_one_dof(d, k)) {   /* u = added_tau + S^T f; f - U D^-1 u */
            c->u = d->tree.added_tau[k->u] + jo_vec_dot(w->A[2], k->type == JO_LINK_HINGE ? c->t : c->f);
            if (d->tree.coupled) pass_to_joint(d, w, c, i);
            const jo_real Dinv_u = -c->u * w->Dinv;
            f = jo_vec_axpy(f, Dinv_u, w->Uf);
            t = jo_vec_axpy(t, Dinv_u, w->Ut_parent);
        }
        if (k->parent == i - 1) continue;
        p->f = jo_vec_add(p->f, f);
        p->t = jo_vec_add(p->t, t);
        f = t = jo_vec_zero();
    }
}

/* forward pass 2: qdd = D^-1 (u - U^T a'), a = a' + S qdd with a' = a_lambda + alpha_lambda x l; the accelerations of a parent i - 1 are
 * still in registers */
void jo_tree_force_response(const jo_model *m, jo_data *d, jo_real *rate)
{
    jo_vec alpha = jo_vec_zero(), a = alpha;
    int last = -1;   /* link whose accelerations are in alpha, a */
    backward_pass(m, d);
    d->tree.response[0].a = d->tree.response[0].alpha = jo_vec_zero();
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        const jo_link_response *p = &d->tree.response[k->parent + 1];
        jo_link_response *c = &d->tree.response[i + 1];
        jo_real *y = rate + k->u;
        const jo_vec alpha_parent = k->parent == last ? alpha : p->alpha, a_parent = k->parent == last ? a : p->a;
        alpha = alpha_parent;
        a = jo_vec_add(a_parent, jo_vec_cross(alpha_parent, w->l));
        if (jo_link_has_one_dof(d, k)) {
            y[0] = w->Dinv * (c->u - jo_vec_dot_sum(w->Uf, a_parent, w->Ut_parent, alpha_parent));
            if (d->tree.coupled) y[0] -= w->Dinv * jo_link_coupled(m, d, i, rate);
            if (k->type == JO_LINK_HINGE) alpha = jo_vec_axpy(alpha, y[0], w->A[2]);
            else a = jo_vec_axpy(a, y[0], w->A[2]);
        } else if (k->type == JO_LINK_HINGE || k->type == JO_LINK_SLIDE) {
            y[0] = 0.0;
        } else if (k->type == JO_LINK_BALL || k->type == JO_LINK_FREE) {
            if (k->type == JO_LINK_FREE) {   /* a = M^-1 (f - H J^-1 t), M after elimination of the rotations */
                jo_vec Minv[3];
                jo_vec_invert(Minv, w->M);
                a = jo_vec_mat_mul_lanes(Minv, jo_vec_sub(c->f, jo_vec_mat_mul_lanes(w->HJinv, c->t)));
                jo_vec_store(y, a);
                y += 3;
            }
            /* alpha = J^-1 (t - H^T a) */
            alpha = jo_vec_sub(jo_vec_mat_mul_lanes(w->Jinv, c->t), jo_vec_mat_tmul(w->HJinv, a));
            jo_vec_store(y, jo_vec_mat_tmul(w->A, k->type == JO_LINK_FREE ? alpha : jo_vec_sub(alpha, alpha_parent)));
        }
        c->alpha = alpha;
        c->a = a;
        last = i;
    }
}

void jo_tree_add_response(const jo_model *m, jo_data *d, jo_real part)
{
    for (int i = 1; i <= m->nlink; i++) {
        const jo_link_response *c = &d->tree.response[i];
        jo_link_work *w = &d->tree.link[i];
        const int type = m->link[i - 1].type;
        const jo_vec change = type == JO_LINK_BALL || type == JO_LINK_FREE ? jo_vec_sub(c->f, jo_vec_mat_mul_lanes(w->HJinv, c->t)) : c->f;
        w->f = jo_vec_axpy(w->f, -part, change);   /* p^A of the joint reaction */
        w->t = jo_vec_axpy(w->t, -part, c->t);
        w->alpha = jo_vec_axpy(w->alpha, part, c->alpha);
        w->a = jo_vec_axpy(w->a, part, c->a);
    }
}
