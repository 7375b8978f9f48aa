/* channel_health.c - validity of each sample of measured channels.
 *
 * Stuck: identical value while other channels change. Spike: jump far beyond the mean step, until `persist` samples stay at the new level.
 * After a failure `back` valid samples are required. */
#include "jousto.h"
#include <math.h>

#define MIN_STEP 1e-12  /* smallest usual step between samples, unit of the channel, since the steps of a constant channel are 0 */
#define STEP_CAP 4.0    /* ratio of a step and the usual step up to which the step enters the mean */

static double smaller(double a, double b) { return a < b ? a : b; }
static double larger(double a, double b) { return a > b ? a : b; }

/* state of a single value: saturated, missing, not a number, or valid */
static int plain(const jo_health *r, double x, int cell)
{
    if (cell == r->infinite || isinf(x) || (isfinite(x) && fabs(x) >= r->range)) return JO_VALUE_SATURATED;
    if (cell == r->empty) return JO_VALUE_DROPOUT;
    return isfinite(x) ? JO_VALUE_OK : JO_VALUE_NAN;
}

/* state of sample x of one channel with the memory m, which is updated */
static int channel(const jo_health *r, double *m, long long n, double x, int state, int before, int others)
{
    const int there = isfinite(x), same = there && x == m[JO_HEALTH_LAST * n];
    m[JO_HEALTH_SAME * n] = same ? m[JO_HEALTH_SAME * n] + 1.0 : 0.0;
    m[JO_HEALTH_MOVES * n] = same ? m[JO_HEALTH_MOVES * n] + (others ? 1.0 : 0.0) : 0.0;
    if (r->stuck && state == JO_VALUE_OK && m[JO_HEALTH_MOVES * n] >= r->stuck) state = JO_VALUE_STUCK;

    const double step = fabs(x - m[JO_HEALTH_GOOD * n]), seen = m[JO_HEALTH_SEEN * n], usual = m[JO_HEALTH_USUAL * n];
    const int known = seen >= r->warm;
    if (r->spike > 0.0) {
        const double limit = r->spike * larger(usual, MIN_STEP);
        const int jump = known && state == JO_VALUE_OK && isfinite(step) && step > limit;
        const int near = isfinite(m[JO_HEALTH_LAST * n]) && fabs(x - m[JO_HEALTH_LAST * n]) <= limit;
        m[JO_HEALTH_LEVEL * n] = !jump ? 0.0 : near ? m[JO_HEALTH_LEVEL * n] + 1.0 : 1.0;
        if (jump && m[JO_HEALTH_LEVEL * n] < r->persist) state = JO_VALUE_SPIKE;
    }
    const int good = state == JO_VALUE_OK;
    if (good && isfinite(step)) {
        /* limit: a valid jump must not raise the mean step so much that the next jump is not detected */
        const double capped = known ? smaller(step, STEP_CAP * usual + MIN_STEP) : step;
        m[JO_HEALTH_USUAL * n] = usual + larger(r->follow, 1.0 / (1.0 + seen)) * (capped - usual);
        m[JO_HEALTH_SEEN * n] = seen + 1.0;
    }
    if (good) m[JO_HEALTH_GOOD * n] = x;
    m[JO_HEALTH_LAST * n] = there ? x : NAN;
    m[JO_HEALTH_WELL * n] = good ? m[JO_HEALTH_WELL * n] + 1.0 : 0.0;
    /* no waiting time after a spike: a single outlier does not affect the next sample */
    return good && before != JO_VALUE_OK && before != JO_VALUE_SPIKE && m[JO_HEALTH_WELL * n] <= r->back ? JO_VALUE_BACK : state;
}

void jo_health_check(const jo_health *r, double *memory, const unsigned char *before, const double *x,
                     const unsigned char *cells, unsigned char *states, long long count, long long n)
{
    for (long long t = 0; t < count; t++, x += n, states += n) {
        int moved = 0;
        for (long long c = 0; c < n; c++)
            moved |= isfinite(x[c]) && isfinite(memory[JO_HEALTH_LAST * n + c]) && x[c] != memory[JO_HEALTH_LAST * n + c];
        for (long long c = 0; c < n; c++)
            states[c] = (unsigned char)channel(r, memory + c, n, x[c], plain(r, x[c], cells ? cells[t * n + c] : 0), before[c], moved);
        before = states;
    }
}
