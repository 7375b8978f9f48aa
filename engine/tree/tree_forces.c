/* tree_forces.c - applied forces of a tree: tau along joint coordinates, external forces f^x on bodies, and the terms that a Rosenbrock
 * method adds to both.
 *
 * ROS2, a W-method with the matrix 1 - g h A (step_rosenbrock.c), has for q' = v, M v' = F with K = -dF/dq, D = -dF/dv the stages
 *   k_q1 = v0 + g h a1,            (M + g h D + (g h)^2 K) a1 = F0 - g h K v0
 *   k_q2 = v1 - 2 g h a1 + g h a2, (M + g h D + (g h)^2 K) a2 = F1 + g h (K (2 v0 - v1 + 4 g h a1) + 2 D a1)
 * where k_q is eliminated from the second row. On a tree K and D are diagonal, of springs and dampers along joint coordinates: they
 * enter D_i = S_i^T U_i of tree.c, the terms on the right enter tau. A gear spring between two joints of one parent, or between the joint of
 * a link and a motor on it, has an element off the diagonal, see jo_link_coupling.
 */
#include "maximal/maximal.h"
#include "force/force.h"
#include "network/network.h"
#include "tree/tree_links.h"

/* positions p and velocities v of the links; orientation, velocity and origin of their bodies; zero body forces fr */
void jo_tree_update_bodies(const jo_model *m, jo_data *d)
{
    const jo_tree *t = &d->tree;
    /* p = p_lambda + l, v = v_lambda + w_lambda x l + S qd, which forward pass 1 leaves out */
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_work *p = &t->link[k->parent + 1];
        jo_link_work *w = &t->link[i + 1];
        w->p = jo_vec_add(p->p, w->l);
        w->v = jo_vec_add(p->v, jo_vec_cross(p->w, w->l));
        if (k->type == JO_LINK_SLIDE) w->v = jo_vec_axpy(w->v, d->u[k->u], w->A[2]);
        if (k->type == JO_LINK_FREE || k->type == JO_LINK_BODY) w->v = jo_vec_load(d->u + k->u);
    }
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_constants *c = &t->constants[i];
        const jo_link_work *w = &t->link[i + 1];
        if (k->body < 0 || k->type == JO_LINK_BODY) continue;
        jo_body_work *b = &d->body[k->body];
        jo_real v[3], om[3];
        /* A_body = A C, by rows */
        for (int j = 0; j < 3; j++) {
            jo_real column[3];
            jo_vec_store(column, jo_vec_mat_mul(w->A, c->C + 3 * j));
            for (int r = 0; r < 3; r++) b->A[3 * r + j] = column[r];
        }
        /* V = A_body^T (v + w x A c), w local = A_body^T w */
        const jo_vec arm = jo_vec_mat_mul(w->A, c->c);
        jo_vec_store(v, jo_vec_add(w->v, jo_vec_cross(w->w, arm)));
        jo_vec_store(om, w->w);
        jo_mul3t(b->V, b->A, v);
        jo_mul3t(b->w, b->A, om);
        for (int j = 0; j < 6; j++) b->fr[j] = jo_same(0.0);
        /* r = p + A c in q, which jo_tree_update_markers reads */
        jo_vec_store(d->q + m->body[k->body].iq, jo_vec_add(w->p, arm));
    }
}

/* r = r_body + A u, A_marker = A A0, local velocity V + w x u and angular velocity of the markers in list */
void jo_tree_update_markers(const jo_model *m, jo_data *d, const int *list, int count)
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

/* value and rate of a joint coordinate, from x and u */
static void read_joint_coordinate(const jo_model *m, jo_data *d, int c)
{
    if (c < 0 || m->coordinate[c].link < 0) return;
    const jo_link *k = &m->link[m->coordinate[c].link];
    d->coordinate[c].value = jo_link_sign(k) * d->x[k->x];
    d->coordinate[c].rate = jo_link_sign(k) * d->u[k->u];
}

/* value and rate of the coordinates of force laws: from x and u for joint coordinates, from the markers for others */
static void update_coordinates(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nforce; i++) {
        read_joint_coordinate(m, d, m->force[i].coordinate);
        read_joint_coordinate(m, d, m->force[i].other);
    }
    for (int i = 0; i < jo_network_count(d); i++)
        for (int k = 0; k < jo_network_at(d, i)->m; k++) read_joint_coordinate(m, d, jo_network_at(d, i)->coordinate[k]);
    for (int i = 0; i < d->tree.ncoordinate; i++) {
        jo_coordinate_value(m, d, d->tree.coordinate[i]);
        jo_coordinate_rate(m, d, d->tree.coordinate[i]);
    }
}

