/* data.c - the state and workspace of one run: one allocation. */
#include "valid.h"
#include "arena.h"
#include "maximal/maximal.h"
#include "newton/newton.h"
#include "beam/beam.h"
#include "tree/tree.h"
#include "integrate/integrate.h"
#include "fatigue/fatigue.h"
#include <string.h>
#ifndef JO_NO_ALLOCATION
#include <stdlib.h>
#endif

/* what the next step needs from the last, one block */
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
    d->algorithmic = jo_take_reals(a, m->nv + m->nstate);
    d->end_a = jo_take_reals(a, m->nv + m->nstate);
    d->end_q = jo_take_reals(a, m->nq);
    d->end_v = jo_take_reals(a, m->nv + m->nstate);
    d->end_lam = jo_take_reals(a, m->nrow);
    d->end_time = jo_take_reals(a, 1);
    d->tree.x = jo_take_reals(a, m->nx + m->nu + m->nstate + JO_WIDTH - 1);   /* u too, which need not lie where vectors of the registers end */
    d->tree.u = d->tree.x + m->nx;
    d->tree.ud = jo_take_reals(a, m->nu + m->nstate);
    d->state_bytes = a->used - state;
    d->kept.state = jo_take(a, jo_watched(m) ? d->state_bytes : 0);   /* the same once more */
}

/* stages of a step and the state at its end */
static void lay_steps(const jo_model *m, jo_arena *a, jo_data *d)
{
    const int nw = m->nv + m->nstate;
    d->q0 = jo_take_reals(a, m->nq);
    d->v0 = jo_take_reals(a, nw);
    d->dq = jo_take_reals(a, nw);
    d->dv = jo_take_reals(a, nw);
    d->rate = jo_take_reals(a, nw);
    d->acc = jo_take_reals(a, nw);
    d->slopes = jo_take(a, (size_t)m->nstate * sizeof *d->slopes);
    d->stages = jo_take_reals(a, 7 * (2 * nw + 3));
    d->change = jo_take_reals(a, 2 * nw + 3);
    d->q1 = jo_take_reals(a, m->nq);
    d->v1 = jo_take_reals(a, nw);
    d->lam1 = jo_take_reals(a, m->nrow);
    d->extent = jo_take(a, (3 * (size_t)m->nbody + (size_t)m->nstate) * sizeof(double));
    d->nominal = jo_take(a, (size_t)m->nstate * sizeof(double));
}

/* arrays of the bodies, of a spare one while bytes are only counted */
static void lay_bodies(const jo_model *m, jo_arena *a, jo_data *d)
{
    for (int i = 0; i < m->nbody; i++) {
        jo_body_work spare, *w = a->base ? &d->body[i] : &spare;
        const int np = m->body[i].np;
        w->p = jo_take_reals(a, np);
        w->pd = jo_take_reals(a, np);
        w->D = jo_take_reals(a, 6 * np);
        w->B = jo_take_reals(a, 3 * np);
        w->G = jo_take_reals(a, 3 * np);
        w->Bw = jo_take_reals(a, 3 * np);
        w->fp = jo_take_reals(a, np);
        w->yp = jo_take_reals(a, np);
        w->extra = jo_take_reals(a, np);
        w->Dd = jo_take_reals(a, 6 * np);
        w->H = jo_take_reals(a, 3 * np);
        w->carried = jo_carries_trees(m, i) ? jo_take_reals(a, 36) : 0;
        for (int s = 0; s < 2; s++) {
            w->set[s].weight = jo_take_reals(a, np);
            w->set[s].I3w = jo_take_reals(a, 3 * np);
        }
    }
}

