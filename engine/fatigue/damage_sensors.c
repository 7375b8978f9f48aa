/* damage_sensors.c - damage meters in a model: a sample of each sensor value at every accepted state. */
#include "maximal/maximal.h"
#include "fatigue/fatigue.h"

/* doubles of work space for the residue of the largest meter */
static int scratch_of(const jo_model *m)
{
    int most = 0;
    for (int i = 0; i < m->nmeter; i++) {
        const int needed = JO_METER + 2 * m->meter[i].depth + 2;
        if (needed > most) most = needed;
    }
    return most;
}

void jo_damage_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    d->damage.reading = jo_take_reals(a, m->nmeter ? m->nout : 0);
    d->damage.scratch = jo_take_doubles(a, scratch_of(m));
    d->damage.list = jo_take_many(a, m->nmeter ? m->nsensor : 0, sizeof *d->damage.list);
}

/* model with the metered sensors only */
void jo_damage_setup(const jo_model *m, jo_data *d)
{
    jo_sensor *list = d->damage.list;
    d->damage.metered = *m;
    d->damage.metered.sensor = list;
    d->damage.metered.nsensor = 0;
    for (int i = 0; i < m->nsensor; i++) {
        const jo_sensor *s = &m->sensor[i];
        int used = 0;
        for (int j = 0; j < m->nmeter; j++) {
            const int output = m->meter[j].output;
            used |= output >= s->offset && output < s->offset + s->count;
        }
        if (!used) continue;
        list[d->damage.metered.nsensor++] = *s;
        d->damage.demanding |= jo_needs_accelerations(s);
    }
}

/* whether the state at `time` has not been counted yet, also if a run is continued from it */
static int is_new(const double *memory, double time)
{
    return memory[JO_METER_SAMPLES] + memory[JO_METER_DROPPED] == 0.0 || memory[JO_METER_TIME] != time;
}

/* sample of all meters at the accepted state */
int jo_measure(const jo_model *m, jo_data *d)
{
    const double time = JO_COMMON(d->time[0]);
    int due = 0;
    for (int i = 0; i < m->nmeter; i++) due |= is_new(d->memory + m->meter[i].at, time);
    if (!due) return JO_OK;
    const int status = jo_ready_sensors(m, d, d->damage.demanding);
    if (status != JO_OK) return status;
    jo_sensors(&d->damage.metered, d, d->damage.reading);
    for (int i = 0; i < m->nmeter; i++) {
        const jo_meter *r = &m->meter[i];
        double *memory = d->memory + r->at;
        if (!is_new(memory, time)) continue;
        const double x = r->factor * JO_RE(d->damage.reading[r->output]);
        jo_meter_push(r, memory, &x, 1);
        memory[JO_METER_TIME] = time;
    }
    return JO_OK;
}
