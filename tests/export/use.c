/* A program with two exported machines: returns 0, or the number of the check that fails. */
#include "arm.h"
#include <stdio.h>
#include <string.h>

static char first[ARM_BYTES], second[ARM_BYTES + 8];
static double state[100000], other[100000];

static double zero(void) { return 0.0; }

int main(void)
{
    jo_machine *a = jo_machine_place(&arm_plant, first, sizeof first);
    jo_machine *b = jo_machine_place(&arm_plant, second + 8, ARM_BYTES);   /* at any address */
    if (!a || !b || jo_machine_place(&arm_plant, first, 1000)) return 1;
    if (jo_machine_bytes(&arm_plant) > ARM_BYTES) return 2;
    /* two machines, interleaved */
    for (int i = 0; i < 50; i++) if (jo_machine_step(a, 1) || jo_machine_step(b, 1)) return 3;
    if (memcmp(jo_machine_outputs(a), jo_machine_outputs(b), sizeof(double) * arm_outputs)) return 4;
    /* saved in mid-run, gone on with, gone back to */
    if (jo_machine_state_size(a) > 100000 || jo_machine_save(a, state)) return 5;
    if (jo_machine_step(a, 100) || jo_machine_load(b, state) || jo_machine_step(b, 100)) return 6;
    if (memcmp(jo_machine_outputs(a), jo_machine_outputs(b), sizeof(double) * arm_outputs)) return 7;
    /* inputs and parameters are of one machine, and checked */
    double before, after;
    if (jo_machine_set_parameter(b, arm_parameter_spring_stiffness, 3e3)) return 8;
    if (jo_machine_get_parameter(a, arm_parameter_spring_stiffness) != 300.0) return 9;
    if (jo_machine_set_input(b, arm_input_push, 5.0) || jo_machine_get_input(a, arm_input_push) != 1.5) return 10;
    jo_machine_step(a, 50);
    jo_machine_step(b, 50);
    jo_machine_get_output(a, arm_output_tip_z, &before);
    jo_machine_get_output(b, arm_output_tip_z, &after);
    if (!(after > before)) return 11;
    if (jo_machine_set_input(a, 7, 1.0) != JO_MACHINE_WRONG || jo_machine_set_input(a, 0, 0.0 / zero()) != JO_MACHINE_WRONG) return 12;
    if (jo_machine_get_output(a, -1, &before) != JO_MACHINE_WRONG) return 13;
    if (jo_machine_set_step_size(a, 0.0) != JO_MACHINE_WRONG) return 14;
    /* damaged states are refused */
    jo_machine_save(a, other);
    for (int i = 0; i < 2; i++) {
        double kept = other[i];
        other[i] += 1.0;
        if (jo_machine_load(a, other) != JO_MACHINE_WRONG) return 15;
        other[i] = kept;
    }
    jo_machine_reset(a);
    jo_machine_place(&arm_plant, second + 8, ARM_BYTES);
    if (memcmp(jo_machine_outputs(a), jo_machine_outputs(b), sizeof(double) * arm_outputs)) return 16;
    return 0;
}
