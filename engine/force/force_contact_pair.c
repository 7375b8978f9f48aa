/* force_contact_pair.c - two convex polytopes with rounded edges touch, or the vertices of one a surface of triangles: up to 8 points, each
 * with the law and the states of force_contact.c.
 *
 * A point is a pair of features: a vertex over a face, two edges, ... (contact/feature.c). The list of points is found at the end of a step
 * (contact/corners.c) and stays within a step, in which force and tangent are smooth functions of the motion. A point that is found again
 * keeps its states; a new one continues those of the nearest point that has touched before, since a corner that leaves a face is followed by
 * others at the same place. The law of a point is multiplied by its weight; what a change of the weights takes from the stored energy counts
 * as dissipated. Without points the pair is apart: then its margin is the gap, and a step is proven by the speeds of both.
 *
 * On a surface of triangles (contact/mesh_points.c) the feature of a point is the local minimum of the distance to which it descends from the
 * triangle of the last step; the other points that may close are in the margin, and in the gap that is proven.
 *
 * Data: numbers of the law, then those of both polytopes (jo_polytope_read, jo_mesh_read). States of a point: those of contact_point.h, code of
 * the features (0: none; of the first point, where polytopes are apart: less than 0, that of the closest ones), weight. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "contact/contact.h"
#include "force/contact_pair.h"

enum { REACH = 6 };     /* place of jo_pair_reach in jo_seen_speeds, beside the velocities */
#define JO_SAME_WEIGHT 1e-9     /* change of a weight that is round-off */

typedef jo_contact_pair_pose pair;

/* A point with its law, in motion. */
typedef struct { jo_contact_law law; jo_feature feature; jo_contact_point y; } point;

static jo_real *states(const jo_data *d, const jo_force *f) { return d->w + (d->nw - d->forces.nstate) + f->state; }

static int any_listed(const jo_force *f, const jo_real *state)
{
    for (int i = 0; i < jo_pair_points(f); i++)
        if (jo_pair_is_listed(state + JO_PAIR_STATES * i)) return 1;
    return 0;
}

static void read(const jo_data *d, const jo_force *f, pair *p)
{
    const jo_real *const *bound = (const jo_real *const *)f->user;   /* of a slot */
    const jo_real *data = bound ? bound[0] : (const jo_real *)(jo_contact_law_of(f) + 1);
    p->mesh.triangles = 0;
    data = jo_is_mesh(data) ? jo_mesh_read(data, &p->mesh, &p->a.radius) : jo_polytope_read(data, &p->a);
    jo_polytope_read(bound ? bound[1] : data, &p->b);
    jo_relative_pose(d, f, p->r, p->R);
    for (int i = 0; i < 3; i++) p->v[i] = p->w[i] = jo_same(0.0);
}

static void read_motion(const jo_model *m, const jo_data *d, const jo_force *f, pair *p)
{
    read(d, f, p);
    jo_relative_velocity(m, d, f, p->v, p->w);
}

static int is_round(const pair *p) { return !p->mesh.triangles && (p->a.round || p->b.round); }

/* signed distance, m, from the face `before` if it is given */
static double separate_from(pair *p, const jo_separated *before, jo_separated *s)
{
    jo_polytope_place(&p->b, p->r, p->R);
    if (p->mesh.triangles) {
        jo_mesh_gap y;
        jo_mesh_distance(&p->mesh, &p->b, jo_pair_radii(p), &y);
        return y.gap;
    }
    jo_polytope_place(&p->a, 0, 0);
    jo_separation(&p->a, &p->b, before, s);
    return s->gap - jo_pair_radii(p);
}

/* signed distance, m, or less if the features of the last step show that they are apart: where these are not the closest ones any more, the
 * distance of their planes and lines is smaller than that of the shapes */
static double separate(pair *p, const jo_real *state, jo_separated *s)
{
    const double code = p->mesh.triangles || is_round(p) ? 0.0 : fabs(JO_RE(state[JO_PAIR_CODE]));
    jo_polytope_place(&p->a, 0, 0);
    jo_polytope_place(&p->b, p->r, p->R);
    if (code > 0.0 && jo_still_separated(&p->a, &p->b, code, p->r, p->R, s) && s->gap > jo_pair_radii(p)) return s->gap - jo_pair_radii(p);
    return separate_from(p, 0, s);
}

