/* contact_sensor.c - sums over the points of contacts. Rows of a sensor: what is summed (jo_contact_sum), then
 * FORCES: number of forces, which follow one another from `object` on: force and moment about the origin of b, world; `other` is the first component
 * PAIR: number of slots of the set `object`; in the second row, for each shape its side of the pair, 1 or 2, 0: none: force on the second side
 *   and moment about the origin of its first shape, world
 * PRESSURE: number of forces; coefficients of largest pressure and half axes, which are proportional to a power of the normal force; the power
 * RAIL: number of the patch of the wheel on its rail `object`: see jo_rail_report */
#include "maximal/maximal.h"
#include "force/force.h"
#include "contact/contact.h"

typedef enum { JO_SUM_FORCES = 0, JO_SUM_PAIR = 1, JO_SUM_PRESSURE = 2, JO_SUM_RAIL = 3 } jo_contact_sum;
enum { JO_SUM_WHAT, JO_SUM_COUNT, JO_SUM_COEFFICIENTS, JO_SUM_POWER = JO_SUM_COEFFICIENTS + 3, JO_SUM_ROW };

static int whole(const jo_real *x) { return (int)JO_RE(*x); }

static void sum_forces(const jo_data *d, const jo_sensor *s, jo_real *y)
{
    for (int i = 0; i < whole(s->rows + JO_SUM_COUNT); i++)
        for (int j = 0; j < s->count; j++) y[j] += d->force[s->object + i].y[s->other + j];
}

/* index of the first shape of the second side */
static int first_of(const jo_real *side, int shapes)
{
    int i = 0;
    while (i + 1 < shapes && whole(side + i) != 2) i++;
    return i;
}

static void sum_pair(const jo_model *m, const jo_data *d, const jo_sensor *s, jo_real *y)
{
    const jo_force *set = &m->force[s->object];
    const int shapes = jo_shape_count(set), padded = (shapes > JO_SUM_ROW ? shapes : JO_SUM_ROW) + JO_PAD - 1;
    const jo_real *side = s->rows + padded / JO_PAD * JO_PAD;
    const jo_real *about = d->marker[jo_shape_marker(set, first_of(side, shapes))].r;
    for (int i = 1; i <= whole(s->rows + JO_SUM_COUNT); i++) {
        const jo_force *contact = jo_bound_force(d, set + i);
        int of[2];
        if (!contact) continue;
        jo_slot_shapes(d, set + i, of);
        const int a = whole(side + of[0]), b = whole(side + of[1]);
        const double sign = a == 1 && b == 2 ? 1.0 : a == 2 && b == 1 ? -1.0 : 0.0;
        if (sign == 0.0) continue;
        const jo_real *F = d->force[s->object + i].y;
        jo_real arm[3], moment[3];
        jo_set3(arm, d->marker[contact->b].r);
        jo_sub3(arm, about);
        jo_cross(moment, arm, F);
        jo_axpy3(y, jo_same(sign), F);
        jo_axpy3(y + 3, jo_same(sign), F + 3);
        jo_axpy3(y + 3, jo_same(sign), moment);
    }
}

/* x^p of a number that is not negative; 0 for 0 */
static jo_real power_of(jo_real x, double p)
{
    if (!(JO_RE(x) > 0.0)) return jo_same(0.0);
#ifdef JO_COMPLEX
    return cpow(x, p);
#else
    return pow(x, p);
#endif
}

static void pressure(const jo_model *m, const jo_data *d, const jo_sensor *s, jo_real *y)
{
    const jo_real *row = s->rows;
    jo_touch unused[JO_MAX_TOUCHES];
    jo_real sums[JO_TOUCH_SUMS] = {0.0};
    for (int i = 0; i < whole(row + JO_SUM_COUNT); i++) {
        const int force = s->object + i;
        jo_touches_of(m, d, force, jo_states(m, d) + m->force[force].state, unused, sums);
    }
    const jo_real scale = power_of(sums[2], JO_RE(row[JO_SUM_POWER]));
    for (int j = 0; j < s->count; j++) y[j] = row[JO_SUM_COEFFICIENTS + j] * scale;
}

void jo_contact_sensor(const jo_model *m, const jo_data *d, const jo_sensor *s, jo_real *y)
{
    for (int j = 0; j < s->count; j++) y[j] = jo_same(0.0);
    switch (whole(s->rows + JO_SUM_WHAT)) {
    case JO_SUM_FORCES: sum_forces(d, s, y); break;
    case JO_SUM_PAIR: sum_pair(m, d, s, y); break;
    case JO_SUM_RAIL: jo_rail_report(m, d, &m->force[s->object], whole(s->rows + JO_SUM_COUNT), y); break;
    default: pressure(m, d, s, y); break;
    }
}
