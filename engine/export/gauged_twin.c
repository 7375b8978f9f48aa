/* gauged_twin.c - modal coordinates from strains, by a Kalman filter or by separate estimates; stress with confidence bands, and damage. */
#include "gauged_twin.h"
#include "bands.h"
#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define NO_VARIANCE 1e-300      /* smallest variance in relative changes of covariances, which prevents division by 0 */
/* ratio of the smallest and largest diagonal entry of R below which the gauges do not determine all modes */
#define DEPENDENT 1e-12
#define TIME_ROUNDING 1e-9      /* round-off of the time, relative to the interval of the means */
#define MAX_COUNT 9e15          /* largest integer in a memory; doubles represent integers up to 2^53 exactly */

/* indices of the first numbers of the memory */
enum { AT_TIME, AT_ORIGIN, AT_INTERVAL, AT_SAMPLES, AT_NUMBER, AT_WATCHED, AT_SEEN, AT_USUAL, AT_STARTED, AT_LAP, AT_STEADY, AT_TOLD, HEADS };

struct jo_twin {
    const jo_plan *plan;
    double *memory;         /* memory of the twin, consecutive arrays */
    long long count;
    double *mask, *state, *x, *f, *K, *S, *P, *D, *health, *sum, *centre, *meter;
    /* trial gains and work space of products */
    double *K2, *S2, *P2, *pred, *T, *U, *Hs, *L, *lap_F, *lap_G, *lap_Q, *to_F, *to_G, *to_Q;
    double *x2, *y, *shown, *f2, *p, *dp, *cov, *moved, *V, *W, *scratch, *out;
    const double *F, *Gu;   /* matrices for the present number of steps between samples */
    jo_band band;
    double *seen, *seen2;
    unsigned char *states;
    int fresh;              /* whether the band was computed from the present P */
};

static int is_finite(double x) { return x >= -DBL_MAX && x <= DBL_MAX; }
static double *take(double *base, long long *at, long long count)
{
    double *const found = base ? base + *at : 0;
    *at += count;
    return found;
}

static int largest_depth(const jo_plan *p)
{
    int most = 0;
    for (int i = 0; i < 3; i++) most = p->metered && p->meter[i].depth > most ? p->meter[i].depth : most;
    return most;
}

/* take the arrays from `base` on; returns the number of doubles; with base NULL they are only counted */
static long long lay_out(jo_twin *k, const jo_plan *p, double *base)
{
    long long at = 0;
    const long long nx = p->nx, n = p->n, nc = p->nchannel, ng = p->ngauge, ns = p->nspot, ne = p->nerror, side = nx > nc ? nx : nc;
    k->memory = take(base, &at, HEADS);
    k->mask = take(base, &at, nc);
    k->state = take(base, &at, ng);
    k->x = take(base, &at, nx);
    k->f = take(base, &at, n);
    k->K = take(base, &at, nx * nc);
    k->S = take(base, &at, nc);
    k->P = take(base, &at, nx * nx);
    k->D = take(base, &at, nx * ne);
    k->health = take(base, &at, 8 * ng);
    k->sum = take(base, &at, ns);
    k->centre = take(base, &at, ns);
    k->meter = take(base, &at, 0);
    for (int i = 0; i < 3; i++) take(base, &at, p->metered ? ns * (JO_METER + p->meter[i].depth) : 0);
    k->count = at;
    k->K2 = take(base, &at, nx * nc);
    k->S2 = take(base, &at, nc);
    k->P2 = take(base, &at, nx * nx);
    k->pred = take(base, &at, nx * nx);
    k->T = take(base, &at, side * (side + nx));
    k->U = take(base, &at, side * side);
    k->Hs = take(base, &at, nc * nx);
    k->L = take(base, &at, nc * nc);
    double **const laps[6] = {&k->lap_F, &k->lap_Q, &k->to_F, &k->to_Q, &k->lap_G, &k->to_G};
    for (int i = 0; i < 6; i++) *laps[i] = take(base, &at, p->method == JO_TWIN_OBSERVER ? nx * (i < 4 ? nx : p->nd) : 0);
    k->x2 = take(base, &at, nx);
    k->y = take(base, &at, nc);
    k->shown = take(base, &at, nc);
    k->seen = take(base, &at, nc);
    k->seen2 = take(base, &at, nc);
    k->f2 = take(base, &at, n);
    k->p = take(base, &at, n);
    k->dp = take(base, &at, n);
    k->cov = take(base, &at, n * n);
    k->moved = take(base, &at, n * ne);
    k->V = take(base, &at, side * ne);
    k->W = take(base, &at, side * ne);
    k->scratch = take(base, &at, JO_METER + 2 * largest_depth(p) + 2);
    k->out = take(base, &at, p->noutput);
    at += jo_band_place(&k->band, p, base ? base + at : 0);
    k->states = (unsigned char *)take(base, &at, (ng + 7) / 8);
    return at;
}

enum { HEAD = (sizeof(jo_twin) + 63) / 64 * 64 };

