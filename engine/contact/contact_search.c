/* contact_search.c - which shapes may touch within a step: swept spheres in a uniform grid, then the distances of the tips.
 *
 * A shape is assumed to move by at most h (1.5 |v| + 2 |g| h) and to turn by at most h 1.5 |w| in a step of length h, both plus a share of
 * its size; the end of the step shows whether that was right (jo_found_all_contacts), and otherwise the step is shortened. Pairs whose
 * distance is larger cannot touch. The others are bound to slots before the step, so that nothing changes when the step is repeated.
 * The cells of the grid are as wide as the largest swept shape; shapes without end and those much larger than the mean are compared
 * with all. The work is linear in the number of shapes. */
#include "valid.h"
#include "force/force.h"
#include "contact/contact_rows.h"

#define JO_FASTER 1.5       /* assumed largest speed in a step over that at its start */
#define JO_PULLED 2.0       /* assumed largest change of the speed in a step over that by gravity */
#define JO_SKIN 0.01        /* further assumed motion: share of the size, and rotation, rad */
#define JO_WIDE 4.0         /* size over the mean size, above which a shape is not in the grid */
#define JO_MOST_CELLS 1e9   /* largest number of a cell */
enum { JO_MOST_HALVINGS = 40 };   /* of a step for which the slots do not suffice */
enum { JO_NEIGHBOURS = 13 };      /* half of the 26 neighbours of a cell: each pair of cells once */

typedef struct { const jo_model *m; jo_data *d; jo_contact_rows rows; jo_contact_search *s; } scan;

static unsigned hash3(const int *c) { return (unsigned)c[0] * 73856093u ^ (unsigned)c[1] * 19349663u ^ (unsigned)c[2] * 83492791u; }
static unsigned hash2(int on, int tip) { return (unsigned)on * 2654435761u ^ (unsigned)tip * 40503u * 65537u; }
static double size3(const double *x) { return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]); }
static int marker_of(const jo_shape_row *k) { return (int)JO_RE(k->marker); }

/* velocity and angular velocity of the marker of a shape, world */
static void motion(const jo_model *m, const jo_data *d, int marker, double *v, double *w)
{
    jo_real x[3] = {0.0}, y[3] = {0.0};
    if (m->marker[marker].body >= 0) {
        jo_to_world(x, m, d, marker, d->marker[marker].v);
        jo_to_world(y, m, d, marker, d->marker[marker].om);
    }
    for (int i = 0; i < 3; i++) {
        v[i] = JO_RE(x[i]);
        w[i] = JO_RE(y[i]);
    }
}

/* swept spheres for a step of length h; share: part of the further motion that is assumed */
static void sweep(const scan *c, double h, double share)
{
    double g[3];
    for (int i = 0; i < 3; i++) g[i] = JO_RE(c->m->gravity[i]);
    const double fall = size3(g);
    for (int i = 0; i < c->rows.shapes; i++) {
        const jo_shape_row *k = &c->rows.shape[i];
        const int marker = marker_of(k), moves = c->m->marker[marker].body >= 0;
        jo_swept *y = &c->s->swept[i];
        for (int j = 0; j < 3; j++) y->centre[j] = JO_RE(c->d->marker[marker].r[j]);
        y->reach = JO_RE(k->reach);
        y->shift = y->turn = 0.0;
        motion(c->m, c->d, marker, y->v, y->w);
        if (!moves) continue;
        y->shift = h * (JO_FASTER * size3(y->v) + JO_PULLED * fall * h) + share * JO_SKIN * fmax(y->reach, 0.0);
        y->turn = h * JO_FASTER * size3(y->w) + share * JO_SKIN;
    }
}

/* radius of a swept shape about its centre */
static double swept_radius(const jo_swept *y) { return y->reach + y->shift + y->turn * y->reach; }

