/* contact_report.c - the pairs in slots at the present state: distances and forces. */
#include "valid.h"
#include "force/force.h"
#include "contact/contact_rows.h"

int jo_near_contacts(const jo_model *m, jo_data *d, double *out)
{
    int count = 0;
    if (!jo_has_contact_sets(d) || jo_yielding_ready(m, d) != JO_OK) return 0;
    for (int k = 0; k < d->contact_sets.count; k++) {
        const int set = d->contact_sets.search[k].set;
        const jo_contact_rows y = jo_contact_rows_of(&m->force[set]);
        for (int i = set + 1; i <= set + y.slots; i++) {
            const jo_real *state = jo_slot_states(d, &m->force[i]);
            const int on = (int)JO_RE(state[0]) - 1, tip = (int)JO_RE(state[1]) - 1;
            if (on < 0) continue;
            double *row = out + JO_CONTACT_ROW * count++;
            row[0] = set;
            row[1] = on;
            row[2] = JO_RE(y.tip[tip].shape);
            row[3] = JO_RE(state[JO_SLOT_STATES]);
            row[4] = jo_tip_gap(&y, d, on, tip);
            for (int j = 0; j < 3; j++) row[5 + j] = JO_RE(d->force[i].y[j]);
        }
    }
    return count;
}
