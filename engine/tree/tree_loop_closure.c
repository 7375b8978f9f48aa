/* tree_loop_closure.c - loops of a tree: the rows of joints that no link is.
 *
 * A row acts on the bodies of its markers with a force and a moment. Carried inward as in tree.c they leave at each joint what
 * accelerates it, `rest`; with all of these J M^-1 J^T = sum of rest^T D^-1 rest (Featherstone 2008, chapter 8). The free forces have
 * left theirs already, so that the multipliers are known before accelerations are, and only change what drives the joints.
 */
#include "maximal/maximal.h"
#include "tree/tree_links.h"

#define JO_REPEATS 1e-9     /* of its scale: a pivot below it repeats other rows, where some are known to */

size_t jo_loop_bytes(void) { return sizeof(jo_loop_work); }
size_t jo_reach_bytes(void) { return sizeof(jo_reach_work); }

int jo_loop_rows(const jo_model *m, int i)
{
    const jo_loop *k = &m->loop[i];
    return i + 1 < m->nloop && k[1].group == k->group ? 0 : k->row + m->joint[k->joint].nrow;
}

static jo_gram *gram_of(const jo_model *m, jo_data *d, int loop) { return &d->tree.gram[m->loop[loop].group]; }

/* ---- constants ----------------------------------------------------------------------------------- */

/* a marker in the frame of the link of its body, and how light that is */
static void place_side(const jo_model *m, const jo_data *d, const jo_loop *loop, jo_loop_side *s)
{
    const jo_marker *k = &m->marker[s->marker];
    s->link = s->reach = -1;
    s->moves = s->turns = 0.0;
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
    s->turns = 1.0 / JO_RE(c->J[0] + c->J[4] + c->J[8]);
    s->moves = 1.0 / JO_RE(c->mass) + JO_RE(jo_dot3(s->arm, s->arm)) * s->turns;
}

void jo_loop_setup(const jo_model *m, jo_data *d)
{
    jo_tree *t = &d->tree;
    for (int i = 0; i < m->nloop; i++) {
        const jo_joint *k = &m->joint[m->loop[i].joint];
        jo_loop_work *w = &t->loop[i];
        double *scale = gram_of(m, d, i)->scale + m->loop[i].row;
        w->rows = k->nrow;
        w->oriented = k->nperp > 0 || k->nline > 0;
        for (int s = 0; s < k->nside; s++) {
            w->side[s].marker = k->side[s];
            place_side(m, d, &m->loop[i], &w->side[s]);
            if (w->side[s].link >= 0) t->closing[t->nclosing++] = k->side[s];
        }
        for (int r = 0; r < k->nrow; r++) scale[r] = 0.0;
        for (int s = 0; s < 2; s++)
            for (int r = 0; r < k->nrow - k->nline; r++)
                scale[r] += k->coincident && r < 3 ? w->side[s].moves : w->side[s].turns;
    }
}

/* ---- rows ------------------------------------------------------------------------------------------ */

/* arms, axes and free motions of the markers of a loop */
static void move_sides(const jo_model *m, jo_data *d, int loop)
{
    jo_loop_work *w = &d->tree.loop[loop];
    for (int i = 0; i < m->joint[m->loop[loop].joint].nside; i++) {
        jo_loop_side *s = &w->side[i];
        jo_motion *y = &w->motion[i];
        if (s->link < 0) {   /* the rest stays 0 */
            jo_set3(y->a, d->marker[s->marker].a);
            continue;
        }
        const jo_link_work *k = &d->tree.link[s->link + 1];
        s->at = jo_vec_mix(k->A, s->arm);
        const jo_vec a = jo_vec_add(k->v0, jo_vec_cross(k->w0, s->at));
        jo_vec_store(y->a, jo_vec_add(a, jo_vec_cross(k->w, jo_vec_cross(k->w, s->at))));
        if (!w->oriented) continue;
        jo_vec_store(y->om, k->w);
        jo_vec_store(y->al, k->w0);
        jo_real *A = d->marker[s->marker].A, column[3];
        for (int j = 0; j < 3; j++) {
            jo_vec_store(column, jo_vec_mix(k->A, s->A + 3 * j));
            for (int r = 0; r < 3; r++) A[3 * r + j] = column[r];
        }
    }
}

