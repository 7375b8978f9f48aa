/* corners.c - corners of the area in which two polytopes touch, with their weights.
 *
 * The face of one that is nearly parallel to the touching face of the other is cut by the sides of the latter (Sutherland, Hodgman,
 * Communications of the ACM 17 (1974), 32-42). Each corner that remains is a vertex over a face, or a crossing of two edges. Weights: 4 for
 * whole faces; their sum follows the area, their centre is that of the area. They are w = q (c + d . x), q being the turning angle of the
 * boundary at the corner, so that a corner within a straight side has none, and two corners that meet are one. */
#include "contact/polytope.h"

enum { JO_ROOM = 128 };             /* corners while a face is cut */
#define JO_WITHIN 1e-9              /* distance from a side, over the size, up to which a point is on it */
#define JO_STRAIGHT 1e-4            /* turning angle of a corner that is left out, rad */
#define JO_NEARLY_FLAT 0.995        /* cosine of the angle of the normal of two edges with that of the face, below which they are no corner */
#define JO_BESIDE 1e-3              /* sine of the angle of two edges up to which they touch along their length */
#define JO_LEAST_WEIGHT 1e-6        /* weight of a corner that is left out */
#define JO_CORNERS_PER_FACE 4.0     /* weight of a whole face */

/* A corner: place; vertex of the other polytope, or crossing of its edge (of[0], of[1]) with side `side`, or a vertex of the face itself.
 * The edge to the next corner: edge of the other polytope, or `along` a side. */
typedef struct { double x[3]; int kind, of[2], side, edge[2], along; } cut;
enum { OTHER_VERTEX, CROSSING, OWN_VERTEX };

typedef struct {
    const jo_polytope *own, *other;
    int face, other_face, of_b;     /* face of own; of_b: own is b */
    double normal[3], size;         /* outward normal of the face */
    int count;
    cut at[JO_ROOM];
} area;

static void ends(const area *t, int side, double *p, double *q)
{
    jo_polytope_vertex(t->own, jo_polytope_corner(t->own, t->face, side), p);
    jo_polytope_vertex(t->own, jo_polytope_corner(t->own, t->face, side + 1), q);
}

/* crossing of the edge from `from` with a side, at share x of it */
static void cross(const area *t, const cut *from, const cut *to, double x, int side, cut *y)
{
    *y = *from;
    for (int i = 0; i < 3; i++) y->x[i] = from->x[i] + x * (to->x[i] - from->x[i]);
    y->kind = CROSSING;
    y->side = side;
    y->of[0] = from->edge[0];
    y->of[1] = from->edge[1];
    if (from->along < 0) return;
    double p[3], q[3], u[3], v[3];   /* along another side: a vertex of the face, the nearer end of the side */
    ends(t, side, p, q);
    jo_minus3d(u, y->x, p);
    jo_minus3d(v, y->x, q);
    y->kind = OWN_VERTEX;
    y->of[0] = jo_polytope_corner(t->own, t->face, jo_dot3d(u, u) < jo_dot3d(v, v) ? side : side + 1);
}

/* leaves what is on the inner side of a side of the face */
static void cut_by(area *t, int side)
{
    double p[3], q[3], e[3], m[3], depth[JO_ROOM];
    cut kept[JO_ROOM];
    int count = 0;
    ends(t, side, p, q);
    jo_minus3d(e, q, p);
    jo_cross3d(m, e, t->normal);
    jo_unit3d(m);
    for (int i = 0; i < t->count; i++) {
        jo_minus3d(e, t->at[i].x, p);
        depth[i] = JO_WITHIN * t->size - jo_dot3d(m, e);
    }
    for (int i = 0; i < t->count && count + 2 <= JO_ROOM; i++) {
        const int next = (i + 1) % t->count, in = depth[i] >= 0.0, next_in = depth[next] >= 0.0;
        if (in) kept[count++] = t->at[i];
        if (in == next_in || t->count == 1) continue;
        cross(t, &t->at[i], &t->at[next], depth[i] / (depth[i] - depth[next]), side, &kept[count]);
        if (in && t->other_face >= 0) kept[count].along = side;   /* a segment has no area that the side bounds */
        count++;
    }
    for (int i = 0; i < count; i++) t->at[i] = kept[i];
    t->count = count;
}

