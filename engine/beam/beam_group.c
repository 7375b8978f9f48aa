/* beam_group.c - groups of beam elements of one kind whose forces and tangents are computed side by side. */
#include "newton/newton.h"
#include "beam/beam.h"
#include "beam/beam_lanes.h"

/* terms of an element that differ from 0 */
int jo_beam_kind(const jo_beam_data *x)
{
    int kind = 0;
    for (int i = 0; i < 9; i++) {
        const double unit = i % 4 == 0;
        if (x->B_a[i] != unit || x->B_b[i] != unit) kind |= JO_BEAM_TURNED;
    }
    for (int i = 0; i < 3; i++)
        if (x->u_a[i] != 0.0 || x->u_b[i] != 0.0) kind |= JO_BEAM_OFFSET;
    for (int i = 0; i < 36; i++)
        if (i % 7 && x->C[i] != 0.0) kind |= JO_BEAM_COUPLED;
    if (x->beta != 0.0) kind |= JO_BEAM_DAMPED;
    if (x->helical != 0.0) kind |= JO_BEAM_HELICAL;
    if (x->polar != 0.0) kind |= JO_BEAM_FIBROUS;
    return kind;
}

/* Groups in the order of their first elements; returns their number. group NULL: they are only counted. */
static int distribute(const jo_model *m, jo_beam_group *group, int *place)
{
    int count[JO_BEAM_KINDS] = {0}, open[JO_BEAM_KINDS], groups = 0;
    for (int i = 0; i < m->nbeam; i++) {
        const int kind = jo_beam_kind(m->beam[i].data), lane = count[kind]++ % JO_WIDTH;
        if (lane == 0) open[kind] = groups++;
        if (!group) continue;
        jo_beam_group *w = &group[open[kind]];
        w->kind = kind;
        w->count = lane + 1;
        w->element[lane] = i;
        place[i] = JO_WIDTH * open[kind] + lane;
    }
    return groups;
}

void jo_beam_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    d->beams.count = m->nbeam;
    d->beams.groups = distribute(m, 0, 0);
    d->beams.group = jo_take_many(a, d->beams.groups, sizeof *d->beams.group);
    d->beams.place = jo_take_ints(a, m->nbeam);
    d->beams.bent = jo_take_doubles(a, 2 * m->nbeam);
    d->beams.stiff = jo_take_many(a, 2 * JO_BEAM_KEPT * d->beams.groups, sizeof(jo_lanes));
}

/* inverse of the sum of `count` numbers, 0 if it is 0 */
static jo_real inverse(const jo_real *x, int count)
{
    jo_real sum = 0.0;
    for (int j = 0; j < count; j++) sum += x[j];
    return JO_RE(sum) > 0.0 ? 1.0 / sum : 0.0;
}

/* constants of the element in one lane of a group */
static void set_lane(const jo_model *m, jo_beam_group *w, int lane)
{
    const int real = lane < w->count;   /* lanes without an element repeat the first one */
    if (!real) w->element[lane] = w->element[0];
    const jo_beam *b = &m->beam[w->element[lane]];
    const jo_beam_data *x = b->data;
    const int body[2] = {b->a, b->b};
    jo_real light = 0.0, q[4];
    jo_set_lane(&w->length, lane, x->length);
    jo_set_lane(&w->inverse_length, lane, 1.0 / x->length);
    jo_set_lane(&w->beta, lane, x->beta);
    jo_set_lane(&w->polar, lane, x->polar);
    jo_set_lane(&w->limit, lane, x->limit);
    for (int j = 0; j < 36; j++) jo_set_lane(w->C + j, lane, x->C[j]);
    for (int j = 0; j < 6; j++) jo_set_lane(w->e0 + j, lane, x->e0[j]);
    for (int k = 0; k < 2; k++) {
        const jo_body *end = &m->body[body[k]];
        const jo_real *u = k ? x->u_b : x->u_a, *B = k ? x->B_b : x->B_a;
        w->body[k][lane] = body[k];
        w->iq[k][lane] = end->iq;
        w->iv[k][lane] = end->iv;
        jo_quaternion(q, B);
        for (int j = 0; j < 3; j++) jo_set_lane(w->u[k] + j, lane, u[j]);
        for (int j = 0; j < 9; j++) jo_set_lane(w->B[k] + j, lane, B[j]);
        for (int j = 0; j < 4; j++) jo_set_lane(w->b[k] + j, lane, q[j]);
        light += real ? inverse(end->mass, 1) : 0.0;
        jo_set_lane(w->easy + k, lane, real ? inverse(end->J0, 3) : 0.0);
    }
    jo_set_lane(&w->light, lane, light);
}

/* places of the element in one lane in Newton's matrix */
static void find_blocks(const jo_model *m, jo_data *d, jo_beam_group *w, int lane)
{
    for (int r = 0; r < 2; r++)
        for (int s = 0; s < 2; s++) {
            const jo_block N = jo_newton_find(m, d, w->body[r][lane], w->body[s][lane]);
            w->newton[r][s][lane].at = N.at;
            w->newton[r][s][lane].stride = N.stride;
        }
}

/* groups and their constants */
void jo_beam_setup(const jo_model *m, jo_data *d)
{
    distribute(m, d->beams.group, d->beams.place);
    for (int i = 0; i < d->beams.groups; i++)
        for (int l = 0; l < JO_WIDTH; l++) {
            set_lane(m, &d->beams.group[i], l);
            find_blocks(m, d, &d->beams.group[i], l);
        }
}
