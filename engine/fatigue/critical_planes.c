/* critical_planes.c - largest fatigue damage on the planes through a point: rainflow counts of the shear along lines in each plane, or of
 * the normal stress, with bounds that exclude most lines.
 *
 * Bound 1: a cycle has at most the range of the line and the largest normal stress of its plane, and t samples have at most (t + 2) / 2
 * cycles; lines are counted in the order of this bound until it is below the largest damage. Bound 2: each cycle crosses every level
 * within its range upwards once. Damage grows at least with a power p >= 1 of the amplitude: its sum is largest if as few cycles as
 * possible cross as many levels as possible (the row sums of a table
 * of zeros and ones are majorised by the conjugate of its column sums, Gale and Ryser 1957). */
#include "fatigue/rainflow.h"
#include <math.h>

enum { CELLS = 24 };   /* number of intervals between levels in the range of a line */
/* relative difference of damage below which planes are equal: round-off of sums, amplified by the slope of the S-N curve */
#define TIE 1e-9

/* damage of one cycle of an amplitude and the largest normal stress in it */
static double one(const jo_planes *r, const jo_meter *curve, double amplitude, double top)
{
    if (r->kind == JO_PLANE_FINDLEY) {
        const double f = amplitude + r->k * top, s = 2.0 * f / (r->k + sqrt(1.0 + r->k * r->k));
        return f > 0.0 ? jo_cycle_damage(curve, -s, s) : 0.0;
    }
    /* shear strain: ln(1 / N) over ln(amplitude) by straight lines between close points */
    const double g = amplitude * (1.0 + r->k * top);
    if (!(g > 0.0)) return 0.0;
    const double u = (log(g) - r->first) / r->step;
    if (u < 0.0) return 0.0;   /* below the table: negligible damage */
    long long i = (long long)u;
    if (i > r->points - 2) i = r->points - 2;
    return exp(r->table[i] + (u - (double)i) * (r->table[i + 1] - r->table[i]));
}

static double cycle(const jo_planes *r, const jo_meter *curve, double from, double to, double top)
{
    if (r->kind == JO_PLANE_NORMAL) return jo_cycle_damage(curve, from, to);
    return one(r, curve, 0.5 * fabs(from - to), top);
}

static double larger(double a, double b) { return a > b ? a : b; }

/* damage by the four-point count of x (count), continued cyclically from sample `start`; sn (count): normal stress;
 * z and seg (count + 1): turning points and the largest normal stress between each and the next */
static double counted(const jo_planes *r, const jo_meter *curve, const double *x, const double *sn, long long count,
                      long long start, double *z, double *seg)
{
    const int round = r->residue == JO_RESIDUE_REPEAT;
    double sum = 0.0, since = -INFINITY;   /* largest normal stress since the last point of the stack */
    long long n = 0;
    for (long long j = 0; j < count + round; j++) {
        long long t = start + j;
        if (t >= count) t -= count;
        const double value = x[t];
        since = larger(since, sn[t]);
        if (n && value == z[n - 1]) continue;
        if (n > 1 && (value > z[n - 1]) == (z[n - 1] > z[n - 2])) {
            seg[n - 2] = larger(seg[n - 2], since);   /* further in the same direction */
        } else {
            if (n) seg[n - 1] = since;
            n++;
        }
        z[n - 1] = value;
        since = sn[t];
        while (n >= 4 && jo_closes(z + n - 4)) {
            sum += cycle(r, curve, z[n - 3], z[n - 2], seg[n - 3]);
            seg[n - 4] = larger(seg[n - 4], larger(seg[n - 3], seg[n - 2]));
            z[n - 3] = z[n - 1];
            n -= 2;
        }
    }
    if (r->residue == JO_RESIDUE_HALF)
        for (long long i = 0; i + 1 < n; i++) sum += 0.5 * cycle(r, curve, z[i], z[i + 1], seg[i]);
    if (round && n > 2) sum += cycle(r, curve, z[0], z[1], seg[0]);   /* largest range, which the repetition of the history closes */
    return sum;
}