long long jo_twin_bytes(const jo_plan *p)
{
    jo_twin k;
    memset(&k, 0, sizeof k);
    return HEAD + 64 + (long long)sizeof(double) * lay_out(&k, p, 0);
}

jo_twin *jo_twin_place(const jo_plan *p, void *memory, long long bytes)
{
    if (!memory || bytes < jo_twin_bytes(p)) return 0;
    char *start = (char *)memory + (64 - (size_t)memory % 64);
    jo_twin *k = (jo_twin *)start;
    memset(k, 0, sizeof *k);
    k->plan = p;
    lay_out(k, p, (double *)(start + HEAD));
    jo_twin_reset(k);
    return k;
}

void jo_twin_reset(jo_twin *k)
{
    const jo_plan *p = k->plan;
    for (long long i = 0; i < k->count; i++) k->memory[i] = 0.0;
    k->memory[AT_TIME] = k->memory[AT_ORIGIN] = k->memory[AT_INTERVAL] = NAN;
    k->memory[AT_SEEN] = k->memory[AT_USUAL] = NAN;
    for (int c = 0; c < p->ngauge; c++) {
        k->health[JO_HEALTH_LAST * p->ngauge + c] = k->health[JO_HEALTH_GOOD * p->ngauge + c] = NAN;
        k->states[c] = JO_VALUE_OK;
    }
    for (int i = 0; i < p->noutput; i++) k->out[i] = NAN;
    jo_band_blind(&k->band, p);
    k->fresh = 0;
}

/* -- matrices, row-major ------------------------------------------------------------------------ */

/* C (a x c) = A (a x b) B (b x c) */
static void times(const double *A, const double *B, double *C, int a, int b, int c)
{
    for (int i = 0; i < a; i++) {
        double *row = C + (long long)i * c;
        for (int j = 0; j < c; j++) row[j] = 0.0;
        for (int l = 0; l < b; l++) {
            const double s = A[(long long)i * b + l];
            const double *from = B + (long long)l * c;
            if (s == 0.0) continue;
            for (int j = 0; j < c; j++) row[j] += s * from[j];
        }
    }
}

/* C (a x c) = A (a x b) B^T, B (c x b) */
static void times_turned(const double *A, const double *B, double *C, int a, int b, int c)
{
    for (int i = 0; i < a; i++)
        for (int j = 0; j < c; j++) {
            double sum = 0.0;
            for (int l = 0; l < b; l++) sum += A[(long long)i * b + l] * B[(long long)j * b + l];
            C[(long long)i * c + j] = sum;
        }
}

static void apply(const double *A, const double *x, double *y, int a, int b) { times_turned(A, x, y, a, b, 1); }

static void even(double *A, int n)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++) A[i * n + j] = A[j * n + i] = 0.5 * (A[i * n + j] + A[j * n + i]);
}

/* Cholesky factor L of A = L L^T in place, lower triangle; 0 if A is not positive definite */
static int cholesky(double *A, int n)
{
    for (int j = 0; j < n; j++) {
        double d = A[j * n + j];
        for (int l = 0; l < j; l++) d -= A[j * n + l] * A[j * n + l];
        if (!(d > 0.0)) return 0;
        d = A[j * n + j] = sqrt(d);
        for (int i = j + 1; i < n; i++) {
            double s = A[i * n + j];
            for (int l = 0; l < j; l++) s -= A[i * n + l] * A[j * n + l];
            A[i * n + j] = s / d;
        }
    }
    return 1;
}

/* b := L^-1 b */
static void forward(const double *L, double *b, int n)
{
    for (int i = 0; i < n; i++) {
        double s = b[i];
        for (int l = 0; l < i; l++) s -= L[i * n + l] * b[l];
        b[i] = s / L[i * n + i];
    }
}

/* b := L^-T b */
static void backward(const double *L, double *b, int n)
{
    for (int i = n - 1; i >= 0; i--) {
        double s = b[i];
        for (int l = i + 1; l < n; l++) s -= L[l * n + i] * b[l];
        b[i] = s / L[i * n + i];
    }
}

/* -- gains -------------------------------------------------------------------------------------- */

/* gain K2 (nx x seen), variances S2 (seen) of the innovations and covariance P2 from pred, scaled by the noise of each channel; returns 0
 * if the matrix is singular */
