/* beam_inertia.c - consistent mass of a beam element beyond the lumped mass of its bodies, and mass-proportional damping of this mass.
 *
 * Each body has half of the mass of the element. `share` times (consistent - lumped mass) is added: with c = share m / 6 a force c (x_b'' -
 * x_a'') on end a and its opposite on b, and with the angular velocities W of the ends in their own frames the momentum p = share/6 J (W_b
 * - W_a) about end a, -p about b, whose torques are p' + W_a x p and -p' - W_b x p. Damping is alpha times these momenta; the damping of
 * the lumped mass is computed with the bodies. The ends are points off the origins of the bodies: the derivatives of their accelerations
 * with respect to positions and velocities are the tangents K_acc and C_acc of Makinen, Marjamaki and Pajunen (eq. 13) in three dimensions.
 */
#include "newton/newton.h"
#include "beam/beam.h"

/* Motion of one end. */
typedef struct {
    const jo_real *A, *u, *B, *w;   /* orientation, end position, end frame and angular velocity of the body, local */
    jo_real wu[3], acc[3];  /* w x u, w' x u + w x (w x u), local */
    jo_real v[3], a[3];     /* velocity and acceleration, world */
    jo_real W[3], Wd[3];    /* angular velocity and acceleration in the end's frame */
} end_motion;

/* motion of end k at accelerations a, where NULL stands for a = 0 */
static void motion(const jo_model *m, const jo_data *d, const jo_beam *b, const int k, const jo_real *a, end_motion *y)
{
    const int body = k ? b->b : b->a, iv = m->body[body].iv;
    const jo_real *v = d->v + iv;
    jo_real t[3];
    y->A = d->body[body].A;
    y->u = k ? b->data->u_b : b->data->u_a;
    y->B = k ? b->data->B_b : b->data->B_a;
    y->w = v + 3;
    jo_cross(y->wu, y->w, y->u);
    jo_cross(y->acc, y->w, y->wu);
    for (int j = 0; j < 3; j++) y->Wd[j] = 0.0;
    if (a) {
        jo_cross(t, a + iv + 3, y->u);
        jo_add3(y->acc, t);
        jo_mul3t(y->Wd, y->B, a + iv + 3);
    }
    jo_mul3(y->v, y->A, y->wu);
    jo_add3(y->v, v);
    jo_mul3(y->a, y->A, y->acc);
    if (a) jo_add3(y->a, a + iv);
    jo_mul3t(y->W, y->B, y->w);
}

/* inertial and damping forces f (world), torques T (end frames) and momentum p; returns the power of the damping, W */
static jo_real momenta(const jo_beam *b, const end_motion *e, jo_real f[2][3], jo_real T[2][3], jo_real *p)
{
    const jo_real *J = b->data->J, alpha = b->data->alpha, share = b->data->share / 6.0;
    const jo_real c = share * b->data->mass;
    jo_real x[3], pd[3], power = 0.0;
    for (int j = 0; j < 3; j++) x[j] = share * (e[1].W[j] - e[0].W[j]);
    jo_sym3(p, J, x);
    for (int j = 0; j < 3; j++) x[j] = share * (e[1].Wd[j] - e[0].Wd[j]);
    jo_sym3(pd, J, x);
    for (int k = 0; k < 2; k++) {
        const double sign = k ? -1.0 : 1.0;
        jo_cross(x, e[k].W, p);
        for (int j = 0; j < 3; j++) {
            const jo_real P = sign * c * (e[1].v[j] - e[0].v[j]), H = sign * p[j];
            f[k][j] = sign * c * (e[1].a[j] - e[0].a[j]) + alpha * P;
            T[k][j] = sign * (pd[j] + x[j]) + alpha * H;
            power += alpha * (P * e[k].v[j] + H * e[k].W[j]);
        }
    }
    return power;
}

/* forces on the bodies -= f, T at accelerations a, where NULL stands for a = 0 */
void jo_beam_inertia(const jo_model *m, jo_data *d, int i, const jo_real *a)
{
    const jo_beam *b = &m->beam[i];
    end_motion e[2];
    jo_real f[2][3], T[2][3], p[3], F[3], t[3];
    for (int k = 0; k < 2; k++) motion(m, d, b, k, a, &e[k]);
    d->power.damping += momenta(b, e, f, T, p);
    for (int k = 0; k < 2; k++) {
        jo_real *fr = d->body[k ? b->b : b->a].fr;
        jo_mul3t(F, e[k].A, f[k]);
        jo_sub3(fr, F);
        jo_cross(t, e[k].u, F);
        jo_sub3(fr + 3, t);
        jo_mul3(t, e[k].B, T[k]);
        jo_sub3(fr + 3, t);
    }
}

/* kinetic energy beyond that of the bodies, J */
jo_real jo_beam_kinetic(const jo_model *m, const jo_data *d)
{
    jo_real T = 0.0;
    for (int i = 0; i < m->nbeam; i++) {
        const jo_beam *b = &m->beam[i];
        if (!jo_beam_inertial(b)) continue;
        end_motion e[2];
        jo_real v[3], W[3], JW[3];
        for (int k = 0; k < 2; k++) motion(m, d, b, k, 0, &e[k]);
        for (int j = 0; j < 3; j++) { v[j] = e[1].v[j] - e[0].v[j]; W[j] = e[1].W[j] - e[0].W[j]; }
        jo_sym3(JW, b->data->J, W);
        T -= b->data->share / 12.0 * (b->data->mass * jo_dot3(v, v) + jo_dot3(W, JW));
    }
    return T;
}

