/* rainflow.c - rainflow count of a complete history: closed cycles and residue of turning points (four-point rule). */
#include "fatigue/rainflow.h"

/* turning points on the stack `residue`; while the inner range of its last four points is closed, it is moved to `cycles` */
long long jo_rainflow(const double *x, long long count, double *cycles, long long *where, double *residue,
                      long long *residue_where, long long *length)
{
    long long n = 0, closed = 0;
    double *z = residue;
    long long *at = residue_where;
    for (long long i = 0; i < count; i++) {
        if (n && x[i] == z[n - 1]) continue;
        if (n < 2 || (x[i] > z[n - 1]) != (z[n - 1] > z[n - 2])) n++;
        z[n - 1] = x[i];
        at[n - 1] = i;
        while (n >= 4 && jo_closes(z + n - 4)) {
            for (int j = 0; j < 2; j++) {
                cycles[2 * closed + j] = z[n - 3 + j];
                where[2 * closed + j] = at[n - 3 + j];
            }
            closed++;
            z[n - 3] = z[n - 1];
            at[n - 3] = at[n - 1];
            n -= 2;
        }
    }
    *length = n;
    return closed;
}
