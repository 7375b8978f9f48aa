/* force.c - what pushes the bodies: loads at markers, springs, bushings, modal loads, user functions.
 *
 * Force F and torque T (world) at a marker: Q_R = F, Q_w = u x A^T F + A^T T, Q_p = Phi^T A^T F + (T(theta) Psi)^T A^T T
 * (Rantalainen 2007, eq. 3.68-3.83, corrected).
 */
#include "internal.h"

/* add force F and torque T (world) at the marker, which is not on ground, to the forces fr and fp of its body */
static void push(const jo_model *m, const jo_data *d, int marker, const jo_real *F, const jo_real *T, jo_real *fr, jo_real *fp)
{
    const jo_marker *k = &m->marker[marker];
    const jo_marker_work *w = &d->marker[marker];
    const jo_real *A = d->body[k->body].A;
    const int np = m->body[k->body].np;
    jo_real f[3], t[3], arm[3];
    jo_mul3t(f, A, F);
    jo_mul3t(t, A, T);
    jo_add3(fr, f);
    jo_cross(arm, w->u, f);
    jo_add3(fr + 3, arm);
    jo_add3(fr + 3, t);
    if (k->Phi)
        for (int j = 0; j < np; j++)
            fp[j] += w->Phi[j] * f[0] + w->Phi[np + j] * f[1] + w->Phi[2 * np + j] * f[2];
    if (k->Psi) {
        jo_mul3t(f, w->T, t);
        for (int j = 0; j < np; j++)
            fp[j] += w->Psi[j] * f[0] + w->Psi[np + j] * f[1] + w->Psi[2 * np + j] * f[2];
    }
}

void jo_push(const jo_model *m, jo_data *d, int marker, const jo_real *F, const jo_real *T)
{
    const int body = m->marker[marker].body;
    if (body >= 0) push(m, d, marker, F, T, d->body[body].fr, d->body[body].fp);
}

/* the same to the change of force that stands in y and yp of the body */
static void push_change(const jo_model *m, jo_data *d, int marker, const jo_real *F, const jo_real *T)
{
    const int body = m->marker[marker].body;
    if (body < 0) return;
    jo_body_work *w = &d->body[body];
    if (!w->pushed) {
        for (int j = 0; j < 6; j++) w->y[j] = 0.0;
        for (int j = 0; j < m->body[body].np; j++) w->yp[j] = 0.0;
        w->pushed = 1;
    }
    push(m, d, marker, F, T, w->y, w->yp);
}

static void load(const jo_model *m, jo_data *d, const jo_force *f, jo_force_work *y)
{
    const jo_marker_work *w = &d->marker[f->b];
    jo_real F[3], T[3], v[3], om[3], factor = 1.0, now = 1.0;
    if (f->signal >= 0) {
        factor = jo_signal_at(m, d, f->signal, d->time[0] + d->lead).value;
        now = d->lead != 0.0 ? jo_signal_at(m, d, f->signal, d->time[0]).value : factor;
    }
    jo_set3(F, f->data);
    jo_set3(T, f->data + 3);
    if (f->follow) {
        jo_mul3(F, w->A, F);
        jo_mul3(T, w->A, T);
    }
    jo_to_world(v, m, d, f->b, w->v);
    d->power[2] += now * jo_dot3(F, v);
    if (m->marker[f->b].turns) {
        jo_to_world(om, m, d, f->b, w->om);
        d->power[2] += now * jo_dot3(T, om);
    }
    for (int j = 0; j < 3; j++) {
        y->y[j] = F[j] *= factor;
        y->y[3 + j] = T[j] *= factor;
    }
    jo_push(m, d, f->b, F, T);
}

/* value of a signal, 0 and no rate for none */
static jo_signal_work optional(const jo_model *m, const jo_data *d, int signal, jo_real time)
{
    const jo_signal_work none = {0.0, 0.0, 0.0};
    return signal < 0 ? none : jo_signal_at(m, d, signal, time);
}

