/* tree.c - joint accelerations of a tree of rigid bodies by the articulated-body algorithm.
 *
 * Featherstone, Rigid Body Dynamics Algorithms (2008), table 7.1, with all vectors resolved in the world frame about the origins of the
 * links (the points of their joints). The three passes, with S_i the motion subspace of joint i and lambda(i) the parent of link i:
 *   forward pass 1   v_i = v_lambda(i) + S_i qd_i,  c_i = v_i x S_i qd_i
 *   backward pass    U_i = I_i^A S_i,  D_i = S_i^T U_i,  u_i = tau_i - S_i^T p_i^A,
 *                    I^a = I_i^A - U_i D_i^-1 U_i^T,  p^a = p_i^A + I^a c_i + U_i D_i^-1 u_i,  added to I^A and p^A of lambda(i)
 *   forward pass 2   a' = a_lambda(i) + c_i,  qdd_i = D_i^-1 (u_i - U_i^T a'),  a_i = a' + S_i qdd_i
 * Unlike in the table, the c_i are summed from the root into bias_alpha, bias_a in forward pass 1, the bias force p_i^A of a body contains
 * its inertial force for these accelerations, and forward pass 2 computes alpha, a, the part of the accelerations due to the qdd_i only.
 * The terms I^a c_i and c_i vanish then. Gravity is the acceleration -g of the ground. The prescribed acceleration of a driven joint is
 * a part of c_i, and its I^a is I^A.
 */
#include "valid.h"
#include "friction/friction.h"
#include "tree/tree_links.h"


/* ---- forward pass 1: orientations, velocities, velocity-product accelerations ------------------- */

/* orientation of a hinged link: A_i = A_lambda(i) K R_z(angle), with cosine c and sine s of the angle */
static inline void rotate_z(jo_link_work *w, const jo_link_work *p, const jo_real *K, jo_real c, jo_real s)
{
    const jo_vec x = jo_vec_mat_mul(p->A, K), y = jo_vec_mat_mul(p->A, K + 3);
    w->A[0] = jo_vec_axpy(jo_vec_scale(c, x), s, y);
    w->A[1] = jo_vec_sub(jo_vec_scale(c, y), jo_vec_scale(s, x));
    w->A[2] = jo_vec_mat_mul(p->A, K + 6);
}

/* orientation of a link on a ball or a free link: A_i = A_lambda(i) K R(e), e: unit quaternion */
static inline void rotate_quaternion(jo_link_work *w, const jo_link_work *p, const jo_real *K, const jo_real *e)
{   /* R = (2 e0^2 - 1) E + 2 e e^T + 2 e0 e~ */
    const jo_real twice = 2.0 * e[0], s = twice * e[0] - 1.0;
    jo_vec B[3], z;
    for (int i = 0; i < 3; i++) B[i] = jo_vec_mat_mul(p->A, K + 3 * i);
    z = jo_vec_mat_mul(B, e + 1);
    z = jo_vec_add(z, z);
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const jo_vec x = jo_vec_axpy(jo_vec_scale(s, B[i]), e[1 + i], z);
        w->A[i] = jo_vec_axpy(jo_vec_axpy(x, twice * e[1 + k], B[j]), -twice * e[1 + j], B[k]);
    }
}

/* I_i^A = 0 and p_i^A = 0 before the children add to them, f_i^x = 0 before the forces are applied */
static inline void reset_accumulators(const jo_link_constants *c, jo_link_work *w)
{
    const jo_vec zero = jo_vec_zero();
    w->joint_f = w->joint_t = zero;
    if (!c->has_branch) return;
    for (int i = 0; i < 3; i++) w->M[i] = w->H[i] = w->J[i] = zero;
    w->f = w->t = zero;
}

