/* contact_matrix.c - contacts in the matrix of a Rosenbrock method of order 2.
 *
 * With x and v the position and velocity of body b on body a at the contact point, and s' = sigma the rate of the bristle, the force F(x, v, s)
 * has in stage i of step_rosenbrock.c the implicit part
 *   g h (K u + D w - B (sigma + S) + g h B w) - G J v_i',   G = g h D + (g h)^2 (K + B),
 *   u = J (-r_i - sum s_ij r_j - g h sum z_ij v_j'),  w = -J sum s_ij v_j',  S = sum s_ij s_j',
 *   s_i' = sigma + g h P (J v_i' - w),   P = 1 - n n^T,
 * since the state s is eliminated: ds'/dv = P. A moment that resists rolling and drilling is the same with angular velocities, P = 1. The
 * matrices and J are those of the first stage. J^T G J enters Newton's matrix of coupled_mass.c, or the equations of a tree in
 * tree_contacts.c. */
#include "valid.h"
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "tree/tree.h"
#include "contact/contact.h"

/* largest number of velocities of a body */
static int most_velocities(const jo_model *m)
{
    int most = 0;
    for (int i = 0; i < m->nbody; i++) most = m->body[i].n > most ? m->body[i].n : most;
    return 6 + most;
}

void jo_contact_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    jo_contacts *w = &d->contacts;
    const int most = most_velocities(m);
    w->count = 0;
    for (int i = 0; i < m->nforce; i++) w->count += jo_contact_blocks(&m->force[i]);
    w->matrix = jo_take_many(a, w->count, sizeof *w->matrix);
    w->list = jo_take_ints(a, w->count);
    w->closed = 0;
    w->of_state = jo_take_ints(a, w->count ? m->nstate : 0);
    for (int i = 0, k = 0; i < m->nforce; i++) {
        const jo_force *f = &m->force[i];
        const int slot = f->type == JO_FORCE_contact_slot, points = jo_contact_points(f);
        for (int point = 0; point < jo_contact_blocks(f); point++, k++) {
            jo_contact_matrix spare, *c = a->base ? &w->matrix[k] : &spare;
            c->declared = i;
            c->turns = point == points;
            c->first = c->turns ? jo_contact_first(f, 0) + JO_TURN_FIRST : jo_contact_first(f, point);
            c->room[0] = jo_take_reals(a, 3 * (slot ? most : jo_marker_velocities(m, f->a)));
            c->room[1] = jo_take_reals(a, 3 * (slot ? most : jo_marker_velocities(m, f->b)));
            if (a->base) w->of_state[c->first] = k;
        }
    }
}

/* whether the bodies of a slot are coupled in Newton's matrix; sets of many bodies are left out of its pattern */
static int is_coupled(const jo_model *m, jo_data *d, const jo_force *slot)
{
    const jo_force *f = jo_bound_force(d, slot);
    const int a = f ? m->marker[f->a].body : -1, b = f ? m->marker[f->b].body : -1;
    return m->nnode && (a < 0 || b < 0 || jo_newton_couples(m, a, b));
}

/* number of contacts that act at the start of a step; -1: the matrix has no room for one of them */
static int count_acting(const jo_model *m, jo_data *d)
{
    const int tree = jo_tree_active(d);
    int acting = 0;
    for (int i = 0; i < d->contacts.count; i++) {
        const jo_contact_matrix *c = &d->contacts.matrix[i];
        const jo_force *f = &m->force[c->declared];
        if (JO_RE(jo_states(m, d)[c->turns ? c->first - JO_TURN_FIRST : c->first]) == 0.0) continue;   /* phase */
        if (!tree && f->type == JO_FORCE_contact_slot && !is_coupled(m, d, f)) return -1;
        acting++;
    }
    return tree && acting > JO_TREE_CLOSED ? -1 : acting;
}

int jo_contacts_fit(const jo_model *m, jo_data *d) { return count_acting(m, d) >= 0; }

int jo_contacts_begin(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < d->contacts.closed; i++) jo_closed_contact(d, i)->closed = 0;
    d->contacts.closed = 0;
    const int acting = count_acting(m, d);
    d->contacts.fit = acting >= 0;
    return acting > 0;
}

/* J of one side in maximal coordinates: sign A_a^T (L_r - arm~ L_phi), arm: contact point from the marker */
static void side_jacobian(const jo_model *m, jo_data *d, jo_contact_matrix *c, int side, int marker)
{
    static const jo_stage derivatives = {.weights = {1.0, 1.0, 0.0, 1.0, 0, 1}};
    const int body = m->marker[marker].body, n = c->count[side] = jo_marker_velocities(m, marker);
    if (body < 0) return;
    const jo_real *A = d->marker[c->force->a].A;
    jo_real arm[3];
    c->at[side] = m->body[body].iv;
    jo_newton_marker(m, d, &derivatives, marker);
    const jo_real *L = jo_marker_derivatives(d, marker);
    const int row = jo_pad(n);
    jo_set3(arm, c->point);
    jo_sub3(arm, d->marker[marker].r);
    for (int j = 0; j < n; j++) {
        const jo_real turn[3] = {L[3 * row + j], L[4 * row + j], L[5 * row + j]};
        jo_real v[3], y[3];
        jo_cross(v, turn, arm);
        for (int i = 0; i < 3; i++) v[i] += L[i * row + j];
        jo_mul3t(y, A, c->turns ? turn : v);
        for (int i = 0; i < 3; i++) c->J[side][i * n + j] = side ? y[i] : -y[i];
    }
}

