/* elements.c - Newton's matrix: joints and forces between two markers, differentiated.
 *
 * An element pushes its markers a, b with y = [F_a, T_a, F_b, T_b] (world); Y holds the derivatives of y with respect
 * to the changes [dr, dphi, dv, dom] of a, then of b.
 */
#include "internal.h"

typedef struct {
    int a, b;
    jo_real y[12];
    jo_real Y[12][24];
} element;

enum { DR = 0, DPHI = 3, DV = 6, DOM = 9, OF_B = 12 };

static void start(element *e, int a, int b)
{
    e->a = a;
    e->b = b;
    for (int i = 0; i < 12; i++) {
        e->y[i] = 0.0;
        for (int j = 0; j < 24; j++) e->Y[i][j] = 0.0;
    }
}

/* rows i.., columns j.. of Y += s M */
static void add(element *e, int i, int j, jo_real s, const jo_real *M)
{
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) e->Y[i + r][j + c] += s * M[3 * r + c];
}

/* += s a~ */
static void add_skew(element *e, int i, int j, jo_real s, const jo_real *a)
{
    e->Y[i][j + 1] -= s * a[2]; e->Y[i][j + 2] += s * a[1];
    e->Y[i + 1][j] += s * a[2]; e->Y[i + 1][j + 2] -= s * a[0];
    e->Y[i + 2][j] -= s * a[1]; e->Y[i + 2][j + 1] += s * a[0];
}

static int is_zero(const element *e, int i, int j)
{
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            if (e->Y[i + r][j + c] != 0.0) return 0;
    return 1;
}

/* N -= L^T Y W of every pair of sides; the loads of the markers are summed up */
static void finish(const jo_model *m, jo_data *d, const element *e)
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
                for (int j = 0; j < 6 + m->body[other].n; j++) {
                    jo_real h[3] = {0.0, 0.0, 0.0};
                    for (int k = 0; k < 4; k++) {
                        if (!used[k]) continue;
                        const jo_real *x = W + 3 * k * columns + j;
                        for (int i = 0; i < 3; i++) {
                            const jo_real *y = &e->Y[6 * s + 3 * half + i][12 * t + 3 * k];
                            h[i] += y[0] * x[0] + y[1] * x[columns] + y[2] * x[2 * columns];
                        }
                    }
                    for (int i = half ? 3 : 0; i < n; i++)
                        N.at[i * N.stride + j] -= L[i] * h[0] + L[row + i] * h[1] + L[2 * row + i] * h[2];
                }
            }
        }
    }
}

static void axis(jo_real *x, const jo_real *A, int i) { x[0] = A[i]; x[1] = A[3 + i]; x[2] = A[6 + i]; }

/* derivatives of s' = g_r . (v_b - v_a) + ...: gradients of s and s' with respect to all 24 changes, and those of the
 * gradient of s itself, G[0..2] along, G[3..5] turn_a, G[6..8] turn_b, with respect to [r_b - r_a, phi_a, phi_b] */
typedef struct { jo_real s[24], rate[24], G[9][9]; } gradients;

static void gradient_rate(const jo_model *m, const jo_data *d, int coordinate, gradients *g)
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
        case JO_AXES:
            axis(f, a->A, c->axis_a);
            axis(h, b->A, c->axis_b);
            jo_cross(t, pa, f);
            jo_cross(ta, t, h);
            jo_cross(t, pb, h);
            jo_cross(u, f, t);
            jo_add3(ta, u);
            for (int i = 0; i < 3; i++) tb[i] = -ta[i];
            break;
        case JO_ALONG:
            axis(f, a->A, c->axis_a);
            jo_cross(along, pa, f);
            jo_cross(ta, along, r);
            jo_cross(t, f, dr);
            jo_add3(ta, t);
            break;
        case JO_DISTANCE: {
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
        g->s[DR + i] = -w->along[i]; g->s[OF_B + DR + i] = w->along[i];
        g->s[DPHI + i] = w->turn_a[i]; g->s[OF_B + DPHI + i] = w->turn_b[i];
        g->rate[DV + i] = -w->along[i]; g->rate[OF_B + DV + i] = w->along[i];
        g->rate[DOM + i] = w->turn_a[i]; g->rate[OF_B + DOM + i] = w->turn_b[i];
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
        if (j < 3) { g->rate[DR + j] -= x; g->rate[OF_B + DR + j] += x; }
        else if (j < 6) g->rate[DPHI + j - 3] += x;
        else g->rate[OF_B + DPHI + j - 6] += x;
    }
}

