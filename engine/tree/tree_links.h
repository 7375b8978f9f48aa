/* tree_links.h - vectors and links of a tree in joint coordinates.
 *
 * Where the processor has registers of four doubles a 3-vector lies in one, its fourth lane 0; elsewhere, and with complex numbers,
 * it is three scalars. 3x3 matrices are three columns.
 */
#ifndef JO_TREE_LINKS_H
#define JO_TREE_LINKS_H

#include "maximal/maximal.h"
#include "tree/tree.h"

#if defined(__GNUC__) && defined(__AVX__) && !defined(JO_COMPLEX) && !defined(JO_VECTOR)
typedef double jo_vec __attribute__((vector_size(32)));
typedef double jo_vec_anywhere __attribute__((vector_size(32), aligned(8), may_alias));   /* in memory, all four lanes */
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
/* a . b + c . d */
static inline jo_real jo_vec_dots(jo_vec a, jo_vec b, jo_vec c, jo_vec d)
{
    const jo_vec p = a * b + c * d;
    return (p[0] + p[1]) + p[2];
}
/* a x b = jo_vec_turn(jo_vec_wedge(a, b)): of a sum of products the sum is turned */
static inline jo_vec jo_vec_turn(jo_vec a) { return JO_PICK(a, a, 1, 2, 0, 3); }
static inline jo_vec jo_vec_wedge(jo_vec a, jo_vec b) { return a * jo_vec_turn(b) - jo_vec_turn(a) * b; }
static inline void jo_vec_less_skew(jo_vec *H, jo_vec a)   /* H - a~ */
{
    H[0] += (jo_vec){0.0, -1.0, 1.0, 0.0} * JO_PICK(a, a, 3, 2, 1, 3);
    H[1] += (jo_vec){1.0, 0.0, -1.0, 0.0} * JO_PICK(a, a, 2, 3, 0, 3);
    H[2] += (jo_vec){-1.0, 1.0, 0.0, 0.0} * JO_PICK(a, a, 1, 0, 3, 3);
}
static inline jo_vec jo_vec_across(const jo_vec *M, jo_vec x)   /* M^T x */
{
    const jo_vec zero = {0.0};
    return jo_four_sums(M[0] * x, M[1] * x, M[2] * x, zero);
}
static inline jo_vec jo_vec_both(const jo_vec *M, jo_vec x, const jo_vec *N, jo_vec y)   /* M^T x + N^T y */
{
    const jo_vec zero = {0.0};
    return jo_four_sums(M[0] * x + N[0] * y, M[1] * x + N[1] * y, M[2] * x + N[2] * y, zero);
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
static inline jo_real jo_vec_dots(jo_vec a, jo_vec b, jo_vec c, jo_vec d) { return jo_vec_dot(a, b) + jo_vec_dot(c, d); }
static inline jo_vec jo_vec_turn(jo_vec a) { return a; }
static inline jo_vec jo_vec_wedge(jo_vec a, jo_vec b)
{
    jo_vec y;
    jo_cross(y.x, a.x, b.x);
    return y;
}
static inline void jo_vec_less_skew(jo_vec *H, jo_vec a)
{
    const jo_real x = a.x[0], y = a.x[1], z = a.x[2];
    H[0].x[1] -= z; H[0].x[2] += y;
    H[1].x[0] += z; H[1].x[2] -= x;
    H[2].x[0] -= y; H[2].x[1] += x;
}
static inline jo_vec jo_vec_across(const jo_vec *M, jo_vec x)
{
    return jo_vec_of(jo_vec_dot(M[0], x), jo_vec_dot(M[1], x), jo_vec_dot(M[2], x));
}
static inline jo_vec jo_vec_both(const jo_vec *M, jo_vec x, const jo_vec *N, jo_vec y)
{
    return jo_vec_add(jo_vec_across(M, x), jo_vec_across(N, y));
}
static inline void jo_vec_transpose(jo_vec *y, const jo_vec *a)
{
    const jo_vec b[3] = {a[0], a[1], a[2]};
    for (int i = 0; i < 3; i++) y[i] = jo_vec_of(b[0].x[i], b[1].x[i], b[2].x[i]);
}
#endif

static inline jo_vec jo_vec_cross(jo_vec a, jo_vec b) { return jo_vec_turn(jo_vec_wedge(a, b)); }
static inline jo_vec jo_vec_zero(void) { return jo_vec_of(0.0, 0.0, 0.0); }
static inline jo_vec jo_vec_load(const jo_real *x) { return jo_vec_of(x[0], x[1], x[2]); }
static inline void jo_vec_store(jo_real *y, jo_vec a)
{
    for (int i = 0; i < 3; i++) y[i] = jo_vec_at(a, i);
}
/* M x */
static inline jo_vec jo_vec_times(const jo_vec *M, jo_vec x)
{
    return jo_vec_with(jo_vec_with(jo_vec_scale(jo_vec_at(x, 0), M[0]), jo_vec_at(x, 1), M[1]), jo_vec_at(x, 2), M[2]);
}
/* M times three numbers in memory, and times a vector there: loads that spread a number over the lanes are cheaper than moves of lanes */
static inline jo_vec jo_vec_mix(const jo_vec *M, const jo_real *x)
{
    return jo_vec_with(jo_vec_with(jo_vec_scale(x[0], M[0]), x[1], M[1]), x[2], M[2]);
}
static inline const jo_real *jo_vec_parts(const jo_vec *a) { return (const jo_real *)a; }
static inline jo_vec jo_vec_on(const jo_vec *M, const jo_vec *x) { return jo_vec_mix(M, jo_vec_parts(x)); }
/* column i of M B^T */
static inline jo_vec jo_vec_on_row(const jo_vec *M, const jo_vec *B, int i)
{
    const jo_vec x = jo_vec_with(jo_vec_scale(jo_vec_parts(B)[i], M[0]), jo_vec_parts(B + 1)[i], M[1]);
    return jo_vec_with(x, jo_vec_parts(B + 2)[i], M[2]);
}

/* e = e0 o exp(theta), as jo_rotate */
#ifdef JO_PICK
static inline void jo_turn_on(jo_real *e, const jo_real *e0, const jo_real *theta)
{
    const jo_vec a = *(const jo_vec_anywhere *)e0, swapped = JO_PICK(a, a, 1, 0, 3, 2), crossed = JO_PICK(a, a, 2, 3, 0, 1);
    const jo_vec both = JO_PICK(a, a, 3, 2, 1, 0);
    const double quarter = 0.25 * jo_dot3(theta, theta);
    double f[3];
    jo_sinc(quarter, f);
    const jo_vec t = theta[0] * ((jo_vec){-1.0, 1.0, 1.0, -1.0} * swapped) + theta[1] * ((jo_vec){-1.0, -1.0, 1.0, 1.0} * crossed)
                     + theta[2] * ((jo_vec){-1.0, 1.0, -1.0, 1.0} * both);
    const jo_vec n = (1.0 - quarter * f[1]) * a + (0.5 * f[0]) * t, s = n * n;
    *(jo_vec_anywhere *)e = jo_inverse_root((s[0] + s[1]) + (s[2] + s[3])) * n;
}
#else
static inline void jo_turn_on(jo_real *e, const jo_real *e0, const jo_real *theta)
{
    for (int i = 0; i < 4; i++) e[i] = e0[i];
    jo_rotate(e, theta);
}
#endif

/* adjoint of a symmetric matrix, its inverse times its determinant, which it returns */
static inline jo_real jo_vec_adjoint(jo_vec *y, const jo_vec *a)
{
    const jo_vec first = jo_vec_wedge(a[1], a[2]);
    y[0] = jo_vec_turn(first);
    y[1] = jo_vec_cross(a[2], a[0]);
    y[2] = jo_vec_cross(a[0], a[1]);
    return jo_vec_dot(jo_vec_turn(jo_vec_turn(a[0])), first);   /* y[0] comes later */
}
static inline void jo_vec_invert(jo_vec *y, const jo_vec *a)
{
    const jo_real r = 1.0 / jo_vec_adjoint(y, a);
    for (int i = 0; i < 3; i++) y[i] = jo_vec_scale(r, y[i]);
}

/* What of a link never changes, in its own frame but for the first two, which are in that of its parent. */
struct jo_link_constants {
    jo_real K[9];           /* orientation at zero, by columns */
    jo_real l[3];           /* origin at zero */
    jo_real mass, S[3];     /* kg; first moment about its origin, kg m */
    jo_real J[9];           /* inertia about its origin, by columns */
    jo_real C[9], c[3];     /* axes, by columns, and origin of the frame of its body */
    int gathers;            /* a link that is not the next one hangs on it, or one that is fixed */
    int on;                 /* link of the body it hangs on: its parent, or one fixed to that; -1: ground */
    jo_real all_mass, all_S[3], all_J[9];   /* with the bodies that are fixed to it */
};

/* Resolved in the world, about the origin of the link; f = M a + H w', t = H^T a + J w' of an articulated inertia. M .. t are all that
 * the link moves with, where somebody reads that; before, what it gathers from links that do not follow it at once. */
struct jo_link_work {
    jo_vec M[3], H[3], J[3];
    jo_vec f, t;            /* force and moment that the articulated inertia needs without joint accelerations */
    jo_vec own_f, own_t;    /* the forces on its body, negative; afterwards what its joint bears */
    jo_vec A[3], l;         /* orientation, way from the origin of the parent */
    jo_real cosine, sine;   /* hinge: of its angle */
    jo_vec w, w0, v0;       /* angular velocity; accelerations without those of joints, afterwards all of them */
    jo_vec Uf, Ut, Us;      /* hinge, slide: inertia along the joint; its moment about the origin of the parent */
    jo_real rest, D, r;     /* force along the joint less that of the bias; inertia along it, 1 / D */
    jo_vec aw, av;          /* what joint accelerations add */
    jo_vec X[3], inverse[3];   /* ball, free: H J^-1 and J^-1 */
    jo_vec Z[3];            /* ball: l~ X */
    jo_vec p, v;            /* position; velocity, in jo_tree_kinematics only */
};

/* What further forces at the origin of a link change, see tree_force_response.c. */
struct jo_link_change {
    jo_vec f, t;            /* of the link and of all that it bears */
    jo_vec aw, av;          /* accelerations */
    jo_real rest;           /* force along the joint */
};

/* A marker of the joint of a loop. */
typedef struct {
    int link, reach, marker;   /* link -1: ground */
    jo_real arm[3], A[9];   /* place and axes, by columns, in the frame of the link */
    double moves, turns;    /* what a unit of force and of moment does to its body alone, about: 1/kg, 1/(kg m2) */
    jo_vec at;              /* arm, world */
    jo_vec f[JO_MAX_ROWS], t[JO_MAX_ROWS];   /* rows as force and moment about the origin of the link */
} jo_loop_side;

struct jo_loop_work {
    int rows, oriented;     /* oriented: the rows need the axes of the markers */
    jo_loop_side side[JO_MAX_SIDES];
    jo_motion motion[JO_MAX_SIDES];   /* of the markers, without accelerations of the joints */
    jo_real x[8];           /* right-hand side, then multipliers */
};

/* What the rows of a loop do at a link: force and moment that arrive there, what of it accelerates the motions of its joint, and
 * that over their inertia. J M^-1 J^T is the sum of rest^T share over the links. */
struct jo_reach_work {
    jo_vec f[JO_MAX_ROWS], t[JO_MAX_ROWS];
    jo_real rest[6][8], share[6][8];   /* (motions x rows), padded with 0 */
};

void jo_tree_sines(const jo_model *m, jo_data *d);   /* tree_joint_sines.c */

/* whether friction holds the joint of a link */
static inline int jo_link_held(const jo_data *d, const jo_link *k) { return k->lock >= 0 && d->locked[k->lock]; }

/* whether the motion of a joint is prescribed, by a drive or as none */
static inline int jo_link_given(const jo_data *d, const jo_link *k) { return k->driven >= 0 || jo_link_held(d, k); }

/* whether the joint of a link moves along one coordinate by its forces */
static inline int jo_link_gives(const jo_data *d, const jo_link *k)
{
    return (k->type == JO_LINK_HINGE || k->type == JO_LINK_SLIDE) && !jo_link_given(d, k);
}

/* the force that prescribes the motion of a hinge or a slide */
static inline jo_real jo_link_pull(const jo_data *d, const jo_link *k, const jo_link_work *w)
{
    const int hinge = k->type == JO_LINK_HINGE;
    jo_vec need = hinge ? jo_vec_across(w->H, w->av) : jo_vec_times(w->M, w->av);
    need = jo_vec_add(need, jo_vec_times(hinge ? w->J : w->H, w->aw));
    need = jo_vec_add(need, hinge ? w->t : w->f);
    return jo_vec_dot(need, w->A[2]) - d->tree.tau[k->u];
}

/* joint coordinate times this is the coordinate of the joint */
static inline double jo_link_sign(const jo_link *k) { return k->reversed ? -1.0 : 1.0; }

#endif