/* forces and moments of the rows about the origins of the links, which arrive at their reaches */
static void load_sides(const jo_model *m, jo_data *d, int loop)
{
    const jo_loop *l = &m->loop[loop];
    const jo_joint *k = &m->joint[l->joint];
    jo_loop_work *w = &d->tree.loop[loop];
    jo_real f[JO_MAX_ROWS][3], g[JO_MAX_ROWS][3];
    for (int i = l->first; i < l->first + l->count; i++)
        for (int r = 0; r < w->rows; r++) d->tree.reach[i].f[r] = d->tree.reach[i].t[r] = jo_vec_zero();
    for (int i = 0; i < k->nside; i++) {
        jo_loop_side *s = &w->side[i];
        jo_joint_slopes(m, d, l->joint, i, f, g);
        if (s->link < 0) continue;
        jo_reach_work *reach = &d->tree.reach[s->reach];
        for (int r = 0; r < w->rows; r++) {
            s->f[r] = jo_vec_load(f[r]);
            s->t[r] = jo_vec_add(jo_vec_load(g[r]), jo_vec_cross(s->at, s->f[r]));
            reach->f[r] = jo_vec_add(reach->f[r], s->f[r]);
            reach->t[r] = jo_vec_add(reach->t[r], s->t[r]);
        }
    }
}

/* scale of the rows of lines, whose units may be any */
static void scale_lines(const jo_model *m, jo_data *d, int loop)
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
                          + JO_RE(jo_vec_dot(s->t[r], s->t[r])) * s->turns;
        }
    }
}

/* what of a hinge or a slide the rows drive, and what it passes on */
static inline void through_one(const jo_link *k, const jo_link_work *w, jo_reach_work *y, jo_reach_work *p, int rows)
{
    const int hinge = k->type == JO_LINK_HINGE;
    for (int r = 0; r < rows; r++) {
        const jo_vec f = y->f[r], t = y->t[r];
        const jo_real rest = jo_vec_dot(w->A[2], hinge ? t : f), share = rest * w->r;
        y->rest[0][r] = rest;
        y->share[0][r] = share;
        if (!p) continue;
        p->f[r] = jo_vec_add(p->f[r], jo_vec_with(f, -share, w->Uf));
        p->t[r] = jo_vec_add(p->t[r], jo_vec_add(t, jo_vec_with(jo_vec_cross(w->l, f), -share, w->Us)));
    }
}

/* the same of a ball, or of what is free */
static inline void through_ball(const jo_link *k, const jo_link_work *w, jo_reach_work *y, jo_reach_work *p, int rows)
{
    jo_vec inverse[3];
    if (k->type == JO_LINK_FREE) jo_vec_invert(inverse, w->M);
    for (int r = 0; r < rows; r++) {
        const jo_vec f = jo_vec_less(y->f[r], jo_vec_times(w->X, y->t[r])), turn = jo_vec_times(w->inverse, y->t[r]);
        for (int i = 0; i < 3; i++) {
            y->rest[i][r] = jo_vec_at(y->t[r], i);
            y->share[i][r] = jo_vec_at(turn, i);
        }
        if (k->type == JO_LINK_FREE) {
            const jo_vec move = jo_vec_times(inverse, f);
            for (int i = 0; i < 3; i++) {
                y->rest[3 + i][r] = jo_vec_at(f, i);
                y->share[3 + i][r] = jo_vec_at(move, i);
            }
        } else if (p) {
            p->f[r] = jo_vec_add(p->f[r], f);
            p->t[r] = jo_vec_add(p->t[r], jo_vec_cross(w->l, f));
        }
    }
}

static inline void through_all(const jo_link_work *w, const jo_reach_work *y, jo_reach_work *p, int rows)
{
    for (int r = 0; p && r < rows; r++) {
        p->f[r] = jo_vec_add(p->f[r], y->f[r]);
        p->t[r] = jo_vec_add(p->t[r], jo_vec_add(y->t[r], jo_vec_cross(w->l, y->f[r])));
    }
}

static inline int motions(const jo_data *d, const jo_link *k)
{
    return jo_link_gives(d, k) ? 1 : k->type == JO_LINK_BALL ? 3 : k->type == JO_LINK_FREE ? 6 : 0;
}

/* x += share times what the free forces leave to the motions of the link */
static inline void add_free(const jo_data *d, const jo_link *k, const jo_link_work *w, const jo_reach_work *y, jo_real *x)
{
    for (int i = 0; i < motions(d, k); i++) {
        const jo_real u = jo_link_gives(d, k) ? w->rest : i < 3 ? -jo_vec_at(w->t, i) : -jo_vec_at(w->f, i - 3);
        for (int l = 0; l < 8; l += JO_WIDTH) JO_STORE(x + l) += u * JO_LOAD(y->share[i] + l);
    }
}

