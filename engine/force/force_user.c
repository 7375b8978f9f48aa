/* force_user.c - force between two markers by a function of the user (jo_callback). */
#include "newton/newton.h"
#include "force/force.h"

#define JO_DIFFERENCE 1e-7       /* step of forward differences, relative to the argument or in rad; about the root of round-off, 1.5e-8 */
#define JO_SMALL_DISTANCE 1e-3  /* smallest distance, relative to the size of the mechanism, that scales the differences of positions */

/* y (6) = result of the user's function at `time`, for real arguments; JO_CALLBACK_FAILED if it fails or is not finite */
static int ask(const jo_force *f, jo_real time, const jo_real *x, jo_real *y)
{
    double given[18], answer[6] = {0.0};
    for (int i = 0; i < 18; i++) given[i] = JO_RE(x[i]);
    if (f->function(JO_RE(time), given, answer, f->user)) return JO_CALLBACK_FAILED;
    for (int i = 0; i < 6; i++) {
        if (!isfinite(answer[i])) return JO_CALLBACK_FAILED;
        y[i] = answer[i];
    }
    return JO_OK;
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *out)
{
    jo_real x[18], y[6], now[6];
    jo_relative_pose(d, f, x, x + 3);
    jo_relative_velocity(m, d, f, x + 12, x + 15);
    int status = ask(f, d->time[0] + stage->lead, x, y);
    if (status != JO_OK) return status;
    for (int i = 0; i < 6; i++) now[i] = y[i];
    if (stage->lead != 0.0) status = ask(f, d->time[0], x, now);
    d->power.forces += jo_dot3(now, x + 12) + jo_dot3(now + 3, x + 15);
    jo_push_between(m, d, f, y, out);
    return status;
}

/* derivatives of the user's function by forward differences; Newton's method then converges linearly */
static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *unused)
{
    (void)stage;
    jo_real x[18], y[6], X[6][12];
    (void)unused;
    jo_relative_pose(d, f, x, x + 3);
    jo_relative_velocity(m, d, f, x + 12, x + 15);
    if (ask(f, d->time[0], x, y) != JO_OK) return JO_CALLBACK_FAILED;
    for (int j = 0; j < 12; j++) {
        jo_real moved[18], z[6];
        double step = JO_DIFFERENCE;
        for (int k = 0; k < 18; k++) moved[k] = x[k];
        if (j >= 3 && j < 6) {
            jo_real angle[3] = {0.0}, q[4] = {1.0, 0.0, 0.0, 0.0}, E[9];
            angle[j - 3] = step;
            jo_rotate(q, angle);
            jo_rotation(E, q);
            jo_mul33(moved + 3, E, x + 3);
        } else {
            const int k = j < 3 ? j : 6 + j;
            const int group = j < 3 ? 0 : j < 9 ? 12 : 15;
            const double size = sqrt(JO_RE(jo_dot3(x + group, x + group)));
            step *= j < 3 ? (size > JO_SMALL_DISTANCE * m->size ? size : JO_SMALL_DISTANCE * m->size) : (size > 1.0 ? size : 1.0);
            moved[k] += step;
        }
        if (ask(f, d->time[0], moved, z) != JO_OK) return JO_CALLBACK_FAILED;
        for (int p = 0; p < 6; p++) X[p][j] = (z[p] - y[p]) / step;
    }
    jo_newton_between(m, d, f, y, X);
    return JO_OK;
}

const jo_force_kind jo_force_user = {apply, 0, tangent, 0, 0, 0};
