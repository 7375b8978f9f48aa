/* brief_touches.c - touches that are reported because they are too short for the step. */
#include "contact/contact.h"

enum { COUNT, STEP, COUNTS, LIST };  /* places in jo_contacts.brief */
#define JO_FEW 10.0         /* steps in a touch, below which it is too short for them */

void jo_brief_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    d->contacts.brief = jo_take_doubles(a, m->nyielding ? LIST + JO_BRIEF * JO_MOST_BRIEF : 0);
}

void jo_brief_step(jo_data *d, double step, int counts)
{
    if (!d->contacts.brief) return;
    if (step > 0.0) d->contacts.brief[STEP] = step;
    d->contacts.brief[COUNTS] = counts;
}

void jo_note_touch(const jo_data *d, int state, double duration)
{
    double *brief = d->contacts.brief;
    if (!brief[COUNTS] || duration >= JO_FEW * brief[STEP]) return;
    double *entry = brief + LIST + JO_BRIEF * (int)fmin(brief[COUNT], JO_MOST_BRIEF - 1);
    if (brief[COUNT]++ >= JO_MOST_BRIEF) return;
    entry[0] = JO_RE(d->time[0]);
    entry[1] = state;
    entry[2] = duration;
}

long long jo_data_brief(const jo_data *d, double *out)
{
    const double *brief = d->contacts.brief;
    if (!brief) return 0;
    const int listed = (int)fmin(brief[COUNT], JO_MOST_BRIEF);
    for (int i = 0; i < JO_BRIEF * listed; i++) out[i] = brief[LIST + i];
    return (long long)brief[COUNT];
}
