/* frame.c - encoding and decoding of frames with the inputs and outputs of a machine. */
#include "frame.h"
#include <float.h>
#include <stdint.h>
#include <string.h>

static uint32_t hashed(uint32_t crc, const char *text)
{
    for (; *text; text++) {
        crc ^= (unsigned char)*text;
        for (int i = 0; i < 8; i++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
    }
    return crc;
}

unsigned long jo_frame_mark(const jo_plant *p)
{
    uint32_t crc = 0xffffffffu;
    for (int i = 0; i < p->ninput; i++) crc = hashed(hashed(crc, p->input[i].name), "\n");
    crc = hashed(crc, "\n");
    for (int i = 0; i < p->noutput; i++) crc = hashed(hashed(crc, p->output[i].name), "\n");
    return (unsigned long)(uint32_t)~crc;
}

long jo_frame_bytes(int count) { return JO_FRAME_HEAD + 8L * count; }

static void put(unsigned char *to, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) to[i] = (unsigned char)(value >> (8 * i) & 0xff);
}

static void put_double(unsigned char *to, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, 8);
    put(to, bits, 8);
}

static uint64_t get(const unsigned char *from, int bytes)
{
    uint64_t value = 0;
    for (int i = 0; i < bytes; i++) value |= (uint64_t)from[i] << (8 * i);
    return value;
}

static double get_double(const unsigned char *from)
{
    const uint64_t bits = get(from, 8);
    double value;
    memcpy(&value, &bits, 8);
    return value;
}

void jo_frame_write(unsigned char *bytes, int kind, unsigned long mark, unsigned long long sequence, double time, const double *values, int count)
{
    memcpy(bytes, "JOFR", 4);
    put(bytes + 4, JO_FRAME_VERSION, 2);
    put(bytes + 6, (uint64_t)kind, 2);
    put(bytes + 8, mark, 4);
    put(bytes + 12, (uint64_t)count, 4);
    put(bytes + 16, sequence, 8);
    put_double(bytes + 24, time);
    for (int i = 0; i < count; i++) put_double(bytes + JO_FRAME_HEAD + 8 * i, values[i]);
}

static int is_finite(double x) { return x >= -DBL_MAX && x <= DBL_MAX; }

static int fits(const unsigned char *bytes, long size, int kind, unsigned long mark, int count)
{
    if (size != jo_frame_bytes(count) || memcmp(bytes, "JOFR", 4) || get(bytes + 4, 2) != JO_FRAME_VERSION) return 0;
    if (get(bytes + 6, 2) != (uint64_t)kind || get(bytes + 8, 4) != mark || get(bytes + 12, 4) != (uint64_t)count) return 0;
    for (int i = 0; i <= count; i++)
        if (!is_finite(get_double(bytes + 24 + 8 * i))) return 0;
    return 1;
}

/* whether a sequence number continues the last one; otherwise counts the frame as old */
static int follows(uint64_t sequence, jo_frame_counts *counts)
{
    const uint64_t ahead = sequence - counts->last, behind = counts->last - sequence;   /* modulo 2^64 */
    if (!sequence || !counts->taken || (counts->leapt && sequence == counts->awaited)) return 1;
    if (ahead && ahead < JO_FRAME_LEAP) {
        counts->lost += (unsigned long)(ahead - 1);
        return 1;
    }
    if (behind >= JO_FRAME_LATE) {
        counts->leapt = 1;
        counts->awaited = sequence + 1;
    }
    counts->old++;
    return 0;
}

int jo_frame_read(const unsigned char *bytes, long size, int kind, unsigned long mark, jo_frame_counts *counts, double *time, double *values, int count)
{
    if (!fits(bytes, size, kind, mark, count)) {
        counts->wrong++;
        return 0;
    }
    const unsigned long long sequence = get(bytes + 16, 8);
    if (!follows(sequence, counts)) return 0;
    counts->leapt = 0;
    counts->last = sequence;
    counts->taken++;
    *time = get_double(bytes + 24);
    for (int i = 0; i < count; i++) values[i] = get_double(bytes + JO_FRAME_HEAD + 8 * i);
    return 1;
}
