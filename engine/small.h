/* small.h - operations on scalars, lanes, 3-vectors, 3x3 matrices and rotations. Matrices are row-major. */
#ifndef JO_SMALL_H
#define JO_SMALL_H

#include "jousto.h"
#include <math.h>

#if defined(JO_VECTOR)
#include "lanes/lanes.h"
#elif defined(JO_COMPLEX)
#define JO_RE(x) creal(x)
#define jo_sqrt csqrt
#define jo_sin csin
#define jo_cos ccos
#define jo_exp cexp
#define jo_log clog
#else
#define JO_RE(x) (x)
#define jo_sqrt sqrt
#define jo_sin sin
#define jo_cos cos
#define jo_exp exp
#define jo_log log
#endif

/* a function that is compiled separately for each constant argument */
#if defined(__GNUC__)
#define JO_INLINE inline __attribute__((always_inline))
#else
#define JO_INLINE inline
#endif

/* Comparisons and selections per lane. Builds with one machine: comparisons of real parts; lanes/lanes.h: several machines. */
#ifndef JO_VECTOR
enum { JO_MACHINES = 1 };
typedef int jo_mask;
#define JO_LESS(a, b) (JO_RE(a) < JO_RE(b))
#define JO_LESS_OR_EQUAL(a, b) (JO_RE(a) <= JO_RE(b))
#define JO_CONSTANT(x) x                                           /* constant x in all lanes, for initialisers */
#define JO_COMMON(x) JO_RE(x)                                      /* value of a number that is equal in all lanes */
#define JO_PART(x, lane) ((void)(lane), JO_RE(x))
static inline jo_real jo_same(double x) { return x; }              /* x in all lanes */
#define JO_ALL 1
static inline int jo_some(jo_mask x) { return x; }
static inline int jo_every(jo_mask x) { return x; }
static inline jo_real jo_choose(jo_mask x, jo_real a, jo_real b) { return x ? a : b; }
static inline jo_real jo_magnitude(jo_real x) { return fabs(JO_RE(x)); }
static inline double jo_floor(jo_real x) { return floor(JO_RE(x)); }
static inline double jo_most(jo_real x) { return JO_RE(x); }       /* largest value of the lanes; NaN if any lane is NaN */
static inline void jo_put(jo_real *y, jo_real x, int lane) { (void)lane; *y = x; }
static inline void jo_only(jo_mask x, jo_real *y, int n) { (void)x; (void)y; (void)n; }   /* y = 0 in lanes where x is false */
/* x = NaN in lanes that are not sound; returns whether no lane is sound */
static inline int jo_spoil(jo_real *x, jo_mask sound) { (void)x; return !sound; }
#endif

/* jo_lanes: JO_WIDTH numbers of a modal array, 4 with AVX, 2 on other processors with vector types, else 1. Modal arrays are padded: loops
 * JO_EACH need no remainder. */
#if defined(__GNUC__) && !defined(JO_COMPLEX) && !defined(JO_VECTOR) && !defined(__AVX__)
typedef double jo_lanes __attribute__((vector_size(16), aligned(8), may_alias));
enum { JO_WIDTH = 2 };
static inline jo_real jo_sum(const jo_lanes x) { return x[0] + x[1]; }
#elif defined(__GNUC__) && !defined(JO_COMPLEX) && !defined(JO_VECTOR)
typedef double jo_lanes __attribute__((vector_size(32), aligned(8), may_alias));
enum { JO_WIDTH = 4 };
static inline jo_real jo_sum(const jo_lanes x) { return (x[0] + x[1]) + (x[2] + x[3]); }
/* vector of lanes i, j, k, l of a (0 to 3) and b (4 to 7) */
#if defined(__clang__)
#define JO_PICK(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#else
typedef long long jo_lane_places __attribute__((vector_size(32)));
#define JO_PICK(a, b, i, j, k, l) __builtin_shuffle(a, b, (jo_lane_places){i, j, k, l})
#endif
/* [jo_sum(a), jo_sum(b), jo_sum(c), jo_sum(d)], equal bit for bit, with shared shuffles */
static inline jo_lanes jo_four_sums(const jo_lanes a, const jo_lanes b, const jo_lanes c, const jo_lanes d)
{
    const jo_lanes ab = JO_PICK(a, b, 0, 4, 2, 6) + JO_PICK(a, b, 1, 5, 3, 7);
    const jo_lanes cd = JO_PICK(c, d, 0, 4, 2, 6) + JO_PICK(c, d, 1, 5, 3, 7);
    return JO_PICK(ab, cd, 0, 1, 4, 5) + JO_PICK(ab, cd, 2, 3, 6, 7);
}
#else
typedef jo_real jo_lanes;
enum { JO_WIDTH = 1 };
static inline jo_real jo_sum(const jo_lanes x) { return x; }
#endif

