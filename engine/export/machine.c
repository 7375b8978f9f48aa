/* machine.c - one instance of a constant plant, in memory provided by the caller. */
#include "machine.h"
#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

struct jo_machine {
    const jo_plant *plant;
    jo_model model;         /* model with the tunable numbers of this machine */
    jo_solver solver;
    jo_data *data;
    jo_real *tunable, *row;
    long long steps;
    int known;              /* whether `row` was computed for the present state */
    int status;             /* last jo_status that was not JO_OK */
};

enum { MARK = 20261126, HEAD = 4 };   /* mark of a saved state, and number of its first entries: mark, size, steps, step length */

#define MIN_NORM2 1e-6      /* smallest square of the norm of Euler parameters that can be normalised */
#define NORM2_RANGE 4.0     /* largest square of the norm of saved Euler parameters, and inverse of the smallest square */
#define MAX_COUNT 9e15      /* largest number of steps: integers up to 2^53 are exact as doubles */

static long long rounded(long long bytes) { return (bytes + 63) / 64 * 64; }
static int is_finite(double x) { return x >= -DBL_MAX && x <= DBL_MAX; }

/* Offsets of the arrays in the memory of a machine, bytes. */
typedef struct { long long force, signal, friction, tunable, row, data, end; } layout;

static layout lay_out(const jo_plant *p)
{
    const jo_model *m = p->model;
    layout at;
    at.force = rounded((long long)sizeof(jo_machine));
    at.signal = at.force + rounded((long long)sizeof(jo_force) * m->nforce);
    at.friction = at.signal + rounded((long long)sizeof(jo_signal) * m->nsignal);
    at.tunable = at.friction + rounded((long long)sizeof(jo_friction) * m->nfriction);
    at.row = at.tunable + rounded((long long)sizeof(jo_real) * p->ntunable);
    at.data = at.row + rounded((long long)sizeof(jo_real) * jo_row_size(m));
    at.end = at.data + jo_data_room(m);
    return at;
}

long long jo_machine_bytes(const jo_plant *p) { return lay_out(p).end + 64; }

/* address of the copy of a constant among the tunable numbers of this machine */
static const jo_real *own(const jo_machine *k, const jo_real *constant)
{
    const ptrdiff_t at = constant - k->plant->tunable;
    return k->tunable + at;
}

/* copies of forces, signals and frictions with the tunable numbers of this machine */
static void redirect(jo_machine *k, char *memory, const layout *at)
{
    const jo_model *m = k->plant->model;
    jo_force *force = (jo_force *)(memory + at->force);
    jo_signal *signal = (jo_signal *)(memory + at->signal);
    jo_friction *friction = (jo_friction *)(memory + at->friction);
    k->model = *m;
    for (int i = 0; i < m->nforce; i++) {
        force[i] = m->force[i];
        if (force[i].data) force[i].data = own(k, force[i].data);
    }
    for (int i = 0; i < m->nsignal; i++) {
        signal[i] = m->signal[i];
        if (signal[i].data) signal[i].data = own(k, signal[i].data);
    }
    for (int i = 0; i < m->nfriction; i++) {
        friction[i] = m->friction[i];
        friction[i].data = (const jo_friction_data *)own(k, (const jo_real *)friction[i].data);
    }
    k->model.force = force;
    k->model.signal = signal;
    k->model.friction = friction;
    k->model.gravity = own(k, m->gravity);
}

jo_machine *jo_machine_place(const jo_plant *p, void *memory, long long bytes)
{
    if (!memory || bytes < jo_machine_bytes(p)) return 0;
    char *start = (char *)memory + (64 - (size_t)memory % 64);
    const layout at = lay_out(p);
    jo_machine *k = (jo_machine *)start;
    memset(k, 0, sizeof *k);
    k->plant = p;
    k->tunable = (jo_real *)(start + at.tunable);
    k->row = (jo_real *)(start + at.row);
    redirect(k, start, &at);
    k->data = (jo_data *)(start + at.data);
    jo_machine_reset(k);
    return k;
}

void jo_machine_in_bodies(jo_machine *k)
{
    k->model.nlink = k->model.nx = k->model.nu = 0;
    jo_machine_reset(k);
}

const jo_plant *jo_machine_plant(const jo_machine *k) { return k->plant; }
jo_data *jo_machine_data(jo_machine *k) { return k->data; }

/* new work space, with constants that depend on tunable numbers */
static void begin(jo_machine *k)
{
    const layout at = lay_out(k->plant);
    char *start = (char *)k;
    k->data = jo_data_place(&k->model, start + at.data);
    k->known = 0;
}