/* shapes into the grid, and the list of those that are not */
static void fill_grid(const scan *c)
{
    jo_contact_search *s = c->s;
    double sum = 0.0, cell = 0.0;
    int bounded = 0;
    s->nwide = 0;
    for (int i = 0; i < s->heads; i++) s->head[i] = -1;
    for (int i = 0; i < c->rows.shapes; i++) {
        if (s->swept[i].reach < 0.0) continue;
        sum += swept_radius(&s->swept[i]);
        bounded++;
    }
    const double wide = bounded ? JO_WIDE * sum / bounded : 0.0;
    for (int i = 0; i < c->rows.shapes; i++) {
        const double r = swept_radius(&s->swept[i]);
        if (s->swept[i].reach >= 0.0 && r <= wide && r > cell) cell = r;
    }
    cell = cell > 0.0 ? 2.0 * cell : 1.0;
    for (int i = 0; i < c->rows.shapes; i++) {
        jo_swept *y = &s->swept[i];
        int inside = y->reach >= 0.0 && swept_radius(y) <= wide;
        for (int j = 0; j < 3 && inside; j++) {
            const double at = floor(y->centre[j] / cell);
            inside = fabs(at) < JO_MOST_CELLS;
            if (inside) y->cell[j] = (int)at;
        }
        y->next = -2;
        if (!inside) {
            s->wide[s->nwide++] = i;
            continue;
        }
        int *head = &s->head[hash3(y->cell) & (unsigned)(s->heads - 1)];
        y->next = *head;
        *head = i;
    }
}

static int is_apart(const jo_contact_rows *y, int i, int j)
{
    const double key = i < j ? (double)i * y->shapes + j : (double)j * y->shapes + i;
    int low = 0, high = y->excluded;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (JO_RE(y->apart[middle]) < key) low = middle + 1;
        else high = middle;
    }
    return low < y->excluded && JO_RE(y->apart[low]) == key;
}

/* by how much the gap between a shape and one with tips may shrink within the step, m */
static double closing(const jo_swept *on, const jo_swept *of)
{
    double r[3];
    for (int i = 0; i < 3; i++) r[i] = of->centre[i] - on->centre[i];
    const double lever = on->reach < 0.0 ? size3(r) + of->reach + of->shift : on->reach;
    return on->shift + on->turn * lever + of->shift + of->turn * of->reach;
}

/* slot forces follow the set */
static const jo_force *slot_force(const scan *c, int slot) { return &c->m->force[c->s->set + 1 + slot]; }
static jo_real *states_of(const scan *c, int slot) { return jo_slot_states(c->d, slot_force(c, slot)); }
static int on_of(const jo_real *state) { return (int)JO_RE(state[0]) - 1; }
static int tip_of(const jo_real *state) { return (int)JO_RE(state[1]) - 1; }
static int is_pair(const scan *c, int tip) { return tip >= c->rows.tips; }

/* whether a point of a slot is in another phase than apart: the first of its own states */
static int touches(const scan *c, int slot)
{
    const jo_force *f = slot_force(c, slot);
    const jo_real *state = states_of(c, slot) + JO_SLOT_STATES;
    for (int i = 0; i < jo_contact_points(f); i++)
        if (JO_RE(state[JO_PAIR_STATES * i]) != 0.0) return 1;
    return 0;
}

/* slots by the hash of their pairs */
static void hash_slots(const scan *c)
{
    jo_contact_search *s = c->s;
    for (int i = 0; i < s->places; i++) s->place[i] = -1;
    for (int k = 0; k < jo_slots(&c->rows); k++) {
        const jo_real *state = states_of(c, k);
        if (on_of(state) < 0) continue;
        unsigned at = hash2(on_of(state), tip_of(state));
        while (s->place[at & (unsigned)(s->places - 1)] >= 0) at++;
        s->place[at & (unsigned)(s->places - 1)] = k;
    }
}

/* slot of a pair; -1: none */
static int slot_of(const scan *c, int on, int tip)
{
    unsigned at = hash2(on, tip);
    for (int k; (k = c->s->place[at & (unsigned)(c->s->places - 1)]) >= 0; at++) {
        const jo_real *state = states_of(c, k);
        if (on_of(state) == on && tip_of(state) == tip) return k;
    }
    return -1;
}

static void add_near(const scan *c, int on, int tip, int slot)
{
    jo_contact_search *s = c->s;
    const int kind = is_pair(c, tip);
    if (s->nnear[kind] == c->rows.slots[kind]) {
        s->full = 1;
        return;
    }
    const jo_near found = {on, tip, slot};
    s->near[s->nnear[0] + s->nnear[1]] = found;
    s->nnear[kind]++;
}

/* polytopes that may touch: always those that do */
static void compare_polytopes(const scan *c, int on, int of)
{
    const int tip = c->rows.tips + of, slot = slot_of(c, on, tip);
    const double most = closing(&c->s->swept[on], &c->s->swept[of]);
    if ((slot >= 0 && touches(c, slot)) || jo_polytope_gap(&c->rows, c->d, on, of, most) <= most) add_near(c, on, tip, slot);
}

