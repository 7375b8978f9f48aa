/* friction.c - Coulomb friction along the coordinates of joints, with the normal force from the reaction of the same joint.
 *
 * Sliding: f = -mu N arm s' / |slip|, N from the reaction resolved in the axes of side 0 (Altarriba 2010, eq. S37-S38), so
 * that f depends on the multipliers and vice versa. Sticking: a row of an optional joint locks the coordinate; its multiplier is
 * the static friction force, limited by mu_static N (eq. S39-S40).
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"
#include "friction/friction_law.h"
#include "tree/tree.h"

/* as JO_REST, when a disc touches a plane, where it rolls already after a flight that round-off caused */
#define JO_TOUCH_REST 1e-6

/* y (6) = reaction of the joint for multipliers lam, in the axes of side 0; of a contact its normal force, whatever they are */
void jo_friction_reaction(const jo_model *m, const jo_data *d, const jo_friction *f, const jo_real *lam, jo_real *y)
{
    const jo_joint *k = &m->joint[f->joint];
    const jo_real *A = d->marker[k->side[0]].A;
    if (f->contact >= 0) {
        for (int j = 0; j < 6; j++) y[j] = jo_same(0.0);
        y[2] = jo_contact_normal_force(m, d, &m->force[f->contact]);
        return;
    }
    jo_reaction_of(m, d, f->joint, lam + k->row, y);
    jo_mul3t(y, A, y);
    jo_mul3t(y + 3, A, y + 3);
}

/* y (6) = reaction of the joint at the last evaluation, in the axes of side 0 */
void jo_friction_joint_reaction(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *y)
{
    if (jo_tree_active(d)) jo_tree_joint_reaction(m, d, f, 0, y);
    else jo_friction_reaction(m, d, f, d->lam, y);
}

/* normal force N and torque of the collar, N m, at the last evaluation */
static jo_real normal_force(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *collar)
{
    jo_real y[6];
    jo_friction_joint_reaction(m, d, f, y);
    return jo_friction_normal_force(m, f, y, collar);
}

/* mu / speed of the regularised law, w = speed / velocity: mu = mu_static w (15 - 10 w^2 + 3 w^4) / 8 for w < 1, then a quintic down to
 * mu_kinetic at w = 2; twice continuously differentiable */
static jo_real mu_by_speed(const jo_friction *f, jo_real square)
{
    const jo_real kinetic = f->data->mu_kinetic, top = f->data->mu_static, velocity = f->data->velocity;
    const jo_real w2 = square / (velocity * velocity);
    if (JO_RE(w2) < 1.0) return top * (15.0 - w2 * (10.0 - 3.0 * w2)) / (8.0 * velocity);
    const jo_real speed = jo_sqrt(square), x = speed / velocity - 1.0;
    if (JO_RE(x) > 1.0) return kinetic / speed;
    return (top + (kinetic - top) * x * x * x * (10.0 - x * (15.0 - 6.0 * x))) / speed;
}

/* slip velocity s (2) = arm times rate, m/s */
void jo_friction_slip(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *s)
{
    s[1] = 0.0;
    for (int k = 0; k < jo_slips(f); k++) s[k] = jo_slip_arm(m, f, k) * d->coordinate[jo_slip_of(f, k)].rate;
}

/* unit direction e (2) of the slip, from the stored state or, while that is undetermined, from the velocity */
void jo_friction_direction(const jo_model *m, const jo_data *d, int i, jo_real *e)
{
    const jo_friction *f = &m->friction[i];
    const jo_real *old = d->direction + 2 * i;
    jo_real s[2];
    jo_friction_slip(m, d, f, s);
    e[0] = e[1] = 0.0;
    if (d->slip[i] && jo_slips(f) == 1) {
        e[0] = d->slip[i];
        return;
    }
    const jo_real speed = jo_length2(s[0], s[1]);
    const double rest = !d->slip[i] && JO_RE(f->data->plane) > 0.0 ? JO_TOUCH_REST : JO_REST;
    const int slow = !(JO_RE(speed) > rest * jo_slip_scale(m, f));
    if (d->slip[i] && (slow || JO_RE(s[0] * old[0] + s[1] * old[1]) < 0.0)) {
        e[0] = old[0];
        e[1] = old[1];
    } else if (!slow) {
        e[0] = s[0] / speed;
        e[1] = s[1] / speed;
    }
}

