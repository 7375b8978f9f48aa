/* tree_position.c - constants of the links, kinematics from joint coordinates to bodies, and joint coordinates from q and v. */
#include "valid.h"
#include "maximal/maximal.h"
#include "tree/tree_links.h"
#include "contact/contact.h"
#include "network/network.h"
#include <string.h>

/* ---- constants --------------------------------------------------------------------------------- */

#define JO_ZERO JO_CONSTANT(0.0)
#define JO_ONE JO_CONSTANT(1.0)
static const jo_real IDENTITY[9] = {JO_ONE, JO_ZERO, JO_ZERO, JO_ZERO, JO_ONE, JO_ZERO, JO_ZERO, JO_ZERO, JO_ONE};
/* universal joint: columns y, z, x */
static const jo_real CROSSED[9] = {JO_ZERO, JO_ONE, JO_ZERO, JO_ZERO, JO_ZERO, JO_ONE, JO_ONE, JO_ZERO, JO_ZERO};
static const jo_real ORIGIN[3] = {JO_ZERO, JO_ZERO, JO_ZERO};

static const jo_real *axes_of(const jo_model *m, int marker) { return marker < 0 ? IDENTITY : m->marker[marker].A0; }
static const jo_real *origin_of(const jo_model *m, int marker) { return marker < 0 ? ORIGIN : m->marker[marker].u0; }

/* y (by columns) = A^T B of matrices by rows */
static void mat_tmul33(jo_real *y, const jo_real *A, const jo_real *B)
{
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < 3; i++) y[3 * j + i] = A[i] * B[j] + A[3 + i] * B[3 + j] + A[6 + i] * B[6 + j];
}

/* K, l of a child on a fixed link, from the frame of the fixed link to the frame of its parent: K' = K_f K, l' = l_f + K_f l */
static void compose_fixed(const jo_link_constants *fixed, jo_link_constants *c)
{
    jo_real K[9], l[3];
    for (int i = 0; i < 3; i++) {
        l[i] = fixed->l[i];
        for (int k = 0; k < 3; k++) l[i] += fixed->K[3 * k + i] * c->l[k];
        for (int j = 0; j < 3; j++) {
            K[3 * j + i] = jo_same(0.0);
            for (int k = 0; k < 3; k++) K[3 * j + i] += fixed->K[3 * k + i] * c->K[3 * j + k];
        }
    }
    for (int i = 0; i < 9; i++) c->K[i] = K[i];
    jo_set3(c->l, l);
}

/* link of the body that has the outer marker of a link: the parent or a link fixed to the parent */
static int find_carrier_link(const jo_model *m, int link)
{
    const jo_link *k = &m->link[link];
    const int body = k->outer < 0 ? -1 : m->marker[k->outer].body;
    if (body < 0 || (k->parent >= 0 && m->link[k->parent].body == body)) return k->parent;
    int on = link - 1;
    while (on > k->parent && m->link[on].body != body) on--;
    return on;
}

/* K = A_inner^T A_outer and l = A_inner^T (u_outer - u_inner) of a link, in the frame of the parent */
static void place_on_parent(const jo_model *m, const jo_link *k, jo_link_constants *c)
{
    jo_real arm[3];
    if (k->outer < 0) {
        for (int j = 0; j < 9; j++) c->K[j] = k->crossed ? CROSSED[j] : IDENTITY[j];
        jo_set3(c->l, ORIGIN);
        return;
    }
    const int inner = c->carrier_link < 0 ? -1 : m->link[c->carrier_link].inner;   /* marker of the carrier link's frame */
    mat_tmul33(c->K, axes_of(m, inner), axes_of(m, k->outer));
    jo_set3(arm, origin_of(m, k->outer));
    jo_sub3(arm, origin_of(m, inner));
    jo_mul3t(c->l, axes_of(m, inner), arm);
    if (c->carrier_link != k->parent) compose_fixed(c + (c->carrier_link - (k - m->link)), c);
}

/* total_mass, total_S, total_J of the parent += mass, first moment and inertia of a fixed body:
 * S_p += K S + m l, J_p += K J K^T - (K S)~ l~ - l~ (K S)~ - m l~ l~ */
