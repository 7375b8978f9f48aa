/* fmu.c - functions of an instance that are common to both versions of the FMI standard. */
#include "fmu.h"
#include "plant.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NEAR 1e-6           /* relative difference of times, over the step, below which times are equal */
#define MAX_STEPS 9e15      /* largest number of steps of a call: integers up to 2^53 are exact as doubles */

static const char *const REASONS[] = {
    "", "the motion diverged", "a body has no inertia", "a joint is in a singular position", "no memory", "a function failed",
    "an implicit step did not converge", "friction found no solution", "an event stopped the machine", "the step is too small",
    "events without end", "a beam is bent by half a turn"};

static const char *reason(int status)
{
    return status > 0 && status < (int)(sizeof REASONS / sizeof *REASONS) ? REASONS[status] : "unknown";
}

int jo_fmu_say(jo_fmu *f, int status, const char *format, ...)
{
    static const char *const categories[] = {"logAll", "logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal"};
    if (f && f->log && (f->logging || status >= JO_FMU_DISCARD)) {
        char text[JO_FMU_MESSAGE];
        va_list values;
        va_start(values, format);
        vsnprintf(text, sizeof text, format, values);
        va_end(values);
        f->log(f->host, status, categories[status], text);
    }
    return status;
}

/* new instance with its machine and work space; NULL if memory is missing */
jo_fmu *jo_fmu_make(const char *name, const char *token, int exchange, int logging, jo_fmu_log log, void *host)
{
    jo_fmu silent = {.log = log, .host = host, .logging = logging};
    if (!name || !*name) {
        jo_fmu_say(&silent, JO_FMU_ERROR, "an instance needs a name");
        return 0;
    }
    if (!token || strcmp(token, PLANT_TOKEN)) {
        jo_fmu_say(&silent, JO_FMU_ERROR, "%s: the token is not %s: description and binary do not belong together", name, PLANT_TOKEN);
        return 0;
    }
    if (exchange && *PLANT_NOT_EXCHANGED) {
        jo_fmu_say(&silent, JO_FMU_ERROR, "%s: is for co-simulation only: %s", name, PLANT_NOT_EXCHANGED);
        return 0;
    }
    const long long bytes = jo_machine_bytes(&PLANT);
    const size_t states = (size_t)(PLANT.model->nq + PLANT.model->nv + PLANT.model->nstate);
    jo_fmu *f = calloc(1, sizeof *f + (size_t)bytes + 2 * states * sizeof(double) + 64);
    if (!f) {
        jo_fmu_say(&silent, JO_FMU_ERROR, "%s: no memory for %lld bytes", name, bytes);
        return 0;
    }
    f->log = log;
    f->host = host;
    f->logging = logging;
    f->exchange = exchange;
    f->scratch = (double *)(f + 1);
    f->machine = jo_machine_place(&PLANT, f->scratch + 2 * states, bytes);
    if (exchange) jo_machine_in_bodies(f->machine);
    f->mode = JO_FMU_MADE;
    return f;
}

void jo_fmu_free(jo_fmu *f) { free(f); }

int jo_fmu_may(jo_fmu *f, const char *function, int modes)
{
    if (!f) return 0;
    if (f->mode & modes) return 1;
    jo_fmu_say(f, JO_FMU_ERROR, "%s may not be called in this state of the instance", function);
    return 0;
}

int jo_fmu_setup(jo_fmu *f, double start, int has_stop, double stop)
{
    if (!isfinite(start) || (has_stop && (!isfinite(stop) || stop < start)))
        return jo_fmu_say(f, JO_FMU_ERROR, "the run shall start at %g s and stop at %g s", start, stop);
    f->start = start;
    f->has_stop = has_stop;
    f->stop = stop;
    *jo_data_time(jo_machine_data(f->machine)) = start;
    return JO_FMU_OK;
}

int jo_fmu_reset(jo_fmu *f)
{
    jo_machine_reset(f->machine);
    f->mode = JO_FMU_MADE;
    f->current = 0;
    return JO_FMU_OK;
}

static int failed(jo_fmu *f)
{
    f->mode = JO_FMU_BROKEN;
    return jo_fmu_say(f, JO_FMU_ERROR, "at %.9g s: %s (object %d)", jo_machine_time(f->machine), reason(jo_machine_error(f->machine)),
                      jo_machine_error_index(f->machine));
}

/* derivatives of the present states; computed once per state */
static const double *rates(jo_fmu *f)
{
    double *xdot = f->scratch + jo_machine_states(f->machine);
    if (!f->current && jo_machine_rates(f->machine, PLANT_BAUMGARTE, xdot) != JO_MACHINE_OK) return 0;
    f->current = 1;
    return xdot;
}

