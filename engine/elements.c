/* elements.c - Newton's matrix: joints and forces between two markers, differentiated.
 *
 * An element pushes its markers a, b with y = [F_a, T_a, F_b, T_b] (world); Y holds the derivatives of y with respect
 * to the changes [dr, dphi, dv, dom] of a, then of b.
 */
#include "element.h"

void jo_element_start(jo_element *e, int a, int b)
{
    e->a = a;
    e->b = b;
    for (int i = 0; i < 12; i++) {
        e->y[i] = 0.0;
        for (int j = 0; j < 24; j++) e->Y[i][j] = 0.0;
    }
}

/* rows i.., columns j.. of Y += s M */
static void add(jo_element *e, int i, int j, jo_real s, const jo_real *M)
{
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) e->Y[i + r][j + c] += s * M[3 * r + c];
}

/* += s a~ */
void jo_element_skew(jo_element *e, int i, int j, jo_real s, const jo_real *a)
{
    e->Y[i][j + 1] -= s * a[2]; e->Y[i][j + 2] += s * a[1];
    e->Y[i + 1][j] += s * a[2]; e->Y[i + 1][j + 2] -= s * a[0];
    e->Y[i + 2][j] -= s * a[1]; e->Y[i + 2][j + 1] += s * a[0];
}

static int is_zero(const jo_element *e, int i, int j)
{
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            if (e->Y[i + r][j + c] != 0.0) return 0;
    return 1;
}

/* N -= L^T Y W of every pair of sides; the loads of the markers are summed up */
void jo_element_finish(const jo_model *m, jo_data *d, const jo_element *e)
{
    const int marker[2] = {e->a, e->b};
    for (int s = 0; s < 2; s++) {
        const int body = marker[s] < 0 ? -1 : m->marker[marker[s]].body;
        if (body < 0) continue;
        jo_marker_work *w = &d->marker[marker[s]];
        const int n = 6 + m->body[body].n, row = jo_pad(n);
        for (int i = 0; i < 6; i++) w->load[i] += e->y[6 * s + i];
        for (int t = 0; t < 2; t++) {
            const int other = marker[t] < 0 ? -1 : m->marker[marker[t]].body;
            if (other < 0) continue;
            const int columns = jo_pad(6 + m->body[other].n);
            const jo_real *W = d->marker[marker[t]].W;
            const jo_block N = jo_newton_find(m, d, body, other);
            for (int half = 0; half < 2; half++) {
                int used[4], any = 0;
                for (int k = 0; k < 4; k++) any |= used[k] = !is_zero(e, 6 * s + 3 * half, 12 * t + 3 * k);
                if (!any) continue;
                const jo_real *L = w->L + 3 * half * row;
                JO_EACH(j, columns) {   /* beyond the last column W is zero */
                    const jo_lanes zero = {0};
                    jo_lanes h[3] = {zero, zero, zero};
                    for (int k = 0; k < 4; k++) {
                        if (!used[k]) continue;
                        const jo_real *x = W + 3 * k * columns + j;
                        const jo_lanes x0 = JO_LOAD(x), x1 = JO_LOAD(x + columns), x2 = JO_LOAD(x + 2 * columns);
                        for (int i = 0; i < 3; i++) {
                            const jo_real *y = &e->Y[6 * s + 3 * half + i][12 * t + 3 * k];
                            h[i] += y[0] * x0 + y[1] * x1 + y[2] * x2;
                        }
                    }
                    for (int i = half ? 3 : 0; i < n; i++)
                        JO_STORE(N.at + i * N.stride + j) -= L[i] * h[0] + L[row + i] * h[1] + L[2 * row + i] * h[2];
                }
            }
        }
    }
}

static void axis(jo_real *x, const jo_real *A, int i) { x[0] = A[i]; x[1] = A[3 + i]; x[2] = A[6 + i]; }