/* tips of a shape that may touch another one */
static void compare_tips(const scan *c, int on, int of)
{
    const jo_shape_row *k = &c->rows.shape[of];
    const jo_marker_work *w = &c->d->marker[marker_of(k)];
    const jo_swept *a = &c->s->swept[on], *b = &c->s->swept[of];
    const double most = closing(a, b);
    if (jo_shape_gap(&c->rows, c->d, on, w->r) - b->reach > most) return;
    const int first = (int)JO_RE(k->first), end = first + (int)JO_RE(k->tips);
    for (int t = first; t < end; t++)
        if (jo_tip_gap(&c->rows, c->d, on, t) <= most) add_near(c, on, t, slot_of(c, on, t));
}

/* polytopes touch a half-space, and a surface of triangles unless that touches the half-space; spheres touch polytopes: they need not turn */
static int is_touched(const jo_shape_row *k)
{
    const int type = (int)JO_RE(k->type);
    return type == JO_SHAPE_HALF_SPACE ? 3 : type == JO_SHAPE_SURFACE ? 2 : type != JO_SHAPE_SPHERE;
}

static void compare(const scan *c, int i, int j)
{
    const jo_contact_rows *y = &c->rows;
    const jo_shape_row *a = &y->shape[i], *b = &y->shape[j];
    const jo_swept *s = &c->s->swept[i], *t = &c->s->swept[j];
    if (c->s->full || c->m->marker[marker_of(a)].body == c->m->marker[marker_of(b)].body) return;
    if (s->reach >= 0.0 && t->reach >= 0.0) {
        const double r = swept_radius(s) + swept_radius(t), x = s->centre[0] - t->centre[0], z = s->centre[1] - t->centre[1],
                     u = s->centre[2] - t->centre[2];
        if (x * x + z * z + u * u > r * r) return;
    }
    if (!(JO_RE(y->meets[(int)JO_RE(a->group) * y->groups + (int)JO_RE(b->group)]) > 0.0) || is_apart(y, i, j)) return;
    const int touching = (int)JO_RE(y->touching[(int)JO_RE(a->type) * JO_SHAPE_TYPES + (int)JO_RE(b->type)]);
    /* that of the lower number is touched where both could be, in whatever order they are met */
    const int alike = touching == 3 || (touching == 1 && JO_RE(a->type) == JO_RE(b->type));
    const int below = touching == 3 ? is_touched(a) - is_touched(b) : 0;
    const int swaps = touching == 2 || below < 0 || (alike && !below && i > j);
    if (touching == 3) compare_polytopes(c, swaps ? j : i, swaps ? i : j);
    else if (touching) compare_tips(c, swaps ? j : i, swaps ? i : j);
}

/* all pairs of the shapes in one cell and in a neighbour */
static void compare_cells(const scan *c, int i, const int *cell, int same)
{
    const jo_contact_search *s = c->s;
    for (int j = s->head[hash3(cell) & (unsigned)(s->heads - 1)]; j >= 0; j = s->swept[j].next) {
        const int *other = s->swept[j].cell;
        if (other[0] == cell[0] && other[1] == cell[1] && other[2] == cell[2] && (!same || j < i)) compare(c, i, j);
    }
}

/* all pairs that may touch */
static void find_near(const scan *c)
{
    static const int NEIGHBOUR[JO_NEIGHBOURS][3] = {{1, 0, 0}, {-1, 1, 0}, {0, 1, 0}, {1, 1, 0}, {-1, -1, 1}, {0, -1, 1}, {1, -1, 1},
                                                     {-1, 0, 1}, {0, 0, 1}, {1, 0, 1}, {-1, 1, 1}, {0, 1, 1}, {1, 1, 1}};
    jo_contact_search *s = c->s;
    s->nnear[0] = s->nnear[1] = s->full = 0;
    for (int i = 0; i < c->rows.shapes && !s->full; i++) {
        const jo_swept *y = &s->swept[i];
        if (y->next == -2) continue;
        compare_cells(c, i, y->cell, 1);
        for (int k = 0; k < JO_NEIGHBOURS; k++) {
            const int cell[3] = {y->cell[0] + NEIGHBOUR[k][0], y->cell[1] + NEIGHBOUR[k][1], y->cell[2] + NEIGHBOUR[k][2]};
            compare_cells(c, i, cell, 0);
        }
    }
    for (int k = 0; k < s->nwide && !s->full; k++)
        for (int j = 0; j < c->rows.shapes; j++) {
            const int i = s->wide[k];
            if (j != i && (s->swept[j].next != -2 || j < i)) compare(c, i, j);   /* two wide ones once */
        }
}

