/* network_data.h - networks of first-order states; other rooms use the functions of network.h. */
#ifndef JO_NETWORK_DATA_H
#define JO_NETWORK_DATA_H

typedef struct {
    int count;
    struct jo_network *list;   /* (count) */
    int most, separate;        /* bound of the rows; whether network_response.c accounts for the networks in the matrix of a method */
    int rows, *row;            /* coordinates along which forces act, (2 x rows) network and coordinate */
    jo_real *a, *lam;          /* (rows x nv), (rows x nrow) changes of accelerations and multipliers by unit forces along these */
    jo_real *A, *x;            /* (rows x rows), (rows) */
    int *pivot;                /* (rows) */
} jo_networks;

#endif