static void add_fixed_body(const jo_link_constants *c, jo_link_constants *p)
{
    jo_real S[3], J[9], T[9], R[9];   /* of the fixed body about its origin, in the axes of the parent; matrices by rows */
    for (int i = 0; i < 3; i++) {
        S[i] = c->K[i] * c->S[0] + c->K[3 + i] * c->S[1] + c->K[6 + i] * c->S[2];
        for (int j = 0; j < 3; j++) R[3 * i + j] = c->K[3 * j + i];
    }
    jo_mul33(T, R, c->J);
    jo_mul33(J, T, c->K);   /* c->K is stored by columns: R^T by rows */
    jo_add_skew_skew(J, jo_same(-1.0), S, c->l);
    jo_add_skew_skew(J, jo_same(-1.0), c->l, S);
    jo_add_skew_skew(J, -c->mass, c->l, c->l);
    p->total_mass += c->mass;
    jo_add3(p->total_S, S);
    jo_axpy3(p->total_S, c->mass, c->l);
    for (int i = 0; i < 9; i++) p->total_J[i] += J[i];
}

/* mass, first moment S = A^T (S0 - m u) and inertia J = A^T (J0 + S0~ u~ + u~ S0~ - m u~ u~) A about the origin u of the link in its
 * axes A; C = A^T, c = -A^T u */
static void body_inertia_in_link_frame(const jo_body *b, const jo_real *u, const jo_real *A, jo_link_constants *c)
{
    const jo_real *S = b->S0, *J = b->J0;
    jo_real full[9] = {J[0], J[5], J[4], J[5], J[1], J[3], J[4], J[3], J[2]}, T[9], arm[3];
    c->mass = b->mass[0];
    jo_set3(arm, S);
    jo_axpy3(arm, -c->mass, u);
    jo_mul3t(c->S, A, arm);
    jo_add_skew_skew(full, jo_same(1.0), S, u);
    jo_add_skew_skew(full, jo_same(1.0), u, S);
    jo_add_skew_skew(full, -c->mass, u, u);
    jo_mul33(T, full, A);
    mat_tmul33(c->J, A, T);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) c->C[3 * i + j] = A[3 * i + j];   /* columns of A^T */
    jo_mul3t(c->c, A, u);
    for (int i = 0; i < 3; i++) c->c[i] = -c->c[i];
}

/* K, l, mass, S, J, totals and carrier of all links */
static void set_link_constants(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        jo_link_constants *c = &d->tree.constants[i];
        const int free = k->type == JO_LINK_FREE || k->type == JO_LINK_BODY;
        c->carrier_link = free ? -1 : find_carrier_link(m, i);
        if (free) {
            for (int j = 0; j < 9; j++) c->K[j] = IDENTITY[j];
            jo_set3(c->l, ORIGIN);
        } else {
            place_on_parent(m, k, c);
        }
        if (k->body < 0 || k->type == JO_LINK_BODY) continue;   /* JO_LINK_BODY: the totals contain only the bodies fixed to it */
        body_inertia_in_link_frame(&m->body[k->body], origin_of(m, k->inner), axes_of(m, k->inner), c);
        c->total_mass = c->mass;
        for (int j = 0; j < 3; j++) c->total_S[j] = c->S[j];
        for (int j = 0; j < 9; j++) c->total_J[j] = c->J[j];
        if (k->type == JO_LINK_FIXED && k->parent >= 0) add_fixed_body(c, &d->tree.constants[k->parent]);
    }
}

/* ---- lists of markers, coordinates and bodies that force laws read ------------------------------ */

/* append i to the list unless i is -1 or in the list already */
static void add_unique(int *list, int *count, int i)
{
    if (i < 0) return;
    for (int j = 0; j < *count; j++)
        if (list[j] == i) return;
    list[(*count)++] = i;
}

/* marker and its body into the lists */
static void add_marker(const jo_model *m, jo_data *d, int marker)
{
    jo_tree *t = &d->tree;
    if (jo_nmaximal(d) && marker >= 0 && !jo_marker_in_tree(d, marker)) return;   /* it is updated by the maximal-coordinate solver */
    add_unique(t->marker, &t->nmarker, marker);
    if (marker >= 0) add_unique(t->body, &t->nbody, m->marker[marker].body);
}

/* coordinate and its markers into the lists, unless it is a joint coordinate */
static void add_coordinate(const jo_model *m, jo_data *d, int c)
{
    jo_tree *t = &d->tree;
    if (c < 0 || m->coordinate[c].link >= 0) return;
    if (!jo_nmaximal(d) || jo_coordinate_in_tree(d, c)) add_unique(t->coordinate, &t->ncoordinate, c);
    add_marker(m, d, m->coordinate[c].a);
    add_marker(m, d, m->coordinate[c].b);
}

/* coordinates of a network of states */
static void add_network(const jo_model *m, jo_data *d, const jo_force *f)
{
    for (int k = 0; jo_network_coordinate(f, k) >= 0; k++) add_coordinate(m, d, jo_network_coordinate(f, k));
}

