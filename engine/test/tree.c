/* tree.c - test of random trees of rigid bodies in joint coordinates, for sanitizers.
 *
 * Checks: poses and velocities against independent kinematics; accelerations against d'Alembert's principle (no resultant of the inertial and
 * applied forces of a subtree along its joint); energy and momentum by the order of the methods; restored states and copies equal bit for
 * bit; error codes for missing inertia and values that are not finite.
 */
#include "jousto.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BODIES = 7, LINKS = 2 * BODIES, MARKERS = 2 * BODIES, NX = 7 * BODIES, NV = 6 * BODIES };
typedef enum { HINGE, SLIDE, BALL, WELD, CYLINDER, CROSS, KINDS } kind;

#define CHECK(x) \
    do { if (!(x)) { fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #x); exit(1); } } while (0)

/* Arrays of the jo_model of one tree. */
typedef struct {
    jo_model m;
    jo_body body[BODIES];
    jo_marker marker[MARKERS];
    jo_link link[LINKS];
    jo_coordinate coordinate[LINKS];
    jo_force force[LINKS];
    jo_along_data along[LINKS];
    double mass[BODIES], S[BODIES][3], J[BODIES][6], u[MARKERS][3], A[MARKERS][9], gravity[3];
    double x[NX + NV];
    int above[BODIES];      /* parent body; -1 for ground */
    int of_body[BODIES];    /* link of each body */
} tree;

/* Frame of reference; matrices by rows. */
typedef struct { double A[9], r[3], v[3], w[3]; } frame;

static unsigned state = 2026;
static double random_number(void)
{
    state = state * 1664525u + 1013904223u;
    return (double)(state >> 8) / (double)(1u << 24) - 0.5;
}

/* ---- vectors ------------------------------------------------------------------------------------ */

static void cross(double *y, const double *a, const double *b)
{
    for (int i = 0; i < 3; i++) y[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}
static void times(double *y, const double *A, const double *x)
{
    for (int i = 0; i < 3; i++) y[i] = A[3 * i] * x[0] + A[3 * i + 1] * x[1] + A[3 * i + 2] * x[2];
}
static void matrices(double *y, const double *A, const double *B)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) y[3 * i + j] = A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j];
}
static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void rotation(double *A, const double *e)
{
    const double a = e[0], b = e[1], c = e[2], d = e[3];
    const double y[9] = {1.0 - 2.0 * (c * c + d * d), 2.0 * (b * c - a * d), 2.0 * (b * d + a * c),
                         2.0 * (b * c + a * d), 1.0 - 2.0 * (b * b + d * d), 2.0 * (c * d - a * b),
                         2.0 * (b * d - a * c), 2.0 * (c * d + a * b), 1.0 - 2.0 * (b * b + c * c)};
    memcpy(A, y, sizeof y);
}
static void random_unit(double *e, int n)
{
    double square = 0.0;
    for (int i = 0; i < n; i++) e[i] = random_number();
    e[0] += 0.6;
    for (int i = 0; i < n; i++) square += e[i] * e[i];
    for (int i = 0; i < n; i++) e[i] /= sqrt(square);
}

/* quaternion of an orientation, from its largest component */
static void parameters(double *e, const double *A)
{
    const double s[4] = {A[0] + A[4] + A[8], A[0] - A[4] - A[8], A[4] - A[0] - A[8], A[8] - A[0] - A[4]};
    int k = 0;
    for (int i = 1; i < 4; i++)
        if (s[i] > s[k]) k = i;
    const double d[3] = {A[7] - A[5], A[2] - A[6], A[3] - A[1]};
    const double large = 0.5 * sqrt(1.0 + s[k]);
    e[k] = large;
    for (int i = 1; i < 4; i++) {
        if (k == 0) e[i] = d[i - 1] / (4.0 * large);
        else if (i != k) e[i] = (A[3 * (i - 1) + k - 1] + A[3 * (k - 1) + i - 1]) / (4.0 * large);
    }
    if (k) e[0] = d[k - 1] / (4.0 * large);
}

/* ---- a random tree ------------------------------------------------------------------------------ */

