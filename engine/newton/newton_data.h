/* newton_data.h - what the files of this room keep; other rooms reach it by the functions of newton.h. */
#ifndef JO_NEWTON_DATA_H
#define JO_NEWTON_DATA_H

#include "small.h"

/* What one unknown of Newton's matrix, an acceleration, changes: accelerations by a, velocities by v, increments of
 * the position by q. The rows of the joints are those of C' times rows, or of C. */
typedef struct {
    double a, v, q, rows;
    int position;           /* rows of C instead of C' */
    int plain;              /* inertia forces change with accelerations only */
} jo_weights;

#endif
