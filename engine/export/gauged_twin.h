/* gauged_twin.h - strains in, stress where no gauge is with its band, and damage out: without files, allocation and globals.
 *
 * A jo_plan is constant: modes, gains' equations, gauges, hot spots and S-N curve, as a Monitor in Python has them. A jo_twin
 * follows one machine in memory that the caller gives. All functions are re-entrant; different twins may run in different threads.
 *
 * The work of a step is bounded. It is least while the same gauges are well: gains that repeat are kept. A gauge that drops out,
 * and a pause of several steps, cost new gains: products of matrices (nx x nx), for a pause twice for each binary digit of it.
 */
#ifndef JO_GAUGED_TWIN_H
#define JO_GAUGED_TWIN_H

#include "jousto.h"

/* a number that goes in or comes out */
typedef struct { const char *name, *unit, *about; } jo_channel;

typedef enum {
    JO_TWIN_ALONE = 0,      /* each sample alone, as many gauges as modes */
    JO_TWIN_PRIOR = 1,      /* each sample alone, with the covariance of the modes */
    JO_TWIN_OBSERVER = 2    /* a Kalman filter with the equations of motion */
} jo_twin_method;

/* all arrays row-major; x = (modes below the limit, their rates, unknown loads, slopes of smooth ones, what gauges miss) */
typedef struct {
    const char *name;
    unsigned int mark;      /* checksum of the constants: memories of other twins are refused */
    int method;
    int moving, balanced;   /* whether the motion of the frame goes in; six equations of balance are rows of H after the gauges */
    int ngauge, nchannel, n, nx, nd, na, load_at;   /* nchannel: rows of H; n modes, nd with equations of motion, na loads */
    int nspot, nerror, kinds;                       /* columns of deviations by errors of gauges that stay; kinds of error */
    double step, jitter, gate, steady;              /* s; share of a step; standard deviations, 0: none; relative change */
    const double *F, *Gu, *Q, *P0;                  /* (nx x nx), (nx x nd) of one step; covariance at first */
    const double *H, *R;                            /* (nchannel x nx), (nchannel x nchannel) */
    const double *shape, *rates;                    /* (n x nx) modes and their rates of the state */
    const double *B, *rest, *stiffness;             /* (ngauge x n); (n) flexibility of modes that follow at once, else 0; (n) */
    const int *dynamic;                             /* (nd) modes with equations of motion */
    const double *errors;                           /* (kinds x ngauge x n) or 0 */
    const double *mean, *mean_force;                /* (na); (n) its modal force */
    const double *I3, *N0, *E, *arms, *wrenches;    /* (3 x n), (n x 9), (n x n x 9), (3 x na x n), (6 x na) */
    double mass, first_moment[3], inertia[9];
    /* stress at the hot spots */
    int linear, criterion, npoint, mises;           /* a weighted sum of components; jo_criterion; points of samples; von Mises */
    double criterion_scale, quantile, level, scale, bent, floor;   /* floor: the low end is not below 0 */
    const double *S, *missed;                       /* linear: (nspot x n), (nspot); else (nspot x 6 x n), (nspot x 6); variances */
    const double *points;                           /* (npoint x roots) normally distributed */
    /* damage */
    int metered, residue;
    jo_meter meter[3];                              /* value, low and high end of the band */
    double every, pause;                            /* s between means; steps that are no watched time */
    jo_health health;
    int ninput, noutput;
    const jo_channel *input, *output;
} jo_plan;

typedef struct jo_twin jo_twin;

enum { JO_TWIN_OK = 0,
       JO_TWIN_BLIND = 1,   /* too few gauges are left: the stress is NaN, it goes on by itself when they are back */
       JO_TWIN_CLOCK = 2,   /* the time is not later than the last, or no multiple of the step after it; nothing was taken */
       JO_TWIN_WRONG = 3,   /* numbers that are not finite where they must be; nothing was taken */
       JO_TWIN_FOREIGN = 4  /* a saved memory of another twin or version, half written or damaged; nothing was taken */
};

long long jo_twin_bytes(const jo_plan *p);                      /* of memory for one twin */
jo_twin *jo_twin_place(const jo_plan *p, void *memory, long long bytes);   /* before its first sample; 0 if the memory is too small */
void jo_twin_reset(jo_twin *k);
/* One sample. strain (ngauge): m/m, NaN where nothing was measured. motion (9), where the frame moves: acceleration of its origin
 * less gravity, m/s2, angular velocity, rad/s, and acceleration, rad/s2, in body axes; else 0. */
int jo_twin_step(jo_twin *k, double time, const double *strain, const double *motion);
const double *jo_twin_outputs(jo_twin *k);                      /* (noutput) as named in the header of the twin */
const unsigned char *jo_twin_states(const jo_twin *k);          /* (ngauge) jo_value of the last sample */
double jo_twin_time(const jo_twin *k);                          /* of the last sample, NaN before the first */

/* All that a twin remembers, for power cuts: version, mark, size and checksum come first. The steps after `load` are those that
 * would have followed `save`, to the last bit. Write to two places in turn, so that one is always whole. */
long long jo_twin_saved_bytes(const jo_twin *k);
void jo_twin_save(const jo_twin *k, unsigned char *buffer);
int jo_twin_load(jo_twin *k, const unsigned char *buffer, long long bytes);

#endif
