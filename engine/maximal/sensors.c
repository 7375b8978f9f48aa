/* sensors.c - sensor values at the present state. */
#include "maximal/maximal.h"
#include "force/force.h"
#include "contact/contact.h"
#include "beam/beam.h"
#include "fatigue/fatigue.h"
#include "network/network.h"

#define JO_ZERO_ENTRY 1e-30  /* off-diagonal entry, relative to the sum of all entries, that counts as 0 in Jacobi's rotations */

/* y relative to an observer o: r - r_o, v - v_o - om_o x r, ... with derivatives in the frame of the observer */
static void observe(jo_motion *y, const jo_motion *o)
{
    jo_real c[3];
    jo_sub3(y->r, o->r);
    jo_sub3(y->v, o->v);
    jo_cross(c, o->om, y->r);
    jo_sub3(y->v, c);               /* relative velocity */
    jo_sub3(y->a, o->a);
    jo_cross(c, o->al, y->r);
    jo_sub3(y->a, c);               /* Euler */
    jo_cross(c, o->om, y->r);
    jo_cross(c, o->om, c);
    jo_sub3(y->a, c);               /* centripetal */
    jo_cross(c, o->om, y->v);
    jo_axpy3(y->a, jo_same(-2.0), c);        /* Coriolis */
    jo_sub3(y->om, o->om);
    jo_sub3(y->al, o->al);
    jo_cross(c, o->om, y->om);
    jo_sub3(y->al, c);
}

/* components of a world vector in the axes of a marker; frame -1: world */
static void resolve(const jo_data *d, int frame, jo_real *y)
{
    if (frame >= 0) jo_mul3t(y, d->marker[frame].A, y);
}

/* all vectors of a sensor in its axes */
static void resolve_all(const jo_data *d, const jo_sensor *s, jo_real *y)
{
    for (int j = 0; j + 3 <= s->count; j += 3) resolve(d, s->frame, y + j);
}

/* C = A^T B */
static void transposed33(jo_real *C, const jo_real *A, const jo_real *B)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) C[3 * i + j] = A[i] * B[j] + A[3 + i] * B[3 + j] + A[6 + i] * B[6 + j];
}

/* Euler parameters of the rotation from `other` to the marker, resolved in `frame`: of A_f^T (A_m A_o^T) A_f */
static void orientation(const jo_data *d, const jo_sensor *s, jo_real *y)
{
    const jo_real *A = d->marker[s->object].A;
    jo_real R[9];
    if (s->other < 0) {
        jo_quaternion(y, A);
        resolve(d, s->frame, y + 1);
        return;
    }
    transposed33(R, d->marker[s->other].A, A);   /* resolved in `other`; the rotation axis has the same components in both frames */
    jo_quaternion(y, R);
    if (s->frame == s->other) return;
    jo_mul3(y + 1, d->marker[s->other].A, y + 1);
    resolve(d, s->frame, y + 1);
}

static int is_acceleration(const jo_sensor *s)
{
    return s->type == JO_SENSOR_ACCELERATION || s->type == JO_SENSOR_ANGULAR_ACCELERATION || s->type == JO_SENSOR_ACCELERATION_PARTS;
}

/* position, velocity or acceleration of a marker, relative to an observer, in the axes of `frame` */
static void marker_sensor(const jo_model *m, const jo_data *d, const jo_sensor *s, jo_real *y)
{
    const int accelerations = is_acceleration(s);
    jo_motion of;
    jo_marker_motion(m, d, s->object, accelerations, &of);
    if (s->other >= 0) {
        jo_motion from;
        jo_marker_motion(m, d, s->other, accelerations, &from);
        observe(&of, &from);
    }
    const jo_real *x = of.r;
    if (s->type == JO_SENSOR_VELOCITY) x = of.v;
    if (s->type == JO_SENSOR_ACCELERATION) x = of.a;
    if (s->type == JO_SENSOR_ANGULAR_VELOCITY) x = of.om;
    if (s->type == JO_SENSOR_ANGULAR_ACCELERATION) x = of.al;
    jo_set3(y, x);
    resolve(d, s->frame, y);
}

/* motion of the frame of a body, or of the ground, in the world */
static void frame_motion(const jo_model *m, const jo_data *d, int body, jo_motion *y)
{
    const jo_motion rest = {{0.0}, {0.0}, {0.0}, {0.0}, {0.0}};
    *y = rest;
    if (body < 0) return;
    const jo_body *b = &m->body[body];
    const jo_real *A = d->body[body].A;
    jo_set3(y->r, d->q + b->iq);
    jo_set3(y->v, d->v + b->iv);
    jo_set3(y->a, d->a + b->iv);
    jo_mul3(y->om, A, d->v + b->iv + 3);
    jo_mul3(y->al, A, d->a + b->iv + 3);
}

