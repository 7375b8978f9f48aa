/* force_data.h - values of signals and forces, and derivatives of states of forces. */
#ifndef JO_FORCE_DATA_H
#define JO_FORCE_DATA_H

typedef struct {
    int nstate;             /* states of all forces, as in the model */
    int *yielding;          /* (nyielding) forces that yield */
    int following, *follower;   /* (nyielding) of these, the forces with a second update */
    jo_real *next;          /* states of one of them after an update */
    double *seen;           /* (nstate) velocities of open gaps in the stages of a step, see jo_see_speed */
    struct jo_slopes_of_state *slopes;   /* (nstate) derivatives of states in a Rosenbrock method's matrix */
} jo_forces;

#endif