/* f along a coordinate does the virtual work f ds: its gradient says what acts on a and on b */
static void both_ends(const jo_model *m, jo_data *d, int coordinate, jo_real f,
                      void (*act)(const jo_model *, jo_data *, int, const jo_real *, const jo_real *))
{
    const jo_coordinate *c = &m->coordinate[coordinate];
    const jo_coordinate_work *w = &d->coordinate[coordinate];
    jo_real F[3], Ta[3], Tb[3];
    for (int j = 0; j < 3; j++) {
        F[j] = f * w->along[j];
        Ta[j] = f * w->turn_a[j];
        Tb[j] = f * w->turn_b[j];
    }
    act(m, d, c->b, F, Tb);
    for (int j = 0; j < 3; j++) F[j] = -F[j];
    act(m, d, c->a, F, Ta);
}

void jo_push_along(const jo_model *m, jo_data *d, int coordinate, jo_real f) { both_ends(m, d, coordinate, f, jo_push); }

void jo_push_change(const jo_model *m, jo_data *d, int coordinate, jo_real f) { both_ends(m, d, coordinate, f, push_change); }

/* force of a spring, damper, servo or actuator at `time` */
static jo_real along_at(const jo_model *m, const jo_data *d, const jo_force *f, jo_real time)
{
    const jo_coordinate_work *w = &d->coordinate[f->coordinate];
    const jo_real *x = f->data;
    const jo_signal_work reference = optional(m, d, f->reference, time);
    jo_real y = x[0] * (x[2] + reference.value - w->value) + x[1] * (reference.rate - w->rate);
    y += x[3] * (f->signal >= 0 ? jo_signal_at(m, d, f->signal, time).value : 1.0);
    y += optional(m, d, f->spring, w->value).value + optional(m, d, f->damper, w->rate).value;
    const double limit = JO_RE(x[4]);
    if (limit > 0.0 && JO_RE(y) > limit) y = limit;
    if (limit > 0.0 && JO_RE(y) < -limit) y = -limit;
    return y;
}

/* energy in the linear part of a passive spring, 0 at its free length without preload */
static jo_real along_stored(const jo_data *d, const jo_force *f)
{
    const jo_real s = d->coordinate[f->coordinate].value - f->data[2];
    return f->active ? 0.0 : 0.5 * f->data[0] * s * s - f->data[3] * s;
}

static void along(const jo_model *m, jo_data *d, const jo_force *f, jo_force_work *y)
{
    const jo_coordinate_work *w = &d->coordinate[f->coordinate];
    const jo_real later = along_at(m, d, f, d->time[0] + d->lead);
    if (f->active) {
        const jo_real now = d->lead != 0.0 ? along_at(m, d, f, d->time[0]) : later;
        d->power[2] += now * w->rate;
    } else {
        d->power[0] += w->rate * (f->data[1] * w->rate - optional(m, d, f->damper, w->rate).value);
        d->power[2] += w->rate * optional(m, d, f->spring, w->value).value;
    }
    y->y[0] = later;
    y->stored = along_stored(d, f);
    jo_push_along(m, d, f->coordinate, later);
}

/* pose of b against a, resolved in a: r_b - r_a and the matrix A_a^T A_b */
void jo_relative_pose(const jo_data *d, const jo_force *f, jo_real *r, jo_real *R)
{
    const jo_marker_work *a = &d->marker[f->a], *b = &d->marker[f->b];
    jo_real world[3];
    jo_set3(world, b->r);
    jo_sub3(world, a->r);
    jo_mul3t(r, a->A, world);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            R[3 * i + j] = a->A[i] * b->A[j] + a->A[3 + i] * b->A[3 + j] + a->A[6 + i] * b->A[6 + j];
}

