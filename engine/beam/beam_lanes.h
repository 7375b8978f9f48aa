/* beam_lanes.h - 3-vectors and matrices of JO_WIDTH elements side by side, one element in each lane, and their way from and to memory. */
#ifndef JO_BEAM_LANES_H
#define JO_BEAM_LANES_H

#include "data.h"

#define JO_EACH_ELEMENT(l, w) for (int l = 0; l < (w)->count; l++)
#define JO_EACH_PLACE(l) for (int l = 0; l < JO_WIDTH; l++)

static inline jo_real jo_lane(const jo_lanes *x, int l) { return ((const jo_real *)x)[l]; }
static inline void jo_set_lane(jo_lanes *x, int l, jo_real y) { ((jo_real *)x)[l] = y; }

/* x in all lanes */
static inline jo_lanes jo_lanes_of(double x)
{
    const jo_lanes zero = {0};
    return zero + x;
}

static inline jo_lanes jo_lanes_sqrt(jo_lanes x)
{
    JO_EACH_PLACE(l) jo_set_lane(&x, l, jo_sqrt(jo_lane(&x, l)));
    return x;
}

/* whether x > limit in all lanes; false for NaN */
static inline int jo_lanes_above(const jo_lanes *x, double limit)
{
    int above = 1;
    JO_EACH_PLACE(l) above &= JO_RE(jo_lane(x, l)) > limit;
    return above;
}

/* 4 x 4 numbers: y[j] = [x[0][j], x[1][j], ...] */
static inline void jo_lanes_gather(jo_lanes *y, const jo_real *const *x)
{
#ifdef JO_PICK
    const jo_lanes a = JO_LOAD(x[0]), b = JO_LOAD(x[1]), c = JO_LOAD(x[2]), d = JO_LOAD(x[3]);
    const jo_lanes ab = JO_PICK(a, b, 0, 4, 2, 6), AB = JO_PICK(a, b, 1, 5, 3, 7);
    const jo_lanes cd = JO_PICK(c, d, 0, 4, 2, 6), CD = JO_PICK(c, d, 1, 5, 3, 7);
    y[0] = JO_PICK(ab, cd, 0, 1, 4, 5);
    y[1] = JO_PICK(AB, CD, 0, 1, 4, 5);
    y[2] = JO_PICK(ab, cd, 2, 3, 6, 7);
    y[3] = JO_PICK(AB, CD, 2, 3, 6, 7);
#else
    for (int j = 0; j < 4; j++)
        JO_EACH_PLACE(l) jo_set_lane(y + j, l, x[l][j]);
#endif
}

/* x[l][j] += lane l of y[j], j = 0 to 3, of the first `count` lanes */
static inline void jo_lanes_scatter(jo_real *const *x, const int count, const jo_lanes y0, const jo_lanes y1, const jo_lanes y2,
                                    const jo_lanes y3)
{
#ifdef JO_PICK
    const jo_lanes ab = JO_PICK(y0, y1, 0, 4, 2, 6), AB = JO_PICK(y0, y1, 1, 5, 3, 7);
    const jo_lanes cd = JO_PICK(y2, y3, 0, 4, 2, 6), CD = JO_PICK(y2, y3, 1, 5, 3, 7);
    JO_STORE(x[0]) += JO_PICK(ab, cd, 0, 1, 4, 5);
    if (count > 1) JO_STORE(x[1]) += JO_PICK(AB, CD, 0, 1, 4, 5);
    if (count > 2) JO_STORE(x[2]) += JO_PICK(ab, cd, 2, 3, 6, 7);
    if (count > 3) JO_STORE(x[3]) += JO_PICK(AB, CD, 2, 3, 6, 7);
#else
    for (int l = 0; l < count; l++) {
        x[l][0] += jo_lane(&y0, l);
        x[l][1] += jo_lane(&y1, l);
        x[l][2] += jo_lane(&y2, l);
        x[l][3] += jo_lane(&y3, l);
    }
#endif
}

/* x[l][j] += lane l of y[j], j = 0 and 1, of the first `count` lanes */
static inline void jo_lanes_scatter_two(jo_real *const *x, const int count, const jo_lanes y0, const jo_lanes y1)
{
#ifdef JO_PICK
    typedef double pair __attribute__((vector_size(16), aligned(8), may_alias));
    const jo_lanes even = JO_PICK(y0, y1, 0, 4, 2, 6), odd = JO_PICK(y0, y1, 1, 5, 3, 7);
    *(pair *)x[0] += (pair){even[0], even[1]};
    if (count > 1) *(pair *)x[1] += (pair){odd[0], odd[1]};
    if (count > 2) *(pair *)x[2] += (pair){even[2], even[3]};
    if (count > 3) *(pair *)x[3] += (pair){odd[2], odd[3]};
#else
    for (int l = 0; l < count; l++) {
        x[l][0] += jo_lane(&y0, l);
        x[l][1] += jo_lane(&y1, l);
    }
#endif
}

