/* internal.h - the workspace of a run, and what each file has for others: after the files that it calls. */
#ifndef JO_INTERNAL_H
#define JO_INTERNAL_H

#include "small.h"
#include <stddef.h>

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
    int pushed;             /* y and yp hold a change of force, see friction_solve.c */
    int modes;              /* place of the modal velocities in what is integrated */
    jo_real *port;          /* (6 x 6) inertia with that of the trees it carries, see tree_ports.c; 0: it carries none */
    jo_real *Dd, *H;        /* (6 x np) ED p', (3 x np) EB p'' for Newton's matrix */
    jo_real turn[9];        /* change of orientation (local) by a change of the increment of a step */
    jo_body_set set[2];
} jo_body_work;

enum { JO_BEAM_KEPT = 216 };   /* reals of the stiffness and damping of a beam element that ROS2 keeps */

/* A beam element; vectors resolved in the frame of its middle unless said otherwise. */
typedef struct {
    jo_real B[2][4];        /* quaternions of the end frames on their bodies */
    int turned, offset, damped, helical, fibrous;   /* B, u, beta are not trivial; a screw line; twist stretches fibres */
    jo_real Q[9];           /* orientation of the middle frame */
    jo_real G[2][9];        /* A^T Q of the bodies */
    jo_real U[2][3];        /* levers u */
    jo_real tau[3], square; /* Rodrigues' parameters of half the rotation between the ends, their square */
    jo_real mu, dmu;        /* H = E - mu tau~ tau~, and its change with the square */
    jo_real d[3], e[6], rate[6], s[6];   /* Gamma + e1; strains, their rates, resultants */
    jo_real om[2][3], om_m[3], dv[3];    /* angular velocities of the ends and the middle, relative velocity of the ends */
    jo_real raw[6], f[6];   /* helical: rates of d and kappa; conjugate to d and kappa, else the resultants */
    jo_real lean;           /* fibrous: Ip/A kappa_x, how twist stretches the fibres */
    jo_real t[3], M[2][3];  /* L n x d; moments on the ends */
    jo_real last[3];        /* tau of the last accepted state */
} jo_beam_work;

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

typedef struct {
    jo_real value, rate, second;   /* and its derivatives with respect to time */
} jo_signal_work;

typedef struct {
    jo_real y[6];           /* force and torque on b, world; ALONG_COORDINATE: the force first */
    jo_real stored;         /* J in its springs */
    jo_real stiffness, damping;   /* of forces with states: -dF/ds, -dF/ds' at the states */
} jo_force_work;

/* A state x' = f of a force F along a coordinate s, as ROS2 has it in its matrix: dF/dx, -df/dx, df/ds, df/ds'. */
typedef struct { jo_real force, decay, value, rate; } jo_slopes_of_state;

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

/* A friction that slides, with `count` forces from `first` on in the iteration. */
enum { JO_REACH = 8 };      /* that many forces at most have their effect on the reactions worked out beforehand */
typedef struct {
    int friction, first, count;
    jo_real press[2], collar[2];   /* its forces for a unit of what presses and of the moment of a collar */
    jo_real start[6], y[6]; /* reaction of its joint in the axes of side 0, without friction and with it */
    jo_real reach[JO_REACH][6];   /* what a unit of each force adds to it */
} jo_slider;

/* the iteration between friction forces f and their residual r, (2 nfriction) each */
enum { JO_PAIRS = 4 };      /* changes of f and r that it remembers */
typedef struct {
    jo_slider *slider;      /* (nfriction) */
    int *coordinate;        /* (2 nfriction) of each force */
    int sliders, n;         /* how many slide, with how many forces */
    jo_real *lam;           /* (nrow) multipliers without friction */
    jo_real *reach;         /* (JO_REACH x nrow) what a unit of each force adds to them */
    jo_real *f, *g, *r, *before, *change;
    jo_real *dF[JO_PAIRS], *dR[JO_PAIRS], *Q[JO_PAIRS];
    int pairs, newest;
} jo_mixing;

/* What the start of a step was, to repeat it. */
typedef struct {
    jo_real time, drive;
    jo_work work, power, power0;
    double waiting;
    int fresh, restart;
    char *state;            /* copy of the arrays */
} jo_kept;

/* What one unknown of Newton's matrix, an acceleration, changes: accelerations by a, velocities by v, increments of
 * the position by q. The rows of the joints are those of C' times rows, or of C. */
typedef struct {
    double a, v, q, rows;
    int position;           /* rows of C instead of C' */
    int plain;              /* inertia forces change with accelerations only */
} jo_weights;

