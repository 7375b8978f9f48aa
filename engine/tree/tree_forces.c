/* tree_forces.c - forces on a tree: along its joint coordinates, or on the bodies as everywhere. */
#include "maximal/maximal.h"
#include "force/force.h"
#include "tree/tree_links.h"

/* the bodies that forces act on or depend on, as jo_refresh leaves them */
void jo_tree_bodies(const jo_model *m, jo_data *d)
{
    const jo_tree *t = &d->tree;
    for (int i = 0; i < m->nlink; i++) {   /* the rest of jo_tree_kinematics */
        const jo_link *k = &m->link[i];
        const jo_link_work *p = &t->link[k->parent + 1];
        jo_link_work *w = &t->link[i + 1];
        w->p = jo_vec_add(p->p, w->l);
        w->v = jo_vec_add(p->v, jo_vec_cross(p->w, w->l));
        if (k->type == JO_LINK_SLIDE) w->v = jo_vec_with(w->v, t->u[k->u], w->A[2]);
        if (k->type == JO_LINK_FREE || k->type == JO_LINK_BODY) w->v = jo_vec_load(t->u + k->u);
    }
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_constants *c = &t->constants[i];
        const jo_link_work *w = &t->link[i + 1];
        if (k->body < 0 || k->type == JO_LINK_BODY) continue;
        jo_body_work *b = &d->body[k->body];
        jo_real v[3], om[3];
        for (int j = 0; j < 3; j++) {
            jo_real column[3];
            jo_vec_store(column, jo_vec_mix(w->A, c->C + 3 * j));
            for (int r = 0; r < 3; r++) b->A[3 * r + j] = column[r];
        }
        const jo_vec arm = jo_vec_mix(w->A, c->c);
        jo_vec_store(v, jo_vec_add(w->v, jo_vec_cross(w->w, arm)));
        jo_vec_store(om, w->w);
        jo_mul3t(b->V, b->A, v);
        jo_mul3t(b->w, b->A, om);
        for (int j = 0; j < 6; j++) b->fr[j] = 0.0;
        /* the origin, where jo_marker_position looks for it */
        jo_vec_store(d->q + m->body[k->body].iq, jo_vec_add(w->p, arm));
    }
}

void jo_tree_markers(const jo_model *m, jo_data *d, const int *list, int count)
{
    for (int i = 0; i < count; i++) {
        const jo_marker *k = &m->marker[list[i]];
        jo_marker_work *w = &d->marker[list[i]];
        if (k->body < 0) continue;
        const jo_body_work *b = &d->body[k->body];
        jo_set3(w->u, k->u0);
        jo_mul3(w->r, b->A, w->u);
        jo_add3(w->r, d->q + m->body[k->body].iq);
        jo_mul33(w->A, b->A, k->A0);
        jo_cross(w->v, b->w, w->u);
        jo_add3(w->v, b->V);
        jo_set3(w->om, b->w);
    }
}

/* coordinates of forces: those of joints directly, the others by their markers */
static void place_coordinates(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nforce; i++) {
        const int c = m->force[i].coordinate;
        if (c < 0 || m->coordinate[c].link < 0) continue;
        const jo_link *k = &m->link[m->coordinate[c].link];
        d->coordinate[c].value = jo_link_sign(k) * d->tree.x[k->x];
        d->coordinate[c].rate = jo_link_sign(k) * d->tree.u[k->u];
    }
    for (int i = 0; i < d->tree.ncoordinate; i++) {
        jo_coordinate_place(m, d, d->tree.coordinate[i]);
        jo_coordinate_move(m, d, d->tree.coordinate[i]);
    }
}

/* whether ROS2 has a force with states in its matrix: it acts along a joint coordinate that is free to move */
static const jo_link *implicit_link(const jo_model *m, const jo_data *d, const jo_force *f)
{
    const int link = f->state >= 0 && m->nstate ? m->coordinate[f->coordinate].link : -1;
    if (link < 0 || jo_link_given(d, &m->link[link]) || jo_released(d, f->release)) return 0;
    return &m->link[link];
}

/* Forces with states x' = f in the W-method: the rows of the states are eliminated from those of the joints. With c = dF/dx /
 * (1 + g h decay) the stiffness becomes K - g h c df/ds, the damping D - g h c df/ds', and the force has g h c f more, in the
 * second stage g h c (f - 2 k) with the rate k of the first. */
static void eliminate_states(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    jo_tree *t = &d->tree;
    const double gh = stage->gh;
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        const jo_link *k = implicit_link(m, d, f);
        if (!k) continue;
        const jo_real *rate = jo_state_rates(m, d), *first = d->acc + d->nw - m->nstate;
        jo_real K = d->force[i].stiffness, D = d->force[i].damping, F = jo_same(0.0);
        for (int j = f->state; j < f->state + f->states; j++) {
            const jo_slopes_of_state *s = &d->slopes[j];
            const jo_real c = s->force / (1.0 + gh * s->decay);
            K -= gh * c * s->value;
            D -= gh * c * s->rate;
            F += gh * c * (stage->lead >= 0.0 ? rate[j] : rate[j] - 2.0 * first[j]);
        }
        if (stage->lead >= 0.0) {
            t->stiffness[k->u] += K;
            t->damping[k->u] += D;
        }
        t->tau[k->u] += jo_link_sign(k) * F;
    }
}

