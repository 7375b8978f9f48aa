/* integrate_data.h - saved start of a step, and data of the step control. */
#ifndef JO_INTEGRATE_DATA_H
#define JO_INTEGRATE_DATA_H

#include "stage.h"
#include "valid_data.h"

/* State at the start of a step, for repetition of the step. */
typedef struct {
    jo_real time, drive;
    jo_work work, power, power0;
    double waiting;
    jo_valid valid;
    char *state;            /* copy of the arrays */
} jo_step_start;

/* Error control of the adaptive method, and its last step for dense output. */
typedef struct {
    double start;           /* time of the first row, s */
    double duration;        /* time from the first to the last row, s */
    double from, length;    /* start, s, and length, s, of the last step; the state is at from + length */
    double next;            /* planned length of the next step, s */
    double error;           /* error of the last accepted step / tolerance */
    jo_work work;           /* work at the start of the last step, J */
    long long tries;        /* tried steps since the last row */
    int shortened;          /* whether the last step that was tried was rejected */
    int found;              /* whether the last step ends at an event */
    int first;              /* no step yet: values at a threshold may cross it in either direction */
    int chain;              /* events since the last step without events */
    int status;             /* jo_status of the last failed evaluation, or JO_OK */
    int worst;              /* body with the largest error */
} jo_control;

/* The adaptive method: stages of its step, and scales of its errors. */
typedef struct {
    jo_real *stages;        /* (7 x (2 nw + 3)) rates of increments, velocities and work in a step; see also jo_kept_rates */
    jo_real *change;        /* (2 nw + 3) changes in the step */
    jo_real *q1, *v1, *lam1;   /* the state at the end of the step, saved while rows before the end are written */
    jo_real *defect[2];     /* (nv) estimated errors of increments and velocities of the bodies of a tree */
    double *extent;         /* (3 x nbody) largest speed, modal coordinates and their speed so far, (nstate) states */
    double *nominal;        /* (nstate) nominal values of states */
} jo_adaptive;

/* Generalised alpha: stored results at the end of its last step, and stored factors. */
typedef struct {
    jo_real *algorithmic, *end_a, *end_q, *end_v, *end_lam;   /* algorithmic and true accelerations, then the state */
    jo_real *end_time;      /* (1) */
    jo_real *change, *first_change, *change_lam;   /* changes of the algorithmic accelerations in the last step, and in that before a
                                                    * window of steps; of the multipliers in the last step */
    jo_real *estimate;      /* (4) of iteration_limit.c */
    jo_real *whole;         /* (nv + nrow) the increment that is being shortened */
    jo_weights weights;     /* weights with which N was factored */
    int forces_read;        /* whether sensors read forces, which then belong to the state at the end of each step */
    double aged;            /* largest rotation of a body since the factorisation, rad */
} jo_alpha;

/* Watched events and frictions, (jo_watched) each. */
typedef struct {
    jo_step_start start;
    jo_model watch;         /* the model with the watched sensors only */
    jo_sensor *list;        /* these */
    jo_real *measured;      /* (nout) their values */
    double instant;         /* time, s, within which impacts of a stop count as one instant */
    double *struck;         /* (2 nswitched) time of the last impact of each stop, and number of impacts in one instant */
    jo_real *rates;         /* (2 nv or 2 nu) velocities before an impact, and their change */
    double *level, *below, *above, *trial, *scale;   /* value less threshold, margin: at the start of the step, at the ends of the
                                                      * interval in which a crossing lies, between; change in the step */
    int *side;              /* sign of the value; 0 if it starts at the threshold */
    int *slip, *reversed;   /* (nfriction) slips before the transitions at the end of a step; whether a slip has reversed in it */
    double *since;          /* (nfriction) time from the end of a margin to the end of the step, s */
    struct jo_approach *near;   /* (2 nyielding) gaps at the start and at the end of the step */
    jo_proof proof;         /* how steps were proven to miss no contact */
    long long unproven;     /* steps in which a gap may have closed for a moment shorter than can be resolved */
    double doubts[JO_DOUBT * JO_MOST_DOUBTS];   /* the first of them, see jo_data_unproven */
    int demanding;          /* whether watched sensors need accelerations */
    int yields;             /* ends of branches of forces that yield, since the last step without any */
    double *log;            /* (jo_log_room x 3) time, event or nevent + friction, direction or slip */
    int logged;
} jo_events;

/* The grid of instants of jo_run, left by its last call. */
typedef struct {
    jo_real start;
    double step, left;      /* s; time at the end of the last call */
    long long count;
} jo_instants;

#endif
