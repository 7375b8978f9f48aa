/* tree_force_response.c - what further forces change in the accelerations of a tree, with the factors of its last evaluation.
 *
 * The second and third sweep of tree.c with another right-hand side: `change` of the links and `push` of the coordinates hold the
 * forces that are added; afterwards `change` has the accelerations of the links that follow and `rate` those of the joints.
 */
#include "tree/tree_links.h"

void jo_tree_respond_clear(const jo_model *m, jo_data *d)
{
    for (int i = 0; i <= m->nlink; i++) d->tree.change[i].f = d->tree.change[i].t = jo_vec_zero();
    for (int i = 0; i < m->nu; i++) d->tree.push[i] = 0.0;
}

/* inward: forces that pass a joint, less what it gives way to */
static void pass(const jo_model *m, jo_data *d)
{
    for (int i = m->nlink - 1; i >= 0; i--) {
        const jo_link *k = &m->link[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        jo_link_change *c = &d->tree.change[i + 1], *p = &d->tree.change[k->parent + 1];
        jo_vec f = c->f, t = c->t;
        if (k->type == JO_LINK_FREE) continue;
        if (k->type == JO_LINK_BALL) {
            f = jo_vec_less(f, jo_vec_times(w->X, t));
            t = jo_vec_cross(w->l, f);
        } else {
            t = jo_vec_add(t, jo_vec_cross(w->l, f));
        }
        if (jo_link_gives(d, k)) {
            c->rest = d->tree.push[k->u] + jo_vec_dot(w->A[2], k->type == JO_LINK_HINGE ? c->t : c->f);
            const jo_real share = -c->rest * w->r;
            f = jo_vec_with(f, share, w->Uf);
            t = jo_vec_with(t, share, w->Us);
        }
        p->f = jo_vec_add(p->f, f);
        p->t = jo_vec_add(p->t, t);
    }
}

void jo_tree_respond(const jo_model *m, jo_data *d, jo_real *rate)
{
    pass(m, d);
    d->tree.change[0].av = d->tree.change[0].aw = jo_vec_zero();
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        const jo_link_change *p = &d->tree.change[k->parent + 1];
        jo_link_change *c = &d->tree.change[i + 1];
        jo_real *y = rate + k->u;
        c->aw = p->aw;
        c->av = jo_vec_add(p->av, jo_vec_cross(p->aw, w->l));
        if (jo_link_gives(d, k)) {
            y[0] = w->r * (c->rest - jo_vec_dots(w->Uf, p->av, w->Us, p->aw));
            if (k->type == JO_LINK_HINGE) c->aw = jo_vec_with(c->aw, y[0], w->A[2]);
            else c->av = jo_vec_with(c->av, y[0], w->A[2]);
        } else if (k->type == JO_LINK_HINGE || k->type == JO_LINK_SLIDE) {
            y[0] = 0.0;
        } else if (k->type == JO_LINK_BALL || k->type == JO_LINK_FREE) {
            if (k->type == JO_LINK_FREE) {   /* what of the force its turns do not take moves it */
                jo_vec inverse[3];
                jo_vec_invert(inverse, w->M);
                c->av = jo_vec_times(inverse, jo_vec_less(c->f, jo_vec_times(w->X, c->t)));
                jo_vec_store(y, c->av);
                y += 3;
            }
            c->aw = jo_vec_less(jo_vec_times(w->inverse, c->t), jo_vec_across(w->X, c->av));
            jo_vec_store(y, jo_vec_across(w->A, k->type == JO_LINK_FREE ? c->aw : jo_vec_less(c->aw, p->aw)));
        }
    }
}