/* A_i, l_i, angular velocity and bias accelerations of a link from those of the parent */
static inline void link_kinematics(const jo_model *m, jo_data *d, int i)
{
    const jo_link *k = &m->link[i];
    const jo_link_constants *c = &d->tree.constants[i];
    const jo_link_work *p = &d->tree.link[k->parent + 1];
    jo_link_work *w = &d->tree.link[i + 1];
    const jo_real *x = d->x + k->x, *u = d->u + k->u;
    const jo_real qdd = k->driven < 0 ? jo_same(0.0) : d->ud[k->u];   /* prescribed joint acceleration */
    w->l = jo_vec_mat_mul(p->A, c->l);
    w->w = p->w;
    w->bias_alpha = p->bias_alpha;
    jo_vec slide_a = jo_vec_zero();   /* part of c_i of a slide: S qdd + 2 w x S qd, m/s2 */
    switch (k->type) {
    case JO_LINK_HINGE: {   /* w_i = w + S qd, alpha_i = alpha + w x S qd + S qdd */
        rotate_z(w, p, c->K, w->cosine, w->sine);
        const jo_vec rate = jo_vec_scale(u[0], w->A[2]);
        w->w = jo_vec_add(p->w, rate);
        w->bias_alpha = jo_vec_add(p->bias_alpha, jo_vec_cross(p->w, rate));
        if (k->driven >= 0) w->bias_alpha = jo_vec_axpy(w->bias_alpha, qdd, w->A[2]);
        break;
    }
    case JO_LINK_SLIDE:   /* l_i = l + S q, w_i = w */
        for (int j = 0; j < 3; j++) w->A[j] = jo_vec_mat_mul(p->A, c->K + 3 * j);
        w->l = jo_vec_axpy(w->l, x[0], w->A[2]);
        slide_a = jo_vec_axpy(jo_vec_scale(qdd, w->A[2]), 2.0 * u[0], jo_vec_cross(p->w, w->A[2]));
        break;
    case JO_LINK_BALL: {   /* w_i = w + A_i qd, alpha_i = alpha + w x A_i qd */
        rotate_quaternion(w, p, c->K, x);
        const jo_vec rate = jo_vec_mat_mul(w->A, u);
        w->w = jo_vec_add(p->w, rate);
        w->bias_alpha = jo_vec_add(p->bias_alpha, jo_vec_cross(p->w, rate));
        break;
    }
    case JO_LINK_FREE:   /* w_i = A_i qd; position and velocity in the world frame */
        rotate_quaternion(w, p, c->K, x + 3);
        w->w = jo_vec_mat_mul(w->A, u + 3);
        w->l = jo_vec_load(x);
        break;
    default:
        for (int j = 0; j < 3; j++) w->A[j] = jo_vec_mat_mul(p->A, c->K + 3 * j);
        break;
    }
    w->bias_a = p->bias_a;
    if (k->type == JO_LINK_FREE) return;
    /* a_i = a + c_i + alpha x l + w x (w x l), the last two with one shuffle */
    const jo_vec rotation_a = jo_vec_add(jo_vec_cross_unshuffled(p->bias_alpha, w->l),
                                         jo_vec_cross_unshuffled(p->w, jo_vec_cross(p->w, w->l)));
    w->bias_a = jo_vec_add(jo_vec_add(p->bias_a, slide_a), jo_vec_shuffle_yzx(rotation_a));
}

static void forward_pass_1(const jo_model *m, jo_data *d)
{
    jo_tree_hinge_sines(m, d);
    for (int i = jo_nmaximal(d); i < m->nlink; i++) {
        link_kinematics(m, d, i);
        reset_accumulators(&d->tree.constants[i], &d->tree.link[i + 1]);
    }
}

/* ---- backward pass: articulated inertias and bias forces ----------------------------------------- */

/* I^A and p^A of the link in work, in registers: link i hands both over to a parent i - 1 without a store to memory. */
typedef struct { jo_vec M[3], H[3], J[3], f, t; } articulated_inertia;

static inline articulated_inertia zero_inertia(void)
{
    const jo_vec o = jo_vec_zero();
    return (articulated_inertia){{o, o, o}, {o, o, o}, {o, o, o}, o, o};
}

/* I_i^A, p_i^A of the link = y */
static inline void store(const articulated_inertia *y, jo_link_work *w)
{
    for (int i = 0; i < 3; i++) {
        w->M[i] = y->M[i];
        w->H[i] = y->H[i];
        w->J[i] = y->J[i];
    }
    w->f = y->f;
    w->t = y->t;
}

