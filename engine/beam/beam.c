/* beam.c - geometrically exact beam element between two rigid bodies: strains, forces, energy.
 *
 * Ends r = R + A u with frames A B. phi is the rotation vector of the relative rotation of the ends, the middle frame Q
 * turns half of it further than end a. Strains (Reissner 1981; Simo 1985) in the middle frame, with the interpolation of
 * Crisfield and Jelenic (1999), are invariant under rigid motions:
 *   Gamma = Q^T (r_b - r_a) / L - e1,  kappa = phi / L,  e = [Gamma, kappa] - e0,  U = L/2 e . C e
 * With spins beta_a, beta_b of the ends resolved in Q, d = Gamma + e1 and tau = tan(|phi|/4) phi/|phi|:
 *   beta_m = (beta_a + beta_b)/2 - tau x (beta_b - beta_a)/2      spin of the middle frame
 *   dGamma = Q^T d(r_b - r_a)/L + d x beta_m,  dkappa = H (beta_b - beta_a) / L
 * Forces are the exact gradient of U: n on b and -n on a, moments (t -+ tau x t)/2 -+ H m with t = L n x d.
 */
#include "maximal/maximal.h"
#include "beam/beam.h"

/* cosine of 1.5 rad, half of a rotation of 3 rad: larger rotations between the ends are close to the jump at pi */
#define JO_MIN_HALF_COSINE 0.0707372
#define JO_RIGHT_ANGLE_TAU2 0.1715729   /* tau^2 = tan^2(pi/8) at a rotation of pi/2 between the ends */
#define JO_ARC_SERIES 0.0225            /* tau^2 below which atan is computed by a series (up to 0.6 rad), with an error below 1e-17 */

/* z = x o y */
static void product(jo_real *z, const jo_real *x, const jo_real *y)
{
    z[0] = x[0] * y[0] - x[1] * y[1] - x[2] * y[2] - x[3] * y[3];
    z[1] = x[0] * y[1] + x[1] * y[0] + x[2] * y[3] - x[3] * y[2];
    z[2] = x[0] * y[2] + x[2] * y[0] + x[3] * y[1] - x[1] * y[3];
    z[3] = x[0] * y[3] + x[3] * y[0] + x[1] * y[2] - x[2] * y[1];
}

/* C = A^T B */
static void transposed33(jo_real *restrict C, const jo_real *restrict A, const jo_real *restrict B)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) C[3 * i + j] = A[i] * B[j] + A[3 + i] * B[3 + j] + A[6 + i] * B[6 + j];
}

/* a = atan(x)/x, mu = ((1 + s) a - 1)/s and d mu / ds as functions of s = x^2, smooth at s = 0 */
static jo_real arc(jo_beam_work *w)
{
    const jo_real s = w->square;
    if (JO_RE(s) < JO_ARC_SERIES) {
        const double c[12] = {1.0 / 3, 1.0 / 15, 1.0 / 35, 1.0 / 63, 1.0 / 99, 1.0 / 143, 1.0 / 195, 1.0 / 255, 1.0 / 323,
                              1.0 / 399, 1.0 / 483, 1.0 / 575};   /* 1 / (4 k^2 - 1) */
        jo_real mu = -c[11], dmu = -11.0 * c[11];
        for (int k = 10; k > 0; k--) {
            mu = (k % 2 ? -c[k] : c[k]) + s * mu;
            dmu = (k % 2 ? -c[k] : c[k]) * k + s * dmu;
        }
        w->mu = 2.0 * (c[0] + s * mu);
        w->dmu = 2.0 * dmu;
        return (1.0 + s * w->mu) / (1.0 + s);
    }
    const jo_real x = jo_sqrt(s), a = jo_arc_tangent(x, 1.0) / x;
    w->mu = ((1.0 + s) * a - 1.0) / s;
    w->dmu = (a + (1.0 + s) * (1.0 / (1.0 + s) - a) / (2.0 * s) - w->mu) / s;
    return a;
}