/* s' = along . (v_b - v_a) + turn_a . om_a + turn_b . om_b, differentiated */
void jo_element_gradients(const jo_model *m, const jo_data *d, int coordinate, jo_gradients *g)
{
    const jo_coordinate *c = &m->coordinate[coordinate];
    const jo_coordinate_work *w = &d->coordinate[coordinate];
    const jo_marker_work *a = &d->marker[c->a], *b = &d->marker[c->b];
    jo_real f[3], h[3], k[3], r[3];
    jo_set3(r, b->r);
    jo_sub3(r, a->r);
    for (int j = 0; j < 9; j++) {
        jo_real dr[3] = {0.0}, pa[3] = {0.0}, pb[3] = {0.0}, t[3], u[3], along[3] = {0.0}, ta[3] = {0.0}, tb[3] = {0.0};
        (j < 3 ? dr : j < 6 ? pa : pb)[j % 3] = 1.0;
        switch (c->type) {
        case JO_COORDINATE_AXES:
            axis(f, a->A, c->axis_a);
            axis(h, b->A, c->axis_b);
            jo_cross(t, pa, f);
            jo_cross(ta, t, h);
            jo_cross(t, pb, h);
            jo_cross(u, f, t);
            jo_add3(ta, u);
            for (int i = 0; i < 3; i++) tb[i] = -ta[i];
            break;
        case JO_COORDINATE_ALONG:
            axis(f, a->A, c->axis_a);
            jo_cross(along, pa, f);
            jo_cross(ta, along, r);
            jo_cross(t, f, dr);
            jo_add3(ta, t);
            break;
        case JO_COORDINATE_DISTANCE: {
            const jo_real s = jo_dot3(w->along, dr);
            for (int i = 0; i < 3; i++) along[i] = (dr[i] - s * w->along[i]) / w->value;
            break;
        }
        default: {   /* turn_b = (x h x g - y h x f) / (x^2 + y^2) with x = h.f, y = h.g; its size is that of s' = .. */
            jo_real df[3], dg[3], dh[3], hg[3], hf[3], p[3], q[3];
            axis(f, a->A, 0);
            axis(k, a->A, 1);
            axis(h, b->A, 0);
            jo_cross(df, pa, f);
            jo_cross(dg, pa, k);
            jo_cross(dh, pb, h);
            const jo_real x = jo_dot3(h, f), y = jo_dot3(h, k), s = 1.0 / (x * x + y * y);
            const jo_real dx = jo_dot3(dh, f) + jo_dot3(h, df), dy = jo_dot3(dh, k) + jo_dot3(h, dg);
            jo_cross(hg, h, k);
            jo_cross(hf, h, f);
            jo_cross(p, dh, k);
            jo_cross(t, h, dg);
            jo_add3(p, t);
            jo_cross(q, dh, f);
            jo_cross(t, h, df);
            jo_add3(q, t);
            const jo_real ds = -2.0 * s * s * (x * dx + y * dy);
            for (int i = 0; i < 3; i++) {
                tb[i] = ds * (x * hg[i] - y * hf[i]) + s * (dx * hg[i] + x * p[i] - dy * hf[i] - y * q[i]);
                ta[i] = -tb[i];
            }
            break;
        }
        }
        for (int i = 0; i < 3; i++) { g->G[i][j] = along[i]; g->G[3 + i][j] = ta[i]; g->G[6 + i][j] = tb[i]; }
    }
    for (int i = 0; i < 24; i++) g->s[i] = g->rate[i] = 0.0;
    for (int i = 0; i < 3; i++) {
        g->s[JO_DR + i] = -w->along[i]; g->s[JO_OF_B + JO_DR + i] = w->along[i];
        g->s[JO_DPHI + i] = w->turn_a[i]; g->s[JO_OF_B + JO_DPHI + i] = w->turn_b[i];
        g->rate[JO_DV + i] = -w->along[i]; g->rate[JO_OF_B + JO_DV + i] = w->along[i];
        g->rate[JO_DOM + i] = w->turn_a[i]; g->rate[JO_OF_B + JO_DOM + i] = w->turn_b[i];
    }
    jo_real v[9], t[3];
    jo_to_world(v, m, d, c->b, b->v);
    jo_to_world(t, m, d, c->a, a->v);
    jo_sub3(v, t);
    jo_to_world(v + 3, m, d, c->a, a->om);
    jo_to_world(v + 6, m, d, c->b, b->om);
    for (int j = 0; j < 9; j++) {
        jo_real x = 0.0;
        for (int i = 0; i < 9; i++) x += v[i] * g->G[i][j];
        if (j < 3) { g->rate[JO_DR + j] -= x; g->rate[JO_OF_B + JO_DR + j] += x; }
        else if (j < 6) g->rate[JO_DPHI + j - 3] += x;
        else g->rate[JO_OF_B + JO_DPHI + j - 6] += x;
    }
}

