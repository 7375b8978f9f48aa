/* force_moving_load.c - force at a point that moves along a body with s = reference(t). */
#include "newton/newton.h"
#include "force/force.h"

/* coefficients of the piece of the path at s, and powers (s - s_k)^0..3; NULL beyond the ends */
static const jo_real *piece(const jo_moving_load_data *x, jo_real s, jo_real *power)
{
    const int count = (int)JO_RE(x->count), n = (int)JO_RE(x->modes);
    const jo_real *at = (const jo_real *)(x + 1);
    if (!(JO_RE(s) >= JO_RE(at[0]) && JO_RE(s) <= JO_RE(at[count - 1]))) return 0;
    int k = 0;
    while (k < count - 2 && JO_RE(s) >= JO_RE(at[k + 1])) k++;
    power[0] = 1.0;
    for (int i = 1; i < 4; i++) power[i] = power[i - 1] * (s - at[k]);
    return at + count + 12 * (1 + n) * k;
}

/* y (3) = cubic polynomials of a position or mode shape */
static void shape(jo_real *y, const jo_real *c, const jo_real *power)
{
    for (int i = 0; i < 3; i++, c += 4) y[i] = c[0] + c[1] * power[1] + c[2] * power[2] + c[3] * power[3];
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *out)
{
    const jo_moving_load_data *x = (const jo_moving_load_data *)f->data;
    jo_body_work *w = &d->body[f->body];
    const int n = (int)JO_RE(x->modes);
    const double lead[2] = {0.0, stage->lead};
    jo_real power[4], F[3], u[3], v[3], phi[3], t[3];
    for (int i = 0; i < 3; i++) out->y[i] = 0.0;
    /* power at the present time; force at the present time + lead */
    for (int ahead = 0; ahead < 2; ahead++) {
        const jo_real time = d->time[0] + lead[ahead];
        const jo_real *c = piece(x, jo_signal_at(m, d, f->reference, time).value, power);
        if (!c) continue;
        const jo_real factor = f->signal >= 0 ? jo_signal_at(m, d, f->signal, time).value : 1.0;
        if (f->follow) jo_set3(F, x->force);
        else jo_mul3t(F, w->A, x->force);
        for (int i = 0; i < 3; i++) F[i] *= factor;
        shape(u, c, power);
        jo_set3(v, w->V);
        for (int j = 0; j < n; j++) {
            shape(phi, c + 12 * (1 + j), power);
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
            d->power.forces += jo_dot3(F, v);
        }
    }
    return JO_OK;
}

static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *y)
{
    const jo_moving_load_data *x = (const jo_moving_load_data *)f->data;
    const jo_block N = jo_newton_find(m, d, f->body, f->body);
    const jo_body_work *w = &d->body[f->body];
    const jo_real q = stage->weights.q;
    const int n = (int)JO_RE(x->modes);
    jo_real power[4], F[3], u[3], phi[3], t[3], M[9] = {0.0}, P[9], Q[9];
    const jo_real *c = piece(x, jo_signal_at(m, d, f->reference, d->time[0]).value, power);
    if (!c) return JO_OK;
    jo_mul3t(F, w->A, y->y);
    shape(u, c, power);
    for (int j = 0; j < n; j++) {
        shape(phi, c + 12 * (1 + j), power);
        for (int k = 0; k < 3; k++) u[k] += phi[k] * w->p[j];
        jo_cross(t, phi, F);
        for (int k = 0; k < 3; k++) N.at[(3 + k) * N.stride + 6 + j] -= q * t[k];   /* du x F */
        if (f->follow) continue;
        jo_mul3t(t, w->turn, t);   /* phi . (F x dtheta) */
        for (int k = 0; k < 3; k++) N.at[(6 + j) * N.stride + 3 + k] -= q * t[k];
    }
    M[1] = -F[2]; M[2] = F[1]; M[3] = F[2]; M[5] = -F[0]; M[6] = -F[1]; M[7] = F[0];
    if (f->follow) {   /* the force turns: A (dtheta x F) */
        jo_mul33(Q, w->A, M);
        jo_mul33(P, Q, w->turn);
        for (int r = 0; r < 3; r++)
            for (int k = 0; k < 3; k++) N.at[r * N.stride + 3 + k] += q * P[3 * r + k];
        return JO_OK;
    }
    jo_mul33(Q, M, w->turn);
    for (int k = 0; k < 3; k++) {   /* u x (F x dtheta) */
        const jo_real column[3] = {Q[k], Q[3 + k], Q[6 + k]};
        jo_cross(t, u, column);
        for (int r = 0; r < 3; r++) N.at[(3 + r) * N.stride + 3 + k] -= q * t[r];
    }
    return JO_OK;
}

const jo_force_kind jo_force_moving_load = {apply, 0, tangent, 0, 0, 0};
