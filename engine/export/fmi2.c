/* fmi2.c - the functions of FMI 2.0.4 for co-simulation and model exchange. Names and meanings are those of the standard. */
#include "fmu.h"
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define API __declspec(dllexport)
#elif defined(__GNUC__)
#define API __attribute__((visibility("default")))
#else
#define API
#endif

typedef void *Component, *Environment, *State;
typedef unsigned Ref;
typedef int Status, Boolean, Integer;
typedef const char *String;
typedef void (*Log)(Environment, String name, Status, String category, String message, ...);
typedef struct {
    Log logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(Environment, Status);
    Environment environment;
} Callbacks;
typedef struct { Boolean again, terminate, nominals, values, defined; double next; } Events;

enum { RUNNING = JO_FMU_EVENTS | JO_FMU_CONTINUOUS | JO_FMU_STEPS, READABLE = RUNNING | JO_FMU_INITIALISING | JO_FMU_ENDED,
       ANY = READABLE | JO_FMU_MADE | JO_FMU_BROKEN };
enum { DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, TERMINATED };
#define MAY(name, modes) do { if (!jo_fmu_may(instance, name, modes)) return JO_FMU_ERROR; } while (0)

typedef struct {
    Log log;
    Environment environment;
    int stopped;            /* whether an event has ended the run */
    char name[1];           /* first character of the name */
} host;

/* The text is passed to the logger as its format, with % doubled: loggers without support of further arguments print it, too. */
static void forward(void *h, int status, const char *category, const char *text)
{
    host *to = h;
    char format[2 * JO_FMU_MESSAGE], *end = format;
    for (; *text && end < format + sizeof format - 2; text++) {
        if (*text == '%') *end++ = '%';
        *end++ = *text;
    }
    *end = 0;
    if (to->log) to->log(to->environment, to->name, status, category, format);
}

API const char *fmi2GetTypesPlatform(void) { return "default"; }
API const char *fmi2GetVersion(void) { return "2.0"; }

API Status fmi2SetDebugLogging(Component instance, Boolean on, size_t count, const String categories[])
{
    MAY("fmi2SetDebugLogging", ANY);
    if (count && !categories) return JO_FMU_ERROR;
    ((jo_fmu *)instance)->logging = on;
    return JO_FMU_OK;
}

API Component fmi2Instantiate(String name, int kind, String guid, String resources, const Callbacks *functions, Boolean visible, Boolean logging)
{
    (void)resources; (void)visible;
    if (!functions || kind < 0 || kind > 1) return 0;
    const size_t length = name ? strlen(name) : 0;
    host *to = calloc(1, sizeof *to + length);
    if (!to) return 0;
    to->log = functions->logger;
    to->environment = functions->environment;
    if (length) memcpy(to->name, name, length);
    jo_fmu *f = jo_fmu_make(name, guid, kind == 0, logging, forward, to);
    if (f) f->more = to;
    else free(to);
    return f;
}

API void fmi2FreeInstance(Component instance)
{
    if (!instance) return;
    free(((jo_fmu *)instance)->more);
    jo_fmu_free(instance);
}

API Status fmi2SetupExperiment(Component instance, Boolean has_tolerance, double tolerance, double start, Boolean has_stop, double stop)
{
    (void)has_tolerance; (void)tolerance;
    MAY("fmi2SetupExperiment", JO_FMU_MADE);
    return jo_fmu_setup(instance, start, has_stop, stop);
}
API Status fmi2EnterInitializationMode(Component instance)
{
    MAY("fmi2EnterInitializationMode", JO_FMU_MADE);
    ((jo_fmu *)instance)->mode = JO_FMU_INITIALISING;
    return JO_FMU_OK;
}
API Status fmi2ExitInitializationMode(Component instance)
{
    MAY("fmi2ExitInitializationMode", JO_FMU_INITIALISING);
    jo_fmu *f = instance;
    f->mode = f->exchange ? JO_FMU_EVENTS : JO_FMU_STEPS;
    return JO_FMU_OK;
}
API Status fmi2Terminate(Component instance)
{
    MAY("fmi2Terminate", RUNNING);
    ((jo_fmu *)instance)->mode = JO_FMU_ENDED;
    return JO_FMU_OK;
}
API Status fmi2Reset(Component instance)
{
    MAY("fmi2Reset", ANY);
    ((host *)((jo_fmu *)instance)->more)->stopped = 0;
    return jo_fmu_reset(instance);
}

API Status fmi2GetReal(Component instance, const Ref refs[], size_t count, double values[])
{
    MAY("fmi2GetReal", READABLE | JO_FMU_MADE);
    return jo_fmu_get(instance, refs, count, values);
}
API Status fmi2SetReal(Component instance, const Ref refs[], size_t count, const double values[])
{
    MAY("fmi2SetReal", JO_FMU_MADE | JO_FMU_INITIALISING | RUNNING);
    return jo_fmu_set(instance, refs, count, values);
}

