/* state.c - state of a mechanism: poses and velocities at q, v, increments of positions, residuals, check that the state is finite.
 *
 * Positions move by increments [dR (world), dtheta (local), dp]; orientations are e o exp(dtheta).
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "beam/beam.h"
#include "tree/tree.h"

/* sum of the magnitudes of coordinates and velocities of a body, SI units, above which the run counts as diverged */
#define JO_MAX_STATE 1e15

/* integrate x, u (tree) or q, v: pointers y, w, wd to them and their sizes; the states of forces are copied */
void jo_select_coordinates(const jo_model *m, jo_data *d, int tree)
{
    const int nu = m->nu, nv = m->nv;
    for (int i = 0; jo_tree_active(d) != tree && i < m->nstate; i++) {   /* copy the states of forces */
        const jo_real x = tree ? d->v[nv + i] : d->u[nu + i], rate = tree ? d->a[nv + i] : d->ud[nu + i];
        *(tree ? d->u + nu + i : d->v + nv + i) = x;
        *(tree ? d->ud + nu + i : d->a + nv + i) = rate;
    }
    jo_tree_chosen(d, tree);
    d->y = tree ? d->x : d->q;
    d->w = tree ? d->u : d->v;
    d->wd = tree ? d->ud : d->a;
    d->ny = tree ? m->nx : m->nq;
    d->nw = (tree ? nu : nv) + m->nstate;
    for (int i = 0; i < m->nbody; i++) d->body[i].maximal.modes = m->body[i].iv + 6;
    for (int i = 0; tree && i < jo_nmaximal(d); i++) d->body[m->link[i].body].maximal.modes = m->link[i].u + 6;
}

/* q or x = q0 o increment */
void jo_integrate_positions(const jo_model *m, jo_data *d, const jo_real *increment)
{
    jo_positions_moved(d);
    if (jo_tree_active(d)) jo_tree_add_increment(m, d->y, d->q0, increment);
    else jo_add_increment(m, d->q, d->q0, increment);
}

/* rate of the increments x at the present velocities */
void jo_position_rate(const jo_model *m, const jo_data *d, jo_real *rate, const jo_real *x)
{
    if (jo_tree_active(d)) jo_tree_increment_rate(m, rate, x, d->w);
    else jo_increment_rate(m, rate, x, d->v);
}

/* poses and velocities of the bodies and positions of the markers at q, v */
void jo_update_positions(const jo_model *m, jo_data *d)
{
    if (!jo_in_hybrid(d)) jo_sync_maximal_state(m, d, JO_SYNC_STATE);
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        if (jo_body_inactive(d, i)) continue;
        jo_body_pose(b, &d->body[i], d->q + b->iq);
        jo_body_twist(b, &d->body[i], d->v + b->iv);
    }
    jo_marker_position(m, d, m->nactive);
    if (m->ncoordinate) jo_coordinates(m, d, m->ncoordinate);
}

/* largest speed of the bodies, m/s; angular velocities times the size of the mechanism */
jo_real jo_speed(const jo_model *m, const jo_data *d)
{
    jo_real fastest = {0.0};
    for (int i = 0; i < m->nbody; i++) {
        const jo_real *v = d->v + m->body[i].iv;
        if (jo_body_inactive(d, i)) continue;
        for (int j = 0; j < 3; j++)
            fastest = jo_maximum(fastest, jo_maximum(jo_magnitude(v[j]), m->size * jo_magnitude(v[3 + j])));
    }
    return fastest;
}

/* largest position residual, m, and velocity residual, m/s */
void jo_residuals(const jo_model *m, jo_data *d, jo_real *out)
{
    jo_update_positions(m, d);
    jo_marker_velocity(m, d, m->nactive);
    out[0] = jo_largest_residual(m, d);
    out[1] = jo_largest_residual_rate(m, d);
}

void jo_constraints(const jo_model *m, jo_data *d, jo_real *c, jo_real *cdot)
{
    jo_real unused[2];
    jo_residuals(m, d, unused);
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) {
            c[m->joint[i].row + r] = d->joint[i].c[r];
            cdot[m->joint[i].row + r] = d->joint[i].cdot[r];
        }
}

/* q = q0 o increment [dR (world), dtheta (local), dp] of one body */
void jo_body_add_increment(const jo_body *b, jo_real *q, const jo_real *q0, const jo_real *increment)
{
    const jo_real *x = q0 + b->iq, *dx = increment + b->iv;
    jo_real *y = q + b->iq;
    for (int j = 0; j < 3; j++) y[j] = x[j] + dx[j];
    for (int j = 0; j < 4; j++) y[3 + j] = x[3 + j];
    jo_rotate(y + 3, dx + 3);
    for (int j = 0; j < b->n; j++) y[7 + j] = x[7 + j] + dx[6 + j];
}

void jo_add_increment(const jo_model *m, jo_real *q, const jo_real *q0, const jo_real *increment)
{
    for (int i = 0; i < m->nbody; i++) jo_body_add_increment(&m->body[i], q, q0, increment);
}

/* rate of the increments x at velocities v: [R', inverse tangent operator times w, p'] */
void jo_increment_rate(const jo_model *m, jo_real *rate, const jo_real *x, const jo_real *v)
{
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        const int o = b->iv;
        jo_set3(rate + o, v + o);
        jo_rotation_rate(rate + o + 3, x + o + 3, v + o + 3);
        for (int j = 6; j < 6 + b->n; j++) rate[o + j] = v[o + j];
    }
}

/* body on which a force acts; 0 if it acts on none or on several */
static int body_of_force(const jo_model *m, const jo_force *f)
{
    const int a = f->coordinate < 0 ? f->a : m->coordinate[f->coordinate].a, b = f->coordinate < 0 ? f->b : m->coordinate[f->coordinate].b;
    const int body = b >= 0 && m->marker[b].body >= 0 ? m->marker[b].body : a >= 0 ? m->marker[a].body : 0;
    return body < 0 ? 0 : body;
}

/* whether a state of a force exceeds JO_MAX_STATE; error_index: body of the force */
static int check_force_states(const jo_model *m, jo_data *d)
{
    jo_real *x = jo_states(m, d);
    for (int k = 0; k < m->nforce; k++) {
        const jo_force *f = &m->force[k];
        for (int i = f->state; i < f->state + f->states; i++) {
            if (!jo_spoil(x + i, JO_LESS(jo_magnitude(x[i]), JO_MAX_STATE))) continue;
            d->error_index = body_of_force(m, f);
            return 1;
        }
    }
    return 0;
}

/* JO_NOT_FINITE with error_index if the state of a body or force exceeds JO_MAX_STATE */
int jo_check(const jo_model *m, jo_data *d)
{
    if (m->nstate && check_force_states(m, d)) return JO_NOT_FINITE;
    if (jo_tree_active(d)) return jo_tree_check_state(m, d);
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        jo_real sum = {0.0};
        for (int j = 0; j < 6 + b->n; j++) sum += jo_magnitude(d->v[b->iv + j]);
        for (int j = 0; j < 7 + b->n; j++) sum += jo_magnitude(d->q[b->iq + j]);
        if (jo_spoil(d->v + b->iv, JO_LESS(sum, JO_MAX_STATE))) {
            d->error_index = i;
            return JO_NOT_FINITE;
        }
    }
    return JO_OK;
}

void jo_restart(jo_data *d)
{
    jo_history_forgotten(d);
    jo_beam_reset_history(d);
}

void jo_data_count_turns(const jo_model *m, jo_data *d)
{
    if (!m->nturn) return;
    jo_update_positions(m, d);
    jo_count_turns(m, d);
}
