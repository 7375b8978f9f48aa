/* tree_loop_closure.c - multipliers of the joints that close loops of a tree (Featherstone 2008, chapter 8).
 *
 * Equations, with H the joint-space inertia matrix, J the rows of the loop joints and gamma their velocity terms:
 *   H qdd + C = tau - J^T lambda,  J qdd = -gamma   =>   (J H^-1 J^T) lambda = J H^-1 (tau - C) + gamma
 * Each row of J is a pair of spatial forces on the bodies of its markers. The backward pass of tree.c, applied to these forces, gives at
 * every joint on the path to the root u = S^T f and propagates f - U D^-1 u to the parent. Then
 *   J H^-1 J^T = sum over joints of u^T D^-1 u   and   J H^-1 (tau - C) = sum over joints of u^T D^-1 u_i + bias acceleration of the row
 * with u_i of the backward pass, so that lambda is known before forward pass 2: u_i -= u lambda.
 */
#include "maximal/maximal.h"
#include "tree/tree_links.h"

/* pivot / scale of the row, below which the row depends on others; used if redundant rows are possible */
#define JO_REDUNDANT_PIVOT 1e-9


/* number of rows of the group of loop i if loop i is the last loop of the group, else 0 */
int jo_loop_rows(const jo_model *m, int i)
{
    const jo_loop *k = &m->loop[i];
    return i + 1 < m->nloop && k[1].group == k->group ? 0 : k->row + m->joint[k->joint].nrow;
}

static jo_gram *gram_of(const jo_model *m, jo_data *d, int loop) { return &d->tree.gram[m->loop[loop].group]; }

/* ---- constants ----------------------------------------------------------------------------------- */

/* place and axes of a marker in the link frame: arm = c + C u0, A = C A0; inverse inertia and inverse mass for forces at the marker */
static void set_side_constants(const jo_model *m, const jo_data *d, const jo_loop *loop, jo_loop_side *s)
{
    const jo_marker *k = &m->marker[s->marker];
    s->link = s->reach = -1;
    s->inverse_mass = s->inverse_inertia = 0.0;
    if (k->body < 0) return;
    for (int i = 0; i < m->nlink; i++)
        if (m->link[i].body == k->body) s->link = i;
    for (int i = loop->first; i < loop->first + loop->count; i++)
        if (m->reach[i].link == s->link) s->reach = i;
    const jo_link_constants *c = &d->tree.constants[s->link];
    for (int i = 0; i < 3; i++) {
        s->arm[i] = c->c[i];
        for (int j = 0; j < 3; j++) {
            s->arm[i] += c->C[3 * j + i] * k->u0[j];
            s->A[3 * j + i] = 0.0;
            for (int l = 0; l < 3; l++) s->A[3 * j + i] += c->C[3 * l + i] * k->A0[3 * l + j];
        }
    }
    s->inverse_inertia = 1.0 / JO_RE(c->J[0] + c->J[4] + c->J[8]);
    s->inverse_mass = 1.0 / JO_RE(c->mass) + JO_RE(jo_dot3(s->arm, s->arm)) * s->inverse_inertia;
}

/* constants of all loops: sides, list of markers, and the scale of each row, which is its diagonal of J H^-1 J^T for free bodies */
void jo_loop_setup(const jo_model *m, jo_data *d)
{
    jo_tree *t = &d->tree;
    for (int i = 0; i < m->nloop; i++) {
        const jo_joint *k = &m->joint[m->loop[i].joint];
        jo_loop_work *w = &t->loop[i];
        double *scale = gram_of(m, d, i)->scale + m->loop[i].row;
        w->rows = k->nrow;
        w->uses_axes = k->nperp > 0 || k->nline > 0;
        for (int s = 0; s < k->nside; s++) {
            w->side[s].marker = k->side[s];
            set_side_constants(m, d, &m->loop[i], &w->side[s]);
            if (w->side[s].link >= 0) t->loop_marker[t->nloop_marker++] = k->side[s];
        }
        for (int r = 0; r < k->nrow; r++) scale[r] = 0.0;
        for (int s = 0; s < 2; s++)
            for (int r = 0; r < k->nrow - k->nline; r++)
                scale[r] += k->coincident && r < 3 ? w->side[s].inverse_mass : w->side[s].inverse_inertia;
    }
}

