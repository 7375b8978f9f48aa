/* joint.c - constraint rows between markers.
 *
 * Rows (Rantalainen 2007, eq. 3.90-3.96): r_b - r_a = 0, (axis of a) . (axis of b) = 0 and lines, relations
 * sum f_i s_i - offset - signal(t) = 0 of coordinates, whose right-hand side may depend on time (eq. 3.84-3.89).
 * Multipliers: M a + Cq^T lam = Q, so the joint acts with -Cq^T lam on the bodies.
 */
#include "internal.h"

static void axis(jo_real *x, const jo_real *A, int i) { x[0] = A[i]; x[1] = A[3 + i]; x[2] = A[6 + i]; }

static int first_line(const jo_joint *k) { return (k->coincident ? 3 : 0) + k->nperp; }

static void clear(jo_real *x, int count)
{
    for (int i = 0; i < count; i++) x[i] = 0.0;
}

static double largest(const jo_real *c, int count)
{
    double x = 0.0;
    for (int r = 0; r < count; r++) {
        const double y = fabs(JO_RE(c[r]));
        if (!(y <= x)) x = y;   /* a NaN stays */
    }
    return x;
}

double jo_joint_residual(const jo_model *m, jo_data *d)
{
    double worst = 0.0;
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        const jo_marker_work *a = &d->marker[k->side[0]], *b = &d->marker[k->side[1]];
        jo_real *c = d->joint[i].c, x[3], y[3];
        if (k->coincident) {
            jo_set3(c, b->r);
            jo_sub3(c, a->r);
            c += 3;
        }
        for (int r = 0; r < k->nperp; r++) {
            axis(x, a->A, k->perp_a[r]);
            axis(y, b->A, k->perp_b[r]);
            c[r] = jo_dot3(x, y);
        }
        for (int l = 0; l < k->nline; l++) {
            const jo_line *line = &m->line[k->line + l];
            jo_real value = k->lock < 0 ? -line->data[0] : -d->held[2 * k->lock + l];
            for (int j = 0; j < line->count; j++) value += line->data[1 + j] * d->coordinate[line->coordinate[j]].value;
            if (line->signal >= 0) value -= jo_signal_at(m, d, line->signal, d->time[0]).value;
            c[k->nperp + l] = value;
        }
        if (jo_absent(d, k)) clear(d->joint[i].c, k->nrow);
        const double gap = largest(d->joint[i].c, k->nrow);
        if (!(gap <= worst)) worst = gap;
    }
    return worst;
}

double jo_joint_residual_rate(const jo_model *m, jo_data *d)
{
    double worst = 0.0;
    if (m->nline) jo_coordinates_rate(m, d, m->ncoordinate);
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        const jo_marker_work *a = &d->marker[k->side[0]], *b = &d->marker[k->side[1]];
        jo_real *c = d->joint[i].cdot, x[3], y[3], s[3];
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
            axis(x, a->A, k->perp_a[r]);
            axis(y, b->A, k->perp_b[r]);
            jo_cross(s, x, y);
            c[r] = jo_dot3(rel, s);
        }
        for (int l = 0; l < k->nline; l++) {   /* Cq v + C_t */
            const jo_line *line = &m->line[k->line + l];
            jo_real rate = 0.0;
            for (int j = 0; j < line->count; j++) rate += line->data[1 + j] * d->coordinate[line->coordinate[j]].rate;
            if (line->signal >= 0) rate -= jo_signal_at(m, d, line->signal, d->time[0]).rate;
            c[k->nperp + l] = rate;
        }
        if (jo_absent(d, k)) clear(d->joint[i].cdot, k->nrow);
        const double rate = largest(d->joint[i].cdot, k->nrow);
        if (!(rate <= worst)) worst = rate;
    }
    return worst;
}

/* V = L^-1 V for n columns */
static inline void forward(const jo_real *restrict L, jo_real *restrict V, const int n)
{
    for (int i = 0; i < 6; i++)
        for (int r = 0; r < n; r++) {
            jo_real x = V[6 * i + r];
            for (int k = 0; k < i; k++) x -= L[6 * i + k] * V[6 * k + r];
            V[6 * i + r] = x * L[7 * i];
        }
}

