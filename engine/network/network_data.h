/* network_data.h - networks of first-order states; other rooms use the functions of network.h. */
#ifndef JO_NETWORK_DATA_H
#define JO_NETWORK_DATA_H

typedef struct {
    int count;
    struct jo_network *list;   /* (count) */
} jo_networks;

#endif
