/* fatigue.h - damage meters in a model; functions for other rooms. */
#ifndef JO_FATIGUE_H
#define JO_FATIGUE_H

#include "arena.h"
#include "data.h"

/* damage and closed cycles that a meter has counted */
static inline void jo_damage_read(const jo_model *m, const jo_data *d, int meter, jo_real *y)
{
    const jo_meter *r = &m->meter[meter];
    const double *memory = d->memory + r->at;
    y[0] = jo_same(jo_meter_damage(r, memory, r->residue, d->damage.scratch));
    y[1] = jo_same(memory[JO_METER_CLOSED]);
}

/* damage_sensors.c */
void jo_damage_layout(const jo_model *m, jo_data *d, jo_arena *a);
void jo_damage_setup(const jo_model *m, jo_data *d);
int jo_measure(const jo_model *m, jo_data *d);   /* damage meters: samples of the accepted state */

#endif