/* ---- rows ------------------------------------------------------------------------------------------ */

/* arm, axes, angular velocity and acceleration for qdd = 0 of the markers of a loop */
static void update_sides(const jo_model *m, jo_data *d, int loop)
{
    jo_loop_work *w = &d->tree.loop[loop];
    for (int i = 0; i < m->joint[m->loop[loop].joint].nside; i++) {
        jo_loop_side *s = &w->side[i];
        jo_motion *y = &w->motion[i];
        if (s->link < 0) {   /* ground: acceleration of the ground frame; other values stay 0 */
            jo_set3(y->a, d->marker[s->marker].a);
            continue;
        }
        const jo_link_work *k = &d->tree.link[s->link + 1];
        s->arm_world = jo_vec_mat_mul(k->A, s->arm);
        /* a = bias_a + bias_alpha x arm + w x (w x arm) */
        const jo_vec a = jo_vec_add(k->bias_a, jo_vec_cross(k->bias_alpha, s->arm_world));
        jo_vec_store(y->a, jo_vec_add(a, jo_vec_cross(k->w, jo_vec_cross(k->w, s->arm_world))));
        if (!w->uses_axes) continue;
        jo_vec_store(y->om, k->w);
        jo_vec_store(y->al, k->bias_alpha);
        jo_real *A = d->marker[s->marker].A, column[3];
        for (int j = 0; j < 3; j++) {
            jo_vec_store(column, jo_vec_mat_mul(k->A, s->A + 3 * j));
            for (int r = 0; r < 3; r++) A[3 * r + j] = column[r];
        }
    }
}

/* rows of J as force f and moment t = g + arm x f about the origin of the link, added up at the reach of the link */
static void set_side_jacobians(const jo_model *m, jo_data *d, int loop)
{
    const jo_loop *l = &m->loop[loop];
    const jo_joint *k = &m->joint[l->joint];
    jo_loop_work *w = &d->tree.loop[loop];
    jo_real f[JO_MAX_ROWS][3], g[JO_MAX_ROWS][3];
    for (int i = l->first; i < l->first + l->count; i++)
        for (int r = 0; r < w->rows; r++) d->tree.reach[i].f[r] = d->tree.reach[i].t[r] = jo_vec_zero();
    for (int i = 0; i < k->nside; i++) {
        jo_loop_side *s = &w->side[i];
        jo_constraint_jacobian(m, d, l->joint, i, f, g);
        if (s->link < 0) continue;
        jo_reach_work *reach = &d->tree.reach[s->reach];
        for (int r = 0; r < w->rows; r++) {
            s->f[r] = jo_vec_load(f[r]);
            s->t[r] = jo_vec_add(jo_vec_load(g[r]), jo_vec_cross(s->arm_world, s->f[r]));
            reach->f[r] = jo_vec_add(reach->f[r], s->f[r]);
            reach->t[r] = jo_vec_add(reach->t[r], s->t[r]);
        }
    }
}

/* scale of rows that are linear in coordinates and have any unit: f.f / mass + t.t / inertia, summed over the sides */
static void set_line_scales(const jo_model *m, jo_data *d, int loop)
{
    const jo_joint *k = &m->joint[m->loop[loop].joint];
    const jo_loop_work *w = &d->tree.loop[loop];
    double *scale = gram_of(m, d, loop)->scale + m->loop[loop].row;
    for (int r = k->nrow - k->nline; r < k->nrow; r++) {
        scale[r] = 0.0;
        for (int i = 0; i < k->nside; i++) {
            const jo_loop_side *s = &w->side[i];
            if (s->link >= 0)
                scale[r] += JO_RE(jo_vec_dot(s->f[r], s->f[r])) / JO_RE(d->tree.constants[s->link].mass)
                          + JO_RE(jo_vec_dot(s->t[r], s->t[r])) * s->inverse_inertia;
        }
    }
}

