/* track_curve.c - a smooth curve through markers, the place of a wheel on it, and loads at this place. See force_contact_track.c. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/contact_track.h"

enum { JO_TRACK_SEARCH = 30 };     /* largest number of iterations for the place of the wheel on the track */
#define JO_TRACK_CLOSE 1e-14       /* change of the share of the way at which the place is found */
#define JO_TRACK_SIDE 1e-9         /* share of the way beyond an end of a piece that counts as rounding */

jo_track_frame jo_track_frame_of(const jo_model *m, const jo_data *d, int marker)
{
    static const jo_real none[3] = {0.0, 0.0, 0.0};
    const jo_marker_work *k = &d->marker[marker];
    jo_real v[3], w[3];
    jo_track_frame y;
    jo_set3(v, none);
    jo_set3(w, none);
    if (m) {
        jo_to_world(v, m, d, marker, k->v);
        jo_to_world(w, m, d, marker, k->om);
    }
    y.r = jo_dual3_of(k->r, none);
    y.turn = jo_dual3_of(none, none);
    y.v = jo_dual3_of(v, none);
    y.w = jo_dual3_of(w, none);
    y.A = k->A;
    return y;
}

/* a vector of the marker, world, and its change with the rotation of the marker */
static jo_dual3 carried(const jo_track_frame *k, const jo_real *local)
{
    jo_dual3 y;
    jo_mul3(y.v, k->A, local);
    jo_cross(y.d, k->turn.d, y.v);
    return y;
}

static jo_track_shares shares(jo_dual x)
{
    static const double c[4][4] = {{1.0, 0.0, -3.0, 2.0}, {0.0, 1.0, -2.0, 1.0}, {0.0, 0.0, 3.0, -2.0}, {0.0, 0.0, -1.0, 1.0}};
    jo_track_shares y;
    for (int i = 0; i < 4; i++) {
        const jo_real a = c[i][1], b = c[i][2], e = c[i][3];
        const jo_real first = a + x.v * (2.0 * b + x.v * 3.0 * e), second = 2.0 * b + 6.0 * e * x.v;
        y.h[i] = jo_dual_of(c[i][0] + x.v * (a + x.v * (b + x.v * e)), first * x.d);
        y.g[i] = jo_dual_of(first, second * x.d);
        y.f[i] = jo_dual_of(second, 6.0 * e * x.d);
    }
    return y;
}

/* sum of shares of both origins and both tangents L t */
static jo_dual3 along_curve(const jo_dual *h, const jo_track_frame *ends, const jo_dual3 *tangent)
{
    jo_dual3 y = jo_dual3_times(h[0], ends[0].r);
    y = jo_dual3_axpy(y, h[1], tangent[0]);
    y = jo_dual3_axpy(y, h[2], ends[1].r);
    return jo_dual3_axpy(y, h[3], tangent[1]);
}

void jo_track_set_tangents(jo_track_part *y)
{
    for (int i = 0; i < 2; i++)
        y->tangent[i] = jo_dual3_times(jo_dual_of(y->piece->length, jo_same(0.0)), carried(&y->end[i], y->piece->tangent[i]));
}

jo_track_part jo_track_part_of(const jo_model *m, const jo_data *d, const jo_track_piece *piece)
{
    jo_track_part y;
    y.piece = piece;
    for (int i = 0; i < 2; i++) y.end[i] = jo_track_frame_of(m, d, (int)JO_RE(piece->marker[i]));
    jo_track_set_tangents(&y);
    return y;
}

/* (r_b - r) . r' at the share x of the way, and its slope with respect to x in *slope */
static jo_dual off_normal(const jo_track_part *p, const jo_track_frame *b, jo_dual x, jo_real *slope)
{
    const jo_track_shares s = shares(x);
    const jo_dual3 to = jo_dual3_sub(b->r, along_curve(s.h, p->end, p->tangent)), first = along_curve(s.g, p->end, p->tangent);
    const jo_dual3 second = along_curve(s.f, p->end, p->tangent);
    *slope = jo_dot3(to.v, second.v) - jo_dot3(first.v, first.v);
    return jo_dual3_dot(to, first);
}

