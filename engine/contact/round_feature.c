/* round_feature.c - gap and normal of two parts of shapes of which one is round, and their derivatives.
 *
 * With the displacement s of the place of b and its rotation phi the normal turns by dn, with (part.c)
 *   W_a dn + W_b (dn - phi x n) + g dn = s   across n, where neither an edge nor a face holds it:
 * an edge of a holds e . dn = 0, one of b e . (dn - phi x n) = 0; a face of a holds dn = 0, one of b dn = phi x n. The place of a moves by W_a dn,
 * that of b by s - W_b (dn - phi x n). On an edge or a face it is opposite of the other one. */
#include "contact/round.h"

#define JO_NOWHERE 1e30     /* gap, m, of parts that have no closest places, such as parallel edges */
enum { FREE, EDGE, FACE };   /* jo_feature.rule: what holds the normal of a and of b */

static int rule_of(int kind) { return kind == JO_PART_EDGE ? EDGE : kind == JO_PART_FACE ? FACE : FREE; }

/* place of a */
static void foot_of(const jo_part *a, const jo_part *b, const jo_meeting *t, jo_feature *y)
{
    jo_set3(y->foot, t->a);
    if (y->rule[0] == FREE) return;
    if (y->rule[1] == FREE) {
        jo_set3(y->foot, t->b);
        jo_axpy3(y->foot, -t->gap, t->n);
        return;
    }
    jo_real w[3];
    jo_set3(w, b->at);
    jo_sub3(w, a->at);
    jo_axpy3(y->foot, jo_dot3(w, y->across) / jo_dot3(y->edge, y->across), y->edge);
}

void jo_round_feature_at(const jo_polytope *A, const jo_polytope *B, const jo_real *r, const jo_real *R, const jo_feature_pair *f, jo_feature *y)
{
    int part[2];
    jo_real n[3];
    jo_meeting t;
    jo_part_pair(f, part);
    const jo_part a = jo_part_of(A, part[0], f->a, part[1] == JO_PART_FACE, 0, 0), b = jo_part_of(B, part[1], f->b, part[0] == JO_PART_FACE, r, R);
    jo_part_direction(f, &a, &b, R, n);
    y->kind = f->kind;
    y->gap = jo_same(JO_NOWHERE);
    for (int i = 0; i < 3; i++) y->normal[i] = y->foot[i] = jo_same(0.0);
    if (!jo_part_closest(&a, &b, n, &t)) return;
    y->gap = t.gap;
    jo_set3(y->normal, t.n);
    for (int s = 0; s < 2; s++) {
        const jo_part *own = s ? &b : &a;
        y->rule[s] = rule_of(own->kind);
        jo_set3(y->u[s], own->along);
        for (int i = 0; i < 9; i++) y->bend[s][i] = t.bend[s][i];
    }
    jo_set3(y->edge, a.along);
    jo_cross(y->across, b.along, t.n);
    foot_of(&a, &b, &t, y);
}

