/* constraints.c - constraint equations of joints: residuals, Jacobian, acceleration terms, and their forces on the bodies.
 *
 * Rows (Rantalainen 2007, eq. 3.90-3.96): r_b - r_a = 0, (axis of a) . (axis of b) = 0 and lines: relations
 * sum f_i s_i - offset - signal(t) = 0 of coordinates, whose right-hand side may depend on time (eq. 3.84-3.89).
 * Multipliers: M a + Cq^T lam = Q, so the joint acts with -Cq^T lam on the bodies.
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "force/force.h"

/* index of the first line among the rows of a joint */
static int first_line(const jo_joint *k) { return (k->coincident ? 3 : 0) + k->nperp; }

static void clear(jo_real *x, int count)
{
    for (int i = 0; i < count; i++) x[i] = jo_same(0.0);
}

/* length, m, that corresponds to a residual of 1 of a line: 1 / largest factor, for angles times the size of the mechanism */
static inline jo_real line_metres(const jo_model *m, const jo_line *line)
{
    jo_real most = {0.0};
    for (int j = 0; j < line->count; j++) {
        const int angle = m->coordinate[line->coordinate[j]].type == JO_COORDINATE_ANGLE;
        most = jo_maximum(most, jo_magnitude(line->data->factor[j]) * (angle ? 1.0 / m->size : 1.0));
    }
    return 1.0 / most;
}

/* length, m, that corresponds to a residual of 1 of a row: for cosines the size of the mechanism */
static inline jo_real row_metres(const jo_model *m, const jo_joint *k, int row)
{
    if (row >= first_line(k)) return line_metres(m, &m->line[k->line + row - first_line(k)]);
    return jo_same(k->coincident && row < 3 ? 1.0 : m->size);
}

void jo_row_metres(const jo_model *m, jo_real *out)
{
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) out[m->joint[i].row + r] = row_metres(m, &m->joint[i], r);
}

/* largest residual of the rows of a joint, m, or of their rates, m/s */
static inline jo_real largest_row(const jo_model *m, const jo_joint *k, const jo_real *c)
{
    jo_real x = {0.0};
    for (int r = 0; r < k->nrow; r++) x = jo_maximum(x, jo_magnitude(c[r]) * row_metres(m, k, r));
    return x;
}

/* c = [r_b - r_a, f_a . h_b, sum f_i s_i - offset - signal] of one joint; returns the largest one, m */
static inline jo_real constraint_residual(const jo_model *m, jo_data *d, int joint)
{
    const jo_joint *k = &m->joint[joint];
    const jo_marker_work *a = &d->marker[k->side[0]], *b = &d->marker[k->side[1]];
    jo_real *c = d->joint[joint].c, x[3], y[3];
    if (k->coincident) {
        jo_set3(c, b->r);
        jo_sub3(c, a->r);
        c += 3;
    }
    for (int r = 0; r < k->nperp; r++) {
        jo_axis(x, a->A, k->perp_a[r]);
        jo_axis(y, b->A, k->perp_b[r]);
        c[r] = jo_dot3(x, y);
    }
    for (int l = 0; l < k->nline; l++) {
        const jo_line *line = &m->line[k->line + l];
        jo_real value = k->lock < 0 ? -line->data->offset : -d->held[2 * k->lock + l];
        for (int j = 0; j < line->count; j++) value += line->data->factor[j] * d->coordinate[line->coordinate[j]].value;
        if (line->signal >= 0) value -= jo_signal_at(m, d, line->signal, d->time[0]).value;
        c[k->nperp + l] = value;
    }
    if (jo_absent(d, k)) clear(d->joint[joint].c, k->nrow);
    return largest_row(m, k, d->joint[joint].c);
}

jo_real jo_constraint_residual(const jo_model *m, jo_data *d, int joint) { return constraint_residual(m, d, joint); }

jo_real jo_largest_residual(const jo_model *m, jo_data *d)
{
    jo_real worst = {0.0};
    for (int i = 0; i < m->njoint; i++)
        if (!jo_joint_inactive(d, i)) worst = jo_maximum(worst, constraint_residual(m, d, i));
    return worst;
}

