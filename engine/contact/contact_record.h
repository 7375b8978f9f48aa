/* contact_record.h - events of contacts, from touch to part, as they are recorded. */
#ifndef JO_CONTACT_RECORD_H
#define JO_CONTACT_RECORD_H

#include "force/force.h"
#include "contact/contact.h"

enum { JO_LISTED_TOUCHES = 256 };   /* room of the list of events, besides two for each contact */

/* A contact at the end of a step: time, s; sums over its points of the normal force, N, of the powers that the normal force dissipates and of
 * the friction force, W, and of the size of the friction force, N; largest depth, m, and its rate, m/s; energy stored in the normal
 * force and in bristles, J; time of the first touch, s, and speed of its approach, m/s */
typedef struct { double time, rate[4], depth, closing, since, speed; jo_real sums[JO_TOUCH_SUMS]; } jo_contact_sample;

/* A contact that touches: its event so far, and the last two ends of steps. */
typedef struct jo_open_contact {
    int touches, samples;   /* whether it touches; number of ends of steps in `last` since the force has jumped */
    jo_touched event;
    jo_real stored[2];      /* energy in the normal force and in bristles, J */
    jo_contact_sample last[2];
} jo_open_contact;

#endif