int jo_fmu_rates(jo_fmu *f, double *xdot)
{
    const double *found = rates(f);
    if (!found) return failed(f);
    memcpy(xdot, found, sizeof(double) * (size_t)jo_machine_states(f->machine));
    return JO_FMU_OK;
}

/* get the values of the variables refs (count) */
int jo_fmu_get(jo_fmu *f, const unsigned *refs, size_t count, double *values)
{
    const jo_plant *p = &PLANT;
    const unsigned inputs = 1, outputs = inputs + (unsigned)p->ninput, parameters = outputs + (unsigned)p->noutput,
                   states = parameters + (unsigned)p->nparameter;
    const unsigned n = f->exchange ? (unsigned)jo_machine_states(f->machine) : 0;
    if (count && (!refs || !values)) return jo_fmu_say(f, JO_FMU_ERROR, "no place for %u values", (unsigned)count);
    for (size_t i = 0; i < count; i++) {
        const unsigned ref = refs[i];
        if (ref == 0) values[i] = jo_machine_time(f->machine);
        else if (ref < outputs) values[i] = jo_machine_get_input(f->machine, (int)(ref - inputs));
        else if (ref < parameters) {
            if (jo_machine_get_output(f->machine, (int)(ref - outputs), &values[i]) != JO_MACHINE_OK) return failed(f);
            f->current = 0;
        } else if (ref < states) values[i] = jo_machine_get_parameter(f->machine, (int)(ref - parameters));
        else if (ref < states + n) {
            jo_machine_get_states(f->machine, f->scratch);
            values[i] = f->scratch[ref - states];
        } else if (ref < states + 2 * n) {
            const double *xdot = rates(f);
            if (!xdot) return failed(f);
            values[i] = xdot[ref - states - n];
        } else return jo_fmu_say(f, JO_FMU_ERROR, "there is no variable with the reference %u", ref);
    }
    return JO_FMU_OK;
}

/* set inputs and parameters refs (count) */
int jo_fmu_set(jo_fmu *f, const unsigned *refs, size_t count, const double *values)
{
    const jo_plant *p = &PLANT;
    const unsigned outputs = 1 + (unsigned)p->ninput, parameters = outputs + (unsigned)p->noutput,
                   states = parameters + (unsigned)p->nparameter;
    if (count && (!refs || !values)) return jo_fmu_say(f, JO_FMU_ERROR, "no values for %u variables", (unsigned)count);
    for (size_t i = 0; i < count; i++) {
        const unsigned ref = refs[i];
        int status = JO_MACHINE_WRONG;
        if (ref == 0 || ref >= states || (ref >= outputs && ref < parameters))
            return jo_fmu_say(f, JO_FMU_ERROR, "the variable with the reference %u cannot be set", ref);
        if (ref < outputs) status = jo_machine_set_input(f->machine, (int)(ref - 1), values[i]);
        else status = jo_machine_set_parameter(f->machine, (int)(ref - parameters), values[i]);
        if (status != JO_MACHINE_OK) return jo_fmu_say(f, JO_FMU_ERROR, "variable %u cannot be %g", ref, values[i]);
        f->current = 0;
    }
    return JO_FMU_OK;
}

/* co-simulation step: whole steps of the machine from time to time + length */
int jo_fmu_advance(jo_fmu *f, double time, double length, int *early, double *reached)
{
    const double now = jo_machine_time(f->machine), h = jo_machine_step_size(f->machine);
    *early = 0;
    *reached = now;
    if (!isfinite(time) || !isfinite(length) || !(length > 0.0))
        return jo_fmu_say(f, JO_FMU_ERROR, "a step of %g s at %g s is not possible", length, time);
    if (fabs(time - now) > NEAR * h) return jo_fmu_say(f, JO_FMU_ERROR, "the step starts at %.9g s, the machine is at %.9g s", time, now);
    if (f->has_stop && time + length > f->stop + NEAR * h)
        return jo_fmu_say(f, JO_FMU_ERROR, "a step to %.9g s ends after the stop time, %.9g s", time + length, f->stop);
    const double count = floor(length / h + 0.5);
    if (!(count >= 1.0) || count > MAX_STEPS || fabs(count * h - length) > NEAR * h)
        return jo_fmu_say(f, JO_FMU_DISCARD, "a step of %.9g s is no multiple of the machine's own, %.9g s", length, h);
    f->current = 0;
    const long long deferred = jo_data_counts(jo_machine_data(f->machine))->deferred;
    const int status = jo_machine_step(f->machine, (long long)count);
    *reached = jo_machine_time(f->machine);
    if (jo_data_counts(jo_machine_data(f->machine))->deferred != deferred)
        jo_fmu_say(f, JO_FMU_WARNING, "until %.9g s a change of friction or an event was deferred to the next step", *reached);
    if (status == JO_MACHINE_STOPPED) {
        *early = 1;
        jo_fmu_say(f, JO_FMU_WARNING, "an event stops the machine at %.9g s", *reached);
        return JO_FMU_OK;
    }
    return status == JO_MACHINE_OK ? JO_FMU_OK : failed(f);
}

