/* part.c - parts of convex shapes: the place that is farthest along a normal, and two parts that are closest to each other.
 *
 * p(m) is the place of a part that is farthest along its outward normal m, dp = W dm. For the normal n from a to b the gap n . (p_b(-n) - p_a(n)) is
 * largest where p_b - p_a = g n: there its derivatives with respect to n are p_b - p_a and -(W_a + W_b + g), so that Newton's method turns n by
 *   (W_a + W_b + g) dn = p_b - p_a   in the plane across n; across an edge only about it; two edges and faces have their n.
 * A code names the direction n coarsely: with the pose at the start of a step it is within some 3e-3 rad of the closest one, and no further state is
 * needed. */
#include "contact/round.h"

enum { JO_TURNS = 40, JO_CODED = 1024 };    /* turns of Newton's method, some 4; numbers of a direction in a code */
#define JO_SMALL_TURN 1e-7      /* rad, after which the next turn is exact */
#define JO_CLEARLY 0.999        /* share of a component of a direction up to which another one is smaller */
#define JO_LARGEST_TURN 0.4     /* rad */
#define JO_CROSSED 1e-10       /* sine of the angle below which two edges do not cross, or an edge is along a direction */
#define JO_STANDS 1e-9          /* tilt, rad, below which the quarters of a rim do not follow its lowest point, as in contact_tip.c */

int jo_part_pair(const jo_feature_pair *f, int *part)
{
    if (f->kind < JO_ROUND_PAIR) return 0;
    part[0] = (f->kind - JO_ROUND_PAIR) / JO_PARTS;
    part[1] = (f->kind - JO_ROUND_PAIR) % JO_PARTS;
    return 1;
}

int jo_part_is_quarter(const jo_feature_pair *f)
{
    int part[2];
    if (!jo_part_pair(f, part)) return 0;
    return (part[0] == JO_PART_RIM && part[1] == JO_PART_FACE && f->a[1]) || (part[1] == JO_PART_RIM && part[0] == JO_PART_FACE && f->b[1]);
}

static double vertex_height(const jo_polytope *p, int i, const double *n)
{
    const jo_real *x = p->vertex + 3 * i;
    return n[0] * JO_RE(x[0]) + n[1] * JO_RE(x[1]) + n[2] * JO_RE(x[2]);
}

double jo_part_height(const jo_polytope *p, int kind, const int *of, const double *n)
{
    if (kind == JO_PART_VERTEX) return vertex_height(p, of[0], n);
    if (kind == JO_PART_EDGE && of[0] != of[1]) return fmax(vertex_height(p, of[0], n), vertex_height(p, of[1], n));
    if (kind == JO_PART_RIM) return JO_RE(p->size[0]) * hypot(n[0], n[1]) + (of[0] ? 1.0 : -1.0) * JO_RE(p->size[1]) * n[2];
    return jo_polytope_height(p, n);
}

static void unit(jo_real *x)
{
    const jo_real size = jo_sqrt(jo_dot3(x, x));
    for (int i = 0; i < 3; i++) x[i] /= size;
}

/* two unit vectors across n; round-off of n does not change which ones */
static void across(const jo_real *n, jo_real *t, jo_real *b)
{
    jo_real e[3] = {0.0, 0.0, 0.0};
    int least = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(JO_RE(n[i])) < JO_CLEARLY * fabs(JO_RE(n[least])) - JO_CROSSED) least = i;
    e[least] = jo_same(1.0);
    jo_cross(t, n, e);
    unit(t);
    jo_cross(b, n, t);
}

/* ---- directions in codes ------------------------------------------------------------------------------ */

