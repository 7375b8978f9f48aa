/* hubs.c - bodies with many joints (hubs) in the Schur complement: their velocities are additional unknowns, see jo_pull.
 *
 * [D V; V^T -1] [lam; y] = [b; 0] is S lam = b with S = D + V V^T. The joints of a hub are coupled with its column only, not with
 * one another.
 */
#include "maximal/maximal.h"

/* blocks of the hubs, and block of V of each side; first: whether the side is the first to write its block */
void jo_hub_plan(const jo_model *m, jo_data *d)
{
    for (int c = 0; c < m->ncolumn; c++) {
        const int hub = m->column[c].joint - m->njoint;
        if (hub < 0) continue;
        d->schur.hubs[hub] = d->schur.S + JO_BLOCK * c;
        d->schur.hubs[hub][0] = jo_same(0.0);
    }
    for (int i = 0; i < m->npull; i++) {
        const jo_pull *p = &m->pull[i];
        const jo_joint *joint = &m->joint[p->joint];
        jo_pull_plan *w = &d->schur.pulls[i];
        w->S = d->schur.S + JO_BLOCK * p->block;
        w->side = &d->joint[p->joint].maximal.side[p->side];
        w->rows = joint->nrow;
        w->first = JO_COMMON(w->S[0]) != 0.0;
        w->lock = joint->release >= 0 ? &d->joint[p->joint].maximal.present : joint->lock < 0 ? 0 : d->locked + joint->lock;
        w->later = p->later;
        w->S[0] = jo_same(0.0);
    }
}

/* diagonal blocks -1 of the hubs, blocks V of their joints */
void jo_hub_assemble(const jo_model *m, jo_data *d)
{
    const int six = jo_padded(6);   /* rows of a block: the joint or hub that is eliminated later */
    for (int h = 0; h < m->nhub; h++) {
        for (int j = 0; j < JO_BLOCK; j++) d->schur.hubs[h][j] = jo_same(0.0);
        for (int j = 0; j < 6; j++) d->schur.hubs[h][(six + 1) * j] = jo_same(-1.0);
    }
    for (int i = 0; i < m->npull; i++) {
        const jo_pull_plan *p = &d->schur.pulls[i];
        const int ld = jo_padded(p->rows);
        for (int j = 0; j < JO_BLOCK && p->first; j++) p->S[j] = jo_same(0.0);
        if (p->lock && !*p->lock) continue;
        for (int c = 0; c < 6; c++)
            for (int r = 0; r < p->rows; r++)
                p->S[p->later ? ld * c + r : six * r + c] += p->side->V[ld * c + r];
    }
}

/* scale += diagonal of V V^T of joints on hubs */
void jo_hub_scales(const jo_model *m, jo_data *d)
{
    const int six = jo_padded(6);
    for (int i = 0; i < m->npull; i++) {
        const jo_pull_plan *p = &d->schur.pulls[i];
        if (!p->first || (p->lock && !*p->lock)) continue;   /* once per block, which contains all sides of the joint */
        jo_real *scale = d->joint[m->pull[i].joint].maximal.scale;
        const int ld = jo_padded(p->rows);
        for (int c = 0; c < 6; c++)
            for (int r = 0; r < p->rows; r++) {
                const jo_real v = p->S[p->later ? ld * c + r : six * r + c];
                scale[r] += v * v;
            }
    }
}