/* -- saved states: head, then the state of the machine, as doubles ------------------------------------------------ */

/* The first number is the size of the state in bytes, which is checked before other numbers are read. */
enum { STATE_BYTES, STATE_EXCHANGE, STATE_MODE, STATE_START, STATE_HAS_STOP, STATE_STOP, HEAD };

static size_t state_bytes(const jo_fmu *f) { return sizeof(double) * (size_t)(HEAD + jo_machine_state_size(f->machine)); }

/* whether a state belongs to an instance of this kind; logs the difference otherwise */
static int fits(jo_fmu *f, const double *state)
{
    static const char *const kinds[] = {"co-simulation", "model exchange"};
    if (state[STATE_BYTES] == (double)state_bytes(f) && state[STATE_EXCHANGE] == (double)f->exchange) return 1;
    const int known = state[STATE_EXCHANGE] == 0.0 || state[STATE_EXCHANGE] == 1.0;
    jo_fmu_say(f, JO_FMU_ERROR, "the state is one of %s with %.0f bytes, states of this instance are of %s with %.0f bytes",
               known ? kinds[state[STATE_EXCHANGE] == 1.0] : "another unit", state[STATE_BYTES], kinds[f->exchange],
               (double)state_bytes(f));
    return 0;
}

int jo_fmu_take(jo_fmu *f, void **state)
{
    if (!state) return JO_FMU_ERROR;
    const double head[HEAD] = {(double)state_bytes(f), f->exchange, f->mode, f->start, f->has_stop, f->stop};
    double *kept = *state;
    const int other = !kept || kept[STATE_BYTES] != head[STATE_BYTES];   /* the state does not belong to an instance of this size */
    double *made = other ? malloc(state_bytes(f)) : kept;
    if (!made) return jo_fmu_say(f, JO_FMU_ERROR, "no memory for a state");
    f->current = 0;
    if (jo_machine_save(f->machine, made + HEAD) != JO_MACHINE_OK) {
        if (other) free(made);
        return failed(f);
    }
    memcpy(made, head, sizeof head);
    if (other) free(kept);
    *state = made;
    return JO_FMU_OK;
}

/* restore a saved state */
int jo_fmu_give(jo_fmu *f, const void *from)
{
    const double *state = from;
    if (!state) return jo_fmu_say(f, JO_FMU_ERROR, "there is no state");
    if (!fits(f, state)) return JO_FMU_ERROR;
    const double mode = state[STATE_MODE];
    const int known = mode == JO_FMU_MADE || mode == JO_FMU_INITIALISING || mode == JO_FMU_EVENTS || mode == JO_FMU_CONTINUOUS
                      || mode == JO_FMU_STEPS || mode == JO_FMU_ENDED;
    f->current = 0;
    if (!known || jo_machine_load(f->machine, state + HEAD) != JO_MACHINE_OK)
        return jo_fmu_say(f, JO_FMU_ERROR, "this is no state of the machine");
    f->mode = (int)mode;
    f->start = state[STATE_START];
    f->has_stop = state[STATE_HAS_STOP] != 0.0;
    f->stop = state[STATE_STOP];
    return JO_FMU_OK;
}

int jo_fmu_release(void **state)
{
    if (!state) return JO_FMU_OK;
    free(*state);
    *state = 0;
    return JO_FMU_OK;
}

size_t jo_fmu_bytes(const void *state) { return (size_t)((const double *)state)[STATE_BYTES]; }

int jo_fmu_write(jo_fmu *f, const void *state, void *bytes, size_t size)
{
    if (!state || !bytes || size < jo_fmu_bytes(state)) return jo_fmu_say(f, JO_FMU_ERROR, "no room for a state");
    memcpy(bytes, state, jo_fmu_bytes(state));
    return JO_FMU_OK;
}

int jo_fmu_read(jo_fmu *f, const void *bytes, size_t size, void **state)
{
    double head[HEAD];
    if (!state || !bytes || size < sizeof head) return jo_fmu_say(f, JO_FMU_ERROR, "this is no state of the machine");
    memcpy(head, bytes, sizeof head);   /* bytes may be unaligned */
    if (!fits(f, head)) return JO_FMU_ERROR;
    if (size != state_bytes(f)) return jo_fmu_say(f, JO_FMU_ERROR, "a state has %.0f bytes, not %.0f", head[0], (double)size);
    double *kept = *state;
    double *made = kept && kept[STATE_BYTES] == head[STATE_BYTES] ? kept : malloc(size);
    if (!made) return jo_fmu_say(f, JO_FMU_ERROR, "no memory for a state");
    memcpy(made, bytes, size);
    if (made != kept) free(kept);
    *state = made;
    return JO_FMU_OK;
}

