/* beam.c - geometrically exact beam elements: forces on the bodies, energy, sections, limits.
 *
 * With the strains of beam_strain.c and the forces f = [n, m] conjugate to d and kappa, the forces are the exact gradient of U: n on b and
 * -n on a, moments (t -+ tau x t)/2 -+ H m with t = L n x d.
 */
#include "beam/beam.h"
#include "beam/beam_lanes.h"

/* moments M = (t -+ tau x t)/2 -+ H m of the ends a, b on the element, t = L n x d */
static void end_moments(jo_beam_group *w)
{
    jo_lanes h[3], x[3];
    jo_lanes_cross(w->t, w->f, w->d);
    for (int j = 0; j < 3; j++) w->t[j] *= w->length;
    jo_lanes_cross(x, w->tau, w->t);
    jo_lanes_h(h, w, w->f + 3);
    for (int j = 0; j < 3; j++) {
        const jo_lanes half = 0.5 * w->t[j], other = h[j] + 0.5 * x[j];
        w->M[0][j] = half - other;
        w->M[1][j] = half + other;
    }
}

/* power of the damping of a group, W */
static jo_real damping_power(const jo_beam_group *w)
{
    jo_lanes power = {0};
    jo_real sum = 0.0;
    for (int j = 0; j < 6; j++)
        for (int l = 0; l < 6; l++) power += w->rate[j] * w->C[6 * j + l] * w->rate[l];
    power *= w->length * w->beta;
    JO_EACH_ELEMENT(l, w) sum += jo_lane(&power, l);
    return sum;
}

/* forces and torques of the elements of a group on their bodies; power of their damping */
static void internal(jo_data *d, jo_beam_group *w)
{
    jo_lanes F[3], T[3], y[3];
    end_moments(w);
    for (int k = 0; k < 2; k++) {
        jo_real *at[JO_WIDTH];
        const double sign = k ? 1.0 : -1.0;
        jo_lanes_copy(y, w->M[k], 3);
        if (w->kind & JO_BEAM_OFFSET) {
            jo_lanes t[3];
            jo_lanes_cross(t, w->U[k], w->f);
            for (int j = 0; j < 3; j++) y[j] += sign * t[j];
        }
        jo_lanes_mul(T, w->G[k], y);
        jo_lanes_mul(F, w->G[k], w->f);
        for (int j = 0; j < 3; j++) {
            F[j] *= -sign;
            T[j] = -T[j];
        }
        JO_EACH_PLACE(l) at[l] = d->body[w->body[k][l]].fr;
        jo_lanes_scatter_six(at, w->count, F, T);
    }
    if (w->kind & JO_BEAM_DAMPED) d->power.damping += damping_power(w);
}

/* elastic, damping and consistent inertial forces of all beams, added to the forces on their bodies */
int jo_beam_forces(const jo_model *m, jo_data *d, const jo_real *a)
{
    for (int i = 0; i < d->beams.groups; i++) {
        jo_beam_group *w = &d->beams.group[i];
        const int unsound = jo_beam_resultants(d, w);
        if (unsound >= 0) {
            const int bent = isfinite(JO_RE(jo_lane(&w->cosine, unsound)));
            d->error_index = bent ? w->element[unsound] : w->body[0][unsound];
            return bent ? JO_BENT : JO_NOT_FINITE;
        }
        internal(d, w);
    }
    for (int i = 0; i < m->nbeam; i++)
        if (jo_beam_inertial(&m->beam[i])) jo_beam_inertia(m, d, i, a);
    return JO_OK;
}

/* square of the accelerations that the forces of the elements give their bodies, in the norm of the masses: |n|^2 / m + |M|^2 / tr(J) */
double jo_beam_force_norm(const jo_data *d)
{
    jo_lanes sum = {0};
    for (int i = 0; i < d->beams.groups; i++) {
        const jo_beam_group *w = &d->beams.group[i];
        sum += w->light * jo_lanes_dot(w->s, w->s);
        for (int k = 0; k < 2; k++) sum += w->easy[k] * jo_lanes_dot(w->M[k], w->M[k]);
    }
    return JO_RE(jo_sum(sum));
}

/* strain energy of the beams at the present q */
jo_real jo_beam_stored(const jo_data *d)
{
    jo_real U = 0.0;
    for (int i = 0; i < d->beams.groups; i++) {
        jo_beam_group *w = &d->beams.group[i];
        jo_lanes sum = {0};
        jo_beam_strain(d, w);
        for (int j = 0; j < 6; j++)
            for (int k = 0; k < 6; k++) sum += w->e[j] * w->C[6 * j + k] * w->e[k];
        sum *= 0.5 * w->length;
        JO_EACH_ELEMENT(l, w) if (jo_beam_sound(w, l)) U += jo_lane(&sum, l);
    }
    return U;
}

/* y (24) = strains and resultants in the middle of one element at the present q, v; resultants at both ends from equilibrium, in the axes of
 * the end sections */
void jo_beam_section(const jo_data *d, int i, jo_real *y)
{
    jo_beam_group *w = &d->beams.group[d->beams.place[i] / JO_WIDTH];
    const int lane = d->beams.place[i] % JO_WIDTH;
    jo_beam_resultants(d, w);
    if (!jo_beam_sound(w, lane)) return;
    end_moments(w);
    for (int j = 0; j < 6; j++) {
        y[j] = jo_lane(w->e + j, lane);
        y[6 + j] = jo_lane(w->s + j, lane);
    }
    for (int k = 0; k < 2; k++) {
        jo_lanes M[3], t[3], z[6];
        for (int j = 0; j < 3; j++) M[j] = (k ? 1.0 : -1.0) * w->M[k][j];
        jo_lanes_mul(t, w->G[k], w->f);
        jo_lanes_mult(z, w->B[k], t);
        jo_lanes_mul(t, w->G[k], M);
        jo_lanes_mult(z + 3, w->B[k], t);
        for (int j = 0; j < 6; j++) y[12 + 6 * k + j] = jo_lane(z + j, lane);
    }
}

/* at an accepted state: largest rotation between the ends, and largest ratio of tension and its limit */
void jo_beam_accept(jo_data *d)
{
    for (int i = 0; i < d->beams.groups; i++) {
        jo_beam_group *w = &d->beams.group[i];
        const jo_lanes ratio = w->s[0] * w->limit;
        jo_lanes_copy(w->last, w->tau, 3);
        JO_EACH_ELEMENT(l, w) {
            double *most = d->beams.bent + 2 * w->element[l];
            const double square = JO_RE(jo_lane(&w->square, l)), tension = JO_RE(jo_lane(&ratio, l));
            if (16.0 * square > most[0] * most[0]) {   /* atan(x) <= x */
                const double bent = 4.0 * atan(sqrt(square));
                if (bent > most[0]) most[0] = bent;
            }
            if (tension > most[1]) most[1] = tension;
        }
    }
}

/* after the state was replaced: the rotation at the last accepted state is unknown */
void jo_beam_reset_history(jo_data *d)
{
    for (int i = 0; i < d->beams.groups; i++) jo_lanes_clear(d->beams.group[i].last, 3);
}
