/* force_contact_slot.c - contact of a pair of shapes that is found at run time: the law of force_contact.c or force_contact_pair.c between the shapes
 * that the first two states of the slot name (contact_rows.h). A free slot exerts no force. */
#include "force/force.h"
#include "contact/contact.h"
#include "force/contact_point.h"

static const jo_force_kind *kind_of(const jo_force *contact)
{
    return contact->type == JO_FORCE_contact_pair ? &jo_force_contact_pair : &jo_force_contact;
}

void jo_start_slot(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *state)
{
    const jo_force *contact = jo_bound_force(d, f);
    kind_of(contact)->start(m, d, contact, state + JO_SLOT_STATES);
}

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *out)
{
    static const jo_force_work none = {{0.0}, 0.0, 0.0, 0.0};
    const jo_force *contact = jo_bound_force(d, f);
    jo_contact_hold_states(m, d, stage, f->state, contact ? JO_SLOT_STATES : f->states);
    if (contact) return (*kind_of(contact)->apply)(m, d, stage, contact, out);
    *out = none;
    return JO_OK;
}

static jo_real stored_in_slot(const jo_data *d, const jo_force *f)
{
    const jo_force *contact = jo_bound_force(d, f);
    return contact ? kind_of(contact)->stored(d, contact) : jo_same(0.0);
}

static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *y)
{
    const jo_force *contact = jo_bound_force(d, f);
    return contact ? (*kind_of(contact)->tangent)(m, d, stage, contact, y) : JO_OK;
}

/* free, until jo_find_contacts binds a pair */
static void free_slot(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x)
{
    (void)m; (void)d;
    for (int i = 0; i < f->states; i++) x[i] = jo_same(0.0);
}

static void slot_nominals(const jo_model *m, const jo_force *f, double duration, double *x)
{
    (void)m; (void)duration;
    for (int i = 0; i < f->states; i++) x[i] = 1.0;
}

static jo_real update_slot(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x)
{
    const jo_force *contact = jo_bound_force(d, f);
    return contact ? kind_of(contact)->yielding->update(m, d, contact, x + JO_SLOT_STATES) : jo_same(0.0);
}

static jo_real slot_margin(const jo_model *m, const jo_data *d, const jo_force *f)
{
    const jo_force *contact = jo_bound_force(d, f);
    return contact ? kind_of(contact)->yielding->margin(m, d, contact) : jo_same(1.0);
}

static int slot_jumps(const jo_force *f, const jo_real *before, const jo_real *after)
{
    jo_force own = *f;
    own.state += JO_SLOT_STATES;
    own.states -= JO_SLOT_STATES;
    own.type = jo_slot_pair_points(f) ? JO_FORCE_contact_pair : JO_FORCE_contact;
    return kind_of(&own)->yielding->jumps(&own, before + JO_SLOT_STATES, after + JO_SLOT_STATES);
}

static double longest_step_of_slot(const jo_model *m, const jo_data *d, const jo_force *f, int explicit_method)
{
    const jo_force *contact = jo_bound_force(d, f);
    return contact ? kind_of(contact)->yielding->longest_step(m, d, contact, explicit_method) : INFINITY;
}

static int ease_slot(const jo_model *m, const jo_data *d, const jo_force *f, jo_real *x)
{
    const jo_force *contact = jo_bound_force(d, f);
    return contact ? kind_of(contact)->yielding->ease(m, d, contact, x + JO_SLOT_STATES) : 0;
}

static int slot_approach(const jo_model *m, const jo_data *d, const jo_force *f, jo_approach *y)
{
    const jo_force *contact = jo_bound_force(d, f);
    return contact ? kind_of(contact)->yielding->approach(m, d, contact, y) : 0;
}

static int slot_strikes(const jo_model *m, const jo_data *d, const jo_force *f, struct jo_strike *list, int room)
{
    const jo_force *contact = jo_bound_force(d, f);
    return contact ? kind_of(contact)->yielding->strikes(m, d, contact, list, room) : 0;
}

/* `x` binds the slot as the present states do */
static int slot_touches(const jo_model *m, const jo_data *d, const jo_force *f, const jo_real *x, jo_touch *y, jo_real *sums)
{
    const jo_force *contact = jo_bound_force(d, f);
    const int count = contact ? kind_of(contact)->yielding->touches(m, d, contact, x + JO_SLOT_STATES, y, sums) : 0;
    int shapes[2];
    jo_slot_shapes(d, f, shapes);
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < 2; j++) y[i].shapes[j] = shapes[j];
        y[i].pressure = jo_slot_pressure(d, f, y[i].N);
    }
    return count;
}

static const jo_yielding yielding = {update_slot, slot_margin, slot_jumps, longest_step_of_slot, ease_slot, slot_approach, slot_strikes, slot_touches, 0};
const jo_force_kind jo_force_contact_slot = {apply, stored_in_slot, tangent, free_slot, slot_nominals, &yielding};
