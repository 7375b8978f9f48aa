/* beam_fibre.c - Wagner effect of beam elements: axial strain of the fibres by twist (Wagner 1929; Biot 1939).
 *
 * A twist kappa about the shear centre adds the strain (r kappa)^2/2 to the fibre at distance r; the mean over a section of area A is Ip/A
 * kappa^2/2. With p = Ip/A about the shear centre
 *   e_x = Gamma_x + p kappa_x^2/2 - that of the unstressed shape,   U = L/2 e . C e
 * The normal force N has a torque p N kappa_x, GJ becomes GJ + p N, and twist shortens the axis. Forces and tangents are those of the plain
 * element with J^T s instead of s, and J^T C J and the derivative of J instead of C, J = E + p kappa_x e1 e4^T.
 */
#include "beam/beam.h"
#include "beam/beam_lanes.h"

/* e_x += p (kappa_x^2 - that of the unstressed shape) / 2; lean = p kappa_x */
void jo_beam_fibre(jo_beam_group *w)
{
    const jo_lanes rest = w->e0[3], kappa = w->e[3] + rest;
    w->lean = w->polar * kappa;
    w->e[0] += 0.5 * w->polar * w->e[3] * (kappa + rest);
}

void jo_beam_fibre_rate(jo_beam_group *w) { w->rate[0] += w->lean * w->rate[3]; }

/* f = J^T s */
void jo_beam_fibre_force(jo_beam_group *w) { w->f[3] += w->lean * w->s[0]; }

/* C = J^T C J; X (6 x 6) = (dJ^T) s, nonzero in its fourth column only */
void jo_beam_fibre_tangent(const jo_beam_group *w, jo_lanes *C, jo_lanes *X)
{
    const jo_lanes zero = {0};
    for (int j = 0; j < 36; j++) {
        C[j] = w->C[j];
        X[j] = zero;
    }
    for (int r = 0; r < 6; r++) C[6 * r + 3] += w->lean * C[6 * r];
    for (int c = 0; c < 6; c++) C[18 + c] += w->lean * C[c];
    X[21] = w->polar * w->s[0];
    if (!(w->kind & JO_BEAM_DAMPED)) return;
    /* damping: derivative of e_x' = ... + lean kappa_x' */
    const jo_lanes rate = w->beta * w->polar * w->rate[3];
    for (int r = 0; r < 6; r++) X[6 * r + 3] += rate * C[6 * r];
}
