/* machine.h - a compiled mechanism as a component without files, allocation and global data.
 *
 * A jo_plant is constant: model, solver, names of inputs, outputs and parameters. A jo_machine is one instance in memory of the caller. All
 * functions are re-entrant; different machines can run in different threads.
 */
#ifndef JO_MACHINE_H
#define JO_MACHINE_H

#include "jousto.h"

/* Input, output or parameter. */
typedef struct {
    const char *name, *unit, *about;
    int place;              /* index among the inputs, sensor values or tunable numbers */
    double start;           /* initial value; 0 for outputs */
} jo_port;

/* Parameter with several tunable numbers: tunable[place] = offset + factor value. */
typedef struct { int parameter, place; double factor, offset; } jo_named_link;

typedef struct {
    const char *name;
    const jo_model *model;
    const jo_solver *solver;
    const jo_real *q0, *v0, *x0; /* initial state (nq), (nv); (nstate) of forces, NULL: none */
    int ntunable;
    const jo_real *tunable; /* (ntunable) gravity, data of forces, frictions and signals; copied for each machine */
    int ninput, noutput, nparameter;
    const jo_port *input, *output, *parameter;
    int nlink;
    const jo_named_link *link;
} jo_plant;

typedef struct jo_machine jo_machine;

enum { JO_MACHINE_OK = 0, JO_MACHINE_STOPPED = 1, JO_MACHINE_FAILED = 2, JO_MACHINE_WRONG = 3 };

long long jo_machine_bytes(const jo_plant *p);                   /* memory for one machine, bytes */
jo_machine *jo_machine_place(const jo_plant *p, void *memory, long long bytes);   /* in its initial state; NULL if the memory is too small */
const jo_plant *jo_machine_plant(const jo_machine *k);
jo_data *jo_machine_data(jo_machine *k);
int jo_machine_reset(jo_machine *k);                             /* initial state, inputs and parameters */
int jo_machine_step(jo_machine *k, long long count);             /* `count` steps; JO_MACHINE_STOPPED at an event that ends the run */
double jo_machine_time(const jo_machine *k);
double jo_machine_step_size(const jo_machine *k);
int jo_machine_set_step_size(jo_machine *k, double step);        /* step > 0, s */
int jo_machine_set_input(jo_machine *k, int input, double value);     /* finite; constant until the next call */
double jo_machine_get_input(const jo_machine *k, int input);
int jo_machine_set_parameter(jo_machine *k, int parameter, double value);
double jo_machine_get_parameter(const jo_machine *k, int parameter);
int jo_machine_get_output(jo_machine *k, int output, double *value);
int jo_machine_update(jo_machine *k);                            /* outputs of the present state, after a change of state or inputs */
const jo_real *jo_machine_outputs(jo_machine *k);                /* (nout) all sensor values, after jo_machine_update; NULL on failure */
int jo_machine_error(const jo_machine *k);                       /* jo_status of the last failure */
int jo_machine_error_index(const jo_machine *k);

/* For integrators of the caller: states [q v x], x of forces, and their rates with Baumgarte terms alpha = beta = rate, 1/s. Machines with
 * trees require jo_machine_in_bodies first. */
void jo_machine_in_bodies(jo_machine *k);                        /* initial state, without joint coordinates */
int jo_machine_states(const jo_machine *k);                      /* nq + nv + nstate */
void jo_machine_get_states(const jo_machine *k, double *x);
int jo_machine_set_states(jo_machine *k, double time, const double *x);   /* Euler parameters are normalised */
int jo_machine_rates(jo_machine *k, double rate, jo_real *xdot);
jo_real *jo_machine_tunable(jo_machine *k);                      /* (ntunable); call jo_machine_changed after a change */
void jo_machine_changed(jo_machine *k);                          /* after a change of tunable numbers or states */
void jo_machine_count(jo_machine *k);                            /* counted angles, at each accepted state */

/* Complete state of a machine as numbers without addresses, to continue after a power failure or from an earlier state. */
int jo_machine_state_size(const jo_machine *k);                  /* doubles */
int jo_machine_save(jo_machine *k, double *state);
int jo_machine_load(jo_machine *k, const double *state);         /* JO_MACHINE_WRONG if not finite, of another plant, or inconsistent */

#endif