int jo_machine_reset(jo_machine *k)
{
    const jo_plant *p = k->plant;
    if (p->ntunable) memcpy(k->tunable, p->tunable, sizeof(jo_real) * (size_t)p->ntunable);
    k->solver = *p->solver;
    k->steps = 0;
    k->status = JO_OK;
    begin(k);
    memcpy(jo_data_q(k->data), p->q0, sizeof(jo_real) * (size_t)p->model->nq);
    memcpy(jo_data_v(k->data), p->v0, sizeof(jo_real) * (size_t)p->model->nv);
    for (int i = 0; i < p->ninput; i++) jo_data_input(k->data)[p->input[i].place] = p->input[i].start;
    if (p->x0) memcpy(jo_data_states(&k->model, k->data), p->x0, sizeof(jo_real) * (size_t)p->model->nstate);
    return JO_MACHINE_OK;
}

static int failed(jo_machine *k, int status)
{
    k->status = status;
    return JO_MACHINE_FAILED;
}

int jo_machine_step(jo_machine *k, long long count)
{
    int written = 0;
    if (count <= 0) return count ? JO_MACHINE_WRONG : JO_MACHINE_OK;
    const long long goal = k->steps + count;
    k->known = 0;
    while (k->steps < goal) {   /* a full log of events ends a call early */
        const int status = jo_run(&k->model, k->data, &k->solver, goal - k->steps, (long long)1 << 62, &k->steps, &written, k->row);
        if (status == JO_EVENT) {
            k->status = status;
            return JO_MACHINE_STOPPED;
        }
        if (status != JO_OK) return failed(k, status);
    }
    return JO_MACHINE_OK;
}

double jo_machine_time(const jo_machine *k) { return *jo_data_time(k->data); }
double jo_machine_step_size(const jo_machine *k) { return k->solver.step; }

int jo_machine_set_step_size(jo_machine *k, double step)
{
    if (!is_finite(step) || step <= 0.0) return JO_MACHINE_WRONG;
    k->solver.step = step;
    return JO_MACHINE_OK;
}

int jo_machine_set_input(jo_machine *k, int input, double value)
{
    if (input < 0 || input >= k->plant->ninput || !is_finite(value)) return JO_MACHINE_WRONG;
    jo_data_input(k->data)[k->plant->input[input].place] = value;
    k->known = 0;
    return JO_MACHINE_OK;
}

double jo_machine_get_input(const jo_machine *k, int input)
{
    if (input < 0 || input >= k->plant->ninput) return 0.0;
    return jo_data_input(k->data)[k->plant->input[input].place];
}

/* jump of a force: restart of methods with history; new acceleration of the ground markers */
int jo_machine_set_parameter(jo_machine *k, int parameter, double value)
{
    if (parameter < 0 || parameter >= k->plant->nparameter || !is_finite(value)) return JO_MACHINE_WRONG;
    const int place = k->plant->parameter[parameter].place;
    if (k->tunable[place] == value) return JO_MACHINE_OK;
    k->tunable[place] = value;
    for (int i = 0; i < k->plant->nlink; i++) {
        const jo_named_link *link = &k->plant->link[i];
        if (link->parameter == parameter) k->tunable[link->place] = link->offset + link->factor * value;
    }
    jo_machine_changed(k);
    return JO_MACHINE_OK;
}

double jo_machine_get_parameter(const jo_machine *k, int parameter)
{
    if (parameter < 0 || parameter >= k->plant->nparameter) return 0.0;
    return k->tunable[k->plant->parameter[parameter].place];
}

int jo_machine_update(jo_machine *k)
{
    if (k->known) return JO_MACHINE_OK;
    const int status = jo_row(&k->model, k->data, k->row);
    if (status != JO_OK) return failed(k, status);
    k->known = 1;
    return JO_MACHINE_OK;
}

/* index of the first sensor in a row: after time, q, v, lam, diagnostics */
static int sensors_at(const jo_model *m)
{
    return 1 + m->nq + m->nv + m->nrow + (int)(sizeof(jo_diagnostics) / sizeof(jo_real));
}

const jo_real *jo_machine_outputs(jo_machine *k)
{
    return jo_machine_update(k) == JO_MACHINE_OK ? k->row + sensors_at(&k->model) : 0;
}

int jo_machine_get_output(jo_machine *k, int output, double *value)
{
    if (output < 0 || output >= k->plant->noutput) return JO_MACHINE_WRONG;
    const jo_real *all = jo_machine_outputs(k);
    if (!all) return JO_MACHINE_FAILED;
    *value = all[k->plant->output[output].place];
    return JO_MACHINE_OK;
}

