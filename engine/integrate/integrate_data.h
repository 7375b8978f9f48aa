/* integrate_data.h - what the files of this room keep; other rooms reach it by the functions of integrate.h. */
#ifndef JO_INTEGRATE_DATA_H
#define JO_INTEGRATE_DATA_H

#include "small.h"
#include "valid_data.h"

/* What the start of a step was, to repeat it. */
typedef struct {
    jo_real time, drive;
    jo_work work, power, power0;
    double waiting;
    jo_valid valid;
    char *state;            /* copy of the arrays */
} jo_kept;

/* Error control of the adaptive method, and its last step for the dense output. */
typedef struct {
    double start;           /* time of the first row */
    double duration;        /* to the last row */
    double from, length;    /* the last step began at `from`; the state stands at from + length */
    double next;            /* length that the next step should have */
    double error;           /* of the last accepted step, 1 is what the tolerance allows */
    jo_work work;           /* at the start of the last step */
    long long tries;        /* since the last row */
    int shortened;          /* the last try was rejected */
    int found;              /* the last step ends at an event */
    int first;              /* no step yet: values at a threshold may leave it either way */
    int chain;              /* events since the last step without one */
    int status;             /* why it could not be evaluated, or JO_OK */
    int worst;              /* body with the largest error */
} jo_control;

#endif