/* place of a point, its motion and its force */
static void present(const jo_force *f, const pair *p, const jo_real *state, point *t)
{
    jo_feature *g = &t->feature;
    jo_contact_point *y = &t->y;
    t->law = *jo_contact_law_of(f);
    t->law.stiffness *= state[JO_PAIR_WEIGHT];
    t->law.viscous *= state[JO_PAIR_WEIGHT];
    t->law.mass *= state[JO_PAIR_WEIGHT];
    if (p->mesh.triangles) jo_mesh_point_feature(&p->mesh, &p->b, p->r, p->R, JO_RE(state[JO_PAIR_CODE]), g);
    else jo_feature_at(&p->a, &p->b, p->r, p->R, state[JO_PAIR_CODE], g);
    y->depth = p->a.radius + p->b.radius - g->gap;
    for (int i = 0; i < 3; i++) {
        y->normal[i] = g->normal[i];
        y->lever[i] = g->foot[i] + (p->a.radius - 0.5 * y->depth) * g->normal[i] - p->r[i];
        y->v[i] = p->v[i];
        y->w[i] = p->w[i];
    }
    jo_contact_slide(y);
    jo_contact_press(&t->law, state, y);
    jo_contact_stretched(state + JO_CONTACT_STRETCH, y);
}

static jo_real energy(const jo_force *f, const pair *p, const jo_real *state)
{
    jo_real sum = {0.0};
    point t;
    for (int i = 0; i < jo_pair_points(f); i++, state += JO_PAIR_STATES) {
        if (!jo_pair_touches(state)) continue;
        present(f, p, state, &t);
        sum += jo_contact_energy(jo_contact_phase(state), &t.y);
    }
    return sum;
}

static jo_real stored(const jo_data *d, const jo_force *f)
{
    pair p;
    if (!any_listed(f, states(d, f))) return jo_same(0.0);
    read(d, f, &p);
    return energy(f, &p, states(d, f));
}

/* change of a point with the k-th motion of b */
static jo_contact_change change_of(const pair *p, const point *t, int k)
{
    jo_contact_change c = {0.0, 0.0, {0.0}, {0.0}, {0.0}};
    if (k < 6) {
        jo_real x[3] = {0.0, 0.0, 0.0}, phi[3] = {0.0, 0.0, 0.0}, gap, foot[3];
        (k < 3 ? x : phi)[k % 3] = jo_same(1.0);
        jo_feature_change(&t->feature, p->r, x, phi, &gap, c.normal, foot);
        c.depth = -gap;
        for (int i = 0; i < 3; i++)
            c.lever[i] = foot[i] + (p->a.radius - 0.5 * t->y.depth) * c.normal[i] - 0.5 * c.depth * t->y.normal[i] - x[i];
    }
    jo_contact_rates(&t->y, k, &c);
    return c;
}

/* in the matrix of a Rosenbrock method */
static void add_implicit(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, int first, const pair *p, const point *t)
{
    jo_contact_change moves[6];   /* with position and velocity of b */
    for (int k = 0; k < 6 && !stage->earlier && jo_pair_touches(jo_states(m, d) + first); k++) moves[k] = change_of(p, t, k < 3 ? k : k + 3);
    jo_contact_implicit(m, d, stage, f, first, &t->y, moves);
}

/* velocity of the origin of b, made longer by |w| reach */
static void longest_velocity(const pair *p, double reach, jo_real *v)
{
    const double speed = jo_length(p->v, 3), turning = jo_length(p->w, 3) * reach, share = speed > 0.0 ? 1.0 + turning / speed : 0.0;
    for (int i = 0; i < 3; i++) v[i] = share * p->v[i];
    if (!(speed > 0.0)) v[0] = jo_same(turning);
}