/* cdot of one joint, after jo_coordinate_rate; returns the largest one, m/s */
static inline jo_real constraint_residual_rate(const jo_model *m, jo_data *d, int joint)
{
    const jo_joint *k = &m->joint[joint];
    const jo_marker_work *a = &d->marker[k->side[0]], *b = &d->marker[k->side[1]];
    jo_real *c = d->joint[joint].cdot, x[3], y[3], s[3];
    if (k->coincident) {
        jo_to_world(x, m, d, k->side[0], a->v);
        jo_to_world(c, m, d, k->side[1], b->v);
        jo_sub3(c, x);
        c += 3;
    }
    jo_real rel[3] = {0};
    if (k->nperp) {
        jo_to_world(rel, m, d, k->side[0], a->om);
        jo_to_world(y, m, d, k->side[1], b->om);
        jo_sub3(rel, y);
    }
    for (int r = 0; r < k->nperp; r++) {   /* (om_a - om_b) . (x_a x y_b) */
        jo_axis(x, a->A, k->perp_a[r]);
        jo_axis(y, b->A, k->perp_b[r]);
        jo_cross(s, x, y);
        c[r] = jo_dot3(rel, s);
    }
    for (int l = 0; l < k->nline; l++) {   /* Cq v + C_t */
        const jo_line *line = &m->line[k->line + l];
        jo_real rate = {0.0};
        for (int j = 0; j < line->count; j++) rate += line->data->factor[j] * d->coordinate[line->coordinate[j]].rate;
        if (line->signal >= 0) rate -= jo_signal_at(m, d, line->signal, d->time[0]).rate;
        c[k->nperp + l] = rate;
    }
    if (jo_absent(d, k)) clear(d->joint[joint].cdot, k->nrow);
    return largest_row(m, k, d->joint[joint].cdot);
}

jo_real jo_constraint_residual_rate(const jo_model *m, jo_data *d, int joint) { return constraint_residual_rate(m, d, joint); }

jo_real jo_largest_residual_rate(const jo_model *m, jo_data *d)
{
    jo_real worst = {0.0};
    if (m->nline) jo_coordinates_rate(m, d, m->ncoordinate);
    for (int i = 0; i < m->njoint; i++)
        if (!jo_joint_inactive(d, i)) worst = jo_maximum(worst, constraint_residual_rate(m, d, i));
    return worst;
}

/* four rows of V = L^-1 (C X)^T with the translations Xt and rotations Xr, 0 if the rows do not depend on them; L is 0 for a rigid body,
 * whose X includes L^-T */
static inline void reduced_rows(jo_real *restrict V, const int ld, const jo_real *restrict C, const jo_real *restrict turn,
                                const jo_real *restrict Xt, const jo_real *restrict Xr, const jo_real *restrict L)
{
    for (int l = 0; l < 4; l += JO_WIDTH) {
        jo_lanes v[6];
        for (int i = 0; i < 6; i++) {
            const jo_lanes zero = {0};
            v[i] = zero;
        }
        if (Xt)
            for (int i = 0; i < 6; i++)
                v[i] += Xt[i] * JO_LOAD(C + l) + Xt[6 + i] * JO_LOAD(C + ld + l) + Xt[12 + i] * JO_LOAD(C + 2 * ld + l);
        if (Xr)
            for (int i = 0; i < 6; i++)
                v[i] += Xr[i] * JO_LOAD(turn + l) + Xr[6 + i] * JO_LOAD(turn + ld + l) + Xr[12 + i] * JO_LOAD(turn + 2 * ld + l);
        if (L)
            for (int i = 0; i < 6; i++) {
                for (int k = 0; k < i; k++) v[i] -= L[6 * i + k] * v[k];
                v[i] *= L[7 * i];
            }
        for (int i = 0; i < 6; i++) JO_STORE(V + i * ld + l) = v[i];
    }
}

/* row r of C = [f, T^T t, t]: translation f and rotation t, local */
static inline void put_row(jo_real *restrict C, const int ld, const int r, const jo_real *f, const jo_real *t, const jo_real *T)
{
    for (int j = 0; f && j < 3; j++) C[ld * j + r] = f[j];
    if (!T) {
        for (int j = 0; j < 3; j++) C[ld * (3 + j) + r] = t[j];
        return;
    }
    jo_real shape[3];
    jo_mul3t(shape, T, t);
    for (int j = 0; j < 3; j++) {
        C[ld * (3 + j) + r] = shape[j];
        C[ld * (6 + j) + r] = t[j];
    }
}

