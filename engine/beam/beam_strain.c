/* beam_strain.c - strains, their rates and resultants of geometrically exact beam elements between two rigid bodies.
 *
 * Ends r = R + A u with frames A B. phi is the rotation vector of the relative rotation of the ends, the middle frame Q
 * turns half of it further than end a. Strains (Reissner 1981; Simo 1985) in the middle frame, with the interpolation of
 * Crisfield and Jelenic (1999), are invariant under rigid motions:
 *   Gamma = Q^T (r_b - r_a) / L - e1,  kappa = phi / L,  e = [Gamma, kappa] - e0,  U = L/2 e . C e
 * With spins beta_a, beta_b of the ends resolved in Q, d = Gamma + e1 and tau = tan(|phi|/4) phi/|phi|:
 *   beta_m = (beta_a + beta_b)/2 - tau x (beta_b - beta_a)/2      spin of the middle frame
 *   dGamma = Q^T d(r_b - r_a)/L + d x beta_m,  dkappa = H (beta_b - beta_a) / L
 */
#include "maximal/maximal.h"
#include "beam/beam.h"
#include "beam/beam_lanes.h"

/* cosine of 1.5 rad, half of a rotation of 3 rad: larger rotations between the ends are close to the jump at pi */
#define JO_MIN_HALF_COSINE 0.0707372
#define JO_RIGHT_ANGLE_TAU2 0.1715729   /* tau^2 = tan^2(pi/8) at a rotation of pi/2 between the ends */
#define JO_ARC_SERIES 0.0225            /* tau^2 below which atan is computed by a series (up to 0.6 rad), with an error below 1e-17 */
#define JO_SMALL_HALF_COSINE 0.9561     /* cos(phi/2) = (1 - tau^2) / (1 + tau^2) above which tau^2 is below JO_ARC_SERIES */

/* z = x o y */
static void product(jo_lanes *z, const jo_lanes *x, const jo_lanes *y)
{
    z[0] = x[0] * y[0] - x[1] * y[1] - x[2] * y[2] - x[3] * y[3];
    z[1] = x[0] * y[1] + x[1] * y[0] + x[2] * y[3] - x[3] * y[2];
    z[2] = x[0] * y[2] + x[2] * y[0] + x[3] * y[1] - x[1] * y[3];
    z[3] = x[0] * y[3] + x[3] * y[0] + x[1] * y[2] - x[2] * y[1];
}

/* rotation matrix of a unit quaternion */
static void rotation(jo_lanes *A, const jo_lanes *e)
{
    const jo_lanes x = e[1] + e[1], y = e[2] + e[2], z = e[3] + e[3];
    const jo_lanes xx = x * e[1], yy = y * e[2], zz = z * e[3];
    A[0] = 1.0 - (yy + zz); A[1] = x * e[2] - z * e[0]; A[2] = x * e[3] + y * e[0];
    A[3] = x * e[2] + z * e[0]; A[4] = 1.0 - (xx + zz); A[5] = y * e[3] - x * e[0];
    A[6] = x * e[3] - y * e[0]; A[7] = y * e[3] + x * e[0]; A[8] = 1.0 - (xx + yy);
}

/* coefficients 1 / (4 k^2 - 1) of (1 + s) atan(sqrt(s)) / sqrt(s) = 1 + 2 sum_k (-1)^(k+1) c_k s^k */
static const double arc_series[12] = {1.0 / 3, 1.0 / 15, 1.0 / 35, 1.0 / 63, 1.0 / 99, 1.0 / 143, 1.0 / 195, 1.0 / 255, 1.0 / 323,
                                      1.0 / 399, 1.0 / 483, 1.0 / 575};

/* a = atan(x)/x, mu = ((1 + s) a - 1)/s and d mu / ds as functions of s = x^2, smooth at s = 0; small: s < JO_ARC_SERIES in all lanes */
static jo_lanes arc(jo_beam_group *w, const int small)
{
    const double *c = arc_series;
    const jo_lanes s = w->square;
    jo_lanes mu = jo_lanes_of(-c[11]), dmu = jo_lanes_of(-11.0 * c[11]);
    for (int k = 10; k > 0; k--) {
        mu = (k % 2 ? -c[k] : c[k]) + s * mu;
        dmu = (k % 2 ? -c[k] : c[k]) * k + s * dmu;
    }
    w->mu = 2.0 * (c[0] + s * mu);
    w->dmu = 2.0 * dmu;
    jo_lanes a = (1.0 + s * w->mu) / (1.0 + s);
    if (small) return a;
    JO_EACH_PLACE(l) {
        const jo_real z = jo_lane(&s, l);
        if (JO_RE(z) < JO_ARC_SERIES) continue;
        const jo_real x = jo_sqrt(z), y = jo_arc_tangent(x, 1.0) / x, factor = ((1.0 + z) * y - 1.0) / z;
        jo_set_lane(&a, l, y);
        jo_set_lane(&w->mu, l, factor);
        jo_set_lane(&w->dmu, l, (y + (1.0 + z) * (1.0 / (1.0 + z) - y) / (2.0 * z) - factor) / z);
    }
    return a;
}