/* y[0..3] = jo_sum of a, b, c, d, equal bit for bit */
static inline void jo_sums(jo_real *y, const jo_lanes a, const jo_lanes b, const jo_lanes c, const jo_lanes d)
{
#ifdef JO_PICK
    *(jo_lanes *)y = jo_four_sums(a, b, c, d);
#else
    y[0] = jo_sum(a);
    y[1] = jo_sum(b);
    y[2] = jo_sum(c);
    y[3] = jo_sum(d);
#endif
}

#define JO_LOAD(p) (*(const jo_lanes *)(p))
#define JO_STORE(p) (*(jo_lanes *)(p))
#define JO_PI 3.14159265358979323846
#define JO_SINC_SERIES 0.04     /* square of the angle, rad2, below which Taylor series replace sin and cos: error below 1e-17 */
#define JO_ROOT_SERIES 1e-6     /* value of |s - 1| below which 1 / sqrt(s) is computed by a series, whose next term is 3e-19 */
#define JO_EACH(j, np) for (int j = 0; j < (np); j += JO_WIDTH)

/* y = M x, M (3 x np) */
static inline void jo_modal3(jo_real *restrict y, const jo_real *restrict M, const jo_real *restrict x, const int np)
{
    jo_lanes s0 = {0}, s1 = {0}, s2 = {0};
    jo_real s[4];
    JO_EACH(j, np) {
        const jo_lanes xj = JO_LOAD(x + j);
        s0 += JO_LOAD(M + j) * xj;
        s1 += JO_LOAD(M + np + j) * xj;
        s2 += JO_LOAD(M + 2 * np + j) * xj;
    }
    jo_sums(s, s0, s1, s2, s2);
    for (int c = 0; c < 3; c++) y[c] = s[c];
}

/* rounded up to whole vectors */
static inline int jo_pad(int count) { return (count + JO_PAD - 1) & ~(JO_PAD - 1); }

static inline void jo_set3(jo_real *y, const jo_real *x) { y[0] = x[0]; y[1] = x[1]; y[2] = x[2]; }
static inline void jo_add3(jo_real *y, const jo_real *x) { y[0] += x[0]; y[1] += x[1]; y[2] += x[2]; }
static inline void jo_sub3(jo_real *y, const jo_real *x) { y[0] -= x[0]; y[1] -= x[1]; y[2] -= x[2]; }
static inline void jo_axpy3(jo_real *y, jo_real s, const jo_real *x)
{
    y[0] += s * x[0]; y[1] += s * x[1]; y[2] += s * x[2];
}
static inline jo_real jo_dot3(const jo_real *a, const jo_real *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
/* larger one of x and y per lane; NaN if y is NaN */
static inline jo_real jo_maximum(jo_real x, jo_real y) { return jo_choose(JO_LESS_OR_EQUAL(y, x), x, y); }

static inline double jo_larger(double a, double b) { return a > b ? a : b; }

/* x = column i of A */
static inline void jo_axis(jo_real *x, const jo_real *A, int i) { x[0] = A[i]; x[1] = A[3 + i]; x[2] = A[6 + i]; }

#ifndef JO_VECTOR
static inline jo_real jo_size(jo_real x) { return JO_RE(x) < 0.0 ? -x : x; }   /* |x|, with its derivative */
static inline int jo_whole(jo_real x) { return (int)JO_RE(x); }
static inline double jo_length(const jo_real *x, int n)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += JO_RE(x[i]) * JO_RE(x[i]);
    return sqrt(sum);
}
#endif
/* y = a x b */
static inline void jo_cross(jo_real *y, const jo_real *a, const jo_real *b)
{
    jo_real y0 = a[1] * b[2] - a[2] * b[1], y1 = a[2] * b[0] - a[0] * b[2], y2 = a[0] * b[1] - a[1] * b[0];
    y[0] = y0; y[1] = y1; y[2] = y2;
}
/* y = A x */
static inline void jo_mul3(jo_real *y, const jo_real *A, const jo_real *x)
{
    jo_real y0 = jo_dot3(A, x), y1 = jo_dot3(A + 3, x), y2 = jo_dot3(A + 6, x);
    y[0] = y0; y[1] = y1; y[2] = y2;
}
/* y = A^T x */
static inline void jo_mul3t(jo_real *y, const jo_real *A, const jo_real *x)
{
    jo_real y0 = A[0] * x[0] + A[3] * x[1] + A[6] * x[2];
    jo_real y1 = A[1] * x[0] + A[4] * x[1] + A[7] * x[2];
    jo_real y2 = A[2] * x[0] + A[5] * x[1] + A[8] * x[2];
    y[0] = y0; y[1] = y1; y[2] = y2;
}
/* C = A B */
static inline void jo_mul33(jo_real *restrict C, const jo_real *restrict A, const jo_real *restrict B)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            C[3 * i + j] = A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j];
}
/* y = J x, J symmetric: [xx yy zz yz xz xy] */
static inline void jo_sym3(jo_real *y, const jo_real *J, const jo_real *x)
{
    jo_real y0 = J[0] * x[0] + J[5] * x[1] + J[4] * x[2];
    jo_real y1 = J[5] * x[0] + J[1] * x[1] + J[3] * x[2];
    jo_real y2 = J[4] * x[0] + J[3] * x[1] + J[2] * x[2];
    y[0] = y0; y[1] = y1; y[2] = y2;
}

