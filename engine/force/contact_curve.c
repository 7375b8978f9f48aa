/* contact_curve.c - force without loss over the depth d of an overlap where it is no power of d.
 *
 * Parallel cylinders (K. L. Johnson, Contact Mechanics, 1985, eq. 4.57): with q = pi E* L, S = 4 |R_1 +- R_2|, u = ln(q S / F)
 *   d = F (u - 1) / q = S (u - 1) exp(-u),   dF/dd = q / (u - 2),   integral of F over d = F d - F^2 (u / 2 - 1/4) / q
 * The depth is largest at u = 2; from JO_LINE_END on, where it is 0.527 |R_1 +- R_2|, the force continues along its tangent.
 *
 * A table: rows d, F, dF/dd, energy; cubic between them, straight beyond the last. */
#include "force/contact_point.h"

#define JO_LINE_END 2.25        /* u from which on, downwards, the force of cylinders continues along its tangent */
enum { JO_LINE_STEPS = 60 };    /* of Newton's method; some 6 */

typedef struct { jo_real depth, force, slope, energy; } row;

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

void jo_contact_curve(const jo_contact_law *x, jo_contact_point *y)
{
    if (JO_RE(x->curve) == JO_CURVE_TABLE) table(x, y);
    else line(x, y);
}
