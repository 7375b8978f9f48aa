/* force_slider.c - a point b that slides along a track: a smooth curve through markers, see force_contact_track.c.
 *
 * At the place where (r_b - r(x)) . r'(x) = 0, with [t, m, n] of the curve there, to = r_b - r, and the velocity v of b on the track:
 *   across, where |to| is beyond the play: F = -stiffness (1 - play / |to|) to - damping [v_m, v_n];   N = |F|
 *   along: F_t = pull(t) + hold (reference(t) - s) + brake (reference'(t) - v_t) - (mu N + resistance) tanh(v_t / slow)
 * s is the length of the undeformed track to the place. Both sides receive the force at b, so that
 * the elastic force, which is along `to`, has the potential stiffness (|to| - play)^2 / 2.
 *
 * States, which change at the ends of steps only: the piece of the track, s, v_t. Beyond the ends there is no track and no force. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/contact_track.h"

enum { JO_SLIDER_PIECE = 0, JO_SLIDER_WAY = 1, JO_SLIDER_SPEED = 2 };

static const jo_slider_data *numbers(const jo_force *f) { return (const jo_slider_data *)f->data; }
static const jo_track_piece *pieces(const jo_force *f) { return (const jo_track_piece *)(numbers(f) + 1); }
static jo_real *states(const jo_data *d, const jo_force *f) { return d->w + (d->nw - d->forces.nstate) + f->state; }

/* where the slider is; aside: [to_m, to_n]; beyond: share of `to` beyond the play; way: s */
typedef struct { int piece; jo_track_part part; jo_track_frame b; jo_track_touch at; jo_dual aside[2], beyond, way; } rider;

/* the common point is b: to_m, to_n, the velocity of b on the track there, s, and the part of |to| beyond the play */
static void measure(const jo_force *f, rider *y)
{
    const jo_dual one = jo_dual_constant(1.0), play = jo_dual_of(numbers(f)->play, jo_same(0.0));
    const jo_dual3 v[3] = {y->part.end[0].v, y->part.end[1].v, y->b.v}, w[3] = {y->part.end[0].w, y->part.end[1].w, y->b.w};
    jo_real before = {0.0};
    for (int k = 0; k < y->piece; k++) before += pieces(f)[k].length;
    y->at.off = jo_dual3_sub(y->at.off, y->at.lever);
    y->at.lever = jo_dual3_times(jo_dual_constant(0.0), y->at.off);
    y->at.v = jo_track_relative(&y->at, &y->part, v, w);
    for (int i = 0; i < 2; i++) y->aside[i] = jo_dual3_dot(y->at.off, y->at.axis[1 + i]);
    y->way = jo_dual_plus(jo_dual_times(pieces(f)[y->piece].length, y->at.x), before);
    /* a constant without play, where |to| may be 0 */
    y->beyond = one;
    if (JO_RE(play.v) == 0.0) return;
    const jo_dual size = jo_dual_sqrt(jo_dual3_dot(y->at.off, y->at.off));
    y->beyond = JO_RE(size.v) > JO_RE(play.v) ? jo_dual_sub(one, jo_dual_div(play, size)) : jo_dual_constant(0.0);
}

/* the slider at present; 0 beyond the ends */
static int present(const jo_model *m, const jo_data *d, const jo_force *f, rider *y)
{
    jo_dual x;
    const int guess = (int)JO_RE(states(d, f)[JO_SLIDER_PIECE]), count = (int)JO_RE(numbers(f)->count);
    y->b = jo_track_frame_of(m, d, f->b);
    y->piece = jo_track_find(m, d, pieces(f), count, &y->b, guess >= 0 && guess < count ? guess : 0, &x);
    if (y->piece < 0) return 0;
    y->part = jo_track_part_of(m, d, pieces(f) + y->piece);
    y->at = jo_track_touch_at(jo_same(0.0), &y->part, &y->b, x.v);
    measure(f, y);
    return 1;
}

/* force F on b along [t, m, n] with its change; power: damping, friction and forces of outside, W */
static void force_of(const jo_model *m, const jo_data *d, const jo_force *f, double lead, const rider *y, jo_dual *F, jo_work *power)
{
    const jo_slider_data *x = numbers(f);
    const jo_real time = d->time[0] + lead;
    jo_dual v[3];
    for (int i = 0; i < 3; i++) v[i] = jo_dual_of(y->at.v.v[i], y->at.v.d[i]);
    const int touches = JO_RE(y->beyond.v) > 0.0;
    for (int i = 1; i < 3; i++) {
        const jo_dual push = jo_dual_times(-x->stiffness, jo_dual_mul(y->beyond, y->aside[i - 1])), loss = jo_dual_times(x->damping, v[i]);
        F[i] = touches ? jo_dual_sub(push, loss) : jo_dual_constant(0.0);
        if (touches) power->damping += loss.v * v[i].v;
    }
    /* drive */
    jo_dual drive = jo_dual_constant(0.0);
    if (f->signal >= 0) drive.v += jo_signal_at(m, d, f->signal, time).value;
    if (f->reference >= 0) {
        const jo_signal_work to = jo_signal_at(m, d, f->reference, time);
        drive = jo_dual_add(drive, jo_dual_sub(jo_dual_of(x->hold * to.value + x->brake * to.rate, jo_same(0.0)),
                                               jo_dual_add(jo_dual_times(x->hold, y->way), jo_dual_times(x->brake, v[0]))));
    }
    /* friction */
    const jo_dual N = jo_dual_sqrt(jo_dual_add(jo_dual_mul(F[1], F[1]), jo_dual_mul(F[2], F[2])));
    const jo_real e = jo_exp(-2.0 * jo_size(v[0].v / x->slow)), t = (JO_RE(v[0].v) < 0.0 ? -1.0 : 1.0) * (1.0 - e) / (1.0 + e);
    const jo_dual share = jo_dual_of(t, (1.0 - t * t) * v[0].d / x->slow);
    const jo_dual loss = jo_dual_mul(jo_dual_plus(jo_dual_times(x->mu, N), x->resistance), share);
    F[0] = jo_dual_sub(drive, loss);
    power->friction += loss.v * v[0].v;
    power->forces += drive.v * v[0].v;
}