/* strains at the present q; JO_BENT if the rotation between the ends is 3 rad or more, or has passed pi since the last accepted state */
static int strain(const jo_model *m, const jo_data *d, const int i)
{
    const jo_beam *b = &m->beam[i];
    const jo_beam_data *x = b->data;
    const jo_real *end[2] = {d->q + m->body[b->a].iq, d->q + m->body[b->b].iq};
    const jo_body_work *body[2] = {&d->body[b->a], &d->body[b->b]};
    jo_beam_work *w = &d->beams.work[i];
    jo_real e[2][4], mid[4], t[3], r[3];
    for (int k = 0; k < 2; k++) {
        if (w->turned) product(e[k], end[k] + 3, w->B[k]);
        else
            for (int j = 0; j < 4; j++) e[k][j] = end[k][3 + j];
    }
    /* tau = vec(e_a^-1 e_b) / (1 + c), c = cos(phi / 2) = e_a . e_b >= 0 */
    jo_real c = e[0][0] * e[1][0] + e[0][1] * e[1][1] + e[0][2] * e[1][2] + e[0][3] * e[1][3];
    if (JO_RE(c) < 0.0) {   /* -e is the same rotation */
        c = -c;
        for (int j = 0; j < 4; j++) e[1][j] = -e[1][j];
    }
    const jo_real half = 1.0 / (1.0 + c);
    jo_cross(t, e[0] + 1, e[1] + 1);
    for (int j = 0; j < 3; j++) w->tau[j] = half * (e[0][0] * e[1][1 + j] - e[1][0] * e[0][1 + j] - t[j]);
    w->square = jo_dot3(w->tau, w->tau);
    if (!(JO_RE(c) > JO_MIN_HALF_COSINE)
        || (JO_RE(w->square) > JO_RIGHT_ANGLE_TAU2 && JO_RE(jo_dot3(w->last, w->last)) > JO_RIGHT_ANGLE_TAU2
            && JO_RE(jo_dot3(w->last, w->tau)) < 0.0))
        return isfinite(JO_RE(c)) ? JO_BENT : JO_NOT_FINITE;
    /* middle frame Q, d = Q^T (r_b - r_a) / L, kappa = 4 atan(|tau|) / |tau| tau / L */
    const jo_real scale = jo_sqrt(0.5 * half);
    for (int j = 0; j < 4; j++) mid[j] = scale * (e[0][j] + e[1][j]);
    jo_rotation(w->Q, mid);
    jo_set3(r, end[1]);
    jo_sub3(r, end[0]);
    for (int k = 0; k < 2; k++) {
        transposed33(w->G[k], body[k]->A, w->Q);
        if (!w->offset) continue;
        const jo_real *u = k ? x->u_b : x->u_a;
        jo_mul3t(w->U[k], w->G[k], u);
        jo_mul3(t, body[k]->A, u);
        jo_axpy3(r, k ? 1.0 : -1.0, t);
    }
    jo_mul3t(w->d, w->Q, r);
    for (int j = 0; j < 3; j++) w->d[j] /= x->length;
    const jo_real angle = 4.0 * arc(w) / x->length;
    for (int j = 0; j < 3; j++) {
        w->e[j] = w->d[j] - (j == 0 ? 1.0 : 0.0) - x->e0[j];
        w->e[3 + j] = angle * w->tau[j] - x->e0[3 + j];
    }
    if (w->helical) jo_beam_helix(m, d, i);
    if (w->fibrous) jo_beam_fibre(m, d, i);
    return JO_OK;
}

/* rates of the strains: Gamma' = dv / L + d x om_m, kappa' = H (om_b - om_a) / L, om_m = (om_a + om_b)/2 - tau x (om_b - om_a)/2 */
static void strain_rate(const jo_model *m, const jo_data *d, const int i)
{
    const jo_beam *b = &m->beam[i];
    const jo_real *va = d->v + m->body[b->a].iv, *vb = d->v + m->body[b->b].iv;
    jo_beam_work *w = &d->beams.work[i];
    jo_real t[3], x[3];
    jo_mul3t(w->om[0], w->G[0], va + 3);
    jo_mul3t(w->om[1], w->G[1], vb + 3);
    for (int j = 0; j < 3; j++) t[j] = vb[j] - va[j];
    jo_mul3t(w->dv, w->Q, t);
    if (w->offset) {
        jo_cross(t, w->om[1], w->U[1]);
        jo_add3(w->dv, t);
        jo_cross(t, w->om[0], w->U[0]);
        jo_sub3(w->dv, t);
    }
    for (int j = 0; j < 3; j++) x[j] = w->om[1][j] - w->om[0][j];
    jo_cross(t, w->tau, x);
    for (int j = 0; j < 3; j++) w->om_m[j] = 0.5 * (w->om[0][j] + w->om[1][j] - t[j]);
    jo_cross(t, w->d, w->om_m);
    jo_beam_h(w->rate + 3, w, x);
    for (int j = 0; j < 3; j++) {
        w->rate[j] = w->dv[j] / b->data->length + t[j];
        w->rate[3 + j] /= b->data->length;
    }
    if (w->helical) jo_beam_helix_rate(m, d, i);
    if (w->fibrous) jo_beam_fibre_rate(d, i);
}

