/* beam_stiffness.c - derivatives of the forces of beam elements in their middle frames.
 *
 * With x = [Delta, beta_a, beta_b] (a step of r_b - r_a of the bodies, and spins of the ends) strains change by B x, generalised forces
 * [n, T_a, T_b] are L B^T s, and
 *   d[n, T_a, T_b] = L B^T C (B + beta E) x + L beta B^T C B x' + (dB^T) s x,  e' changes by E x with the position.
 * Torques are resolved in the frames of the bodies, which rotate. Operators are computed on [Delta, sigma, delta] with the mean spin sigma =
 * (beta_a + beta_b)/2 and the relative one delta = beta_b - beta_a: only delta bends the element, and all spins relative to the middle frame
 *   beta_m = sigma - tau~ delta / 2,  beta_a - beta_m = (-E + tau~) delta / 2,  beta_b - beta_m = (E + tau~) delta / 2
 * depend on delta alone.
 */
#include "beam/beam.h"
#include "beam/beam_lanes.h"

enum { DELTA = 0, MEAN = 1, RELATIVE = 2 };   /* columns of operators: Delta, sigma, delta */

/* Operator for strains: rows Gamma; rows kappa, which depend on delta only. */
typedef struct { jo_lanes gamma[3][JO_BEAM_BLOCK], kappa[JO_BEAM_BLOCK]; } strain_operator;

/* Operator for resultants [N, M]. */
typedef struct { jo_lanes n[3][JO_BEAM_BLOCK], m[3][JO_BEAM_BLOCK]; } stress_operator;

static inline void clear_block(jo_lanes *Y) { jo_lanes_clear(Y, JO_BEAM_BLOCK); }

/* Y = s E */
static inline void set_unit(jo_lanes *Y, const jo_lanes s)
{
    clear_block(Y);
    Y[0] = Y[4] = Y[8] = s;
}

/* Y += s H X */
static inline void add_h(jo_lanes *restrict Y, const jo_beam_group *w, const jo_lanes s, const jo_lanes *restrict X)
{
    const jo_lanes one = s * (1.0 + w->mu * w->square), mu = s * w->mu;
    for (int j = 0; j < 3; j++) {
        const jo_lanes p = mu * (w->tau[0] * X[j] + w->tau[1] * X[3 + j] + w->tau[2] * X[6 + j]);
        for (int i = 0; i < 3; i++) Y[3 * i + j] += one * X[3 * i + j] - w->tau[i] * p;
    }
}

/* Y += s d(H x) / d delta + skew matrix of a */
static void add_h_rate(jo_lanes *Y, const jo_beam_group *w, const jo_lanes s, const jo_lanes *x, const jo_lanes *a)
{
    const jo_lanes quarter = 0.25 * s * (1.0 + w->square), f = quarter * w->mu, g = -2.0 * quarter * w->dmu, tx = f * jo_lanes_dot(w->tau, x);
    jo_lanes one[3], two[3], z[3];
    jo_lanes_cross(one, w->tau, x);
    jo_lanes_cross(two, w->tau, one);
    for (int i = 0; i < 3; i++) {
        const jo_lanes y = g * two[i] + f * x[i];
        for (int j = 0; j < 3; j++) Y[3 * i + j] += y * w->tau[j];
        Y[4 * i] -= tx;
        z[i] = f * one[i] + a[i];
    }
    jo_lanes_add_skew(Y, jo_lanes_of(1.0), z);
}

/* B: derivative of the strains */
static void differentiate_strains(strain_operator *B, const jo_beam_group *w)
{
    const jo_lanes L = w->inverse_length, half = jo_lanes_of(-0.5), *tau = w->tau;
    const jo_lanes mu = w->mu * L, diagonal = L + mu * w->square;
    set_unit(B->gamma[DELTA], L);
    clear_block(B->gamma[MEAN]);
    clear_block(B->gamma[RELATIVE]);
    jo_lanes_add_skew(B->gamma[MEAN], jo_lanes_of(1.0), w->d);
    jo_lanes_add_skew_skew(B->gamma[RELATIVE], half, w->d, tau);
    if (w->kind & JO_BEAM_OFFSET)
        for (int k = 0; k < 2; k++) {
            jo_lanes_add_skew(B->gamma[MEAN], (k ? -1.0 : 1.0) * L, w->U[k]);
            jo_lanes_add_skew(B->gamma[RELATIVE], -0.5 * L, w->U[k]);
        }
    for (int i = 0; i < 3; i++) {   /* H / L */
        const jo_lanes y = mu * tau[i];
        for (int j = 0; j < 3; j++) B->kappa[3 * i + j] = -(y * tau[j]);
        B->kappa[4 * i] += diagonal;
    }
}

