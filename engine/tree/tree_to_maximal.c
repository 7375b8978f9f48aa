/* tree_to_maximal.c - the state of a tree in q and v, its accelerations and the multipliers of its joints, for whoever needs them. */
#include "maximal/maximal.h"
#include "tree/tree_links.h"
#include <string.h>

/* ---- positions and velocities -------------------------------------------------------------------- */

/* the quaternion of a link's body, of the two the one nearer to `near` */
static void quaternion(jo_real *e, const jo_real *A, const jo_real *near)
{
    jo_quaternion(e, A);
    if (JO_RE(e[0] * near[0] + e[1] * near[1] + e[2] * near[2] + e[3] * near[3]) < 0.0)
        for (int i = 0; i < 4; i++) e[i] = -e[i];
}

/* orientation (by rows) and origin of the body of a link */
static void body_frame(const jo_link_constants *c, const jo_link_work *w, jo_real *A, jo_real *r)
{
    for (int j = 0; j < 3; j++) {
        jo_real column[3];
        jo_vec_store(column, jo_vec_mix(w->A, c->C + 3 * j));
        for (int i = 0; i < 3; i++) A[3 * i + j] = column[i];
    }
    jo_vec_store(r, jo_vec_add(w->p, jo_vec_mix(w->A, c->c)));
}

/* q and v of all bodies where jo_tree_kinematics found the links; quaternions beside those in d->q */
static void write_state(const jo_model *m, const jo_data *d, jo_real *q, jo_real *v)
{
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_constants *c = &d->tree.constants[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        jo_real A[9], r[3], e[4], om[3];
        if (k->body < 0) continue;
        const jo_body *b = &m->body[k->body];
        if (k->type == JO_LINK_FREE || k->type == JO_LINK_BODY) {   /* they are the same, to the last digit */
            for (int j = 0; j < 7 + b->n; j++) q[b->iq + j] = d->tree.x[k->x + j];
            for (int j = 0; j < 6 + b->n; j++) v[b->iv + j] = d->tree.u[k->u + j];
            continue;
        }
        body_frame(c, w, A, r);
        quaternion(e, A, d->q + b->iq + 3);
        jo_set3(q + b->iq, r);
        for (int j = 0; j < 4; j++) q[b->iq + 3 + j] = e[j];
        jo_vec_store(v + b->iv, jo_vec_add(w->v, jo_vec_cross(w->w, jo_vec_mix(w->A, c->c))));
        jo_vec_store(om, w->w);
        jo_mul3t(v + b->iv + 3, A, om);
    }
}

int jo_tree_stands(const jo_model *m, jo_data *d)
{
    jo_tree_kinematics(m, d);
    jo_real *q = d->tree.seen, *v = q + m->nq;
    write_state(m, d, q, v);
    return !memcmp(q, d->q, sizeof(jo_real) * (size_t)m->nq) && !memcmp(v, d->v, sizeof(jo_real) * (size_t)m->nv);
}

/* ---- accelerations and reactions --------------------------------------------------------------- */

/* force and moment that a body needs for its accelerations, about the origin of its link */
static void own_inertia(const jo_link_constants *c, const jo_link_work *w, jo_vec *f, jo_vec *t)
{
    jo_vec J[3];
    const jo_vec S = jo_vec_mix(w->A, c->S);
    for (int i = 0; i < 3; i++) J[i] = jo_vec_mix(w->A, c->J + 3 * i);   /* times A^T */
    const jo_vec Jw = jo_vec_times(J, jo_vec_across(w->A, w->w)), Ja = jo_vec_times(J, jo_vec_across(w->A, w->w0));
    *f = jo_vec_with(jo_vec_add(jo_vec_cross(w->w0, S), jo_vec_cross(w->w, jo_vec_cross(w->w, S))), c->mass, w->v0);
    *t = jo_vec_add(jo_vec_add(Ja, jo_vec_cross(w->w, Jw)), jo_vec_cross(S, w->v0));
}

/* all accelerations of the links, and what each joint bears in own_f, own_t: own inertia less forces, and all beyond it */
static void totals(const jo_model *m, jo_data *d)
{
    if (d->tree.summed) return;
    d->tree.summed = 1;
    for (int i = d->tree.kept; i < m->nlink; i++) {
        jo_link_work *w = &d->tree.link[i + 1];
        jo_vec f, t;
        w->w0 = jo_vec_add(w->w0, w->aw);
        w->v0 = jo_vec_add(w->v0, w->av);
        if (m->link[i].body < 0) continue;
        own_inertia(&d->tree.constants[i], w, &f, &t);
        w->own_f = jo_vec_add(w->own_f, f);
        w->own_t = jo_vec_add(w->own_t, t);
    }
    for (int i = m->nlink - 1; i >= d->tree.kept; i--) {
        const int on = d->tree.constants[i].on;   /* not the parent: a fixed joint bears what hangs on its body */
        const jo_link_work *w = &d->tree.link[i + 1];
        jo_link_work *p = &d->tree.link[on + 1];
        if (on < 0) continue;
        const jo_vec arm = on == m->link[i].parent ? w->l : jo_vec_less(w->l, p->l);
        p->own_f = jo_vec_add(p->own_f, w->own_f);
        p->own_t = jo_vec_add(p->own_t, jo_vec_add(w->own_t, jo_vec_cross(arm, w->own_f)));
    }
}

