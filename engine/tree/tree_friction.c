/* tree_friction.c - joint reactions, friction forces and sticking of the joints of a tree.
 *
 * The force that joint i transmits, f_i = I_i^A a_i + p_i^A (Featherstone 2008, eq. 7.25), needs no sum over the bodies of the subtree.
 * The acceleration of a joint that sticks is prescribed as 0, like the acceleration of a driven joint: I^a = I^A.
 */
#include "valid.h"
#include "friction/friction.h"
#include "tree/tree_links.h"

/* link of which a coordinate is the joint coordinate */
static const jo_link *link_along(const jo_model *m, int coordinate) { return &m->link[m->coordinate[coordinate].link]; }

/* link of the body of the joint; the second link if two links make up the joint */
static int last_link(const jo_model *m, const jo_friction *f)
{
    const int link = m->coordinate[f->coordinate].link;
    return m->link[link].body < 0 ? link + 1 : link;
}

/* value and rate of the coordinates along which frictions slide */
void jo_tree_update_slips(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++)
        for (int k = 0; k < jo_slips(&m->friction[i]); k++) {
            const int c = jo_slip_of(&m->friction[i], k);
            const jo_link *link = link_along(m, c);
            d->coordinate[c].value = jo_link_sign(link) * d->x[link->x];
            d->coordinate[c].rate = jo_link_sign(link) * d->u[link->u];
        }
}

/* acceleration of a coordinate with friction, m/s2 or rad/s2 */
jo_real jo_tree_slip_acceleration(const jo_model *m, const jo_data *d, int coordinate)
{
    const jo_link *link = link_along(m, coordinate);
    return jo_link_sign(link) * d->ud[link->u];
}

/* distance from the origin of side 1 to the origin of side 0 along the joint axis if the link has side 0, m */
static jo_real slide_distance(const jo_model *m, const jo_data *d, const jo_friction *f)
{
    const jo_link *k = link_along(m, f->coordinate);
    return k->type == JO_LINK_SLIDE ? d->x[k->x] : jo_same(0.0);
}

/* Force and moment y (6) of a joint on side 1, in axes of the link, z along the joint axis. With `change`, the change of force and moment
 * by the last jo_tree_force_response. The component along the joint is tau, not a reaction: it does not load the joint. */
void jo_tree_joint_reaction(const jo_model *m, const jo_data *d, const jo_friction *f, int change, jo_real *y)
{
    const int i = last_link(m, f);
    const jo_link_work *w = &d->tree.link[i + 1];
    const jo_link_response *c = &d->tree.response[i + 1];
    const jo_vec *a = change ? &c->a : &w->a, *alpha = change ? &c->alpha : &w->alpha;
    /* F = M a + H alpha + f, T = H^T a + J alpha + t */
    jo_vec F = jo_vec_add(jo_vec_mat_mul_at(w->M, a), jo_vec_mat_mul_at(w->H, alpha));
    jo_vec T = jo_vec_add(jo_vec_mat_tmul(w->H, *a), jo_vec_mat_mul_at(w->J, alpha));
    F = change ? jo_vec_sub(F, c->f) : jo_vec_add(F, w->f);
    T = change ? jo_vec_sub(T, c->t) : jo_vec_add(T, w->t);
    if (m->link[i].reversed) {   /* on the other side the reaction is -F, -(T - distance x F) */
        F = jo_vec_scale(-1.0, F);
        T = jo_vec_sub(jo_vec_cross(jo_vec_scale(slide_distance(m, d, f), w->A[2]), F), T);
    }
    jo_vec_store(y, jo_vec_mat_tmul(w->A, F));
    jo_vec_store(y + 3, jo_vec_mat_tmul(w->A, T));
}

/* force y along each coordinate of a joint that sticks: tau_i = S^T (I^A a + p^A) */
void jo_tree_sticking_force(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *y)
{
    for (int k = 0; k < jo_slips(f); k++) y[k] = jo_tree_row_force(m, d, jo_slip_of(f, k));
}

/* force along a locked coordinate */
jo_real jo_tree_row_force(const jo_model *m, const jo_data *d, int coordinate)
{
    const int i = m->coordinate[coordinate].link;
    return jo_link_sign(&m->link[i]) * jo_link_drive_force(d, &m->link[i], &d->tree.link[i + 1]);
}

/* multipliers of the rows that lock joints */
void jo_tree_lock_sticking(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++) {
        const jo_friction *f = &m->friction[i];
        if (!f->law) continue;
        const jo_joint *lock = &m->joint[f->lock];
        jo_real y[2] = {0.0, 0.0};
        if (jo_sticks(m, d, f)) jo_tree_sticking_force(m, d, f, y);
        for (int k = 0; k < jo_slips(f); k++) d->lam[lock->row + k] = -y[k] / m->line[lock->line + k].data->factor[0];
    }
    for (int i = 0; i < m->nswitched; i++) {
        const jo_joint *lock = &m->joint[m->switched[i].joint];
        const jo_line *line = &m->line[lock->line];
        d->lam[lock->row] = d->locked[lock->lock] ? -jo_tree_row_force(m, d, line->coordinate[0]) / line->data->factor[0] : 0.0;
    }
}

