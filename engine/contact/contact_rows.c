/* contact_rows.c - numbers of a set of shapes, and the contact that a slot holds. */
#include "contact/contact_rows.h"

int jo_is_contact_set(const jo_force *f) { return f->type == JO_FORCE_contact_set; }

jo_contact_rows jo_contact_rows_of(const jo_force *set)
{
    const jo_contact_set_data *n = (const jo_contact_set_data *)set->data;
    const jo_real *at = set->data + sizeof *n / sizeof(jo_real);
    jo_contact_rows y;
    y.shapes = (int)JO_RE(n->shapes);
    y.tips = (int)JO_RE(n->tips);
    y.surfaces = (int)JO_RE(n->surfaces);
    y.groups = (int)JO_RE(n->groups);
    y.excluded = (int)JO_RE(n->excluded);
    y.slots[0] = (int)JO_RE(n->slots);
    y.slots[1] = (int)JO_RE(n->pairs);
    y.resolve = (int)JO_RE(n->resolve);
    y.shape = (const jo_shape_row *)at;
    y.tip = (const jo_tip_row *)(y.shape + y.shapes);
    y.law = (const jo_law_row *)(y.tip + y.tips);
    y.touching = (const jo_real *)(y.law + y.surfaces * y.surfaces);
    y.meets = y.touching + JO_SHAPE_TYPES * JO_SHAPE_TYPES;
    y.apart = y.meets + y.groups * y.groups;
    y.polytope = y.apart + y.excluded;
    return y;
}

int jo_shape_count(const jo_force *set) { return jo_contact_rows_of(set).shapes; }

int jo_shape_marker(const jo_force *set, int shape)
{
    const jo_contact_rows y = jo_contact_rows_of(set);
    return shape < y.shapes ? (int)JO_RE(y.shape[shape].marker) : -1;
}

/* numbers of the law between two shapes */
static void bind_law(const jo_contact_rows *y, const jo_shape_row *on, const jo_shape_row *of, int second, jo_contact_data *x)
{
    const jo_law_row *law = &y->law[(int)JO_RE(on->surface) * y->surfaces + (int)JO_RE(of->surface)];
    const jo_real curvature = on->curvature[second ? 0 : 1] + of->curvature[1];
    const jo_real mobility = on->mobility[0] + of->mobility[second];
    x->stiffness = JO_RE(law->hertz) > 0.0 ? law->stiffness / jo_sqrt(curvature) : law->stiffness;
    x->exponent = law->exponent;
    x->damping = law->damping;
    x->slowest = law->slowest;
    x->viscous = law->viscous;
    x->full = law->full;
    x->mu_static = law->mu_static;
    x->mu_kinetic = law->mu_kinetic;
    x->shear = law->shear;
    x->mass = 1.0 / mobility;
    x->duration = law->span * pow(JO_RE(x->mass / x->stiffness), 1.0 / (JO_RE(law->exponent) + 1.0));
    x->resolve = jo_same(y->resolve);
    x->restitution = law->restitution;
    x->velocity = law->velocity;
    x->curve = law->curve;
    x->extent = law->extent;
    for (int i = 0; i < 5; i++) x->impedance[i] = law->impedance[i];
    x->rolling = law->rolling;
    x->drilling = law->drilling;
    x->inertia = 1.0 / (on->angular + of->angular);
}

/* numbers of the polytope of a shape, or of the surface if it is touched and is one of triangles, see force_contact_pair.c */
static const jo_real *polytope_of(const jo_contact_rows *y, const jo_shape_row *k, int touched)
{
    const jo_real *data = y->polytope + (int)JO_RE(k->polytope);
    jo_mesh unused;
    jo_real radius;
    return touched || !jo_is_mesh(data) ? data : jo_mesh_read(data, &unused, &radius);
}

