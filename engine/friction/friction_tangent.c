/* friction_tangent.c - derivatives of friction forces with respect to rates, positions and multipliers, in Newton's matrix. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "friction/friction_law.h"

/* Derivatives of force . F + moment . M of the reaction F, M of a joint: with respect to the motion of the markers, x (24), and to the
 * multipliers, l. F and M are resolved in the axes of side 0, which rotate. */
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
        jo_axis(u, d->marker[k->side[0]].A, k->perp_a[r]);
        jo_axis(v, d->marker[k->side[1]].A, k->perp_b[r]);
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

/* friction forces of one joint in Newton's matrix */
static void friction_tangent(const jo_model *m, jo_data *d, int i)
{
    const jo_friction *f = &m->friction[i];
    const jo_joint *k = &m->joint[f->joint];
    const int coordinate[2] = {f->coordinate, f->other}, count = f->other >= 0 ? 2 : 1;
    jo_slopes slopes;
    jo_gradients g[2];
    jo_element e;
    if (f->law && d->locked[m->joint[f->lock].lock]) return;   /* sticking: lock rows instead */
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
        for (int side = 0; side < 2; side++) {   /* with respect to the multipliers: r -= L^T y l */
            const int body = m->marker[k->side[side]].body;
            if (body < 0) continue;
            const jo_real *L = jo_marker_derivatives(d, k->side[side]);
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

void jo_newton_frictions(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++) friction_tangent(m, d, i);
}
