/* tree_friction.c - friction in the joints of a tree: what they bear, what forces along them change, and how they come to rest.
 *
 * What presses a joint needs no sums over the bodies beyond it: an articulated inertia and the accelerations of its link say what the
 * joint bears. A joint that sticks is held like one that is driven, its inertia passes whole.
 */
#include "friction/friction_law.h"
#include "tree/tree_links.h"

static const jo_link *link_along(const jo_model *m, int coordinate) { return &m->link[m->coordinate[coordinate].link]; }

/* the link that has the body of the joint */
static int last_link(const jo_model *m, const jo_friction *f)
{
    const int link = m->coordinate[f->coordinate].link;
    return m->link[link].body < 0 ? link + 1 : link;
}

/* value and rate of the coordinates along which frictions slide */
void jo_tree_slips(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++)
        for (int k = 0; k < jo_slips(&m->friction[i]); k++) {
            const int c = jo_slip_of(&m->friction[i], k);
            const jo_link *link = link_along(m, c);
            d->coordinate[c].value = jo_link_sign(link) * d->tree.x[link->x];
            d->coordinate[c].rate = jo_link_sign(link) * d->tree.u[link->u];
        }
}

jo_real jo_tree_second(const jo_model *m, const jo_data *d, int coordinate)
{
    const jo_link *link = link_along(m, coordinate);
    return jo_link_sign(link) * d->tree.ud[link->u];
}

/* way from the origin of side 1 to that of side 0 along the axis of a joint whose link has side 0 */
static jo_real slid(const jo_model *m, const jo_data *d, const jo_friction *f)
{
    const jo_link *k = link_along(m, f->coordinate);
    return k->type == JO_LINK_SLIDE ? d->tree.x[k->x] : jo_same(0.0);
}

/* Force and moment of a joint on side 1, in axes of its link, whose z is that of side 0: all of it, or what jo_tree_respond changes.
 * Along the joint it holds what acts there besides its reaction, which does not press. */
void jo_tree_bears(const jo_model *m, const jo_data *d, const jo_friction *f, int change, jo_real *y)
{
    const int i = last_link(m, f);
    const jo_link_work *w = &d->tree.link[i + 1];
    const jo_link_change *c = &d->tree.change[i + 1];
    const jo_vec av = change ? c->av : w->av, aw = change ? c->aw : w->aw;
    jo_vec F = jo_vec_add(jo_vec_times(w->M, av), jo_vec_times(w->H, aw));
    jo_vec T = jo_vec_add(jo_vec_across(w->H, av), jo_vec_times(w->J, aw));
    F = change ? jo_vec_less(F, c->f) : jo_vec_add(F, w->f);
    T = change ? jo_vec_less(T, c->t) : jo_vec_add(T, w->t);
    if (m->link[i].reversed) {
        F = jo_vec_scale(-1.0, F);
        T = jo_vec_less(jo_vec_cross(jo_vec_scale(slid(m, d, f), w->A[2]), F), T);
    }
    jo_vec_store(y, jo_vec_across(w->A, F));
    jo_vec_store(y + 3, jo_vec_across(w->A, T));
}

/* forces with which a friction that sticks holds its coordinates */
void jo_tree_held(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *y)
{
    for (int k = 0; k < jo_slips(f); k++) {
        const int i = m->coordinate[jo_slip_of(f, k)].link;
        y[k] = jo_link_sign(&m->link[i]) * jo_link_pull(d, &m->link[i], &d->tree.link[i + 1]);
    }
}

/* multipliers of the rows that hold what sticks */
void jo_tree_locks(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++) {
        const jo_friction *f = &m->friction[i];
        if (!f->law) continue;
        const jo_joint *lock = &m->joint[f->lock];
        jo_real y[2] = {0.0, 0.0};
        if (jo_sticks(m, d, f)) jo_tree_held(m, d, f, y);
        for (int k = 0; k < jo_slips(f); k++) d->lam[lock->row + k] = -y[k] / m->line[lock->line + k].data->factor[0];
    }
}

/* what sticks stands where it is held */
void jo_tree_hold(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++) {
        const jo_friction *f = &m->friction[i];
        if (!jo_sticks(m, d, f)) continue;
        for (int k = 0; k < jo_slips(f); k++) {
            const jo_link *link = link_along(m, jo_slip_of(f, k));
            d->tree.x[link->x] = jo_link_sign(link) * d->held[2 * m->joint[f->lock].lock + k];
            d->tree.u[link->u] = 0.0;
        }
    }
}