/* velocity and angular velocity of b as an observer on a sees them, resolved in a: A_a^T (v_b - v_a - om_a x d) */
void jo_relative_velocity(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *v, jo_real *w)
{
    const jo_marker_work *a = &d->marker[f->a], *b = &d->marker[f->b];
    jo_real va[3], vb[3], oma[3], omb[3], r[3], t[3];
    jo_to_world(va, m, d, f->a, a->v);
    jo_to_world(vb, m, d, f->b, b->v);
    jo_to_world(oma, m, d, f->a, a->om);
    jo_to_world(omb, m, d, f->b, b->om);
    jo_set3(r, b->r);
    jo_sub3(r, a->r);
    jo_cross(t, oma, r);
    jo_sub3(vb, va);
    jo_sub3(vb, t);
    jo_sub3(omb, oma);
    jo_mul3t(v, a->A, vb);
    jo_mul3t(w, a->A, omb);
}

/* y (6), resolved in a, on b at its origin; on a the opposite with the moment of the arm d: -F, -(d x F) - T */
static void push_between(const jo_model *m, jo_data *d, const jo_force *f, const jo_real *y, jo_force_work *out)
{
    const jo_marker_work *a = &d->marker[f->a], *b = &d->marker[f->b];
    jo_real r[3], t[3], *F = out->y, *T = out->y + 3;
    jo_mul3(F, a->A, y);
    jo_mul3(T, a->A, y + 3);
    jo_push(m, d, f->b, F, T);
    jo_set3(r, b->r);
    jo_sub3(r, a->r);
    jo_cross(t, r, F);
    jo_real Fa[3], Ta[3];
    for (int j = 0; j < 3; j++) {
        Fa[j] = -F[j];
        Ta[j] = -T[j] - t[j];
    }
    jo_push(m, d, f->a, Fa, Ta);
}

/* rotation vector of R, of at most half a turn */
void jo_rotation_vector(jo_real *theta, const jo_real *R)
{
    jo_real e[4];
    jo_quaternion(e, R);
    const jo_real square = jo_dot3(e + 1, e + 1), x = square / (e[0] * e[0]);
    jo_real factor;
    if (JO_RE(square) < 1e-3 * JO_RE(e[0] * e[0]))   /* 2 atan(|v| / e0) / |v|, error below 1e-17 */
        factor = 2.0 / e[0] * (1.0 - x * (1.0 / 3.0 - x * (0.2 - x * (1.0 / 7.0 - x * (1.0 / 9.0 - x / 11.0)))));
    else {
        const jo_real sine = jo_sqrt(square);
        factor = 2.0 * jo_arc_tangent(sine, e[0]) / sine;
    }
    for (int i = 0; i < 3; i++) theta[i] = factor * e[1 + i];
}

/* y = x + sign theta x x / 2 + c theta x (theta x x): with sign -1 theta' of an angular velocity in frame a, with
 * sign +1 the torque that does the work of a load on theta; c = (1 - (t/2) cot(t/2)) / t^2, t = |theta| */
void jo_conjugate(jo_real *y, const jo_real *theta, const jo_real *x, double sign)
{
    const jo_real s = jo_dot3(theta, theta);
    jo_real c, one[3], two[3];
    if (JO_RE(s) < 0.01)
        c = 1.0 / 12.0 + s * (1.0 / 720.0 + s * (1.0 / 30240.0 + s * (1.0 / 1209600.0 + s / 47900160.0)));
    else {
        const jo_real half = 0.5 * jo_sqrt(s);
        c = (1.0 - half * jo_cos(half) / jo_sin(half)) / s;
    }
    jo_cross(one, theta, x);
    jo_cross(two, theta, one);
    for (int i = 0; i < 3; i++) y[i] = x[i] + sign * 0.5 * one[i] + c * two[i];
}

