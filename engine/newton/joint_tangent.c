/* joint_tangent.c - joints in Newton's matrix: constraint rows and derivatives of the reactions. */
#include "newton/newton.h"

/* Y(i.., j..) += s M */
static void add(jo_element *e, int i, int j, jo_real s, const jo_real *M)
{
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) e->Y[i + r][j + c] += s * M[3 * r + c];
}

/* Row of a joint and its transpose. c (24): derivatives of C' with respect to the changes of markers a, b; those with respect to
 * velocities are the row of Cq. */
static void add_row(const jo_model *m, jo_data *d, const jo_weights *by, int joint, int row, int a, int b, const jo_real *c)
{
    const int marker[2] = {a, b};
    for (int s = 0; s < 2; s++) {
        const int body = m->marker[marker[s]].body;
        if (body < 0) continue;
        const jo_marker_tangent *w = &d->newton.marker[marker[s]];
        const int n = 6 + m->body[body].n, stride = jo_pad(n);
        const jo_block N = jo_newton_find(m, d, m->nbody + joint, body), T = jo_newton_find(m, d, body, m->nbody + joint);
        const jo_real *x = c + 12 * s;
        for (int i = 0; i < 6; i++) {
            const jo_real y = x[JO_DV + i], z = by->position ? 0.0 : x[i], *L = w->L + i * stride;
            const jo_real *W = w->W + i * stride, *V = W + 6 * stride;
            if (by->position) V = W;   /* dC/dq = dC'/dv */
            if (y == 0.0 && z == 0.0) continue;
            JO_EACH(j, stride) JO_STORE(N.at + row * N.stride + j) += by->rows * (y * JO_LOAD(V + j) + z * JO_LOAD(W + j));
            for (int j = 0; j < n; j++) T.at[j * T.stride + row] += y * L[j];
        }
    }
}

/* row C' = rel . (x x y), rel = om_a - om_b, and derivatives of its reaction lam x x y in e */
static inline void perpendicular(const jo_model *m, jo_data *d, const jo_weights *by, int i, int r, int row, const jo_real *rel,
                                 jo_element *e)
{
    const jo_joint *k = &m->joint[i];
    const jo_real lam = d->lam[k->row + row];
    jo_real x[3], y[3], t[3], c[24] = {0.0}, Ma[9], Mb[9];
    jo_axis(x, d->marker[e->a].A, k->perp_a[r]);
    jo_axis(y, d->marker[e->b].A, k->perp_b[r]);
    jo_cross(t, x, y);
    const jo_real xy = jo_dot3(x, y);
    for (int p = 0; p < 3; p++) {   /* d(x x y) = Ma phi_a + Mb phi_b */
        for (int q = 0; q < 3; q++) {
            Ma[3 * p + q] = x[p] * y[q] - (p == q ? xy : 0.0);
            Mb[3 * p + q] = (p == q ? xy : 0.0) - y[p] * x[q];
        }
        c[JO_DOM + p] = t[p];
        c[JO_OF_B + JO_DOM + p] = -t[p];
        e->y[3 + p] -= lam * t[p];
        e->y[9 + p] += lam * t[p];
    }
    jo_mul3t(c + JO_DPHI, Ma, rel);
    jo_mul3t(c + JO_OF_B + JO_DPHI, Mb, rel);
    add_row(m, d, by, i, row, e->a, e->b, c);
    add(e, 3, JO_DPHI, -lam, Ma);
    add(e, 3, JO_OF_B + JO_DPHI, -lam, Mb);
    add(e, 9, JO_DPHI, lam, Ma);
    add(e, 9, JO_OF_B + JO_DPHI, lam, Mb);
}

/* row that is linear in coordinates; one element per coordinate */
static void line_row(const jo_model *m, jo_data *d, const jo_weights *by, int i, const jo_line *line, int row)
{
    const jo_real lam = d->lam[m->joint[i].row + row];
    for (int j = 0; j < line->count; j++) {
        const int s = line->coordinate[j];
        jo_element e;
        jo_gradients g;
        jo_element_gradients(m, d, s, &g);
        jo_element_start(&e, m->coordinate[s].a, m->coordinate[s].b);
        jo_element_along(d, &e, s, &g, -line->data->factor[j] * lam, 0.0, 0.0);
        jo_element_finish(m, d, &e);
        for (int p = 0; p < 24; p++) g.rate[p] *= line->data->factor[j];
        add_row(m, d, by, i, row, e.a, e.b, g.rate);
    }
}

/* rows of one joint and derivatives of its reactions: coincident points, perpendicular axes, lines */
void jo_newton_joint(const jo_model *m, jo_data *d, const jo_stage *stage, int i)
{
    const jo_joint *k = &m->joint[i];
    const int a = k->side[0], b = k->side[1];
    const jo_real *lam = d->lam + k->row;
    jo_element e;
    int row = 0;
    if (jo_absent(d, k)) {
        const jo_block D = jo_newton_find(m, d, m->nbody + i, m->nbody + i);
        for (int r = 0; r < k->nrow; r++) D.at[r * (D.stride + 1)] = 1.0;
        return;
    }
    jo_element_start(&e, a, b);
    for (; row < (k->coincident ? 3 : 0); row++) {
        jo_real c[24] = {0.0};
        c[JO_DV + row] = -1.0;
        c[JO_OF_B + JO_DV + row] = 1.0;
        add_row(m, d, &stage->weights, i, row, a, b, c);
        e.y[row] += lam[row];
        e.y[6 + row] -= lam[row];
    }
    jo_real rel[3] = {0.0}, t[3];
    if (k->nperp) {
        jo_to_world(rel, m, d, a, d->marker[a].om);
        jo_to_world(t, m, d, b, d->marker[b].om);
        jo_sub3(rel, t);
    }
    for (int r = 0; r < k->nperp; r++, row++) perpendicular(m, d, &stage->weights, i, r, row, rel, &e);
    if (row) jo_element_finish(m, d, &e);
    for (int r = 0; r < k->nline; r++, row++) line_row(m, d, &stage->weights, i, &m->line[k->line + r], row);
}
