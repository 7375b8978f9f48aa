/* contact_turn.c - resistance to rolling and to drilling at a point of contact.
 *
 * A bristle t is stretched by the angular velocity w of b on a. Of each of its parts p, in the contact plane (rolling) and along the normal n
 * (drilling), with the length l_p, the moment on b is
 *   M_p = -l_p^2 (k t_p + c_p w_p), |M_p| <= l_p N,   k = dN/dd without loss,   t' = w - t max(0, k'/k)
 * N acts at most l_p beside the contact point, and k l_p^2 is the stiffness against tilting of a face of that size. Its damping is critical for
 * the smallest moment of inertia I, l_p^2 c_p = 2 l_p sqrt(k I), so that what has stopped does not rock. At the end of a step t is shortened to
 * |t_p| <= N / (k l_p), as in plasticity; the moment is limited within the step. Nothing switches, so that no event is located.
 * As with the bristle of friction no energy appears: t is shortened while k grows, and the moment falls with k. */
#include "maximal/maximal.h"
#include "contact/contact.h"
#include "force/contact_turn.h"

enum { ROLLING, DRILLING, PARTS };

static jo_real length_of(const jo_contact_data *x, int part) { return part == ROLLING ? x->rolling : x->drilling; }
static int acts(const jo_real *state, const jo_contact_point *y) { return jo_contact_phase(state) != JO_CONTACT_APART && JO_RE(y->depth) > 0.0; }

/* part of a vector in the contact plane or along the normal */
static void part_of(int part, const jo_real *n, const jo_real *v, jo_real *out)
{
    const jo_real along = jo_dot3(n, v);
    for (int i = 0; i < 3; i++) out[i] = part == ROLLING ? v[i] - along * n[i] : along * n[i];
}

/* l c; 0 where the law has no slope */
static jo_real damping(const jo_contact_data *x, const jo_contact_point *y)
{
    return JO_RE(y->slope) > 0.0 ? 2.0 * jo_sqrt(y->slope * x->inertia) : 0.0;
}

/* l (k t + c w) */
static void pull(const jo_contact_data *x, int part, const jo_real *t, const jo_contact_point *y, jo_real *q)
{
    const jo_real k = length_of(x, part) * y->slope, c = damping(x, y);
    for (int i = 0; i < 3; i++) q[i] = k * t[i] + c * y->w[i];
}

/* relative rate of the stiffness while it grows */
static jo_real growth(const jo_contact_point *y)
{
    const jo_real g = JO_RE(y->slope) > 0.0 ? y->bend * y->rate / y->slope : 0.0;
    return JO_RE(g) > 0.0 ? g : 0.0;
}

jo_real jo_turn_energy(const jo_contact_data *x, const jo_real *state, const jo_contact_point *y)
{
    jo_real sum = {0.0}, t[3];
    if (!acts(state, y)) return sum;
    for (int p = 0; p < PARTS; p++) {
        const jo_real l = length_of(x, p);
        part_of(p, y->normal, state + JO_TURN_FIRST, t);
        sum += 0.5 * l * l * y->slope * jo_dot3(t, t);
    }
    return sum;
}

void jo_turn_moment(const jo_contact_data *x, const jo_real *state, const jo_contact_point *y, jo_real *M, jo_work *power)
{
    jo_real whole[3], q[3];
    for (int p = 0; p < PARTS; p++) {
        const jo_real l = length_of(x, p);
        pull(x, p, state + JO_TURN_FIRST, y, whole);
        part_of(p, y->normal, whole, q);
        const jo_real size = jo_length3(q);
        if (!(JO_RE(l * size) > 0.0)) continue;
        const jo_real share = JO_RE(size) > JO_RE(y->N) ? l * y->N / size : l;
        jo_axpy3(M, -share, q);
        power->friction += share * jo_dot3(q, y->w);
    }
}

