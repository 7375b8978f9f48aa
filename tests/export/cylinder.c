/* a hydraulic cylinder with trapped oil, FMI 2.0 co-simulation: p' = -B A v / V, F = A p */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    double v, p, F, A, B, V;
    double steps;
} cylinder;
typedef void (*logger)(void *, const char *, int, const char *, const char *, ...);
static logger say;

#ifdef MARK /* a file that shows that code of this library ran */
__attribute__((constructor)) static void mark(void)
{
    FILE *file = fopen(MARK, "w");
    if (file)
        fclose(file);
}
#endif

const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const *names) { return 0; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *place,
                      const void *calls, int visible, int logging)
{
    cylinder *c = calloc(1, sizeof *c);
    say = *(const logger *)calls;
    c->A = 1e-3;
    c->B = 1.5e9;
    c->V = 1e-3;
    printf("noise on the standard output\n");
    fflush(stdout);
    return c;
}
#ifdef MASS
/* an added mass A, with drag B per acceleration squared: F = -A v - B |v| v, v being an acceleration */
static void respond(cylinder *x) { x->F = -x->A * x->v - x->B * (x->v < 0 ? -x->v : x->v) * x->v; }
#endif
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int a, double b, double s, int d, double e) { return 0; }
int fmi2EnterInitializationMode(void *c) { return 0; }
int fmi2ExitInitializationMode(void *c)
{
    cylinder *x = c;
#ifdef MASS
    respond(x);
#else
    x->F = x->A * x->p * 1e5;
#endif
    return 0;
}
int fmi2Terminate(void *c) { return 0; }
int fmi2Reset(void *c) { return 0; }

int fmi2GetReal(void *c, const unsigned *r, size_t n, double *x)
{
    for (size_t i = 0; i < n; i++)
        x[i] = ((double *)c)[r[i]];
    return 0;
}
int fmi2SetReal(void *c, const unsigned *r, size_t n, const double *x)
{
    for (size_t i = 0; i < n; i++)
        ((double *)c)[r[i]] = x[i];
#if defined(MASS) && !defined(LATE)
    respond(c);
#endif
    return 0;
}
int fmi2GetInteger(void *c, const unsigned *r, size_t n, int *x) { return 3; }
int fmi2GetBoolean(void *c, const unsigned *r, size_t n, int *x) { return 3; }
int fmi2GetString(void *c, const unsigned *r, size_t n, const char **x) { return 3; }
int fmi2SetInteger(void *c, const unsigned *r, size_t n, const int *x) { return 3; }
int fmi2SetBoolean(void *c, const unsigned *r, size_t n, const int *x) { return 3; }
int fmi2SetString(void *c, const unsigned *r, size_t n, const char *const *x) { return 3; }

int fmi2GetFMUstate(void *c, void **s)
{
    *s = malloc(sizeof(cylinder));
    memcpy(*s, c, sizeof(cylinder));
    return 0;
}
int fmi2SetFMUstate(void *c, void *s)
{
    memcpy(c, s, sizeof(cylinder));
    return 0;
}
int fmi2FreeFMUstate(void *c, void **s)
{
    free(*s);
    *s = NULL;
    return 0;
}
int fmi2SerializedFMUstateSize(void *c, void *s, size_t *n) { return 3; }
int fmi2SerializeFMUstate(void *c, void *s, char *b, size_t n) { return 3; }
int fmi2DeSerializeFMUstate(void *c, const char *b, size_t n, void **s) { return 3; }
int fmi2GetDirectionalDerivative(void *c, const unsigned *u, size_t a, const unsigned *k, size_t b,
                                 const double *x, double *y) { return 3; }
int fmi2SetRealInputDerivatives(void *c, const unsigned *r, size_t n, const int *o,
                                const double *x) { return 3; }
int fmi2GetRealOutputDerivatives(void *c, const unsigned *r, size_t n, const int *o, double *x)
{
    return 3;
}
int fmi2CancelStep(void *c) { return 3; }
int fmi2GetStatus(void *c, int k, int *x) { return 3; }
int fmi2GetRealStatus(void *c, int k, double *x) { return 3; }
int fmi2GetIntegerStatus(void *c, int k, int *x) { return 3; }
int fmi2GetBooleanStatus(void *c, int k, int *x) { return 3; }
int fmi2GetStringStatus(void *c, int k, const char **x) { return 3; }

int fmi2DoStep(void *c, double t, double h, int keep)
{
    cylinder *x = c;
    x->steps += 1;
#ifdef CRASH
    if (x->steps > 5)
        *(volatile int *)0 = 1;
#endif
#ifdef REFUSE
    if (x->steps > 5) {
        say(NULL, "oil", 3, "error", "the oil boils at %d bar, %s", 42, "100%");
        return 3;
    }
#endif
#ifdef HANG
    while (x->steps > 5)
        *(volatile double *)&x->steps += 1;
#endif
#ifdef NOT_A_NUMBER
    if (x->steps > 5)
        x->p = 0.0 / 0.0 * x->steps;
#endif
#ifdef MASS
    respond(x);
    return 0;
#endif
    x->p -= x->B * x->A / x->V * x->v * h * 1e-5; /* bar */
    x->F = x->A * x->p * 1e5;
    return 0;
}