/* What an evaluation is for: the same for its forces, masses, multipliers and friction. All 0: the accelerations now. */
typedef struct {
    int set;                /* 1: effective modal masses E + g h D + (g h)^2 K, and the stiffness of beams is kept: ROS2 */
    double gh;              /* its g h */
    double lead;            /* forces act as they will be so much later: the time derivative in ROS2 */
    int second;             /* its second stage: from the accelerations of the first, whose factors serve again */
    int smooth;             /* friction is left out: the joints are being closed */
    double alpha, beta;     /* Baumgarte's terms, as of jo_solver */
    jo_weights weights;     /* of Newton's matrix */
} jo_stage;
static const jo_stage jo_now = {0};
static inline int jo_stabilised(const jo_stage *stage) { return stage->alpha != 0.0 || stage->beta != 0.0; }

/* The block Cholesky of S as it is carried out: what the model's lists mean in memory. `kind` says which numbers of rows
 * and columns occur, see schur.c. `lock` is that of an optional joint, else 0: where it is switched off its blocks are 0. */
typedef struct { jo_real *S; const jo_side_work *k, *l; int kind, first, flexible; const int *lock_k, *lock_l; } jo_pair_plan;
typedef struct { jo_real *S; const jo_side_work *side; int rows, later, first; const int *lock; } jo_pull_plan;
typedef struct { jo_real *S, *x, *scale; double sign; int n, first, count, update, updates; const int *lock; } jo_column_plan;
typedef struct { jo_real *X, *x; int rows, kind; const int *lock; } jo_below_plan;
typedef struct { jo_real *T; const jo_real *X, *Y; int rows, ny, kind; const int *lock_x, *lock_y; } jo_update_plan;

/* Error control of the adaptive method, and its last step for the dense output. */
typedef struct {
    double start;           /* time of the first row */
    double duration;        /* to the last row */
    double from, length;    /* the last step began at `from`; the state stands at from + length */
    double next;            /* length that the next step should have */
    double error;           /* of the last accepted step, 1 is what the tolerance allows */
    jo_work work;           /* at the start of the last step */
    long long tries;        /* since the last row */
    int shortened;          /* the last try was rejected */
    int known;              /* a and power belong to the present state though it is not fresh */
    int found;              /* the last step ends at an event */
    int first;              /* no step yet: values at a threshold may leave it either way */
    int measured;           /* the damage meters know the present state */
    int chain;              /* events since the last step without one */
    int status;             /* why it could not be evaluated, or JO_OK */
    int worst;              /* body with the largest error */
} jo_control;

/* Rigid trees in joint coordinates, see tree.c. While `on` the state is x and u; q and v, then also a and lam, follow when somebody
 * needs them. */
typedef struct jo_link_work jo_link_work;
typedef struct jo_link_constants jo_link_constants;
typedef struct jo_link_change jo_link_change;
typedef enum { JO_MIRROR_NONE = 0, JO_MIRROR_PART = 1,   /* PART: the bodies that run by rows, with their markers */
               JO_MIRROR_STATE = 2, JO_MIRROR_ALL = 3 } jo_mirrored;
typedef struct jo_loop_work jo_loop_work;
typedef struct jo_reach_work jo_reach_work;

/* A dense symmetric matrix S of n rows and its factors, see gram.c. */
typedef struct {
    int n, ld, rank;        /* columns in memory; rows that do not repeat others */
    jo_real *S, *inverse, *y;   /* (n x ld), (n) of the pivots, (n) scratch */
    double *scale;          /* (n) what a diagonal may be like: a pivot that vanishes against it repeats others */
    int *order;             /* (n) rows as they were eliminated */
} jo_gram;

typedef struct {
    int on;
    jo_mirrored mirrored;
    int summed;             /* the links have all accelerations and loads of the last evaluation */
    jo_real *x, *u, *ud;    /* (nx), (nu) coordinates, rates, accelerations */
    jo_real *tau;           /* (nu) force along each of them */
    jo_real *stiffness, *damping;   /* (nu) that are implicit in ROS2 */
    jo_real *pull;          /* (nlink) force of each drive */
    jo_link_work *link;     /* (nlink + 1), the ground first */
    jo_link_constants *constants;   /* (nlink) */
    jo_link_change *change; /* (nlink + 1) by further forces */
    jo_real *push;          /* (nu) further forces along the coordinates */
    int *marker, *coordinate, *body;   /* that forces need at every evaluation */
    int nmarker, ncoordinate, nbody;
    int *hinge, nhinge;     /* links that are hinges */
    int ndriven;            /* links whose motion is prescribed by a drive */
    jo_real *seen;          /* (nq + nv) what q and v are by x and u */
    int direct;             /* all counted angles are joint coordinates */
    jo_loop_work *loop;     /* (nloop) */
    jo_reach_work *reach;   /* (nreach) */
    jo_gram *gram;          /* (ngroup) */
    int ngroup;
    int *closing, nclosing; /* markers of the loops */
    int kept;               /* bodies that run by the rows of their joints, the first links; 0: the links have all */
    int narrow;             /* the core in q and v works on these alone */
    int *away_body, *away_marker, *away_coordinate, *away_joint;   /* what it leaves out then */
    int column, pair, fill; /* where its columns and fills begin and its pairs end */
} jo_tree;

