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

int jo_tree_takes_contacts(const jo_model *m)
{
    return m->nlink && !jo_mixed(m) && !m->nloop && !m->nfriction && 3 * jo_contact_count(m) + jo_network_rows(m) <= JO_TREE_CONTACT_ROWS;
}

void jo_tree_contact_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    const int n = jo_tree_takes_contacts(m) ? 3 * jo_contact_count(m) + jo_network_rows(m) : 0;
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

/* columns of the joints between a link and the ground */
static void add_path(const jo_model *m, jo_data *d, jo_contact_matrix *c, int link, double sign)
{
    const jo_real *A = d->marker[m->force[c->force].a].A;
    const jo_vec point = jo_vec_load(c->point);
    for (int i = link; i >= 0; i = m->link[i].parent) {
        const jo_link *k = &m->link[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        const jo_vec arm = jo_vec_sub(point, w->p);
        if (k->type == JO_LINK_HINGE) add_column(c, A, k->u, sign, jo_vec_cross(w->A[2], arm));
        if (k->type == JO_LINK_SLIDE) add_column(c, A, k->u, sign, w->A[2]);
        const int turns = k->type == JO_LINK_BALL ? k->u : k->type == JO_LINK_FREE ? k->u + 3 : -1;
        for (int j = 0; j < 3 && turns >= 0; j++) add_column(c, A, turns + j, sign, jo_vec_cross(w->A[j], arm));
        for (int j = 0; j < 3 && k->type == JO_LINK_FREE; j++)
            add_column(c, A, k->u + j, sign, jo_vec_make(jo_same(j == 0), jo_same(j == 1), jo_same(j == 2)));
    }
}

void jo_tree_contact_jacobian(const jo_model *m, jo_data *d, jo_contact_matrix *c)
{
    c->at[0] = c->at[1] = c->count[1] = 0;
    c->count[0] = m->nu;
    for (int j = 0; j < 3 * m->nu; j++) c->J[0][j] = jo_same(0.0);
    add_path(m, d, c, c->link[1], 1.0);
    add_path(m, d, c, c->link[0], -1.0);
}

/* added force F (3), resolved in a, on b and -F on a at the contact point */
static void add_force(const jo_model *m, jo_data *d, const jo_contact_matrix *c, const jo_real *F)
{
    jo_real world[3];
    jo_mul3(world, d->marker[m->force[c->force].a].A, F);
    for (int s = 0; s < 2; s++) {
        if (c->link[s] < 0) continue;
        jo_link_response *r = &d->tree.response[c->link[s] + 1];
        const jo_vec f = jo_vec_scale(jo_same(s ? 1.0 : -1.0), jo_vec_load(world));
        const jo_vec arm = jo_vec_sub(jo_vec_load(c->point), d->tree.link[c->link[s] + 1].p);
        r->f = jo_vec_add(r->f, f);
        r->t = jo_vec_add(r->t, jo_vec_cross(arm, f));
    }
}

/* Y by rows, and the factors of 1 + G W; returns the number of rows */
static int prepare(const jo_model *m, jo_data *d)
{
    jo_tree *t = &d->tree;
    int n = 0;
    for (const jo_contact_matrix *c = jo_next_contact(d, 0); c; c = jo_next_contact(d, c))
        for (int i = 0; i < 3; i++, n++) {
            const jo_real unit[3] = {jo_same(i == 0), jo_same(i == 1), jo_same(i == 2)};
            jo_tree_clear_added_forces(m, d);
            add_force(m, d, c, unit);
            jo_tree_force_response(m, d, t->contact_response + n * m->nu);
        }
    const int contacts = n;
    for (int i = 0; i < jo_network_count(d); i++)
        for (int k = 0; k < jo_network_at(d, i)->m; k++, n++) {
            jo_tree_clear_added_forces(m, d);
            jo_tree_push_network(m, d, jo_network_at(d, i), k, jo_same(1.0));
            jo_tree_force_response(m, d, t->contact_response + n * m->nu);
        }
    int row = 0;
    for (const jo_contact_matrix *c = jo_next_contact(d, 0); c; c = jo_next_contact(d, c), row += 3)
        for (int j = 0; j < n; j++) {
            jo_real W[3], GW[3];
            jo_contact_velocity(c, t->contact_response + j * m->nu, W);
            jo_mul3(GW, c->G, W);
            for (int i = 0; i < 3; i++) t->contact_factors[(row + i) * n + j] = GW[i] + (row + i == j ? 1.0 : 0.0);
        }
    row = contacts;
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
    int row = 0;
    jo_tree_clear_added_forces(m, d);
    for (const jo_contact_matrix *c = jo_next_contact(d, 0); c; c = jo_next_contact(d, c), row += 3) {
        const jo_real *x = d->tree.contact_force + row, F[3] = {-x[0], -x[1], -x[2]};
        add_force(m, d, c, F);
    }
    for (int i = 0; i < jo_network_count(d); i++)
        for (int k = 0; k < jo_network_at(d, i)->m; k++, row++) jo_tree_push_network(m, d, jo_network_at(d, i), k, -d->tree.contact_force[row]);
    jo_tree_force_response(m, d, d->tree.joint_response);
    jo_tree_add_response(m, d, jo_same(1.0));
}

void jo_tree_contacts(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    jo_tree *t = &d->tree;
    jo_real *x = t->contact_force, J[3];
    if (!stage->earlier) t->contact_rows = prepare(m, d);
    for (const jo_contact_matrix *c = jo_next_contact(d, 0); c; c = jo_next_contact(d, c), x += 3) {
        jo_contact_velocity(c, d->ud, J);
        jo_mul3(x, c->G, J);
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
