/* sensor.c - what is measured, evaluated where the engine stands. */
#include "internal.h"

/* quaternion (scalar first) of a rotation matrix, from its largest component */
void jo_quaternion(jo_real *e, const jo_real *A)
{
    jo_real t[4] = {1.0 + A[0] + A[4] + A[8], 1.0 + A[0] - A[4] - A[8], 1.0 - A[0] + A[4] - A[8], 1.0 - A[0] - A[4] + A[8]};
    int k = 0;
    for (int i = 1; i < 4; i++)
        if (JO_RE(t[i]) > JO_RE(t[k])) k = i;
    jo_real s = 0.5 / jo_sqrt(t[k]);
    jo_real x[4][4] = {
        {t[0], A[7] - A[5], A[2] - A[6], A[3] - A[1]},
        {A[7] - A[5], t[1], A[1] + A[3], A[2] + A[6]},
        {A[2] - A[6], A[1] + A[3], t[2], A[5] + A[7]},
        {A[3] - A[1], A[2] + A[6], A[5] + A[7], t[3]},
    };
    if (JO_RE(x[k][0]) < 0.0) s = -s;
    for (int i = 0; i < 4; i++) e[i] = x[k][i] * s;
}

/* force and moment with which the joint acts on marker b, world */
static void reaction(const jo_model *m, const jo_data *d, int joint, jo_real *y)
{
    const jo_joint *k = &m->joint[joint];
    const jo_real *lam = d->lam + k->row, *Aa = d->marker[k->side[0]].A, *Ab = d->marker[k->side[1]].A;
    for (int i = 0; i < 6; i++) y[i] = 0.0;
    if (k->coincident) {
        for (int i = 0; i < 3; i++) y[i] = -lam[i];
        lam += 3;
    }
    for (int r = 0; r < k->nperp; r++) {
        jo_real f[3], h[3], s[3];
        for (int i = 0; i < 3; i++) { f[i] = Aa[3 * i + k->perp_a[r]]; h[i] = Ab[3 * i + k->perp_b[r]]; }
        jo_cross(s, f, h);
        jo_axpy3(y + 3, lam[r], s);
    }
    lam += k->nperp;
    for (int l = 0; l < k->nline; l++) {
        const jo_line *line = &m->line[k->line + l];
        for (int j = 0; j < line->count; j++) {
            if (line->side[j]) continue;   /* a coupling reacts here with its first coordinate only */
            const jo_coordinate_work *c = &d->coordinate[line->coordinate[j]];
            jo_axpy3(y, -lam[l] * line->data[1 + j], c->along);
            jo_axpy3(y + 3, -lam[l] * line->data[1 + j], c->turn_b);
        }
    }
}

void jo_sensors(const jo_model *m, jo_data *d, jo_real *out)
{
    jo_marker_position(m, d, m->nmarker);
    jo_marker_velocity(m, d, m->nmarker);
    if (m->ncoordinate) {
        jo_coordinates(m, d, m->ncoordinate);
        jo_coordinates_rate(m, d, m->ncoordinate);
    }
    for (int i = 0; i < m->nsensor; i++) {
        const jo_sensor *s = &m->sensor[i];
        jo_real *y = out + s->offset;
        const jo_marker_work *w = &d->marker[s->object];
        switch (s->type) {
        case JO_POSITION: jo_set3(y, w->r); break;
        case JO_ORIENTATION: jo_quaternion(y, w->A); break;
        case JO_VELOCITY:
        case JO_ANGULAR_VELOCITY: {
            const jo_real *x = s->type == JO_VELOCITY ? w->v : w->om;
            int body = m->marker[s->object].body;
            if (body < 0) jo_set3(y, x);
            else jo_mul3(y, d->body[body].A, x);
            break;
        }
        case JO_MODAL: {
            const jo_body *b = &m->body[s->object];
            for (int j = 0; j < b->n; j++) { y[j] = d->q[b->iq + 7 + j]; y[b->n + j] = d->v[b->iv + 6 + j]; }
            break;
        }
        case JO_MULTIPLIER: {   /* force or torque along the coordinate, on b */
            const jo_joint *k = &m->joint[s->object];
            y[0] = -d->lam[k->row + k->nrow - k->nline] * m->line[k->line].data[1];
            break;
        }
        case JO_COORDINATE: y[0] = d->coordinate[s->object].value; break;
        case JO_RATE: y[0] = d->coordinate[s->object].rate; break;
        case JO_ENERGY:   /* kinetic strain potential springs, then dissipated friction work so far */
            if (s->object >= 4) {
                y[0] = d->work[s->object - 4];
            } else {
                jo_real energy[4];
                jo_energy(m, d, energy);
                y[0] = energy[s->object];
            }
            break;
        case JO_SIGNAL: y[0] = jo_signal_at(m, d, s->object, d->time[0]).value; break;
        case JO_ELEMENT:
            for (int j = 0; j < s->count; j++) y[j] = d->force[s->object].y[j];
            break;
        case JO_REACTION: reaction(m, d, s->object, y); break;
        case JO_STRESS: {
            const jo_body *b = &m->body[s->object];
            for (int r = 0; r < s->count; r++) {
                jo_real x = 0.0;
                for (int j = 0; j < b->n; j++) x += s->rows[r * b->np + j] * d->q[b->iq + 7 + j];
                y[r] = x;
            }
            break;
        }
        default: break;
        }
    }
}