/* rotation matrix of unit Euler parameters (Rantalainen 2007, eq. 3.5 corrected) */
static inline void jo_rotation(jo_real *A, const jo_real *e)
{
    jo_real e0 = e[0], e1 = e[1], e2 = e[2], e3 = e[3];
    A[0] = 1.0 - 2.0 * (e2 * e2 + e3 * e3); A[1] = 2.0 * (e1 * e2 - e0 * e3); A[2] = 2.0 * (e1 * e3 + e0 * e2);
    A[3] = 2.0 * (e1 * e2 + e0 * e3); A[4] = 1.0 - 2.0 * (e1 * e1 + e3 * e3); A[5] = 2.0 * (e2 * e3 - e0 * e1);
    A[6] = 2.0 * (e1 * e3 - e0 * e2); A[7] = 2.0 * (e2 * e3 + e0 * e1); A[8] = 1.0 - 2.0 * (e1 * e1 + e2 * e2);
}

/* quaternion (scalar first, not negative) of a rotation matrix in a lane, from its largest component */
static inline void jo_quaternion_of(jo_real *e, const jo_real *A, int lane)
{
    const jo_real t[4] = {1.0 + A[0] + A[4] + A[8], 1.0 + A[0] - A[4] - A[8], 1.0 - A[0] + A[4] - A[8], 1.0 - A[0] - A[4] + A[8]};
    int k = 0;
    for (int i = 1; i < 4; i++)
        if (JO_PART(t[i], lane) > JO_PART(t[k], lane)) k = i;
    jo_real s = 0.5 / jo_sqrt(t[k]);
    jo_real x[4][4] = {
        {t[0], A[7] - A[5], A[2] - A[6], A[3] - A[1]},
        {A[7] - A[5], t[1], A[1] + A[3], A[2] + A[6]},
        {A[2] - A[6], A[1] + A[3], t[2], A[5] + A[7]},
        {A[3] - A[1], A[2] + A[6], A[5] + A[7], t[3]},
    };
    if (JO_PART(x[k][0], lane) < 0.0) s = -s;
    for (int i = 0; i < 4; i++) jo_put(e + i, x[k][i] * s, lane);
}
static inline void jo_quaternion(jo_real *e, const jo_real *A)
{
    for (int l = 0; l < JO_MACHINES; l++) jo_quaternion_of(e, A, l);
}

/* f[0..2] = sin(x)/x, (1 - cos x)/x^2, (x - sin x)/x^3 as functions of s = x^2, smooth at 0 */
static inline void jo_sinc(jo_real s, jo_real *f)
{
    const jo_mask small = JO_LESS(s, JO_SINC_SERIES);
    if (jo_some(small)) {
        f[0] = 1.0 + s * (-1.0 / 6.0 + s * (1.0 / 120.0 + s * (-1.0 / 5040.0 + s * (1.0 / 362880.0 - s * (1.0 / 39916800.0)))));
        f[1] = 0.5 + s * (-1.0 / 24.0 + s * (1.0 / 720.0 + s * (-1.0 / 40320.0 + s * (1.0 / 3628800.0 - s * (1.0 / 479001600.0)))));
        f[2] = 1.0 / 6.0 + s * (-1.0 / 120.0 + s * (1.0 / 5040.0 + s * (-1.0 / 362880.0 + s * (1.0 / 39916800.0 - s * (1.0 / 6227020800.0)))));
    }
    if (!jo_every(small)) {
        const jo_real x = jo_sqrt(s), sx = jo_sin(x), cx = jo_cos(x);
        const jo_real g[3] = {sx / x, (1.0 - cx) / s, (x - sx) / (s * x)};
        for (int i = 0; i < 3; i++) f[i] = jo_choose(small, f[i], g[i]);
    }
}

