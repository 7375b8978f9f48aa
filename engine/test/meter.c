/* meter.c - test of the damage meter without a model, for sanitizers.
 *
 * Checks: counts and damage of the block of ASTM E1049-85; residue rules; dropped samples; full stacks of growing and decaying vibrations;
 * blocks of many meters; a copy of the memory as a checkpoint; count of a complete history. */
#include "jousto.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(x) \
    do { if (!(x)) { fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #x); exit(1); } } while (0)

enum { DEPTH = 8, SIZE = JO_METER + DEPTH, LONG = 5000, METERS = 70 };

static unsigned seed = 12345;
static double random_number(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (double)(seed >> 8) / (double)(1u << 24) - 0.5;
}

static jo_meter meter(int depth)
{
    jo_meter r;
    memset(&r, 0, sizeof r);
    r.depth = depth;
    r.amplitude = 100e6;
    r.cycles = 1e6;
    r.slope = r.below = 5.0;
    return r;
}

static int near(double a, double b, double relative) { return fabs(a - b) <= relative * fabs(b); }

/* ASTM E1049-85(2017), figure 6: ranges 3 x 0.5, 4 x 1.5, 6 x 0.5, 8 x 1, 9 x 0.5 */
static void astm(void)
{
    const double x[9] = {-2, 1, -3, 5, -1, 3, -4, 4, -2};
    double memory[SIZE] = {0}, scratch[JO_METER + 2 * DEPTH + 2], cycles[10], damage = 0.0;
    jo_meter r = meter(DEPTH);
    CHECK(jo_meter_trace(&r, memory, x, 9, cycles) == 1 && cycles[0] == -1.0 && cycles[1] == 3.0);
    CHECK(memory[JO_METER_POINTS] == 7.0 && memory[JO_METER_SAMPLES] == 9.0 && memory[JO_METER_CLOSED] == 1.0
          && memory[JO_METER_SMALLEST] == -4.0 && memory[JO_METER_LARGEST] == 5.0);
    CHECK(jo_meter_valid(&r, memory));

    double scaled[9];
    for (int i = 0; i < 9; i++) scaled[i] = 25e6 * x[i];
    memset(memory, 0, sizeof memory);
    jo_meter_push(&r, memory, scaled, 9);
    const double table[5][2] = {{3, 0.5}, {4, 1.5}, {6, 0.5}, {8, 1.0}, {9, 0.5}};
    for (int i = 0; i < 5; i++) damage += table[i][1] * pow(12.5 * table[i][0] / 100.0, 5.0) / 1e6;
    CHECK(near(damage, 2.07025146e-6, 1e-8));
    CHECK(near(jo_meter_damage(&r, memory, JO_RESIDUE_HALF, scratch), damage, 1e-14));
    CHECK(near(jo_meter_damage(&r, memory, JO_RESIDUE_IGNORE, scratch), pow(0.5, 5.0) / 1e6, 1e-14));
    /* history repeated, starting at the largest range: cycles 9, 7 and 3, and the 4 closed before */
    double before[SIZE];
    memcpy(before, memory, sizeof before);
    const double repeated = jo_meter_damage(&r, memory, JO_RESIDUE_REPEAT, scratch);
    CHECK(!memcmp(before, memory, sizeof before));
    double twice[SIZE] = {0};
    jo_meter deep = r;
    deep.depth = DEPTH;
    jo_meter_push(&deep, twice, scaled, 9);
    const double once = twice[JO_METER_DAMAGE];
    jo_meter_push(&deep, twice, scaled, 9);
    CHECK(near(once + repeated - once, twice[JO_METER_DAMAGE] - once, 1e-13));
}

/* values that are not finite only increase the count of dropped samples */
static void dropped(void)
{
    double a[SIZE] = {0}, b[SIZE] = {0};
    jo_meter r = meter(DEPTH);
    for (int i = 0; i < 200; i++) {
        const double x = 1e8 * random_number(), bad = i % 3 ? NAN : i % 2 ? INFINITY : -INFINITY;
        jo_meter_push(&r, a, &x, 1);
        if (i % 7 == 0) jo_meter_push(&r, a, &bad, 1);
        jo_meter_push(&r, b, &x, 1);
    }
    CHECK(a[2] == 29.0 && b[2] == 0.0);
    a[2] = 0.0;
    CHECK(!memcmp(a, b, sizeof a));
}

/* growing vibration: exact with half cycles; decaying vibration: forced cycles */
static void full(void)
{
    double small[SIZE] = {0}, large[JO_METER + 500] = {0}, scratch[JO_METER + 1010];
    jo_meter r = meter(DEPTH), deep = meter(500);
    for (int i = 0; i < 400; i++) {
        const double x = (i % 2 ? -1e6 : 1e6) * (i + 1);
        jo_meter_push(&r, small, &x, 1);
        jo_meter_push(&deep, large, &x, 1);
    }
    CHECK(small[JO_METER_SHED] == 392.0 && small[JO_METER_FORCED] == 0.0 && large[JO_METER_SHED] == 0.0);
    CHECK(near(jo_meter_damage(&r, small, JO_RESIDUE_HALF, scratch), jo_meter_damage(&deep, large, JO_RESIDUE_HALF, scratch), 1e-13));
    for (int i = 400; i > 0; i--) {
        const double x = (i % 2 ? -1e6 : 1e6) * i;
        jo_meter_push(&r, small, &x, 1);
        jo_meter_push(&deep, large, &x, 1);
    }
    CHECK(small[6] > 100.0 && small[7] < 8e8 && jo_meter_valid(&r, small));
    const double careful = jo_meter_damage(&r, small, JO_RESIDUE_HALF, scratch);
    const double exact = jo_meter_damage(&deep, large, JO_RESIDUE_HALF, scratch);
    printf("forced %g cycles, damage %.5f of the exact one\n", small[6], careful / exact);
    CHECK(careful >= exact && careful < 1.02 * exact);
    /* classes of which each has at most two points, so that no cycle is forced */
    jo_meter coarse = meter(44);
    double classes[JO_METER + 44] = {0};
    coarse.width = 40e6;
    for (int i = 400; i > 0; i--) {
        const double x = (i % 2 ? -1e6 : 1e6) * i;
        jo_meter_push(&coarse, classes, &x, 1);
    }
    CHECK(classes[6] == 0.0 && classes[0] <= 42.0);
}

/* blocks of many meters in arbitrary pieces, and the complete history */
static void blocks(void)
{
    static double x[LONG * METERS], block[METERS * SIZE], column[LONG], cycles[LONG], traced[LONG], residue[LONG];
    static long long where[LONG], residue_where[LONG];
    jo_meter r = meter(DEPTH);
    for (int j = 0; j < METERS; j++) {
        double walk = 0.0;
        for (int i = 0; i < LONG; i++) {
            walk = 0.97 * walk + 30e6 * random_number();
            x[i * METERS + j] = i % 11 == 4 ? x[(i - 1) * METERS + j] : walk;   /* plateaus */
        }
    }
    jo_meter_block(&r, block, x, 1234, METERS);
    static double checkpoint[METERS * SIZE];
    memcpy(checkpoint, block, sizeof block);
    jo_meter_block(&r, checkpoint, x + 1234 * METERS, LONG - 1234, METERS);
    jo_meter deep = meter(200);
    for (int j = 0; j < METERS; j++) {
        double alone[SIZE] = {0}, memory[JO_METER + 200] = {0};
        for (int i = 0; i < LONG; i++) column[i] = x[i * METERS + j];
        jo_meter_push(&r, alone, column, LONG);
        CHECK(!memcmp(alone, checkpoint + j * SIZE, sizeof alone));
        CHECK(jo_meter_valid(&r, alone));
        long long length;
        const long long closed = jo_rainflow(column, LONG, cycles, where, residue, residue_where, &length);
        CHECK(jo_meter_trace(&deep, memory, column, LONG, traced) == closed);
        CHECK(!memcmp(cycles, traced, (size_t)closed * 2 * sizeof *cycles));
        CHECK((long long)memory[JO_METER_POINTS] == length && !memcmp(memory + JO_METER, residue, (size_t)length * sizeof *residue));
        for (long long k = 0; k < 2 * closed; k++) CHECK(column[where[k]] == cycles[k]);
        for (long long k = 0; k < length; k++) CHECK(column[residue_where[k]] == residue[k]);
    }
}

/* inconsistent memories are detected */
static void spoiled(void)
{
    const double x[5] = {0, 3, -1, 2, 0.5};
    double good[SIZE] = {0}, bad[SIZE];
    jo_meter r = meter(DEPTH);
    CHECK(jo_meter_valid(&r, good));
    jo_meter_push(&r, good, x, 5);
    CHECK(jo_meter_valid(&r, good));
    const int place[6] = {JO_METER_POINTS, JO_METER_POINTS, JO_METER_DAMAGE, JO_METER_CLOSED, JO_METER, JO_METER + 1};
    const double value[6] = {9.0, -1.0, -1.0, NAN, 3.0, NAN};
    for (int i = 0; i < 6; i++) {
        memcpy(bad, good, sizeof bad);
        bad[place[i]] = value[i];
        CHECK(!jo_meter_valid(&r, bad));
    }
}

int main(void)
{
    astm();
    dropped();
    full();
    blocks();
    spoiled();
    return 0;
}
