/* evaluation.h - results of an evaluation: motion, forces and accelerations of bodies, markers and coordinates, residuals and multipliers of
 * joints.
 *
 * All folders use them: maximal/ and tree/ compute the motion, force/, beam/ and friction/ the forces, maximal/, newton/ and tree/ the
 * accelerations and multipliers. The members `maximal` are data of maximal/, whose files alone use their fields.
 */
#ifndef JO_EVALUATION_H
#define JO_EVALUATION_H

#include "maximal/maximal_data.h"

typedef struct jo_body_work {
    jo_real A[9];           /* orientation in the world frame */
    jo_real At[12];         /* columns of A, padded */
    jo_real V[3], w[3];     /* velocity of the frame origin, m/s, angular velocity, rad/s, local */
    jo_real S[3], J[6];     /* first moment, kg m, and inertia tensor, kg m2, at p */
    jo_real fr[6];          /* force, N, and torque, N m, on the rigid coordinates, local */
    jo_real y[6];           /* acceleration of the rigid coordinates, local, relative to free fall; or a change of fr, see jo_push_change */
    jo_real *p, *pd;        /* (np) modal coordinates and velocities, padded */
    jo_real *D, *B, *G;     /* (6 x np) D_j(p), (3 x np) B_j(p), (3 x np) int phi' x phi_j dm */
    jo_real *fp, *yp;       /* (np) modal forces, modal accelerations or a change of fp */
    jo_real turn[9];        /* tangent operator: rotation (local) / change of the rotation vector of a step */
    jo_body_maximal maximal;
} jo_body_work;

typedef struct jo_marker_work {
    jo_real u[3];           /* position on the body, m, local */
    jo_real r[3];           /* position, m, world */
    jo_real theta[3];       /* rotation vector Psi p, rad, local */
    jo_real T[9];           /* tangent operator: angular velocity relative to the body = T theta' */
    jo_real A[9];           /* orientation in the world frame */
    jo_real v[3], om[3];    /* velocity and angular velocity, local */
    jo_real a[6];           /* acceleration for R'' = w' = 0, local */
    const jo_real *Phi, *Psi;   /* (3 x np) mode shapes at p: of jo_marker, or with geometric stiffening */
    jo_marker_maximal maximal;
} jo_marker_work;

/* Coordinate s and its derivatives: s' = along . (v_b - v_a) + turn_a . om_a + turn_b . om_b, all in the world frame;
 * s'' the same with accelerations, plus bias. */
typedef struct {
    jo_real value, rate, bias;
    jo_real along[3], turn_a[3], turn_b[3];
} jo_coordinate_work;

typedef struct {
    jo_real c[6], cdot[6];  /* residuals C and C' */
    jo_real x[8];           /* right-hand side, then multipliers; padded with 0 */
    jo_joint_maximal maximal;
} jo_joint_work;

typedef struct {
    jo_real y[6];           /* force, N, and torque, N m, on b, world; along a coordinate: y[0] is the force */
    jo_real stored;         /* energy of its springs, J */
    jo_real stiffness, damping;   /* forces with states, gear springs: -dF/ds, -dF/ds' at constant states */
} jo_force_work;

#endif
