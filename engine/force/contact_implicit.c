/* contact_implicit.c - a point at which two bodies touch in the matrix of a Rosenbrock method, see contact_matrix.c. */
#include "maximal/maximal.h"
#include "force/contact_point.h"
#include "contact/contact.h"

/* K, D and B from the changes of the point with the position and the velocity of b */
static void differentiate(const jo_contact_law *x, int phase, const jo_contact_point *y, const jo_contact_change *moves, jo_contact_matrix *c)
{
    static const jo_contact_change none;
    const jo_real zero[3] = {0.0, 0.0, 0.0}, *n = y->normal;
    jo_real F[3];
    for (int k = 0; k < 3; k++) {
        jo_contact_force_change(x, phase, y, moves + k, zero, F);
        for (int i = 0; i < 3; i++) c->K[3 * i + k] = -F[i];
        jo_contact_force_change(x, phase, y, moves + 3 + k, zero, F);
        for (int i = 0; i < 3; i++) c->D[3 * i + k] = -F[i];
        const jo_real s[3] = {(k == 0) - n[0] * n[k], (k == 1) - n[1] * n[k], (k == 2) - n[2] * n[k]};
        jo_contact_force_change(x, phase, y, &none, s, F);
        for (int i = 0; i < 3; i++) c->B[3 * i + k] = c->follows ? -F[i] : jo_same(0.0);
    }
}

void jo_contact_implicit(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, int state, const jo_contact_point *y,
                         const jo_contact_change *moves)
{
    const jo_contact_law *x = jo_contact_law_of(f);
    const int phase = jo_contact_phase(jo_states(m, d) + state);
    jo_contact_matrix *c = jo_contact_in_matrix(d, state);
    if (!stage->earlier) {
        c->closed = jo_matrix_takes_contacts(d) && phase != JO_CONTACT_APART && JO_RE(y->depth) > 0.0;
        if (!c->closed) return;
        c->force = f;
        c->state = state + JO_CONTACT_STRETCH;
        c->follows = jo_contact_follows(phase) && JO_RE(x->shear) > 0.0;
        differentiate(x, phase, y, moves, c);
        jo_mul3(c->point, d->marker[f->a].A, y->lever);
        jo_add3(c->point, d->marker[f->b].r);
        jo_set3(c->normal, y->normal);
        jo_contact_place_in_matrix(m, d, stage, c);
        for (int i = 0; i < 3; i++) {
            c->u[i] = -y->v[i];
            c->w[i] = c->S[i] = jo_same(0.0);
        }
    }
    if (c->closed) jo_contact_push(m, d, stage, c, y->lever);
}
