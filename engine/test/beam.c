/* beam.c - test of a beam element between two rigid bodies, for sanitizers.
 *
 * Checks: Newton's matrix against differences of the residual; energy in free flight by the order of the method; section sensor; status
 * JO_BENT of excessive bending.
 */
#include "beam/beam.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(x) \
    do { if (!(x)) { fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #x); exit(1); } } while (0)

static jo_beam_data data;

static void fill(double beta, double alpha, double share, double helical)
{
    memset(&data, 0, sizeof data);
    data.length = 0.9;
    for (int k = 0; k < 2; k++) {   /* ends off the origins, frames rotated about z */
        const double angle = k ? 0.2 : -0.1, c = cos(angle), s = sin(angle);
        const double u[3] = {0.05, -0.1, 0.07 * (k + 1)}, B[9] = {c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0};
        memcpy(k ? data.u_b : data.u_a, u, sizeof u);
        memcpy(k ? data.B_b : data.B_a, B, sizeof B);
    }
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++) data.C[6 * i + j] = i == j ? 20.0 * (6 - i) : 1.0 / (1 + i + j);
    for (int i = 0; i < 6; i++) data.e0[i] = 0.02 * i - 0.05;
    data.beta = beta; data.alpha = alpha; data.share = share; data.mass = 0.8;
    data.J[0] = 0.06; data.J[1] = 0.05; data.J[2] = 0.04; data.J[3] = 0.01; data.limit = 1e-3; data.helical = helical;
}

static void place(const jo_model *m, jo_data *d)
{
    double *q = jo_data_q(d), *v = jo_data_v(d), *a = jo_data_a(d);
    const double start[14] = {0.0, 0.1, 0.0, 0.9, 0.1, -0.2, 0.3, 1.1, 0.2, -0.1, 0.8, -0.3, 0.2, 0.1};
    memcpy(q, start, sizeof start);
    for (int k = 0; k < 2; k++) {
        double *e = q + 7 * k + 3, norm = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3]);
        for (int i = 0; i < 4; i++) e[i] /= norm;
    }
    for (int i = 0; i < m->nv; i++) { v[i] = sin(1.0 + i); a[i] = cos(2.0 + i); }
}

/* q o increment along unknown j: [dR (world), dtheta (local)] */
static void move(double *q, int j, double x)
{
    double *R = q + 7 * (j / 6), *e = R + 3, old[4];
    if (j % 6 < 3) { R[j % 6] += x; return; }
    const double c = cos(0.5 * x), s = sin(0.5 * x);
    double t[4] = {c, 0.0, 0.0, 0.0};
    t[1 + j % 3] = s;
    memcpy(old, e, sizeof old);
    e[0] = old[0] * t[0] - old[1] * t[1] - old[2] * t[2] - old[3] * t[3];
    e[1] = old[0] * t[1] + old[1] * t[0] + old[2] * t[3] - old[3] * t[2];
    e[2] = old[0] * t[2] + old[2] * t[0] + old[3] * t[1] - old[1] * t[3];
    e[3] = old[0] * t[3] + old[3] * t[0] + old[1] * t[2] - old[2] * t[1];
}

static double worst_tangent(const jo_model *m, jo_data *d)
{
    enum { N = 12 };
    const double h = 1e-4;
    double worst = 0.0, M[N * N], plus[N], minus[N], kept[14];
    for (int kind = 0; kind < 3; kind++) {
        CHECK(jo_newton_matrix(m, d, kind == 0, kind == 1, kind == 2, M) == JO_OK);
        for (int j = 0; j < N; j++) {
            for (int side = 0; side < 2; side++) {
                const double x = side ? -h : h;
                memcpy(kept, jo_data_q(d), sizeof kept);
                if (kind == 0) jo_data_a(d)[j] += x;
                else if (kind == 1) jo_data_v(d)[j] += x;
                else move(jo_data_q(d), j, x);
                CHECK(jo_residual(m, d, side ? minus : plus) == JO_OK);
                if (kind == 0) jo_data_a(d)[j] -= x;
                if (kind == 1) jo_data_v(d)[j] -= x;
                memcpy(jo_data_q(d), kept, sizeof kept);
            }
            for (int i = 0; i < N; i++) worst = fmax(worst, fabs((plus[i] - minus[i]) / (2.0 * h) - M[N * i + j]));
        }
    }
    return worst;
}