/* hinge or slide: u = S^T f, D^-1 u; to the parent f - U D^-1 u */
static inline void propagate_one_dof(const jo_link *k, const jo_link_work *w, jo_reach_work *y, jo_reach_work *p, int rows)
{
    const int hinge = k->type == JO_LINK_HINGE;
    for (int r = 0; r < rows; r++) {
        const jo_vec f = y->f[r], t = y->t[r];
        const jo_real u = jo_vec_dot(w->A[2], hinge ? t : f), Dinv_u = u * w->Dinv;
        y->u[0][r] = u;
        y->Dinv_u[0][r] = Dinv_u;
        if (!p) continue;
        p->f[r] = jo_vec_add(p->f[r], jo_vec_axpy(f, -Dinv_u, w->Uf));
        p->t[r] = jo_vec_add(p->t[r], jo_vec_add(t, jo_vec_axpy(jo_vec_cross(w->l, f), -Dinv_u, w->Ut_parent)));
    }
}

/* ball: u = t, D^-1 u = J^-1 t; to the parent f - H J^-1 t. Free link: in addition u = f - H J^-1 t, D^-1 u = M^-1 u */
static inline void propagate_ball(const jo_link *k, const jo_link_work *w, jo_reach_work *y, jo_reach_work *p, int rows)
{
    jo_vec Minv[3];
    if (k->type == JO_LINK_FREE) jo_vec_invert(Minv, w->M);
    for (int r = 0; r < rows; r++) {
        const jo_vec f = jo_vec_sub(y->f[r], jo_vec_mat_mul_lanes(w->HJinv, y->t[r])), turn = jo_vec_mat_mul_lanes(w->Jinv, y->t[r]);
        for (int i = 0; i < 3; i++) {
            y->u[i][r] = jo_vec_element(y->t[r], i);
            y->Dinv_u[i][r] = jo_vec_element(turn, i);
        }
        if (k->type == JO_LINK_FREE) {
            const jo_vec move = jo_vec_mat_mul_lanes(Minv, f);
            for (int i = 0; i < 3; i++) {
                y->u[3 + i][r] = jo_vec_element(f, i);
                y->Dinv_u[3 + i][r] = jo_vec_element(move, i);
            }
        } else if (p) {
            p->f[r] = jo_vec_add(p->f[r], f);
            p->t[r] = jo_vec_add(p->t[r], jo_vec_cross(w->l, f));
        }
    }
}

/* fixed or prescribed joint: f to the parent */
static inline void propagate_rigid(const jo_link_work *w, const jo_reach_work *y, jo_reach_work *p, int rows)
{
    for (int r = 0; p && r < rows; r++) {
        p->f[r] = jo_vec_add(p->f[r], y->f[r]);
        p->t[r] = jo_vec_add(p->t[r], jo_vec_add(y->t[r], jo_vec_cross(w->l, y->f[r])));
    }
}

/* number of degrees of freedom of the joint whose accelerations follow from the forces */
static inline int joint_dofs(const jo_data *d, const jo_link *k)
{
    return jo_link_has_one_dof(d, k) ? 1 : k->type == JO_LINK_BALL ? 3 : k->type == JO_LINK_FREE ? 6 : 0;
}

/* x += (D^-1 u)^T u_i: acceleration of the rows by the force u_i along the joint, without multipliers */
static inline void add_free_acceleration(const jo_data *d, const jo_link *k, const jo_link_work *w, const jo_reach_work *y, jo_real *x)
{
    for (int i = 0; i < joint_dofs(d, k); i++) {
        const jo_real u = jo_link_has_one_dof(d, k) ? w->u : i < 3 ? -jo_vec_element(w->t, i) : -jo_vec_element(w->f, i - 3);
        for (int l = 0; l < 8; l += JO_WIDTH) JO_STORE(x + l) += u * JO_LOAD(y->Dinv_u[i] + l);
    }
}

/* u and D^-1 u of a loop at all links from its markers to the root; right-hand side x without multipliers */
static void propagate_rows(const jo_model *m, jo_data *d, int loop)
{
    const jo_loop *l = &m->loop[loop];
    jo_loop_work *w = &d->tree.loop[loop];
    for (int i = l->first; i < l->first + l->count; i++) {
        const jo_link *k = &m->link[m->reach[i].link];
        const jo_link_work *link = &d->tree.link[m->reach[i].link + 1];
        jo_reach_work *y = &d->tree.reach[i], *p = m->reach[i].next < 0 ? 0 : &d->tree.reach[m->reach[i].next];
        if (jo_link_has_one_dof(d, k)) propagate_one_dof(k, link, y, p, w->rows);
        else if (k->type == JO_LINK_BALL || k->type == JO_LINK_FREE) propagate_ball(k, link, y, p, w->rows);
        else propagate_rigid(link, y, p, w->rows);
        add_free_acceleration(d, k, link, y, w->x);
    }
}