/* numbers of the contact of a tip on a shape, or of two polytopes */
static void bind(const jo_contact_rows *y, const jo_force *f, jo_bound *b)
{
    const int pair = b->tip >= y->tips;
    const jo_tip_row *tip = &y->tip[pair ? 0 : b->tip];
    const jo_shape_row *on = &y->shape[b->on], *of = &y->shape[pair ? b->tip - y->tips : (int)JO_RE(tip->shape)];
    jo_contact_data *x = &b->data;
    bind_law(y, on, of, !pair, x);
    x->shape = on->type;
    for (int i = 0; i < 3; i++) x->size[i] = on->size[i];
    b->force = *f;
    b->force.type = pair ? JO_FORCE_contact_pair : JO_FORCE_contact;
    b->force.a = (int)JO_RE(on->marker);
    b->force.b = (int)JO_RE(of->marker);
    b->force.state = f->state + JO_SLOT_STATES;
    b->force.states = f->states - JO_SLOT_STATES;
    b->force.data = (const jo_real *)x;
    if (pair) {
        b->polytope[0] = polytope_of(y, on, 1);
        b->polytope[1] = polytope_of(y, of, 0);
        const jo_law_row *law = &y->law[(int)JO_RE(on->surface) * y->surfaces + (int)JO_RE(of->surface)];
        b->curvature[0] = on->curvature[1];
        b->curvature[1] = of->curvature[1];
        b->polytope[2] = JO_RE(law->hertz) > 0.0 ? b->curvature : 0;
        b->force.user = b->polytope;
        return;
    }
    x->radius = tip->radius;
    x->ring = tip->ring;
    x->around = tip->around;
    for (int i = 0; i < 3; i++) {
        x->centre[i] = tip->centre[i];
        x->axes[i] = tip->axes[i];
    }
}

const jo_force *jo_bound_force(const jo_data *d, const jo_force *f)
{
    const jo_real *state = jo_slot_states(d, f);
    const int on = (int)JO_RE(state[0]) - 1, tip = (int)JO_RE(state[1]) - 1;
    if (on < 0) return 0;
    const jo_contact_slot_data *n = (const jo_contact_slot_data *)f->data;
    const int number = (int)JO_RE(n->number);
    jo_bound *b = &d->contact_sets.bound[number];
    if (JO_RE(b->data.exponent) == 0.0 || b->on != on || b->tip != tip) {   /* the numbers of the last pair are kept */
        const jo_contact_rows y = jo_contact_rows_of(f - (number - (int)JO_RE(n->set)));
        b->on = on;
        b->tip = tip;
        bind(&y, f, b);
    }
    return &b->force;
}

/* p = (6 N E*^2 / (pi^3 R^2))^(1/3), R the radius of the law; its stiffness at a curvature of 1 is 4/3 E* */
double jo_slot_pressure(const jo_data *d, const jo_force *slot, double N)
{
    const jo_real *state = jo_slot_states(d, slot);
    const jo_contact_slot_data *n = (const jo_contact_slot_data *)slot->data;
    const jo_contact_rows y = jo_contact_rows_of(slot - ((int)JO_RE(n->number) - (int)JO_RE(n->set)));
    const int on = (int)JO_RE(state[0]) - 1, tip = (int)JO_RE(state[1]) - 1;
    if (on < 0 || tip >= y.tips) return 0.0;   /* faces of polytopes have no curvature */
    const jo_shape_row *a = &y.shape[on], *b = &y.shape[(int)JO_RE(y.tip[tip].shape)];
    const jo_law_row *law = &y.law[(int)JO_RE(a->surface) * y.surfaces + (int)JO_RE(b->surface)];
    if (!(JO_RE(law->hertz) > 0.0)) return 0.0;
    const double modulus = 0.75 * JO_RE(law->stiffness), curvature = JO_RE(a->curvature[0] + b->curvature[1]);
    return cbrt(6.0 * N * modulus * modulus * curvature * curvature) / JO_PI;
}

void jo_slot_shapes(const jo_data *d, const jo_force *slot, int *shapes)
{
    const jo_real *state = jo_slot_states(d, slot);
    const jo_contact_slot_data *n = (const jo_contact_slot_data *)slot->data;
    const jo_contact_rows y = jo_contact_rows_of(slot - ((int)JO_RE(n->number) - (int)JO_RE(n->set)));
    const int tip = (int)JO_RE(state[1]) - 1;
    shapes[0] = (int)JO_RE(state[0]) - 1;
    shapes[1] = tip < 0 ? -1 : tip < y.tips ? (int)JO_RE(y.tip[tip].shape) : tip - y.tips;
}

double jo_shape_gap(const jo_contact_rows *y, const jo_data *d, int on, const jo_real *place)
{
    const jo_shape_row *k = &y->shape[on];
    const jo_marker_work *w = &d->marker[(int)JO_RE(k->marker)];
    jo_real r[3], x[3];
    jo_distance found;
    jo_set3(r, place);
    jo_sub3(r, w->r);
    jo_mul3t(x, w->A, r);
    jo_shape_distance((int)JO_RE(k->type), k->size, x, &found);
    return JO_RE(found.gap);
}

