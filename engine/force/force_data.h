/* force_data.h - what the files of this room keep; other rooms reach it by the functions of force.h. */
#ifndef JO_FORCE_DATA_H
#define JO_FORCE_DATA_H

#include "small.h"

typedef struct {
    jo_real value, rate, second;   /* and its derivatives with respect to time */
} jo_signal_work;

typedef struct {
    jo_real y[6];           /* force and torque on b, world; ALONG_COORDINATE: the force first */
    jo_real stored;         /* J in its springs */
    jo_real stiffness, damping;   /* of forces with states: -dF/ds, -dF/ds' at the states */
} jo_force_work;

/* A state x' = f of a force F along a coordinate s, as ROS2 has it in its matrix: dF/dx, -df/dx, df/ds, df/ds'. */
typedef struct { jo_real force, decay, value, rate; } jo_slopes_of_state;

#endif
