/* newton.h - Newton's matrix of the implicit methods: residual, tangents, assembly, factors, coupled masses; functions for other rooms. */
#ifndef JO_NEWTON_H
#define JO_NEWTON_H

#include "arena.h"
#include "data.h"

/* Joint or force element between two markers a, b with its derivatives for Newton's matrix: forces y = [F_a, T_a, F_b, T_b] (world) and
 * Y = dy / d[dr, dphi, dv, dom of a, the same of b]. */
typedef struct {
    int a, b;               /* markers; a -1: none */
    int of_a, of_b;         /* markers whose motion the columns of Y are: a, b but for jo_element_cross */
    jo_real y[12];
    jo_real Y[12][24];
} jo_element;

enum { JO_DR = 0, JO_DPHI = 3, JO_DV = 6, JO_DOM = 9, JO_OF_B = 12 };

/* Derivatives of a coordinate s and of its rate with respect to the 24 changes, and of the gradient [along, turn_a, turn_b] (rows of G)
 * with respect to [r_b - r_a, phi_a, phi_b]. */
typedef struct { jo_real s[24], rate[24], G[9][9]; } jo_gradients;

void jo_element_start(jo_element *e, int a, int b);
void jo_element_skew(jo_element *e, int i, int j, jo_real s, const jo_real *a);   /* Y(i.., j..) += s a~ */
void jo_element_finish(const jo_model *m, jo_data *d, const jo_element *e);   /* add to Newton's matrix */
void jo_element_gradients(const jo_model *m, const jo_data *d, int coordinate, jo_gradients *g);
/* force f along a coordinate, fs = df/ds, frate = df/ds' */
void jo_element_along(const jo_data *d, jo_element *e, int coordinate, const jo_gradients *g, jo_real f, jo_real fs,
                      jo_real frate);
/* slopes fs, frate of the force along a coordinate with respect to the value and rate, with gradients g, of a coordinate of the markers
 * of_a, of_b */
void jo_element_cross(const jo_data *d, jo_element *e, int coordinate, int of_a, int of_b, const jo_gradients *g, jo_real fs,
                      jo_real frate);

/* relative_motion_tangent.c: motion of b relative to a, resolved in a */
void jo_relative_pose(const jo_data *d, const jo_force *f, jo_real *r, jo_real *R);
void jo_relative_velocity(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *v, jo_real *w);
void jo_push_between(const jo_model *m, jo_data *d, const jo_force *f, const jo_real *y, jo_force_work *out);
void jo_newton_between(const jo_model *m, jo_data *d, const jo_force *f, const jo_real *y, jo_real (*X)[12]);

/* right-hand side and solution of jo_newton_solve: (nv + nrow), and the position of the unknowns of a body or joint in it */
static inline jo_real *jo_newton_vector(jo_data *d) { return d->newton.x; }
static inline int jo_newton_place(const jo_model *m, int item) { return m->node[m->place[item].node].at + m->place[item].local; }

/* regularisation of the rows of the joints, (nrow), which the last factorisation subtracted from the diagonal */
static inline const jo_real *jo_newton_regularisation(const jo_data *d) { return d->newton.soft; }

/* (6 x jo_pad(6 + n)) derivatives of [r, rotation] (world) of a marker with respect to the coordinates of its body, of jo_newton_marker */
static inline const jo_real *jo_marker_derivatives(const jo_data *d, int marker) { return d->newton.marker[marker].L; }

/* newton_blocks.c */
typedef struct { jo_real *at; int stride; } jo_block;
int jo_newton_branches(const jo_model *m);   /* number of all branches */
/* block with the rows of item x and the columns of item y (bodies, then joints); address 0 if it is structurally zero */
jo_block jo_newton_find(const jo_model *m, jo_data *d, int x, int y);
int jo_newton_couples(const jo_model *m, int x, int y);   /* whether there is such a block of two bodies */
void jo_newton_clear(const jo_model *m, jo_data *d);   /* N = 0 */
int jo_newton_fill_in(const jo_model *m, jo_data *d, int c);   /* number of branches of a node that are used, listed in newton.row; marks their fill-in */
static inline int jo_newton_empty(const jo_data *d, int branch) { return d->newton.sparse && !d->newton.used[branch]; }

/* newton_layout.c */
void jo_newton_layout(const jo_model *m, jo_data *d, jo_arena *a);

/* newton_factor.c */
int jo_newton_factor(const jo_model *m, jo_data *d, int redundant);

/* newton_solve.c */
void jo_newton_solve(const jo_model *m, jo_data *d);

/* newton_residual.c */
int jo_residual_at(const jo_model *m, jo_data *d, const jo_stage *stage, jo_real *r);   /* residual for the stage of an implicit method */
void jo_equations_residual(const jo_model *m, const jo_data *d, jo_real *r);   /* M a - [fr, fp] */
int jo_newton_centred(const jo_model *m, const jo_data *d, int body);   /* whether it is rigid, its mass centre at the origin of its frame */

/* body_tangent.c */
void jo_newton_body(const jo_model *m, jo_data *d, const jo_stage *stage, int body);

/* marker_tangent.c */
void jo_newton_marker(const jo_model *m, jo_data *d, const jo_stage *stage, int marker);
void jo_newton_stress(const jo_model *m, jo_data *d, const jo_stage *stage, int marker);   /* geometric stiffness of the loads on the marker */

/* joint_tangent.c */
void jo_newton_joint(const jo_model *m, jo_data *d, const jo_stage *stage, int joint);

/* newton_assemble.c */
int jo_newton_assemble(const jo_model *m, jo_data *d, const jo_stage *stage);   /* at the state of the last residual */
void jo_newton_masses(const jo_model *m, jo_data *d, const jo_stage *stage);    /* bodies and beams only */
void jo_newton_rows(const jo_model *m, jo_data *d, const jo_stage *stage);      /* joints only, without multipliers */

/* coupled_mass.c */
int jo_couples(const jo_model *m, const jo_stage *stage);   /* whether masses of bodies are coupled in a stage */
int jo_coupled_accelerations(const jo_model *m, jo_data *d, const jo_stage *stage);   /* a and joint[].x */
/* the accelerations from which jo_coupled_accelerations starts */
static inline const jo_real *jo_coupled_base(const jo_data *d) { return d->newton.base; }
/* later stages of a Rosenbrock step: beams lag by their stiffness times x and damping times z */
void jo_coupled_lag(const jo_model *m, jo_data *d, const jo_real *x, const jo_real *z);
/* the second stage of ROS2 starts from a and the present multipliers; beams lag by their stiffness times x and damping times z */
void jo_coupled_second(const jo_model *m, jo_data *d, const jo_real *a, const jo_real *x, const jo_real *z);
void jo_coupled_solve(const jo_model *m, jo_data *d, const jo_stage *stage);
void jo_coupled_respond(const jo_model *m, jo_data *d);   /* joint[].x: change of the multipliers by y, yp */
void jo_coupled_correction(const jo_model *m, jo_data *d, jo_real *increment);

#endif
