/* maximal_data.h - data of the files of this folder: bodies, markers, joints, Schur complement; other folders use the functions of
 * maximal.h. */
#ifndef JO_MAXIMAL_DATA_H
#define JO_MAXIMAL_DATA_H

#include "stage.h"

/* Constants for the effective modal mass E + g h D + (g h)^2 K; set 0: g h = 0. */
typedef struct {
    jo_real *weight;        /* (np)     inverse of the effective modal mass */
    jo_real *I3w;           /* (3 x np) I3 weight */
    jo_real L11[9];         /*          Cholesky factor of m E - I3 weight I3^T, with the inverse of its diagonal */
} jo_body_set;

/* Body: factors, and forces that the solution of the joints uses. */
typedef struct {
    jo_real L[36];          /* Cholesky factor of the 6 x 6 inertia with modes eliminated, with the inverse of its diagonal */
    jo_real z[6];           /* L^-1 times the reduced force */
    jo_real *Bw;            /* (3 x np) B weight */
    jo_real *extra;         /* (np) additional modal force of a Rosenbrock method */
    int status;             /* rigid body: status of its constant factor */
    int changed;            /* whether the force on the body changes after the free accelerations were computed, see apply_force.c */
    int modes;              /* index of the modal velocities in jo_data.w */
    jo_real *carried;       /* (6 x 6) inertia of the body, without its mass, and of the trees on it; 0: no trees */
    jo_body_set set[2];
} jo_body_maximal;

typedef struct {
    jo_real *Phiw, *Psiw;   /* (3 x np) Phi weight, Psi weight */
    jo_real PhiI3[9], PsiI3[9];   /* Phi weight I3^T, Psi weight I3^T */
} jo_marker_set;

/* Marker: accelerations that do not depend on those of the body, and rows with modes eliminated. */
typedef struct {
    jo_real bv[3], bom[3];  /* accelerations for R'' = w' = p'' = 0, local */
    jo_real Xt[18], Xr[18]; /* (3 x 6) translation and rotation rows with modes eliminated; rigid body: times L^-T, constant */
    jo_real *shapes;        /* (6 x np) Phi + chi p with geometric stiffening, else 0 */
    jo_marker_set set[2];
} jo_marker_maximal;

/* Reals of a block of V or S and of C. Blocks are stored by columns, each padded to jo_padded(rows). */
enum { JO_BLOCK = 48, JO_ROWS_C = 72 };

/* One side of a joint. */
typedef struct {
    struct jo_body_work *body;   /* 0: ground */
    struct jo_marker_work *marker;
    const jo_real *L;       /* factor of the body; 0: Xt, Xr include L^-T */
    const jo_real *T;       /* tangent operator of the marker; 0: no rotation mode shapes */
    jo_real V[JO_BLOCK];    /* (6 x ld) L^-1 (C X)^T, by columns; ld = jo_padded(nrow) */
    jo_real C[JO_ROWS_C];   /* (9 x ld) rows, local: [translation, rotation shape, rotation], the last one only with T; padded with 0 */
} jo_side_work;

/* Joint: its rows, and its part of S. */
typedef struct {
    jo_side_work *side;     /* (nside) */
    jo_real axes[3][3];     /* f_a x h_b of row r, world: d(f_a . h_b) = axes[r] . (dtheta_a - dtheta_b) */
    jo_real right[6], sum[6];   /* iterative refinement: right-hand side, sum of solutions */
    int present;            /* joint with a release event: whether it is active */
    jo_real scale[6];       /* diagonal of S before elimination */
} jo_joint_maximal;

/* Plan of the block Cholesky of S: addresses of the blocks in the lists of the model. kind: kernel for the numbers of rows and columns,
 * see schur_complement.c. lock: address of the activity of a joint, 0: always active; blocks of inactive joints are 0. */
typedef struct { jo_real *S; const jo_side_work *k, *l; int kind, first, flexible; const int *lock_k, *lock_l; } jo_pair_plan;
typedef struct { jo_real *S; const jo_side_work *side; int rows, later, first; const int *lock; } jo_pull_plan;
typedef struct { jo_real *S, *x, *scale; double sign; int n, first, count, update, updates; const int *lock; } jo_column_plan;
typedef struct { jo_real *X, *x; int rows, kind; const int *lock; } jo_below_plan;
typedef struct { jo_real *T; const jo_real *X, *Y; int rows, ny, kind; const int *lock_x, *lock_y; } jo_update_plan;

/* S, its factors, and the plan of their computation. */
typedef struct {
    double gh;              /* g h of the constants of set 1, also of bodies and markers, s */
    jo_real *S, *S0;        /* (nblock x JO_BLOCK) S = Cq M^-1 Cq^T or its factors; copy of S for refinement */
    jo_real *gram[2];       /* (npair x 36) L_k weight L_l^T of pairs on flexible bodies, of both sets */
    jo_pair_plan *pairs;
    jo_pull_plan *pulls;
    jo_real **hubs;         /* (nhub) diagonal blocks of the hubs */
    jo_column_plan *columns;
    jo_below_plan *belows;
    jo_update_plan *updates;
    jo_real **fills;        /* (nfill) fill-in blocks, 0 before elimination */
    int nfill;
    int first_column, npair, first_fill;   /* hybrid mode: range of columns, pairs and fill-ins of the block Cholesky */
} jo_schur;

#endif
