/* force_contact_track.c - a wheel or ball at b touches a track: a smooth curve through markers of any bodies, such as nodes of a beam.
 *
 * From marker i to the next one the track is a cubic through both origins with the tangents of both frames (Hermite; x: share of the way,
 * L: length): r(x) = h00 r_i + h10 L A_i t_i + h01 r_j + h11 L A_j t_j. The wheel is at the place where (r_b - r(x)) . r'(x) = 0. With t = r' / |r'|,
 * the direction u of the top between both markers, n = (u - (u . t) t) / |.| and m = n x t:
 *   depth d = radius - (r_b - r) . n;   common point P = r_b - (radius - d / 2) n
 * The force F and law of this point are those of force_contact.c, resolved in [t, m, n], which moves along. F at b has the lever P - r_b; -F acts on
 * the markers by the virtual work of the curve: shares h of the force, h L t x F of the moments, and the moment of the lever P - r by shares of
 * the way. So no momentum is made, and the power is that of the velocity of P on the track.
 *
 * Beyond the ends there is no track. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/contact_track.h"

#define JO_TRACK_PIECE JO_CONTACT_STATES   /* state after those of a point: the piece on which the wheel is */

static const jo_contact_track_data *numbers(const jo_force *f) { return (const jo_contact_track_data *)f->data; }
static jo_real *states(const jo_data *d, const jo_force *f) { return d->w + (d->nw - d->forces.nstate) + f->state; }

/* Where the wheel is. */
typedef struct { int piece; jo_track_part part; jo_track_frame b; jo_track_touch at; jo_contact_point point; } rider;

/* the point of contact, resolved in [t, m, n], without its force */
static void point_of(const jo_track_touch *y, jo_contact_point *p)
{
    for (int i = 0; i < 3; i++) {
        p->normal[i] = jo_same(i == 2);
        p->lever[i] = p->w[i] = jo_same(0.0);
        p->slip[i] = i < 2 ? y->v.v[i] : jo_same(0.0);
    }
    jo_set3(p->v, y->v.v);
    p->depth = y->depth.v;
    p->rate = -y->v.v[2];
}

/* the wheel at present, with its force for the states `state` unless it is NULL; 0 beyond the ends */
static int present(const jo_model *m, const jo_data *d, const jo_force *f, const jo_real *state, rider *y)
{
    jo_dual x;
    const int guess = (int)JO_RE(states(d, f)[JO_TRACK_PIECE]), count = (int)JO_RE(numbers(f)->count);
    y->b = jo_track_frame_of(m, d, f->b);
    y->piece = jo_track_find(m, d, jo_track_pieces(f), count, &y->b, guess >= 0 && guess < count ? guess : 0, &x);
    if (y->piece < 0) {
        for (int i = 0; i < 3; i++) y->point.slip[i] = y->point.v[i] = y->point.normal[i] = jo_same(0.0);
        y->point.depth = jo_same(-1.0);
        y->point.rate = jo_same(0.0);
    } else {
        y->part = jo_track_part_of(m, d, jo_track_pieces(f) + y->piece);
        y->at = jo_track_touch_at(numbers(f)->radius, &y->part, &y->b, x.v);
        point_of(&y->at, &y->point);
    }
    if (state) {
        jo_contact_press(jo_contact_law_of(f), state, &y->point);
        jo_contact_stretched(state + JO_CONTACT_STRETCH, &y->point);
    }
    return y->piece >= 0;
}

static int is_closed(const jo_real *state, const rider *y)
{
    return jo_contact_phase(state) != JO_CONTACT_APART && JO_RE(y->point.depth) > 0.0;
}

