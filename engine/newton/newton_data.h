/* newton_data.h - weights of the unknowns of Newton's method. */
#ifndef JO_NEWTON_DATA_H
#define JO_NEWTON_DATA_H

#include "small.h"

typedef struct {
    jo_real *N, *x;         /* (nnewton) Newton's matrix or its factors, (nv + nrow) right-hand side or solution */
    int *pivot;             /* (nv + nrow) row exchanges */
    double *unit, *unit_of_row;   /* (nv + nrow) units of the unknowns of N; the same in the order of the exchanged rows */
    jo_real *base, *base_lam;   /* (nv), (nrow) initial accelerations and multipliers of coupled_mass.c */
    jo_real *lag, *sum;     /* (nv) forces of beams in the W-method; work space */
} jo_newton;

#endif