/* the speed of an open gap in a stage */
static void see_apart(const jo_model *m, jo_data *d, const jo_force *f, pair *p)
{
    jo_real v[3];
    read_motion(m, d, f, p);
    longest_velocity(p, jo_seen_speeds(d, f->state)[REACH], v);
    jo_see_speed(d, f->state, v);
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *out)
{
    static const jo_force_work none = {{0.0}, 0.0, 0.0, 0.0};
    const jo_real *state = states(d, f);
    jo_real F[6], sum[6] = {0.0};
    pair p;
    point t;
    int any = 0;
    *out = none;
    for (int i = 0; i < jo_pair_points(f); i++, state += JO_PAIR_STATES) {
        const int first = f->state + JO_PAIR_STATES * i;
        if (!jo_pair_touches(state)) {
            jo_contact_hold_states(m, d, stage, first, JO_PAIR_STATES);
            if (stage->contacts) add_implicit(m, d, stage, f, first, &p, &t);
            if (!jo_blows(d) || !jo_pair_is_listed(state)) continue;
        }
        if (!any++) read_motion(m, d, f, &p);
        present(f, &p, state, &t);
        if (jo_blows(d)) jo_add_blow(d, first, t.y.lever, sum);
        if (!jo_pair_touches(state)) continue;
        jo_contact_move_states(m, d, stage, &t.law, first, &t.y);
        jo_contact_hold_states(m, d, stage, first + JO_PAIR_CODE, JO_PAIR_STATES - JO_PAIR_CODE);
        if (stage->contacts) add_implicit(m, d, stage, f, first, &p, &t);
        if (!(JO_RE(t.y.depth) > 0.0)) continue;
        jo_contact_force(&t.law, jo_contact_phase(state), &t.y, F, &d->power);
        out->stored += jo_contact_energy(jo_contact_phase(state), &t.y);
        for (int k = 0; k < 6; k++) sum[k] += F[k];
    }
    if (any) jo_push_between(m, d, f, sum, out);
    if (!any || p.mesh.triangles) see_apart(m, d, f, &p);
    return JO_OK;
}

static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *unused)
{
    (void)unused;
    const jo_real *state = states(d, f);
    jo_real F[6], dF[6], sum[6] = {0.0}, X[6][12] = {{0.0}};
    jo_work power = {0.0, 0.0, 0.0};
    pair p;
    point t;
    int any = 0;
    for (int i = 0; i < jo_pair_points(f); i++, state += JO_PAIR_STATES) {
        if (!jo_pair_touches(state)) continue;
        if (!any++) read_motion(m, d, f, &p);
        present(f, &p, state, &t);
        if (!(JO_RE(t.y.depth) > 0.0)) continue;
        jo_contact_force(&t.law, jo_contact_phase(state), &t.y, F, &power);
        for (int k = 0; k < 6; k++) sum[k] += F[k];
        for (int k = 0; k < 12; k++) {
            const jo_contact_change c = change_of(&p, &t, k);
            jo_contact_response(&t.law, stage, state, &t.y, &c, k, F, dF);
            for (int j = 0; j < 6; j++) X[j][k] += dF[j];
        }
    }
    if (any) jo_newton_between(m, d, f, sum, X);
    return JO_OK;
}

/* states of a corner that is found: its own before, else those of the nearest point that touched, else apart */
static void continue_states(const jo_force *f, const pair *p, const jo_corner *corner, const jo_real *old, jo_real *state)
{
    const jo_real *from = 0;
    double nearest = INFINITY;
    point t;
    for (int i = 0; i < jo_pair_points(f); i++, old += JO_PAIR_STATES) {
        double distance = 0.0;
        if (jo_pair_is_listed(old) && jo_same_parts(JO_RE(old[JO_PAIR_CODE]), corner->code)) {
            from = old;
            break;
        }
        if (!jo_pair_touches(old)) continue;
        present(f, p, old, &t);
        for (int k = 0; k < 3; k++) distance += pow(JO_RE(t.y.lever[k] + p->r[k]) - corner->at[k], 2);
        if (distance >= nearest) continue;
        nearest = distance;
        from = old;
    }
    for (int k = 0; from && k < JO_PAIR_STATES; k++) state[k] = from[k];
    const int same = from && jo_same_parts(JO_RE(from[JO_PAIR_CODE]), corner->code) && fabs(JO_RE(from[JO_PAIR_WEIGHT]) - corner->weight) < JO_SAME_WEIGHT;
    state[JO_PAIR_CODE] = jo_same(corner->code);
    if (!same) state[JO_PAIR_WEIGHT] = jo_same(corner->weight);
}

