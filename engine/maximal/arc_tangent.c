/* arc_tangent.c - atan2 of numbers that may be complex, or of several machines. */
#include "maximal/maximal.h"

/* atan2(y, x); complex build: first-order expansion in the imaginary parts */
jo_real jo_arc_tangent(jo_real y, jo_real x)
{
#if defined(JO_COMPLEX)
    const double u = creal(x), v = creal(y);
    return atan2(v, u) + I * ((u * cimag(y) - v * cimag(x)) / (u * u + v * v));
#elif defined(JO_VECTOR)
    return jo_atan2(y, x);
#else
    return atan2(y, x);
#endif
}
