/* tree_from_maximal.c - into joint coordinates and out of them: the caller knows q and v. */
#include "maximal/maximal.h"
#include "tree/tree_links.h"

#define JO_OPEN 1e-9        /* of the size of the mechanism: joints that are open by more are closed before they are read */
#define JO_OPENING 1e-7     /* of the speed of the mechanism: the same of their velocities */

/* joint angles as many turns on as the counted ones of their coordinates */
static void follow_turns(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->ncoordinate; i++) {
        const jo_coordinate *c = &m->coordinate[i];
        if (c->turn < 0 || c->link < 0) continue;
        const jo_link *k = &m->link[c->link];
        const jo_real near = jo_link_sign(k) * d->turn[c->turn];
        d->tree.x[k->x] += 2.0 * JO_PI * jo_floor((near - d->tree.x[k->x]) / (2.0 * JO_PI) + 0.5);
    }
}

/* Joints that the caller has left open are closed as the method in q and v would: in the metric of the masses. */
static int close_gaps(const jo_model *m, jo_data *d)
{
    jo_real open[2];
    jo_residuals(m, d, open);
    if (JO_RE(open[0]) <= JO_OPEN * m->size && JO_RE(open[1]) <= JO_OPENING * JO_RE(jo_speed(m, d))) return JO_OK;
    d->current = 0;
    const int status = jo_evaluate(m, d, &jo_now);
    if (status == JO_OK) jo_project(m, d, &jo_now);
    return status;
}

int jo_tree_enter(const jo_model *m, jo_data *d)
{
    if (d->tree.on) return JO_OK;
    if (!jo_tree_stands(m, d)) {
        const int status = close_gaps(m, d);
        if (status != JO_OK) return status;
        jo_tree_read(m, d);
        jo_tree_hold(m, d);
        d->fresh = d->control.known = 0;
    }
    follow_turns(m, d);
    jo_use_core(m, d, 1);
    d->tree.mirrored = JO_MIRROR_NONE;
    d->current = 0;
    return JO_OK;
}

void jo_tree_leave(const jo_model *m, jo_data *d)
{
    if (!d->tree.on) return;
    if (d->fresh) jo_mirror_all(m, d);
    else jo_mirror(m, d, JO_MIRROR_STATE);
    jo_use_core(m, d, 0);
}

/* the angles where it stands are accepted */
void jo_tree_count_turns(const jo_model *m, jo_data *d)
{
    if (!d->tree.direct) jo_refresh(m, d);
    else if (d->tree.kept) jo_ports_place(m, d);
    if (!d->tree.direct || d->tree.kept) jo_count_turns(m, d);
    for (int i = 0; i < m->ncoordinate; i++) {
        const jo_coordinate *c = &m->coordinate[i];
        if (c->turn >= 0 && c->link >= 0) d->turn[c->turn] = jo_link_sign(&m->link[c->link]) * d->tree.x[m->link[c->link].x];
    }
}

void jo_tree_drives_end(const jo_model *m, jo_data *d)
{
    jo_tree_drives(m, d);
    for (int i = 0; i < m->nlink; i++)
        if (m->link[i].driven >= 0) d->dq[m->link[i].u] = d->tree.x[m->link[i].x] - d->q0[m->link[i].x];
}

int jo_tree_accelerations(const jo_model *m, jo_data *d)
{
    d->fresh = d->current = 0;
    int status = jo_tree_enter(m, d);
    if (status != JO_OK) return status;
    status = jo_evaluate(m, d, &jo_now);
    d->fresh = status == JO_OK;
    jo_tree_leave(m, d);
    return status;
}
