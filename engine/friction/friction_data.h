/* friction_data.h - work arrays of the iteration for friction forces. */
#ifndef JO_FRICTION_DATA_H
#define JO_FRICTION_DATA_H

#include "small.h"

/* Sliding friction with forces first .. first + count - 1 of the iteration. */
enum { JO_REACH = 8 };      /* largest number of forces whose influence on the reactions is computed in advance */
typedef struct {
    int friction, first, count;
    jo_real press[2], collar[2];   /* friction forces per unit normal force, and per unit torque of the collar */
    jo_real start[6], y[6]; /* reaction of the joint in the axes of side 0, without and with friction */
    jo_real reach[JO_REACH][6];   /* change of the reaction by a unit of each force */
} jo_sliding_friction;

/* Anderson acceleration of the fixed point f = g(f) of the friction forces; arrays (2 nfriction). */
enum { JO_PAIRS = 4 };      /* largest number of stored pairs of changes */
typedef struct {
    jo_sliding_friction *sliding;     /* (nfriction) */
    int *coordinate;        /* (2 nfriction) coordinate of each force */
    int *turns;             /* (nfriction) changes in one pass at the end of a step: 1 starts to slide, -1 sticks again */
    jo_work power;          /* powers, W, and power of the drives, W, before the last changes at the end of a step */
    jo_real drive;
    int nsliding, n;         /* number of sliding frictions and of their forces */
    double *share;          /* (njoint) locks of contacts: 1 / (mass N), over the sum of N of their body, 1/kg, by which they share; 0: none */
    int *first, *next;      /* (nbody), (nfriction) first contact of each bearing body, and the next one of the same body; -1: none */
    double *press;          /* (nbody) sum of N of the contacts of a body that stick, N */
    jo_real *lam;           /* (nrow) multipliers without friction */
    jo_real *reach;         /* (JO_REACH x nrow) change of the multipliers by a unit of each force */
    jo_real *f, *g, *r, *before, *change;   /* forces, g(f), residual g - f, residual before, change of f */
    jo_real *dF[JO_PAIRS], *dR[JO_PAIRS], *Q[JO_PAIRS];   /* changes of f and of r; orthonormal basis of the changes of r */
    int pairs, newest;      /* number of pairs, index of the newest */
} jo_anderson;

#endif