/* rows of a loop from its markers to the ground, and the accelerations along them without multipliers */
static void carry(const jo_model *m, jo_data *d, int loop)
{
    const jo_loop *l = &m->loop[loop];
    jo_loop_work *w = &d->tree.loop[loop];
    for (int i = l->first; i < l->first + l->count; i++) {
        const jo_link *k = &m->link[m->reach[i].link];
        const jo_link_work *link = &d->tree.link[m->reach[i].link + 1];
        jo_reach_work *y = &d->tree.reach[i], *p = m->reach[i].next < 0 ? 0 : &d->tree.reach[m->reach[i].next];
        if (jo_link_gives(d, k)) through_one(k, link, y, p, w->rows);
        else if (k->type == JO_LINK_BALL || k->type == JO_LINK_FREE) through_ball(k, link, y, p, w->rows);
        else through_all(link, y, p, w->rows);
        add_free(d, k, link, y, w->x);
    }
}

/* ---- multipliers ----------------------------------------------------------------------------------- */

static void assemble(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < d->tree.ngroup; i++)
        for (int j = 0; j < d->tree.gram[i].n * d->tree.gram[i].ld; j++) d->tree.gram[i].S[j] = 0.0;
    for (int i = 0, one = 0, other; i < m->nmeet; i++) {
        const jo_meet *k = &m->meet[i];
        while (k->one >= m->loop[one].first + m->loop[one].count) one++;
        for (other = one; k->other >= m->loop[other].first + m->loop[other].count;) other++;
        const jo_gram *g = gram_of(m, d, one);
        const jo_reach_work *a = &d->tree.reach[k->one], *b = &d->tree.reach[k->other];
        const int count = motions(d, &m->link[m->reach[k->one].link]), rows = d->tree.loop[one].rows;
        const int width = jo_padded(d->tree.loop[other].rows);
        jo_real *S = g->S + m->loop[one].row * g->ld + m->loop[other].row;
        for (int n = 0; n < count; n++)
            for (int r = 0; r < rows; r++)
                for (int l = 0; l < width; l += JO_WIDTH) JO_STORE(S + r * g->ld + l) += a->rest[n][r] * JO_LOAD(b->share[n] + l);
    }
}

/* Rows that repeat others, always or in a singular position, bear nothing: the accelerations are the same. */
static int factor(const jo_model *m, jo_data *d)
{
    int status = 1, row = 0, group = 0;
    assemble(m, d);
    for (; group < d->tree.ngroup && status == 1; group++) {
        jo_gram *g = &d->tree.gram[group];
        status = m->redundant > 0 ? jo_gram_reveal(g, JO_REPEATS) : jo_gram_factor(g, &row);
    }
    if (status == 1) return JO_OK;
    int loop = 0;
    while (loop + 1 < m->nloop && (m->loop[loop].group < group - 1 || (m->loop[loop + 1].group == group - 1 && m->loop[loop + 1].row <= row)))
        loop++;
    const jo_joint *k = &m->joint[m->loop[loop].joint];
    const int body = m->marker[k->side[1]].body;
    d->error_index = status == 0 ? m->loop[loop].joint : body < 0 ? m->marker[k->side[0]].body : body;
    if (status < 0) return JO_NOT_FINITE;
    if (m->redundant < 0) return JO_SINGULAR_JOINT;
    d->counts.singular++;
    assemble(m, d);
    for (int i = 0; i < d->tree.ngroup; i++)
        if (jo_gram_reveal(&d->tree.gram[i], JO_REPEATS) < 0) return JO_NOT_FINITE;
    return JO_OK;
}

void jo_loop_solve(const jo_model *m, jo_data *d)
{
    for (int i = 0, first = 0; i < m->nloop; i++) {
        if (!jo_loop_rows(m, i)) continue;
        jo_gram *g = gram_of(m, d, i);
        jo_real *x = g->S + (size_t)g->n * (size_t)g->ld;   /* behind it */
        for (int j = first; j <= i; j++)
            for (int r = 0; r < d->tree.loop[j].rows; r++) x[m->loop[j].row + r] = d->tree.loop[j].x[r];
        jo_gram_solve(g, x);
        for (int j = first; j <= i; j++)
            for (int r = 0; r < d->tree.loop[j].rows; r++) d->tree.loop[j].x[r] = x[m->loop[j].row + r];
        first = i + 1;
    }
}