/* the face of the other polytope that looks most against the normal; all vertices if it has no faces */
static void start(area *t)
{
    double n[3], least = INFINITY;
    t->other_face = -1;
    for (int i = 0; i < t->other->faces; i++) {
        jo_polytope_face(t->other, i, n);
        if (jo_dot3d(n, t->normal) < least) {
            least = jo_dot3d(n, t->normal);
            t->other_face = i;
        }
    }
    const int whole = t->other_face < 0, all = whole ? t->other->vertices : jo_polytope_corners(t->other, t->other_face);
    t->count = all < JO_ROOM ? all : JO_ROOM;
    for (int i = 0; i < t->count; i++) {
        const int k = t->count - 1 - i;   /* counterclockwise seen along the normal of the face */
        const int v = whole ? k : jo_polytope_corner(t->other, t->other_face, k);
        const int next = whole ? (k + t->count - 1) % t->count : jo_polytope_corner(t->other, t->other_face, k + t->count - 1);
        const cut y = {{0.0}, OTHER_VERTEX, {v, v}, 0, {v, next}, -1};
        t->at[i] = y;
        jo_polytope_vertex(t->other, v, t->at[i].x);
    }
}

/* twice the area vector of corners, about the first one */
static double area_of(const area *t, double *centre)
{
    double sum = 0.0, first[3] = {0.0, 0.0, 0.0};
    for (int i = 1; i + 1 < t->count; i++) {
        double u[3], v[3], c[3];
        jo_minus3d(u, t->at[i].x, t->at[0].x);
        jo_minus3d(v, t->at[i + 1].x, t->at[0].x);
        jo_cross3d(c, u, v);
        const double part = jo_dot3d(c, t->normal);
        sum += part;
        for (int k = 0; k < 3; k++) first[k] += part * (u[k] + v[k]) / 3.0;
    }
    for (int k = 0; k < 3; k++) centre[k] = t->at[0].x[k] + (sum > 0.0 ? first[k] / sum : 0.0);
    return sum;
}

/* twice the area of the face itself; INFINITY for a half-space */
static double area_of_face(const area *t)
{
    double p[3], q[3], r[3], u[3], v[3], c[3], sum = 0.0;
    if (!t->own->vertices) return INFINITY;
    jo_polytope_vertex(t->own, jo_polytope_corner(t->own, t->face, 0), p);
    for (int i = 1; i + 1 < jo_polytope_corners(t->own, t->face); i++) {
        jo_polytope_vertex(t->own, jo_polytope_corner(t->own, t->face, i), q);
        jo_polytope_vertex(t->own, jo_polytope_corner(t->own, t->face, i + 1), r);
        jo_minus3d(u, q, p);
        jo_minus3d(v, r, p);
        jo_cross3d(c, u, v);
        sum += jo_dot3d(c, t->normal);
    }
    return sum;
}

/* angle by which the boundary turns at corner i, seen along the normal */
static double turn_at(const area *t, int i)
{
    const double *a = t->at[(i + t->count - 1) % t->count].x, *b = t->at[i].x, *c = t->at[(i + 1) % t->count].x;
    double u[3], v[3], w[3];
    jo_minus3d(u, b, a);
    jo_minus3d(v, c, b);
    jo_cross3d(w, u, v);
    return atan2(jo_dot3d(w, t->normal), jo_dot3d(u, v));
}

static void leave_out(area *t, int i)
{
    t->count--;
    for (; i < t->count; i++) t->at[i] = t->at[i + 1];
}

/* Whether a corner is a crossing of edges that press in another direction than the face, where these touch only if they overlap deeply: at an
 * angle to its normal, or, edges on the far side of a polytope, against it (by the rule of contact/feature.c). */