/* ---- multipliers ----------------------------------------------------------------------------------- */

/* S = J H^-1 J^T of each group: += u^T D^-1 u of every pair of reaches at one link */
static void assemble_schur(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < d->tree.ngroup; i++)
        for (int j = 0; j < d->tree.gram[i].n * d->tree.gram[i].ld; j++) d->tree.gram[i].S[j] = 0.0;
    for (int i = 0, one = 0, other; i < m->nmeet; i++) {
        const jo_meet *k = &m->meet[i];
        while (k->one >= m->loop[one].first + m->loop[one].count) one++;
        for (other = one; k->other >= m->loop[other].first + m->loop[other].count;) other++;
        const jo_gram *g = gram_of(m, d, one);
        const jo_reach_work *a = &d->tree.reach[k->one], *b = &d->tree.reach[k->other];
        const int count = joint_dofs(d, &m->link[m->reach[k->one].link]), rows = d->tree.loop[one].rows;
        const int width = jo_padded(d->tree.loop[other].rows);
        jo_real *S = g->S + m->loop[one].row * g->ld + m->loop[other].row;
        for (int n = 0; n < count; n++)
            for (int r = 0; r < rows; r++)
                for (int l = 0; l < width; l += JO_WIDTH) JO_STORE(S + r * g->ld + l) += a->u[n][r] * JO_LOAD(b->Dinv_u[n] + l);
    }
}

/* Factor S of each group. Rows that depend on others, always or in a singular position, get lambda = 0, which does not change the
 * accelerations. */
static int factor_schur(const jo_model *m, jo_data *d)
{
    int status = 1, row = 0, group = 0;
    assemble_schur(m, d);
    for (; group < d->tree.ngroup && status == 1; group++) {
        jo_gram *g = &d->tree.gram[group];
        status = m->redundant > 0 ? jo_gram_factor_pivoted(g, JO_REDUNDANT_PIVOT) : jo_gram_factor(g, &row);
    }
    if (status == 1) return JO_OK;
    /* loop of the vanishing pivot, for the message */
    int loop = 0;
    while (loop + 1 < m->nloop
           && (m->loop[loop].group < group - 1 || (m->loop[loop + 1].group == group - 1 && m->loop[loop + 1].row <= row)))
        loop++;
    const jo_joint *k = &m->joint[m->loop[loop].joint];
    const int body = m->marker[k->side[1]].body;
    d->error_index = status == 0 ? m->loop[loop].joint : body < 0 ? m->marker[k->side[0]].body : body;
    if (status < 0) return JO_NOT_FINITE;
    if (m->redundant < 0) return JO_SINGULAR_JOINT;
    /* singular position: factor again with pivoting, without the dependent rows */
    d->counts.singular++;
    assemble_schur(m, d);
    for (int i = 0; i < d->tree.ngroup; i++)
        if (jo_gram_factor_pivoted(&d->tree.gram[i], JO_REDUNDANT_PIVOT) < 0) return JO_NOT_FINITE;
    return JO_OK;
}

/* lambda = S^-1 x for all groups */
void jo_loop_solve(const jo_model *m, jo_data *d)
{
    for (int i = 0, first = 0; i < m->nloop; i++) {
        if (!jo_loop_rows(m, i)) continue;
        jo_gram *g = gram_of(m, d, i);
        jo_real *x = g->S + (size_t)g->n * (size_t)g->ld;   /* work vector (n) stored behind S */
        for (int j = first; j <= i; j++)
            for (int r = 0; r < d->tree.loop[j].rows; r++) x[m->loop[j].row + r] = d->tree.loop[j].x[r];
        jo_gram_solve(g, x);
        for (int j = first; j <= i; j++)
            for (int r = 0; r < d->tree.loop[j].rows; r++) d->tree.loop[j].x[r] = x[m->loop[j].row + r];
        first = i + 1;
    }
}

