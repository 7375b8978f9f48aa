/* beam_helix.c - beam elements with a helical axis between the ends instead of a chord.
 *
 * Sections in screw motion from one end to the other (Sonneville, Cardona and Bruels 2014) have, with psi = phi/2 and the
 * quotient d = Q_m^T (r_b - r_a)/L of the chord, the constant strain
 *   Gamma = g - e1,  g = D d,  D = E - k psi~ psi~,  k(x) = (sqrt(x)/sin(sqrt(x)) - 1)/x,  x = psi . psi
 * as an arc is longer than its chord by psi/sin(psi). Forces and tangents are those of the plain element with the quantities conjugate to
 * d and kappa: J^T s instead of s, J^T C J and the derivative of J instead of C, J = [D, A L/2; 0, E], A = dg/dpsi. If the bending
 * flexibility within the element is added to the shear flexibility, the element is of fourth order.
 */
#include "beam/beam.h"
#include "beam/beam_lanes.h"

#define JO_SERIES 0.5   /* square of half the rotation between the ends, rad2, below which the series of x / sin(x) is used */

/* coefficients of k from x/sin(x) = 1 + 2 x^2 sum (-1)^(m+1) / (m^2 pi^2 - x^2) */
static const double series[16] = {
    0.16666666666666669, 0.019444444444444448, 0.0020502645502645509, 0.00020998677248677258,
    2.1336045641601203e-05, 2.1633474427786609e-06, 2.1923271344567653e-07, 2.2213930853920427e-08,
    2.2507674795567888e-09, 2.2805107707218226e-10, 2.3106421580996986e-11, 2.3411704028931971e-12,
    2.3721016693292275e-13, 2.4034415154237387e-14, 2.435195398382435e-15, 2.4673688033682523e-16};

/* k, k', k'' without the series */
static void large_factor(jo_real k[3], const jo_real x)
{
    const jo_real r = jo_sqrt(x), ratio = r / jo_sin(r), rest = 1.0 - ratio * jo_cos(r);
    const jo_real rate = 0.5 * ratio * rest / x;   /* d ratio / dx */
    /* d rest / dx = -rate cos(r) + ratio sin(r) / (2 r) */
    const jo_real second = (0.5 * (rate * rest + ratio * (0.5 - rate * jo_cos(r))) - rate) / x;
    k[0] = (ratio - 1.0) / x;
    k[1] = (rate - k[0]) / x;
    k[2] = (second - 2.0 * k[1]) / x;
}

/* k, k', k'' */
static void factor(jo_lanes k[3], const jo_lanes x)
{
    const double *c = series;
    k[0] = k[1] = k[2] = jo_lanes_of(0.0);
    for (int j = 15; j >= 0; j--) {
        k[0] = c[j] + x * k[0];
        if (j > 0) k[1] = j * c[j] + x * k[1];
        if (j > 1) k[2] = j * (j - 1) * c[j] + x * k[2];
    }
    JO_EACH_PLACE(l) {
        jo_real large[3];
        if (JO_RE(jo_lane(&x, l)) < JO_SERIES) continue;
        large_factor(large, jo_lane(&x, l));
        for (int j = 0; j < 3; j++) jo_set_lane(k + j, l, large[j]);
    }
}

/* psi = L kappa / 2, and k, k', k'' at psi . psi */
static void half_turn(jo_beam_group *w)
{
    for (int j = 0; j < 3; j++) w->psi[j] = 0.5 * w->length * (w->e[3 + j] + w->e0[3 + j]);
    factor(w->k, jo_lanes_dot(w->psi, w->psi));
}

/* y = D x = x + k (psi . psi x - (psi . x) psi) */
static void unbent(jo_lanes *y, const jo_lanes *x, const jo_lanes *psi, const jo_lanes k)
{
    const jo_lanes s = jo_lanes_dot(psi, psi), p = jo_lanes_dot(psi, x);
    for (int j = 0; j < 3; j++) y[j] = x[j] + k * (s * x[j] - p * psi[j]);
}

/* A = dg/dpsi */
static void bending(jo_lanes A[9], const jo_lanes *d, const jo_lanes *psi, const jo_lanes k[3])
{
    const jo_lanes s = jo_lanes_dot(psi, psi), p = jo_lanes_dot(psi, d);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            A[3 * i + j] = 2.0 * k[1] * (s * d[i] - p * psi[i]) * psi[j] + k[0] * (2.0 * d[i] * psi[j] - psi[i] * d[j])
                           - (i == j ? 1.0 : 0.0) * k[0] * p;
}

