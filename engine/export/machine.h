/* machine.h - a compiled mechanism as a program part without files, allocation and globals.
 *
 * A jo_plant is constant: the model, its method, and the names of what goes in and comes out. A jo_machine is one running
 * copy of it in memory that the caller gives. All functions are re-entrant; different machines may run in different threads.
 */
#ifndef JO_MACHINE_H
#define JO_MACHINE_H

#include "jousto.h"

/* a number that goes in or comes out */
typedef struct {
    const char *name, *unit, *about;
    int place;              /* among the inputs, the sensor values or the tunable numbers */
    double start;           /* value at the beginning; 0 of outputs, which are computed */
} jo_port;

/* a parameter that stands for several tunable numbers: tunable[place] = offset + factor value */
typedef struct { int parameter, place; double factor, offset; } jo_named_link;

typedef struct {
    const char *name;
    const jo_model *model;
    const jo_solver *solver;
    const jo_real *q0, *v0, *x0; /* where it starts; x0 (nstate) of forces, 0: none */
    int ntunable;
    const jo_real *tunable; /* (ntunable) gravity, and data of forces, frictions and signals: copied for each machine */
    int ninput, noutput, nparameter;
    const jo_port *input, *output, *parameter;
    int nlink;
    const jo_named_link *link;
} jo_plant;

typedef struct jo_machine jo_machine;

enum { JO_MACHINE_OK = 0, JO_MACHINE_STOPPED = 1, JO_MACHINE_FAILED = 2, JO_MACHINE_WRONG = 3 };

long long jo_machine_bytes(const jo_plant *p);                   /* of memory for one machine */
jo_machine *jo_machine_place(const jo_plant *p, void *memory, long long bytes);   /* at its start; 0 if the memory is too small */
const jo_plant *jo_machine_plant(const jo_machine *k);
jo_data *jo_machine_data(jo_machine *k);
int jo_machine_reset(jo_machine *k);                             /* to the start, with inputs and parameters as at first */
int jo_machine_step(jo_machine *k, long long count);             /* steps of the method; STOPPED at an event that stops */
double jo_machine_time(const jo_machine *k);
double jo_machine_step_size(const jo_machine *k);
int jo_machine_set_step_size(jo_machine *k, double step);        /* s, above 0 */
int jo_machine_set_input(jo_machine *k, int input, double value);     /* held until it is set again; finite */
double jo_machine_get_input(const jo_machine *k, int input);
int jo_machine_set_parameter(jo_machine *k, int parameter, double value);
double jo_machine_get_parameter(const jo_machine *k, int parameter);
int jo_machine_get_output(jo_machine *k, int output, double *value);
int jo_machine_update(jo_machine *k);                            /* outputs of the present state, after it or an input was changed */
const jo_real *jo_machine_outputs(jo_machine *k);                /* (nout) all sensor values after jo_machine_update; 0 if it failed */
int jo_machine_error(const jo_machine *k);                       /* jo_status of the last failure */
int jo_machine_error_index(const jo_machine *k);

/* For integrators of somebody else's: states [q v x], x those of forces, their rates with joints drawn together by Baumgarte's terms of this rate, 1/s.
 * A machine that steps itself in joint coordinates is to be told so first. */
void jo_machine_in_bodies(jo_machine *k);                        /* from its start in q and v, like any machine */
int jo_machine_states(const jo_machine *k);                      /* nq + nv + nstate */
void jo_machine_get_states(const jo_machine *k, double *x);
int jo_machine_set_states(jo_machine *k, double time, const double *x);   /* Euler parameters are made unit vectors */
int jo_machine_rates(jo_machine *k, double rate, jo_real *xdot);
jo_real *jo_machine_tunable(jo_machine *k);                      /* (ntunable); then jo_machine_changed */
void jo_machine_changed(jo_machine *k);                          /* tunable numbers or states were written over */
void jo_machine_count(jo_machine *k);                            /* whole turns of angles: at each state that is kept */

/* All that a machine remembers, as numbers without addresses: for power cuts and for going back. */
int jo_machine_state_size(const jo_machine *k);                  /* doubles */
int jo_machine_save(jo_machine *k, double *state);
int jo_machine_load(jo_machine *k, const double *state);         /* WRONG if it is not finite, not of this plant, or impossible */

#endif