/* positions r_b - r_a of the bodies and quaternions of the end frames */
static void ends(const jo_data *d, const jo_beam_group *w, jo_lanes *r, jo_lanes e[2][4])
{
    jo_lanes q[2][4], body[4];
    for (int k = 0; k < 2; k++) {
        const jo_real *at[JO_WIDTH], *next[JO_WIDTH];
        JO_EACH_PLACE(l) {
            at[l] = d->q + w->iq[k][l];
            next[l] = at[l] + 3;
        }
        jo_lanes_gather(q[k], at);
        if (w->kind & JO_BEAM_TURNED) {
            jo_lanes_gather(body, next);
            product(e[k], body, w->b[k]);
        } else jo_lanes_gather(e[k], next);
    }
    for (int j = 0; j < 3; j++) r[j] = q[1][j] - q[0][j];
}

/* G = A^T Q of both ends: half of the relative rotation, whose quaternion is [1, tau] / sqrt(1 + tau^2), relative to the end frames */
static void end_frames(jo_beam_group *w)
{
    const jo_lanes twice = 1.0 + w->cosine;   /* 2 / (1 + tau^2) */
    const jo_lanes x = twice * w->tau[0], y = twice * w->tau[1], z = twice * w->tau[2];
    const jo_lanes xx = x * w->tau[0], yy = y * w->tau[1], zz = z * w->tau[2], xy = x * w->tau[1], xz = x * w->tau[2], yz = y * w->tau[2];
    const jo_lanes R[9] = {1.0 - (yy + zz), xy - z, xz + y, xy + z, 1.0 - (xx + zz), yz - x, xz - y, yz + x, 1.0 - (xx + yy)};
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                const jo_lanes *x0 = k ? R + 3 * j : R + j, *B = w->B[k] + 3 * i;   /* column j of R or R^T */
                const int step = k ? 1 : 3;
                if (w->kind & JO_BEAM_TURNED) w->G[k][3 * i + j] = B[0] * x0[0] + B[1] * x0[step] + B[2] * x0[2 * step];
                else w->G[k][3 * i + j] = x0[i * step];
            }
}

/* strains at the present q; lanes may be unsound (jo_beam_sound) */
void jo_beam_strain(const jo_data *d, jo_beam_group *w)
{
    jo_lanes e[2][4], mid[4], t[3], r[3];
    ends(d, w, r, e);
    /* tau = vec(e_a^-1 e_b) / (1 + c), c = cos(phi / 2) = e_a . e_b >= 0 */
    jo_lanes c = e[0][0] * e[1][0] + e[0][1] * e[1][1] + e[0][2] * e[1][2] + e[0][3] * e[1][3];
    const int small = jo_lanes_above(&c, JO_SMALL_HALF_COSINE);
    if (!small) {   /* -e is the same rotation */
        jo_lanes sign = jo_lanes_of(1.0);
        JO_EACH_PLACE(l) if (JO_RE(jo_lane(&c, l)) < 0.0) jo_set_lane(&sign, l, -1.0);
        c *= sign;
        for (int j = 0; j < 4; j++) e[1][j] *= sign;
    }
    const jo_lanes half = 1.0 / (1.0 + c);
    jo_lanes_cross(t, e[0] + 1, e[1] + 1);
    for (int j = 0; j < 3; j++) w->tau[j] = half * (e[0][0] * e[1][1 + j] - e[1][0] * e[0][1 + j] - t[j]);
    w->cosine = c;
    w->square = jo_lanes_dot(w->tau, w->tau);
    end_frames(w);
    /* middle frame Q, d = Q^T (r_b - r_a) / L, kappa = 4 atan(|tau|) / |tau| tau / L */
    const jo_lanes scale = jo_lanes_sqrt(0.5 * half);
    for (int j = 0; j < 4; j++) mid[j] = scale * (e[0][j] + e[1][j]);
    rotation(w->Q, mid);
    jo_lanes_mult(w->d, w->Q, r);
    if (w->kind & JO_BEAM_OFFSET)
        for (int k = 0; k < 2; k++) {
            jo_lanes_mult(w->U[k], w->G[k], w->u[k]);
            for (int j = 0; j < 3; j++) w->d[j] += (k ? 1.0 : -1.0) * w->U[k][j];
        }
    const jo_lanes angle = 4.0 * arc(w, small) * w->inverse_length;
    for (int j = 0; j < 3; j++) {
        w->d[j] *= w->inverse_length;
        w->e[j] = w->d[j] - (j == 0 ? 1.0 : 0.0) - w->e0[j];
        w->e[3 + j] = angle * w->tau[j] - w->e0[3 + j];
    }
    if (w->kind & JO_BEAM_HELICAL) jo_beam_helix(w);
    if (w->kind & JO_BEAM_FIBROUS) jo_beam_fibre(w);
}