/* a force f along the coordinate, with the derivatives fs and frate of f with respect to s and s' */
static void add_along(const jo_model *m, const jo_data *d, element *e, int coordinate, const gradients *g, jo_real f,
                      jo_real fs, jo_real frate)
{
    const jo_coordinate_work *w = &d->coordinate[coordinate];
    jo_real y[12];
    (void)m;
    for (int i = 0; i < 3; i++) { y[i] = -w->along[i]; y[3 + i] = w->turn_a[i]; y[6 + i] = w->along[i]; y[9 + i] = w->turn_b[i]; }
    static const int row[4] = {0, 3, 0, 6};   /* of G */
    for (int i = 0; i < 12; i++) {
        const jo_real *G = g->G[row[i / 3] + i % 3], s = i < 3 ? -f : f;
        e->y[i] += f * y[i];
        for (int j = 0; j < 3; j++) {
            e->Y[i][DR + j] -= s * G[j];
            e->Y[i][OF_B + DR + j] += s * G[j];
            e->Y[i][DPHI + j] += s * G[3 + j];
            e->Y[i][OF_B + DPHI + j] += s * G[6 + j];
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
            const jo_real y = x[DV + i], z = d->weights.position ? 0.0 : x[i], *L = w->L + i * stride;
            const jo_real *W = w->W + i * stride, *V = W + 6 * stride;
            if (d->weights.position) V = W;   /* C itself changes with the position as C' with the velocity */
            if (y == 0.0 && z == 0.0) continue;
            for (int j = 0; j < n; j++) {
                N.at[row * N.stride + j] += d->weights.rows * (y * V[j] + z * W[j]);
                T.at[j * T.stride + row] += y * L[j];
            }
        }
    }
}

static void joint(const jo_model *m, jo_data *d, int i)
{
    const jo_joint *k = &m->joint[i];
    const int a = k->side[0], b = k->side[1];
    const jo_real *lam = d->lam + k->row;
    element e;
    int row = 0;
    if (jo_absent(d, k)) {
        const jo_block D = jo_newton_find(m, d, m->nbody + i, m->nbody + i);
        for (int r = 0; r < k->nrow; r++) D.at[r * (D.stride + 1)] = 1.0;
        return;
    }
    start(&e, a, b);
    if (k->coincident) {
        for (; row < 3; row++) {
            jo_real c[24] = {0.0};
            c[DV + row] = -1.0;
            c[OF_B + DV + row] = 1.0;
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
            c[DOM + p] = t[p];
            c[OF_B + DOM + p] = -t[p];
            e.y[3 + p] -= lam[row] * t[p];
            e.y[9 + p] += lam[row] * t[p];
        }
        jo_mul3t(c + DPHI, Ma, rel);
        jo_mul3t(c + OF_B + DPHI, Mb, rel);
        add_row(m, d, i, row, a, b, c);
        add(&e, 3, DPHI, -lam[row], Ma);
        add(&e, 3, OF_B + DPHI, -lam[row], Mb);
        add(&e, 9, DPHI, lam[row], Ma);
        add(&e, 9, OF_B + DPHI, lam[row], Mb);
    }
    if (row) finish(m, d, &e);
    for (int r = 0; r < k->nline; r++, row++) {
        const jo_line *line = &m->line[k->line + r];
        for (int j = 0; j < line->count; j++) {
            const int s = line->coordinate[j];
            gradients g;
            gradient_rate(m, d, s, &g);
            start(&e, m->coordinate[s].a, m->coordinate[s].b);
            add_along(m, d, &e, s, &g, -line->data[1 + j] * lam[row], 0.0, 0.0);
            finish(m, d, &e);
            for (int p = 0; p < 24; p++) g.rate[p] *= line->data[1 + j];
            add_row(m, d, i, row, e.a, e.b, g.rate);
        }
    }
}