static int update(jo_twin *k, const double *seen)
{
    const jo_plan *p = k->plan;
    const int nx = p->nx, nc = p->nchannel;
    int m = 0;
    double *scale = k->shown;
    for (int i = 0; i < nc; i++) {
        if (seen[i] == 0.0) continue;
        scale[m] = sqrt(p->R[i * nc + i]);
        for (int j = 0; j < nx; j++) k->Hs[m * nx + j] = p->H[i * nx + j] / scale[m];
        int l = 0;
        for (int j = 0; j < i; j++)
            if (seen[j] != 0.0) {
                k->U[m * nc + l] = p->R[i * nc + j] / (scale[m] * scale[l]);
                l++;
            }
        k->U[m * nc + m] = 1.0;
        m++;
    }
    times_turned(k->Hs, k->pred, k->T, m, nx, nx);          /* H P, as P is symmetric */
    times_turned(k->T, k->Hs, k->L, m, nx, m);
    for (int i = 0; i < m; i++)
        for (int j = 0; j <= i; j++) k->L[i * m + j] = k->L[j * m + i] = 0.5 * (k->L[i * m + j] + k->L[j * m + i]) + k->U[i * nc + j];
    for (int i = 0; i < m; i++) k->S2[i] = k->L[i * m + i] * scale[i] * scale[i];
    if (!cholesky(k->L, m)) return 0;
    for (int j = 0; j < nx; j++) {                          /* one row of K at a time */
        double *row = k->K2 + (long long)j * m;
        for (int i = 0; i < m; i++) row[i] = k->T[(long long)i * nx + j];
        forward(k->L, row, m);
        backward(k->L, row, m);
    }
    /* Joseph form, positive definite: (1 - K H) P (1 - K H)^T + K R K^T */
    times(k->K2, k->Hs, k->T, nx, m, nx);
    for (int i = 0; i < nx; i++)
        for (int j = 0; j < nx; j++) k->T[i * nx + j] = (i == j ? 1.0 : 0.0) - k->T[i * nx + j];
    times(k->T, k->pred, k->P2, nx, nx, nx);
    times_turned(k->P2, k->T, k->pred, nx, nx, nx);
    for (int i = 0; i < m; i++)
        for (int j = 0; j <= i; j++) k->L[i * m + j] = k->L[j * m + i] = k->U[i * nc + j];
    times(k->K2, k->L, k->T, nx, m, m);
    times_turned(k->T, k->K2, k->P2, nx, m, nx);
    for (int i = 0; i < nx * nx; i++) k->P2[i] += k->pred[i];
    even(k->P2, nx);
    for (int j = 0; j < nx; j++)
        for (int i = 0; i < m; i++) k->K2[(long long)j * m + i] /= scale[i];
    return 1;
}

/* F, Gu and Q of several steps by binary powers; constant forces in between */
static void laps(jo_twin *k, double count)
{
    const jo_plan *p = k->plan;
    const int nx = p->nx, nd = p->nd;
    const size_t square = sizeof(double) * (size_t)(nx * nx), push = sizeof(double) * (size_t)(nx * nd);
    int begun = 0;
    memcpy(k->lap_F, p->F, square);
    memcpy(k->lap_Q, p->Q, square);
    if (nd > 0) memcpy(k->lap_G, p->Gu, push);
    for (;;) {
        const double half = floor(0.5 * count);
        if (count - 2.0 * half > 0.5) {
            if (!begun) {
                memcpy(k->to_F, k->lap_F, square);
                memcpy(k->to_Q, k->lap_Q, square);
                if (nd > 0) memcpy(k->to_G, k->lap_G, push);
                begun = 1;
            } else {
                times(k->lap_F, k->to_Q, k->T, nx, nx, nx);
                times_turned(k->T, k->lap_F, k->to_Q, nx, nx, nx);
                for (int i = 0; i < nx * nx; i++) k->to_Q[i] += k->lap_Q[i];
                if (nd > 0) times(k->lap_F, k->to_G, k->T, nx, nx, nd);
                for (int i = 0; i < nx * nd; i++) k->to_G[i] = k->T[i] + k->lap_G[i];
                times(k->lap_F, k->to_F, k->T, nx, nx, nx);
                memcpy(k->to_F, k->T, square);
            }
        }
        count = half;
        if (count < 0.5) break;
        times(k->lap_F, k->lap_Q, k->T, nx, nx, nx);
        times_turned(k->T, k->lap_F, k->U, nx, nx, nx);
        for (int i = 0; i < nx * nx; i++) k->lap_Q[i] += k->U[i];
        if (nd > 0) times(k->lap_F, k->lap_G, k->T, nx, nx, nd);
        for (int i = 0; i < nx * nd; i++) k->lap_G[i] += k->T[i];
        times(k->lap_F, k->lap_F, k->T, nx, nx, nx);
        memcpy(k->lap_F, k->T, square);
    }
}

static int same(const double *a, const double *b, int n)
{
    for (int i = 0; i < n; i++)
        if (a[i] != b[i]) return 0;
    return 1;
}

typedef enum { FAILED = 0, KEPT = 1, NEW = 2, STEADY = 3 } outcome;

/* gain of the next sample; a gain that recurs is stored */
static outcome gain(jo_twin *k, double lap, const double *seen)
{
    const jo_plan *p = k->plan;
    const int nx = p->nx, observer = p->method == JO_TWIN_OBSERVER, started = k->memory[AT_STARTED] != 0.0;
    const int again = started && k->memory[AT_LAP] == lap && same(k->mask, seen, p->nchannel);
    if (again && k->memory[AT_STEADY] != 0.0) return KEPT;
    if (observer && started) {
        const double *Q = lap == 1.0 ? p->Q : k->to_Q;
        times(k->F, k->P, k->T, nx, nx, nx);
        times_turned(k->T, k->F, k->pred, nx, nx, nx);
        for (int i = 0; i < nx * nx; i++) k->pred[i] += Q[i];
        even(k->pred, nx);
    } else {
        memcpy(k->pred, p->P0, sizeof(double) * (size_t)(nx * nx));
    }
    if (!update(k, seen)) return FAILED;
    if (!observer) return STEADY;
    if (!again) return NEW;
    double most = 0.0;
    for (int i = 0; i < nx; i++)
        for (int j = 0; j < nx; j++) {
            const double a = k->P2[i * nx + i], b = k->P2[j * nx + j];
            const double size = sqrt(a > NO_VARIANCE ? a : NO_VARIANCE) * sqrt(b > NO_VARIANCE ? b : NO_VARIANCE);
            const double change = fabs(k->P2[i * nx + j] - k->P[i * nx + j]) / size;
            if (change > most) most = change;
        }
    return most < p->steady ? STEADY : NEW;
}