struct jo_data {
    jo_real time[1];
    jo_work work, power;    /* so far, and the rates at the last evaluation */
    jo_work power0;         /* rates at the start of the last step, whose half is not yet in work */
    double waiting;         /* length of that step, or 0 */
    jo_real *q, *v, *a, *lam;
    jo_tree tree;
    jo_real *y, *w, *wd;    /* what is integrated: q, v and a, or x, u and ud */
    int ny, nw;             /* how many positions and velocities these are; the states of forces follow the velocities */
    jo_real *q0, *v0, *dq, *dv, *rate;   /* stages of a step: (nq) and (nw) */
    jo_real *acc;           /* (nw) first stage of ROS2 */
    jo_slopes_of_state *slopes;   /* (nstate) that ROS2 has in its matrix */
    jo_real *stages;        /* (7 x (2 nw + 3)) rates of increments, velocities and work in an adaptive step */
    jo_real *change;        /* (2 nw + 3) what the step changed */
    jo_real *q1, *v1, *lam1;   /* the state at its end, while rows before it are written */
    double *extent;         /* (3 x nbody) largest speed, modal coordinates and their speed so far, (nstate) states */
    double *nominal;        /* (nstate) size of states whose errors matter */
    jo_control control;
    jo_body_work *body;
    int nbeam;
    jo_beam_work *beam;
    double *bent;           /* (nbeam x 2) */
    jo_marker_work *marker;
    jo_coordinate_work *coordinate;
    jo_joint_work *joint;
    jo_force_work *force;
    jo_real *turn;          /* (nturn) last accepted values of the angles */
    jo_real *input;         /* (ninput) */
    int *locked, *slip, *happened;
    jo_real *held;          /* (2 nlock) */
    jo_real *direction, *rub;   /* (2 nfriction) */
    double *memory;         /* (nmemory) */
    jo_mixing mixing;

    char *state;            /* q .. happened and what methods remember, one block of state_bytes */
    size_t state_bytes;
    int restart;            /* forces jumped: methods with a memory start anew, and set it to 0 */
    jo_kept kept;
    jo_model metered;       /* the model with the metered sensors only */
    jo_real *reading;       /* (nout) their values */
    double *scratch;        /* of the largest meter */
    int metered_demanding;  /* metered sensors need accelerations */
    jo_model watch;         /* the model with the watched sensors only */
    jo_real *measured;      /* (nout) their values */
    double *level, *below, *above, *trial, *scale;   /* (jo_watched) value less threshold, margin: at the start of the step, at the ends
                                                      * of the interval in which a crossing lies, between; change in the step */
    int *side;              /* (jo_watched) sign of the value, 0: starts at the threshold */
    int watching, demanding;   /* level and side are valid; watched sensors need accelerations */
    double *log;            /* (jo_log_room x 3) time, event or nevent + friction, direction or slip */
    int logged;
    double left;            /* time at the end of the last call */
    struct { jo_real start; double step; long long count; int valid; } grid;   /* of the instants of jo_run, and its last call */
    jo_counts counts;
    int regular;            /* S is regularised */
    jo_pair_plan *pairs;
    jo_pull_plan *pulls;
    jo_real **hubs;         /* (nhub) diagonal blocks of the hubs */
    jo_column_plan *columns;
    jo_below_plan *belows;
    jo_update_plan *updates;
    jo_real **fills;        /* (nfill) blocks that are zero before elimination */
    int nfill;
    jo_real *S, *S0;        /* (nblock x JO_BLOCK); S0 before it is factored, with redundant rows */
    jo_real drive;          /* part of power.forces that drives do */
    jo_real *gram[2];       /* (npair x 36) */
    double gh;              /* g h of set 1 */
    jo_weights weights;     /* with which an implicit step factored N */
    int factored;           /* N holds factors */
    int softened;           /* those of the matrix with jo_joint_work.soft */
    double aged;            /* rad, by which a body has turned since then, at most */
    jo_real *base, *base_lam;   /* (nv), (nrow) accelerations and multipliers that coupled.c starts from */
    jo_real *stiff;         /* (nbeam x JO_BEAM_KEPT) stiffness and damping of beams that ROS2 keeps */
    jo_real *lag, *sum;     /* (nv) what beams lag behind in an implicit stage; scratch */
    int *started;           /* (1) implicit method: the arrays below belong to the state end_q, end_v */
    jo_real *algorithmic, *end_a, *end_q, *end_v, *end_lam;   /* algorithmic and true accelerations .. at the end of its step */
    jo_real *end_time;      /* (1) */
    jo_real *N, *x;         /* (nnewton) Newton's matrix or its factors, (nv + nrow) right-hand side or solution */
    jo_real *whole;         /* (nv + nrow) the increment that is being shortened */
    int *pivot;             /* (nv + nrow) */
    double *unit, *unit_of_row;   /* (nv + nrow) of the unknowns of N, and as the rows of a node lie while they are exchanged */
    int current;            /* bodies and active markers stand at the present q, v */
    int fresh;              /* a and lam belong to the present time, q, v and set 0 */
    int again;              /* they did before the caller could change the state */
    int error_index;
    void *arena;
};