/* y += accumulated I^A, p^A of the link */
static inline void accumulate(articulated_inertia *y, const jo_link_work *w)
{
    for (int i = 0; i < 3; i++) {
        y->M[i] = jo_vec_add(y->M[i], w->M[i]);
        y->H[i] = jo_vec_add(y->H[i], w->H[i]);
        y->J[i] = jo_vec_add(y->J[i], w->J[i]);
    }
    y->f = jo_vec_add(y->f, w->f);
    y->t = jo_vec_add(y->t, w->t);
}

/* p^A += (f, t) */
static inline void add_force(jo_link_work *p, jo_vec f, jo_vec t)
{
    p->f = jo_vec_add(p->f, f);
    p->t = jo_vec_add(p->t, t);
}

/* I_i^A += I_i, p_i^A += I_i a_i + v_i x* I_i v_i of the body and of the bodies fixed to it, with the bias accelerations a_i.
 * Placed in the backward pass because the dependency chain of its recursion leaves arithmetic units idle. */
static inline void add_body_inertia(const jo_link_constants *c, const jo_link_work *w, articulated_inertia *y)
{
    static const jo_real unit[3][3] = {{JO_CONSTANT(1.0), JO_CONSTANT(0.0), JO_CONSTANT(0.0)},
                                       {JO_CONSTANT(0.0), JO_CONSTANT(1.0), JO_CONSTANT(0.0)},
                                       {JO_CONSTANT(0.0), JO_CONSTANT(0.0), JO_CONSTANT(1.0)}};
    jo_vec T[3], J[3];   /* J = A J_local A^T, S = A S_local */
    const jo_vec S = jo_vec_mat_mul(w->A, c->total_S);
    for (int i = 0; i < 3; i++) T[i] = jo_vec_mat_mul(w->A, c->total_J + 3 * i);
    for (int i = 0; i < 3; i++) J[i] = jo_vec_mat_mul_row(T, w->A, i);
    /* f = m a + alpha x S + w x (w x S); t = J alpha + w x J w + S x a */
    const jo_vec Jw = jo_vec_mat_mul_at(J, &w->w);
    const jo_vec f = jo_vec_add(jo_vec_cross_unshuffled(w->bias_alpha, S), jo_vec_cross_unshuffled(w->w, jo_vec_cross(w->w, S)));
    const jo_vec t = jo_vec_add(jo_vec_cross_unshuffled(w->w, Jw), jo_vec_cross_unshuffled(S, w->bias_a));
    y->f = jo_vec_add(y->f, jo_vec_axpy(jo_vec_shuffle_yzx(f), c->total_mass, w->bias_a));
    y->t = jo_vec_add(y->t, jo_vec_add(jo_vec_shuffle_yzx(t), jo_vec_mat_mul_at(J, &w->bias_alpha)));
    /* M += m E, J += J_i, H -= S~ */
    for (int i = 0; i < 3; i++) {
        y->M[i] = jo_vec_axpy(y->M[i], c->total_mass, jo_vec_load(unit[i]));
        y->J[i] = jo_vec_add(y->J[i], J[i]);
    }
    jo_vec_sub_skew(y->H, S);
}

/* N = M l~ */
static inline void mul_skew(jo_vec *N, const jo_vec *M, const jo_vec *l)
{
    const jo_real x = jo_vec_elements(l)[0], y = jo_vec_elements(l)[1], z = jo_vec_elements(l)[2];
    N[0] = jo_vec_sub(jo_vec_scale(z, M[1]), jo_vec_scale(y, M[2]));
    N[1] = jo_vec_sub(jo_vec_scale(x, M[2]), jo_vec_scale(z, M[0]));
    N[2] = jo_vec_sub(jo_vec_scale(y, M[0]), jo_vec_scale(x, M[1]));
}

/* I^A and p^A from the origin of the link to the origin of the parent, X* I^A X^-1 (Featherstone, eq. 2.66):
 * H' = H - M l~, J' = J + P + P^T with P = l~ (H - M l~ / 2), t' = t + l x f */