/* a spring, damper, servo or actuator */
static void along(const jo_model *m, jo_data *d, int i)
{
    const jo_force *f = &m->force[i];
    const jo_coordinate_work *w = &d->coordinate[f->coordinate];
    const double limit = JO_RE(f->data[4]);
    const jo_real y = d->force[i].y[0];
    jo_real fs = -f->data[0], frate = -f->data[1];
    element e;
    gradients g;
    if (f->spring >= 0) fs += jo_signal_at(m, d, f->spring, w->value).rate;
    if (f->damper >= 0) frate += jo_signal_at(m, d, f->damper, w->rate).rate;
    if (limit > 0.0 && fabs(JO_RE(y)) >= limit) fs = frate = 0.0;
    gradient_rate(m, d, f->coordinate, &g);
    start(&e, m->coordinate[f->coordinate].a, m->coordinate[f->coordinate].b);
    add_along(m, d, &e, f->coordinate, &g, y, fs, frate);
    finish(m, d, &e);
}

/* y (6) on b, resolved in a, depends on the relative motion; X (6 x 12): its derivatives with respect to the changes
 * [position, rotation, velocity, angular velocity] of b against a, resolved in a */
static void between(const jo_model *m, jo_data *d, const jo_force *f, const jo_real *y, jo_real (*X)[12])
{
    const jo_marker_work *a = &d->marker[f->a], *b = &d->marker[f->b];
    jo_real K[12][24] = {{0.0}}, r[3], va[3], vb[3], oma[3], omb[3], t[3], M[9];
    element e;
    start(&e, f->a, f->b);
    jo_set3(r, b->r);
    jo_sub3(r, a->r);
    jo_to_world(va, m, d, f->a, a->v);
    jo_to_world(vb, m, d, f->b, b->v);
    jo_to_world(oma, m, d, f->a, a->om);
    jo_to_world(omb, m, d, f->b, b->om);
    jo_cross(t, oma, r);
    jo_sub3(vb, va);
    jo_sub3(vb, t);      /* relative velocity */
    jo_sub3(omb, oma);
    /* changes of the relative motion, first in the world frame: e.Y serves as scratch */
    for (int p = 0; p < 3; p++) {
        e.Y[p][DR + p] = e.Y[3 + p][DPHI + p] = e.Y[6 + p][DV + p] = e.Y[9 + p][DOM + p] = -1.0;
        e.Y[p][OF_B + DR + p] = e.Y[3 + p][OF_B + DPHI + p] = e.Y[6 + p][OF_B + DV + p] = e.Y[9 + p][OF_B + DOM + p] = 1.0;
    }
    add_skew(&e, 0, DPHI, 1.0, r);         /* -phi_a x r */
    add_skew(&e, 6, DOM, 1.0, r);          /* -dom_a x r */
    add_skew(&e, 6, DR, 1.0, oma);         /* -om_a x dr */
    add_skew(&e, 6, OF_B + DR, -1.0, oma);
    add_skew(&e, 6, DPHI, 1.0, vb);
    add_skew(&e, 9, DPHI, 1.0, omb);
    for (int p = 0; p < 12; p++)
        for (int q = 0; q < 24; q++)
            for (int s = 0; s < 3; s++) K[p][q] += a->A[3 * s + p % 3] * e.Y[3 * (p / 3) + s][q];
    start(&e, f->a, f->b);
    jo_mul3(e.y + 6, a->A, y);
    jo_mul3(e.y + 9, a->A, y + 3);
    for (int p = 0; p < 6; p++)
        for (int q = 0; q < 24; q++) {
            jo_real x = 0.0;
            for (int s = 0; s < 12; s++) x += X[p][s] * K[s][q];
            for (int s = 0; s < 3; s++) e.Y[6 + 3 * (p / 3) + s][q] += a->A[3 * s + p % 3] * x;
        }
    add_skew(&e, 6, DPHI, -1.0, e.y + 6);
    add_skew(&e, 9, DPHI, -1.0, e.y + 9);
    /* on a: -F, -T - r x F */
    jo_cross(t, r, e.y + 6);
    for (int i = 0; i < 9; i++) M[i] = 0.0;
    M[1] = -r[2]; M[2] = r[1]; M[3] = r[2]; M[5] = -r[0]; M[6] = -r[1]; M[7] = r[0];
    for (int p = 0; p < 3; p++) {
        e.y[p] = -e.y[6 + p];
        e.y[3 + p] = -e.y[9 + p] - t[p];
        for (int q = 0; q < 24; q++) {
            e.Y[p][q] = -e.Y[6 + p][q];
            e.Y[3 + p][q] = -e.Y[9 + p][q] - (M[3 * p] * e.Y[6][q] + M[3 * p + 1] * e.Y[7][q] + M[3 * p + 2] * e.Y[8][q]);
        }
    }
    add_skew(&e, 3, DR, -1.0, e.y + 6);    /* -dr x F = F x dr, dr = dr_b - dr_a */
    add_skew(&e, 3, OF_B + DR, 1.0, e.y + 6);
    finish(m, d, &e);
}

