/* left_out.c - empty functions in place of the sources that the build with lanes omits: beams, frictions, events, damage meters, moving
 * loads, functions of the user, loops of trees, trees on flexible bodies, implicit and adaptive steps. ensemble.py excludes models that need
 * any of these. */
#include "maximal/maximal.h"
#include "beam/beam.h"
#include "force/force.h"
#include "contact/contact.h"
#include "network/network.h"
#include "newton/newton.h"
#include "friction/friction.h"
#include "tree/tree.h"
#include "integrate/integrate.h"
#include "fatigue/fatigue.h"

/* memory of the folders that are left out */
void jo_beam_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    (void)m; (void)d; (void)a;
}
void jo_newton_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    (void)m; (void)d; (void)a;
}
void jo_friction_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    (void)m; (void)d; (void)a;
}
void jo_damage_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    (void)m; (void)d; (void)a;
}

/* beams */
void jo_beam_accept(jo_data *d)
{
    (void)d;
}
int jo_beam_forces(const jo_model *m, jo_data *d, const jo_real *a)
{
    (void)m; (void)d; (void)a;
    return 0;
}
void jo_beam_reset_history(jo_data *d)
{
    (void)d;
}
jo_real jo_beam_kinetic(const jo_model *m, const jo_data *d)
{
    (void)m; (void)d;
    return jo_same(0.0);
}
void jo_coupled_lag(const jo_model *m, jo_data *d, const jo_real *x, const jo_real *z)
{
    (void)m; (void)d; (void)x; (void)z;
}
void jo_coupled_second(const jo_model *m, jo_data *d, const jo_real *a, const jo_real *x, const jo_real *z)
{
    (void)m; (void)d; (void)a; (void)x; (void)z;
}
void jo_beam_section(const jo_data *d, int i, jo_real *y)
{
    (void)d; (void)i; (void)y;
}
void jo_beam_setup(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
}
jo_real jo_beam_stored(const jo_data *d)
{
    (void)d;
    return jo_same(0.0);
}
int jo_couples(const jo_model *m, const jo_stage *stage)
{
    (void)m; (void)stage;
    return 0;
}
int jo_coupled_accelerations(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    (void)m; (void)d; (void)stage;
    return JO_NO_CONVERGENCE;
}
void jo_coupled_correction(const jo_model *m, jo_data *d, jo_real *increment)
{
    (void)m; (void)d; (void)increment;
}

/* frictions, events, damage meters */
int jo_friction_solve(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    (void)m; (void)d; (void)stage;
    return 0;
}
void jo_friction_share(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
}
void jo_friction_push_contacts(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
}
void jo_friction_apply_force(const jo_model *m, jo_data *d, int i)
{
    (void)m; (void)d; (void)i;
}
int jo_friction_initialise_states(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
    return 0;
}
int jo_watched(const jo_model *m)
{
    (void)m;
    return 0;
}
void jo_event_setup(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
}
int jo_event_step(const jo_model *m, jo_data *d, const jo_solver *s)
{
    (void)m; (void)d; (void)s;
    return JO_NO_CONVERGENCE;
}
int jo_log_room(const jo_model *m)
{
    (void)m;
    return 0;
}
int jo_log_has_room(const jo_model *m, const jo_data *d)
{
    (void)m; (void)d;
    return 1;
}
void jo_damage_setup(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
}
double jo_meter_damage(const jo_meter *r, const double *memory, int residue, double *scratch)
{
    (void)r; (void)memory; (void)residue; (void)scratch;
    return 0.0;
}
int jo_measure(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
    return 0;
}

/* Newton's matrix of implicit steps, and adaptive steps */
jo_block jo_newton_find(const jo_model *m, jo_data *d, int x, int y)
{
    (void)m; (void)d; (void)x; (void)y;
    return (jo_block){0, 0};
}
void jo_element_start(jo_element *e, int a, int b)
{
    (void)e; (void)a; (void)b;
}
void jo_element_skew(jo_element *e, int i, int j, jo_real s, const jo_real *a)
{
    (void)e; (void)i; (void)j; (void)s; (void)a;
}
void jo_element_gradients(const jo_model *m, const jo_data *d, int coordinate, jo_gradients *g)
{
    (void)m; (void)d; (void)coordinate; (void)g;
}
void jo_element_along(const jo_data *d, jo_element *e, int coordinate, const jo_gradients *g, jo_real f, jo_real fs, jo_real frate)
{
    (void)d; (void)e; (void)coordinate; (void)g; (void)f; (void)fs; (void)frate;
}
void jo_element_cross(const jo_data *d, jo_element *e, int coordinate, int of_a, int of_b, const jo_gradients *g, jo_real fs, jo_real frate)
{
    (void)d; (void)e; (void)coordinate; (void)of_a; (void)of_b; (void)g; (void)fs; (void)frate;
}
void jo_element_finish(const jo_model *m, jo_data *d, const jo_element *e)
{
    (void)m; (void)d; (void)e;
}
int jo_step_alpha(const jo_model *m, jo_data *d, const jo_solver *s)
{
    (void)m; (void)d; (void)s;
    return JO_NO_CONVERGENCE;
}
int jo_step_dopri(const jo_model *m, jo_data *d, const jo_solver *s)
{
    (void)m; (void)d; (void)s;
    return JO_NO_CONVERGENCE;
}

