/* method_table.c - integration methods: rows of JO_METHODS in jousto.h with the functions of their families; one step. */
#include "valid.h"
#include "maximal/maximal.h"
#include "beam/beam.h"
#include "network/network.h"
#include "tree/tree.h"
#include "integrate/integrate.h"

/* integration of a tree by a family of methods: always in joint coordinates, only if no bodies run by rows beside it, or never */
enum { JO_NO_TREE, JO_WHOLE_TREE, JO_ANY_TREE };

typedef struct {
    int (*step)(const jo_model *m, jo_data *d, const jo_solver *s);
    int tree;
} jo_family;

static const jo_family runge_kutta = {jo_step_runge_kutta, JO_ANY_TREE}, rosenbrock = {jo_step_rosenbrock, JO_ANY_TREE},
                       generalized_alpha = {jo_step_alpha, JO_NO_TREE}, dormand_prince = {jo_step_dopri, JO_WHOLE_TREE};
enum { implicit_runge_kutta = 0, implicit_rosenbrock = 1, implicit_generalized_alpha = 0, implicit_dormand_prince = 0 };

typedef struct {
    const jo_family *family;
    jo_tableau tableau;
} jo_method_row;

/* an implicit method of order 2 has two stages: with exact beams the second stage uses the factors of the first */
#define JO_METHOD_FITS(name, family, order, stages, ...) \
    typedef char name##_fits[(stages) <= JO_MOST_STAGES && (!implicit_##family || (order) != 2 || (stages) == 2) ? 1 : -1];
#define JO_METHOD_COEFFICIENTS(name, family, order, stages, ...) static const double name##_coefficients[] = {__VA_ARGS__};
#define JO_METHOD_ROW(name, family, order, stages, ...) \
    {&family, {implicit_##family, order, stages, name##_coefficients}},
JO_METHODS(JO_METHOD_FITS)
JO_METHODS(JO_METHOD_COEFFICIENTS)
static const jo_method_row table[] = {{0, {0, 0, 0, 0}}, JO_METHODS(JO_METHOD_ROW)};

const jo_tableau *jo_method_tableau(int method) { return &table[method].tableau; }

/* whether a method integrates this model in joint coordinates */
int jo_takes_tree(const jo_model *m, const jo_solver *s)
{
    const int tree = table[s->method].family->tree;
    if ((m->nyielding || jo_network_rows(m)) && jo_contacts_in_matrix(&table[s->method].tableau) && !jo_tree_takes_contacts(m)) return 0;
    return m->nlink && (tree == JO_ANY_TREE || (tree == JO_WHOLE_TREE && !jo_mixed(m)));
}

int jo_one_step(const jo_model *m, jo_data *d, const jo_solver *s)
{
    d->counts.steps++;
    jo_stage_forgotten(d);
    d->control.length = s->step;
    const int status = table[s->method].family->step(m, d, s);
    if (status != JO_OK) return status;
    if (jo_tree_active(d)) {
        if (m->nturn) jo_tree_count_turns(m, d);
    } else if (m->nturn) {   /* without projection: the last stage is accurate enough to count turns */
        if (!s->projection) jo_coordinates(m, d, m->ncoordinate);
        jo_count_turns(m, d);
    }
    if (m->nbeam) jo_beam_accept(d);
    return jo_check(m, d);
}
