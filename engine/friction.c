/* friction.c - Coulomb friction along the coordinates of joints, pressed by the joint's own reaction.
 *
 * Sliding: f = -mu N arm s' / |slip|, N from the reaction resolved in the axes of side 0 (Altarriba 2010, eq. S37-S38), so
 * that f and the multipliers are found together. Sticking: the coordinate is held by a row of a joint of its own, whose
 * multiplier is the force of the static friction, limited by mu_static N (eq. S39-S40).
 */
#include "internal.h"

enum { JO_ITERATIONS = 60, JO_STAGNANT = 3 };   /* at most, and without coming nearer */
#define JO_AGREED 1e-12    /* relative difference of the friction and of what its reaction makes of it */
#define JO_NEARLY 1e-6     /* the same where rounding allows no better */

#define JO_PASSES 1e-7      /* of the size of the mechanism per second: a slip along two coordinates that does not stop */
#define JO_REST 1e-10      /* of the size of the mechanism, 1/s: slip below this is rest */
#define JO_HOLDS 1e-9      /* share of the static friction by which a joint may be overloaded, for round-off */

#ifdef JO_COMPLEX
#define JO_IM(x) cimag(x)
#else
#define JO_IM(x) 0.0
#endif

static int count_of(const jo_friction *f) { return f->other >= 0 ? 2 : 1; }
static int coordinate_of(const jo_friction *f, int k) { return k ? f->other : f->coordinate; }
static int turns(const jo_model *m, const jo_friction *f, int k) { return m->coordinate[coordinate_of(f, k)].type == JO_ANGLE; }
static int *lock_of(const jo_model *m, jo_data *d, const jo_friction *f) { return &d->locked[m->joint[f->lock].lock]; }
static int sticks(const jo_model *m, const jo_data *d, const jo_friction *f)
{
    return f->law && d->locked[m->joint[f->lock].lock];
}

/* slip, m, for a unit of the coordinate */
static jo_real arm(const jo_model *m, const jo_friction *f, int k) { return turns(m, f, k) ? f->data[3] : 1.0; }

static jo_real length(jo_real x, jo_real y)
{
    const jo_real square = x * x + y * y;
    return JO_RE(square) > 0.0 ? jo_sqrt(square) : 0.0;
}

static jo_real size(jo_real x) { return JO_RE(x) < 0.0 ? -x : x; }

/* what presses on the slipping surface, N, and the moment arm times force of a thrust collar, N m */
static jo_real press(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *collar)
{
    const jo_real *A = d->marker[m->joint[f->joint].side[0]].A, *data = f->data;
    jo_real y[6], F[3], M[3];
    jo_reaction(m, d, f->joint, y);
    jo_mul3t(F, A, y);
    jo_mul3t(M, A, y + 3);
    jo_real N = length(F[0], F[1]) + data[6];
    *collar = 0.0;
    if (JO_RE(data[4]) > 0.0) N += length(M[0], M[1]) / data[4];
    if (JO_RE(data[5]) > 0.0) {
        if (turns(m, f, 0)) *collar = data[5] * size(F[2]);
        else N += size(M[2]) / data[5];
    }
    return N;
}

/* mu / speed of the regularised law from the square of the speed: mu_static w (15 - 10 w^2 + 3 w^4) / 8 with w = speed / velocity
 * up to `velocity`, from there down to mu_kinetic at twice of it; two continuous derivatives */
static jo_real mu_by_speed(const jo_friction *f, jo_real square)
{
    const jo_real kinetic = f->data[0], top = f->data[1], velocity = f->data[2];
    const jo_real w2 = square / (velocity * velocity);
    if (JO_RE(w2) < 1.0) return top * (15.0 - w2 * (10.0 - 3.0 * w2)) / (8.0 * velocity);
    const jo_real speed = jo_sqrt(square), x = speed / velocity - 1.0;
    if (JO_RE(x) > 1.0) return kinetic / speed;
    return (top + (kinetic - top) * x * x * x * (10.0 - x * (15.0 - 6.0 * x))) / speed;
}

static void slip_velocity(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *s)
{
    s[1] = 0.0;
    for (int k = 0; k < count_of(f); k++) s[k] = arm(m, f, k) * d->coordinate[coordinate_of(f, k)].rate;
}