/* change of the energy in half a second of free flight */
static double drift(const jo_model *m, double step)
{
    jo_data *d = jo_data_new(m);
    jo_energies e;
    jo_solver rk4;
    memset(&rk4, 0, sizeof rk4);
    rk4.method = JO_METHOD_rk4;
    rk4.step = step;
    CHECK(d);
    place(m, d);
    jo_energy(m, d, &e);
    const double start = e.kinetic + e.strain + e.potential;
    for (int i = 0; i < (int)(0.5 / step + 0.5); i++) CHECK(jo_step(m, d, &rk4) == JO_OK);
    CHECK(jo_data_bent(d)[0] > 0.3 && jo_data_bent(d)[1] > 0.0);
    jo_energy(m, d, &e);
    jo_data_free(d);
    return fabs(e.kinetic + e.strain + e.potential - start);
}

int main(int argc, char **argv)
{
    static const double mass[2] = {1.5, 2.0}, S0[3] = {0.1, 0.0, -0.05}, J0[6] = {0.3, 0.4, 0.5, 0.02, 0.0, 0.01}, zero[3] = {0};
    jo_body body[2] = {{0, 0, 0, 0, mass, S0, J0, 0, 0, 0, 0, 0, 0, 0, 0.0},
                       {0, 0, 7, 6, mass + 1, S0, J0, 0, 0, 0, 0, 0, 0, 0, 0.0}};
    jo_beam beam[1] = {{0, 1, &data}};
    jo_node node[2] = {{0, 6, 6, 0, 0, 0, 1}, {1, 6, 6, 6, 144, 1, 0}};
    jo_branch branch[1] = {{1, 6, 48, 96}};
    jo_fill fill_in[1] = {{144, 8, 0, 0}};
    int fill_first[3] = {0, 1, 1};
    jo_place places[2] = {{0, 0}, {1, 0}};
    jo_sensor sensor[1];
    jo_model m;
    memset(&m, 0, sizeof m);
    memset(sensor, 0, sizeof sensor);
    sensor[0].type = JO_SENSOR_SECTION; sensor[0].count = 12;
    m.nbody = 2; m.nbeam = 1; m.nnode = 2; m.nnewton = 192; m.nq = 14; m.nv = 12; m.nsensor = 1; m.nout = 12;
    m.size = 1.0; m.gravity = zero; m.body = body; m.beam = beam; m.node = node; m.branch = branch; m.fill = fill_in;
    m.fill_first = fill_first; m.place = places; m.sensor = sensor;

    const double kinds[5][4] = {{0, 0, 0, 0}, {0.05, 0, 0, 0}, {0, 0.3, 1, 0}, {0, 0, 0, 1}, {0.05, 0.3, 0.5, 1}};
    for (int k = 0; k < 5; k++) {
        fill(kinds[k][0], kinds[k][1], kinds[k][2], kinds[k][3]);
        body[0].alpha = body[1].alpha = kinds[k][1];
        jo_data *d = jo_data_new(&m);
        CHECK(d);
        place(&m, d);
        const double worst = worst_tangent(&m, d);
        printf("tangent %d: %.1e\n", k, worst);
        CHECK(worst < 1e-5);
        if (argc > 1) {   /* evaluations only, for counts of instructions */
            double r[12], M[144];
            for (int i = 0; i < atoi(argv[1]); i++) jo_residual(&m, d, r);
            for (int i = 0; i < atoi(argv[1]); i++) jo_newton_matrix(&m, d, 1.0, 0.1, 0.01, M);
        }
        jo_data_free(d);
    }
    fill(0.0, 0.0, 0.0, 0.0);
    body[0].alpha = body[1].alpha = 0.0;
    const double coarse = drift(&m, 1e-2), fine = drift(&m, 5e-3);
    printf("RK4 energy error %.2e -> %.2e J\n", coarse, fine);
    CHECK(fine < coarse / 12.0 && fine < 1e-4);

    jo_data *d = jo_data_new(&m);
    double y[12], sum;
    place(&m, d);
    CHECK(jo_accelerations(&m, d) == JO_OK);
    jo_sensors(&m, d, y);
    for (int i = 0; i < 6; i++) {
        sum = 0.0;
        for (int j = 0; j < 6; j++) sum += data.C[6 * i + j] * y[j];
        CHECK(fabs(sum - y[6 + i]) < 1e-12 * (1.0 + fabs(sum)));
    }
    memcpy(jo_data_q(d) + 10, jo_data_q(d) + 3, 4 * sizeof(double));
    move(jo_data_q(d), 11, 2.8);   /* + 0.3 rad between the end frames */
    CHECK(jo_accelerations(&m, d) == JO_BENT && jo_data_error_index(d) == 0);
    jo_data_free(d);
    return 0;
}
