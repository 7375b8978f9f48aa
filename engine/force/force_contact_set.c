/* force_contact_set.c - a set of shapes: its numbers are read by its slots, which exert the forces. */
#include "force/force.h"

static int apply(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, jo_force_work *out)
{
    static const jo_force_work none = {{0.0}, 0.0, 0.0, 0.0};
    (void)m; (void)d; (void)stage; (void)f;
    *out = none;
    return JO_OK;
}

static int tangent(const jo_model *m, jo_data *d, const jo_stage *stage, const jo_force *f, const jo_force_work *unused)
{
    (void)m; (void)d; (void)stage; (void)f; (void)unused;
    return JO_OK;
}

const jo_force_kind jo_force_contact_set = {apply, 0, tangent, 0, 0, 0};
