/* network_program.c - the program of a network of states: a list of instructions, each of which computes one register.
 *
 * The derivatives with respect to states and coordinates are further instructions of the same program, made where the network is compiled
 * (Griewank, Walther, Evaluating Derivatives, 2008, ch. 6), so that there is one kind of evaluation only. */
#include "force/force.h"
#include "network/network.h"

static jo_real power(jo_real x, jo_real n)
{
#ifdef JO_COMPLEX
    return cpow(x, n);
#else
    return pow(x, n);
#endif
}

/* arc tangent and hyperbolic tangent of numbers that may have an imaginary part */
#ifdef JO_COMPLEX
#define JO_ATAN catan
#define JO_TANH ctanh
#else
#define JO_ATAN atan
#define JO_TANH tanh
#endif

/* dp/(dp^2 + t^2)^(1/4), the law of an edge: laminar below t, then the root of dp */
static jo_real edge(jo_real dp, jo_real t) { return dp / jo_sqrt(jo_sqrt(dp * dp + t * t)); }

/* its derivative, (dp^2/2 + t^2)/(dp^2 + t^2)^(5/4) */
static jo_real edge_slope(jo_real dp, jo_real t)
{
    const jo_real s = dp * dp, all = s + t * t;
    return (0.5 * s + t * t) / (all * jo_sqrt(jo_sqrt(all)));
}

static void run(jo_network *w, int from, int to)
{
    const jo_real *const r = w->r;
    jo_real *y = w->r + w->registers - w->instructions + from;
    const int *const end = w->code + 4 * to;
    for (const int *k = w->code + 4 * from; k < end; k += 4, y++) {
        const jo_real a = r[k[1]], b = r[k[2]];
        switch (k[0]) {
        case JO_DO_add: *y = a + b; break;
        case JO_DO_subtract: *y = a - b; break;
        case JO_DO_multiply: *y = a * b; break;
        case JO_DO_divide: *y = a / b; break;
        case JO_DO_sqrt: *y = jo_sqrt(a); break;
        case JO_DO_exp: *y = jo_exp(a); break;
        case JO_DO_log: *y = jo_log(a); break;
        case JO_DO_sin: *y = jo_sin(a); break;
        case JO_DO_cos: *y = jo_cos(a); break;
        case JO_DO_atan: *y = JO_ATAN(a); break;
        case JO_DO_tanh: *y = JO_TANH(a); break;
        case JO_DO_power: *y = power(a, b); break;
        case JO_DO_minimum: *y = JO_RE(a) < JO_RE(b) ? a : b; break;
        case JO_DO_maximum: *y = JO_RE(a) > JO_RE(b) ? a : b; break;
        case JO_DO_select: *y = JO_RE(a) > 0.0 ? b : r[k[3]]; break;
        case JO_DO_edge: *y = edge(a, b); break;
        case JO_DO_edge_slope: *y = edge_slope(a, b); break;
        default: w->outside |= jo_network_table(k[0], r + k[2], a, r[k[3]], y);
        }
    }
}

/* x into a register; whether it was there */
static inline int set(jo_real *r, jo_real x)
{
    const int there = *r == x;
    *r = x;
    return there;
}

void jo_network_evaluate(const jo_model *m, const jo_data *d, jo_network *w, const jo_real *x, double lead, int derivatives)
{
    jo_real *r = w->r + w->fixed;
    int same = 1;   /* results of the same inputs are there already */
    for (int i = 0; i < w->n; i++) same &= set(r++, x[i]);
    for (int i = 0; i < w->m; i++) same &= set(r++, d->coordinate[w->coordinate[i]].value);
    for (int i = 0; i < w->m; i++) same &= set(r++, d->coordinate[w->coordinate[i]].rate);
    same &= set(r++, d->time[0] + lead);
    for (int i = 0; i < w->nsignal; i++) {
        const jo_signal_work y = jo_signal_at(m, d, w->signal[i], d->time[0] + lead);
        same &= set(r + i, y.value);
        same &= set(r + w->nsignal + i, y.rate);
    }
    r += 2 * w->nsignal;
    for (int i = 0; i < w->memories; i++) same &= set(r++, jo_states(m, d)[w->memory[i]]);
    for (int i = 0; i < w->gravity; i++) same &= set(r++, m->gravity[i]);
    if (!same || !w->computed) {
        w->outside = 0;
        run(w, 0, w->values);
        w->computed = 1;
    }
    if (!derivatives || w->computed > 1) return;
    run(w, w->values, w->instructions);
    w->computed = 2;
    const int columns = w->n + 2 * w->m;
    for (int i = 0; i < (w->n + w->m) * columns; i++) w->S[i] = jo_same(0.0);
    for (int i = 0; i < w->nslope; i++) {
        const int *k = w->slope + 3 * i;
        w->S[k[0] * columns + k[1]] += w->r[k[2]];
    }
}