/* unit direction of the slip: the state says it; while nothing is decided, the velocity */
static void direction(const jo_model *m, const jo_data *d, int i, jo_real *e)
{
    const jo_friction *f = &m->friction[i];
    const jo_real *old = d->direction + 2 * i;
    jo_real s[2];
    slip_velocity(m, d, f, s);
    e[0] = e[1] = 0.0;
    if (d->slip[i] && count_of(f) == 1) {
        e[0] = d->slip[i];
        return;
    }
    const jo_real speed = length(s[0], s[1]);
    const int slow = !(JO_RE(speed) > JO_REST * m->size);
    if (d->slip[i] && (slow || JO_RE(s[0] * old[0] + s[1] * old[1]) < 0.0)) {
        e[0] = old[0];
        e[1] = old[1];
    } else if (!slow) {
        e[0] = s[0] / speed;
        e[1] = s[1] / speed;
    }
}

/* forces y (2) along the coordinates while they slide, 0 while they stick */
static void sliding(const jo_model *m, const jo_data *d, int i, jo_real *y)
{
    const jo_friction *f = &m->friction[i];
    jo_real e[2], collar;
    y[0] = y[1] = 0.0;
    if (sticks(m, d, f)) return;
    const jo_real N = press(m, d, f, &collar);
    if (f->law) {
        direction(m, d, i, e);
        for (int k = 0; k < 2; k++) e[k] *= f->data[0];
    } else {
        slip_velocity(m, d, f, e);
        const jo_real mu = mu_by_speed(f, e[0] * e[0] + e[1] * e[1]);
        for (int k = 0; k < 2; k++) e[k] *= mu;
    }
    for (int k = 0; k < count_of(f); k++) y[k] = -e[k] * (arm(m, f, k) * N + (turns(m, f, k) ? collar : 0.0));
}

/* gradient of |(x, y)| */
static void gradient_of_length(jo_real *g, jo_real x, jo_real y, jo_real factor)
{
    const jo_real whole = length(x, y);
    g[0] = JO_RE(whole) > 0.0 ? factor * x / whole : 0.0;
    g[1] = JO_RE(whole) > 0.0 ? factor * y / whole : 0.0;
    g[2] = 0.0;
}

/* derivative of mu_by_speed with respect to the square of the speed */
static jo_real mu_rate(const jo_friction *f, jo_real square)
{
    const jo_real kinetic = f->data[0], top = f->data[1], velocity = f->data[2];
    const jo_real w2 = square / (velocity * velocity);
    if (JO_RE(w2) < 1.0) return top * (6.0 * w2 - 10.0) / (8.0 * velocity * velocity * velocity);
    const jo_real speed = jo_sqrt(square), x = speed / velocity - 1.0, y = 1.0 - x;
    const jo_real rate = JO_RE(x) > 1.0 ? 0.0 : 30.0 * (kinetic - top) * x * x * y * y / velocity;
    return (rate - mu_by_speed(f, square)) / (2.0 * square);
}

void jo_friction_slopes(const jo_model *m, const jo_data *d, int i, jo_slopes *y)
{
    const jo_friction *f = &m->friction[i];
    const jo_real *A = d->marker[m->joint[f->joint].side[0]].A, *data = f->data;
    const jo_slopes none = {{{0.0}}, {{0.0}}, {{0.0}}};
    jo_real s[2], e[2], E[2][2] = {{0.0}}, reaction[6], F[3], M[3], collar, g[3], h[3], c[3] = {0.0, 0.0, 0.0};
    *y = none;
    if (sticks(m, d, f)) return;
    const jo_real N = press(m, d, f, &collar);
    slip_velocity(m, d, f, s);
    const jo_real square = s[0] * s[0] + s[1] * s[1];
    if (f->law) {
        direction(m, d, i, e);
        const jo_real speed = length(s[0], s[1]);
        const int follows = count_of(f) == 2 && JO_RE(speed) > 1e-10 * m->size;
        for (int k = 0; k < 2; k++) {
            for (int j = 0; follows && j < 2; j++) E[k][j] = data[0] * ((k == j) - e[k] * e[j]) / speed;
        }
        for (int k = 0; k < 2; k++) e[k] *= data[0];
    } else {
        const jo_real mu = mu_by_speed(f, square), rate = JO_RE(square) > 0.0 ? mu_rate(f, square) : 0.0;
        for (int k = 0; k < 2; k++) {
            for (int j = 0; j < 2; j++) E[k][j] = mu * (k == j) + 2.0 * rate * s[k] * s[j];
            e[k] = mu * s[k];
        }
    }
    /* gradients g, h of N and c of the collar, in the axes of side 0 */
    jo_reaction(m, d, f->joint, reaction);
    jo_mul3t(F, A, reaction);
    jo_mul3t(M, A, reaction + 3);
    gradient_of_length(g, F[0], F[1], 1.0);
    gradient_of_length(h, M[0], M[1], JO_RE(data[4]) > 0.0 ? 1.0 / data[4] : 0.0);
    if (JO_RE(data[5]) > 0.0) {
        if (turns(m, f, 0)) c[2] = JO_RE(F[2]) < 0.0 ? -data[5] : data[5];
        else h[2] = (JO_RE(M[2]) < 0.0 ? -1.0 : 1.0) / data[5];
    }
    for (int k = 0; k < count_of(f); k++) {
        const jo_real a = arm(m, f, k), around = turns(m, f, k);
        for (int j = 0; j < count_of(f); j++) y->rate[k][j] = -E[k][j] * arm(m, f, j) * (a * N + around * collar);
        jo_real x[3];
        for (int j = 0; j < 3; j++) x[j] = -e[k] * (a * g[j] + around * c[j]);
        jo_mul3(y->force[k], A, x);
        for (int j = 0; j < 3; j++) x[j] = -e[k] * a * h[j];
        jo_mul3(y->moment[k], A, x);
    }
}

