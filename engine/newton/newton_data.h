/* newton_data.h - data of the files of this folder: Newton's matrix, derivatives; other folders use the functions of newton.h. */
#ifndef JO_NEWTON_DATA_H
#define JO_NEWTON_DATA_H

#include "small.h"

enum { JO_SIX = 6, JO_ROW = 8 };   /* unknowns of a rigid body or of a node of a beam; length of a row of its block, padded */

/* Derivatives of the motion and of the loads of a marker. */
typedef struct {
    jo_real *L;             /* (6 x 6 + n) derivatives of [r, rotation], world, with respect to the coordinates of the body */
    jo_real *W;             /* (12 x 6 + n) derivatives of [r, rotation, velocity, angular velocity] with respect to Newton's unknowns */
    jo_real load[6];        /* sum of forces, N, and torques, N m, on the marker, world */
} jo_marker_tangent;

typedef struct {
    jo_real *N, *x;         /* (nnewton) Newton's matrix or its factors, (nv + nrow) right-hand side or solution */
    int *pivot;             /* (nv + nrow) row exchanges */
    int sparse;             /* whether most blocks are zero at a time, since sets of shapes touch */
    int *used, *row;        /* (branches) then whether the blocks of a branch contain numbers; scratch */
    double *unit, *unit_of_row;   /* (nv + nrow) units of the unknowns of N; the same in the order of the exchanged rows */
    jo_real *base, *base_lam;   /* (nv), (nrow) initial accelerations and multipliers of coupled_mass.c */
    jo_real *lag;           /* (nv) forces of beams in the W-method */
    jo_real *sum, *sum_lam; /* (nv), (nrow) sum of solutions of the iterative refinement; sum: also work space */
    jo_real *soft;          /* (nrow) regularisation, subtracted from the diagonal of N */
    jo_real *Dd, *H;        /* (6 x np), (3 x np) ED p', EB p'' of one body; np is that of the largest body */
    jo_real *chi_pd;        /* (3 x np) sum of chi_k p'_k of one marker */
    jo_marker_tangent *marker;   /* (nactive) */
} jo_newton;

#endif
