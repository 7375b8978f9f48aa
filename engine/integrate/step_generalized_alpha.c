/* step_generalized_alpha.c - generalised alpha (Chung and Hulbert 1993) on the Lie group of poses, with Newton's method.
 *
 * With the algorithmic acceleration a (Arnold and Bruels 2007; Bruels, Cardona and Arnold 2012)
 *   (1 - alpha_m) a1 + alpha_m a0 = (1 - alpha_f) v1' + alpha_f v0'
 *   q1 = q0 o exp(h v0 + h^2 ((1/2 - beta) a0 + beta a1)),  v1 = v0 + h ((1 - gamma) a0 + gamma a1)
 *   M v1' + Cq^T lam1 = Q at q1, v1, t1, and Cq v1 + Ct = 0 (index 2, projection) or C(q1) = 0 (index 3).
 * The multipliers of index 2 satisfy the velocity constraints; the positions, with residuals of O(h^3) per step,
 * are projected after the step in the norm of Newton's matrix, which does not excite stiff springs.
 * Newton's unknowns are changes of a1 and lam1; scaled so, no term of the matrix grows as the step shrinks
 * (Bottasso, Bauchau and Cardona 2007).
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "beam/beam.h"
#include "integrate/integrate.h"
#include "network/network.h"
#include "integrate/acceleration_size.h"
#include <string.h>

#define JO_SLOW_GAIN 0.1        /* ratio of successive increments above which stored factors are renewed */
/* rotation of a body, rad, since the computation of the factors, up to which they are used to close its joints */
#define JO_MAX_AGE 0.01
#define JO_ROUND_OFF_INCREMENT 1e-6   /* increment / reference below which an increment that does not shrink is round-off */
#define JO_STAGNATION 0.5       /* ratio of successive increments above which an increment counts as not shrinking */
#define JO_MAX_HALVINGS 40      /* halvings of an increment across a kink of a force law */
#define JO_DAMPED_ITERATIONS 5  /* limit of the iterations with shortened increments, relative to the normal limit */
#define JO_POSITION_ROUNDING 2.2e-15   /* rounding of positions / size of the mechanism: ten times DBL_EPSILON */
#define JO_STOPPING_SHARE2 1e-6 /* square of the weight (1e-3) in the reference of the accelerations that stop all bodies within one step */
#define JO_NEXT 1.5             /* time between two ends of steps over the step, above which the openings of valves are not compared */
#define JO_MIN_REDUCTION 0.5    /* ratio of successive residuals above which the joints are not corrected again */

#ifdef JO_COMPLEX
enum { JO_AFTER = 1 };    /* iterations after convergence: derivatives (imaginary parts) converge one iteration later */
enum { JO_KEEP = 0 };     /* no modified Newton method, since derivatives need the exact matrix */
enum { JO_LOOSE = 0 };    /* no limit by the error of the step, which does not bound the error of derivatives */
#else
enum { JO_AFTER = 0 };
enum { JO_KEEP = 1 };
enum { JO_LOOSE = 1 };
#endif

/* square of the reference of increments: accelerations without gravity, elastic forces, and a share of the accelerations that stop all
 * bodies within one step, v / h */
static double reference(const jo_model *m, const jo_data *d, double h)
{
    double sum = 0.0;
    for (int i = 0; i < m->nbody; i++) {
        const jo_body *b = &m->body[i];
        const jo_real *a = d->a + b->iv;
        sum += JO_STOPPING_SHARE2 / (h * h) * jo_acceleration_size(m, d, i, d->v + b->iv);
        for (int j = 0; j < 3; j++) {
            const double R = JO_RE(a[j] - m->gravity[j]), w = JO_RE(a[3 + j]);
            sum += JO_RE(b->mass[0]) * R * R + JO_RE(d->body[i].J[j]) * w * w;
        }
        for (int j = 0; j < b->n; j++) {
            const double f = JO_RE(b->K[j] * d->body[i].p[j]), a2 = JO_RE(a[6 + j]);
            sum += f * f + a2 * a2;
        }
    }
    return sum;
}

