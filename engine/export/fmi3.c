/* fmi3.c - the functions of FMI 3.0.2 for co-simulation and model exchange. Names and meanings are those of the standard. */
#include "fmu.h"
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#if defined(_WIN32)
#define API __declspec(dllexport)
#elif defined(__GNUC__)
#define API __attribute__((visibility("default")))
#else
#define API
#endif

typedef void *Instance, *Environment, *State;
typedef uint32_t Ref;
typedef int Status;
typedef bool Boolean;
typedef void (*Log)(Environment, Status, const char *category, const char *message);
typedef void (*Intermediate)(Environment, double, Boolean, Boolean, Boolean, Boolean, Boolean, Boolean *, double *);
typedef void (*Locked)(void);

enum { RUNNING = JO_FMU_EVENTS | JO_FMU_CONTINUOUS | JO_FMU_STEPS, READABLE = RUNNING | JO_FMU_INITIALISING | JO_FMU_ENDED,
       ANY = READABLE | JO_FMU_MADE | JO_FMU_BROKEN };
#define MAY(name, modes) do { if (!jo_fmu_may(instance, name, modes)) return JO_FMU_ERROR; } while (0)

typedef struct { Log log; Environment environment; Boolean early; } host;   /* early: whether a step may return before its end */

static void forward(void *h, int status, const char *category, const char *text)
{
    host *to = h;
    if (to->log) to->log(to->environment, status, category, text);
}

API const char *fmi3GetVersion(void) { return "3.0"; }

API Status fmi3SetDebugLogging(Instance instance, Boolean on, size_t count, const char *const categories[])
{
    MAY("fmi3SetDebugLogging", ANY);
    if (count && !categories) return JO_FMU_ERROR;
    ((jo_fmu *)instance)->logging = on;
    return JO_FMU_OK;
}

static Instance make(const char *name, const char *token, int exchange, Boolean logging, Environment environment, Log log)
{
    host *to = calloc(1, sizeof *to);
    if (!to) return 0;
    to->log = log;
    to->environment = environment;
    jo_fmu *f = jo_fmu_make(name, token, exchange, logging, forward, to);
    if (f) f->more = to;
    else free(to);
    return f;
}

API Instance fmi3InstantiateModelExchange(const char *name, const char *token, const char *resources, Boolean visible,
                                          Boolean logging, Environment environment, Log log)
{
    (void)resources; (void)visible;
    return make(name, token, 1, logging, environment, log);
}

API Instance fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, Boolean visible,
                                         Boolean logging, Boolean events, Boolean early, const Ref required[], size_t count,
                                         Environment environment, Log log, Intermediate update)
{
    (void)resources; (void)visible; (void)required; (void)count; (void)update;
    if (events) return 0;   /* hasEventMode is false */
    jo_fmu *f = make(name, token, 0, logging, environment, log);
    if (f) ((host *)f->more)->early = early;
    return f;
}

API Instance fmi3InstantiateScheduledExecution(const char *name, const char *token, const char *resources, Boolean visible,
                                               Boolean logging, Environment environment, Log log, void *clock, Locked lock, Locked unlock)
{
    (void)name; (void)token; (void)resources; (void)visible; (void)logging; (void)environment; (void)log; (void)clock;
    (void)lock; (void)unlock;
    return 0;
}

API void fmi3FreeInstance(Instance instance)
{
    if (!instance) return;
    free(((jo_fmu *)instance)->more);
    jo_fmu_free(instance);
}

API Status fmi3EnterInitializationMode(Instance instance, Boolean has_tolerance, double tolerance, double start, Boolean has_stop, double stop)
{
    (void)has_tolerance; (void)tolerance;
    MAY("fmi3EnterInitializationMode", JO_FMU_MADE);
    const Status status = jo_fmu_setup(instance, start, has_stop, stop);
    if (status == JO_FMU_OK) ((jo_fmu *)instance)->mode = JO_FMU_INITIALISING;
    return status;
}

