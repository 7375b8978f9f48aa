/* tree_links.h - 3-vectors, 3x3 matrices and the data of the links of a tree in joint coordinates.
 *
 * With AVX a 3-vector is a register of four doubles with the fourth lane 0; without AVX, and in the complex build, a 3-vector is three
 * scalars. A 3x3 matrix is an array of its three columns. The letters are as in Featherstone, Rigid Body Dynamics Algorithms (2008).
 */
#ifndef JO_TREE_LINKS_H
#define JO_TREE_LINKS_H

#include "maximal/maximal.h"
#include "tree/tree.h"

#if defined(__GNUC__) && defined(__AVX__) && !defined(JO_COMPLEX) && !defined(JO_VECTOR)
typedef double jo_vec __attribute__((vector_size(32)));
typedef double jo_vec_unaligned __attribute__((vector_size(32), aligned(8), may_alias));   /* four doubles in memory at any address */
static inline jo_vec jo_vec_make(jo_real x, jo_real y, jo_real z) { return (jo_vec){x, y, z, 0.0}; }
static inline jo_real jo_vec_element(jo_vec a, int i) { return a[i]; }
static inline jo_vec jo_vec_add(jo_vec a, jo_vec b) { return a + b; }
static inline jo_vec jo_vec_sub(jo_vec a, jo_vec b) { return a - b; }
static inline jo_vec jo_vec_scale(jo_real s, jo_vec a) { return s * a; }
static inline jo_vec jo_vec_axpy(jo_vec y, jo_real s, jo_vec a) { return y + s * a; }   /* y + s a */
static inline jo_real jo_vec_dot(jo_vec a, jo_vec b)
{
    const jo_vec p = a * b;
    return (p[0] + p[1]) + p[2];
}
/* a . b + c . d */
static inline jo_real jo_vec_dot_sum(jo_vec a, jo_vec b, jo_vec c, jo_vec d)
{
    const jo_vec p = a * b + c * d;
    return (p[0] + p[1]) + p[2];
}
/* (x, y, z) -> (y, z, x). a x b = jo_vec_shuffle_yzx(jo_vec_cross_unshuffled(a, b)); one shuffle of a sum serves all its terms */
static inline jo_vec jo_vec_shuffle_yzx(jo_vec a) { return JO_PICK(a, a, 1, 2, 0, 3); }
static inline jo_vec jo_vec_cross_unshuffled(jo_vec a, jo_vec b) { return a * jo_vec_shuffle_yzx(b) - jo_vec_shuffle_yzx(a) * b; }
static inline void jo_vec_sub_skew(jo_vec *H, jo_vec a)   /* H - a~ */
{
    H[0] += (jo_vec){0.0, -1.0, 1.0, 0.0} * JO_PICK(a, a, 3, 2, 1, 3);
    H[1] += (jo_vec){1.0, 0.0, -1.0, 0.0} * JO_PICK(a, a, 2, 3, 0, 3);
    H[2] += (jo_vec){-1.0, 1.0, 0.0, 0.0} * JO_PICK(a, a, 1, 0, 3, 3);
}
static inline jo_vec jo_vec_mat_tmul(const jo_vec *M, jo_vec x)   /* M^T x */
{
    const jo_vec zero = {0.0};
    return jo_four_sums(M[0] * x, M[1] * x, M[2] * x, zero);
}
static inline jo_vec jo_vec_mat_tmul_sum(const jo_vec *M, jo_vec x, const jo_vec *N, jo_vec y)   /* M^T x + N^T y */
{
    const jo_vec zero = {0.0};
    return jo_four_sums(M[0] * x + N[0] * y, M[1] * x + N[1] * y, M[2] * x + N[2] * y, zero);
}
static inline void jo_vec_transpose(jo_vec *y, const jo_vec *a)   /* y = a^T; y and a may be the same array */
{
    const jo_vec zero = {0.0};
    const jo_vec low = JO_PICK(a[0], a[1], 0, 4, 2, 6), high = JO_PICK(a[0], a[1], 1, 5, 3, 7), c = a[2];
    const jo_vec z0 = JO_PICK(c, zero, 0, 4, 2, 6), z1 = JO_PICK(c, zero, 1, 5, 3, 7);
    y[0] = JO_PICK(low, z0, 0, 1, 4, 5);
    y[1] = JO_PICK(high, z1, 0, 1, 4, 5);
    y[2] = JO_PICK(low, z0, 2, 3, 6, 7);
}
#else
typedef struct { jo_real x[3]; } jo_vec;
static inline jo_vec jo_vec_make(jo_real x, jo_real y, jo_real z) { return (jo_vec){{x, y, z}}; }
static inline jo_real jo_vec_element(jo_vec a, int i) { return a.x[i]; }
static inline jo_vec jo_vec_add(jo_vec a, jo_vec b) { return jo_vec_make(a.x[0] + b.x[0], a.x[1] + b.x[1], a.x[2] + b.x[2]); }
static inline jo_vec jo_vec_sub(jo_vec a, jo_vec b) { return jo_vec_make(a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]); }
static inline jo_vec jo_vec_scale(jo_real s, jo_vec a) { return jo_vec_make(s * a.x[0], s * a.x[1], s * a.x[2]); }
static inline jo_vec jo_vec_axpy(jo_vec y, jo_real s, jo_vec a)
{
    return jo_vec_make(y.x[0] + s * a.x[0], y.x[1] + s * a.x[1], y.x[2] + s * a.x[2]);
}
static inline jo_real jo_vec_dot(jo_vec a, jo_vec b) { return jo_dot3(a.x, b.x); }
static inline jo_real jo_vec_dot_sum(jo_vec a, jo_vec b, jo_vec c, jo_vec d) { return jo_vec_dot(a, b) + jo_vec_dot(c, d); }
static inline jo_vec jo_vec_shuffle_yzx(jo_vec a) { return a; }
static inline jo_vec jo_vec_cross_unshuffled(jo_vec a, jo_vec b)
{
    jo_vec y;
    jo_cross(y.x, a.x, b.x);
    return y;
}
static inline void jo_vec_sub_skew(jo_vec *H, jo_vec a)
{
    const jo_real x = a.x[0], y = a.x[1], z = a.x[2];
    H[0].x[1] -= z; H[0].x[2] += y;
    H[1].x[0] += z; H[1].x[2] -= x;
    H[2].x[0] -= y; H[2].x[1] += x;
}
static inline jo_vec jo_vec_mat_tmul(const jo_vec *M, jo_vec x)
{
    return jo_vec_make(jo_vec_dot(M[0], x), jo_vec_dot(M[1], x), jo_vec_dot(M[2], x));
}
static inline jo_vec jo_vec_mat_tmul_sum(const jo_vec *M, jo_vec x, const jo_vec *N, jo_vec y)
{
    return jo_vec_add(jo_vec_mat_tmul(M, x), jo_vec_mat_tmul(N, y));
}
static inline void jo_vec_transpose(jo_vec *y, const jo_vec *a)
{
    const jo_vec b[3] = {a[0], a[1], a[2]};
    for (int i = 0; i < 3; i++) y[i] = jo_vec_make(b[0].x[i], b[1].x[i], b[2].x[i]);
}
#endif