/* whether the rotation between the ends is below 3 rad and has not passed pi since the last accepted state */
int jo_beam_sound(const jo_beam_group *w, int lane)
{
    jo_real last = 0.0, along = 0.0;
    for (int j = 0; j < 3; j++) {
        const jo_real x = jo_lane(w->last + j, lane);
        last += x * x;
        along += x * jo_lane(w->tau + j, lane);
    }
    return JO_RE(jo_lane(&w->cosine, lane)) > JO_MIN_HALF_COSINE
           && !(JO_RE(jo_lane(&w->square, lane)) > JO_RIGHT_ANGLE_TAU2 && JO_RE(last) > JO_RIGHT_ANGLE_TAU2 && JO_RE(along) < 0.0);
}

/* relative velocity of the ends and their angular velocities, in the middle frame */
static void relative_motion(const jo_data *d, jo_beam_group *w)
{
    jo_lanes v[2][4], om[4], t[3];
    for (int k = 0; k < 2; k++) {
        const jo_real *at[JO_WIDTH], *turn[JO_WIDTH];
        JO_EACH_PLACE(l) {
            at[l] = d->v + w->iv[k][l];
            turn[l] = at[l] + 2;
        }
        jo_lanes_gather(v[k], at);
        jo_lanes_gather(om, turn);   /* the last velocity and the angular velocities */
        jo_lanes_mult(w->om[k], w->G[k], om + 1);
    }
    for (int j = 0; j < 3; j++) t[j] = v[1][j] - v[0][j];
    jo_lanes_mult(w->dv, w->Q, t);
    if (w->kind & JO_BEAM_OFFSET)
        for (int k = 0; k < 2; k++) {
            jo_lanes_cross(t, w->om[k], w->U[k]);
            for (int j = 0; j < 3; j++) w->dv[j] += (k ? 1.0 : -1.0) * t[j];
        }
}

/* rates of the strains: Gamma' = dv / L + d x om_m, kappa' = H (om_b - om_a) / L, om_m = (om_a + om_b)/2 - tau x (om_b - om_a)/2 */
static void strain_rate(const jo_data *d, jo_beam_group *w)
{
    jo_lanes t[3], x[3];
    relative_motion(d, w);
    for (int j = 0; j < 3; j++) x[j] = w->om[1][j] - w->om[0][j];
    jo_lanes_cross(t, w->tau, x);
    for (int j = 0; j < 3; j++) w->om_m[j] = 0.5 * (w->om[0][j] + w->om[1][j] - t[j]);
    jo_lanes_cross(t, w->d, w->om_m);
    jo_lanes_h(w->rate + 3, w, x);
    for (int j = 0; j < 3; j++) {
        w->rate[j] = w->dv[j] * w->inverse_length + t[j];
        w->rate[3 + j] *= w->inverse_length;
    }
    if (w->kind & JO_BEAM_HELICAL) jo_beam_helix_rate(w);
    if (w->kind & JO_BEAM_FIBROUS) jo_beam_fibre_rate(w);
}

/* strains, resultants s = C (e + beta e') and the forces f conjugate to d and kappa; returns the first unsound lane, or -1 */
int jo_beam_resultants(const jo_data *d, jo_beam_group *w)
{
    jo_lanes e[6];
    jo_beam_strain(d, w);
    jo_lanes_copy(e, w->e, 6);
    if (w->kind & JO_BEAM_DAMPED) {
        strain_rate(d, w);
        for (int j = 0; j < 6; j++) e[j] += w->beta * w->rate[j];
    }
    for (int j = 0; j < 6; j++) {
        const jo_lanes *C = w->C + 6 * j;
        if (w->kind & JO_BEAM_COUPLED) w->s[j] = C[0] * e[0] + C[1] * e[1] + C[2] * e[2] + C[3] * e[3] + C[4] * e[4] + C[5] * e[5];
        else w->s[j] = C[j] * e[j];
    }
    jo_lanes_copy(w->f, w->s, 6);
    if (w->kind & JO_BEAM_FIBROUS) jo_beam_fibre_force(w);
    if (w->kind & JO_BEAM_HELICAL) jo_beam_helix_force(w);
    if (jo_lanes_above(&w->cosine, JO_SMALL_HALF_COSINE)) return -1;
    JO_EACH_ELEMENT(l, w) if (!jo_beam_sound(w, l)) return l;
    return -1;
}
