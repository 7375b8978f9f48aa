/* fmu.h - instance of a functional mock-up unit, common to both versions of the standard (FMI 2.0.4, FMI 3.0.2).
 *
 * Value references: 0: time; then inputs, outputs and parameters of the plant in their order; for model exchange then the states [q v] and
 * their derivatives.
 */
#ifndef JO_FMU_H
#define JO_FMU_H

#include "machine.h"
#include <stddef.h>

typedef enum { JO_FMU_OK = 0, JO_FMU_WARNING = 1, JO_FMU_DISCARD = 2, JO_FMU_ERROR = 3, JO_FMU_FATAL = 4 } jo_fmu_status;

/* states of an instance as bits, for masks of the states in which a function is allowed */
enum { JO_FMU_MADE = 1, JO_FMU_INITIALISING = 2, JO_FMU_EVENTS = 4, JO_FMU_CONTINUOUS = 8, JO_FMU_STEPS = 16, JO_FMU_ENDED = 32,
       JO_FMU_BROKEN = 64 };

enum { JO_FMU_MESSAGE = 400 };   /* largest length of a message, bytes */

typedef struct jo_fmu jo_fmu;
typedef void (*jo_fmu_log)(void *host, int status, const char *category, const char *text);
struct jo_fmu {
    jo_machine *machine;
    int mode;
    int exchange;           /* 1: model exchange, 0: co-simulation */
    int logging;
    int first;              /* whether the next step is the first one after initialisation */
    double start, stop;     /* start and stop time, s; stop 0: none */
    int has_stop;
    double *scratch;        /* work space: states and their derivatives */
    int current;            /* whether scratch has the derivatives of the present states */
    jo_fmu_log log;
    void *host;             /* argument of log */
    void *more;             /* data of the FMI version */
};

jo_fmu *jo_fmu_make(const char *name, const char *token, int exchange, int logging, jo_fmu_log log, void *host);
void jo_fmu_free(jo_fmu *f);
int jo_fmu_may(jo_fmu *f, const char *function, int modes);      /* whether the function is allowed now; logs the reason otherwise */
int jo_fmu_say(jo_fmu *f, int status, const char *format, ...);  /* logs and returns the status */
int jo_fmu_setup(jo_fmu *f, double start, int has_stop, double stop);
int jo_fmu_reset(jo_fmu *f);
int jo_fmu_get(jo_fmu *f, const unsigned *refs, size_t count, double *values);
int jo_fmu_set(jo_fmu *f, const unsigned *refs, size_t count, const double *values);
/* steps to time + length; reached: time reached, s; early: whether an event ended the run before */
int jo_fmu_advance(jo_fmu *f, double time, double length, int *early, double *reached);
int jo_fmu_rates(jo_fmu *f, double *xdot);

/* Saved states in separate memory, as in both versions of the standard; allocated if `state` is NULL. A state contains its size and kind
 * (model exchange or co-simulation); an instance accepts states of its kind only. */
int jo_fmu_take(jo_fmu *f, void **state);
int jo_fmu_give(jo_fmu *f, const void *state);
size_t jo_fmu_bytes(const void *state);
int jo_fmu_release(void **state);
int jo_fmu_write(jo_fmu *f, const void *state, void *bytes, size_t size);
int jo_fmu_read(jo_fmu *f, const void *bytes, size_t size, void **state);

/* Directional derivative of `unknowns` along `seed` of `knowns`; an error in units built without it. */
int jo_fmu_slope(jo_fmu *f, const unsigned *unknowns, size_t nunknown, const unsigned *knowns, size_t nknown, const double *seed,
                 double *change);

/* Model exchange: the importer sets time and states. */
int jo_fmu_set_time(jo_fmu *f, double time);
int jo_fmu_count_states(jo_fmu *f, size_t count);                /* whether the number of states is `count` */
int jo_fmu_set_states(jo_fmu *f, const double *states, size_t count);

#endif