/* gain of separate samples without a prior: Householder's W = Q R of the whitened rows, K = R^-1 Q^T L^-1 */
static outcome alone(jo_twin *k, const double *seen)
{
    const jo_plan *p = k->plan;
    const int n = p->n, nc = p->nchannel;
    if (k->memory[AT_STARTED] != 0.0 && same(k->mask, seen, nc)) return k->memory[AT_TOLD] != 0.0 ? KEPT : FAILED;
    int m = 0;
    for (int i = 0; i < nc; i++) {
        if (seen[i] == 0.0) continue;
        int l = 0;
        for (int j = 0; j < nc; j++)
            if (seen[j] != 0.0) k->U[m * nc + l++] = p->R[i * nc + j];
        for (int j = 0; j < n; j++) k->Hs[m * n + j] = p->B[i * n + j];
        m++;
    }
    if (m < n) return FAILED;
    for (int i = 0; i < m; i++)
        for (int j = 0; j < m; j++) k->L[i * m + j] = k->U[i * nc + j];
    if (!cholesky(k->L, m)) return FAILED;
    const int width = n + m;
    double *A = k->T;                                       /* [L^-1 B, L^-1] */
    for (int j = 0; j < width; j++) {
        for (int i = 0; i < m; i++) k->shown[i] = j < n ? k->Hs[i * n + j] : (double)(i == j - n);
        forward(k->L, k->shown, m);
        for (int i = 0; i < m; i++) A[i * width + j] = k->shown[i];
    }
    double least = INFINITY, most = 0.0;
    for (int j = 0; j < n; j++) {
        double norm = 0.0;
        for (int i = j; i < m; i++) norm += A[i * width + j] * A[i * width + j];
        norm = sqrt(norm);
        if (!(norm > 0.0)) return FAILED;
        const double alpha = A[j * width + j] > 0.0 ? -norm : norm;
        double length = 0.0;
        for (int i = j; i < m; i++) {
            k->shown[i] = A[i * width + j] - (i == j ? alpha : 0.0);
            length += k->shown[i] * k->shown[i];
        }
        for (int c = j; c < width; c++) {
            double s = 0.0;
            for (int i = j; i < m; i++) s += k->shown[i] * A[i * width + c];
            s *= 2.0 / length;
            for (int i = j; i < m; i++) A[i * width + c] -= s * k->shown[i];
        }
        const double size = fabs(A[j * width + j]);
        least = size < least ? size : least;
        most = size > most ? size : most;
    }
    if (least <= DEPENDENT * most) return FAILED;
    for (int c = 0; c < m; c++)                             /* R K = transformed right-hand side */
        for (int i = n - 1; i >= 0; i--) {
            double s = A[i * width + n + c];
            for (int l = i + 1; l < n; l++) s -= A[i * width + l] * k->K2[l * m + c];
            k->K2[i * m + c] = s / A[i * width + i];
        }
    for (int c = 0; c < n; c++)                             /* R^-1 */
        for (int i = n - 1; i >= 0; i--) {
            double s = (double)(i == c);
            for (int l = i + 1; l < n; l++) s -= A[i * width + l] * k->pred[l * n + c];
            k->pred[i * n + c] = s / A[i * width + i];
        }
    times_turned(k->pred, k->pred, k->P2, n, n, n);
    for (int i = 0; i < m; i++) k->S2[i] = 0.0;
    return STEADY;
}

/* -- one sample --------------------------------------------------------------------------------- */

static void cross(const double *a, const double *b, double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* known modal forces f (n), from the motion of the frame (floating frame, docs/theory.md) and the mean loads */
static void known_forces(const jo_plan *p, const double *motion, const double *q, const double *dq, double *f)
{
    const int n = p->n;
    for (int j = 0; j < n; j++) f[j] = p->mean_force[j];
    if (!p->moving) return;
    const double *a = motion, *w = motion + 3, *dw = motion + 6;
    const double square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
    const int turns = square != 0.0 || dw[0] != 0.0 || dw[1] != 0.0 || dw[2] != 0.0;
    for (int j = 0; j < n; j++) {
        f[j] -= a[0] * p->I3[j] + a[1] * p->I3[n + j] + a[2] * p->I3[2 * n + j];
        if (!turns) continue;
        double N[9], G[9] = {0.0};
        for (int c = 0; c < 9; c++) N[c] = p->N0[9 * j + c];
        for (int l = 0; l < n; l++)
            for (int c = 0; c < 9; c++) {
                const double e = p->E[((long long)l * n + j) * 9 + c];
                N[c] += q[l] * e;
                G[c] += dq[l] * e;
            }
        double wNw = 0.0;
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++) wNw += w[r] * N[3 * r + c] * w[c];
        f[j] += (N[0] + N[4] + N[8]) * square - wNw;
        f[j] -= (N[5] - N[7]) * dw[0] + (N[6] - N[2]) * dw[1] + (N[1] - N[3]) * dw[2];
        f[j] -= 2.0 * ((G[5] - G[7]) * w[0] + (G[6] - G[2]) * w[1] + (G[1] - G[3]) * w[2]);
    }
}

