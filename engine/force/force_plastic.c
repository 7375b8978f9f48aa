/* force_plastic.c - elastic-plastic spring along a coordinate s: bilinear, isotropic and kinematic hardening, Armstrong-Frederick.
 *
 *   M = stiffness (s - free - p), force -M,   |M - X| <= strength + R,   p' = +-l',   l' >= 0
 *   X' = kinematic p' - recovery X l',   R = isotropic l + saturation (1 - exp(-rate l))
 * (Armstrong, Frederick, CEGB report RD/B/N731 (1966); Simo, Hughes, Computational Inelasticity (1998), chapter 1).
 *
 * States: plastic deformation p, back force X, length l of the plastic path, dissipated energy, direction of the flow at the end of the
 * last step (1, -1; 0: none). The states keep their values from the start of a step within the step. The law does not depend on the rate;
 * until s turns, the force is therefore a function of s, given by the return map from these states. The end of a step replaces them
 * (jo_accept_yielding), and steps end where yielding begins and where s turns (margin below). */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"

enum { PLASTIC, BACK, PATH, LOSS, FLOW, STATES };
enum { JO_RETURNS = 60 };       /* largest number of iterations of the return map, which converges monotonically; a step takes 1 to 6 */
#define JO_RETURNED 4e-16       /* change relative to the length of the flow at which the return map has converged */
/* excess over the yield force, relative to the strength, above which a step counts as yielding; larger than round-off */
#define JO_YIELD_MARGIN 1e-10
#define JO_SERIES 0.03          /* argument below which the functions of exponentials are computed by series, with an error of 1e-16 */

/* The spring at the present coordinate. */
typedef struct {
    jo_real x[STATES];          /* states after the motion from the start of the step */
    jo_real force, slope;       /* M and dM/ds */
    jo_real excess;             /* |M - X| - strength - R of the elastic motion */
} jo_spring_state;

static const jo_plastic_data *numbers(const jo_force *f) { return (const jo_plastic_data *)f->data; }

/* (1 - exp(-x)) / x */
static jo_real mean_decay(jo_real x)
{
    if (JO_RE(x) < JO_SERIES) return 1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0 * (1.0 - x / 7.0)))));
    return (1.0 - jo_exp(-x)) / x;
}

/* (1 - mean_decay(x)) / x */
static jo_real mean_growth(jo_real x)
{
    if (JO_RE(x) < JO_SERIES) return 0.5 * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0 * (1.0 - x / 7.0 * (1.0 - x / 8.0))))));
    return (1.0 - mean_decay(x)) / x;
}

/* s X after a flow dl in direction s, from its previous value u: u + (C - G u) dl (1 - exp(-G dl)) / (G dl) */
static jo_real back_force(const jo_plastic_data *x, jo_real u, jo_real dl)
{
    return u + (x->kinematic - x->recovery * u) * dl * mean_decay(x->recovery * dl);
}

/* increase of R by a flow dl that begins at the path length l */
static jo_real hardening(const jo_plastic_data *x, jo_real l, jo_real dl)
{
    return x->isotropic * dl + x->saturation * jo_exp(-x->rate * l) * x->rate * dl * mean_decay(x->rate * dl);
}

static jo_real radius(const jo_plastic_data *x, jo_real l) { return x->strength + hardening(x, jo_same(0.0), l); }

/* derivative of s X + R with respect to dl, the plastic modulus */
static jo_real modulus(const jo_plastic_data *x, jo_real u, jo_real l, jo_real dl)
{
    return x->kinematic - x->recovery * back_force(x, u, dl) + x->isotropic + x->saturation * x->rate * jo_exp(-x->rate * (l + dl));
}

/* Flow dl > 0 with excess - k dl - (increase of s X + R) = 0. The left side is decreasing and convex: Newton's method from 0 converges from
 * below. */
static jo_real flow(const jo_plastic_data *x, jo_real u, jo_real l, jo_real excess)
{
    jo_real dl = jo_same(0.0);
    for (int i = 0; i < JO_RETURNS; i++) {
        const jo_real left = excess - x->stiffness * dl - (back_force(x, u, dl) - u) - hardening(x, l, dl);
        const jo_real step = left / (x->stiffness + modulus(x, u, l, dl));
        dl += step;
        if (jo_most(jo_magnitude(step)) <= JO_RETURNED * jo_most(jo_magnitude(dl))) break;
    }
    return dl;
}

/* Energy dissipated by a flow dl: the plastic work int (s X + R + strength) dl less the increase of X^2 / 2 kinematic. */
static jo_real dissipation(const jo_plastic_data *x, jo_real u, jo_real l, jo_real dl)
{
    const jo_real first = x->saturation * jo_exp(-x->rate * l) * x->rate;
    jo_real y = radius(x, l) * dl + 0.5 * x->isotropic * dl * dl + first * dl * dl * mean_growth(x->rate * dl);
    if (JO_RE(x->recovery) > 0.0) {
        const jo_real slope = x->kinematic - x->recovery * u, end = back_force(x, u, dl);
        const jo_real spent = (u + slope * dl * mean_growth(x->recovery * dl)) * dl - (end - u) * (end + u) / (2.0 * x->kinematic);
        y += jo_choose(JO_LESS(spent, jo_same(0.0)), jo_same(0.0), spent);
    }
    return y;
}

