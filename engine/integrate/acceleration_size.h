/* acceleration_size.h - size of accelerations in the metric of the masses, for the iteration of generalised alpha. */
#ifndef JO_ACCELERATION_SIZE_H
#define JO_ACCELERATION_SIZE_H

#include "data.h"

/* square of the accelerations x of a body in the metric of the masses: m R''^2 + J w'^2 + p''^2 */
static inline double jo_acceleration_size(const jo_model *m, const jo_data *d, int body, const jo_real *x)
{
    const jo_body *b = &m->body[body];
    double sum = 0.0;
    for (int j = 0; j < 3; j++) {
        const double R = JO_RE(x[j]), w = JO_RE(x[3 + j]);
        sum += JO_RE(b->mass[0]) * R * R + JO_RE(d->body[body].J[j]) * w * w;
    }
    for (int j = 6; j < 6 + b->n; j++) sum += JO_RE(x[j]) * JO_RE(x[j]);
    return sum;
}

#endif