/* share x of the way in a piece, from `start` by Newton's method within -1 .. 2; its change follows from that of the equation */
static jo_dual place_on(const jo_track_part *p, const jo_track_frame *b, jo_real start)
{
    jo_dual x = jo_dual_of(start, jo_same(0.0));
    jo_real slope;
    for (int i = 0; i < JO_TRACK_SEARCH; i++) {
        const jo_real change = off_normal(p, b, x, &slope).v / slope;
        x.v -= change;
        if (JO_RE(x.v) < -1.0 || JO_RE(x.v) > 2.0) x.v = jo_same(JO_RE(x.v) < -1.0 ? -1.0 : 2.0);
        if (fabs(JO_RE(change)) < JO_TRACK_CLOSE) break;
    }
    const jo_dual rest = off_normal(p, b, x, &slope);
    return jo_dual_of(x.v - rest.v / slope, -rest.d / slope);
}

/* the piece where the wheel is, from piece `guess` to its neighbours; -1: beyond the ends. *x: share of the way */
int jo_track_find(const jo_model *m, const jo_data *d, const jo_track_piece *pieces, int count, const jo_track_frame *b, int guess, jo_dual *x)
{
    int last = 0;
    for (int k = guess, tries = 0; tries < count + 2; tries++) {
        const jo_track_part p = jo_track_part_of(m, d, pieces + k);
        *x = place_on(&p, b, jo_same(last > 0 ? 0.0 : last < 0 ? 1.0 : 0.5));
        const int way = JO_RE(x->v) < -JO_TRACK_SIDE ? -1 : JO_RE(x->v) > 1.0 + JO_TRACK_SIDE ? 1 : 0;
        if (!way || way == -last) return k;   /* between two pieces with a corner: the last one */
        if (k + way < 0 || k + way >= count) return -1;
        k += way;
        last = way;
    }
    return guess;
}

/* that of the track at P: of the curve at this place, with the rotation of both frames by shares of the way */
jo_dual3 jo_track_relative(const jo_track_touch *y, const jo_track_part *p, const jo_dual3 *v, const jo_dual3 *w)
{
    const jo_dual rest = jo_dual_sub(jo_dual_constant(1.0), y->x);
    jo_dual3 track = jo_dual3_axpy(jo_dual3_times(y->s.h[0], v[0]), y->s.h[2], v[1]), part;
    const jo_dual3 turn = jo_dual3_axpy(jo_dual3_times(rest, w[0]), y->x, w[1]);
    for (int i = 0; i < 2; i++) track = jo_dual3_axpy(track, y->s.h[2 * i + 1], jo_dual3_cross(w[i], p->tangent[i]));
    track = jo_dual3_add(track, jo_dual3_cross(turn, y->off));
    const jo_dual3 own = jo_dual3_sub(jo_dual3_add(v[2], jo_dual3_cross(w[2], y->lever)), track);
    for (int i = 0; i < 3; i++) {
        const jo_dual along = jo_dual3_dot(own, y->axis[i]);
        part.v[i] = along.v;
        part.d[i] = along.d;
    }
    return part;
}

