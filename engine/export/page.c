/* page.c - one machine for a page in a browser: WebAssembly without imports. Numbers are passed singly, arrays by their addresses in the
 * memory of the module; SI units. */
#include "plant.h"

#define EXPORT(name) __attribute__((export_name(#name))) name

static union { double number; char bytes[PLANT_BYTES]; } memory;
static jo_machine *machine;

int EXPORT(start)(void)
{
    machine = jo_machine_place(&PLANT, memory.bytes, (long long)sizeof memory.bytes);
    return machine ? JO_MACHINE_OK : JO_MACHINE_WRONG;
}
int EXPORT(reset)(void) { return jo_machine_reset(machine); }
int EXPORT(advance)(int steps) { return jo_machine_step(machine, steps); }
int EXPORT(set_input)(int k, double value) { return jo_machine_set_input(machine, k, value); }
int EXPORT(set_parameter)(int k, double value) { return jo_machine_set_parameter(machine, k, value); }
double EXPORT(now)(void) { return jo_machine_time(machine); }
int EXPORT(error)(void) { return jo_machine_error(machine); }
int EXPORT(error_index)(void) { return jo_machine_error_index(machine); }

const double *EXPORT(positions)(void) { return jo_data_q(jo_machine_data(machine)); }       /* (nq) */
const double *EXPORT(velocities)(void) { return jo_data_v(jo_machine_data(machine)); }      /* (nv) */
const double *EXPORT(outputs)(void) { return jo_machine_outputs(machine); }                 /* (nout); NULL on failure */
