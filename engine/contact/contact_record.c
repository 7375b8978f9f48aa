/* contact_record.c - events of contacts from touch to part, and the energy that contacts lose; both from the ends of accepted steps.
 *
 * Integrals over time (impulse, losses) by parabolas through the last three ends; the largest force likewise, the largest depth by the cubic
 * of depth and rate at two ends. Energy that friction loses: its work less what the bristle stores,
 * which is booked at the end of each step, as its rate is not bounded where a contact parts. See jo_contact_record. */
#include "valid.h"
#include "force/force.h"
#include "contact/contact_record.h"

#define JO_PEAK_ROUNDING 1e-14  /* change of a rate, relative to it, below which a depth has no peak within the step */
#define JO_UNEVEN 10.0     /* length of a step over that of another one up to which both are of one parabola */

/* whether a force can touch */
static int can_touch(const jo_force *f)
{
    const jo_yielding *kind = jo_yielding_of(f);
    return kind && kind->approach;
}

int jo_has_contacts(const jo_model *m)
{
    for (int i = 0; i < m->nforce; i++)
        if (can_touch(&m->force[i])) return 1;
    return 0;
}

int jo_contact_energy_size(const jo_model *m) { return jo_has_contacts(m) ? JO_CONTACT_ENERGIES : 0; }

/* room of the list of events between two calls */
static int room_of(const jo_model *m) { return jo_has_contacts(m) ? JO_LISTED_TOUCHES + 2 * m->nyielding : 0; }

void jo_contact_record_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    jo_contact_record *w = &d->contact_record;
    w->room = room_of(m);
    w->open = jo_take_many(a, jo_has_contacts(m) ? m->nyielding : 0, sizeof *w->open);
    w->list = jo_take_many(a, w->room, sizeof *w->list);
}

/* -- one force --------------------------------------------------------------------------- */

/* sums over the points of a force */
static jo_contact_sample sum_of(const jo_model *m, const jo_data *d, int force, const jo_real *x, int *touching, double *shapes)
{
    jo_touch t[JO_MAX_TOUCHES];
    jo_contact_sample s = {JO_RE(d->time[0]), {0.0}, -INFINITY, 0.0, INFINITY, 0.0, {0.0}};
    const int points = jo_touches_of(m, d, force, x, t, s.sums);
    *touching = 0;
    shapes[0] = shapes[1] = -1.0;
    for (int i = 0; i < points; i++) {
        for (int j = 0; j < 2; j++) shapes[j] = t[i].shapes[j];
        if (!(t[i].phase > 0.0)) continue;
        ++*touching;
        s.rate[0] += t[i].N;
        s.rate[1] += t[i].power[0];
        s.rate[2] += t[i].power[1];
        s.rate[3] += sqrt(t[i].friction[0] * t[i].friction[0] + t[i].friction[1] * t[i].friction[1] + t[i].friction[2] * t[i].friction[2]);
        if (-t[i].gap > s.depth) {
            s.depth = -t[i].gap;
            s.closing = t[i].rate;
        }
        if (t[i].since < s.since) {   /* the first point that touched */
            s.since = t[i].since;
            s.speed = t[i].speed;
        }
    }
    return s;
}

/* Whether a parabola through the last three ends says something: where a step is much longer than the one before, which an event has cut,
 * it extrapolates round-off. */
static int even(const jo_open_contact *w, const jo_contact_sample *now)
{
    if (w->samples < 2) return 0;
    const double h = now->time - w->last[0].time, h0 = w->last[0].time - w->last[1].time;
    return h <= JO_UNEVEN * h0 && h0 <= JO_UNEVEN * h;
}

/* integral of a rate over the last step: parabola through the last three ends, a straight line after a jump */
static double integral(const jo_open_contact *w, const jo_contact_sample *now, int i)
{
    const jo_contact_sample *b = &w->last[0], *a = &w->last[1];
    const double h = now->time - b->time, line = 0.5 * h * (b->rate[i] + now->rate[i]);
    if (!even(w, now)) return line;
    const double h0 = b->time - a->time;
    const double bend = ((now->rate[i] - b->rate[i]) / h - (b->rate[i] - a->rate[i]) / h0) / (h + h0);
    return line - bend * h * h * h / 6.0;
}