/* derivatives of f[1], f[2] with respect to s, from f of jo_sinc */
static inline void jo_sinc_rate(jo_real s, const jo_real *f, jo_real *df1, jo_real *df2)
{
    const jo_mask small = JO_LESS(s, JO_SINC_SERIES);
    if (jo_some(small)) {
        *df1 = -1.0 / 24.0 + s * (1.0 / 360.0 - s * (1.0 / 13440.0 - s * (1.0 / 907200.0 - s * (1.0 / 95800320.0))));
        *df2 = -1.0 / 120.0 + s * (1.0 / 2520.0 - s * (1.0 / 120960.0 - s * (1.0 / 9979200.0 - s * (1.0 / 1245404160.0))));
    }
    if (!jo_every(small)) {
        *df1 = jo_choose(small, *df1, (0.5 * f[0] - f[1]) / s);
        *df2 = jo_choose(small, *df2, (0.5 * f[1] - 1.5 * f[2]) / s);
    }
}

/* 1 / sqrt(s); near 1 (product of unit quaternions) by its series, which is exact to round-off */
static inline jo_real jo_inverse_root(jo_real s)
{
    const jo_real off = s - 1.0;
    if (jo_every(JO_LESS(jo_magnitude(off), JO_ROOT_SERIES))) return 1.0 + off * (-0.5 + 0.375 * off);
    return 1.0 / jo_sqrt(s);
}

/* e = e o exp(theta), normalised; theta: local rotation vector, rad */
static inline void jo_rotate(jo_real *e, const jo_real *theta)
{
    jo_real quarter = 0.25 * jo_dot3(theta, theta), f[3];
    jo_sinc(quarter, f);
    jo_real d0 = 1.0 - quarter * f[1];   /* cos(x/2) = 1 - (x/2)^2 (1 - cos)/(x/2)^2 */
    jo_real d1 = 0.5 * f[0] * theta[0], d2 = 0.5 * f[0] * theta[1], d3 = 0.5 * f[0] * theta[2];
    jo_real n0 = e[0] * d0 - e[1] * d1 - e[2] * d2 - e[3] * d3;
    jo_real n1 = e[0] * d1 + e[1] * d0 + e[2] * d3 - e[3] * d2;
    jo_real n2 = e[0] * d2 + e[2] * d0 + e[3] * d1 - e[1] * d3;
    jo_real n3 = e[0] * d3 + e[3] * d0 + e[1] * d2 - e[2] * d1;
    const jo_real norm = jo_inverse_root(n0 * n0 + n1 * n1 + n2 * n2 + n3 * n3);
    e[0] = n0 * norm; e[1] = n1 * norm; e[2] = n2 * norm; e[3] = n3 * norm;
}

/* rate of the rotation vector theta of a frame e o exp(theta) with angular velocity w (local):
 * theta' = w + theta x w / 2 + c theta x (theta x w), c = (1 - x cot(x/2) / 2) / x^2 with x = |theta|; error of the
 * series: 1e-9 at x = 1 */
static inline void jo_rotation_rate(jo_real *rate, const jo_real *theta, const jo_real *w)
{
    const jo_real s = jo_dot3(theta, theta);
    const jo_real c = 1.0 / 12.0 + s * (1.0 / 720.0 + s * (1.0 / 30240.0 + s * (1.0 / 1209600.0 + s * (1.0 / 47900160.0))));
    jo_real c1[3], c2[3];
    jo_cross(c1, theta, w);
    jo_cross(c2, theta, c1);
    for (int i = 0; i < 3; i++) rate[i] = w[i] + 0.5 * c1[i] + c * c2[i];
}

/* M (3x3) += s a~ */
static inline void jo_add_skew(jo_real *M, jo_real s, const jo_real *a)
{
    M[1] -= s * a[2]; M[2] += s * a[1];
    M[3] += s * a[2]; M[5] -= s * a[0];
    M[6] -= s * a[1]; M[7] += s * a[0];
}

/* M += s a~ b~ = s (b a^T - (a . b) E) */
static inline void jo_add_skew_skew(jo_real *M, jo_real s, const jo_real *a, const jo_real *b)
{
    const jo_real ab = jo_dot3(a, b);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) M[3 * i + j] += s * b[i] * a[j];
        M[4 * i] -= s * ab;
    }
}

#endif