/* The rates of these states with what the accelerations of the joints add to them: (1 + g h decay) k = f + g h (df/ds s' + df/ds' s'')
 * with the rates s', s'' of the stage, in the second one less twice those of the first. */
void jo_tree_states(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    const double gh = stage->gh;
    const int second = stage->lead < 0.0;
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        const jo_link *k = implicit_link(m, d, f);
        if (!k) continue;
        const jo_real sign = jo_same(jo_link_sign(k)), *first = d->acc + d->nw - m->nstate;
        jo_real *rate = jo_state_rates(m, d), move = d->tree.u[k->u], a = d->tree.ud[k->u];
        if (second) {   /* s' = u1 - 2 g h a1 + g h a2 - 2 (u0 + g h a1) */
            const jo_real a1 = d->acc[k->u];
            move += gh * a - 4.0 * gh * a1 - 2.0 * d->v0[k->u];
            a -= 2.0 * a1;
        } else move += gh * a;
        for (int j = f->state; j < f->state + f->states; j++) {
            const jo_slopes_of_state *s = &d->slopes[j];
            jo_real y = rate[j] + gh * sign * (s->value * move + s->rate * a);
            if (second) y += 2.0 * gh * s->decay * first[j];
            rate[j] = y / (1.0 + gh * s->decay);
        }
    }
}

/* stiffness and damping of springs along joint coordinates, which ROS2 takes in its matrix: that of its first stage serves for both */
static void gather_stiffness(const jo_model *m, jo_data *d)
{
    jo_tree *t = &d->tree;
    for (int i = 0; i < m->nu; i++) t->stiffness[i] = t->damping[i] = 0.0;
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        const int c = f->type == JO_FORCE_along ? f->coordinate : -1;
        if (c < 0 || m->coordinate[c].link < 0 || jo_released(d, f->release)) continue;
        const jo_along_data *x = (const jo_along_data *)f->data;
        const jo_link *k = &m->link[m->coordinate[c].link];
        const int u = k->u;
        if (jo_link_given(d, k)) continue;
        if (JO_RE(x->limit) > 0.0 && fabs(JO_RE(d->force[i].y[0])) >= JO_RE(x->limit)) continue;
        if (JO_RE(x->stiffness) > 0.0) t->stiffness[u] += x->stiffness;
        if (JO_RE(x->damping) > 0.0) t->damping[u] += x->damping;
    }
}

/* what the W-method adds to the forces, see step_ros2 */
static void add_implicit(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    jo_tree *t = &d->tree;
    const double gh = stage->gh;
    if (stage->lead >= 0.0) gather_stiffness(m, d);
    if (m->nstate) eliminate_states(m, d, stage);
    for (int i = 0; i < m->nu; i++) {
        const jo_real K = t->stiffness[i], D = t->damping[i];
        if (stage->lead >= 0.0) t->tau[i] -= gh * K * t->u[i];
        else t->tau[i] += gh * (K * (2.0 * d->v0[i] - t->u[i] + 4.0 * gh * d->acc[i]) + 2.0 * D * d->acc[i]);
    }
}

/* the forces on the bodies are no longer needed by the joints */
static void relieve(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        jo_link_work *w = &d->tree.link[i + 1];
        if (k->body < 0 || k->type == JO_LINK_BODY) continue;
        const jo_body_work *b = &d->body[k->body];
        jo_real F[3], T[3];
        jo_mul3(F, b->A, b->fr);
        jo_mul3(T, b->A, b->fr + 3);
        const jo_vec f = jo_vec_load(F), t = jo_vec_add(jo_vec_load(T), jo_vec_cross(jo_vec_mix(w->A, d->tree.constants[i].c), f));
        w->own_f = jo_vec_scale(-1.0, f);
        w->own_t = jo_vec_scale(-1.0, t);
    }
}

int jo_tree_forces(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    const int pushed = d->tree.nbody > 0;
    const jo_lanes none = {0.0};
    JO_EACH(i, m->nu) JO_STORE(d->tree.tau + i) = none;
    if (!m->nforce && !pushed) {
        if (stage->set)
            for (int i = 0; i < m->nu; i++) d->tree.stiffness[i] = d->tree.damping[i] = 0.0;
        return JO_OK;
    }
    if (pushed) {
        jo_tree_bodies(m, d);
        jo_tree_markers(m, d, d->tree.marker, d->tree.nmarker);
    }
    place_coordinates(m, d);
    const int status = jo_apply_forces(m, d, stage);
    if (status != JO_OK) return status;
    if (pushed) relieve(m, d);
    if (stage->set) add_implicit(m, d, stage);
    return JO_OK;
}
