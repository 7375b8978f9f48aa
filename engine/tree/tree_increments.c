/* tree_increments.c - increments of the joint coordinates between two states, for error control and events. */
#include "maximal/maximal.h"
#include "tree/tree_links.h"

#define JO_SMALL_SINE2 1e-5 /* sin^2 of half an angle below which 2 asin(s) / s is computed by its series; its next term is 6e-22 */

/* theta = 2 atan2(|s|, c) s / |s| with [c, s] = e0^-1 o e: rotation vector from e0 to e in the frame of e0, |theta| < pi */
void jo_rotation_vector_between(jo_real *theta, const jo_real *e0, const jo_real *e)
{
    const jo_real c = e0[0] * e[0] + e0[1] * e[1] + e0[2] * e[2] + e0[3] * e[3];
    jo_real x[3];
    x[0] = e0[0] * e[1] - e0[1] * e[0] - e0[2] * e[3] + e0[3] * e[2];
    x[1] = e0[0] * e[2] - e0[2] * e[0] - e0[3] * e[1] + e0[1] * e[3];
    x[2] = e0[0] * e[3] - e0[3] * e[0] - e0[1] * e[2] + e0[2] * e[1];
    const jo_real s = jo_dot3(x, x), sine = jo_sqrt(s);
    /* f = 2 asin(|s|) / |s|, by its series for small angles */
    const jo_real f = JO_RE(s) < JO_SMALL_SINE2 ? 2.0 + s * (1.0 / 3.0 + s * (3.0 / 20.0 + s * (5.0 / 56.0)))
                                      : 2.0 * jo_arc_tangent(sine, c) / sine;
    for (int i = 0; i < 3; i++) theta[i] = f * x[i];
}

/* increment dq (nu) with x = x0 o dq: differences, and rotation vectors of balls and free links */
void jo_tree_increment_between(const jo_model *m, jo_real *dq, const jo_real *x0, const jo_real *x)
{
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const int ball = k->type == JO_LINK_BALL || k->type == JO_LINK_FREE, moves = k->type == JO_LINK_FREE ? 3 : 0;
        if (k->type == JO_LINK_HINGE || k->type == JO_LINK_SLIDE) dq[k->u] = x[k->x] - x0[k->x];
        for (int j = 0; j < moves; j++) dq[k->u + j] = x[k->x + j] - x0[k->x + j];
        if (ball) jo_rotation_vector_between(dq + k->u + moves, x0 + k->x + moves, x + k->x + moves);
    }
}

/* largest rotation of a body by the increments dq at the present orientations, rad */
double jo_tree_largest_rotation(const jo_model *m, jo_data *d)
{
    double turn = 0.0;
    jo_real *rates = d->tree.maximal_copy + m->nq;   /* scratch here */
    jo_tree_body_rates(m, d, d->dq, rates);
    for (int i = 0; i < m->nbody; i++) turn = jo_larger(turn, jo_length(rates + m->body[i].iv + 3, 3));
    return turn;
}