/* derivatives f, g of the rate of a line with respect to velocity and angular velocity (world) of a side */
static void line_jacobian(const jo_data *d, const jo_line *line, int side, jo_real *f, jo_real *g)
{
    for (int i = 0; i < 3; i++) f[i] = g[i] = jo_same(0.0);
    for (int j = 0; j < line->count; j++) {
        const jo_coordinate_work *s = &d->coordinate[line->coordinate[j]];
        const jo_real factor = line->data->factor[j];
        if (side == line->side[j]) {
            jo_axpy3(f, -factor, s->along);
            jo_axpy3(g, factor, s->turn_a);
        } else if (side == line->side[j] + 1) {
            jo_axpy3(f, factor, s->along);
            jo_axpy3(g, factor, s->turn_b);
        }
    }
}

/* rows of lines on one side: translations and rotations */
static void line_rows(const jo_model *m, jo_data *d, const jo_joint *k, jo_joint_work *w, int side)
{
    jo_side_work *here = &w->maximal.side[side];
    const jo_real *A = here->body->A;
    const int first = first_line(k);
    for (int l = 0; l < k->nline; l++) {
        jo_real f[3], g[3], c[3], t[3];
        line_jacobian(d, &m->line[k->line + l], side, f, g);
        jo_mul3t(c, A, f);
        jo_mul3t(t, A, g);
        put_row(here->C, jo_padded(k->nrow), first + l, c, t, here->T);
    }
}

/* rows of r_b - r_a: sign times the columns of A^T */
static inline void moving_rows(jo_real *restrict C, const int ld, const double sign, const jo_real *restrict At)
{
    for (int j = 0; j < 3; j++)
        for (int l = 0; l < 4; l += JO_WIDTH) JO_STORE(C + ld * j + l) = sign * JO_LOAD(At + 4 * j + l);
}

/* C and V of one side of a joint with any rows */
static void any_rows(const jo_model *m, jo_data *d, const jo_joint *k, jo_joint_work *w, int side)
{
    jo_side_work *here = &w->maximal.side[side];
    const jo_marker_work *mw = here->marker;
    const double sign = side ? 1.0 : -1.0;
    const jo_real *A = here->body->A;
    const int ld = jo_padded(k->nrow), first = k->coincident ? 3 : 0, rotations = k->nperp + k->nline;
    jo_real *C = here->C;
    if (first) moving_rows(C, ld, sign, here->body->At);
    for (int r = 0; r < k->nperp; r++) {
        jo_real t[3];
        jo_mul3t(t, A, w->maximal.axes[r]);
        for (int j = 0; j < 3; j++) t[j] *= -sign;
        put_row(C, ld, first + r, 0, t, here->T);
    }
    if (k->nline) line_rows(m, d, k, w, side);
    const jo_real *turn = C + (here->T ? 6 : 3) * ld;
    reduced_rows(here->V, ld, C, turn, first || k->nline ? mw->maximal.Xt : 0, rotations ? mw->maximal.Xr : 0, here->L);
    if (ld > 4) reduced_rows(here->V + 4, ld, C + 4, turn + 4, k->nline ? mw->maximal.Xt : 0, mw->maximal.Xr, here->L);
}

/* axes[r] = f_a x h_b of the rows of perpendicular axes */
static inline void turn_axes(const jo_data *d, const jo_joint *k, jo_joint_work *w)
{
    for (int r = 0; r < k->nperp; r++) {
        jo_real x[3], y[3];
        jo_axis(x, d->marker[k->side[0]].A, k->perp_a[r]);
        jo_axis(y, d->marker[k->side[1]].A, k->perp_b[r]);
        jo_cross(w->maximal.axes[r], x, y);
    }
}

/* Jacobian of all rows with respect to velocity f and angular velocity g (world) of the marker of a side */
void jo_constraint_jacobian(const jo_model *m, jo_data *d, int joint, int side, jo_real (*f)[3], jo_real (*g)[3])
{
    const jo_joint *k = &m->joint[joint];
    jo_joint_work *w = &d->joint[joint];
    const jo_real sign = jo_same(side == 0 ? -1.0 : side == 1 ? 1.0 : 0.0);
    if (!side) turn_axes(d, k, w);
    for (int r = 0; r < first_line(k); r++)
        for (int i = 0; i < 3; i++) f[r][i] = g[r][i] = jo_same(0.0);
    for (int r = 0; k->coincident && r < 3; r++) f[r][r] = sign;
    for (int r = 0; r < k->nperp; r++) jo_axpy3(g[first_line(k) - k->nperp + r], -sign, w->maximal.axes[r]);
    for (int l = 0; l < k->nline; l++) line_jacobian(d, &m->line[k->line + l], side, f[first_line(k) + l], g[first_line(k) + l]);
}