static jo_link *add_link(tree *t, int type, int parent, int body)
{
    static const int positions[] = {0, 1, 1, 4, 7}, rates[] = {0, 1, 1, 3, 6};
    jo_model *m = &t->m;
    jo_link *k = &t->link[m->nlink++];
    memset(k, 0, sizeof *k);
    k->type = type;
    k->parent = parent;
    k->body = body;
    k->outer = k->inner = k->joint = k->drive = k->driven = -1;
    k->x = m->nx;
    k->u = m->nu;
    m->nx += positions[type];
    m->nu += rates[type];
    return k;
}

/* a spring along the coordinate of the last link */
static void add_spring(tree *t)
{
    jo_model *m = &t->m;
    const jo_link *k = &t->link[m->nlink - 1];
    const int i = m->ncoordinate;
    jo_coordinate *c = &t->coordinate[i];
    memset(c, 0, sizeof *c);
    c->type = k->type == JO_LINK_HINGE ? JO_COORDINATE_ANGLE : JO_COORDINATE_ALONG;
    c->a = k->outer;
    c->b = k->inner;
    c->axis_a = 2;
    c->turn = k->type == JO_LINK_HINGE ? m->nturn++ : -1;
    c->link = m->nlink - 1;
    jo_force *f = &t->force[i];
    memset(f, 0, sizeof *f);
    f->type = JO_FORCE_along;
    f->a = f->b = f->body = f->other = f->signal = f->reference = f->spring = f->damper = f->release = f->state = -1;
    f->coordinate = i;
    const jo_along_data data = {6.0, 0.0, 0.1, 0.0, 0.0};
    t->along[i] = data;
    f->data = (const jo_real *)&t->along[i];
    m->ncoordinate++;
    m->nforce++;
}

static void random_body(tree *t, int i)
{
    double centre[3], square;
    t->mass[i] = 1.0 + 0.5 * random_number();
    for (int j = 0; j < 3; j++) centre[j] = 0.6 * random_number();
    square = dot(centre, centre);
    for (int j = 0; j < 3; j++) {
        t->S[i][j] = t->mass[i] * centre[j];
        t->J[i][j] = t->mass[i] * (square - centre[j] * centre[j]) + 0.1 + 0.02 * random_number();
        t->J[i][3 + j] = -t->mass[i] * centre[(j + 1) % 3] * centre[(j + 2) % 3] + 0.01 * random_number();
    }
    jo_body *b = &t->body[i];
    memset(b, 0, sizeof *b);
    b->iq = 7 * i;
    b->iv = 6 * i;
    b->mass = &t->mass[i];
    b->S0 = t->S[i];
    b->J0 = t->J[i];
    for (int side = 0; side < 2; side++) {
        double e[4];
        const int k = 2 * i + side;
        jo_marker *marker = &t->marker[k];
        memset(marker, 0, sizeof *marker);
        random_unit(e, 4);
        rotation(t->A[k], e);
        for (int j = 0; j < 3; j++) t->u[k][j] = 0.6 * random_number();
        marker->body = side ? i : t->above[i];
        marker->turns = 1;
        marker->u0 = t->u[k];
        marker->A0 = t->A[k];
    }
}

/* joint between marker 2 i on the parent and marker 2 i + 1 */
static void hang(tree *t, int i, int parent, kind which)
{
    static const int last[KINDS] = {JO_LINK_HINGE, JO_LINK_SLIDE, JO_LINK_BALL, JO_LINK_FIXED, JO_LINK_HINGE, JO_LINK_HINGE};
    const int two = which == CYLINDER || which == CROSS;
    if (two) {
        add_link(t, which == CROSS ? JO_LINK_HINGE : JO_LINK_SLIDE, parent, -1)->outer = 2 * i;
        parent = t->m.nlink - 1;
    }
    jo_link *k = add_link(t, last[which], parent, i);
    k->outer = two ? -1 : 2 * i;
    k->crossed = which == CROSS;
    k->inner = 2 * i + 1;
    if (which == HINGE || which == SLIDE) add_spring(t);
}

