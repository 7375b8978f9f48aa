/* friction_data.h - what the files of this room keep; other rooms reach it by the functions of friction.h. */
#ifndef JO_FRICTION_DATA_H
#define JO_FRICTION_DATA_H

#include "small.h"

/* A friction that slides, with `count` forces from `first` on in the iteration. */
enum { JO_REACH = 8 };      /* that many forces at most have their effect on the reactions worked out beforehand */
typedef struct {
    int friction, first, count;
    jo_real press[2], collar[2];   /* its forces for a unit of what presses and of the moment of a collar */
    jo_real start[6], y[6]; /* reaction of its joint in the axes of side 0, without friction and with it */
    jo_real reach[JO_REACH][6];   /* what a unit of each force adds to it */
} jo_sliding_friction;

/* the iteration between friction forces f and their residual r, (2 nfriction) each */
enum { JO_PAIRS = 4 };      /* changes of f and r that it remembers */
typedef struct {
    jo_sliding_friction *sliding;     /* (nfriction) */
    int *coordinate;        /* (2 nfriction) of each force */
    int nsliding, n;         /* how many slide, with how many forces */
    jo_real *lam;           /* (nrow) multipliers without friction */
    jo_real *reach;         /* (JO_REACH x nrow) what a unit of each force adds to them */
    jo_real *f, *g, *r, *before, *change;
    jo_real *dF[JO_PAIRS], *dR[JO_PAIRS], *Q[JO_PAIRS];
    int pairs, newest;
} jo_anderson;

#endif
