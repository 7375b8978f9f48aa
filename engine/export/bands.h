/* bands.h - stress at a few places from modal coordinates and their covariance, with the band in which it lies. */
#ifndef JO_BANDS_H
#define JO_BANDS_H
#include "gauged_twin.h"

typedef struct {
    double *value, *low, *high;     /* (nspot) */
    double *spread, *root, *size;   /* (nspot); (nspot x 6 x 6) deviations in rows; (nspot) */
    double *tensors, *found, *columns;
} jo_band;

long long jo_band_place(jo_band *b, const jo_plan *p, double *base);   /* doubles from `base` on, which may be 0 */
void jo_band_blind(jo_band *b, const jo_plan *p);
void jo_band_spread(jo_band *b, const jo_plan *p, const double *cov);  /* after the covariance (n x n) of the modes has changed */
void jo_band_stress(jo_band *b, const jo_plan *p, const double *q, const double *moved);   /* modes (n), deviations (n x nerror) */

#endif
