/* load_sensor.c - sum of all loads of one kind on a body: joints, forces, friction, gravity, inertia, elastic forces or damping.
 *
 * [force, moment about the origin of the body frame, modal forces], in the body frame. The sum over all kinds vanishes (d'Alembert;
 * Altarriba 2010, eq. 96-98).
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"
#include "friction/friction.h"

/* fr, fp = -K p */
static void elastic(const jo_body *b, jo_body_work *w)
{
    jo_clear_forces(b, w);
    for (int j = 0; j < b->n; j++) w->fp[j] = -b->K[j] * w->p[j];
}

/* fr, fp = damping: -D p' of modes, -alpha [m V + w x S, J w + S x V] of a rigid body */
static void damping(const jo_body *b, jo_body_work *w)
{
    jo_real t[3], h[3], SV[3];
    jo_clear_forces(b, w);
    for (int j = 0; j < b->n; j++) w->fp[j] = -b->D[j] * w->pd[j];
    if (b->n) return;
    jo_cross(t, w->w, w->S);
    jo_sym3(h, w->J, w->w);
    jo_cross(SV, w->S, w->V);
    for (int j = 0; j < 3; j++) {
        w->fr[j] = -b->alpha * (b->mass[0] * w->V[j] + t[j]);
        w->fr[3 + j] = -b->alpha * (h[j] + SV[j]);
    }
}

/* fr, fp = [m g, S x g, I3^T g] */
static void gravity(const jo_model *m, const jo_body *b, jo_body_work *w)
{
    jo_real g[3];
    jo_mul3t(g, w->A, m->gravity);
    jo_clear_forces(b, w);
    jo_axpy3(w->fr, b->mass[0], g);
    jo_cross(w->fr + 3, w->S, g);
    for (int j = 0; j < b->n; j++)
        for (int i = 0; i < 3; i++) w->fp[j] += b->I3[i * b->np + j] * g[i];
}

/* fr, fp = velocity-dependent forces - M [R'', w', p''] */
static void inertia(const jo_body *b, jo_body_work *w, const jo_real *a)
{
    const jo_real *turn = a + 3, *modes = a + 6;
    jo_real A[3], x[3], y[3], other[6], unused = {0.0};
    /* velocity-dependent forces: those of jo_body_inertia without elastic forces and damping */
    damping(b, w);
    for (int j = 0; j < 6; j++) other[j] = w->fr[j];
    jo_body_inertia(b, w, &unused);
    for (int j = 0; j < 6; j++) w->fr[j] -= other[j];
    for (int j = 0; j < b->n; j++) w->fp[j] += b->K[j] * w->p[j] + b->D[j] * w->pd[j];
    /* [m A + w' x S + I3 p'', S x A + J w' + B p'', I3^T A + B^T w' + p''] */
    jo_mul3t(A, w->A, a);
    jo_cross(x, turn, w->S);
    jo_axpy3(x, b->mass[0], A);
    jo_cross(y, w->S, A);
    jo_sub3(w->fr, x);
    jo_sub3(w->fr + 3, y);
    jo_sym3(y, w->J, turn);
    jo_sub3(w->fr + 3, y);
    for (int j = 0; j < b->n; j++) {
        w->fp[j] -= modes[j];
        for (int i = 0; i < 3; i++) {
            const jo_real shift = b->I3[i * b->np + j], turned = w->B[i * b->np + j];
            w->fr[i] -= shift * modes[j];
            w->fr[3 + i] -= turned * modes[j];
            w->fp[j] -= shift * A[i] + turned * turn[i];
        }
    }
}

/* fr, fp = sum of the forces of one kind: JO_LOAD_JOINT, JO_LOAD_APPLIED or JO_LOAD_FRICTION */
static void pushed(const jo_model *m, jo_data *d, int body, int kind)
{
    jo_body_work *w = &d->body[body];
    const int tree = jo_tree_active(d);
    const jo_valid before = tree ? jo_detour_begins(d) : jo_valid_now(d);   /* forces along joint coordinates: on both bodies */
    jo_clear_forces(&m->body[body], w);
    if (kind == JO_LOAD_APPLIED) {
        const jo_work power = d->power;
        for (int i = 0; i < m->nforce; i++) (void)jo_apply_force(m, d, &jo_now, i);
        d->power = power;
    }
    for (int i = 0; i < m->nfriction && kind == JO_LOAD_FRICTION; i++) jo_friction_apply_force(m, d, i);
    for (int i = 0; i < m->njoint; i++) {
        const int locks = m->joint[i].lock >= m->nswitched;   /* those of sticking friction */
        if (kind != (locks ? JO_LOAD_FRICTION : JO_LOAD_JOINT) || jo_joint_inactive(d, i)) continue;
        jo_apply_reaction(m, d, i);
    }
    if (tree) jo_detour_ends(d, &before);
}

/* y = force and moment (6), or modal forces (n), of the loads of a kind on a body */
void jo_load_sensor(const jo_model *m, jo_data *d, const jo_sensor *s, jo_real *y)
{
    const jo_body *b = &m->body[s->object];
    jo_body_work *w = &d->body[s->object];
    switch (s->other) {
    case JO_LOAD_GRAVITY: gravity(m, b, w); break;
    case JO_LOAD_INERTIA: inertia(b, w, d->a + b->iv); break;
    case JO_LOAD_ELASTIC: elastic(b, w); break;
    case JO_LOAD_DAMPING: damping(b, w); break;
    default: pushed(m, d, s->object, s->other); break;
    }
    const jo_real *x = s->type == JO_SENSOR_MODAL_LOAD ? w->fp : w->fr;
    for (int j = 0; j < s->count; j++) y[j] = x[j];
}
