/* split.c - which bodies, markers, coordinates and joints of a model run in trees; the others run by their positions. */
#include "valid.h"

void jo_split_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    jo_split *s = &d->split;
    s->body = jo_take_ints(a, m->nbody);
    s->marker = jo_take_ints(a, m->nmarker);
    s->coordinate = jo_take_ints(a, m->ncoordinate);
    s->joint = jo_take_ints(a, m->njoint);
}

void jo_split_setup(const jo_model *m, jo_data *d)
{
    jo_split *s = &d->split;
    while (s->nmaximal < m->nlink && m->link[s->nmaximal].type == JO_LINK_BODY) s->nmaximal++;
    for (int i = s->nmaximal; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        if (k->body >= 0) s->body[k->body] = 1;
        if (k->joint >= 0) s->joint[k->joint] = 1;
        if (k->drive >= 0) s->joint[k->drive] = 1;
    }
    for (int i = 0; i < m->nmarker; i++) s->marker[i] = m->marker[i].body >= 0 && s->body[m->marker[i].body];
    for (int i = 0; i < m->ncoordinate; i++) s->coordinate[i] = s->marker[m->coordinate[i].a] || s->marker[m->coordinate[i].b];
}
