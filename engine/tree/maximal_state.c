/* maximal_state.c - q, v, accelerations a and multipliers lam of the maximal coordinates from the state of a tree. */
#include "valid.h"
#include "maximal/maximal.h"
#include "tree/tree_links.h"
#include <string.h>

/* ---- positions and velocities -------------------------------------------------------------------- */

/* quaternion e of A with the sign for which e . near >= 0 */
static void nearest_quaternion(jo_real *e, const jo_real *A, const jo_real *near)
{
    jo_quaternion(e, A);
    const jo_mask opposite = JO_LESS(e[0] * near[0] + e[1] * near[1] + e[2] * near[2] + e[3] * near[3], jo_same(0.0));
    for (int i = 0; i < 4; i++) e[i] = jo_choose(opposite, -e[i], e[i]);
}

/* orientation A C (by rows) and origin p + A c of the body of a link */
static void body_frame(const jo_link_constants *c, const jo_link_work *w, jo_real *A, jo_real *r)
{
    for (int j = 0; j < 3; j++) {
        jo_real column[3];
        jo_vec_store(column, jo_vec_mat_mul(w->A, c->C + 3 * j));
        for (int i = 0; i < 3; i++) A[3 * i + j] = column[i];
    }
    jo_vec_store(r, jo_vec_add(w->p, jo_vec_mat_mul(w->A, c->c)));
}

/* q and v of all bodies after jo_tree_kinematics; signs of the quaternions as in d->q */
static void write_state(const jo_model *m, const jo_data *d, jo_real *q, jo_real *v)
{
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_constants *c = &d->tree.constants[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        jo_real A[9], r[3], e[4], om[3];
        if (k->body < 0) continue;
        const jo_body *b = &m->body[k->body];
        if (k->type == JO_LINK_FREE || k->type == JO_LINK_BODY) {   /* x, u are q, v: copies, equal bit for bit */
            for (int j = 0; j < 7 + b->n; j++) q[b->iq + j] = d->x[k->x + j];
            for (int j = 0; j < 6 + b->n; j++) v[b->iv + j] = d->u[k->u + j];
            continue;
        }
        body_frame(c, w, A, r);
        nearest_quaternion(e, A, d->q + b->iq + 3);
        jo_set3(q + b->iq, r);
        for (int j = 0; j < 4; j++) q[b->iq + 3 + j] = e[j];
        jo_vec_store(v + b->iv, jo_vec_add(w->v, jo_vec_cross(w->w, jo_vec_mat_mul(w->A, c->c))));
        jo_vec_store(om, w->w);
        jo_mul3t(v + b->iv + 3, A, om);
    }
}

/* whether q and v computed from x and u equal d->q and d->v bit for bit */
int jo_tree_matches_maximal_state(const jo_model *m, jo_data *d)
{
    jo_tree_kinematics(m, d);
    jo_real *q = d->tree.maximal_copy, *v = q + m->nq;
    write_state(m, d, q, v);
    return !memcmp(q, d->q, sizeof(jo_real) * (size_t)m->nq) && !memcmp(v, d->v, sizeof(jo_real) * (size_t)m->nv);
}

/* ---- accelerations and reactions --------------------------------------------------------------- */

/* inertial force I a + v x* I v of a body about the origin of the link, with total accelerations:
 * f = m a + alpha x S + w x (w x S), t = J alpha + w x J w + S x a */
static void inertial_force(const jo_link_constants *c, const jo_link_work *w, jo_vec *f, jo_vec *t)
{
    jo_vec J[3];
    const jo_vec S = jo_vec_mat_mul(w->A, c->S);
    for (int i = 0; i < 3; i++) J[i] = jo_vec_mat_mul(w->A, c->J + 3 * i);   /* times A^T */
    const jo_vec Jw = jo_vec_mat_mul_lanes(J, jo_vec_mat_tmul(w->A, w->w));
    const jo_vec Ja = jo_vec_mat_mul_lanes(J, jo_vec_mat_tmul(w->A, w->bias_alpha));
    *f = jo_vec_axpy(jo_vec_add(jo_vec_cross(w->bias_alpha, S), jo_vec_cross(w->w, jo_vec_cross(w->w, S))), c->mass, w->bias_a);
    *t = jo_vec_add(jo_vec_add(Ja, jo_vec_cross(w->w, Jw)), jo_vec_cross(S, w->bias_a));
}

/* total accelerations of the links, and the force that each joint transmits (recursive Newton-Euler, Featherstone 2008, table 5.1):
 * f_i = I_i a_i + v_i x* I_i v_i - f_i^x + sum of f_j over the children j */