static void project(const double *row, const double *s, long long nt, double *out)
{
    for (long long t = 0; t < nt; t++, s += 6)
        out[t] = row[0] * s[0] + row[1] * s[1] + row[2] * s[2] + row[3] * s[3] + row[4] * s[4] + row[5] * s[5];
}

static void mixed(const double *turn, const double *u, const double *v, long long nt, double *out)
{
    for (long long t = 0; t < nt; t++) out[t] = turn[0] * u[t] + turn[1] * v[t];
}

static void extremes(const double *x, long long nt, double *low, double *high)
{
    *low = *high = x[0];
    for (long long t = 1; t < nt; t++) {
        *low = x[t] < *low ? x[t] : *low;
        *high = x[t] > *high ? x[t] : *high;
    }
}

/* first sample of the count; for `repeat` the sample of largest magnitude, since all cycles then close within one round */
static long long beginning(const jo_planes *r, const double *x, long long nt)
{
    long long at = 0;
    if (r->residue == JO_RESIDUE_REPEAT)
        for (long long t = 1; t < nt; t++)
            if (fabs(x[t]) > fabs(x[at])) at = t;
    return at;
}

static double at_most(long long turns) { return 0.5 * (double)(turns + 2); }

/* bound 2 of the damage of x (nt) with extremes low, high */
static double crossed(const jo_planes *r, const jo_meter *curve, const double *x, long long nt, double low, double high,
                      double top)
{
    double ends[CELLS + 2] = {0.0}, up[CELLS];
    const double cells = CELLS / (high - low);
    long long turns = 2;
    int here = (int)((x[0] - low) * cells);
    for (long long t = 1; t < nt; t++) {
        const int next = (int)((x[t] - low) * cells);
        ends[here + 1] += 1.0;
        ends[(next > here ? next : here) + 1] -= 1.0;
        here = next;
        if (t + 1 < nt) turns += (x[t + 1] - x[t]) * (x[t] - x[t - 1]) <= 0.0;
    }
    /* crossings of each level, descending; + 1 for the cyclic continuation and for half cycles */
    double sum = 0.0;
    for (int i = 1; i < CELLS; i++) {
        sum += ends[i];
        int j = i - 1;
        for (; j > 0 && up[j - 1] < sum + 1.0; j--) up[j] = up[j - 1];
        up[j] = sum + 1.0;
    }
    const double least = r->kind == JO_PLANE_FINDLEY ? larger(r->k * top, 0.0) : 0.0, half = 0.5 * (high - low);
    const double whole = r->kind == JO_PLANE_NORMAL ? jo_cycle_damage(curve, low, high) : one(r, curve, half, top);
    double bound = larger(at_most(turns) - up[0], 0.0) * pow((half / CELLS + least) / (half + least), r->p);
    for (int k = 1; k < CELLS; k++) {
        const double many = up[k - 1] - (k < CELLS - 1 ? up[k] : 0.0);
        if (many > 0.0) bound += many * pow((half * (k + 1) / CELLS + least) / (half + least), r->p);
    }
    return whole * bound;
}

/* order (n) of the bounds, descending, ties by index: heap sort */
static void sorted(const double *bound, long long *order, long long n)
{
    for (long long i = 0; i < n; i++) order[i] = i;
    for (long long last = n, root = n / 2; last > 1;) {
        long long i, held;
        if (root > 0) {
            held = order[i = --root];
        } else {
            held = order[--last];
            order[last] = order[i = 0];
        }
        for (long long child; (child = 2 * i + 1) < last; i = child) {
            if (child + 1 < last) {
                const long long a = order[child], b = order[child + 1];
                child += bound[b] < bound[a] || (bound[b] == bound[a] && b > a);
            }
            const long long c = order[child];
            if (bound[c] > bound[held] || (bound[c] == bound[held] && c < held)) break;
            order[i] = c;
        }
        order[i] = held;
    }
}