/* y minus the strains by known forces, and minus the inertial forces of the motion in the equilibrium equations */
static void offsets(jo_twin *k, const double *motion, const double *f)
{
    const jo_plan *p = k->plan;
    const int n = p->n, ng = p->ngauge, na = p->na;
    double *bent = k->dp;                                   /* static part, then sum of the modes */
    for (int j = 0; j < n; j++) bent[j] = f[j] * p->rest[j];
    for (int i = 0; i < ng; i++) {
        double s = 0.0;
        for (int j = 0; j < n; j++) s += p->B[i * n + j] * bent[j];
        k->y[i] -= s;
    }
    if (!p->balanced) return;
    const double *a = motion, *w = motion + 3, *dw = motion + 6, *S = p->first_moment;
    double once[3], twice[3], turned[3], Jw[3], Jdw[3], carried[6];
    for (int j = 0; j < n; j++) bent[j] += k->p[j];
    for (int i = 0; i < 6; i++) {
        carried[i] = 0.0;
        for (int l = 0; l < na; l++) carried[i] += p->wrenches[i * na + l] * p->mean[l];
    }
    cross(w, S, once);
    cross(w, once, twice);
    cross(dw, S, once);
    for (int i = 0; i < 3; i++) carried[i] -= p->mass * a[i] + once[i] + twice[i];
    for (int i = 0; i < 3; i++) {
        Jw[i] = p->inertia[3 * i] * w[0] + p->inertia[3 * i + 1] * w[1] + p->inertia[3 * i + 2] * w[2];
        Jdw[i] = p->inertia[3 * i] * dw[0] + p->inertia[3 * i + 1] * dw[1] + p->inertia[3 * i + 2] * dw[2];
    }
    cross(S, a, once);
    cross(w, Jw, turned);
    for (int i = 0; i < 3; i++) {
        carried[3 + i] -= once[i] + Jdw[i] + turned[i];
        for (int l = 0; l < na; l++) {
            double arm = 0.0;
            for (int j = 0; j < n; j++) arm += p->arms[((long long)i * na + l) * n + j] * bent[j];
            carried[3 + i] += arm * (k->x[p->load_at + l] + p->mean[l]);
        }
    }
    for (int i = 0; i < 6; i++) k->y[ng + i] -= carried[i];
}

/* prediction x2, and innovations of the valid channels */
static void predict(jo_twin *k, const double *f, const double *seen)
{
    const jo_plan *p = k->plan;
    const int nx = p->nx;
    if (p->method != JO_TWIN_OBSERVER || k->memory[AT_STARTED] == 0.0) {
        for (int i = 0; i < nx; i++) k->x2[i] = 0.0;
        for (int i = 0; i < p->nd; i++) k->x2[i] = f[p->dynamic[i]] / p->stiffness[p->dynamic[i]];
    } else {
        apply(k->F, k->x, k->x2, nx, nx);
        for (int j = 0; j < p->nd; j++) {
            const double push = 0.5 * (k->f[p->dynamic[j]] + f[p->dynamic[j]]);
            for (int i = 0; i < nx; i++) k->x2[i] += k->Gu[i * p->nd + j] * push;
        }
    }
    for (int i = 0, m = 0; i < p->nchannel; i++) {
        if (seen[i] == 0.0) continue;
        double s = k->y[i];
        for (int j = 0; j < nx; j++) s -= p->H[i * nx + j] * k->x2[j];
        k->shown[m++] = s;
    }
}

