/* dual.h - numbers and vectors with their change in one direction (forward differentiation): a formula written once gives its derivative. */
#ifndef JO_DUAL_H
#define JO_DUAL_H

#include "small.h"

typedef struct { jo_real v, d; } jo_dual;            /* value and change */
typedef struct { jo_real v[3], d[3]; } jo_dual3;

static inline jo_dual jo_dual_of(jo_real v, jo_real d)
{
    jo_dual y;
    y.v = v;
    y.d = d;
    return y;
}
static inline jo_dual jo_dual_constant(double v) { return jo_dual_of(jo_same(v), jo_same(0.0)); }
static inline jo_dual jo_dual_add(jo_dual a, jo_dual b) { return jo_dual_of(a.v + b.v, a.d + b.d); }
static inline jo_dual jo_dual_sub(jo_dual a, jo_dual b) { return jo_dual_of(a.v - b.v, a.d - b.d); }
static inline jo_dual jo_dual_mul(jo_dual a, jo_dual b) { return jo_dual_of(a.v * b.v, a.d * b.v + a.v * b.d); }
static inline jo_dual jo_dual_div(jo_dual a, jo_dual b)
{
    const jo_real q = a.v / b.v;
    return jo_dual_of(q, (a.d - q * b.d) / b.v);
}
static inline jo_dual jo_dual_times(jo_real s, jo_dual a) { return jo_dual_of(s * a.v, s * a.d); }
static inline jo_dual jo_dual_plus(jo_dual a, jo_real s) { return jo_dual_of(a.v + s, a.d); }
/* root of a positive number */
static inline jo_dual jo_dual_root(jo_dual a)
{
    const jo_real root = jo_sqrt(a.v);
    return jo_dual_of(root, 0.5 * a.d / root);
}
#ifndef JO_VECTOR
/* root, with the derivative 0 at 0: of the length of a vector that is multiplied by the vector */
static inline jo_dual jo_dual_sqrt(jo_dual a)
{
    return JO_RE(a.v) > 0.0 ? jo_dual_root(a) : jo_dual_constant(0.0);
}
static inline jo_dual jo_dual_sin(jo_dual a) { return jo_dual_of(jo_sin(a.v), jo_cos(a.v) * a.d); }
static inline jo_dual jo_dual_exp(jo_dual a)
{
    const jo_real e = jo_exp(a.v);
    return jo_dual_of(e, e * a.d);
}
static inline jo_dual jo_dual_size(jo_dual a) { return JO_RE(a.v) < 0.0 ? jo_dual_times(jo_same(-1.0), a) : a; }
#endif

static inline jo_dual3 jo_dual3_of(const jo_real *v, const jo_real *d)
{
    jo_dual3 y;
    jo_set3(y.v, v);
    jo_set3(y.d, d);
    return y;
}
static inline jo_dual3 jo_dual3_add(jo_dual3 a, jo_dual3 b)
{
    jo_add3(a.v, b.v);
    jo_add3(a.d, b.d);
    return a;
}
static inline jo_dual3 jo_dual3_sub(jo_dual3 a, jo_dual3 b)
{
    jo_sub3(a.v, b.v);
    jo_sub3(a.d, b.d);
    return a;
}
static inline jo_dual jo_dual3_dot(jo_dual3 a, jo_dual3 b) { return jo_dual_of(jo_dot3(a.v, b.v), jo_dot3(a.d, b.v) + jo_dot3(a.v, b.d)); }
static inline jo_dual3 jo_dual3_cross(jo_dual3 a, jo_dual3 b)
{
    jo_dual3 y;
    jo_real t[3];
    jo_cross(y.v, a.v, b.v);
    jo_cross(y.d, a.d, b.v);
    jo_cross(t, a.v, b.d);
    jo_add3(y.d, t);
    return y;
}
static inline jo_dual3 jo_dual3_times(jo_dual s, jo_dual3 a)
{
    jo_dual3 y;
    for (int i = 0; i < 3; i++) {
        y.v[i] = s.v * a.v[i];
        y.d[i] = s.d * a.v[i] + s.v * a.d[i];
    }
    return y;
}
/* a + s b */
static inline jo_dual3 jo_dual3_axpy(jo_dual3 a, jo_dual s, jo_dual3 b) { return jo_dual3_add(a, jo_dual3_times(s, b)); }
static inline jo_dual jo_dual3_length(jo_dual3 a) { return jo_dual_root(jo_dual3_dot(a, a)); }
static inline jo_dual3 jo_dual3_unit(jo_dual3 a)
{
    return jo_dual3_times(jo_dual_div(jo_dual_constant(1.0), jo_dual3_length(a)), a);
}

#endif