/* y += s x */
static inline void jo_add_work(jo_work *y, double s, const jo_work *x)
{
    y->damping += s * x->damping;
    y->friction += s * x->friction;
    y->forces += s * x->forces;
}

/* the states of forces and their rates, behind what is integrated */
static inline jo_real *jo_states(const jo_model *m, const jo_data *d) { return d->w + (d->nw - m->nstate); }
static inline jo_real *jo_state_rates(const jo_model *m, const jo_data *d) { return d->wd + (d->nw - m->nstate); }

/* world vector of a local one; ground is its own world */
static inline void jo_to_world(jo_real *y, const jo_model *m, const jo_data *d, int marker, const jo_real *x)
{
    const int body = m->marker[marker].body;
    if (body < 0) jo_set3(y, x);
    else jo_mul3(y, d->body[body].A, x);
}

/* The work on small blocks is compiled for the row counts that occur, so that loops unroll. */
#define JO_BY_ROWS(n, call)        \
    switch (n) {                   \
    case 1: call(1); break;        \
    case 2: call(2); break;        \
    case 3: call(3); break;        \
    case 4: call(4); break;        \
    case 5: call(5); break;        \
    default: call(6); break;       \
    }

/* whether an event has happened that releases a joint or a force */
static inline int jo_released(const jo_data *d, int event) { return event >= 0 && d->happened[event] > 0; }

/* whether the rows of an optional joint are switched off */
static inline int jo_absent(const jo_data *d, const jo_joint *k)
{
    return (k->lock >= 0 && !d->locked[k->lock]) || jo_released(d, k->release);
}

/* what the core in q and v leaves out now, because joint coordinates carry it */
static inline int jo_body_away(const jo_data *d, int i) { return d->tree.narrow && d->tree.away_body[i]; }
static inline int jo_marker_away(const jo_data *d, int i) { return d->tree.narrow && d->tree.away_marker[i]; }
static inline int jo_coordinate_away(const jo_data *d, int i) { return d->tree.narrow && d->tree.away_coordinate[i]; }
static inline int jo_joint_away(const jo_data *d, int i) { return d->tree.narrow && d->tree.away_joint[i]; }

/* whether rows of joints and joint coordinates run a model together */
static inline int jo_mixed(const jo_model *m) { return m->nlink && m->link->type == JO_LINK_BODY; }

/* whether a body runs by rows and has links on it */
static inline int jo_bears(const jo_model *m, int body)
{
    for (int i = 0; i < m->nlink && jo_mixed(m); i++)
        if (m->link[i].parent >= 0 && m->link[m->link[i].parent].type == JO_LINK_BODY && m->link[m->link[i].parent].body == body) return 1;
    return 0;
}

/* body.c */
void jo_body_setup(const jo_body *b, jo_body_work *w, int set, double gh);
void jo_body_pose(const jo_body *b, jo_body_work *w, const jo_real *q);
void jo_body_twist(const jo_body *b, jo_body_work *w, const jo_real *v);
void jo_body_inertia(const jo_body *b, jo_body_work *w, jo_real *power);
int jo_body_factor(const jo_body *b, jo_body_work *w, int set);
void jo_body_free(const jo_body *b, jo_body_work *w, int set);
void jo_body_reduce(const jo_body *b, const jo_body_work *w, int set, const jo_real *fr, const jo_real *fp, jo_real *z);
void jo_body_forward(const jo_real *L, jo_real *x);
void jo_body_backward(const jo_real *L, jo_real *x);
void jo_body_modal(const jo_body *b, jo_body_work *w, int set);

/* newton.c */
typedef struct { jo_real *at; int stride; } jo_block;
static inline int jo_pad(int count) { return (count + JO_PAD - 1) & ~(JO_PAD - 1); }
jo_block jo_newton_find(const jo_model *m, jo_data *d, int x, int y);   /* rows of x, columns of y: bodies, then joints */
int jo_newton_factor(const jo_model *m, jo_data *d, int redundant);
void jo_newton_solve(const jo_model *m, jo_data *d);

