/* beam_data.h - work arrays of a beam element. */
#ifndef JO_BEAM_DATA_H
#define JO_BEAM_DATA_H

#include "small.h"

enum { JO_BEAM_KEPT = 216 };   /* reals of stiffness (9 x 12) and damping (9 x 12) of an element for a Rosenbrock method */

/* Beam element; vectors resolved in the middle frame unless noted. */
typedef struct {
    jo_real B[2][4];        /* quaternions of the end frames on their bodies */
    /* whether B differs from E, u from 0 and beta from 0; whether the axis is helical, and whether the Wagner effect is included */
    int turned, offset, damped, helical, fibrous;
    jo_real Q[9];           /* orientation of the middle frame */
    jo_real G[2][9];        /* A^T Q: from the middle frame to the frames of the bodies */
    jo_real U[2][3];        /* positions u of the ends on the bodies, m */
    jo_real tau[3], square; /* tau = tan(phi/4) n of the rotation phi n between the ends; its square */
    jo_real mu, dmu;        /* H = E - mu tau~ tau~; dmu / d(tau^2) */
    jo_real d[3], e[6], rate[6], s[6];   /* Gamma + e1; strains [Gamma, kappa] - e0; their rates; resultants [N, M] */
    jo_real om[2][3], om_m[3], dv[3];    /* angular velocities of ends and middle; relative velocity of the ends */
    jo_real raw[6], f[6];   /* helical: rates of d and kappa; f: forces conjugate to d and kappa, otherwise the resultants */
    jo_real lean;           /* fibrous: Ip/A kappa_x, derivative of the mean fibre strain with respect to kappa_x */
    jo_real t[3], M[2][3];  /* L n x d; moments on the ends, N m */
    jo_real last[3];        /* tau at the last accepted state */
} jo_beam_work;

typedef struct {
    int count;
    jo_beam_work *work;     /* (nbeam) */
    double *bent;           /* (nbeam x 2) largest bending, rad, and largest tension ratio so far */
    jo_real *stiff;         /* (nbeam x JO_BEAM_KEPT) stiffness and damping stored by a Rosenbrock method */
} jo_beams;

#endif
