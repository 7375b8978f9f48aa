/* contact_data.h - contacts in the matrix of a Rosenbrock method; other rooms use the functions of contact.h. */
#ifndef JO_CONTACT_DATA_H
#define JO_CONTACT_DATA_H

typedef struct {
    struct jo_contact_matrix *matrix;   /* (count) of the contacts of the model */
    int count;
    int *of_state;          /* (nstate) of a first state of a contact: its number */
} jo_contacts;

#endif
