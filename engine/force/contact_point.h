/* contact_point.h - one point at which two bodies touch: its motion, its force and its states, and how these change. */
#ifndef JO_CONTACT_POINT_H
#define JO_CONTACT_POINT_H

#include "force/force.h"
#include "contact/contact.h"

/* States of a point: phase, speed of approach v_in at the touch, m/s, time of the touch, s, stretch s of the bristle, m. */
enum { JO_CONTACT_PHASE, JO_CONTACT_SPEED, JO_CONTACT_SINCE, JO_CONTACT_STRETCH, JO_CONTACT_STATES = JO_CONTACT_STRETCH + 3 };
/* opens: apart after an impulse that came when it overlapped, by the resolution of an instant, and not yet open; glides: touches without friction,
 * in reports alone */
enum { JO_CONTACT_APART, JO_CONTACT_STICKS, JO_CONTACT_SLIPS, JO_CONTACT_EASED, JO_CONTACT_OPENS, JO_CONTACT_GLIDES };

#define JO_CONTACT_STABLE 0.5   /* step of an explicit method times the rate of a contact */

/* Forces without loss over the depth: K d^n; parallel cylinders by Johnson; a table; the impedance of robot files */
enum { JO_CURVE_POWER, JO_CURVE_LINE, JO_CURVE_TABLE, JO_CURVE_IMPEDANCE };

/* The numbers of the law, with which the data of every kind of contact begin. */
typedef struct { jo_real JO_CONTACT_LAW, JO_TOUCH_LAW; } jo_contact_law;

/* A point at the present positions and velocities, resolved in a. */
typedef struct {
    jo_real normal[3];              /* n, outward normal of a */
    jo_real depth, rate;            /* d, d' */
    jo_real lever[3];               /* from the origin of b */
    jo_real w[3], v[3], slip[3];    /* relative angular velocity; velocity of b on a there, and its part in the contact plane */
    jo_real stretch[3];             /* s in the contact plane */
    jo_real elastic, slope, bend, energy;   /* force without loss, such as K d^n, its first two derivatives, and its integral over the depth */
    jo_real lag, lag_rate;          /* (u / v_in) times this force, or the damper of a contact at rest, N s/m, and its derivative with respect to d */
    jo_real N, by_depth, by_rate;   /* normal force and its derivatives */
    jo_real shear, shear_rate;      /* k_t and its derivative with respect to d */
    jo_real loss;                   /* c_t */
    jo_real force[3], size;         /* force of the bristle before its limit: -(k_t s + c_t v_t), and its length */
} jo_contact_point;

/* Changes of a point with one of [position, rotation, velocity, angular velocity] of b against a. */
typedef struct { jo_real depth, rate, normal[3], lever[3], slip[3]; } jo_contact_change;

static inline jo_real jo_length3(const jo_real *x)
{
    const jo_real square = jo_dot3(x, x);
    return JO_RE(square) > 0.0 ? jo_sqrt(square) : 0.0;
}

/* x^y, x > 0 */
static inline jo_real jo_raised(jo_real x, jo_real y)
{
    if (JO_RE(y) == 1.0) return x;
    if (JO_RE(y) == 2.0) return x * x;
    if (JO_RE(y) == 1.5) return x * jo_sqrt(x);
#ifdef JO_COMPLEX
    return cpow(x, y);
#else
    return pow(x, y);
#endif
}

static inline const jo_contact_law *jo_contact_law_of(const jo_force *f) { return (const jo_contact_law *)f->data; }
static inline int jo_contact_opens(const jo_real *state) { return (int)JO_RE(state[JO_CONTACT_PHASE]) == JO_CONTACT_OPENS; }
static inline int jo_contact_phase(const jo_real *state) { return jo_contact_opens(state) ? JO_CONTACT_APART : (int)JO_RE(state[JO_CONTACT_PHASE]); }
static inline int jo_contact_follows(int phase) { return phase == JO_CONTACT_STICKS || phase == JO_CONTACT_EASED; }   /* whether the bristle moves within a step */

/* Smallest and largest components of the velocity v of the point of jo_approach in the stages of a step so far, of an open gap with this first
 * state, which has at least 6 states. */
static inline void jo_see_speed(jo_data *d, int first, const jo_real *v)
{
    double *low = d->forces.seen + first, *high = low + 3;
    for (int i = 0; i < 3; i++) {
        low[i] = fmin(low[i], JO_RE(v[i]));
        high[i] = fmax(high[i], JO_RE(v[i]));
    }
}