/* link of a force with states that a Rosenbrock method treats implicitly: one along a joint coordinate whose motion is not prescribed; else 0 */
static const jo_link *implicit_link(const jo_model *m, const jo_data *d, const jo_force *f)
{
    const int link = f->state >= 0 && f->coordinate >= 0 ? m->coordinate[f->coordinate].link : -1;
    if (link < 0 || jo_link_is_prescribed(d, &m->link[link]) || jo_released(d, f->release)) return 0;
    return &m->link[link];
}

/* Condensation of the states x' = f(x, s, s') of a force F(x, s, s') out of the W-method, with decay = -df/dx, c = dF/dx / (1 + g h decay):
 *   stiffness K - g h c df/ds, damping D - g h c df/ds', force + g h c (f + sum s_ij k_j) with the rates k_j of the
 * stages before, see step_rosenbrock.c. */
static void eliminate_states(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    jo_tree *t = &d->tree;
    const double gh = stage->gh;
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        const jo_link *k = implicit_link(m, d, f);
        if (!k) continue;
        const jo_real *rate = jo_state_rates(m, d), *before = d->acc + d->nw - m->nstate;
        jo_real K = d->force[i].stiffness, D = d->force[i].damping, F = jo_same(0.0);
        for (int j = f->state; j < f->state + f->states; j++) {
            const jo_slopes_of_state *s = jo_force_slopes(d, j);
            const jo_real c = s->force / (1.0 + gh * s->decay);
            K -= gh * c * s->value;
            D -= gh * c * s->rate;
            F += gh * c * (stage->earlier ? rate[j] - before[j] : rate[j]);
        }
        if (!stage->earlier) {
            t->stiffness[k->u] += K;
            t->damping[k->u] += D;
        }
        t->tau[k->u] += jo_link_sign(k) * F;
    }
}

/* Back substitution for the rates k of these states: (1 + g h decay) k = f + g h (df/ds k_s + df/ds' k_s'), where k_s, k_s' are the rates
 * of s, s' in the stage plus s_ij times the rates in earlier stages; likewise k. */
void jo_tree_implicit_state_rates(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    const double gh = stage->gh;
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        const jo_link *k = implicit_link(m, d, f);
        if (!k) continue;
        const jo_real sign = jo_same(jo_link_sign(k)), *before = d->acc + d->nw - m->nstate;
        jo_real *rate = jo_state_rates(m, d), rate_s = d->u[k->u], a = d->ud[k->u];
        jo_real more = gh * a;
        for (int j = 0; j < stage->earlier; j++) more -= stage->acceleration[j] * gh * stage->accelerations[j][k->u];
        for (int j = 0; j < stage->earlier; j++) more -= stage->rate[j] * stage->rates[j][k->u];
        rate_s += more;
        if (stage->earlier) a -= d->acc[k->u];
        for (int j = f->state; j < f->state + f->states; j++) {
            const jo_slopes_of_state *s = jo_force_slopes(d, j);
            jo_real y = rate[j] + gh * sign * (s->value * rate_s + s->rate * a);
            if (stage->earlier) y += gh * s->decay * before[j];
            rate[j] = y / (1.0 + gh * s->decay);
        }
    }
}

/* whether the gear spring of a motor at link `motor` and a joint at link `to` can be in the matrix, see jo_link_coupling */
static int can_couple(const jo_model *m, const jo_data *d, int motor, int to)
{
    const int on = m->link[motor].parent;
    return !m->nloop && motor > to && d->tree.coupling[motor].to < 0 && (on < 0 || on == to || on == m->link[to].parent);
}

/* K and D of a gear spring; none if it acts on other motions than the free joint coordinates of two links */
static void gather_gear_spring(const jo_model *m, jo_data *d, const jo_force *f, const jo_force_work *w)
{
    jo_tree *t = &d->tree;
    const int to = m->coordinate[f->coordinate].link, motor = m->coordinate[f->other].link;
    if (to < 0 || motor < 0) return;
    const jo_link *q = &m->link[to], *k = &m->link[motor];
    const jo_real share = 1.0 / ((const jo_gear_spring_data *)f->data)->ratio;
    const int q_moves = !jo_link_is_prescribed(d, q), k_moves = !jo_link_is_prescribed(d, k);
    const jo_real none = jo_same(0.0), K = jo_choose(JO_LESS(none, w->stiffness), w->stiffness, none), D = w->damping;
    if (q_moves && k_moves) {
        if (!can_couple(m, d, motor, to)) return;
        const jo_real cross = -jo_link_sign(q) * jo_link_sign(k) * share;
        t->coupling[motor].to = to;
        t->coupling[motor].stiffness = cross * K;
        t->coupling[motor].damping = cross * D;
        t->coupled = 1;
    }
    if (q_moves) { t->stiffness[q->u] += K; t->damping[q->u] += D; }
    if (k_moves) { t->stiffness[k->u] += share * share * K; t->damping[k->u] += share * share * D; }
}