/* the multipliers act: on what drives each joint on the way, and on the bodies themselves */
static void bear(const jo_model *m, jo_data *d, int loop)
{
    const jo_loop *l = &m->loop[loop];
    jo_loop_work *w = &d->tree.loop[loop];
    for (int i = l->first; i < l->first + l->count; i++) {
        const jo_link *k = &m->link[m->reach[i].link];
        jo_link_work *link = &d->tree.link[m->reach[i].link + 1];
        const jo_reach_work *y = &d->tree.reach[i];
        if (jo_link_gives(d, k)) {
            for (int r = 0; r < w->rows; r++) link->rest -= w->x[r] * y->rest[0][r];
        } else if (k->type == JO_LINK_FREE) {
            for (int r = 0; r < w->rows; r++) {
                const jo_real f[3] = {y->rest[3][r], y->rest[4][r], y->rest[5][r]};
                link->f = jo_vec_with(link->f, w->x[r], jo_vec_load(f));
                link->t = jo_vec_with(link->t, w->x[r], y->t[r]);
            }
        } else if (k->type != JO_LINK_FIXED) {
            for (int r = 0; r < w->rows; r++) {
                if (k->driven >= 0) link->f = jo_vec_with(link->f, w->x[r], y->f[r]);
                link->t = jo_vec_with(link->t, w->x[r], y->t[r]);
            }
        }
    }
    for (int i = 0; i < m->joint[l->joint].nside; i++) {
        const jo_loop_side *s = &w->side[i];
        if (s->link < 0) continue;
        jo_link_work *link = &d->tree.link[s->link + 1];
        for (int r = 0; r < w->rows; r++) {
            link->own_f = jo_vec_with(link->own_f, w->x[r], s->f[r]);
            link->own_t = jo_vec_with(link->own_t, w->x[r], s->t[r]);
        }
    }
}

/* bodies and markers of all loops where the links are, for their residuals */
static void stabilise(const jo_model *m, jo_data *d, const jo_stage *stage, int loop)
{
    const int joint = m->loop[loop].joint;
    jo_loop_work *w = &d->tree.loop[loop];
    jo_joint_gap(m, d, joint);
    jo_joint_gap_rate(m, d, joint);
    for (int r = 0; r < w->rows; r++)
        w->x[r] += 2.0 * stage->alpha * d->joint[joint].cdot[r] + stage->beta * stage->beta * d->joint[joint].c[r];
}

int jo_loop_evaluate(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    if (jo_stabilised(stage)) {
        jo_tree_bodies(m, d);
        jo_tree_markers(m, d, d->tree.closing, d->tree.nclosing);
    }
    for (int i = 0; i < m->nloop; i++) {
        move_sides(m, d, i);
        load_sides(m, d, i);
        if (m->joint[m->loop[i].joint].nline) scale_lines(m, d, i);
        jo_joint_second(m, d, m->loop[i].joint, d->tree.loop[i].motion, stage->lead, d->tree.loop[i].x);
        if (jo_stabilised(stage)) stabilise(m, d, stage, i);
        carry(m, d, i);
    }
    const int status = factor(m, d);
    if (status != JO_OK) return status;
    jo_loop_solve(m, d);
    for (int i = 0; i < m->nloop; i++) bear(m, d, i);
    return JO_OK;
}

void jo_loop_push(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nloop; i++) {
        const jo_loop_work *w = &d->tree.loop[i];
        for (int j = 0; j < m->joint[m->loop[i].joint].nside; j++) {
            const jo_loop_side *s = &w->side[j];
            if (s->link < 0) continue;
            jo_link_change *c = &d->tree.change[s->link + 1];
            for (int r = 0; r < w->rows; r++) {
                c->f = jo_vec_with(c->f, -w->x[r], s->f[r]);
                c->t = jo_vec_with(c->t, -w->x[r], s->t[r]);
            }
        }
    }
}

jo_real jo_loop_power(const jo_model *m, const jo_data *d)
{
    jo_real power = 0.0;
    for (int i = 0; i < m->nloop; i++) power += jo_joint_drive(m, d, m->loop[i].joint, d->tree.loop[i].x);
    return power;
}