/* ---- the iteration for friction forces: n forces f along coordinates ------------------------------ */

/* changes of the links and, in d->sum, of the joints' accelerations by changes f of the friction */
void jo_tree_friction_respond(const jo_model *m, jo_data *d, const jo_real *f)
{
    jo_tree_respond_clear(m, d);
    for (int c = 0; c < d->mixing.n; c++) {
        const jo_link *k = link_along(m, d->mixing.coordinate[c]);
        d->tree.push[k->u] += jo_link_sign(k) * f[c];
    }
    jo_tree_respond(m, d, d->sum);
}

/* the friction that was found acts; a single force has been responded to, as a unit */
void jo_tree_friction_act(const jo_model *m, jo_data *d)
{
    const jo_mixing *x = &d->mixing;
    const jo_real part = x->n == 1 ? x->f[0] : jo_same(1.0);
    if (x->n > 1) jo_tree_friction_respond(m, d, x->f);
    for (int c = 0; c < x->n; c++) {
        const jo_link *k = link_along(m, x->coordinate[c]);
        d->tree.tau[k->u] += jo_link_sign(k) * x->f[c];
    }
    for (int i = 0; i < m->nu; i++) d->tree.ud[i] += part * d->sum[i];
    for (int i = 1; i <= m->nlink; i++) {
        const jo_link_change *c = &d->tree.change[i];
        jo_link_work *w = &d->tree.link[i];
        const int type = m->link[i - 1].type;
        const jo_vec f = type == JO_LINK_BALL || type == JO_LINK_FREE ? jo_vec_less(c->f, jo_vec_times(w->X, c->t)) : c->f;
        w->f = jo_vec_with(w->f, -part, f);
        w->t = jo_vec_with(w->t, -part, c->t);
        w->aw = jo_vec_with(w->aw, part, c->aw);
        w->av = jo_vec_with(w->av, part, c->av);
    }
}

/* ---- coming to rest --------------------------------------------------------------------------------- */

/* the inertia of a body, with those fixed to it, against the accelerations av, aw */
static void resist(const jo_link_constants *k, const jo_link_work *w, jo_link_change *c)
{
    jo_vec T[3];
    const jo_vec S = jo_vec_mix(w->A, k->all_S);
    for (int i = 0; i < 3; i++) T[i] = jo_vec_mix(w->A, k->all_J + 3 * i);   /* times A^T */
    c->f = jo_vec_less(jo_vec_cross(S, c->aw), jo_vec_scale(k->all_mass, c->av));
    c->t = jo_vec_scale(-1.0, jo_vec_add(jo_vec_times(T, jo_vec_across(w->A, c->aw)), jo_vec_cross(S, c->av)));
}

/* An impulse in each joint that is held takes its rate, with the factors of an evaluation in which it is held: the change of the rates
 * is the smallest in the metric of the masses. */
void jo_tree_stop(const jo_model *m, jo_data *d)
{
    jo_tree_respond_clear(m, d);
    d->tree.change[0].av = d->tree.change[0].aw = jo_vec_zero();
    for (int i = 0; i < m->nlink; i++) {   /* the inertia of what stops acts on all that goes on */
        const jo_link *k = &m->link[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        const jo_link_change *p = &d->tree.change[k->parent + 1];
        jo_link_change *c = &d->tree.change[i + 1];
        if (k->type == JO_LINK_FREE) {
            c->av = c->aw = jo_vec_zero();
            continue;
        }
        c->aw = p->aw;
        c->av = jo_vec_add(p->av, jo_vec_cross(p->aw, w->l));
        if (jo_link_held(d, k)) {
            const jo_vec lost = jo_vec_scale(-d->tree.u[k->u], w->A[2]);
            if (k->type == JO_LINK_HINGE) c->aw = jo_vec_add(c->aw, lost);
            else c->av = jo_vec_add(c->av, lost);
        }
        if (k->body < 0 || k->type == JO_LINK_FIXED) continue;
        resist(&d->tree.constants[i], w, c);
    }
    jo_tree_respond(m, d, d->sum);
    for (int i = 0; i < m->nu; i++) d->tree.u[i] += d->sum[i];
    for (int i = 0; i < m->nlink; i++)
        if (jo_link_held(d, &m->link[i])) d->tree.u[m->link[i].u] = 0.0;
    d->fresh = d->current = 0;
    d->tree.mirrored = JO_MIRROR_NONE;
}