void jo_network_note_openings(const jo_data *d, double longest, jo_network *w)
{
    const double now = JO_RE(d->time[0]);
    const int follows = fabs(now - w->last) < longest;   /* not after a change of the state by the caller */
    w->last = now;
    for (int i = 0; i < w->nopening; i++) {
        const jo_real x = w->r[w->opening[i]];
        const double change = fabs(JO_RE(x) - JO_RE(w->before[i]));
        w->before[i] = x;
        if (!follows || !(change > w->most[2 * i])) continue;
        w->most[2 * i] = change;
        w->most[2 * i + 1] = now;
    }
}

void jo_networks_note_openings(const jo_data *d, double longest)
{
    for (int i = 0; i < d->networks.count; i++) jo_network_note_openings(d, longest, &d->networks.list[i]);
}

int jo_data_openings(jo_data *d, double *out)
{
    int count = 0;
    for (int i = 0; i < d->networks.count; i++) {
        jo_network *w = &d->networks.list[i];
        for (int k = 0; k < 2 * w->nopening; k++) {
            out[count++] = w->most[k];
            w->most[k] = 0.0;
        }
    }
    return count / 2;
}

jo_real jo_network_value(const jo_model *m, const jo_data *d, int network, int number)
{
    jo_network *w = &d->networks.list[network];
    jo_network_evaluate(m, d, w, jo_states(m, d) + m->force[w->force].state, 0.0, 0);
    return w->r[number];
}

void jo_network_factor(jo_real *A, int n, int *pivot)
{
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(JO_RE(A[i * n + k])) > fabs(JO_RE(A[best * n + k]))) best = i;
        pivot[k] = best;
        for (int j = 0; j < n && best != k; j++) {
            const jo_real x = A[k * n + j];
            A[k * n + j] = A[best * n + j];
            A[best * n + j] = x;
        }
        const jo_real inverse = 1.0 / A[k * n + k];
        for (int i = k + 1; i < n; i++) {
            if (A[i * n + k] == 0.0) continue;
            const jo_real s = A[i * n + k] * inverse;
            A[i * n + k] = s;
            for (int j = k + 1; j < n; j++) A[i * n + j] -= s * A[k * n + j];
        }
    }
}

void jo_network_solve(const jo_real *A, int n, const int *pivot, jo_real *x)
{
    for (int k = 0; k < n; k++) {
        const jo_real t = x[pivot[k]];
        x[pivot[k]] = x[k];
        x[k] = t;
    }
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++) x[i] -= A[i * n + j] * x[j];
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) x[i] -= A[i * n + j] * x[j];
        x[i] /= A[i * n + i];
    }
}

/* Response of the states, (ca - cv f_x) dx' = f_s ds + f_s' ds', dx = cv dx' for a unit of algorithmic rate: K = -(F_s + cv F_x A^-1 f_s),
 * D = -(F_s' + cv F_x A^-1 f_s') */
void jo_network_response(jo_network *w, double ca, double cv)
{
    const int n = w->n, m = w->m, columns = n + 2 * m;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) w->A[i * n + j] = (i == j ? ca : 0.0) - cv * w->S[i * columns + j];
    jo_network_factor(w->A, n, w->pivot);
    for (int i = 0; i < m * m; i++) w->K[i] = w->D[i] = jo_same(0.0);
    for (int j = 0; j < 2 * m; j++) {   /* column by column: z = A^-1 f_s */
        jo_real *y = j < m ? w->K + j : w->D + j - m;
        int any = 0;
        for (int i = 0; i < n; i++) {
            w->z[i] = w->S[i * columns + n + j];
            any |= w->z[i] != 0.0;
        }
        if (any) jo_network_solve(w->A, n, w->pivot, w->z);
        for (int k = 0; k < m; k++) {
            const jo_real *row = w->S + (n + k) * columns;
            jo_real sum = row[n + j];
            for (int i = 0; i < n && any; i++) sum += cv * row[i] * w->z[i];
            y[k * m] = -sum;
        }
    }
}