/* a force f along the coordinate, with the derivatives fs and frate of f with respect to s and s' */
void jo_element_along(const jo_data *d, jo_element *e, int coordinate, const jo_gradients *g, jo_real f, jo_real fs,
                      jo_real frate)
{
    const jo_coordinate_work *w = &d->coordinate[coordinate];
    jo_real y[12];
    for (int i = 0; i < 3; i++) { y[i] = -w->along[i]; y[3 + i] = w->turn_a[i]; y[6 + i] = w->along[i]; y[9 + i] = w->turn_b[i]; }
    static const int row[4] = {0, 3, 0, 6};   /* of G */
    for (int i = 0; i < 12; i++) {
        const jo_real *G = g->G[row[i / 3] + i % 3], s = i < 3 ? -f : f;
        e->y[i] += f * y[i];
        for (int j = 0; j < 3; j++) {
            e->Y[i][JO_DR + j] -= s * G[j];
            e->Y[i][JO_OF_B + JO_DR + j] += s * G[j];
            e->Y[i][JO_DPHI + j] += s * G[3 + j];
            e->Y[i][JO_OF_B + JO_DPHI + j] += s * G[6 + j];
        }
        if (fs != 0.0 || frate != 0.0)
            for (int j = 0; j < 24; j++) e->Y[i][j] += y[i] * (fs * g->s[j] + frate * g->rate[j]);
    }
}

/* Rows of a joint and their transpose: c (24) are the derivatives of C' with respect to all changes of markers a, b;
 * those with respect to the velocities are the row of Cq itself. */
static void add_row(const jo_model *m, jo_data *d, int joint, int row, int a, int b, const jo_real *c)
{
    const int marker[2] = {a, b};
    for (int s = 0; s < 2; s++) {
        const int body = m->marker[marker[s]].body;
        if (body < 0) continue;
        const jo_marker_work *w = &d->marker[marker[s]];
        const int n = 6 + m->body[body].n, stride = jo_pad(n);
        const jo_block N = jo_newton_find(m, d, m->nbody + joint, body), T = jo_newton_find(m, d, body, m->nbody + joint);
        const jo_real *x = c + 12 * s;
        for (int i = 0; i < 6; i++) {
            const jo_real y = x[JO_DV + i], z = d->weights.position ? 0.0 : x[i], *L = w->L + i * stride;
            const jo_real *W = w->W + i * stride, *V = W + 6 * stride;
            if (d->weights.position) V = W;   /* C itself changes with the position as C' with the velocity */
            if (y == 0.0 && z == 0.0) continue;
            JO_EACH(j, stride) JO_STORE(N.at + row * N.stride + j) += d->weights.rows * (y * JO_LOAD(V + j) + z * JO_LOAD(W + j));
            for (int j = 0; j < n; j++) T.at[j * T.stride + row] += y * L[j];
        }
    }
}

