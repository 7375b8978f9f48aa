/* step_rosenbrock.c - one step of a Rosenbrock W-method, whose tableau is a row of JO_METHODS in jousto.h.
 *
 *   k_i = f(y + h sum_j<i a_ij k_j) + h A sum_j<=i g_ij k_j,   y + h sum_i b_i k_i
 * (Hairer, Wanner, Solving Ordinary Differential Equations II (1996), IV.7). A is not the Jacobian: of positions x and velocities v
 *   x' + g h A_x v',  M v' = Q - g h (K x' + D v')
 * it contains the stiffness K and damping D of modes, of beams and of forces along joint coordinates, and the mass M of the stage. The
 * masses M + g h D + (g h)^2 K therefore replace M. With the weights s_ij = g_ij / g, r_j the rates of the increments and v_j' of the
 * velocities in stage j
 *   (M + g h D + (g h)^2 K) v_i' = Q + g h K (-r_i - sum s_ij r_j - g h sum z_ij v_j') - g h D sum s_ij v_j',
 *   z_ij = 2 s_ij + sum_j<l<i s_il s_lj
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "contact/contact.h"
#include "network/network.h"
#include "integrate/integrate.h"

/* coefficients of the tableau in the form that a step needs */
typedef struct {
    double rate[JO_MOST_STAGES][JO_MOST_STAGES];           /* -s_ij */
    double acceleration[JO_MOST_STAGES][JO_MOST_STAGES];   /* -z_ij */
    double lead[JO_MOST_STAGES];                           /* sum_j g_ij over g */
} weights;

static JO_INLINE void weigh(const jo_tableau *t, weights *w)
{
    for (int i = 0; i < t->stages; i++) {
        const double *g = jo_tableau_implicit(t, i);
        w->lead[i] = 1.0;
        for (int j = i - 1; j >= 0; j--) {
            w->rate[i][j] = -g[j] / t->coefficient[0];
            w->lead[i] -= w->rate[i][j];
            w->acceleration[i][j] = 2.0 * w->rate[i][j];
            for (int l = j + 1; l < i; l++) w->acceleration[i][j] -= w->rate[i][l] * w->rate[l][j];
        }
    }
}

/* move by sum_j a_j k_j over the first `count` stages: increments h (sum a_j r_j + g h sum e_j v_j') and velocities h sum a_j v_j', e_j =
 * a_j + sum_l>j a_l s_lj */
static JO_INLINE void move(const jo_model *m, jo_data *d, const weights *w, const double *a, const int count, double gh)
{
    const double h = d->control.length;
    double e[JO_MOST_STAGES];
    for (int j = 0; j < count; j++) {
        e[j] = a[j];
        for (int l = j + 1; l < count; l++) e[j] -= a[l] * w->rate[l][j];
    }
    const jo_real *rates[JO_MOST_STAGES], *accelerations[JO_MOST_STAGES], *const v0 = d->v0;
    for (int j = 0; j < count; j++) {
        rates[j] = jo_kept_rates(d, j);
        accelerations[j] = jo_kept_accelerations(d, j);
    }
    jo_real *const dq = d->dq, *const w_next = d->w;
    const int n = d->nw;
    JO_EACH(i, n) {
        const jo_lanes v = JO_LOAD(accelerations[0] + i);
        jo_lanes r = a[0] * JO_LOAD(rates[0] + i), x = a[0] * v, y = e[0] * v;
        for (int j = 1; j < count; j++) {
            const jo_lanes next = JO_LOAD(accelerations[j] + i);
            r += a[j] * JO_LOAD(rates[j] + i);
            x += a[j] * next;
            y += e[j] * next;
        }
        JO_STORE(dq + i) = h * (r + gh * y);
        JO_STORE(w_next + i) = JO_LOAD(v0 + i) + h * x;
    }
    jo_integrate_positions(m, d, d->dq);
}

/* Arguments of stiffness and damping in stage k, divided by g h: x = -r_k - sum s_kj r_j - g h sum z_kj v_j' with the rates r_k in `own`,
 * and y = -sum s_kj v_j'; the weights of the first stage are smaller by `less`. */
static JO_INLINE void carry(const jo_data *d, const weights *w, const int k, const jo_stage *stage, double less, const jo_real *own, jo_real *x,
                     jo_real *y)
{
    const int n = d->nw;
    const double gh = stage->gh;
    const jo_real *const *r = stage->rates, *const *v = stage->accelerations;
    JO_EACH(i, n) {
        jo_lanes a = w->rate[k][0] * JO_LOAD(r[0] + i) - JO_LOAD(own + i), b = (w->rate[k][0] - less) * JO_LOAD(v[0] + i);
        for (int j = 1; j < k; j++) a += w->rate[k][j] * JO_LOAD(r[j] + i);
        a += (w->acceleration[k][0] - less) * gh * JO_LOAD(v[0] + i);
        for (int j = 1; j < k; j++) {
            a += w->acceleration[k][j] * gh * JO_LOAD(v[j] + i);
            b += w->rate[k][j] * JO_LOAD(v[j] + i);
        }
        JO_STORE(x + i) = a;
        JO_STORE(y + i) = b;
    }
}

/* Implicit part of the forces of beams. A stage that uses the factors of the first stage starts from the accelerations of that stage:
 * (g h D + (g h)^2 K) v_1' has already vanished. */
