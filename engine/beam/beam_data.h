/* beam_data.h - what the files of this room keep; other rooms reach it by the functions of beam.h. */
#ifndef JO_BEAM_DATA_H
#define JO_BEAM_DATA_H

#include "small.h"

enum { JO_BEAM_KEPT = 216 };   /* reals of the stiffness and damping of a beam element that ROS2 keeps */

/* A beam element; vectors resolved in the frame of its middle unless said otherwise. */
typedef struct {
    jo_real B[2][4];        /* quaternions of the end frames on their bodies */
    int turned, offset, damped, helical, fibrous;   /* B, u, beta are not trivial; a screw line; twist stretches fibres */
    jo_real Q[9];           /* orientation of the middle frame */
    jo_real G[2][9];        /* A^T Q of the bodies */
    jo_real U[2][3];        /* levers u */
    jo_real tau[3], square; /* Rodrigues' parameters of half the rotation between the ends, their square */
    jo_real mu, dmu;        /* H = E - mu tau~ tau~, and its change with the square */
    jo_real d[3], e[6], rate[6], s[6];   /* Gamma + e1; strains, their rates, resultants */
    jo_real om[2][3], om_m[3], dv[3];    /* angular velocities of the ends and the middle, relative velocity of the ends */
    jo_real raw[6], f[6];   /* helical: rates of d and kappa; conjugate to d and kappa, else the resultants */
    jo_real lean;           /* fibrous: Ip/A kappa_x, how twist stretches the fibres */
    jo_real t[3], M[2][3];  /* L n x d; moments on the ends */
    jo_real last[3];        /* tau of the last accepted state */
} jo_beam_work;

typedef struct {
    int count;
    jo_beam_work *work;     /* (nbeam) */
    double *bent;           /* (nbeam x 2) largest bending, rad, and tension so far */
    jo_real *stiff;         /* (nbeam x JO_BEAM_KEPT) stiffness and damping that ROS2 keeps */
} jo_beams;

#endif