void jo_newton_joint(const jo_model *m, jo_data *d, int i)
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
    if (k->coincident) {
        for (; row < 3; row++) {
            jo_real c[24] = {0.0};
            c[JO_DV + row] = -1.0;
            c[JO_OF_B + JO_DV + row] = 1.0;
            add_row(m, d, i, row, a, b, c);
            e.y[row] += lam[row];
            e.y[6 + row] -= lam[row];
        }
    }
    jo_real rel[3] = {0.0}, t[3];
    if (k->nperp) {
        jo_to_world(rel, m, d, a, d->marker[a].om);
        jo_to_world(t, m, d, b, d->marker[b].om);
        jo_sub3(rel, t);
    }
    for (int r = 0; r < k->nperp; r++, row++) {   /* C' = (om_a - om_b) . (x x y) */
        jo_real x[3], y[3], c[24] = {0.0}, Ma[9], Mb[9];
        axis(x, d->marker[a].A, k->perp_a[r]);
        axis(y, d->marker[b].A, k->perp_b[r]);
        jo_cross(t, x, y);
        const jo_real xy = jo_dot3(x, y);
        for (int p = 0; p < 3; p++) {   /* d(x x y) = Ma phi_a + Mb phi_b */
            for (int q = 0; q < 3; q++) {
                Ma[3 * p + q] = x[p] * y[q] - (p == q ? xy : 0.0);
                Mb[3 * p + q] = (p == q ? xy : 0.0) - y[p] * x[q];
            }
            c[JO_DOM + p] = t[p];
            c[JO_OF_B + JO_DOM + p] = -t[p];
            e.y[3 + p] -= lam[row] * t[p];
            e.y[9 + p] += lam[row] * t[p];
        }
        jo_mul3t(c + JO_DPHI, Ma, rel);
        jo_mul3t(c + JO_OF_B + JO_DPHI, Mb, rel);
        add_row(m, d, i, row, a, b, c);
        add(&e, 3, JO_DPHI, -lam[row], Ma);
        add(&e, 3, JO_OF_B + JO_DPHI, -lam[row], Mb);
        add(&e, 9, JO_DPHI, lam[row], Ma);
        add(&e, 9, JO_OF_B + JO_DPHI, lam[row], Mb);
    }
    if (row) jo_element_finish(m, d, &e);
    for (int r = 0; r < k->nline; r++, row++) {
        const jo_line *line = &m->line[k->line + r];
        for (int j = 0; j < line->count; j++) {
            const int s = line->coordinate[j];
            jo_gradients g;
            jo_element_gradients(m, d, s, &g);
            jo_element_start(&e, m->coordinate[s].a, m->coordinate[s].b);
            jo_element_along(d, &e, s, &g, -line->data->factor[j] * lam[row], 0.0, 0.0);
            jo_element_finish(m, d, &e);
            for (int p = 0; p < 24; p++) g.rate[p] *= line->data->factor[j];
            add_row(m, d, i, row, e.a, e.b, g.rate);
        }
    }
}

/* Change of the reaction of a joint, of which d(force of friction) = force . dF + moment . dM: with the motion of the
 * markers into x (24), with the multipliers into l. The axes of side 0, in which it is resolved, turn with it. */
