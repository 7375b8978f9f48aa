/* tree_on_flexible_bodies.c - rigid trees that hang on bodies which run by the rows of their joints, such as those with modes.
 *
 * Each tree is condensed to its port, the articulated inertia (6x6) and the force that the body which carries it feels of it: the
 * rows of the other joints then see a heavier body. Its own acceleration says, outward again, how the tree moves. The first links
 * are the bodies that remain, with q and v as their coordinates, so that all of it is integrated as one state x, u.
 */
#include "maximal/maximal.h"
#include "tree/tree_links.h"

void jo_ports_setup(const jo_model *m, jo_data *d)
{
    jo_tree *t = &d->tree;
    while (t->kept < m->nlink && m->link[t->kept].type == JO_LINK_BODY) t->kept++;
    for (int i = t->kept; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        if (k->body >= 0) t->away_body[k->body] = 1;
        if (k->joint >= 0) t->away_joint[k->joint] = 1;
        if (k->drive >= 0) t->away_joint[k->drive] = 1;
    }
    for (int i = 0; i < m->nmarker; i++) t->away_marker[i] = m->marker[i].body >= 0 && t->away_body[m->marker[i].body];
    for (int i = 0; i < m->ncoordinate; i++)
        t->away_coordinate[i] = t->away_marker[m->coordinate[i].a] || t->away_marker[m->coordinate[i].b];
    while (t->column < m->ncolumn && t->away_joint[m->column[t->column].joint]) t->column++;
    while (t->pair < m->npair && !t->away_joint[m->pair[t->pair].joint_k] && !t->away_joint[m->pair[t->pair].joint_l]) t->pair++;
}

void jo_ports_place(const jo_model *m, jo_data *d)
{
    jo_tree *t = &d->tree;
    const int narrow = t->narrow;
    if (t->mirrored == JO_MIRROR_PART) return;
    for (int i = 0; i < t->kept; i++) {
        const jo_link *k = &m->link[i];
        const jo_body *b = &m->body[k->body];
        for (int j = 0; j < 7 + b->n; j++) d->q[b->iq + j] = t->x[k->x + j];
        for (int j = 0; j < 6 + b->n; j++) d->v[b->iv + j] = t->u[k->u + j];
    }
    t->narrow = 1;
    jo_refresh(m, d);
    jo_marker_velocity(m, d, m->nactive);
    t->narrow = narrow;
    t->mirrored = JO_MIRROR_PART;
}

void jo_ports_accept(const jo_model *m, jo_data *d)
{
    jo_tree *t = &d->tree;
    for (int i = 0; i < t->kept; i++) {
        const jo_link *k = &m->link[i];
        const jo_body *b = &m->body[k->body];
        for (int j = 0; j < 7 + b->n; j++) t->x[k->x + j] = d->q[b->iq + j];
        for (int j = 0; j < 6 + b->n; j++) t->u[k->u + j] = d->v[b->iv + j];
    }
    t->mirrored = JO_MIRROR_PART;
}

/* the bodies that carry something, without acceleration, as the links on them need it */
static void stand(const jo_model *m, jo_data *d)
{
    const jo_vec zero = jo_vec_zero();
    for (int i = 0; i < d->tree.kept; i++) {
        const jo_link *k = &m->link[i];
        const jo_body_work *b = &d->body[k->body];
        jo_link_work *w = &d->tree.link[i + 1];
        if (!b->port) continue;
        for (int j = 0; j < 3; j++) {
            w->A[j] = jo_vec_load(b->At + 4 * j);
            w->M[j] = w->H[j] = w->J[j] = zero;
        }
        w->w = jo_vec_mix(w->A, b->w);
        w->l = jo_vec_load(d->tree.x + k->x);
        w->w0 = w->v0 = w->f = w->t = w->own_f = w->own_t = zero;
    }
}

/* y = A^T M A, by columns */
static void local(jo_real (*y)[3], const jo_vec *A, const jo_vec *M)
{
    for (int j = 0; j < 3; j++) jo_vec_store(y[j], jo_vec_across(A, jo_vec_on(M, &A[j])));
}

/* what a body carries, in its own frame: inertia beside its own, force among the others */
static void condense(const jo_link_work *w, jo_body_work *b)
{
    jo_real M[3][3], H[3][3], J[3][3], f[3], t[3];
    const jo_real *S = b->S, *Jb = b->J;
    local(M, w->A, w->M);
    local(H, w->A, w->H);
    local(J, w->A, w->J);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            b->port[6 * i + k] = M[k][i];
            b->port[6 * (3 + i) + k] = H[i][k];
            b->port[6 * (3 + i) + 3 + k] = J[k][i];
        }
    const jo_real own[9] = {0.0, -S[2], S[1], S[2], 0.0, -S[0], -S[1], S[0], 0.0};
    const jo_real full[9] = {Jb[0], Jb[5], Jb[4], Jb[5], Jb[1], Jb[3], Jb[4], Jb[3], Jb[2]};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            b->port[6 * (3 + i) + k] += own[3 * i + k];
            b->port[6 * (3 + i) + 3 + k] += full[3 * i + k];
        }
    jo_vec_store(f, jo_vec_across(w->A, w->f));
    jo_vec_store(t, jo_vec_across(w->A, w->t));
    jo_sub3(b->fr, f);
    jo_sub3(b->fr + 3, t);
}

int jo_ports_load(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    stand(m, d);
    const int status = jo_tree_load(m, d, stage);
    for (int i = 0; i < d->tree.kept && status == JO_OK; i++) {
        jo_body_work *b = &d->body[m->link[i].body];
        if (b->port) condense(&d->tree.link[i + 1], b);
    }
    return status;
}

/* as that of body.c, of a matrix that moves with what hangs on the body */
int jo_ports_factor(const jo_body *b, jo_body_work *w)
{
    for (int i = 0; i < 6; i++) {
        jo_real *x = w->L + 6 * i;
        const jo_real diagonal = w->port[7 * i] + (i < 3 ? b->mass[0] : jo_same(0.0));
        for (int k = 0; k <= i; k++) {
            const jo_real *y = w->L + 6 * k;
            jo_real t = k < i ? w->port[6 * i + k] : diagonal;
            for (int j = 0; j < k; j++) t -= x[j] * y[j];
            if (k < i) {
                x[k] = t * y[k];
                continue;
            }
            if (jo_spoil(&t, JO_LESS(1e-14 * diagonal, t))) return isfinite(jo_most(t)) ? JO_SINGULAR_BODY : JO_NOT_FINITE;
            x[i] = 1.0 / jo_sqrt(t);
        }
    }
    return JO_OK;
}

void jo_ports_follow(const jo_model *m, jo_data *d)
{
    jo_tree *t = &d->tree;
    for (int i = 0; i < t->kept; i++) {
        const jo_link *k = &m->link[i];
        const jo_body *b = &m->body[k->body];
        const jo_body_work *w = &d->body[k->body];
        jo_link_work *link = &t->link[i + 1];
        for (int j = 0; j < 6 + b->n; j++) t->ud[k->u + j] = d->a[b->iv + j];
        if (!w->port) continue;
        link->av = jo_vec_mix(link->A, w->y);
        link->aw = jo_vec_mix(link->A, w->y + 3);
    }
    jo_tree_follow(m, d);
    const jo_real power = jo_tree_drive(m, d);
    d->drive += power;
    d->power.forces += power;
}
