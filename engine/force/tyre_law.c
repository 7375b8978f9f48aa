/* tyre_law.c - slip forces of a tyre.
 *
 * Brush with parabolic pressure (H. B. Pacejka, Tyre and Vehicle Dynamics, 2012, section 3.2), slip s = (sx, sy), slip stiffness
 * (Cx, Cy) = (cx, cy) Fz, half length a = a_0 sqrt(Fz / Fz_0) of the contact patch:
 *   g = |(cx sx, cy sy)| / (3 mu),   F = Fz (cx sx, cy sy) (1 - g + g^2 / 3)  up to g = 1, from there mu Fz in the same direction
 *   Mz = -a Fz cy sy (1 - g)^3 / 3 up to g = 1, from there 0
 *
 * Magic formula (E. Bakker, L. Nyborg, H. B. Pacejka, SAE 870421, 1987; Pacejka, Bakker, Int. Tyre Colloquium, 1991): slip in per cent or degrees,
 * load in kN:  y = D sin(C atan(B z - E (B z - atan(B z)))) + Sv, z = slip + Sh, with coefficients that depend on load and camber. Combined slip by
 * similarity: with s = |(sx, sy)| of the slip relative to that of the largest forces, F = (sx Fx0(s), sy Fy0(s)) / s, and so is the moment. */
#include "maximal/maximal.h"
#include "force/tyre_law.h"

#define JO_DEGREE (JO_PI / 180.0)

static jo_dual arc_tangent(jo_dual a) { return jo_dual_of(jo_arc_tangent(a.v, jo_same(1.0)), a.d / (1.0 + a.v * a.v)); }

/* polynomial c[0] z^2 + c[1] z + c[2] */
static jo_dual square(const jo_real *c, jo_dual z)
{
    return jo_dual_plus(jo_dual_mul(z, jo_dual_plus(jo_dual_times(c[0], z), c[1])), c[2]);
}

/* c[0] z^2 + c[1] z */
static jo_dual rising(const jo_real *c, jo_dual z) { return jo_dual_mul(z, jo_dual_plus(jo_dual_times(c[0], z), c[1])); }

static jo_tyre_force brush(const jo_tyre_data *x, jo_dual along, jo_dual across, jo_dual load)
{
    const jo_dual fx = jo_dual_times(x->cx, along), fy = jo_dual_times(x->cy, across);
    const jo_dual whole = jo_dual_sqrt(jo_dual_add(jo_dual_mul(fx, fx), jo_dual_mul(fy, fy)));
    const jo_dual g = jo_dual_times(1.0 / (3.0 * x->mu), whole), rest = jo_dual_sub(jo_dual_constant(1.0), g);
    jo_tyre_force y;
    jo_dual share;
    y.z = jo_dual_constant(0.0);
    if (JO_RE(g.v) < 1.0) {
        /* a Fz = a_0 Fz sqrt(Fz / Fz_0) */
        const jo_dual half = jo_dual_times(x->half_length, jo_dual_sqrt(jo_dual_times(1.0 / x->load, load)));
        const jo_dual cube = jo_dual_mul(rest, jo_dual_mul(rest, rest));
        share = jo_dual_add(rest, jo_dual_times(jo_same(1.0 / 3.0), jo_dual_mul(g, g)));
        y.z = jo_dual_times(jo_same(-1.0 / 3.0), jo_dual_mul(jo_dual_mul(half, load), jo_dual_mul(fy, cube)));
    } else {
        share = jo_dual_div(jo_dual_of(x->mu, jo_same(0.0)), whole);
    }
    const jo_dual press = jo_dual_mul(share, load);
    y.x = jo_dual_mul(press, fx);
    y.y = jo_dual_mul(press, fy);
    return y;
}

/* Numbers of a curve at a load and camber: D sin(C atan(B z - E (B z - atan(B z)))). */
typedef struct { jo_real C; jo_dual B, D, E, Sh, Sv; } curve;

static jo_dual value_of(const curve *c, jo_dual z)
{
    const jo_dual b = jo_dual_mul(c->B, z);
    const jo_dual bent = jo_dual_sub(b, jo_dual_mul(c->E, jo_dual_sub(b, arc_tangent(b))));
    return jo_dual_mul(c->D, jo_dual_sin(jo_dual_times(c->C, arc_tangent(bent))));
}

/* C D B = (c3 z^2 + c4 z) exp(-c5 z) */
static jo_dual stiffness_of(const jo_real *c, jo_dual load)
{
    return jo_dual_mul(rising(c + 2, load), jo_dual_exp(jo_dual_times(-c[4], load)));
}

