/* contact_apart.c - how the gap between a polytope and another one, or a surface, may close within a step.
 *
 * A plane through the closest place of a, with its normal n, has a, or the part of a surface that is near, below it and each vertex x_i of b above it by gap + o_i. The vertex rises with
 * c_i = n . (v + w x x_i) and, as its lever turns, differs from that by at most |w|^2 |x| t: after t <= h all vertices are above it by
 *   gap + min (o_i + c_i t) - |w|^2 |x| t^2 >= gap + t (min (o_i / h + c_i) - |w|^2 |x| h),
 * since the minimum is a concave function of t. Backwards from the end of a step the signs of c_i are the others. */
#include "contact/contact.h"
#include "force/contact_pair.h"

#define JO_ROUND_OFF 1e-15   /* of a coordinate, over the size of the machine about it */

double jo_pair_reach(const jo_contact_pair_pose *p)
{
    double most = 0.0;
    for (int i = 0; i < p->b.vertices; i++) most = fmax(most, jo_length(p->b.vertex + 3 * i, 3));
    return most;
}

static double along(const double *n, const jo_real *x) { return n[0] * JO_RE(x[0]) + n[1] * JO_RE(x[1]) + n[2] * JO_RE(x[2]); }

/* height of a vertex of b over its origin, and its lever in frame a */
static double height(const jo_contact_pair_pose *p, const double *n, int i, jo_real *lever)
{
    jo_mul3(lever, p->R, p->b.vertex + 3 * i);
    return along(n, lever);
}

/* lowest and highest rate of a vertex of b */
static void rates(const jo_contact_pair_pose *p, const double *n, jo_approach *to)
{
    jo_real lever[3], v[3];
    const double h = to->within, spin = jo_length(p->w, 3), turning = spin * jo_pair_reach(p);
    double least = INFINITY, low = INFINITY, high = -INFINITY;
    to->rate = along(n, p->v);
    to->highest = to->rate + turning;
    if (!(h < INFINITY) || !(turning > 0.0)) {
        to->rate -= turning;
        return;
    }
    for (int i = 0; i < p->b.vertices; i++) least = fmin(least, height(p, n, i, lever));
    for (int i = 0; i < p->b.vertices; i++) {
        const double above = (height(p, n, i, lever) - least) / h;
        jo_cross(v, p->w, lever);
        const double rate = to->rate + along(n, v);
        low = fmin(low, rate + above);
        high = fmax(high, rate - above);
    }
    to->highest = high + spin * turning * h;
    to->rate = low - spin * turning * h;
}

/* a depth that the coordinates do not show is none */
double jo_pair_round_off(const jo_contact_pair_pose *p) { return JO_ROUND_OFF * (jo_length(p->r, 3) + jo_pair_reach(p)); }

void jo_pair_approach_speeds(const jo_contact_pair_pose *p, jo_approach *to)
{
    const double reach = jo_pair_reach(p), turning = jo_length(p->w, 3) * reach, speed = jo_length(p->v, 3);
    for (int i = 0; i < 3; i++) {
        to->v[i] = (speed > 0.0 ? 1.0 + turning / speed : 0.0) * JO_RE(p->v[i]);
        to->spin[i] = reach * JO_RE(p->w[i]);
    }
    if (!(speed > 0.0)) to->v[0] = turning;
}

void jo_pair_approach_along(const jo_contact_pair_pose *p, const double *n, jo_approach *to)
{
    jo_pair_approach_speeds(p, to);
    to->gap += jo_pair_round_off(p);
    rates(p, n, to);
}

void jo_pair_approach_apart(const jo_contact_pair_pose *p, const jo_separated *s, double gap, jo_approach *to)
{
    to->gap = gap;
    to->face = 0;
    to->curvature = INFINITY;
    to->convex = 1;   /* of the displacement of one of them */
    jo_pair_approach_along(p, s->normal, to);
}
