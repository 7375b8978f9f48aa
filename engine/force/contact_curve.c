/* contact_curve.c - force without loss over the depth d of an overlap where it is no power of d.
 *
 * Parallel cylinders (K. L. Johnson, Contact Mechanics, 1985, eq. 4.57): with q = pi E* L, S = 4 |R_1 +- R_2|, u = ln(q S / F)
 *   d = F (u - 1) / q = S (u - 1) exp(-u),   dF/dd = q / (u - 2),   integral of F over d = F d - F^2 (u / 2 - 1/4) / q
 * The depth is largest at u = 2; from JO_LINE_END on, where it is 0.527 |R_1 +- R_2|, the force continues along its tangent.
 *
 * A table: rows d, F, dF/dd, energy; cubic between them, straight beyond the last.
 *
 * The impedance a of MuJoCo's soft constraints: F = K d g(a), g = a^2 / (1 - a), by which they carry a load at rest. a rises from a_0 to a_1 over
 * the width w: a = a_0 + (a_1 - a_0) y(d / w), y = x^p / m^(p-1) up to the middle m, then 1 - (1 - x)^p / (1 - m)^(p-1). */
#include "force/contact_point.h"

#define JO_LINE_END 2.25        /* u from which on, downwards, the force of cylinders continues along its tangent */
enum { JO_LINE_STEPS = 60 };    /* of Newton's method; some 6 */

typedef struct { jo_real depth, force, slope, energy; } row;
typedef struct { jo_real low, high, width, middle, power; } impedance;   /* a_0, a_1, w, m, p */

enum { JO_PANELS = 5 };         /* of the rise of an impedance beyond its middle */
#define JO_SHORTER 0.2          /* what is left after a panel over what was left before it */
/* nodes on (0, 1) and weights of the Gauss-Legendre rule of 8 points */
static const double node[] = {0.01985507175123188, 0.10166676129318664, 0.2372337950418355, 0.4082826787521751,
                              0.5917173212478249,  0.7627662049581645,  0.8983332387068134, 0.9801449282487681};
static const double share[] = {0.05061426814518813, 0.11119051722668724, 0.15685332293894363, 0.18134189168918100,
                               0.18134189168918100, 0.15685332293894363, 0.11119051722668724, 0.05061426814518813};

/* u - ln(u - 1) = -ln(d / S): Newton's method falls to the root from 2 ln(S / d), since the left side is convex */
static jo_real logarithm_of_force(jo_real share)
{
    const jo_real level = -jo_log(share);
    jo_real u = 2.0 * level;
    for (int i = 0; i < JO_LINE_STEPS; i++) {
        const jo_real next = u - (u - jo_log(u - 1.0) - level) * (u - 1.0) / (u - 2.0);
        const int still = !(JO_RE(next) < JO_RE(u));
        u = next;
        if (still) break;
    }
    return u;
}

/* of two cylinders at u and the depth d */
static void press_line(jo_real q, jo_real S, jo_real u, jo_real d, jo_contact_point *y)
{
    y->elastic = q * S * jo_exp(-u);
    y->slope = q / (u - 2.0);
    y->bend = q * y->slope / (y->elastic * (u - 2.0) * (u - 2.0));
    y->energy = y->elastic * d - y->elastic * y->elastic * (0.5 * u - 0.25) / q;
}

/* from a row on along its tangent */
static void continue_straight(jo_real beyond, jo_contact_point *y)
{
    y->energy += beyond * (y->elastic + 0.5 * beyond * y->slope);
    y->elastic += beyond * y->slope;
    y->bend = jo_same(0.0);
}

static void line(const jo_contact_law *x, jo_contact_point *y)
{
    const jo_real end = (JO_LINE_END - 1.0) * exp(-JO_LINE_END) * x->extent;
    if (JO_RE(y->depth) < JO_RE(end)) {
        press_line(x->stiffness, x->extent, logarithm_of_force(y->depth / x->extent), y->depth, y);
        return;
    }
    press_line(x->stiffness, x->extent, jo_same(JO_LINE_END), end, y);
    continue_straight(y->depth - end, y);
}

/* the last row whose depth is not larger */
static const row *row_before(const row *rows, int count, jo_real depth)
{
    int low = 0, high = count;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (JO_RE(rows[middle].depth) <= JO_RE(depth)) low = middle;
        else high = middle;
    }
    return rows + low;
}