/* x[l] += lane l of six numbers y, z. In two parts that do not overlap: a load that overlaps an earlier store in part waits for it */
static inline void jo_lanes_scatter_six(jo_real *const *x, const int count, const jo_lanes *y, const jo_lanes *z)
{
    jo_real *rest[JO_WIDTH];
    JO_EACH_PLACE(l) rest[l] = x[l] + 4;
    jo_lanes_scatter(x, count, y[0], y[1], y[2], z[0]);
    jo_lanes_scatter_two(rest, count, z[1], z[2]);
}

static inline void jo_lanes_copy(jo_lanes *y, const jo_lanes *x, int n)
{
    for (int i = 0; i < n; i++) y[i] = x[i];
}
static inline void jo_lanes_clear(jo_lanes *y, int n)
{
    const jo_lanes zero = {0};
    for (int i = 0; i < n; i++) y[i] = zero;
}
static inline jo_lanes jo_lanes_dot(const jo_lanes *a, const jo_lanes *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
/* y = a x b */
static inline void jo_lanes_cross(jo_lanes *y, const jo_lanes *a, const jo_lanes *b)
{
    const jo_lanes y0 = a[1] * b[2] - a[2] * b[1], y1 = a[2] * b[0] - a[0] * b[2], y2 = a[0] * b[1] - a[1] * b[0];
    y[0] = y0; y[1] = y1; y[2] = y2;
}
/* y = A x */
static inline void jo_lanes_mul(jo_lanes *y, const jo_lanes *A, const jo_lanes *x)
{
    const jo_lanes y0 = jo_lanes_dot(A, x), y1 = jo_lanes_dot(A + 3, x), y2 = jo_lanes_dot(A + 6, x);
    y[0] = y0; y[1] = y1; y[2] = y2;
}
/* y = A^T x */
static inline void jo_lanes_mult(jo_lanes *y, const jo_lanes *A, const jo_lanes *x)
{
    const jo_lanes y0 = A[0] * x[0] + A[3] * x[1] + A[6] * x[2], y1 = A[1] * x[0] + A[4] * x[1] + A[7] * x[2],
                   y2 = A[2] * x[0] + A[5] * x[1] + A[8] * x[2];
    y[0] = y0; y[1] = y1; y[2] = y2;
}

/* 3 x 3 matrices */
/* Y += s a~ */
static inline void jo_lanes_add_skew(jo_lanes *Y, const jo_lanes s, const jo_lanes *a)
{
    const jo_lanes x = s * a[0], y = s * a[1], z = s * a[2];
    Y[1] -= z; Y[2] += y; Y[3] += z; Y[5] -= x; Y[6] -= y; Y[7] += x;
}
/* Y += s a~ b~ = s (b a^T - (a . b) E) */
static inline void jo_lanes_add_skew_skew(jo_lanes *Y, const jo_lanes s, const jo_lanes *a, const jo_lanes *b)
{
    const jo_lanes ab = s * jo_lanes_dot(a, b);
    for (int i = 0; i < 3; i++) {
        const jo_lanes y = s * b[i];
        for (int j = 0; j < 3; j++) Y[3 * i + j] += y * a[j];
        Y[4 * i] -= ab;
    }
}
/* Y += s a~ X */
static inline void jo_lanes_add_cross(jo_lanes *restrict Y, const jo_lanes s, const jo_lanes *a, const jo_lanes *restrict X)
{
    const jo_lanes x = s * a[0], y = s * a[1], z = s * a[2];
    for (int j = 0; j < 3; j++) {
        const jo_lanes x0 = X[j], x1 = X[3 + j], x2 = X[6 + j];
        Y[j] += y * x2 - z * x1;
        Y[3 + j] += z * x0 - x * x2;
        Y[6 + j] += x * x1 - y * x0;
    }
}
/* Y += A X */
static inline void jo_lanes_add_product(jo_lanes *restrict Y, const jo_lanes *restrict A, const jo_lanes *restrict X)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) Y[3 * i + j] += A[3 * i] * X[j] + A[3 * i + 1] * X[3 + j] + A[3 * i + 2] * X[6 + j];
}
/* Y = A X */
static inline void jo_lanes_product(jo_lanes *restrict Y, const jo_lanes *restrict A, const jo_lanes *restrict X)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) Y[3 * i + j] = A[3 * i] * X[j] + A[3 * i + 1] * X[3 + j] + A[3 * i + 2] * X[6 + j];
}

/* Operator H of the forces and tangents of the element. With Rodrigues' parameters tau = tan(phi/4) n of the rotation phi n between the
 * ends and the spins beta_a, beta_b of the ends, all in the middle frame:
 *   d tau = (1 + tau^2)/4 dbeta,  d(phi n) = H dbeta,  H = E - mu tau~ tau~,  dbeta = beta_b - beta_a */
/* y = H x */
static inline void jo_lanes_h(jo_lanes *y, const jo_beam_group *w, const jo_lanes *x)
{
    const jo_lanes one = 1.0 + w->mu * w->square, p = w->mu * jo_lanes_dot(w->tau, x);
    for (int i = 0; i < 3; i++) y[i] = one * x[i] - p * w->tau[i];
}

#endif
