/* real_time_pace.c - execution of steps in real time (wall clock), without calls of the caller in between. */
#ifndef _WIN32
#define _POSIX_C_SOURCE 200112L
#endif
#include "integrate/integrate.h"

#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#include <windows.h>

static double watch(void)
{
    LARGE_INTEGER now, rate;
    QueryPerformanceCounter(&now);
    QueryPerformanceFrequency(&rate);
    return (double)now.QuadPart / (double)rate.QuadPart;
}

/* sleep has a resolution of milliseconds, so the last millisecond is busy waiting */
static void pause_for(double seconds)
{
    const double awake = 2e-3;   /* waiting time, s, below which the thread only yields */
    Sleep(seconds > awake ? (DWORD)(1e3 * seconds - 1.0) : 0);
}
#else
#include <time.h>

static double watch(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void pause_for(double seconds)
{
    struct timespec length;
    length.tv_sec = (time_t)seconds;
    length.tv_nsec = (long)(1e9 * (seconds - (double)length.tv_sec));
    nanosleep(&length, NULL);
}
#endif

/* wait until `due`, s, and enter the lateness into the histogram; returns the time */
static double wait_until(jo_pace *p, double due, int nedge, const double *edge, long long *late)
{
    double now = watch();
    while (now < due) {
        pause_for(due - now);
        now = watch();
    }
    int interval = 0;
    while (interval < nedge && now - due >= edge[interval]) interval++;
    late[interval]++;
    if (now - due > p->latest) p->latest = now - due;
    return now;
}

int jo_paced(const jo_model *m, jo_data *d, const jo_solver *s, jo_pace *p, int nsteps, int nedge, const double *edge,
             long long *late, long long every, long long *count, int *written, jo_real *rows)
{
    const size_t size = (size_t)jo_row_size(m);
    double due = watch() + p->ahead;
    int status = JO_OK, total = 0;
    p->done = 0;
    while (status == JO_OK && p->done < nsteps) {
        const double began = wait_until(p, due, nedge, edge, late);
        status = jo_run(m, d, s, 1, every, count, written, rows + (size_t)total * size);
        total += *written;
        const double ended = watch();
        due += p->step;
        p->done++;
        p->missed += ended > due;
        if (ended - began > p->worst) p->worst = ended - began;
        /* return, since the log covers one call of jo_run only; a large lateness needs a new schedule */
        if (jo_data_logged(d) || ended - due > p->farthest) break;
    }
    *written = total;
    p->ahead = due - watch();
    return status;
}