/* c: C, a1 .. a8, and for lateral forces a9 .. a13, for moments c9 .. c17; see jo_tyre_data */
static curve longitudinal_curve(const jo_real *c, jo_dual load)
{
    curve y;
    y.C = c[0];
    y.D = rising(c + 1, load);
    y.B = jo_dual_div(stiffness_of(c + 1, load), jo_dual_times(y.C, y.D));
    y.E = square(c + 6, load);
    y.Sh = y.Sv = jo_dual_constant(0.0);
    return y;
}

static curve lateral_curve(const jo_real *c, jo_dual load, jo_dual camber)
{
    curve y;
    const jo_dual lean = jo_dual_size(camber);
    y.C = c[0];
    y.D = rising(c + 1, load);
    const jo_dual stiff = jo_dual_times(c[3], jo_dual_sin(jo_dual_times(c[4], arc_tangent(jo_dual_times(c[5], load)))));
    const jo_dual softer = jo_dual_plus(jo_dual_times(-c[12], lean), jo_same(1.0));
    y.B = jo_dual_div(jo_dual_mul(stiff, softer), jo_dual_times(y.C, y.D));
    y.E = square(c + 6, load);
    y.Sh = jo_dual_times(c[9], camber);
    y.Sv = jo_dual_mul(rising(c + 10, load), camber);
    return y;
}

static curve moment_curve(const jo_real *c, jo_dual load, jo_dual camber)
{
    curve y;
    const jo_dual lean = jo_dual_size(camber);
    y.C = c[0];
    y.D = rising(c + 1, load);
    const jo_dual softer = jo_dual_plus(jo_dual_times(-c[12], lean), jo_same(1.0));
    y.B = jo_dual_div(jo_dual_mul(stiffness_of(c + 1, load), softer), jo_dual_times(y.C, y.D));
    y.E = jo_dual_div(square(c + 6, load), jo_dual_plus(jo_dual_times(-c[13], lean), jo_same(1.0)));
    y.Sh = jo_dual_times(c[9], camber);
    y.Sv = jo_dual_mul(rising(c + 10, load), camber);
    return y;
}

/* own / s y(peak s), s = |(own, other)|: value of a curve as if the tyre slipped in its direction only; own, other: slip over that of the
 * largest force */
static jo_dual combined(const curve *c, jo_dual own, jo_dual other, jo_real peak)
{
    const jo_dual s = jo_dual_sqrt(jo_dual_add(jo_dual_mul(own, own), jo_dual_mul(other, other)));
    if (!(JO_RE(s.v) > 0.0)) return jo_dual_mul(jo_dual_times(c->C * peak, own), jo_dual_mul(c->D, c->B));   /* slope at 0 */
    return jo_dual_mul(jo_dual_div(own, s), value_of(c, jo_dual_times(peak, s)));
}

static jo_tyre_force magic(const jo_tyre_data *x, jo_dual along, jo_dual across, jo_dual load, jo_dual camber)
{
    const jo_dual kilo = jo_dual_times(jo_same(1e-3), load), lean = jo_dual_times(jo_same(1.0 / JO_DEGREE), camber);
    const curve cx = longitudinal_curve(x->longitudinal, kilo), cy = lateral_curve(x->lateral, kilo, lean), cz = moment_curve(x->aligning, kilo, lean);
    const jo_dual angle = jo_dual_times(jo_same(1.0 / JO_DEGREE), arc_tangent(across));
    const jo_dual sx = jo_dual_times(100.0 / x->peak[0], along), sy = jo_dual_times(1.0 / x->peak[1], jo_dual_add(angle, cy.Sh));
    const jo_dual sz = jo_dual_times(1.0 / x->peak[1], jo_dual_add(angle, cz.Sh));
    jo_tyre_force y;
    y.x = combined(&cx, sx, sy, x->peak[0]);
    y.y = jo_dual_add(combined(&cy, sy, sx, x->peak[1]), cy.Sv);
    y.z = jo_dual_add(combined(&cz, sz, sx, x->peak[1]), cz.Sv);
    return y;
}

jo_tyre_force jo_tyre_law(const jo_tyre_data *x, jo_dual along, jo_dual across, jo_dual load, jo_dual camber)
{
    return (int)JO_RE(x->law) == JO_TYRE_BRUSH ? brush(x, along, across, load) : magic(x, along, across, load, camber);
}

jo_real jo_tyre_full_slip(const jo_tyre_data *x)
{
    if ((int)JO_RE(x->law) == JO_TYRE_BRUSH) return 3.0 * x->mu / (JO_RE(x->cx) < JO_RE(x->cy) ? x->cx : x->cy);
    const double along = 1e-2 * JO_RE(x->peak[0]), across = tan(JO_DEGREE * JO_RE(x->peak[1]));
    return jo_same(along > across ? along : across);
}