/* parent link: a fixed body is replaced by the body that it is fixed to */
static int bears(const tree *t, int link)
{
    while (link >= 0 && t->link[link].type == JO_LINK_FIXED) link = t->link[link].parent;
    return link;
}

static void make(tree *t, unsigned seed, int loose)
{
    state = 7919u * seed + 1u;
    memset(t, 0, sizeof *t);
    for (int i = 0; i < BODIES; i++) {
        t->above[i] = i ? (int)((random_number() + 0.5) * i) : -1;
        random_body(t, i);
        if (i == 0 && loose) add_link(t, JO_LINK_FREE, -1, 0);
        else hang(t, i, i ? bears(t, t->of_body[t->above[i]]) : -1, (kind)((unsigned)(i + (int)seed) % KINDS));
        t->of_body[i] = t->m.nlink - 1;
    }
    if (!loose) t->gravity[2] = -9.81;
    jo_model *m = &t->m;
    m->nbody = BODIES;
    m->nmarker = m->nactive = MARKERS;
    m->nq = 7 * BODIES;
    m->nv = NV;
    m->size = 1.0;
    m->gravity = t->gravity;
    m->body = t->body;
    m->marker = t->marker;
    m->coordinate = t->coordinate;
    m->force = t->force;
    m->link = t->link;
    for (int i = 0; i < m->nlink; i++) {
        const jo_link *k = &t->link[i];
        const int turns = k->type == JO_LINK_FREE ? 3 : k->type == JO_LINK_BALL ? 0 : -1, end = i + 1 < m->nlink ? k[1].x : m->nx;
        for (int j = k->x; j < end; j++) t->x[j] = random_number();
        if (turns >= 0) random_unit(t->x + k->x + turns, 4);
    }
    for (int j = 0; j < m->nu; j++) t->x[m->nx + j] = random_number();
}

/* ---- independent kinematics ------------------------------------------------------------------------ */

static const frame GROUND = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0}, {0}, {0}};

/* frame at u with axes B, fixed on another frame */
static frame fixed_on(const frame *o, const double *u, const double *B)
{
    frame y;
    double arm[3], v[3];
    times(arm, o->A, u);
    cross(v, o->w, arm);
    matrices(y.A, o->A, B);
    for (int i = 0; i < 3; i++) {
        y.r[i] = o->r[i] + arm[i];
        y.v[i] = o->v[i] + v[i];
        y.w[i] = o->w[i];
    }
    return y;
}