API Status fmi3ExitInitializationMode(Instance instance)
{
    MAY("fmi3ExitInitializationMode", JO_FMU_INITIALISING);
    jo_fmu *f = instance;
    f->mode = f->exchange ? JO_FMU_EVENTS : JO_FMU_STEPS;
    return JO_FMU_OK;
}

API Status fmi3EnterEventMode(Instance instance)
{
    MAY("fmi3EnterEventMode", JO_FMU_CONTINUOUS);
    ((jo_fmu *)instance)->mode = JO_FMU_EVENTS;
    return JO_FMU_OK;
}

API Status fmi3Terminate(Instance instance)
{
    MAY("fmi3Terminate", RUNNING);
    ((jo_fmu *)instance)->mode = JO_FMU_ENDED;
    return JO_FMU_OK;
}

API Status fmi3Reset(Instance instance)
{
    MAY("fmi3Reset", ANY);
    return jo_fmu_reset(instance);
}

API Status fmi3GetFloat64(Instance instance, const Ref refs[], size_t count, double values[], size_t size)
{
    MAY("fmi3GetFloat64", READABLE | JO_FMU_MADE);
    if (size != count) return jo_fmu_say(instance, JO_FMU_ERROR, "%u values for %u scalar variables", (unsigned)size, (unsigned)count);
    return jo_fmu_get(instance, refs, count, values);
}

API Status fmi3SetFloat64(Instance instance, const Ref refs[], size_t count, const double values[], size_t size)
{
    MAY("fmi3SetFloat64", JO_FMU_MADE | JO_FMU_INITIALISING | RUNNING);
    if (size != count) return jo_fmu_say(instance, JO_FMU_ERROR, "%u values for %u scalar variables", (unsigned)size, (unsigned)count);
    return jo_fmu_set(instance, refs, count, values);
}

