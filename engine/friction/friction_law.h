/* friction_law.h - normal force and slip of a friction, for the files of this folder. */
#ifndef JO_FRICTION_LAW_H
#define JO_FRICTION_LAW_H

#include "friction/friction.h"

#define JO_REST 1e-10   /* ratio of slip speed and scale of the slip, 1/s, below which a joint is at rest */
#define JO_RADII 100.0  /* scale of the slip of a pin over its radius, at most: rates above 1e-8 rad/s are no rest, however thin the pin is */

#define JO_OVERLOAD 1e-9    /* excess of the holding force, relative to the static friction, that counts as round-off */

static inline int jo_slip_turns(const jo_model *m, const jo_friction *f, int k)
{
    return m->coordinate[jo_slip_of(f, k)].type == JO_COORDINATE_ANGLE;
}

/* slip per unit of the coordinate: pin radius, m, for angles, else 1 */
static inline jo_real jo_slip_arm(const jo_model *m, const jo_friction *f, int k)
{
    return jo_slip_turns(m, f, k) ? f->data->radius : 1.0;
}

/* scale of the slip, m: size of the mechanism, at most JO_RADII radii of a pin that only turns */
static inline double jo_slip_scale(const jo_model *m, const jo_friction *f)
{
    const int pin = jo_slips(f) == 1 && jo_slip_turns(m, f, 0);
    return pin && JO_RADII * JO_RE(f->data->radius) < m->size ? JO_RADII * JO_RE(f->data->radius) : m->size;
}

static inline jo_real jo_length2(jo_real x, jo_real y)
{
    const jo_real square = x * x + y * y;
    return JO_RE(square) > 0.0 ? jo_sqrt(square) : 0.0;
}

/* normal force N = preload + |F_xy| + |M_xy| / bearing (+ |M_z| / collar), of a disc on a plane preload + |F_z|, from the reaction y in the axes of side 0, and torque of a thrust
 * collar, collar |F_z|, N m */
static inline jo_real jo_friction_normal_force(const jo_model *m, const jo_friction *f, const jo_real *y, jo_real *collar)
{
    const jo_friction_data *data = f->data;
    const jo_real *M = y + 3;
    *collar = 0.0;
    if (JO_RE(data->plane) > 0.0) return jo_size(y[2]) + data->preload;
    jo_real N = jo_length2(y[0], y[1]) + data->preload;
    if (JO_RE(data->bearing) > 0.0) N += jo_length2(M[0], M[1]) / data->bearing;
    if (JO_RE(data->collar) > 0.0) {
        if (jo_slip_turns(m, f, 0)) *collar = data->collar * jo_size(y[2]);
        else N += jo_size(M[2]) / data->collar;
    }
    return N;
}

/* friction.c */
void jo_friction_slip(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *s);   /* slip velocity (2), m/s */
void jo_friction_direction(const jo_model *m, const jo_data *d, int i, jo_real *e);
/* friction forces (2) per normal force and per torque of the collar; returns whether any is not 0 */
int jo_friction_weights(const jo_model *m, const jo_data *d, int i, jo_real *press, jo_real *collar);
void jo_friction_reaction(const jo_model *m, const jo_data *d, const jo_friction *f, const jo_real *lam, jo_real *y);   /* axes of side 0 */
void jo_friction_joint_reaction(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *y);   /* last evaluation */
void jo_friction_sticking_force(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *y);   /* static friction */

void jo_friction_sliding_force(const jo_model *m, const jo_data *d, int i, jo_real *y);   /* along the coordinates; 0 if it sticks */

/* friction_margin.c */
void jo_friction_let_go(const jo_model *m, jo_data *d, int i);

/* friction_switch.c */
void jo_friction_start_sliding(const jo_model *m, jo_data *d, int i);
void jo_friction_hold(const jo_model *m, jo_data *d, int i);
void jo_friction_start_sticking(const jo_model *m, jo_data *d, int i);
double jo_friction_overload(const jo_model *m, const jo_data *d, int i);
int jo_friction_accelerated_back(const jo_model *m, const jo_data *d, int i);

#endif