/* C and V = L^-1 (C X)^T of all sides of all joints */
void jo_joint_rows(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        jo_joint_work *w = &d->joint[i];
        if (jo_joint_inactive(d, i)) continue;
        w->maximal.present = !jo_released(d, k->release);
        if (jo_absent(d, k)) continue;
        turn_axes(d, k, w);
        for (int side = 0; side < k->nside; side++) {
            jo_side_work *here = &w->maximal.side[side];
            if (!here->body) continue;
            if (k->nrow == 3 && k->coincident) {
                moving_rows(here->C, 4, side ? 1.0 : -1.0, here->body->At);
                reduced_rows(here->V, 4, here->C, 0, here->marker->maximal.Xt, 0, here->L);
            } else {
                any_rows(m, d, k, w, side);
            }
        }
    }
}

/* x += V^T z, z (6) */
static inline void add_columns(jo_real *restrict x, const jo_real *restrict V, const jo_real *restrict z, const int n)
{
    const int ld = jo_padded(n);
    for (int l = 0; l < ld; l += JO_WIDTH) {
        jo_lanes s = JO_LOAD(x + l);
        for (int c = 0; c < 6; c++) s += z[c] * JO_LOAD(V + c * ld + l);
        JO_STORE(x + l) = s;
    }
}

/* x = sum f_i s_i'' - signal'' of the lines, for the motions of the sides */
static void line_acceleration(const jo_model *m, const jo_data *d, const jo_joint *k, const jo_motion *side, double lead, jo_real *x)
{
    for (int l = 0; l < k->nline; l++) {
        const jo_line *line = &m->line[k->line + l];
        x[l] = jo_same(0.0);
        for (int j = 0; j < line->count; j++) {
            const jo_coordinate_work *s = &d->coordinate[line->coordinate[j]];
            const jo_motion *a = &side[line->side[j]], *b = a + 1;
            jo_real apart[3];
            jo_set3(apart, b->a);
            jo_sub3(apart, a->a);
            x[l] += line->data->factor[j]
                  * (jo_dot3(s->along, apart) + jo_dot3(s->turn_a, a->al) + jo_dot3(s->turn_b, b->al) + s->bias);
        }
        /* a Rosenbrock method: the same lead as in forces, for the time derivative of the right-hand side */
        if (line->signal >= 0) x[l] -= jo_signal_at(m, d, line->signal, d->time[0] + lead).second;
    }
}

/* x = C'' of a joint for the angular velocities and accelerations of its sides:
 * a_b - a_a; (al_a - al_b) . (f x h) + f'' . h + 2 f' . h' + f . h'' with the centripetal part of f'', h''; lines */
static inline void constraint_acceleration(const jo_model *m, const jo_data *d, int joint, const jo_motion *side, double lead, jo_real *x)
{
    const jo_joint *k = &m->joint[joint];
    const jo_joint_work *w = &d->joint[joint];
    if (k->coincident) {
        jo_set3(x, side[1].a);
        jo_sub3(x, side[0].a);
        x += 3;
    }
    for (int r = 0; r < k->nperp; r++) {
        jo_real f[3], h[3], fd[3], hd[3], fdd[3], hdd[3], al[3];
        jo_axis(f, d->marker[k->side[0]].A, k->perp_a[r]);
        jo_axis(h, d->marker[k->side[1]].A, k->perp_b[r]);
        jo_cross(fd, side[0].om, f);
        jo_cross(hd, side[1].om, h);
        jo_cross(fdd, side[0].om, fd);
        jo_cross(hdd, side[1].om, hd);
        jo_set3(al, side[0].al);
        jo_sub3(al, side[1].al);
        x[r] = jo_dot3(al, w->maximal.axes[r]) + jo_dot3(fdd, h) + 2.0 * jo_dot3(fd, hd) + jo_dot3(f, hdd);
    }
    if (k->nline) line_acceleration(m, d, k, side, lead, x + k->nperp);
}