/* E: derivative of the rates of the strains with respect to positions */
static void differentiate_rates(strain_operator *E, const strain_operator *B, const jo_beam_group *w)
{
    const jo_lanes L = w->inverse_length, *tau = w->tau, one = jo_lanes_of(1.0), half = jo_lanes_of(-0.5), quarter = jo_lanes_of(-0.25);
    const jo_lanes none[3] = {0.0 * L, 0.0 * L, 0.0 * L};
    jo_lanes difference[JO_BEAM_BLOCK], om[JO_BEAM_BLOCK], x[3], y[3], z[3];
    for (int j = 0; j < 3; j++) {
        x[j] = w->om[1][j] - w->om[0][j];
        y[j] = w->om[0][j] + w->om[1][j];
    }
    /* derivatives -om~ (-+ E + tau~) / 2 of the angular velocities of the ends: their difference; that of the middle frame */
    clear_block(difference);
    jo_lanes_add_skew(difference, half, y);
    jo_lanes_add_skew_skew(difference, half, x, tau);
    clear_block(om);
    jo_lanes_add_skew(om, 0.125 * (w->square - 1.0), x);
    jo_lanes_add_skew_skew(om, quarter, y, tau);
    jo_lanes_add_cross(om, half, tau, difference);
    for (int c = 0; c < 3; c++) {
        clear_block(E->gamma[c]);
        jo_lanes_add_cross(E->gamma[c], -one, w->om_m, B->gamma[c]);
    }
    jo_lanes_add_skew(E->gamma[MEAN], L, w->dv);
    jo_lanes_add_skew_skew(E->gamma[RELATIVE], -0.5 * L, w->dv, tau);
    jo_lanes_add_cross(E->gamma[RELATIVE], one, w->d, om);
    if (w->kind & JO_BEAM_OFFSET)
        for (int k = 0; k < 2; k++) {
            jo_lanes_cross(z, w->om[k], w->U[k]);
            jo_lanes_add_skew(E->gamma[MEAN], (k ? -1.0 : 1.0) * L, z);
            jo_lanes_add_skew(E->gamma[RELATIVE], -0.5 * L, z);
        }
    clear_block(E->kappa);
    add_h_rate(E->kappa, w, L, x, none);
    add_h(E->kappa, w, L, difference);
}

/* S += s C B */
static void add_stresses(stress_operator *S, const jo_lanes s, const jo_lanes *C, const strain_operator *B)
{
    jo_lanes part[2][2][JO_BEAM_BLOCK];
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++) part[i / 3][j / 3][3 * (i % 3) + j % 3] = s * C[6 * i + j];
    for (int c = 0; c < 3; c++) {
        jo_lanes_add_product(S->n[c], part[0][0], B->gamma[c]);
        jo_lanes_add_product(S->m[c], part[1][0], B->gamma[c]);
    }
    jo_lanes_add_product(S->n[RELATIVE], part[0][1], B->kappa);
    jo_lanes_add_product(S->m[RELATIVE], part[1][1], B->kappa);
}

/* S = C B with a diagonal C; of the rows M only the columns of delta, the others are 0 */
static void set_diagonal_stresses(stress_operator *S, const jo_lanes *C, const strain_operator *B)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            for (int c = 0; c < 3; c++) S->n[c][3 * i + j] = C[7 * i] * B->gamma[c][3 * i + j];
            S->m[RELATIVE][3 * i + j] = C[7 * (3 + i)] * B->kappa[3 * i + j];
        }
}

/* K += (dB^T) s: the forces turn with the middle frame, the torques with the bodies */
static void add_turning(jo_lanes K[3][3][JO_BEAM_BLOCK], const jo_beam_group *w)
{
    const jo_lanes one = jo_lanes_of(1.0), half = jo_lanes_of(0.5);
    jo_lanes_add_skew(K[0][MEAN], -one, w->f);
    jo_lanes_add_skew_skew(K[0][RELATIVE], half, w->f, w->tau);
    for (int k = 0; k < 2; k++) {
        const jo_lanes sign = jo_lanes_of(k ? 1.0 : -1.0);
        jo_lanes *T = K[1 + k][RELATIVE], F[JO_BEAM_BLOCK];
        jo_lanes_add_skew(T, 0.5 * sign, w->M[k]);
        jo_lanes_add_skew_skew(T, half, w->M[k], w->tau);
        if (!(w->kind & JO_BEAM_OFFSET)) continue;
        clear_block(F);
        jo_lanes_add_skew(F, 0.5 * sign, w->f);
        jo_lanes_add_skew_skew(F, half, w->f, w->tau);
        jo_lanes_add_cross(T, sign, w->U[k], F);
    }
}

