/* newton_blocks.c - blocks of Newton's matrix. With sets of shapes, of which any two may touch, most of its blocks are zero at a time: those that
 * are found since the matrix was cleared, and the fill-in of the elimination, are marked as used. */
#include "valid.h"
#include "newton/newton.h"

int jo_newton_branches(const jo_model *m)
{
    return m->nnode ? m->node[m->nnode - 1].first + m->node[m->nnode - 1].count : 0;
}

/* branch of a node to a later one; -1: none. They are in ascending order. */
static int branch_to(const jo_model *m, int early, int late)
{
    int low = m->node[early].first, high = low + m->node[early].count;
    const int end = high;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (m->branch[middle].node < late) low = middle + 1;
        else high = middle;
    }
    return low < end && m->branch[low].node == late ? low : -1;
}

jo_block jo_newton_find(const jo_model *m, jo_data *d, int x, int y)
{
    const jo_place *p = &m->place[x], *q = &m->place[y];
    const int early = p->node < q->node ? p->node : q->node, late = p->node < q->node ? q->node : p->node;
    const jo_node *node = &m->node[early];
    jo_block block = {d->newton.N + node->diagonal, jo_pad(node->size)};
    if (early != late) {
        const int b = branch_to(m, early, late);
        const jo_branch *branch = &m->branch[b < 0 ? 0 : b];
        if (b < 0 || (p->node == late ? p->local : q->local) >= branch->width) {
            const jo_block none = {0, 0};
            return none;
        }
        if (d->newton.sparse) d->newton.used[b] = 1;
        if (p->node == late) {
            block.at = d->newton.N + branch->lower;
        } else {
            block.at = d->newton.N + branch->upper;
            block.stride = jo_pad(branch->width);
        }
    }
    block.at += p->local * block.stride + q->local;
    return block;
}

/* whether bodies x, y have a block, without a mark on it */
int jo_newton_couples(const jo_model *m, int x, int y)
{
    const int p = m->place[x].node, q = m->place[y].node;
    return p == q || branch_to(m, p < q ? p : q, p < q ? q : p) >= 0;
}

static void set_zeros(jo_real *x, int count)
{
    for (int i = 0; i < count; i++) x[i] = jo_same(0.0);
}

void jo_newton_clear(const jo_model *m, jo_data *d)
{
    if (!d->newton.sparse) {
        set_zeros(d->newton.N, m->nnewton);
        return;
    }
    for (int c = 0; c < m->nnode; c++) {
        const jo_node *node = &m->node[c];
        set_zeros(d->newton.N + node->diagonal, node->size * jo_pad(node->size));
        for (int b = node->first; b < node->first + node->count; b++) {
            const jo_branch *branch = &m->branch[b];
            if (!d->newton.used[b]) continue;
            d->newton.used[b] = 0;
            set_zeros(d->newton.N + branch->lower, branch->width * jo_pad(node->size));
            set_zeros(d->newton.N + branch->upper, node->size * jo_pad(branch->width));
        }
    }
}

int jo_newton_fill_in(const jo_model *m, jo_data *d, int c)
{
    const jo_node *node = &m->node[c];
    int count = 0, *row = d->newton.row;
    for (int b = 0; b < node->count; b++)
        if (d->newton.used[node->first + b]) row[count++] = b;
    for (int i = 0; i < count; i++)
        for (int j = i + 1; j < count; j++)
            d->newton.used[branch_to(m, m->branch[node->first + row[i]].node, m->branch[node->first + row[j]].node)] = 1;
    return count;
}