/* the rows of lines on one side, which see translations and rotations */
static void line_rows(const jo_model *m, jo_data *d, const jo_joint *k, jo_joint_work *w, int side)
{
    const int marker = k->side[side];
    const jo_marker_work *mw = &d->marker[marker];
    const jo_real *A = d->body[m->marker[marker].body].A;
    const int first = first_line(k);
    for (int l = 0; l < k->nline; l++) {
        const jo_line *line = &m->line[k->line + l];
        const int r = first + l;
        jo_real *C = w->C[side] + 6 * r, f[3] = {0.0, 0.0, 0.0}, g[3] = {0.0, 0.0, 0.0}, t[3];
        for (int j = 0; j < line->count; j++) {
            const jo_coordinate_work *s = &d->coordinate[line->coordinate[j]];
            const jo_real factor = line->data[1 + j];
            if (side == line->side[j]) {
                jo_axpy3(f, -factor, s->along);
                jo_axpy3(g, factor, s->turn_a);
            } else if (side == line->side[j] + 1) {
                jo_axpy3(f, factor, s->along);
                jo_axpy3(g, factor, s->turn_b);
            }
        }
        jo_mul3t(C, A, f);
        jo_mul3t(t, A, g);
        if (m->marker[marker].Psi) jo_mul3t(C + 3, mw->T, t);
        else jo_set3(C + 3, t);
        const jo_real *X = mw->Xt, *Y = mw->Xr;
        for (int j = 0; j < 6; j++)
            w->V[side][6 * j + r] = C[0] * X[j] + C[1] * X[6 + j] + C[2] * X[12 + j]
                                    + t[0] * Y[j] + t[1] * Y[6 + j] + t[2] * Y[12 + j];
    }
}

/* rows C of both sides in body coordinates, V = L^-1 (reduced rows)^T */
void jo_joint_rows(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        jo_joint_work *w = &d->joint[i];
        for (int r = 0; r < k->nperp; r++) {
            jo_real x[3], y[3];
            axis(x, d->marker[k->side[0]].A, k->perp_a[r]);
            axis(y, d->marker[k->side[1]].A, k->perp_b[r]);
            jo_cross(w->axes[r], x, y);
        }
        for (int side = 0; side < k->nside; side++) {
            const int marker = k->side[side];
            const int body = m->marker[marker].body;
            if (body < 0) continue;
            const jo_marker_work *mw = &d->marker[marker];
            const jo_real sign = side ? 1.0 : -1.0, *A = d->body[body].A;
            jo_real *C = w->C[side], *V = w->V[side];
            int first = 0;
            if (jo_absent(d, k)) {
                clear(C, 36);
                clear(V, 36);
                continue;
            }
            if (k->coincident) {
                const jo_real *X = mw->Xt;
                for (int r = 0; r < 3; r++) {
                    const jo_real c0 = sign * A[3 * r], c1 = sign * A[3 * r + 1], c2 = sign * A[3 * r + 2];
                    C[6 * r] = c0; C[6 * r + 1] = c1; C[6 * r + 2] = c2;
                    C[6 * r + 3] = C[6 * r + 4] = C[6 * r + 5] = 0.0;
                    for (int j = 0; j < 6; j++) V[6 * j + r] = c0 * X[j] + c1 * X[6 + j] + c2 * X[12 + j];
                }
                first = 3;
            }
            for (int r = first; r < first + k->nperp; r++) {
                const jo_real *X = mw->Xr;
                jo_real t[3];
                jo_mul3t(t, A, w->axes[r - first]);
                for (int j = 0; j < 3; j++) t[j] *= -sign;
                C[6 * r] = C[6 * r + 1] = C[6 * r + 2] = 0.0;
                if (m->marker[marker].Psi) jo_mul3t(C + 6 * r + 3, mw->T, t);
                else jo_set3(C + 6 * r + 3, t);
                for (int j = 0; j < 6; j++) V[6 * j + r] = t[0] * X[j] + t[1] * X[6 + j] + t[2] * X[12 + j];
            }
            if (k->nline) line_rows(m, d, k, w, side);
#define CALL(n) forward(d->body[body].L, V, n)
            JO_BY_ROWS(k->nrow, CALL)
#undef CALL
        }
    }
}

