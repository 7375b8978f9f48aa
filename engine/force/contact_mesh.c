/* contact_mesh.c - points at which the vertices of a polytope touch a surface of triangles, with their states. */
#include "contact/contact.h"
#include "force/contact_pair.h"

/* codes of the points that touch, and their indices; returns their number */
static int touching_codes(const jo_force *f, const jo_real *state, double *code, int *of)
{
    int n = 0;
    for (int i = 0; i < jo_pair_points(f); i++, state += JO_PAIR_STATES) {
        if (!jo_pair_touches(state)) continue;
        of[n] = i;
        code[n++] = JO_RE(state[JO_PAIR_CODE]);
    }
    return n;
}

void jo_pair_list_on_mesh(const jo_force *f, jo_contact_pair_pose *p, const jo_real *state, jo_real *next)
{
    double code[JO_MESH_POINTS], found[JO_MESH_POINTS];
    int of[JO_MESH_POINTS], from[JO_MESH_POINTS];
    const int count = touching_codes(f, state, code, of);
    jo_polytope_place(&p->b, p->r, p->R);
    const int n = jo_mesh_points(&p->mesh, &p->b, jo_pair_radii(p), code, count, found, from);
    for (int i = 0; i < n && i < jo_pair_points(f); i++, next += JO_PAIR_STATES) {
        for (int k = 0; from[i] >= 0 && k < JO_PAIR_STATES; k++) next[k] = state[JO_PAIR_STATES * of[from[i]] + k];
        next[JO_PAIR_CODE] = jo_same(found[i]);
        next[JO_PAIR_WEIGHT] = jo_same(1.0);
    }
}

double jo_pair_further_gap(const jo_force *f, jo_contact_pair_pose *p, const jo_real *state)
{
    double code[JO_MESH_POINTS];
    int of[JO_MESH_POINTS];
    const int count = touching_codes(f, state, code, of);
    jo_polytope_place(&p->b, p->r, p->R);
    return jo_mesh_unlisted(&p->mesh, &p->b, jo_pair_radii(p), code, count);
}

int jo_pair_approach_mesh(const jo_force *f, jo_contact_pair_pose *p, const jo_real *state, double reach, jo_approach *to)
{
    double code[JO_MESH_POINTS];
    int of[JO_MESH_POINTS];
    jo_mesh_gap y;
    jo_polytope_place(&p->b, p->r, p->R);
    const int count = touching_codes(f, state, code, of);
    jo_mesh_clearance(&p->mesh, &p->b, jo_pair_radii(p), code, count, &y);
    if (!(y.gap < INFINITY) || (count && !(y.gap > 0.0))) return 0;   /* it touches, or the next place overlaps already */
    to->gap = y.gap;
    to->clear = y.clear;
    to->face = y.part;
    jo_pair_approach_along(p, y.normal, reach, to);
    to->curvature = y.curvature;
    return 1;
}
