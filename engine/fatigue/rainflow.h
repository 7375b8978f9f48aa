/* rainflow.h - four-point rule of the rainflow count, for damage_meter.c, critical_planes.c and rainflow.c. */
#ifndef JO_RAINFLOW_H
#define JO_RAINFLOW_H

#include "jousto.h"

/* whether the inner range of four turning points z lies within the outer range: a closed cycle */
static inline int jo_closes(const double *z)
{
    return z[3] > z[2] ? z[3] >= z[1] && z[0] <= z[2] : z[3] <= z[1] && z[0] >= z[2];
}

#endif
