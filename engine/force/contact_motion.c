/* contact_motion.c - velocity of b on a at a point of contact. */
#include "force/contact_point.h"

void jo_contact_slide(jo_contact_point *y)
{
    jo_real turn[3];
    jo_cross(turn, y->w, y->lever);
    jo_add3(y->v, turn);
    y->rate = -jo_dot3(y->normal, y->v);
    jo_set3(y->slip, y->v);
    jo_axpy3(y->slip, y->rate, y->normal);
}

/* v = v_b + w x lever; d' = -n . v; slip = v + d' n */
void jo_contact_rates(const jo_contact_point *y, int k, jo_contact_change *c)
{
    jo_real e[3] = {0.0, 0.0, 0.0}, v[3];
    e[k % 3] = 1.0;
    if (k < 6) jo_cross(v, y->w, c->lever);
    else if (k < 9) jo_set3(v, e);
    else jo_cross(v, e, y->lever);
    c->rate = -jo_dot3(c->normal, y->v) - jo_dot3(y->normal, v);
    for (int i = 0; i < 3; i++) c->slip[i] = v[i] + c->rate * y->normal[i] + y->rate * c->normal[i];
}
