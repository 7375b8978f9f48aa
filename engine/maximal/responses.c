/* responses.c - accelerations by the multipliers of the joints, and their changes by changes of force. */
#include "valid.h"
#include "maximal/maximal.h"

/* a = M^-1 (Q - Cq^T x) with the multipliers x of the joints; fall: the acceleration of free fall, or 0 for changes of a */
void jo_apply_multipliers(const jo_model *m, jo_data *d, int set, const jo_real *fall, jo_real *a)
{
    jo_joint_apply(m, d, set);
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        const jo_body_work *w = &d->body[i];
        jo_real *x = a + b->iv;
        if (jo_body_inactive(d, i)) continue;
        jo_mul3(x, w->A, w->y);
        if (fall) jo_add3(x, fall);
        jo_set3(x + 3, w->y + 3);
        for (int j = 0; j < b->n; j++) x[6 + j] = w->yp[j];
    }
}

/* changes of the accelerations a, and of the multipliers x of the joints, by the changes of force of jo_push_change */
void jo_respond(const jo_model *m, jo_data *d, int set, jo_real *a)
{
    jo_joint_force_change(m, d, set);
    jo_joint_solve(m, d);
    for (int i = 0; i < m->nbody; i++) {
        jo_body_work *w = &d->body[i];
        const int changed = jo_force_changed(w);
        for (int j = 0; j < 6; j++) w->maximal.z[j] = changed ? w->y[j] : jo_same(0.0);
        for (int j = 0; j < m->body[i].np; j++) w->fp[j] = changed ? w->yp[j] : jo_same(0.0);
    }
    jo_apply_multipliers(m, d, set, 0, a);
}
