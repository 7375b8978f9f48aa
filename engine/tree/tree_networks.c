/* tree_networks.c - networks of states along coordinates of a tree in joint coordinates, see tree_contacts.c. */
#include "maximal/maximal.h"
#include "network/network.h"
#include "tree/tree_links.h"

/* J += sign times the motion of a marker: of its point along `along`, of its frame along `turn` */
static void add_path(const jo_model *m, const jo_data *d, jo_real *J, int link, int marker, double sign, const jo_real *along, const jo_real *turn)
{
    const jo_vec point = jo_vec_load(d->marker[marker].r), a = jo_vec_scale(jo_same(sign), jo_vec_load(along)), b = jo_vec_load(turn);
    for (int i = link; i >= 0; i = m->link[i].parent) {
        const jo_link *k = &m->link[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        const jo_vec moment = jo_vec_add(jo_vec_cross(jo_vec_sub(point, w->p), a), b);
        if (k->type == JO_LINK_HINGE) J[k->u] += jo_vec_dot(w->A[2], moment);
        if (k->type == JO_LINK_SLIDE) J[k->u] += jo_vec_dot(w->A[2], a);
        const int turns = k->type == JO_LINK_BALL ? k->u : k->type == JO_LINK_FREE ? k->u + 3 : -1;
        for (int j = 0; j < 3 && turns >= 0; j++) J[turns + j] += jo_vec_dot(w->A[j], moment);
        for (int j = 0; j < 3 && k->type == JO_LINK_FREE; j++) J[k->u + j] += jo_vec_element(a, j);
    }
}

void jo_tree_network_jacobian(const jo_model *m, jo_data *d, jo_network *w, int k)
{
    const int c = w->coordinate[k];
    const jo_coordinate *of = &m->coordinate[c];
    w->at[2 * k] = w->at[2 * k + 1] = w->count[2 * k + 1] = 0;
    if (of->link >= 0) {
        w->at[2 * k] = m->link[of->link].u;
        w->count[2 * k] = 1;
        w->J[2 * k][0] = jo_link_sign(&m->link[of->link]);
        return;
    }
    const jo_coordinate_work *x = &d->coordinate[c];
    w->count[2 * k] = m->nu;
    for (int j = 0; j < m->nu; j++) w->J[2 * k][j] = jo_same(0.0);
    add_path(m, d, w->J[2 * k], w->link[2 * k], of->a, -1.0, x->along, x->turn_a);
    add_path(m, d, w->J[2 * k], w->link[2 * k + 1], of->b, 1.0, x->along, x->turn_b);
}

/* added force F along coordinate k */
void jo_tree_push_network(const jo_model *m, jo_data *d, const jo_network *w, int k, jo_real F)
{
    const int c = w->coordinate[k];
    const jo_coordinate *of = &m->coordinate[c];
    if (of->link >= 0) {
        const jo_link *link = &m->link[of->link];
        d->tree.added_tau[link->u] += jo_link_sign(link) * F;
        return;
    }
    const jo_coordinate_work *x = &d->coordinate[c];
    for (int s = 0; s < 2; s++) {
        const int link = w->link[2 * k + s];
        if (link < 0) continue;
        jo_link_response *r = &d->tree.response[link + 1];
        const jo_vec f = jo_vec_scale((s ? 1.0 : -1.0) * F, jo_vec_load(x->along));
        const jo_vec arm = jo_vec_sub(jo_vec_load(d->marker[s ? of->b : of->a].r), d->tree.link[link + 1].p);
        r->f = jo_vec_add(r->f, f);
        r->t = jo_vec_add(r->t, jo_vec_add(jo_vec_cross(arm, f), jo_vec_scale(F, jo_vec_load(s ? x->turn_b : x->turn_a))));
    }
}
