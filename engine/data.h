/* data.h - the workspace of a run: the state, and what each room keeps. */
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
    jo_anderson anderson;

    char *state;            /* q .. happened and what methods remember, one block of state_bytes */
    size_t state_bytes;
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
    int demanding;          /* watched sensors need accelerations */
    double *log;            /* (jo_log_room x 3) time, event or nevent + friction, direction or slip */
    int logged;
    double left;            /* time at the end of the last call */
    struct { jo_real start; double step; long long count; } grid;   /* of the instants of jo_run, and its last call */
    jo_counts counts;
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
    double aged;            /* rad, by which a body has turned since then, at most */
    jo_real *base, *base_lam;   /* (nv), (nrow) accelerations and multipliers that coupled_mass.c starts from */
    jo_real *stiff;         /* (nbeam x JO_BEAM_KEPT) stiffness and damping of beams that ROS2 keeps */
    jo_real *lag, *sum;     /* (nv) what beams lag behind in an implicit stage; scratch */
    jo_real *algorithmic, *end_a, *end_q, *end_v, *end_lam;   /* algorithmic and true accelerations .. at the end of its step */
    jo_real *end_time;      /* (1) */
    jo_real *N, *x;         /* (nnewton) Newton's matrix or its factors, (nv + nrow) right-hand side or solution */
    jo_real *whole;         /* (nv + nrow) the increment that is being shortened */
    int *pivot;             /* (nv + nrow) */
    double *unit, *unit_of_row;   /* (nv + nrow) of the unknowns of N, and as the rows of a node lie while they are exchanged */
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

/* whether rows of joints and joint coordinates run a model together */
static inline int jo_mixed(const jo_model *m) { return m->nlink && m->link->type == JO_LINK_BODY; }

/* whether a body runs by rows and has links on it */
static inline int jo_carries_trees(const jo_model *m, int body)
{
    for (int i = 0; i < m->nlink && jo_mixed(m); i++)
        if (m->link[i].parent >= 0 && m->link[m->link[i].parent].type == JO_LINK_BODY && m->link[m->link[i].parent].body == body) return 1;
    return 0;
}

#endif
