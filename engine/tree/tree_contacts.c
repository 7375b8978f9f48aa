/* tree_contacts.c - contacts of a tree in joint coordinates in the matrix of a Rosenbrock method.
 *
 * With the joint-space inertia H of the articulated-body algorithm and its accelerations qdd0, the matrix H + J^T G J gives (Woodbury 1950)
 *   qdd = qdd0 - Y x,  (1 + G W) x = G J qdd0,  Y = H^-1 J^T,  W = J Y
 * J: see contact.h. A column of Y is the response to a unit force between two links. Y and the factors are those of the first stage:
 * G J qdd is O(h) and H changes by O(h), so that the second stage has an error O(h^2), and the order of the method remains 2. */
#include "maximal/maximal.h"
#include "contact/contact.h"
#include "network/network.h"
#include "tree/tree_links.h"

/* Few bodies may move freely beside the trees if sets of shapes touch: each may have several contacts, and Newton's matrix is sparse. */
int jo_tree_takes_contacts(const jo_model *m)
{
    int count = 0, bodies = 0, sets = 0;
    if (!m->nlink || jo_mixed(m) || m->nloop || m->nfriction) return 0;
    for (int i = 0; i < m->nforce; i++) {
        if (m->force[i].type != JO_FORCE_contact_slot) count += jo_contact_blocks(&m->force[i]);
        sets += jo_is_contact_set(&m->force[i]);
    }
    for (int i = 0; sets && i < m->nlink; i++) bodies += m->link[i].type == JO_LINK_FREE;
    return 3 * count + jo_network_rows(m) <= JO_TREE_ROWS && bodies <= JO_TREE_BODIES;
}

void jo_tree_contact_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    int count = 0;
    for (int i = 0; i < m->nforce; i++) count += jo_contact_blocks(&m->force[i]);
    const int closed = jo_tree_takes_contacts(m) ? 3 * (count < JO_TREE_CLOSED ? count : JO_TREE_CLOSED) : 0;
    const int n = jo_tree_takes_contacts(m) ? closed + jo_network_rows(m) : 0;
    d->tree.contact_jacobian = jo_take_reals(a, closed * m->nu);
    d->tree.contact_response = jo_take_reals(a, n * m->nu);
    d->tree.contact_factors = jo_take_reals(a, n * n);
    d->tree.contact_force = jo_take_reals(a, n);
    d->tree.contact_pivot = jo_take_ints(a, n);
}

/* y (3) += sign A_a^T v in column j of J */
static void add_column(jo_contact_matrix *c, const jo_real *A, int j, double sign, jo_vec v)
{
    const int n = c->count[0];
    jo_real world[3], y[3];
    jo_vec_store(world, v);
    jo_mul3t(y, A, world);
    for (int i = 0; i < 3; i++) c->J[0][i * n + j] += sign * y[i];
}

/* velocity of the contact point, or angular velocity, with a unit angular velocity about an axis */
static jo_vec turned_by(const jo_contact_matrix *c, jo_vec axis, jo_vec arm) { return c->turns ? axis : jo_vec_cross(axis, arm); }