/* y (15) = R'', w x (w x u), w' x u, 2 w x u', u'', derivatives of u in the moving frame */
static void acceleration_parts(const jo_model *m, const jo_data *d, const jo_sensor *s, jo_real *y)
{
    jo_motion of, from;
    jo_real c[3];
    jo_marker_motion(m, d, s->object, 1, &of);
    if (s->other >= 0) jo_marker_motion(m, d, s->other, 1, &from);
    else frame_motion(m, d, m->marker[s->object].body, &from);
    observe(&of, &from);
    jo_set3(y, from.a);
    jo_cross(c, from.om, of.r);
    jo_cross(y + 3, from.om, c);
    jo_cross(y + 6, from.al, of.r);
    jo_cross(y + 9, from.om, of.v);
    for (int j = 9; j < 12; j++) y[j] *= 2.0;
    jo_set3(y + 12, of.a);
    for (int j = 0; j < 15; j += 3) resolve(d, s->frame, y + j);
}

/* y (count) = rows (count x np) of modal stress or strain times the modal coordinates */
static void modal_rows(const jo_model *m, const jo_data *d, const jo_sensor *s, int first, int count, jo_real *y)
{
    const jo_body *b = &m->body[s->object];
    const jo_real *p = d->q + b->iq + 7;
    for (int r = 0; r < count; r++) {
        const jo_real *row = s->rows + (first + r) * b->np;
        y[r] = jo_same(0.0);
        for (int j = 0; j < b->n; j++) y[r] += row[j] * p[j];
    }
}

/* equivalent stress of [s11 s22 s33 s12 s23 s13] */
static jo_real von_mises(const jo_real *s)
{
    const jo_real a = s[0] - s[1], b = s[1] - s[2], c = s[2] - s[0];
    return jo_sqrt(0.5 * (a * a + b * b + c * c) + 3.0 * jo_dot3(s + 3, s + 3));
}

/* principal stresses, descending, of [s11 s22 s33 s12 s23 s13] in a lane by Jacobi's method, accurate also for equal values */
static void principal_of(jo_real *out, const jo_real *s, int lane)
{
    enum { JO_SWEEPS = 8 };   /* largest number of sweeps: convergence is quadratic, and five sweeps reach round-off */
    jo_real S[3][3] = {{s[0], s[3], s[5]}, {s[3], s[1], s[4]}, {s[5], s[4], s[2]}};
    jo_real y[3];
    double size = 0.0;
    for (int i = 0; i < 6; i++) size += fabs(JO_PART(s[i], lane));
    for (int k = 0; k < 3 * JO_SWEEPS; k++) {
        const int i = k % 3 == 2, j = k % 3 == 0 ? 1 : 2, l = 3 - i - j;
        if (fabs(JO_PART(S[i][j], lane)) <= JO_ZERO_ENTRY * size) continue;
        const jo_real x = 0.5 * (S[j][j] - S[i][i]) / S[i][j], root = jo_sqrt(x * x + 1.0);
        const jo_real t = 1.0 / (JO_PART(x, lane) < 0.0 ? x - root : x + root), c = 1.0 / jo_sqrt(t * t + 1.0);
        const jo_real u = S[i][l], v = S[j][l];
        S[i][i] -= t * S[i][j];
        S[j][j] += t * S[i][j];
        S[i][j] = S[j][i] = jo_same(0.0);
        S[i][l] = S[l][i] = c * (u - t * v);
        S[j][l] = S[l][j] = c * (v + t * u);
    }
    for (int i = 0; i < 3; i++) y[i] = S[i][i];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 2; j++)
            if (JO_PART(y[j], lane) < JO_PART(y[j + 1], lane)) {
                const jo_real t = y[j];
                y[j] = y[j + 1];
                y[j + 1] = t;
            }
    for (int i = 0; i < 3; i++) jo_put(out + i, y[i], lane);
}

static void principal(jo_real *y, const jo_real *s)
{
    for (int l = 0; l < JO_MACHINES; l++) principal_of(y, s, l);
}