void jo_constraint_acceleration(const jo_model *m, const jo_data *d, int joint, const jo_motion *side, double lead, jo_real *x)
{
    constraint_acceleration(m, d, joint, side, lead, x);
}

/* accelerations and angular velocities of the markers of a joint for R'' = w' = 0 */
static inline void free_marker_motions(const jo_model *m, const jo_data *d, const jo_joint *k, jo_motion *y)
{
    for (int s = 0; s < k->nside; s++, y++) {
        const jo_marker_work *w = &d->marker[k->side[s]];
        if (k->coincident || k->nline) jo_to_world(y->a, m, d, k->side[s], w->a);
        if (k->nperp) jo_to_world(y->om, m, d, k->side[s], w->om);
        if (k->nperp || k->nline) jo_to_world(y->al, m, d, k->side[s], w->a + 3);
    }
}

/* power of the drives of a joint, -lam signal', W */
jo_real jo_joint_drive(const jo_model *m, const jo_data *d, int joint, const jo_real *lam)
{
    const jo_joint *k = &m->joint[joint];
    jo_real power = {0.0};
    for (int l = 0; l < k->nline; l++) {
        const jo_line *line = &m->line[k->line + l];
        if (line->signal >= 0) power -= lam[first_line(k) + l] * jo_signal_at(m, d, line->signal, d->time[0]).rate;
    }
    return power;
}

jo_real jo_joint_power(const jo_model *m, const jo_data *d)
{
    jo_real power = {0.0};
    for (int i = 0; i < m->njoint; i++)
        if (!jo_joint_inactive(d, i)) power += jo_joint_drive(m, d, i, d->joint[i].x);
    return power;
}

/* right-hand side x = Cq a_free + (Cq)' v + 2 alpha C' + beta^2 C of all joints */
void jo_joint_acceleration(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        jo_joint_work *w = &d->joint[i];
        jo_motion motion[JO_MAX_SIDES];
        if (jo_joint_inactive(d, i)) continue;
        if (jo_absent(d, k)) {
            clear(w->x, k->nrow);
            continue;
        }
        free_marker_motions(m, d, k, motion);
        constraint_acceleration(m, d, i, motion, stage->lead, w->x);
        jo_real t[8] = {0};
        for (int side = 0; side < k->nside; side++) {   /* rigid coordinates: C X Z^-1 z = V^T z */
            const jo_side_work *here = &w->maximal.side[side];
            if (!here->body) continue;
#define CALL(n) add_columns(t, here->V, here->body->maximal.z, n)
            JO_BY_ROWS(k->nrow, CALL)
#undef CALL
        }
        for (int r = 0; r < k->nrow; r++) w->x[r] += t[r];
        if (jo_stabilised(stage))
            for (int r = 0; r < k->nrow; r++)
                w->x[r] += 2.0 * stage->alpha * w->cdot[r] + stage->beta * stage->beta * w->c[r];
    }
}

/* x += C a with column c of the rows C and a = P yp, P (np) */
static inline void add_modal_change(jo_real *x, const jo_real *C, const jo_real *P, const jo_real *yp, const int np, const int n)
{
    jo_real a = jo_same(0.0);
    for (int j = 0; j < np; j++) a += P[j] * yp[j];
    for (int r = 0; r < n; r++) x[r] += C[r] * a;
}

/* x = Cq M^-1 Q of one joint for changes of force Q in y, reduced, and yp of the bodies */
static void force_change(const jo_model *m, jo_data *d, int set, int joint)
{
    const jo_joint *k = &m->joint[joint];
    jo_joint_work *w = &d->joint[joint];
    const int n = k->nrow, ld = jo_padded(n);
    for (int r = 0; r < n; r++) w->x[r] = jo_same(0.0);
    if (jo_absent(d, k)) return;
    for (int s = 0; s < k->nside; s++) {
        const jo_side_work *here = &w->maximal.side[s];
        if (!here->body || !here->body->maximal.changed) continue;
        for (int c = 0; c < 6; c++)
            for (int r = 0; r < n; r++) w->x[r] += here->V[c * ld + r] * here->body->y[c];
        if (!here->L) continue;   /* rigid */
        const jo_marker *mk = &m->marker[k->side[s]];
        const jo_marker_set *weighted = &here->marker->maximal.set[set];
        const int np = m->body[mk->body].np;
        for (int c = 0; c < 3 && mk->Phi; c++)
            add_modal_change(w->x, here->C + c * ld, weighted->Phiw + c * np, here->body->yp, np, n);
        for (int c = 0; c < 3 && mk->Psi; c++)
            add_modal_change(w->x, here->C + (3 + c) * ld, weighted->Psiw + c * np, here->body->yp, np, n);
    }
}