/* the numbers of a pair that are free for a direction; their count */
static int free_numbers(const int *part, int *of, int **at)
{
    int count = 0;
    for (int s = 0; s < 2; s++) {
        if (part[1 - s] == JO_PART_FACE) return 0;   /* its normal is known */
        if (part[s] == JO_PART_WHOLE) at[count++] = of + 2 * s;
        if (part[s] == JO_PART_WHOLE || part[s] == JO_PART_RIM || part[s] == JO_PART_VERTEX) at[count++] = of + 2 * s + 1;
    }
    return part[0] == JO_PART_FACE ? 0 : count;
}

int jo_same_parts(double code, double other)
{
    int part[2][2], of[2][4], *at[4];
    if (code == other) return 1;
    for (int k = 0; k < 2; k++) {
        const jo_feature_pair f = jo_feature_of(k ? other : code);
        if (!jo_part_pair(&f, part[k])) return 0;
        for (int i = 0; i < 4; i++) of[k][i] = i < 2 ? f.a[i] : f.b[i - 2];
        const int count = free_numbers(part[k], of[k], at);
        for (int i = 0; i < count; i++) *at[i] = 0;
    }
    for (int i = 0; i < 4; i++)
        if (of[0][i] != of[1][i]) return 0;
    return part[0][0] == part[1][0] && part[0][1] == part[1][1];
}

static int coded(double x)   /* -1 ... 1 */
{
    const int i = (int)(0.5 * (x + 1.0) * JO_CODED);
    return i < 0 ? 0 : i < JO_CODED ? i : JO_CODED - 1;
}
static double decoded(int i) { return 2.0 * (i + 0.5) / JO_CODED - 1.0; }
static double sign(double x) { return x < 0.0 ? -1.0 : 1.0; }

/* direction of the edge of a pair with one number, in the frame of its body */
static void edge_alone(const jo_polytope *p, const int *of, jo_real *e)
{
    for (int i = 0; i < 3; i++) e[i] = of[0] == of[1] ? jo_same(i == 2) : p->vertex[3 * of[1] + i] - p->vertex[3 * of[0] + i];
    unit(e);
}

/* The direction: by the octahedron of both numbers, of which the lower half is folded out; by its angle about an edge. */
double jo_part_code(const jo_polytope *a, const jo_polytope *b, const int *part, const int *of, const double *n)
{
    int numbers[4] = {of[0], of[1], of[2], of[3]}, *at[4];
    const int count = free_numbers(part, numbers, at);
    if (count == 1) {
        const int side = part[1] == JO_PART_EDGE;
        const double *R = b->R;
        jo_real e[3], t[3], s[3], m[3] = {n[0], n[1], n[2]};
        for (int i = 0; i < 3 && side; i++) m[i] = jo_same(R[i] * n[0] + R[3 + i] * n[1] + R[6 + i] * n[2]);
        edge_alone(side ? b : a, of + 2 * side, e);
        across(e, t, s);
        *at[0] = coded(atan2(JO_RE(jo_dot3(m, s)), JO_RE(jo_dot3(m, t))) / JO_PI);
    } else if (count > 1) {
        const double size = fabs(n[0]) + fabs(n[1]) + fabs(n[2]), x = n[0] / size, y = n[1] / size;
        *at[0] = coded(n[2] < 0.0 ? (1.0 - fabs(y)) * sign(x) : x);
        *at[1] = coded(n[2] < 0.0 ? (1.0 - fabs(x)) * sign(y) : y);
    }
    const jo_feature_pair f = {JO_ROUND_PAIR + JO_PARTS * part[0] + part[1], {numbers[0], numbers[1]}, {numbers[2], numbers[3]}};
    return jo_feature_code(&f);
}

