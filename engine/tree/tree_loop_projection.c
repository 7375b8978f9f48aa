/* tree_loop_projection.c - projection of x and u onto the loop constraints after a step, as jo_project does for q and v.
 *
 * Newton iteration with the factors of the last evaluation: (J H^-1 J^T) lambda = c, x -= H^-1 J^T lambda, then the same for u with c'.
 */
#include "valid.h"
#include "maximal/maximal.h"
#include "tree/tree_links.h"

enum { JO_MAX_CORRECTIONS = 4 };   /* largest number of corrections of x and of u in one projection */
#define JO_SKIP_RATIO 0.01      /* ratio of residual and tolerance below which the first correction is skipped */
#define JO_MIN_REDUCTION 0.5    /* ratio of successive residuals above which the iteration for x ends */

/* links, bodies, markers and coordinates of the loops at x and u */
static void update_loops(const jo_model *m, jo_data *d)
{
    jo_tree_kinematics(m, d);
    jo_tree_update_bodies(m, d);
    jo_tree_update_markers(m, d, d->tree.loop_marker, d->tree.nloop_marker);
    for (int i = 0; i < m->nloop; i++) {
        const jo_joint *k = &m->joint[m->loop[i].joint];
        for (int l = 0; l < k->nline; l++)
            for (int j = 0; j < m->line[k->line + l].count; j++) {
                jo_coordinate_value(m, d, m->line[k->line + l].coordinate[j]);
                jo_coordinate_rate(m, d, m->line[k->line + l].coordinate[j]);
            }
    }
}

/* largest residual of the loops: of the positions, m, or of the velocities, m/s */
static double largest_residual(const jo_model *m, jo_data *d, int velocity)
{
    double worst = 0.0;
    for (int i = 0; i < m->nloop; i++) {
        const int joint = m->loop[i].joint;
        const double x = JO_RE(velocity ? jo_constraint_residual_rate(m, d, joint) : jo_constraint_residual(m, d, joint));
        if (!(x <= worst)) worst = x;
    }
    return worst;
}

/* largest joint rate, m/s, with angular rates times the size of the mechanism */
static double speed(const jo_model *m, const jo_data *d)
{
    double fastest = 0.0;
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const int turns = k->type == JO_LINK_HINGE || k->type == JO_LINK_BALL, frees = k->type == JO_LINK_FREE || k->type == JO_LINK_BODY;
        const int count = k->type == JO_LINK_FIXED ? 0 : frees ? 6 : k->type == JO_LINK_BALL ? 3 : 1;
        for (int j = 0; j < count; j++)
            fastest = jo_larger(fastest, fabs(JO_RE(d->u[k->u + j])) * (turns || (frees && j > 2) ? m->size : 1.0));
    }
    return fastest;
}

/* d->rate = -H^-1 J^T (J H^-1 J^T)^-1 c: correction of x, or of u with c' */
static void solve_correction(const jo_model *m, jo_data *d, int velocity)
{
    for (int i = 0; i < m->nloop; i++) {
        const jo_joint_work *w = &d->joint[m->loop[i].joint];
        for (int r = 0; r < d->tree.loop[i].rows; r++) d->tree.loop[i].x[r] = velocity ? w->cdot[r] : w->c[r];
    }
    jo_loop_solve(m, d);
    jo_tree_clear_added_forces(m, d);
    jo_loop_add_multiplier_forces(m, d);
    jo_tree_force_response(m, d, d->rate);
    jo_positions_moved(d);
}

/* whether the residual needs no correction k. The complex build always makes the first correction, since derivatives converge one iteration
 * later. */
static int is_closed(double residual, double small, int k)
{
#ifdef JO_COMPLEX
    if (!k) return 0;
#endif
    return residual <= (k ? 1.0 : JO_SKIP_RATIO) * small;
}

/* project x, then u; returns whether both residuals are within the tolerance JO_CLOSED */
int jo_tree_close_loops(const jo_model *m, jo_data *d)
{
    if (!m->nloop) return 1;
    const double small = JO_CLOSED * m->size, small_rate = JO_CLOSED * speed(m, d);
    /* positions: x -= H^-1 J^T lambda */
    update_loops(m, d);
    double residual = largest_residual(m, d, 0), before = HUGE_VAL;
    for (int k = 0; k < JO_MAX_CORRECTIONS && !is_closed(residual, small, k) && residual < JO_MIN_REDUCTION * before; k++) {
        before = residual;
        solve_correction(m, d, 0);
        jo_tree_add_increment(m, d->x, d->x, d->rate);
        update_loops(m, d);
        residual = largest_residual(m, d, 0);
    }
    /* velocities: u -= H^-1 J^T lambda */
    double rate = largest_residual(m, d, 1);
    for (int k = 0; k < JO_MAX_CORRECTIONS && !is_closed(rate, small_rate, k); k++) {
        before = rate;
        solve_correction(m, d, 1);
        for (int i = 0; i < m->nu; i++) d->u[i] += d->rate[i];
        update_loops(m, d);
        rate = largest_residual(m, d, 1);
        if (rate < before) continue;
        for (int i = 0; i < m->nu; i++) d->u[i] -= d->rate[i];   /* undo the correction, since the factors belong to another position */
        update_loops(m, d);
        rate = before;
        break;
    }
    jo_state_changed(d);
    return residual <= small && rate <= small_rate;
}
