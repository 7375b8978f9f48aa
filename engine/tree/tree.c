/* tree.c - accelerations of a tree of rigid bodies in joint coordinates, by articulated inertias.
 *
 * Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 7, here with vectors resolved in the world about the points of the
 * joints. Outward: positions, velocities, accelerations that velocities alone cause and the forces that these need. Inward: each
 * joint passes on what the inertia beyond it resists, less what the joint gives way to. Outward again: accelerations of the joints.
 * What is prescribed passes on all, its acceleration is one of those without joints.
 */
#include "friction/friction.h"
#include "tree/tree_links.h"

#define JO_LEAST 1e-14      /* of the inertia along a joint before it is reduced */

size_t jo_link_bytes(void) { return sizeof(jo_link_work); }
size_t jo_link_constant_bytes(void) { return sizeof(jo_link_constants); }
size_t jo_link_change_bytes(void) { return sizeof(jo_link_change); }

/* ---- outward: motion and bias ------------------------------------------------------------------ */

/* orientation at zero of the link, then turned about z */
static inline void turn(jo_link_work *w, const jo_link_work *p, const jo_real *K, jo_real c, jo_real s)
{
    const jo_vec x = jo_vec_mix(p->A, K), y = jo_vec_mix(p->A, K + 3);
    w->A[0] = jo_vec_with(jo_vec_scale(c, x), s, y);
    w->A[1] = jo_vec_less(jo_vec_scale(c, y), jo_vec_scale(s, x));
    w->A[2] = jo_vec_mix(p->A, K + 6);
}

/* orientation at zero times that of a quaternion */
static inline void turn_freely(jo_link_work *w, const jo_link_work *p, const jo_real *K, const jo_real *e)
{   /* (2 e0^2 - 1) E + 2 e e^T + 2 e0 e~ */
    const jo_real twice = 2.0 * e[0], s = twice * e[0] - 1.0;
    jo_vec B[3], z;
    for (int i = 0; i < 3; i++) B[i] = jo_vec_mix(p->A, K + 3 * i);
    z = jo_vec_mix(B, e + 1);
    z = jo_vec_add(z, z);
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const jo_vec x = jo_vec_with(jo_vec_scale(s, B[i]), e[1 + i], z);
        w->A[i] = jo_vec_with(jo_vec_with(x, twice * e[1 + k], B[j]), -twice * e[1 + j], B[k]);
    }
}

/* nothing beyond it, and no forces */
static inline void unload(const jo_link_constants *c, jo_link_work *w)
{
    const jo_vec zero = jo_vec_zero();
    w->own_f = w->own_t = zero;
    if (!c->gathers) return;
    for (int i = 0; i < 3; i++) w->M[i] = w->H[i] = w->J[i] = zero;
    w->f = w->t = zero;
}

