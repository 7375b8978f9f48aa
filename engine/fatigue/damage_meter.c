/* damage_meter.c - fatigue damage of a history, sample by sample: rainflow count (rainflow.h) and Miner's sum.
 *
 * The stack contains the turning points that belong to no closed cycle; its last point is the newest sample of the present rise or fall.
 * Of its last four points A B C D the inner range B C is a closed cycle if it lies within A D; D can still move, but only away from C, which
 * does not affect this cycle. The remaining points are the residue: growing, then shrinking ranges.
 *
 * A full stack is reduced with the least error. If the first ranges grow, no later sample can reach the first point: half a cycle is
 * removed, as in ASTM E1049, and the count with half cycles remains exact. If all ranges shrink (decaying vibration), the last range between
 * known points, one of the smallest, counts as a full cycle, and the loss of the range around it counts in full: the damage is never below
 * the exact one. Number and largest range of such forced cycles are stored. */
#include "fatigue/rainflow.h"
#include <float.h>
#include <math.h>
#include <string.h>


/* -- one cycle ---------------------------------------------------------------------------------- */

static double positive(double x) { return x > 0.0 ? x : 0.0; }

/* equivalent amplitude by the FKM guideline, 6th edition, 4.4.2: R > 1, R <= 0, R < 1/2, R >= 1/2 */
static double fkm(double M, double s, double mean)
{
    if (mean < -s) return s * (1.0 - M);
    if (mean <= s) return s + M * mean;
    if (mean < 3.0 * s) return (1.0 + M) * (s + M / 3.0 * mean) / (1.0 + M / 3.0);
    return s * 3.0 * (1.0 + M) * (1.0 + M) / (3.0 + M);
}

/* amplitude / f(R) of welds, IIW-2259-15, 3.5.2: f = 1.2 - 0.4 R up to 1.6 (low residual stress), 0.9 - 0.4 R up to 1.3 (medium) */
static double weld(double relief, double s, double mean)
{
    if (relief == 0.0) return s;
    const double offset = relief == 2.0 ? 1.2 : 0.9, most = relief == 2.0 ? 1.6 : 1.3, peak = mean + s;
    const double R = peak > 0.0 ? (mean - s) / peak : -INFINITY, f = R < -1.0 ? most : offset - 0.4 * R;
    return s / (f < 1.0 ? 1.0 : f > most ? most : f);
}

/* amplitude s of a cycle corrected for its mean stress, see jo_meter in jousto.h */
double jo_cycle_amplitude(const jo_meter *r, double from, double to)
{
    const double s = 0.5 * fabs(from - to), mean = 0.5 * (from + to);
    const double high = mean + s, low = mean - s;
    double rest;
    switch (r->mean) {
    case JO_MEAN_LINE:
        rest = 1.0 - (r->credit != 0.0 ? mean : positive(mean)) / r->strength;
        return rest > 0.0 ? s / rest : INFINITY;
    case JO_MEAN_GERBER:
        rest = 1.0 - positive(mean) / r->strength * (positive(mean) / r->strength);
        return rest > 0.0 ? s / rest : INFINITY;
    case JO_MEAN_WALKER:
        if (r->exponent == 0.5) return sqrt(positive(high) * s);
        return pow(positive(high), 1.0 - r->exponent) * pow(s, r->exponent);
    case JO_MEAN_FKM: return fkm(r->sensitivity, s, mean);
    case JO_MEAN_WELD: return weld(r->relief, s, mean);
    case JO_MEAN_COMPRESSION:
        return 0.5 * (positive(high) - positive(low) + r->share * (positive(-low) - positive(-high)));
    default: return s;
    }
}

double jo_cycle_damage(const jo_meter *r, double from, double to)
{
    const double s = jo_cycle_amplitude(r, from, to);
    if (s < r->cut || s == 0.0) return 0.0;
    const double slope = s >= r->amplitude ? r->slope : r->below;
    if (!(slope <= DBL_MAX)) return 0.0;   /* infinite slope: no damage below the knee */
    return pow(s / r->amplitude, slope) / r->cycles;
}

/* range / amplitude of the knee of the S-N curve, below which a range is round-off of the history */
#define ROUNDING 1e-12

/* -- the stack ---------------------------------------------------------------------------------- */

/* Kahan summation, which retains the damage of 1e9 small cycles */
static void add_damage(double *m, double damage)
{
    volatile double y = damage - m[JO_METER_ROUNDING], sum = m[JO_METER_DAMAGE] + y;
    m[JO_METER_ROUNDING] = sum <= DBL_MAX ? (sum - m[JO_METER_DAMAGE]) - y : 0.0;
    m[JO_METER_DAMAGE] = sum;
}

/* reduce a full stack of n points; returns the new number of points */
static int make_room(const jo_meter *r, double *m, int n)
{
    double *z = m + JO_METER;
    if (fabs(z[0] - z[1]) < fabs(z[1] - z[2])) {
        m[JO_METER_SHED] += 1.0;
        m[JO_METER_SHED_DAMAGE] += jo_cycle_damage(r, z[0], z[1]);
        memmove(z, z + 1, (size_t)(n - 1) * sizeof *z);
        return n - 1;
    }
    const double range = fabs(z[n - 3] - z[n - 2]);
    const double lost = jo_cycle_damage(r, z[n - 4], z[n - 3]) - jo_cycle_damage(r, z[n - 4], z[n - 1]);
    add_damage(m, jo_cycle_damage(r, z[n - 3], z[n - 2]));
    if (lost > 0.0) add_damage(m, lost);   /* reduction of the surrounding range */
    m[JO_METER_CLOSED] += 1.0;
    m[JO_METER_FORCED] += 1.0;
    if (range > m[JO_METER_LARGEST_FORCED]) m[JO_METER_LARGEST_FORCED] = range;
    z[n - 3] = z[n - 1];
    return n - 2;
}

