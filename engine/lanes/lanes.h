/* lanes.h - numbers of JO_VECTOR machines of one structure in the lanes of a vector: comparisons, selections, functions.
 *
 * The machines are independent: results of a lane depend on that lane only. A machine that fails becomes NaN and remains NaN.
 */
#ifndef JO_LANES_H
#define JO_LANES_H

enum { JO_MACHINES = JO_VECTOR };
typedef long long jo_mask __attribute__((vector_size(8 * JO_VECTOR)));

#define JO_ALL (~(jo_mask){0})
#define JO_LESS(a, b) ((jo_mask)((a) < (b)))
#define JO_LESS_OR_EQUAL(a, b) ((jo_mask)((a) <= (b)))
/* constant x in all lanes, for initialisers */
#if JO_VECTOR == 4
#define JO_CONSTANT(x) {x, x, x, x}
#else
#define JO_CONSTANT(x) {x, x, x, x, x, x, x, x}
#endif
#define JO_COMMON(x) ((x)[0])
#define JO_PART(x, lane) ((x)[lane])
#define JO_EACH_LANE(l) for (int l = 0; l < JO_MACHINES; l++)

static inline jo_real jo_same(double x) { return x - (jo_real){0}; }   /* - 0 and not + 0: preserves the sign of 0 */
static inline int jo_some(jo_mask x)
{
    long long any = 0;
    JO_EACH_LANE(l) any |= x[l];
    return any != 0;
}
static inline int jo_every(jo_mask x) { return !jo_some(~x); }
static inline jo_real jo_choose(jo_mask x, jo_real a, jo_real b) { return (jo_real)((x & (jo_mask)a) | (~x & (jo_mask)b)); }
static inline void jo_put(jo_real *y, jo_real x, int lane) { (*y)[lane] = x[lane]; }
static inline void jo_only(jo_mask x, jo_real *y, int n)
{
    for (int i = 0; i < n; i++) y[i] = (jo_real)(x & (jo_mask)y[i]);
}
static inline int jo_spoil(jo_real *x, jo_mask sound)
{
    *x = jo_choose(sound, *x, jo_same(NAN));
    return !jo_some(sound);
}
static inline double jo_most(jo_real x)
{
    double y = x[0];
    JO_EACH_LANE(l) y = x[l] <= y ? y : x[l];
    return y;
}

#define JO_BY_LANE(name, function)            \
    static inline jo_real name(jo_real x)     \
    {                                         \
        jo_real y = x;                        \
        JO_EACH_LANE(l) y[l] = function(x[l]); \
        return y;                             \
    }
JO_BY_LANE(jo_sqrt, sqrt)
JO_BY_LANE(jo_sin, sin)
JO_BY_LANE(jo_cos, cos)
JO_BY_LANE(jo_floor, floor)
JO_BY_LANE(jo_magnitude, fabs)
static inline jo_real jo_atan2(jo_real y, jo_real x)
{
    jo_real z = x;
    JO_EACH_LANE(l) z[l] = atan2(y[l], x[l]);
    return z;
}

#endif