/* forces with which sticking friction holds */
static void held(const jo_model *m, const jo_data *d, const jo_friction *f, jo_real *y)
{
    const jo_joint *k = &m->joint[f->lock];
    y[1] = 0.0;
    for (int r = 0; r < count_of(f); r++) y[r] = -d->lam[k->row + r] * m->line[k->line + r].data[1];
}

static void take_multipliers(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->njoint; i++)
        for (int r = 0; r < m->joint[i].nrow; r++) d->lam[m->joint[i].row + r] = d->joint[i].x[r];
}

static void push_all(const jo_model *m, jo_data *d, const jo_real *y)
{
    for (int i = 0; i < m->nfriction; i++)
        for (int k = 0; k < count_of(&m->friction[i]); k++)
            if (y[2 * i + k] != 0.0) jo_push_along(m, d, coordinate_of(&m->friction[i], k), y[2 * i + k]);
}

/* the friction that belongs to given multipliers and velocities */
void jo_friction_push(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++) sliding(m, d, i, d->rub + 2 * i);
    push_all(m, d, d->rub);
    for (int i = 0; i < m->nfriction; i++)   /* what sticks is held by its row */
        if (sticks(m, d, &m->friction[i])) held(m, d, &m->friction[i], d->rub + 2 * i);
}

static jo_real dot(const jo_real *x, const jo_real *y, int n)
{
    jo_real s = 0.0;
    for (int i = 0; i < n; i++) s += x[i] * y[i];
    return s;
}

/* change (n) = r - sum_j gamma_j (dF_j + dR_j) with dR gamma = r in least squares, by orthogonalisation, newest pair first
 * (Anderson, J. ACM 12, 1965); for one unknown this is the secant method */
static void accelerate(jo_mixing *w, int n, jo_real *change)
{
    jo_real gamma[JO_PAIRS] = {0.0}, R[JO_PAIRS][JO_PAIRS] = {{0.0}};
    int used[JO_PAIRS], count = 0;
    for (int i = 0; i < n; i++) change[i] = w->r[i];
    for (int j = 0; j < w->pairs; j++) {
        const int p = (w->newest - j + JO_PAIRS) % JO_PAIRS;
        jo_real *q = w->Q[count];
        for (int i = 0; i < n; i++) q[i] = w->dR[p][i];
        const double before = JO_RE(dot(q, q, n));
        for (int k = 0; k < count; k++) {
            R[k][count] = dot(w->Q[k], q, n);
            for (int i = 0; i < n; i++) q[i] -= R[k][count] * w->Q[k][i];
        }
        const jo_real square = dot(q, q, n);
        if (!(JO_RE(square) > 1e-12 * before)) continue;   /* adds nothing */
        R[count][count] = jo_sqrt(square);
        for (int i = 0; i < n; i++) q[i] /= R[count][count];
        used[count++] = p;
    }
    for (int k = count - 1; k >= 0; k--) {
        gamma[k] = dot(w->Q[k], w->r, n);
        for (int j = k + 1; j < count; j++) gamma[k] -= R[k][j] * gamma[j];
        gamma[k] /= R[k][k];
    }
    for (int k = 0; k < count; k++)
        for (int i = 0; i < n; i++) change[i] -= gamma[k] * (w->dF[used[k]][i] + w->dR[used[k]][i]);
}