/* M (3x3) = d(x + sign theta x x / 2 + c theta x (theta x x)) / dtheta of jo_conjugate, and the same with respect to x in P */
static void conjugate_rate(jo_real *M, jo_real *P, const jo_real *theta, const jo_real *x, double sign)
{
    const jo_real s = jo_dot3(theta, theta);
    jo_real c, dc, one[3], two[3];
    if (JO_RE(s) < 0.01) {
        c = 1.0 / 12.0 + s * (1.0 / 720.0 + s * (1.0 / 30240.0 + s * (1.0 / 1209600.0 + s / 47900160.0)));
        dc = 1.0 / 720.0 + s * (1.0 / 15120.0 + s * (1.0 / 403200.0 + s * (1.0 / 11975040.0 + s * 5.0 * 5.2840e-10)));
    } else {
        const jo_real h = 0.5 * jo_sqrt(s), sine = jo_sin(h), cot = jo_cos(h) / sine;
        c = (1.0 - h * cot) / s;
        dc = (h / (sine * sine) - cot) / (8.0 * h * s) - c / s;
    }
    jo_cross(one, theta, x);
    jo_cross(two, theta, one);
    const jo_real tx = jo_dot3(theta, x);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            /* c (e x one + theta x (e x x)), theta x (e x x) = e (theta . x) - x (theta . e) */
            M[3 * i + j] = 2.0 * dc * two[i] * theta[j] - c * x[i] * theta[j] + (i == j ? c * tx : 0.0);
            P[3 * i + j] = c * theta[i] * theta[j] + (i == j ? 1.0 - c * s : 0.0);
        }
    const jo_real half = 0.5 * sign;
    const jo_real u[3] = {-half * x[0] - c * one[0], -half * x[1] - c * one[1], -half * x[2] - c * one[2]};
    M[1] -= u[2]; M[2] += u[1]; M[3] += u[2]; M[5] -= u[0]; M[6] -= u[1]; M[7] += u[0];
    P[1] -= half * theta[2]; P[2] += half * theta[1]; P[3] += half * theta[2];
    P[5] -= half * theta[0]; P[6] -= half * theta[1]; P[7] += half * theta[0];
}

static void bushing(const jo_model *m, jo_data *d, int i)
{
    const jo_force *f = &m->force[i];
    jo_real x[6], rate[6], R[9], w[3], g[6], y[6], X[6][12], Z[6][12] = {{0.0}};
    jo_real P[9], Pi[9], M[9], Q[9];   /* theta' = P omega; torque = Q g */
    jo_relative_pose(d, f, x, R);
    jo_rotation_vector(x + 3, R);
    jo_relative_velocity(m, d, f, rate, w);
    jo_conjugate(rate + 3, x + 3, w, -1.0);
    for (int p = 0; p < 6; p++) {
        g[p] = f->data[72 + p];
        for (int q = 0; q < 6; q++) g[p] -= f->data[6 * p + q] * x[q] + f->data[36 + 6 * p + q] * rate[q];
    }
    /* Z: changes of g; dtheta = P dphi, dtheta' = P dom + M dtheta */
    conjugate_rate(M, P, x + 3, w, -1.0);
    jo_mul33(Pi, M, P);
    for (int p = 0; p < 6; p++)
        for (int q = 0; q < 3; q++) {
            const jo_real *K = f->data + 6 * p, *D = f->data + 36 + 6 * p;
            Z[p][q] -= K[q];
            Z[p][6 + q] -= D[q];
            for (int s = 0; s < 3; s++) {
                Z[p][3 + q] -= K[3 + s] * P[3 * s + q] + D[3 + s] * Pi[3 * s + q];
                Z[p][9 + q] -= D[3 + s] * P[3 * s + q];
            }
        }
    jo_set3(y, g);
    jo_conjugate(y + 3, x + 3, g + 3, 1.0);
    conjugate_rate(M, Q, x + 3, g + 3, 1.0);
    jo_mul33(Pi, M, P);
    for (int p = 0; p < 3; p++)
        for (int q = 0; q < 12; q++) {
            X[p][q] = Z[p][q];
            X[3 + p][q] = Q[3 * p] * Z[3][q] + Q[3 * p + 1] * Z[4][q] + Q[3 * p + 2] * Z[5][q];
            if (q >= 3 && q < 6) X[3 + p][q] += Pi[3 * p + q - 3];
        }
    between(m, d, f, y, X);
}