/* H (6 x 6) += second derivatives of n . g with respect to d and kappa; h = L/2 */
static void curving(jo_lanes *H, const jo_lanes *n, const jo_lanes *d, const jo_lanes *psi, const jo_lanes k[3], const jo_lanes h)
{
    const jo_lanes s = jo_lanes_dot(psi, psi), nd = jo_lanes_dot(n, d), a = jo_lanes_dot(psi, n), b = jo_lanes_dot(psi, d), P = s * nd - a * b;
    for (int i = 0; i < 3; i++) {
        const jo_lanes pi = 2.0 * psi[i] * nd - n[i] * b - d[i] * a;
        for (int j = 0; j < 3; j++) {
            const jo_lanes pj = 2.0 * psi[j] * nd - n[j] * b - d[j] * a;
            const double one = i == j ? 1.0 : 0.0;
            const jo_lanes twice = 2.0 * k[1] * (P * one + psi[i] * pj + pi * psi[j]) + 4.0 * k[2] * P * psi[i] * psi[j]
                                  + k[0] * (2.0 * nd * one - n[i] * d[j] - d[i] * n[j]);
            const jo_lanes mixed = 2.0 * k[1] * psi[i] * (s * n[j] - a * psi[j])
                                  + k[0] * (2.0 * psi[i] * n[j] - n[i] * psi[j] - a * one);
            H[6 * (3 + i) + 3 + j] += h * h * twice;
            H[6 * (3 + i) + j] += h * mixed;
            H[6 * j + 3 + i] += h * mixed;
        }
    }
}

/* Gamma = D d - e1 instead of d - e1 */
void jo_beam_helix(jo_beam_group *w)
{
    jo_lanes g[3];
    half_turn(w);
    unbent(g, w->d, w->psi, w->k[0]);
    for (int j = 0; j < 3; j++) w->e[j] += g[j] - w->d[j];
}

/* rate = J [d', kappa'] */
void jo_beam_helix_rate(jo_beam_group *w)
{
    const jo_lanes h = 0.5 * w->length;
    jo_lanes A[9], x[3];
    bending(A, w->d, w->psi, w->k);
    for (int j = 0; j < 6; j++) w->raw[j] = w->rate[j];
    jo_lanes_mul(x, A, w->rate + 3);
    unbent(w->rate, w->raw, w->psi, w->k[0]);
    for (int j = 0; j < 3; j++) w->rate[j] += h * x[j];
}

/* f = J^T s, conjugate to d and kappa */
void jo_beam_helix_force(jo_beam_group *w)
{
    const jo_lanes h = 0.5 * w->length;
    jo_lanes A[9], x[3];
    bending(A, w->d, w->psi, w->k);
    unbent(w->f, w->s, w->psi, w->k[0]);
    jo_lanes_mult(x, A, w->s);
    for (int j = 0; j < 3; j++) w->f[3 + j] += h * x[j];
}

/* J = [D, A L/2; 0, E] */
static void jacobian(jo_lanes *J, const jo_beam_group *w)
{
    const jo_lanes *psi = w->psi, *k = w->k, s = jo_lanes_dot(psi, psi);
    jo_lanes A[9];
    bending(A, w->d, psi, k);
    for (int r = 0; r < 6; r++)
        for (int c = 0; c < 6; c++) {
            const double one = r == c ? 1.0 : 0.0;
            jo_lanes y = jo_lanes_of(one);
            if (r < 3 && c < 3) y += one * k[0] * s - k[0] * psi[r] * psi[c];
            if (r < 3 && c >= 3) y = 0.5 * w->length * A[3 * r + c - 3];
            J[6 * r + c] = y;
        }
}

/* E = J^T C J; X (6 x 6) = J^T X J + derivative of J^T s at constant s, where only the fourth column of X on entry is not 0 */
void jo_beam_helix_tangent(const jo_beam_group *w, const jo_lanes *C, jo_lanes *E, jo_lanes *X)
{
    const jo_lanes h = 0.5 * w->length, *psi = w->psi, *k = w->k;
    jo_lanes J[36], CJ[36];
    jacobian(J, w);
    for (int r = 0; r < 6; r++)
        for (int c = 0; c < 6; c++) {
            jo_lanes y = {0};
            for (int j = 0; j < 6; j++) y += C[6 * r + j] * J[6 * j + c];
            CJ[6 * r + c] = y;
        }
    jo_lanes twist[6];
    for (int r = 0; r < 6; r++) {
        twist[r] = jo_lanes_of(0.0);
        for (int j = 0; j < 6; j++) twist[r] += J[6 * j + r] * X[6 * j + 3];
    }
    for (int r = 0; r < 6; r++)
        for (int c = 0; c < 6; c++) {
            jo_lanes y = {0};
            for (int j = 0; j < 6; j++) y += J[6 * j + r] * CJ[6 * j + c];
            E[6 * r + c] = y;
            X[6 * r + c] = c == 3 ? twist[r] : jo_lanes_of(0.0);
        }
    curving(X, w->s, w->d, psi, k, h);
    if (!(w->kind & JO_BEAM_DAMPED)) return;
    /* damping: derivative of J [d', kappa'] */
    for (int a = 0; a < 3; a++) {
        jo_lanes H[36], one[3], row[6];
        jo_lanes_clear(H, 36);
        jo_lanes_clear(one, 3);
        one[a] = jo_lanes_of(1.0);
        curving(H, one, w->d, psi, k, h);
        for (int c = 0; c < 6; c++) {
            row[c] = jo_lanes_of(0.0);
            for (int j = 0; j < 6; j++) row[c] += H[6 * c + j] * w->raw[j];
        }
        for (int r = 0; r < 6; r++)
            for (int c = 0; c < 6; c++) X[6 * r + c] += w->beta * CJ[6 * a + r] * row[c];
    }
}