static inline void shift_to_parent(const jo_link_work *w, articulated_inertia *y)
{
    jo_vec N[3], P[3], Q[3];
    mul_skew(N, y->M, &w->l);
    for (int i = 0; i < 3; i++) {
        P[i] = jo_vec_cross(w->l, jo_vec_axpy(y->H[i], jo_same(-0.5), N[i]));
        y->H[i] = jo_vec_sub(y->H[i], N[i]);
    }
    jo_vec_transpose(Q, P);
    for (int i = 0; i < 3; i++) y->J[i] = jo_vec_add(y->J[i], jo_vec_add(P[i], Q[i]));
    y->t = jo_vec_add(y->t, jo_vec_cross(w->l, y->f));
}

/* I^a = I^A - U D^-1 U^T, p^a = p^A + U D^-1 u of a hinge or slide, at the origin of the parent. The factor D^-1 is applied last, since the
 * division has the longest latency. */
static inline void eliminate_one_dof(const jo_link_work *w, articulated_inertia *y)
{
    const jo_real Dinv = w->Dinv, Dinv_u = w->u * Dinv;
    const jo_vec Uf = w->Uf, Ut = w->Ut_parent;
    shift_to_parent(w, y);
    for (int i = 0; i < 3; i++) {
        const jo_real f = jo_vec_element(Uf, i), t = jo_vec_element(Ut, i);
        y->M[i] = jo_vec_axpy(y->M[i], -Dinv, jo_vec_scale(f, Uf));
        y->H[i] = jo_vec_axpy(y->H[i], -Dinv, jo_vec_scale(t, Uf));
        y->J[i] = jo_vec_axpy(y->J[i], -Dinv, jo_vec_scale(t, Ut));
    }
    y->f = jo_vec_axpy(y->f, Dinv_u, Uf);
    y->t = jo_vec_axpy(y->t, Dinv_u, Ut);
}

/* Ball or free link, with S the three rotations, U = [H; J], D = J, u = -t: I^a = I^A - U D^-1 U^T has the block M - H J^-1 H^T only,
 * p^a = p^A + U D^-1 u the force f - H J^-1 t only. J^-1 = adj J / det J, with the division last. Returns whether J is regular. */
static inline int eliminate_ball(jo_link_work *w, articulated_inertia *y)
{
    jo_vec adj[3], Y[3];   /* adj J, H adj J */
    const jo_real trace = jo_vec_element(y->J[0], 0) + jo_vec_element(y->J[1], 1) + jo_vec_element(y->J[2], 2);
    w->D = jo_vec_adjugate(adj, y->J);
    const int regular = !jo_spoil(&w->D, JO_LESS(JO_MIN_PIVOT * trace * trace * trace, w->D));
    w->t = y->t;
    const jo_real Dinv = 1.0 / w->D;
    for (int i = 0; i < 3; i++) Y[i] = jo_vec_mat_mul_lanes(y->H, adj[i]);
    for (int i = 0; i < 3; i++) {
        y->M[i] = jo_vec_axpy(y->M[i], -Dinv, jo_vec_mat_mul_row(Y, y->H, i));
        w->HJinv[i] = jo_vec_scale(Dinv, Y[i]);
        w->Jinv[i] = jo_vec_scale(Dinv, adj[i]);
    }
    y->f = jo_vec_axpy(y->f, -Dinv, jo_vec_mat_mul_at(Y, &w->t));
    return regular;
}

/* I^a and p^a of a ball from the origin of the link to that of the parent, where only M and f are not 0 before:
 * H' = -M l~, J' = -l~ M l~, t' = l x f */
static inline void shift_force(jo_link_work *w, articulated_inertia *y)
{
    jo_vec N[3];
    mul_skew(N, y->M, &w->l);
    for (int i = 0; i < 3; i++) {
        w->lHJinv[i] = jo_vec_cross(w->l, w->HJinv[i]);
        y->H[i] = jo_vec_minus(N[i]);
        y->J[i] = jo_vec_minus(jo_vec_cross(w->l, N[i]));
    }
    y->t = jo_vec_cross(w->l, y->f);
}