/* x += V^T z, six rows */
static inline void add_columns(jo_real *restrict x, const jo_real *restrict V, const jo_real *restrict z, const int n)
{
    for (int r = 0; r < n; r++) {
        jo_real s = x[r];
        for (int c = 0; c < 6; c++) s += V[6 * c + r] * z[c];
        x[r] = s;
    }
}

/* second derivatives of the lines while R'' = w' = 0, minus those of their signals */
static void line_acceleration(const jo_model *m, const jo_data *d, const jo_joint *k, jo_real *x)
{
    for (int l = 0; l < k->nline; l++) {
        const jo_line *line = &m->line[k->line + l];
        x[l] = 0.0;
        for (int j = 0; j < line->count; j++) {
            const jo_coordinate *c = &m->coordinate[line->coordinate[j]];
            const jo_coordinate_work *s = &d->coordinate[line->coordinate[j]];
            const jo_marker_work *a = &d->marker[c->a], *b = &d->marker[c->b];
            jo_real aa[3], ab[3], ta[3], tb[3];
            jo_to_world(aa, m, d, c->a, a->a);
            jo_to_world(ab, m, d, c->b, b->a);
            jo_to_world(ta, m, d, c->a, a->a + 3);
            jo_to_world(tb, m, d, c->b, b->a + 3);
            jo_sub3(ab, aa);
            x[l] += line->data[1 + j] * (jo_dot3(s->along, ab) + jo_dot3(s->turn_a, ta) + jo_dot3(s->turn_b, tb) + s->bias);
        }
        /* the matrix of ROS2 knows the time derivative of the right-hand side as that of the forces */
        if (line->signal >= 0) x[l] -= jo_signal_at(m, d, line->signal, d->time[0] + d->lead).second;
    }
}

/* rate of the work of the drives, -lam signal' */
jo_real jo_joint_power(const jo_model *m, const jo_data *d)
{
    jo_real power = 0.0;
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        for (int l = 0; l < k->nline; l++) {
            const jo_line *line = &m->line[k->line + l];
            if (line->signal >= 0)
                power -= d->joint[i].x[first_line(k) + l] * jo_signal_at(m, d, line->signal, d->time[0]).rate;
        }
    }
    return power;
}

/* right-hand side x = Cq a_free + (Cq)' v, plus Baumgarte terms if asked for */
void jo_joint_acceleration(const jo_model *m, jo_data *d, const jo_solver *solver)
{
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        const jo_marker_work *a = &d->marker[k->side[0]], *b = &d->marker[k->side[1]];
        jo_joint_work *w = &d->joint[i];
        jo_real *x = w->x;
        if (jo_absent(d, k)) {
            clear(x, k->nrow);
            continue;
        }
        if (k->coincident) {
            jo_real t[3];
            jo_to_world(t, m, d, k->side[0], a->a);
            jo_to_world(x, m, d, k->side[1], b->a);
            jo_sub3(x, t);
            x += 3;
        }
        if (k->nperp) {
            jo_real oma[3], omb[3], aa[3], ab[3];
            jo_to_world(oma, m, d, k->side[0], a->om);
            jo_to_world(omb, m, d, k->side[1], b->om);
            jo_to_world(aa, m, d, k->side[0], a->a + 3);
            jo_to_world(ab, m, d, k->side[1], b->a + 3);
            jo_sub3(aa, ab);
            for (int r = 0; r < k->nperp; r++) {
                jo_real f[3], h[3], fd[3], hd[3], fdd[3], hdd[3];
                axis(f, a->A, k->perp_a[r]);
                axis(h, b->A, k->perp_b[r]);
                jo_cross(fd, oma, f);
                jo_cross(hd, omb, h);
                jo_cross(fdd, oma, fd);
                jo_cross(hdd, omb, hd);
                x[r] = jo_dot3(aa, w->axes[r]) + jo_dot3(fdd, h) + 2.0 * jo_dot3(fd, hd) + jo_dot3(f, hdd);
            }
        }
        if (k->nline) line_acceleration(m, d, k, x + k->nperp);
        for (int side = 0; side < k->nside; side++) {   /* rigid coordinates: C X Z^-1 z = V^T z */
            const int body = m->marker[k->side[side]].body;
            if (body < 0) continue;
#define CALL(n) add_columns(w->x, w->V[side], d->body[body].z, n)
            JO_BY_ROWS(k->nrow, CALL)
#undef CALL
        }
        if (solver && (solver->alpha != 0.0 || solver->beta != 0.0))
            for (int r = 0; r < k->nrow; r++)
                w->x[r] += 2.0 * solver->alpha * w->cdot[r] + solver->beta * solver->beta * w->c[r];
    }
}

