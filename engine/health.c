/* health.c - which values of measured channels can be believed, sample by sample.
 *
 * A channel is "stuck" if its value stays the same to the last digit while others change, and a "spike" is a jump far beyond
 * the usual steps, until a few samples stay there. What failed must be well for some samples before it is believed again. */
#include "jousto.h"
#include <math.h>

enum { LAST, GOOD, USUAL, SEEN, SAME, MOVES, LEVEL, WELL };   /* rows of the memory */

static double smaller(double a, double b) { return a < b ? a : b; }
static double larger(double a, double b) { return a > b ? a : b; }

/* what a value is by itself */
static int plain(const jo_health *r, double x, int cell)
{
    if (cell == r->infinite || isinf(x) || (isfinite(x) && fabs(x) >= r->range)) return JO_SATURATED;
    if (cell == r->empty) return JO_DROPOUT;
    return isfinite(x) ? JO_OK_VALUE : JO_NAN;
}

static int channel(const jo_health *r, double *m, long long n, double x, int state, int before, int others)
{
    const int there = isfinite(x), same = there && x == m[LAST * n];
    m[SAME * n] = same ? m[SAME * n] + 1.0 : 0.0;
    m[MOVES * n] = same ? m[MOVES * n] + (others ? 1.0 : 0.0) : 0.0;
    if (r->stuck && state == JO_OK_VALUE && m[MOVES * n] >= r->stuck) state = JO_STUCK;

    const double step = fabs(x - m[GOOD * n]), seen = m[SEEN * n], usual = m[USUAL * n];
    const int known = seen >= r->warm;
    if (r->spike > 0.0) {
        const double limit = r->spike * larger(usual, 1e-12);
        const int jump = known && state == JO_OK_VALUE && isfinite(step) && step > limit;
        const int near = isfinite(m[LAST * n]) && fabs(x - m[LAST * n]) <= limit;
        m[LEVEL * n] = !jump ? 0.0 : near ? m[LEVEL * n] + 1.0 : 1.0;
        if (jump && m[LEVEL * n] < r->persist) state = JO_SPIKE;
    }
    const int good = state == JO_OK_VALUE;
    if (good && isfinite(step)) {
        /* a believed jump must not make the next one look usual */
        const double capped = known ? smaller(step, 4.0 * usual + 1e-12) : step;
        m[USUAL * n] = usual + larger(r->follow, 1.0 / (1.0 + seen)) * (capped - usual);
        m[SEEN * n] = seen + 1.0;
    }
    if (good) m[GOOD * n] = x;
    m[LAST * n] = there ? x : NAN;
    m[WELL * n] = good ? m[WELL * n] + 1.0 : 0.0;
    /* one wild value says nothing of the next */
    return good && before != JO_OK_VALUE && before != JO_SPIKE && m[WELL * n] <= r->back ? JO_BACK : state;
}

void jo_health_check(const jo_health *r, double *memory, const unsigned char *before, const double *x,
                     const unsigned char *cells, unsigned char *states, long long count, long long n)
{
    for (long long t = 0; t < count; t++, x += n, states += n) {
        int moved = 0;
        for (long long c = 0; c < n; c++)
            moved |= isfinite(x[c]) && isfinite(memory[LAST * n + c]) && x[c] != memory[LAST * n + c];
        for (long long c = 0; c < n; c++)
            states[c] = (unsigned char)channel(r, memory + c, n, x[c], plain(r, x[c], cells ? cells[t * n + c] : 0), before[c], moved);
        before = states;
    }
}
