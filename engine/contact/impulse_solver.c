/* impulse_solver.c - impulses of points that strike with Coulomb friction, by Gauss-Seidel sweeps over the points (M. Jean, Computer Methods in
 * Applied Mechanics and Engineering 177 (1999), 235-257).
 *
 * Of each point, with u = v + W p less its target velocity:
 *   0 <= p_n, 0 <= u_n, p_n u_n = 0;   |p_t| <= mu p_n, and p_t = -mu p_n u_t / |u_t| where u_t is not 0. */
#include "contact/contact.h"

enum { JO_SWEEPS = 1000, JO_SLIP_ITERATIONS = 100 };
#define JO_IMPULSE_SMALL 1e-14      /* change of the impulses over their size, at which a sweep has converged */
#define JO_IMPULSE_CLOSE 1e-6       /* the same up to which the result counts as converged after the last sweep */
#define JO_SLIP_PACE 1.9            /* step of the iteration for the direction of slip, times the inverse trace */

/* x of a (3 x 3) matrix with this row stride: a x = -b, by Cramer's rule */
static int solve3(const jo_real *a, int stride, const jo_real *b, jo_real *x)
{
    const jo_real *p = a, *q = a + stride, *r = a + 2 * stride;
    jo_real c[3], e[3];
    jo_cross(c, q, r);
    const jo_real det = jo_dot3(p, c);
    if (!(JO_RE(det) > 0.0)) return 0;
    /* columns of the inverse: q x r, r x p, p x q, over the determinant */
    for (int i = 0; i < 3; i++) x[i] = -c[i] * b[0] / det;
    jo_cross(e, r, p);
    for (int i = 0; i < 3; i++) x[i] -= e[i] * b[1] / det;
    jo_cross(e, p, q);
    for (int i = 0; i < 3; i++) x[i] -= e[i] * b[2] / det;
    return 1;
}

static jo_real length2(jo_real x, jo_real y)
{
    const jo_real square = x * x + y * y;
    return JO_RE(square) > 0.0 ? jo_sqrt(square) : 0.0;
}

/* impulse x of a point that slips: p_t follows from a projected gradient, p_n from u_n = 0 */
static void slip(const jo_real *a, int stride, const jo_real *b, jo_real mu, jo_real *x)
{
    const jo_real pace = JO_SLIP_PACE / (a[stride + 1] + a[2 * stride + 2]);
    jo_real n = -b[0] / a[0];
    for (int i = 0; i < 3; i++) x[i] = i ? jo_same(0.0) : n;
    for (int k = 0; k < JO_SLIP_ITERATIONS; k++) {
        jo_real t[2];
        for (int i = 1; i < 3; i++) {
            const jo_real *row = a + i * stride, u = b[i] + row[0] * x[0] + row[1] * x[1] + row[2] * x[2];
            t[i - 1] = x[i] - pace * u;
        }
        const jo_real size = length2(t[0], t[1]);
        if (!(JO_RE(size) > 0.0)) return;
        /* on the circle: u_n = b_n + (a_nn + mu a_nt e) p_n = 0 */
        const jo_real e0 = t[0] / size, e1 = t[1] / size, slope = a[0] + mu * (a[1] * e0 + a[2] * e1);
        n = JO_RE(slope) > 0.0 ? -b[0] / slope : -b[0] / a[0];
        const jo_real most = mu * n, change = jo_size(x[1] - most * e0) + jo_size(x[2] - most * e1);
        x[0] = n;
        x[1] = most * e0;
        x[2] = most * e1;
        if (JO_RE(change) <= JO_IMPULSE_SMALL * JO_RE(n)) return;
    }
}

/* impulse x (rows) of a point whose velocity without it is b */
static void solve_point(const jo_strike *s, const jo_real *a, int stride, const jo_real *b, jo_real *x)
{
    for (int i = 0; i < s->rows; i++) x[i] = jo_same(0.0);
    if (JO_RE(b[0]) >= 0.0 || !(JO_RE(a[0]) > 0.0)) return;
    if (s->rows == 1) {
        x[0] = -b[0] / a[0];
        return;
    }
    if (solve3(a, stride, b, x) && JO_RE(x[0]) > 0.0 && JO_RE(length2(x[1], x[2])) <= JO_RE(s->mu * x[0])) return;
    slip(a, stride, b, s->mu, x);
}

int jo_impulse_solve(const jo_strike *s, int k, int n, const jo_real *W, jo_real *p)
{
    double change = 0.0, size = 0.0;
    for (int i = 0; i < n; i++) p[i] = jo_same(0.0);
    for (int sweep = 0; sweep < JO_SWEEPS; sweep++) {
        change = size = 0.0;
        for (int i = 0, at = 0; i < k; at += s[i++].rows) {
            jo_real b[3] = {0.0}, x[3];
            for (int r = 0; r < s[i].rows; r++) {
                const jo_real *row = W + (at + r) * n;
                b[r] = s[i].v[r] - s[i].target[r];
                for (int c = 0; c < n; c++)
                    if (c < at || c >= at + s[i].rows) b[r] += row[c] * p[c];
            }
            solve_point(&s[i], W + at * n + at, n, b, x);
            for (int r = 0; r < s[i].rows; r++) {
                change = fmax(change, fabs(JO_RE(x[r] - p[at + r])));
                size = fmax(size, fabs(JO_RE(x[r])));
                p[at + r] = x[r];
            }
        }
        if (k == 1 || change <= JO_IMPULSE_SMALL * size) return 1;
    }
    return change <= JO_IMPULSE_CLOSE * size;
}
