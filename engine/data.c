/* data.c - allocation of the state and work space of one run in one block, and access to it. */
#include "arena.h"
#include "valid.h"
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "force/force.h"
#include "contact/contact.h"
#include "network/network.h"
#include "beam/beam.h"
#include "friction/friction.h"
#include "tree/tree.h"
#include "integrate/integrate.h"
#include "fatigue/fatigue.h"
#include <string.h>
#ifndef JO_NO_ALLOCATION
#include <stdlib.h>
#endif

/* the state, in one block: all quantities that the next step needs from the last one */
static void lay_state(const jo_model *m, jo_arena *a, jo_data *d)
{
    d->state = jo_take(a, 0);
    const size_t state = a->used;
    d->q = jo_take_reals(a, m->nq);
    d->v = jo_take_reals(a, m->nv + m->nstate);
    d->a = jo_take_reals(a, m->nv + m->nstate);
    d->lam = jo_take_reals(a, m->nrow);
    d->turn = jo_take_reals(a, m->nturn);
    d->input = jo_take_reals(a, m->ninput);
    d->locked = jo_take(a, (size_t)m->nlock * sizeof(int));
    d->slip = jo_take(a, (size_t)m->nfriction * sizeof(int));
    d->held = jo_take_reals(a, 2 * m->nlock);
    d->direction = jo_take_reals(a, 2 * m->nfriction);
    d->rub = jo_take_reals(a, 2 * m->nfriction);
    d->happened = jo_take(a, (size_t)m->nevent * sizeof(int));
    d->memory = jo_take(a, (size_t)m->nmemory * sizeof(double));
    d->contact_energy = jo_take_reals(a, jo_contact_energy_size(m));
    jo_integrate_layout_state(m, d, a);
    d->x = jo_take_reals(a, m->nx + m->nu + m->nstate + JO_WIDTH - 1);   /* x, u and states; padding, as u is not aligned */
    d->u = d->x + m->nx;
    d->ud = jo_take_reals(a, m->nu + m->nstate);
    d->state_bytes = a->used - state;
}

/* take all arrays of a jo_data from the arena; without a block only the bytes are counted */
static jo_data *lay_out(const jo_model *m, jo_arena *a)
{
    jo_data spare, *taken = jo_take(a, sizeof(jo_data)), *d = taken ? taken : &spare;
    jo_real **stages[] = {&d->v0, &d->dq, &d->dv, &d->rate, &d->acc};
    lay_state(m, a, d);
    d->q0 = jo_take_reals(a, m->nq);
    for (int i = 0; i < 5; i++) *stages[i] = jo_take_reals(a, m->nv + m->nstate);
    d->force = jo_take_many(a, m->nforce, sizeof *d->force);
    jo_maximal_layout(m, d, a);
    jo_force_layout(m, d, a);
    jo_contact_layout(m, d, a);
    jo_networks_layout(m, d, a);
    jo_contact_record_layout(m, d, a);
    jo_beam_layout(m, d, a);
    jo_newton_layout(m, d, a);
    jo_friction_layout(m, d, a);
    jo_tree_layout(m, d, a);
    if (jo_mixed(m)) jo_split_layout(m, d, a);
    jo_integrate_layout(m, d, a);
    jo_damage_layout(m, d, a);
    return taken;
}

long long jo_data_bytes(const jo_model *m)
{
    jo_arena a = {0, 0};
    lay_out(m, &a);
    return (long long)a.used;
}

long long jo_data_room(const jo_model *m) { return jo_data_bytes(m) + 64; }

