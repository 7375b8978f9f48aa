/* relative_motion_tangent.c - motion of marker b relative to marker a, and forces that depend on this motion with their derivatives. */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"

/* relative pose, resolved in a: r = A_a^T (r_b - r_a), R = A_a^T A_b */
void jo_relative_pose(const jo_data *d, const jo_force *f, jo_real *r, jo_real *R)
{
    const jo_marker_work *a = &d->marker[f->a], *b = &d->marker[f->b];
    jo_real world[3];
    jo_set3(world, b->r);
    jo_sub3(world, a->r);
    jo_mul3t(r, a->A, world);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            R[3 * i + j] = a->A[i] * b->A[j] + a->A[3 + i] * b->A[3 + j] + a->A[6 + i] * b->A[6 + j];
}

/* relative velocity, resolved in a: v = A_a^T (v_b - v_a - om_a x (r_b - r_a)), w = A_a^T (om_b - om_a) */
void jo_relative_velocity(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *v, jo_real *w)
{
    const jo_marker_work *a = &d->marker[f->a], *b = &d->marker[f->b];
    jo_real va[3], vb[3], oma[3], omb[3], r[3], t[3];
    jo_to_world(va, m, d, f->a, a->v);
    jo_to_world(vb, m, d, f->b, b->v);
    jo_to_world(oma, m, d, f->a, a->om);
    jo_to_world(omb, m, d, f->b, b->om);
    jo_set3(r, b->r);
    jo_sub3(r, a->r);
    jo_cross(t, oma, r);
    jo_sub3(vb, va);
    jo_sub3(vb, t);
    jo_sub3(omb, oma);
    jo_mul3t(v, a->A, vb);
    jo_mul3t(w, a->A, omb);
}

/* y (6), resolved in a, on b; on a -F and -T - d x F with d = r_b - r_a */
void jo_push_between(const jo_model *m, jo_data *d, const jo_force *f, const jo_real *y, jo_force_work *out)
{
    const jo_marker_work *a = &d->marker[f->a], *b = &d->marker[f->b];
    jo_real r[3], t[3], *F = out->y, *T = out->y + 3;
    jo_mul3(F, a->A, y);
    jo_mul3(T, a->A, y + 3);
    jo_push(m, d, f->b, F, T);
    jo_set3(r, b->r);
    jo_sub3(r, a->r);
    jo_cross(t, r, F);
    jo_real Fa[3], Ta[3];
    for (int j = 0; j < 3; j++) {
        Fa[j] = -F[j];
        Ta[j] = -T[j] - t[j];
    }
    jo_push(m, d, f->a, Fa, Ta);
}

/* force y (6) on b, resolved in a, with X (6 x 12), its derivatives with respect to relative [position, rotation, velocity, angular velocity]:
 * Y = X K with the derivatives K of the relative motion, rotation of y with a, and reaction on a */
void jo_newton_between(const jo_model *m, jo_data *d, const jo_force *f, const jo_real *y, jo_real (*X)[12])
{
    const jo_marker_work *a = &d->marker[f->a], *b = &d->marker[f->b];
    jo_real K[12][24] = {{0.0}}, r[3], va[3], vb[3], oma[3], omb[3], t[3], M[9];
    jo_element e;
    jo_element_start(&e, f->a, f->b);
    jo_set3(r, b->r);
    jo_sub3(r, a->r);
    jo_to_world(va, m, d, f->a, a->v);
    jo_to_world(vb, m, d, f->b, b->v);
    jo_to_world(oma, m, d, f->a, a->om);
    jo_to_world(omb, m, d, f->b, b->om);
    jo_cross(t, oma, r);
    jo_sub3(vb, va);
    jo_sub3(vb, t);      /* relative velocity */
    jo_sub3(omb, oma);
    /* derivatives of the relative motion in the world frame; e.Y is work space */
    for (int p = 0; p < 3; p++) {
        e.Y[p][JO_DR + p] = e.Y[3 + p][JO_DPHI + p] = e.Y[6 + p][JO_DV + p] = e.Y[9 + p][JO_DOM + p] = jo_same(-1.0);
        e.Y[p][JO_OF_B + JO_DR + p] = e.Y[3 + p][JO_OF_B + JO_DPHI + p] = e.Y[6 + p][JO_OF_B + JO_DV + p] = e.Y[9 + p][JO_OF_B + JO_DOM + p] = jo_same(1.0);
    }
    jo_element_skew(&e, 0, JO_DPHI, jo_same(1.0), r);         /* -phi_a x r */
    jo_element_skew(&e, 6, JO_DOM, jo_same(1.0), r);          /* -dom_a x r */
    jo_element_skew(&e, 6, JO_DR, jo_same(1.0), oma);         /* -om_a x dr */
    jo_element_skew(&e, 6, JO_OF_B + JO_DR, jo_same(-1.0), oma);
    jo_element_skew(&e, 6, JO_DPHI, jo_same(1.0), vb);
    jo_element_skew(&e, 9, JO_DPHI, jo_same(1.0), omb);
    for (int p = 0; p < 12; p++)
        for (int q = 0; q < 24; q++)
            for (int s = 0; s < 3; s++) K[p][q] += a->A[3 * s + p % 3] * e.Y[3 * (p / 3) + s][q];
    jo_element_start(&e, f->a, f->b);
    jo_mul3(e.y + 6, a->A, y);
    jo_mul3(e.y + 9, a->A, y + 3);
    for (int p = 0; p < 6; p++)
        for (int q = 0; q < 24; q++) {
            jo_real x = {0.0};
            for (int s = 0; s < 12; s++) x += X[p][s] * K[s][q];
            for (int s = 0; s < 3; s++) e.Y[6 + 3 * (p / 3) + s][q] += a->A[3 * s + p % 3] * x;
        }
    jo_element_skew(&e, 6, JO_DPHI, jo_same(-1.0), e.y + 6);
    jo_element_skew(&e, 9, JO_DPHI, jo_same(-1.0), e.y + 9);
    /* on a: -F, -T - r x F */
    jo_cross(t, r, e.y + 6);
    for (int i = 0; i < 9; i++) M[i] = jo_same(0.0);
    M[1] = -r[2]; M[2] = r[1]; M[3] = r[2]; M[5] = -r[0]; M[6] = -r[1]; M[7] = r[0];
    for (int p = 0; p < 3; p++) {
        e.y[p] = -e.y[6 + p];
        e.y[3 + p] = -e.y[9 + p] - t[p];
        for (int q = 0; q < 24; q++) {
            e.Y[p][q] = -e.Y[6 + p][q];
            e.Y[3 + p][q] = -e.Y[9 + p][q] - (M[3 * p] * e.Y[6][q] + M[3 * p + 1] * e.Y[7][q] + M[3 * p + 2] * e.Y[8][q]);
        }
    }
    jo_element_skew(&e, 3, JO_DR, jo_same(-1.0), e.y + 6);    /* -dr x F = F x dr, dr = dr_b - dr_a */
    jo_element_skew(&e, 3, JO_OF_B + JO_DR, jo_same(1.0), e.y + 6);
    jo_element_finish(m, d, &e);
}