/* Hinge or slide: U = I^A S, D = S^T U, u = tau - S^T p^A, with S = [0; z] or [z; 0]. ROS2 and other W-methods have
 * D + g h (damping + g h stiffness), the diagonal of their matrix. Returns whether D is positive. */
static inline int joint_space_inertia(const jo_data *d, const jo_stage *stage, const jo_link *k, const jo_link_coupling *g,
                                      jo_link_work *w, const articulated_inertia *y)
{
    const jo_vec *z = &w->A[2];   /* axis of the joint */
    if (k->type == JO_LINK_HINGE) {
        w->Uf = jo_vec_mat_mul_at(y->H, z);
        w->Ut = jo_vec_mat_mul_at(y->J, z);
        w->D = jo_vec_dot(*z, w->Ut);
        w->u = d->tree.tau[k->u] - jo_vec_dot(*z, y->t);
    } else {
        w->Uf = jo_vec_mat_mul_at(y->M, z);
        w->Ut = jo_vec_mat_tmul(y->H, *z);
        w->D = jo_vec_dot(*z, w->Uf);
        w->u = d->tree.tau[k->u] - jo_vec_dot(*z, y->f);
    }
    if (stage->set) w->D += stage->gh * (d->tree.damping[k->u] + stage->gh * d->tree.stiffness[k->u]);
    if (g) w->D -= g->Dc;
    const int regular = !jo_spoil(&w->D, JO_LESS(jo_same(0.0), w->D));
    w->Dinv = 1.0 / w->D;
    /* U about the origin of the parent: t + l x f */
    w->Ut_parent = jo_vec_add(w->Ut, jo_vec_cross(w->l, w->Uf));
    if (g) {   /* less the shares of motors */
        w->u -= g->u;
        w->Uf = jo_vec_sub(w->Uf, g->Uf);
        w->Ut_parent = jo_vec_sub(w->Ut_parent, g->Ut);
    }
    return regular;
}

/* The motor of a gear spring is eliminated: c^2 / D, c u / D, c U / D to the joint of the spring. If the motor stands on the link of that
 * joint, with the axis S of the joint: c (c + 2 S^T U) / D, and c U / D is moved to the origin of the joint's parent. */
static inline void pass_to_joint(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_link *k, const jo_link_work *w,
                                 jo_link_coupling *g)
{
    jo_link_coupling *q = &d->tree.coupling[g->to];
    g->c = stage->gh * (g->damping + stage->gh * g->stiffness);
    const jo_real share = g->c * w->Dinv;
    q->Dc += share * g->c;
    q->u += share * w->u;
    if (k->parent < 0) return;
    q->Uf = jo_vec_axpy(q->Uf, share, w->Uf);
    q->Ut = jo_vec_axpy(q->Ut, share, w->Ut_parent);
    if (k->parent != g->to) return;
    const jo_link_work *joint = &d->tree.link[g->to + 1];
    const int hinge = m->link[g->to].type == JO_LINK_HINGE;
    q->Dc += 2.0 * share * jo_vec_dot(joint->A[2], hinge ? w->Ut_parent : w->Uf);
    q->Ut = jo_vec_axpy(q->Ut, share, jo_vec_cross(joint->l, w->Uf));
}

/* y: I_i^A, p_i^A on entry, I^a, p^a at the origin of the parent on return. Returns whether D_i is regular. */
static inline int eliminate_joint(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_link *k, jo_link_coupling *g,
                                  int store_all, jo_link_work *w, articulated_inertia *y)
{
    int regular = 1;
    if (jo_link_is_prescribed(d, k)) {   /* I^a = I^A, p^a = p^A, with the prescribed acceleration in c_i */
        store(y, w);
        if (k->parent >= 0) shift_to_parent(w, y);
    } else if (k->type == JO_LINK_HINGE || k->type == JO_LINK_SLIDE) {
        regular = joint_space_inertia(d, stage, k, g, w, y);
        if (g && g->to >= 0) pass_to_joint(m, d, stage, k, w, g);
        if (store_all) store(y, w);
        if (k->parent >= 0) eliminate_one_dof(w, y);
    } else {
        regular = eliminate_ball(w, y);
        if (store_all || k->type == JO_LINK_FREE) store(y, w);
        if (k->parent >= 0) shift_force(w, y);
    }
    return regular;
}

