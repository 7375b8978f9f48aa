/* contact_apart.c - how the gap between a polytope and another one, or a surface, may close within a step.
 *
 * A plane through the closest place of a, with its normal n, has a, or the part of a surface that is near, below it and each vertex x_i of b above it by gap + o_i. The vertex rises with
 * c_i = n . (v + w x x_i) and, as its lever turns, differs from that by at most |w|^2 |x| t: after t <= h all vertices are above it by
 *   gap + min (o_i + c_i t) - |w|^2 |x| t^2 >= gap + t (min (o_i / h + c_i) - |w|^2 |x| h),
 * since the minimum is a concave function of t. Backwards from the end of a step the signs of c_i are the others.
 *
 * The same holds for a plane that b carries along, with the vertices y_j of a below it: c_j = n . (v + w x x_j), with levers x_j = y_j - r from the
 * origin of b. As the plane turns and this origin moves, it differs from that by at most |w| (2 |v| + |w| |x|) t. Both bounds hold, so the
 * higher one does: where an edge of a is over a face of b, vertices of the face approach a plane of a although the gap opens. */
#include "contact/contact.h"
#include "force/contact_pair.h"

#define JO_ROUND_OFF 1e-15   /* of a coordinate, over the size of the machine about it */
#define JO_FARTHEST 2.0      /* lever of a vertex of a over the longest one of b up to which planes that b carries along are looked at */
#define JO_MORE_REACH 1.05   /* reach over the longest lever of a, which changes within a step */
#define JO_FAR 2.0           /* gap over the way that vertices turn within a step from which on these are not looked at */

static double reach_of_b(const jo_contact_pair_pose *p) { return jo_polytope_reach(&p->b); }

/* largest distance of a vertex of a from the origin of b; INFINITY for a surface or a half-space */
static double reach_of_a(const jo_contact_pair_pose *p)
{
    double most = 0.0;
    if (p->mesh.triangles || (!p->a.vertices && !p->a.round)) return INFINITY;
    if (p->a.round) return jo_length(p->r, 3) + jo_polytope_reach(&p->a);
    for (int i = 0; i < p->a.vertices; i++) {
        jo_real lever[3];
        for (int k = 0; k < 3; k++) lever[k] = p->a.vertex[3 * i + k] - p->r[k];
        most = fmax(most, jo_length(lever, 3));
    }
    return most;
}

double jo_pair_reach(const jo_contact_pair_pose *p)
{
    const double b = reach_of_b(p), a = JO_MORE_REACH * reach_of_a(p);
    return a > b && a < JO_FARTHEST * b ? a : b;
}

static double along(const double *n, const jo_real *x) { return n[0] * JO_RE(x[0]) + n[1] * JO_RE(x[1]) + n[2] * JO_RE(x[2]); }

/* Places of one of both shapes, of a part of it or of all (kind -1), that are in front of a plane of the other one. */
typedef struct { const jo_contact_pair_pose *p; int of_a, kind; const int *of; } places;

/* largest m . x among their levers x from the origin of b */
static double highest(const places *t, const double *m)
{
    const jo_contact_pair_pose *p = t->p;
    const jo_polytope *own = t->of_a ? &p->a : &p->b;
    double local[3];
    for (int i = 0; i < 3; i++) local[i] = t->of_a ? m[i] : JO_RE(p->R[i]) * m[0] + JO_RE(p->R[3 + i]) * m[1] + JO_RE(p->R[6 + i]) * m[2];
    const double above = t->kind < 0 ? jo_polytope_height(own, local) : jo_part_height(own, t->kind, t->of, local);
    return t->of_a ? above - along(m, p->r) : above;
}

/* Lowest and highest rate of these places; bent: by how much the rate of one may change per unit of time, m/s2. With u = n x w, c_i = n . v + u . x_i:
 * both extremes are heights along other directions. */