/* friction forces per normal force, -mu e arm, and per torque of the collar, -mu e */
int jo_friction_weights(const jo_model *m, const jo_data *d, int i, jo_real *press, jo_real *collar)
{
    const jo_friction *f = &m->friction[i];
    jo_real e[2], mu = f->data->mu_kinetic;
    if (f->law) {
        jo_friction_direction(m, d, i, e);
    } else {
        jo_friction_slip(m, d, f, e);
        mu = mu_by_speed(f, e[0] * e[0] + e[1] * e[1]);
    }
    for (int k = 0; k < jo_slips(f); k++) {
        press[k] = -mu * e[k] * jo_slip_arm(m, f, k);
        collar[k] = jo_slip_turns(m, f, k) ? -mu * e[k] : 0.0;
    }
    return e[0] != 0.0 || e[1] != 0.0;
}

/* friction forces y (2) along the coordinates of a sliding joint; 0 if it sticks */
void jo_friction_sliding_force(const jo_model *m, const jo_data *d, int i, jo_real *y)
{
    const jo_friction *f = &m->friction[i];
    jo_real pressed[2], turned[2], collar;
    y[0] = y[1] = 0.0;
    if (jo_sticks(m, d, f) || jo_friction_apart(m, d, f)) return;
    const jo_real N = normal_force(m, d, f, &collar);
    jo_friction_weights(m, d, i, pressed, turned);
    for (int k = 0; k < jo_slips(f); k++) y[k] = pressed[k] * N + turned[k] * collar;
}

/* g = factor times the gradient of |(x, y)| */
static void gradient_of_length(jo_real *g, jo_real x, jo_real y, jo_real factor)
{
    const jo_real whole = jo_length2(x, y);
    g[0] = JO_RE(whole) > 0.0 ? factor * x / whole : 0.0;
    g[1] = JO_RE(whole) > 0.0 ? factor * y / whole : 0.0;
    g[2] = 0.0;
}

/* derivative of mu_by_speed with respect to the square of the speed */
static jo_real mu_rate(const jo_friction *f, jo_real square)
{
    const jo_real kinetic = f->data->mu_kinetic, top = f->data->mu_static, velocity = f->data->velocity;
    const jo_real w2 = square / (velocity * velocity);
    if (JO_RE(w2) < 1.0) return top * (6.0 * w2 - 10.0) / (8.0 * velocity * velocity * velocity);
    const jo_real speed = jo_sqrt(square), x = speed / velocity - 1.0, y = 1.0 - x;
    const jo_real rate = JO_RE(x) > 1.0 ? 0.0 : 30.0 * (kinetic - top) * x * x * y * y / velocity;
    return (rate - mu_by_speed(f, square)) / (2.0 * square);
}

