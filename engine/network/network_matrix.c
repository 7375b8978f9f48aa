/* network_matrix.c - networks of states in the matrix of a Rosenbrock method of order 2.
 *
 * With the rates k of the increments in a stage and kappa = k_i + sum s_ij k_j (step_rosenbrock.c), the states x' = f(s, s', x) have
 *   (1 - g h f_x) kappa_x = f + S + g h (f_s kappa_s + f_s' kappa_s'),   S = sum s_ij x_j'
 * Eliminated from the force F(s, s', x) they leave, with P = F_x (1 - g h f_x)^-1, the force F + g h P (f + S) and
 *   K = -(F_s + g h P f_s),  D = -(F_s' + g h P f_s'),  G = g h D + (g h)^2 K,
 * as a spring and damper along the coordinates s has them: g h (K u + D w) - G J v_i', u = J (-r_i - sum s_ij r_j - g h sum z_ij v_j'),
 * w = -J sum s_ij v_j'. The derivatives and J are those of the first stage. J^T G J is accounted for after the accelerations without it
 * (network_response.c), enters Newton's matrix of coupled_mass.c, or the equations of a tree in tree_contacts.c. */
#include "valid.h"
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "tree/tree.h"
#include "network/network.h"

/* Derivatives of the rate of coordinate k with respect to the velocities of the bodies, in maximal coordinates: those of the virtual work of a
 * unit force along it */
static void find_jacobian(const jo_model *m, jo_data *d, jo_network *w, int k)
{
    const jo_coordinate *c = &m->coordinate[w->coordinate[k]];
    const int marker[2] = {c->a, c->b};
    jo_clear_changes(m, d);
    jo_push_change(m, d, w->coordinate[k], jo_same(1.0));
    for (int side = 0; side < 2; side++) {
        const int body = m->marker[marker[side]].body, again = side && body == m->marker[c->a].body;
        w->count[2 * k + side] = again ? 0 : jo_marker_velocities(m, marker[side]);
        if (!w->count[2 * k + side]) continue;
        w->at[2 * k + side] = m->body[body].iv;
        jo_body_change(m, d, body, w->J[2 * k + side]);
    }
}

void jo_network_rates_along(const jo_network *w, const jo_real *z, jo_real *y)
{
    for (int k = 0; k < w->m; k++) {
        y[k] = jo_same(0.0);
        for (int s = 2 * k; s < 2 * k + 2; s++)
            for (int j = 0; j < w->count[s]; j++) y[k] += w->J[s][j] * z[w->at[s] + j];
    }
}

/* y = M x, M (m x m) */
static void multiply(const jo_real *M, int m, const jo_real *x, jo_real *y)
{
    for (int i = 0; i < m; i++) {
        y[i] = jo_same(0.0);
        for (int j = 0; j < m; j++) y[i] += M[i * m + j] * x[j];
    }
}

static void place(const jo_model *m, jo_data *d, const jo_stage *stage, jo_network *w)
{
    const double gh = stage->gh;
    jo_network_response(w, 1.0, gh);
    for (int i = 0; i < w->m * w->m; i++) w->G[i] = gh * (w->D[i] + gh * w->K[i]);
    for (int k = 0; k < w->m; k++) {
        if (jo_tree_active(d)) jo_tree_network_jacobian(m, d, w, k);
        else find_jacobian(m, d, w, k);
    }
}

void jo_network_implicit(const jo_model *m, jo_data *d, const jo_stage *stage, jo_network *w)
{
    const double gh = stage->gh;
    const int n = w->n, rows = w->m, columns = n + 2 * rows;
    if (!stage->earlier) {
        place(m, d, stage, w);
        for (int k = 0; k < rows; k++) {
            w->u[k] = -d->coordinate[w->coordinate[k]].rate;
            w->w[k] = jo_same(0.0);
        }
        for (int i = 0; i < n; i++) w->k[i] = jo_same(0.0);
    }
    for (int i = 0; i < n; i++) w->z[i] = w->r[w->rate[i]] + w->k[i];
    jo_network_solve(w->A, n, w->pivot, w->z);
    multiply(w->K, rows, w->u, w->F);
    multiply(w->D, rows, w->w, w->y);
    for (int k = 0; k < rows; k++) {
        jo_real F = w->F[k] + w->y[k];
        for (int i = 0; i < n; i++) F += w->S[(n + k) * columns + i] * w->z[i];
        jo_push_along(m, d, w->coordinate[k], gh * F);
    }
}

void jo_networks_carry(const jo_model *m, jo_data *d)
{
    const jo_real *S = d->acc + d->nw - m->nstate;   /* minus the sum of the earlier stages */
    for (int i = 0; i < d->networks.count; i++) {
        jo_network *w = &d->networks.list[i];
        jo_network_rates_along(w, d->dv, w->u);
        jo_network_rates_along(w, d->acc, w->w);
        for (int j = 0; j < w->n; j++) w->k[j] = -S[m->force[w->force].state + j];
    }
}

/* x' of a stage from the accelerations: kappa_x - S */
void jo_networks_state_rates(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    const double gh = stage->gh;
    for (int i = 0; i < d->networks.count; i++) {
        jo_network *w = &d->networks.list[i];
        const int n = w->n, columns = n + 2 * w->m;
        jo_real *rate = jo_state_rates(m, d) + m->force[w->force].state;
        jo_network_rates_along(w, d->wd, w->y);
        for (int j = 0; j < n; j++) {
            const jo_real *row = w->S + j * columns + n;
            w->z[j] = rate[j] + w->k[j];
            for (int k = 0; k < w->m; k++) w->z[j] += gh * (row[k] * (gh * w->y[k] - w->u[k]) + row[w->m + k] * (w->y[k] - w->w[k]));
        }
        jo_network_solve(w->A, n, w->pivot, w->z);
        for (int j = 0; j < n; j++) rate[j] = w->z[j] - w->k[j];
    }
}

int jo_network_body(const jo_model *m, const jo_network *w, int side)
{
    const jo_coordinate *c = &m->coordinate[w->coordinate[side / 2]];
    return m->marker[side % 2 ? c->b : c->a].body;
}

void jo_networks_add_to_newton(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < d->networks.count; i++) {
        const jo_network *w = &d->networks.list[i];
        for (int s = 0; s < 2 * w->m; s++)
            for (int t = 0; t < 2 * w->m; t++) {
                const jo_real g = w->G[s / 2 * w->m + t / 2];
                if (!w->count[s] || !w->count[t] || g == 0.0) continue;
                const jo_block N = jo_newton_find(m, d, jo_network_body(m, w, s), jo_network_body(m, w, t));
                for (int k = 0; k < w->count[s]; k++)
                    for (int j = 0; j < w->count[t]; j++) N.at[k * N.stride + j] += w->J[s][k] * g * w->J[t][j];
            }
    }
}

void jo_networks_subtract(const jo_model *m, jo_data *d, const jo_real *a)
{
    for (int i = 0; i < d->networks.count; i++) {
        const jo_network *w = &d->networks.list[i];
        jo_network_rates_along(w, a, w->y);
        multiply(w->G, w->m, w->y, w->F);
        for (int s = 0; s < 2 * w->m; s++) {
            if (!w->count[s]) continue;
            jo_real *x = jo_newton_vector(d) + jo_newton_place(m, jo_network_body(m, w, s));
            for (int j = 0; j < w->count[s]; j++) x[j] -= w->J[s][j] * w->F[s / 2];
        }
    }
}
