/* fatigue_data.h - data of the files of this folder; other folders use the functions of fatigue.h. */
#ifndef JO_FATIGUE_DATA_H
#define JO_FATIGUE_DATA_H

#include "small.h"

typedef struct {
    jo_model metered;       /* the model with the metered sensors only */
    jo_sensor *list;        /* these */
    jo_real *reading;       /* (nout) their values */
    double *scratch;        /* of the largest meter */
    int demanding;          /* metered sensors need accelerations */
} jo_damage;

#endif
