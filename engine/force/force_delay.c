/* force_delay.c - delays of a network of states: the value that an expression u had a time tau ago.
 *
 * States: the memory of delay_ring.c. A point is added at the end of each step, and a second one at the same time where u or u' jumps there.
 * Steps end where the output jumps, and 2 tau, 3 tau and 4 tau after the start, where its higher derivatives jump; they are at most tau
 * long. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"
#include "force/delay_ring.h"
#include "network/network.h"

static const jo_delay_data *numbers(const jo_force *f) { return (const jo_delay_data *)f->data; }
static const jo_real *own(const jo_model *m, const jo_data *d, const jo_force *f) { return jo_states(m, d) + f->state; }

/* u at the end of a step, or within one */
static jo_delay_point present(const jo_model *m, const jo_data *d, const jo_force *f)
{
    jo_network *w = jo_network_of_memory(d, f);
    jo_network_evaluate(m, d, w, jo_states(m, d) + m->force[w->force].state, 0.0, 0);
    const int slope = jo_whole(numbers(f)->slope);
    const jo_delay_point p = {d->time[0], w->r[jo_whole(numbers(f)->input)], slope < 0 ? jo_same(0.0) : w->r[slope]};
    return p;
}

int jo_delay_count(const jo_data *d) { return d->forces.following; }

void jo_delay_keep(const jo_model *m, jo_data *d, int k)
{
    const jo_force *f = &m->force[d->forces.follower[k]];
    jo_real *x = d->forces.next;
    const jo_delay_point p = present(m, d, f);
    for (int i = 0; i < f->states; i++) x[i] = own(m, d, f)[i];
    jo_ring_add(f, x, &p, jo_whole(numbers(f)->slope) >= 0);
}

double jo_delay_error(const jo_model *m, const jo_data *d, int k)
{
    const jo_force *f = &m->force[d->forces.follower[k]];
    const jo_delay_point p = present(m, d, f);
    return jo_ring_error(f, own(m, d, f), d->forces.next, &p);
}

static jo_real update(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x)
{
    const jo_delay_point p = present(m, d, f);
    jo_ring_add(f, x, &p, jo_whole(numbers(f)->slope) >= 0);
    x[JO_DELAY_JUMPS] = jo_same(jo_ring_jumps(f, x) ? 1.0 : 0.0);
    return jo_same(0.0);
}

static jo_real margin(const jo_model *m, const jo_data *d, const jo_force *f)
{
    (void)m; (void)d; (void)f;
    return jo_same(1.0);
}

static int jumps(const jo_force *f, const jo_real *before, const jo_real *after)
{
    (void)f; (void)before;
    return JO_RE(after[JO_DELAY_JUMPS]) != 0.0;
}

static double longest_step(const jo_model *m, const jo_data *d, const jo_force *f, int explicit_method)
{
    (void)explicit_method;
    return jo_ring_longest_step(f, own(m, d, f), JO_RE(d->time[0]));
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *y)
{
    static const jo_force_work none = {{0.0}, 0.0, 0.0, 0.0};
    *y = none;
    jo_keep_states(m, d, stage, f);
    return jo_ring_full(f, own(m, d, f), JO_RE(d->time[0])) ? JO_DELAY_FULL : JO_OK;
}

static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *y)
{
    (void)m; (void)d; (void)stage; (void)f; (void)y;
    return JO_OK;
}

/* no points; the first one is added when the states of all forces have their initial values */
static void start(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x)
{
    (void)m; (void)d;
    for (int i = 0; i < f->states; i++) x[i] = jo_same(0.0);
}

static void nominals(const jo_model *m, const jo_force *f, double duration, double *x)
{
    (void)m; (void)duration;
    for (int i = 0; i < f->states; i++) x[i] = 1.0;
}

static const jo_yielding yielding = {update, margin, jumps, longest_step, 0, 0, 0, 0, update};
const jo_force_kind jo_force_delay = {apply, 0, tangent, start, nominals, &yielding};
