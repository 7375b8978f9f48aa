/* delay_ring.c - points (t, u, u') of a quantity u in the last time tau, and its value at a time between them.
 *
 * Memory: number of points, modulo twice those of the ring once it is full, whether the output jumps at the present time, time of the first
 * point, then a ring of points. Between points: cubic Hermite polynomials, so that a method of order 4 keeps its order (Bellen and Zennaro,
 * Numerical Methods for Delay Differential Equations, 2003, ch. 4); before the first point: the value given, or the first one. Points are at
 * least 1.5 tau over their number apart, but for jumps: two points at one time. Where u' is not known, slopes are those of parabolas through
 * three points.
 *
 * At a jump, the stages of the step before it have the left value, and the next step the right one: the last point is at the start of the
 * present step. */
#include "maximal/maximal.h"
#include "force/force.h"
#include "force/delay_ring.h"

enum { JO_DELAY_SMOOTH = 4 };        /* multiples of tau after the start at which steps end */
enum { JO_DELAY_SETTLED = 4 };       /* intervals after a jump that are as long as the steps where slopes are those of parabolas */
#define JO_DELAY_CLOSE 3.0           /* points within this part of tau over their number are one: two thirds of the ring, the rest is for jumps */
#define JO_DELAY_RESOLUTION 1e-12    /* times are the same within this part of the time and of tau */

static const jo_delay_data *numbers(const jo_force *f) { return (const jo_delay_data *)f->data; }
static int capacity(const jo_force *f) { return jo_whole(numbers(f)->points); }
static int count(const jo_real *x) { return jo_whole(x[JO_DELAY_COUNT]); }

static jo_delay_point *point(const jo_force *f, const jo_real *x, int i)
{
    return (jo_delay_point *)(x + JO_DELAY_RING) + i % capacity(f);
}

static double resolution(const jo_force *f, double t) { return JO_DELAY_RESOLUTION * (fabs(t) + JO_RE(numbers(f)->time)); }
static int oldest(const jo_force *f, const jo_real *x) { return count(x) > capacity(f) ? count(x) - capacity(f) : 0; }

/* latest point at a time up to t; -1: none */
static int latest(const jo_force *f, const jo_real *x, double t)
{
    int low = oldest(f, x) - 1, high = count(x);
    while (high - low > 1) {
        const int middle = low + (high - low) / 2;
        if (JO_RE(point(f, x, middle)->t) <= t) low = middle;
        else high = middle;
    }
    return low < oldest(f, x) ? -1 : low;
}

/* value before the first point */
static jo_real history(const jo_force *f, const jo_real *x)
{
    return JO_RE(numbers(f)->given) != 0.0 || !count(x) ? numbers(f)->initial : point(f, x, 0)->u;
}

static jo_signal_work between(const jo_delay_point *a, const jo_delay_point *b, jo_real t)
{
    const jo_real h = b->t - a->t, z = (t - a->t) / h, rise = b->u - a->u;
    const jo_real c = 3.0 * rise - h * (2.0 * a->s + b->s), e = h * (a->s + b->s) - 2.0 * rise;
    const jo_signal_work y = {a->u + z * (h * a->s + z * (c + z * e)), a->s + z * (2.0 * c + 3.0 * z * e) / h, (2.0 * c + 6.0 * z * e) / (h * h)};
    return y;
}

jo_signal_work jo_delayed(const jo_model *m, const jo_data *d, int force, jo_real time)
{
    const jo_force *f = &m->force[force];
    const jo_real *x = jo_states(m, d) + f->state;
    const int last = count(x) - 1;
    const jo_real t = time - numbers(f)->time;
    const double same = resolution(f, JO_RE(time));
    const int starts = last >= 0 && JO_RE(time) - JO_RE(point(f, x, last)->t) <= same;   /* at the start of a step */
    const int k = latest(f, x, JO_RE(t) + (starts ? same : -same));
    jo_signal_work y = {0.0, 0.0, 0.0};
    if (k < 0) y.value = history(f, x);
    else if (k < last) y = between(point(f, x, k), point(f, x, k + 1), t);
    else {   /* after the last point, as in the last stage of a step of length tau */
        y.value = point(f, x, k)->u + point(f, x, k)->s * (t - point(f, x, k)->t);
        y.rate = point(f, x, k)->s;
    }
    return y;
}

/* whether u jumps from the point k - 1 to the point k */
static int pair(const jo_force *f, const jo_real *x, int k)
{
    return k > oldest(f, x) && JO_RE(point(f, x, k)->t) == JO_RE(point(f, x, k - 1)->t);
}

