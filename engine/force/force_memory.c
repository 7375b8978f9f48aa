/* force_memory.c - values of a network of states that are constant within a step: play, relay, sampled control.
 *
 * States: number of samples taken, then the values z. The end of a step replaces them by registers of the network at the present state
 * (network_program.c), in which z are those of the start of the step: always, or for period > 0 at the times phase + k period only, each later by a
 * random part of `jitter`, at which steps end. Steps also end where the register `margin` falls below 0. All values of one force change together. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"
#include "network/network.h"

#define JO_DUE 1e-9             /* part of a period before the time of a sample from which on it is taken */

static const jo_memory_data *numbers(const jo_force *f) { return (const jo_memory_data *)f->data; }
static const jo_real *initial(const jo_force *f) { return (const jo_real *)(numbers(f) + 1); }
static int count(const jo_force *f) { return jo_whole(numbers(f)->count); }

/* random number from 0 to 1 of a sample: SplitMix64 (Steele, Lea, Flood, Fast Splittable Pseudorandom Number Generators, 2014) */
static double random_of(double seed, double sample)
{
    unsigned long long z = (unsigned long long)seed * 0xD1B54A32D192ED03ULL + ((unsigned long long)sample + 1) * 0x9E3779B97F4A7C15ULL;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return (double)((z ^ (z >> 31)) >> 11) / 9007199254740992.0;   /* 2^53 */
}

/* time of a sample, from 0 on */
static double time_of(const jo_force *f, double sample)
{
    const double jitter = JO_RE(numbers(f)->jitter), time = JO_RE(numbers(f)->phase) + sample * JO_RE(numbers(f)->period);
    return jitter > 0.0 ? time + jitter * random_of(JO_RE(numbers(f)->seed), sample) : time;
}

/* number of the samples at the times up to the present one */
static double due(const jo_data *d, const jo_force *f)
{
    const double period = JO_RE(numbers(f)->period), since = JO_RE(d->time[0]) - JO_RE(numbers(f)->phase);
    const double last = floor(since / period + JO_DUE);
    if (last < 0.0) return 0.0;
    return last + (JO_RE(d->time[0]) - time_of(f, last) >= -JO_DUE * period ? 1.0 : 0.0);   /* the last one may be late */
}

/* x = values after an update at the present state */
static void next_values(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x)
{
    jo_network *w = jo_network_of_memory(d, f);
    const jo_real *updates = initial(f) + count(f);
    jo_network_evaluate(m, d, w, jo_states(m, d) + m->force[w->force].state, 0.0, 0);
    for (int i = 0; i < count(f); i++) x[1 + i] = w->r[jo_whole(updates[i])];
}

static jo_real update(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x)
{
    if (JO_RE(numbers(f)->period) > 0.0) {
        const double samples = due(d, f);
        if (samples <= JO_RE(x[0])) return jo_same(0.0);
        x[0] = jo_same(samples);
    }
    next_values(m, d, f, x);
    return jo_same(0.0);
}

static jo_real margin(const jo_model *m, const jo_data *d, const jo_force *f)
{
    const int number = jo_whole(numbers(f)->margin);
    if (number < 0) return jo_same(1.0);
    jo_network *w = jo_network_of_memory(d, f);
    jo_network_evaluate(m, d, w, jo_states(m, d) + m->force[w->force].state, 0.0, 0);
    return w->r[number];
}

static int jumps(const jo_force *f, const jo_real *before, const jo_real *after)
{
    int changed = 0;
    for (int i = 1; i <= count(f); i++) changed |= before[i] != after[i];
    return changed && jo_whole(numbers(f)->jumps);
}

/* up to the next sample */
static double longest_step(const jo_model *m, const jo_data *d, const jo_force *f, int explicit_method)
{
    (void)m; (void)explicit_method;
    const double period = JO_RE(numbers(f)->period);
    if (!(period > 0.0)) return INFINITY;
    return time_of(f, due(d, f)) - JO_RE(d->time[0]);
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *y)
{
    static const jo_force_work none = {{0.0}, 0.0, 0.0, 0.0};
    *y = none;
    jo_keep_states(m, d, stage, f);
    return JO_OK;
}

static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *y)
{
    (void)m; (void)d; (void)stage; (void)f; (void)y;
    return JO_OK;
}

static void start(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x)
{
    (void)m; (void)d;
    x[0] = jo_same(0.0);
    for (int i = 0; i < count(f); i++) x[1 + i] = initial(f)[i];
}

static void nominals(const jo_model *m, const jo_force *f, double duration, double *x)
{
    (void)m; (void)duration;
    for (int i = 0; i < f->states; i++) x[i] = 1.0;
}

static const jo_yielding yielding = {update, margin, jumps, longest_step, 0, 0, 0, 0, 0};
const jo_force_kind jo_force_memory = {apply, 0, tangent, start, nominals, &yielding};
