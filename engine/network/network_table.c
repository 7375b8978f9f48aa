/* network_table.c - tables in one and two variables: piecewise cubic Hermite polynomials, and their products in x and y (bicubic).
 *
 * With the weights p of the values f and slopes s at the ends of an interval, f(x) = sum p_k (f_i, f_i+1, s_i, s_i+1)_k; in two variables
 * f(x, y) = sum p_k(x) q_l(y) F_kl with the values, slopes along x, along y, and mixed derivatives at the four corners. */
#include "network/network.h"

enum { JO_HOLD = 0, JO_LINE = 1 };   /* beyond the ends: the value there, or the line with the slope there; else the run ends */

/* knots (n) of one direction, and what is beyond them */
typedef struct { const jo_real *x; int n, outside; } jo_knots;

/* Weights (4) of the ends of the interval that contains x, or their derivatives with respect to x; first: its first knot.
 * Returns whether x is beyond the ends where the run shall end. */
static int knot_weights(const jo_knots *a, jo_real x, int derivative, jo_real *p, int *first)
{
    int low = 0, high = a->n - 1;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (JO_RE(x) < JO_RE(a->x[middle])) high = middle;
        else low = middle;
    }
    *first = low;
    const jo_real h = a->x[low + 1] - a->x[low], z = (x - a->x[low]) / h;
    const int before = JO_RE(x) < JO_RE(a->x[0]), after = JO_RE(x) > JO_RE(a->x[a->n - 1]);
    if (before || after) {
        for (int k = 0; k < 4; k++) p[k] = jo_same(0.0);
        if (!derivative) p[after] = jo_same(1.0);
        if (a->outside == JO_LINE) p[2 + after] = derivative ? jo_same(1.0) : x - a->x[low + after];
        return a->outside > JO_LINE;
    }
    if (derivative) {
        p[1] = 6.0 * z * (1.0 - z) / h;
        p[0] = -p[1];
        p[2] = (1.0 - z) * (1.0 - 3.0 * z);
        p[3] = z * (3.0 * z - 2.0);
        return 0;
    }
    p[1] = z * z * (3.0 - 2.0 * z);
    p[0] = 1.0 - p[1];
    p[2] = h * z * (1.0 - z) * (1.0 - z);
    p[3] = -h * z * z * (1.0 - z);
    return 0;
}

/* one variable: number of knots, what is beyond them, knots (n), values (n), slopes (n) */
static int line_table(const jo_real *t, jo_real x, int derivative, jo_real *y)
{
    const jo_knots a = {t + 2, jo_whole(t[0]), jo_whole(t[1])};
    const jo_real *f = a.x + a.n, *s = f + a.n;
    jo_real p[4];
    int i;
    const int left = knot_weights(&a, x, derivative, p, &i);
    *y = p[0] * f[i] + p[1] * f[i + 1] + p[2] * s[i] + p[3] * s[i + 1];
    return left;
}

/* two variables: numbers of knots n, m, what is beyond them, knots x (n), y (m), then (n x m) values, slopes along x, along y, and mixed */
static int surface_table(const jo_real *t, jo_real x, jo_real y, int along_x, int along_y, jo_real *z)
{
    const int n = jo_whole(t[0]), m = jo_whole(t[1]);
    const jo_knots a = {t + 3, n, jo_whole(t[2])}, b = {t + 3 + n, m, jo_whole(t[2])};
    const jo_real *f = b.x + m;
    jo_real p[4], q[4], sum = jo_same(0.0);
    int i, j;
    const int left = knot_weights(&a, x, along_x, p, &i) | knot_weights(&b, y, along_y, q, &j);
    for (int k = 0; k < 4; k++)
        for (int l = 0; l < 4; l++) sum += p[k] * q[l] * f[(k / 2 + 2 * (l / 2)) * n * m + (i + k % 2) * m + j + l % 2];
    *z = sum;
    return left;
}

int jo_network_table(int operation, const jo_real *t, jo_real x, jo_real y, jo_real *z)
{
    if (operation == JO_DO_table || operation == JO_DO_table_x) return line_table(t, x, operation == JO_DO_table_x, z);
    return surface_table(t, x, y, operation == JO_DO_map_x, operation == JO_DO_map_y, z);
}