static void table(const jo_contact_law *x, jo_contact_point *y)
{
    const row *rows = (const row *)((const jo_contact_data *)x + 1);
    const int count = (int)JO_RE(x->extent);
    const row *a = row_before(rows, count, y->depth);
    const jo_real s = y->depth - a->depth;
    y->elastic = a->force;
    y->slope = a->slope;
    y->energy = a->energy;
    if (a == rows + count - 1) {
        continue_straight(s, y);
        return;
    }
    /* F = F_a + m_a s + c s^2 + e s^3 */
    const jo_real h = a[1].depth - a->depth, secant = (a[1].force - a->force) / h;
    const jo_real c = (3.0 * secant - 2.0 * a->slope - a[1].slope) / h, e = (a->slope + a[1].slope - 2.0 * secant) / (h * h);
    y->elastic += s * (a->slope + s * (c + s * e));
    y->slope += s * (2.0 * c + 3.0 * s * e);
    y->bend = 2.0 * c + 6.0 * s * e;
    y->energy += s * (a->force + s * (0.5 * a->slope + s * (c / 3.0 + 0.25 * s * e)));
}

/* g and its first two derivatives with respect to the depth (3), d < w */
static void rise(const impedance *k, jo_real d, jo_real *g)
{
    const jo_real x = d / k->width, p = k->power;
    const int late = JO_RE(x) > JO_RE(k->middle);
    const jo_real z = late ? 1.0 - x : x, side = late ? 1.0 - k->middle : k->middle;
    jo_real y = jo_same(0.0), dy = y, ddy = y;
    if (JO_RE(z) > 0.0) {
        y = z * jo_raised(z / side, p - 1.0);
        dy = p * y / z;
        ddy = (p - 1.0) * dy / z;
    }
    const jo_real scale = (k->high - k->low) / k->width, a = k->low + (k->high - k->low) * (late ? 1.0 - y : y), b = 1.0 - a;
    const jo_real da = scale * dy, dda = scale / k->width * (late ? -ddy : ddy);
    g[0] = a * a / b;
    g[1] = a * (2.0 - a) / (b * b) * da;
    g[2] = 2.0 / (b * b * b) * da * da + a * (2.0 - a) / (b * b) * dda;
}

/* integral of g d over the depth from one depth to another */
static jo_real panel(const impedance *k, jo_real from, jo_real to)
{
    jo_real sum = jo_same(0.0), g[3];
    for (int i = 0; i < (int)(sizeof node / sizeof *node); i++) {
        const jo_real d = from + node[i] * (to - from);
        rise(k, d, g);
        sum += share[i] * g[0] * d;
    }
    return sum * (to - from);
}

/* the same from 0 to a depth up to the width: up to the middle, then in panels that become shorter towards the width, where 1 / (1 - a) peaks */
static jo_real area(const impedance *k, jo_real depth)
{
    jo_real sum = jo_same(0.0), from = sum, left = k->width * (1.0 - k->middle);
    for (int i = 0; i <= JO_PANELS; i++, left *= JO_SHORTER) {
        const jo_real end = i < JO_PANELS ? k->width - left : k->width;
        if (JO_RE(depth) <= JO_RE(end)) return sum + panel(k, from, depth);
        sum += panel(k, from, end);
        from = end;
    }
    return sum;
}

static void soften(const jo_contact_law *x, jo_contact_point *y)
{
    const impedance *k = (const impedance *)x->impedance;
    const jo_real d = y->depth;
    if (JO_RE(d) < JO_RE(k->width)) {
        jo_real g[3];
        rise(k, d, g);
        y->elastic = x->stiffness * d * g[0];
        y->slope = x->stiffness * (g[0] + d * g[1]);
        y->bend = x->stiffness * (2.0 * g[1] + d * g[2]);
    } else {
        y->slope = x->stiffness * k->high * k->high / (1.0 - k->high);
        y->elastic = y->slope * d;
        y->bend = jo_same(0.0);
    }
    const int whole = !(JO_RE(d) < JO_RE(k->width));
    y->energy = x->stiffness * area(k, whole ? k->width : d);
    if (whole) y->energy += 0.5 * y->slope * (d * d - k->width * k->width);
}

void jo_contact_curve(const jo_contact_law *x, jo_contact_point *y)
{
    if (JO_RE(x->curve) == JO_CURVE_IMPEDANCE) {
        soften(x, y);
        return;
    }
    if (JO_RE(x->curve) == JO_CURVE_TABLE) table(x, y);
    else line(x, y);
}
