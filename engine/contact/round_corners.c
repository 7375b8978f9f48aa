/* round_corners.c - points at which two convex shapes touch of which one is round.
 *
 * A cylinder lies on a face with both ends of its side, or where that crosses the sides of the face; it stands with four quarters of its rim, which
 * turn with the lowest point. Over the border of a face its end counts as a polygon (corners.c), a rim that leans as its lowest point. Sides of
 * cylinders and edges that are parallel touch at both ends of their common length. Anything else touches at one point. */
#include "contact/round.h"

#define JO_LIES 0.1           /* cosine of the angle of the axis of a cylinder with the normal of a face, up to which it lies on it */
#define JO_SIDE_BY_SIDE 1e-3  /* sine of the angle of two lines up to which they touch along their length */
#define JO_ON_BORDER 1e-9     /* distance from a side over the size up to which a place is on it */
#define JO_EIGHTH 0.29289321881345254   /* 1 - cos 45 degrees */
#define JO_SHORT 1e-6         /* common length over the length below which there is none */

/* what touches a face: own has the face, with its outward normal; the axis of the other shape, out of its end that is near the face */
typedef struct { const jo_polytope *a, *b, *own, *other; int face, of_b, end; double normal[3], offset, axis[3], up; jo_corner *list; } above;

static double dot_vertex(const double *n, const double *x, const double *of)
{
    double d[3];
    jo_minus3d(d, x, of);
    return jo_dot3d(n, d);
}

/* corner of a part of the other shape and one of own */
static void add(const above *t, int count, double weight, const double *at, int own, const int *of_own, int other, const int *of_other)
{
    const int part[2] = {t->of_b ? other : own, t->of_b ? own : other};
    const int *first = t->of_b ? of_other : of_own, *second = t->of_b ? of_own : of_other, of[4] = {first[0], first[1], second[0], second[1]};
    const double sign = t->of_b ? -1.0 : 1.0, n[3] = {sign * t->normal[0], sign * t->normal[1], sign * t->normal[2]};
    t->list[count].code = jo_part_code(t->a, t->b, part, of, n);
    t->list[count].weight = weight;
    for (int k = 0; k < 3; k++) t->list[count].at[k] = at[k];
}

static void over_face(const above *t, int count, double weight, const double *at, int kind, int first, int second)
{
    const int own[2] = {t->face, 0}, other[2] = {first, second};
    add(t, count, weight, at, JO_PART_FACE, own, kind, other);
}

/* inner normal of a side of the face, and its end */
static void side_of(const above *t, int i, double *p, double *inwards)
{
    double q[3], e[3];
    jo_polytope_vertex(t->own, jo_polytope_corner(t->own, t->face, i), p);
    jo_polytope_vertex(t->own, jo_polytope_corner(t->own, t->face, i + 1), q);
    jo_minus3d(e, q, p);
    jo_cross3d(inwards, t->normal, e);
    jo_unit3d(inwards);
}

/* distance of a place from the nearest side of the face */
static double inside(const above *t, const double *x)
{
    double least = INFINITY, p[3], m[3];
    for (int i = 0; i < jo_polytope_corners(t->own, t->face); i++) {
        side_of(t, i, p, m);
        least = fmin(least, dot_vertex(m, x, p));
    }
    return least;
}

/* centre of an end of the other shape */
static void end_of(const above *t, int end, double *c)
{
    const double h = (end ? 1.0 : -1.0) * JO_RE(t->other->size[1]);
    for (int i = 0; i < 3; i++) c[i] = t->other->r[i] + h * t->other->R[3 * i + 2];
}

/* a quarter of its rim from the lowest place; the first axis where it does not lean */
static void on_rim(const above *t, int end, int quarter, double *x)
{
    double u[3], v[3];
    end_of(t, end, x);
    for (int i = 0; i < 3; i++) u[i] = -t->normal[i] + t->up * t->axis[i];
    if (!(sqrt(jo_dot3d(u, u)) > JO_ON_BORDER))
        for (int i = 0; i < 3; i++) u[i] = t->other->R[3 * i];
    jo_unit3d(u);
    jo_cross3d(v, t->axis, u);
    const double *e = quarter % 2 ? v : u, r = (quarter > 1 ? -1.0 : 1.0) * JO_RE(t->other->size[0]);
    for (int i = 0; i < 3; i++) x[i] += r * e[i];
}

