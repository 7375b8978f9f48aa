/* reactions.c - reaction forces of joints from their multipliers, for sensors and as forces on the bodies. */
#include "maximal/maximal.h"

/* y = force and moment (world) of a joint on side 1: -lam for coincident points, lam f x h for perpendicular axes,
 * -lam factor [gradient of s] for lines */
void jo_reaction_of(const jo_model *m, const jo_data *d, int joint, const jo_real *lam, jo_real *y)
{
    const jo_joint *k = &m->joint[joint];
    const jo_real *Aa = d->marker[k->side[0]].A, *Ab = d->marker[k->side[1]].A;
    for (int i = 0; i < 6; i++) y[i] = jo_same(0.0);
    if (k->coincident) {
        for (int i = 0; i < 3; i++) y[i] = -lam[i];
        lam += 3;
    }
    for (int r = 0; r < k->nperp; r++) {
        jo_real f[3], h[3], s[3];
        for (int i = 0; i < 3; i++) { f[i] = Aa[3 * i + k->perp_a[r]]; h[i] = Ab[3 * i + k->perp_b[r]]; }
        jo_cross(s, f, h);
        jo_axpy3(y + 3, lam[r], s);
    }
    lam += k->nperp;
    for (int l = 0; l < k->nline; l++) {
        const jo_line *line = &m->line[k->line + l];
        for (int j = 0; j < line->count; j++) {
            if (line->side[j]) continue;   /* couplings: the first coordinate only */
            const jo_coordinate_work *c = &d->coordinate[line->coordinate[j]];
            jo_axpy3(y, -lam[l] * line->data->factor[j], c->along);
            jo_axpy3(y + 3, -lam[l] * line->data->factor[j], c->turn_b);
        }
    }
}

/* force and moment with which the joint acts on marker b, world */
void jo_reaction(const jo_model *m, const jo_data *d, int joint, jo_real *y)
{
    jo_reaction_of(m, d, joint, d->lam + m->joint[joint].row, y);
}

/* y = s x */
static void scaled(jo_real *y, jo_real s, const jo_real *x)
{
    for (int i = 0; i < 3; i++) y[i] = s * x[i];
}

/* force -lam times the gradient of the coordinate on its markers a and b; lam includes the factor */
static void apply_coordinate_reaction(const jo_model *m, jo_data *d, int coordinate, jo_real lam)
{
    const jo_coordinate *c = &m->coordinate[coordinate];
    const jo_coordinate_work *w = &d->coordinate[coordinate];
    jo_real F[3], T[3];
    scaled(F, -lam, w->along);
    scaled(T, -lam, w->turn_b);
    jo_push(m, d, c->b, F, T);
    scaled(F, lam, w->along);
    scaled(T, -lam, w->turn_a);
    jo_push(m, d, c->a, F, T);
}

/* forces -Cq^T lam of one joint on its bodies; 0 for an optional joint that is not active */
void jo_apply_reaction(const jo_model *m, jo_data *d, int joint)
{
    static const jo_real none[3] = {0.0, 0.0, 0.0};
    const jo_joint *k = &m->joint[joint];
    const jo_real *lam = d->lam + k->row;
    const int a = k->side[0], b = k->side[1];
    jo_real x[3], y[3], t[3];
    if (k->lock >= 0 && !d->locked[k->lock]) return;
    if (k->coincident) {
        jo_push(m, d, a, lam, none);
        scaled(x, jo_same(-1.0), lam);
        jo_push(m, d, b, x, none);
        lam += 3;
    }
    for (int r = 0; r < k->nperp; r++, lam++) {   /* (x . y)' = (om_a - om_b) . (x x y) */
        const jo_real *A = d->marker[a].A + k->perp_a[r], *B = d->marker[b].A + k->perp_b[r];
        for (int j = 0; j < 3; j++) { x[j] = A[3 * j]; y[j] = B[3 * j]; }
        jo_cross(t, x, y);
        scaled(x, -lam[0], t);
        jo_push(m, d, a, none, x);
        scaled(x, lam[0], t);
        jo_push(m, d, b, none, x);
    }
    for (int r = 0; r < k->nline; r++, lam++) {
        const jo_line *l = &m->line[k->line + r];
        for (int j = 0; j < l->count; j++) apply_coordinate_reaction(m, d, l->coordinate[j], l->data->factor[j] * lam[0]);
    }
}

/* forces -Cq^T lam of all joints on the bodies */
void jo_apply_reactions(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->njoint; i++) jo_apply_reaction(m, d, i);
}