/* marker.c */
void jo_marker_setup(const jo_model *m, jo_data *d, int set);
void jo_marker_position(const jo_model *m, jo_data *d, int count);
void jo_marker_velocity(const jo_model *m, jo_data *d, int count);
void jo_marker_bias(const jo_model *m, jo_data *d, int count);
void jo_marker_reduce(const jo_model *m, jo_data *d, int set, int count);

/* motion of a marker, world frame */
typedef struct {
    jo_real r[3], v[3], a[3];      /* position, velocity, acceleration */
    jo_real om[3], al[3];          /* angular velocity and acceleration */
} jo_motion;
/* after jo_marker_bias; accelerations 0: not those */
void jo_marker_motion(const jo_model *m, const jo_data *d, int marker, int accelerations, jo_motion *y);
void jo_marker_acceleration(const jo_model *m, const jo_data *d, int marker, jo_real *y);

/* signal.c */
jo_signal_work jo_signal_at(const jo_model *m, const jo_data *d, int signal, jo_real time);

/* coordinate.c */
void jo_coordinate_place(const jo_model *m, jo_data *d, int coordinate);   /* value, gradient */
void jo_coordinate_move(const jo_model *m, jo_data *d, int coordinate);    /* rate, bias */
void jo_coordinates(const jo_model *m, jo_data *d, int count);     /* value, gradient */
void jo_coordinates_rate(const jo_model *m, jo_data *d, int count);   /* rate, bias */
jo_real jo_coordinate_acceleration(const jo_model *m, const jo_data *d, int coordinate);
void jo_count_turns(const jo_model *m, jo_data *d);                /* the present angles are accepted */
jo_real jo_arc_tangent(jo_real y, jo_real x);                      /* four quadrants */

/* joint.c */
jo_real jo_joint_residual(const jo_model *m, jo_data *d);         /* fills c, returns the largest, m (jo_row_metres) */
jo_real jo_joint_residual_rate(const jo_model *m, jo_data *d);    /* the same for cdot, m/s */
jo_real jo_joint_gap(const jo_model *m, jo_data *d, int joint);        /* the same of one joint */
jo_real jo_joint_gap_rate(const jo_model *m, jo_data *d, int joint);   /* its coordinates have their rates */
void jo_joint_rows(const jo_model *m, jo_data *d);
/* (nrow x 3) what velocity f and angular velocity g of the marker of a side (world) add to the rates of the rows; side 0 first */
void jo_joint_slopes(const jo_model *m, jo_data *d, int joint, int side, jo_real (*f)[3], jo_real (*g)[3]);
/* second derivatives of the rows where the markers of the sides have these angular velocities and accelerations */
void jo_joint_second(const jo_model *m, const jo_data *d, int joint, const jo_motion *side, double lead, jo_real *x);
void jo_joint_acceleration(const jo_model *m, jo_data *d, const jo_stage *stage);
jo_real jo_joint_power(const jo_model *m, const jo_data *d);     /* work that drives do, per second */
jo_real jo_joint_drive(const jo_model *m, const jo_data *d, int joint, const jo_real *lam);   /* the same of one joint */
void jo_joint_apply(const jo_model *m, jo_data *d, int set);

/* push.c */
void jo_push(const jo_model *m, jo_data *d, int marker, const jo_real *F, const jo_real *T);
void jo_push_along(const jo_model *m, jo_data *d, int coordinate, jo_real f);
void jo_push_change(const jo_model *m, jo_data *d, int coordinate, jo_real f);   /* into y and yp of the bodies */

/* beam_fibre.c */
void jo_beam_fibre(const jo_model *m, const jo_data *d, int i);
void jo_beam_fibre_rate(const jo_data *d, int i);
void jo_beam_fibre_force(const jo_data *d, int i);
void jo_beam_fibre_tangent(const jo_model *m, const jo_data *d, int i, jo_real *C, jo_real *X);

/* beam_helix.c */
void jo_beam_helix(const jo_model *m, const jo_data *d, int i);
void jo_beam_helix_rate(const jo_model *m, const jo_data *d, int i);
void jo_beam_helix_force(const jo_model *m, const jo_data *d, int i);
void jo_beam_helix_tangent(const jo_model *m, const jo_data *d, int i, const jo_real *C, jo_real *effective, jo_real *X);

/* beam_inertia.c */
void jo_beam_inertia(const jo_model *m, jo_data *d, int i, const jo_real *a);
jo_real jo_beam_kinetic(const jo_model *m, const jo_data *d);
void jo_beam_newton_inertia(const jo_model *m, jo_data *d, int i, const jo_weights *c);