static int lowest_of_rim(const above *t)
{
    double x[3];
    on_rim(t, t->end, 0, x);
    over_face(t, 0, 1.0, x, JO_PART_RIM, t->end, 0);
    return 1;
}

static int stands(const above *t)
{
    double c[3], x[3];
    end_of(t, t->end, c);
    const double r = JO_RE(t->other->size[0]), sine = sqrt(fmax(0.0, 1.0 - t->up * t->up));
    if (inside(t, c) < r) {
        on_rim(t, t->end, 0, x);
        const double leans = jo_dot3d(t->normal, x) - t->offset + JO_EIGHTH * r * sine;
        if (!(leans > 0.0)) return jo_face_corners(t->own, t->other, t->face, t->of_b, t->list);
        return inside(t, x) < 0.0 ? 0 : lowest_of_rim(t);
    }
    for (int k = 0; k < 4; k++) {
        on_rim(t, t->end, k, x);
        over_face(t, k, 1.0, x, JO_PART_RIM, t->end, k);
    }
    return 4;
}

/* both ends of the line of its side, or its crossings with sides of the face */
static int lies(const above *t)
{
    double x[2][3], p[3], m[3], from = 0.0, to = 1.0;
    int cut[2] = {-1, -1};
    for (int end = 0; end < 2; end++) on_rim(t, end, 0, x[end]);
    for (int i = 0; i < jo_polytope_corners(t->own, t->face); i++) {
        side_of(t, i, p, m);
        const double d = dot_vertex(m, x[0], p), e = dot_vertex(m, x[1], p), share = d / (d - e);
        if (d < 0.0 && e < 0.0) return 0;
        if (d < 0.0 && share > from) {
            from = share;
            cut[0] = i;
        } else if (e < 0.0 && share < to) {
            to = share;
            cut[1] = i;
        }
    }
    if (!(to - from > JO_SHORT)) return 0;
    for (int k = 0; k < 2; k++) {
        static const int side[2] = {0, 0};
        const double share = k ? to : from, at[3] = {x[0][0] + share * (x[1][0] - x[0][0]), x[0][1] + share * (x[1][1] - x[0][1]), x[0][2] + share * (x[1][2] - x[0][2])};
        if (cut[k] < 0) {
            over_face(t, k, to - from, at, JO_PART_RIM, k, 0);
            continue;
        }
        const int first = jo_polytope_corner(t->own, t->face, cut[k]), next = jo_polytope_corner(t->own, t->face, cut[k] + 1);
        const int own[2] = {first < next ? first : next, first < next ? next : first};
        add(t, k, to - from, at, JO_PART_EDGE, own, JO_PART_EDGE, side);
    }
    return 2;
}

static int on_face(const jo_polytope *a, const jo_polytope *b, int kind, int face, jo_corner *list)
{
    above t = {a, b, 0, 0, face, kind == JO_FACE_B, 0, {0.0}, 0.0, {0.0}, 0.0, list};
    t.own = t.of_b ? b : a;
    t.other = t.of_b ? a : b;
    t.offset = jo_polytope_face(t.own, face, t.normal);
    if (!t.other->round) return jo_face_corners(t.own, t.other, face, t.of_b, list);
    if (t.other->round == JO_ROUND_ELLIPSOID) {
        const double back[3] = {-t.normal[0], -t.normal[1], -t.normal[2]};
        double x[3];
        jo_polytope_extreme(t.other, back, 0, x);
        over_face(&t, 0, 1.0, x, JO_PART_WHOLE, 0, 0);
        return 1;
    }
    for (int i = 0; i < 3; i++) t.axis[i] = t.other->R[3 * i + 2];
    t.up = jo_dot3d(t.axis, t.normal);
    t.end = t.up < 0.0;
    const int count = fabs(t.up) > JO_NEAR_FACE ? stands(&t) : fabs(t.up) < JO_LIES ? lies(&t) : 0;
    return count ? count : lowest_of_rim(&t);
}

/* A line of a shape that may touch another one along its length: side of a cylinder or edge of a polytope at its vertex v, with the ends x */
typedef struct { const jo_polytope *p; int of[2]; double x[2][3], along[3], length; } line;

static void set_line(line *t)
{
    for (int i = 0; i < 2 && !t->p->round; i++) jo_polytope_vertex(t->p, t->of[i], t->x[i]);
    for (int i = 0; i < 3 && t->p->round; i++)
        for (int end = 0; end < 2; end++) t->x[end][i] = t->p->r[i] + (end ? 1.0 : -1.0) * JO_RE(t->p->size[1]) * t->p->R[3 * i + 2];
    jo_minus3d(t->along, t->x[1], t->x[0]);
    t->length = jo_unit3d(t->along);
}