/* the same of markers */
static void lay_markers(const jo_model *m, jo_arena *a, jo_data *d)
{
    for (int i = 0; i < m->nmarker; i++) {
        jo_marker_work spare, *w = a->base ? &d->marker[i] : &spare;
        const jo_marker *k = &m->marker[i];
        w->shapes = k->chi ? jo_take_reals(a, 6 * m->body[k->body].np) : 0;
        w->Phi = k->chi && k->Phi ? w->shapes : k->Phi;
        w->Psi = k->chi && k->Psi && w->shapes ? w->shapes + 3 * m->body[k->body].np : k->Psi;
    }
    for (int i = 0; i < m->nactive; i++) {
        jo_marker_work spare, *w = a->base ? &d->marker[i] : &spare;
        const int np = m->marker[i].body < 0 ? 0 : m->body[m->marker[i].body].np;
        for (int s = 0; s < 2; s++) {
            w->set[s].Phiw = jo_take_reals(a, 3 * np);
            w->set[s].Psiw = jo_take_reals(a, 3 * np);
        }
        const int row = m->marker[i].body < 0 ? 0 : jo_pad(6 + m->body[m->marker[i].body].n);
        w->L = jo_take_reals(a, 6 * row);
        w->W = jo_take_reals(a, 12 * row);
    }
}

/* joints, and the matrix of their multipliers with its plan */
static void lay_joints(const jo_model *m, jo_arena *a, jo_data *d)
{
    d->S = jo_take_reals(a, JO_BLOCK * m->nblock);
    d->S0 = jo_take_reals(a, m->redundant >= 0 ? JO_BLOCK * m->nblock : 0);
    for (int s = 0; s < 2; s++) d->gram[s] = jo_take_reals(a, 36 * m->npair);
    d->joint = jo_take(a, (size_t)(m->njoint + m->nhub) * sizeof(jo_joint_work));
    for (int i = 0; i < m->njoint; i++) {
        jo_joint_work spare, *w = a->base ? &d->joint[i] : &spare;
        w->side = jo_take(a, (size_t)m->joint[i].nside * sizeof *w->side);
    }
    const int nbelow = m->nblock - m->ncolumn, nupdate = m->ncolumn ? m->update_first[m->ncolumn] : 0;
    d->pairs = jo_take(a, (size_t)m->npair * sizeof *d->pairs);
    d->pulls = jo_take(a, (size_t)m->npull * sizeof *d->pulls);
    d->hubs = jo_take(a, (size_t)m->nhub * sizeof *d->hubs);
    d->columns = jo_take(a, (size_t)m->ncolumn * sizeof *d->columns);
    d->belows = jo_take(a, (size_t)nbelow * sizeof *d->belows);
    d->updates = jo_take(a, (size_t)nupdate * sizeof *d->updates);
    d->fills = jo_take(a, (size_t)nbelow * sizeof *d->fills);
}

/* Newton's matrix and the accelerations of coupled masses */
static void lay_newton(const jo_model *m, jo_arena *a, jo_data *d)
{
    d->N = jo_take_reals(a, m->nnewton + JO_PAD);
    d->x = jo_take_reals(a, m->nv + m->nrow);
    d->whole = jo_take_reals(a, m->nv + m->nrow);
    d->base = jo_take_reals(a, m->nv);
    d->base_lam = jo_take_reals(a, m->nrow);
    d->stiff = jo_take_reals(a, JO_BEAM_KEPT * m->nbeam);
    d->lag = jo_take_reals(a, m->nv);
    d->sum = jo_take_reals(a, m->nv);
    d->pivot = jo_take(a, (size_t)(m->nv + m->nrow) * sizeof(int));
    d->unit = jo_take(a, (size_t)(m->nv + m->nrow) * sizeof(double));
    d->unit_of_row = jo_take(a, (size_t)(m->nv + m->nrow) * sizeof(double));
}

/* the iteration for forces of friction */
static void lay_friction(const jo_model *m, jo_arena *a, jo_data *d)
{
    jo_anderson *x = &d->anderson;
    x->sliding = jo_take(a, (size_t)m->nfriction * sizeof(jo_sliding_friction));
    x->coordinate = jo_take(a, 2 * (size_t)m->nfriction * sizeof(int));
    x->lam = jo_take_reals(a, m->nfriction ? m->nrow : 0);
    x->reach = jo_take_reals(a, m->nfriction ? JO_REACH * m->nrow : 0);
    jo_real **arrays[5] = {&x->f, &x->g, &x->r, &x->before, &x->change};
    for (int i = 0; i < 5; i++) *arrays[i] = jo_take_reals(a, 2 * m->nfriction);
    for (int i = 0; i < JO_PAIRS; i++) {
        x->dF[i] = jo_take_reals(a, 2 * m->nfriction);
        x->dR[i] = jo_take_reals(a, 2 * m->nfriction);
        x->Q[i] = jo_take_reals(a, 2 * m->nfriction);
    }
}

