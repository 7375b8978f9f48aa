/* element.h - a joint or force between two markers a, b, differentiated for Newton's matrix.
 *
 * It pushes with y = [F_a, T_a, F_b, T_b] (world); Y holds the derivatives of y with respect to the changes
 * [dr, dphi, dv, dom] of a, then of b.
 */
#ifndef JO_ELEMENT_H
#define JO_ELEMENT_H

#include "internal.h"

typedef struct {
    int a, b;               /* markers, a may be -1 */
    jo_real y[12];
    jo_real Y[12][24];
} jo_element;

enum { JO_DR = 0, JO_DPHI = 3, JO_DV = 6, JO_DOM = 9, JO_OF_B = 12 };

/* Gradients of a coordinate and of its rate with respect to all 24 changes, and those of the gradient itself, G[0..2] along,
 * G[3..5] turn_a, G[6..8] turn_b, with respect to [r_b - r_a, phi_a, phi_b]. */
typedef struct { jo_real s[24], rate[24], G[9][9]; } jo_gradients;

/* x = column i of A */
static inline void jo_axis(jo_real *x, const jo_real *A, int i) { x[0] = A[i]; x[1] = A[3 + i]; x[2] = A[6 + i]; }

void jo_element_start(jo_element *e, int a, int b);
void jo_element_skew(jo_element *e, int i, int j, jo_real s, const jo_real *a);   /* rows i.., columns j.. += s a~ */
void jo_element_finish(const jo_model *m, jo_data *d, const jo_element *e);   /* into the matrix */
void jo_element_gradients(const jo_model *m, const jo_data *d, int coordinate, jo_gradients *g);
/* a force f along the coordinate, with its derivatives with respect to s and s' */
void jo_element_along(const jo_data *d, jo_element *e, int coordinate, const jo_gradients *g, jo_real f, jo_real fs,
                      jo_real frate);

#endif