/* modal stresses, von Mises stresses or principal stresses */
static void stress(const jo_model *m, const jo_data *d, const jo_sensor *s, jo_real *y)
{
    if (s->type == JO_SENSOR_STRESS) {
        modal_rows(m, d, s, 0, s->count, y);
        if (s->other >= 0) {   /* apparent strain */
            const jo_real e = jo_signal_at(m, d, s->other, d->time[0]).value;
            for (int r = 0; r < s->count; r++) y[r] += e;
        }
        return;
    }
    const int each = s->type == JO_SENSOR_PRINCIPAL ? 3 : 1;
    for (int k = 0; k < s->count / each; k++) {
        jo_real x[6];
        modal_rows(m, d, s, 6 * k, 6, x);
        if (s->type == JO_SENSOR_PRINCIPAL) principal(y + 3 * k, x);
        else y[k] = von_mises(x);
    }
}

/* output voltage of a Wheatstone bridge / supply voltage: arms 1 and 2 in series, parallel to arms 4 and 3 in series */
static void bridge(const jo_model *m, const jo_data *d, const jo_sensor *s, jo_real *y)
{
    jo_real r[4];
    modal_rows(m, d, s, 0, 4, r);
    if (s->other >= 0) {
        const jo_real *drift = s->rows + 4 * m->body[s->object].np;
        const jo_real change = jo_signal_at(m, d, s->other, d->time[0]).value;
        for (int i = 0; i < 4; i++) r[i] += drift[i] * change;
    }
    y[0] = 0.5 * (r[0] - r[1]) / (2.0 + r[0] + r[1]) + 0.5 * (r[2] - r[3]) / (2.0 + r[2] + r[3]);
}

/* energy or work of a kind, J */
static jo_real energy(const jo_model *m, jo_data *d, int kind)
{
    jo_energies now;
    switch (kind) {
    case JO_ENERGY_DISSIPATED: return d->work.damping + jo_yielding_loss(m, d);
    case JO_ENERGY_FRICTION: return d->work.friction + jo_bristles(m, d) - jo_bristles_at_end(m, d);
    case JO_ENERGY_WORK: return d->work.forces;
    default: break;
    }
    jo_energy(m, d, &now);
    switch (kind) {
    case JO_ENERGY_KINETIC: return now.kinetic;
    case JO_ENERGY_STRAIN: return now.strain;
    case JO_ENERGY_POTENTIAL: return now.potential;
    default: return now.springs;
    }
}

static void modal(const jo_model *m, const jo_data *d, int body, jo_real *y)
{
    const jo_body *b = &m->body[body];
    for (int j = 0; j < b->n; j++) {
        y[j] = d->q[b->iq + 7 + j];
        y[b->n + j] = d->v[b->iv + 6 + j];
    }
}

/* momentum int Phi p' dm and angular momentum int u x Phi p' dm of the deformation about the body frame, local */
static void deformation_momentum(const jo_model *m, const jo_data *d, int body, jo_real *y)
{
    const jo_body *b = &m->body[body];
    const jo_body_work *w = &d->body[body];
    for (int i = 0; i < 3; i++) {
        y[i] = y[3 + i] = jo_same(0.0);
        for (int j = 0; j < b->n; j++) {
            y[i] += b->I3[i * b->np + j] * w->pd[j];
            y[3 + i] += w->B[i * b->np + j] * w->pd[j];
        }
    }
}

/* force or torque -lam factor of a coupling or drive along each of its coordinates, on marker b */
static void multiplier(const jo_model *m, const jo_data *d, const jo_sensor *s, jo_real *y)
{
    const jo_joint *k = &m->joint[s->object];
    const jo_real lam = d->lam[k->row + k->nrow - k->nline];
    for (int j = 0; j < s->count; j++) y[j] = -lam * m->line[k->line].data->factor[j];
}

/* components other .. other + count - 1 of the 24 strains and resultants of a beam element */
static void section(const jo_data *d, const jo_sensor *s, jo_real *y)
{
    jo_real all[24] = {0.0};
    const int first = s->other > 0 ? s->other : 0;
    jo_beam_section(d, s->object, all);
    for (int i = 0; i < s->count; i++) y[i] = first + i < 24 ? all[first + i] : jo_same(0.0);
}

/* value of a signal of time, or of an expression of the motion */
static jo_real signal_value(const jo_model *m, const jo_data *d, int signal)
{
    const jo_signal *x = &m->signal[signal];
    return x->type == JO_SIGNAL_NETWORK ? jo_network_value(m, d, x->count, x->child[0]) : jo_signal_at(m, d, signal, d->time[0]).value;
}

