/* network_layout.c - memory and constants of the networks of states. */
#include "maximal/maximal.h"
#include "tree/tree.h"
#include "network/network.h"

enum { JO_MOST_RESPONSES = 8 };   /* forces along more coordinates: Newton's matrix, factorised once, needs less work than their responses */

int jo_is_network(const jo_force *f) { return f->type == JO_FORCE_network; }

static const jo_network_data *header(const jo_force *f) { return (const jo_network_data *)f->data; }
static const jo_real *rest(const jo_force *f) { return (const jo_real *)(header(f) + 1); }

const jo_real *jo_network_starts(const jo_force *f) { return rest(f); }

int jo_network_coordinate(const jo_force *f, int k)
{
    return k < jo_whole(header(f)->coordinates) ? jo_whole(rest(f)[2 * jo_whole(header(f)->states) + k]) : -1;
}

int jo_network_rows(const jo_model *m)
{
    int rows = 0;
    for (int i = 0; i < m->nforce; i++)
        if (jo_is_network(&m->force[i])) rows += jo_whole(header(&m->force[i])->coordinates);
    return rows;
}

jo_network *jo_network_of(const jo_data *d, const jo_force *f) { return &d->networks.list[jo_whole(header(f)->number)]; }

jo_network *jo_network_of_memory(const jo_data *d, const jo_force *f)
{
    if (f->type == JO_FORCE_delay) return &d->networks.list[jo_whole(((const jo_delay_data *)f->data)->network)];
    return f->type == JO_FORCE_memory ? &d->networks.list[jo_whole(((const jo_memory_data *)f->data)->network)] : 0;
}

void jo_network_coordinates(const jo_model *m, jo_data *d, const jo_network *w)
{
    for (int k = 0; k < w->m; k++) {
        jo_coordinate_value(m, d, w->coordinate[k]);
        jo_coordinate_rate(m, d, w->coordinate[k]);
    }
}

static void count(const jo_force *f, jo_network *w)
{
    const jo_network_data *x = header(f);
    w->n = jo_whole(x->states);
    w->m = jo_whole(x->coordinates);
    w->nsignal = jo_whole(x->signals);
    w->fixed = jo_whole(x->constants);
    w->values = jo_whole(x->values);
    w->instructions = jo_whole(x->instructions);
    w->npush = jo_whole(x->pushes);
    w->nslope = jo_whole(x->slopes);
    w->memories = jo_whole(x->memories);
    w->gravity = jo_whole(x->gravity);
    w->nopening = jo_whole(x->openings);
    w->registers = w->fixed + w->n + 2 * w->m + 1 + 2 * w->nsignal + w->memories + w->gravity + w->instructions;
}

static void take(const jo_model *m, const jo_force *f, jo_network *w, jo_arena *a)
{
    w->coordinate = jo_take_ints(a, w->m);
    w->signal = jo_take_ints(a, w->nsignal);
    w->code = jo_take_ints(a, 4 * w->instructions);
    w->rate = jo_take_ints(a, w->n);
    w->push = jo_take_ints(a, 2 * w->npush);
    w->slope = jo_take_ints(a, 3 * w->nslope);
    w->opening = jo_take_ints(a, w->nopening);
    w->before = jo_take_reals(a, w->nopening);
    w->most = jo_take_doubles(a, 2 * w->nopening);
    w->pivot = jo_take_ints(a, w->n);
    w->memory = jo_take_ints(a, w->memories);
    w->at = jo_take_ints(a, 2 * w->m);
    w->count = jo_take_ints(a, 2 * w->m);
    w->link = jo_take_ints(a, 2 * w->m);
    w->r = jo_take_reals(a, w->registers);
    w->S = jo_take_reals(a, (w->n + w->m) * (w->n + 2 * w->m));
    w->A = jo_take_reals(a, w->n * w->n);
    jo_real **square[3] = {&w->K, &w->D, &w->G}, **of_rows[4] = {&w->u, &w->w, &w->y, &w->F}, **of_states[2] = {&w->k, &w->z};
    for (int i = 0; i < 3; i++) *square[i] = jo_take_reals(a, w->m * w->m);
    for (int i = 0; i < 4; i++) *of_rows[i] = jo_take_reals(a, w->m);
    for (int i = 0; i < 2; i++) *of_states[i] = jo_take_reals(a, w->n);
    w->J = (jo_real **)jo_take_many(a, 2 * w->m, sizeof *w->J);
    for (int k = 0; k < w->m; k++) {
        const jo_coordinate *c = &m->coordinate[jo_network_coordinate(f, k)];
        const int first = jo_marker_velocities(m, c->a), second = jo_marker_velocities(m, c->b), all = m->nlink && m->nu > first ? m->nu : first;
        jo_real *x = jo_take_reals(a, all), *y = jo_take_reals(a, second);
        if (!a->base) continue;
        w->J[2 * k] = x;
        w->J[2 * k + 1] = y;
    }
}

