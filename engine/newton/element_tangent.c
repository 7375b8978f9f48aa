/* element_tangent.c - joint or force element between two markers in Newton's matrix, see jo_element of newton.h. */
#include "newton/newton.h"
#include "maximal/maximal.h"

void jo_element_start(jo_element *e, int a, int b)
{
    e->a = a;
    e->b = b;
    e->of_a = a;
    e->of_b = b;
    for (int i = 0; i < 12; i++) {
        e->y[i] = 0.0;
        for (int j = 0; j < 24; j++) e->Y[i][j] = 0.0;
    }
}

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

/* N -= L^T Y W for each pair of sides; loads of the markers += y */
void jo_element_finish(const jo_model *m, jo_data *d, const jo_element *e)
{
    const int marker[2] = {e->a, e->b}, moved[2] = {e->of_a, e->of_b};
    for (int s = 0; s < 2; s++) {
        const int body = marker[s] < 0 ? -1 : m->marker[marker[s]].body;
        if (body < 0) continue;
        jo_marker_tangent *w = &d->newton.marker[marker[s]];
        const int n = 6 + m->body[body].n, row = jo_pad(n);
        for (int i = 0; i < 6; i++) w->load[i] += e->y[6 * s + i];
        for (int t = 0; t < 2; t++) {
            const int other = moved[t] < 0 ? -1 : m->marker[moved[t]].body;
            if (other < 0) continue;
            const int columns = jo_pad(6 + m->body[other].n);
            const jo_real *W = d->newton.marker[moved[t]].W;
            const jo_block N = jo_newton_find(m, d, body, other);
            for (int half = 0; half < 2; half++) {
                int used[4], any = 0;
                for (int k = 0; k < 4; k++) any |= used[k] = !is_zero(e, 6 * s + 3 * half, 12 * t + 3 * k);
                if (!any) continue;
                const jo_real *L = w->L + 3 * half * row;
                JO_EACH(j, columns) {   /* the padding of W is 0 */
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

/* Change of the gradient of a coordinate by [dr, pa, pb] = changes of [r_b - r_a, phi_a, phi_b]. */
typedef struct { jo_real along[3], turn_a[3], turn_b[3]; } gradient;

/* angle: change of turn_b = (x h x g - y h x f) / (x^2 + y^2) with x = h . f, y = h . g; turn_a = -turn_b */
static inline void angle_change(const jo_marker_work *a, const jo_marker_work *b, const jo_real *pa, const jo_real *pb,
                                gradient *c)
{
    jo_real f[3], k[3], h[3], df[3], dg[3], dh[3], hg[3], hf[3], p[3], q[3], t[3];
    jo_axis(f, a->A, 0);
    jo_axis(k, a->A, 1);
    jo_axis(h, b->A, 0);
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
        c->turn_b[i] = ds * (x * hg[i] - y * hf[i]) + s * (dx * hg[i] + x * p[i] - dy * hf[i] - y * q[i]);
        c->turn_a[i] = -c->turn_b[i];
    }
}

/* c = change of the gradient of a coordinate by dr, pa, pb */
static inline void gradient_change(const jo_data *d, const jo_coordinate *k, const jo_coordinate_work *w, const jo_real *dr,
                                   const jo_real *pa, const jo_real *pb, gradient *c)
{
    const jo_marker_work *a = &d->marker[k->a], *b = &d->marker[k->b];
    jo_real f[3], h[3], r[3], t[3], u[3];
    switch (k->type) {
    case JO_COORDINATE_AXES:
        jo_axis(f, a->A, k->axis_a);
        jo_axis(h, b->A, k->axis_b);
        jo_cross(t, pa, f);
        jo_cross(c->turn_a, t, h);
        jo_cross(t, pb, h);
        jo_cross(u, f, t);
        jo_add3(c->turn_a, u);
        for (int i = 0; i < 3; i++) c->turn_b[i] = -c->turn_a[i];
        break;
    case JO_COORDINATE_ALONG:
        jo_set3(r, b->r);
        jo_sub3(r, a->r);
        jo_axis(f, a->A, k->axis_a);
        jo_cross(c->along, pa, f);
        jo_cross(c->turn_a, c->along, r);
        jo_cross(t, f, dr);
        jo_add3(c->turn_a, t);
        break;
    case JO_COORDINATE_DISTANCE: {
        const jo_real s = jo_dot3(w->along, dr);
        for (int i = 0; i < 3; i++) c->along[i] = (dr[i] - s * w->along[i]) / w->value;
        break;
    }
    case JO_COORDINATE_RIM:
    case JO_COORDINATE_ROLLED:
    case JO_COORDINATE_ACROSS:
    case JO_COORDINATE_RAIL_GAP:
    case JO_COORDINATE_RAIL_ROLLED:
    case JO_COORDINATE_RAIL_ACROSS:
    case JO_COORDINATE_SLIP:
    case JO_COORDINATE_ROPE: jo_gradient_change(k, a, b, dr, pa, pb, c->along, c->turn_a, c->turn_b); break;
    default: angle_change(a, b, pa, pb, c);
    }
}

/* derivatives of s and of s' = along . (v_b - v_a) + turn_a . om_a + turn_b . om_b with respect to the 24 changes, from G */
static void own_gradients(const jo_model *m, const jo_data *d, const jo_coordinate *c, const jo_coordinate_work *w, jo_gradients *g)
{
    for (int i = 0; i < 24; i++) g->s[i] = g->rate[i] = 0.0;
    for (int i = 0; i < 3; i++) {
        g->s[JO_DR + i] = -w->along[i]; g->s[JO_OF_B + JO_DR + i] = w->along[i];
        g->s[JO_DPHI + i] = w->turn_a[i]; g->s[JO_OF_B + JO_DPHI + i] = w->turn_b[i];
        g->rate[JO_DV + i] = -w->along[i]; g->rate[JO_OF_B + JO_DV + i] = w->along[i];
        g->rate[JO_DOM + i] = w->turn_a[i]; g->rate[JO_OF_B + JO_DOM + i] = w->turn_b[i];
    }
    const jo_marker_work *a = &d->marker[c->a], *b = &d->marker[c->b];
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

void jo_element_gradients(const jo_model *m, const jo_data *d, int coordinate, jo_gradients *g)
{
    const jo_coordinate *k = &m->coordinate[coordinate];
    const jo_coordinate_work *w = &d->coordinate[coordinate];
    for (int j = 0; j < 9; j++) {
        jo_real change[3][3] = {{0.0}};   /* [dr, pa, pb] */
        gradient c = {{0.0}, {0.0}, {0.0}};
        change[j / 3][j % 3] = 1.0;
        gradient_change(d, k, w, change[0], change[1], change[2], &c);
        for (int i = 0; i < 3; i++) { g->G[i][j] = c.along[i]; g->G[3 + i][j] = c.turn_a[i]; g->G[6 + i][j] = c.turn_b[i]; }
    }
    own_gradients(m, d, k, w, g);
}

/* gradient of a coordinate with respect to [r, phi] of a and of b */
static inline void gradient_of(const jo_coordinate_work *w, jo_real *y)
{
    for (int i = 0; i < 3; i++) { y[i] = -w->along[i]; y[3 + i] = w->turn_a[i]; y[6 + i] = w->along[i]; y[9 + i] = w->turn_b[i]; }
}

/* Y += gradient (fs ds + frate ds'), s: a coordinate of the markers of_a, of_b with the gradients g */
void jo_element_cross(const jo_data *d, jo_element *e, int coordinate, int of_a, int of_b, const jo_gradients *g, jo_real fs,
                      jo_real frate)
{
    jo_real y[12];
    gradient_of(&d->coordinate[coordinate], y);
    e->of_a = of_a;
    e->of_b = of_b;
    for (int i = 0; i < 12; i++)
        for (int j = 0; j < 24; j++) e->Y[i][j] += y[i] * (fs * g->s[j] + frate * g->rate[j]);
}

/* y += f gradient, Y += f G + gradient (fs ds + frate ds'): force f along a coordinate with fs = df/ds, frate = df/ds' */
void jo_element_along(const jo_data *d, jo_element *e, int coordinate, const jo_gradients *g, jo_real f, jo_real fs,
                      jo_real frate)
{
    jo_real y[12];
    gradient_of(&d->coordinate[coordinate], y);
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
