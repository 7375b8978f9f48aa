/* gauged_twin.h - stress with confidence bands and damage at hot spots from measured strains, without files, allocation and global data.
 *
 * A jo_plan is constant: modes, equations of the gains, gauges, hot spots and S-N curve, as in a Monitor in Python. A jo_twin is one instance
 * in memory of the caller. All functions are re-entrant; different twins can run in different threads.
 *
 * The work of a step is bounded, and least while the same gauges are valid: gains that repeat are stored. A change of the valid gauges or a
 * pause of several steps requires new gains: products of matrices (nx x nx), for a pause two per binary digit of its number of steps.
 */
#ifndef JO_GAUGED_TWIN_H
#define JO_GAUGED_TWIN_H

#include "jousto.h"

/* Input or output. */
typedef struct { const char *name, *unit, *about; } jo_channel;

typedef enum {
    JO_TWIN_ALONE = 0,      /* each sample separately, at least as many gauges as modes */
    JO_TWIN_PRIOR = 1,      /* each sample separately, with the covariance of the modes */
    JO_TWIN_OBSERVER = 2    /* Kalman filter with the equations of motion */
} jo_twin_method;

/* Arrays row-major; x = (modes below the limit, their rates, unknown loads, slopes of smooth loads, model errors at the gauges). */
typedef struct {
    const char *name;
    unsigned int mark;      /* checksum of the constants, to reject memories of other twins */
    int method;
    int moving;             /* whether the motion of the frame is an input */
    int balanced;           /* whether six equilibrium equations are rows of H after the gauges */
    int ngauge, nchannel, n, nx, nd, na, load_at;   /* nchannel: rows of H; n modes, nd with equations of motion, na loads */
    int nspot, nerror, kinds;                       /* hot spots; columns of deviations by systematic gauge errors; kinds of these errors */
    double step, jitter;                            /* s; time tolerance / step */
    double gate, steady;                            /* limit of innovations / standard deviation, 0: none; relative change of steady gains */
    const double *F, *Gu, *Q, *P0;                  /* (nx x nx), (nx x nd) of one step; initial covariance */
    const double *H, *R;                            /* (nchannel x nx), (nchannel x nchannel) */
    const double *shape, *rates;                    /* (n x nx) modes and their rates of the state */
    const double *B, *rest, *stiffness;             /* (ngauge x n) strains; (n) flexibility of quasi-static modes, else 0; (n) stiffness */
    const int *dynamic;                             /* (nd) modes with equations of motion */
    const double *errors;                           /* (kinds x ngauge x n) or NULL */
    const double *mean, *mean_force;                /* (na) mean loads; (n) their modal force */
    const double *I3, *N0, *E, *arms, *wrenches;    /* (3 x n), (n x 9), (n x n x 9), (3 x na x n), (6 x na) */
    double mass, first_moment[3], inertia[9];
    /* stress at the hot spots: linear criterion, jo_criterion, number of samples, von Mises */
    int linear, criterion, npoint, mises;
    double criterion_scale, quantile, level, scale, bent, floor;   /* floor > 0: lower end of the band >= 0 */
    const double *S, *missed;                       /* linear: (nspot x n), (nspot); else (nspot x 6 x n), (nspot x 6); variances */
    const double *points;                           /* (npoint x roots) standard normal samples */
    /* damage */
    int metered, residue;
    jo_meter meter[3];                              /* value, lower and upper end of the band */
    double every, pause;                            /* s between means; gaps, in steps, that do not count as watched time */
    jo_health health;
    int ninput, noutput;
    const jo_channel *input, *output;
} jo_plan;

typedef struct jo_twin jo_twin;

enum { JO_TWIN_OK = 0,
       JO_TWIN_BLIND = 1,   /* too few valid gauges: stress is NaN until enough are valid again */
       JO_TWIN_CLOCK = 2,   /* time not after the last one, or not a multiple of the step after it; sample rejected */
       JO_TWIN_WRONG = 3,   /* a number is not finite; sample rejected */
       JO_TWIN_FOREIGN = 4  /* memory of another twin or version, incomplete or damaged; not loaded */
};

long long jo_twin_bytes(const jo_plan *p);                      /* memory for one twin, bytes */
jo_twin *jo_twin_place(const jo_plan *p, void *memory, long long bytes);   /* initial state; NULL if the memory is too small */
void jo_twin_reset(jo_twin *k);
/* One sample. strain (ngauge): m/m, NaN: missing. motion (9) of a moving frame: acceleration of its origin minus gravity, m/s2, angular
 * velocity, rad/s, angular acceleration, rad/s2, in body axes; otherwise NULL. */
int jo_twin_step(jo_twin *k, double time, const double *strain, const double *motion);
const double *jo_twin_outputs(jo_twin *k);                      /* (noutput), named in the header of the twin */
const unsigned char *jo_twin_states(const jo_twin *k);          /* (ngauge) jo_value of the last sample */
double jo_twin_time(const jo_twin *k);                          /* time of the last sample, s; NaN before the first one */

/* Complete memory of a twin with version, mark, size and checksum. Steps after `load` equal those after `save` bit for bit. Two alternating
 * places ensure that one is complete after a power failure. */
long long jo_twin_saved_bytes(const jo_twin *k);
void jo_twin_save(const jo_twin *k, unsigned char *buffer);
int jo_twin_load(jo_twin *k, const unsigned char *buffer, long long bytes);

#endif
