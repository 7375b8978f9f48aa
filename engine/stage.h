/* stage.h - what an evaluation of the accelerations is for. */
#ifndef JO_STAGE_H
#define JO_STAGE_H

#include "newton/newton_data.h"

/* What an evaluation is for: the same for its forces, masses, multipliers and friction. All 0: the accelerations now. */
typedef struct {
    int set;                /* 1: effective modal masses E + g h D + (g h)^2 K, and the stiffness of beams is kept: ROS2 */
    double gh;              /* its g h */
    double lead;            /* forces act as they will be so much later: the time derivative in ROS2 */
    int second;             /* its second stage: from the accelerations of the first, whose factors serve again */
    int smooth;             /* friction is left out: the joints are being closed */
    double alpha, beta;     /* Baumgarte's terms, as of jo_solver */
    jo_weights weights;     /* of Newton's matrix */
} jo_stage;
static const jo_stage jo_now = {0};
static inline int jo_stabilised(const jo_stage *stage) { return stage->alpha != 0.0 || stage->beta != 0.0; }

#endif