/* beam.c */
void jo_beam_setup(const jo_model *m, jo_data *d);
int jo_beam_forces(const jo_model *m, jo_data *d, const jo_real *a);   /* with inertia at accelerations a, 0: at none */
double jo_beam_pull(const jo_model *m, const jo_data *d, int i);
jo_real jo_beam_stored(const jo_model *m, const jo_data *d);
void jo_beam_section(const jo_model *m, const jo_data *d, int i, jo_real *y);
void jo_beam_accept(const jo_model *m, jo_data *d);
void jo_beam_forget(jo_data *d);

/* tree_respond.c */
void jo_tree_respond_clear(const jo_model *m, jo_data *d);
void jo_tree_respond(const jo_model *m, jo_data *d, jo_real *rate);   /* (nu) changes of the joints' accelerations */

/* tree_friction.c */
void jo_tree_slips(const jo_model *m, jo_data *d);    /* coordinates along which frictions slide, and their rates */
jo_real jo_tree_second(const jo_model *m, const jo_data *d, int coordinate);   /* and its acceleration */
void jo_tree_bears(const jo_model *m, const jo_data *d, const jo_friction *f, int change, jo_real *y);
void jo_tree_held(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *y);
void jo_tree_locks(const jo_model *m, jo_data *d);
void jo_tree_hold(const jo_model *m, jo_data *d);
void jo_tree_friction_respond(const jo_model *m, jo_data *d, const jo_real *f);
void jo_tree_friction_act(const jo_model *m, jo_data *d);
void jo_tree_stop(const jo_model *m, jo_data *d);     /* what is held comes to rest */

/* tree_place.c */
void jo_tree_setup(const jo_model *m, jo_data *d);
void jo_tree_kinematics(const jo_model *m, jo_data *d);
void jo_tree_read(const jo_model *m, jo_data *d);     /* x and u from q and v */
void jo_tree_spread(const jo_model *m, jo_data *d, const jo_real *rate, jo_real *v);   /* (nv) of the bodies at (nu) of the joints */

/* tree_mirror.c */
int jo_tree_stands(const jo_model *m, jo_data *d);    /* whether q and v are those of x and u, to the last digit */
void jo_mirror(const jo_model *m, jo_data *d, jo_mirrored how);

/* tree_move.c */
void jo_tree_displace(const jo_model *m, jo_real *x, const jo_real *x0, const jo_real *increment);
void jo_tree_increment_rate(const jo_model *m, jo_real *rate, const jo_real *x, const jo_real *u);
void jo_turn_between(jo_real *theta, const jo_real *e0, const jo_real *e);   /* below half a turn, in the frame of e0 */
void jo_tree_drives(const jo_model *m, jo_data *d);   /* what is prescribed has its value and rate of this time */
int jo_tree_check(const jo_model *m, jo_data *d);
double jo_tree_turned(const jo_model *m, jo_data *d);   /* largest turn of a body by the increments dq, about */

/* state.c */
void jo_use_core(const jo_model *m, jo_data *d, int tree);   /* what is integrated */
void jo_move(const jo_model *m, jo_data *d, const jo_real *increment);   /* from q0, what is integrated */
void jo_move_rate(const jo_model *m, const jo_data *d, jo_real *rate, const jo_real *x);
void jo_refresh(const jo_model *m, jo_data *d);
void jo_body_displace(const jo_body *b, jo_real *q, const jo_real *q0, const jo_real *increment);
void jo_displace(const jo_model *m, jo_real *q, const jo_real *q0, const jo_real *increment);
void jo_increment_rate(const jo_model *m, jo_real *rate, const jo_real *x, const jo_real *v);
jo_real jo_speed(const jo_model *m, const jo_data *d);   /* m/s, the largest; turns on an arm of the size of the mechanism */
int jo_check(const jo_model *m, jo_data *d);   /* JO_OK if the state is finite and of a reasonable size */

/* force.c */
int jo_apply_forces(const jo_model *m, jo_data *d, const jo_stage *stage);
int jo_newton_forces(const jo_model *m, jo_data *d, const jo_stage *stage);
jo_real jo_stored(const jo_model *m, const jo_data *d);   /* in springs, where markers and coordinates stand */
void jo_state_nominals(const jo_model *m, jo_data *d, double duration);

/* hub.c */
void jo_hub_plan(const jo_model *m, jo_data *d);      /* after the pairs */
void jo_hub_assemble(const jo_model *m, jo_data *d);
void jo_hub_scales(const jo_model *m, jo_data *d);    /* adds what hubs give to the diagonal of S */

/* schur.c */
void jo_joint_plan(const jo_model *m, jo_data *d);    /* once */
void jo_joint_setup(const jo_model *m, jo_data *d, int set);
int jo_joint_factor(const jo_model *m, jo_data *d, int set);
void jo_joint_solve(const jo_model *m, jo_data *d);