/* functions for types without variables: all variables are Float64 */
#define NONE_OF(type, name)                                                                                                     \
    API Status fmi3Get##name(Instance instance, const Ref refs[], size_t count, type values[], size_t size)                     \
    {                                                                                                                           \
        (void)refs; (void)values;                                                                                               \
        MAY("fmi3Get" #name, READABLE | JO_FMU_MADE);                                                                           \
        return count || size ? jo_fmu_say(instance, JO_FMU_ERROR, "there are no variables of the type " #name) : JO_FMU_OK;     \
    }                                                                                                                           \
    API Status fmi3Set##name(Instance instance, const Ref refs[], size_t count, const type values[], size_t size)               \
    {                                                                                                                           \
        (void)refs; (void)values;                                                                                               \
        MAY("fmi3Set" #name, JO_FMU_MADE | JO_FMU_INITIALISING | RUNNING);                                                      \
        return count || size ? jo_fmu_say(instance, JO_FMU_ERROR, "there are no variables of the type " #name) : JO_FMU_OK;     \
    }
typedef const char *String;
NONE_OF(float, Float32)
NONE_OF(int8_t, Int8)
NONE_OF(uint8_t, UInt8)
NONE_OF(int16_t, Int16)
NONE_OF(uint16_t, UInt16)
NONE_OF(int32_t, Int32)
NONE_OF(uint32_t, UInt32)
NONE_OF(int64_t, Int64)
NONE_OF(uint64_t, UInt64)
NONE_OF(bool, Boolean)
NONE_OF(String, String)

API Status fmi3GetBinary(Instance instance, const Ref refs[], size_t count, size_t sizes[], const uint8_t *values[], size_t size)
{
    (void)refs; (void)sizes; (void)values;
    MAY("fmi3GetBinary", READABLE | JO_FMU_MADE);
    return count || size ? jo_fmu_say(instance, JO_FMU_ERROR, "there are no variables of the type Binary") : JO_FMU_OK;
}
API Status fmi3SetBinary(Instance instance, const Ref refs[], size_t count, const size_t sizes[], const uint8_t *const values[], size_t size)
{
    (void)refs; (void)sizes; (void)values;
    MAY("fmi3SetBinary", JO_FMU_MADE | JO_FMU_INITIALISING | RUNNING);
    return count || size ? jo_fmu_say(instance, JO_FMU_ERROR, "there are no variables of the type Binary") : JO_FMU_OK;
}
API Status fmi3GetClock(Instance instance, const Ref refs[], size_t count, bool values[])
{
    (void)refs; (void)values;
    MAY("fmi3GetClock", READABLE);
    return count ? jo_fmu_say(instance, JO_FMU_ERROR, "there are no clocks") : JO_FMU_OK;
}
API Status fmi3SetClock(Instance instance, const Ref refs[], size_t count, const bool values[])
{
    (void)refs; (void)values;
    MAY("fmi3SetClock", READABLE);
    return count ? jo_fmu_say(instance, JO_FMU_ERROR, "there are no clocks") : JO_FMU_OK;
}

/* functions for capabilities that the model description does not declare */
static Status missing(Instance instance, const char *what)
{
    return instance ? jo_fmu_say(instance, JO_FMU_ERROR, "%s is not provided", what) : JO_FMU_ERROR;
}
API Status fmi3GetNumberOfVariableDependencies(Instance instance, Ref ref, size_t *count)
{
    (void)ref; (void)count;
    return missing(instance, "fmi3GetNumberOfVariableDependencies");
}
API Status fmi3GetVariableDependencies(Instance instance, Ref dependent, size_t elements[], Ref independents[], size_t others[],
                                       int kinds[], size_t count)
{
    (void)dependent; (void)elements; (void)independents; (void)others; (void)kinds; (void)count;
    return missing(instance, "fmi3GetVariableDependencies");
}
API Status fmi3GetDirectionalDerivative(Instance instance, const Ref unknowns[], size_t nunknown, const Ref knowns[], size_t nknown,
                                        const double seed[], size_t nseed, double sensitivity[], size_t nsensitivity)
{
    MAY("fmi3GetDirectionalDerivative", READABLE);
    if (nseed != nknown || nsensitivity != nunknown)
        return jo_fmu_say(instance, JO_FMU_ERROR, "%u seeds for %u scalar variables", (unsigned)nseed, (unsigned)nknown);
    return jo_fmu_slope(instance, unknowns, nunknown, knowns, nknown, seed, sensitivity);
}
API Status fmi3GetAdjointDerivative(Instance instance, const Ref unknowns[], size_t nunknown, const Ref knowns[], size_t nknown,
                                    const double seed[], size_t nseed, double sensitivity[], size_t nsensitivity)
{
    (void)unknowns; (void)nunknown; (void)knowns; (void)nknown; (void)seed; (void)nseed; (void)sensitivity; (void)nsensitivity;
    return missing(instance, "fmi3GetAdjointDerivative");
}
API Status fmi3EnterConfigurationMode(Instance instance) { return missing(instance, "configuration mode"); }
API Status fmi3ExitConfigurationMode(Instance instance) { return missing(instance, "configuration mode"); }
#define NO_CLOCK(name, ...) API Status fmi3##name(Instance instance, const Ref refs[], size_t count, __VA_ARGS__)                \
    { (void)refs; (void)count; (void)a; (void)b; return missing(instance, "fmi3" #name); }
NO_CLOCK(GetIntervalDecimal, double a[], int b[])
NO_CLOCK(SetIntervalFraction, const uint64_t a[], const uint64_t b[])
NO_CLOCK(GetShiftFraction, uint64_t a[], uint64_t b[])
NO_CLOCK(SetShiftFraction, const uint64_t a[], const uint64_t b[])
#undef NO_CLOCK
API Status fmi3GetIntervalFraction(Instance instance, const Ref refs[], size_t count, uint64_t counters[], uint64_t resolutions[], int qualifiers[])
{
    (void)refs; (void)count; (void)counters; (void)resolutions; (void)qualifiers;
    return missing(instance, "fmi3GetIntervalFraction");
}
API Status fmi3GetShiftDecimal(Instance instance, const Ref refs[], size_t count, double shifts[])
{
    (void)refs; (void)count; (void)shifts;
    return missing(instance, "fmi3GetShiftDecimal");
}
API Status fmi3SetIntervalDecimal(Instance instance, const Ref refs[], size_t count, const double intervals[])
{
    (void)refs; (void)count; (void)intervals;
    return missing(instance, "fmi3SetIntervalDecimal");
}
API Status fmi3SetShiftDecimal(Instance instance, const Ref refs[], size_t count, const double shifts[])
{
    (void)refs; (void)count; (void)shifts;
    return missing(instance, "fmi3SetShiftDecimal");
}
API Status fmi3EvaluateDiscreteStates(Instance instance)
{
    MAY("fmi3EvaluateDiscreteStates", JO_FMU_INITIALISING | JO_FMU_EVENTS);
    return JO_FMU_OK;
}

API Status fmi3GetFMUState(Instance instance, State *state)
{
    MAY("fmi3GetFMUState", ANY & ~JO_FMU_BROKEN);
    return jo_fmu_take(instance, state);
}
API Status fmi3SetFMUState(Instance instance, State state)
{
    MAY("fmi3SetFMUState", ANY);
    return jo_fmu_give(instance, state);
}
API Status fmi3FreeFMUState(Instance instance, State *state)
{
    MAY("fmi3FreeFMUState", ANY);
    return jo_fmu_release(state);
}
API Status fmi3SerializedFMUStateSize(Instance instance, State state, size_t *size)
{
    MAY("fmi3SerializedFMUStateSize", ANY);
    if (!state || !size) return JO_FMU_ERROR;
    *size = jo_fmu_bytes(state);
    return JO_FMU_OK;
}
API Status fmi3SerializeFMUState(Instance instance, State state, uint8_t bytes[], size_t size)
{
    MAY("fmi3SerializeFMUState", ANY);
    return jo_fmu_write(instance, state, bytes, size);
}
API Status fmi3DeserializeFMUState(Instance instance, const uint8_t bytes[], size_t size, State *state)
{
    MAY("fmi3DeserializeFMUState", ANY);
    return jo_fmu_read(instance, bytes, size, state);
}

/* -- model exchange ---------------------------------------------------------------------------------------------- */

API Status fmi3UpdateDiscreteStates(Instance instance, Boolean *again, Boolean *terminate, Boolean *nominals, Boolean *values,
                                    Boolean *defined, double *next)
{
    MAY("fmi3UpdateDiscreteStates", JO_FMU_EVENTS);
    if (!again || !terminate || !nominals || !values || !defined || !next) return JO_FMU_ERROR;
    *again = *terminate = *nominals = *values = *defined = false;
    *next = 0.0;
    return JO_FMU_OK;
}
API Status fmi3EnterContinuousTimeMode(Instance instance)
{
    MAY("fmi3EnterContinuousTimeMode", JO_FMU_EVENTS);
    ((jo_fmu *)instance)->mode = JO_FMU_CONTINUOUS;
    return JO_FMU_OK;
}
API Status fmi3CompletedIntegratorStep(Instance instance, Boolean no_return, Boolean *event, Boolean *terminate)
{
    (void)no_return;
    MAY("fmi3CompletedIntegratorStep", JO_FMU_CONTINUOUS);
    if (!event || !terminate) return JO_FMU_ERROR;
    *event = *terminate = false;
    jo_machine_count(((jo_fmu *)instance)->machine);
    return JO_FMU_OK;
}
API Status fmi3SetTime(Instance instance, double time)
{
    MAY("fmi3SetTime", JO_FMU_CONTINUOUS);
    return jo_fmu_set_time(instance, time);
}
API Status fmi3SetContinuousStates(Instance instance, const double states[], size_t count)
{
    MAY("fmi3SetContinuousStates", JO_FMU_CONTINUOUS);
    return jo_fmu_set_states(instance, states, count);
}
API Status fmi3GetContinuousStateDerivatives(Instance instance, double rates[], size_t count)
{
    MAY("fmi3GetContinuousStateDerivatives", JO_FMU_INITIALISING | JO_FMU_EVENTS | JO_FMU_CONTINUOUS | JO_FMU_ENDED);
    if (jo_fmu_count_states(instance, count) != JO_FMU_OK || !rates) return JO_FMU_ERROR;
    return jo_fmu_rates(instance, rates);
}
API Status fmi3GetEventIndicators(Instance instance, double indicators[], size_t count)
{
    (void)indicators;
    MAY("fmi3GetEventIndicators", JO_FMU_INITIALISING | JO_FMU_EVENTS | JO_FMU_CONTINUOUS | JO_FMU_ENDED);
    return count ? jo_fmu_say(instance, JO_FMU_ERROR, "there are no event indicators") : JO_FMU_OK;
}
API Status fmi3GetContinuousStates(Instance instance, double states[], size_t count)
{
    MAY("fmi3GetContinuousStates", JO_FMU_INITIALISING | JO_FMU_EVENTS | JO_FMU_CONTINUOUS | JO_FMU_ENDED);
    if (jo_fmu_count_states(instance, count) != JO_FMU_OK || !states) return JO_FMU_ERROR;
    jo_machine_get_states(((jo_fmu *)instance)->machine, states);
    return JO_FMU_OK;
}
API Status fmi3GetNominalsOfContinuousStates(Instance instance, double nominals[], size_t count)
{
    MAY("fmi3GetNominalsOfContinuousStates", JO_FMU_INITIALISING | JO_FMU_EVENTS | JO_FMU_CONTINUOUS | JO_FMU_ENDED);
    if (jo_fmu_count_states(instance, count) != JO_FMU_OK || !nominals) return JO_FMU_ERROR;
    for (size_t i = 0; i < count; i++) nominals[i] = 1.0;
    return JO_FMU_OK;
}
API Status fmi3GetNumberOfEventIndicators(Instance instance, size_t *count)
{
    MAY("fmi3GetNumberOfEventIndicators", ANY);
    if (!count) return JO_FMU_ERROR;
    *count = 0;
    return JO_FMU_OK;
}
API Status fmi3GetNumberOfContinuousStates(Instance instance, size_t *count)
{
    MAY("fmi3GetNumberOfContinuousStates", ANY);
    jo_fmu *f = instance;
    if (!count) return JO_FMU_ERROR;
    *count = f->exchange ? (size_t)jo_machine_states(f->machine) : 0;
    return JO_FMU_OK;
}

/* -- co-simulation ----------------------------------------------------------------------------------------------- */

API Status fmi3EnterStepMode(Instance instance)
{
    MAY("fmi3EnterStepMode", 0);   /* no event mode */
    return JO_FMU_OK;
}
API Status fmi3GetOutputDerivatives(Instance instance, const Ref refs[], size_t count, const int32_t orders[], double values[], size_t size)
{
    (void)refs; (void)count; (void)orders; (void)values; (void)size;
    return missing(instance, "fmi3GetOutputDerivatives");
}
API Status fmi3DoStep(Instance instance, double time, double length, Boolean no_return, Boolean *event, Boolean *terminate,
                      Boolean *early, double *reached)
{
    (void)no_return;
    MAY("fmi3DoStep", JO_FMU_STEPS);
    if (!event || !terminate || !early || !reached) return JO_FMU_ERROR;
    int stopped = 0;
    const Status status = jo_fmu_advance(instance, time, length, &stopped, reached);
    *event = false;
    *terminate = stopped;
    *early = stopped && ((host *)((jo_fmu *)instance)->more)->early;
    return status;
}
API Status fmi3ActivateModelPartition(Instance instance, Ref clock, double time)
{
    (void)clock; (void)time;
    return missing(instance, "scheduled execution");
}