/* square of the increment of a body's acceleration that moves it by the rounding of positions, in the metric of the masses. Internal forces
 * K q have the rounding error K dq, which changes the solution of (M + q^ K) x = K dq by dq / q^ at most, q^ = weights.q, however stiff K
 * is. This is the only scale for a mechanism at rest without load, whose forces are 0. Smaller increments of an iteration with the exact
 * matrix do not change the positions. */
static double resolution(const jo_model *m, const jo_data *d, const jo_weights *c, int body)
{
    const jo_body *b = &m->body[body];
    const jo_real *R = d->q + b->iq, *J = d->body[body].J;
    const double digits = JO_POSITION_ROUNDING / c->q, square = m->size * m->size + JO_RE(jo_dot3(R, R));
    return digits * digits * (JO_RE(b->mass[0]) * square + JO_RE(J[0] + J[1] + J[2]));
}

/* first step, or step after a change of the state: consistent accelerations, and the algorithmic acceleration, an approximation of the
 * acceleration (alpha_m - alpha_f) h later (Arnold, Bruels and Cardona 2015) */
static int restart(const jo_model *m, jo_data *d, const jo_solver *s)
{
    const double shift = s->alpha_m - s->alpha_f, ahead = fabs(shift) * s->step;
    const jo_real t0 = d->time[0];
    jo_kinematics_used(d);
    int status = jo_evaluate(m, d, &jo_now);
    if (status != JO_OK) return status;
    d->power0 = d->power;
    for (int i = 0; i < m->nrow; i++) d->alpha.end_lam[i] = d->lam[i];
    for (int i = 0; i < d->nw; i++) {
        d->alpha.algorithmic[i] = d->alpha.end_a[i] = d->a[i];
        d->dq[i] = ahead * (d->v[i] + 0.5 * ahead * d->a[i]);
    }
    if (ahead == 0.0 || m->nbeam) return JO_OK;   /* an explicit move would strain stiff beams */
    for (int i = 0; i < m->nq; i++) d->q0[i] = d->q[i];
    for (int i = 0; i < d->nw; i++) {
        d->v0[i] = d->v[i];
        d->v[i] += ahead * d->a[i];
    }
    jo_add_increment(m, d->q, d->q0, d->dq);
    d->time[0] = t0 + ahead;
    status = jo_evaluate(m, d, &jo_now);
    d->time[0] = t0;
    /* motions much faster than the step respond to the explicit move with huge accelerations; then the move is omitted, which causes a
     * single error of second order */
    double change = 0.0, scale = 0.0;
    for (int i = 0; i < d->nw; i++) d->dq[i] = d->a[i] - d->alpha.end_a[i];
    for (int i = 0; i < m->nbody; i++) {
        change += jo_acceleration_size(m, d, i, d->dq + m->body[i].iv);
        scale += jo_acceleration_size(m, d, i, d->alpha.end_a + m->body[i].iv);
    }
    const double part = status == JO_OK && change < scale ? 1.0 : 0.0;
    for (int i = 0; i < m->nq; i++) d->q[i] = d->q0[i];
    for (int i = 0; i < d->nw; i++) {
        d->v[i] = d->v0[i];
        if (part > 0.0) d->alpha.algorithmic[i] += (shift < 0.0 ? -part : part) * d->dq[i];
    }
    return status == JO_BENT ? JO_OK : status;
}

static int factor_matrix(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    jo_alpha_tangents(m, d);
    int status = jo_newton_assemble(m, d, stage);
    if (status != JO_OK) return status;
    status = jo_newton_factor(m, d, m->redundant > 0);
    if (status == JO_SINGULAR_JOINT && m->redundant == 0) {   /* a singular position is accepted */
        d->counts.singular++;
        status = jo_newton_assemble(m, d, stage);
        if (status == JO_OK) status = jo_newton_factor(m, d, 1);
    }
    jo_newton_factored(d, status == JO_OK);
    d->alpha.aged = 0.0;
    return status;
}

