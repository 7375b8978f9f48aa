/* rainflow.h - the four-point rule of the rainflow count, for meters (damage_meter.c), planes (critical_planes.c) and whole histories. */
#ifndef JO_RAINFLOW_H
#define JO_RAINFLOW_H

#include "jousto.h"

/* The inner two of four turning points z lie within the outer two, and are a cycle; the last has to reach the second for that. */
static inline int jo_closes(const double *z)
{
    return z[3] > z[2] ? z[3] >= z[1] && z[0] <= z[2] : z[3] <= z[1] && z[0] >= z[2];
}

#endif