/* motion of a link from that of its parent */
static inline void move(const jo_model *m, jo_data *d, int i)
{
    const jo_link *k = &m->link[i];
    const jo_link_constants *c = &d->tree.constants[i];
    const jo_link_work *p = &d->tree.link[k->parent + 1];
    jo_link_work *w = &d->tree.link[i + 1];
    const jo_real *x = d->tree.x + k->x, *u = d->tree.u + k->u;
    const jo_real given = k->driven < 0 ? 0.0 : d->tree.ud[k->u];
    w->l = jo_vec_mix(p->A, c->l);
    w->w = p->w;
    w->w0 = p->w0;
    jo_vec extra = jo_vec_zero();
    switch (k->type) {
    case JO_LINK_HINGE: {
        turn(w, p, c->K, w->cosine, w->sine);
        const jo_vec rate = jo_vec_scale(u[0], w->A[2]);
        w->w = jo_vec_add(p->w, rate);
        w->w0 = jo_vec_add(p->w0, jo_vec_cross(p->w, rate));
        if (k->driven >= 0) w->w0 = jo_vec_with(w->w0, given, w->A[2]);
        break;
    }
    case JO_LINK_SLIDE:
        for (int j = 0; j < 3; j++) w->A[j] = jo_vec_mix(p->A, c->K + 3 * j);
        w->l = jo_vec_with(w->l, x[0], w->A[2]);
        extra = jo_vec_with(jo_vec_scale(given, w->A[2]), 2.0 * u[0], jo_vec_cross(p->w, w->A[2]));
        break;
    case JO_LINK_BALL: {
        turn_freely(w, p, c->K, x);
        const jo_vec rate = jo_vec_mix(w->A, u);
        w->w = jo_vec_add(p->w, rate);
        w->w0 = jo_vec_add(p->w0, jo_vec_cross(p->w, rate));
        break;
    }
    case JO_LINK_FREE:
        turn_freely(w, p, c->K, x + 3);
        w->w = jo_vec_mix(w->A, u + 3);
        w->l = jo_vec_load(x);
        break;
    default:
        for (int j = 0; j < 3; j++) w->A[j] = jo_vec_mix(p->A, c->K + 3 * j);
        break;
    }
    w->v0 = p->v0;
    if (k->type == JO_LINK_FREE) return;
    const jo_vec carried = jo_vec_add(jo_vec_wedge(p->w0, w->l), jo_vec_wedge(p->w, jo_vec_cross(p->w, w->l)));
    w->v0 = jo_vec_add(jo_vec_add(p->v0, extra), jo_vec_turn(carried));
}

static void outward(const jo_model *m, jo_data *d)
{
    jo_tree_sines(m, d);
    for (int i = d->tree.kept; i < m->nlink; i++) {
        move(m, d, i);
        unload(&d->tree.constants[i], &d->tree.link[i + 1]);
    }
}

/* ---- inward: articulated inertias ------------------------------------------------------------- */

/* An articulated inertia as in jo_link_work, on its way inward: where a link hangs on the one before it, what it passes on does not
 * go through memory. */
typedef struct { jo_vec M[3], H[3], J[3], f, t; } load;

static inline load no_load(void)
{
    const jo_vec o = jo_vec_zero();
    return (load){{o, o, o}, {o, o, o}, {o, o, o}, o, o};
}

static inline void put_down(const load *y, jo_link_work *w)
{
    for (int i = 0; i < 3; i++) {
        w->M[i] = y->M[i];
        w->H[i] = y->H[i];
        w->J[i] = y->J[i];
    }
    w->f = y->f;
    w->t = y->t;
}

static inline void pick_up(load *y, const jo_link_work *w)
{
    for (int i = 0; i < 3; i++) {
        y->M[i] = jo_vec_add(y->M[i], w->M[i]);
        y->H[i] = jo_vec_add(y->H[i], w->H[i]);
        y->J[i] = jo_vec_add(y->J[i], w->J[i]);
    }
    y->f = jo_vec_add(y->f, w->f);
    y->t = jo_vec_add(y->t, w->t);
}

static inline void add_force(jo_link_work *p, jo_vec f, jo_vec t)
{
    p->f = jo_vec_add(p->f, f);
    p->t = jo_vec_add(p->t, t);
}

/* the body of a link and those fixed to it join what follows: their inertia, and the force for the accelerations w0, v0. Here and not outward:
 * beside the inward recursion, each step of which waits for that before, it costs next to nothing. */
