/* stage.h - purpose of an evaluation of the accelerations: stage of a method, lead of the forces, stabilisation. */
#ifndef JO_STAGE_H
#define JO_STAGE_H

#include "small.h"

/* Effect of one unknown of Newton's matrix, an acceleration: accelerations change by a, velocities by v, increments of the position by q.
 * The rows of the joints are those of C' times rows, or those of C. */
typedef struct {
    double a, v, q, rows;
    int position;           /* rows of C instead of C' */
    int plain;              /* inertia forces depend on accelerations only */
} jo_weights;

/* Parameters of an evaluation. All 0: the accelerations at the present state. */
typedef struct {
    int set;                /* 1: stage of a Rosenbrock method, with effective modal masses E + g h D + (g h)^2 K */
    double gh;              /* its g h, s */
    double lead;            /* lead of the forces, s: the matrix of the method contains their time derivative */
    int earlier;            /* number of earlier stages; the matrix uses the stiffness of beams and joint coordinates of the first stage */
    const double *rate, *acceleration;   /* (earlier) -s_ij and -z_ij of step_rosenbrock.c */
    const jo_real *rates[JO_MOST_STAGES], *accelerations[JO_MOST_STAGES];   /* (earlier) rates of increments and of velocities, (nw) each */
    int contacts;           /* whether its matrix contains contacts or networks */
    int separate;           /* whether these are networks that follow after the accelerations without their part, network_response.c */
    int second;             /* second stage of ROS2 with beams or contacts: solved for the change from the accelerations of stage 1, with its factors */
    int smooth;             /* whether friction is left out, for the assembly of the joints */
    double alpha, beta;     /* Baumgarte, 1/s, as in jo_solver */
    jo_weights weights;     /* weights of Newton's matrix */
} jo_stage;
static const jo_stage jo_now = {0};
static inline int jo_stabilised(const jo_stage *stage) { return stage->alpha != 0.0 || stage->beta != 0.0; }

#endif
