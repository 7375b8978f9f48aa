/* tree_integrate_position.c - increments of joint coordinates, prescribed motion, and the check that the state is finite. */
#include "maximal/maximal.h"
#include "force/force.h"
#include "tree/tree_links.h"

#define JO_MAX_STATE 1e15   /* Euclidean norm of [x, u] above which the run stops with "not finite", as in state.c */

/* whether x' = u, that is, there are no balls and no free links */
static int is_vector_space(const jo_model *m) { return m->nx == m->nu; }

/* x = x0 o increment: sum, and e0 o exp(theta) for quaternions */
void jo_tree_add_increment(const jo_model *m, jo_real *x, const jo_real *x0, const jo_real *increment)
{
    if (is_vector_space(m)) {
        int i = 0;
        for (; i + JO_WIDTH <= m->nu; i += JO_WIDTH) JO_STORE(x + i) = JO_LOAD(x0 + i) + JO_LOAD(increment + i);
        for (; i < m->nu; i++) x[i] = x0[i] + increment[i];   /* not padded, since the rates follow in memory */
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
            jo_compose_rotation(to, from, by);
            break;
        default: break;
        }
    }
}

/* rate (nu) of the increment from the start of the step: u, and the inverse tangent operator times w for rotations */
void jo_tree_increment_rate(const jo_model *m, jo_real *rate, const jo_real *x, const jo_real *u)
{
    if (is_vector_space(m)) {
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

/* x = (signal + offset) / factor, u and ud likewise, of driven joints at the present time */
void jo_tree_prescribe_motion(const jo_model *m, jo_data *d)
{
    for (int i = 0; d->tree.ndriven && i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        if (k->driven < 0) continue;
        const jo_line_data *line = m->line[k->driven].data;
        const jo_signal_work s = jo_signal_at(m, d, m->line[k->driven].signal, d->time[0]);
        const jo_real factor = jo_link_sign(k) * line->factor[0];
        d->x[k->x] = (s.value + line->offset) / factor;
        d->u[k->u] = s.rate / factor;
        d->ud[k->u] = s.second / factor;
    }
}

/* JO_NOT_FINITE with the body in error_index if |[x, u]| is not below JO_MAX_STATE */
int jo_tree_check_state(const jo_model *m, jo_data *d)
{
    const jo_real *x = d->x;   /* u follows x in memory */
    const int n = m->nx + m->nu;
    jo_lanes squares = {0.0};
    jo_real rest = jo_same(0.0);
    int at = 0;
    for (; at + JO_WIDTH <= n; at += JO_WIDTH) squares += JO_LOAD(x + at) * JO_LOAD(x + at);
    for (; at < n; at++) rest += x[at] * x[at];
    if (!jo_spoil(d->u, JO_LESS(rest + jo_sum(squares), jo_same(JO_MAX_STATE * JO_MAX_STATE)))) return JO_OK;
    /* first link at which the sum of magnitudes exceeds the limit */
    double sum = 0.0;
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const int next_x = i + 1 < m->nlink ? k[1].x : m->nx, next_u = i + 1 < m->nlink ? k[1].u : m->nu;
        for (int j = k->x; j < next_x; j++) sum += jo_most(jo_magnitude(d->x[j]));
        for (int j = k->u; j < next_u; j++) sum += jo_most(jo_magnitude(d->u[j]));
        if (sum < JO_MAX_STATE && i + 1 < m->nlink) continue;
        d->error_index = k->body >= 0 ? k->body : k[1].body;
        return JO_NOT_FINITE;
    }
    return JO_OK;
}
