/* arena.h - memory of a run, which each room takes for itself from one block. */
#ifndef JO_ARENA_H
#define JO_ARENA_H

#include "jousto.h"
#include <stddef.h>

/* with no base it only counts what is taken */
typedef struct { char *base; size_t used; } jo_arena;

/* whole cache lines, aligned for vector loads */
static inline void *jo_take(jo_arena *a, size_t bytes)
{
    const size_t at = a->used;
    a->used += (bytes + 63) & ~(size_t)63;
    return a->base ? a->base + at : 0;
}
static inline void *jo_take_many(jo_arena *a, int count, size_t size) { return jo_take(a, (size_t)count * size); }
static inline jo_real *jo_take_reals(jo_arena *a, int count) { return jo_take_many(a, count, sizeof(jo_real)); }
static inline int *jo_take_ints(jo_arena *a, int count) { return jo_take_many(a, count, sizeof(int)); }
static inline double *jo_take_doubles(jo_arena *a, int count) { return jo_take_many(a, count, sizeof(double)); }

#endif
