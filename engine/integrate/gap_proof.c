/* gap_proof.c - whether a gap may have closed for a moment within a step, between two ends at which it is open. */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"
#include "contact/contact.h"
#include "integrate/integrate.h"

void jo_measure_gaps(const jo_model *m, jo_data *d, int at_end)
{
    for (int k = 0; k < m->nyielding; k++) {
        jo_approach *y = d->events.near + 2 * k + at_end;
        if (!jo_yielding_approach(m, d, k, y)) y->gap = INFINITY;
    }
}

static double speed_of(const jo_approach *x) { return sqrt(x->v[0] * x->v[0] + x->v[1] * x->v[1] + x->v[2] * x->v[2]); }

/* Whether a gap that is open at the ends a and b of a step of length h may have been closed between them: it would have to shrink to 0 and
 * to open again. Its rate is n . v: at most the speed of the point, and at most the rates at the ends plus what acceleration and
 * curvature change; speeds between the ends exceed those at the ends by at most half of their difference. A gap that shrinks all
 * the time has not opened again. The rate is that over one face only as long as nothing beside it can come near. */
static int may_have_closed(const jo_approach *a, const jo_approach *b, double h)
{
    double change = 0.0;
    for (int i = 0; i < 3; i++) change += (b->v[i] - a->v[i]) * (b->v[i] - a->v[i]);
    change = sqrt(change);
    const double speed = fmax(speed_of(a), speed_of(b)) + 0.5 * change;
    const int alone = a->face == b->face && a->clear + b->clear > h * speed;
    const double curved = alone ? fmax(a->curvature, b->curvature) : INFINITY, bent = curved > 0.0 ? speed * speed * curved * h : 0.0;
    const double varies = 0.5 * change + bent;
    if (fmax(a->rate, b->rate) + varies < 0.0) return 0;
    return !(a->gap + b->gap > h * fmin(speed, fmax(0.0, fmax(-a->rate, -b->rate)) + varies));
}

int jo_doubtful_gap(const jo_model *m, const jo_data *d, double h)
{
    for (int k = 0; k < m->nyielding; k++) {
        const jo_approach *a = d->events.near + 2 * k, *b = a + 1;
        if (a->gap < INFINITY && b->gap < INFINITY && b->gap > 0.0 && may_have_closed(a, b, h)) return k;
    }
    return jo_has_contact_sets(d) && !jo_found_all_contacts(m, d, h) ? m->nyielding : -1;
}

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