void jo_part_direction(const jo_feature_pair *f, const jo_part *a, const jo_part *b, const jo_real *R, jo_real *n)
{
    int part[2], numbers[4] = {f->a[0], f->a[1], f->b[0], f->b[1]}, *at[4];
    jo_part_pair(f, part);
    const int count = free_numbers(part, numbers, at);
    for (int i = 0; i < 3; i++) n[i] = jo_same(i == 2);
    if (count == 1) {
        const int side = part[1] == JO_PART_EDGE;
        const double angle = JO_PI * decoded(*at[0]);
        jo_real e[3], t[3], s[3];
        if (side) jo_mul3t(e, R, b->along);
        else jo_set3(e, a->along);
        across(e, t, s);
        for (int i = 0; i < 3; i++) t[i] = cos(angle) * t[i] + sin(angle) * s[i];
        if (side) jo_mul3(n, R, t);
        else jo_set3(n, t);
    } else if (count > 1) {
        const double x = decoded(*at[0]), y = decoded(*at[1]), z = 1.0 - fabs(x) - fabs(y), fold = z < 0.0 ? -z : 0.0;
        n[0] = jo_same(x - sign(x) * fold);
        n[1] = jo_same(y - sign(y) * fold);
        n[2] = jo_same(z);
        unit(n);
    }
}

/* ---- places ------------------------------------------------------------------------------------------- */

static void to_a(const jo_real *r, const jo_real *R, jo_real *x)
{
    if (!R) return;
    jo_real y[3];
    jo_mul3(y, R, x);
    for (int i = 0; i < 3; i++) x[i] = y[i] + (r ? r[i] : jo_same(0.0));
}

/* plane of a face, its place nearest to the origin of its body */
static void face_part(const jo_polytope *p, int face, jo_part *y)
{
    const jo_real *plane = p->plane + 4 * face;
    for (int i = 0; i < 3; i++) {
        y->along[i] = plane[i];
        y->at[i] = plane[3] * plane[i];
    }
}

static void edge_part(const jo_polytope *p, const int *of, jo_part *y)
{
    edge_alone(p, of, y->along);
    if (of[0] == of[1]) {
        y->radius = p->size[0];
        return;
    }
    for (int i = 0; i < 3; i++) {
        y->at[i] = p->vertex[3 * of[0] + i];
        y->out[i] = p->faces ? y->at[i] - p->centre[i] : jo_same(0.0);
    }
}

static void rim_part(const jo_polytope *p, const int *of, int over_face, jo_part *y)
{
    static const double cosines[4] = {1.0, 0.0, -1.0, 0.0}, sines[4] = {0.0, 1.0, 0.0, -1.0};
    const int quarter = over_face ? of[1] % 4 : 0;
    y->at[2] = of[0] ? p->size[1] : -p->size[1];
    y->along[2] = y->first[0] = jo_same(1.0);
    y->radius = p->size[0];
    y->stands = over_face;
    y->cosine = cosines[quarter];
    y->sine = sines[quarter];
}

jo_part jo_part_of(const jo_polytope *p, int kind, const int *of, int over_face, const jo_real *r, const jo_real *R)
{
    static const jo_part none;
    jo_part y = none;
    y.kind = kind;
    switch (kind) {
    case JO_PART_VERTEX: jo_set3(y.at, p->vertex + 3 * of[0]); break;
    case JO_PART_EDGE: edge_part(p, of, &y); break;
    case JO_PART_FACE: face_part(p, of[0], &y); break;
    case JO_PART_RIM: rim_part(p, of, over_face, &y); break;
    default:
        jo_set3(y.size, p->size);
        for (int i = 0; i < 9; i++) y.R[i] = R ? R[i] : jo_same(i % 4 == 0);
    }
    to_a(r, R, y.at);
    to_a(0, R, y.along);
    to_a(0, R, y.first);
    to_a(0, R, y.out);
    return y;
}

/* W = x y^T */
static void product(jo_real *W, jo_real scale, const jo_real *x, const jo_real *y)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) W[3 * i + j] += scale * x[i] * y[j];
}

