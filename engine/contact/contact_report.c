/* contact_report.c - points at which bodies touch at the present state. */
#include "valid.h"
#include "force/force.h"
#include "contact/contact.h"

int jo_contact_report(const jo_model *m, jo_data *d, int most, jo_touch *out)
{
    jo_touch t[JO_MAX_TOUCHES];
    jo_real unused[JO_TOUCH_SUMS] = {0.0};
    int count = 0;
    if (jo_yielding_ready(m, d) != JO_OK) return 0;
    for (int k = 0; k < m->nyielding; k++) {
        const int force = jo_yielding_force(d, k);
        const int points = jo_touches_of(m, d, force, jo_states(m, d) + m->force[force].state, t, unused);
        for (int i = 0; i < points && count < most; i++) {
            out[count] = t[i];
            out[count].force = force;
            out[count++].number = i;
        }
    }
    return count;
}