void jo_contact_place_in_matrix(const jo_model *m, jo_data *d, const jo_stage *stage, jo_contact_matrix *c)
{
    const double gh = stage->gh;
    d->contacts.list[d->contacts.closed++] = (int)(c - d->contacts.matrix);
    for (int i = 0; i < 9; i++) c->G[i] = gh * (c->D[i] + gh * (c->K[i] + c->B[i]));
    if (jo_tree_active(d)) {
        jo_tree_contact_jacobian(m, d, c);
        return;
    }
    for (int s = 0; s < 2; s++) {
        c->J[s] = c->room[s];
        side_jacobian(m, d, c, s, s ? c->force->b : c->force->a);
    }
}

void jo_contact_carry(const jo_model *m, jo_data *d)
{
    const jo_real *S = d->acc + d->nw - m->nstate;   /* minus the sum of the earlier stages */
    for (int k = 0; k < d->contacts.closed; k++) {
        jo_contact_matrix *c = jo_closed_contact(d, k);
        jo_contact_velocity(c, d->dv, c->u);
        jo_contact_velocity(c, d->acc, c->w);
        for (int i = 0; i < 3; i++) c->S[i] = -S[c->state + i];
    }
}

void jo_contact_push(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_contact_matrix *c, const jo_real *lever)
{
    const double gh = stage->gh;
    const jo_real *sigma = jo_state_rates(m, d) + c->state;
    jo_real F[6], s[3], x[3];
    jo_force_work unused;
    for (int i = 0; i < 3; i++) s[i] = gh * c->w[i] - sigma[i] - c->S[i];
    jo_mul3(F, c->K, c->u);
    jo_mul3(x, c->D, c->w);
    jo_add3(F, x);
    jo_mul3(x, c->B, s);
    jo_add3(F, x);
    for (int i = 0; i < 3; i++) F[i] *= gh;
    jo_cross(F + 3, lever, F);
    for (int i = 0; i < 3 && c->turns; i++) {
        F[3 + i] = F[i];
        F[i] = jo_same(0.0);
    }
    jo_push_between(m, d, c->force, F, &unused);
}

void jo_contact_state_rates(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    for (int k = 0; k < d->contacts.closed; k++) {
        const jo_contact_matrix *c = jo_closed_contact(d, k);
        if (!c->follows) continue;
        jo_real *rate = jo_state_rates(m, d) + c->state, v[3];
        jo_contact_velocity(c, d->wd, v);
        jo_sub3(v, c->w);
        if (!c->turns) jo_axpy3(v, -jo_dot3(v, c->normal), c->normal);
        jo_axpy3(rate, jo_same(stage->gh), v);
    }
}

/* body of a side */
static int body_of(const jo_model *m, const jo_contact_matrix *c, int side)
{
    return m->marker[side ? c->force->b : c->force->a].body;
}

/* y (3 x n) = G J of a side */
static jo_real scaled(const jo_contact_matrix *c, int side, int i, int j)
{
    const int n = c->count[side];
    const jo_real *J = c->J[side] + j, *G = c->G + 3 * i;
    return G[0] * J[0] + G[1] * J[n] + G[2] * J[2 * n];
}

void jo_contact_add_to_newton(const jo_model *m, jo_data *d)
{
    for (int k = 0; k < d->contacts.closed; k++) {
        const jo_contact_matrix *c = jo_closed_contact(d, k);
        for (int s = 0; s < 2; s++)
            for (int t = 0; t < 2; t++) {
                if (!c->count[s] || !c->count[t]) continue;
                const jo_block N = jo_newton_find(m, d, body_of(m, c, s), body_of(m, c, t));
                const int n = c->count[s];
                for (int j = 0; j < c->count[t]; j++) {
                    const jo_real x = scaled(c, t, 0, j), y = scaled(c, t, 1, j), z = scaled(c, t, 2, j);
                    for (int i = 0; i < n; i++)
                        N.at[i * N.stride + j] += c->J[s][i] * x + c->J[s][n + i] * y + c->J[s][2 * n + i] * z;
                }
            }
    }
}

void jo_contact_subtract(const jo_model *m, jo_data *d, const jo_real *a)
{
    for (int k = 0; k < d->contacts.closed; k++) {
        const jo_contact_matrix *c = jo_closed_contact(d, k);
        jo_real y[3], F[3];
        jo_contact_velocity(c, a, y);
        jo_mul3(F, c->G, y);
        for (int s = 0; s < 2; s++) {
            const int n = c->count[s];
            if (!n) continue;
            jo_real *x = jo_newton_vector(d) + jo_newton_place(m, body_of(m, c, s));
            for (int i = 0; i < n; i++) x[i] -= c->J[s][i] * F[0] + c->J[s][n + i] * F[1] + c->J[s][2 * n + i] * F[2];
        }
    }
}