jo_track_touch jo_track_touch_at(jo_real wheel, const jo_track_part *p, const jo_track_frame *b, jo_real start)
{
    jo_track_touch y;
    y.x = place_on(p, b, start);
    y.s = shares(y.x);
    const jo_dual rest = jo_dual_sub(jo_dual_constant(1.0), y.x), share[2] = {rest, y.x};
    const jo_dual3 r = along_curve(y.s.h, p->end, p->tangent), to = jo_dual3_sub(b->r, r);
    const jo_dual3 tops[2] = {carried(&p->end[0], p->piece->top[0]), carried(&p->end[1], p->piece->top[1])};
    const jo_dual3 top = jo_dual3_axpy(jo_dual3_times(share[0], tops[0]), share[1], tops[1]);
    const jo_dual3 first = along_curve(y.s.g, p->end, p->tangent), second = along_curve(y.s.f, p->end, p->tangent);
    y.curvature = JO_RE(jo_length3(second.v) / jo_dot3(first.v, first.v));
    y.axis[0] = jo_dual3_unit(first);
    y.axis[2] = jo_dual3_unit(jo_dual3_sub(top, jo_dual3_times(jo_dual3_dot(top, y.axis[0]), y.axis[0])));
    y.axis[1] = jo_dual3_cross(y.axis[2], y.axis[0]);
    const jo_dual radius = jo_dual_of(wheel, jo_same(0.0));
    y.depth = jo_dual_sub(radius, jo_dual3_dot(to, y.axis[2]));
    y.lever = jo_dual3_times(jo_dual_sub(jo_dual_times(jo_same(0.5), y.depth), radius), y.axis[2]);
    y.off = jo_dual3_add(to, y.lever);
    const jo_dual3 v[3] = {p->end[0].v, p->end[1].v, b->v}, w[3] = {p->end[0].w, p->end[1].w, b->w};
    y.v = jo_track_relative(&y, p, v, w);
    return y;
}

void jo_track_loads(const jo_track_touch *y, const jo_track_part *p, const jo_real *F, const jo_real *dF, jo_dual3 (*load)[2])
{
    const jo_dual rest = jo_dual_sub(jo_dual_constant(1.0), y->x), share[2] = {rest, y->x};
    jo_dual3 world = jo_dual3_times(jo_dual_of(F[0], dF[0]), y->axis[0]);
    for (int i = 1; i < 3; i++) world = jo_dual3_axpy(world, jo_dual_of(F[i], dF[i]), y->axis[i]);
    const jo_dual3 back = jo_dual3_times(jo_dual_constant(-1.0), world), moment = jo_dual3_cross(y->off, back);
    for (int i = 0; i < 2; i++) {
        load[i][0] = jo_dual3_times(y->s.h[2 * i], back);
        load[i][1] = jo_dual3_times(y->s.h[2 * i + 1], jo_dual3_cross(p->tangent[i], back));
        load[i][1] = jo_dual3_axpy(load[i][1], share[i], moment);
    }
    load[2][0] = world;
    load[2][1] = jo_dual3_cross(y->lever, world);
}

/* changes Y of the loads on the markers `row` with the motion of the markers `column`; loads: those of the rows, NULL: counted already */
static void add_element(const jo_model *m, jo_data *d, const int *row, const int *column, const jo_dual3 (*load)[2], jo_real (*Y)[24])
{
    jo_element e;
    jo_element_start(&e, row[0], row[1]);
    e.of_a = column[0];
    e.of_b = column[1];
    for (int i = 0; i < 12; i++) {
        if (load && row[i / 6] >= 0) e.y[i] = load[i / 6][i % 6 / 3].v[i % 3];
        for (int j = 0; j < 24; j++) e.Y[i][j] = Y[i][j];
    }
    jo_element_finish(m, d, &e);
}

void jo_track_add_elements(const jo_model *m, jo_data *d, const jo_track_part *p, int b, jo_dual3 (*load)[2], jo_real (*Y)[2][12][24])
{
    const int ends[2] = {(int)JO_RE(p->piece->marker[0]), (int)JO_RE(p->piece->marker[1])}, own[2] = {b, -1};
    const jo_dual3 (*loads)[2] = (const jo_dual3 (*)[2])load;
    add_element(m, d, ends, ends, loads, Y[0][0]);
    add_element(m, d, ends, own, 0, Y[0][1]);
    add_element(m, d, own, ends, loads + 2, Y[1][0]);
    add_element(m, d, own, own, 0, Y[1][1]);
}
