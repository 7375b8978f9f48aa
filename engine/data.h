/* data.h - jo_data: state and work space of one run. */
#ifndef JO_DATA_H
#define JO_DATA_H

#include "valid_data.h"
#include "maximal/maximal_data.h"
#include "newton/newton_data.h"
#include "force/force_data.h"
#include "beam/beam_data.h"
#include "friction/friction_data.h"
#include "tree/tree_data.h"
#include "integrate/integrate_data.h"
#include <stddef.h>

struct jo_data {
    jo_valid valid;
    jo_split split;
    jo_real time[1];
    jo_work work, power;    /* work since the start, J; rates at the last evaluation, W */
    jo_work power0;         /* rates at the start of the last step, W; half of its work is added by jo_add_step_work */
    double waiting;         /* length of that step, s; 0: work is complete */
    jo_real *q, *v, *a, *lam;   /* (nq), (nv), (nv), (nrow) maximal coordinates, velocities, accelerations, multipliers */
    jo_tree tree;
    jo_real *y, *w, *wd;    /* integrated quantities: q, v, a or, in joint coordinates, x, u, ud */
    int ny, nw;             /* number of positions and of velocities; the latter include the states of forces, which come last */
    jo_real *q0, *v0, *dq, *dv, *rate;   /* stage of a step: (nq), (nw) start, (nw) increments, changes of velocities, rates */
    jo_real *acc;           /* (nw) accelerations of stage 1 of ROS2; residual of Newton's method */
    jo_slopes_of_state *slopes;   /* (nstate) derivatives of states in the matrix of ROS2 */
    jo_real *stages;        /* (7 x (2 nw + 3)) rates of increments, velocities and work in an adaptive step */
    jo_real *change;        /* (2 nw + 3) change of increments, velocities and work in the step */
    jo_real *q1, *v1, *lam1;   /* state at the end of the step while rows within the step are written */
    double *extent;         /* (3 x nbody) largest speed, m/s, modal coordinates, their rates since the start; (nstate) largest states */
    double *nominal;        /* (nstate) smallest size of states to which errors are relative */
    jo_control control;
    jo_body_work *body;
    int nbeam;
    jo_beam_work *beam;
    double *bent;           /* (nbeam x 2) largest bending and tension, see jo_data_bent */
    jo_marker_work *marker;
    jo_coordinate_work *coordinate;
    jo_joint_work *joint;
    jo_force_work *force;
    jo_real *turn;          /* (nturn) last accepted values of the counted angles, rad */
    jo_real *input;         /* (ninput) */
    int *locked, *slip, *happened;   /* (nlock), (nfriction), (nevent) see jo_data_locked ... */
    jo_real *held;          /* (2 nlock) */
    jo_real *direction, *rub;   /* (2 nfriction) */
    double *memory;         /* (nmemory) */
    jo_anderson anderson;

