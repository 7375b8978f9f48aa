/* tree_loop_projection.c - loops of a tree are closed after a step, as joints of bodies are by jo_project. */
#include "maximal/maximal.h"
#include "tree/tree_links.h"

enum { JO_CORRECTIONS = 4 };
#define JO_UNTOUCHED 0.01       /* of these: so small a gap is left as it is */

/* bodies and markers of the loops where x and u are */
static void place(const jo_model *m, jo_data *d)
{
    jo_tree_kinematics(m, d);
    jo_tree_bodies(m, d);
    jo_tree_markers(m, d, d->tree.closing, d->tree.nclosing);
    for (int i = 0; i < m->nloop; i++) {
        const jo_joint *k = &m->joint[m->loop[i].joint];
        for (int l = 0; l < k->nline; l++)
            for (int j = 0; j < m->line[k->line + l].count; j++) {
                jo_coordinate_place(m, d, m->line[k->line + l].coordinate[j]);
                jo_coordinate_move(m, d, m->line[k->line + l].coordinate[j]);
            }
    }
}

static double gap(const jo_model *m, jo_data *d, int velocity)
{
    double worst = 0.0;
    for (int i = 0; i < m->nloop; i++) {
        const int joint = m->loop[i].joint;
        const double x = JO_RE(velocity ? jo_joint_gap_rate(m, d, joint) : jo_joint_gap(m, d, joint));
        if (!(x <= worst)) worst = x;
    }
    return worst;
}

/* m/s, the largest of the joints, as jo_speed of the bodies */
static double speed(const jo_model *m, const jo_data *d)
{
    double fastest = 0.0;
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const int turns = k->type == JO_LINK_HINGE || k->type == JO_LINK_BALL, frees = k->type == JO_LINK_FREE || k->type == JO_LINK_BODY;
        const int count = k->type == JO_LINK_FIXED ? 0 : frees ? 6 : k->type == JO_LINK_BALL ? 3 : 1;
        for (int j = 0; j < count; j++)
            fastest = jo_larger(fastest, fabs(JO_RE(d->tree.u[k->u + j])) * (turns || (frees && j > 2) ? m->size : 1.0));
    }
    return fastest;
}

/* change of x or of u that closes the residuals, into d->rate */
static void correct(const jo_model *m, jo_data *d, int velocity)
{
    for (int i = 0; i < m->nloop; i++) {
        const jo_joint_work *w = &d->joint[m->loop[i].joint];
        for (int r = 0; r < d->tree.loop[i].rows; r++) d->tree.loop[i].x[r] = velocity ? w->cdot[r] : w->c[r];
    }
    jo_loop_solve(m, d);
    jo_tree_respond_clear(m, d);
    jo_loop_push(m, d);
    jo_tree_respond(m, d, d->rate);
    d->tree.mirrored = JO_MIRROR_NONE;
}

/* derivatives converge behind the values: the complex build corrects once in any case */
static int untouched(double residual, double small, int k)
{
#ifdef JO_COMPLEX
    if (!k) return 0;
#endif
    return residual <= (k ? 1.0 : JO_UNTOUCHED) * small;
}

int jo_tree_close(const jo_model *m, jo_data *d)
{
    if (!m->nloop) return 1;
    const double small = JO_CLOSED * m->size, small_rate = JO_CLOSED * speed(m, d);
    place(m, d);
    double residual = gap(m, d, 0), before = HUGE_VAL;
    for (int k = 0; k < JO_CORRECTIONS && !untouched(residual, small, k) && residual < 0.5 * before; k++) {
        before = residual;
        correct(m, d, 0);
        jo_tree_displace(m, d->tree.x, d->tree.x, d->rate);
        place(m, d);
        residual = gap(m, d, 0);
    }
    double rate = gap(m, d, 1);
    for (int k = 0; k < JO_CORRECTIONS && !untouched(rate, small_rate, k); k++) {
        before = rate;
        correct(m, d, 1);
        for (int i = 0; i < m->nu; i++) d->tree.u[i] += d->rate[i];
        place(m, d);
        rate = gap(m, d, 1);
        if (rate < before) continue;
        for (int i = 0; i < m->nu; i++) d->tree.u[i] -= d->rate[i];   /* the factors are those of another place */
        place(m, d);
        rate = before;
        break;
    }
    d->fresh = d->current = 0;
    return residual <= small && rate <= small_rate;
}

void jo_tree_increments(const jo_model *m, jo_real *dq, const jo_real *x0, const jo_real *x)
{
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &m->link[i];
        const int ball = k->type == JO_LINK_BALL || k->type == JO_LINK_FREE, moves = k->type == JO_LINK_FREE ? 3 : 0;
        if (k->type == JO_LINK_HINGE || k->type == JO_LINK_SLIDE) dq[k->u] = x[k->x] - x0[k->x];
        for (int j = 0; j < moves; j++) dq[k->u + j] = x[k->x + j] - x0[k->x + j];
        if (ball) jo_turn_between(dq + k->u + moves, x0 + k->x + moves, x + k->x + moves);
    }
}