/* turn dn of the normal, with f = s + W_b (phi x n) and turn = phi x n */
static void normal_change(const jo_feature *y, const jo_real *f, const jo_real *turn, jo_real *dn)
{
    const jo_real *n = y->normal;
    jo_real W[9], u[3], v[3], c[3], d[3];
    for (int i = 0; i < 3; i++) dn[i] = jo_same(0.0);
    if (y->rule[0] == FACE || y->rule[1] == FACE) {
        for (int i = 0; i < 3 && y->rule[1] == FACE; i++) dn[i] = turn[i];
        return;
    }
    if (y->rule[0] == EDGE && y->rule[1] == EDGE) {   /* d . e_b = e_b . turn along the direction d across n and e_a */
        jo_cross(d, n, y->u[0]);
        jo_axpy3(dn, jo_dot3(y->u[1], turn) / jo_dot3(y->u[1], d), d);
        return;
    }
    for (int i = 0; i < 9; i++) W[i] = y->bend[0][i] + y->bend[1][i];
    if (y->rule[0] == EDGE || y->rule[1] == EDGE) {
        const jo_real *e = y->u[y->rule[0] == EDGE ? 0 : 1];
        if (y->rule[1] == EDGE) jo_axpy3(dn, jo_dot3(e, turn), e);
        jo_cross(c, e, n);
        jo_mul3(u, W, dn);
        jo_mul3(v, W, c);
        jo_axpy3(dn, (jo_dot3(c, f) - jo_dot3(c, u)) / (jo_dot3(c, v) + y->gap), c);
        return;
    }
    /* (P W P + g) dn = P f by the matrix W + g + n n^T of full rank, with n . W = 0 */
    for (int i = 0; i < 9; i++) W[i] += (i % 4 == 0 ? y->gap : jo_same(0.0)) + n[i / 3] * n[i % 3];
    const jo_real out = jo_dot3(f, n);
    for (int i = 0; i < 3; i++) d[i] = f[i] - out * n[i];
    for (int i = 0; i < 3; i++) {   /* Cramer's rule: rows i, j, k */
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        jo_cross(c, W + 3 * j, W + 3 * k);
        jo_axpy3(dn, d[i], c);
    }
    jo_cross(c, W + 3, W + 6);
    const jo_real det = jo_dot3(W, c);
    for (int i = 0; i < 3; i++) dn[i] /= det;
}

void jo_round_feature_change(const jo_feature *y, const jo_real *r, const jo_real *x, const jo_real *phi, jo_real *gap, jo_real *normal, jo_real *foot)
{
    const jo_real *n = y->normal;
    jo_real arm[3], s[3], turn[3], moved[3], other[3], relative[3];
    for (int i = 0; i < 3; i++) arm[i] = y->foot[i] + y->gap * n[i] - r[i];
    jo_cross(s, phi, arm);
    jo_add3(s, x);
    jo_cross(turn, phi, n);
    jo_mul3(moved, y->bend[1], turn);
    jo_add3(moved, s);
    normal_change(y, moved, turn, normal);
    for (int i = 0; i < 3; i++) relative[i] = normal[i] - turn[i];
    jo_mul3(moved, y->bend[1], relative);   /* of the place of b on its body, reversed */
    jo_mul3(other, y->bend[0], normal);
    *gap = jo_dot3(n, s) - jo_dot3(n, moved) - jo_dot3(n, other);
    if (y->rule[0] == FREE) {
        jo_set3(foot, other);
    } else if (y->rule[1] == FREE) {
        for (int i = 0; i < 3; i++) foot[i] = s[i] - moved[i] - *gap * n[i] - y->gap * normal[i];
    } else {   /* both slide along their edges, from places that move by W dn */
        jo_real apart[3];
        for (int i = 0; i < 3; i++) {
            foot[i] = other[i];
            apart[i] = s[i] - moved[i] - other[i] - y->gap * normal[i];
        }
        jo_axpy3(foot, jo_dot3(apart, y->across) / jo_dot3(y->edge, y->across), y->edge);
    }
}

/* mean curvature of a part: of an ellipsoid (r_1 + r_2) / (2 r_1 r_2), with the radii in W */
static double curvature_of(int kind, const int *of, const jo_polytope *p, const jo_real *W, double edge)
{
    if (kind == JO_PART_FACE) return 0.0;
    if (kind == JO_PART_EDGE && of[0] == of[1]) return 0.5 / JO_RE(p->size[0]);
    if (kind != JO_PART_WHOLE) return edge;
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < 3; i++) sum += JO_RE(W[4 * i]);
    for (int i = 0; i < 9; i++) squares += JO_RE(W[i]) * JO_RE(W[i]);
    return sum / (sum * sum - squares);
}

double jo_round_curvature(const jo_polytope *A, const jo_polytope *B, const jo_real *r, const jo_real *R, double code, const jo_real *edge)
{
    const jo_feature_pair f = jo_feature_of(code);
    jo_feature y;
    int part[2];
    if (!jo_part_pair(&f, part)) return 0.0;
    jo_round_feature_at(A, B, r, R, &f, &y);
    return curvature_of(part[0], f.a, A, y.bend[0], JO_RE(edge[0])) + curvature_of(part[1], f.b, B, y.bend[1], JO_RE(edge[1]));
}