static void contact(const jo_model *m, const jo_data *d, const jo_sensor *s, jo_real *y)
{
    jo_contact_sensor(m, d, s, y);
    resolve_all(d, s, y);
}

/* whether a sensor needs accelerations or multipliers */
int jo_needs_accelerations(const jo_sensor *s)
{
    switch (s->type) {
    case JO_SENSOR_POSITION: case JO_SENSOR_VELOCITY: case JO_SENSOR_ORIENTATION: case JO_SENSOR_ANGULAR_VELOCITY: case JO_SENSOR_MODAL:
    case JO_SENSOR_STRESS: case JO_SENSOR_VON_MISES: case JO_SENSOR_PRINCIPAL: case JO_SENSOR_COORDINATE: case JO_SENSOR_RATE: case JO_SENSOR_SIGNAL:
    case JO_SENSOR_DAMAGE:
    case JO_SENSOR_BRIDGE:
    case JO_SENSOR_FORCE_STATE:
        return 0;
    case JO_SENSOR_ENERGY: return s->object >= JO_ENERGY_DISSIPATED;   /* work needs the power at the end of the step */
    default: return 1;
    }
}

/* values of all sensors at the present poses, velocities and, where needed, accelerations */
void jo_sensors(const jo_model *m, jo_data *d, jo_real *out)
{
    jo_marker_position(m, d, m->nmarker);
    jo_marker_velocity(m, d, m->nmarker);
    for (int i = 0; i < m->nsensor; i++)
        if (is_acceleration(&m->sensor[i])) {
            jo_marker_bias(m, d, m->nmarker);
            break;
        }
    if (m->ncoordinate) {
        jo_coordinates(m, d, m->ncoordinate);
        jo_coordinates_rate(m, d, m->ncoordinate);
    }
    for (int i = 0; i < m->nsensor; i++) {
        const jo_sensor *s = &m->sensor[i];
        jo_real *y = out + s->offset;
        switch (s->type) {
        case JO_SENSOR_POSITION:
        case JO_SENSOR_VELOCITY:
        case JO_SENSOR_ACCELERATION:
        case JO_SENSOR_ANGULAR_VELOCITY:
        case JO_SENSOR_ANGULAR_ACCELERATION: marker_sensor(m, d, s, y); break;
        case JO_SENSOR_ACCELERATION_PARTS: acceleration_parts(m, d, s, y); break;
        case JO_SENSOR_ORIENTATION: orientation(d, s, y); break;
        case JO_SENSOR_MODAL: modal(m, d, s->object, y); break;
        case JO_SENSOR_DEFORMATION_MOMENTUM: deformation_momentum(m, d, s->object, y); break;
        case JO_SENSOR_MULTIPLIER: multiplier(m, d, s, y); break;
        case JO_SENSOR_COORDINATE: y[0] = d->coordinate[s->object].value; break;
        case JO_SENSOR_RATE: y[0] = d->coordinate[s->object].rate; break;
        case JO_SENSOR_ENERGY: y[0] = energy(m, d, s->object); break;
        case JO_SENSOR_SIGNAL: y[0] = signal_value(m, d, s->object); break;
        case JO_SENSOR_ELEMENT:   /* `other` is the index of the first component */
            for (int j = 0; j < s->count; j++) y[j] = d->force[s->object].y[s->other + j];
            resolve_all(d, s, y);
            break;
        case JO_SENSOR_FRICTION:   /* force along each coordinate */
            for (int j = 0; j < s->count; j++) y[j] = d->rub[2 * s->object + j];
            break;
        case JO_SENSOR_REACTION:
            jo_reaction(m, d, s->object, y);
            resolve_all(d, s, y);
            break;
        case JO_SENSOR_STRESS:
        case JO_SENSOR_VON_MISES:
        case JO_SENSOR_PRINCIPAL: stress(m, d, s, y); break;
        case JO_SENSOR_DAMAGE:
            for (int k = 0; k < s->count / 2; k++) jo_damage_read(m, d, s->object + k, y + 2 * k);
            break;
        case JO_SENSOR_BRIDGE: bridge(m, d, s, y); break;
        case JO_SENSOR_SECTION: section(d, s, y); break;
        case JO_SENSOR_BODY_LOAD:
        case JO_SENSOR_MODAL_LOAD: jo_load_sensor(m, d, s, y); break;
        case JO_SENSOR_CONTACT: contact(m, d, s, y); break;
        case JO_SENSOR_FORCE_STATE: jo_force_state(m, d, s->object, s->other, y); break;
        default: break;
        }
    }
}