/* right-hand side x = Cq M^-1 Q of all joints for the changes of force Q of jo_push_change, whose y is reduced */
void jo_joint_force_change(const jo_model *m, jo_data *d, int set)
{
    for (int i = 0; i < m->nbody; i++) {
        jo_body_work *w = &d->body[i];
        if (w->maximal.changed) jo_body_reduce(&m->body[i], w, set, w->y, w->yp, w->y);
    }
    for (int i = 0; i < m->njoint; i++) force_change(m, d, set, i);
}

/* fp -= P^T f, P (3 x np) */
static inline void subtract_modal(jo_real *restrict fp, const jo_real *restrict P, const jo_real *f, int np)
{
    const jo_real f0 = f[0], f1 = f[1], f2 = f[2];
    JO_EACH(j, np) JO_STORE(fp + j) -= f0 * JO_LOAD(P + j) + f1 * JO_LOAD(P + np + j) + f2 * JO_LOAD(P + 2 * np + j);
}

/* y -= V x, y (6) */
static inline void subtract_rows(jo_real *restrict y, const jo_real *restrict V, const jo_real *restrict x,
                                 const int n)
{
    const int ld = jo_padded(n);
    for (int j = 0; j < 6; j++) {
        jo_real s = y[j];
        for (int r = 0; r < n; r++) s -= V[ld * j + r] * x[r];
        y[j] = s;
    }
}

/* f (3) = C^T x with rows first .. end - 1 of three columns of C */
static inline void row_force(jo_real *f, const jo_real *restrict C, const int ld, const jo_real *restrict x, int first, int end)
{
    for (int j = 0; j < 3; j++) {
        f[j] = jo_same(0.0);
        for (int r = first; r < end; r++) f[j] += C[ld * j + r] * x[r];
    }
}

/* accelerations with the multipliers x: y = L^-T (z - V x), f_p -= L_p^T C^T x, y_p = weight (f_p - M_pr y) */
void jo_joint_apply(const jo_model *m, jo_data *d, int set)
{
    for (int i = 0; i < m->nbody; i++)
        for (int j = 0; j < 6 && !jo_body_inactive(d, i); j++) d->body[i].y[j] = d->body[i].maximal.z[j];
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        const jo_joint_work *w = &d->joint[i];
        if (jo_joint_inactive(d, i) || jo_absent(d, k)) continue;
        for (int side = 0; side < k->nside; side++) {
            const jo_side_work *here = &w->maximal.side[side];
            if (!here->body) continue;
            jo_body_work *bw = here->body;
#define CALL(n) subtract_rows(bw->y, here->V, w->x, n)
            JO_BY_ROWS(k->nrow, CALL)
#undef CALL
            if (!here->L) continue;   /* rigid */
            const jo_marker *mk = &m->marker[k->side[side]];
            const int moving = k->coincident ? 3 : 0, ld = jo_padded(k->nrow), np = m->body[mk->body].np;
            jo_real f[3];
            if (mk->Phi && (moving || k->nline)) {
                row_force(f, here->C, ld, w->x, 0, k->nline ? k->nrow : moving);
                subtract_modal(bw->fp, here->marker->Phi, f, np);
            }
            if (mk->Psi && k->nrow > moving) {
                row_force(f, here->C + 3 * ld, ld, w->x, moving, k->nrow);
                subtract_modal(bw->fp, here->marker->Psi, f, np);
            }
        }
    }
    for (int i = 0; i < m->nbody; i++) {
        jo_body_work *bw = &d->body[i];
        if (jo_body_inactive(d, i)) continue;
        jo_body_backward(bw->maximal.L, bw->y);
        if (m->body[i].n) jo_body_modal(&m->body[i], bw, set);
    }
}