/* columns of the joints between a link and the ground */
static void add_path(const jo_model *m, jo_data *d, jo_contact_matrix *c, int link, double sign)
{
    const jo_real *A = d->marker[c->force->a].A;
    const jo_vec point = jo_vec_load(c->point);
    for (int i = link; i >= 0; i = m->link[i].parent) {
        const jo_link *k = &m->link[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        const jo_vec arm = jo_vec_sub(point, w->p);
        if (k->type == JO_LINK_HINGE) add_column(c, A, k->u, sign, turned_by(c, w->A[2], arm));
        if (k->type == JO_LINK_SLIDE && !c->turns) add_column(c, A, k->u, sign, w->A[2]);
        const int turns = k->type == JO_LINK_BALL ? k->u : k->type == JO_LINK_FREE ? k->u + 3 : -1;
        for (int j = 0; j < 3 && turns >= 0; j++) add_column(c, A, turns + j, sign, turned_by(c, w->A[j], arm));
        for (int j = 0; j < 3 && k->type == JO_LINK_FREE && !c->turns; j++)
            add_column(c, A, k->u + j, sign, jo_vec_make(jo_same(j == 0), jo_same(j == 1), jo_same(j == 2)));
    }
}

void jo_tree_contact_jacobian(const jo_model *m, jo_data *d, jo_contact_matrix *c)
{
    c->at[0] = c->at[1] = c->count[1] = 0;
    c->count[0] = m->nu;
    c->J[0] = d->tree.contact_jacobian + 3 * m->nu * (jo_closed_contacts(d) - 1);   /* it is the last one of the list */
    for (int j = 0; j < 3 * m->nu; j++) c->J[0][j] = jo_same(0.0);
    add_path(m, d, c, jo_marker_link(m, d, c->force->b), 1.0);
    add_path(m, d, c, jo_marker_link(m, d, c->force->a), -1.0);
}

/* added force F (3), resolved in a, on b and -F on a at the contact point */
static void add_force(const jo_model *m, jo_data *d, const jo_contact_matrix *c, const jo_real *F)
{
    jo_real world[3];
    jo_mul3(world, d->marker[c->force->a].A, F);
    for (int s = 0; s < 2; s++) {
        const int link = jo_marker_link(m, d, s ? c->force->b : c->force->a);
        if (link < 0) continue;
        jo_link_response *r = &d->tree.response[link + 1];
        const jo_vec f = jo_vec_scale(jo_same(s ? 1.0 : -1.0), jo_vec_load(world));
        if (c->turns) {   /* a moment */
            r->t = jo_vec_add(r->t, f);
            continue;
        }
        const jo_vec arm = jo_vec_sub(jo_vec_load(c->point), d->tree.link[link + 1].p);
        r->f = jo_vec_add(r->f, f);
        r->t = jo_vec_add(r->t, jo_vec_cross(arm, f));
    }
}

/* Y by rows, and the factors of 1 + G W; returns the number of rows */
static int prepare(const jo_model *m, jo_data *d)
{
    jo_tree *t = &d->tree;
    const int contacts = 3 * jo_closed_contacts(d);
    int n = 0;
    for (; n < contacts; n++) {
        const jo_real unit[3] = {jo_same(n % 3 == 0), jo_same(n % 3 == 1), jo_same(n % 3 == 2)};
        jo_tree_clear_added_forces(m, d);
        add_force(m, d, jo_closed_contact(d, n / 3), unit);
        jo_tree_force_response(m, d, t->contact_response + n * m->nu);
    }
    for (int i = 0; i < jo_network_count(d); i++)
        for (int k = 0; k < jo_network_at(d, i)->m; k++, n++) {
            jo_tree_clear_added_forces(m, d);
            jo_tree_push_network(m, d, jo_network_at(d, i), k, jo_same(1.0));
            jo_tree_force_response(m, d, t->contact_response + n * m->nu);
        }
    for (int row = 0; row < contacts; row += 3)
        for (int j = 0; j < n; j++) {
            const jo_contact_matrix *c = jo_closed_contact(d, row / 3);
            jo_real W[3], GW[3];
            jo_contact_velocity(c, t->contact_response + j * m->nu, W);
            jo_mul3(GW, c->G, W);
            for (int i = 0; i < 3; i++) t->contact_factors[(row + i) * n + j] = GW[i] + (row + i == j ? 1.0 : 0.0);
        }
    int row = contacts;
    for (int i = 0; i < jo_network_count(d); i++) {
        const jo_network *w = jo_network_at(d, i);
        for (int j = 0; j < n; j++) {
            jo_network_rates_along(w, t->contact_response + j * m->nu, w->y);
            for (int k = 0; k < w->m; k++) {
                jo_real x = jo_same(row + k == j ? 1.0 : 0.0);
                for (int l = 0; l < w->m; l++) x += w->G[k * w->m + l] * w->y[l];
                t->contact_factors[(row + k) * n + j] = x;
            }
        }
        row += w->m;
    }
    jo_network_factor(t->contact_factors, n, t->contact_pivot);
    return n;
}

/* the accelerations of the links, for the forces of drives */
static void accept_forces(const jo_model *m, jo_data *d)
{
    int row = 3 * jo_closed_contacts(d);
    jo_tree_clear_added_forces(m, d);
    for (int k = 0; k < jo_closed_contacts(d); k++) {
        const jo_real *x = d->tree.contact_force + 3 * k, F[3] = {-x[0], -x[1], -x[2]};
        add_force(m, d, jo_closed_contact(d, k), F);
    }
    for (int i = 0; i < jo_network_count(d); i++)
        for (int k = 0; k < jo_network_at(d, i)->m; k++, row++) jo_tree_push_network(m, d, jo_network_at(d, i), k, -d->tree.contact_force[row]);
    jo_tree_force_response(m, d, d->tree.joint_response);
    jo_tree_add_response(m, d, jo_same(1.0));
}

void jo_tree_contacts(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    jo_tree *t = &d->tree;
    jo_real *x = t->contact_force + 3 * jo_closed_contacts(d), J[3];
    if (!stage->earlier) t->contact_rows = prepare(m, d);
    for (int k = 0; k < jo_closed_contacts(d); k++) {
        const jo_contact_matrix *c = jo_closed_contact(d, k);
        jo_contact_velocity(c, d->ud, J);
        jo_mul3(t->contact_force + 3 * k, c->G, J);
    }
    for (int i = 0; i < jo_network_count(d); i++) {
        const jo_network *w = jo_network_at(d, i);
        jo_network_rates_along(w, d->ud, w->y);
        for (int k = 0; k < w->m; k++, x++) {
            *x = jo_same(0.0);
            for (int l = 0; l < w->m; l++) *x += w->G[k * w->m + l] * w->y[l];
        }
    }
    const int n = t->contact_rows;
    jo_network_solve(t->contact_factors, n, t->contact_pivot, t->contact_force);
    for (int k = 0; k < n; k++)
        for (int i = 0; i < m->nu; i++) d->ud[i] -= t->contact_force[k] * t->contact_response[k * m->nu + i];
    if (t->ndriven) accept_forces(m, d);
}