/* derivatives of the friction forces with respect to rates and reaction: f = -e(s') (arm N + around collar) */
void jo_friction_slopes(const jo_model *m, const jo_data *d, int i, jo_slopes *y)
{
    const jo_friction *f = &m->friction[i];
    const jo_real *A = d->marker[m->joint[f->joint].side[0]].A;
    const jo_friction_data *data = f->data;
    const jo_slopes none = {{{0.0}}, {{0.0}}, {{0.0}}};
    jo_real s[2], e[2], E[2][2] = {{0.0}}, F[6], *M = F + 3, collar, g[3], h[3], c[3] = {0.0, 0.0, 0.0};
    *y = none;
    if (jo_sticks(m, d, f)) return;
    jo_friction_reaction(m, d, f, d->lam, F);
    const jo_real N = jo_friction_normal_force(m, f, F, &collar);
    jo_friction_slip(m, d, f, s);
    const jo_real square = s[0] * s[0] + s[1] * s[1];
    /* e = mu direction and E = de/ds' */
    if (f->law) {
        jo_friction_direction(m, d, i, e);
        const jo_real speed = jo_length2(s[0], s[1]);
        const int follows = jo_slips(f) == 2 && JO_RE(speed) > JO_REST * jo_slip_scale(m, f);
        for (int k = 0; k < 2; k++) {
            for (int j = 0; follows && j < 2; j++) E[k][j] = data->mu_kinetic * ((k == j) - e[k] * e[j]) / speed;
        }
        for (int k = 0; k < 2; k++) e[k] *= data->mu_kinetic;
    } else {
        const jo_real mu = mu_by_speed(f, square), rate = JO_RE(square) > 0.0 ? mu_rate(f, square) : 0.0;
        for (int k = 0; k < 2; k++) {
            for (int j = 0; j < 2; j++) E[k][j] = mu * (k == j) + 2.0 * rate * s[k] * s[j];
            e[k] = mu * s[k];
        }
    }
    /* gradients g, h of N and c of the collar, in the axes of side 0 */
    if (JO_RE(data->plane) > 0.0) {
        g[0] = g[1] = g[2] = 0.0;
        if (f->contact < 0) g[2] = JO_RE(F[2]) < 0.0 ? -1.0 : 1.0;
    } else {
        gradient_of_length(g, F[0], F[1], 1.0);
    }
    gradient_of_length(h, M[0], M[1], JO_RE(data->bearing) > 0.0 ? 1.0 / data->bearing : 0.0);
    if (JO_RE(data->collar) > 0.0) {
        if (jo_slip_turns(m, f, 0)) c[2] = JO_RE(F[2]) < 0.0 ? -data->collar : data->collar;
        else h[2] = (JO_RE(M[2]) < 0.0 ? -1.0 : 1.0) / data->collar;
    }
    for (int k = 0; k < jo_slips(f); k++) {
        const jo_real a = jo_slip_arm(m, f, k), around = jo_slip_turns(m, f, k);
        for (int j = 0; j < jo_slips(f); j++) y->rate[k][j] = -E[k][j] * jo_slip_arm(m, f, j) * (a * N + around * collar);
        jo_real x[3];
        for (int j = 0; j < 3; j++) x[j] = -e[k] * (a * g[j] + around * c[j]);
        jo_mul3(y->force[k], A, x);
        for (int j = 0; j < 3; j++) x[j] = -e[k] * a * h[j];
        jo_mul3(y->moment[k], A, x);
    }
}

/* forces y (2) along the coordinates of a sticking joint: -lam factor of its lock rows */
void jo_friction_sticking_force(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *y)
{
    const jo_joint *k = &m->joint[f->lock];
    y[1] = 0.0;
    if (jo_tree_active(d)) {
        jo_tree_sticking_force(m, d, f, y);
        return;
    }
    for (int r = 0; r < jo_slips(f); r++) y[r] = -d->lam[k->row + r] * m->line[k->line + r].data->factor[0];
}

/* sliding friction force i, stored in rub, on the bodies; 0 while the friction sticks, since its lock rows act then */
void jo_friction_apply_force(const jo_model *m, jo_data *d, int i)
{
    if (jo_sticks(m, d, &m->friction[i])) return;
    for (int k = 0; k < jo_slips(&m->friction[i]); k++)
        if (d->rub[2 * i + k] != 0.0) jo_push_along(m, d, jo_slip_of(&m->friction[i], k), d->rub[2 * i + k]);
}

/* Sliding friction of contacts on the bodies: their normal forces follow from the state, so that these forces are known in advance. */
void jo_friction_push_contacts(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++) {
        const jo_friction *f = &m->friction[i];
        jo_real *y = d->rub + 2 * i;
        if (f->contact < 0) continue;
        jo_friction_sliding_force(m, d, i, y);
        jo_friction_apply_force(m, d, i);
        for (int k = 0; k < jo_slips(f); k++) d->power.friction -= y[k] * d->coordinate[jo_slip_of(f, k)].rate;
    }
}

/* friction forces at given multipliers and velocities, on the bodies and in rub */
void jo_friction_apply_forces(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++) jo_friction_sliding_force(m, d, i, d->rub + 2 * i);
    for (int i = 0; i < m->nfriction; i++) jo_friction_apply_force(m, d, i);
    for (int i = 0; i < m->nfriction; i++)   /* sticking: force of the lock row */
        if (jo_sticks(m, d, &m->friction[i])) jo_friction_sticking_force(m, d, &m->friction[i], d->rub + 2 * i);
}

/* end of a step: the direction of slip along two coordinates becomes the direction of the slip velocity */
void jo_friction_update_direction(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++) {
        const jo_friction *f = &m->friction[i];
        if (!f->law || jo_sticks(m, d, f) || jo_slips(f) == 1) continue;
        jo_real e[2];
        jo_friction_direction(m, d, i, e);
        for (int k = 0; k < 2; k++) d->direction[2 * i + k] = e[k];
    }
}
