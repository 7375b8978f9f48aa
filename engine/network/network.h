/* network.h - networks of first-order states x' = f(t, s, s', x): functions for other rooms. */
#ifndef JO_NETWORK_H
#define JO_NETWORK_H

#include "arena.h"
#include "data.h"

/* x' = f(t, s, s', x) of the states x (n) and coordinates s (m) of a force of the kind "network", with forces F along s */
typedef struct jo_network {
    int force;              /* in m->force */
    int n, m;               /* states, coordinates */
    int values, instructions, registers;   /* instructions for values, and with those for derivatives */
    int nsignal, npush, nslope, fixed;     /* fixed: constant registers */
    int outside;                /* whether an argument lies beyond a table at whose ends the run shall end */
    int memories;               /* values that are constant within a step, see force_memory.c */
    int gravity;                /* 3 where something depends on the acceleration of free fall, else 0 */
    int *memory;                /* (memories) their places among the states of all forces */
    int timed;              /* whether forces depend on time or signals */
    int nopening, *opening; /* openings of valves that pressures open, and their registers */
    jo_real *before;        /* (nopening) when last noted */
    double *most, last;     /* (2 x nopening) largest change and its time; time when last noted */
    int computed;           /* results in the registers: 1 of values, 2 also of derivatives */
    int *coordinate, *signal;   /* (m), (nsignal) */
    int *code;              /* (4 x instructions) operation and operands, see network_program.c */
    int *rate, *push, *slope;   /* (n) register of x'; (2 x npush) coordinate, register; (3 x nslope) row, column, register */
    jo_real *r;             /* (registers): constants, x, s, s', time, signals and their rates, memories, gravity, results of instructions */
    jo_real *S;             /* (n + m) x (n + 2 m): derivatives of x' and F with respect to x, s, s' */
    jo_real *A;             /* (n x n) factors of 1 - g h f_x or of ca - cv f_x */
    int *pivot;             /* (n) */
    jo_real *K, *D, *G;     /* (m x m) -dF/ds, -dF/ds' with the response of x, and g h D + (g h)^2 K */
    jo_real *u, *w, *y, *F; /* (m): arguments of K and D in a stage, work */
    jo_real *k, *z;         /* (n): sum s_ij x_j' of the earlier stages, work */
    int *at, *count;        /* (2 m) first of the velocities of each side on which s' depends, and their number */
    jo_real **J;            /* (2 m) derivatives of s' with respect to these */
    int *link;              /* (2 m) links of the sides in joint coordinates; -1: ground */
} jo_network;

static inline int jo_network_count(const jo_data *d) { return d->networks.count; }
static inline jo_network *jo_network_at(const jo_data *d, int i) { return &d->networks.list[i]; }

/* network_layout.c */
int jo_is_network(const jo_force *f);
jo_network *jo_network_of_memory(const jo_data *d, const jo_force *f);   /* 0: the force is no memory and no delay */
void jo_network_coordinates(const jo_model *m, jo_data *d, const jo_network *w);   /* values and rates at the present state */
int jo_network_rows(const jo_model *m);   /* coordinates of all networks */
int jo_network_coordinate(const jo_force *f, int k);   /* the k-th coordinate of a network; -1 beyond the last one */
void jo_networks_layout(const jo_model *m, jo_data *d, jo_arena *a);
void jo_networks_setup(const jo_model *m, jo_data *d);
jo_network *jo_network_of(const jo_data *d, const jo_force *f);
const jo_real *jo_network_starts(const jo_force *f);   /* (2 n) initial and nominal values of the states */

/* network_table.c */
/* value or derivative of a table t at x (and y) as z; returns whether it lies beyond a table at whose ends the run shall end */
int jo_network_table(int operation, const jo_real *t, jo_real x, jo_real y, jo_real *z);

/* network_program.c */
/* registers at the present coordinates and states, with signals at time + lead; derivatives also: those of the table S */
void jo_network_evaluate(const jo_model *m, const jo_data *d, jo_network *w, const jo_real *x, double lead, int derivatives);
/* openings in the registers, and their change since the last call if that is less than `longest` ago, s */
void jo_network_note_openings(const jo_data *d, double longest, jo_network *w);
void jo_networks_note_openings(const jo_data *d, double longest);   /* of all networks */
void jo_network_factor(jo_real *A, int n, int *pivot);   /* LU by rows, with row exchanges */
void jo_network_solve(const jo_real *A, int n, const int *pivot, jo_real *x);
void jo_network_response(jo_network *w, double ca, double cv);   /* factors of ca - cv f_x; K and D with this response */

jo_real jo_network_value(const jo_model *m, const jo_data *d, int network, int number);   /* a register at the present state */

/* network_matrix.c */
void jo_network_implicit(const jo_model *m, jo_data *d, const jo_stage *stage, jo_network *w);   /* force F of a stage of a Rosenbrock method */
void jo_networks_carry(const jo_model *m, jo_data *d);
void jo_networks_state_rates(const jo_model *m, jo_data *d, const jo_stage *stage);
void jo_networks_add_to_newton(const jo_model *m, jo_data *d);
void jo_networks_subtract(const jo_model *m, jo_data *d, const jo_real *a);
int jo_network_body(const jo_model *m, const jo_network *w, int side);   /* body of side 2 k or 2 k + 1 of coordinate k; -1: ground */
void jo_network_rates_along(const jo_network *w, const jo_real *z, jo_real *y);   /* y (m) = J z */

/* network_response.c */
int jo_networks_separate(const jo_model *m, const jo_data *d);   /* whether jo_networks_respond accounts for them, not Newton's matrix */
void jo_networks_respond(const jo_model *m, jo_data *d, const jo_stage *stage);   /* accelerations and multipliers with J^T G J */

#endif
