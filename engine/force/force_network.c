/* force_network.c - a network of first-order states x' = f(t, s, s', x) with forces F(t, s, s', x) along coordinates s: control, drives,
 * hydraulics. f, F and their derivatives: network_program.c.
 *
 * RK4 and DormandPrince integrate x like velocities. Rosenbrock methods of order 2 have all derivatives in their matrix
 * (network_matrix.c). The implicit methods solve for x at each position and velocity of Newton's method (force_states.c). */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"
#include "network/network.h"

enum { JO_STATE_ITERATIONS = 40 };   /* largest number of Newton's method for the states */
enum { JO_STATE_HALVINGS = 40 };     /* largest number for one increment */
#define JO_FOLLOWS 5.0         /* time between two stages over g h, above which they are not of one step or of the next: h is 2.3 to 3.4 g h */
#define JO_STATES_FOUND 1e-14  /* increment of a state over its size at which they are found */
#define JO_STATES_NEAR 1e-9    /* the same, below which increments are not halved: where they do not shrink, that is round-off */

static const jo_real *own_states(const jo_model *m, const jo_data *d, const jo_force *f) { return jo_states(m, d) + f->state; }

/* z = (ca - cv f_x)^-1 (f - x') with the factors at hand; returns its largest effect on a state over the size of that state */
static double increment(const jo_data *d, const jo_stage *stage, const jo_force *f, jo_network *w, int first, jo_real *z)
{
    double most = 0.0;
    for (int i = 0; i < w->n; i++) z[i] = w->r[w->rate[i]] - d->a[first + i];
    jo_network_solve(w->A, w->n, w->pivot, z);
    for (int i = 0; i < w->n; i++) {
        const double size = fabs(JO_RE(d->v[first + i])) + JO_RE(jo_network_starts(f)[w->n + i]);
        most = fmax(most, fabs(stage->weights.v * JO_RE(z[i])) / size);
    }
    return most;
}

/* states + share z */
static void shift(jo_data *d, const jo_stage *stage, int n, int first, double share, const jo_real *z)
{
    for (int i = 0; i < n; i++) {
        d->rate[first + i] += share * z[i];
        d->a[first + i] += share * stage->weights.a * z[i];
        d->v[first + i] += share * stage->weights.v * z[i];
    }
}

/* States of an implicit step at the present position and velocity: ca x' - cv f(x) = .. by Newton's method. Where a valve opens or closes, its
 * slope at one end is not the one at the other: an increment is halved until the next one with the same factors is smaller (natural
 * monotonicity test; Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 3.1). */
static int condense(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_network *w)
{
    const int first = m->nv + f->state;
    double before = INFINITY;
    for (int k = 0; k < JO_STATE_ITERATIONS; k++) {
        jo_network_evaluate(m, d, w, own_states(m, d, f), 0.0, 1);
        jo_network_response(w, stage->weights.a, stage->weights.v);
        const double most = increment(d, stage, f, w, first, w->k);
        shift(d, stage, w->n, first, 1.0, w->k);
        if (!(most > JO_STATES_FOUND) || (most < JO_STATES_NEAR && !(most < before))) return JO_OK;
        before = most;
        double taken = 1.0;
        for (int i = 0; i < JO_STATE_HALVINGS && most > JO_STATES_NEAR; i++) {
            jo_network_evaluate(m, d, w, own_states(m, d, f), 0.0, 0);
            if (increment(d, stage, f, w, first, w->z) < most) break;
            taken *= 0.5;
            shift(d, stage, w->n, first, -taken, w->k);
        }
    }
    return JO_NO_CONVERGENCE;
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *y)
{
    static const jo_force_work none = {{0.0}, 0.0, 0.0, 0.0};
    jo_network *w = jo_network_of(d, f);
    *y = none;
    if (jo_condenses(stage)) {
        const int status = condense(m, d, stage, f, w);
        if (status != JO_OK) return status;
    }
    const int first = stage->contacts && !stage->earlier;
    jo_network_evaluate(m, d, w, own_states(m, d, f), stage->lead, first);
    if (stage->contacts && w->nopening) jo_network_note_openings(d, JO_FOLLOWS * stage->gh, w);
    if (w->outside) {
        d->error_index = w->force;
        return JO_BEYOND_TABLE;
    }
    if (!jo_condenses(stage)) {
        jo_real *rate = jo_state_rates(m, d) + f->state;
        for (int i = 0; i < w->n; i++) rate[i] = w->r[w->rate[i]];
    }
    for (int i = 0; i < w->npush; i++) jo_push_along(m, d, w->coordinate[w->push[2 * i]], w->r[w->push[2 * i + 1]]);
    if (stage->contacts) jo_network_implicit(m, d, stage, w);
    if (w->timed && stage->lead != 0.0) jo_network_evaluate(m, d, w, own_states(m, d, f), 0.0, 0);   /* the power is that of the present */
    for (int i = 0; i < w->npush; i++)
        d->power.forces += w->r[w->push[2 * i + 1]] * d->coordinate[w->coordinate[w->push[2 * i]]].rate;
    return JO_OK;
}

/* in a step with the response of the states; for equilibria and vibrations with constant states */
static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *unused)
{
    (void)unused;
    jo_network *w = jo_network_of(d, f);
    jo_network_evaluate(m, d, w, own_states(m, d, f), 0.0, 1);
    jo_network_response(w, jo_condenses(stage) ? stage->weights.a : 1.0, jo_condenses(stage) ? stage->weights.v : 0.0);
    for (int k = 0; k < w->m; k++) w->F[k] = jo_same(0.0);
    for (int i = 0; i < w->npush; i++) w->F[w->push[2 * i]] += w->r[w->push[2 * i + 1]];
    for (int c = 0; c < w->m; c++) {
        const jo_coordinate *of = &m->coordinate[w->coordinate[c]];
        jo_gradients g;
        jo_element_gradients(m, d, w->coordinate[c], &g);
        for (int k = 0; k < w->m; k++) {
            const jo_real fs = -w->K[k * w->m + c], frate = -w->D[k * w->m + c];
            const jo_coordinate *on = &m->coordinate[w->coordinate[k]];
            jo_element e;
            if (k != c && fs == 0.0 && frate == 0.0) continue;
            jo_element_start(&e, on->a, on->b);
            if (k == c) jo_element_along(d, &e, w->coordinate[k], &g, w->F[k], fs, frate);
            else jo_element_cross(d, &e, w->coordinate[k], of->a, of->b, &g, fs, frate);
            jo_element_finish(m, d, &e);
        }
    }
    return JO_OK;
}

static void start(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x)
{
    (void)m; (void)d;
    for (int i = 0; i < f->states; i++) x[i] = jo_network_starts(f)[i];
}

static void nominals(const jo_model *m, const jo_force *f, double duration, double *x)
{
    (void)m; (void)duration;
    for (int i = 0; i < f->states; i++) x[i] = JO_RE(jo_network_starts(f)[f->states + i]);
}

const jo_force_kind jo_force_network = {apply, 0, tangent, start, nominals, 0};