/* of a rim: at + radius (c u + s z x u), u the direction of m across the axis z */
static void on_rim(const jo_part *t, const jo_real *m, jo_real *p, jo_real *W)
{
    jo_real u[3], q[3], v[3];
    const jo_real up = jo_dot3(m, t->along);
    for (int i = 0; i < 3; i++) u[i] = m[i] - up * t->along[i] + (t->stands ? JO_STANDS * t->first[i] : jo_same(0.0));
    const jo_real square = jo_dot3(u, u), size = JO_RE(square) > 0.0 ? jo_sqrt(square) : jo_same(0.0);
    for (int i = 0; i < 3; i++) u[i] = JO_RE(size) > 0.0 ? u[i] / size : t->first[i];
    jo_cross(q, t->along, u);
    for (int i = 0; i < 3; i++) {
        p[i] += t->radius * (t->cosine * u[i] + t->sine * q[i]);
        v[i] = t->cosine * q[i] - t->sine * u[i];
    }
    if (JO_RE(size) > 0.0) product(W, t->radius / size, v, q);
}

/* of an ellipsoid: R D^2 R^T m / h, h = |D R^T m| */
static void on_ellipsoid(const jo_part *t, const jo_real *m, jo_real *p, jo_real *W)
{
    jo_real local[3], x[3], axis[3], square = jo_same(0.0);
    jo_mul3t(local, t->R, m);
    for (int i = 0; i < 3; i++) square += t->size[i] * t->size[i] * local[i] * local[i];
    const jo_real h = jo_sqrt(square);
    for (int i = 0; i < 3; i++) local[i] *= t->size[i] * t->size[i] / h;
    jo_mul3(x, t->R, local);
    jo_add3(p, x);
    for (int i = 0; i < 3; i++) {
        jo_axis(axis, t->R, i);
        product(W, t->size[i] * t->size[i] / h, axis, axis);
    }
    product(W, -1.0 / h, x, x);
}

static void place(const jo_part *t, const jo_real *m, jo_real *p, jo_real *W)
{
    for (int i = 0; i < 9; i++) W[i] = jo_same(0.0);
    jo_set3(p, t->at);
    if (t->kind == JO_PART_RIM) on_rim(t, m, p, W);
    if (t->kind == JO_PART_WHOLE) on_ellipsoid(t, m, p, W);
    if (t->kind == JO_PART_EDGE) {
        jo_axpy3(p, t->radius, m);
        for (int i = 0; i < 3; i++) W[4 * i] = t->radius;
        product(W, -t->radius, m, m);
    }
}

static void meet(const jo_part *a, const jo_part *b, const jo_real *n, jo_meeting *y)
{
    const jo_real back[3] = {-n[0], -n[1], -n[2]};
    jo_set3(y->n, n);
    place(a, n, y->a, y->bend[0]);
    place(b, back, y->b, y->bend[1]);
    jo_set3(y->apart, y->b);
    jo_sub3(y->apart, y->a);
    y->gap = jo_dot3(n, y->apart);
}

/* ---- closest places ----------------------------------------------------------------------------------- */

/* x . (W_a + W_b) y */
static jo_real bent(const jo_meeting *t, const jo_real *x, const jo_real *y)
{
    jo_real v[3], w[3];
    jo_mul3(v, t->bend[0], y);
    jo_mul3(w, t->bend[1], y);
    return jo_dot3(x, v) + jo_dot3(x, w);
}

/* Newton's turn of n; edge: 0 if n is free. 0: the gap has no largest value near, as of a corner that is below a rim */
static int turn_of(const jo_meeting *t, const jo_real *edge, jo_real *dn)
{
    jo_real u[2][3], H[3], x[2];
    if (edge) {
        jo_cross(u[0], edge, t->n);
        const jo_real k = bent(t, u[0], u[0]) + t->gap, f = jo_dot3(u[0], t->apart);
        for (int i = 0; i < 3; i++) dn[i] = f / k * u[0][i];
        return JO_RE(k) > 0.0;
    }
    across(t->n, u[0], u[1]);
    H[0] = bent(t, u[0], u[0]) + t->gap;
    H[1] = bent(t, u[0], u[1]);
    H[2] = bent(t, u[1], u[1]) + t->gap;
    const jo_real f[2] = {jo_dot3(u[0], t->apart), jo_dot3(u[1], t->apart)}, det = H[0] * H[2] - H[1] * H[1];
    x[0] = (H[2] * f[0] - H[1] * f[1]) / det;
    x[1] = (H[0] * f[1] - H[1] * f[0]) / det;
    for (int i = 0; i < 3; i++) dn[i] = x[0] * u[0][i] + x[1] * u[1][i];
    return JO_RE(H[0]) > 0.0 && JO_RE(det) > 0.0;
}

