/* force_data.h - values of signals and forces, and derivatives of states of forces. */
#ifndef JO_FORCE_DATA_H
#define JO_FORCE_DATA_H

#include "small.h"

typedef struct {
    jo_real value, rate, second;   /* value and its first and second derivatives with respect to time */
} jo_signal_work;

typedef struct {
    jo_real y[6];           /* force, N, and torque, N m, on b, world; along a coordinate: y[0] is the force */
    jo_real stored;         /* energy of its springs, J */
    jo_real stiffness, damping;   /* forces with states: -dF/ds, -dF/ds' at constant states */
} jo_force_work;

/* State x' = f of a force F along a coordinate s in the matrix of ROS2: dF/dx, -df/dx, df/ds, df/ds'. */
typedef struct { jo_real force, decay, value, rate; } jo_slopes_of_state;

#endif