/* jo_data in a block that contains zeros */
static jo_data *place(const jo_model *m, void *memory)
{
    jo_arena a = {(char *)memory + (64 - (size_t)memory % 64), 0};
    jo_data *d = lay_out(m, &a);
    jo_forget_step(d);
    jo_nothing_valid(d);
    for (int i = 0; i < m->nbody; i++) {
        d->q[m->body[i].iq + 3] = jo_same(1.0);
        jo_body_setup(&m->body[i], &d->body[i], 0, 0.0);
    }
    jo_select_coordinates(m, d, 0);
    if (jo_mixed(m)) jo_split_setup(m, d);
    if (m->nlink) jo_tree_setup(m, d);
    if (m->nloop) jo_loop_setup(m, d);
    jo_beam_setup(m, d);
    jo_marker_setup(m, d, 0);
    jo_joint_plan(m, d);
    jo_joint_setup(m, d, 0);
    jo_force_setup(m, d);
    jo_networks_setup(m, d);
    if (jo_watched(m)) jo_event_setup(m, d);
    if (m->nmeter) jo_damage_setup(m, d);
    for (int i = 0; i < m->nmarker; i++) {   /* ground markers are constant */
        if (m->marker[i].body >= 0) continue;
        jo_set3(d->marker[i].r, m->marker[i].u0);
        memcpy(d->marker[i].A, m->marker[i].A0, sizeof d->marker[i].A);
    }
    jo_data_gravity(m, d);
    return d;
}

jo_data *jo_data_place(const jo_model *m, void *memory)
{
    memset(memory, 0, (size_t)jo_data_room(m));
    return place(m, memory);
}

/* acceleration -g of the ground markers */
void jo_data_gravity(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nmarker; i++)
        for (int j = 0; j < 3 && m->marker[i].body < 0; j++) d->marker[i].a[j] = -m->gravity[j];
}

#ifndef JO_NO_ALLOCATION   /* exported machines use memory of the caller */
jo_data *jo_data_new(const jo_model *m)
{
    /* of a large block the system provides only the pages that are written: none for unused methods */
    void *block = calloc(1, (size_t)jo_data_room(m));
    jo_data *d = block ? place(m, block) : 0;
    if (d) d->arena = block;
    return d;
}

void jo_data_free(jo_data *d) { if (d) free(d->arena); }
#endif

jo_real *jo_data_q(jo_data *d) { return d->q; }
jo_real *jo_data_v(jo_data *d) { return d->v; }
jo_real *jo_data_a(jo_data *d) { return d->a; }
jo_real *jo_data_lam(jo_data *d) { return d->lam; }
jo_real *jo_data_time(jo_data *d) { return d->time; }
jo_work *jo_data_work(jo_data *d) { return &d->work; }
const jo_work *jo_data_power(const jo_data *d) { return &d->power; }
jo_real *jo_data_input(jo_data *d) { return d->input; }
jo_real *jo_data_turn(jo_data *d) { return d->turn; }
int *jo_data_locked(jo_data *d) { return d->locked; }
int *jo_data_slip(jo_data *d) { return d->slip; }
jo_real *jo_data_direction(jo_data *d) { return d->direction; }
jo_real *jo_data_held(jo_data *d) { return d->held; }
jo_real *jo_data_rub(jo_data *d) { return d->rub; }
double *jo_data_memory(jo_data *d) { return d->memory; }
double *jo_data_bent(jo_data *d) { return jo_beam_bent(d); }
int *jo_data_happened(jo_data *d) { return d->happened; }
jo_real *jo_data_states(const jo_model *m, jo_data *d) { return d->v + m->nv; }
jo_real *jo_data_state_rates(const jo_model *m, jo_data *d) { return d->a + m->nv; }
jo_real *jo_data_joint(jo_data *d) { return d->x; }
jo_counts *jo_data_counts(jo_data *d) { return &d->counts; }
const double *jo_data_log(const jo_data *d) { return jo_log_entries(d); }
int jo_data_logged(const jo_data *d) { return jo_log_count(d); }
int jo_data_error_index(const jo_data *d) { return d->error_index; }

int jo_abi(void) { return JO_ABI; }
int jo_model_size(void) { return (int)sizeof(jo_model); }
int jo_machines(void) { return JO_MACHINES; }

int jo_cpu_level(void)
{
#if defined(__x86_64__) && defined(__GNUC__)
    __builtin_cpu_init();
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma") || !__builtin_cpu_supports("bmi2")) return 1;
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")
        && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") ? 4 : 3;
#else
    return 0;
#endif
}
