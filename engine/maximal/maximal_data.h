/* maximal_data.h - what the files of this room keep; other rooms reach it by the functions of maximal.h. */
#ifndef JO_MAXIMAL_DATA_H
#define JO_MAXIMAL_DATA_H

#include "stage.h"

/* Constants that depend on the effective modal mass E + g h D + (g h)^2 K: set 0 has g h = 0. */
typedef struct {
    jo_real *weight;        /* (np)     inverse effective modal mass */
    jo_real *I3w;           /* (3 x np) I3 weighted */
    jo_real L11[9];         /*          Cholesky factor of m E - I3 weight I3^T, inverse diagonal */
} jo_body_set;

typedef struct {
    jo_real A[9];           /* orientation of the body frame */
    jo_real At[12];         /* its columns, padded */
    jo_real V[3], w[3];     /* velocity of the frame origin and angular velocity, local */
    jo_real S[3], J[6];     /* first moment, inertia tensor at p */
    jo_real L[36];          /* Cholesky factor of the 6x6 Schur complement, inverse diagonal */
    jo_real fr[6];          /* force on the rigid coordinates, local */
    jo_real z[6], y[6];     /* L^-1 of the reduced force; acceleration of the rigid coordinates, local */
    jo_real *p, *pd;        /* (np) modal coordinates and velocities, padded */
    jo_real *D, *B, *G;     /* (6 x np) D_j(p), (3 x np) B_j(p), (3 x np) int phi' x phi_j dm */
    jo_real *Bw;            /* (3 x np) B weighted */
    jo_real *fp, *yp;       /* (np) force on the modal coordinates, their acceleration */
    jo_real *extra;         /* (np) additional modal force of an implicit stage */
    int status;             /* rigid: of the factor, which is constant */
    int pushed;             /* y and yp hold a change of force, see friction_iteration.c */
    int modes;              /* place of the modal velocities in what is integrated */
    jo_real *carried;         /* (6 x 6) inertia with that of the trees it carries, see tree_on_flexible_bodies.c; 0: it carries none */
    jo_real *Dd, *H;        /* (6 x np) ED p', (3 x np) EB p'' for Newton's matrix */
    jo_real turn[9];        /* change of orientation (local) by a change of the increment of a step */
    jo_body_set set[2];
} jo_body_work;

typedef struct {
    jo_real *Phiw, *Psiw;   /* (3 x np) mode shapes weighted */
    jo_real PhiI3[9], PsiI3[9];
} jo_marker_set;

typedef struct {
    jo_real u[3];           /* position, local */
    jo_real r[3];           /* position, world */
    jo_real theta[3];       /* rotation vector Psi p, local */
    jo_real T[9];           /* tangent operator: angular velocity relative to the body = T theta' */
    jo_real A[9];           /* orientation, world */
    jo_real v[3], om[3];    /* velocity and angular velocity, local */
    jo_real bv[3], bom[3];  /* velocity-dependent accelerations, local */
    jo_real Xt[18], Xr[18]; /* marker rows reduced to the six rigid coordinates; on a rigid body L^-1 of them, constant */
    jo_real a[6];           /* acceleration without that of the rigid coordinates, local */
    const jo_real *Phi, *Psi;   /* (3 x np) mode shapes at p: those of the marker, with stiffening in `shapes` */
    jo_real *shapes;        /* (6 x np) with stiffening, else 0 */
    jo_marker_set set[2];
    jo_real load[6];        /* all force and torque on it, world */
    jo_real *L;             /* (6 x 6 + n) changes of [r, rotation], world, with the coordinates of the body */
    jo_real *W;             /* (12 x 6 + n) changes of [r, rotation, velocity, angular velocity] with the unknowns of Newton */
} jo_marker_work;

/* Small blocks lie column after column, the rows of a column padded to whole vectors. */
enum { JO_BLOCK = 48, JO_ROWS_C = 72 };
static inline int jo_padded(int rows) { return rows <= 4 ? 4 : 8; }

/* A coordinate and its derivatives: s' = along . (v_b - v_a) + turn_a . om_a + turn_b . om_b, all in the world frame;
 * s'' the same with accelerations, plus bias. */
typedef struct {
    jo_real value, rate, bias;
    jo_real along[3], turn_a[3], turn_b[3];
} jo_coordinate_work;

/* one side of a joint */
typedef struct {
    jo_body_work *body;     /* 0: ground */
    jo_marker_work *marker;
    const jo_real *L;       /* factor of the body, 0 where the marker's rows have it in them */
    const jo_real *T;       /* tangent operator of the marker, 0 without rotation shapes */
    jo_real V[JO_BLOCK];    /* (6 x ld) L^-1 of the rows reduced to the rigid coordinates, by columns; ld = jo_padded(nrow) */
    jo_real C[JO_ROWS_C];   /* (9 x ld) rows, local: [translation, rotation shape, rotation], the last only with T; pads are 0 */
} jo_side_work;

typedef struct {
    jo_side_work *side;     /* (nside) */
    jo_real axes[3][3];     /* world: a change of rotation dtheta_a - dtheta_b turns row r by axes[r] */
    jo_real c[6], cdot[6];  /* constraint residuals */
    jo_real x[8];           /* right-hand side, then multipliers; padded */
    jo_real right[6], sum[6];   /* refinement of redundant rows */
    int present;            /* of a joint that an event releases: whether it still holds */
    jo_real scale[6];       /* diagonal of S before elimination */
    jo_real soft[6];        /* subtracted from the diagonal of Newton's matrix where rows repeat one another */
} jo_joint_work;

/* The block Cholesky of S as it is carried out: what the model's lists mean in memory. `kind` says which numbers of rows
 * and columns occur, see schur_complement.c. `lock` is that of an optional joint, else 0: where it is switched off its blocks are 0. */
typedef struct { jo_real *S; const jo_side_work *k, *l; int kind, first, flexible; const int *lock_k, *lock_l; } jo_pair_plan;
typedef struct { jo_real *S; const jo_side_work *side; int rows, later, first; const int *lock; } jo_pull_plan;
typedef struct { jo_real *S, *x, *scale; double sign; int n, first, count, update, updates; const int *lock; } jo_column_plan;
typedef struct { jo_real *X, *x; int rows, kind; const int *lock; } jo_below_plan;
typedef struct { jo_real *T; const jo_real *X, *Y; int rows, ny, kind; const int *lock_x, *lock_y; } jo_update_plan;

/* A dense symmetric matrix S of n rows and its factors, see dense_cholesky.c. */
typedef struct {
    int n, ld, rank;        /* columns in memory; rows that do not repeat others */
    jo_real *S, *inverse, *y;   /* (n x ld), (n) of the pivots, (n) scratch */
    double *scale;          /* (n) what a diagonal may be like: a pivot that vanishes against it repeats others */
    int *order;             /* (n) rows as they were eliminated */
} jo_gram;

#endif