/* Y = u~ X */
static void lever(jo_real *Y, const jo_real *u, const jo_real *X)
{
    for (int j = 0; j < 3; j++) {
        Y[j] = u[1] * X[6 + j] - u[2] * X[3 + j];
        Y[3 + j] = u[2] * X[j] - u[0] * X[6 + j];
        Y[6 + j] = u[0] * X[3 + j] - u[1] * X[j];
    }
}

static void add_block(jo_block N, int row, int column, const jo_real *M)
{
    jo_real *at = N.at + row * N.stride + column;
    for (int i = 0; i < 3; i++, at += N.stride)
        for (int j = 0; j < 3; j++) at[j] += M[3 * i + j];
}

/* Newton's matrix of the forces of the ends; offset: ends off the origins of the bodies */
static void translation(jo_block N[2][2], const jo_beam *b, const jo_weights *c, const end_motion *e, jo_real f[2][3],
                        const jo_real *const *turn, int offset)
{
    const jo_real part = b->data->share * b->data->mass / 6.0, alpha = b->data->alpha;
    jo_real X[2][9] = {{0.0}}, Y[2][9] = {{0.0}}, At[2][9];
    if (offset)
        for (int k = 0; k < 2; k++) {   /* derivatives X, Y of acceleration and velocity of the end with respect to the rotation, local */
            jo_real M[9] = {0.0};
            jo_add_skew(X[k], -c->a, e[k].u);
            jo_add_skew(Y[k], -c->v, e[k].u);
            for (int j = 0; j < 9; j++) At[k][j] = e[k].A[3 * (j % 3) + j / 3];
            if (c->plain) continue;
            jo_add_skew(X[k], -c->v, e[k].wu);
            jo_add_skew_skew(X[k], -c->v, e[k].w, e[k].u);
            jo_add_skew(M, -c->q, e[k].acc);
            jo_real P[9];
            jo_mul33(P, M, turn[k]);
            for (int j = 0; j < 9; j++) { X[k][j] += P[j]; M[j] = 0.0; }
            jo_add_skew(M, -c->q, e[k].wu);
            jo_mul33(P, M, turn[k]);
            for (int j = 0; j < 9; j++) { Y[k][j] += P[j]; M[j] = 0.0; }
            jo_mul3(P, At[k], f[k]);
            jo_add_skew_skew(M, c->q, e[k].u, P);
            jo_mul33(P, M, turn[k]);
            add_block(N[k][k], 3, 3, P);
        }
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++) {
            const jo_real ca = i == j ? -part : part, cv = alpha * ca;
            const jo_real diagonal = c->a * ca + c->v * cv;
            for (int r = 0; r < 3; r++) N[i][j].at[r * (N[i][j].stride + 1)] += diagonal;
            if (!offset) continue;
            jo_real P[9], Q[9], Z[9];
            for (int r = 0; r < 9; r++) P[r] = ca * X[j][r] + cv * Y[j][r];
            jo_mul33(Q, e[j].A, P);
            add_block(N[i][j], 0, 3, Q);
            jo_mul33(P, At[i], Q);
            lever(Z, e[i].u, P);
            add_block(N[i][j], 3, 3, Z);
            for (int r = 0; r < 9; r++) P[r] = diagonal * At[i][r];
            lever(Z, e[i].u, P);
            add_block(N[i][j], 3, 0, Z);
        }
}

/* Newton's matrix of the torques, which depend on angular velocities and accelerations only */
static void rotation(jo_block N[2][2], const jo_beam *b, const jo_weights *c, const end_motion *e, const jo_real *p)
{
    const jo_real *x = b->data->J, share = b->data->share / 6.0, alpha = b->data->alpha;
    const jo_real J[9] = {x[0], x[5], x[4], x[5], x[1], x[3], x[4], x[3], x[2]};
    for (int i = 0; i < 2; i++) {
        jo_real WJ[9];
        lever(WJ, e[i].W, J);
        for (int j = 0; j < 2; j++) {
            const jo_real sign = i == j ? -share : share;
            jo_real R[9], Q[9];
            for (int r = 0; r < 9; r++) {
                R[r] = sign * (c->a + c->v * alpha) * J[r];
                if (!c->plain) R[r] += sign * c->v * WJ[r];
            }
            if (i == j && !c->plain) jo_add_skew(R, i ? c->v : -c->v, p);
            jo_mul33(Q, e[i].B, R);
            for (int r = 0; r < 3; r++)
                for (int s = 0; s < 3; s++)
                    R[3 * r + s] = Q[3 * r] * e[j].B[3 * s] + Q[3 * r + 1] * e[j].B[3 * s + 1] + Q[3 * r + 2] * e[j].B[3 * s + 2];
            add_block(N[i][j], 3, 3, R);
        }
    }
}

/* consistent inertia of one element in Newton's matrix */
void jo_beam_newton_inertia(const jo_model *m, jo_data *d, int i, const jo_weights *c)
{
    const jo_beam *b = &m->beam[i];
    const int body[2] = {b->a, b->b};
    const jo_real *const turn[2] = {d->body[b->a].turn, d->body[b->b].turn};
    jo_block N[2][2];
    end_motion e[2];
    jo_real f[2][3], T[2][3], p[3];
    for (int k = 0; k < 2; k++) {
        motion(m, d, b, k, d->a, &e[k]);
        for (int j = 0; j < 2; j++) N[k][j] = jo_newton_find(m, d, body[k], body[j]);
    }
    momenta(b, e, f, T, p);
    translation(N, b, c, e, f, turn, jo_beam_kind(b->data) & JO_BEAM_OFFSET);
    rotation(N, b, c, e, p);
}