/* deviations of the modes by each systematic gauge error, one column per error */
static void deviations(jo_twin *k, int first)
{
    const jo_plan *p = k->plan;
    const int nx = p->nx, n = p->n, ne = p->nerror, ng = p->ngauge, nc = p->nchannel;
    int m = 0;
    if (p->method != JO_TWIN_OBSERVER) {                    /* K of each gauge times the size of its errors */
        for (int i = 0; i < nc; i++) m += k->mask[i] != 0.0;
        for (int g = 0, l = 0; g < ng; g++) {
            double square = 0.0;
            for (int r = 0; r < p->kinds; r++) {
                double s = 0.0;
                for (int j = 0; j < n; j++) s += p->errors[(r * ng + g) * n + j] * k->p[j];
                square += s * s;
            }
            for (int j = 0; j < n; j++) k->moved[j * ne + g] = k->mask[g] != 0.0 ? k->K[j * m + l] * sqrt(square) : 0.0;
            l += k->mask[g] != 0.0;
        }
        return;
    }
    /* D = F D, then D + K (V - H D), V: errors at the channels */
    if (!first) {
        times(k->F, k->D, k->V, nx, nx, ne);
        memcpy(k->D, k->V, sizeof(double) * (size_t)nx * (size_t)ne);
    }
    for (int i = 0; i < nc; i++) {
        if (k->mask[i] == 0.0) continue;
        for (int c = 0; c < ne; c++) {
            double s = 0.0;
            if (i < ng && c % ng == i)
                for (int j = 0; j < n; j++) s += p->errors[((c / ng) * ng + i) * n + j] * k->p[j];
            for (int j = 0; j < nx; j++) s -= p->H[i * nx + j] * k->D[j * ne + c];
            k->W[m * ne + c] = s;
        }
        m++;
    }
    times(k->K, k->W, k->V, nx, m, ne);
    for (int i = 0; i < nx * ne; i++) k->D[i] += k->V[i];
    times(p->shape, k->D, k->moved, n, nx, ne);
}

/* modes and stress from the state */
static void estimate_outputs(jo_twin *k, int first)
{
    const jo_plan *p = k->plan;
    const int n = p->n, nx = p->nx;
    if (p->shape) {
        apply(p->shape, k->x, k->p, n, nx);
        for (int j = 0; j < n; j++) k->p[j] += k->f[j] * p->rest[j];
    } else {
        memcpy(k->p, k->x, sizeof(double) * (size_t)n);
    }
    if (p->nerror) deviations(k, first);
    if (!k->fresh) {
        if (p->shape) {
            times(p->shape, k->P, k->T, n, nx, nx);
            times_turned(k->T, p->shape, k->cov, n, nx, n);
        } else {
            memcpy(k->cov, k->P, sizeof(double) * (size_t)(n * n));
        }
        jo_band_spread(&k->band, p, k->cov);
        k->fresh = 1;
    }
    jo_band_stress(&k->band, p, k->p, k->moved);
}

static double *meter_of(jo_twin *k, int which, int spot)
{
    const jo_plan *p = k->plan;
    double *at = k->meter;
    for (int i = 0; i < which; i++) at += (long long)p->nspot * (JO_METER + p->meter[i].depth);
    return at + (long long)spot * (JO_METER + p->meter[which].depth);
}

/* damage of the estimated cycles, also with peaks increased and reduced by half of the band width; watched time */
static void count_cycles(jo_twin *k, double time, int told)
{
    const jo_plan *p = k->plan;
    double *m = k->memory;
    if (isnan(m[AT_ORIGIN])) {
        m[AT_ORIGIN] = time;
        m[AT_INTERVAL] = 0.0;
    }
    const double number = floor((time - m[AT_ORIGIN]) / p->every + TIME_ROUNDING);
    if (number != m[AT_INTERVAL]) {                         /* peaks relative to the present mean */
        if (m[AT_SAMPLES] > 0.0 && m[AT_NUMBER] > 0.0)
            for (int i = 0; i < p->nspot; i++) k->centre[i] = k->sum[i] / m[AT_NUMBER];
        m[AT_SAMPLES] = 0.0;
        m[AT_INTERVAL] = number;
    }
    m[AT_SAMPLES] += 1.0;
    for (int i = 0; i < p->nspot; i++) {
        const double s = k->band.value[i], half = 0.5 * (k->band.high[i] - k->band.low[i]), away = s - k->centre[i];
        const double outer = s + copysign(half, away), least = fabs(away) - half;
        const double inner = k->centre[i] + copysign(isnan(least) ? least : least > 0.0 ? least : 0.0, away);
        jo_meter_push(&p->meter[0], meter_of(k, 0, i), &s, 1);
        jo_meter_push(&p->meter[1], meter_of(k, 1, i), &inner, 1);
        jo_meter_push(&p->meter[2], meter_of(k, 2, i), &outer, 1);
        if (told) k->sum[i] += s;
    }
    m[AT_NUMBER] += told;
    const double step = time - m[AT_SEEN];
    if (isnan(m[AT_USUAL])) m[AT_USUAL] = step;
    if (told && step <= p->pause * m[AT_USUAL]) m[AT_WATCHED] += step;
    m[AT_SEEN] = time;
}

/* gate: channels whose innovation exceeds `gate` standard deviations are excluded; returns whether there are any */
static int gated(jo_twin *k, const double *seen, const double *variance)
{
    const jo_plan *p = k->plan;
    int wild = 0;
    for (int i = 0, m = 0; i < p->nchannel; i++) {
        k->seen2[i] = seen[i];
        if (seen[i] == 0.0) continue;
        if (i < p->ngauge && fabs(k->shown[m]) > p->gate * sqrt(variance[m])) {
            k->seen2[i] = 0.0;
            wild = 1;
        }
        m++;
    }
    return wild;
}

