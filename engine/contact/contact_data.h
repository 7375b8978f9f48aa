/* contact_data.h - contacts in the matrix of a Rosenbrock method, and sets of shapes; other rooms use the functions of contact.h. */
#ifndef JO_CONTACT_DATA_H
#define JO_CONTACT_DATA_H

typedef struct {
    struct jo_contact_matrix *matrix;   /* (count) of the contacts of the model */
    int count;
    int *of_state;          /* (nstate) of a first state of a contact: its number */
    jo_real *blow;          /* (nstate) force at a point in frame a, from its first state on; only while blows is set */
    double *brief;          /* number of touches that were too short, present step, s, whether they count now, then the list of jo_data_brief */
    int waits;              /* whether touches that strike wait for their impulse at the end of a step of bounded work */
    int blows, struck_points;   /* whether impulses act; whether any contact is resolved by impulses */
    struct jo_struck *struck;   /* points that strike, see impulses.c */
    int *list, closed;      /* (count) closed contacts of the present step, and their number */
    int fit;                /* whether the matrix of the present step has room for all of them; if not, it contains none */
} jo_contacts;

/* Sets of shapes that touch. */
typedef struct {
    int count;              /* number of sets */
    int nstate;             /* states of all forces, as in the model */
    struct jo_contact_search *search;   /* (count) */
    struct jo_bound *bound; /* (nforce) contacts of slots; none without sets */
} jo_contact_sets;

/* Events of contacts from touch to part, see contact_record.h. */
typedef struct {
    struct jo_open_contact *open;   /* (nyielding) those that touch at present; none without contacts */
    jo_touched *list;       /* (room) events that have ended since the start of the call */
    int room, count;
    double before[2];       /* losses at the start of the last adaptive step, J */
    jo_real bristles;       /* energy that bristles stored then, J */
    long long dropped;      /* events for which the list had no room, since the start */
} jo_contact_record;

#endif