/* columns c of K = L B^T S; if B is given, with the derivative of the moments of constant resultants. bent: whether rows M of S are not 0 */
static inline void moments(jo_lanes K[3][3][JO_BEAM_BLOCK], const jo_beam_group *w, const stress_operator *S, const strain_operator *B, const int c,
                           const int bent)
{
    jo_lanes t[JO_BEAM_BLOCK], g[JO_BEAM_BLOCK];
    clear_block(t);
    clear_block(g);
    jo_lanes_add_cross(t, -w->length, w->d, S->n[c]);
    if (B) jo_lanes_add_cross(t, w->length, w->f, B->gamma[c]);
    if (bent) add_h(g, w, jo_lanes_of(1.0), S->m[c]);
    jo_lanes_add_cross(g, jo_lanes_of(0.5), w->tau, t);
    if (B && c == RELATIVE) {
        jo_lanes a[3];
        for (int j = 0; j < 3; j++) a[j] = -0.125 * (1.0 + w->square) * w->t[j];
        add_h_rate(g, w, jo_lanes_of(1.0), w->f + 3, a);
    }
    for (int j = 0; j < JO_BEAM_BLOCK; j++) {
        const jo_lanes half = 0.5 * t[j];
        K[0][c][j] = S->n[c][j];
        K[1][c][j] = half - g[j];
        K[2][c][j] = half + g[j];
    }
    if (w->kind & JO_BEAM_OFFSET)
        for (int k = 0; k < 2; k++) jo_lanes_add_cross(K[1 + k][c], jo_lanes_of(k ? 1.0 : -1.0), w->U[k], S->n[c]);
}

/* columns of the spins of the ends from those of sigma, delta */
static void split_spins(jo_lanes K[3][3][JO_BEAM_BLOCK])
{
    for (int r = 0; r < 3; r++)
        for (int j = 0; j < JO_BEAM_BLOCK; j++) {
            const jo_lanes half = 0.5 * K[r][MEAN][j], relative = K[r][RELATIVE][j];
            K[r][1][j] = half - relative;
            K[r][2][j] = half + relative;
        }
}

/* diagonal C without damping */
static void diagonal_stiffness(const jo_beam_group *w, const strain_operator *B, jo_lanes K[3][3][JO_BEAM_BLOCK])
{
    stress_operator S;
    set_diagonal_stresses(&S, w->C, B);
    for (int c = 0; c < 3; c++) moments(K, w, &S, B, c, c == RELATIVE);
}

/* any C, its changes by helical axes and the Wagner effect, damping */
static void coupled_stiffness(const jo_beam_group *w, const strain_operator *B, jo_lanes K[3][3][JO_BEAM_BLOCK], jo_lanes V[3][3][JO_BEAM_BLOCK])
{
    const jo_lanes one = jo_lanes_of(1.0), *C = w->C;
    jo_lanes fibrous[36], effective[36], changing[36];
    stress_operator S;
    jo_lanes_clear(changing, 36);
    jo_lanes_clear(&S.n[0][0], 6 * JO_BEAM_BLOCK);
    if (w->kind & JO_BEAM_FIBROUS) {
        jo_beam_fibre_tangent(w, fibrous, changing);
        C = fibrous;
    }
    if (w->kind & JO_BEAM_HELICAL) {
        jo_beam_helix_tangent(w, C, effective, changing);
        C = effective;
    }
    add_stresses(&S, one, C, B);
    if (w->kind & JO_BEAM_DAMPED) {
        stress_operator Z;
        strain_operator E;
        jo_lanes_clear(&Z.n[0][0], 6 * JO_BEAM_BLOCK);
        add_stresses(&Z, w->beta, C, B);
        for (int c = 0; c < 3; c++) moments(V, w, &Z, 0, c, 1);
        differentiate_rates(&E, B, w);
        add_stresses(&S, w->beta, C, &E);
    }
    if (w->kind & (JO_BEAM_HELICAL | JO_BEAM_FIBROUS)) add_stresses(&S, one, changing, B);
    for (int c = 0; c < 3; c++) moments(K, w, &S, B, c, 1);
}

/* K, and V of damped elements: blocks (3 x 3) of rows n, T_a, T_b by columns Delta, beta_a, beta_b, for increments and for velocities */
void jo_beam_stiffness(const jo_beam_group *w, jo_lanes *K, jo_lanes *V)
{
    jo_lanes(*const k)[3][JO_BEAM_BLOCK] = (jo_lanes(*)[3][JO_BEAM_BLOCK])K, (*const v)[3][JO_BEAM_BLOCK] = (jo_lanes(*)[3][JO_BEAM_BLOCK])V;
    strain_operator B;
    differentiate_strains(&B, w);
    if (w->kind & (JO_BEAM_COUPLED | JO_BEAM_DAMPED | JO_BEAM_HELICAL | JO_BEAM_FIBROUS)) coupled_stiffness(w, &B, k, v);
    else diagonal_stiffness(w, &B, k);
    add_turning(k, w);
    split_spins(k);
    if (w->kind & JO_BEAM_DAMPED) split_spins(v);
}