/* axes, position, velocity and acceleration of the ground */
static void set_ground(jo_link_work *ground)
{
    for (int i = 0; i < 3; i++) ground->A[i] = jo_vec_load(IDENTITY + 3 * i);
    ground->p = ground->w = ground->v = ground->bias_alpha = ground->a = ground->alpha = jo_vec_zero();
}

/* markers of the shapes of a set */
static void add_shapes(const jo_model *m, jo_data *d, const jo_force *set)
{
    for (int i = 0, marker; (marker = jo_shape_marker(set, i)) >= 0; i++) add_marker(m, d, marker);
}

/* constants of the links, unit quaternions, and the lists of hinges, forces and loops */
void jo_tree_setup(const jo_model *m, jo_data *d)
{
    jo_tree *t = &d->tree;
    set_ground(t->link);
    for (int i = 0; i < m->nlink; i++) {
        const int type = m->link[i].type;
        if (type == JO_LINK_BALL) d->x[m->link[i].x] = jo_same(1.0);
        if (type == JO_LINK_FREE || type == JO_LINK_BODY) d->x[m->link[i].x + 3] = jo_same(1.0);
    }
    set_link_constants(m, d);
    for (int i = 0; i < m->nbody; i++) t->of_body[i] = -1;
    for (int i = 0; i < m->nlink; i++)
        if (m->link[i].body >= 0) t->of_body[m->link[i].body] = i;
    /* hinges, driven links, links with other children than i + 1 */
    t->nhinge = t->ndriven = 0;
    for (int i = 0; i < m->nlink; i++) {
        if (m->link[i].type == JO_LINK_HINGE) t->hinge[t->nhinge++] = i;
        t->ndriven += m->link[i].driven >= 0;
        const int parent = m->link[i].parent;
        if (parent >= 0 && (parent != i - 1 || m->link[i].type == JO_LINK_FIXED)) t->constants[parent].has_branch = 1;
    }
    for (int i = 0; i < m->nlink; i++) t->coupling[i].to = -1;
    t->coupled = 0;
    /* coordinates and markers of force laws, except joint coordinates */
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        const int c = f->coordinate;
        add_coordinate(m, d, f->other);
        add_coordinate(m, d, c);
        if (c >= 0) continue;
        add_marker(m, d, f->a);
        add_marker(m, d, f->b);
        if (jo_is_contact_set(f)) add_shapes(m, d, f);
        if (jo_is_network(f)) add_network(m, d, f);
        if (f->body >= 0 && (!jo_nmaximal(d) || jo_body_in_tree(d, f->body))) add_unique(t->body, &t->nbody, f->body);
    }
    /* loops: rows that are linear in coordinates read these; other rows read the links only */
    for (int i = 0; i < m->nloop; i++) {
        const jo_joint *k = &m->joint[m->loop[i].joint];
        for (int l = 0; l < k->nline; l++)
            for (int j = 0; j < m->line[k->line + l].count; j++)
                add_unique(t->coordinate, &t->ncoordinate, m->line[k->line + l].coordinate[j]);
        for (int s = 0; k->nline && s < k->nside; s++) add_marker(m, d, k->side[s]);
    }
    t->counts_joint_angles = 1;
    for (int i = 0; i < m->ncoordinate; i++)
        if (m->coordinate[i].turn >= 0 && m->coordinate[i].link < 0 && !(jo_nmaximal(d) && !jo_coordinate_in_tree(d, i)))
            t->counts_joint_angles = 0;
}

/* ---- positions and velocities from joint coordinates --------------------------------------------- */

/* orientation A, vector l, position p, angular velocity w, velocity v of all links:
 * p = p_lambda + l, w = w_lambda + S qd, v = v_lambda + S qd + w_lambda x l */