/* contact_motion.c */
void jo_contact_slide(jo_contact_point *y);   /* d' and slip; v is the velocity of the origin of b before it */
void jo_contact_rates(const jo_contact_point *y, int k, jo_contact_change *c);   /* changes of d' and slip, after those of position */

/* contact_curve.c */
void jo_contact_curve(const jo_contact_law *x, jo_contact_point *y);   /* elastic, slope, bend and energy of a curve other than K d^n */

/* contact_slip.c */
/* friction -g(|v|) N v of the regularised law; g in N s/m per N of the normal force */
jo_real jo_contact_smooth(const jo_contact_law *x, jo_real square);
void jo_contact_smooth_change(const jo_contact_law *x, const jo_contact_point *y, const jo_real *dv, jo_real dN, jo_real *dF);
static inline int jo_contact_is_smooth(const jo_contact_law *x) { return JO_RE(x->velocity) > 0.0; }

/* contact_law.c */
jo_real jo_contact_speed_of_depth(const jo_contact_law *x, jo_real depth);   /* of approach, m/s */
double jo_contact_lasts(const jo_contact_law *x, double speed);     /* duration of a touch without loss from this speed of approach, s */
void jo_contact_press(const jo_contact_law *x, const jo_real *state, jo_contact_point *y);
void jo_contact_stretched(const jo_real *s, jo_contact_point *y);
jo_real jo_contact_energy(int phase, const jo_contact_point *y);
jo_real jo_contact_growth(const jo_contact_point *y);
/* force and torque F (6) on b about its origin; adds the dissipated power */
void jo_contact_force(const jo_contact_law *x, int phase, const jo_contact_point *y, jo_real *F, jo_work *power);
/* change dF (3) of the force with the changes c of the point and ds of its stretch */
void jo_contact_force_change(const jo_contact_law *x, int phase, const jo_contact_point *y, const jo_contact_change *c, const jo_real *ds, jo_real *dF);
/* change dF (6) of F with the k-th motion of b, which changes the point by c */
void jo_contact_response(const jo_contact_law *x, const jo_stage *stage, const jo_real *state, const jo_contact_point *y, const jo_contact_change *c,
                         int k, const jo_real *F, jo_real *dF);

/* contact_touch.c: the point is at origin + A lever, A (3 x 3): its axes in the world; adds to the sums */
void jo_contact_touch(const jo_real *A, const jo_real *origin, const jo_contact_law *x, const jo_real *state, const jo_contact_point *y, jo_touch *t,
                      jo_real *sums);

/* contact_implicit.c: moves (6): changes of the point with the position and with the velocity of b; `state`: its first one */
void jo_contact_implicit(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, int state, const jo_contact_point *y,
                         const jo_contact_change *moves);

/* contact_phase.c: `state` are those of a point */
void jo_contact_start(const jo_contact_law *x, jo_real time, jo_contact_point *y, jo_real *state);
void jo_contact_move_states(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_contact_law *x, int state, jo_contact_point *y);
void jo_contact_hold_states(const jo_model *m, jo_data *d, const jo_stage *stage, int first, int count);   /* constant within a step */
/* returns the energy that it dissipates; waits: whether a touch does not begin here, see jo_touches_wait */
jo_real jo_contact_update(const jo_contact_law *x, int waits, jo_real time, jo_contact_point *y, jo_real *state);
jo_real jo_contact_margin(const jo_contact_law *x, const jo_real *state, const jo_contact_point *y);   /* < 0: the phase has ended */
/* y: needed for explicit methods and smooth friction */
double jo_contact_longest_step(const jo_contact_law *x, const jo_real *state, jo_real time, int explicit_method, const jo_contact_point *y);
int jo_contact_ease(jo_real *state);
void jo_contact_begun(const jo_data *d, const jo_contact_law *x, int first, const jo_real *state);   /* notes a touch that has begun */

/* contact_strike.c */
#define JO_CONTACT_SOON 1e-9    /* time, s, within which a gap may close for its point to be listed */
int jo_contact_may_strike(const jo_contact_law *x);
/* the point with the first state `first` of f as one that strikes or is closed; returns their number, 0 or 1 */
int jo_contact_strike(const jo_contact_law *x, int waits, const jo_force *f, int first, const jo_real *state, const jo_contact_point *y, struct jo_strike *s);

#endif