static void sum_joint_forces(const jo_model *m, jo_data *d)
{
    if (jo_joint_forces_valid(d)) return;
    jo_joint_forces_summed(d);
    /* a_i = bias + part due to qdd; f_i = inertial force - f_i^x */
    for (int i = jo_nmaximal(d); i < m->nlink; i++) {
        jo_link_work *w = &d->tree.link[i + 1];
        jo_vec f, t;
        w->bias_alpha = jo_vec_add(w->bias_alpha, w->alpha);
        w->bias_a = jo_vec_add(w->bias_a, w->a);
        if (m->link[i].body < 0) continue;
        inertial_force(&d->tree.constants[i], w, &f, &t);
        w->joint_f = jo_vec_add(w->joint_f, f);
        w->joint_t = jo_vec_add(w->joint_t, t);
    }
    /* f_carrier += f_i, t_carrier += t_i + arm x f_i */
    for (int i = m->nlink - 1; i >= jo_nmaximal(d); i--) {
        const int on = d->tree.constants[i].carrier_link;   /* a fixed joint transmits the forces of all joints on its body */
        const jo_link_work *w = &d->tree.link[i + 1];
        jo_link_work *p = &d->tree.link[on + 1];
        if (on < 0) continue;
        const jo_vec arm = on == m->link[i].parent ? w->l : jo_vec_sub(w->l, p->l);
        p->joint_f = jo_vec_add(p->joint_f, w->joint_f);
        p->joint_t = jo_vec_add(p->joint_t, jo_vec_add(w->joint_t, jo_vec_cross(arm, w->joint_f)));
    }
}

/* a of all bodies: a = bias_a + g + alpha x arm + w x (w x arm); angular acceleration in the body frame */
static void write_accelerations(const jo_model *m, jo_data *d)
{
    const jo_vec g = jo_vec_load(m->gravity);
    for (int i = jo_nmaximal(d); i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        if (k->body < 0) continue;
        const jo_body *b = &m->body[k->body];
        const jo_vec arm = jo_vec_mat_mul(w->A, d->tree.constants[i].c);
        jo_vec a = jo_vec_add(jo_vec_add(w->bias_a, g), jo_vec_cross(w->bias_alpha, arm));
        a = jo_vec_add(a, jo_vec_cross(w->w, jo_vec_cross(w->w, arm)));
        jo_real al[3];
        jo_vec_store(d->a + b->iv, a);
        jo_vec_store(al, w->bias_alpha);
        jo_mul3t(d->a + b->iv + 3, d->body[k->body].A, al);
    }
}

/* force F and moment T of the joint of a link on side 1, about the origin of side 1 */
static void joint_reaction(const jo_model *m, const jo_data *d, int link, jo_real *F, jo_real *T)
{
    const jo_link *k = &m->link[link];
    const jo_link_work *w = &d->tree.link[link + 1];
    const jo_joint *joint = &m->joint[k->joint];
    jo_vec_store(F, w->joint_f);
    jo_vec_store(T, w->joint_t);
    if (!k->reversed) return;
    /* the link has side 0 instead: F' = -F, T' = -T - arm x F */
    jo_real arm[3], t[3];
    jo_set3(arm, d->marker[joint->side[0]].r);
    jo_sub3(arm, d->marker[joint->side[1]].r);
    jo_cross(t, arm, F);
    for (int i = 0; i < 3; i++) {
        F[i] = -F[i];
        T[i] = -T[i] - t[i];
    }
}

/* multipliers of a joint. Its rows are orthonormal: each multiplier is a component of the reaction F, T */
static void joint_multipliers(const jo_model *m, jo_data *d, int link)
{
    const jo_joint *joint = &m->joint[m->link[link].joint];
    const jo_real *A = d->marker[joint->side[0]].A, *B = d->marker[joint->side[1]].A;
    jo_real F[3], T[3], *lam = d->lam + joint->row;
    joint_reaction(m, d, link, F, T);
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

/* lam of tree joints, drives, loops and locks */
static void write_multipliers(const jo_model *m, jo_data *d)
{
    jo_marker_position(m, d, m->nactive);
    if (m->ncoordinate) jo_coordinates(m, d, m->ncoordinate);
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        if (k->joint >= 0 && k->body >= 0) joint_multipliers(m, d, i);
        if (k->driven < 0) continue;
        const jo_real factor = jo_link_sign(k) * m->line[k->driven].data->factor[0];
        d->lam[m->joint[k->drive].row] = -d->tree.drive_force[i] / factor;
    }
    for (int i = 0; i < m->nloop; i++)
        for (int r = 0; r < d->tree.loop[i].rows; r++) d->lam[m->joint[m->loop[i].joint].row + r] = d->tree.loop[i].x[r];
    jo_tree_lock_sticking(m, d);
}

/* Update the maximal coordinates to `level`: bodies, q and v from x and u; with JO_SYNC_ALL a and lam of the last evaluation as well. */
void jo_sync_maximal_state(const jo_model *m, jo_data *d, jo_sync_level level)
{
    if (!jo_tree_active(d) || jo_sync_valid(d, level)) return;
    if (!jo_sync_valid(d, JO_SYNC_STATE)) {
        jo_tree_kinematics(m, d);
        write_state(m, d, d->q, d->v);
    }
    for (int i = 0; i < m->nbody; i++) {
        jo_body_pose(&m->body[i], &d->body[i], d->q + m->body[i].iq);
        jo_body_twist(&m->body[i], &d->body[i], d->v + m->body[i].iv);
    }
    if (level == JO_SYNC_ALL) {
        sum_joint_forces(m, d);
        write_accelerations(m, d);
        write_multipliers(m, d);
    }
    jo_sync_reached(d, level);
}
