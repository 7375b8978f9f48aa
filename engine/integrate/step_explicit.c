/* step_explicit.c - steps of fixed length of RK4 and ROS2, and the common step function of all methods.
 *
 * Positions are q0 o increments [dR, dtheta, dp] from the start of the step; orientations are e o exp(dtheta).
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "beam/beam.h"
#include "tree/tree.h"
#include "integrate/integrate.h"

#define JO_ROS2_GAMMA (1.0 - 0.70710678118654752440)   /* g of ROS2: 1 - 1/sqrt(2), for which the method is L-stable */

/* dq += share rate, dv += share wd of a stage; rate, w = v0 + next wd for the next stage. In stage 0 the rate of the increments is w. */
static void accumulate_stage(jo_data *d, int stage, double share, double next)
{
    jo_real *const rate = d->rate, *const dq = d->dq, *const dv = d->dv, *const w = d->w, *const v0 = d->v0, *const wd = d->wd;
    const int n = d->nw;
    JO_EACH(i, n) {
        const jo_lanes r = stage ? JO_LOAD(rate + i) : JO_LOAD(w + i), a = JO_LOAD(wd + i);
        JO_STORE(dq + i) = stage ? JO_LOAD(dq + i) + share * r : share * r;
        JO_STORE(dv + i) = stage ? JO_LOAD(dv + i) + share * a : share * a;
        JO_STORE(rate + i) = next * r;
        JO_STORE(w + i) = JO_LOAD(v0 + i) + next * a;
    }
}

/* classical Runge-Kutta (Rantalainen 2007, chapter 4) on the index-1 equations */
static int step_rk4(const jo_model *m, jo_data *d, const jo_solver *s, const jo_stage *stage)
{
    static const double node[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    const double h = s->step;
    const jo_real t0 = d->time[0];
    const int baumgarte = jo_stabilised(stage);
    JO_EACH(i, d->ny) JO_STORE(d->q0 + i) = JO_LOAD(d->y + i);
    JO_EACH(i, d->nw) JO_STORE(d->v0 + i) = JO_LOAD(d->w + i);
    for (int k = 0; k < 4; k++) {
        if (k) {
            jo_integrate_positions(m, d, d->rate);
            d->time[0] = t0 + node[k] * h;
        }
        if (k || !jo_accelerations_valid(d) || baumgarte) {
            int status = jo_evaluate(m, d, stage);
            if (status != JO_OK) return status;
            /* evaluation counts must not depend on how a run is split into calls */
            if (!k && jo_valid_before_call(d) && !baumgarte) d->counts.evaluations--;
        }
        jo_first_stage_done(d);
        if (k) jo_position_rate(m, d, d->rate, d->rate);
        accumulate_stage(d, k, weight[k] * h, k < 3 ? node[k + 1] * h : 0.0);
        jo_add_work(&d->work, weight[k] * h, &d->power);
    }
    jo_integrate_positions(m, d, d->dq);
    JO_EACH(i, d->nw) JO_STORE(d->w + i) = JO_LOAD(d->v0 + i) + JO_LOAD(d->dv + i);
    return JO_OK;
}

static void clear_extra_forces(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nbody; i++)
        for (int j = 0; j < m->body[i].n; j++) d->body[i].extra[j] = jo_same(0.0);
}

/* stage 2 of ROS2 with beams, solved for the change from a1, lam1 of stage 1:
 * lag = g h K (2 v0 - x' + 4 g h a1) + 2 g h D a1 - (M^ - M) a1 */
static void second_stage(const jo_model *m, jo_data *d, double gh)
{
    jo_increment_rate(m, d->rate, d->dq, d->v);
    for (int i = 0; i < m->nv; i++) {
        d->rate[i] = gh * (2.0 * d->v0[i] - d->rate[i] + 3.0 * gh * d->acc[i]);
        d->dv[i] = gh * d->acc[i];
    }
    jo_coupled_second(m, d, d->acc, d->rate, d->dv);
}

/* ROS2 (Verwer, Spee, Blom, Hundsdorfer 1999), a W-method of order 2: modal stiffness and damping implicit.
 *   (1 - g h A) k1 = F(y0), (1 - g h A) k2 = F(y0 + h k1) - 2 k1, y1 = y0 + h (3 k1 + k2) / 2
 * With k2' = k2 + 2 k1 the step is y0 + h (k1 + k2') / 2. Beams are treated like modes, with the stiffness of stage 1. */