/* d->newton.x = -[residual of the equations of motion in acc; C or C' of the joints] */
static void right_hand_side(const jo_model *m, jo_data *d, const jo_weights *c, int first)
{
    for (int i = 0; i < m->nbody; i++) {
        const jo_place *p = &m->place[i];
        jo_real *x = jo_newton_vector(d) + m->node[p->node].at + p->local;
        for (int j = 0; j < 6 + m->body[i].n; j++) x[j] = -d->acc[m->body[i].iv + j];
    }
    for (int i = 0; i < m->njoint; i++) {
        const jo_place *p = &m->place[m->nbody + i];
        const jo_joint_work *w = &d->joint[i];
        const jo_real *soft = jo_newton_regularisation(d) + m->joint[i].row;
        jo_real *x = jo_newton_vector(d) + m->node[p->node].at + p->local;
        for (int r = 0; r < m->joint[i].nrow; r++) {
            const jo_real lam = d->lam[m->joint[i].row + r];
            if (jo_absent(d, &m->joint[i])) x[r] = -lam;
            else {
                x[r] = -c->rows * (c->position ? w->c[r] : w->cdot[r]);
                if (first && jo_newton_soft(d)) x[r] += soft[r] * lam;   /* multipliers of least norm at every step */
            }
        }
    }
}

static jo_real *solution_of(const jo_model *m, jo_data *d, int item)
{
    return jo_newton_vector(d) + jo_newton_place(m, item);
}

/* Damping at kinks of force laws, where Newton's method alternates between branches. The last increment, of norm `size`, is halved until the
 * next simplified increment is shorter (natural monotonicity test: Deuflhard, Newton Methods for Nonlinear Problems, 2011, ch. 3).
 * Returns the remaining share; 0: none was found. */
static double shorten(const jo_model *m, jo_data *d, const jo_solver *s, const jo_stage *stage, double size)
{
    double share = 1.0;
    for (int i = 0; i < m->nv + m->nrow; i++) d->alpha.whole[i] = jo_newton_vector(d)[i];
    for (int k = 0; k < JO_MAX_HALVINGS; k++, share *= 0.5) {
        if (k) jo_alpha_add(m, d, &stage->weights, d->alpha.whole, -share);
        jo_alpha_update(m, d, s);
        d->counts.evaluations++;
        if (jo_residual_at(m, d, stage, d->acc) != JO_OK) continue;   /* no residual can be computed, as with a folded beam */
        right_hand_side(m, d, &stage->weights, 0);
        jo_newton_solve(m, d);
        double next = 0.0;
        for (int i = 0; i < m->nbody; i++) next += jo_acceleration_size(m, d, i, solution_of(m, d, i));
        if (sqrt(next) <= (1.0 - 0.5 * share) * size) return share;
    }
    return 0.0;
}

/* Newton's method for one step from q0, v0: accelerations in a, algorithmic accelerations in rate. Converged if the increment, or its
 * estimate by the rate of convergence, is below tolerance times reference, or if it is round-off, or if the increment is small beside the
 * error of the step and the next one, by the rate of convergence, far smaller; `close` is then 1: the last residual and power are as
 * accurate as the step. */