/* multipliers with the forces that stand in fr and fp, the factors untouched */
static void solve_again(const jo_model *m, jo_data *d, const jo_solver *s)
{
    if (d->coupled) {
        jo_coupled_solve(m, d, s);
        return;
    }
    for (int i = 0; i < m->nbody; i++) jo_body_free(&m->body[i], &d->body[i], d->set);
    jo_marker_reduce(m, d, m->nactive);
    jo_joint_acceleration(m, d, s);
    jo_joint_solve(m, d);
}

/* largest real and imaginary part of n numbers */
static void largest(const jo_real *x, int n, double *y)
{
    y[0] = y[1] = 0.0;
    for (int i = 0; i < n; i++) {
        const double re = fabs(JO_RE(x[i])), im = fabs(JO_IM(x[i]));
        if (!(re <= y[0])) y[0] = re;
        if (!(im <= y[1])) y[1] = im;
    }
}

/* relative size of the residual; derivatives, in the imaginary part, need two digits less */
static double relative(const double *r, const double *f)
{
    const double re = r[0] > 0.0 ? r[0] / f[0] : 0.0, im = r[1] > 0.0 ? 1e-2 * r[1] / f[1] : 0.0;
    return re > im ? re : im;
}

static int failed(const jo_model *m, jo_data *d)
{
    double worst = -1.0;
    for (int i = 0; i < 2 * m->nfriction; i++)
        if (fabs(JO_RE(d->mixing.r[i])) > worst) {
            worst = fabs(JO_RE(d->mixing.r[i]));
            d->error_index = i / 2;
        }
    return JO_FRICTION_FAILED;
}

/* the fixed point f = F(lam(f)) from f = 0, lam(0) in joint[].x; 0 where it is not found, or, with one sliding coordinate,
 * where the slope of F(lam(f)) is above 1. The first change is `first` of the residual. */
static int find(const jo_model *m, jo_data *d, const jo_solver *s, double first)
{
    const int n = 2 * m->nfriction;
    jo_mixing *w = &d->mixing;
    jo_real *f = d->rub;
    double off[2], all[2], best = INFINITY;
    int jammed = 0, stagnant = 0;
    w->pairs = 0;
    w->newest = JO_PAIRS - 1;
    for (int i = 0; i < n; i++) f[i] = 0.0;
    for (int k = 0;; k++) {
        int unknowns = 0;
        take_multipliers(m, d);
        for (int i = 0; i < m->nfriction; i++) sliding(m, d, i, w->g + 2 * i);
        for (int i = 0; i < n; i++) {
            w->r[i] = w->g[i] - f[i];
            unknowns += w->g[i] != 0.0;
        }
        largest(w->r, n, off);
        largest(w->g, n, all);
        if (!isfinite(off[0])) return !k;   /* the run has diverged before, which the step says */
        const double apart = relative(off, all);
        stagnant = apart < 0.5 * best ? 0 : stagnant + 1;
        if (apart < best) best = apart;
        if (apart <= JO_AGREED || (stagnant >= JO_STAGNANT && apart <= JO_NEARLY)) return !jammed;
        if (k == JO_ITERATIONS) return 0;
        if (k) {   /* the last change of f and of r */
            w->newest = (w->newest + 1) % JO_PAIRS;
            if (w->pairs < JO_PAIRS) w->pairs++;
            for (int i = 0; i < n; i++) {
                w->dF[w->newest][i] = w->change[i];
                w->dR[w->newest][i] = w->r[i] - w->before[i];
            }
            if (unknowns == 1 && JO_RE(dot(w->change, w->change, n)) > 1e-12 * JO_RE(dot(f, f, n)))
                jammed = JO_RE(dot(w->change, w->dR[w->newest], n)) >= 0.0;
        }
        accelerate(w, n, w->change);
        for (int i = 0; i < n; i++) {
            if (!k) w->change[i] *= first;
            w->before[i] = w->r[i];
            f[i] += w->change[i];
        }
        push_all(m, d, w->change);
        solve_again(m, d, s);
    }
}