/* reaction.c */
void jo_reaction(const jo_model *m, const jo_data *d, int joint, jo_real *y);   /* force and moment on side 1, world */
void jo_reaction_of(const jo_model *m, const jo_data *d, int joint, const jo_real *lam, jo_real *y);   /* of its multipliers lam */
void jo_react(const jo_model *m, jo_data *d);   /* -Cq^T lam acts on the bodies */

/* friction.c */
void jo_friction_push(const jo_model *m, jo_data *d);
jo_real jo_friction_margin(const jo_model *m, const jo_data *d, int i);
void jo_friction_turn(const jo_model *m, jo_data *d);
/* changes of the two sliding forces with the rates of the coordinates, and with force and moment (world) of the reaction */
typedef struct { jo_real rate[2][2], force[2][3], moment[2][3]; } jo_slopes;
void jo_friction_slopes(const jo_model *m, const jo_data *d, int i, jo_slopes *y);

/* tangent.c */
int jo_residual_at(const jo_model *m, jo_data *d, const jo_stage *stage, jo_real *r);   /* jo_residual in a step of an implicit method */
void jo_balance(const jo_model *m, const jo_data *d, jo_real *r);   /* M a less the forces that stand in fr and fp */

/* body_tangent.c */
void jo_newton_body(const jo_model *m, jo_data *d, const jo_stage *stage, int body);

/* beam_tangent.c */
void jo_newton_beams(const jo_model *m, jo_data *d, const jo_stage *stage);
void jo_beam_lag(const jo_model *m, jo_data *d, const jo_real *x, const jo_real *z);   /* (nv) d->lag += K x + D z, z may be 0 */

/* marker_tangent.c */
void jo_newton_marker(const jo_model *m, jo_data *d, const jo_stage *stage, int marker);
void jo_newton_stress(const jo_model *m, jo_data *d, const jo_stage *stage, int marker);   /* of the loads on it */

/* joint_tangent.c */
void jo_newton_joint(const jo_model *m, jo_data *d, const jo_stage *stage, int joint);

/* friction_tangent.c */
void jo_newton_frictions(const jo_model *m, jo_data *d);

/* blocks.c */
int jo_newton_assemble(const jo_model *m, jo_data *d, const jo_stage *stage);   /* at the state of the last jo_residual */
void jo_newton_masses(const jo_model *m, jo_data *d, const jo_stage *stage);    /* bodies and beams only */
void jo_newton_rows(const jo_model *m, jo_data *d, const jo_stage *stage);      /* joints only, without multipliers */

/* coupled.c */
int jo_couples(const jo_model *m, const jo_stage *stage);   /* whether the masses are coupled in it */
int jo_coupled_accelerations(const jo_model *m, jo_data *d, const jo_stage *stage);   /* a and joint[].x */
void jo_coupled_solve(const jo_model *m, jo_data *d, const jo_stage *stage);
void jo_coupled_respond(const jo_model *m, jo_data *d);   /* joint[].x by the changes of force in y and yp */
void jo_coupled_correction(const jo_model *m, jo_data *d, jo_real *increment);

/* friction_solve.c */
int jo_friction_solve(const jo_model *m, jo_data *d, const jo_stage *stage);

/* energy.c */
void jo_close_work(jo_data *d);

/* tree_force.c */
void jo_tree_bodies(const jo_model *m, jo_data *d);    /* the bodies of all links, as jo_refresh leaves them */
void jo_tree_markers(const jo_model *m, jo_data *d, const int *list, int count);   /* the same of markers, with their velocities */
int jo_tree_forces(const jo_model *m, jo_data *d, const jo_stage *stage);
void jo_tree_states(const jo_model *m, jo_data *d, const jo_stage *stage);   /* rates of states that answer to the accelerations */

/* gram.c */
int jo_gram_factor(jo_gram *g, int *row);   /* 1, 0: a pivot vanishes, -1: it is not finite; `row` says which */
int jo_gram_reveal(jo_gram *g, double least);   /* largest pivots first, down to `least` of their scale: 1, or -1 */
void jo_gram_solve(const jo_gram *g, jo_real *x);   /* S x = x; 0 in rows that repeat others */

/* tree_loop.c */
size_t jo_loop_bytes(void);
size_t jo_reach_bytes(void);
int jo_loop_rows(const jo_model *m, int i);   /* of the group of the loop, if it is the last one in it; else 0 */
void jo_loop_setup(const jo_model *m, jo_data *d);
int jo_loop_evaluate(const jo_model *m, jo_data *d, const jo_stage *stage);   /* multipliers, and the links bear them */
void jo_loop_solve(const jo_model *m, jo_data *d);   /* multipliers of the right-hand sides, with the factors of that */
void jo_loop_push(const jo_model *m, jo_data *d);    /* they act in jo_tree_respond */
jo_real jo_loop_power(const jo_model *m, const jo_data *d);