/* subtract P^T f from the modal forces */
static inline void subtract_modal(jo_real *restrict fp, const jo_real *restrict P, const jo_real *f, int np)
{
    const jo_real f0 = f[0], f1 = f[1], f2 = f[2];
    JO_EACH(j, np) JO_STORE(fp + j) -= f0 * JO_LOAD(P + j) + f1 * JO_LOAD(P + np + j) + f2 * JO_LOAD(P + 2 * np + j);
}

/* y -= V x, six rows */
static inline void subtract_rows(jo_real *restrict y, const jo_real *restrict V, const jo_real *restrict x,
                                 const int n)
{
    for (int j = 0; j < 6; j++) {
        jo_real s = y[j];
        for (int r = 0; r < n; r++) s -= V[6 * j + r] * x[r];
        y[j] = s;
    }
}

/* the joint forces act: f_p -= L_p^T C^T x, y = L^-T (z - V x), then the modal accelerations */
void jo_joint_apply(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nbody; i++)
        for (int j = 0; j < 6; j++) d->body[i].y[j] = d->body[i].z[j];
    for (int i = 0; i < m->njoint; i++) {
        const jo_joint *k = &m->joint[i];
        const jo_joint_work *w = &d->joint[i];
        for (int side = 0; side < k->nside; side++) {
            const jo_marker *mk = &m->marker[k->side[side]];
            if (mk->body < 0) continue;
            jo_body_work *bw = &d->body[mk->body];
            const jo_real *C = w->C[side], *V = w->V[side];
            const int np = m->body[mk->body].np;
#define CALL(n) subtract_rows(bw->y, V, w->x, n)
            JO_BY_ROWS(k->nrow, CALL)
#undef CALL
            if (mk->Phi && k->coincident) {
                jo_real f[3];
                for (int j = 0; j < 3; j++) f[j] = C[j] * w->x[0] + C[6 + j] * w->x[1] + C[12 + j] * w->x[2];
                subtract_modal(bw->fp, d->marker[k->side[side]].Phi, f, np);
            }
            if (mk->Psi && k->nperp) {
                jo_real f[3] = {0.0, 0.0, 0.0};
                for (int r = first_line(k) - k->nperp; r < first_line(k); r++) jo_axpy3(f, w->x[r], C + 6 * r + 3);
                subtract_modal(bw->fp, d->marker[k->side[side]].Psi, f, np);
            }
            for (int r = first_line(k); r < k->nrow; r++) {
                jo_real f[6];
                for (int j = 0; j < 6; j++) f[j] = w->x[r] * C[6 * r + j];
                if (mk->Phi) subtract_modal(bw->fp, d->marker[k->side[side]].Phi, f, np);
                if (mk->Psi) subtract_modal(bw->fp, d->marker[k->side[side]].Psi, f + 3, np);
            }
        }
    }
    for (int i = 0; i < m->nbody; i++) {
        jo_body_work *bw = &d->body[i];
        jo_body_backward(bw->L, bw->y);
        if (m->body[i].n) jo_body_modal(&m->body[i], bw, d->set);
    }
}
