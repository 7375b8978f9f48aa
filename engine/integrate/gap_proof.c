/* gap_proof.c - whether a gap may have closed for a moment within a step, between two ends at which it is open. */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"
#include "contact/contact.h"
#include "integrate/integrate.h"

#define JO_OPEN 1e-12       /* gap over the size of the machine up to which a touch at the end of a step is the one that begins it */
#define JO_PARABOLA 1.5     /* largest distance of a parabola from its chord over that of its mean from the middle of the chord */

void jo_measure_gaps(const jo_model *m, jo_data *d, int at_end, double h)
{
    for (int k = 0; k < m->nyielding; k++) {
        jo_approach *y = d->events.near + 2 * k + at_end;
        y->within = h;
        y->at_end = at_end;
        if (!jo_yielding_approach(m, d, k, y)) y->gap = INFINITY;
    }
    if (!at_end) jo_forget_speeds(m, d);
}

void jo_forget_speeds(const jo_model *m, jo_data *d)
{
    for (int k = 0; k < m->nyielding; k++) {
        const jo_approach *y = d->events.near + 2 * k;
        if (!(y->gap < INFINITY)) continue;
        double *low = jo_seen_speeds(d, y->seen);
        for (int i = 0; i < 3; i++) low[i] = low[3 + i] = y->v[i];
    }
}

/* by how much the velocities of the stages are beyond those at the ends */
static double beyond_ends(const jo_data *d, const jo_approach *a, const jo_approach *b)
{
    const double *low = jo_seen_speeds(d, a->seen), *high = low + 3;
    double sum = 0.0;
    for (int i = 0; i < 3; i++) {
        const double below = fmin(a->v[i], b->v[i]) - low[i], above = high[i] - fmax(a->v[i], b->v[i]), x = fmax(0.0, fmax(below, above));
        sum += x * x;
    }
    return sqrt(sum);
}

static double length3(const double *x) { return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]); }
static double distance3(const double *a, const double *b)
{
    const double x[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    return length3(x);
}

/* A convex function of the place is above its tangents at both ends. Mean velocities from an end on that differ from that at the end by at most
 * `varied` change it by as much, so the gap is above two lines through its ends; the value where these meet. */
static int may_touch_convex(const jo_approach *a, const jo_approach *b, double varied, double h)
{
    const double falls = varied - a->rate, rises = b->highest + varied, end = fmax(b->gap, 0.0);
    if (falls <= 0.0 || rises <= 0.0) return 0;
    const double t = (a->gap - end + rises * h) / (falls + rises);
    return !(a->gap - falls * fmin(fmax(t, 0.0), h) > 0.0);
}

/* Whether a gap that is open at the start a of a step of length h may have been closed before its end b: it would have to shrink to 0 and
 * to open again. Where it is closed at the end, the step ends at this touch, which has to be the first one. Its rate is n . v: at most the
 * speed of the point, and at most the rates at the ends plus what acceleration and curvature change. A gap that shrinks all the time has not
 * opened again. The rate is that over one face only as long as nothing beside it can come near.
 *
 * Velocity within the step: the position is the cubic of Hermite through both ends, so the velocity is a parabola through v_a and v_b, whose
 * distance from the line between them is at most 3/2 |c|, c: mean velocity less (v_a + v_b) / 2. The mean velocity is one of the stages', whose
 * components are between those at the ends up to `beyond`: |c| <= |v_b - v_a| / 2 + beyond. */
static int may_have_closed(const jo_approach *a, const jo_approach *b, double beyond, double h)
{
    const double changed = distance3(a->v, b->v) + distance3(a->spin, b->spin);
    const double varied = JO_PARABOLA * (0.5 * changed + beyond), speed = fmax(jo_approach_speed(a), jo_approach_speed(b)) + varied;
    /* the mean of the parabola from an end to any instant differs from the velocity there by at most the whole change, not half of it */
    if (a->convex && b->convex) return may_touch_convex(a, b, changed + JO_PARABOLA * beyond, h);
    const int alone = a->face == b->face && a->clear + b->clear > h * speed;
    const double curved = alone ? fmax(a->curvature, b->curvature) : INFINITY, bent = curved > 0.0 ? speed * speed * curved * h : 0.0;
    const double varies = varied + bent;
    if (fmax(a->highest, b->highest) + varies < 0.0) return 0;
    return !(a->gap + fmax(b->gap, 0.0) > h * fmin(speed, fmax(0.0, fmax(-a->rate, -b->rate) + varies)));
}

int jo_doubtful_gap(const jo_model *m, const jo_data *d, int located, double h)
{
    for (int k = 0; k < m->nyielding; k++) {
        const jo_approach *a = d->events.near + 2 * k, *b = a + 1;
        if (!(a->gap < INFINITY && b->gap < INFINITY)) continue;
        const int opens = b->gap > 0.0, first = located && a->gap > JO_OPEN * m->size;
        if ((opens || first) && may_have_closed(a, b, beyond_ends(d, a, b), h)) return k;
    }
    return jo_has_contact_sets(d) && !jo_found_all_contacts(m, d, h) ? m->nyielding : -1;
}

int jo_closed_at_end(const jo_model *m, const jo_data *d, int k) { return k < m->nyielding && !(d->events.near[2 * k + 1].gap > 0.0); }

/* Entry of the list: time; force, -1 for the search in the sets; shape that is touched and tip of a slot, else -1. */
void jo_note_doubt(const jo_model *m, jo_data *d, int k)
{
    double *entry = d->events.doubts + JO_DOUBT * d->events.unproven;
    if (d->events.unproven++ >= JO_MOST_DOUBTS) return;
    const jo_force *f = k < m->nyielding ? &m->force[jo_yielding_force(d, k)] : 0;
    const int slot = f && f->type == JO_FORCE_contact_slot;
    entry[0] = JO_RE(d->time[0]);
    entry[1] = f ? jo_yielding_force(d, k) : -1;
    for (int i = 0; i < JO_SLOT_STATES; i++) entry[2 + i] = slot ? JO_RE(jo_slot_states(d, f)[i]) - 1.0 : -1.0;
}

long long jo_data_unproven(const jo_data *d, double *out)
{
    const long long count = d->events.unproven < JO_MOST_DOUBTS ? d->events.unproven : JO_MOST_DOUBTS;
    for (int i = 0; i < JO_DOUBT * count; i++) out[i] = d->events.doubts[i];
    return d->events.unproven;
}

void jo_note_proof(jo_data *d, int halved, int found)
{
    jo_proof *y = &d->events.proof;
    if (found) y->events++;
    else if (halved) y->advanced++;
    else y->at_once++;
    if (halved > y->most) y->most = halved;
}

const jo_proof *jo_data_proof(const jo_data *d) { return &d->events.proof; }