int jo_machine_error(const jo_machine *k) { return k->status; }
int jo_machine_error_index(const jo_machine *k) { return jo_data_error_index(k->data); }

int jo_machine_states(const jo_machine *k) { return k->model.nq + k->model.nv + k->model.nstate; }

void jo_machine_get_states(const jo_machine *k, double *x)
{
    const jo_real *q = jo_data_q(k->data), *v = jo_data_v(k->data);
    for (int i = 0; i < k->model.nq; i++) x[i] = q[i];
    for (int i = 0; i < k->model.nv; i++) x[k->model.nq + i] = v[i];
    for (int i = 0; i < k->model.nstate; i++) x[k->model.nq + k->model.nv + i] = jo_data_states(&k->model, k->data)[i];
}

/* check and set time, q, v and states of forces; Euler parameters are normalised */
int jo_machine_set_states(jo_machine *k, double time, const double *x)
{
    const jo_model *m = &k->model;
    if (!is_finite(time)) return JO_MACHINE_WRONG;
    for (int i = 0; i < m->nq + m->nv + m->nstate; i++)
        if (!is_finite(x[i])) return JO_MACHINE_WRONG;
    for (int i = 0; i < m->nbody; i++) {
        const double *e = x + m->body[i].iq + 3;
        if (!(e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3] > MIN_NORM2)) return JO_MACHINE_WRONG;
    }
    jo_real *q = jo_data_q(k->data), *v = jo_data_v(k->data);
    for (int i = 0; i < m->nq; i++) q[i] = x[i];
    for (int i = 0; i < m->nv; i++) v[i] = x[m->nq + i];
    for (int i = 0; i < m->nstate; i++) jo_data_states(m, k->data)[i] = x[m->nq + m->nv + i];
    for (int i = 0; i < m->nbody; i++) {
        jo_real *e = q + m->body[i].iq + 3;
        const double length = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3]);
        for (int j = 0; j < 4; j++) e[j] /= length;
    }
    *jo_data_time(k->data) = time;
    jo_restart(k->data);
    k->known = 0;
    return JO_MACHINE_OK;
}

int jo_machine_rates(jo_machine *k, double rate, jo_real *xdot)
{
    k->known = 0;
    const int status = jo_rates(&k->model, k->data, rate, rate, xdot);
    if (status != JO_OK) return failed(k, status);
    memcpy(xdot + k->model.nq, jo_data_a(k->data), sizeof(jo_real) * (size_t)(k->model.nv + k->model.nstate));   /* includes the rates of states */
    return JO_MACHINE_OK;
}

jo_real *jo_machine_tunable(jo_machine *k) { return k->tunable; }

void jo_machine_changed(jo_machine *k)
{
    k->known = 0;
    jo_data_gravity(&k->model, k->data);
    jo_restart(k->data);
}

void jo_machine_count(jo_machine *k)
{
    jo_data_count_turns(&k->model, k->data);
    k->known = 0;
}

/* -- saved states: HEAD numbers, work (3), tunable numbers, the row ---------------------------------------- */

int jo_machine_state_size(const jo_machine *k) { return HEAD + 3 + k->plant->ntunable + jo_row_size(&k->model); }

int jo_machine_save(jo_machine *k, double *state)
{
    if (jo_machine_update(k) != JO_MACHINE_OK) return JO_MACHINE_FAILED;
    const jo_work *work = jo_data_work(k->data);
    *state++ = MARK;
    *state++ = jo_machine_state_size(k);
    *state++ = (double)k->steps;
    *state++ = k->solver.step;
    *state++ = work->damping;
    *state++ = work->friction;
    *state++ = work->forces;
    for (int i = 0; i < k->plant->ntunable; i++) *state++ = k->tunable[i];
    for (int i = 0; i < jo_row_size(&k->model); i++) *state++ = k->row[i];
    return JO_MACHINE_OK;
}

/* copy doubles into an array of the engine; returns the next double */
static const double *put(jo_real *to, const double *from, int count)
{
    for (int i = 0; i < count; i++) to[i] = from[i];
    return from + count;
}
static const double *put_int(int *to, const double *from, int count)
{
    for (int i = 0; i < count; i++) to[i] = (int)from[i];
    return from + count;
}

/* whether Euler parameters are plausible: square of the norm from 1/4 to 4 */
static int turns(const double *e)
{
    const double square = e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3];
    return square >= 1.0 / NORM2_RANGE && square <= NORM2_RANGE;
}