static int newton(const jo_model *m, jo_data *d, const jo_solver *s, const jo_stage *stage, int damped, int *close)
{
    const int most_iterations = (damped ? JO_DAMPED_ITERATIONS : 1) * s->iterations + JO_AFTER;
    double before = 0.0, elastic = INFINITY;   /* smallest beam forces of all iterates, since a single iterate may have too large ones */
    double limit = 0.0;   /* of increments, by the error of the step */
    int after = -1;
    for (int k = 0; k < most_iterations; k++) {
        jo_alpha_update(m, d, s);
        int status = jo_residual_at(m, d, stage, d->acc);
        if (status != JO_OK) return status;
        d->counts.evaluations++;
        const int renewed = !JO_KEEP || !s->modified || !jo_newton_valid(d);
        if (renewed) status = factor_matrix(m, d, stage);
        if (status == JO_NOT_FINITE) return JO_NO_CONVERGENCE;
        if (status != JO_OK) return status;
        right_hand_side(m, d, &stage->weights, k == 0);
        jo_newton_solve(m, d);
        d->counts.iterations++;
        double size = 0.0, most = -1.0;
        int rounding = renewed;   /* whether all increments are below the resolution of the positions */
        for (int i = 0; i < m->nbody; i++) {
            const double part = jo_acceleration_size(m, d, i, solution_of(m, d, i));
            size += part;
            if (rounding) rounding = part <= resolution(m, d, &stage->weights, i);
            if (!(part <= most)) { most = part; d->error_index = i; }
        }
        jo_alpha_add(m, d, &stage->weights, jo_newton_vector(d), 1.0);
        size = sqrt(size);
        if (!isfinite(size)) return JO_NO_CONVERGENCE;
        if (JO_LOOSE && k == 0 && !damped) limit = jo_iteration_limit(m, d, s);
        const double gain = before > 0.0 ? size / before : 1.0;
        *close = k && size <= limit && size * gain <= JO_SLOW_GAIN * (1.0 - gain) * limit && limit > 0.0;
        if (*close) return JO_OK;
        double beam_forces = 0.0;
        if (m->nbeam) beam_forces = jo_beam_force_norm(d);
        if (beam_forces < elastic) elastic = beam_forces;
        const double work = sqrt(reference(m, d, s->step) + elastic), small = s->tolerance * work;
        if (s->tolerance <= 0.0) {   /* a fixed number of iterations */
            if (k + 1 == s->iterations) return JO_OK;
            continue;
        }
        if (after >= 0 || size <= small || rounding || (k && gain < 1.0 && size * gain / (1.0 - gain) <= small)
            || (k > 1 && renewed && gain > JO_STAGNATION && size <= JO_ROUND_OFF_INCREMENT * work)) {
            if (++after == JO_AFTER) return JO_OK;
        }
        if (s->modified && !renewed && k && gain > JO_SLOW_GAIN) jo_newton_outdated(d);
        before = size;
        if (damped && after < 0) {
            const double share = shorten(m, d, s, stage, size);
            if (share == 0.0) return JO_NO_CONVERGENCE;
            if (share < 1.0) before = 0.0;   /* the ratio of a shortened increment does not measure the rate of convergence */
        }
    }
    return JO_NO_CONVERGENCE;
}

/* d->newton.x = -[0; c], or cdot if `velocity` */
static void set_residuals(const jo_model *m, jo_data *d, int velocity)
{
    for (int i = 0; i < m->nbody; i++) {
        jo_real *x = solution_of(m, d, i);
        for (int j = 0; j < 6 + m->body[i].n; j++) x[j] = 0.0;
    }
    for (int i = 0; i < m->njoint; i++) {
        jo_real *x = solution_of(m, d, m->nbody + i);
        for (int r = 0; r < m->joint[i].nrow; r++) x[r] = velocity ? -d->joint[i].cdot[r] : -d->joint[i].c[r];
    }
}

/* q = q o x or v += x with x = N^-1 d->newton.x */
static void correct(const jo_model *m, jo_data *d, int velocity)
{
    jo_newton_solve(m, d);
    for (int i = 0; i < m->nbody; i++) {
        const jo_real *x = solution_of(m, d, i);
        jo_real *y = (velocity ? d->v : d->rate) + m->body[i].iv;
        for (int j = 0; j < 6 + m->body[i].n; j++) y[j] = (velocity ? y[j] : 0.0) + x[j];
    }
    if (!velocity) jo_add_increment(m, d->q, d->q, d->rate);
}

/* Projection of positions, then velocities, with factors of this or a nearby state. Factors of an older state also move the mechanism along
 * its free directions, in proportion to the rotation since then, and these errors accumulate. With redundant rows the matrix is
 * nearly singular in some directions: only factors of this state are used. */
