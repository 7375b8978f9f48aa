/* tree_layout.c - memory of trees in joint coordinates. */
#include "maximal/maximal.h"
#include "tree/tree_links.h"

/* links of a tree, including the ground, and lists for forces */
static void lay_links(const jo_model *m, jo_data *d, jo_arena *a)
{
    jo_tree *t = &d->tree;
    jo_real **along[5] = {&t->tau, &t->stiffness, &t->damping, &t->added_tau, &t->joint_response};
    for (int i = 0; i < 5; i++) *along[i] = jo_take_reals(a, m->nu);
    t->drive_force = jo_take_reals(a, m->nlink);
    t->maximal_copy = jo_take_reals(a, m->nlink ? m->nq + m->nv : 0);
    t->link = jo_take(a, m->nlink ? (size_t)(m->nlink + 1) * sizeof *t->link : 0);
    t->response = jo_take(a, m->nlink ? (size_t)(m->nlink + 1) * sizeof *t->response : 0);
    t->coupling = jo_take(a, m->nlink ? (size_t)m->nlink * sizeof *t->coupling : 0);
    t->constants = jo_take(a, (size_t)m->nlink * sizeof *t->constants);
    t->hinge = jo_take(a, (size_t)m->nlink * sizeof(int));
    t->of_body = jo_take_ints(a, m->nlink ? m->nbody : 0);
    t->marker = jo_take(a, m->nlink ? (size_t)m->nactive * sizeof(int) : 0);
    t->coordinate = jo_take(a, m->nlink ? (size_t)m->ncoordinate * sizeof(int) : 0);
    t->body = jo_take(a, m->nlink ? (size_t)m->nbody * sizeof(int) : 0);
}

/* loops of a tree and the matrices of their rows */
static void lay_loops(const jo_model *m, jo_data *d, jo_arena *a)
{
    jo_tree *t = &d->tree;
    t->loop = jo_take(a, (size_t)m->nloop * sizeof *t->loop);
    t->reach = jo_take(a, (size_t)m->nreach * sizeof *t->reach);
    t->loop_marker = jo_take(a, (size_t)m->nloop * JO_MAX_SIDES * sizeof(int));
    t->gram = jo_take(a, (size_t)m->nloop * sizeof(jo_gram));
    t->ngroup = 0;
    for (int i = 0; i < m->nloop; i++) {
        jo_gram spare, *g = a->base ? &t->gram[t->ngroup] : &spare;
        const int n = jo_loop_rows(m, i);
        if (!n) continue;
        t->ngroup++;
        g->n = n;
        g->ld = jo_pad(n) + 8;   /* padded, since whole vectors are written from any row on */
        g->S = jo_take_reals(a, (n + 1) * g->ld);   /* with room for a right-hand side */
        g->inverse = jo_take_reals(a, n);
        g->y = jo_take_reals(a, n);
        g->scale = jo_take(a, (size_t)n * sizeof(double));
        g->order = jo_take(a, (size_t)n * sizeof(int));
    }
}

void jo_tree_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    lay_links(m, d, a);
    lay_loops(m, d, a);
    jo_tree_contact_layout(m, d, a);
}
