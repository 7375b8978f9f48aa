/* recover.c - test of stress fields against plain sums, with incomplete tiles and chunks, for sanitizers. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "../jousto.h"

static double chance(unsigned *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return *seed / 4294967296.0 - 0.5;
}

static int wrong;

static void expect(double found, double wanted, double scale, const char *what)
{
    if (fabs(found - wanted) <= 1e-12 * scale) return;
    printf("%s: %.17g, wanted %.17g\n", what, found, wanted);
    wrong = 1;
}

static double tensor(const double *s, const double *v)   /* v . S v */
{
    return s[0] * v[0] * v[0] + s[1] * v[1] * v[1] + s[2] * v[2] * v[2]
           + 2.0 * (s[3] * v[0] * v[1] + s[4] * v[1] * v[2] + s[5] * v[0] * v[2]);
}

int main(void)
{
    enum { NS = 13, K = 5, NT = 131, TILES = (NS + JO_LANES - 1) / JO_LANES };
    unsigned seed = 7u;
    double *S = calloc(TILES * K * 6 * JO_LANES, sizeof *S), *p = malloc(NT * K * sizeof *p);
    double *w = malloc(NT * 6 * sizeof *w), *out = malloc(NT * NS * sizeof *out), *s = malloc(NT * NS * 6 * sizeof *s);
    double *values = malloc(NT * NS * 3 * sizeof *values), *n = malloc(NT * NS * 9 * sizeof *n);
    double low[NS], high[NS];
    long long low_at[NS], high_at[NS];
    if (!S || !p || !w || !out || !s || !values || !n) return 2;

    for (int i = 0; i < NS; i++)
        for (int j = 0; j < K; j++)
            for (int r = 0; r < 6; r++) S[((i / JO_LANES * K + j) * 6 + r) * JO_LANES + i % JO_LANES] = chance(&seed);
    for (int i = 0; i < NT * K; i++) p[i] = chance(&seed);
    for (int i = 0; i < NT * 6; i++) w[i] = chance(&seed);
    for (int t = 0; t < NT; t++)
        for (int i = 0; i < NS; i++)
            for (int r = 0; r < 6; r++) {
                double sum = 0.0;
                for (int j = 0; j < K; j++)
                    sum += S[((i / JO_LANES * K + j) * 6 + r) * JO_LANES + i % JO_LANES] * p[t * K + j];
                s[(t * NS + i) * 6 + r] = sum;
            }

    jo_recover(S, NS, 6, K, p, NT, 0, JO_NORM, 2.0, out, NS);
    for (int i = 0; i < NT * NS; i++) {
        double sum = 0.0;
        for (int r = 0; r < 6; r++) sum += s[6 * i + r] * s[6 * i + r];
        expect(out[i], 2.0 * sqrt(sum), 1.0, "norm");
    }
    jo_recover(S, NS, 6, K, p, NT, w, JO_WEIGHTED, 1.0, out, NS);
    for (int i = 0; i < NT * NS; i++) {
        double sum = 0.0;
        for (int r = 0; r < 6; r++) sum += w[i / NS * 6 + r] * s[6 * i + r];
        expect(out[i], sum, 1.0, "weighted");
    }

    /* the extremes of signed stress, in two pieces */
    for (int i = 0; i < NS; i++) low[i] = INFINITY, high[i] = -INFINITY, low_at[i] = high_at[i] = -1;
    jo_recover_extremes(S, NS, 6, K, p, 70, 0, JO_SIGNED_MISES, 1.0, 0, low, low_at, high, high_at);
    jo_recover_extremes(S, NS, 6, K, p + 70 * K, NT - 70, 0, JO_SIGNED_MISES, 1.0, 70, low, low_at, high, high_at);
    jo_recover(S, NS, 6, K, p, NT, 0, JO_SIGNED_MISES, 1.0, out, NS);
    for (int i = 0; i < NS; i++) {
        double least = INFINITY, most = -INFINITY;
        for (int t = 0; t < NT; t++) {
            least = out[t * NS + i] < least ? out[t * NS + i] : least;
            most = out[t * NS + i] > most ? out[t * NS + i] : most;
        }
        expect(low[i], least, 1.0, "smallest");
        expect(high[i], most, 1.0, "largest");
        expect(out[low_at[i] * NS + i], least, 1.0, "instant of the smallest");
        expect(out[high_at[i] * NS + i], most, 1.0, "instant of the largest");
    }

    /* principal values are the normal stress along their directions, and von Mises stress follows from them */
    jo_principal(s, NT * NS, values, n);
    for (int i = 0; i < NT * NS; i++) {
        const double *x = values + 3 * i;
        for (int j = 0; j < 3; j++) {
            const double v[3] = { n[9 * i + j], n[9 * i + 3 + j], n[9 * i + 6 + j] };
            expect(v[0] * v[0] + v[1] * v[1] + v[2] * v[2], 1.0, 1.0, "length");
            expect(tensor(s + 6 * i, v), x[j], 1.0, "principal value");
        }
        expect(x[0] + x[1] + x[2], s[6 * i] + s[6 * i + 1] + s[6 * i + 2], 1.0, "trace");
        const double mises = sqrt(0.5 * ((x[0] - x[1]) * (x[0] - x[1]) + (x[1] - x[2]) * (x[1] - x[2])
                                         + (x[2] - x[0]) * (x[2] - x[0])));
        expect(out[i], x[0] + x[2] >= 0.0 ? mises : -mises, 1.0, "signed von Mises stress");
    }
    free(S), free(p), free(w), free(out), free(s), free(values), free(n);
    return wrong;
}