    char *state;            /* block of state_bytes: q .. happened, memory, history of the methods */
    size_t state_bytes;
    jo_kept kept;
    jo_model metered;       /* the model with the sensors of damage meters only */
    jo_real *reading;       /* (nout) values of the sensors of meters */
    double *scratch;        /* work space for the residue of a meter */
    int metered_demanding;  /* whether the sensors of meters need accelerations */
    jo_model watch;         /* the model with the sensors of events only */
    jo_real *measured;      /* (nout) values of the sensors of events */
    double *level, *below, *above, *trial, *scale;   /* (jo_watched) value - threshold of events, margin of frictions: at the start of
                                                      * the step; at the ends of the bracket of a crossing; at a trial; change in the step */
    int *side;              /* (jo_watched) sign of value - threshold; 0: the run starts at the threshold */
    int demanding;          /* whether the sensors of events need accelerations */
    double *log;            /* (jo_log_room x 3) log, see jo_data_log */
    int logged;
    double left;            /* time at the end of the last call, s */
    struct { jo_real start; double step; long long count; } grid;   /* times start + count step of jo_run */
    jo_counts counts;
    jo_pair_plan *pairs;
    jo_pull_plan *pulls;
    jo_real **hubs;         /* (nhub) diagonal blocks of the hubs */
    jo_column_plan *columns;
    jo_below_plan *belows;
    jo_update_plan *updates;
    jo_real **fills;        /* (nfill) fill-in blocks, 0 before elimination */
    int nfill;
    jo_real *S, *S0;        /* (nblock x JO_BLOCK) S = Cq M^-1 Cq^T or its factors; copy of S for refinement */
    jo_real drive;          /* power of the drives, W, which power.forces includes */
    jo_real *gram[2];       /* (npair x 36) L_k weight L_l^T of pairs on flexible bodies, of both sets */
    double gh;              /* g h of the constants of set 1, s */
    jo_weights weights;     /* weights of the factors of N */
    double aged;            /* bound of the rotation of bodies since N was factored, rad */
    jo_real *base, *base_lam;   /* (nv), (nrow) initial accelerations and multipliers of coupled_mass.c */
    jo_real *stiff;         /* (nbeam x JO_BEAM_KEPT) stiffness and damping of beams for ROS2 */
    jo_real *lag, *sum;     /* (nv) forces of beams in the W-method; work space */
    jo_real *algorithmic, *end_a, *end_q, *end_v, *end_lam;   /* generalised alpha: at the end of the step */
    jo_real *end_time;      /* (1) time at the end of that step, s */
    jo_real *N, *x;         /* (nnewton) Newton's matrix or its factors, (nv + nrow) right-hand side or solution */
    jo_real *whole;         /* (nv + nrow) Newton increment before it is shortened */
    int *pivot;             /* (nv + nrow) row exchanges */
    double *unit, *unit_of_row;   /* (nv + nrow) units of the unknowns of N; the same in the order of the exchanged rows */
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

/* states of forces and their rates, the last entries of w and wd */
static inline jo_real *jo_states(const jo_model *m, const jo_data *d) { return d->w + (d->nw - m->nstate); }
static inline jo_real *jo_state_rates(const jo_model *m, const jo_data *d) { return d->wd + (d->nw - m->nstate); }

/* y = A x: from the frame of the body of a marker to the world frame; y = x on ground */
static inline void jo_to_world(jo_real *y, const jo_model *m, const jo_data *d, int marker, const jo_real *x)
{
    const int body = m->marker[marker].body;
    if (body < 0) jo_set3(y, x);
    else jo_mul3(y, d->body[body].A, x);
}

/* calls with the number of rows as a constant, so that the compiler unrolls loops over rows */
#define JO_BY_ROWS(n, call)        \
    switch (n) {                   \
    case 1: call(1); break;        \
    case 2: call(2); break;        \
    case 3: call(3); break;        \
    case 4: call(4); break;        \
    case 5: call(5); break;        \
    default: call(6); break;       \
    }

/* whether the event that deactivates a joint or a force has occurred; event -1: never */
static inline int jo_released(const jo_data *d, int event) { return event >= 0 && d->happened[event] > 0; }

/* whether the rows of a joint are inactive: unlocked or released */
static inline int jo_absent(const jo_data *d, const jo_joint *k)
{
    return (k->lock >= 0 && !d->locked[k->lock]) || jo_released(d, k->release);
}

/* whether a model has hybrid mode: bodies in maximal coordinates and trees */
static inline int jo_mixed(const jo_model *m) { return m->nlink && m->link->type == JO_LINK_BODY; }

/* whether a body in maximal coordinates carries trees */
static inline int jo_carries_trees(const jo_model *m, int body)
{
    for (int i = 0; i < m->nlink && jo_mixed(m); i++)
        if (m->link[i].parent >= 0 && m->link[m->link[i].parent].type == JO_LINK_BODY && m->link[m->link[i].parent].body == body) return 1;
    return 0;
}

#endif