/* the derivatives of a user's function by forward differences: Newton's method converges still, no longer quadratically */
static int user(const jo_model *m, jo_data *d, int i)
{
    const jo_force *f = &m->force[i];
    const double relative = 1e-7;
    jo_real x[18], y[6], X[6][12];
    jo_relative_pose(d, f, x, x + 3);
    jo_relative_velocity(m, d, f, x + 12, x + 15);
    int status = jo_ask(f, d->time[0], x, y);
    for (int j = 0; j < 12 && status == JO_OK; j++) {
        jo_real moved[18], z[6];
        double step = relative;
        for (int k = 0; k < 18; k++) moved[k] = x[k];
        if (j >= 3 && j < 6) {
            jo_real angle[3] = {0.0}, q[4] = {1.0, 0.0, 0.0, 0.0}, E[9];
            angle[j - 3] = step;
            jo_rotate(q, angle);
            jo_rotation(E, q);
            jo_mul33(moved + 3, E, x + 3);
        } else {
            const int k = j < 3 ? j : 6 + j;
            const int group = j < 3 ? 0 : j < 9 ? 12 : 15;
            const double size = sqrt(JO_RE(jo_dot3(x + group, x + group)));
            step *= j < 3 ? (size > 1e-3 * m->size ? size : 1e-3 * m->size) : (size > 1.0 ? size : 1.0);
            moved[k] += step;
        }
        status = jo_ask(f, d->time[0], moved, z);
        for (int p = 0; p < 6; p++) X[p][j] = (z[p] - y[p]) / step;
    }
    if (status == JO_OK) between(m, d, f, y, X);
    return status;
}

/* loads in the world do not change, those that follow turn with the marker */
static void load(const jo_model *m, jo_data *d, int i)
{
    const jo_force *f = &m->force[i];
    element e;
    (void)m;
    start(&e, -1, f->b);
    for (int j = 0; j < 6; j++) e.y[6 + j] = d->force[i].y[j];
    if (f->follow) {
        add_skew(&e, 6, OF_B + DPHI, -1.0, e.y + 6);
        add_skew(&e, 9, OF_B + DPHI, -1.0, e.y + 9);
    }
    finish(m, d, &e);
}

/* the force on the origin turns with the body: r_R -= A f */
static void modal_load(const jo_model *m, jo_data *d, int i)
{
    const jo_force *f = &m->force[i];
    const jo_block N = jo_newton_find(m, d, f->body, f->body);
    const jo_body_work *w = &d->body[f->body];
    jo_real x[3], M[9] = {0.0}, Q[9], P[9];
    jo_mul3t(x, w->A, d->force[i].y);
    M[1] = -x[2]; M[2] = x[1]; M[3] = x[2]; M[5] = -x[0]; M[6] = -x[1]; M[7] = x[0];
    jo_mul33(Q, w->A, M);
    jo_mul33(P, Q, w->turn);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) N.at[r * N.stride + 3 + c] += d->weights.q * P[3 * r + c];
}

int jo_newton_elements(const jo_model *m, jo_data *d)
{
    int status = JO_OK;
    for (int i = 0; i < m->njoint; i++) joint(m, d, i);
    for (int i = 0; i < m->nforce && status == JO_OK; i++) {
        switch (m->force[i].type) {
        case JO_LOAD: load(m, d, i); break;
        case JO_ALONG_COORDINATE: along(m, d, i); break;
        case JO_BUSHING: bushing(m, d, i); break;
        case JO_MODAL_LOAD: modal_load(m, d, i); break;
        case JO_USER: status = user(m, d, i); break;
        default: break;
        }
        if (status != JO_OK) d->error_index = i;
    }
    return status;
}
