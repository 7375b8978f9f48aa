/* mesh_search.c - closest points of a surface of triangles by its tree of boxes: the work grows by 3 to 4 for 100 times the triangles. */
#include "contact/mesh.h"

enum { JO_MESH_DEPTH = 64 };          /* nodes that wait; twice the depth of a tree of 2^30 triangles */
#define JO_SAME_CONTACT 0.99984770    /* cosine of 1 degree, below which two local minima are one contact */

/* A search: `found` is called for the closest point of each triangle within the square of the distance, which it may lower. */
typedef struct mesh_search {
    const jo_mesh *m;
    const double *c;
    double square;
    void (*found)(struct mesh_search *s, const jo_mesh_foot *y);
    int group, count;           /* group that is left out; number of points in `list` */
    jo_mesh_foot best, *list;
    const jo_mesh_foot *known;
    int knows;
} mesh_search;

static double box_square(const mesh_search *s, int node)
{
    const jo_real *x = s->m->box + 6 * node;
    double sum = 0.0;
    for (int k = 0; k < 3; k++) {
        const double low = JO_RE(x[k]) - s->c[k], high = s->c[k] - JO_RE(x[k + 3]), d = low > high ? low : high;
        if (d > 0.0) sum += d * d;
    }
    return sum;
}

static void search_leaf(mesh_search *s, int leaf)
{
    jo_mesh_foot y;
    const int end = (leaf + 1) * JO_MESH_LEAF;
    for (int t = leaf * JO_MESH_LEAF; t < end && t < s->m->triangles; t++) {
        int left_out = jo_whole(s->m->group[t]) == s->group;
        for (int i = 0; i < s->knows; i++) left_out |= JO_RE(s->m->group[t]) == JO_RE(s->m->group[s->known[i].triangle]);
        if (left_out) continue;   /* of a plane that is known */
        jo_mesh_closest(s->m, t, s->c, &y);
        if (y.square <= s->square) (*s->found)(s, &y);
    }
}

/* nodes within the distance, the nearer one of two first */
static void search_tree(mesh_search *s)
{
    int wait[JO_MESH_DEPTH], n = 0;
    double far[JO_MESH_DEPTH];
    wait[n] = 1;
    far[n++] = box_square(s, 1);
    while (n > 0) {
        const int node = wait[--n];
        if (far[n] > s->square) continue;
        if (node >= s->m->leaves) {
            search_leaf(s, node - s->m->leaves);
            continue;
        }
        const double a = box_square(s, 2 * node), b = box_square(s, 2 * node + 1);
        const int first = a <= b;   /* on top */
        wait[n] = 2 * node + first;
        far[n++] = first ? b : a;
        wait[n] = 2 * node + 1 - first;
        far[n++] = first ? a : b;
    }
}

static void keep_nearest(mesh_search *s, const jo_mesh_foot *y)
{
    if (s->count && !(y->square < s->square)) return;
    s->best = *y;
    s->square = y->square;
    s->count = 1;
}

static mesh_search search_about(const jo_mesh *m, const double *c, double limit, void (*found)(mesh_search *s, const jo_mesh_foot *y))
{
    static const mesh_search none;
    mesh_search s = none;
    s.m = m;
    s.c = c;
    s.square = limit * limit;
    s.found = found;
    s.group = -1;
    return s;
}

int jo_mesh_nearest(const jo_mesh *m, const double *c, int but_group, double limit, jo_mesh_foot *y)
{
    mesh_search s = search_about(m, c, limit, keep_nearest);
    s.group = but_group;
    search_tree(&s);
    if (s.count) *y = s.best;
    return s.count;
}

/* whether y is a local minimum of the distance from c, in front of a closed surface */
static int is_contact(const mesh_search *s, const jo_mesh_foot *y)
{
    if (s->m->closed && y->part == JO_ON_FACE && jo_mesh_outside(s->m, y, s->c) < 0.0) return 0;
    return jo_mesh_is_minimum(s->m, y, s->c);
}

/* whether c is in the same direction from two points */
static int is_same(const mesh_search *s, const jo_mesh_foot *y, const jo_mesh_foot *z)
{
    double n[3], k[3];
    jo_mesh_direction(s->m, y, s->c, n);
    jo_mesh_direction(s->m, z, s->c, k);
    return jo_dot3d(n, k) > JO_SAME_CONTACT;
}

/* into the list by distance; of two in one direction the nearer one */
static void keep_minimum(mesh_search *s, const jo_mesh_foot *y)
{
    if (!is_contact(s, y)) return;
    int at = 0;
    for (; at < s->count && s->list[at].square <= y->square; at++)
        if (is_same(s, s->list + at, y)) return;
    int end = at;   /* farther ones in its direction go */
    for (int i = at; i < s->count; i++)
        if (!is_same(s, s->list + i, y)) s->list[end++] = s->list[i];
    if (end == JO_MESH_POINTS) end--;
    if (at > end) return;
    for (int i = end; i > at; i--) s->list[i] = s->list[i - 1];
    s->list[at] = *y;
    s->count = end + 1;
}

int jo_mesh_minima(const jo_mesh *m, const double *c, double limit, jo_mesh_foot *list)
{
    mesh_search s = search_about(m, c, limit, keep_minimum);
    s.list = list;
    search_tree(&s);
    return s.count;
}

static void keep_other(mesh_search *s, const jo_mesh_foot *y)
{
    int same_patch = 0;
    for (int i = 0; i < s->knows; i++) same_patch |= JO_RE(s->m->patch[s->known[i].triangle]) == JO_RE(s->m->patch[y->triangle]);
    if (s->m->closed && y->part == JO_ON_FACE && jo_mesh_outside(s->m, y, s->c) < 0.0) return;
    if (same_patch) {
        for (int i = 0; i < s->knows; i++)
            if (is_same(s, s->known + i, y)) return;
        if (!jo_mesh_is_minimum(s->m, y, s->c)) return;
    }
    s->square = y->square;
    s->best = *y;
    s->count = 1;
}

int jo_mesh_other(const jo_mesh *m, const double *c, const jo_mesh_foot *known, int count, double limit, jo_mesh_foot *y)
{
    mesh_search s = search_about(m, c, limit, keep_other);
    s.known = known;
    s.knows = count;
    search_tree(&s);
    if (s.count) *y = s.best;
    return s.count;
}