/* tree.c */
size_t jo_link_bytes(void);
size_t jo_link_constant_bytes(void);
size_t jo_link_change_bytes(void);
int jo_tree_load(const jo_model *m, jo_data *d, const jo_stage *stage);   /* forces and articulated inertias */
void jo_tree_follow(const jo_model *m, jo_data *d);   /* accelerations of the joints after that */
jo_real jo_tree_drive(const jo_model *m, jo_data *d); /* forces of what is prescribed; their power */
int jo_tree_evaluate(const jo_model *m, jo_data *d, const jo_stage *stage);

/* tree_ports.c */
void jo_ports_setup(const jo_model *m, jo_data *d);
void jo_ports_place(const jo_model *m, jo_data *d);   /* bodies that run by rows and their markers are at x and u */
void jo_ports_accept(const jo_model *m, jo_data *d);  /* x and u of these are q and v, where the markers are */
int jo_ports_load(const jo_model *m, jo_data *d, const jo_stage *stage);   /* all forces, and the inertia of what is carried */
int jo_ports_factor(const jo_body *b, jo_body_work *w);
void jo_ports_follow(const jo_model *m, jo_data *d);  /* accelerations of what is carried */

/* tree_close.c */
/* Loops are closed in the metric of the masses, with the factors of the last evaluation; whether they are then. */
int jo_tree_close(const jo_model *m, jo_data *d);
void jo_tree_increments(const jo_model *m, jo_real *dq, const jo_real *x0, const jo_real *x);

/* dynamics.c */
int jo_evaluate(const jo_model *m, jo_data *d, const jo_stage *stage);
void jo_mirror_all(const jo_model *m, jo_data *d);    /* a and lam of the last evaluation too */
void jo_use_step(const jo_model *m, jo_data *d, double gh);
#define JO_CLOSED 1e-12       /* of the size of a mechanism, or of its speed: residuals of closed joints, m and m/s */
void jo_project(const jo_model *m, jo_data *d, const jo_stage *stage);   /* with the factors of its last evaluation */
int jo_ready_sensors(const jo_model *m, jo_data *d, int demanding);

/* tree_enter.c */
int jo_tree_enter(const jo_model *m, jo_data *d);     /* the state of the caller becomes x and u */
void jo_tree_leave(const jo_model *m, jo_data *d);    /* and is the caller's again */
void jo_tree_count_turns(const jo_model *m, jo_data *d);
void jo_tree_drives_end(const jo_model *m, jo_data *d);   /* what is prescribed at the end of a step, and dq */

/* friction_switch.c */
int jo_friction_switch(const jo_model *m, jo_data *d, int i);
int jo_friction_settle(const jo_model *m, jo_data *d);

/* sensor.c */
int jo_needs_accelerations(const jo_sensor *s);

/* damage.c */
void jo_damage_setup(const jo_model *m, jo_data *d, jo_sensor *list);
int jo_damage_scratch(const jo_model *m);
int jo_measure(const jo_model *m, jo_data *d);   /* the present state is accepted: the meters count it */

/* row.c */
int jo_write_row(const jo_model *m, jo_data *d, jo_real *row);

/* implicit.c */
int jo_step_alpha(const jo_model *m, jo_data *d, const jo_solver *s);

/* dopri.c */
int jo_step_dopri(const jo_model *m, jo_data *d, const jo_solver *s, double h, double seen);
double jo_increments(const jo_model *m, jo_real *x, const jo_real *q0, const jo_real *q);
void jo_recall_stage(jo_data *d, int last);   /* the first or the last stage of the step */
void jo_interpolate(const jo_model *m, jo_data *d, double u);
double jo_defect(const jo_data *d, int i, int n);
void jo_tree_defects(const jo_model *m, jo_data *d, jo_real *increment, jo_real *velocity);   /* (nv) each */

/* step.c */
int jo_one_step(const jo_model *m, jo_data *d, const jo_solver *s);   /* by exactly s->step */

/* event.c */
int jo_event_step(const jo_model *m, jo_data *d, const jo_solver *s);   /* the same, with the events on the way */
void jo_event_setup(const jo_model *m, jo_data *d, jo_sensor *list);
int jo_watched(const jo_model *m);
int jo_event_keep(const jo_model *m, jo_data *d);   /* the state from which a step may be repeated */
int jo_event_find(const jo_model *m, jo_data *d, const jo_solver *s, int first, double *length, int *found);   /* after it */
int jo_event_happen(const jo_model *m, jo_data *d, int *chain);
int jo_log_room(const jo_model *m);
int jo_log_has_room(const jo_model *m, const jo_data *d);

#endif
