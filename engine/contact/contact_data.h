/* contact_data.h - contacts in the matrix of a Rosenbrock method, and sets of shapes; other rooms use the functions of contact.h. */
#ifndef JO_CONTACT_DATA_H
#define JO_CONTACT_DATA_H

typedef struct {
    struct jo_contact_matrix *matrix;   /* (count) of the contacts of the model */
    int count;
    int *of_state;          /* (nstate) of a first state of a contact: its number */
} jo_contacts;

/* Sets of shapes that touch. */
typedef struct {
    int count;              /* number of sets */
    int nstate;             /* states of all forces, as in the model */
    struct jo_contact_search *search;   /* (count) */
    struct jo_bound *bound; /* (nforce) contacts of slots; none without sets */
} jo_contact_sets;

#endif