static int is_steep(const area *t, const cut *x)
{
    double own[2][3], other[2][3], centre[2][3], u[3], v[3], n[3], out[3];
    if (x->kind != CROSSING) return 0;
    ends(t, x->side, own[0], own[1]);
    for (int i = 0; i < 2; i++) jo_polytope_vertex(t->other, x->of[i], other[i]);
    jo_polytope_vertex(t->own, -1, centre[0]);
    jo_polytope_vertex(t->other, -1, centre[1]);
    jo_minus3d(u, own[1], own[0]);
    jo_minus3d(v, other[1], other[0]);
    jo_cross3d(n, u, v);
    jo_unit3d(n);
    for (int i = 0; i < 3; i++) out[i] = own[0][i] - centre[0][i] - other[0][i] + centre[1][i];
    const double along = jo_dot3d(n, t->normal);
    return !(fabs(along) > JO_NEARLY_FLAT) || jo_dot3d(n, out) * along < 0.0;
}

/* one of several corners at a place, none within a side, and the most marked ones if they are too many */
static void thin(area *t)
{
    for (int i = 0; i < t->count && t->count > 1;) {
        double d[3];
        jo_minus3d(d, t->at[i].x, t->at[(i + 1) % t->count].x);
        if (sqrt(jo_dot3d(d, d)) > 4.0 * JO_WITHIN * t->size) i++;
        else leave_out(t, t->at[i].kind == OTHER_VERTEX ? (i + 1) % t->count : i);
    }
    double turn[JO_ROOM];
    if (t->count > 2)
        for (int i = 0; i < t->count; i++) turn[i] = turn_at(t, i);
    while (t->count > 2) {
        int flattest = 0;
        double least = INFINITY;
        for (int i = 0; i < t->count; i++)
            if (turn[i] < least) {
                least = turn[i];
                flattest = i;
            }
        if (!(least < JO_STRAIGHT) && t->count <= JO_CORNERS) break;
        leave_out(t, flattest);
        for (int i = flattest; i < t->count; i++) turn[i] = turn[i + 1];
        const int after = flattest % t->count, before = (flattest + t->count - 1) % t->count;
        turn[after] = turn_at(t, after);
        turn[before] = turn_at(t, before);
    }
}

/* w_i = q_i (c + d . x_i), x_i from the centre in the plane: sum w_i = total, sum w_i x_i = 0; never negative */
static void weights(const area *t, const double *centre, double total, double *w)
{
    double q[JO_CORNERS], x[JO_CORNERS][2], e[3], f[3], S[5] = {0.0}, S0 = 0.0;   /* sums of q times x, y, xx, xy, yy */
    jo_minus3d(e, t->at[1].x, t->at[0].x);
    jo_unit3d(e);
    jo_cross3d(f, t->normal, e);
    jo_cross3d(e, f, t->normal);
    for (int i = 0; i < t->count; i++) {
        double r[3];
        jo_minus3d(r, t->at[i].x, centre);
        q[i] = fmax(turn_at(t, i), 0.0);
        x[i][0] = jo_dot3d(r, e);
        x[i][1] = jo_dot3d(r, f);
        S0 += q[i];
        S[0] += q[i] * x[i][0];
        S[1] += q[i] * x[i][1];
        S[2] += q[i] * x[i][0] * x[i][0];
        S[3] += q[i] * x[i][0] * x[i][1];
        S[4] += q[i] * x[i][1] * x[i][1];
    }
    const double D = S[2] * S[4] - S[3] * S[3];
    const double dx = D > 0.0 ? -(S[4] * S[0] - S[3] * S[1]) / D : 0.0, dy = D > 0.0 ? -(S[2] * S[1] - S[3] * S[0]) / D : 0.0;
    double sum = 0.0;
    for (int i = 0; i < t->count; i++) sum += w[i] = fmax(q[i] * (1.0 + dx * x[i][0] + dy * x[i][1]), 0.0);
    for (int i = 0; i < t->count; i++) w[i] *= sum > 0.0 ? total / sum : 0.0;
}

static double length_between(const double *p, const double *q)
{
    double d[3];
    jo_minus3d(d, q, p);
    return sqrt(jo_dot3d(d, d));
}