static inline jo_vec jo_vec_cross(jo_vec a, jo_vec b) { return jo_vec_shuffle_yzx(jo_vec_cross_unshuffled(a, b)); }
static inline jo_vec jo_vec_zero(void) { return jo_vec_make(jo_same(0.0), jo_same(0.0), jo_same(0.0)); }
static inline jo_vec jo_vec_minus(jo_vec a) { return jo_vec_scale(jo_same(-1.0), a); }
static inline jo_vec jo_vec_load(const jo_real *x) { return jo_vec_make(x[0], x[1], x[2]); }
static inline void jo_vec_store(jo_real *y, jo_vec a)
{
    for (int i = 0; i < 3; i++) y[i] = jo_vec_element(a, i);
}
/* M x with x in a register */
static inline jo_vec jo_vec_mat_mul_lanes(const jo_vec *M, jo_vec x)
{
    return jo_vec_axpy(jo_vec_axpy(jo_vec_scale(jo_vec_element(x, 0), M[0]), jo_vec_element(x, 1), M[1]), jo_vec_element(x, 2), M[2]);
}
/* M x with the three numbers x in memory: a load that broadcasts a number to all lanes is cheaper than a shuffle of lanes */
static inline jo_vec jo_vec_mat_mul(const jo_vec *M, const jo_real *x)
{
    return jo_vec_axpy(jo_vec_axpy(jo_vec_scale(x[0], M[0]), x[1], M[1]), x[2], M[2]);
}
/* elements of a vector in memory */
static inline const jo_real *jo_vec_elements(const jo_vec *a) { return (const jo_real *)a; }
/* M x with a vector x in memory */
static inline jo_vec jo_vec_mat_mul_at(const jo_vec *M, const jo_vec *x) { return jo_vec_mat_mul(M, jo_vec_elements(x)); }
/* column i of M B^T, which is M times row i of B */
static inline jo_vec jo_vec_mat_mul_row(const jo_vec *M, const jo_vec *B, int i)
{
    const jo_vec x = jo_vec_axpy(jo_vec_scale(jo_vec_elements(B)[i], M[0]), jo_vec_elements(B + 1)[i], M[1]);
    return jo_vec_axpy(x, jo_vec_elements(B + 2)[i], M[2]);
}