/* n + share dn, a unit vector, across the edge */
static void turned(const jo_real *n, jo_real share, const jo_real *dn, const jo_real *edge, jo_real *y)
{
    for (int i = 0; i < 3; i++) y[i] = n[i] + share * dn[i];
    if (edge) jo_axpy3(y, -jo_dot3(y, edge), edge);
    unit(y);
}

/* The gap grows with each turn; the last one is exact also in its derivatives. */
static int turn_to_closest(const jo_part *a, const jo_part *b, const jo_real *edge, jo_meeting *y)
{
    jo_real dn[3], n[3];
    for (int k = 0; k < JO_TURNS; k++) {
        jo_meeting next;
        if (!turn_of(y, edge, dn)) return 0;
        const double size = jo_length(dn, 3), before = JO_RE(y->gap);
        double share = size > JO_LARGEST_TURN ? JO_LARGEST_TURN / size : 1.0;
        for (int half = 0; half < JO_TURNS; half++, share *= 0.5) {
            turned(y->n, jo_same(share), dn, edge, n);
            meet(a, b, n, &next);
            if (JO_RE(next.gap) >= before || share * size < JO_SMALL_TURN) break;
        }
        *y = next;
        if (!(size > JO_SMALL_TURN)) break;
    }
    if (!turn_of(y, edge, dn)) return 0;
    turned(y->n, jo_same(1.0), dn, edge, n);
    meet(a, b, n, y);
    return 1;
}

/* normal of two edges that cross, out of a into b */
static int crossed(const jo_part *a, const jo_part *b, jo_real *n)
{
    jo_real out[3], apart[3];
    jo_cross(n, a->along, b->along);
    if (!(jo_length(n, 3) > JO_CROSSED)) return 0;
    unit(n);
    for (int i = 0; i < 3; i++) {
        out[i] = a->out[i] - b->out[i];
        apart[i] = b->at[i] - a->at[i];
    }
    const jo_real along = jo_length(out, 3) > 0.0 ? jo_dot3(n, out) : jo_dot3(n, apart);
    for (int i = 0; i < 3 && JO_RE(along) < 0.0; i++) n[i] = -n[i];
    return 1;
}

int jo_part_closest(const jo_part *a, const jo_part *b, const jo_real *start, jo_meeting *y)
{
    const int edge_a = a->kind == JO_PART_EDGE, edge_b = b->kind == JO_PART_EDGE;
    const jo_real *edge = edge_a ? a->along : edge_b ? b->along : 0;
    jo_real n[3];
    jo_set3(n, start);
    if (a->kind == JO_PART_FACE) jo_set3(n, a->along);
    for (int i = 0; i < 3 && b->kind == JO_PART_FACE; i++) n[i] = -b->along[i];
    if (edge_a && edge_b && !crossed(a, b, n)) return 0;
    const int known = a->kind == JO_PART_FACE || b->kind == JO_PART_FACE || (edge_a && edge_b);
    if (edge && !known) {
        jo_axpy3(n, -jo_dot3(n, edge), edge);
        if (!(jo_length(n, 3) > JO_CROSSED)) return 0;
        unit(n);
    }
    meet(a, b, n, y);
    return known || turn_to_closest(a, b, edge, y);
}