static double code_of(const area *t, const cut *x)
{
    int own[2] = {t->face, 0}, other[2] = {x->of[0], 0}, dimension[2] = {2, 0};
    if (x->kind == CROSSING) {
        own[0] = jo_polytope_corner(t->own, t->face, x->side);
        own[1] = jo_polytope_corner(t->own, t->face, x->side + 1);
        other[1] = x->of[1];
        dimension[0] = dimension[1] = 1;
    } else if (x->kind == OWN_VERTEX) {
        own[0] = x->of[0];
        other[0] = t->other_face;
        dimension[0] = 0;
        dimension[1] = 2;
    }
    const jo_feature_pair along = {3 * dimension[0] + dimension[1], {own[0], own[1]}, {other[0], other[1]}};
    const jo_feature_pair back = {3 * dimension[1] + dimension[0], {other[0], other[1]}, {own[0], own[1]}};
    return jo_feature_code(t->of_b ? &back : &along);
}

/* the vertex that is deepest below the face, where nothing lies over the face */
static void deepest(area *t)
{
    const double back[3] = {-t->normal[0], -t->normal[1], -t->normal[2]};
    const int v = jo_polytope_support(t->other, back, 0);
    const cut y = {{0.0}, OTHER_VERTEX, {v, v}, 0, {v, v}, -1};
    t->at[0] = y;
    t->count = 1;
    jo_polytope_vertex(t->other, v, t->at[0].x);
}

/* the corners that count; their number */
static int listed(const area *t, const double *w, jo_corner *list)
{
    int count = 0;
    for (int i = 0; i < t->count; i++) {
        if (!(w[i] > JO_LEAST_WEIGHT) || is_steep(t, &t->at[i])) continue;
        list[count].code = code_of(t, &t->at[i]);
        list[count].weight = w[i];
        for (int k = 0; k < 3; k++) list[count].at[k] = t->at[i].x[k];
        count++;
    }
    return count;
}

static int corners_of_faces(area *t, jo_corner *list)
{
    double w[JO_CORNERS] = {1.0}, centre[3], ends_of[2][3];
    start(t);
    const int segment = t->other_face < 0 && t->count == 2;
    double whole = area_of(t, centre);
    if (segment)
        for (int i = 0; i < 2; i++) jo_polytope_vertex(t->other, i, ends_of[i]);
    const int sides = t->own->vertices ? jo_polytope_corners(t->own, t->face) : 0;
    for (int i = 0; i < sides && t->count > 0; i++) cut_by(t, i);
    const double face = area_of_face(t), part = area_of(t, centre);
    whole = fmin(whole, face);
    if (!t->count) deepest(t);
    thin(t);
    if (t->count > 2) {
        weights(t, centre, JO_CORNERS_PER_FACE * part / whole, w);
    } else if (t->count == 2) {
        w[0] = w[1] = segment ? length_between(t->at[0].x, t->at[1].x) / length_between(ends_of[0], ends_of[1]) : 1.0;
    }
    const int count = listed(t, w, list);
    if (count) return count;
    deepest(t);
    w[0] = 1.0;
    return listed(t, w, list);
}

/* Two parallel edges touch where they lie beside each other: at the ends of that length, each a vertex of one over the edge of the other. The
 * weight of an end is the length over that of a segment, as above a face. A segment has an edge also where its vertex is the closest point.
 * Their number; 0 if the edges are not parallel. */
