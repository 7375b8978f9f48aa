/* apply_force.c - generalised forces of a force and torque at a marker, and of a force along a coordinate.
 *
 * Force F and torque T (world) at a marker: Q_R = F, Q_w = u x A^T F + A^T T, Q_p = Phi^T A^T F + (T(theta) Psi)^T A^T T
 * (Rantalainen 2007, eq. 3.68-3.83, corrected).
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "tree/tree.h"

/* fr, fp += generalised forces of F and T (world) at a marker that is not on ground */
static void add_marker_force(const jo_model *m, const jo_data *d, int marker, const jo_real *F, const jo_real *T, jo_real *fr, jo_real *fp)
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

/* F and T (world) at a marker into fr, fp of its body; none on ground */
void jo_push(const jo_model *m, jo_data *d, int marker, const jo_real *F, const jo_real *T)
{
    const int body = m->marker[marker].body;
    if (body >= 0) add_marker_force(m, d, marker, F, T, d->body[body].fr, d->body[body].fp);
}

/* change of the forces of a body = 0, unless it has one already */
static void begin_change(const jo_model *m, jo_data *d, int body)
{
    jo_body_work *w = &d->body[body];
    if (w->maximal.changed) return;
    for (int j = 0; j < 6; j++) w->y[j] = jo_same(0.0);
    for (int j = 0; j < m->body[body].np; j++) w->yp[j] = jo_same(0.0);
    w->maximal.changed = 1;
}

/* F and T (world) at a marker into y, yp of its body, a change of the forces */
static void push_change(const jo_model *m, jo_data *d, int marker, const jo_real *F, const jo_real *T)
{
    const int body = m->marker[marker].body;
    if (body < 0) return;
    jo_body_work *w = &d->body[body];
    begin_change(m, d, body);
    add_marker_force(m, d, marker, F, T, w->y, w->yp);
}

/* f along a coordinate, virtual work f ds: force and torque f times the gradient of s on a and b */
static void apply_to_both_markers(const jo_model *m, jo_data *d, int coordinate, jo_real f,
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

/* f along a coordinate; a joint coordinate of a tree: tau += f, else both markers */
void jo_push_along(const jo_model *m, jo_data *d, int coordinate, jo_real f)
{
    const int link = m->coordinate[coordinate].link;
    if (!jo_tree_active(d) || link < 0) apply_to_both_markers(m, d, coordinate, f, jo_push);
    else jo_tree_push(m, d, link, f);
}

/* changes of forces = 0, before jo_push_change or jo_push_late */
void jo_clear_changes(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nbody; i++) d->body[i].maximal.changed = 0;
}

void jo_push_change(const jo_model *m, jo_data *d, int coordinate, jo_real f) { apply_to_both_markers(m, d, coordinate, f, push_change); }

/* change of the forces of a body += Q along its velocities */
void jo_push_body_change(const jo_model *m, jo_data *d, int body, const jo_real *Q)
{
    jo_body_work *w = &d->body[body];
    jo_real f[3];
    begin_change(m, d, body);
    jo_mul3t(f, w->A, Q);
    jo_add3(w->y, f);
    jo_add3(w->y + 3, Q + 3);
    for (int j = 0; j < m->body[body].n; j++) w->yp[j] += Q[6 + j];
}

/* Q = change of the forces of a body along its velocities */
void jo_body_change(const jo_model *m, const jo_data *d, int body, jo_real *Q)
{
    const jo_body_work *w = &d->body[body];
    jo_mul3(Q, w->A, w->y);
    jo_set3(Q + 3, w->y + 3);
    for (int j = 0; j < m->body[body].n; j++) Q[6 + j] = w->yp[j];
}

/* add f along a coordinate after jo_body_free; jo_free_changed must follow */
void jo_push_late(const jo_model *m, jo_data *d, int coordinate, jo_real f)
{
    const int ends[2] = {m->coordinate[coordinate].a, m->coordinate[coordinate].b};
    jo_push_along(m, d, coordinate, f);
    for (int j = 0; j < 2; j++)
        if (m->marker[ends[j]].body >= 0) d->body[m->marker[ends[j]].body].maximal.changed = 1;
}

/* repeat jo_body_free for the bodies with forces of jo_push_late */
void jo_free_changed(const jo_model *m, jo_data *d, int set)
{
    for (int i = 0; i < m->nbody; i++)
        if (d->body[i].maximal.changed) jo_body_free(&m->body[i], &d->body[i], set);
}

/* implicit part of the modal forces in a stage of a Rosenbrock method, until jo_clear_modes */
void jo_push_modes(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    const double gh = stage->gh;
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        const int modes = d->body[i].maximal.modes;
        const jo_real *v = d->w + modes, *x = d->dv + modes, *y = d->acc + modes;
        jo_real *extra = d->body[i].maximal.extra;
        if (!stage->earlier) for (int j = 0; j < b->n; j++) extra[j] = -gh * b->K[j] * v[j];
        else for (int j = 0; j < b->n; j++) extra[j] = gh * (b->K[j] * x[j] + b->D[j] * y[j]);
    }
}

void jo_clear_modes(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nbody; i++)
        for (int j = 0; j < m->body[i].n; j++) d->body[i].maximal.extra[j] = jo_same(0.0);
}