static int step_ros2(const jo_model *m, jo_data *d, const jo_solver *s, jo_stage *stage)
{
    const double h = s->step, gh = JO_ROS2_GAMMA * h;
    const jo_real t0 = d->time[0];
    jo_use_step(m, d, gh);
    stage->set = 1;
    stage->gh = gh;
    for (int i = 0; i < m->nbody; i++) {   /* stage 1: extra = -g h K p' */
        const jo_body *b = &m->body[i];
        for (int j = 0; j < b->n; j++) d->body[i].extra[j] = -gh * b->K[j] * d->w[d->body[i].modes + j];
    }
    stage->lead = gh;   /* time derivative of the forces: evaluate them g h later */
    int status = jo_evaluate(m, d, stage);
    if (status != JO_OK) {
        clear_extra_forces(m, d);
        return status;
    }
    for (int i = 0; i < d->ny; i++) d->q0[i] = d->y[i];
    for (int i = 0; i < d->nw; i++) {
        d->v0[i] = d->w[i];
        d->acc[i] = d->wd[i];
        d->dq[i] = h * (d->w[i] + gh * d->wd[i]);
        d->w[i] += h * d->wd[i];
    }
    jo_add_step_work(d);
    d->waiting = h;
    d->power0 = d->power;
    d->power0.forces -= d->drive;
    d->work.friction += 0.5 * h * d->power.friction;
    d->work.forces += 0.5 * h * d->drive;   /* errors of the multipliers in stages 1 and 2 cancel */
    jo_integrate_positions(m, d, d->dq);
    d->time[0] = t0 + h;
    for (int i = 0; i < m->nbody; i++) {   /* stage 2: extra = -g h K (p' - 2 g h a1) + 2 g h (K (p0' + g h a1) + D a1) */
        const jo_body *b = &m->body[i];
        const int at = d->body[i].modes;
        const jo_real *a1 = d->acc + at, *v0 = d->v0 + at, *v = d->w + at;
        for (int j = 0; j < b->n; j++)
            d->body[i].extra[j] = gh * (b->K[j] * (2.0 * v0[j] - v[j] + 4.0 * gh * a1[j]) + 2.0 * b->D[j] * a1[j]);
    }
    stage->lead = -gh;
    stage->second = m->nbeam > 0;
    if (stage->second) second_stage(m, d, gh);
    status = jo_evaluate(m, d, stage);
    clear_extra_forces(m, d);
    if (status != JO_OK) return status;
    d->work.friction += 0.5 * h * d->power.friction;
    d->work.forces += 0.5 * h * d->drive;
    jo_position_rate(m, d, d->rate, d->dq);
    for (int i = 0; i < d->nw; i++) {
        d->dq[i] = 0.5 * h * (d->v0[i] + d->rate[i] + gh * (d->wd[i] - d->acc[i]));
        d->w[i] = d->v0[i] + 0.5 * h * (d->acc[i] + d->wd[i]);
    }
    jo_integrate_positions(m, d, d->dq);
    return JO_OK;
}

int jo_one_step(const jo_model *m, jo_data *d, const jo_solver *s)
{
    int status;
    d->counts.steps++;
    jo_stage_forgotten(d);
    d->control.length = s->step;
    if (s->method == JO_DOPRI) status = jo_step_dopri(m, d, s, s->step, JO_COMMON(d->time[0]) + s->step);
    else {
        const int implicit = s->method == JO_ALPHA;
        jo_stage stage = {.alpha = s->alpha, .beta = s->beta};
        status = implicit ? jo_step_alpha(m, d, s) : s->method == JO_RK4 ? step_rk4(m, d, s, &stage) : step_ros2(m, d, s, &stage);
        jo_state_changed(d);
        if (implicit) jo_accelerations_found(d, status == JO_OK && m->redundant <= 0);   /* not lam of least norm */
        else if (status == JO_OK && jo_tree_active(d)) {   /* drives, and projection of the loops */
            jo_tree_prescribe_motion(m, d);
            if (s->projection && jo_nmaximal(d)) jo_project(m, d, &stage);
            else if (s->projection) jo_tree_close_loops(m, d);
        } else if (status == JO_OK && s->projection) jo_project(m, d, &stage);
    }
    if (status != JO_OK) return status;
    if (jo_tree_active(d)) {
        if (m->nturn) jo_tree_count_turns(m, d);
    } else if (m->nturn) {   /* without projection coordinates of the last stage: accurate enough for counting */
        if (!s->projection) jo_coordinates(m, d, m->ncoordinate);
        jo_count_turns(m, d);
    }
    if (m->nbeam) jo_beam_accept(m, d);
    return jo_check(m, d);
}