/* one sample; closed cycles into `cycles` unless NULL; returns their number */
static int push(const jo_meter *r, double *m, double x, double *cycles)
{
    double *z = m + JO_METER;
    int n = (int)m[JO_METER_POINTS], closed = 0;
    if (!(fabs(x) <= DBL_MAX)) {
        m[JO_METER_DROPPED] += 1.0;
        return 0;
    }
    if (r->width > 0.0) x = r->width * floor(x / r->width + 0.5);
    m[JO_METER_SAMPLES] += 1.0;
    if (x < m[JO_METER_SMALLEST] || n == 0) m[JO_METER_SMALLEST] = x;
    if (x > m[JO_METER_LARGEST] || n == 0) m[JO_METER_LARGEST] = x;
    if (n == 0) {
        z[0] = x;
        m[JO_METER_POINTS] = 1.0;
        return 0;
    }
    const double top = z[n - 1];
    if (fabs(x - top) <= ROUNDING * r->amplitude) return 0;   /* round-off does not make a turning point */
    if (n > 1 && (x > top) == (top > z[n - 2])) {
        z[n - 1] = x;   /* further in the same direction */
    } else {
        if (n >= r->depth) n = make_room(r, m, n);
        z[n++] = x;
    }
    while (n >= 4 && jo_closes(z + n - 4)) {
        add_damage(m, jo_cycle_damage(r, z[n - 3], z[n - 2]));
        if (cycles) {
            cycles[2 * closed] = z[n - 3];
            cycles[2 * closed + 1] = z[n - 2];
        }
        closed++;
        z[n - 3] = z[n - 1];
        n -= 2;
    }
    m[JO_METER_CLOSED] += closed;
    m[JO_METER_POINTS] = n;
    return closed;
}

void jo_meter_push(const jo_meter *r, double *memory, const double *x, long long count)
{
    for (long long i = 0; i < count; i++) push(r, memory, x[i], 0);
}

long long jo_meter_trace(const jo_meter *r, double *memory, const double *x, long long count, double *cycles)
{
    long long closed = 0;
    for (long long i = 0; i < count; i++) closed += push(r, memory, x[i], cycles + 2 * closed);
    return closed;
}

/* meters per tile, whose memory fits into the cache while their columns are read */
enum { TILE = 32 };

void jo_meter_block(const jo_meter *r, double *memory, const double *x, long long count, long long n)
{
    const long long size = JO_METER + r->depth;
    for (long long first = 0; first < n; first += TILE) {
        const long long end = first + TILE < n ? first + TILE : n;
        for (long long t = 0; t < count; t++)
            for (long long i = first; i < end; i++) push(r, memory + i * size, x[t * n + i], 0);
    }
}

/* -- reading ------------------------------------------------------------------------------------ */

double jo_meter_damage(const jo_meter *r, const double *m, int residue, double *scratch)
{
    const double *z = m + JO_METER;
    const int n = (int)m[JO_METER_POINTS];
    double sum = 0.0;
    if (residue == JO_RESIDUE_HALF) {
        for (int i = 0; i + 1 < n; i++) sum += jo_cycle_damage(r, z[i], z[i + 1]);
        sum = 0.5 * (sum + m[JO_METER_SHED_DAMAGE]);
    } else if (residue == JO_RESIDUE_REPEAT) {
        /* the residue repeated after itself; removed half cycles count as full cycles */
        jo_meter deep = *r;
        deep.depth = 2 * r->depth + 2;
        deep.width = 0.0;
        for (int i = 0; i < JO_METER + n; i++) scratch[i] = m[i];
        scratch[JO_METER_DAMAGE] = scratch[JO_METER_ROUNDING] = 0.0;
        for (int i = 0; i < n; i++) push(&deep, scratch, z[i], 0);
        sum = scratch[JO_METER_DAMAGE] + m[JO_METER_SHED_DAMAGE];
    }
    return m[JO_METER_DAMAGE] + sum;
}

void jo_meter_damages(const jo_meter *r, const double *memory, long long n, int residue, double *scratch, double *out)
{
    const long long size = JO_METER + r->depth;
    for (long long i = 0; i < n; i++) out[i] = jo_meter_damage(r, memory + i * size, residue, scratch);
}

int jo_meter_valid(const jo_meter *r, const double *m)
{
    const int counts[6] = {JO_METER_POINTS, JO_METER_SAMPLES, JO_METER_DROPPED, JO_METER_CLOSED, JO_METER_FORCED, JO_METER_SHED};
    for (int i = 0; i < 6; i++)
        if (!(m[counts[i]] >= 0.0 && m[counts[i]] == floor(m[counts[i]]) && m[counts[i]] <= DBL_MAX)) return 0;
    if (m[JO_METER_POINTS] > r->depth || m[JO_METER_FORCED] > m[JO_METER_CLOSED] || (m[JO_METER_POINTS] == 0.0) != (m[JO_METER_SAMPLES] == 0.0)) return 0;
    if (!(m[JO_METER_DAMAGE] >= 0.0 && m[JO_METER_SHED_DAMAGE] >= 0.0 && m[JO_METER_LARGEST_FORCED] >= 0.0)) return 0;   /* infinite values are valid */
    const double *z = m + JO_METER;
    const int n = (int)m[JO_METER_POINTS];
    for (int i = 0; i < n; i++) {
        if (!(fabs(z[i]) <= DBL_MAX) || (i && z[i] == z[i - 1])) return 0;
        if (i > 1 && (z[i] > z[i - 1]) == (z[i - 1] > z[i - 2])) return 0;   /* no turning point */
    }
    return 1;
}
