/* watch.c - program that reads strains from a table and prints the outputs of a twin: NAME [samples.csv|-] [memory]
 *
 * The first line contains the names of the columns: time (s), gauges (m/m) and, for a moving frame, its motion; units in brackets are
 * ignored. Cells that are empty or no numbers are missing values. With a memory file the twin continues from it and saves it every thousand
 * samples and at the end, to another file first: after a power failure the old or the new file is complete. */
#include "plant.h"
#if !defined(JO_ONE_FILE) || defined(MAIN)
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LINE = 65536, COLUMNS = 4096, SAVED = 16 * PLANT_BYTES / 8 + 64 };
static union { double number; char bytes[PLANT_BYTES]; } memory;
static unsigned char saved[SAVED];
static char line[LINE];

/* next cell of a line without surrounding blanks; NULL at the end */
static char *cell(char **rest)
{
    char *start = *rest, *end;
    if (!start) return 0;
    char *comma = strchr(start, ',');
    *rest = comma ? comma + 1 : 0;
    end = comma ? comma : start + strlen(start);
    while (*start == ' ' || *start == '\t') start++;
    while (end > start && strchr(" \t\r\n", end[-1])) end--;
    *end = 0;
    return start;
}

static double number(const char *text)
{
    char *end;
    const double x = strtod(text, &end);
    return end == text || *end ? NAN : x;
}

/* column[0] of the time, column[1 ..] of the inputs; returns the number of columns, 0 if one is missing */
static int header(int *column)
{
    int count = 0, found = 1;
    char *rest = line, *name;
    for (int i = 0; i <= PLANT.ninput; i++) column[i] = -1;
    for (; (name = cell(&rest)) && count < COLUMNS; count++) {
        char *unit = strpbrk(name, "[(");
        if (unit) {
            *unit = 0;
            while (unit > name && unit[-1] == ' ') *--unit = 0;
        }
        if (!strcmp(name, "time")) column[0] = count;
        for (int i = 0; i < PLANT.ninput; i++)
            if (!strcmp(name, PLANT.input[i].name)) column[1 + i] = count;
    }
    for (int i = 0; i <= PLANT.ninput; i++)
        if (column[i] < 0) {
            fprintf(stderr, "%s: no column '%s'\n", PLANT.name, i ? PLANT.input[i - 1].name : "time");
            found = 0;
        }
    return found ? count : 0;
}

static int save(const jo_twin *twin, const char *path)
{
    char beside[4096];
    const size_t size = (size_t)jo_twin_saved_bytes(twin);
    if (strlen(path) + 5 > sizeof beside) return 0;
    sprintf(beside, "%s.new", path);
    jo_twin_save(twin, saved);
    FILE *file = fopen(beside, "wb");
    if (!file) return 0;
    int good = fwrite(saved, 1, size, file) == size;
    good = fclose(file) == 0 && good;
    if (good && rename(beside, path)) {
        remove(path);           /* on systems on which rename does not replace files */
        good = !rename(beside, path);
    }
    return good;
}

/* load the memory; returns 1 also if there is no file yet, 0 if the file does not belong to this twin */
static int load(jo_twin *twin, const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file) return 1;
    const size_t size = fread(saved, 1, sizeof saved, file);
    fclose(file);
    return jo_twin_load(twin, saved, (long long)size) == JO_TWIN_OK;
}

/* arguments, twin, header, then a line of outputs for each sample */
int main(int argc, char **argv)
{
    static int column[1 + PLANT_INPUTS];
    static double values[1 + PLANT_INPUTS];
    FILE *file = argc < 2 || !strcmp(argv[1], "-") ? stdin : fopen(argv[1], "r");
    const char *path = argc > 2 ? argv[2] : 0;
    jo_twin *twin = jo_twin_place(&PLANT, memory.bytes, (long long)sizeof memory.bytes);
    if (!twin || jo_twin_saved_bytes(twin) > SAVED) return 2;
    if (!file) {
        fprintf(stderr, "%s: cannot be read\n", argv[1]);
        return 2;
    }
    if (path && !load(twin, path)) {
        fprintf(stderr, "%s: is no whole memory of this twin; remove it to begin anew\n", path);
        return 3;
    }
    const int columns = fgets(line, LINE, file) ? header(column) : 0;
    if (!columns) return 2;
    printf("time (s)");
    for (int i = 0; i < PLANT.noutput; i++) printf(",%s (%s)", PLANT.output[i].name, PLANT.output[i].unit);
    printf("\n");
    long refused = 0, taken = 0;
    while (fgets(line, LINE, file)) {
        char *rest = line, *text;
        int at = 0;
        for (int i = 0; i <= PLANT.ninput; i++) values[i] = NAN;
        for (; (text = cell(&rest)); at++)
            for (int i = 0; i <= PLANT.ninput; i++)
                if (column[i] == at) values[i] = number(text);
        const int status = at == columns ? jo_twin_step(twin, values[0], values + 1, values + 1 + PLANT.ngauge) : JO_TWIN_WRONG;
        if (status > JO_TWIN_BLIND) {
            refused++;
            continue;
        }
        const double *y = jo_twin_outputs(twin);
        printf("%.17g", values[0]);
        for (int i = 0; i < PLANT.noutput; i++) printf(",%.17g", y[i]);
        printf("\n");
        if (path && ++taken % 1000 == 0 && !save(twin, path)) fprintf(stderr, "%s: cannot be written\n", path);
    }
    if (refused) fprintf(stderr, "%s: %ld lines whose time does not go on by whole steps, or that lack numbers, were left out\n", PLANT.name, refused);
    if (path && !save(twin, path)) {
        fprintf(stderr, "%s: cannot be written\n", path);
        return 1;
    }
    return ferror(file) ? 1 : 0;
}
#else
typedef int jo_no_main;   /* a source file must not be empty */
#endif