/* History on one plane: normal stress, shear along two directions and along a line (nt each); work space of the count. */
typedef struct { double *sn, *u, *v, *x, *z, *seg; } history;

static int has_lines(const jo_planes *r) { return r->kind != JO_PLANE_NORMAL; }

static void resolved(const jo_planes *r, long long plane, const double *s, long long nt, const history *h)
{
    const double *row = r->rows + 18 * plane;
    project(row, s, nt, h->sn);
    if (!has_lines(r)) return;
    project(row + 6, s, nt, h->u);
    project(row + 12, s, nt, h->v);
}

/* bound 1 / number of cycles of each line: damage of a cycle over its whole range; negative for a constant history */
static void bounds(const jo_planes *r, const jo_meter *curve, const double *s, long long nt, const history *h, double *bound)
{
    double low, high, least, top;
    for (long long i = 0; i < r->planes; i++) {
        resolved(r, i, s, nt, h);
        extremes(h->sn, nt, &least, &top);
        if (!has_lines(r)) {
            /* no bound if there is a mean stress correction */
            bound[i] = least == top ? -1.0 : curve->mean ? INFINITY : jo_cycle_damage(curve, least, top);
            continue;
        }
        for (long long j = 0; j < r->turns; j++) {
            mixed(r->turn + 2 * j, h->u, h->v, nt, h->x);
            extremes(h->x, nt, &low, &high);
            bound[i * r->turns + j] = low == high ? -1.0 : one(r, curve, 0.5 * (high - low), top);
        }
    }
}

/* whether bound 2 of a series is below `damage` */
static int falls_short(const jo_planes *r, const jo_meter *curve, const double *series, const double *sn, long long nt,
                       double damage)
{
    double low, high, least, top;
    extremes(sn, nt, &least, &top);
    extremes(series, nt, &low, &high);
    return crossed(r, curve, series, nt, low, high, top) < damage;
}

void jo_plane_damage(const jo_planes *r, const jo_meter *curve, const double *s, long long nt, double *scratch,
                     long long *order, double *damage, long long *plane)
{
    double *sn = scratch, *u = sn + nt, *v = u + nt, *x = v + nt, *z = x + nt, *seg = z + nt + 2, *bound = seg + nt + 2;
    const history h = {sn, u, v, x, z, seg};
    const double *series = has_lines(r) ? x : sn;
    const long long turns = has_lines(r) ? r->turns : 1, count = r->planes * turns;
    long long have = -1, q = 0;
    *damage = 0.0;
    *plane = 0;
    bounds(r, curve, s, nt, &h, bound);
    sorted(bound, order, count);
    for (; q < count; q++) {
        const long long i = order[q] / turns, j = order[q] % turns;
        const double most = bound[order[q]] * at_most(nt), equal = *damage * (1.0 - TIE);
        if (!(most > 0.0) || most < equal) break;
        if (have != i) resolved(r, i, s, nt, &h);
        have = i;
        if (has_lines(r)) mixed(r->turn + 2 * j, u, v, nt, x);
        if (*damage > 0.0 && r->p >= 1.0 && falls_short(r, curve, series, sn, nt, equal)) {
            bound[order[q]] = -1.0;
            continue;
        }
        bound[order[q]] = counted(r, curve, series, sn, nt, beginning(r, series, nt), z, seg);
        if (bound[order[q]] > *damage) *damage = bound[order[q]];
    }
    /* lines that were not counted have less damage; of planes with equal damage (up to round-off) the first one counts */
    for (; q < count; q++) bound[order[q]] = -1.0;
    for (q = 0; q < count; q++) {
        if (bound[q] > 0.0 && bound[q] >= *damage * (1.0 - TIE)) {
            *plane = q / turns;
            break;
        }
    }
}