void jo_tree_kinematics(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_constants *c = &d->tree.constants[i];
        const jo_link_work *p = &d->tree.link[k->parent + 1];
        jo_link_work *w = &d->tree.link[i + 1];
        const int free = k->type == JO_LINK_FREE || k->type == JO_LINK_BODY;
        const jo_real *x = d->x + k->x, *u = d->u + k->u, *e = free ? x + 3 : x;
        jo_vec B[3], slide_rate = jo_vec_zero();
        for (int j = 0; j < 3; j++) B[j] = jo_vec_mat_mul(p->A, c->K + 3 * j);
        w->l = jo_vec_mat_mul(p->A, c->l);
        w->w = p->w;
        for (int j = 0; j < 3; j++) w->A[j] = B[j];
        /* A = A_lambda K R(q), l = l_0 + S q, w = w_lambda + S qd */
        if (k->type == JO_LINK_HINGE) {
            const jo_real cosine = jo_cos(x[0]), sine = jo_sin(x[0]);
            w->A[0] = jo_vec_axpy(jo_vec_scale(cosine, B[0]), sine, B[1]);
            w->A[1] = jo_vec_sub(jo_vec_scale(cosine, B[1]), jo_vec_scale(sine, B[0]));
            w->w = jo_vec_axpy(p->w, u[0], B[2]);
        } else if (k->type == JO_LINK_SLIDE) {
            w->l = jo_vec_axpy(w->l, x[0], B[2]);
            slide_rate = jo_vec_scale(u[0], B[2]);
        } else if (k->type == JO_LINK_BALL || free) {
            jo_real R[9];
            jo_rotation(R, e);
            for (int j = 0; j < 3; j++) {
                const jo_real column[3] = {R[j], R[3 + j], R[6 + j]};
                w->A[j] = jo_vec_mat_mul(B, column);
            }
            w->w = jo_vec_add(p->w, jo_vec_mat_mul(w->A, free ? u + 3 : u));
        }
        if (free) {
            w->l = jo_vec_load(x);
            slide_rate = jo_vec_load(u);
        }
        /* p = p_lambda + l, v = v_lambda + S qd + w_lambda x l */
        w->p = jo_vec_add(p->p, w->l);
        w->v = jo_vec_add(jo_vec_add(p->v, slide_rate), jo_vec_cross(p->w, w->l));
    }
}

/* velocities v (nv) of the bodies at joint rates `rate` (nu) and the present orientations; the velocities of the links do not change */
void jo_tree_body_rates(const jo_model *m, jo_data *d, const jo_real *rate, jo_real *v)
{   /* Uf and Ut are unused after an evaluation: work space for velocity and angular velocity */
    jo_link_work *link = d->tree.link;
    link->Ut = link->Uf = jo_vec_zero();
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_constants *c = &d->tree.constants[i];
        const jo_link_work *p = &link[k->parent + 1];
        jo_link_work *w = &link[i + 1];
        const jo_real *u = rate + k->u;
        w->Ut = p->Ut;
        w->Uf = jo_vec_add(p->Uf, jo_vec_cross(p->Ut, w->l));
        if (k->type == JO_LINK_HINGE) w->Ut = jo_vec_axpy(w->Ut, u[0], w->A[2]);
        if (k->type == JO_LINK_SLIDE) w->Uf = jo_vec_axpy(w->Uf, u[0], w->A[2]);
        if (k->type == JO_LINK_BALL) w->Ut = jo_vec_add(w->Ut, jo_vec_mat_mul(w->A, u));
        if (k->type == JO_LINK_FREE) {
            w->Uf = jo_vec_load(u);
            w->Ut = jo_vec_mat_mul(w->A, u + 3);
        }
        if (k->body < 0) continue;
        jo_real *y = v + m->body[k->body].iv, local[3];
        jo_vec_store(y, jo_vec_add(w->Uf, jo_vec_cross(w->Ut, jo_vec_mat_mul(w->A, c->c))));
        jo_vec_store(local, jo_vec_mat_tmul(w->A, w->Ut));
        jo_mul3(y + 3, axes_of(m, k->inner), local);
    }
}

/* ---- joint coordinates from positions and velocities --------------------------------------------- */

/* position, orientation (by rows), velocity and angular velocity of a marker from q and v, world frame */
typedef struct { jo_real r[3], A[9], v[3], w[3]; } frame;

/* frame y of a marker from q and v; body -1: ground */
static void marker_frame(const jo_model *m, const jo_data *d, int body, int marker, frame *y)
{
    jo_real A[9], arm[3];
    if (body < 0) {
        for (int i = 0; i < 9; i++) y->A[i] = axes_of(m, marker)[i];
        jo_set3(y->r, origin_of(m, marker));
        jo_set3(y->v, ORIGIN);
        jo_set3(y->w, ORIGIN);
        return;
    }
    const jo_real *q = d->q + m->body[body].iq, *v = d->v + m->body[body].iv;
    jo_rotation(A, q + 3);
    jo_mul33(y->A, A, axes_of(m, marker));
    jo_mul3(arm, A, origin_of(m, marker));
    jo_set3(y->r, q);
    jo_add3(y->r, arm);
    jo_mul3(y->w, A, v + 3);
    jo_cross(y->v, y->w, arm);
    jo_add3(y->v, v);
}