/* links of a tree, with the ground, and what forces need of it */
static void lay_tree(const jo_model *m, jo_arena *a, jo_data *d)
{
    jo_tree *t = &d->tree;
    jo_real **along[4] = {&t->tau, &t->stiffness, &t->damping, &t->added_tau};
    for (int i = 0; i < 4; i++) *along[i] = jo_take_reals(a, m->nu);
    t->drive_force = jo_take_reals(a, m->nlink);
    t->maximal_copy = jo_take_reals(a, m->nlink ? m->nq + m->nv : 0);
    t->link = jo_take(a, m->nlink ? (size_t)(m->nlink + 1) * jo_link_bytes() : 0);
    t->response = jo_take(a, m->nlink ? (size_t)(m->nlink + 1) * jo_link_response_bytes() : 0);
    t->constants = jo_take(a, (size_t)m->nlink * jo_link_constant_bytes());
    t->hinge = jo_take(a, (size_t)m->nlink * sizeof(int));
    t->marker = jo_take(a, m->nlink ? (size_t)m->nactive * sizeof(int) : 0);
    t->coordinate = jo_take(a, m->nlink ? (size_t)m->ncoordinate * sizeof(int) : 0);
    t->body = jo_take(a, m->nlink ? (size_t)m->nbody * sizeof(int) : 0);
    if (jo_mixed(m)) jo_split_layout(m, d, a);
}

/* loops of a tree and the matrices of their rows */
static void lay_loops(const jo_model *m, jo_arena *a, jo_data *d)
{
    jo_tree *t = &d->tree;
    t->loop = jo_take(a, (size_t)m->nloop * jo_loop_bytes());
    t->reach = jo_take(a, (size_t)m->nreach * jo_reach_bytes());
    t->loop_marker = jo_take(a, (size_t)m->nloop * JO_MAX_SIDES * sizeof(int));
    t->gram = jo_take(a, (size_t)m->nloop * sizeof(jo_gram));
    t->ngroup = 0;
    for (int i = 0; i < m->nloop; i++) {
        jo_gram spare, *g = a->base ? &t->gram[t->ngroup] : &spare;
        const int n = jo_loop_rows(m, i);
        if (!n) continue;
        t->ngroup++;
        g->n = n;
        g->ld = jo_pad(n) + 8;   /* whole vectors are written from any row on */
        g->S = jo_take_reals(a, (n + 1) * g->ld);   /* and a right-hand side */
        g->inverse = jo_take_reals(a, n);
        g->y = jo_take_reals(a, n);
        g->scale = jo_take(a, (size_t)n * sizeof(double));
        g->order = jo_take(a, (size_t)n * sizeof(int));
    }
}

/* what events and damage meters watch */
static void lay_watch(const jo_model *m, jo_arena *a, jo_data *d, jo_sensor **watched, jo_sensor **metered)
{
    double **event_values[] = {&d->level, &d->below, &d->above, &d->trial, &d->scale};
    for (int i = 0; i < 5; i++) *event_values[i] = jo_take(a, (size_t)jo_watched(m) * sizeof(double));
    d->side = jo_take(a, (size_t)jo_watched(m) * sizeof(int));
    d->log = jo_take(a, 3 * (size_t)jo_log_room(m) * sizeof(double));
    d->measured = jo_take_reals(a, m->nevent ? m->nout : 0);
    *watched = jo_take(a, m->nevent ? (size_t)m->nsensor * sizeof(jo_sensor) : 0);
    d->reading = jo_take_reals(a, m->nmeter ? m->nout : 0);
    d->scratch = jo_take(a, (size_t)jo_damage_scratch(m) * sizeof(double));
    *metered = jo_take(a, m->nmeter ? (size_t)m->nsensor * sizeof(jo_sensor) : 0);
}

