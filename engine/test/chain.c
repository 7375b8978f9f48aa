/* chain.c - test of the engine without Python, for sanitizers.
 *
 * Ground -revolute- flexible -fixed- rigid -spherical- flexible, two elimination branches, forces with every
 * kind of signal, every kind of sensor. Checks: energy by the order of the method; constraint residuals;
 * error codes.
 */
#include "jousto.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { N = 5, NP = 8, BODIES = 3, JOINTS = 3 };

#define CHECK(x) \
    do { if (!(x)) { fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #x); exit(1); } } while (0)

/* consistent invariants of eight particles with five mode shapes */
enum { PARTICLES = 8 };
static double u0[PARTICLES][3], phi[PARTICLES][3][N];
static double mass[1] = {PARTICLES}, S0[3], J0[6], I3[3 * NP], B0[3 * NP], D0[6 * NP], K[NP], D[NP], none[NP];
static double ED[6 * NP * N], EB[3 * NP * N];

static unsigned state = 12345;
static double random_number(void)
{
    state = state * 1664525u + 1013904223u;
    return (double)(state >> 8) / (double)(1u << 24) - 0.5;
}

static void half_rate(const double *a, const double *b, double *out)   /* tr(a b^T) E - sym(a b^T) */
{
    double trace = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    for (int i = 0; i < 3; i++) out[i] += trace - a[i] * b[i];
    out[3] -= 0.5 * (a[1] * b[2] + a[2] * b[1]);
    out[4] -= 0.5 * (a[0] * b[2] + a[2] * b[0]);
    out[5] -= 0.5 * (a[0] * b[1] + a[1] * b[0]);
}

static void cross(const double *a, const double *b, double *out)
{
    out[0] += a[1] * b[2] - a[2] * b[1];
    out[1] += a[2] * b[0] - a[0] * b[2];
    out[2] += a[0] * b[1] - a[1] * b[0];
}

static void make_body(void)
{
    for (int p = 0; p < PARTICLES; p++)
        for (int c = 0; c < 3; c++) {
            u0[p][c] = random_number() + (c == 0);
            for (int j = 0; j < N; j++) phi[p][c][j] = 0.4 * random_number();
        }
    /* mass-orthonormal modes: Gram-Schmidt */
    for (int j = 0; j < N; j++) {
        for (int k = 0; k <= j; k++) {
            double dot = 0.0;
            for (int p = 0; p < PARTICLES; p++)
                for (int c = 0; c < 3; c++) dot += phi[p][c][j] * phi[p][c][k];
            for (int p = 0; p < PARTICLES; p++)
                for (int c = 0; c < 3; c++) {
                    if (k < j) phi[p][c][j] -= dot * phi[p][c][k];
                    else phi[p][c][j] /= sqrt(dot);
                }
        }
        K[j] = 400.0 * (j + 1) * (j + 1);
        D[j] = 0.1 * (j + 1);
    }
    for (int p = 0; p < PARTICLES; p++) {
        double J[6] = {0};
        half_rate(u0[p], u0[p], J);
        for (int c = 0; c < 6; c++) J0[c] += J[c];
        for (int c = 0; c < 3; c++) S0[c] += u0[p][c];
        for (int j = 0; j < N; j++) {
            double f[3] = {phi[p][0][j], phi[p][1][j], phi[p][2][j]}, d[6] = {0}, b[3] = {0};
            half_rate(u0[p], f, d);
            cross(u0[p], f, b);
            for (int c = 0; c < 6; c++) D0[c * NP + j] += d[c];
            for (int c = 0; c < 3; c++) { B0[c * NP + j] += b[c]; I3[c * NP + j] += f[c]; }
            for (int k = 0; k < N; k++) {
                double g[3] = {phi[p][0][k], phi[p][1][k], phi[p][2][k]}, e[6] = {0}, x[3] = {0};
                half_rate(g, f, e);
                cross(g, f, x);
                for (int c = 0; c < 6; c++) {
                    int row = c * NP + j;
                    ED[(row / JO_ROW_D * N + k) * JO_ROW_D + row % JO_ROW_D] += e[c];
                }
                for (int c = 0; c < 3; c++) {
                    int row = c * NP + j;
                    EB[(row / JO_ROW_B * N + k) * JO_ROW_B + row % JO_ROW_B] += x[c];
                }
            }
        }
    }
}

static double energy(const jo_model *m, jo_data *d)
{
    jo_energies e;
    const jo_work *w = jo_data_work(d);
    jo_energy(m, d, &e);
    return e.kinetic + e.strain + e.potential + e.springs + w->damping + w->friction - w->forces;
}

static double total(const jo_diagnostics *e)
{
    return e->kinetic + e->strain + e->potential + e->springs + e->dissipated + e->friction - e->work;
}

/* largest change of the energy balance over a second */
static double drift(const jo_model *m, jo_solver s)
{
    jo_data *d = jo_data_new(m);
    CHECK(d);
    double *q = jo_data_q(d), *v = jo_data_v(d), residual[2], start, worst = 0.0;
    q[m->body[1].iq] = 1.0;
    q[m->body[2].iq] = 2.0;
    for (int i = 0; i < m->nv; i++) v[i] = 0.2;
    CHECK(jo_assemble(m, d, 30, 1e-13) == JO_OK);
    start = energy(m, d);
    int width = jo_row_size(m), steps = (int)(1.0 / s.step + 0.5);
    double *rows = malloc(sizeof(double) * (size_t)width * (size_t)(steps / 10));
    long long count = 0;
    int written = 0;
    CHECK(jo_run(m, d, &s, steps, 10, &count, &written, rows) == JO_OK);
    CHECK(written == steps / 10 && count == steps);
    for (int i = 0; i < steps / 10; i++) {
        const jo_diagnostics *e = (const jo_diagnostics *)(rows + i * width + 1 + m->nq + m->nv + m->nrow);
        worst = fmax(worst, fabs(total(e) - start));
        CHECK(e->position_residual < 1e-10 && e->velocity_residual < 1e-9);
        for (int j = 0; j < width; j++) CHECK(isfinite(rows[i * width + j]));
    }
    jo_residuals(m, d, residual);
    CHECK(residual[0] < 1e-10 && residual[1] < 1e-9);
    free(rows);
    jo_data_free(d);
    return worst;
}

/* the same with error control, split into many short calls */
static double followed(const jo_model *m, jo_solver s)
{
    jo_data *d = jo_data_new(m);
    CHECK(d);
    double *q = jo_data_q(d), *v = jo_data_v(d), start, worst = 0.0;
    q[m->body[1].iq] = 1.0;
    q[m->body[2].iq] = 2.0;
    for (int i = 0; i < m->nv; i++) v[i] = 0.2;
    CHECK(jo_assemble(m, d, 30, 1e-13) == JO_OK);
    start = energy(m, d);
    int width = jo_row_size(m), written;
    double *rows = malloc(sizeof(double) * (size_t)width * 3);
    long long count = 0, last = 100;
    while (count <= last) {
        const long long before = count;
        CHECK(jo_follow(m, d, &s, last, 7, 3, &count, &written, rows) == JO_OK);
        CHECK(count == before + written && written <= 3);
        for (int i = 0; i < written; i++) {
            const jo_diagnostics *e = (const jo_diagnostics *)(rows + i * width + 1 + m->nq + m->nv + m->nrow);
            CHECK(fabs(rows[i * width] - (double)(before + i) * s.step) < 1e-15);
            worst = fmax(worst, fabs(total(e) - start));
            CHECK(e->position_residual < 1e-10 && e->velocity_residual < 1e-9);
            for (int j = 0; j < width; j++) CHECK(isfinite(rows[i * width + j]));
        }
    }
    CHECK(jo_data_counts(d)->steps > 10);
    free(rows);
    jo_data_free(d);
    return worst;
}

int main(void)
{
    make_body();
    static const double E[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, origin[3] = {0}, end[3] = {1, 0, 0};
    static const double rigid_mass[1] = {2}, rigid_S[3] = {1, 0, 0}, rigid_J[6] = {0.1, 0.8, 0.8, 0, 0, 0};
    static const double gravity[3] = {0, -9.81, 0}, push[6] = {1, 2, 3, 0, 0, 0};
    static const double screw[6] = {1, 2, 3, 0.1, 0.2, -0.1}, twist[6] = {0, 0, 0, 0.1, 0.2, -0.1};
    static double near[3 * NP], far[3 * NP], turn[3 * NP], rows[6 * NP];
    for (int c = 0; c < 3; c++)
        for (int j = 0; j < N; j++) {
            near[c * NP + j] = 0.1 * random_number();
            far[c * NP + j] = 0.1 * random_number();
            turn[c * NP + j] = 0.1 * random_number();
        }
    jo_body body[BODIES] = {
        {N, NP, 0, 0, mass, S0, J0, I3, B0, D0, ED, EB, K, D, 0.0},
        {0, 0, 7 + N, 6 + N, rigid_mass, rigid_S, rigid_J, none, none, none, none, none, none, none, 0.0},
        {N, NP, 14 + N, 12 + N, mass, S0, J0, I3, B0, D0, ED, EB, K, D, 0.0},
    };
    jo_marker marker[] = {
        {-1, 0, origin, E, 0, 0, 0},  {0, 1, origin, E, near, turn, 0}, {0, 1, end, E, far, turn, 0}, {1, 1, origin, E, 0, 0, 0},
        {1, 0, end, E, 0, 0, 0},      {2, 0, origin, E, near, 0, 0},    {2, 1, end, E, far, turn, 0}, {2, 1, end, E, far, turn, 0},
    };
    jo_joint joint[JOINTS] = {
        {2, {0, 1}, 1, 2, 0, {0, 1, 0}, {2, 2, 0}, 0, 5, 0, -1, -1},
        {2, {2, 3}, 1, 3, 0, {0, 1, 0}, {2, 2, 1}, 0, 6, 5, -1, -1},
        {2, {4, 5}, 1, 0, 0, {0, 0, 0}, {0, 0, 0}, 0, 3, 11, -1, -1},
    };
    /* elimination order revolute, spherical, fixed: blocks 3 = (fixed, revolute), 4 = (fixed, spherical) */
    jo_pair pair[] = {
        {0, 1, 0, 1, 0}, {1, 0, 0, 1, 3}, {1, 0, 1, 0, 2}, {1, 1, 1, 1, 2}, {1, 1, 2, 0, 4}, {2, 0, 2, 0, 1}, {2, 1, 2, 1, 1},
    };
    jo_column column[] = {{0, 0, 1}, {2, 1, 1}, {1, 2, 0}};
    jo_below below[] = {{3, 1}, {4, 1}};
    jo_update update[] = {{2, 3, 3, 6, 6}, {2, 4, 4, 6, 6}};
    int update_first[] = {0, 1, 2, 2};
    static const double harmonic[4] = {1, 2, 3, 0.5}, table[6] = {0, 0.5, 2, 0, 1, 0.5}, jump[3] = {5, 1, 2};
    jo_signal signal[] = {{JO_SIGNAL_HARMONIC, 0, 0, {0, 0}, harmonic}, {JO_SIGNAL_TABLE, 3, 0, {0, 0}, table}, {JO_SIGNAL_STEP, 0, 0, {0, 0}, jump}};
    jo_force force[] = {
        {JO_FORCE_load, -1, 6, -1, -1, -1, 0, 0, 0, -1, -1, -1, push, 0, 0, -1, -1, 0},     {JO_FORCE_load, -1, 6, -1, -1, -1, 1, 0, 1, -1, -1, -1, screw, 0, 0, -1, -1, 0},
        {JO_FORCE_load, -1, 4, -1, -1, -1, 0, 0, 2, -1, -1, -1, push, 0, 0, -1, -1, 0},     {JO_FORCE_load, -1, 6, -1, -1, -1, 0, 0, -1, -1, -1, -1, twist, 0, 0, -1, -1, 0},
    };
    jo_sensor sensor[] = {
        {JO_SENSOR_POSITION, 7, -1, -1, 0, 3, 0},          {JO_SENSOR_VELOCITY, 7, -1, -1, 3, 3, 0},   {JO_SENSOR_ORIENTATION, 7, -1, -1, 6, 4, 0},
        {JO_SENSOR_ANGULAR_VELOCITY, 7, -1, -1, 10, 3, 0}, {JO_SENSOR_MODAL, 2, -1, -1, 13, 2 * N, 0}, {JO_SENSOR_REACTION, 1, -1, -1, 23, 6, 0},
        {JO_SENSOR_STRESS, 0, -1, -1, 29, 6, rows},
    };
    static const double breaks[4] = {0, 0.5, 2, 5};   /* breaks of the table and of the jump */
    jo_model m;
    memset(&m, 0, sizeof m);
    m.nbreak = 4; m.breaks = breaks;
    m.nbody = BODIES; m.nmarker = 8; m.nactive = 7; m.njoint = JOINTS; m.npair = 7; m.ncolumn = JOINTS;
    m.nblock = 5; m.nforce = 4; m.nsignal = 3; m.nsensor = 7;
    m.nq = 21 + 2 * N; m.nv = 18 + 2 * N; m.nrow = 14; m.nout = 35;
    m.size = 1.0; m.gravity = gravity; m.body = body; m.marker = marker; m.joint = joint; m.pair = pair; m.column = column;
    m.below = below; m.update = update; m.update_first = update_first; m.signal = signal; m.force = force; m.sensor = sensor;

    jo_solver rk4, ros2;
    memset(&rk4, 0, sizeof rk4);
    rk4.method = JO_METHOD_rk4; rk4.projection = 1; rk4.step = 2e-3;
    ros2 = rk4;
    ros2.method = JO_METHOD_ros2;
    double coarse = drift(&m, rk4), fine;
    rk4.step = 1e-3;
    fine = drift(&m, rk4);
    printf("RK4  energy error %.2e -> %.2e J\n", coarse, fine);
    CHECK(fine < coarse / 12.0 && fine < 1e-5);
    coarse = drift(&m, ros2);
    ros2.step = 1e-3;
    fine = drift(&m, ros2);
    printf("ROS2 energy error %.2e -> %.2e J\n", coarse, fine);
    CHECK(fine < coarse / 3.0 && fine < 1e-1);
    ros2.alpha = ros2.beta = 20.0;
    CHECK(drift(&m, ros2) < 1e-1);
    jo_solver dopri = rk4;
    dopri.method = JO_METHOD_dopri; dopri.step = 1e-2; dopri.iterations = 10000;
    dopri.tolerance = 1e-5;
    coarse = followed(&m, dopri);
    dopri.tolerance = 1e-8;
    fine = followed(&m, dopri);
    printf("DOPRI energy error %.2e -> %.2e J\n", coarse, fine);
    CHECK(fine < coarse / 100.0 && fine < 1e-6);
    dopri.iterations = 2;
    jo_data *few = jo_data_new(&m);
    long long count = 0;
    int written;
    double *row = malloc(sizeof(double) * (size_t)jo_row_size(&m));
    CHECK(jo_assemble(&m, few, 30, 1e-13) == JO_OK);
    CHECK(jo_follow(&m, few, &dopri, 1, 100, 1, &count, &written, row) == JO_OK && written == 1);
    CHECK(jo_follow(&m, few, &dopri, 1, 100, 1, &count, &written, row) == JO_STEP_TOO_SMALL);
    free(row);
    jo_data_free(few);

    /* events: a position and a reaction at half of a step of a plain run; the reaction ends the run */
    const int size = jo_row_size(&m), out = size - m.nout;
    double *plain = calloc((size_t)(202 * (size + 3)), sizeof *plain);
    count = 0;
    jo_data *d = jo_data_new(&m);
    CHECK(plain && jo_assemble(&m, d, 30, 1e-13) == JO_OK);
    CHECK(jo_run(&m, d, &rk4, 200, 1, &count, &written, plain) == JO_OK && written == 200);
    jo_data_free(d);
    jo_event event[] = {{1, 0, 0, 0, 0.0}, {24, 0, 0, 1, 0.0}, {0, 0, 0, 0, 1e9}};
    for (int i = 0; i < 2; i++) {
        const double *row = plain + (size_t)(size * (i ? 150 : 4)) + out + event[i].output;
        event[i].threshold = 0.5 * (row[0] + row[size]);
    }
    m.nevent = 3;
    m.event = event;
    d = jo_data_new(&m);
    count = 0;
    CHECK(jo_row_size(&m) == size + 3 && jo_assemble(&m, d, 30, 1e-13) == JO_OK);
    CHECK(jo_run(&m, d, &rk4, 200, 1, &count, &written, plain) == JO_EVENT && jo_data_error_index(d) == 1);
    const int *happened = jo_data_happened(d);
    const double *last = plain + (size_t)(written - 1) * (size_t)(size + 3);
    printf("%d events, stopped at %.9g s\n", jo_data_logged(d), last[0]);
    CHECK(happened[0] >= 1 && happened[1] == 1 && happened[2] == 0 && count <= 151 && written == count + 1);
    CHECK(jo_data_logged(d) == happened[0] + happened[1]);
    CHECK(fabs(last[out + 24] - event[1].threshold) < 1e-8 * (1.0 + fabs(event[1].threshold)));
    CHECK(last[size] == happened[0]);   /* rows end with the discrete states */
    jo_data_free(d);
    free(plain);
    m.nevent = 0;

    /* error codes and indices */
    d = jo_data_new(&m);
    CHECK(jo_assemble(&m, d, 30, 1e-13) == JO_OK);
    jo_data_v(d)[m.body[2].iv] = 1e16;
    CHECK(jo_step(&m, d, &rk4) != JO_OK);
    jo_data_free(d);
    static const double line[6] = {0, 1, 1, 0, 0, 0};   /* all mass on a line through the origin */
    static const double zero[3] = {0, 0, 0};
    body[1].J0 = line;
    body[1].S0 = zero;
    d = jo_data_new(&m);
    CHECK(jo_accelerations(&m, d) == JO_SINGULAR_BODY && jo_data_error_index(d) == 1);
    jo_data_free(d);
    return 0;
}