static JO_INLINE void push_beams(const jo_model *m, jo_data *d, const weights *w, const int k, const jo_stage *stage)
{
    jo_increment_rate(m, d->rate, d->dq, d->v);
    carry(d, w, k, stage, stage->second ? 1.0 : 0.0, d->rate, d->rate, d->dv);
    for (int i = 0; i < m->nv; i++) {
        d->rate[i] *= stage->gh;
        d->dv[i] *= stage->gh;
    }
    if (stage->second) jo_coupled_second(m, d, stage->accelerations[0], d->rate, d->dv);
    else jo_coupled_lag(m, d, d->rate, d->dv);
}

/* Work of a stage. For order 2 the work of damping and loads follows from the trapezoidal rule over the ends of the step, since
 * stages are inaccurate for modes that the step does not resolve. */
static JO_INLINE void add_work(jo_data *d, const jo_tableau *t, const int k)
{
    const double h = d->control.length, share = jo_tableau_weights(t)[k] * h;
    if (t->order > 2) {
        jo_add_work(&d->work, share, &d->power);
        return;
    }
    if (!k) {
        jo_add_step_work(d);
        d->waiting = h;
        d->power0 = d->power;
        d->power0.forces -= d->drive;
    }
    d->work.friction += share * d->power.friction;
    d->work.forces += share * d->drive;   /* the lead of the multipliers in stage 1 compensates their lag in stage 2 */
}

/* stage k: state, rates, work */
static JO_INLINE int stage_of(const jo_model *m, jo_data *d, const jo_tableau *t, const weights *w, const int k, jo_real t0, jo_stage *stage)
{
    if (k) {
        move(m, d, w, jo_tableau_row(t, k), k, stage->gh);
        d->time[0] = t0 + jo_tableau_node(t, k) * d->control.length;
    }
    stage->earlier = k;
    stage->rate = w->rate[k];
    stage->acceleration = w->acceleration[k];
    stage->lead = t->order > 2 ? 0.0 : w->lead[k] * stage->gh;   /* order 2: A contains the time derivative of the forces */
    stage->second = k && t->order <= 2 && (m->nbeam || (stage->contacts && !stage->separate));
    if (k && (!jo_tree_active(d) || jo_nmaximal(d) || m->nforce)) carry(d, w, k, stage, 0.0, d->w, d->dv, d->acc);   /* otherwise not used */
    jo_push_modes(m, d, stage);
    if (k && stage->contacts) {
        jo_contact_carry(m, d);
        jo_networks_carry(m, d);
    }
    if (k && jo_couples(m, stage) && !jo_tree_active(d)) push_beams(m, d, w, k, stage);
    const int status = jo_evaluate(m, d, stage);
    if (status != JO_OK) {
        jo_clear_modes(m, d);
        jo_state_changed(d);
        return status;
    }
    if (k) jo_position_rate(m, d, d->rate, d->dq);
    else {   /* prescribed coordinates are already set by the evaluation at the start */
        jo_real *const q0 = d->q0, *const v0 = d->v0, *const y = d->y, *const v = d->w;
        const int ny = d->ny, nw = d->nw;
        JO_EACH(i, ny) JO_STORE(q0 + i) = JO_LOAD(y + i);
        JO_EACH(i, nw) JO_STORE(v0 + i) = JO_LOAD(v + i);
    }
    jo_keep_rates(d, k, k ? d->rate : d->w);
    stage->rates[k] = jo_kept_rates(d, k);
    stage->accelerations[k] = jo_kept_accelerations(d, k);
    add_work(d, t, k);
    return JO_OK;
}

/* compiled for each tableau, so that its coefficients are constants of the code */
static JO_INLINE int step(const jo_model *m, jo_data *d, const jo_solver *s, const jo_tableau *t)
{
    const jo_real t0 = d->time[0];
    weights w;
    weigh(t, &w);
    const int inside = jo_contacts_in_matrix(t), touching = inside && jo_contacts_begin(m, d), networks = inside && jo_network_count(d) > 0;
    jo_stage stage = {.set = 1, .gh = t->coefficient[0] * s->step, .contacts = touching || networks, .alpha = s->alpha, .beta = s->beta};
    stage.separate = networks && !touching && jo_networks_separate(m, d);
    jo_use_step(m, d, stage.gh);
    int status = stage_of(m, d, t, &w, 0, t0, &stage);
    if (t->stages > 1 && status == JO_OK) status = stage_of(m, d, t, &w, 1, t0, &stage);
    if (t->stages > 2 && status == JO_OK) status = stage_of(m, d, t, &w, 2, t0, &stage);
    if (t->stages > 3 && status == JO_OK) status = stage_of(m, d, t, &w, 3, t0, &stage);
    if (status != JO_OK) return status;
    jo_clear_modes(m, d);
    move(m, d, &w, jo_tableau_weights(t), t->stages, stage.gh);
    d->time[0] = t0 + s->step;
    return jo_close_step(m, d, s, &stage);
}

/* cases of the methods of this family */
#define JO_ROS_rosenbrock(name, order, stages, ...) \
    case JO_METHOD_##name: { \
        static const double coefficient[] = {__VA_ARGS__}; \
        const jo_tableau t = {1, order, stages, coefficient}; \
        return step(m, d, s, &t); \
    }
#define JO_ROS_runge_kutta(...)
#define JO_ROS_generalized_alpha(...)
#define JO_ROS_dormand_prince(...)
#define JO_ROS_ROW(name, family, ...) JO_ROS_##family(name, __VA_ARGS__)

int jo_step_rosenbrock(const jo_model *m, jo_data *d, const jo_solver *s)
{
    switch (s->method) {
    JO_METHODS(JO_ROS_ROW)
    default: return JO_NO_CONVERGENCE;   /* a method of another family */
    }
}