/* U = x^T K x / 2 - x . preload of x = [r_b - r_a, rotation vector], resolved in a; K x into y */
static jo_real bushing_stored(const jo_force *f, const jo_real *x, jo_real *y)
{
    jo_real U = 0.0;
    for (int i = 0; i < 6; i++) {
        y[i] = 0.0;
        for (int j = 0; j < 6; j++) y[i] += f->data[6 * i + j] * x[j];
        U += x[i] * (0.5 * y[i] - f->data[72 + i]);
    }
    return U;
}

static void bushing(const jo_model *m, jo_data *d, const jo_force *f, jo_force_work *out)
{
    jo_real x[6], rate[6], R[9], w[3], y[6], g[6];
    jo_relative_pose(d, f, x, R);
    jo_rotation_vector(x + 3, R);
    jo_relative_velocity(m, d, f, rate, w);
    jo_conjugate(rate + 3, x + 3, w, -1.0);
    out->stored = bushing_stored(f, x, g);
    for (int i = 0; i < 6; i++) {
        jo_real damping = 0.0;
        for (int j = 0; j < 6; j++) damping += f->data[36 + 6 * i + j] * rate[j];
        d->power[0] += damping * rate[i];
        g[i] = f->data[72 + i] - g[i] - damping;
    }
    jo_set3(y, g);
    jo_conjugate(y + 3, x + 3, g + 3, 1.0);
    push_between(m, d, f, y, out);
}

static void modal_load(const jo_model *m, jo_data *d, const jo_force *f, jo_force_work *out)
{
    jo_body_work *w = &d->body[f->body];
    const int np = m->body[f->body].np;
    const jo_real *x = f->data;
    jo_real factor = 1.0, now = 1.0, power = jo_dot3(x, w->V) + jo_dot3(x + 3, w->w);
    if (f->signal >= 0) {
        factor = jo_signal_at(m, d, f->signal, d->time[0] + d->lead).value;
        now = d->lead != 0.0 ? jo_signal_at(m, d, f->signal, d->time[0]).value : factor;
    }
    for (int j = 0; j < np; j++) {
        power += x[6 + j] * w->pd[j];
        w->fp[j] += factor * x[6 + j];
    }
    for (int j = 0; j < 6; j++) w->fr[j] += factor * x[j];
    jo_mul3(out->y, w->A, x);
    jo_mul3(out->y + 3, w->A, x + 3);
    for (int j = 0; j < 6; j++) out->y[j] *= factor;
    d->power[2] += now * power;
}

/* the piece of a path at s and the powers of the way into it; 0 beyond the ends */
const jo_real *jo_moving_piece(const jo_real *x, jo_real s, jo_real *power)
{
    const int count = (int)JO_RE(x[0]), n = (int)JO_RE(x[1]);
    const jo_real *at = x + 5;
    if (!(JO_RE(s) >= JO_RE(at[0]) && JO_RE(s) <= JO_RE(at[count - 1]))) return 0;
    int k = 0;
    while (k < count - 2 && JO_RE(s) >= JO_RE(at[k + 1])) k++;
    power[0] = 1.0;
    for (int i = 1; i < 4; i++) power[i] = power[i - 1] * (s - at[k]);
    return at + count + 12 * (1 + n) * k;
}

/* a point or a mode shape (3) there */
void jo_moving_shape(jo_real *y, const jo_real *c, const jo_real *power)
{
    for (int i = 0; i < 3; i++, c += 4) y[i] = c[0] + c[1] * power[1] + c[2] * power[2] + c[3] * power[3];
}