/* no shares of motors */
static void reset_couplings(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nlink; i++) {
        jo_link_coupling *g = &d->tree.coupling[i];
        g->c = g->Dc = g->u = jo_same(0.0);
        g->Uf = g->Ut = jo_vec_zero();
    }
}

/* I_i^A, p_i^A, U_i, D_i, u_i of all links from the last one to the first */
static int backward_pass(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    const int store_all = m->nfriction || m->nloop, has_body_forces = d->tree.nbody > 0;   /* reactions need I^A, p^A of all links */
    articulated_inertia y = zero_inertia();
    if (d->tree.coupled) reset_couplings(m, d);
    for (int i = m->nlink - 1; i >= 0; i--) {
        const jo_link *k = &m->link[i];
        const jo_link_constants *c = &d->tree.constants[i];
        jo_link_work *w = &d->tree.link[i + 1], *p = &d->tree.link[k->parent + 1];
        if (k->type == JO_LINK_FIXED) {   /* total_mass ... of the parent contain the inertia of a fixed body; p^A -= f^x */
            if (has_body_forces && k->parent >= 0) add_force(p, w->joint_f, jo_vec_add(w->joint_t, jo_vec_cross(w->l, w->joint_f)));
            continue;
        }
        if (k->type == JO_LINK_BODY && !jo_carries(&d->body[k->body])) continue;
        /* I^A += I^a, p^A += p^a of the children, then I_i and v_i x* I_i v_i of the body */
        if (c->has_branch) accumulate(&y, w);
        if (k->body >= 0) add_body_inertia(c, w, &y);
        if (k->type == JO_LINK_BODY) {   /* body in maximal coordinates: jo_hybrid_condense reads its I^A, p^A */
            store(&y, w);
            y = zero_inertia();
            continue;
        }
        if (has_body_forces) {   /* p^A -= f^x */
            y.f = jo_vec_add(y.f, w->joint_f);
            y.t = jo_vec_add(y.t, w->joint_t);
        }
        /* U, D, u; I^a, p^a */
        if (!eliminate_joint(m, d, stage, k, d->tree.coupled ? &d->tree.coupling[i] : 0, store_all, w, &y)) {
            d->error_index = k->body >= 0 ? k->body : m->link[i + 1].body;
            const double D = jo_most(w->D);
            return D == D ? JO_SINGULAR_BODY : JO_NOT_FINITE;
        }
        /* hand I^a, p^a over to a parent i - 1 in registers, to any other parent through its accumulator */
        if (k->parent >= 0 && k->parent == i - 1) continue;
        if (k->parent >= 0) {
            accumulate(&y, p);
            store(&y, p);
        }
        if (i) y = zero_inertia();
    }
    return JO_OK;
}

/* ---- forward pass 2: accelerations ---------------------------------------------------------------- */

/* qdd_i = D_i^-1 (u_i - U_i^T a_lambda(i)), a_i = a_lambda(i) + S_i qdd_i, where alpha, a are the accelerations due to the qdd only. The
 * dependency chain runs through the acceleration of the parent: this acceleration enters each expression last; that of a parent i - 1 is
 * still in registers. */
