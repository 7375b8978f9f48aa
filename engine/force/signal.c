/* signal.c - signals: functions of time with first and second derivatives. */
#include "force/force.h"

/* index k of the interval [x_k, x_k+1] that contains t, by bisection */
static int interval(const jo_real *x, int count, double t, int lane)
{
    int low = 0, high = count - 1;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (t < JO_PART(x[middle], lane)) high = middle;
        else low = middle;
    }
    return low;
}

static jo_signal_work harmonic(const jo_harmonic_data *c, jo_real time)
{
    const jo_real sine = jo_sin(c->omega * time + c->phase), cosine = jo_cos(c->omega * time + c->phase);
    const jo_signal_work y = {c->offset + c->amplitude * sine, c->amplitude * c->omega * cosine,
                              -c->amplitude * c->omega * c->omega * sine};
    return y;
}

/* interval of `time` in a lane: -1 before the first point, count - 1 after the last one */
static int place(const jo_signal *s, jo_real time, int lane)
{
    const jo_real *x = s->data;
    const double t = JO_PART(time, lane), first = JO_PART(x[0], lane);
    if (s->type == JO_SIGNAL_TABLE ? t <= first : t < first) return -1;
    return t >= JO_PART(x[s->count - 1], lane) ? s->count - 1 : interval(x, s->count, t, lane);
}

/* linear interpolation; constant beyond the ends */
static jo_signal_work table(const jo_signal *s, jo_real time, int k)
{
    const jo_real *x = s->data, *f = x + s->count;
    jo_signal_work y = {0.0, 0.0, 0.0};
    if (k < 0) y.value = f[0];
    else if (k == s->count - 1) y.value = f[k];
    else {
        y.rate = (f[k + 1] - f[k]) / (x[k + 1] - x[k]);
        y.value = f[k] + y.rate * (time - x[k]);
    }
    return y;
}

/* piecewise polynomials by Horner's scheme; constant beyond the ends */
static jo_signal_work pieces(const jo_signal *s, jo_real time, int found)
{
    const jo_real *x = s->data;
    const int order = s->degree + 1, before = found < 0, after = found == s->count - 1;
    const int k = before ? 0 : after ? found - 1 : found;
    const jo_real *c = x + s->count + k * order;
    const jo_real u = before ? jo_same(0.0) : after ? x[s->count - 1] - x[k] : time - x[k];
    jo_signal_work y = {0.0, 0.0, 0.0};
    for (int i = s->degree; i >= 0; i--) {
        y.second = y.second * u + 2.0 * y.rate;
        y.rate = y.rate * u + y.value;
        y.value = y.value * u + c[i];
    }
    if (before || after) y.rate = y.second = jo_same(0.0);
    return y;
}

/* table or pieces, interval by interval: lanes may be in different intervals */
static jo_signal_work by_interval(const jo_signal *s, jo_real time)
{
    jo_signal_work x = {0.0, 0.0, 0.0}, y = x;
    int last = s->count;
    for (int l = 0; l < JO_MACHINES; l++) {
        const int k = place(s, time, l);
        if (k != last) x = s->type == JO_SIGNAL_TABLE ? table(s, time, k) : pieces(s, time, k);
        last = k;
        jo_put(&y.value, x.value, l);
        jo_put(&y.rate, x.rate, l);
        jo_put(&y.second, x.second, l);
    }
    return y;
}

static jo_signal_work sum(jo_signal_work a, jo_signal_work b)
{
    const jo_signal_work y = {a.value + b.value, a.rate + b.rate, a.second + b.second};
    return y;
}

static jo_signal_work product(jo_signal_work a, jo_signal_work b)
{
    const jo_signal_work y = {a.value * b.value, a.rate * b.value + a.value * b.rate,
                              a.second * b.value + 2.0 * a.rate * b.rate + a.value * b.second};
    return y;
}

/* value, rate and second derivative of a signal at `time` */
jo_signal_work jo_signal_at(const jo_model *m, const jo_data *d, int signal, jo_real time)
{
    const jo_signal *s = &m->signal[signal];
    const int *child = s->child;
    jo_signal_work y = {0.0, 0.0, 0.0};
    switch (s->type) {
    case JO_SIGNAL_CONSTANT: y.value = ((const jo_constant_data *)s->data)->value; break;
    case JO_SIGNAL_SPEED: {
        const jo_speed_data *c = (const jo_speed_data *)s->data;
        y.value = c->offset + c->speed * time;
        y.rate = c->speed;
        break;
    }
    case JO_SIGNAL_HARMONIC: return harmonic((const jo_harmonic_data *)s->data, time);
    case JO_SIGNAL_STEP: {
        const jo_step_data *c = (const jo_step_data *)s->data;
        y.value = jo_choose(JO_LESS(time, c->time), c->before, c->after);
        break;
    }
    case JO_SIGNAL_TABLE:
    case JO_SIGNAL_PIECES: return by_interval(s, time);
    case JO_SIGNAL_SUM: return sum(jo_signal_at(m, d, child[0], time), jo_signal_at(m, d, child[1], time));
    case JO_SIGNAL_PRODUCT: return product(jo_signal_at(m, d, child[0], time), jo_signal_at(m, d, child[1], time));
    case JO_SIGNAL_INPUT: y.value = d->input[s->count]; break;
    case JO_SIGNAL_DELAY: return jo_delayed(m, d, s->count, time);
    case JO_SIGNAL_SWITCHED: return jo_signal_at(m, d, child[d->happened[s->count] > 0], time);
    default: break;
    }
    return y;
}
