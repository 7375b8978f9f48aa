/* force_data.h - values of signals and forces, and derivatives of states of forces. */
#ifndef JO_FORCE_DATA_H
#define JO_FORCE_DATA_H

typedef struct {
    struct jo_slopes_of_state *slopes;   /* (nstate) that a Rosenbrock method has in its matrix */
} jo_forces;

#endif