static double sine_between(const double *e, const double *k)
{
    double n[3];
    jo_cross3d(n, e, k);
    return sqrt(jo_dot3d(n, n));
}

/* the edge at the support along n that is parallel to e */
static int parallel_edge(line *t, const double *n, const double *e)
{
    const int v = jo_polytope_support(t->p, n, 0);
    for (int k = jo_whole(t->p->near[v]); k < jo_whole(t->p->near[v + 1]); k++) {
        const int w = jo_whole(t->p->neighbour[k]);
        t->of[0] = v < w ? v : w;
        t->of[1] = v < w ? w : v;
        set_line(t);
        if (sine_between(t->along, e) < JO_SIDE_BY_SIDE) return 1;
    }
    return 0;
}

/* lines of both that are parallel to each other and across the normal */
static int parallel_lines(const jo_polytope *a, const jo_polytope *b, const double *n, line *both)
{
    const double back[3] = {-n[0], -n[1], -n[2]};
    both[0].p = a;
    both[1].p = b;
    for (int s = 0; s < 2; s++) {
        both[s].of[0] = both[s].of[1] = 0;
        if (both[s].p->round == JO_ROUND_CYLINDER) set_line(&both[s]);
        else if (both[s].p->round || both[s].p->vertices < 2) return 0;
    }
    const int round = a->round ? 0 : 1;
    if (fabs(jo_dot3d(both[round].along, n)) > JO_SIDE_BY_SIDE) return 0;
    if (a->round && b->round) return sine_between(both[0].along, both[1].along) < JO_SIDE_BY_SIDE;
    return parallel_edge(&both[1 - round], round ? n : back, both[round].along);
}

/* where two parallel lines are beside each other: each end is one of a line, over the other line */
static int along_lines(const jo_polytope *a, const jo_polytope *b, const jo_separated *s, jo_corner *list)
{
    line both[2];
    int count = 0;
    double at[2] = {0.0, 0.0};
    if (!parallel_lines(a, b, s->normal, both)) return 0;
    const double least = fmin(both[0].length, both[1].length), *e = both[0].along;
    for (int own = 1; own >= 0; own--)
        for (int end = 0; end < 2 && count < 2; end++) {
            const line *t = &both[own], *other = &both[1 - own];
            const double from = dot_vertex(other->along, t->x[end], other->x[0]), place = dot_vertex(e, t->x[end], both[0].x[0]);
            if (from < -JO_ON_BORDER * least || from > other->length + JO_ON_BORDER * least) continue;
            if (count && fabs(place - at[0]) < JO_SHORT * least) continue;
            const int kind = t->p->round ? JO_PART_RIM : JO_PART_VERTEX, which = t->p->round ? end : t->of[end];
            const int part[2] = {own ? JO_PART_EDGE : kind, own ? kind : JO_PART_EDGE};
            const int of[4] = {own ? other->of[0] : which, own ? other->of[1] : 0, own ? which : other->of[0], own ? 0 : other->of[1]};
            list[count].code = jo_part_code(a, b, part, of, s->normal);
            for (int i = 0; i < 3; i++) list[count].at[i] = t->x[end][i];
            at[count++] = place;
        }
    if (count < 2) return 0;
    /* of an edge of a polytope the length of the cylinder counts */
    const double whole = a->round == b->round || a->vertices == 2 || b->vertices == 2 ? least : both[a->round ? 0 : 1].length;
    list[0].weight = list[1].weight = fabs(at[1] - at[0]) / whole;
    return 2;
}

int jo_round_corners(const jo_polytope *a, const jo_polytope *b, const jo_separated *s, jo_corner *list)
{
    if (s->kind != JO_ROUND_PARTS) return on_face(a, b, s->kind, s->of[0], list);
    if (s->near != JO_CLOSEST_POINTS) {
        const int several = on_face(a, b, s->near, s->near_face, list);
        if (several > 1) return several;
    }
    const int beside = along_lines(a, b, s, list);
    if (beside) return beside;
    list->code = jo_part_code(a, b, s->part, s->of, s->normal);
    list->weight = 1.0;
    jo_polytope_extreme(a, s->normal, 0, list->at);
    return 1;
}