static void reaction_rate(const jo_model *m, const jo_data *d, const jo_joint *k, const jo_real *force,
                          const jo_real *moment, jo_real *x, jo_real *l)
{
    const jo_real *lam = d->lam + k->row;
    jo_real y[6], t[3], u[3], v[3];
    int row = 0;
    jo_reaction(m, d, (int)(k - m->joint), y);
    jo_cross(t, force, y);
    jo_add3(x + JO_DPHI, t);
    jo_cross(t, moment, y + 3);
    jo_add3(x + JO_DPHI, t);
    for (; row < (k->coincident ? 3 : 0); row++) l[row] -= force[row];
    for (int r = 0; r < k->nperp; r++, row++) {
        axis(u, d->marker[k->side[0]].A, k->perp_a[r]);
        axis(v, d->marker[k->side[1]].A, k->perp_b[r]);
        jo_cross(t, u, v);
        l[row] += jo_dot3(moment, t);
        /* d(u x v) = (phi_a x u) x v + u x (phi_b x v) */
        const jo_real uv = jo_dot3(u, v), mu = jo_dot3(moment, u), mv = jo_dot3(moment, v);
        for (int i = 0; i < 3; i++) {
            x[JO_DPHI + i] += lam[row] * (mu * v[i] - uv * moment[i]);
            x[JO_OF_B + JO_DPHI + i] += lam[row] * (uv * moment[i] - mv * u[i]);
        }
    }
    for (int r = 0; r < k->nline; r++, row++) {
        const jo_line *line = &m->line[k->line + r];
        for (int j = 0; j < line->count; j++) {
            if (line->side[j]) continue;
            const jo_coordinate_work *c = &d->coordinate[line->coordinate[j]];
            jo_gradients g;
            jo_element_gradients(m, d, line->coordinate[j], &g);
            l[row] -= line->data->factor[j] * (jo_dot3(force, c->along) + jo_dot3(moment, c->turn_b));
            for (int p = 0; p < 9; p++) {
                jo_real z = 0.0;
                for (int q = 0; q < 3; q++) z -= lam[row] * line->data->factor[j] * (force[q] * g.G[q][p] + moment[q] * g.G[6 + q][p]);
                if (p < 3) { x[JO_DR + p] -= z; x[JO_OF_B + JO_DR + p] += z; }
                else if (p < 6) x[JO_DPHI + p - 3] += z;
                else x[JO_OF_B + JO_DPHI + p - 6] += z;
            }
        }
    }
}

/* friction of a joint: its forces depend on rates, positions and the multipliers of the joint */
static void rub(const jo_model *m, jo_data *d, int i)
{
    const jo_friction *f = &m->friction[i];
    const jo_joint *k = &m->joint[f->joint];
    const int coordinate[2] = {f->coordinate, f->other}, count = f->other >= 0 ? 2 : 1;
    jo_slopes slopes;
    jo_gradients g[2];
    jo_element e;
    if (f->law && d->locked[m->joint[f->lock].lock]) return;   /* it sticks: its row holds it */
    jo_friction_slopes(m, d, i, &slopes);
    jo_element_start(&e, k->side[0], k->side[1]);
    for (int c = 0; c < count; c++) jo_element_gradients(m, d, coordinate[c], &g[c]);
    for (int c = 0; c < count; c++) {
        const jo_coordinate_work *w = &d->coordinate[coordinate[c]];
        jo_real x[24] = {0.0}, l[JO_MAX_ROWS] = {0.0}, y[12];
        jo_element_along(d, &e, coordinate[c], &g[c], d->rub[2 * i + c], 0.0, 0.0);
        reaction_rate(m, d, k, slopes.force[c], slopes.moment[c], x, l);
        for (int j = 0; j < count; j++)
            for (int p = 0; p < 24; p++) x[p] += slopes.rate[c][j] * g[j].rate[p];
        for (int p = 0; p < 3; p++) { y[p] = -w->along[p]; y[3 + p] = w->turn_a[p]; y[6 + p] = w->along[p]; y[9 + p] = w->turn_b[p]; }
        for (int p = 0; p < 12; p++)
            for (int q = 0; q < 24; q++) e.Y[p][q] += y[p] * x[q];
        for (int side = 0; side < 2; side++) {   /* by the multipliers: r -= L^T y l */
            const int body = m->marker[k->side[side]].body;
            if (body < 0) continue;
            const jo_real *L = d->marker[k->side[side]].L;
            const int n = 6 + m->body[body].n, stride = jo_pad(n);
            const jo_block T = jo_newton_find(m, d, body, m->nbody + f->joint);
            for (int p = 0; p < n; p++) {
                jo_real z = 0.0;
                for (int q = 0; q < 6; q++) z += L[q * stride + p] * y[6 * side + q];
                for (int r = 0; r < k->nrow; r++) T.at[p * T.stride + r] -= z * l[r];
            }
        }
    }
    jo_element_finish(m, d, &e);
}

int jo_newton_elements(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->njoint; i++) jo_newton_joint(m, d, i);
    for (int i = 0; i < m->nfriction; i++) rub(m, d, i);
    return jo_newton_forces(m, d);
}