/* store the gain, covariance and variances of the sample */
static void keep(jo_twin *k, outcome found, double lap, const double *seen)
{
    const jo_plan *p = k->plan;
    const int nx = p->nx;
    int m = 0;
    for (int i = 0; i < p->nchannel; i++) {
        k->mask[i] = seen[i];
        m += seen[i] != 0.0;
    }
    k->memory[AT_LAP] = lap;
    if (found == KEPT) return;
    if (found != FAILED) {
        memcpy(k->K, k->K2, sizeof(double) * (size_t)nx * (size_t)m);
        memcpy(k->S, k->S2, sizeof(double) * (size_t)m);
        memcpy(k->P, k->P2, sizeof(double) * (size_t)nx * (size_t)nx);
    }
    k->memory[AT_STEADY] = found == STEADY;
    k->memory[AT_TOLD] = found != FAILED;
    k->fresh = 0;
}

/* one sample: check of the time, health of the gauges, gain, gate, update, stress, damage */
int jo_twin_step(jo_twin *k, double time, const double *strain, const double *motion)
{
    const jo_plan *p = k->plan;
    double *memory = k->memory, *seen = k->seen;
    const int nx = p->nx, nc = p->nchannel, ng = p->ngauge, observer = p->method == JO_TWIN_OBSERVER;
    const int first = memory[AT_STARTED] == 0.0;
    double lap = first ? 0.0 : 1.0;
    if (!is_finite(time)) return JO_TWIN_WRONG;
    for (int i = 0; i < 9 && p->moving; i++)
        if (!motion || !is_finite(motion[i])) return JO_TWIN_WRONG;
    if (!first) {
        const double dt = time - memory[AT_TIME];
        if (!(dt > 0.0)) return JO_TWIN_CLOCK;
        if (observer) {
            lap = floor(dt / p->step + 0.5);
            if (lap < 1.0 || fabs(dt - lap * p->step) >= p->jitter * p->step) return JO_TWIN_CLOCK;
        }
    }
    jo_health_check(&p->health, k->health, k->states, strain, 0, k->states, 1, ng);
    for (int i = 0; i < nc; i++) {
        seen[i] = i >= ng || k->states[i] == JO_VALUE_OK ? 1.0 : 0.0;
        k->y[i] = i < ng && seen[i] != 0.0 ? strain[i] : 0.0;
        if (i < ng) k->state[i] = k->states[i];
    }
    if (observer) {
        apply(p->shape, k->x, k->p, p->n, nx);
        apply(p->rates, k->x, k->dp, p->n, nx);
        known_forces(p, motion, k->p, k->dp, k->f2);
        offsets(k, motion, k->f2);
        if (lap > 1.0) laps(k, lap);
        k->F = lap > 1.0 ? k->to_F : p->F;
        k->Gu = lap > 1.0 ? k->to_G : p->Gu;
    }
    outcome found = p->method == JO_TWIN_ALONE ? alone(k, seen) : gain(k, lap, seen);
    if (found != FAILED) predict(k, k->f2, seen);
    if (found != FAILED && p->gate > 0.0 && gated(k, seen, found == KEPT ? k->S : k->S2)) {
        seen = k->seen2;
        found = gain(k, lap, seen);
        if (found != FAILED) predict(k, k->f2, seen);
    }
    keep(k, found, lap, seen);
    if (found != FAILED) {
        int m = 0;
        for (int i = 0; i < nc; i++) m += seen[i] != 0.0;
        for (int i = 0; i < nx; i++) {
            double s = k->x2[i];
            for (int c = 0; c < m; c++) s += k->K[(long long)i * m + c] * k->shown[c];
            k->x[i] = s;
        }
        if (observer) memcpy(k->f, k->f2, sizeof(double) * (size_t)p->n);
        estimate_outputs(k, first);
    } else {
        jo_band_blind(&k->band, p);
    }
    memory[AT_STARTED] = 1.0;
    memory[AT_TIME] = time;
    if (p->metered) count_cycles(k, time, found != FAILED);
    return found != FAILED ? JO_TWIN_OK : JO_TWIN_BLIND;
}

double jo_twin_time(const jo_twin *k) { return k->memory[AT_TIME]; }
const unsigned char *jo_twin_states(const jo_twin *k) { return k->states; }

/* outputs: stress, bands, damage, cycles, watched time */
const double *jo_twin_outputs(jo_twin *k)
{
    const jo_plan *p = k->plan;
    double *out = k->out;
    for (int i = 0; i < p->nspot; i++) {
        *out++ = k->band.value[i];
        *out++ = k->band.low[i];
        *out++ = k->band.high[i];
        if (!p->metered) continue;
        double d[3];
        for (int j = 0; j < 3; j++) d[j] = jo_meter_damage(&p->meter[j], meter_of(k, j, i), p->residue, k->scratch);
        *out++ = d[0];
        *out++ = d[1] < d[0] ? d[1] : d[0];
        *out++ = d[2] > d[0] ? d[2] : d[0];
    }
    if (p->metered) *out++ = k->memory[AT_WATCHED];
    for (int i = 0; i < p->na; i++) *out++ = k->memory[AT_STARTED] != 0.0 ? k->x[p->load_at + i] + p->mean[i] : NAN;
    return k->out;
}