/* loops, frictions and flexible carriers of trees */
int jo_loop_rows(const jo_model *m, int i)
{
    (void)m; (void)i;
    return 0;
}
void jo_loop_setup(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
}
int jo_loop_evaluate(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    (void)m; (void)d; (void)stage;
    return JO_NO_CONVERGENCE;
}
jo_real jo_loop_power(const jo_model *m, const jo_data *d)
{
    (void)m; (void)d;
    return jo_same(0.0);
}
int jo_tree_close_loops(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
    return 1;
}
void jo_tree_hold_sticking(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
}
void jo_tree_lock_sticking(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
}
void jo_hybrid_update_bodies(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
}
void jo_hybrid_accept_state(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
}
int jo_hybrid_condense(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    (void)m; (void)d; (void)stage;
    return JO_NO_CONVERGENCE;
}
void jo_hybrid_forward_pass_2(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
}

/* contacts in the matrix of a Rosenbrock method */
void jo_contact_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    (void)m; (void)d; (void)a;
}
void jo_brief_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    (void)m; (void)d; (void)a;
}
void jo_impulse_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    (void)m; (void)d; (void)a;
}
int jo_contacts_fit(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
    return 1;
}
int jo_contacts_begin(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
    return 0;
}
void jo_contact_carry(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
}
void jo_contact_state_rates(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    (void)m; (void)d; (void)stage;
}
int jo_tree_takes_contacts(const jo_model *m)
{
    (void)m;
    return 0;
}
void jo_tree_contact_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    (void)m; (void)d; (void)a;
}
void jo_tree_contacts(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    (void)m; (void)d; (void)stage;
}

/* sets of shapes that touch */
int jo_is_contact_set(const jo_force *f)
{
    (void)f;
    return 0;
}
int jo_shape_marker(const jo_force *set, int shape)
{
    (void)set; (void)shape;
    return -1;
}
void jo_contact_sets_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    (void)m; (void)d; (void)a;
}
int jo_find_contacts(const jo_model *m, jo_data *d, double *length, int *jumped)
{
    (void)m; (void)d; (void)length;
    *jumped = 0;
    return JO_OK;
}

/* networks of states */
int jo_is_network(const jo_force *f)
{
    (void)f;
    return 0;
}
int jo_network_rows(const jo_model *m)
{
    (void)m;
    return 0;
}
int jo_network_coordinate(const jo_force *f, int k)
{
    (void)f; (void)k;
    return -1;
}
jo_real jo_network_value(const jo_model *m, const jo_data *d, int network, int number)
{
    (void)m; (void)d; (void)network; (void)number;
    return jo_same(NAN);
}
jo_network *jo_network_of_memory(const jo_data *d, const jo_force *f)
{
    (void)d; (void)f;
    return 0;
}
jo_signal_work jo_delayed(const jo_model *m, const jo_data *d, int force, jo_real time)
{
    (void)m; (void)d; (void)force; (void)time;
    const jo_signal_work y = {jo_same(NAN), jo_same(NAN), jo_same(NAN)};
    return y;
}
void jo_network_coordinates(const jo_model *m, jo_data *d, const jo_network *w)
{
    (void)m; (void)d; (void)w;
}
void jo_networks_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    (void)m; (void)a;
    d->networks.count = 0;
}
void jo_networks_setup(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
}
void jo_networks_carry(const jo_model *m, jo_data *d)
{
    (void)m; (void)d;
}
int jo_networks_separate(const jo_model *m, const jo_data *d)
{
    (void)m; (void)d;
    return 0;
}
void jo_networks_respond(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    (void)m; (void)d; (void)stage;
}
void jo_networks_state_rates(const jo_model *m, jo_data *d, const jo_stage *stage)
{
    (void)m; (void)d; (void)stage;
}

/* records of contacts */
int jo_contact_energy_size(const jo_model *m)
{
    (void)m;
    return 0;
}
void jo_contact_record_layout(const jo_model *m, jo_data *d, jo_arena *a)
{
    (void)m; (void)d; (void)a;
}
void jo_contact_sensor(const jo_model *m, const jo_data *d, const jo_sensor *s, jo_real *y)
{
    (void)m; (void)d; (void)s; (void)y;
}
void jo_record_step(const jo_model *m, jo_data *d, int k)
{
    (void)m; (void)d; (void)k;
}
void jo_record_change(const jo_model *m, jo_data *d, int k, const jo_real *x, int jumped)
{
    (void)m; (void)d; (void)k; (void)x; (void)jumped;
}
jo_real jo_bristles(const jo_model *m, const jo_data *d)
{
    (void)m; (void)d;
    return jo_same(0.0);
}
void jo_contact_list_begins(jo_data *d)
{
    (void)d;
}
int jo_contact_list_has_room(const jo_model *m, const jo_data *d)
{
    (void)m; (void)d;
    return 1;
}

/* kinds of force that no file of this build defines */
#define LEFT_OUT(name, ...) const jo_force_kind jo_force_##name __attribute__((weak)) = {0, 0, 0, 0, 0, 0};
JO_FORCES(LEFT_OUT)