/* change of the moment, for the changes c of the contact, dt of the stretch and dw of the angular velocity; adds */
static void moment_change(const jo_contact_data *x, const jo_real *t, const jo_contact_point *y, const jo_contact_change *c, const jo_real *dt,
                          const jo_real *dw, jo_real *dM)
{
    const jo_real *n = y->normal, dN = y->by_depth * c->depth + y->by_rate * c->rate;
    const jo_real loss = damping(x, y), dloss = JO_RE(loss) > 0.0 ? 0.5 * loss * y->bend * c->depth / y->slope : 0.0;
    jo_real whole[3], change[3], q[3], dq[3];
    for (int p = 0; p < PARTS; p++) {
        const jo_real l = length_of(x, p);
        pull(x, p, t, y, whole);
        for (int i = 0; i < 3; i++)
            change[i] = l * (y->bend * c->depth * t[i] + y->slope * dt[i]) + dloss * y->w[i] + loss * dw[i];
        const jo_real along = jo_dot3(n, whole), dalong = jo_dot3(n, change) + jo_dot3(c->normal, whole);
        part_of(p, n, whole, q);
        for (int i = 0; i < 3; i++) {
            dq[i] = dalong * n[i] + along * c->normal[i];
            if (p == ROLLING) dq[i] = change[i] - dq[i];
        }
        const jo_real size = jo_length3(q);
        if (!(JO_RE(size) > JO_RE(y->N))) {
            jo_axpy3(dM, -l, dq);
            continue;
        }
        const jo_real turned = jo_dot3(q, dq) / size;
        for (int i = 0; i < 3; i++) dM[i] -= l * (dN * q[i] + y->N * (dq[i] - turned * q[i] / size)) / size;
    }
}

void jo_turn_response(const jo_contact_data *x, const jo_stage *stage, const jo_real *state, const jo_contact_point *y, const jo_contact_change *c,
                      int k, jo_real *dM)
{
    const jo_real *t = state + JO_TURN_FIRST, g = growth(y);
    const double ca = stage->weights.a, cv = stage->weights.v;
    jo_real dt[3] = {0.0, 0.0, 0.0}, dw[3] = {0.0, 0.0, 0.0};
    if (k >= 9) dw[k - 9] = jo_same(1.0);
    if (ca != 0.0 && cv != 0.0) {   /* response of the state to w in a step */
        const jo_real dg = JO_RE(g) > 0.0 ? g * (c->rate / y->rate - c->depth / y->depth) : 0.0;
        for (int i = 0; i < 3; i++) dt[i] = cv / (ca + cv * g) * (dw[i] - dg * t[i]);
    } else if (k >= 3 && k < 6) {   /* turn of b on a */
        dt[k - 3] = jo_same(1.0);
    }
    moment_change(x, t, y, c, dt, dw, dM);
}

void jo_turn_move_states(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_contact_point *y)
{
    static const jo_slopes_of_state none = {0.0, 0.0, 0.0, 0.0};
    const int moves = acts(d->w + (d->nw - d->forces.nstate) + f->state, y);
    const jo_real decay = moves ? growth(y) : 0.0;
    for (int i = 0; i < JO_TURN_STATES; i++) {
        const int k = f->state + JO_TURN_FIRST + i;
        const jo_real rate = moves ? y->w[i] - decay * jo_states(m, d)[k] : 0.0;
        if (jo_condenses(stage)) {
            jo_condense_state(m, d, stage, k, rate, decay);
            continue;
        }
        jo_state_rates(m, d)[k] = rate;
        if (stage->set && !stage->earlier) d->forces.slopes[k] = none;
    }
}

/* stretch of a part shortened to its limit, or stretched to it along `t` */
static void fit(const jo_contact_data *x, const jo_contact_point *y, int part, int stretches, const jo_real *t, jo_real *out)
{
    jo_real own[3];
    part_of(part, y->normal, t, own);
    const jo_real l = length_of(x, part), size = jo_length3(own);
    const jo_real full = JO_RE(l * y->slope) > 0.0 ? y->N / (l * y->slope) : 0.0;
    const int fits = !stretches && JO_RE(size) <= JO_RE(full);
    jo_axpy3(out, fits || !(JO_RE(size) > 0.0) ? jo_same(1.0) : full / size, own);
}