/* motion of a frame by a joint from coordinate zero; z is invariant except for BALL */
static void move(frame *f, const jo_link *k, const double *x, const double *u)
{
    double B[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, A[9], z[3] = {f->A[2], f->A[5], f->A[8]}, v[3], w[3];
    if (k->type == JO_LINK_HINGE) {
        B[0] = B[4] = cos(x[0]);
        B[3] = sin(x[0]);
        B[1] = -B[3];
        for (int i = 0; i < 3; i++) f->w[i] += u[0] * z[i];
    } else if (k->type == JO_LINK_SLIDE) {
        double arm[3] = {x[0] * z[0], x[0] * z[1], x[0] * z[2]};
        cross(v, f->w, arm);
        for (int i = 0; i < 3; i++) {
            f->r[i] += arm[i];
            f->v[i] += v[i] + u[0] * z[i];
        }
    } else if (k->type == JO_LINK_BALL) {
        rotation(B, x);
    }
    memcpy(A, f->A, sizeof A);
    matrices(f->A, A, B);
    if (k->type != JO_LINK_BALL) return;
    times(w, f->A, u);
    for (int i = 0; i < 3; i++) f->w[i] += w[i];
}

/* frames of the links, q and v of the bodies at x and u */
static void place(const tree *t, frame *f, double *q, double *v)
{
    /* axes x, y, z are the axes y, z, x of the previous frame */
    static const double across[9] = {0, 0, 1, 1, 0, 0, 0, 1, 0}, none[3] = {0};
    for (int i = 0; i < t->m.nlink; i++) {
        const jo_link *k = &t->link[i];
        const double *x = t->x + k->x, *u = t->x + t->m.nx + k->u;
        frame body = GROUND;
        if (k->type == JO_LINK_FREE) {
            rotation(body.A, x + 3);
            memcpy(body.r, x, sizeof body.r);
            memcpy(body.v, u, sizeof body.v);
            times(body.w, body.A, u + 3);
            f[i] = body;
        } else {
            if (k->outer < 0) f[i] = fixed_on(&f[k->parent], none, k->crossed ? across : GROUND.A);
            else if (t->marker[k->outer].body < 0) f[i] = fixed_on(&GROUND, t->u[k->outer], t->A[k->outer]);
            else {   /* a marker of a body; the frame of its link is at the inner marker of this body */
                const int bearing = t->of_body[t->marker[k->outer].body], inner = t->link[bearing].inner;
                double B[9], arm[3], away[3] = {0}, by[3] = {0};
                for (int r = 0; r < 9 && inner >= 0; r++) B[3 * (r % 3) + r / 3] = t->A[inner][r];
                if (inner < 0) memcpy(B, GROUND.A, sizeof B);
                for (int r = 0; r < 3 && inner >= 0; r++) by[r] = -t->u[inner][r];
                times(away, B, by);
                const frame bearer = fixed_on(&f[bearing], away, B);
                memcpy(arm, t->u[k->outer], sizeof arm);
                f[i] = fixed_on(&bearer, arm, t->A[k->outer]);
            }
            move(&f[i], k, x, u);
            if (k->body < 0) continue;
            double B[9], away[3], by[3];
            for (int r = 0; r < 9; r++) B[3 * (r % 3) + r / 3] = t->A[k->inner][r];
            for (int r = 0; r < 3; r++) by[r] = -t->u[k->inner][r];
            times(away, B, by);
            body = fixed_on(&f[i], away, B);
        }
        double *e = q + 7 * k->body, local[9];
        memcpy(e, body.r, sizeof body.r);
        parameters(e + 3, body.A);
        memcpy(v + 6 * k->body, body.v, sizeof body.v);
        for (int r = 0; r < 9; r++) local[3 * (r % 3) + r / 3] = body.A[r];
        times(v + 6 * k->body + 3, local, body.w);
    }
}

static jo_solver steps_of(int method, double step)
{
    jo_solver s;
    memset(&s, 0, sizeof s);
    s.method = method;
    s.step = step;
    return s;
}

/* work space with q, v and counted angles at x, u of the tree */
static jo_data *begin(const tree *t, frame *f)
{
    double q[7 * BODIES], v[NV];
    jo_data *d = jo_data_new(&t->m);
    CHECK(d);
    place(t, f, q, v);
    memcpy(jo_data_q(d), q, sizeof q);
    memcpy(jo_data_v(d), v, sizeof v);
    return d;
}

/* ---- checks ---------------------------------------------------------------------------------------- */

/* inertial force minus weight of the subtree of a link, and its moment about p */
static void needed(const tree *t, jo_data *d, int body, const double *p, double *F, double *T)
{
    const double *q = jo_data_q(d) + 7 * body, *v = jo_data_v(d) + 6 * body, *a = jo_data_a(d) + 6 * body;
    const double *J = t->J[body], full[9] = {J[0], J[5], J[4], J[5], J[1], J[3], J[4], J[3], J[2]};
    double A[9], S[3], w[3], al[3], f[3], y[3], z[3], Jw[3], Ja[3], local[3], arm[3], acc[3];
    rotation(A, q + 3);
    times(S, A, t->S[body]);
    times(w, A, v + 3);
    times(al, A, a + 3);
    for (int i = 0; i < 3; i++) acc[i] = a[i] - t->gravity[i];
    cross(y, al, S);
    cross(z, w, S);
    cross(f, w, z);
    for (int i = 0; i < 3; i++) f[i] += t->mass[body] * acc[i] + y[i];
    times(Ja, full, a + 3);
    times(Jw, full, v + 3);
    cross(y, v + 3, Jw);
    for (int i = 0; i < 3; i++) Ja[i] += y[i];
    times(local, A, Ja);
    cross(y, S, acc);
    for (int i = 0; i < 3; i++) arm[i] = q[i] - p[i];
    cross(z, arm, f);
    for (int i = 0; i < 3; i++) {
        F[i] += f[i];
        T[i] += local[i] + y[i] + z[i];
    }
}

static int beyond(const tree *t, int link, int of)
{
    while (of > link) of = t->link[of].parent;
    return of == link;
}

/* d'Alembert: largest resultant along the joints, minus the spring forces */
static double unbalanced(const tree *t, const frame *f, jo_data *d)
{
    double worst = 0.0;
    for (int i = 0; i < t->m.nlink; i++) {
        const jo_link *k = &t->link[i];
        double F[3] = {0}, T[3] = {0}, spring = 0.0;
        const double z[3] = {f[i].A[2], f[i].A[5], f[i].A[8]};
        for (int j = i; j < t->m.nlink; j++)
            if (t->link[j].body >= 0 && beyond(t, i, j)) needed(t, d, t->link[j].body, f[i].r, F, T);
        for (int c = 0; c < t->m.ncoordinate; c++)
            if (t->coordinate[c].link == i) spring = t->along[c].stiffness * (t->along[c].free - t->x[k->x]);
        if (k->type == JO_LINK_HINGE) worst = fmax(worst, fabs(dot(z, T) - spring));
        if (k->type == JO_LINK_SLIDE) worst = fmax(worst, fabs(dot(z, F) - spring));
        for (int j = 0; j < 3; j++) {
            if (k->type == JO_LINK_BALL || k->type == JO_LINK_FREE) worst = fmax(worst, fabs(T[j]));
            if (k->type == JO_LINK_FREE) worst = fmax(worst, fabs(F[j]));
        }
    }
    return worst;
}

static void check_accelerations(const tree *t)
{
    frame f[LINKS];
    jo_data *d = begin(t, f);
    const double *joint = jo_data_joint(d);
    CHECK(jo_tree_accelerations(&t->m, d) == JO_OK);
    for (int i = 0; i < t->m.nlink; i++) {   /* the joints are at the given coordinates; the sign of a quaternion is arbitrary */
        const jo_link *k = &t->link[i];
        const int ball = k->type == JO_LINK_BALL;
        const double same = ball ? joint[k->x] * t->x[k->x] + dot(joint + k->x + 1, t->x + k->x + 1) : 1.0;
        if (k->type == JO_LINK_HINGE || k->type == JO_LINK_SLIDE) CHECK(fabs(joint[k->x] - t->x[k->x]) < 1e-13);
        CHECK(fabs(fabs(same) - 1.0) < 1e-13);
    }
    for (int i = 0; i < t->m.nu; i++) CHECK(fabs(joint[t->m.nx + i] - t->x[t->m.nx + i]) < 1e-13);
    CHECK(unbalanced(t, f, d) < 1e-11);   /* round-off of forces of 100 N passed through seven bodies */
    jo_data_free(d);
}

/* linear and angular momentum about the world's origin */
static void momentum(const tree *t, jo_data *d, double *y)
{
    memset(y, 0, 6 * sizeof *y);
    for (int i = 0; i < BODIES; i++) {
        const double *q = jo_data_q(d) + 7 * i, *v = jo_data_v(d) + 6 * i, *J = t->J[i];
        const double full[9] = {J[0], J[5], J[4], J[5], J[1], J[3], J[4], J[3], J[2]};
        double A[9], S[3], w[3], p[3], L[3], local[3], a[3], b[3];
        rotation(A, q + 3);
        times(S, A, t->S[i]);
        times(w, A, v + 3);
        cross(p, w, S);
        for (int j = 0; j < 3; j++) p[j] += t->mass[i] * v[j];
        times(local, full, v + 3);
        times(L, A, local);
        cross(a, S, v);
        cross(b, q, p);
        for (int j = 0; j < 3; j++) {
            y[j] += p[j];
            y[3 + j] += L[j] + a[j] + b[j];
        }
    }
}

static double energy(const tree *t, jo_data *d)
{
    jo_energies e;
    jo_energy(&t->m, d, &e);
    return e.kinetic + e.potential + e.springs;
}

/* change of energy, and of momentum without supports, in a run; q at its end */
static double drift(const tree *t, jo_method method, double step, double *q)
{
    frame f[LINKS];
    double before[6], after[6];
    jo_solver s = steps_of(method, step);
    s.projection = 1;
    jo_data *d = begin(t, f);
    const double start = energy(t, d);
    const int steps = (int)(0.32 / step + 0.5);
    momentum(t, d, before);
    for (int i = 0; i < steps; i++) CHECK(jo_step(&t->m, d, &s) == JO_OK);
    double worst = fabs(energy(t, d) - start);
    momentum(t, d, after);
    for (int j = 0; j < 6 && t->link[0].type == JO_LINK_FREE; j++) worst = fmax(worst, fabs(after[j] - before[j]));
    memcpy(q, jo_data_q(d), sizeof(double) * 7 * BODIES);
    jo_data_free(d);
    return worst;
}

/* differences of the final states of runs with steps h and 2h, and drifts, decrease by the order of the method */
static void check_order(const tree *t, jo_method method, double step, double least)
{
    double q[3][7 * BODIES], apart[2] = {0.0, 0.0}, drifts[3];
    for (int k = 0; k < 3; k++) drifts[k] = drift(t, method, step / (1 << k), q[k]);
    for (int i = 0; i < 7 * BODIES; i++)
        for (int k = 0; k < 2; k++) apart[k] = fmax(apart[k], fabs(q[k][i] - q[k + 1][i]));
    CHECK(apart[0] < 1e-2 && apart[0] > least * apart[1]);
    CHECK(drifts[0] > 0.7 * least * drifts[1] || drifts[1] < 1e-10);
}

/* accelerations against differences of velocities over steps of 0.1 ms */
static void check_motion(const tree *t)
{
    frame f[LINKS];
    double v[3][NV], a[NV], largest = 1.0;
    const jo_solver s = steps_of(JO_METHOD_rk4, 1e-4);
    jo_data *d = begin(t, f);
    CHECK(jo_tree_accelerations(&t->m, d) == JO_OK);
    memcpy(a, jo_data_a(d), sizeof a);
    for (int k = 0; k < 3; k++) {
        memcpy(v[k], jo_data_v(d), sizeof v[k]);
        CHECK(jo_step(&t->m, d, &s) == JO_OK);
    }
    for (int i = 0; i < NV; i++) largest = fmax(largest, fabs(a[i]));
    for (int i = 0; i < NV; i++) CHECK(fabs((4.0 * v[1][i] - 3.0 * v[0][i] - v[2][i]) / 2e-4 - a[i]) < 1e-4 * largest);
    jo_data_free(d);
}

/* restored state and continuation in another work space: equal bit for bit */
static void check_rewinding(const tree *t)
{
    frame f[LINKS];
    const jo_solver s = steps_of(JO_METHOD_ros2, 1e-3);
    jo_data *d = begin(t, f), *other = begin(t, f);
    const size_t size = (size_t)jo_data_bytes(&t->m), joint = sizeof(double) * (size_t)(t->m.nx + t->m.nu);
    char *memory = malloc(size);
    double end[7 * BODIES];
    for (int i = 0; i < 5; i++) CHECK(jo_step(&t->m, d, &s) == JO_OK);
    memcpy(memory, d, size);
    memcpy(jo_data_q(other), jo_data_q(d), sizeof end);
    memcpy(jo_data_v(other), jo_data_v(d), sizeof(double) * NV);
    memcpy(jo_data_turn(other), jo_data_turn(d), sizeof(double) * (size_t)t->m.nturn);
    memcpy(jo_data_joint(other), jo_data_joint(d), joint);
    *jo_data_time(other) = *jo_data_time(d);
    jo_restart(other);
    for (int i = 0; i < 5; i++) CHECK(jo_step(&t->m, d, &s) == JO_OK && jo_step(&t->m, other, &s) == JO_OK);
    memcpy(end, jo_data_q(d), sizeof end);
    CHECK(!memcmp(end, jo_data_q(other), sizeof end));
    memcpy(d, memory, size);
    for (int i = 0; i < 5; i++) CHECK(jo_step(&t->m, d, &s) == JO_OK);
    CHECK(!memcmp(end, jo_data_q(d), sizeof end));
    free(memory);
    jo_data_free(d);
    jo_data_free(other);
}

/* rows of a run: finite, with the joint coordinates at the end */
static void check_rows(const tree *t)
{
    frame f[LINKS];
    const jo_solver s = steps_of(JO_METHOD_rk4, 1e-3);
    jo_data *d = begin(t, f);
    const int width = jo_row_size(&t->m), joint = t->m.nx + t->m.nu;
    double *rows = malloc(sizeof(double) * 2 * (size_t)width);
    long long count = 0;
    int written = 0;
    CHECK(jo_run(&t->m, d, &s, 10, 5, &count, &written, rows) == JO_OK && written == 2 && count == 10);
    for (int i = 0; i < 2 * width; i++) CHECK(isfinite(rows[i]));
    CHECK(!memcmp(rows + 2 * width - joint, jo_data_joint(d), sizeof(double) * (size_t)joint));
    free(rows);
    jo_data_free(d);
}

/* ---- error codes ------------------------------------------------------------------------------------- */

/* status of a step from a state with one invalid number of q or v */
static int stepped(const tree *t, int at, double wrong)
{
    frame f[LINKS];
    const jo_solver s = steps_of(JO_METHOD_rk4, 1e-3);
    jo_data *d = begin(t, f);
    *(at < 7 * BODIES ? jo_data_q(d) + at : jo_data_v(d) + at - 7 * BODIES) = wrong;
    const int status = jo_step(&t->m, d, &s);
    jo_data_free(d);
    return status;
}

static int refused(const tree *t, int body)
{
    frame f[LINKS];
    jo_data *d = begin(t, f);
    const int status = jo_tree_accelerations(&t->m, d);
    CHECK(status == JO_OK || jo_data_error_index(d) == body);
    jo_data_free(d);
    return status;
}

static void check_damage(void)
{
    tree t;
    for (int loose = 0; loose < 2; loose++) {
        make(&t, 3, loose);
        const double wrong[] = {NAN, INFINITY, -INFINITY, 1e300, 1e16};
        for (int i = 0; i < t.m.nlink; i++) {   /* numbers that identify links: without joints no other numbers are read */
            const jo_link *k = &t.link[i];
            const int loose_one = k->type == JO_LINK_FREE, turning = k->type == JO_LINK_HINGE || k->type == JO_LINK_BALL;
            if (k->body < 0 || !(loose_one || turning)) continue;
            for (int n = 0; n < 5; n++) {
                for (int j = loose_one ? 0 : 3; j < 7 && wrong[n] != 1e16; j++) CHECK(stepped(&t, 7 * k->body + j, wrong[n]) != JO_OK);
                for (int j = loose_one ? 0 : 3; j < 6; j++) CHECK(stepped(&t, 7 * BODIES + 6 * k->body + j, wrong[n]) != JO_OK);
            }
        }
    }
    for (int seed = 0; seed < KINDS; seed++) {   /* the last body, without children, is connected by each kind of joint in turn */
        const int last = BODIES - 1;
        make(&t, (unsigned)seed, 0);
        const int type = t.link[t.m.nlink - 1].type;
        t.mass[last] = 0.0;
        for (int j = 0; j < 6; j++) t.J[last][j] = 0.0;
        for (int j = 0; j < 3; j++) t.S[last][j] = 0.0;
        CHECK(refused(&t, last) == (type == JO_LINK_FIXED ? JO_OK : JO_SINGULAR_BODY));
    }
}

int main(void)
{
    tree t;
    for (unsigned seed = 0; seed < 2 * KINDS; seed++) {
        make(&t, seed, seed % 2);
        check_accelerations(&t);
        check_motion(&t);
        check_rewinding(&t);
        check_rows(&t);
        check_order(&t, JO_METHOD_rk4, 1e-2, 11.0);
        check_order(&t, JO_METHOD_ros2, 2e-3, 3.3);
    }
    check_damage();
    printf("%d trees of %d bodies\n", 2 * KINDS, BODIES);
    return 0;
}