static const jo_real *read_ints(const jo_real *x, int *y, int n)
{
    for (int i = 0; i < n; i++) y[i] = jo_whole(x[i]);
    return x + n;
}

/* Marks results that depend on time or signals, and returns whether a force does. Registers of inputs and results are overwritten. */
static int depends_on_time(jo_network *w)
{
    const int inputs = w->fixed, time = inputs + w->n + 2 * w->m, memories = time + 1 + 2 * w->nsignal, first = w->registers - w->instructions;
    int depends = 0;
    for (int i = inputs; i < first; i++) w->r[i] = jo_same(i >= time && i < memories ? 1.0 : 0.0);
    for (int i = 0; i < w->values; i++) {
        const int *k = w->code + 4 * i;
        int any = 0;
        for (int j = 1; j < 4; j++) any |= k[j] >= inputs && JO_RE(w->r[k[j]]) > 0.0;
        w->r[first + i] = jo_same(any ? 1.0 : 0.0);
    }
    for (int i = 0; i < w->npush; i++) depends |= w->push[2 * i + 1] >= inputs && JO_RE(w->r[w->push[2 * i + 1]]) > 0.0;
    return depends;
}

static void read(const jo_force *f, jo_network *w)
{
    const jo_real *x = read_ints(rest(f) + 2 * w->n, w->coordinate, w->m);
    x = read_ints(x, w->signal, w->nsignal);
    for (int i = 0; i < w->fixed; i++) w->r[i] = *x++;
    x = read_ints(x, w->code, 4 * w->instructions);
    x = read_ints(x, w->rate, w->n);
    x = read_ints(x, w->push, 2 * w->npush);
    x = read_ints(x, w->slope, 3 * w->nslope);
    read_ints(x, w->opening, w->nopening);
    w->last = -INFINITY;
    w->timed = depends_on_time(w);
    w->computed = 0;
}

/* room for the responses of network_response.c; most: bound of their number */
static void responses_layout(const jo_model *m, jo_networks *all, int most, jo_arena *a)
{
    const int rows = most > JO_MOST_RESPONSES || m->nbeam || m->nfriction ? 0 : most;
    all->most = most;
    all->row = jo_take_ints(a, 2 * rows);
    all->pivot = jo_take_ints(a, rows);
    all->a = jo_take_reals(a, rows * m->nv);
    all->lam = jo_take_reals(a, (rows + 1) * m->nrow);
    all->A = jo_take_reals(a, rows * rows);
    all->x = jo_take_reals(a, rows);
}

void jo_networks_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    jo_networks *all = &d->networks;
    all->count = 0;
    for (int i = 0; i < m->nforce; i++) all->count += jo_is_network(&m->force[i]);
    all->list = (jo_network *)jo_take_many(a, all->count, sizeof *all->list);
    int most = 0;
    for (int i = 0, k = 0; i < m->nforce; i++) {
        if (!jo_is_network(&m->force[i])) continue;
        jo_network spare, *w = a->base ? &all->list[k++] : &spare;
        w->force = i;
        count(&m->force[i], w);
        take(m, &m->force[i], w, a);
        most += w->npush < w->m ? w->npush : w->m;
    }
    responses_layout(m, all, most, a);
}

/* places of the memories of the networks */
static void find_memories(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        jo_network *w = jo_network_of_memory(d, f);
        if (!w || f->type != JO_FORCE_memory) continue;
        const jo_memory_data *x = (const jo_memory_data *)f->data;
        for (int k = 0; k < jo_whole(x->count); k++) w->memory[jo_whole(x->first) + k] = f->state + 1 + k;
    }
}

static int pushes(const jo_network *w, int k)
{
    for (int i = 0; i < w->npush; i++)
        if (w->push[2 * i] == k) return 1;
    return 0;
}

/* coordinates along which networks push */
static void responses_setup(const jo_model *m, jo_networks *all)
{
    all->rows = 0;
    all->separate = all->most <= JO_MOST_RESPONSES && !m->nbeam && !m->nfriction;
    for (int i = 0; i < all->count && all->separate; i++)
        for (int k = 0; k < all->list[i].m; k++) {
            if (!pushes(&all->list[i], k)) continue;
            all->row[2 * all->rows] = i;
            all->row[2 * all->rows++ + 1] = k;
        }
}

/* constants and codes of all networks, from the numbers of the model */
void jo_networks_setup(const jo_model *m, jo_data *d)
{
    find_memories(m, d);
    for (int i = 0; i < d->networks.count; i++) {
        jo_network *w = &d->networks.list[i];
        read(&m->force[w->force], w);
        for (int k = 0; k < w->m; k++) {
            const jo_coordinate *c = &m->coordinate[w->coordinate[k]];
            w->link[2 * k] = jo_marker_link(m, d, c->a);
            w->link[2 * k + 1] = jo_marker_link(m, d, c->b);
        }
    }
    responses_setup(m, &d->networks);
}
