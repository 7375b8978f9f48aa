/* main.c - program that runs a machine and prints its outputs: NAME [seconds [rows]] */
#include "plant.h"
#if !defined(JO_ONE_FILE) || defined(MAIN)
#include <stdio.h>
#include <stdlib.h>

static union { double number; char bytes[PLANT_BYTES]; } memory;   /* memory of the machine */

int main(int argc, char **argv)
{
    const double seconds = argc > 1 ? atof(argv[1]) : 1.0;
    const long rows = argc > 2 ? atol(argv[2]) : 10;
    const jo_plant *plant = &PLANT;
    jo_machine *machine = jo_machine_place(plant, memory.bytes, (long long)sizeof memory.bytes);
    if (!machine || !(seconds >= 0.0) || rows < 1) {
        fprintf(stderr, "usage: %s [SECONDS [ROWS]], such as 2 100: a time from 0 on, at least one row\n", argv[0]);
        return 2;
    }
    const double h = jo_machine_step_size(machine);
    const long long steps = (long long)(seconds / h + 0.5);
    printf("time");
    for (int i = 0; i < plant->noutput; i++) printf(",%s (%s)", plant->output[i].name, plant->output[i].unit);
    printf("\n");
    long long done = 0;
    for (long k = 0; k <= rows; k++) {
        const long long goal = steps * k / rows;
        const int status = jo_machine_step(machine, goal - done);
        done = goal;
        const double *y = jo_machine_outputs(machine);
        if (status == JO_MACHINE_FAILED || !y) {
            fprintf(stderr, "%s: stopped at %g s with status %d at object %d\n", plant->name, jo_machine_time(machine),
                    jo_machine_error(machine), jo_machine_error_index(machine));
            return 1;
        }
        printf("%.17g", jo_machine_time(machine));
        for (int i = 0; i < plant->noutput; i++) printf(",%.17g", y[plant->output[i].place]);
        printf("\n");
        if (status == JO_MACHINE_STOPPED) break;
    }
    return 0;
}
#else
typedef int jo_no_main;   /* a source file must not be empty */
#endif