double jo_tip_gap(const jo_contact_rows *y, const jo_data *d, int on, int tip)
{
    const jo_tip_row *t = &y->tip[tip];
    const jo_marker_work *a = &d->marker[(int)JO_RE(y->shape[on].marker)];
    const jo_marker_work *b = &d->marker[(int)JO_RE(y->shape[(int)JO_RE(t->shape)].marker)];
    jo_real place[3], sine = {0.0}, below = {0.0};
    jo_mul3(place, b->A, t->centre);
    jo_add3(place, b->r);
    if (JO_RE(t->ring) > 0.0) {   /* above a half-space: its lowest point */
        const jo_real along = a->A[2] * b->A[2] + a->A[5] * b->A[5] + a->A[8] * b->A[8];
        sine = jo_sqrt(jo_larger(0.0, JO_RE(1.0 - along * along)));
    }
    if (JO_RE(t->axes[0]) > 0.0) {   /* the same of an ellipsoid */
        for (int i = 0; i < 3; i++) {
            const jo_real along = a->A[2] * b->A[i] + a->A[5] * b->A[3 + i] + a->A[8] * b->A[6 + i];
            below += t->axes[i] * t->axes[i] * along * along;
        }
        below = jo_sqrt(below);
    }
    return jo_shape_gap(y, d, on, place) - JO_RE(t->radius + t->ring * sine + below);
}

double jo_polytope_gap(const jo_contact_rows *y, const jo_data *d, int on, int of, double most)
{
    const jo_marker_work *a = &d->marker[(int)JO_RE(y->shape[on].marker)], *b = &d->marker[(int)JO_RE(y->shape[of].marker)];
    jo_polytope p, q;
    jo_separated s;
    jo_real x[3], r[3], R[9];
    jo_set3(x, b->r);
    jo_sub3(x, a->r);
    jo_mul3t(r, a->A, x);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) R[3 * i + j] = a->A[i] * b->A[j] + a->A[3 + i] * b->A[3 + j] + a->A[6 + i] * b->A[6 + j];
    jo_polytope_read(polytope_of(y, &y->shape[of], 0), &q);
    jo_polytope_place(&q, r, R);
    const jo_real *touched = polytope_of(y, &y->shape[on], 1);
    if (jo_is_mesh(touched)) {
        jo_mesh mesh;
        jo_mesh_gap found;
        jo_mesh_read(touched, &mesh, &p.radius);
        jo_mesh_distance(&mesh, &q, JO_RE(p.radius + q.radius), &found);
        return found.gap;
    }
    jo_polytope_read(touched, &p);
    jo_polytope_place(&p, 0, 0);
    const double radii = JO_RE(p.radius + q.radius), apart = jo_separation_at_least(&p, &q) - radii;
    if (apart > most) return apart;
    jo_separation(&p, &q, 0, &s);
    return s.gap - radii;
}

/* smallest power of 2 from n on */
static int power_of_two(int n)
{
    int size = 1;
    while (size < n) size *= 2;
    return size;
}

void jo_contact_sets_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    d->contact_sets.count = 0;
    d->contact_sets.nstate = m->nstate;
    for (int i = 0; i < m->nforce; i++) d->contact_sets.count += jo_is_contact_set(&m->force[i]);
    d->contact_sets.search = jo_take_many(a, d->contact_sets.count, sizeof *d->contact_sets.search);
    d->contact_sets.bound = jo_take_many(a, d->contact_sets.count ? m->nforce : 0, sizeof *d->contact_sets.bound);
    for (int i = 0, k = 0; i < m->nforce && k < d->contact_sets.count; i++) {
        if (!jo_is_contact_set(&m->force[i])) continue;
        const jo_contact_rows y = jo_contact_rows_of(&m->force[i]);
        jo_contact_search spare, *s = a->base ? &d->contact_sets.search[k] : &spare;
        s->set = i;
        s->swept = jo_take_many(a, y.shapes, sizeof *s->swept);
        s->heads = power_of_two(2 * y.shapes);
        s->head = jo_take_ints(a, s->heads);
        s->wide = jo_take_ints(a, y.shapes);
        s->near = jo_take_many(a, jo_slots(&y), sizeof *s->near);
        s->places = power_of_two(2 * jo_slots(&y));
        s->place = jo_take_ints(a, s->places);
        k++;
    }
}