/* whether u is smooth over the last points, so many that their slopes are those of parabolas */
static int settled(const jo_force *f, const jo_real *x)
{
    const int last = count(x) - 1;
    int smooth = 1;
    for (int k = last; k > last - JO_DELAY_SETTLED; k--) smooth = smooth && k > oldest(f, x) && !pair(f, x, k);
    return smooth;
}

/* slopes of the last points by the parabola through three of them, after a jump by the line through two */
static void find_slopes(const jo_force *f, const jo_real *x)
{
    const int k = count(x) - 1, first = oldest(f, x);
    if (k <= first || pair(f, x, k)) {
        point(f, x, k)->s = jo_same(0.0);
        return;
    }
    jo_delay_point *b = point(f, x, k - 1), *c = point(f, x, k);
    const jo_real h = c->t - b->t, slope = (c->u - b->u) / h;
    c->s = slope;
    if (k - 1 <= first || pair(f, x, k - 1)) {
        b->s = slope;
        return;
    }
    jo_delay_point *a = point(f, x, k - 2);
    const jo_real g = b->t - a->t, before = (b->u - a->u) / g, curvature = (slope - before) / (g + h);
    b->s = before + g * curvature;
    c->s = slope + h * curvature;
    if (k - 2 <= first || pair(f, x, k - 2)) a->s = before - g * curvature;
}

/* add a point at the end of a step, or change that of the same time */
void jo_ring_add(const jo_force *f, jo_real *x, const jo_delay_point *p, int sloped)
{
    const int n = count(x), last = n - 1;
    const double same = resolution(f, JO_RE(p->t)), spacing = JO_DELAY_CLOSE * JO_RE(numbers(f)->time) / capacity(f);
    int k = n;
    jo_delay_point q = *p;
    if (!n) x[JO_DELAY_FIRST] = p->t;
    if (n && fabs(JO_RE(p->t) - JO_RE(point(f, x, last)->t)) <= same) {
        const jo_delay_point *b = point(f, x, last);
        if (b->u == p->u && (!sloped || b->s == p->s)) return;
        q.t = b->t;
        if (last == 0 || pair(f, x, last)) k = last;
    } else if (last > oldest(f, x) && !pair(f, x, last) && JO_RE(p->t) - JO_RE(point(f, x, last - 1)->t) <= spacing)
        k = sloped || settled(f, x) ? last : n;
    *point(f, x, k) = q;
    x[JO_DELAY_COUNT] = jo_same(k + 1 - (k + 1 < 4 * capacity(f) ? 0 : 2 * capacity(f)));   /* the number stays small in runs of any length */
    if (!sloped) find_slopes(f, x);
}

/* whether the output jumps at the time t */
int jo_ring_jumps(const jo_force *f, const jo_real *x)
{
    const double t = JO_RE(point(f, x, count(x) - 1)->t);
    const double since = t - JO_RE(numbers(f)->time), same = resolution(f, t);
    const int k = latest(f, x, since + same);
    if (k < 0 || fabs(JO_RE(point(f, x, k)->t) - since) > same) return 0;
    return k ? pair(f, x, k) : history(f, x) != point(f, x, 0)->u;
}

double jo_ring_error(const jo_force *f, const jo_real *before, const jo_real *after, const jo_delay_point *p)
{
    const int last = count(after) - 1;
    double scale = JO_RE(numbers(f)->size);
    if (last < 1 || point(f, after, last - 1)->t != point(f, before, count(before) - 1)->t) return 0.0;   /* no shorter step helps */
    for (int i = oldest(f, after); i <= last; i++) scale = fmax(scale, fabs(JO_RE(point(f, after, i)->u)));
    return fabs(JO_RE(between(point(f, after, last - 1), point(f, after, last), p->t).value - p->u)) / scale;
}

int jo_ring_full(const jo_force *f, const jo_real *x, double now)
{
    const int lost = oldest(f, x);   /* points before this one are overwritten */
    return lost && JO_RE(point(f, x, lost)->t) > now - JO_RE(numbers(f)->time);
}

double jo_ring_longest_step(const jo_force *f, const jo_real *x, double now)
{
    const double tau = JO_RE(numbers(f)->time), same = resolution(f, now);
    double longest = tau;
    for (int j = 1; j <= JO_DELAY_SMOOTH; j++) {
        const double left = JO_RE(x[JO_DELAY_FIRST]) + j * tau - now;
        if (left > same) longest = fmin(longest, left);
    }
    for (int k = latest(f, x, now - tau + same) + 1; k < count(x); k++)
        if (k > oldest(f, x) && pair(f, x, k)) return fmin(longest, JO_RE(point(f, x, k)->t) + tau - now);
    return longest;
}