static inline void join(const jo_link_constants *c, const jo_link_work *w, load *y)
{
    static const jo_real unit[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    jo_vec T[3], J[3];
    const jo_vec S = jo_vec_mix(w->A, c->all_S);
    for (int i = 0; i < 3; i++) T[i] = jo_vec_mix(w->A, c->all_J + 3 * i);
    for (int i = 0; i < 3; i++) J[i] = jo_vec_on_row(T, w->A, i);
    const jo_vec Jw = jo_vec_on(J, &w->w);
    const jo_vec f = jo_vec_add(jo_vec_wedge(w->w0, S), jo_vec_wedge(w->w, jo_vec_cross(w->w, S)));
    const jo_vec t = jo_vec_add(jo_vec_wedge(w->w, Jw), jo_vec_wedge(S, w->v0));
    y->f = jo_vec_add(y->f, jo_vec_with(jo_vec_turn(f), c->all_mass, w->v0));
    y->t = jo_vec_add(y->t, jo_vec_add(jo_vec_turn(t), jo_vec_on(J, &w->w0)));
    for (int i = 0; i < 3; i++) {
        y->M[i] = jo_vec_with(y->M[i], c->all_mass, jo_vec_load(unit[i]));
        y->J[i] = jo_vec_add(y->J[i], J[i]);
    }
    jo_vec_less_skew(y->H, S);
}

/* M l~ */
static inline void on_lever(jo_vec *N, const jo_vec *M, const jo_vec *l)
{
    const jo_real x = jo_vec_parts(l)[0], y = jo_vec_parts(l)[1], z = jo_vec_parts(l)[2];
    N[0] = jo_vec_less(jo_vec_scale(z, M[1]), jo_vec_scale(y, M[2]));
    N[1] = jo_vec_less(jo_vec_scale(x, M[2]), jo_vec_scale(z, M[0]));
    N[2] = jo_vec_less(jo_vec_scale(y, M[0]), jo_vec_scale(x, M[1]));
}

/* all of it as seen from the origin of the parent */
static inline void pass_all(const jo_link_work *w, load *y)
{
    jo_vec N[3], P[3], Q[3];
    on_lever(N, y->M, &w->l);
    for (int i = 0; i < 3; i++) {
        P[i] = jo_vec_cross(w->l, jo_vec_with(y->H[i], -0.5, N[i]));
        y->H[i] = jo_vec_less(y->H[i], N[i]);
    }
    jo_vec_transpose(Q, P);
    for (int i = 0; i < 3; i++) y->J[i] = jo_vec_add(y->J[i], jo_vec_add(P[i], Q[i]));
    y->t = jo_vec_add(y->t, jo_vec_cross(w->l, y->f));
}

/* what is left of it by a hinge or a slide, whose Uf, Ut, r and rest are known; the division comes in last */
static inline void pass_one(const jo_link_work *w, load *y)
{
    const jo_real r = w->r, share = w->rest * r;
    const jo_vec Uf = w->Uf, Us = w->Us;
    pass_all(w, y);
    for (int i = 0; i < 3; i++) {
        const jo_real f = jo_vec_at(Uf, i), s = jo_vec_at(Us, i);
        y->M[i] = jo_vec_with(y->M[i], -r, jo_vec_scale(f, Uf));
        y->H[i] = jo_vec_with(y->H[i], -r, jo_vec_scale(s, Uf));
        y->J[i] = jo_vec_with(y->J[i], -r, jo_vec_scale(s, Us));
    }
    y->f = jo_vec_with(y->f, share, Uf);
    y->t = jo_vec_with(y->t, share, Us);
}

/* A ball gives way to all turns: M - H J^-1 H^T and f - H J^-1 t are left. The division comes in last. */
static inline int free_turns(jo_link_work *w, load *y)
{
    jo_vec adjoint[3], Y[3];
    const double scale = JO_RE(jo_vec_at(y->J[0], 0)) + JO_RE(jo_vec_at(y->J[1], 1)) + JO_RE(jo_vec_at(y->J[2], 2));
    w->D = jo_vec_adjoint(adjoint, y->J);
    w->t = y->t;
    const jo_real r = 1.0 / w->D;
    for (int i = 0; i < 3; i++) Y[i] = jo_vec_times(y->H, adjoint[i]);
    for (int i = 0; i < 3; i++) {
        y->M[i] = jo_vec_with(y->M[i], -r, jo_vec_on_row(Y, y->H, i));
        w->X[i] = jo_vec_scale(r, Y[i]);
        w->inverse[i] = jo_vec_scale(r, adjoint[i]);
    }
    y->f = jo_vec_with(y->f, -r, jo_vec_on(Y, &w->t));
    return JO_RE(w->D) > JO_LEAST * scale * scale * scale;
}

/* M and f alone */
static inline void pass_force(jo_link_work *w, load *y)
{
    jo_vec N[3];
    on_lever(N, y->M, &w->l);
    for (int i = 0; i < 3; i++) {
        w->Z[i] = jo_vec_cross(w->l, w->X[i]);
        y->H[i] = jo_vec_scale(-1.0, N[i]);
        y->J[i] = jo_vec_scale(-1.0, jo_vec_cross(w->l, N[i]));
    }
    y->t = jo_vec_cross(w->l, y->f);
}

/* inertia along a hinge or a slide and the force that is left to accelerate it; 0 where there is none */
static inline int along(const jo_data *d, const jo_stage *stage, const jo_link *k, jo_link_work *w, const load *y)
{
    const jo_vec *a = &w->A[2];
    if (k->type == JO_LINK_HINGE) {
        w->Uf = jo_vec_on(y->H, a);
        w->Ut = jo_vec_on(y->J, a);
        w->D = jo_vec_dot(*a, w->Ut);
        w->rest = d->tree.tau[k->u] - jo_vec_dot(*a, y->t);
    } else {
        w->Uf = jo_vec_on(y->M, a);
        w->Ut = jo_vec_across(y->H, *a);
        w->D = jo_vec_dot(*a, w->Uf);
        w->rest = d->tree.tau[k->u] - jo_vec_dot(*a, y->f);
    }
    if (stage->set) w->D += stage->gh * (d->tree.damping[k->u] + stage->gh * d->tree.stiffness[k->u]);
    w->r = 1.0 / w->D;
    w->Us = jo_vec_add(w->Ut, jo_vec_cross(w->l, w->Uf));
    return JO_RE(w->D) > 0.0;
}

/* a link with all that follows it in y, which is then what it passes on; 0: it has no inertia along its joint */
static inline int give_way(const jo_data *d, const jo_stage *stage, const jo_link *k, int kept, jo_link_work *w, load *y)
{
    int sound = 1;
    if (jo_link_given(d, k)) {
        put_down(y, w);
        if (k->parent >= 0) pass_all(w, y);
    } else if (k->type == JO_LINK_HINGE || k->type == JO_LINK_SLIDE) {
        sound = along(d, stage, k, w, y);
        if (kept) put_down(y, w);
        if (k->parent >= 0) pass_one(w, y);
    } else {
        sound = free_turns(w, y);
        if (kept || k->type == JO_LINK_FREE) put_down(y, w);
        if (k->parent >= 0) pass_force(w, y);
    }
    return sound;
}

static int inward(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    const int kept = m->nfriction || m->nloop, pushed = d->tree.nbody > 0;   /* somebody reads what links bear */
    load y = no_load();
    for (int i = m->nlink - 1; i >= 0; i--) {
        const jo_link *k = &m->link[i];
        const jo_link_constants *c = &d->tree.constants[i];
        jo_link_work *w = &d->tree.link[i + 1], *p = &d->tree.link[k->parent + 1];
        if (k->type == JO_LINK_FIXED) {   /* its inertia is in that of the parent, its forces are not */
            if (pushed && k->parent >= 0) add_force(p, w->own_f, jo_vec_add(w->own_t, jo_vec_cross(w->l, w->own_f)));
            continue;
        }
        if (k->type == JO_LINK_BODY && !d->body[k->body].port) continue;
        if (c->gathers) pick_up(&y, w);
        if (k->body >= 0) join(c, w, &y);
        if (k->type == JO_LINK_BODY) {
            put_down(&y, w);
            y = no_load();
            continue;
        }
        if (pushed) {
            y.f = jo_vec_add(y.f, w->own_f);
            y.t = jo_vec_add(y.t, w->own_t);
        }
        if (!give_way(d, stage, k, kept, w, &y)) {
            d->error_index = k->body >= 0 ? k->body : m->link[i + 1].body;
            return JO_RE(w->D) == JO_RE(w->D) ? JO_SINGULAR_BODY : JO_NOT_FINITE;
        }
        if (k->parent >= 0 && k->parent == i - 1) continue;
        if (k->parent >= 0) {
            pick_up(&y, p);
            put_down(&y, p);
        }
        if (i) y = no_load();
    }
    return JO_OK;
}

/* ---- outward: accelerations ---------------------------------------------------------------------- */

/* Each waits for the parent: what it has comes in last, and where that is the link before it does not go through memory. */
void jo_tree_follow(const jo_model *m, jo_data *d)
{
    jo_vec aw = jo_vec_zero(), av = jo_vec_zero();
    int last = -2;   /* the link that moves with these */
    for (int i = d->tree.kept; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_work *p = &d->tree.link[k->parent + 1];
        jo_link_work *w = &d->tree.link[i + 1];
        jo_real *ud = d->tree.ud + k->u;
        const jo_vec aw0 = k->parent == last ? aw : p->aw, av0 = k->parent == last ? av : p->av;
        aw = aw0;
        av = jo_vec_add(av0, jo_vec_cross(aw0, w->l));
        if (k->type == JO_LINK_BALL) {
            aw = jo_vec_scale(-1.0, jo_vec_add(jo_vec_times(w->inverse, w->t), jo_vec_both(w->X, av0, w->Z, aw0)));
            jo_vec_store(ud, jo_vec_across(w->A, jo_vec_less(aw, aw0)));
        } else if (k->type == JO_LINK_FREE) {
            jo_vec inverse[3];
            jo_vec_invert(inverse, w->M);
            av = jo_vec_scale(-1.0, jo_vec_times(inverse, w->f));
            aw = jo_vec_scale(-1.0, jo_vec_add(jo_vec_times(w->inverse, w->t), jo_vec_across(w->X, av)));
            jo_vec_store(ud, av);
            jo_vec_store(ud + 3, jo_vec_across(w->A, aw));
        } else if (k->driven < 0 && k->type != JO_LINK_FIXED) {
            ud[0] = jo_link_held(d, k) ? 0.0 : w->r * (w->rest - jo_vec_dots(w->Uf, av0, w->Us, aw0));
            if (k->type == JO_LINK_HINGE) aw = jo_vec_with(aw, ud[0], w->A[2]);
            else av = jo_vec_with(av, ud[0], w->A[2]);
        }
        w->aw = aw;
        w->av = av;
        last = i;
    }
}

/* the forces of what is prescribed, from all that it passes on, and their power */
jo_real jo_tree_drive(const jo_model *m, jo_data *d)
{
    jo_real power = m->nloop ? jo_loop_power(m, d) : 0.0;
    for (int i = 0; d->tree.ndriven && i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_link_work *w = &d->tree.link[i + 1];
        if (k->driven < 0) continue;
        d->tree.pull[i] = jo_link_pull(d, k, w);
        power += d->tree.pull[i] * d->tree.u[k->u];
    }
    return power;
}

int jo_tree_load(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    d->tree.summed = 0;
    d->tree.link->v0 = jo_vec_scale(-1.0, jo_vec_load(m->gravity));   /* the ground's; the rest of it stays, see jo_tree_setup */
    jo_tree_drives(m, d);
    outward(m, d);
    const int status = jo_tree_forces(m, d, stage);
    return status == JO_OK ? inward(m, d, stage) : status;
}

/* accelerations of the joints at time, x, u */
int jo_tree_evaluate(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    static const jo_work none = {0.0, 0.0, 0.0};
    d->power = none;
    d->counts.evaluations++;
    d->current = 0;
    d->tree.mirrored = JO_MIRROR_NONE;
    int status = jo_tree_load(m, d, stage);
    if (status == JO_OK && m->nloop) status = jo_loop_evaluate(m, d, stage);
    if (status != JO_OK) return status;
    jo_tree_follow(m, d);
    if (m->nfriction) status = jo_friction_solve(m, d, stage);
    d->drive = jo_tree_drive(m, d);
    d->power.forces += d->drive;
    return status;
}