static int close_joints(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    enum { JO_MAX_CORRECTIONS = 10 };   /* of positions and of velocities */
    const double small[2] = {JO_CLOSED * m->size, JO_CLOSED * jo_most(jo_speed(m, d))};
    jo_real largest[2];
    for (int velocity = 0; velocity < 2; velocity++) {
        double before = 0.0;
        for (int k = 0; k < JO_MAX_CORRECTIONS; k++) {
            if (k || velocity) jo_residuals(m, d, largest);
            else largest[0] = jo_largest_residual(m, d);   /* velocities are not needed */
            const double residual = JO_RE(largest[velocity]);
            if (residual <= small[velocity] || (k && !(residual < JO_MIN_REDUCTION * before))) break;
            if (d->alpha.aged > (jo_newton_soft(d) ? 0.0 : JO_MAX_AGE)) {   /* new factors that are used for the projection only */
                const int status = factor_matrix(m, d, stage);
                if (status != JO_OK) return status;
            }
            set_residuals(m, d, velocity);
            before = residual;
            correct(m, d, velocity);
        }
    }
    return JO_OK;
}

/* whether sensors read what an evaluation of the forces leaves */
static int forces_read(const jo_model *m)
{
    for (int i = 0; i < m->nsensor; i++)
        switch (m->sensor[i].type) {
        case JO_SENSOR_ELEMENT: case JO_SENSOR_FRICTION: case JO_SENSOR_SECTION: case JO_SENSOR_BODY_LOAD: case JO_SENSOR_MODAL_LOAD:
        case JO_SENSOR_CONTACT: return 1;
        default: break;
        }
    return 0;
}

/* work of the step by the trapezoidal rule, with forces and multipliers at its start and end; close: the power is that of the last
 * iteration, and only the motion of bodies and markers is computed */
static int finish_work(const jo_model *m, jo_data *d, double h, int close)
{
    if (!close) {
        const int status = jo_residual(m, d, d->acc);
        if (status != JO_OK) return status;
        d->counts.evaluations++;
    } else {
        jo_real unused[2];
        jo_residuals(m, d, unused);
    }
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) d->joint[i].x[r] = d->lam[m->joint[i].row + r];
    d->power.forces += m->nline ? jo_joint_power(m, d) : 0.0;
    for (int i = 0; i < m->nfriction; i++) {
        const int coordinate[2] = {m->friction[i].coordinate, m->friction[i].other};
        for (int k = 0; k < 2; k++)
            if (coordinate[k] >= 0) d->power.friction -= d->rub[2 * i + k] * d->coordinate[coordinate[k]].rate;
    }
    jo_add_work(&d->power0, 1.0, &d->power);
    jo_add_work(&d->work, 0.5 * h, &d->power0);
    d->power0 = d->power;
    return JO_OK;
}

/* largest angular velocity of the bodies, rad/s */
static double fastest_turn(const jo_model *m, const jo_data *d)
{
    double square = 0.0;
    for (int i = 0; i < m->nbody; i++) {
        const jo_real *w = d->v + m->body[i].iv + 3;
        square = jo_larger(square, JO_RE(jo_dot3(w, w)));
    }
    return sqrt(square);
}

/* end of a step whose iteration has converged: state, history, work, projection */
static int accept(const jo_model *m, jo_data *d, const jo_solver *s, const jo_stage *stage, int close)
{
    int status = JO_OK;
    jo_alpha_update(m, d, s);
    if (m->nstate) {
        status = jo_residual_at(m, d, stage, d->acc);   /* states of the forces after the last increment */
        jo_networks_note_openings(d, JO_NEXT * s->step);
    }
    jo_iteration_limit_update(m, d, s);
    memcpy(d->alpha.algorithmic, d->rate, (size_t)d->nw * sizeof(jo_real));
    memcpy(d->alpha.end_a, d->a, (size_t)d->nw * sizeof(jo_real));
    for (int i = 0; i < m->nrow; i++) d->alpha.end_lam[i] = d->lam[i];
    if (status == JO_OK) status = finish_work(m, d, s->step, close);
    if (status == JO_OK && s->projection && m->njoint) status = close_joints(m, d, stage);
    if (status == JO_OK && close && d->alpha.forces_read) {   /* the motion is the same with and without sensors: so is its work */
        const jo_work power = d->power;
        status = jo_residual(m, d, d->acc);
        d->power = power;
    }
    return status;
}