/* strains, and resultants s = C (e + beta e') */
static int section(const jo_model *m, const jo_data *d, const int i)
{
    const jo_beam_data *x = m->beam[i].data;
    jo_beam_work *w = &d->beams.work[i];
    jo_real e[6];
    const int status = strain(m, d, i);
    if (status != JO_OK) return status;
    for (int j = 0; j < 6; j++) e[j] = w->e[j];
    if (w->damped) {
        strain_rate(m, d, i);
        for (int j = 0; j < 6; j++) e[j] += x->beta * w->rate[j];
    }
    for (int j = 0; j < 6; j++) {
        const jo_real *C = x->C + 6 * j;
        w->s[j] = C[0] * e[0] + C[1] * e[1] + C[2] * e[2] + C[3] * e[3] + C[4] * e[4] + C[5] * e[5];
        w->f[j] = w->s[j];
    }
    if (w->fibrous) jo_beam_fibre_force(d, i);
    if (w->helical) jo_beam_helix_force(m, d, i);
    return JO_OK;
}

/* moments M = (t -+ tau x t)/2 -+ H m of the ends a, b on the element, t = L n x d */
static void end_moments(const jo_model *m, const jo_data *d, const int i)
{
    jo_beam_work *w = &d->beams.work[i];
    jo_real h[3], x[3];
    jo_cross(w->t, w->f, w->d);
    for (int j = 0; j < 3; j++) w->t[j] *= m->beam[i].data->length;
    jo_cross(x, w->tau, w->t);
    jo_beam_h(h, w, w->f + 3);
    for (int k = 0; k < 2; k++) {
        const double sign = k ? 1.0 : -1.0;
        for (int j = 0; j < 3; j++) w->M[k][j] = 0.5 * w->t[j] + sign * (h[j] + 0.5 * x[j]);
    }
}

/* forces and torques of one element on its bodies; power of its damping */
static void internal(const jo_model *m, jo_data *d, const int i)
{
    const jo_beam *b = &m->beam[i];
    jo_body_work *body[2] = {&d->body[b->a], &d->body[b->b]};
    jo_beam_work *w = &d->beams.work[i];
    const jo_real *n = w->f;
    jo_real y[3];
    end_moments(m, d, i);
    for (int k = 0; k < 2; k++) {
        const double sign = k ? 1.0 : -1.0;
        jo_set3(y, w->M[k]);
        if (w->offset) {
            jo_real t[3];
            jo_cross(t, w->U[k], n);
            jo_axpy3(y, sign, t);
        }
        jo_mul3(y, w->G[k], y);
        jo_sub3(body[k]->fr + 3, y);
        jo_mul3(y, w->G[k], n);
        jo_axpy3(body[k]->fr, -sign, y);
    }
    if (w->damped) {
        jo_real power = 0.0;
        for (int j = 0; j < 6; j++) {
            const jo_real *C = b->data->C + 6 * j;
            for (int l = 0; l < 6; l++) power += w->rate[j] * C[l] * w->rate[l];
        }
        d->power.damping += b->data->length * b->data->beta * power;
    }
}

/* elastic, damping and consistent inertial forces of all beams, added to the forces on their bodies */
int jo_beam_forces(const jo_model *m, jo_data *d, const jo_real *a)
{
    for (int i = 0; i < m->nbeam; i++) {
        const int status = section(m, d, i);
        if (status != JO_OK) {
            d->error_index = status == JO_BENT ? i : m->beam[i].a;
            return status;
        }
        internal(m, d, i);
        if (jo_beam_inertial(&m->beam[i])) jo_beam_inertia(m, d, i, a);
    }
    return JO_OK;
}

