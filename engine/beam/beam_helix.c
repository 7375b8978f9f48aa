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

#define JO_SERIES 0.5   /* square of half the rotation between the ends, rad2, below which the series of x / sin(x) is used */

/* k, k', k'' from x/sin(x) = 1 + 2 x^2 sum (-1)^(m+1) / (m^2 pi^2 - x^2) */
static void factor(jo_real k[3], const jo_real x)
{
    static const double c[16] = {
        0.16666666666666669, 0.019444444444444448, 0.0020502645502645509, 0.00020998677248677258,
        2.1336045641601203e-05, 2.1633474427786609e-06, 2.1923271344567653e-07, 2.2213930853920427e-08,
        2.2507674795567888e-09, 2.2805107707218226e-10, 2.3106421580996986e-11, 2.3411704028931971e-12,
        2.3721016693292275e-13, 2.4034415154237387e-14, 2.435195398382435e-15, 2.4673688033682523e-16};
    if (JO_RE(x) < JO_SERIES) {
        k[0] = k[1] = k[2] = 0.0;
        for (int j = 15; j >= 0; j--) {
            k[0] = c[j] + x * k[0];
            if (j > 0) k[1] = j * c[j] + x * k[1];
            if (j > 1) k[2] = j * (j - 1) * c[j] + x * k[2];
        }
        return;
    }
    const jo_real r = jo_sqrt(x), ratio = r / jo_sin(r), rest = 1.0 - ratio * jo_cos(r);
    const jo_real rate = 0.5 * ratio * rest / x;   /* d ratio / dx */
    /* d rest / dx = -rate cos(r) + ratio sin(r) / (2 r) */
    const jo_real second = (0.5 * (rate * rest + ratio * (0.5 - rate * jo_cos(r))) - rate) / x;
    k[0] = (ratio - 1.0) / x;
    k[1] = (rate - k[0]) / x;
    k[2] = (second - 2.0 * k[1]) / x;
}

/* psi = L kappa / 2, and k, k', k'' at psi . psi */
static void half_turn(const jo_model *m, const jo_data *d, const int i, jo_real *psi, jo_real k[3])
{
    const jo_beam_data *x = m->beam[i].data;
    const jo_real *e = d->beams.work[i].e;
    for (int j = 0; j < 3; j++) psi[j] = 0.5 * x->length * (e[3 + j] + x->e0[3 + j]);
    factor(k, jo_dot3(psi, psi));
}

/* y = D x = x + k (psi . psi x - (psi . x) psi) */
static void unbent(jo_real *y, const jo_real *x, const jo_real *psi, const jo_real k)
{
    const jo_real s = jo_dot3(psi, psi), p = jo_dot3(psi, x);
    for (int j = 0; j < 3; j++) y[j] = x[j] + k * (s * x[j] - p * psi[j]);
}

/* A = dg/dpsi */
static void bending(jo_real A[9], const jo_real *d, const jo_real *psi, const jo_real k[3])
{
    const jo_real s = jo_dot3(psi, psi), p = jo_dot3(psi, d);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            A[3 * i + j] = 2.0 * k[1] * (s * d[i] - p * psi[i]) * psi[j] + k[0] * (2.0 * d[i] * psi[j] - psi[i] * d[j])
                           - (i == j ? k[0] * p : 0.0);
}

/* H (6 x 6) += second derivatives of n . g with respect to d and kappa; h = L/2 */
static void curving(jo_real *H, const jo_real *n, const jo_real *d, const jo_real *psi, const jo_real k[3], const jo_real h)
{
    const jo_real s = jo_dot3(psi, psi), nd = jo_dot3(n, d), a = jo_dot3(psi, n), b = jo_dot3(psi, d), P = s * nd - a * b;
    for (int i = 0; i < 3; i++) {
        const jo_real pi = 2.0 * psi[i] * nd - n[i] * b - d[i] * a;
        for (int j = 0; j < 3; j++) {
            const jo_real pj = 2.0 * psi[j] * nd - n[j] * b - d[j] * a, one = i == j ? 1.0 : 0.0;
            const jo_real twice = 2.0 * k[1] * (P * one + psi[i] * pj + pi * psi[j]) + 4.0 * k[2] * P * psi[i] * psi[j]
                                  + k[0] * (2.0 * nd * one - n[i] * d[j] - d[i] * n[j]);
            const jo_real mixed = 2.0 * k[1] * psi[i] * (s * n[j] - a * psi[j])
                                  + k[0] * (2.0 * psi[i] * n[j] - n[i] * psi[j] - a * one);
            H[6 * (3 + i) + 3 + j] += h * h * twice;
            H[6 * (3 + i) + j] += h * mixed;
            H[6 * j + 3 + i] += h * mixed;
        }
    }
}