/* functions for types without variables: all variables are real */
#define NONE_OF(type, name)                                                                                                    \
    API Status fmi2Get##name(Component instance, const Ref refs[], size_t count, type values[])                                \
    {                                                                                                                          \
        (void)refs; (void)values;                                                                                              \
        MAY("fmi2Get" #name, READABLE | JO_FMU_MADE);                                                                          \
        return count ? jo_fmu_say(instance, JO_FMU_ERROR, "there are no variables of the type " #name) : JO_FMU_OK;            \
    }                                                                                                                          \
    API Status fmi2Set##name(Component instance, const Ref refs[], size_t count, const type values[])                          \
    {                                                                                                                          \
        (void)refs; (void)values;                                                                                              \
        MAY("fmi2Set" #name, JO_FMU_MADE | JO_FMU_INITIALISING | RUNNING);                                                     \
        return count ? jo_fmu_say(instance, JO_FMU_ERROR, "there are no variables of the type " #name) : JO_FMU_OK;            \
    }
NONE_OF(Integer, Integer)
NONE_OF(Boolean, Boolean)
NONE_OF(String, String)

API Status fmi2GetFMUstate(Component instance, State *state)
{
    MAY("fmi2GetFMUstate", ANY & ~JO_FMU_BROKEN);
    return jo_fmu_take(instance, state);
}
API Status fmi2SetFMUstate(Component instance, State state)
{
    MAY("fmi2SetFMUstate", ANY);
    ((host *)((jo_fmu *)instance)->more)->stopped = 0;
    return jo_fmu_give(instance, state);
}
API Status fmi2FreeFMUstate(Component instance, State *state)
{
    MAY("fmi2FreeFMUstate", ANY);
    return jo_fmu_release(state);
}
API Status fmi2SerializedFMUstateSize(Component instance, State state, size_t *size)
{
    MAY("fmi2SerializedFMUstateSize", ANY);
    if (!state || !size) return JO_FMU_ERROR;
    *size = jo_fmu_bytes(state);
    return JO_FMU_OK;
}
API Status fmi2SerializeFMUstate(Component instance, State state, char bytes[], size_t size)
{
    MAY("fmi2SerializeFMUstate", ANY);
    return jo_fmu_write(instance, state, bytes, size);
}
API Status fmi2DeSerializeFMUstate(Component instance, const char bytes[], size_t size, State *state)
{
    MAY("fmi2DeSerializeFMUstate", ANY);
    return jo_fmu_read(instance, bytes, size, state);
}
API Status fmi2GetDirectionalDerivative(Component instance, const Ref unknowns[], size_t nunknown, const Ref knowns[], size_t nknown,
                                        const double seed[], double sensitivity[])
{
    MAY("fmi2GetDirectionalDerivative", READABLE);
    return jo_fmu_slope(instance, unknowns, nunknown, knowns, nknown, seed, sensitivity);
}

/* -- model exchange ---------------------------------------------------------------------------------------------- */

enum { EXCHANGE = JO_FMU_INITIALISING | JO_FMU_EVENTS | JO_FMU_CONTINUOUS | JO_FMU_ENDED };

API Status fmi2EnterEventMode(Component instance)
{
    MAY("fmi2EnterEventMode", JO_FMU_CONTINUOUS | JO_FMU_EVENTS);
    ((jo_fmu *)instance)->mode = JO_FMU_EVENTS;
    return JO_FMU_OK;
}
API Status fmi2NewDiscreteStates(Component instance, Events *events)
{
    MAY("fmi2NewDiscreteStates", JO_FMU_EVENTS);
    if (!events) return JO_FMU_ERROR;
    memset(events, 0, sizeof *events);
    return JO_FMU_OK;
}
API Status fmi2EnterContinuousTimeMode(Component instance)
{
    MAY("fmi2EnterContinuousTimeMode", JO_FMU_EVENTS);
    ((jo_fmu *)instance)->mode = JO_FMU_CONTINUOUS;
    return JO_FMU_OK;
}
API Status fmi2CompletedIntegratorStep(Component instance, Boolean no_return, Boolean *event, Boolean *terminate)
{
    (void)no_return;
    MAY("fmi2CompletedIntegratorStep", JO_FMU_CONTINUOUS);
    if (!event || !terminate) return JO_FMU_ERROR;
    *event = *terminate = 0;
    jo_machine_count(((jo_fmu *)instance)->machine);
    return JO_FMU_OK;
}
API Status fmi2SetTime(Component instance, double time)
{
    MAY("fmi2SetTime", JO_FMU_CONTINUOUS | JO_FMU_EVENTS);
    return jo_fmu_set_time(instance, time);
}
API Status fmi2SetContinuousStates(Component instance, const double states[], size_t count)
{
    MAY("fmi2SetContinuousStates", JO_FMU_CONTINUOUS);
    return jo_fmu_set_states(instance, states, count);
}
API Status fmi2GetDerivatives(Component instance, double rates[], size_t count)
{
    MAY("fmi2GetDerivatives", EXCHANGE);
    if (jo_fmu_count_states(instance, count) != JO_FMU_OK || !rates) return JO_FMU_ERROR;
    return jo_fmu_rates(instance, rates);
}
API Status fmi2GetEventIndicators(Component instance, double indicators[], size_t count)
{
    (void)indicators;
    MAY("fmi2GetEventIndicators", EXCHANGE);
    return count ? jo_fmu_say(instance, JO_FMU_ERROR, "there are no event indicators") : JO_FMU_OK;
}
API Status fmi2GetContinuousStates(Component instance, double states[], size_t count)
{
    MAY("fmi2GetContinuousStates", EXCHANGE);
    if (jo_fmu_count_states(instance, count) != JO_FMU_OK || !states) return JO_FMU_ERROR;
    jo_machine_get_states(((jo_fmu *)instance)->machine, states);
    return JO_FMU_OK;
}
API Status fmi2GetNominalsOfContinuousStates(Component instance, double nominals[], size_t count)
{
    MAY("fmi2GetNominalsOfContinuousStates", EXCHANGE | JO_FMU_MADE);
    if (jo_fmu_count_states(instance, count) != JO_FMU_OK || !nominals) return JO_FMU_ERROR;
    for (size_t i = 0; i < count; i++) nominals[i] = 1.0;
    return JO_FMU_OK;
}

/* -- co-simulation ----------------------------------------------------------------------------------------------- */

API Status fmi2SetRealInputDerivatives(Component instance, const Ref refs[], size_t count, const Integer orders[], const double values[])
{
    (void)refs; (void)count; (void)orders; (void)values;
    return instance ? jo_fmu_say(instance, JO_FMU_ERROR, "inputs are held, their derivatives cannot be set") : JO_FMU_ERROR;
}
API Status fmi2GetRealOutputDerivatives(Component instance, const Ref refs[], size_t count, const Integer orders[], double values[])
{
    (void)refs; (void)count; (void)orders; (void)values;
    return instance ? jo_fmu_say(instance, JO_FMU_ERROR, "derivatives of outputs are not provided") : JO_FMU_ERROR;
}
API Status fmi2DoStep(Component instance, double time, double length, Boolean no_return)
{
    (void)no_return;
    MAY("fmi2DoStep", JO_FMU_STEPS);
    jo_fmu *f = instance;
    int early = 0;
    double reached;
    const Status status = jo_fmu_advance(f, time, length, &early, &reached);
    if (!early) return status;
    ((host *)f->more)->stopped = 1;
    return JO_FMU_DISCARD;   /* terminated: fmi2GetBooleanStatus */
}
API Status fmi2CancelStep(Component instance)
{
    return instance ? jo_fmu_say(instance, JO_FMU_ERROR, "no step is running") : JO_FMU_ERROR;
}
API Status fmi2GetStatus(Component instance, int kind, Status *value)
{
    (void)value;
    MAY("fmi2GetStatus", ANY);
    return jo_fmu_say(instance, JO_FMU_DISCARD, "status %d is known of steps that run on only", kind);
}
API Status fmi2GetRealStatus(Component instance, int kind, double *value)
{
    MAY("fmi2GetRealStatus", ANY);
    if (kind != LAST_SUCCESSFUL_TIME || !value) return JO_FMU_DISCARD;
    *value = jo_machine_time(((jo_fmu *)instance)->machine);
    return JO_FMU_OK;
}
API Status fmi2GetIntegerStatus(Component instance, int kind, Integer *value)
{
    (void)kind; (void)value;
    MAY("fmi2GetIntegerStatus", ANY);
    return JO_FMU_DISCARD;
}
API Status fmi2GetBooleanStatus(Component instance, int kind, Boolean *value)
{
    MAY("fmi2GetBooleanStatus", ANY);
    if (kind != TERMINATED || !value) return JO_FMU_DISCARD;
    *value = ((host *)((jo_fmu *)instance)->more)->stopped;
    return JO_FMU_OK;
}
API Status fmi2GetStringStatus(Component instance, int kind, String *value)
{
    (void)kind; (void)value;
    MAY("fmi2GetStringStatus", ANY);
    return JO_FMU_DISCARD;
}
