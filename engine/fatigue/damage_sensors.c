/* damage_sensors.c - damage meters in a model: they count sensor values of every accepted state. */
#include "maximal/maximal.h"
#include "fatigue/fatigue.h"

/* doubles that the read-out of the largest meter needs */
int jo_damage_scratch(const jo_model *m)
{
    int most = 0;
    for (int i = 0; i < m->nmeter; i++) {
        const int needed = JO_METER + 2 * m->meter[i].depth + 2;
        if (needed > most) most = needed;
    }
    return most;
}

/* the metered sensors alone, `list` has room for them */
void jo_damage_setup(const jo_model *m, jo_data *d, jo_sensor *list)
{
    d->metered = *m;
    d->metered.sensor = list;
    d->metered.nsensor = 0;
    for (int i = 0; i < m->nsensor; i++) {
        const jo_sensor *s = &m->sensor[i];
        int used = 0;
        for (int j = 0; j < m->nmeter; j++) {
            const int output = m->meter[j].output;
            used |= output >= s->offset && output < s->offset + s->count;
        }
        if (!used) continue;
        list[d->metered.nsensor++] = *s;
        d->metered_demanding |= jo_needs_accelerations(s);
    }
}

/* a state is counted once, also when a run goes on from it */
static int is_new(const double *memory, double time)
{
    return memory[JO_METER_SAMPLES] + memory[JO_METER_DROPPED] == 0.0 || memory[JO_METER_TIME] != time;
}

int jo_measure(const jo_model *m, jo_data *d)
{
    const double time = JO_COMMON(d->time[0]);
    int due = 0;
    for (int i = 0; i < m->nmeter; i++) due |= is_new(d->memory + m->meter[i].at, time);
    if (!due) return JO_OK;
    const int status = jo_ready_sensors(m, d, d->metered_demanding);
    if (status != JO_OK) return status;
    jo_sensors(&d->metered, d, d->reading);
    for (int i = 0; i < m->nmeter; i++) {
        const jo_meter *r = &m->meter[i];
        double *memory = d->memory + r->at;
        if (!is_new(memory, time)) continue;
        const double x = r->factor * JO_RE(d->reading[r->output]);
        jo_meter_push(r, memory, &x, 1);
        memory[JO_METER_TIME] = time;
    }
    return JO_OK;
}