/* Gamma = D d - e1 instead of d - e1 */
void jo_beam_helix(const jo_model *m, const jo_data *d, const int i)
{
    jo_beam_work *w = &d->beams.work[i];
    jo_real psi[3], k[3], g[3];
    half_turn(m, d, i, psi, k);
    unbent(g, w->d, psi, k[0]);
    for (int j = 0; j < 3; j++) w->e[j] += g[j] - w->d[j];
}

/* rate = J [d', kappa'] */
void jo_beam_helix_rate(const jo_model *m, const jo_data *d, const int i)
{
    jo_beam_work *w = &d->beams.work[i];
    const jo_real h = 0.5 * m->beam[i].data->length;
    jo_real psi[3], k[3], A[9], x[3];
    half_turn(m, d, i, psi, k);
    bending(A, w->d, psi, k);
    for (int j = 0; j < 6; j++) w->raw[j] = w->rate[j];
    jo_mul3(x, A, w->rate + 3);
    unbent(w->rate, w->raw, psi, k[0]);
    jo_axpy3(w->rate, h, x);
}

/* f = J^T s, conjugate to d and kappa */
void jo_beam_helix_force(const jo_model *m, const jo_data *d, const int i)
{
    jo_beam_work *w = &d->beams.work[i];
    const jo_real h = 0.5 * m->beam[i].data->length;
    jo_real psi[3], k[3], A[9], x[3];
    half_turn(m, d, i, psi, k);
    bending(A, w->d, psi, k);
    unbent(w->f, w->s, psi, k[0]);
    jo_mul3t(x, A, w->s);
    for (int j = 0; j < 3; j++) w->f[3 + j] += h * x[j];
}

/* E = J^T C J; X (6 x 6) = J^T X J + derivative of J^T s at constant s, where only the fourth column of X on entry is not 0 */
void jo_beam_helix_tangent(const jo_model *m, const jo_data *d, const int i, const jo_real *C, jo_real *E, jo_real *X)
{
    const jo_beam_work *w = &d->beams.work[i];
    const jo_beam_data *x = m->beam[i].data;
    const jo_real h = 0.5 * x->length;
    jo_real psi[3], k[3], A[9], J[36], CJ[36];
    half_turn(m, d, i, psi, k);
    bending(A, w->d, psi, k);
    const jo_real s = jo_dot3(psi, psi);
    for (int r = 0; r < 6; r++)
        for (int c = 0; c < 6; c++) {
            jo_real y = r == c ? 1.0 : 0.0;
            if (r < 3 && c < 3) y = (r == c ? 1.0 + k[0] * s : 0.0) - k[0] * psi[r] * psi[c];
            if (r < 3 && c >= 3) y = h * A[3 * r + c - 3];
            J[6 * r + c] = y;
        }
    for (int r = 0; r < 6; r++)
        for (int c = 0; c < 6; c++) {
            jo_real y = 0.0;
            for (int j = 0; j < 6; j++) y += C[6 * r + j] * J[6 * j + c];
            CJ[6 * r + c] = y;
        }
    jo_real twist[6];
    for (int r = 0; r < 6; r++) {
        twist[r] = 0.0;
        for (int j = 0; j < 6; j++) twist[r] += J[6 * j + r] * X[6 * j + 3];
    }
    for (int r = 0; r < 6; r++)
        for (int c = 0; c < 6; c++) {
            jo_real y = 0.0;
            for (int j = 0; j < 6; j++) y += J[6 * j + r] * CJ[6 * j + c];
            E[6 * r + c] = y;
            X[6 * r + c] = c == 3 ? twist[r] : 0.0;
        }
    curving(X, w->s, w->d, psi, k, h);
    if (!w->damped) return;
    /* damping: derivative of J [d', kappa'] */
    for (int a = 0; a < 3; a++) {
        jo_real H[36] = {0.0}, one[3] = {0.0}, row[6];
        one[a] = 1.0;
        curving(H, one, w->d, psi, k, h);
        for (int c = 0; c < 6; c++) {
            row[c] = 0.0;
            for (int j = 0; j < 6; j++) row[c] += H[6 * c + j] * w->raw[j];
        }
        for (int r = 0; r < 6; r++)
            for (int c = 0; c < 6; c++) X[6 * r + c] += x->beta * CJ[6 * a + r] * row[c];
    }
}
