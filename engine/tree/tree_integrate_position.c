/* tree_integrate_position.c - increments of joint coordinates, prescribed motion, and the check that the state is finite. */
#include "maximal/maximal.h"
#include "force/force.h"
#include "tree/tree_links.h"

#define JO_MAX_STATE 1e15   /* Euclidean norm of [x, u] above which the run stops with "not finite", as in state.c */
#define JO_SMALL_SINE2 1e-5 /* sin^2 of half an angle below which 2 asin(s) / s is computed by its series; its next term is 6e-22 */

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

/* theta = 2 atan2(|s|, c) s / |s| with [c, s] = e0^-1 o e: rotation vector from e0 to e in the frame of e0, |theta| < pi */
void jo_rotation_vector_between(jo_real *theta, const jo_real *e0, const jo_real *e)
{
    const jo_real c = e0[0] * e[0] + e0[1] * e[1] + e0[2] * e[2] + e0[3] * e[3];
    jo_real x[3];
    x[0] = e0[0] * e[1] - e0[1] * e[0] - e0[2] * e[3] + e0[3] * e[2];
    x[1] = e0[0] * e[2] - e0[2] * e[0] - e0[3] * e[1] + e0[1] * e[3];
    x[2] = e0[0] * e[3] - e0[3] * e[0] - e0[1] * e[2] + e0[2] * e[1];
    const jo_real s = jo_dot3(x, x), sine = jo_sqrt(s);
    /* f = 2 asin(|s|) / |s|, by its series for small angles */
    const jo_real f = JO_RE(s) < JO_SMALL_SINE2 ? 2.0 + s * (1.0 / 3.0 + s * (3.0 / 20.0 + s * (5.0 / 56.0)))
                                      : 2.0 * jo_arc_tangent(sine, c) / sine;
    for (int i = 0; i < 3; i++) theta[i] = f * x[i];
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
    double sum = 0.0;
    int at = 0;
    for (; at + JO_WIDTH <= n; at += JO_WIDTH) squares += JO_LOAD(x + at) * JO_LOAD(x + at);
    for (; at < n; at++) sum += JO_RE(x[at] * x[at]);
    if (sum + JO_RE(jo_sum(squares)) < JO_MAX_STATE * JO_MAX_STATE) return JO_OK;
    /* first link at which the sum of magnitudes exceeds the limit */
    sum = 0.0;
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const int next_x = i + 1 < m->nlink ? k[1].x : m->nx, next_u = i + 1 < m->nlink ? k[1].u : m->nu;
        for (int j = k->x; j < next_x; j++) sum += JO_RE(jo_magnitude(d->x[j]));
        for (int j = k->u; j < next_u; j++) sum += JO_RE(jo_magnitude(d->u[j]));
        if (sum < JO_MAX_STATE && i + 1 < m->nlink) continue;
        d->error_index = k->body >= 0 ? k->body : k[1].body;
        return JO_NOT_FINITE;
    }
    return JO_OK;
}

/* largest rotation of a body by the increments dq at the present orientations, rad */
double jo_tree_largest_rotation(const jo_model *m, jo_data *d)
{
    double turn = 0.0;
    jo_real *rates = d->tree.maximal_copy + m->nq;   /* scratch here */
    jo_tree_body_rates(m, d, d->dq, rates);
    for (int i = 0; i < m->nbody; i++) turn = jo_larger(turn, jo_length(rates + m->body[i].iv + 3, 3));
    return turn;
}
