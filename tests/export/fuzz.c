/* Calls the functions of a unit of FMI 3.0 in random order with random values: TOKEN COUNT [SEED]. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

typedef void *I;
I fmi3InstantiateCoSimulation(const char *, const char *, const char *, bool, bool, bool, bool, const uint32_t *, size_t, void *,
                              void (*)(void *, int, const char *, const char *), void *);
I fmi3InstantiateModelExchange(const char *, const char *, const char *, bool, bool, void *,
                               void (*)(void *, int, const char *, const char *));
void fmi3FreeInstance(I);
int fmi3EnterInitializationMode(I, bool, double, double, bool, double);
int fmi3ExitInitializationMode(I);
int fmi3EnterEventMode(I);
int fmi3EnterContinuousTimeMode(I);
int fmi3Terminate(I);
int fmi3Reset(I);
int fmi3GetFloat64(I, const uint32_t *, size_t, double *, size_t);
int fmi3SetFloat64(I, const uint32_t *, size_t, const double *, size_t);
int fmi3GetInt32(I, const uint32_t *, size_t, int32_t *, size_t);
int fmi3GetFMUState(I, void **);
int fmi3SetFMUState(I, void *);
int fmi3FreeFMUState(I, void **);
int fmi3SerializedFMUStateSize(I, void *, size_t *);
int fmi3SerializeFMUState(I, void *, uint8_t *, size_t);
int fmi3DeserializeFMUState(I, const uint8_t *, size_t, void **);
int fmi3UpdateDiscreteStates(I, bool *, bool *, bool *, bool *, bool *, double *);
int fmi3CompletedIntegratorStep(I, bool, bool *, bool *);
int fmi3SetTime(I, double);
int fmi3SetContinuousStates(I, const double *, size_t);
int fmi3GetContinuousStates(I, double *, size_t);
int fmi3GetContinuousStateDerivatives(I, double *, size_t);
int fmi3GetNumberOfContinuousStates(I, size_t *);
int fmi3DoStep(I, double, double, bool, bool *, bool *, bool *, double *);

static unsigned long long seed = 1;
static unsigned die(unsigned n)
{
    seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
    return (unsigned)(seed >> 33) % n;
}
static double odd(void)
{
    static const double values[] = {0.0, 1.0, -1.0, 1e-3, 5e-3, 0.5, 1e300, -1e300, 1e-300, 100.0};
    const unsigned k = die(13);
    return k == 10 ? NAN : k == 11 ? INFINITY : k == 12 ? -INFINITY : values[k];
}
static long messages;
static void listen(void *e, int status, const char *category, const char *text)
{
    (void)e; (void)status; (void)category;
    if (text) messages++;
}

int main(int argc, char **argv)
{
    if (argc < 3) return 2;
    const long count = atol(argv[2]);
    if (argc > 3) seed = (unsigned long long)atol(argv[3]);
    static double x[4000], y[4000];
    static uint32_t refs[64];
    long worked = 0, refused = 0, exchanged = 0;
    for (long s = 0; s < count; s++) {
        const int exchange = die(2);
        I f = exchange ? fmi3InstantiateModelExchange("m", argv[1], 0, false, die(2), 0, listen)
                       : fmi3InstantiateCoSimulation("m", argv[1], 0, false, die(2), false, false, 0, 0, 0, listen, 0);
        if (!f && !exchange) return 3;
        if (!f) {   /* the unit does not offer model exchange */
            refused++;
            continue;
        }
        exchanged += exchange;
        void *state = 0;
        bool b[5];
        double t = 0.0;
        size_t n = 0;
        if (die(2)) {   /* half of them begin as they should */
            fmi3EnterInitializationMode(f, false, 0.0, 0.0, false, 0.0);
            fmi3ExitInitializationMode(f);
        }
        for (int c = 0; c < 30; c++) {
            int status = 0;
            const size_t k = die(8);
            for (size_t i = 0; i < k; i++) {
                refs[i] = die(300);
                x[i] = odd();
            }
            fmi3GetNumberOfContinuousStates(f, &n);
            switch (die(22)) {
            case 0: status = fmi3EnterInitializationMode(f, false, 0.0, odd(), die(2), odd()); break;
            case 1: status = fmi3ExitInitializationMode(f); break;
            case 2: status = fmi3EnterEventMode(f); break;
            case 3: status = fmi3EnterContinuousTimeMode(f); break;
            case 4: status = die(5) ? 0 : fmi3Terminate(f); break;
            case 5: status = die(5) ? 0 : fmi3Reset(f); break;
            case 6: status = fmi3GetFloat64(f, refs, k, y, k); break;
            case 7: status = fmi3SetFloat64(f, refs, k, x, k); break;
            case 8: status = fmi3GetInt32(f, refs, k, (int32_t *)y, k); break;
            case 9: status = fmi3GetFMUState(f, &state); break;
            case 10: status = fmi3SetFMUState(f, state); break;
            case 11: status = fmi3FreeFMUState(f, &state); break;
            case 12: {   /* there and back, at times with a damaged byte */
                size_t size = 0;
                if (!state || fmi3SerializedFMUStateSize(f, state, &size)) break;
                uint8_t *bytes = malloc(size);
                status = fmi3SerializeFMUState(f, state, bytes, size);
                if (die(2)) bytes[die((unsigned)size)] ^= (uint8_t)(1 + die(255));
                if (!status) status = fmi3DeserializeFMUState(f, bytes, size, &state);
                free(bytes);
                break;
            }
            case 13: status = fmi3UpdateDiscreteStates(f, b, b + 1, b + 2, b + 3, b + 4, &t); break;
            case 14: status = fmi3CompletedIntegratorStep(f, true, b, b + 1); break;
            case 15: status = fmi3SetTime(f, odd()); break;
            case 16:
                status = fmi3GetContinuousStates(f, x, n);
                if (!status && n && die(2)) x[die((unsigned)n)] = odd();
                if (!status) status = fmi3SetContinuousStates(f, x, n);
                break;
            case 17: status = fmi3GetContinuousStateDerivatives(f, y, n); break;
            case 18: status = fmi3GetContinuousStateDerivatives(f, y, n + 1); break;
            case 19: status = fmi3DoStep(f, odd(), odd(), true, b, b + 1, b + 2, &t); break;
            default:
                if (fmi3GetFloat64(f, (const uint32_t[]){0}, 1, &t, 1)) break;
                status = fmi3DoStep(f, t, 1e-3 * (1 + die(3)), true, b, b + 1, b + 2, &t);
            }
            if (status < 0 || status > 4) return 4;
            if (status) refused++;
            else worked++;
        }
        fmi3FreeFMUState(f, &state);
        free(state);   /* of an instance that is broken */
        fmi3FreeInstance(f);
    }
    printf("%ld sequences, %ld of model exchange, %ld calls worked, %ld were refused, %ld messages\n", count, exchanged, worked,
           refused, messages);
    return worked > 0 && refused > 0 ? 0 : 5;
}
