/* feature.c - gap and normal of a vertex, edge or face of one polytope and one of another, and their derivatives.
 *
 * n: unit normal from a to b; foot points p_b - p_a = g n; s: displacement of the material foot point of b. Then dg = n . s, and n turns by two
 * conditions u_i . dn in its tangent plane: 0 along an edge or face of a, u . (phi x n) along one of b, u . s / g where neither holds it. */
#include "contact/round.h"

enum { JO_FIXED_A, JO_FIXED_B, JO_FREE };
#define JO_EDGES_CROSS 1e-20    /* square of the sine of the angle below which two edges do not cross */

static void vertex(const jo_polytope *p, int i, jo_real *y) { jo_set3(y, p->vertex + 3 * i); }

static void length1(jo_real *x)
{
    const jo_real length = jo_sqrt(jo_dot3(x, x));
    for (int i = 0; i < 3; i++) x[i] /= length;
}

/* two conditions and their dual vectors: d_i . u_j = 1 if i = j, else 0, in the tangent plane of n */
static void conditions(jo_feature *y, const jo_real *u0, int rule0, const jo_real *u1, int rule1)
{
    jo_set3(y->u[0], u0);
    jo_set3(y->u[1], u1);
    y->rule[0] = rule0;
    y->rule[1] = rule1;
    jo_cross(y->dual[0], y->u[1], y->normal);
    jo_cross(y->dual[1], y->normal, y->u[0]);
    const jo_real scale = jo_dot3(y->u[0], y->dual[0]);
    for (int i = 0; i < 3; i++) {
        y->dual[0][i] /= scale;
        y->dual[1][i] /= scale;
    }
}

/* both conditions by the same rule */
static void isotropic(jo_feature *y, int rule)
{
    int least = 0;
    jo_real axis[3] = {0.0, 0.0, 0.0}, u[3], v[3];
    for (int i = 1; i < 3; i++)
        if (fabs(JO_RE(y->normal[i])) < fabs(JO_RE(y->normal[least]))) least = i;
    axis[least] = 1.0;
    jo_cross(u, y->normal, axis);
    length1(u);
    jo_cross(v, y->normal, u);
    conditions(y, u, rule, v, rule);
}

/* w = n g, perpendicular to the edge e (0: none); sign of g */
static void apart(jo_feature *y, jo_real *w, const jo_real *e, int rule, double sign)
{
    if (e) jo_axpy3(w, -jo_dot3(w, e), e);
    y->gap = sign * jo_sqrt(jo_dot3(w, w));
    for (int i = 0; i < 3; i++) y->normal[i] = w[i] / y->gap;
    if (!e) {
        isotropic(y, JO_FREE);
        return;
    }
    jo_real c[3];
    jo_cross(c, e, y->normal);
    conditions(y, e, rule, c, JO_FREE);
}

/* edges a + t e, b + u k: foot points and n; sign of n: out of a, into b. 0 if they are parallel */
static int edges(const jo_polytope *A, const jo_polytope *B, const jo_real *a, const jo_real *e, const jo_real *b, const jo_real *k, const jo_real *R,
                 const jo_real *r, jo_feature *y)
{
    jo_real n[3], w[3], m[3], c[3], out;
    jo_cross(n, e, k);
    const jo_real square = jo_dot3(n, n);
    if (!(JO_RE(square) > JO_EDGES_CROSS)) return 0;
    jo_set3(w, b);
    jo_sub3(w, a);
    if (!A->faces && !B->faces) {
        out = jo_dot3(n, w);
    } else {   /* from the centre of a to its edge, less from that of b to its edge */
        jo_mul3(c, R, B->centre);
        jo_add3(c, r);
        for (int i = 0; i < 3; i++) m[i] = a[i] - A->centre[i] - b[i] + c[i];
        out = jo_dot3(n, m);
    }
    const jo_real scale = (JO_RE(out) < 0.0 ? -1.0 : 1.0) / jo_sqrt(square);
    for (int i = 0; i < 3; i++) y->normal[i] = scale * n[i];
    y->gap = jo_dot3(y->normal, w);
    jo_cross(m, k, y->normal);
    const jo_real t = jo_dot3(w, m) / jo_dot3(e, m);
    jo_set3(y->foot, a);
    jo_axpy3(y->foot, t, e);
    jo_set3(y->edge, e);
    jo_set3(y->across, m);
    conditions(y, e, JO_FIXED_A, k, JO_FIXED_B);
    return 1;
}

/* unit vector of an edge from vertex i to k */
static void edge(const jo_polytope *p, int i, int k, jo_real *e)
{
    vertex(p, k, e);
    jo_sub3(e, p->vertex + 3 * i);
    length1(e);
}

