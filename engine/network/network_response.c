/* network_response.c - networks of states in the matrix of a Rosenbrock method of order 2, without Newton's matrix.
 *
 * Where networks are all that couples masses, a = N^-1 Q is known by the bodies and joints alone, N = [M^ Cq^T; Cq 0]. Forces act along few
 * coordinates, so that J^T G J of network_matrix.c is a correction of small rank (Woodbury): with the responses Y = N^-1 J^T to unit forces
 *   (1 + G J Y) x = G J a,   a -= Y x,
 * and the same of the multipliers. */
#include "maximal/maximal.h"
#include "network/network.h"
#include "valid.h"

int jo_networks_separate(const jo_model *m, const jo_data *d)
{
    (void)m;
    return d->networks.separate && !jo_tree_active(d);
}

/* responses Y (nv) and those of the multipliers (nrow) to a unit force along coordinate k of the first stage */
static void respond(const jo_model *m, jo_data *d, const jo_network *w, int k, int set, jo_real *a, jo_real *lam)
{
    jo_clear_changes(m, d);
    for (int s = 2 * k; s < 2 * k + 2; s++)
        if (w->count[s]) jo_push_body_change(m, d, jo_network_body(m, w, s), w->J[s]);
    jo_respond(m, d, set, a);
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) lam[m->joint[i].row + r] = d->joint[i].x[r];
}

static int acts(const jo_network *w, int k)
{
    int any = 0;
    for (int c = 0; c < w->m; c++) any |= w->G[k * w->m + c] != 0.0;
    return any;
}

/* G J times a vector by rows, y[0], y[stride], ... += */
static void add_changes(const jo_networks *all, const jo_real *a, jo_real *y, int stride)
{
    for (int i = 0, r = 0; i < all->count; i++) {
        jo_network *w = &all->list[i];
        if (r < all->rows && all->row[2 * r] == i) jo_network_rates_along(w, a, w->y);
        for (; r < all->rows && all->row[2 * r] == i; r++) {
            const jo_real *G = w->G + all->row[2 * r + 1] * w->m;
            for (int c = 0; c < w->m; c++) y[r * stride] += G[c] * w->y[c];
        }
    }
}

void jo_networks_respond(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    jo_networks *all = &d->networks;
    jo_real *const before = all->lam + all->rows * m->nrow;
    int active = 0;
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) before[m->joint[i].row + r] = d->joint[i].x[r];
    for (int r = 0; r < all->rows; r++) {
        const jo_network *w = &all->list[all->row[2 * r]];
        jo_real *Y = all->a + r * m->nv, *lam = all->lam + r * m->nrow;
        if (acts(w, all->row[2 * r + 1])) {
            respond(m, d, w, all->row[2 * r + 1], stage->set, Y, lam);
            active = 1;
            continue;
        }
        for (int j = 0; j < m->nv; j++) Y[j] = jo_same(0.0);
        for (int j = 0; j < m->nrow; j++) lam[j] = jo_same(0.0);
    }
    if (!active) return;
    for (int r = 0; r < all->rows; r++) all->x[r] = jo_same(0.0);
    for (int r = 0; r < all->rows * all->rows; r++) all->A[r] = jo_same(r % (all->rows + 1) ? 0.0 : 1.0);
    add_changes(all, d->a, all->x, 1);
    for (int r = 0; r < all->rows; r++) add_changes(all, all->a + r * m->nv, all->A + r, all->rows);
    jo_network_factor(all->A, all->rows, all->pivot);
    jo_network_solve(all->A, all->rows, all->pivot, all->x);
    for (int r = 0; r < all->rows; r++) {
        for (int j = 0; j < m->nv; j++) d->a[j] -= all->x[r] * all->a[r * m->nv + j];
        for (int j = 0; j < m->nrow; j++) before[j] -= all->x[r] * all->lam[r * m->nrow + j];
    }
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) d->joint[i].x[r] = before[m->joint[i].row + r];
}