static jo_real stored(const jo_data *d, const jo_force *f)
{
    rider y;
    return present(0, d, f, states(d, f), &y) ? jo_contact_energy(jo_contact_phase(states(d, f)), &y.point) : jo_same(0.0);
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *out)
{
    static const jo_force_work none = {{0.0}, 0.0, 0.0, 0.0};
    static const jo_real still[3] = {0.0, 0.0, 0.0};
    const jo_contact_law *x = jo_contact_law_of(f);
    const jo_real *state = states(d, f);
    jo_real F[6];
    jo_dual3 load[3][2];
    rider y;
    if (present(m, d, f, state, &y) && jo_contact_phase(state) == JO_CONTACT_APART) jo_see_speed(d, f->state, y.at.v.v);
    jo_contact_move_states(m, d, stage, x, f->state, &y.point);
    jo_contact_hold_states(m, d, stage, f->state + JO_CONTACT_STATES, f->states - JO_CONTACT_STATES);
    *out = none;
    if (!is_closed(state, &y)) return JO_OK;
    jo_contact_force(x, jo_contact_phase(state), &y.point, F, &d->power);
    out->stored = jo_contact_energy(jo_contact_phase(state), &y.point);
    jo_track_loads(&y.at, &y.part, F, still, load);
    for (int i = 0; i < 2; i++) jo_push(m, d, (int)JO_RE(y.part.piece->marker[i]), load[i][0].v, load[i][1].v);
    jo_push(m, d, f->b, load[2][0].v, load[2][1].v);
    jo_set3(out->y, load[2][0].v);
    jo_set3(out->y + 3, load[2][1].v);
    return JO_OK;
}

/* ---- tangent ------------------------------------------------------------------------------------------ */

/* the rider with the k-th of [position, rotation, velocity, angular velocity] of an end or of b (side 2) changed, and this change */
static jo_contact_change change_of(const jo_force *f, const rider *now, int side, int k, rider *y)
{
    jo_contact_change c = {0.0, 0.0, {0.0}, {0.0}, {0.0}};
    *y = *now;
    jo_track_frame *moved = side < 2 ? &y->part.end[side] : &y->b;
    jo_dual3 *part = k < 3 ? &moved->r : k < 6 ? &moved->turn : k < 9 ? &moved->v : &moved->w;
    part->d[k % 3] = jo_same(1.0);
    jo_track_set_tangents(&y->part);
    y->at = jo_track_touch_at(numbers(f)->radius, &y->part, &y->b, now->at.x.v);
    c.depth = y->at.depth.d;
    c.rate = -y->at.v.d[2];
    for (int i = 0; i < 2; i++) c.slip[i] = y->at.v.d[i];
    return c;
}

/* change of the stretch: by its response in a step; for equilibria and vibrations by the displacement of b on the track */
static void stretch_change(const jo_stage *stage, const jo_real *state, const rider *y, const jo_contact_change *c, int side, int k, jo_real *ds)
{
    const double ca = stage->weights.a, cv = stage->weights.v;
    const jo_real *s = state + JO_CONTACT_STRETCH, g = jo_contact_growth(&y->point);
    for (int i = 0; i < 3; i++) ds[i] = jo_same(0.0);
    if (!jo_contact_follows(jo_contact_phase(state))) return;
    if (ca != 0.0 && cv != 0.0) {
        const jo_real dg = JO_RE(g) > 0.0 ? g * (c->rate / y->point.rate - c->depth / y->point.depth) : 0.0;
        for (int i = 0; i < 2; i++) ds[i] = cv / (ca + cv * g) * (c->slip[i] - dg * s[i]);
    } else if (k < 6) {
        static const jo_real none[3] = {0.0, 0.0, 0.0};
        jo_dual3 move[2][3];
        for (int i = 0; i < 3; i++) move[0][i] = move[1][i] = jo_dual3_of(none, none);
        move[k / 3][side].v[k % 3] = jo_same(1.0);
        const jo_dual3 moved = jo_track_relative(&y->at, &y->part, move[0], move[1]);
        for (int i = 0; i < 2; i++) ds[i] = moved.v[i];
    }
}