/* hinge angle + multiple of 2 pi, nearest to the counted angle of its coordinate or to the present joint coordinate, rad */
static jo_real nearest_angle(const jo_model *m, const jo_data *d, const jo_link *k, int link, jo_real angle)
{
    jo_real near = d->x[k->x];
    for (int i = 0; i < m->ncoordinate; i++)
        if (m->coordinate[i].link == link && m->coordinate[i].turn >= 0) near = jo_link_sign(k) * d->turn[m->coordinate[i].turn];
    return angle + 2.0 * JO_PI * jo_floor((near - angle) / (2.0 * JO_PI) + 0.5);
}

/* column i of a matrix by rows */
static void axis(jo_real *y, const jo_real *A, int i) { y[0] = A[i]; y[1] = A[3 + i]; y[2] = A[6 + i]; }

/* hinge: angle about z of o from x of o to the axis `to`, and rate = about . w with the relative angular velocity w */
static void read_hinge(const jo_model *m, jo_data *d, int link, const jo_real *to, const frame *o, const jo_real *about, const jo_real *w)
{
    const jo_link *k = &m->link[link];
    jo_real x[3], y[3];
    axis(x, o->A, 0);
    axis(y, o->A, 1);
    d->x[k->x] = nearest_angle(m, d, k, link, jo_arc_tangent(jo_dot3(to, y), jo_dot3(to, x)));
    d->u[k->u] = jo_dot3(about, w);
}

/* ball: quaternion x of R = A_o^T A_f, rates u = A_f^T w */
static void read_ball(jo_real *x, jo_real *u, const frame *o, const frame *f, const jo_real *w)
{
    jo_real R[9], e[4];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) R[3 * i + j] = o->A[i] * f->A[j] + o->A[3 + i] * f->A[3 + j] + o->A[6 + i] * f->A[6 + j];
    jo_quaternion(e, R);
    jo_mul3t(u, f->A, w);
    for (int i = 0; i < 4; i++) x[i] = e[i];
}

/* coordinates and rates of one joint between frames o and f: one link, or two if the first has no body (cylindrical, universal) */
static void read_joint(const jo_model *m, jo_data *d, int first, const frame *o, const frame *f)
{
    const jo_link *k = &m->link[first];
    jo_real w[3], r[3], v[3], t[3], z[3], zf[3], xf[3];
    jo_set3(w, f->w);
    jo_sub3(w, o->w);
    axis(z, o->A, 2);
    axis(zf, f->A, 2);
    axis(xf, f->A, 0);
    if (k->type == JO_LINK_SLIDE) {   /* x = z . r, u = z . (v - w_o x r); cylindrical: then the angle about z */
        jo_set3(r, f->r);
        jo_sub3(r, o->r);
        jo_set3(v, f->v);
        jo_sub3(v, o->v);
        jo_cross(t, o->w, r);
        jo_sub3(v, t);
        d->x[k->x] = jo_dot3(z, r);
        d->u[k->u] = jo_dot3(z, v);
        if (k->body < 0) read_hinge(m, d, first + 1, xf, o, z, w);
    } else if (k->type == JO_LINK_HINGE && k->body < 0) {   /* universal */
        frame cross = *o;   /* x = z_o x z_f, y = z_o, z = z_f: axes of the link between */
        read_hinge(m, d, first, zf, o, z, w);
        jo_cross(t, z, zf);
        for (int i = 0; i < 3; i++) {
            cross.A[3 * i] = t[i];
            cross.A[3 * i + 1] = z[i];
            cross.A[3 * i + 2] = zf[i];
        }
        read_hinge(m, d, first + 1, xf, &cross, zf, w);
    } else if (k->type == JO_LINK_HINGE) {
        read_hinge(m, d, first, xf, o, z, w);
    } else if (k->type == JO_LINK_BALL) {
        read_ball(d->x + k->x, d->u + k->u, o, f, w);
    }
}

/* x, u of all links from q, v */
void jo_tree_read_maximal_state(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link *last = k->body < 0 ? &m->link[i + 1] : k;
        if (k->type == JO_LINK_FREE || k->type == JO_LINK_BODY) {
            const jo_body *b = &m->body[k->body];
            for (int j = 0; j < 7 + b->n; j++) d->x[k->x + j] = d->q[b->iq + j];
            for (int j = 0; j < 6 + b->n; j++) d->u[k->u + j] = d->v[b->iv + j];
            continue;
        }
        if (k->type == JO_LINK_FIXED) continue;
        frame o, f;
        marker_frame(m, d, m->marker[k->outer].body, k->outer, &o);
        marker_frame(m, d, last->body, last->inner, &f);
        read_joint(m, d, i, &o, &f);
        if (last != k) i++;
    }
}