/* e = e0 o exp(theta), the arithmetic of jo_rotate; e, e0: unit quaternions (4), theta: rotation vector (3), rad */
#ifdef JO_PICK
static inline void jo_compose_rotation(jo_real *e, const jo_real *e0, const jo_real *theta)
{
    const jo_vec a = *(const jo_vec_unaligned *)e0, swapped = JO_PICK(a, a, 1, 0, 3, 2), crossed = JO_PICK(a, a, 2, 3, 0, 1);
    const jo_vec both = JO_PICK(a, a, 3, 2, 1, 0);
    const double quarter = 0.25 * jo_dot3(theta, theta);
    double f[3];
    jo_sinc(quarter, f);
    const jo_vec t = theta[0] * ((jo_vec){-1.0, 1.0, 1.0, -1.0} * swapped) + theta[1] * ((jo_vec){-1.0, -1.0, 1.0, 1.0} * crossed)
                     + theta[2] * ((jo_vec){-1.0, 1.0, -1.0, 1.0} * both);
    const jo_vec n = (1.0 - quarter * f[1]) * a + (0.5 * f[0]) * t, s = n * n;
    *(jo_vec_unaligned *)e = jo_inverse_root((s[0] + s[1]) + (s[2] + s[3])) * n;
}
#else
static inline void jo_compose_rotation(jo_real *e, const jo_real *e0, const jo_real *theta)
{
    for (int i = 0; i < 4; i++) e[i] = e0[i];
    jo_rotate(e, theta);
}
#endif

/* y = det(a) a^-1, the adjugate of a symmetric matrix a; returns det(a) */
static inline jo_real jo_vec_adjugate(jo_vec *y, const jo_vec *a)
{
    const jo_vec first = jo_vec_cross_unshuffled(a[1], a[2]);
    y[0] = jo_vec_shuffle_yzx(first);
    y[1] = jo_vec_cross(a[2], a[0]);
    y[2] = jo_vec_cross(a[0], a[1]);
    /* a[0] . y[0], computed without waiting for the shuffle of y[0] */
    return jo_vec_dot(jo_vec_shuffle_yzx(jo_vec_shuffle_yzx(a[0])), first);
}
/* y = a^-1 of a symmetric matrix a */
static inline void jo_vec_invert(jo_vec *y, const jo_vec *a)
{
    const jo_real r = 1.0 / jo_vec_adjugate(y, a);
    for (int i = 0; i < 3; i++) y[i] = jo_vec_scale(r, y[i]);
}