/* K and D of springs and dampers along joint coordinates for the matrix of a Rosenbrock method, in stage 1; later stages use the same matrix */
static void gather_stiffness(const jo_model *m, jo_data *d)
{
    jo_tree *t = &d->tree;
    const jo_real none = jo_same(0.0);
    for (int i = 0; i < m->nu; i++) t->stiffness[i] = t->damping[i] = jo_same(0.0);
    for (int i = 0; i < m->nlink; i++) t->coupling[i].to = -1;
    t->coupled = 0;
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        if (f->type == JO_FORCE_gear_spring && !jo_released(d, f->release)) gather_gear_spring(m, d, f, &d->force[i]);
        const int c = f->type == JO_FORCE_along ? f->coordinate : -1;
        if (c < 0 || m->coordinate[c].link < 0 || jo_released(d, f->release)) continue;
        const jo_along_data *x = (const jo_along_data *)f->data;
        const jo_link *k = &m->link[m->coordinate[c].link];
        const int u = k->u;
        if (jo_link_is_prescribed(d, k)) continue;
        const jo_mask limited = JO_LESS(none, x->limit) & JO_LESS_OR_EQUAL(x->limit, jo_magnitude(d->force[i].y[0]));
        t->stiffness[u] += jo_choose(~limited & JO_LESS(none, x->stiffness), x->stiffness, none);
        t->damping[u] += jo_choose(~limited & JO_LESS(none, x->damping), x->damping, none);
    }
}

/* tau_i += s (K_ij x_j + D_ij y_j) of the elements off the diagonal */
static void add_coupled(const jo_model *m, jo_data *d, double s, const jo_real *x, const jo_real *y)
{
    jo_real *tau = d->tree.tau;
    for (int i = 0; i < m->nlink; i++) {
        const jo_link_coupling *g = &d->tree.coupling[i];
        if (g->to < 0) continue;
        const int k = m->link[i].u, q = m->link[g->to].u;
        tau[q] += s * g->stiffness * x[k];
        tau[k] += s * g->stiffness * x[q];
        if (!y) continue;
        tau[q] += s * g->damping * y[k];
        tau[k] += s * g->damping * y[q];
    }
}

/* right-hand side of a Rosenbrock method: tau -= g h K v in stage 1; in later stages dv and acc contain the arguments of K and D */
static void add_implicit(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    jo_tree *t = &d->tree;
    const double gh = stage->gh;
    if (!stage->earlier) gather_stiffness(m, d);
    if (m->nstate) eliminate_states(m, d, stage);
    if (!stage->earlier) for (int i = 0; i < m->nu; i++) t->tau[i] -= gh * t->stiffness[i] * d->u[i];
    else for (int i = 0; i < m->nu; i++) t->tau[i] += gh * (t->stiffness[i] * d->dv[i] + t->damping[i] * d->acc[i]);
    if (!t->coupled) return;
    if (!stage->earlier) add_coupled(m, d, -gh, d->u, 0);
    else add_coupled(m, d, gh, d->dv, d->acc);
}

/* minus the external force and moment on each body, about the origin of the link: -f^x of the backward pass */
static void set_body_forces(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        jo_link_work *w = &d->tree.link[i + 1];
        if (k->body < 0 || k->type == JO_LINK_BODY) continue;
        const jo_body_work *b = &d->body[k->body];
        jo_real F[3], T[3];
        jo_mul3(F, b->A, b->fr);
        jo_mul3(T, b->A, b->fr + 3);
        const jo_vec f = jo_vec_load(F), t = jo_vec_add(jo_vec_load(T), jo_vec_cross(jo_vec_mat_mul(w->A, d->tree.constants[i].c), f));
        w->joint_f = jo_vec_minus(f);
        w->joint_t = jo_vec_minus(t);
    }
}

/* tau of the joints and f^x of the bodies by all force laws at time, x, u */
int jo_tree_apply_forces(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    const int has_body_forces = d->tree.nbody > 0;
    const jo_lanes none = {0.0};
    if (!stage->set) d->tree.coupled = 0;
    JO_EACH(i, m->nu) JO_STORE(d->tree.tau + i) = none;
    if (!m->nforce && !has_body_forces) {
        if (stage->set)
            for (int i = 0; i < m->nu; i++) d->tree.stiffness[i] = d->tree.damping[i] = jo_same(0.0);
        return JO_OK;
    }
    if (has_body_forces) {
        jo_tree_update_bodies(m, d);
        jo_tree_update_markers(m, d, d->tree.marker, d->tree.nmarker);
    }
    update_coordinates(m, d);
    const int status = jo_apply_forces(m, d, stage);
    if (status != JO_OK) return status;
    if (has_body_forces) set_body_forces(m, d);
    if (stage->set) add_implicit(m, d, stage);
    return JO_OK;
}
