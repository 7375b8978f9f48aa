/* force_rail.c - a wheel of b, axle n (its z axis), on a straight rail of a along its x axis, top along z: load and creep forces of its patches
 * (tread, flange), see rail_patch.c. The numbers of the force are followed by those of its patches (count). */
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"
#include "force/rail_patch.h"

static const jo_rail_data *numbers(const jo_force *f) { return (const jo_rail_data *)f->data; }
static int count_of(const jo_force *f) { return (int)JO_RE(numbers(f)->count); }
static const jo_rail_patch *patch_of(const jo_force *f, int i) { return (const jo_rail_patch *)(numbers(f) + 1) + i; }

static const jo_real rail_rest[3] = {0.0, 0.0, 0.0};

/* adds force and torque on b, at its origin, resolved in a */
static void add_force(const jo_rail_touch *t, jo_dual3 *F, jo_dual3 *T)
{
    const jo_real ahead[3] = {1.0, 0.0, 0.0};
    const jo_dual none = jo_dual_constant(0.0);
    jo_dual3 one = jo_dual3_times(jo_dual_sub(none, t->load), t->down);
    one = jo_dual3_axpy(jo_dual3_axpy(one, t->force[0], jo_dual3_of(ahead, rail_rest)), t->force[1], t->across);
    *F = jo_dual3_add(*F, one);
    *T = jo_dual3_axpy(jo_dual3_add(*T, jo_dual3_cross(t->at, one)), jo_dual_sub(none, t->moment), t->down);
}

static jo_real stored_in(const jo_rail_touch *t) { return JO_RE(t->depth.v) > 0.0 ? 0.4 * t->elastic.v * t->depth.v : jo_same(0.0); }

static jo_real stored(const jo_data *d, const jo_force *f)
{
    jo_real r[3], R[9], sum = jo_same(0.0);
    jo_relative_pose(d, f, r, R);
    const jo_wheel_motion at = jo_wheel_motion_of(r, R, rail_rest, rail_rest, -1);
    for (int i = 0; i < count_of(f); i++) {
        const jo_rail_touch t = jo_rail_touch_of(numbers(f), patch_of(f, i), &at, jo_same(0.0));
        sum += stored_in(&t);
    }
    return sum;
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *out)
{
    (void)stage;
    static const jo_force_work none = {{0.0}, 0.0, 0.0, 0.0};
    jo_real r[3], R[9], v[3], w[3], load[6];
    jo_dual3 F = jo_dual3_of(rail_rest, rail_rest), T = F;
    jo_relative_pose(d, f, r, R);
    jo_relative_velocity(m, d, f, v, w);
    const jo_wheel_motion at = jo_wheel_motion_of(r, R, v, w, -1);
    *out = none;
    int touches = 0;
    for (int i = 0; i < count_of(f); i++) {
        const jo_rail_touch t = jo_rail_touch_of(numbers(f), patch_of(f, i), &at, jo_same(0.0));
        out->stored += stored_in(&t);
        d->power.damping += (t.load.v - t.elastic.v) * t.rate.v;
        d->power.friction -= t.force[0].v * t.slide[0].v + t.force[1].v * t.slide[1].v + t.moment.v * t.spin.v;
        touches |= t.touches;
        if (t.touches) add_force(&t, &F, &T);
    }
    if (!touches) return JO_OK;
    jo_set3(load, F.v);
    jo_set3(load + 3, T.v);
    jo_push_between(m, d, f, load, out);
    return JO_OK;
}

static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *unused)
{
    (void)unused;
    (void)stage;
    jo_real r[3], R[9], v[3], w[3], load[6] = {0.0}, X[6][12] = {{0.0}};
    jo_relative_pose(d, f, r, R);
    jo_relative_velocity(m, d, f, v, w);
    int touches = 0;
    for (int i = 0; i < count_of(f); i++) {
        jo_real along = jo_same(0.0);
        for (int k = 0; k < 12; k++) {
            const jo_wheel_motion at = jo_wheel_motion_of(r, R, v, w, k);
            const jo_rail_touch t = jo_rail_touch_of(numbers(f), patch_of(f, i), &at, along);
            jo_dual3 F = jo_dual3_of(rail_rest, rail_rest), T = F;
            along = t.along;
            if (!t.touches) break;
            touches = 1;
            add_force(&t, &F, &T);
            for (int j = 0; j < 3; j++) {
                X[j][k] += F.d[j];
                X[3 + j][k] += T.d[j];
                if (k) continue;
                load[j] += F.v[j];
                load[3 + j] += T.v[j];
            }
        }
    }
    if (touches) jo_newton_between(m, d, f, load, X);
    return JO_OK;
}

void jo_rail_report(const jo_model *m, const jo_data *d, const jo_force *f, int patch, jo_real *y)
{
    const jo_rail_patch *c = patch_of(f, patch);
    jo_real r[3], R[9], v[3], w[3];
    jo_relative_pose(d, f, r, R);
    jo_relative_velocity(m, d, f, v, w);
    const jo_wheel_motion at = jo_wheel_motion_of(r, R, v, w, -1);
    const jo_rail_touch t = jo_rail_touch_of(numbers(f), c, &at, jo_same(0.0));
    /* half axes and pressure grow with the root of the depth */
    const jo_real grows = t.touches ? jo_sqrt(t.depth.v) : jo_same(0.0);
    const jo_dual place = jo_dual3_dot(t.at, at.n);
    const jo_dual3 arm = jo_dual3_sub(t.at, jo_dual3_times(place, at.n));
    const jo_real all[JO_RAIL_REPORT] = {t.load.v, t.force[0].v, t.force[1].v, t.moment.v, t.creep[0].v, t.creep[1].v, t.creep[2].v,
                                         c->hertz[0] * grows, c->hertz[1] * grows, c->hertz[2] * grows, jo_dual3_length(arm).v, r[1] + t.at.v[1]};
    for (int i = 0; i < JO_RAIL_REPORT; i++) y[i] = all[i];
}

const jo_force_kind jo_force_rail = {apply, stored, tangent, 0, 0, 0};