/* loads on the markers of the piece and on b */
static void loads_of(const rider *y, const jo_dual *F, jo_dual3 (*load)[2])
{
    jo_real v[3], change[3];
    for (int i = 0; i < 3; i++) {
        v[i] = F[i].v;
        change[i] = F[i].d;
    }
    jo_track_loads(&y->at, &y->part, v, change, load);
}

static jo_real energy(const jo_force *f, const rider *y)
{
    const jo_real m = y->beyond.v * y->aside[0].v, n = y->beyond.v * y->aside[1].v;
    return 0.5 * numbers(f)->stiffness * (m * m + n * n);
}

static jo_real stored(const jo_data *d, const jo_force *f)
{
    rider y;
    return present(0, d, f, &y) ? energy(f, &y) : jo_same(0.0);
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *out)
{
    static const jo_force_work none = {{0.0}, 0.0, 0.0, 0.0};
    jo_dual F[3];
    jo_dual3 load[3][2];
    rider y;
    jo_contact_hold_states(m, d, stage, f->state, f->states);
    *out = none;
    if (!present(m, d, f, &y)) return JO_OK;
    force_of(m, d, f, stage->lead, &y, F, &d->power);
    out->stored = energy(f, &y);
    loads_of(&y, F, load);
    for (int i = 0; i < 2; i++) jo_push(m, d, (int)JO_RE(y.part.piece->marker[i]), load[i][0].v, load[i][1].v);
    jo_push(m, d, f->b, load[2][0].v, load[2][1].v);
    jo_set3(out->y, load[2][0].v);
    jo_set3(out->y + 3, load[2][1].v);
    return JO_OK;
}

static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *unused)
{
    (void)unused;
    jo_work power = {0.0, 0.0, 0.0};
    jo_real Y[2][2][12][24] = {{{{0.0}}}};   /* rows: ends, b; columns: ends, b */
    jo_dual F[3];
    jo_dual3 load[3][2];
    rider now, y;
    if (!present(m, d, f, &now)) return JO_OK;
    for (int side = 0; side < 3; side++)
        for (int k = 0; k < 12; k++) {   /* each of [position, rotation, velocity, angular velocity] */
            y = now;
            jo_track_frame *moved = side < 2 ? &y.part.end[side] : &y.b;
            jo_dual3 *part = k < 3 ? &moved->r : k < 6 ? &moved->turn : k < 9 ? &moved->v : &moved->w;
            part->d[k % 3] = jo_same(1.0);
            jo_track_set_tangents(&y.part);
            y.at = jo_track_touch_at(jo_same(0.0), &y.part, &y.b, now.at.x.v);
            measure(f, &y);
            force_of(m, d, f, stage->lead, &y, F, &power);
            loads_of(&y, F, load);
            for (int i = 0; i < 18; i++) Y[i / 12][side / 2][i % 12][12 * (side % 2) + k] = load[i / 6][i % 6 / 3].d[i % 3];
        }
    jo_track_add_elements(m, d, &now.part, f->b, load, Y);
    return JO_OK;
}

/* ---- states ------------------------------------------------------------------------------------------- */

static void note(const rider *y, jo_real *state)
{
    state[JO_SLIDER_PIECE] = jo_same(y->piece);
    state[JO_SLIDER_WAY] = y->way.v;
    state[JO_SLIDER_SPEED] = y->at.v.v[0];
}

static void start(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    rider y;
    for (int i = 0; i < f->states; i++) state[i] = jo_same(0.0);
    if (present(m, d, f, &y)) note(&y, state);
}

static void nominals(const jo_model *m, const jo_force *f, double duration, double *x)
{
    (void)m; (void)duration;
    for (int i = 0; i < f->states; i++) x[i] = 1.0;
}

static jo_real update(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    rider y;
    if (present(m, d, f, &y)) note(&y, state);
    return jo_same(0.0);
}

static jo_real margin(const jo_model *m, const jo_data *d, const jo_force *f)
{
    (void)m; (void)d; (void)f;
    return jo_same(1.0);
}

static const jo_yielding yielding = {update, margin, 0, 0, 0, 0, 0, 0, 0};
const jo_force_kind jo_force_slider = {apply, stored, tangent, start, nominals, &yielding};