/* whether the slots suffice for the near pairs, and for those that touch although they are not near */
static int suffice(const scan *c)
{
    jo_contact_search *s = c->s;
    int needed[2] = {s->nnear[0], s->nnear[1]};
    for (int k = 0; k < jo_slots(&c->rows); k++)
        if (on_of(states_of(c, k)) >= 0) needed[k >= c->rows.slots[0]] += touches(c, k);
    for (int i = 0; i < s->nnear[0] + s->nnear[1]; i++)
        if (s->near[i].slot >= 0) needed[is_pair(c, s->near[i].tip)] -= touches(c, s->near[i].slot);
    return !s->full && needed[0] <= c->rows.slots[0] && needed[1] <= c->rows.slots[1];
}

/* free the slots of pairs that are apart and not near */
static void release_slots(const scan *c)
{
    jo_contact_search *s = c->s;
    for (int i = 0; i < s->places; i++) s->place[i] = 0;   /* here: whether a slot is near */
    for (int i = 0; i < s->nnear[0] + s->nnear[1]; i++)
        if (s->near[i].slot >= 0) s->place[s->near[i].slot] = 1;
    for (int k = 0; k < jo_slots(&c->rows); k++) {
        const jo_force *f = slot_force(c, k);
        jo_real *state = states_of(c, k);
        if (s->place[k] || on_of(state) < 0 || touches(c, k)) continue;
        for (int i = 0; i < f->states; i++) state[i] = jo_same(0.0);
    }
}

/* bind near pairs without a slot to free ones; returns whether one of them overlaps */
static int bind_slots(const scan *c)
{
    int free[2] = {0, c->rows.slots[0]}, overlaps = 0;
    for (int i = 0; i < c->s->nnear[0] + c->s->nnear[1]; i++) {
        const jo_near *x = &c->s->near[i];
        int *k = &free[is_pair(c, x->tip)];
        if (x->slot >= 0) continue;
        while (on_of(states_of(c, *k)) >= 0) (*k)++;
        jo_real *state = states_of(c, *k);
        state[0] = jo_same(x->on + 1);
        state[1] = jo_same(x->tip + 1);
        jo_start_slot(c->m, c->d, slot_force(c, *k), state);
        overlaps |= touches(c, *k);
    }
    return overlaps;
}

/* near pairs of one set, for a step of *length or a shorter one */
static int search_set(const scan *c, double *length)
{
    double share = 1.0;
    hash_slots(c);
    for (int k = 0; k < JO_MOST_HALVINGS; k++, *length *= 0.5, share *= 0.5) {
        sweep(c, *length, share);
        fill_grid(c);
        find_near(c);
        if (suffice(c)) return JO_OK;
    }
    c->d->error_index = c->s->set;
    return JO_TOO_MANY_CONTACTS;
}

int jo_find_contacts(const jo_model *m, jo_data *d, double *length, int *jumped)
{
    *jumped = 0;
    for (int i = 0; i < d->contact_sets.count; i++) {
        jo_contact_search *s = &d->contact_sets.search[i];
        if (jo_released(d, m->force[s->set].release)) continue;
        const scan c = {m, d, jo_contact_rows_of(&m->force[s->set]), s};
        const int status = search_set(&c, length);
        if (status != JO_OK) return status;
        release_slots(&c);
        *jumped |= bind_slots(&c);
    }
    return JO_OK;
}

/* largest value between two vectors whose change within the step is at most half more than that between its ends */
static double largest_between(const double *a, const double *b)
{
    const double change[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    return fmax(size3(a), size3(b)) + 0.5 * size3(change);
}

int jo_found_all_contacts(const jo_model *m, const jo_data *d, double h)
{
    for (int k = 0; k < d->contact_sets.count; k++) {
        const jo_contact_search *s = &d->contact_sets.search[k];
        if (jo_released(d, m->force[s->set].release)) continue;
        const jo_contact_rows rows = jo_contact_rows_of(&m->force[s->set]);
        for (int i = 0; i < rows.shapes; i++) {
            double v[3], w[3];
            const jo_swept *y = &s->swept[i];
            if (m->marker[marker_of(&rows.shape[i])].body < 0) continue;
            motion(m, d, marker_of(&rows.shape[i]), v, w);
            if (!(h * largest_between(y->v, v) <= y->shift && h * largest_between(y->w, w) <= y->turn)) return 0;
        }
    }
    return 1;
}
