/* jousto.h - the public interface of the jousto engine (C99).
 *
 * A const jo_model holds sizes and constants, a jo_data the state and the workspace of one run.
 * A step allocates nothing, touches no globals and prints nothing; every function is re-entrant.
 *
 * Frames: no suffix = resolved in the world frame, _local = resolved in the body frame.
 * Units: SI. Symmetric 3x3 tensors are stored as xx yy zz yz xz xy.
 * Modal arrays are component-major, (c x np), np = n padded with zeros to a multiple of JO_PAD.
 *
 * The lines between the marks BEGIN and END are also read by the Python binding; they hold only
 * enums, structs with pointers and plain integers and doubles, and function declarations.
 */
#ifndef JOUSTO_H
#define JOUSTO_H

#ifdef JO_COMPLEX
#include <complex.h>
typedef double complex jo_real;  /* complex-step derivatives of anything the engine computes */
#else
typedef double jo_real;
#endif

/* BEGIN */
enum { JO_ABI = 2 };           /* raised whenever a struct or a meaning below changes */
enum { JO_PAD = 4 };           /* modal coordinates are padded to a multiple of this */
enum { JO_ROW_D = 24 };        /* rows of one block of jo_body.ED */
enum { JO_ROW_B = 12 };        /* rows of one block of jo_body.EB */
enum { JO_DENSE = 32 };        /* np up to which ED, EB are blocks of rows, above it triangles of tiles */
enum { JO_MAX_ROWS = 6 };      /* constraint rows of one joint */

typedef enum { JO_OK = 0, JO_NOT_FINITE = 1, JO_SINGULAR_BODY = 2, JO_SINGULAR_JOINT = 3, JO_NO_MEMORY = 4 } jo_status;
typedef enum { JO_RK4 = 1, JO_ROS2 = 2 } jo_method;
typedef enum { JO_CONSTANT = 0, JO_HARMONIC = 1, JO_TABLE = 2, JO_STEP = 3 } jo_signal_type;
typedef enum { JO_POSITION = 1, JO_VELOCITY = 2, JO_ORIENTATION = 3, JO_ANGULAR_VELOCITY = 4,
               JO_MODAL = 5, JO_REACTION = 6, JO_STRESS = 7 } jo_sensor_type;

/* A rigid (n = 0) or modal body: displacement field u = u0 + Phi p in a floating frame. */
typedef struct {
    int n, np;              /* modal coordinates, and padded */
    int iq, iv;             /* offsets of [R e p] in q and of [R' w_local p'] in v */
    const jo_real *mass;    /* (1)       kg */
    const jo_real *S0;      /* (3)       first moment I2 */
    const jo_real *J0;      /* (6)       inertia tensor I7 about the frame origin */
    const jo_real *I3;      /* (3 x np)  int phi dm */
    const jo_real *B0;      /* (3 x np)  I4: int u0 x phi_j dm */
    const jo_real *D0;      /* (6 x np)  half the derivative of J with respect to p_j at p = 0 */
    /* np <= JO_DENSE: rows c np + j in blocks of JO_ROW_D or JO_ROW_B, each block (n x rows).
     * Else for every component c the tiles [k][j] of 4 x 4 with j-block >= k-block, k-block after k-block. */
    const jo_real *ED;      /* (6 np x n) d D_j / d p_k, symmetric in j, k */
    const jo_real *EB;      /* (3 np x n) int phi_k x phi_j dm, antisymmetric */
    const jo_real *K;       /* (np)      modal stiffness omega^2, rad^2/s^2 */
    const jo_real *D;       /* (np)      modal damping 2 zeta omega, 1/s */
} jo_body;

/* A frame on a body: at a node with translation and rotation mode shapes, or rigid. */
typedef struct {
    int body;               /* -1: ground */
    int turns;              /* its orientation is needed at every evaluation, not only by sensors */
    const jo_real *u0;      /* (3)       undeformed position, local */
    const jo_real *A0;      /* (9)       undeformed orientation, local, row-major */
    const jo_real *Phi;     /* (3 x np)  translation mode shapes, 0 where rigid */
    const jo_real *Psi;     /* (3 x np)  rotation mode shapes, 0 where rigid or not needed */
} jo_marker;

/* Constraint rows between marker a and marker b. The first three rows, if coincident, are
 * r_b - r_a = 0; then nperp rows  (axis perp_a of a) . (axis perp_b of b) = 0. */
typedef struct {
    int a, b;
    int coincident, nperp;
    int perp_a[3], perp_b[3];
    int nrow, row;          /* rows, and offset in lam */
    int order;              /* place in the elimination order */
} jo_joint;

