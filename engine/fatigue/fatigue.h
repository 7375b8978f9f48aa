/* fatigue.h - damage meters, critical planes, recovered stress, health of channels: what other rooms may use. */
#ifndef JO_FATIGUE_H
#define JO_FATIGUE_H

#include "data.h"

/* damage_sensors.c */
void jo_damage_setup(const jo_model *m, jo_data *d, jo_sensor *list);
int jo_damage_scratch(const jo_model *m);
int jo_measure(const jo_model *m, jo_data *d);   /* the present state is accepted: the meters count it */

#endif