void jo_tree_forward_pass_2(const jo_model *m, jo_data *d)
{
    jo_vec alpha = jo_vec_zero(), a = jo_vec_zero();
    int last = -2;   /* link whose accelerations are in alpha, a */
    for (int i = jo_nmaximal(d); i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_work *p = &d->tree.link[k->parent + 1];
        jo_link_work *w = &d->tree.link[i + 1];
        jo_real *ud = d->ud + k->u;
        const jo_vec alpha_parent = k->parent == last ? alpha : p->alpha, a_parent = k->parent == last ? a : p->a;
        /* at the origin of link i: a + alpha x l */
        alpha = alpha_parent;
        a = jo_vec_add(a_parent, jo_vec_cross(alpha_parent, w->l));
        if (k->type == JO_LINK_BALL) {   /* alpha = -J^-1 (t + H^T a), a = a_parent - l~ alpha_parent */
            alpha = jo_vec_minus(jo_vec_add(jo_vec_mat_mul_lanes(w->Jinv, w->t),
                                            jo_vec_mat_tmul_sum(w->HJinv, a_parent, w->lHJinv, alpha_parent)));
            jo_vec_store(ud, jo_vec_mat_tmul(w->A, jo_vec_sub(alpha, alpha_parent)));
        } else if (k->type == JO_LINK_FREE) {   /* a = -M^-1 f with M, f after elimination of the rotations; alpha = -J^-1 (t + H^T a) */
            jo_vec Minv[3];
            jo_vec_invert(Minv, w->M);
            a = jo_vec_minus(jo_vec_mat_mul_lanes(Minv, w->f));
            alpha = jo_vec_minus(jo_vec_add(jo_vec_mat_mul_lanes(w->Jinv, w->t), jo_vec_mat_tmul(w->HJinv, a)));
            jo_vec_store(ud, a);
            jo_vec_store(ud + 3, jo_vec_mat_tmul(w->A, alpha));
        } else if (k->driven < 0 && k->type != JO_LINK_FIXED) {
            ud[0] = jo_link_is_locked(d, k) ? jo_same(0.0) : w->Dinv * (w->u - jo_vec_dot_sum(w->Uf, a_parent, w->Ut_parent, alpha_parent));
            if (d->tree.coupled && !jo_link_is_locked(d, k)) ud[0] -= w->Dinv * jo_link_coupled(m, d, i, d->ud);
            if (k->type == JO_LINK_HINGE) alpha = jo_vec_axpy(alpha, ud[0], w->A[2]);
            else a = jo_vec_axpy(a, ud[0], w->A[2]);
        }
        w->alpha = alpha;
        w->a = a;
        last = i;
    }
}

/* tau_i = S_i^T (I_i^A a_i + p_i^A) of the driven joints; returns the power of the drives, W */
jo_real jo_tree_drive_forces(const jo_model *m, jo_data *d)
{
    jo_real power = m->nloop ? jo_loop_power(m, d) : jo_same(0.0);
    for (int i = 0; d->tree.ndriven && i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        if (k->driven < 0) continue;
        d->tree.drive_force[i] = jo_link_drive_force(d, k, w);
        power += d->tree.drive_force[i] * d->u[k->u];
    }
    return power;
}

/* forward pass 1, forces of the stage, backward pass: I^A, p^A, U, D, u of all links at time, x, u */
int jo_tree_articulated_inertias(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    jo_joint_forces_outdated(d);
    d->tree.link->bias_a = jo_vec_minus(jo_vec_load(m->gravity));   /* a_0 = -g; jo_tree_setup sets the other values of the ground */
    jo_tree_prescribe_motion(m, d);
    forward_pass_1(m, d);
    const int status = jo_tree_apply_forces(m, d, stage);
    return status == JO_OK ? backward_pass(m, d, stage) : status;
}

/* joint accelerations ud at time, x, u: tree without loops, then multipliers of the loops, then dry friction */
int jo_tree_evaluate(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    static const jo_work none = {0.0, 0.0, 0.0};
    d->power = none;
    d->counts.evaluations++;
    jo_kinematics_used(d);
    jo_positions_moved(d);
    int status = jo_tree_articulated_inertias(m, d, stage);
    if (status == JO_OK && m->nloop) status = jo_loop_evaluate(m, d, stage);
    if (status != JO_OK) return status;
    jo_tree_forward_pass_2(m, d);
    if (stage->contacts) jo_tree_contacts(m, d, stage);
    if (m->nfriction) status = jo_friction_solve(m, d, stage);
    d->drive = jo_tree_drive_forces(m, d);
    d->power.forces += d->drive;
    return status;
}