/* largest force by a parabola through the last three ends, if that in the middle is the largest */
static void see_force(jo_open_contact *w, const jo_contact_sample *now)
{
    w->event.largest = fmax(w->event.largest, now->rate[0]);
    if (!even(w, now)) return;
    const jo_contact_sample *b = &w->last[0], *a = &w->last[1];
    const double x = a->time - b->time, y = now->time - b->time, u = a->rate[0] - b->rate[0], v = now->rate[0] - b->rate[0];
    const double bend = (v / y - u / x) / (y - x), slope = v / y - bend * y;
    if (u <= 0.0 && v <= 0.0 && bend < 0.0) w->event.largest = fmax(w->event.largest, b->rate[0] - 0.25 * slope * slope / bend);
}

/* largest depth: at a change of the sign of its rate, by the cubic through both ends */
static void see_depth(jo_open_contact *w, const jo_contact_sample *now)
{
    const jo_contact_sample *b = &w->last[0];
    const double h = now->time - b->time;
    w->event.depth = fmax(w->event.depth, now->depth);
    if (!(b->closing > 0.0 && now->closing < 0.0 && h > 0.0)) return;
    /* d(t) = d0 + r0 t + c t^2 + e t^3; its rate r0 + 2 c t + 3 e t^2 vanishes once between the ends */
    const double r0 = b->closing, mean = (now->depth - b->depth) / h, c = (3.0 * mean - 2.0 * r0 - now->closing) / h;
    const double e = (r0 + now->closing - 2.0 * mean) / (h * h), root = sqrt(fmax(0.0, c * c - 3.0 * e * r0)), below = root - c;
    if (!(below > JO_PEAK_ROUNDING * r0 / h)) return;
    const double t = fmin(r0 / below, h);   /* the smaller root, without cancellation */
    w->event.depth = fmax(w->event.depth, b->depth + t * (r0 + t * (c + t * e)));
}

static void begin(const jo_contact_sample *now, jo_open_contact *w, const double *shapes)
{
    static const jo_open_contact empty = {0};
    *w = empty;
    w->touches = 1;
    for (int i = 0; i < 2; i++) w->event.shapes[i] = shapes[i];
    w->event.touch = now->since;
    w->event.approach = now->speed;
    w->event.depth = fmax(0.0, now->depth);
    w->event.largest = now->rate[0];
    for (int i = 0; i < 2; i++) w->stored[i] = now->sums[i];
}

/* entry of the list */
static jo_touched event_of(const jo_data *d, int k, const jo_open_contact *w, double part)
{
    jo_touched y = w->event;
    y.force = jo_yielding_force(d, k);
    y.part = part;
    return y;
}

static void end(jo_data *d, int k)
{
    jo_contact_record *list = &d->contact_record;
    jo_open_contact *w = &list->open[k];
    if (list->count < list->room) list->list[list->count++] = event_of(d, k, w, JO_RE(d->time[0]));
    else list->dropped++;
    w->touches = 0;
}

/* energy that a contact has lost */
static void lose(jo_data *d, jo_open_contact *w, int kind, double energy)
{
    w->event.lost[kind] += energy;
    d->contact_energy[1 + kind] += energy;
}

/* -- ends of steps ------------------------------------------------------------------------- */

/* a contact that touches since before the first step */
static void join(const jo_contact_sample *now, jo_open_contact *w, const double *shapes)
{
    begin(now, w, shapes);
    w->last[0] = *now;
    w->samples = 1;
}

void jo_record_start(const jo_model *m, jo_data *d)
{
    for (int k = 0; k < m->nyielding && d->contact_record.room; k++) {
        jo_open_contact *w = &d->contact_record.open[k];
        const int force = jo_yielding_force(d, k);
        int touching;
        double shapes[2];
        const jo_contact_sample now = sum_of(m, d, force, jo_states(m, d) + m->force[force].state, &touching, shapes);
        const int same = touching && w->touches && w->event.touch == now.since;
        if (!same) w->touches = 0;
        if (touching && !same) join(&now, w, shapes);
        if (!same) continue;
        for (int i = 0; i < 2; i++) w->stored[i] = now.sums[i];
        w->last[0] = now;
        w->samples = 1;
    }
}