/* Constant data of a link, in the link frame; K and l in the frame of the parent link. Matrices by columns. */
struct jo_link_constants {
    jo_real K[9];           /* orientation of the link frame at joint coordinate zero */
    jo_real l[3];           /* vector from the origin of the parent to the origin of the link at joint coordinate zero, m */
    jo_real mass, S[3];     /* mass, kg; first moment of mass about the origin of the link, kg m */
    jo_real J[9];           /* inertia about the origin of the link, kg m2 */
    jo_real C[9], c[3];     /* axes and origin (m) of the frame of the body */
    int has_branch;         /* whether a child other than link i + 1, or a fixed child, adds to the accumulator of this link */
    int carrier_link;       /* link of the body on which the joint is: the parent or a link fixed to the parent; -1: ground */
    jo_real total_mass, total_S[3], total_J[9];   /* mass, first moment and inertia of the body and of the bodies fixed to it */
};

/* Variable data of a link, resolved in the world frame about the origin of the link. Spatial inertia and force as blocks:
 * f = M a + H alpha + bias force f, t = H^T a + J alpha + bias moment t. */
struct jo_link_work {
    jo_vec M[3], H[3], J[3];   /* I^A: articulated inertia of the subtree, kg, kg m, kg m2; accumulator for children other than i + 1 */
    jo_vec f, t;            /* p^A: bias force (N) and moment (N m) of the subtree; accumulator likewise */
    jo_vec joint_f, joint_t;   /* minus the external force and moment on the body; after sum_joint_forces force of the joint, N, N m */
    jo_vec A[3], l;         /* orientation; vector from the origin of the parent to the origin of the link, m */
    jo_real cosine, sine;   /* hinge: cosine and sine of the angle */
    jo_vec w, bias_alpha, bias_a;   /* angular velocity, rad/s; accelerations for qdd = 0 (c_i summed from the root), rad/s2, m/s2 */
    jo_vec Uf, Ut, Ut_parent;   /* hinge, slide: U = I^A S as force and moment; its moment about the origin of the parent */
    jo_real u, D, Dinv;     /* u = tau - S^T p^A; D = S^T U; 1 / D */
    jo_vec alpha, a;        /* accelerations that the joint accelerations qdd add, rad/s2, m/s2 */
    jo_vec HJinv[3], Jinv[3];   /* ball, free: H J^-1 and J^-1 */
    jo_vec lHJinv[3];       /* ball: l~ H J^-1 */
    jo_vec p, v;            /* position of the origin, m; its velocity, m/s, set by jo_tree_kinematics and jo_tree_update_bodies */
};

/* Response of a link to added forces at link origins and along joints, see tree_force_response.c. */
struct jo_link_response {
    jo_vec f, t;            /* added force and moment on the link and its subtree, N, N m */
    jo_vec alpha, a;        /* change of the accelerations, rad/s2, m/s2 */
    jo_real u;              /* change of u, the force along the joint */
};

/* Gear spring between the joint of a link, a motor, and the joint of another link `to` in the matrix M + g h D + (g h)^2 K of a Rosenbrock
 * method: an element c off its diagonal. The motor is eliminated first: D_to -= c^2 / D, U_to -= c U / D, u_to -= c u / D. Both links have
 * one parent, or the motor stands on `to`: then D_to -= c (c + 2 S_to^T U) / D, since `to` moves U. A motor on the ground (parent -1) has no
 * part in U_to, since the ground does not move. */
struct jo_link_coupling {
    int to;                 /* of a motor; -1: none */
    jo_real stiffness, damping;   /* of a motor: K, D off the diagonal; c = g h (D + g h K) */
    jo_real c, Dc, u, added_u;   /* c of a motor; of a joint: sums of c^2 / D, c u / D over its motors, the latter of added forces too */
    jo_vec Uf, Ut;          /* of a joint: sums of c U / D about the origin of the parent */
};

