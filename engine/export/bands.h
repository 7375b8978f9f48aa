/* bands.h - stress at hot spots with confidence bands, from modal coordinates and their covariance. */
#ifndef JO_BANDS_H
#define JO_BANDS_H
#include "gauged_twin.h"

typedef struct {
    double *value, *low, *high;     /* (nspot) */
    double *spread, *root, *size;   /* (nspot); (nspot x 6 x 6) deviations in rows; (nspot) */
    double *tensors, *found, *columns;
} jo_band;

long long jo_band_place(jo_band *b, const jo_plan *p, double *base);   /* returns the number of doubles; base NULL: count only */
void jo_band_blind(jo_band *b, const jo_plan *p);
void jo_band_spread(jo_band *b, const jo_plan *p, const double *cov);  /* after a change of the covariance (n x n) of the modes */
void jo_band_stress(jo_band *b, const jo_plan *p, const double *q, const double *moved);   /* modes (n), deviations (n x nerror) */

#endif