static void write_accelerations(const jo_model *m, jo_data *d)
{
    const jo_vec g = jo_vec_load(m->gravity);
    for (int i = d->tree.kept; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        if (k->body < 0) continue;
        const jo_body *b = &m->body[k->body];
        const jo_vec arm = jo_vec_mix(w->A, d->tree.constants[i].c);
        jo_vec a = jo_vec_add(jo_vec_add(w->v0, g), jo_vec_cross(w->w0, arm));
        a = jo_vec_add(a, jo_vec_cross(w->w, jo_vec_cross(w->w, arm)));
        jo_real al[3];
        jo_vec_store(d->a + b->iv, a);
        jo_vec_store(al, w->w0);
        jo_mul3t(d->a + b->iv + 3, d->body[k->body].A, al);
    }
}

/* force and moment of the joint of a link on side 1, about its origin */
static void reaction(const jo_model *m, const jo_data *d, int link, jo_real *F, jo_real *T)
{
    const jo_link *k = &m->link[link];
    const jo_link_work *w = &d->tree.link[link + 1];
    const jo_joint *joint = &m->joint[k->joint];
    jo_vec_store(F, w->own_f);
    jo_vec_store(T, w->own_t);
    if (!k->reversed) return;
    jo_real arm[3], t[3];
    jo_set3(arm, d->marker[joint->side[0]].r);
    jo_sub3(arm, d->marker[joint->side[1]].r);
    jo_cross(t, arm, F);
    for (int i = 0; i < 3; i++) {
        F[i] = -F[i];
        T[i] = -T[i] - t[i];
    }
}

/* the rows of a joint of a tree are orthogonal and of length 1: each multiplier is a component of the reaction */
static void joint_multipliers(const jo_model *m, jo_data *d, int link)
{
    const jo_joint *joint = &m->joint[m->link[link].joint];
    const jo_real *A = d->marker[joint->side[0]].A, *B = d->marker[joint->side[1]].A;
    jo_real F[3], T[3], *lam = d->lam + joint->row;
    reaction(m, d, link, F, T);
    for (int i = 0; joint->coincident && i < 3; i++) *lam++ = -F[i];
    for (int r = 0; r < joint->nperp; r++) {
        const jo_real f[3] = {A[joint->perp_a[r]], A[3 + joint->perp_a[r]], A[6 + joint->perp_a[r]]};
        const jo_real h[3] = {B[joint->perp_b[r]], B[3 + joint->perp_b[r]], B[6 + joint->perp_b[r]]};
        jo_real s[3];
        jo_cross(s, f, h);
        *lam++ = jo_dot3(s, T);
    }
    for (int l = 0; l < joint->nline; l++) {
        const jo_line *line = &m->line[joint->line + l];
        const jo_coordinate_work *c = &d->coordinate[line->coordinate[0]];
        *lam++ = -(jo_dot3(c->along, F) + jo_dot3(c->turn_b, T)) / line->data->factor[0];
    }
}

static void write_multipliers(const jo_model *m, jo_data *d)
{
    jo_marker_position(m, d, m->nactive);
    if (m->ncoordinate) jo_coordinates(m, d, m->ncoordinate);
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        if (k->joint >= 0 && k->body >= 0) joint_multipliers(m, d, i);
        if (k->driven < 0) continue;
        const jo_real factor = jo_link_sign(k) * m->line[k->driven].data->factor[0];
        d->lam[m->joint[k->drive].row] = -d->tree.pull[i] / factor;
    }
    for (int i = 0; i < m->nloop; i++)
        for (int r = 0; r < d->tree.loop[i].rows; r++) d->lam[m->joint[m->loop[i].joint].row + r] = d->tree.loop[i].x[r];
    jo_tree_locks(m, d);
}

/* Bodies, q and v as x and u are, and with `how` all of it a and lam of the last evaluation. */
void jo_mirror(const jo_model *m, jo_data *d, jo_mirrored how)
{
    jo_tree *t = &d->tree;
    if (!t->on || t->mirrored >= how) return;
    if (t->mirrored < JO_MIRROR_STATE) {
        jo_tree_kinematics(m, d);
        write_state(m, d, d->q, d->v);
    }
    for (int i = 0; i < m->nbody; i++) {
        jo_body_pose(&m->body[i], &d->body[i], d->q + m->body[i].iq);
        jo_body_twist(&m->body[i], &d->body[i], d->v + m->body[i].iv);
    }
    if (how == JO_MIRROR_ALL) {
        totals(m, d);
        write_accelerations(m, d);
        write_multipliers(m, d);
    }
    t->mirrored = how;
}