/* Two joint sides on one body: their contribution to one block of S = Cq M^-1 Cq^T. */
typedef struct {
    int joint_k, side_k, joint_l, side_l;   /* elimination order of k >= that of l */
    int block;              /* block of S, or its transpose, that receives it */
} jo_pair;

/* Sparse block Cholesky S = L L^T: S_ij is block `block` (36 reals, leading dimension 6). */
typedef struct { int joint, first, count; } jo_column;   /* diagonal; range in below[] */
typedef struct { int block, joint; } jo_below;           /* L_ij below the diagonal of a column */
typedef struct { int target, left, right, left_rows, right_rows; } jo_update;   /* S_target -= L_left L_right^T */

typedef struct {
    int type;               /* jo_signal_type */
    int count;
    const jo_real *data;    /* HARMONIC: offset amplitude omega phase; STEP: time before after; TABLE: t.., f.. */
} jo_signal;

/* Force and torque at a marker, fixed in the world or following the marker. */
typedef struct {
    int marker, follow, signal;   /* signal: -1 for constant */
    const jo_real *force;   /* (3) N */
    const jo_real *torque;  /* (3) N m */
} jo_force;

typedef struct {
    int type;               /* jo_sensor_type */
    int object;             /* marker, body or joint */
    int offset, count;      /* place in the sensor vector */
    const jo_real *rows;    /* STRESS: (count x np), row-major */
} jo_sensor;

typedef struct {
    int nbody, nmarker, nactive, njoint, npair, ncolumn, nupdate, nblock, nforce, nsensor;
    int nq, nv, nrow, nout;
    double size;            /* m, of the mechanism: measure of what is small */
    const jo_real *gravity; /* (3) m/s^2 */
    const jo_body *body;
    const jo_marker *marker;   /* the first nactive belong to joints and forces, the rest to sensors */
    const jo_joint *joint;
    const jo_pair *pair;
    const jo_column *column;
    const jo_below *below;
    const jo_update *update;
    const int *update_first;   /* (ncolumn + 1) range of updates made by each column */
    const jo_signal *signal;
    const jo_force *force;
    const jo_sensor *sensor;
} jo_model;

typedef struct {
    int method;             /* jo_method */
    int projection;         /* positions and velocities are projected after every step */
    double step;            /* s */
    double alpha, beta;     /* Baumgarte: C'' + 2 alpha C' + beta^2 C = 0; 0 = off */
} jo_solver;

typedef struct jo_data jo_data;

int jo_abi(void);
int jo_model_size(void);                         /* bytes of a jo_model, to compare with the caller's */
int jo_cpu_level(void);                          /* x86-64 level of this processor (1, 3, 4); 0 elsewhere */
jo_data *jo_data_new(const jo_model *m);         /* 0 if there is no memory */
void jo_data_free(jo_data *d);
jo_real *jo_data_q(jo_data *d);                  /* (nq) */
jo_real *jo_data_v(jo_data *d);                  /* (nv) */
jo_real *jo_data_a(jo_data *d);                  /* (nv) */
jo_real *jo_data_lam(jo_data *d);                /* (nrow) */
jo_real *jo_data_time(jo_data *d);               /* (1) s */
jo_real *jo_data_work(jo_data *d);               /* (2) J: dissipated by damping, done by forces */
int jo_data_error_index(const jo_data *d);       /* body or joint of the last error */

int jo_accelerations(const jo_model *m, jo_data *d);          /* a, lam from time, q, v */
int jo_assemble(const jo_model *m, jo_data *d, int iterations, double tolerance);
int jo_step(const jo_model *m, jo_data *d, const jo_solver *s);
void jo_energy(const jo_model *m, jo_data *d, jo_real *out);      /* (3) kinetic strain potential */
void jo_residuals(const jo_model *m, jo_data *d, jo_real *out);   /* (2) largest |C|, |Cq v| */
void jo_constraints(const jo_model *m, jo_data *d, jo_real *c, jo_real *cdot);   /* (nrow) each */
void jo_mass_matrix(const jo_model *m, jo_data *d, int body, jo_real *M);        /* (6+n)^2, local */
void jo_sensors(const jo_model *m, jo_data *d, jo_real *out);     /* (nout), after jo_accelerations */

/* Advance nsteps; whenever the step count is a multiple of `every` write one row
 * [time q v lam kinetic strain potential dissipated work |C| |Cq v| sensors] to rows.
 * `count` holds the steps done before and is advanced, `written` the rows. Returns a jo_status. */
int jo_run(const jo_model *m, jo_data *d, const jo_solver *s, long long nsteps, long long every,
           long long *count, int *written, jo_real *rows);
int jo_row(const jo_model *m, jo_data *d, jo_real *row);   /* one such row of the present state */
int jo_row_size(const jo_model *m);
/* END */

#endif
