/* alpha_motion.c - unknowns of a step of generalised alpha and the motion that follows from them. */
#include "valid.h"
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "integrate/integrate.h"

#define JO_SAME_TIME 1e-6       /* difference of times / step that counts as equal */

/* whether n numbers are equal */
static int equal(const jo_real *x, const jo_real *y, const int n)
{
    int i = 0, differ = 0;
    for (; i + 4 <= n && !differ; i += 4)
        for (int j = i; j < i + 4; j++) differ |= x[j] != y[j];
    for (; i < n && !differ; i++) differ = x[i] != y[i];
    return !differ;
}

/* whether time, q and v are those at the end of the last step */
int jo_alpha_continues(const jo_model *m, const jo_data *d, double h)
{
    if (!jo_history_valid(d) || !(fabs(JO_RE(d->time[0] - *d->alpha.end_time)) < JO_SAME_TIME * h)) return 0;
    return equal(d->q, d->alpha.end_q, m->nq) && equal(d->v, d->alpha.end_v, d->nw);
}

/* q, v by the Newmark formulas from the algorithmic acceleration a1 in `rate` */
void jo_alpha_update(const jo_model *m, jo_data *d, const jo_solver *s)
{
    const double h = s->step, b = s->newmark_beta, g = s->newmark_gamma;
    const jo_real *v0 = d->v0, *a0 = d->alpha.algorithmic, *a1 = d->rate;
    jo_real *dq = d->dq, *v = d->v;
    const int n = d->nw;
    JO_EACH(i, n) {
        const jo_lanes start = JO_LOAD(v0 + i), old = JO_LOAD(a0 + i), present = JO_LOAD(a1 + i);
        JO_STORE(dq + i) = h * (start + h * ((0.5 - b) * old + b * present));
        JO_STORE(v + i) = start + h * ((1.0 - g) * old + g * present);
    }
    jo_add_increment(m, d->q, d->q0, d->dq);
}

/* tangent operators E - f1 theta~ + f2 theta~ theta~ of the increments of the last jo_alpha_update, for Newton's matrix */
void jo_alpha_tangents(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nbody; i++) {
        const jo_real *x = d->dq + m->body[i].iv + 3, square = jo_dot3(x, x);
        jo_real *T = d->body[i].turn, f[3];
        jo_sinc(square, f);
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++) T[3 * r + c] = f[2] * x[r] * x[c] + (r == c ? 1.0 - f[2] * square : 0.0);
        T[1] += f[1] * x[2]; T[2] -= f[1] * x[1]; T[3] -= f[1] * x[2];
        T[5] += f[1] * x[0]; T[6] += f[1] * x[1]; T[7] -= f[1] * x[0];
    }
}

/* unknowns += share x, in the layout of jo_newton_vector: a1 in rate, accelerations a, multipliers */
void jo_alpha_add(const jo_model *m, jo_data *d, const jo_weights *c, const jo_real *x, double share)
{
    for (int i = 0; i < m->nbody; i++) {
        const jo_real *restrict y = x + jo_newton_place(m, i);
        jo_real *restrict rate = d->rate + m->body[i].iv, *restrict a = d->a + m->body[i].iv;
        const double of_a = share * c->a;
        for (int j = 0; j < 6; j++) {
            rate[j] += share * y[j];
            a[j] += of_a * y[j];
        }
        for (int j = 6; j < 6 + m->body[i].n; j++) {
            rate[j] += share * y[j];
            a[j] += of_a * y[j];
        }
    }
    for (int i = 0; i < m->njoint; i++) {
        const jo_real *y = x + jo_newton_place(m, m->nbody + i);
        for (int r = 0; r < m->joint[i].nrow; r++) d->lam[m->joint[i].row + r] += share * y[r];
    }
}

/* prediction: algorithmic acceleration and multipliers of the last step, plus their last change times `ahead` */
void jo_alpha_predict(const jo_model *m, jo_data *d, const jo_solver *s, double ahead)
{
    for (int i = 0; i < m->nrow; i++) d->lam[i] = d->alpha.end_lam[i] + ahead * d->alpha.change_lam[i];
    const double am = s->alpha_m, af = s->alpha_f, share = 1.0 / (1.0 - af);
    const jo_real *old = d->alpha.algorithmic, *change = d->alpha.change, *end = d->alpha.end_a;
    jo_real *rate = d->rate, *a = d->a;
    const int n = d->nw;
    JO_EACH(i, n) {
        const jo_lanes more = ahead * JO_LOAD(change + i), base = JO_LOAD(old + i);
        JO_STORE(rate + i) = base + more;
        JO_STORE(a + i) = share * (base + (1.0 - am) * more - af * JO_LOAD(end + i));
    }
}