static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *unused)
{
    (void)unused;
    const jo_contact_law *x = jo_contact_law_of(f);
    const jo_real *state = states(d, f);
    jo_work power = {0.0, 0.0, 0.0};
    jo_real F[6], dF[3], ds[3];
    jo_real Y[2][2][12][24] = {{{{0.0}}}};   /* rows: ends, b; columns: ends, b */
    jo_dual3 load[3][2];
    rider now, y;
    if (!present(m, d, f, state, &now) || !is_closed(state, &now)) return JO_OK;
    jo_contact_force(x, jo_contact_phase(state), &now.point, F, &power);
    for (int side = 0; side < 3; side++)
        for (int k = 0; k < 12; k++) {
            const jo_contact_change c = change_of(f, &now, side, k, &y);
            stretch_change(stage, state, &y, &c, side, k, ds);
            jo_contact_force_change(x, jo_contact_phase(state), &now.point, &c, ds, dF);
            jo_track_loads(&y.at, &y.part, F, dF, load);
            for (int i = 0; i < 18; i++) Y[i / 12][side / 2][i % 12][12 * (side % 2) + k] = load[i / 6][i % 6 / 3].d[i % 3];
        }
    jo_track_add_elements(m, d, &now.part, f->b, load, Y);
    return JO_OK;
}

/* ---- states ------------------------------------------------------------------------------------------- */

static void start(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    rider y;
    state[JO_TRACK_PIECE] = jo_same(0.0);
    const int found = present(m, d, f, 0, &y);
    jo_contact_start(jo_contact_law_of(f), d->time[0], &y.point, state);
    state[JO_TRACK_PIECE] = jo_same(found ? y.piece : 0);
}

/* no error control by the stretch: it follows the positions */
static void nominals(const jo_model *m, const jo_force *f, double duration, double *x)
{
    (void)m; (void)duration;
    for (int i = 0; i < f->states; i++) x[i] = 1.0;
}

static jo_real update(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    rider y;
    if (present(m, d, f, states(d, f), &y)) state[JO_TRACK_PIECE] = jo_same(y.piece);
    return jo_contact_update(jo_contact_law_of(f), 0, d->time[0], &y.point, state);
}

static jo_real margin(const jo_model *m, const jo_data *d, const jo_force *f)
{
    rider y;
    present(m, d, f, states(d, f), &y);
    return jo_contact_margin(jo_contact_law_of(f), states(d, f), &y.point);
}

static double longest_step(const jo_model *m, const jo_data *d, const jo_force *f, int explicit_method)
{
    rider y;
    if (explicit_method && jo_contact_phase(states(d, f)) != JO_CONTACT_APART) present(m, d, f, states(d, f), &y);
    return jo_contact_longest_step(jo_contact_law_of(f), states(d, f), d->time[0], explicit_method, explicit_method ? &y.point : 0);
}

static int ease(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    (void)m; (void)d; (void)f;
    return jo_contact_ease(state);
}

static int approach(const jo_model *m, const jo_data *d, const jo_force *f, jo_approach *to)
{
    rider y;
    if (jo_contact_phase(states(d, f)) != JO_CONTACT_APART || !present(m, d, f, 0, &y)) return 0;
    to->gap = -JO_RE(y.point.depth);
    to->rate = -JO_RE(y.point.rate);
    to->curvature = y.at.curvature;
    to->face = to->convex = 0;
    to->seen = f->state;
    for (int i = 0; i < 3; i++) to->v[i] = JO_RE(y.at.v.v[i]);
    return 1;
}

static int jumps(const jo_force *f, const jo_real *before, const jo_real *after)
{
    (void)f;
    return jo_contact_phase(before) != jo_contact_phase(after);
}

static int touches(const jo_model *m, const jo_data *d, const jo_force *f, const jo_real *state, jo_touch *t, jo_real *sums)
{
    rider y;
    jo_real A[9], origin[3];
    if (!present(m, d, f, state, &y)) return 0;
    for (int i = 0; i < 3; i++) {
        origin[i] = d->marker[f->b].r[i] + y.at.lever.v[i];
        for (int k = 0; k < 3; k++) A[3 * i + k] = y.at.axis[k].v[i];
    }
    jo_contact_touch(A, origin, jo_contact_law_of(f), state, &y.point, t, sums);
    return 1;
}

static const jo_yielding yielding = {update, margin, jumps, longest_step, ease, approach, 0, touches, 0};
const jo_force_kind jo_force_contact_track = {apply, stored, tangent, start, nominals, &yielding};