void jo_record_step(const jo_model *m, jo_data *d, int k)
{
    jo_open_contact *w = &d->contact_record.open[k];
    const int force = jo_yielding_force(d, k);
    int touching;
    double shapes[2];
    if (jo_released(d, m->force[force].release)) return;
    const jo_contact_sample now = sum_of(m, d, force, jo_states(m, d) + m->force[force].state, &touching, shapes);
    if (!touching) return;
    if (!w->touches) {
        join(&now, w, shapes);
        return;
    }
    const double h = now.time - w->last[0].time;
    if (!(h > 0.0)) return;
    w->event.steps++;
    see_force(w, &now);
    see_depth(w, &now);
    w->event.impulse += integral(w, &now, 0);
    w->event.rubbing += integral(w, &now, 3);
    w->event.rebound = -now.closing;
    lose(d, w, 0, integral(w, &now, 1));
    lose(d, w, 1, integral(w, &now, 2));
    w->stored[0] = now.sums[0];
    w->last[1] = w->last[0];
    w->last[0] = now;
    w->samples = 2;
}

void jo_record_release(const jo_model *m, jo_data *d)
{
    for (int k = 0; k < m->nyielding && d->contact_record.room; k++) {
        jo_open_contact *w = &d->contact_record.open[k];
        if (!w->touches || !jo_released(d, m->force[jo_yielding_force(d, k)].release)) continue;
        for (int i = 0; i < 2; i++) lose(d, w, i, JO_RE(w->stored[i]));
        end(d, k);
    }
}

void jo_record_change(const jo_model *m, jo_data *d, int k, const jo_real *x, int jumped)
{
    jo_open_contact *w = &d->contact_record.open[k];
    const int force = jo_yielding_force(d, k);
    int touching;
    double shapes[2];
    if (jo_released(d, m->force[force].release) || (!jumped && !w->touches)) return;
    const jo_contact_sample now = sum_of(m, d, force, x, &touching, shapes);
    if (!touching && !w->touches) return;
    if (!w->touches) {
        begin(&now, w, shapes);
        w->stored[0] = now.sums[0];   /* its depth is round-off */
        w->stored[1] = jo_same(0.0);
    }
    /* at this instant the normal force stores less, and since the last step the bristle */
    const jo_real lost[2] = {w->stored[0] - now.sums[0], w->stored[1] - now.sums[1]};
    d->work.damping += lost[0];
    d->work.friction += lost[1];
    for (int i = 0; i < 2; i++) {
        lose(d, w, i, JO_RE(lost[i]));
        w->stored[i] = now.sums[i];
    }
    if (!touching) {
        end(d, k);
    } else if (jumped || !w->samples) {
        w->last[0] = now;
        w->samples = 1;
    }
}

jo_real jo_bristles(const jo_model *m, const jo_data *d)
{
    jo_real sum = {0.0};
    for (int k = 0; k < m->nyielding && d->contact_record.room; k++)
        if (d->contact_record.open[k].touches) sum += d->contact_record.open[k].stored[1];
    return sum;
}

/* -- rows within an adaptive step ------------------------------------------------------------ */

void jo_keep_contact_losses(const jo_model *m, jo_data *d)
{
    if (!d->contact_record.room) return;
    for (int i = 0; i < 2; i++) d->contact_record.before[i] = JO_RE(d->contact_energy[1 + i]);
    d->contact_record.bristles = jo_bristles(m, d);
}

void jo_place_contact_losses(jo_data *d, double share, jo_real bristles, double *losses)
{
    if (!d->contact_record.room) return;
    if (share < 1.0) d->work.friction += d->contact_record.bristles - bristles;
    for (int i = 0; i < 2; i++) {
        const double now = JO_RE(d->contact_energy[1 + i]), before = d->contact_record.before[i];
        d->contact_energy[1 + i] = jo_same(share < 1.0 ? before + share * (now - before) : losses[i]);
        losses[i] = now;
    }
}

/* -- for the caller -------------------------------------------------------------------------- */

void jo_contact_list_begins(jo_data *d) { d->contact_record.count = 0; }

int jo_contact_list_has_room(const jo_model *m, const jo_data *d)
{
    return !d->contact_record.room || d->contact_record.count + m->nyielding <= d->contact_record.room;
}

jo_real *jo_data_contact_energy(jo_data *d) { return d->contact_energy; }

const jo_touched *jo_data_touched(const jo_data *d, int *count, long long *dropped)
{
    *count = d->contact_record.count;
    *dropped = d->contact_record.dropped;
    return d->contact_record.list;
}

int jo_data_touching(const jo_model *m, const jo_data *d, jo_touched *out)
{
    int count = 0;
    for (int k = 0; k < m->nyielding && d->contact_record.room; k++)
        if (d->contact_record.open[k].touches) out[count++] = event_of(d, k, &d->contact_record.open[k], NAN);
    return count;
}