/* -- saved memories: "JOTW", version, mark, count of doubles, the doubles, checksum; all little endian ---------------- */

enum { VERSION = 1, LEAD = 4 + 4 + 4 + 8, TAIL = 4 };

static void put_number(unsigned char *to, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) to[i] = (unsigned char)(value >> (8 * i) & 0xff);
}
static uint64_t get_number(const unsigned char *from, int bytes)
{
    uint64_t value = 0;
    for (int i = 0; i < bytes; i++) value |= (uint64_t)from[i] << (8 * i);
    return value;
}
static double get_double(const unsigned char *from)
{
    const uint64_t bits = get_number(from, 8);
    double value;
    memcpy(&value, &bits, 8);
    return value;
}

/* CRC-32 of ISO 3309, by half-bytes */
static uint32_t checksum(const unsigned char *bytes, long long count)
{
    static const uint32_t table[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4, 0x4db26158, 0x5005713c,
                                       0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c, 0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
    uint32_t crc = 0xffffffffu;
    for (long long i = 0; i < count; i++) {
        crc = table[(crc ^ bytes[i]) & 15] ^ crc >> 4;
        crc = table[(crc ^ (unsigned)(bytes[i] >> 4)) & 15] ^ crc >> 4;
    }
    return ~crc;
}

long long jo_twin_saved_bytes(const jo_twin *k) { return LEAD + 8 * k->count + TAIL; }

void jo_twin_save(const jo_twin *k, unsigned char *buffer)
{
    memcpy(buffer, "JOTW", 4);
    put_number(buffer + 4, VERSION, 4);
    put_number(buffer + 8, k->plan->mark, 4);
    put_number(buffer + 12, (uint64_t)k->count, 8);
    for (long long i = 0; i < k->count; i++) {
        uint64_t bits;
        memcpy(&bits, &k->memory[i], 8);
        put_number(buffer + LEAD + 8 * i, bits, 8);
    }
    const long long end = LEAD + 8 * k->count;
    put_number(buffer + end, checksum(buffer, end), 4);
}

/* whether numbers from .. to - 1 of a saved memory are finite and, if most >= 0, integers from 0 to `most` */
static int possible(const unsigned char *numbers, long long from, long long to, double most)
{
    for (long long i = from; i < to; i++) {
        const double x = get_double(numbers + 8 * i);
        if (!is_finite(x) || (most >= 0.0 && (x < 0.0 || x > most || x != floor(x)))) return 0;
    }
    return 1;
}

/* check version, mark, size, checksum and ranges of a saved memory, then load it */
int jo_twin_load(jo_twin *k, const unsigned char *buffer, long long bytes)
{
    const jo_plan *p = k->plan;
    const long long end = LEAD + 8 * k->count;
    if (!buffer || bytes != end + TAIL || memcmp(buffer, "JOTW", 4) || get_number(buffer + 4, 4) != VERSION) return JO_TWIN_FOREIGN;
    if (get_number(buffer + 8, 4) != p->mark || get_number(buffer + 12, 8) != (uint64_t)k->count) return JO_TWIN_FOREIGN;
    if (get_number(buffer + end, 4) != checksum(buffer, end)) return JO_TWIN_FOREIGN;
    const unsigned char *numbers = buffer + LEAD;
    const long long mask = k->mask - k->memory, state = k->state - k->memory, x = k->x - k->memory;
    const long long health = k->health - k->memory, sum = k->sum - k->memory, meter = k->meter - k->memory;
    if (!possible(numbers, AT_SAMPLES, AT_WATCHED + 1, -1.0) || !possible(numbers, AT_STARTED, AT_STARTED + 1, 1.0)) return JO_TWIN_FOREIGN;
    if (!possible(numbers, AT_LAP, AT_LAP + 1, MAX_COUNT) || !possible(numbers, AT_STEADY, mask + p->nchannel, 1.0)) return JO_TWIN_FOREIGN;
    if (!possible(numbers, state, x, JO_VALUE_BACK) || !possible(numbers, x, health, -1.0)) return JO_TWIN_FOREIGN;
    if (!possible(numbers, sum, meter, -1.0)) return JO_TWIN_FOREIGN;
    if (get_double(numbers + 8 * AT_STARTED) != 0.0 && !possible(numbers, AT_TIME, AT_TIME + 1, -1.0)) return JO_TWIN_FOREIGN;
    long long at = meter;
    for (int i = 0; i < 3 && p->metered; i++)
        for (int s = 0; s < p->nspot; s++) {
            const int size = JO_METER + p->meter[i].depth;
            for (int j = 0; j < size; j++) k->scratch[j] = get_double(numbers + 8 * (at + j));
            if (!jo_meter_valid(&p->meter[i], k->scratch)) return JO_TWIN_FOREIGN;
            at += size;
        }
    for (long long i = 0; i < k->count; i++) k->memory[i] = get_double(numbers + 8 * i);
    for (int c = 0; c < p->ngauge; c++) k->states[c] = (unsigned char)k->state[c];
    jo_band_blind(&k->band, p);
    k->fresh = 0;
    return JO_TWIN_OK;
}