/* A part slips from the first instant on if its limit grows more slowly than its moment: l dN/dd / N w > d'/d. */
void jo_turn_start(const jo_contact_data *x, const jo_contact_point *y, jo_real *state)
{
    jo_real *t = state + JO_TURN_FIRST, w[3];
    for (int i = 0; i < 3; i++) t[i] = jo_same(0.0);
    for (int p = 0; p < PARTS && acts(state, y); p++) {
        part_of(p, y->normal, y->w, w);
        if (JO_RE(length_of(x, p) * x->exponent * jo_length3(w)) > JO_RE(y->rate)) fit(x, y, p, 1, w, t);
    }
}

void jo_turn_update(const jo_contact_data *x, const jo_contact_point *y, jo_real *state)
{
    jo_real *t = state + JO_TURN_FIRST;
    const jo_real old[3] = {t[0], t[1], t[2]};
    for (int i = 0; i < 3; i++) t[i] = jo_same(0.0);
    for (int p = 0; p < PARTS && acts(state, y); p++) fit(x, y, p, 0, old, t);
}

double jo_turn_rate(const jo_contact_data *x, const jo_contact_point *y)
{
    const double l = fmax(JO_RE(x->rolling), JO_RE(x->drilling));
    return 3.0 * l * sqrt(JO_RE(y->slope / x->inertia));   /* w + c / I */
}

void jo_turn_implicit(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_contact_point *y)
{
    static const jo_contact_change none;
    static const jo_real zero[3] = {0.0, 0.0, 0.0};
    const jo_contact_data *x = (const jo_contact_data *)f->data;
    const jo_real *state = jo_states(m, d) + f->state;
    jo_contact_matrix *c = jo_contact_in_matrix(d, f->state + JO_TURN_FIRST);
    if (!stage->earlier) {
        c->closed = jo_matrix_takes_contacts(d) && acts(state, y);
        if (!c->closed) return;
        c->force = f;
        c->state = f->state + JO_TURN_FIRST;
        c->follows = 1;
        for (int k = 0; k < 3; k++) {
            const jo_real unit[3] = {jo_same(k == 0), jo_same(k == 1), jo_same(k == 2)};
            jo_real by_rate[3] = {0.0}, by_stretch[3] = {0.0};
            moment_change(x, state + JO_TURN_FIRST, y, &none, zero, unit, by_rate);
            moment_change(x, state + JO_TURN_FIRST, y, &none, unit, zero, by_stretch);
            for (int i = 0; i < 3; i++) {
                c->K[3 * i + k] = jo_same(0.0);
                c->D[3 * i + k] = -by_rate[i];
                c->B[3 * i + k] = -by_stretch[i];
            }
        }
        jo_set3(c->point, d->marker[f->b].r);
        jo_set3(c->normal, y->normal);
        jo_contact_place_in_matrix(m, d, stage, c);
        for (int i = 0; i < 3; i++) {
            c->u[i] = -y->w[i];
            c->w[i] = c->S[i] = jo_same(0.0);
        }
    }
    if (c->closed) jo_contact_push(m, d, stage, c, zero);
}

void jo_turn_touch(const jo_contact_data *x, const jo_real *state, const jo_contact_point *y, jo_touch *t, jo_real *sums)
{
    const jo_real stored = jo_turn_energy(x, state, y);
    jo_work power = {0.0, 0.0, 0.0};
    jo_real M[3] = {0.0};
    if (!acts(state, y)) return;
    jo_turn_moment(x, state, y, M, &power);
    sums[1] += stored;
    t->stored[1] += JO_RE(stored);
    t->power[1] += JO_RE(power.friction);
}
