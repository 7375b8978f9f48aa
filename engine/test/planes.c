/* planes.c - test of the damage on planes, for sanitizers: closed form for alternating tension; additional planes and lines do not reduce the
 * damage. */
#include "jousto.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { NT = 41, PLANES = 3, TURNS = 4 };

static int fail(const char *what)
{
    fprintf(stderr, "planes: %s\n", what);
    return 1;
}

int main(void)
{
    double s[NT * 6] = {0.0}, rows[PLANES * 18] = {0.0}, turn[2 * TURNS], table[2] = {-50.0, 0.0};
    for (int t = 0; t < NT; t++) s[6 * t] = t % 2 ? 120e6 : -120e6;
    rows[0] = 1.0;                        /* across the tension: no shear */
    rows[18] = 0.5, rows[18 + 6] = 0.5;   /* at 45 degrees: half of it normal, half shear */
    rows[36 + 1] = 1.0;                   /* along the tension: no stress */
    for (int j = 0; j < TURNS; j++) turn[2 * j] = cos(0.25 * 3.14159265358979 * j), turn[2 * j + 1] = 0.5;
    jo_meter curve = {0};
    curve.amplitude = 100e6, curve.cycles = 1e6, curve.slope = curve.below = 5.0;
    jo_planes r = {0};
    r.planes = PLANES, r.turns = TURNS, r.rows = rows, r.turn = turn, r.p = 5.0;
    r.table = table, r.points = 2, r.first = 0.0, r.step = log(60e6);
    double *scratch = malloc((6 * NT + 4 + PLANES * TURNS) * sizeof *scratch), damage;
    long long *order = malloc(PLANES * TURNS * sizeof *order), plane;
    if (!scratch || !order) return fail("no memory");
    const double cycles[3] = {20.0, 20.0, 19.0};   /* half, repeat, ignore: 20 up and 20 down */
    for (int residue = 0; residue < 3; residue++) {
        r.residue = residue;
        r.kind = JO_PLANE_NORMAL, r.k = 0.0;
        jo_plane_damage(&r, &curve, s, NT, scratch, order, &damage, &plane);
        double want = cycles[residue] * pow(1.2, 5.0) / 1e6;
        if (fabs(damage - want) > 1e-9 * want || plane != 0) return fail("normal stress");
        r.kind = JO_PLANE_FINDLEY;   /* k = 0: the shear of 45 degrees, an equivalent tension of twice as much */
        jo_plane_damage(&r, &curve, s, NT, scratch, order, &damage, &plane);
        if (fabs(damage - want) > 1e-9 * want || plane != 1) return fail("shear stress");
        r.kind = JO_PLANE_STRAIN, r.p = 0.0;   /* ln(1 / N) is 0 at 60 MPa */
        jo_plane_damage(&r, &curve, s, NT, scratch, order, &damage, &plane);
        if (fabs(damage - cycles[residue]) > 1e-6 * cycles[residue] || plane != 1) return fail("shear strain");
        r.p = 5.0;
        jo_plane_damage(&r, &curve, s, 1, scratch, order, &damage, &plane);
        if (damage != 0.0) return fail("a single sample does damage");
    }
    free(scratch);
    free(order);
    return 0;
}