/* square of the accelerations that the forces of one element give its bodies, in the norm of the masses: |n|^2 / m + |M|^2 / J */
double jo_beam_force_norm(const jo_model *m, const jo_data *d, int i)
{
    const jo_beam_work *w = &d->beams.work[i];
    const int body[2] = {m->beam[i].a, m->beam[i].b};
    double n = 0.0, sum = 0.0;
    for (int j = 0; j < 3; j++) n += JO_RE(w->s[j]) * JO_RE(w->s[j]);
    for (int k = 0; k < 2; k++) {
        const jo_real *J = m->body[body[k]].J0;
        const double mass = JO_RE(m->body[body[k]].mass[0]);
        double M = 0.0;
        for (int j = 0; j < 3; j++) M += JO_RE(w->M[k][j]) * JO_RE(w->M[k][j]);
        if (mass > 0.0) sum += n / mass;
        const double inertia = JO_RE(J[0] + J[1] + J[2]);
        if (inertia > 0.0) sum += M / inertia;
    }
    return sum;
}

/* strain energy of the beams at the present q */
jo_real jo_beam_stored(const jo_model *m, const jo_data *d)
{
    jo_real U = 0.0;
    for (int i = 0; i < m->nbeam; i++) {
        const jo_beam_data *x = m->beam[i].data;
        const jo_real *e = d->beams.work[i].e;
        if (strain(m, d, i) != JO_OK) continue;
        jo_real sum = 0.0;
        for (int j = 0; j < 6; j++)
            for (int k = 0; k < 6; k++) sum += e[j] * x->C[6 * j + k] * e[k];
        U += 0.5 * x->length * sum;
    }
    return U;
}

/* y (24) = strains and resultants in the middle of one element at the present q, v; resultants at both ends from equilibrium, in the axes of
 * the end sections */
void jo_beam_section(const jo_model *m, const jo_data *d, int i, jo_real *y)
{
    const jo_beam_work *w = &d->beams.work[i];
    const jo_beam_data *x = m->beam[i].data;
    if (section(m, d, i) != JO_OK) return;
    for (int j = 0; j < 6; j++) {
        y[j] = w->e[j];
        y[6 + j] = w->s[j];
    }
    end_moments(m, d, i);
    for (int k = 0; k < 2; k++) {
        const jo_real *B = k ? x->B_b : x->B_a;
        jo_real M[3], t[3], *z = y + 12 + 6 * k;
        for (int j = 0; j < 3; j++) M[j] = (k ? 1.0 : -1.0) * w->M[k][j];
        jo_mul3(t, w->G[k], w->f);
        jo_mul3t(z, B, t);
        jo_mul3(t, w->G[k], M);
        jo_mul3t(z + 3, B, t);
    }
}

void jo_beam_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    d->beams.count = m->nbeam;
    d->beams.work = jo_take_many(a, m->nbeam, sizeof *d->beams.work);
    d->beams.bent = jo_take_doubles(a, 2 * m->nbeam);
    d->beams.stiff = jo_take_reals(a, JO_BEAM_KEPT * m->nbeam);
}

/* constants: quaternions of the end frames on the bodies, and flags of the terms that are not 0 */
void jo_beam_setup(const jo_model *m, jo_data *d)
{
    static const double unit[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    for (int i = 0; i < m->nbeam; i++) {
        const jo_beam_data *x = m->beam[i].data;
        jo_beam_work *w = &d->beams.work[i];
        jo_quaternion(w->B[0], x->B_a);
        jo_quaternion(w->B[1], x->B_b);
        for (int j = 0; j < 9; j++) w->turned |= x->B_a[j] != unit[j] || x->B_b[j] != unit[j];
        for (int j = 0; j < 3; j++) w->offset |= x->u_a[j] != 0.0 || x->u_b[j] != 0.0;
        w->damped = x->beta != 0.0;
        w->helical = x->helical != 0.0;
        w->fibrous = x->polar != 0.0;
    }
}

/* at an accepted state: largest rotation between the ends, and largest ratio of tension and its limit */
void jo_beam_accept(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nbeam; i++) {
        jo_beam_work *w = &d->beams.work[i];
        const double bent = 4.0 * atan(sqrt(JO_RE(w->square))), tension = JO_RE(w->s[0] * m->beam[i].data->limit);
        jo_set3(w->last, w->tau);
        if (bent > d->beams.bent[2 * i]) d->beams.bent[2 * i] = bent;
        if (tension > d->beams.bent[2 * i + 1]) d->beams.bent[2 * i + 1] = tension;
    }
}

/* after the state was replaced: the rotation at the last accepted state is unknown */
void jo_beam_reset_history(jo_data *d)
{
    for (int i = 0; i < d->beams.count; i++)
        for (int j = 0; j < 3; j++) d->beams.work[i].last[j] = 0.0;
}