static int along_edges(const jo_polytope *a, const jo_polytope *b, const jo_separated *s, jo_corner *list)
{
    const jo_polytope *const both[2] = {a, b};
    int of[4];
    for (int i = 0; i < 4; i++) of[i] = s->of[i];
    for (int k = 0; k < 2; k++)
        if (both[k]->vertices == 2) of[2 * k + 1] = 1 - of[2 * k];
    const int known = of[0] != of[1] ? 0 : 1;
    if (of[2 * known] == of[2 * known + 1]) return 0;
    double at[4][3], e[2][3], length[2], n[3];
    for (int i = 0; i < 2; i++) jo_polytope_vertex(both[known], of[2 * known + i], at[i]);
    jo_minus3d(e[known], at[1], at[0]);
    jo_unit3d(e[known]);
    /* the other edge, where it is parallel: its ends are furthest along the normal, tilted both ways */
    for (int side = -1; side <= 1; side += 2) {
        for (int c = 0; c < 3; c++) n[c] = (known ? 1.0 : -1.0) * s->normal[c] + side * JO_BESIDE * e[known][c];
        const int at_other = 2 * (1 - known);
        of[at_other + (side > 0)] = jo_polytope_support(both[1 - known], n, s->of[at_other]);
    }
    if (of[0] == of[1] || of[2] == of[3]) return 0;
    for (int i = 0; i < 4; i++) jo_polytope_vertex(both[i > 1], of[i], at[i]);
    for (int k = 0; k < 2; k++) {
        jo_minus3d(e[k], at[2 * k + 1], at[2 * k]);
        length[k] = jo_unit3d(e[k]);
    }
    jo_cross3d(n, e[0], e[1]);
    if (!(jo_dot3d(n, n) <= JO_BESIDE * JO_BESIDE)) return 0;
    static const int order[4] = {2, 3, 0, 1};
    int count = 0;
    for (int j = 0; j < 4 && count < 2; j++) {
        const int i = order[j], edge = i < 2;   /* vertex i of b over the edge 0, that of a, or of a over that of b */
        double d[3];
        jo_minus3d(d, at[i], at[2 * edge]);
        const double x = jo_dot3d(d, e[edge]), rounding = JO_WITHIN * length[edge];
        if (x < -rounding || x > length[edge] + rounding) continue;
        if (count) {
            jo_minus3d(d, at[i], list->at);
            if (fabs(jo_dot3d(d, e[edge])) <= 4.0 * rounding) continue;
        }
        const jo_feature_pair over_a = {JO_EDGE_VERTEX, {of[0], of[1]}, {of[i], of[i]}}, over_b = {JO_VERTEX_EDGE, {of[i], of[i]}, {of[2], of[3]}};
        list[count].code = jo_feature_code(edge ? &over_b : &over_a);
        for (int k = 0; k < 3; k++) list[count].at[k] = at[i][k];
        count++;
    }
    if (count < 2) return 0;
    double part[3];
    jo_minus3d(part, list[1].at, list[0].at);
    const double whole = a->vertices > 2 ? length[1] : b->vertices > 2 ? length[0] : fmin(length[0], length[1]);
    list[0].weight = list[1].weight = fabs(jo_dot3d(part, e[0])) / whole;
    return 2;
}

/* two edges, or closest points that are no face */
static int one_corner(const jo_polytope *a, const jo_separated *s, jo_corner *list)
{
    jo_feature_pair f = {JO_EDGE_EDGE, {s->of[0], s->of[1]}, {s->of[2], s->of[3]}};
    if (s->kind == JO_CLOSEST_POINTS) f.kind = 3 * (s->count[0] > 1) + (s->count[1] > 1);
    list->code = jo_feature_code(&f);
    list->weight = 1.0;
    jo_polytope_vertex(a, s->of[0], list->at);
    return 1;
}

int jo_face_corners(const jo_polytope *own, const jo_polytope *other, int face, int of_b, jo_corner *list)
{
    area t;
    t.own = own;
    t.other = other;
    t.face = face;
    t.of_b = of_b;
    t.size = 0.0;
    jo_polytope_face(t.own, t.face, t.normal);
    for (int i = 0; i < t.other->vertices && i < 2; i++) {   /* any length of the other polytope, and more than 0 */
        double p[3], c[3];
        jo_polytope_vertex(t.other, i, p);
        jo_polytope_vertex(t.other, -1, c);
        t.size = fmax(t.size, length_between(p, c));
    }
    return corners_of_faces(&t, list);
}

int jo_corners(const jo_polytope *a, const jo_polytope *b, const jo_separated *s, jo_corner *list)
{
    const int several = s->kind == JO_CLOSEST_POINTS ? along_edges(a, b, s, list) : 0;
    if (several) return several;
    if (s->kind == JO_EDGES || s->kind == JO_CLOSEST_POINTS) return one_corner(a, s, list);
    const int of_b = s->kind == JO_FACE_B;
    return jo_face_corners(of_b ? b : a, of_b ? a : b, s->of[0], of_b, list);
}