static int step(const jo_model *m, jo_data *d, const jo_solver *s, int *steady)
{
    const double h = s->step, am = s->alpha_m, af = s->alpha_f, g = s->newmark_gamma, b = s->newmark_beta;
    const jo_weights old = d->alpha.weights;
    const jo_weights weights = {(1.0 - am) / (1.0 - af), g * h, b * h * h, 1.0 / (s->projection ? g * h : b * h * h),
                                !s->projection, s->plain_inertia};
    *steady = jo_alpha_continues(m, d, h) && old.v == weights.v;
    if (!jo_alpha_continues(m, d, h)) {
        jo_history_begins(d);
        jo_iteration_limit_forget(d);
        d->alpha.forces_read = forces_read(m);
        const int status = restart(m, d, s);
        if (status != JO_OK) return status;
        if (m->nstate) jo_networks_note_openings(d, 0.0);
    }
    if (old.a != weights.a || old.v != weights.v || old.q != weights.q || old.position != weights.position
        || old.plain != weights.plain) jo_newton_outdated(d);
    d->alpha.weights = weights;
    const jo_stage stage = {.weights = weights};
    const jo_real t0 = d->time[0];
    memcpy(d->q0, d->q, (size_t)m->nq * sizeof(jo_real));
    memcpy(d->v0, d->v, (size_t)d->nw * sizeof(jo_real));
    d->time[0] = t0 + h;
    d->alpha.aged += h * fastest_turn(m, d);
    jo_alpha_predict(m, d, s, JO_LOOSE ? jo_iteration_ahead(m, d, s) : 0.0);
    const long long passed = d->counts.singular;
    int close = 0, status = newton(m, d, s, &stage, 0, &close);
    /* without convergence: repeat with new factors in every iteration, then with shortened increments (kinks) */
    const int tries = s->tolerance > 0.0 ? 2 : 1;
    for (int damped = !s->modified; status != JO_OK && damped < tries; damped++) {
        jo_solver exact = *s;
        exact.modified = 0;
        jo_newton_outdated(d);
        d->counts.singular = passed;   /* positions of the failed attempt are not counted */
        jo_alpha_predict(m, d, s, 0.0);
        status = newton(m, d, &exact, &stage, damped, &close);
    }
    if (status == JO_OK) status = accept(m, d, s, &stage, close);
    if (status != JO_OK) {   /* on failure restore the state at the start of the step */
        for (int i = 0; i < m->nq; i++) d->q[i] = d->q0[i];
        for (int i = 0; i < d->nw; i++) d->v[i] = d->v0[i];
        d->time[0] = t0;
        jo_history_lost(d);
        return status;
    }
    memcpy(d->alpha.end_q, d->q, (size_t)m->nq * sizeof(jo_real));
    memcpy(d->alpha.end_v, d->v, (size_t)d->nw * sizeof(jo_real));
    *d->alpha.end_time = d->time[0];
    jo_history_written(d);
    return JO_OK;
}

/* a and lam at the end are the results of the step, unless multipliers of least norm are needed; or the step begins a history or has
 * another length than the one before, so that its lam has an error of first order, since the algorithmic acceleration is that of another
 * instant, or of third order / h, since the positions were projected before it */
int jo_step_alpha(const jo_model *m, jo_data *d, const jo_solver *s)
{
    int steady = 0;
    const int status = step(m, d, s, &steady);
    jo_state_changed(d);
    jo_accelerations_found(d, status == JO_OK && m->redundant <= 0 && steady);
    return status;
}