/* Friction and multipliers that belong together, after the multipliers without friction stand in joint[].x. The normal
 * force is convex in the friction: with one sliding coordinate secants from a short first change stay on the side of
 * f = 0 and find the smallest solution, if there is one. Beyond it friction presses the joint more than it needs to
 * (Painleve). */
int jo_friction_solve(const jo_model *m, jo_data *d, const jo_solver *s)
{
    const int n = 2 * m->nfriction;
    jo_real *f = d->rub;
    if (!find(m, d, s, 1.0)) {
        for (int i = 0; i < n; i++) d->mixing.change[i] = -f[i];
        push_all(m, d, d->mixing.change);
        solve_again(m, d, s);
        if (!find(m, d, s, 1e-2)) return failed(m, d);
    }
    for (int i = 0; i < m->nfriction; i++) {
        const jo_friction *c = &m->friction[i];
        for (int k = 0; k < count_of(c); k++) d->power[1] -= f[2 * i + k] * d->coordinate[coordinate_of(c, k)].rate;
        if (sticks(m, d, c)) held(m, d, c, f + 2 * i);
    }
    return JO_OK;
}

/* Positive while friction i keeps its state, after jo_evaluate: N or N m that it could hold more while it sticks, speed
 * along its direction, m/s, while it slips. Both begin a little above zero, so that round-off is no change of state. */
jo_real jo_friction_margin(const jo_model *m, const jo_data *d, int i)
{
    const jo_friction *f = &m->friction[i];
    jo_real y[2], collar;
    if (sticks(m, d, f)) {
        const jo_real N = press(m, d, f, &collar), limit = (1.0 + JO_HOLDS) * f->data[1];
        held(m, d, f, y);
        if (count_of(f) == 1) return limit * (arm(m, f, 0) * N + collar) - size(y[0]);
        return limit * N - length(y[0] / arm(m, f, 0), y[1] / arm(m, f, 1));
    }
    if (!f->law || !d->slip[i]) return 1.0;
    slip_velocity(m, d, f, y);
    const jo_real *e = d->direction + 2 * i;
    return JO_REST * m->size + (count_of(f) == 1 ? d->slip[i] * y[0] : e[0] * y[0] + e[1] * y[1]);
}

static int evaluate(const jo_model *m, jo_data *d)
{
    d->fresh = d->current = 0;
    const int status = jo_evaluate(m, d, 0, 0);
    d->fresh = status == JO_OK;
    return status;
}

/* friction i lets go: it slips where the held force pushed it */
static void let_go(const jo_model *m, jo_data *d, int i)
{
    const jo_friction *f = &m->friction[i];
    jo_real y[2], *e = d->direction + 2 * i;
    held(m, d, f, y);
    for (int k = 0; k < count_of(f); k++) y[k] /= arm(m, f, k);
    const jo_real whole = length(y[0], y[1]);
    for (int k = 0; k < 2; k++) e[k] = JO_RE(whole) > 0.0 ? -y[k] / whole : (k ? 0.0 : 1.0);
    d->slip[i] = count_of(f) == 2 || JO_RE(e[0]) > 0.0 ? 1 : -1;
    *lock_of(m, d, f) = 0;
    d->restart = 1;
}

/* friction i holds its coordinates where they are */
static void hold(const jo_model *m, jo_data *d, int i)
{
    const jo_friction *f = &m->friction[i];
    for (int k = 0; k < count_of(f); k++)
        d->held[2 * m->joint[f->lock].lock + k] = d->coordinate[coordinate_of(f, k)].value;
    *lock_of(m, d, f) = 1;
    d->slip[i] = 0;
    d->restart = 1;
}

/* the velocities obey the rows that hold now; what they lose is lost to friction */
static int stop(const jo_model *m, jo_data *d)
{
    jo_real before[4], after[4];
    int status = evaluate(m, d);
    if (status != JO_OK) return status;
    jo_energy(m, d, before);
    jo_project(m, d);
    jo_energy(m, d, after);
    d->work[1] += before[0] - after[0];
    return evaluate(m, d);
}

