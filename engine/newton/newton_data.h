/* newton_data.h - weights of the unknowns of Newton's method. */
#ifndef JO_NEWTON_DATA_H
#define JO_NEWTON_DATA_H

#include "small.h"

/* Change of accelerations (a), velocities (v, s) and increments of positions (q, s2) by a unit of an unknown, an algorithmic acceleration.
 * The joint rows are `rows` times those of C', or of C. */
typedef struct {
    double a, v, q, rows;
    int position;           /* whether the joint rows are those of C instead of C' */
    int plain;              /* whether derivatives of inertia forces with respect to positions and velocities are omitted */
} jo_weights;

#endif
