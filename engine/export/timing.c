/* timing.c - execution times of single steps of a machine on this computer: NAME steps [urgent]; prints a histogram, ns.
 *
 * urgent: requests real-time priority and locked memory, and prints the granted ones: 1 priority, 2 memory, 3 both. */
#define _POSIX_C_SOURCE 200112L
#include "plant.h"
#ifdef __linux__
#include <sched.h>
#include <sys/mman.h>
#endif
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { BINS = 400 };        /* bins of the histogram, each WIDTH times as wide as the previous one */
#define FIRST 100.0         /* upper edge of the first bin, ns */
#define WIDTH 1.05          /* ratio of the upper edges of a bin and the previous bin */
static union { double number; char bytes[PLANT_BYTES]; } memory;

enum { PRIORITY = 10 };     /* real-time priority, 1 .. 99, below that of device drivers */

static int hurry(void)
{
    int granted = 0;
#ifdef __linux__
    struct sched_param wish = {0};
    wish.sched_priority = PRIORITY;
    if (!sched_setscheduler(0, SCHED_FIFO, &wish)) granted |= 1;
    if (!mlockall(MCL_CURRENT | MCL_FUTURE)) granted |= 2;
#endif
    return granted;
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

int main(int argc, char **argv)
{
    static long counts[BINS];
    static double ends[BINS];
    const long steps = argc > 1 ? atol(argv[1]) : 100000;
    const long warm = steps / 10 < 1000 ? steps / 10 : 1000;   /* steps before the measurement, which fill the caches */
    jo_machine *machine = jo_machine_place(&PLANT, memory.bytes, (long long)sizeof memory.bytes);
    if (!machine || steps < 1) return 2;
    const int granted = argc > 2 ? hurry() : 0;
    ends[0] = FIRST;
    for (int i = 1; i < BINS; i++) ends[i] = WIDTH * ends[i - 1];
    double sum = 0.0, worst = 0.0;
    long done = 0;
    for (long k = -warm; k < steps; k++) {
        const double start = now();
        const int status = jo_machine_step(machine, 1);
        const double took = now() - start;
        if (status == JO_MACHINE_FAILED) return 1;
        if (status == JO_MACHINE_STOPPED) jo_machine_reset(machine);
        if (k < 0) continue;
        int bin = 0;
        while (bin < BINS - 1 && took > ends[bin]) bin++;
        counts[bin]++;
        sum += took;
        if (took > worst) worst = took;
        done++;
    }
    printf("%ld %.17g %.17g %lld %d %lld\n", done, sum, worst, jo_machine_bytes(&PLANT), granted,
           jo_data_counts(jo_machine_data(machine))->deferred);
    for (int i = 0; i < BINS; i++)
        if (counts[i]) printf("%.17g %ld\n", ends[i], counts[i]);
    return 0;
}