/* whether friction i is to slip along its one coordinate from rest, but is accelerated against that */
static int pushed_back(const jo_model *m, const jo_data *d, int i)
{
    const jo_friction *f = &m->friction[i];
    jo_real s[2], a[6], b[6];
    if (!f->law || sticks(m, d, f) || !d->slip[i] || count_of(f) == 2) return 0;
    slip_velocity(m, d, f, s);
    if (fabs(JO_RE(s[0])) > 2.0 * JO_REST * m->size) return 0;
    const jo_coordinate *c = &m->coordinate[f->coordinate];
    const jo_coordinate_work *w = &d->coordinate[f->coordinate];
    jo_marker_acceleration(m, d, c->a, a);
    jo_marker_acceleration(m, d, c->b, b);
    for (int j = 0; j < 3; j++) b[j] -= a[j];
    const jo_real second = jo_dot3(w->along, b) + jo_dot3(w->turn_a, a + 3) + jo_dot3(w->turn_b, b + 3) + w->bias;
    return d->slip[i] * JO_RE(arm(m, f, 0) * second) < -1e-9 * m->size;
}

/* What cannot hold lets go, the most overloaded first. Others that have just let go may be pushed back by it: they hold again.
 * Coupled frictions seldom need more than a few rounds; the number is bounded. */
static int release(const jo_model *m, jo_data *d)
{
    for (int round = 0; round < 8 + 4 * m->nfriction; round++) {
        int weakest = -1, back = -1;
        double least = 0.0;
        for (int i = 0; i < m->nfriction; i++) {
            if (pushed_back(m, d, i)) back = i;
            if (!sticks(m, d, &m->friction[i])) continue;
            jo_real y[2];
            held(m, d, &m->friction[i], y);
            const double margin = JO_RE(jo_friction_margin(m, d, i)), load = fabs(JO_RE(y[0])) + fabs(JO_RE(y[1]));
            if (margin < 0.0 && margin < least * load) {
                least = margin / load;
                weakest = i;
            }
        }
        if (weakest >= 0) let_go(m, d, weakest);
        else if (back >= 0) hold(m, d, back);
        else break;
        const int status = evaluate(m, d);
        if (status != JO_OK) return status;
    }
    return JO_OK;
}

/* the state of friction i ends, after jo_evaluate: what sticks lets go, what slips sticks if it can, else it turns round */
int jo_friction_switch(const jo_model *m, jo_data *d, int i)
{
    const jo_friction *f = &m->friction[i];
    if (!f->law) return JO_OK;
    int status;
    if (sticks(m, d, f)) {
        let_go(m, d, i);
        status = evaluate(m, d);
    } else {
        jo_real e[2];
        slip_velocity(m, d, f, e);
        const jo_real speed = length(e[0], e[1]);
        if (count_of(f) == 2 && JO_RE(speed) > JO_PASSES * m->size) {   /* it turned past rest without coming to rest */
            for (int k = 0; k < 2; k++) d->direction[2 * i + k] = e[k] / speed;
            d->restart = 1;
            return evaluate(m, d);
        }
        hold(m, d, i);
        status = stop(m, d);
    }
    return status == JO_OK ? release(m, d) : status;
}

/* frictions whose state nobody has said: what moves slips, what rests sticks if it can */
int jo_friction_settle(const jo_model *m, jo_data *d)
{
    int undecided = 0, resting = 0, status = JO_OK;
    for (int i = 0; i < m->nfriction; i++)
        undecided += m->friction[i].law && !d->slip[i] && !sticks(m, d, &m->friction[i]);
    if (!undecided) return JO_OK;
    status = evaluate(m, d);
    for (int i = 0; i < m->nfriction && status == JO_OK; i++) {
        const jo_friction *f = &m->friction[i];
        jo_real e[2];
        if (!f->law || d->slip[i] || sticks(m, d, f)) continue;
        direction(m, d, i, e);
        if (e[0] == 0.0 && e[1] == 0.0) {
            hold(m, d, i);
            resting = 1;
        } else {
            for (int k = 0; k < 2; k++) d->direction[2 * i + k] = e[k];
            d->slip[i] = count_of(f) == 2 || JO_RE(e[0]) > 0.0 ? 1 : -1;
        }
    }
    if (status == JO_OK) status = resting ? stop(m, d) : evaluate(m, d);
    return status == JO_OK ? release(m, d) : status;
}

/* at the end of a step: friction that slips along two coordinates follows the velocity */
void jo_friction_turn(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nfriction; i++) {
        const jo_friction *f = &m->friction[i];
        if (!f->law || sticks(m, d, f) || count_of(f) == 1) continue;
        jo_real e[2];
        direction(m, d, i, e);
        for (int k = 0; k < 2; k++) d->direction[2 * i + k] = e[k];
    }
}
