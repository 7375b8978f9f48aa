/* A program with exported machines in joint coordinates: returns 0, or the number of the check that fails. */
#include "arm.h"
#include <math.h>
#include <string.h>

static union { double number; char bytes[ARM_BYTES]; } first, second;
static double state[20000], other[20000];
static const size_t outputs = sizeof(double) * arm_outputs;

/* whether a machine takes the state with another number at a place */
static int takes(jo_machine *k, int at, double value)
{
    memcpy(other, state, sizeof state);
    other[at] = value;
    return jo_machine_load(k, other) == JO_MACHINE_OK;
}

int main(void)
{
    jo_machine *a = jo_machine_place(&arm_plant, first.bytes, ARM_BYTES);
    jo_machine *b = jo_machine_place(&arm_plant, second.bytes, ARM_BYTES);
    const jo_model *m = arm_plant.model;
    if (!a || !b || jo_machine_bytes(&arm_plant) > ARM_BYTES) return 1;
    if (!m->nlink || jo_machine_step(a, 300)) return 2;
    /* saved, gone on with elsewhere and gone back to, to the last bit; joint coordinates and energies of contacts end the state */
    const int size = jo_machine_state_size(a), joints = size - m->nx - m->nu - JO_CONTACT_ENERGIES;
    if (size > 20000 || jo_machine_save(a, state)) return 3;
    if (memcmp(state + joints, jo_data_joint(jo_machine_data(a)), sizeof(double) * (size_t)(m->nx + m->nu))) return 4;
    if (jo_machine_step(a, 200) || jo_machine_load(b, state) || jo_machine_step(b, 200)) return 5;
    if (memcmp(jo_machine_outputs(a), jo_machine_outputs(b), outputs)) return 6;
    if (jo_machine_load(a, state) || jo_machine_step(a, 200)) return 7;
    if (memcmp(jo_machine_outputs(a), jo_machine_outputs(b), outputs)) return 8;
    /* what is no joint coordinate is refused */
    for (int i = 0; i < m->nlink; i++) {
        const int at = joints + m->link[i].x;
        if (takes(b, at, NAN) || takes(b, joints + m->nx + m->link[i].u, INFINITY)) return 9;
        if (m->link[i].type == JO_LINK_BALL && takes(b, at, 3.0)) return 10;
        if (m->link[i].type == JO_LINK_FREE && takes(b, at + 3, 3.0)) return 11;
    }
    /* joint coordinates that are not those of the bodies give way to them */
    if (!takes(b, joints, 0.5) || jo_machine_step(b, 200)) return 12;
    for (int i = 0; i < arm_outputs; i++) {
        const double x = jo_machine_outputs(a)[i], y = jo_machine_outputs(b)[i];
        if (!(fabs(x - y) <= 1e-6 * (1.0 + fabs(x)))) return 13;
    }
    /* inputs, parameters and the start */
    double before, after;
    jo_machine_get_output(a, arm_output_tip_z, &before);
    if (jo_machine_load(b, state) || jo_machine_set_parameter(b, arm_parameter_gravity_z, -1.0)) return 14;
    if (jo_machine_set_parameter(b, arm_parameter_coil_stiffness, 50.0) || jo_machine_set_input(b, arm_input_push, -20.0)) return 15;
    if (jo_machine_step(b, 200) || jo_machine_get_output(b, arm_output_tip_z, &after)) return 16;
    if (!(after > before + 0.01)) return 17;
    jo_machine_reset(b);
    jo_machine_place(&arm_plant, first.bytes, ARM_BYTES);
    if (memcmp(jo_machine_outputs(a), jo_machine_outputs(b), outputs)) return 18;
    /* for an integrator of somebody else's: the states alone say where it is, also where a drive moves */
    jo_machine_in_bodies(a);
    if (jo_machine_get_output(a, arm_output_tip_y, &before)) return 19;
    jo_machine_get_states(a, other);
    if (jo_machine_set_states(a, 0.25, other) || jo_machine_get_output(a, arm_output_tip_y, &after)) return 20;
    if (fabs(after - before) > 1e-14 || jo_machine_rates(a, 20.0, other + 1000)) return 21;
    if (jo_machine_state_size(a) != size - m->nx - m->nu) return 22;
    return 0;
}
