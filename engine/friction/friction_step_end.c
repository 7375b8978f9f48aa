/* friction_step_end.c - transitions of stick-slip frictions at the end of a step, all at once, in a bounded number of evaluations. */
#include "valid.h"
#include "maximal/maximal.h"
#include "friction/friction_law.h"
#include "tree/tree.h"

/* impulses that stop the sticking joints, with the factors of an evaluation in which they are locked */
static void stop(const jo_model *m, jo_data *d)
{
    if (jo_tree_active(d)) jo_tree_stop_sticking(m, d);
    else jo_project(m, d, &jo_now);
}

/* the marked frictions hold the coordinates of the present positions */
static void hold(const jo_model *m, jo_data *d, const int *marked)
{
    if (jo_tree_active(d)) jo_tree_update_slips(m, d);
    else jo_update_positions(m, d);
    for (int i = 0; i < m->nfriction; i++)
        if (marked[i]) jo_friction_hold(m, d, i);
}

/* change of the positions by dq, with the joints closed */
static void move(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < d->ny; i++) d->q0[i] = d->y[i];
    jo_integrate_positions(m, d, d->dq);
    jo_state_changed(d);
}

/* Work in the last `late` s of the step by the change of the powers since `power` and `drive`: the forces of drives change at given speeds, other
 * powers with speeds that change linearly. */
static void add_work(jo_data *d, double late, const jo_work *power, jo_real drive)
{
    d->work.damping += 0.5 * late * (d->power.damping - power->damping);
    d->work.forces += 0.5 * late * (d->power.forces - d->drive - power->forces + drive) + late * (d->drive - drive);
}

/* The marked frictions, whose slip has reversed in the step, stick. Impulses of the frictions, those of forces that would have held the joints
 * since the reversal `late` s ago, stop the slip: the smallest change of the velocities in the metric of the masses. Forces over that time
 * change the velocities linearly, therefore the positions by half of the change of the velocities times `late`. This returns the joint to
 * where its slip reversed, with an error of the third order in the step if one friction reverses, of the second if several do. */
int jo_friction_end_slips(const jo_model *m, jo_data *d, const int *reversed, double late)
{
    const jo_work power = d->power;
    const jo_real drive = d->drive;
    for (int i = 0; i < m->nfriction; i++)
        if (reversed[i]) jo_friction_start_sticking(m, d, i);
    int status = jo_accelerations(m, d);
    if (status != JO_OK) return status;
    for (int i = 0; i < d->nw; i++) d->v0[i] = d->w[i];
    stop(m, d);
    for (int i = 0; i < d->nw; i++) d->dq[i] = 0.5 * late * (d->w[i] - d->v0[i]);
    move(m, d);
    hold(m, d, reversed);
    if (!jo_tree_active(d)) jo_project(m, d, &jo_now);
    status = jo_accelerations(m, d);
    add_work(d, late, &power, drive);
    return status;
}

void jo_friction_keep_accelerations(jo_data *d)
{
    for (int i = 0; i < d->nw; i++) d->dv[i] = d->wd[i];
    d->friction.power = d->power;
    d->friction.drive = d->drive;
}

/* Frictions that slide since `late` s: the change of the accelerations since jo_friction_keep_accelerations has acted for that time. With one
 * friction the errors of velocities and positions are of the second and third order in the step, with several one order less. */
int jo_friction_catch_up(const jo_model *m, jo_data *d, double late)
{
    for (int i = 0; i < d->nw; i++) {
        const jo_real change = late * (d->wd[i] - d->dv[i]);
        d->w[i] += change;
        d->dq[i] = 0.5 * late * change;
    }
    move(m, d);
    if (!jo_tree_active(d)) jo_project(m, d, &jo_now);
    const int status = jo_accelerations(m, d);
    add_work(d, late, &d->friction.power, d->friction.drive);
    return status;
}

/* One pass over all frictions: those above their static limit start to slide, and those that are accelerated against their slip stick again;
 * *changed: whether any did. One evaluation if so. */
int jo_friction_release_all(const jo_model *m, jo_data *d, int *changed)
{
    *changed = 0;
    for (int i = 0; i < m->nfriction; i++) {
        const int slides = jo_friction_overload(m, d, i) > 0.0, back = jo_friction_accelerated_back(m, d, i);
        d->friction.turns[i] = slides - back;
        *changed |= slides || back;
    }
    for (int i = 0; i < m->nfriction && *changed; i++) {
        if (d->friction.turns[i] > 0) jo_friction_start_sliding(m, d, i);
        if (d->friction.turns[i] < 0) jo_friction_start_sticking(m, d, i);
    }
    if (!*changed) return JO_OK;
    if (jo_tree_active(d)) jo_tree_hold_sticking(m, d);   /* locked coordinates exactly at rest */
    return jo_accelerations(m, d);
}

/* whether any friction would change its state in another pass */
int jo_friction_unsettled(const jo_model *m, const jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++)
        if (jo_friction_overload(m, d, i) > 0.0 || jo_friction_accelerated_back(m, d, i)) return 1;
    return 0;
}