/* -- directional derivatives ----------------------------------------------------------------------------------- */

#ifdef PLANT_SLOPES
#include "slope.h"

/* kind and index of a value reference */
static jo_slope_ref ref_of(const jo_fmu *f, unsigned ref)
{
    const jo_plant *p = &PLANT;
    const unsigned n = f->exchange ? (unsigned)jo_machine_states(f->machine) : 0;
    const unsigned counts[] = {1, (unsigned)p->ninput, (unsigned)p->noutput, (unsigned)p->nparameter, n, n};
    jo_slope_ref found = {-1, 0};
    for (int kind = JO_SLOPE_TIME; kind <= JO_SLOPE_RATE; kind++) {
        if (ref < counts[kind]) {
            found.kind = kind;
            found.index = (int)ref;
            return found;
        }
        ref -= counts[kind];
    }
    return found;
}

int jo_fmu_slope(jo_fmu *f, const unsigned *unknowns, size_t nunknown, const unsigned *knowns, size_t nknown, const double *seed,
                 double *change)
{
    int status = JO_FMU_OK;
    if ((nknown && (!knowns || !seed)) || (nunknown && (!unknowns || !change)))
        return jo_fmu_say(f, JO_FMU_ERROR, "no variables, or no place for their derivatives");
    double *state = malloc(sizeof(double) * (size_t)jo_machine_state_size(f->machine));
    jo_slope_ref *refs = malloc(sizeof *refs * (nknown + nunknown + 1));
    if (!state || !refs) status = jo_fmu_say(f, JO_FMU_ERROR, "no memory for derivatives");
    for (size_t i = 0; i < nknown && status == JO_FMU_OK; i++) {
        refs[i] = ref_of(f, knowns[i]);
        if (refs[i].kind < 0 || refs[i].kind == JO_SLOPE_OUTPUT || refs[i].kind == JO_SLOPE_RATE)
            status = jo_fmu_say(f, JO_FMU_ERROR, "there are no derivatives by variable %u", knowns[i]);
    }
    for (size_t i = 0; i < nunknown && status == JO_FMU_OK; i++) {
        refs[nknown + i] = ref_of(f, unknowns[i]);
        if (refs[nknown + i].kind != JO_SLOPE_OUTPUT && refs[nknown + i].kind != JO_SLOPE_RATE)
            status = jo_fmu_say(f, JO_FMU_ERROR, "variable %u has no derivatives", unknowns[i]);
    }
    if (status == JO_FMU_OK) {
        f->current = 0;
        if (jo_machine_save(f->machine, state) != JO_MACHINE_OK) status = failed(f);
        else if (jo_slope(state, f->exchange, PLANT_BAUMGARTE, refs, seed, (int)nknown, refs + nknown, change, (int)nunknown))
            status = jo_fmu_say(f, JO_FMU_DISCARD, "at %.9g s there are no derivatives", jo_machine_time(f->machine));
    }
    free(refs);
    free(state);
    return status;
}
#else
int jo_fmu_slope(jo_fmu *f, const unsigned *unknowns, size_t nunknown, const unsigned *knowns, size_t nknown, const double *seed,
                 double *change)
{
    (void)unknowns; (void)nunknown; (void)knowns; (void)nknown; (void)seed; (void)change;
    return jo_fmu_say(f, JO_FMU_ERROR, "directional derivatives are not provided");
}
#endif

/* -- model exchange ---------------------------------------------------------------------------------------------- */

int jo_fmu_set_time(jo_fmu *f, double time)
{
    if (!isfinite(time)) return jo_fmu_say(f, JO_FMU_ERROR, "time cannot be %g", time);
    jo_machine_get_states(f->machine, f->scratch);
    f->current = 0;
    return jo_machine_set_states(f->machine, time, f->scratch) == JO_MACHINE_OK ? JO_FMU_OK : JO_FMU_ERROR;
}

int jo_fmu_count_states(jo_fmu *f, size_t count)
{
    if (!f->exchange) return jo_fmu_say(f, JO_FMU_ERROR, "states are those of model exchange");
    if (count == (size_t)jo_machine_states(f->machine)) return JO_FMU_OK;
    return jo_fmu_say(f, JO_FMU_ERROR, "there are %d states, not %u", jo_machine_states(f->machine), (unsigned)count);
}

int jo_fmu_set_states(jo_fmu *f, const double *states, size_t count)
{
    if (jo_fmu_count_states(f, count) != JO_FMU_OK || !states) return JO_FMU_ERROR;
    f->current = 0;
    if (jo_machine_set_states(f->machine, jo_machine_time(f->machine), states) == JO_MACHINE_OK) return JO_FMU_OK;
    return jo_fmu_say(f, JO_FMU_DISCARD, "the states are not finite, or Euler parameters vanish");
}