/* numbers that end a row, after the joint coordinates: energies of contacts */
static int energies_in(const jo_model *m)
{
    const int discrete = 3 * m->nlock + 3 * m->nfriction + m->nevent + m->ninput + m->nmemory;
    return jo_row_size(m) - sensors_at(m) - m->nout - m->nstate - m->nturn - discrete - m->nx - m->nu;
}

/* whether the numbers of a row are consistent with this model: finite, discrete states and counts in their ranges */
static int possible(const jo_model *m, const double *row)
{
    const int sensors = sensors_at(m), lead = 1 + m->nq + m->nv + m->nrow;
    const int after = sensors + m->nout, ints = m->nlock + m->nfriction;
    for (int i = 0; i < lead; i++)
        if (!is_finite(row[i])) return 0;
    const int joint = jo_row_size(m) - energies_in(m) - m->nx - m->nu, end = joint - m->nmemory;
    for (int i = after; i < end; i++)
        if (!is_finite(row[i])) return 0;
    for (int i = joint; i < joint + m->nx + m->nu; i++)
        if (!is_finite(row[i])) return 0;
    const int locked = after + m->nstate + m->nturn;
    for (int i = locked; i < locked + ints; i++)
        if (row[i] != 0.0 && row[i] != 1.0 && row[i] != -1.0) return 0;
    const int happened = end - m->ninput - m->nevent;
    for (int i = happened; i < happened + m->nevent; i++)
        if (row[i] < 0.0 || row[i] > 2147483647.0) return 0;
    for (int i = 0; i < m->nmeter; i++)
        if (!jo_meter_valid(&m->meter[i], row + end + m->meter[i].at)) return 0;
    for (int i = 0; i < m->nbody; i++)
        if (!turns(row + 1 + m->body[i].iq + 3)) return 0;
    for (int i = 0; i < m->nlink; i++) {
        const double *x = row + joint + m->link[i].x;
        if (m->link[i].type == JO_LINK_BALL && !turns(x)) return 0;
        if ((m->link[i].type == JO_LINK_FREE || m->link[i].type == JO_LINK_BODY) && !turns(x + 3)) return 0;
    }
    return 1;
}

/* check a saved state, then restore head, work, tunable numbers and the row */
int jo_machine_load(jo_machine *k, const double *state)
{
    const jo_model *m = &k->model;
    jo_data *d = k->data;
    const double *head = state, *work = state + HEAD, *tunable = work + 3, *row = tunable + k->plant->ntunable;
    if (head[0] != MARK || head[1] != jo_machine_state_size(k)) return JO_MACHINE_WRONG;
    if (!(head[2] >= 0.0 && head[2] < MAX_COUNT) || !is_finite(head[3]) || head[3] <= 0.0) return JO_MACHINE_WRONG;
    for (int i = 0; i < 3 + k->plant->ntunable; i++)
        if (!is_finite(work[i])) return JO_MACHINE_WRONG;
    if (!possible(m, row)) return JO_MACHINE_WRONG;
    k->steps = (long long)head[2];
    k->solver.step = head[3];
    for (int i = 0; i < k->plant->ntunable; i++) k->tunable[i] = tunable[i];
    begin(k);
    d = k->data;
    jo_data_work(d)->damping = work[0];
    jo_data_work(d)->friction = work[1];
    jo_data_work(d)->forces = work[2];
    row = put(jo_data_time(d), row, 1);
    row = put(jo_data_q(d), row, m->nq);
    row = put(jo_data_v(d), row, m->nv);
    row = put(jo_data_lam(d), row, m->nrow);
    row += sizeof(jo_diagnostics) / sizeof(jo_real) + (size_t)m->nout;
    row = put(jo_data_states(m, d), row, m->nstate);
    row = put(jo_data_turn(d), row, m->nturn);
    row = put_int(jo_data_locked(d), row, m->nlock);
    row = put_int(jo_data_slip(d), row, m->nfriction);
    row = put(jo_data_held(d), row, 2 * m->nlock);
    row = put(jo_data_direction(d), row, 2 * m->nfriction);
    row = put_int(jo_data_happened(d), row, m->nevent);
    row = put(jo_data_input(d), row, m->ninput);
    memcpy(jo_data_memory(d), row, sizeof(double) * (size_t)m->nmemory);
    row = put(jo_data_joint(d), row + m->nmemory, m->nx + m->nu);
    put(jo_data_contact_energy(d), row, energies_in(m));
    k->status = JO_OK;
    return JO_MACHINE_OK;
}
