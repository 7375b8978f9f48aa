/* tree_conversion.c - maximal coordinates q, v of the caller to joint coordinates x, u of a run and back; end of a step. */
#include "valid.h"
#include "maximal/maximal.h"
#include "tree/tree_links.h"

#define JO_OPEN_POSITION 1e-9   /* position residual of the joints / size of the mechanism, above which q is projected before conversion */
#define JO_OPEN_RATE 1e-7       /* velocity residual / speed of the mechanism, above which v is projected before conversion */

/* joint angles += the multiple of 2 pi that brings them next to the counted angles of their coordinates */
static void match_turns(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->ncoordinate; i++) {
        const jo_coordinate *c = &m->coordinate[i];
        if (c->turn < 0 || c->link < 0) continue;
        const jo_link *k = &m->link[c->link];
        const jo_real near = jo_link_sign(k) * d->turn[c->turn];
        d->x[k->x] += 2.0 * JO_PI * jo_floor((near - d->x[k->x]) / (2.0 * JO_PI) + 0.5);
    }
}

/* project q and v onto the constraints in the norm of the mass matrix if their residuals exceed the limits above */
static int close_gaps(const jo_model *m, jo_data *d)
{
    jo_real open[2];
    jo_residuals(m, d, open);
    const jo_mask closed = JO_LESS_OR_EQUAL(open[0], jo_same(JO_OPEN_POSITION * m->size));
    if (jo_every(closed & JO_LESS_OR_EQUAL(open[1], JO_OPEN_RATE * jo_magnitude(jo_speed(m, d))))) return JO_OK;
    jo_kinematics_used(d);
    const int status = jo_evaluate(m, d, &jo_now);
    if (status == JO_OK) jo_project(m, d, &jo_now);
    return status;
}

/* u = NaN in lanes whose q or v is not finite, even if x and u do not depend on that number; a single machine fails in its projection */
static void spoil_unsound(const jo_model *m, jo_data *d)
{
    jo_real sum = jo_same(0.0);
    for (int i = 0; i < m->nq; i++) sum += jo_magnitude(d->q[i]);
    for (int i = 0; i < m->nv; i++) sum += jo_magnitude(d->v[i]);
    if (m->nu) (void)jo_spoil(d->u, JO_LESS(sum, jo_same(INFINITY)));
}

/* x, u from q, v; x and u of the last run are used if q and v still equal them bit for bit */
int jo_tree_from_maximal(const jo_model *m, jo_data *d)
{
    if (jo_tree_active(d)) return JO_OK;
    if (!jo_tree_matches_maximal_state(m, d)) {
        const int status = close_gaps(m, d);
        if (status != JO_OK) return status;
        jo_tree_read_maximal_state(m, d);
        if (JO_MACHINES > 1) spoil_unsound(m, d);
        jo_tree_hold_sticking(m, d);
        jo_state_read(d);
    }
    match_turns(m, d);
    jo_select_coordinates(m, d, 1);
    jo_positions_moved(d);
    jo_kinematics_used(d);
    return JO_OK;
}

/* q, v from x, u; a and lam as well if the last evaluation belongs to this state */
void jo_tree_to_maximal(const jo_model *m, jo_data *d)
{
    if (!jo_tree_active(d)) return;
    if (jo_accelerations_valid(d)) jo_sync_all(m, d);
    else jo_sync_maximal_state(m, d, JO_SYNC_STATE);
    jo_select_coordinates(m, d, 0);
}

/* counted angles of the coordinates at the accepted state */
void jo_tree_count_turns(const jo_model *m, jo_data *d)
{
    if (!d->tree.counts_joint_angles) jo_update_positions(m, d);
    else if (jo_nmaximal(d)) jo_hybrid_update_bodies(m, d);
    if (!d->tree.counts_joint_angles || jo_nmaximal(d)) jo_count_turns(m, d);
    for (int i = 0; i < m->ncoordinate; i++) {
        const jo_coordinate *c = &m->coordinate[i];
        if (c->turn >= 0 && c->link >= 0) d->turn[c->turn] = jo_link_sign(&m->link[c->link]) * d->x[m->link[c->link].x];
    }
}

/* x, u, ud of drives at the present time, and their increments dq from the start of the step */
void jo_tree_prescribe_end_of_step(const jo_model *m, jo_data *d)
{
    jo_tree_prescribe_motion(m, d);
    for (int i = 0; i < m->nlink; i++)
        if (m->link[i].driven >= 0) d->dq[m->link[i].u] = d->x[m->link[i].x] - d->q0[m->link[i].x];
}

/* accelerations and multipliers at the state q, v of the caller, computed in joint coordinates */
int jo_tree_accelerations(const jo_model *m, jo_data *d)
{
    jo_state_changed(d);
    int status = jo_tree_from_maximal(m, d);
    if (status != JO_OK) return status;
    status = jo_evaluate(m, d, &jo_now);
    jo_accelerations_found(d, status == JO_OK);
    jo_tree_to_maximal(m, d);
    return status;
}