static void hold_at(const jo_model *m, jo_data *d, int coordinate, jo_real value)
{
    const jo_link *link = link_along(m, coordinate);
    d->x[link->x] = jo_link_sign(link) * value;
    d->u[link->u] = 0.0;
}

/* coordinates of joints that are locked: locked value, rate 0 */
void jo_tree_hold_sticking(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++) {
        const jo_friction *f = &m->friction[i];
        if (!jo_sticks(m, d, f)) continue;
        for (int k = 0; k < jo_slips(f); k++) hold_at(m, d, jo_slip_of(f, k), d->held[2 * m->joint[f->lock].lock + k]);
    }
    for (int i = 0; i < m->nswitched; i++) {
        const jo_joint *lock = &m->joint[m->switched[i].joint];
        if (d->locked[lock->lock]) hold_at(m, d, m->line[lock->line].coordinate[0], d->held[2 * lock->lock]);
    }
}

/* ---- response to n friction forces f along coordinates -------------------------------------------- */

/* change of the accelerations of the links and, in joint_response, of the joints by friction forces f */
void jo_tree_friction_response(const jo_model *m, jo_data *d, int n, const int *coordinate, const jo_real *f)
{
    jo_tree_clear_added_forces(m, d);
    for (int c = 0; c < n; c++) {
        const jo_link *k = link_along(m, coordinate[c]);
        d->tree.added_tau[k->u] += jo_link_sign(k) * f[c];
    }
    jo_tree_force_response(m, d, d->tree.joint_response);
}

/* Add the converged friction forces f to tau and their response to all accelerations. With a single force the response to a unit force is
 * known, and is scaled by f. */
void jo_tree_apply_friction(const jo_model *m, jo_data *d, int n, const int *coordinate, const jo_real *f)
{
    const jo_real part = n == 1 ? f[0] : jo_same(1.0);
    if (n > 1) jo_tree_friction_response(m, d, n, coordinate, f);
    for (int c = 0; c < n; c++) {
        const jo_link *k = link_along(m, coordinate[c]);
        d->tree.tau[k->u] += jo_link_sign(k) * f[c];
    }
    for (int i = 0; i < m->nu; i++) d->ud[i] += part * d->tree.joint_response[i];
    jo_tree_add_response(m, d, part);
}

/* ---- impulse at the start of sticking -------------------------------------------------------------- */

/* -I a of a body and of the bodies fixed to it: f = -(m a + alpha x S), t = -(J alpha + S x a) */
static void inertial_force(const jo_link_constants *k, const jo_link_work *w, jo_link_response *c)
{
    jo_vec T[3];
    const jo_vec S = jo_vec_mat_mul(w->A, k->total_S);
    for (int i = 0; i < 3; i++) T[i] = jo_vec_mat_mul(w->A, k->total_J + 3 * i);   /* times A^T */
    c->f = jo_vec_sub(jo_vec_cross(S, c->alpha), jo_vec_scale(k->total_mass, c->a));
    c->t = jo_vec_scale(-1.0, jo_vec_add(jo_vec_mat_mul_lanes(T, jo_vec_mat_tmul(w->A, c->alpha)), jo_vec_cross(S, c->a)));
}

/* Impulses that set the rate of the locked joints to 0, with the factors of an evaluation in which these joints are locked. The change of
 * all rates is the smallest possible in the norm of the mass matrix: H_ff dqd_f = -H_fl dqd_l, with dqd_l = -qd_l of the locked joints. */
void jo_tree_stop_sticking(const jo_model *m, jo_data *d)
{
    jo_tree_clear_added_forces(m, d);
    d->tree.response[0].a = d->tree.response[0].alpha = jo_vec_zero();
    /* added forces -I_i a_i with the accelerations a_i of all links by dqd_l alone */
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        const jo_link_response *p = &d->tree.response[k->parent + 1];
        jo_link_response *c = &d->tree.response[i + 1];
        if (k->type == JO_LINK_FREE) {
            c->a = c->alpha = jo_vec_zero();
            continue;
        }
        c->alpha = p->alpha;
        c->a = jo_vec_add(p->a, jo_vec_cross(p->alpha, w->l));
        if (jo_link_is_locked(d, k)) {
            const jo_vec rate_change = jo_vec_scale(-d->u[k->u], w->A[2]);
            if (k->type == JO_LINK_HINGE) c->alpha = jo_vec_add(c->alpha, rate_change);
            else c->a = jo_vec_add(c->a, rate_change);
        }
        if (k->body < 0 || k->type == JO_LINK_FIXED) continue;
        inertial_force(&d->tree.constants[i], w, c);
    }
    /* dqd_f, and rates exactly 0 of the locked joints */
    jo_tree_force_response(m, d, d->tree.joint_response);
    for (int i = 0; i < m->nu; i++) d->u[i] += d->tree.joint_response[i];
    for (int i = 0; i < m->nlink; i++)
        if (jo_link_is_locked(d, &m->link[i])) d->u[m->link[i].u] = 0.0;
    jo_state_changed(d);
    jo_positions_moved(d);
}