/* the face of a listed point, from which the search may start */
static jo_separated face_of(const jo_force *f, const jo_real *state)
{
    static const jo_separated none = {.kind = JO_CLOSEST_POINTS};
    jo_separated y = none;
    for (int i = 0; i < jo_pair_points(f) && y.kind == JO_CLOSEST_POINTS; i++, state += JO_PAIR_STATES) {
        if (!jo_pair_is_listed(state)) continue;
        const jo_feature_pair of = jo_feature_of(JO_RE(state[JO_PAIR_CODE]));
        if (of.kind == JO_FACE_VERTEX) y.kind = JO_FACE_A;
        if (of.kind == JO_VERTEX_FACE) y.kind = JO_FACE_B;
        y.of[0] = of.kind == JO_FACE_VERTEX ? of.a[0] : of.b[0];
    }
    return y;
}

/* Hertz's stiffness of round shapes is that of their curvature at the point; that of the law is with the curvature of edges. */
static void adapt(const jo_force *f, const pair *p, jo_corner *corner, int count)
{
    const jo_real *const *bound = (const jo_real *const *)f->user, *edge = bound ? bound[2] : 0;
    for (int i = 0; i < count && edge && is_round(p); i++) {
        const double curvature = jo_round_curvature(&p->a, &p->b, p->r, p->R, corner[i].code, edge);
        if (curvature > 0.0) corner[i].weight *= sqrt(JO_RE(edge[0] + edge[1]) / curvature);
    }
}

/* points of two polytopes with the states that continue those in `state` */
static void list_corners(const jo_force *f, pair *p, const jo_real *state, jo_real *next)
{
    jo_separated s;
    jo_corner corner[JO_CORNERS];
    const jo_separated before = face_of(f, state);
    const double gap = before.kind == JO_CLOSEST_POINTS ? separate(p, state, &s) : separate_from(p, &before, &s);
    const int found = !(gap < 0.0) ? 0 : is_round(p) ? jo_round_corners(&p->a, &p->b, &s, corner) : jo_corners(&p->a, &p->b, &s, corner);
    adapt(f, p, corner, found);
    for (int i = 0; i < found && i < jo_pair_points(f); i++) continue_states(f, p, corner + i, state, next + JO_PAIR_STATES * i);
    if (!found && s.gap > 0.0) next[JO_PAIR_CODE] = jo_same(-jo_separation_code(&s));
}

/* the points of the present pose with the states that continue those in `state` */
static void list(const jo_force *f, pair *p, jo_real *state)
{
    jo_real next[JO_CORNERS * JO_PAIR_STATES] = {0.0};
    int last = 0;
    for (int i = 1; i < jo_pair_points(f); i++)
        if (JO_RE(state[JO_PAIR_STATES * i + JO_CONTACT_SINCE]) > JO_RE(state[JO_PAIR_STATES * last + JO_CONTACT_SINCE])) last = i;
    for (int i = 0; i < jo_pair_points(f); i++) {   /* speed and time of the last touch remain for sensors */
        const jo_real speed = state[JO_PAIR_STATES * last + JO_CONTACT_SPEED];
        next[JO_PAIR_STATES * i + JO_CONTACT_SPEED] = JO_RE(speed) > 0.0 ? speed : jo_contact_law_of(f)->slowest;
        next[JO_PAIR_STATES * i + JO_CONTACT_SINCE] = state[JO_PAIR_STATES * last + JO_CONTACT_SINCE];
    }
    if (p->mesh.triangles) jo_pair_list_on_mesh(f, p, state, next);
    else list_corners(f, p, state, next);
    for (int i = 0; i < f->states; i++) state[i] = next[i];
}

static void start(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    pair p;
    point t;
    for (int i = 0; i < f->states; i++) state[i] = jo_same(0.0);
    read_motion(m, d, f, &p);
    list(f, &p, state);
    for (int i = 0; i < jo_pair_points(f); i++, state += JO_PAIR_STATES) {
        if (!jo_pair_is_listed(state)) continue;
        present(f, &p, state, &t);
        jo_contact_start(&t.law, d->time[0], &t.y, state);
    }
}

/* no error control by the stretch: it follows the positions */
static void nominals(const jo_model *m, const jo_force *f, double duration, double *x)
{
    (void)m; (void)duration;
    for (int i = 0; i < f->states; i++) x[i] = 1.0;
}

