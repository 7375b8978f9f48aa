/* arena.h - allocation of the arrays of a run from one block of memory. */
#ifndef JO_ARENA_H
#define JO_ARENA_H

#include "jousto.h"
#include <stddef.h>

/* Block of memory and number of used bytes; with base NULL bytes are only counted. */
typedef struct { char *base; size_t used; } jo_arena;

/* `bytes` rounded up to cache lines of 64 bytes, aligned for vector loads */
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
