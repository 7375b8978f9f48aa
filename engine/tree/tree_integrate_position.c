/* tree_integrate_position.c - the state of a tree in joint coordinates is moved, and watched. */
#include "maximal/maximal.h"
#include "force/force.h"
#include "tree/tree_links.h"

#define JO_LARGEST 1e15     /* as in state.c */

/* neither balls nor free bodies: coordinates and rates are one for one */
static int plain(const jo_model *m) { return m->nx == m->nu; }

void jo_tree_displace(const jo_model *m, jo_real *x, const jo_real *x0, const jo_real *increment)
{
    if (plain(m)) {
        int i = 0;
        for (; i + JO_WIDTH <= m->nu; i += JO_WIDTH) JO_STORE(x + i) = JO_LOAD(x0 + i) + JO_LOAD(increment + i);
        for (; i < m->nu; i++) x[i] = x0[i] + increment[i];   /* rates follow in memory */
        return;
    }
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const jo_real *from = x0 + k->x, *by = increment + k->u;
        jo_real *to = x + k->x;
        switch (k->type) {
        case JO_LINK_HINGE:
        case JO_LINK_SLIDE: to[0] = from[0] + by[0]; break;
        case JO_LINK_BODY:
            for (int j = 0; j < m->body[k->body].n; j++) to[7 + j] = from[7 + j] + by[6 + j];
            /* fall through */
        case JO_LINK_FREE:
            for (int j = 0; j < 3; j++) to[j] = from[j] + by[j];
            to += 3, from += 3, by += 3;
            /* fall through */
        case JO_LINK_BALL:
            jo_turn_on(to, from, by);
            break;
        default: break;
        }
    }
}

void jo_tree_increment_rate(const jo_model *m, jo_real *rate, const jo_real *x, const jo_real *u)
{
    if (plain(m)) {
        JO_EACH(i, m->nu) JO_STORE(rate + i) = JO_LOAD(u + i);
        return;
    }
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const int at = k->u;
        switch (k->type) {
        case JO_LINK_HINGE:
        case JO_LINK_SLIDE: rate[at] = u[at]; break;
        case JO_LINK_BODY:
            for (int j = 6; j < 6 + m->body[k->body].n; j++) rate[at + j] = u[at + j];
            /* fall through */
        case JO_LINK_FREE:
            jo_set3(rate + at, u + at);
            jo_rotation_rate(rate + at + 3, x + at + 3, u + at + 3);
            break;
        case JO_LINK_BALL: jo_rotation_rate(rate + at, x + at, u + at); break;
        default: break;
        }
    }
}

/* rotation vector of the turn from e0 to e, below half a turn, in the frame of e0 */
void jo_turn_between(jo_real *theta, const jo_real *e0, const jo_real *e)
{
    const jo_real c = e0[0] * e[0] + e0[1] * e[1] + e0[2] * e[2] + e0[3] * e[3];
    jo_real x[3];
    x[0] = e0[0] * e[1] - e0[1] * e[0] - e0[2] * e[3] + e0[3] * e[2];
    x[1] = e0[0] * e[2] - e0[2] * e[0] - e0[3] * e[1] + e0[1] * e[3];
    x[2] = e0[0] * e[3] - e0[3] * e[0] - e0[1] * e[2] + e0[2] * e[1];
    const jo_real s = jo_dot3(x, x), sine = jo_sqrt(s);
    /* 2 asin(u) / u for small angles */
    const jo_real f = JO_RE(s) < 1e-5 ? 2.0 + s * (1.0 / 3.0 + s * (3.0 / 20.0 + s * (5.0 / 56.0)))
                                      : 2.0 * jo_arc_tangent(sine, c) / sine;
    for (int i = 0; i < 3; i++) theta[i] = f * x[i];
}

/* what is prescribed has its value and rate of this time, and its acceleration */
void jo_tree_drives(const jo_model *m, jo_data *d)
{
    for (int i = 0; d->tree.ndriven && i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        if (k->driven < 0) continue;
        const jo_line_data *line = m->line[k->driven].data;
        const jo_signal_work s = jo_signal_at(m, d, m->line[k->driven].signal, d->time[0]);
        const jo_real factor = jo_link_sign(k) * line->factor[0];
        d->tree.x[k->x] = (s.value + line->offset) / factor;
        d->tree.u[k->u] = s.rate / factor;
        d->tree.ud[k->u] = s.second / factor;
    }
}

int jo_tree_check(const jo_model *m, jo_data *d)
{
    const jo_real *x = d->tree.x;   /* and u behind it */
    const int n = m->nx + m->nu;
    jo_lanes squares = {0.0};
    double sum = 0.0;
    int at = 0;
    for (; at + JO_WIDTH <= n; at += JO_WIDTH) squares += JO_LOAD(x + at) * JO_LOAD(x + at);
    for (; at < n; at++) sum += JO_RE(x[at] * x[at]);
    if (sum + JO_RE(jo_sum(squares)) < JO_LARGEST * JO_LARGEST) return JO_OK;
    sum = 0.0;   /* which link */
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const int next_x = i + 1 < m->nlink ? k[1].x : m->nx, next_u = i + 1 < m->nlink ? k[1].u : m->nu;
        for (int j = k->x; j < next_x; j++) sum += JO_RE(jo_magnitude(d->tree.x[j]));
        for (int j = k->u; j < next_u; j++) sum += JO_RE(jo_magnitude(d->tree.u[j]));
        if (sum < JO_LARGEST && i + 1 < m->nlink) continue;
        d->error_index = k->body >= 0 ? k->body : k[1].body;
        return JO_NOT_FINITE;
    }
    return JO_OK;
}

double jo_tree_turned(const jo_model *m, jo_data *d)
{
    double turn = 0.0;
    jo_tree_spread(m, d, d->dq, d->lag);
    for (int i = 0; i < m->nbody; i++) turn = jo_larger(turn, jo_length(d->lag + m->body[i].iv + 3, 3));
    return turn;
}
