/* step_closure.c - the end of a step of fixed work: prescribed coordinates, loops, projection. */
#include "valid.h"
#include "maximal/maximal.h"
#include "tree/tree.h"
#include "integrate/integrate.h"

/* prescribed coordinates and loops; the other coordinates of a tree need no projection */
int jo_close_step(const jo_model *m, jo_data *d, const jo_solver *s, const jo_stage *stage)
{
    jo_state_changed(d);
    if (jo_tree_active(d)) {
        jo_tree_prescribe_motion(m, d);
        if (s->projection && jo_nmaximal(d)) jo_project(m, d, stage);
        else if (s->projection) jo_tree_close_loops(m, d);
    } else if (s->projection) jo_project(m, d, stage);
    return JO_OK;
}