static jo_data *lay_out(const jo_model *m, jo_arena *a, jo_sensor **watched, jo_sensor **metered)
{
    jo_data spare_data, *taken = jo_take(a, sizeof(jo_data)), *d = taken ? taken : &spare_data;
    lay_state(m, a, d);
    lay_steps(m, a, d);
    d->body = jo_take(a, (size_t)m->nbody * sizeof(jo_body_work));
    d->nbeam = m->nbeam;
    d->beam = jo_take(a, (size_t)m->nbeam * sizeof(jo_beam_work));
    d->bent = jo_take(a, 2 * (size_t)m->nbeam * sizeof(double));
    d->marker = jo_take(a, (size_t)m->nmarker * sizeof(jo_marker_work));
    d->coordinate = jo_take(a, (size_t)m->ncoordinate * sizeof(jo_coordinate_work));
    d->force = jo_take(a, (size_t)m->nforce * sizeof(jo_force_work));
    lay_joints(m, a, d);
    lay_newton(m, a, d);
    lay_friction(m, a, d);
    lay_tree(m, a, d);
    lay_loops(m, a, d);
    lay_watch(m, a, d, watched, metered);
    lay_bodies(m, a, d);
    lay_markers(m, a, d);
    return taken;
}

long long jo_data_bytes(const jo_model *m)
{
    jo_arena a = {0, 0};
    jo_sensor *watched, *metered;
    lay_out(m, &a, &watched, &metered);
    return (long long)a.used;
}

long long jo_data_room(const jo_model *m) { return jo_data_bytes(m) + 64; }

jo_data *jo_data_place(const jo_model *m, void *memory)
{
    memset(memory, 0, (size_t)jo_data_room(m));
    jo_arena a = {(char *)memory + (64 - (size_t)memory % 64), 0};
    jo_sensor *watched, *metered;
    jo_data *d = lay_out(m, &a, &watched, &metered);
    d->gh = -1.0;
    jo_nothing_valid(d);
    for (int i = 0; i < m->nbody; i++) {
        d->q[m->body[i].iq + 3] = jo_same(1.0);
        jo_body_setup(&m->body[i], &d->body[i], 0, 0.0);
    }
    jo_select_coordinates(m, d, 0);
    if (jo_mixed(m)) {
        jo_split_setup(m, d);
        jo_hybrid_setup(m, d);
    }
    if (m->nlink) jo_tree_setup(m, d);
    if (m->nloop) jo_loop_setup(m, d);
    jo_beam_setup(m, d);
    jo_marker_setup(m, d, 0);
    jo_joint_plan(m, d);
    jo_joint_setup(m, d, 0);
    if (jo_watched(m)) jo_event_setup(m, d, watched);
    if (m->nmeter) jo_damage_setup(m, d, metered);
    for (int i = 0; i < m->nmarker; i++) {   /* ground markers stand still */
        if (m->marker[i].body >= 0) continue;
        jo_set3(d->marker[i].r, m->marker[i].u0);
        memcpy(d->marker[i].A, m->marker[i].A0, sizeof d->marker[i].A);
    }
    jo_data_gravity(m, d);
    return d;
}

/* gravity is a frame acceleration */
void jo_data_gravity(const jo_model *m, jo_data *d)
{
    for (int i = 0; i < m->nmarker; i++)
        for (int j = 0; j < 3 && m->marker[i].body < 0; j++) d->marker[i].a[j] = -m->gravity[j];
}

#ifndef JO_NO_ALLOCATION   /* exported machines have memory of their own */
jo_data *jo_data_new(const jo_model *m)
{
    void *block = malloc((size_t)jo_data_room(m));
    jo_data *d = block ? jo_data_place(m, block) : 0;
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
double *jo_data_bent(jo_data *d) { return d->bent; }
int *jo_data_happened(jo_data *d) { return d->happened; }
jo_real *jo_data_states(const jo_model *m, jo_data *d) { return d->v + m->nv; }
jo_real *jo_data_state_rates(const jo_model *m, jo_data *d) { return d->a + m->nv; }
jo_real *jo_data_joint(jo_data *d) { return d->tree.x; }
jo_counts *jo_data_counts(jo_data *d) { return &d->counts; }
const double *jo_data_log(const jo_data *d) { return d->log; }
int jo_data_logged(const jo_data *d) { return d->logged; }
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