static void moving_load(const jo_model *m, jo_data *d, const jo_force *f, jo_force_work *out)
{
    jo_body_work *w = &d->body[f->body];
    const int n = (int)JO_RE(f->data[1]);
    const double lead[2] = {0.0, d->lead};
    jo_real power[4], F[3], u[3], v[3], phi[3], t[3];
    for (int i = 0; i < 3; i++) out->y[i] = 0.0;
    /* its power now, what it pushes a lead ahead */
    for (int ahead = 0; ahead < 2; ahead++) {
        const jo_real time = d->time[0] + lead[ahead];
        const jo_real *c = jo_moving_piece(f->data, jo_signal_at(m, d, f->reference, time).value, power);
        if (!c) continue;
        const jo_real factor = f->signal >= 0 ? jo_signal_at(m, d, f->signal, time).value : 1.0;
        if (f->follow) jo_set3(F, f->data + 2);
        else jo_mul3t(F, w->A, f->data + 2);
        for (int i = 0; i < 3; i++) F[i] *= factor;
        jo_moving_shape(u, c, power);
        jo_set3(v, w->V);
        for (int j = 0; j < n; j++) {
            jo_moving_shape(phi, c + 12 * (1 + j), power);
            for (int i = 0; i < 3; i++) {
                u[i] += phi[i] * w->p[j];
                v[i] += phi[i] * w->pd[j];
            }
            if (ahead) w->fp[j] += jo_dot3(phi, F);
        }
        if (ahead) {
            jo_add3(w->fr, F);
            jo_cross(t, u, F);
            jo_add3(w->fr + 3, t);
            jo_mul3(out->y, w->A, F);
        } else {
            jo_cross(t, w->w, u);
            jo_add3(v, t);
            d->power[2] += jo_dot3(F, v);
        }
    }
}

/* what the user's function answers at `time`; it knows real numbers only */
int jo_ask(const jo_force *f, jo_real time, const jo_real *x, jo_real *y)
{
    double given[18], answer[6] = {0.0};
    for (int i = 0; i < 18; i++) given[i] = JO_RE(x[i]);
    if (f->function(JO_RE(time), given, answer, f->user)) return JO_CALLBACK_FAILED;
    for (int i = 0; i < 6; i++) {
        if (!isfinite(answer[i])) return JO_CALLBACK_FAILED;
        y[i] = answer[i];
    }
    return JO_OK;
}

static int user(const jo_model *m, jo_data *d, const jo_force *f, jo_force_work *out)
{
    jo_real x[18], y[6], now[6];
    jo_relative_pose(d, f, x, x + 3);
    jo_relative_velocity(m, d, f, x + 12, x + 15);
    int status = jo_ask(f, d->time[0] + d->lead, x, y);
    if (status != JO_OK) return status;
    for (int i = 0; i < 6; i++) now[i] = y[i];
    if (d->lead != 0.0) status = jo_ask(f, d->time[0], x, now);
    d->power[2] += jo_dot3(now, x + 12) + jo_dot3(now + 3, x + 15);
    push_between(m, d, f, y, out);
    return status;
}

int jo_apply_forces(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        int status = JO_OK;
        switch (f->type) {
        case JO_LOAD: load(m, d, f, &d->force[i]); break;
        case JO_ALONG_COORDINATE: along(m, d, f, &d->force[i]); break;
        case JO_BUSHING: bushing(m, d, f, &d->force[i]); break;
        case JO_MODAL_LOAD: modal_load(m, d, f, &d->force[i]); break;
        case JO_MOVING_LOAD: moving_load(m, d, f, &d->force[i]); break;
        case JO_USER: status = user(m, d, f, &d->force[i]); break;
        default: break;
        }
        if (status != JO_OK) {
            d->error_index = i;
            return status;
        }
    }
    return JO_OK;
}

/* energy in all springs where the markers and coordinates stand */
jo_real jo_stored(const jo_model *m, jo_data *d)
{
    jo_real U = 0.0;
    for (int i = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        if (f->type == JO_ALONG_COORDINATE) U += along_stored(d, f);
        if (f->type == JO_BUSHING) {
            jo_real x[6], R[9], unused[6];
            jo_relative_pose(d, f, x, R);
            jo_rotation_vector(x + 3, R);
            U += bushing_stored(f, x, unused);
        }
    }
    return U;
}
