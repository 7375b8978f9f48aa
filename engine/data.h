/* data.h - jo_data: state and work space of one run. */
#ifndef JO_DATA_H
#define JO_DATA_H

#include "valid_data.h"
#include "evaluation.h"
#include "newton/newton_data.h"
#include "force/force_data.h"
#include "contact/contact_data.h"
#include "network/network_data.h"
#include "beam/beam_data.h"
#include "friction/friction_data.h"
#include "tree/tree_data.h"
#include "integrate/integrate_data.h"
#include "fatigue/fatigue_data.h"
#include <stddef.h>

struct jo_data {
    jo_valid valid;
    jo_split split;

    /* the state, visible to the caller: one block of state_bytes that includes the history of methods */
    char *state;
    size_t state_bytes;
    jo_real time[1];
    jo_real *q, *v, *a, *lam;   /* (nq), (nv), (nv), (nrow) maximal coordinates, velocities, accelerations, multipliers */
    jo_real *x, *u, *ud;    /* (nx), (nu), (nu) joint coordinates, velocities, accelerations */
    jo_real *turn;          /* (nturn) last accepted values of the counted angles, rad */
    jo_real *input;         /* (ninput) */
    int *locked, *slip, *happened;   /* (nlock), (nfriction), (nevent) see jo_data_locked ... */
    jo_real *held;          /* (2 nlock) */
    jo_real *direction, *rub;   /* (2 nfriction) */
    double *memory;         /* (nmemory) */
    jo_real *contact_energy;   /* (jo_contact_energy_size) */
    jo_work work;           /* work since the start, J */
    jo_counts counts;
    int error_index;

    /* integrated quantities, and stages of a step: (nq) and (nw) */
    jo_real *y, *w, *wd;    /* integrated quantities: q, v, a or, in joint coordinates, x, u, ud */
    int ny, nw;             /* number of positions and of velocities; the latter include the states of forces, which come last */
    jo_real *q0, *v0, *dq, *dv, *rate;
    /* (nw) residual of Newton's method; in a Rosenbrock stage the argument of the damping, and dv that of the stiffness */
    jo_real *acc;

    /* results of the last evaluation */
    jo_work power;          /* rates, W */
    jo_real drive;          /* power of the drives, W, which power.forces includes */
    jo_work power0;         /* power at the start of the last step, W; jo_add_step_work adds half of its work */
    double waiting;         /* length of that step, s; 0 if its work is complete */
    jo_body_work *body;
    jo_marker_work *marker;
    jo_coordinate_work *coordinate;
    jo_joint_work *joint;
    jo_force_work *force;

    /* data of each folder of the engine; only files of the folder use the fields */
    jo_schur schur;
    jo_newton newton;
    jo_forces forces;
    jo_contacts contacts;
    jo_contact_sets contact_sets;
    jo_networks networks;
    jo_contact_record contact_record;
    jo_beams beams;
    jo_anderson friction;
    jo_tree tree;
    jo_control control;
    jo_adaptive adaptive;
    jo_alpha alpha;
    jo_events events;
    jo_instants run;
    jo_damage damage;
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

/* whether the event that deactivates a joint or a force has occurred; never for event -1 */
static inline int jo_released(const jo_data *d, int event) { return event >= 0 && d->happened[event] > 0; }

/* whether the rows of a joint are inactive: unlocked or released */
static inline int jo_absent(const jo_data *d, const jo_joint *k)
{
    return (k->lock >= 0 && !d->locked[k->lock]) || jo_released(d, k->release);
}

/* whether a model runs in hybrid mode, with bodies in maximal coordinates and trees */
static inline int jo_mixed(const jo_model *m) { return m->nlink && m->link->type == JO_LINK_BODY; }

/* whether a body in maximal coordinates carries trees */
static inline int jo_carries_trees(const jo_model *m, int body)
{
    for (int i = 0; i < m->nlink && jo_mixed(m); i++)
        if (m->link[i].parent >= 0 && m->link[m->link[i].parent].type == JO_LINK_BODY && m->link[m->link[i].parent].body == body) return 1;
    return 0;
}

#endif