static void rates_of(const places *t, const double *n, double bent, jo_approach *to)
{
    const jo_contact_pair_pose *p = t->p;
    const double h = to->within, rate_of_origin = along(n, p->v), sign = t->of_a ? 1.0 : -1.0;
    double out[3], low[3], high[3];
    for (int i = 0; i < 3; i++) {
        const double u = n[(i + 1) % 3] * JO_RE(p->w[(i + 2) % 3]) - n[(i + 2) % 3] * JO_RE(p->w[(i + 1) % 3]);
        out[i] = sign * n[i];
        low[i] = out[i] / h - u;
        high[i] = out[i] / h + u;
    }
    const double most = highest(t, out) / h;
    to->rate = fmax(to->rate, rate_of_origin - (highest(t, low) - most) - bent * h);
    to->highest = fmin(to->highest, rate_of_origin + (highest(t, high) - most) + bent * h);
}

/* by how much the rate of a place of b, or of a, may change per unit of time, m/s2 */
static double bent_by(const jo_contact_pair_pose *p, int of_a, double reach)
{
    const double spin = jo_length(p->w, 3);
    return of_a ? spin * (2.0 * jo_length(p->v, 3) + spin * reach) : spin * spin * reach_of_b(p);
}

/* lowest and highest rate of the gap */
static void rates(const jo_contact_pair_pose *p, const double *n, double reach, jo_approach *to)
{
    const double h = to->within, spin = jo_length(p->w, 3), turning = spin * reach_of_b(p), rate_of_origin = along(n, p->v);
    to->rate = rate_of_origin - turning;
    to->highest = rate_of_origin + turning;
    if (!(h < INFINITY) || !(turning > 0.0) || to->gap > JO_FAR * h * (fabs(rate_of_origin) + turning)) return;
    const places b = {p, 0, -1, 0}, a = {p, 1, -1, 0};
    rates_of(&b, n, bent_by(p, 0, reach), to);
    if (reach_of_a(p) <= reach) rates_of(&a, n, bent_by(p, 1, reach), to);
}

/* a depth that the coordinates do not show is none */
double jo_pair_round_off(const jo_contact_pair_pose *p) { return JO_ROUND_OFF * (jo_length(p->r, 3) + reach_of_b(p)); }

void jo_pair_approach_speeds(const jo_contact_pair_pose *p, double reach, jo_approach *to)
{
    const double turning = jo_length(p->w, 3) * reach, speed = jo_length(p->v, 3);
    for (int i = 0; i < 3; i++) {
        to->v[i] = (speed > 0.0 ? 1.0 + turning / speed : 0.0) * JO_RE(p->v[i]);
        to->spin[i] = reach * JO_RE(p->w[i]);
    }
    if (!(speed > 0.0)) to->v[0] = turning;
}

void jo_pair_approach_along(const jo_contact_pair_pose *p, const double *n, double reach, jo_approach *to)
{
    jo_pair_approach_speeds(p, reach, to);
    to->gap += jo_pair_round_off(p);
    rates(p, n, reach, to);
}

void jo_pair_approach_part(const jo_contact_pair_pose *p, double code, const double *n, jo_approach *to)
{
    const jo_feature_pair f = jo_feature_of(code);
    int part[2];
    jo_part_pair(&f, part);
    const int of_a = part[1] == JO_PART_FACE;
    const places some = {p, of_a, part[1 - of_a], of_a ? f.a : f.b};
    const double reach = of_a ? reach_of_a(p) : reach_of_b(p), turning = jo_length(p->w, 3) * reach, rate_of_origin = along(n, p->v);
    to->rate = rate_of_origin - turning;
    to->highest = rate_of_origin + turning;
    to->convex = 1;
    to->curvature = INFINITY;
    if (to->within < INFINITY && turning > 0.0) rates_of(&some, n, bent_by(p, of_a, reach), to);
}

/* n . (v + w x (x - r)), of the place x of b */
static double rate_at(const jo_contact_pair_pose *p, const double *n, const double *x)
{
    double rate = 0.0;
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        rate += n[i] * (JO_RE(p->v[i]) + JO_RE(p->w[j]) * (x[k] - JO_RE(p->r[k])) - JO_RE(p->w[k]) * (x[j] - JO_RE(p->r[j])));
    }
    return rate;
}