/* u_i -= u lambda at each joint on the path, f + f lambda at joints without u_i; joint_f, joint_t of the bodies += f lambda, t lambda */
static void apply_multipliers(const jo_model *m, jo_data *d, int loop)
{
    const jo_loop *l = &m->loop[loop];
    jo_loop_work *w = &d->tree.loop[loop];
    for (int i = l->first; i < l->first + l->count; i++) {
        const jo_link *k = &m->link[m->reach[i].link];
        jo_link_work *link = &d->tree.link[m->reach[i].link + 1];
        const jo_reach_work *y = &d->tree.reach[i];
        if (jo_link_has_one_dof(d, k)) {
            for (int r = 0; r < w->rows; r++) link->u -= w->x[r] * y->u[0][r];
        } else if (k->type == JO_LINK_FREE) {
            for (int r = 0; r < w->rows; r++) {
                const jo_real f[3] = {y->u[3][r], y->u[4][r], y->u[5][r]};
                link->f = jo_vec_axpy(link->f, w->x[r], jo_vec_load(f));
                link->t = jo_vec_axpy(link->t, w->x[r], y->t[r]);
            }
        } else if (k->type != JO_LINK_FIXED) {
            for (int r = 0; r < w->rows; r++) {
                if (k->driven >= 0) link->f = jo_vec_axpy(link->f, w->x[r], y->f[r]);
                link->t = jo_vec_axpy(link->t, w->x[r], y->t[r]);
            }
        }
    }
    for (int i = 0; i < m->joint[l->joint].nside; i++) {
        const jo_loop_side *s = &w->side[i];
        if (s->link < 0) continue;
        jo_link_work *link = &d->tree.link[s->link + 1];
        for (int r = 0; r < w->rows; r++) {
            link->joint_f = jo_vec_axpy(link->joint_f, w->x[r], s->f[r]);
            link->joint_t = jo_vec_axpy(link->joint_t, w->x[r], s->t[r]);
        }
    }
}

/* Baumgarte: right-hand side += 2 alpha c' + beta^2 c with the constraint residuals c, c' */
static void add_baumgarte(const jo_model *m, jo_data *d, const jo_stage *stage, int loop)
{
    const int joint = m->loop[loop].joint;
    jo_loop_work *w = &d->tree.loop[loop];
    jo_constraint_residual(m, d, joint);
    jo_constraint_residual_rate(m, d, joint);
    for (int r = 0; r < w->rows; r++)
        w->x[r] += 2.0 * stage->alpha * d->joint[joint].cdot[r] + stage->beta * stage->beta * d->joint[joint].c[r];
}

/* lambda of all loops after the backward pass: rows J and -gamma, u and D^-1 u, S, lambda, u_i -= u lambda */
int jo_loop_evaluate(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    if (jo_stabilised(stage)) {
        jo_tree_update_bodies(m, d);
        jo_tree_update_markers(m, d, d->tree.loop_marker, d->tree.nloop_marker);
    }
    for (int i = 0; i < m->nloop; i++) {
        update_sides(m, d, i);
        set_side_jacobians(m, d, i);
        if (m->joint[m->loop[i].joint].nline) set_line_scales(m, d, i);
        jo_constraint_acceleration(m, d, m->loop[i].joint, d->tree.loop[i].motion, stage->lead, d->tree.loop[i].x);
        if (jo_stabilised(stage)) add_baumgarte(m, d, stage, i);
        propagate_rows(m, d, i);
    }
    const int status = factor_schur(m, d);
    if (status != JO_OK) return status;
    jo_loop_solve(m, d);
    for (int i = 0; i < m->nloop; i++) apply_multipliers(m, d, i);
    return JO_OK;
}

/* added forces -J^T lambda at the links, for jo_tree_force_response */
void jo_loop_add_multiplier_forces(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nloop; i++) {
        const jo_loop_work *w = &d->tree.loop[i];
        for (int j = 0; j < m->joint[m->loop[i].joint].nside; j++) {
            const jo_loop_side *s = &w->side[j];
            if (s->link < 0) continue;
            jo_link_response *c = &d->tree.response[s->link + 1];
            for (int r = 0; r < w->rows; r++) {
                c->f = jo_vec_axpy(c->f, -w->x[r], s->f[r]);
                c->t = jo_vec_axpy(c->t, -w->x[r], s->t[r]);
            }
        }
    }
}

/* power of drives in joints that close loops, W */
jo_real jo_loop_power(const jo_model *m, const jo_data *d)
{
    jo_real power = 0.0;
    for (int i = 0; i < m->nloop; i++) power += jo_joint_drive(m, d, m->loop[i].joint, d->tree.loop[i].x);
    return power;
}