static jo_real update(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    pair p;
    point t;
    read_motion(m, d, f, &p);
    const jo_real before = energy(f, &p, state);
    list(f, &p, state);
    for (int i = 0; i < jo_pair_points(f); i++) {
        jo_real *own = state + JO_PAIR_STATES * i;
        if (!jo_pair_is_listed(own)) continue;
        const int apart = jo_contact_phase(own) == JO_CONTACT_APART;
        present(f, &p, own, &t);
        jo_contact_update(&t.law, jo_touches_wait(d), d->time[0], &t.y, own);
        if (apart) jo_contact_begun(d, &t.law, f->state, own);
    }
    return before - energy(f, &p, state);
}

static jo_real margin(const jo_model *m, const jo_data *d, const jo_force *f)
{
    const jo_real *state = states(d, f);
    pair p;
    if (!any_listed(f, state)) {
        jo_separated s;
        read(d, f, &p);
        return jo_same(separate(&p, state, &s));
    }
    jo_real least = {INFINITY};
    point t;
    read_motion(m, d, f, &p);
    for (int i = 0; i < jo_pair_points(f); i++, state += JO_PAIR_STATES) {
        if (!jo_pair_is_listed(state)) continue;
        present(f, &p, state, &t);
        const jo_real x = jo_contact_margin(&t.law, state, &t.y);
        if (JO_RE(x) < JO_RE(least)) least = x;
    }
    if (p.mesh.triangles) {
        const double further = jo_pair_further_gap(f, &p, states(d, f));
        if (further < JO_RE(least)) least = jo_same(further);
    }
    return least;
}

static double longest_step(const jo_model *m, const jo_data *d, const jo_force *f, int explicit_method)
{
    const jo_real *state = states(d, f);
    double longest = INFINITY;
    pair p;
    point t;
    const int moves = explicit_method || jo_contact_is_smooth(jo_contact_law_of(f));
    if (moves && any_listed(f, state)) read_motion(m, d, f, &p);
    for (int i = 0; i < jo_pair_points(f); i++, state += JO_PAIR_STATES) {
        if (!jo_pair_touches(state)) continue;
        if (moves) present(f, &p, state, &t);
        longest = fmin(longest, jo_contact_longest_step(jo_contact_law_of(f), state, d->time[0], explicit_method, moves ? &t.y : 0));
    }
    return longest;
}

static int ease(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    (void)m; (void)d;
    int changed = 0;
    for (int i = 0; i < jo_pair_points(f); i++, state += JO_PAIR_STATES)
        if (jo_pair_is_listed(state)) changed |= jo_contact_ease(state);
    return changed;
}

/* Curvature of the gap between two features: its rate changes by at most speed^2 x curvature x time. The rate is n . v at the foot points. As b
 * turns by w, its levers and planes do; across two edges at the angle x the normal turns by w / sin x and the foot slides by speed / sin x; about
 * a rounded vertex or edge the normal turns by speed / radius. */
static double bending(const pair *p, const jo_feature *g, const jo_approach *to)
{
    const double spin = jo_length(p->w, 3), turning = spin > 0.0 ? 3.0 * spin / jo_approach_speed(to) : 0.0, radius = jo_pair_radii(p);
    if (g->kind == JO_FACE_VERTEX || g->kind == JO_VERTEX_FACE) return turning;
    if (g->kind >= JO_ROUND_PAIR) return turning;
    if (g->kind != JO_EDGE_EDGE) return radius > 0.0 ? turning + 1.0 / radius : INFINITY;
    const double sine = fabs(JO_RE(jo_dot3(g->edge, g->across))) - spin * to->within;
    return sine > 0.0 ? turning / sine : INFINITY;
}

/* The lowest place of a round part, that which is nearest to the other shape, changes as it turns; the height of another quarter of a rim is a
 * convex function of the tilt, so that its rate does not fall by that. */
static void approach_round(const pair *p, double code, const jo_feature *g, jo_approach *to)
{
    const jo_feature_pair f = jo_feature_of(code);
    const double n[3] = {JO_RE(g->normal[0]), JO_RE(g->normal[1]), JO_RE(g->normal[2])};
    if (!jo_part_is_quarter(&f)) jo_pair_approach_part(p, code, n, to);
}

