/* integrate_data.h - saved start of a step, and data of the step control. */
#ifndef JO_INTEGRATE_DATA_H
#define JO_INTEGRATE_DATA_H

#include "small.h"
#include "valid_data.h"

/* State at the start of a step, for repetition of the step. */
typedef struct {
    jo_real time, drive;
    jo_work work, power, power0;
    double waiting;
    jo_valid valid;
    char *state;            /* copy of the arrays */
} jo_kept;

/* Error control of the adaptive method, and its last step for dense output. */
typedef struct {
    double start;           /* time of the first row, s */
    double duration;        /* time from the first to the last row, s */
    double from, length;    /* start, s, and length, s, of the last step; the state is at from + length */
    double next;            /* planned length of the next step, s */
    double error;           /* error of the last accepted step / tolerance */
    jo_work work;           /* work at the start of the last step, J */
    long long tries;        /* tried steps since the last row */
    int shortened;          /* whether the last tried step was rejected */
    int found;              /* whether the last step ends at an event */
    int first;              /* no step yet: values at a threshold may cross it in both directions */
    int chain;              /* events since the last step without events */
    int status;             /* jo_status of the last failed evaluation, or JO_OK */
    int worst;              /* body with the largest error */
} jo_control;

#endif
