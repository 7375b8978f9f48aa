/* slope.c - directional derivatives by the complex-step method (Squire and Trapp, SIAM Rev. 40, 1998, 110-112).
 *
 * Evaluation with x + i h s, h^2 negligible: Im f / h is the derivative along s without cancellation. All sources are compiled a second time
 * with complex numbers and other names (twice.h).
 */
#include "twice.h"
#include "machine.h"
#include "slope.h"
#include "plant.h"
#include <math.h>
#include <stdlib.h>

#define SMALL 1e-30         /* imaginary step of the largest seed: its square is negligible, and far above the smallest double */
#define FINITE 1e300        /* magnitude above which a seed or derivative has no finite value */

static void turn_to_unit(const jo_model *m, jo_real *q)
{
    for (int i = 0; i < m->nbody; i++) {
        jo_real *e = q + m->body[i].iq + 3;
        const jo_real length = csqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3]);
        for (int j = 0; j < 4; j++) e[j] /= length;
    }
}

static void lean(jo_machine *k, jo_slope_ref at, jo_real by)
{
    const jo_plant *p = &PLANT;
    jo_data *d = jo_machine_data(k);
    const int nq = p->model->nq;
    if (at.kind == JO_SLOPE_TIME) *jo_data_time(d) += by;
    else if (at.kind == JO_SLOPE_INPUT) jo_data_input(d)[p->input[at.index].place] += by;
    else if (at.kind == JO_SLOPE_PARAMETER) {
        jo_machine_tunable(k)[p->parameter[at.index].place] += by;
        for (int i = 0; i < p->nlink; i++)
            if (p->link[i].parameter == at.index) jo_machine_tunable(k)[p->link[i].place] += p->link[i].factor * by;
    } else if (at.index < nq) jo_data_q(d)[at.index] += by;
    else jo_data_v(d)[at.index - nq] += by;
}

/* load the state, add i h seed, evaluate outputs and rates, imaginary parts / h */
static int slope(jo_machine *k, jo_real *rates, const double *state, double rate, const jo_slope_ref *known, const double *seed,
                 int nknown, const jo_slope_ref *unknown, double *change, int nunknown)
{
    double most = 0.0;
    int states = 0, outputs = 0, derivatives = 0;
    if (jo_machine_load(k, state) != JO_MACHINE_OK) return 1;
    for (int i = 0; i < nknown; i++)
        if (fabs(seed[i]) > most) most = fabs(seed[i]);
    if (!(most <= FINITE)) return 1;
    const double h = most > 0.0 ? SMALL / most : 0.0;
    for (int i = 0; i < nknown; i++) {
        lean(k, known[i], I * (h * seed[i]));
        states |= known[i].kind == JO_SLOPE_STATE;
    }
    if (states) turn_to_unit(PLANT.model, jo_data_q(jo_machine_data(k)));
    jo_machine_changed(k);
    for (int j = 0; j < nunknown; j++) {
        outputs |= unknown[j].kind == JO_SLOPE_OUTPUT;
        derivatives |= unknown[j].kind == JO_SLOPE_RATE;
    }
    const jo_real *values = outputs ? jo_machine_outputs(k) : 0;
    if (outputs && !values) return 1;
    for (int j = 0; j < nunknown; j++)
        if (unknown[j].kind == JO_SLOPE_OUTPUT)
            change[j] = h > 0.0 ? cimag(values[PLANT.output[unknown[j].index].place]) / h : 0.0;
    if (derivatives && jo_machine_rates(k, rate, rates) != JO_MACHINE_OK) return 1;
    for (int j = 0; j < nunknown; j++) {
        if (unknown[j].kind == JO_SLOPE_RATE) change[j] = h > 0.0 ? cimag(rates[unknown[j].index]) / h : 0.0;
        if (!(fabs(change[j]) <= FINITE)) return 1;
    }
    return 0;
}

int jo_slope(const double *state, int in_bodies, double rate, const jo_slope_ref *known, const double *seed, int nknown,
             const jo_slope_ref *unknown, double *change, int nunknown)
{
    const long long bytes = jo_machine_bytes(&PLANT);
    const size_t states = (size_t)(PLANT.model->nq + PLANT.model->nv + PLANT.model->nstate);
    jo_real *rates = malloc(sizeof *rates * (states + 1) + (size_t)bytes);
    int status = 1;
    if (!rates) return status;
    jo_machine *k = jo_machine_place(&PLANT, rates + states + 1, bytes);
    if (k && in_bodies) jo_machine_in_bodies(k);
    if (k) status = slope(k, rates, state, rate, known, seed, nknown, unknown, change, nunknown);
    free(rates);
    return status;
}