/* of the nearest point of the list that does not touch, on its face */
static int approach(const jo_model *m, const jo_data *d, const jo_force *f, jo_approach *to)
{
    const jo_real *state = states(d, f);
    pair p;
    point t;
    jo_feature nearest = {0};
    read_motion(m, d, f, &p);
    to->seen = f->state;
    to->convex = 0;
    double *reach = &jo_seen_speeds(d, f->state)[REACH];   /* the same in the stages and at the end */
    if (!to->at_end) *reach = jo_pair_reach(&p);
    if (p.mesh.triangles) return jo_pair_approach_mesh(f, &p, state, *reach, to);
    if (!any_listed(f, state)) {
        jo_separated s;
        const double gap = separate(&p, state, &s);
        jo_pair_approach_apart(&p, &s, gap, *reach, to);
        return 1;
    }
    to->gap = INFINITY;
    for (int i = 0; i < jo_pair_points(f); i++, state += JO_PAIR_STATES) {
        if (!jo_pair_is_listed(state) || jo_pair_touches(state)) continue;
        present(f, &p, state, &t);
        if (-JO_RE(t.y.depth) >= to->gap) continue;
        to->gap = -JO_RE(t.y.depth);
        to->rate = -JO_RE(t.y.rate);
        to->face = i;
        nearest = t.feature;
    }
    if (!(to->gap < INFINITY)) return 0;
    jo_pair_approach_speeds(&p, *reach, to);
    to->curvature = bending(&p, &nearest, to);
    if (nearest.kind >= JO_ROUND_PAIR) approach_round(&p, JO_RE(states(d, f)[JO_PAIR_STATES * to->face + JO_PAIR_CODE]), &nearest, to);
    to->gap = fmax(to->gap, 0.0) + jo_pair_round_off(&p);   /* one that an impulse has opened again is below 0 by the resolution of its instant */
    return 1;
}

/* a bristle that breaks changes mu_static to mu_kinetic; so do points that come and go */
static int jumps(const jo_force *f, const jo_real *before, const jo_real *after)
{
    for (int i = 0; i < jo_pair_points(f); i++, before += JO_PAIR_STATES, after += JO_PAIR_STATES) {
        if (!jo_pair_is_listed(before) && !jo_pair_is_listed(after)) continue;
        if (!jo_same_parts(JO_RE(before[JO_PAIR_CODE]), JO_RE(after[JO_PAIR_CODE])) || JO_RE(before[JO_PAIR_WEIGHT]) != JO_RE(after[JO_PAIR_WEIGHT])) return 1;
        if (jo_contact_phase(before) != jo_contact_phase(after)) return 1;
    }
    return 0;
}

static int strikes(const jo_model *m, const jo_data *d, const jo_force *f, jo_strike *points, int room)
{
    const jo_real *state = states(d, f);
    int found = 0;
    pair p;
    point t;
    if (!jo_contact_may_strike(jo_contact_law_of(f)) || !any_listed(f, state)) return 0;
    read_motion(m, d, f, &p);
    for (int i = 0; i < jo_pair_points(f) && found < room; i++, state += JO_PAIR_STATES) {
        if (!jo_pair_is_listed(state)) continue;
        present(f, &p, state, &t);
        found += jo_contact_strike(&t.law, jo_touches_wait(d), f, f->state + JO_PAIR_STATES * i, state, &t.y, points + found);
    }
    return found;
}

static int points(const jo_model *m, const jo_data *d, const jo_force *f, const jo_real *state, jo_touch *out, jo_real *sums)
{
    int count = 0;
    pair p;
    point t;
    if (!any_listed(f, state)) return 0;
    read_motion(m, d, f, &p);
    for (int i = 0; i < jo_pair_points(f); i++, state += JO_PAIR_STATES) {
        if (!jo_pair_is_listed(state)) continue;
        present(f, &p, state, &t);
        jo_contact_touch(d->marker[f->a].A, d->marker[f->b].r, &t.law, state, &t.y, out + count, sums);
        out[count++].feature = p.mesh.triangles ? -JO_RE(state[JO_PAIR_CODE]) : JO_RE(state[JO_PAIR_CODE]);
    }
    return count;
}

static const jo_yielding yielding = {update, margin, jumps, longest_step, ease, approach, strikes, points, 0};
const jo_force_kind jo_force_contact_pair = {apply, stored, tangent, start, nominals, &yielding};
