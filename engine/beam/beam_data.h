/* beam_data.h - work arrays of beam elements, JO_WIDTH elements side by side. */
#ifndef JO_BEAM_DATA_H
#define JO_BEAM_DATA_H

#include "small.h"

enum { JO_BEAM_BLOCK = 9, JO_BEAM_KEPT = 81 };   /* lanes of a 3 x 3 block; of the 3 x 3 blocks of a matrix of an element */

/* Kind of an element: terms that differ from 0. Coupled: C is not diagonal. */
enum {
    JO_BEAM_TURNED = 1,     /* end frames B of the bodies */
    JO_BEAM_OFFSET = 2,     /* positions u of the ends */
    JO_BEAM_DAMPED = 4,     /* damping beta */
    JO_BEAM_HELICAL = 8,    /* helical axis (beam_helix.c) */
    JO_BEAM_FIBROUS = 16,   /* Wagner effect (beam_fibre.c) */
    JO_BEAM_COUPLED = 32,
    JO_BEAM_KINDS = 64
};

/* Elements of one kind, an element in each lane; vectors resolved in the middle frame unless noted. Lanes without an element repeat the
 * first one and are not added to the bodies. */
typedef struct {
    int kind, count;        /* count: number of elements */
    int element[JO_WIDTH];
    struct { jo_real *at; int stride; } newton[2][2][JO_WIDTH];   /* blocks of Newton's matrix: rows of end i, columns of end j */
    int body[2][JO_WIDTH], iq[2][JO_WIDTH], iv[2][JO_WIDTH];   /* bodies of the ends, their first entries in q and v */
    /* constants, see jo_beam_data */
    jo_lanes length, inverse_length, beta, polar, limit, C[36], e0[6], u[2][3], B[2][9];
    jo_lanes b[2][4];       /* quaternions of B */
    jo_lanes light, easy[2];   /* 1/m of both bodies together, 1/kg; 1/tr(J) of each, 1/(kg m2); 0 in lanes without an element */
    /* at the present state */
    jo_lanes Q[9];          /* orientation of the middle frame */
    jo_lanes G[2][9];       /* A^T Q: from the middle frame to the frames of the bodies */
    jo_lanes U[2][3];       /* positions u of the ends on the bodies, m */
    jo_lanes tau[3], square, cosine;   /* tau = tan(phi/4) n of the rotation phi n between the ends; its square; cos(phi/2) */
    jo_lanes mu, dmu;       /* H = E - mu tau~ tau~; dmu / d(tau^2) */
    jo_lanes d[3], e[6], rate[6], s[6];   /* Gamma + e1; strains [Gamma, kappa] - e0; their rates; resultants [N, M] */
    jo_lanes om[2][3], om_m[3], dv[3];    /* angular velocities of ends and middle; relative velocity of the ends */
    jo_lanes raw[6], f[6];  /* helical: rates of d and kappa; f: forces conjugate to d and kappa, otherwise the resultants */
    jo_lanes psi[3], k[3];  /* helical: L kappa / 2; k, k', k'' at its square */
    jo_lanes lean;          /* fibrous: Ip/A kappa_x, derivative of the mean fibre strain with respect to kappa_x */
    jo_lanes t[3], M[2][3]; /* L n x d; moments on the ends, N m */
    jo_lanes last[3];       /* tau at the last accepted state */
} jo_beam_group;

typedef struct {
    int count, groups;      /* number of elements, of groups */
    jo_beam_group *group;
    int *place;             /* (nbeam) JO_WIDTH group + lane of an element */
    double *bent;           /* (nbeam x 2) largest bending, rad, and largest tension ratio so far */
    jo_lanes *stiff;        /* (groups x 2 JO_BEAM_KEPT) stiffness and damping stored by a Rosenbrock method */
} jo_beams;

#endif
