/* contact_turn.h - moments that resist rolling and drilling at a point of contact, and their states. */
#ifndef JO_CONTACT_TURN_H
#define JO_CONTACT_TURN_H

#include "force/contact_point.h"

/* contact_turn.c: `state`: the first one of a point, after whose states is the stretch t of the bristle of turning, rad, in frame a; y after
 * jo_contact_press */
jo_real jo_turn_energy(const jo_contact_data *x, const jo_real *state, const jo_contact_point *y);
void jo_turn_moment(const jo_contact_data *x, const jo_real *state, const jo_contact_point *y, jo_real *M, jo_work *power);   /* adds M (3) on b */
/* change dM (3) with the k-th motion of b, which changes the point by c; adds */
void jo_turn_response(const jo_contact_data *x, const jo_stage *stage, const jo_real *state, const jo_contact_point *y, const jo_contact_change *c,
                      int k, jo_real *dM);
void jo_turn_move_states(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_contact_point *y);
void jo_turn_start(const jo_contact_data *x, const jo_contact_point *y, jo_real *state);   /* as the contact begins */
void jo_turn_update(const jo_contact_data *x, const jo_contact_point *y, jo_real *state);   /* at the end of a step */
double jo_turn_rate(const jo_contact_data *x, const jo_contact_point *y);   /* 1/s, of the step of an explicit method */
void jo_turn_implicit(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_contact_point *y);
void jo_turn_touch(const jo_contact_data *x, const jo_real *state, const jo_contact_point *y, jo_touch *t, jo_real *sums);

#endif
