/* tree.h - vectors and links of a tree in joint coordinates.
 *
 * Where the processor has registers of four doubles a 3-vector lies in one, its fourth lane 0; elsewhere, and with complex numbers,
 * it is three scalars. 3x3 matrices are three columns.
 */
#ifndef JO_TREE_H
#define JO_TREE_H

#include "internal.h"

#if defined(__GNUC__) && defined(__AVX__) && !defined(JO_COMPLEX) && !defined(JO_VECTOR)
typedef double jo_vec __attribute__((vector_size(32)));
#if defined(__clang__)
#define JO_PICK(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#else
typedef long long jo_lane_places __attribute__((vector_size(32)));
#define JO_PICK(a, b, i, j, k, l) __builtin_shuffle(a, b, (jo_lane_places){i, j, k, l})
#endif
static inline jo_vec jo_vec_of(jo_real x, jo_real y, jo_real z) { return (jo_vec){x, y, z, 0.0}; }
static inline jo_real jo_vec_at(jo_vec a, int i) { return a[i]; }
static inline jo_vec jo_vec_add(jo_vec a, jo_vec b) { return a + b; }
static inline jo_vec jo_vec_less(jo_vec a, jo_vec b) { return a - b; }
static inline jo_vec jo_vec_scale(jo_real s, jo_vec a) { return s * a; }
static inline jo_vec jo_vec_with(jo_vec y, jo_real s, jo_vec a) { return y + s * a; }   /* y + s a */
static inline jo_real jo_vec_dot(jo_vec a, jo_vec b)
{
    const jo_vec p = a * b;
    return (p[0] + p[1]) + p[2];
}
static inline jo_vec jo_vec_cross(jo_vec a, jo_vec b)
{
    const jo_vec x = a * JO_PICK(b, b, 1, 2, 0, 3) - JO_PICK(a, a, 1, 2, 0, 3) * b;
    return JO_PICK(x, x, 1, 2, 0, 3);
}
static inline void jo_vec_transpose(jo_vec *y, const jo_vec *a)   /* y and a may be the same */
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
static inline jo_vec jo_vec_of(jo_real x, jo_real y, jo_real z) { return (jo_vec){{x, y, z}}; }
static inline jo_real jo_vec_at(jo_vec a, int i) { return a.x[i]; }
static inline jo_vec jo_vec_add(jo_vec a, jo_vec b) { return jo_vec_of(a.x[0] + b.x[0], a.x[1] + b.x[1], a.x[2] + b.x[2]); }
static inline jo_vec jo_vec_less(jo_vec a, jo_vec b) { return jo_vec_of(a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]); }
static inline jo_vec jo_vec_scale(jo_real s, jo_vec a) { return jo_vec_of(s * a.x[0], s * a.x[1], s * a.x[2]); }
static inline jo_vec jo_vec_with(jo_vec y, jo_real s, jo_vec a)
{
    return jo_vec_of(y.x[0] + s * a.x[0], y.x[1] + s * a.x[1], y.x[2] + s * a.x[2]);
}
static inline jo_real jo_vec_dot(jo_vec a, jo_vec b) { return jo_dot3(a.x, b.x); }
static inline jo_vec jo_vec_cross(jo_vec a, jo_vec b)
{
    jo_vec y;
    jo_cross(y.x, a.x, b.x);
    return y;
}
static inline void jo_vec_transpose(jo_vec *y, const jo_vec *a)
{
    const jo_vec b[3] = {a[0], a[1], a[2]};
    for (int i = 0; i < 3; i++) y[i] = jo_vec_of(b[0].x[i], b[1].x[i], b[2].x[i]);
}
#endif

static inline jo_vec jo_vec_zero(void) { return jo_vec_of(0.0, 0.0, 0.0); }
static inline jo_vec jo_vec_load(const jo_real *x) { return jo_vec_of(x[0], x[1], x[2]); }
static inline void jo_vec_store(jo_real *y, jo_vec a)
{
    for (int i = 0; i < 3; i++) y[i] = jo_vec_at(a, i);
}
/* M x, and M^T x */
static inline jo_vec jo_vec_times(const jo_vec *M, jo_vec x)
{
    return jo_vec_with(jo_vec_with(jo_vec_scale(jo_vec_at(x, 0), M[0]), jo_vec_at(x, 1), M[1]), jo_vec_at(x, 2), M[2]);
}
static inline jo_vec jo_vec_across(const jo_vec *M, jo_vec x)
{
    return jo_vec_of(jo_vec_dot(M[0], x), jo_vec_dot(M[1], x), jo_vec_dot(M[2], x));
}
/* M times three numbers in memory */
static inline jo_vec jo_vec_mix(const jo_vec *M, const jo_real *x)
{
    return jo_vec_with(jo_vec_with(jo_vec_scale(x[0], M[0]), x[1], M[1]), x[2], M[2]);
}

/* inverse of a symmetric matrix by its adjoint; its determinant */
static inline jo_real jo_vec_invert(jo_vec *y, const jo_vec *a)
{
    const jo_vec c0 = jo_vec_cross(a[1], a[2]), c1 = jo_vec_cross(a[2], a[0]), c2 = jo_vec_cross(a[0], a[1]);
    const jo_real det = jo_vec_dot(a[0], c0), r = 1.0 / det;
    y[0] = jo_vec_scale(r, c0);
    y[1] = jo_vec_scale(r, c1);
    y[2] = jo_vec_scale(r, c2);
    return det;
}

/* What of a link never changes, in its own frame but for the first two, which are in that of its parent. */
struct jo_link_constants {
    jo_real K[9];           /* orientation at zero, by columns */
    jo_real l[3];           /* origin at zero */
    jo_real mass, S[3];     /* kg; first moment about its origin, kg m */
    jo_real J[9];           /* inertia about its origin, by columns */
    jo_real C[9], c[3];     /* axes, by columns, and origin of the frame of its body */
};

/* Resolved in the world, about the origin of the link; f = M a + H w', t = H^T a + J w' of an articulated inertia. */
struct jo_link_work {
    jo_vec M[3], H[3], J[3];
    jo_vec f, t;            /* force and moment that the articulated inertia needs without joint accelerations */
    jo_vec A[3], p, l;      /* orientation, position, way from the origin of the parent */
    jo_vec w, v;            /* angular velocity; velocity, in jo_tree_kinematics only */
    jo_vec w0, v0;          /* accelerations without those of joints; afterwards all of them */
    jo_vec own_f, own_t;    /* of the body alone, less its forces */
    jo_vec S, own_J[3];
    jo_vec aw, av;          /* what joint accelerations add */
    jo_vec Uf, Ut;          /* hinge, slide: inertia along the joint */
    jo_vec X[3], inverse[3];   /* ball, free: H J^-1 and J^-1 */
    jo_real rest, D;        /* force along the joint less that of the bias; inertia along it */
};

/* What further forces at the origin of a link change, see tree_respond.c. */
struct jo_link_change {
    jo_vec f, t;            /* of the link and of all that it bears */
    jo_vec aw, av;          /* accelerations */
    jo_real rest;           /* force along the joint */
};

/* whether the joint of a link moves along one coordinate by its forces */
static inline int jo_link_gives(const jo_link *k)
{
    return k->driven < 0 && (k->type == JO_LINK_HINGE || k->type == JO_LINK_SLIDE);
}

/* joint coordinate times this is the coordinate of the joint */
static inline double jo_link_sign(const jo_link *k) { return k->reversed ? -1.0 : 1.0; }

#endif