void jo_feature_at(const jo_polytope *A, const jo_polytope *B, const jo_real *r, const jo_real *R, jo_real code, jo_feature *y)
{
    jo_real a[3], b[3] = {0.0}, e[3], k[3], w[3];
    const jo_feature_pair f = jo_feature_of(JO_RE(code));
    y->kind = f.kind;
    if (f.kind >= JO_ROUND_PAIR) {
        jo_round_feature_at(A, B, r, R, &f, y);
        return;
    }
    if (f.kind != JO_FACE_VERTEX) vertex(A, f.a[0], a);
    if (f.kind != JO_VERTEX_FACE) {
        jo_mul3(b, R, B->vertex + 3 * f.b[0]);
        jo_add3(b, r);
    }
    if (f.kind == JO_EDGE_VERTEX || f.kind == JO_EDGE_EDGE) edge(A, f.a[0], f.a[1], e);
    if (f.kind == JO_VERTEX_EDGE || f.kind == JO_EDGE_EDGE) {
        edge(B, f.b[0], f.b[1], w);
        jo_mul3(k, R, w);
    }
    jo_set3(w, b);
    if (f.kind != JO_FACE_VERTEX && f.kind != JO_VERTEX_FACE) jo_sub3(w, a);
    switch (f.kind) {
    case JO_VERTEX_VERTEX: apart(y, w, 0, JO_FREE, 1.0); break;
    case JO_EDGE_VERTEX: apart(y, w, e, JO_FIXED_A, 1.0); break;
    case JO_VERTEX_EDGE: apart(y, w, k, JO_FIXED_B, 1.0); break;
    case JO_FACE_VERTEX:
        jo_set3(y->normal, A->plane + 4 * f.a[0]);
        y->gap = jo_dot3(y->normal, b) - A->plane[4 * f.a[0] + 3];
        isotropic(y, JO_FIXED_A);
        break;
    case JO_VERTEX_FACE:
        jo_mul3(w, R, B->plane + 4 * f.b[0]);
        y->gap = jo_dot3(w, a) - jo_dot3(w, r) - B->plane[4 * f.b[0] + 3];
        for (int i = 0; i < 3; i++) y->normal[i] = -w[i];
        isotropic(y, JO_FIXED_B);
        break;
    default:
        if (!edges(A, B, a, e, b, k, R, r, y)) {
            y->gap = jo_same(INFINITY);
            return;
        }
    }
    if (f.kind == JO_FACE_VERTEX || f.kind == JO_EDGE_VERTEX || f.kind == JO_VERTEX_VERTEX) {
        jo_set3(y->foot, b);
        jo_axpy3(y->foot, -y->gap, y->normal);
    } else if (f.kind != JO_EDGE_EDGE) {
        jo_set3(y->foot, a);
    }
}

void jo_feature_above(jo_feature *y, const jo_real *normal, jo_real gap, const jo_real *c)
{
    y->kind = JO_FACE_VERTEX;
    y->gap = gap;
    jo_set3(y->normal, normal);
    isotropic(y, JO_FIXED_A);
    jo_set3(y->foot, c);
    jo_axpy3(y->foot, -gap, normal);
}

void jo_feature_around(jo_feature *y, jo_real *w, jo_real *e, double sign, const jo_real *c)
{
    y->kind = e ? JO_EDGE_VERTEX : JO_VERTEX_VERTEX;
    if (e) length1(e);
    apart(y, w, e, e ? JO_FIXED_A : JO_FREE, sign);
    jo_set3(y->foot, c);
    jo_axpy3(y->foot, -y->gap, y->normal);
}

/* changes of gap, normal and foot point of a with a displacement x and rotation phi of b about its origin, where r is that origin */
void jo_feature_change(const jo_feature *y, const jo_real *r, const jo_real *x, const jo_real *phi, jo_real *gap, jo_real *normal, jo_real *foot)
{
    if (y->kind >= JO_ROUND_PAIR) {
        jo_round_feature_change(y, r, x, phi, gap, normal, foot);
        return;
    }
    jo_real arm[3], s[3], turn[3];
    for (int i = 0; i < 3; i++) arm[i] = y->foot[i] + y->gap * y->normal[i] - r[i];
    jo_cross(s, phi, arm);
    jo_add3(s, x);
    jo_cross(turn, phi, y->normal);
    *gap = jo_dot3(y->normal, s);
    for (int i = 0; i < 3; i++) normal[i] = foot[i] = jo_same(0.0);
    for (int k = 0; k < 2; k++) {
        if (y->rule[k] == JO_FIXED_A) continue;
        jo_axpy3(normal, y->rule[k] == JO_FIXED_B ? jo_dot3(y->u[k], turn) : jo_dot3(y->u[k], s) / y->gap, y->dual[k]);
    }
    if (y->kind == JO_VERTEX_FACE || y->kind == JO_VERTEX_EDGE) return;
    if (y->kind == JO_EDGE_EDGE) {   /* the foot point slides along the edge */
        jo_axpy3(s, -y->gap, normal);
        jo_axpy3(foot, jo_dot3(s, y->across) / jo_dot3(y->edge, y->across), y->edge);
        return;
    }
    for (int i = 0; i < 3; i++) foot[i] = s[i] - *gap * y->normal[i] - y->gap * normal[i];
}