static void narrow(jo_approach *to, double rate, double bent)
{
    to->rate = fmax(to->rate, rate - bent * to->within);
    to->highest = fmin(to->highest, rate + bent * to->within);
}

/* Two edges that cross at the angle x: the direction n across both turns with them, by at most |w| / sin x, and separates the shapes by the
 * distance g of the lines as long as all other edges at their ends rise from the planes across n. The rate of g is n . v at the closest places of
 * the lines; these slide by at most s = (|v| + g |w| / sin x) / sin x, so that it changes by at most |w| (|v| / sin x + 2 s) per unit of time.
 * The planes above, which keep their direction, see each end of an edge instead. */
static void rates_of_edges(const jo_contact_pair_pose *p, const int *of, jo_approach *to)
{
    const double h = to->within, spin = jo_length(p->w, 3);
    const jo_feature_pair f = {JO_EDGE_EDGE, {of[0], of[1]}, {of[2], of[3]}};
    jo_feature g;
    jo_feature_at(&p->a, &p->b, p->r, p->R, jo_same(jo_feature_code(&f)), &g);
    if (!(fabs(JO_RE(g.gap)) < INFINITY)) return;
    const double sine = fabs(JO_RE(jo_dot3(g.edge, g.across))) - spin * h;
    double n[3], back[3], on_a[3], on_b[3];
    for (int i = 0; i < 3; i++) {
        back[i] = -(n[i] = JO_RE(g.normal[i]));
        on_a[i] = JO_RE(g.foot[i]);
        on_b[i] = on_a[i] + JO_RE(g.gap) * n[i];
    }
    if (!(sine > 0.0 && jo_polytope_rises(&p->a, of[0], of[1], n) > spin * h / sine)) return;
    if (!(jo_polytope_rises(&p->b, of[2], of[3], back) > spin * h * (1.0 + 1.0 / sine))) return;
    const double slides = (jo_approach_speed(to) + fabs(JO_RE(g.gap)) * spin / sine) / sine;
    if (!(jo_polytope_room(&p->a, of[0], of[1], on_a) > slides * h && jo_polytope_room(&p->b, of[2], of[3], on_b) > slides * h)) return;
    narrow(to, rate_at(p, n, on_b), spin * (jo_approach_speed(to) / sine + 2.0 * slides));
}

/* A vertex of a in front of a face of b, as for the planes that b carries along, also where other vertices of a are too far for these. */
static void rates_of_vertex(const jo_contact_pair_pose *p, const double *n, int from, jo_approach *to)
{
    const double spin = jo_length(p->w, 3);
    double x[3];
    jo_real lever[3];
    const int v = jo_polytope_extreme(&p->a, n, from, x);
    if (!(jo_polytope_rises(&p->a, v, v, n) > spin * to->within)) return;
    for (int i = 0; i < 3; i++) lever[i] = x[i] - p->r[i];
    narrow(to, rate_at(p, n, x), bent_by(p, 1, jo_length(lever, 3)));
}

void jo_pair_approach_apart(const jo_contact_pair_pose *p, const jo_separated *s, double gap, double reach, jo_approach *to)
{
    to->gap = gap;
    to->face = 0;
    to->curvature = INFINITY;
    to->convex = 1;   /* of the displacement of one of them */
    jo_pair_approach_along(p, s->edges ? s->across : s->normal, reach, to);
    if (s->round || !(to->within < INFINITY) || !(jo_length(p->w, 3) > 0.0)) return;
    if (s->edges || (s->kind == JO_CLOSEST_POINTS && s->count[0] == 2 && s->count[1] == 2)) rates_of_edges(p, s->edges ? s->edge : s->of, to);
    else if (s->kind == JO_FACE_B) rates_of_vertex(p, s->normal, s->vertex[0], to);
}