/* Marker on one side of the joint that closes a loop. */
typedef struct {
    int link, reach, marker;   /* index in m->link, m->reach, m->marker; link -1: ground */
    jo_real arm[3], A[9];   /* place (m) and axes, by columns, of the marker in the link frame */
    /* magnitude of the acceleration of the free body due to a unit force (1/kg) and a unit moment (1/(kg m2)) */
    double inverse_mass, inverse_inertia;
    jo_vec arm_world;       /* arm, resolved in the world frame */
    jo_vec f[JO_MAX_ROWS], t[JO_MAX_ROWS];   /* rows of the constraint Jacobian as force and moment about the origin of the link */
} jo_loop_side;

struct jo_loop_work {
    int rows, uses_axes;    /* number of constraint rows; whether the rows depend on the axes of the markers */
    jo_loop_side side[JO_MAX_SIDES];
    jo_motion motion[JO_MAX_SIDES];   /* velocity and acceleration of the markers for qdd = 0 */
    jo_real x[8];           /* right-hand side, then multipliers lambda; padded with 0 */
};

/* Constraint rows of a loop at a link on the path to the root: force and moment about the origin of the link, u = S^T f of the
 * joint, and D^-1 u. J H^-1 J^T is the sum of u^T D^-1 u over the links (H: joint-space inertia matrix). */
struct jo_reach_work {
    jo_vec f[JO_MAX_ROWS], t[JO_MAX_ROWS];
    jo_real u[6][8], Dinv_u[6][8];   /* (degrees of freedom of the joint x rows), padded with 0 */
};

void jo_tree_hinge_sines(const jo_model *m, jo_data *d);   /* in tree_joint_sines.c */

/* whether dry friction locks the joint of a link (it sticks) */
static inline int jo_link_is_locked(const jo_data *d, const jo_link *k) { return k->lock >= 0 && d->locked[k->lock]; }

/* whether qdd of the joint is prescribed, by a drive or as 0 by sticking friction */
static inline int jo_link_is_prescribed(const jo_data *d, const jo_link *k) { return k->driven >= 0 || jo_link_is_locked(d, k); }

/* whether the joint is a hinge or slide whose acceleration follows from the forces */
static inline int jo_link_has_one_dof(const jo_data *d, const jo_link *k)
{
    return (k->type == JO_LINK_HINGE || k->type == JO_LINK_SLIDE) && !jo_link_is_prescribed(d, k);
}

/* force along a hinge or slide with prescribed motion: S^T (I^A a + p^A) - tau */
static inline jo_real jo_link_drive_force(const jo_data *d, const jo_link *k, const jo_link_work *w)
{
    const int hinge = k->type == JO_LINK_HINGE;
    jo_vec F = hinge ? jo_vec_mat_tmul(w->H, w->a) : jo_vec_mat_mul_lanes(w->M, w->a);
    F = jo_vec_add(F, jo_vec_mat_mul_lanes(hinge ? w->J : w->H, w->alpha));
    F = jo_vec_add(F, hinge ? w->t : w->f);
    return jo_vec_dot(F, w->A[2]) - d->tree.tau[k->u];
}

/* c times the rate of the joint to which a gear spring couples a link; 0: none. rate (nu) */
static inline jo_real jo_link_coupled(const jo_model *m, const jo_data *d, int link, const jo_real *rate)
{
    const jo_link_coupling *g = &d->tree.coupling[link];
    return g->to < 0 ? jo_same(0.0) : g->c * rate[m->link[g->to].u];
}

/* 1, or -1 if the coordinate of the joint is minus the joint coordinate of the link */
static inline double jo_link_sign(const jo_link *k) { return k->reversed ? -1.0 : 1.0; }

/* dense_cholesky.c */
int jo_gram_factor(jo_gram *g, int *row);   /* 1: regular; 0: a pivot vanishes, in `row`; -1: a pivot is not finite */
int jo_gram_factor_pivoted(jo_gram *g, double least);   /* largest pivots first, down to `least` times their scale; returns 1 or -1 */
void jo_gram_solve(const jo_gram *g, jo_real *x);   /* x = S^-1 x; 0 in dependent rows */

#endif