/* the spring at coordinate s, from the states x0 */
static jo_spring_state state_at(const jo_plastic_data *x, const jo_real *x0, jo_real s)
{
    jo_spring_state y;
    for (int i = 0; i < STATES; i++) y.x[i] = x0[i];
    y.force = x->stiffness * (s - x->free - x0[PLASTIC]);
    y.slope = x->stiffness;
    const jo_real pull = y.force - x0[BACK];
    const double side = JO_RE(pull) < 0.0 ? -1.0 : 1.0;
    y.excess = side * pull - radius(x, x0[PATH]);
    if (JO_RE(y.excess) < -JO_YIELD_MARGIN * JO_RE(x->strength)) y.x[FLOW] = jo_same(0.0);   /* otherwise at the end of the previous flow */
    if (!(JO_RE(y.excess) > 0.0)) return y;
    const jo_real u = side * x0[BACK], dl = flow(x, u, x0[PATH], y.excess), H = modulus(x, u, x0[PATH], dl);
    y.x[PLASTIC] += side * dl;
    y.x[BACK] = side * back_force(x, u, dl);
    y.x[PATH] += dl;
    y.x[LOSS] += dissipation(x, u, x0[PATH], dl);
    y.x[FLOW] = jo_same(side);
    y.force = y.x[BACK] + side * radius(x, y.x[PATH]);
    y.slope = x->stiffness * H / (x->stiffness + H);
    return y;
}

/* slope of the force in the next step: if a flow continues from the previous step, the slope of the flow */
static jo_real slope_ahead(const jo_plastic_data *x, const jo_real *x0, const jo_spring_state *s)
{
    const double going = JO_RE(x0[FLOW]);
    if (going == 0.0 || going != JO_RE(s->x[FLOW])) return s->slope;
    const jo_real H = modulus(x, going * s->x[BACK], s->x[PATH], jo_same(0.0));
    return x->stiffness * H / (x->stiffness + H);
}

/* states at the start of the step */
static const jo_real *states(const jo_data *d, const jo_force *f) { return d->w + (d->nw - d->forces.nstate) + f->state; }

static jo_spring_state present(const jo_data *d, const jo_force *f)
{
    return state_at(numbers(f), states(d, f), d->coordinate[f->coordinate].value);
}

/* M^2 / 2 stiffness + X^2 / 2 kinematic */
static jo_real energy_of(const jo_plastic_data *x, const jo_spring_state *s)
{
    jo_real y = s->force * s->force / (2.0 * x->stiffness);
    if (JO_RE(x->kinematic) > 0.0) y += s->x[BACK] * s->x[BACK] / (2.0 * x->kinematic);
    return y;
}

static jo_real stored(const jo_data *d, const jo_force *f)
{
    const jo_spring_state s = present(d, f);
    return energy_of(numbers(f), &s);
}

/* the states are constant within a step; the slope of the force for the matrix of a Rosenbrock method */
static void keep_states(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *y, jo_real slope)
{
    static const jo_slopes_of_state none = {0.0, 0.0, 0.0, 0.0};
    for (int k = f->state; k < f->state + f->states; k++) {
        if (jo_condenses(stage)) {
            jo_condense_state(m, d, stage, k, jo_same(0.0), jo_same(0.0));
            continue;
        }
        jo_state_rates(m, d)[k] = jo_same(0.0);
        if (stage->set && !stage->earlier) d->forces.slopes[k] = none;
    }
    y->stiffness = slope;
    y->damping = jo_same(0.0);
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *y)
{
    const jo_spring_state s = present(d, f);
    keep_states(m, d, stage, f, y, slope_ahead(numbers(f), states(d, f), &s));
    y->y[0] = -s.force;
    y->stored = energy_of(numbers(f), &s);
    jo_push_along(m, d, f->coordinate, y->y[0]);
    return JO_OK;
}

/* consistent with the return map: df/ds = -stiffness H / (stiffness + H) where it flows */
static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *y)
{
    (void)stage;
    const jo_spring_state s = present(d, f);
    jo_element e;
    jo_gradients g;
    jo_element_gradients(m, d, f->coordinate, &g);
    jo_element_start(&e, m->coordinate[f->coordinate].a, m->coordinate[f->coordinate].b);
    jo_element_along(d, &e, f->coordinate, &g, y->y[0], -s.slope, jo_same(0.0));
    jo_element_finish(m, d, &e);
    return JO_OK;
}

/* no previous deformation; a spring that starts beyond the yield force has already yielded */
static void start(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x)
{
    static const jo_real none[STATES] = {0.0};
    (void)m;
    const jo_spring_state s = state_at(numbers(f), none, d->coordinate[f->coordinate].value);
    for (int i = 0; i < STATES; i++) x[i] = s.x[i];
    x[LOSS] = x[FLOW] = jo_same(0.0);
}

/* the states do not change within a step, so their errors do not matter */
static void nominals(const jo_model *m, const jo_force *f, double duration, double *x)
{
    (void)m; (void)f; (void)duration;
    for (int i = 0; i < STATES; i++) x[i] = 1.0;
}

/* states at the present coordinate; returns the energy dissipated since the start of the step */
static jo_real update(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x)
{
    (void)m;
    const jo_real *x0 = states(d, f);
    const jo_spring_state s = present(d, f);
    for (int i = 0; i < STATES; i++) x[i] = s.x[i];
    if (!(JO_RE(s.x[FLOW] * d->coordinate[f->coordinate].rate) > 0.0)) x[FLOW] = jo_same(0.0);   /* it has turned */
    return x[LOSS] - x0[LOSS];
}

/* negative: yielding has begun in the step, or a flow has reversed */
static jo_real margin(const jo_model *m, const jo_data *d, const jo_force *f)
{
    (void)m;
    const jo_real going = states(d, f)[FLOW];
    if (JO_RE(going) != 0.0) return going * d->coordinate[f->coordinate].rate;
    return JO_YIELD_MARGIN * numbers(f)->strength - present(d, f).excess;
}

static const jo_yielding yielding = {update, margin, 0, 0, 0, 0, 0, 0, 0};
const jo_force_kind jo_force_plastic = {apply, stored, tangent, start, nominals, &yielding};
