/* frame.h - binary frames with the inputs and outputs of a machine, for hardware and other programs; independent of the processor.
 *
 *   bytes  0 .. 3   "JOFR"
 *          4 .. 5   version, 1
 *          6 .. 7   kind: 0 inputs, to the machine; 1 outputs, from it
 *          8 .. 11  checksum of the names: CRC-32 of the inputs, an empty line, the outputs, one per line
 *         12 .. 15  count of the numbers that follow
 *         16 .. 23  sequence number, increased by 1 with every frame of a sender; 0: new start
 *         24 .. 31  time stamp, s: clock of the sender for inputs, simulated time for outputs
 *         32 ..     the numbers, 8 bytes each, in the order of the header of the machine, SI units
 *
 * Integers and doubles are little endian. Frames of another size, version or machine, with numbers that are not finite, or with a sequence
 * number not above the last one are rejected; gaps in the sequence count as lost frames. Sequence numbers continue from 2^64 - 1 to 0. A
 * number that is JO_FRAME_LEAP or more ahead, or JO_FRAME_LATE or more behind, is accepted only if the next frame continues it (RFC 3550,
 * appendix A.1): a single forged or damaged frame does not interrupt a link, and a restarted sender is accepted. */
#ifndef JO_FRAME_H
#define JO_FRAME_H

#include "machine.h"

enum { JO_FRAME_HEAD = 32, JO_FRAME_VERSION = 1, JO_FRAME_INPUTS = 0, JO_FRAME_OUTPUTS = 1, JO_FRAME_LEAP = 3000, JO_FRAME_LATE = 100 };

typedef struct {
    unsigned long taken, wrong, old, lost;   /* accepted, invalid, outdated and lost frames */
    unsigned long long last;                 /* sequence number of the last accepted frame */
    unsigned long long awaited;              /* after a leap: number that confirms it */
    int leapt;
} jo_frame_counts;

unsigned long jo_frame_mark(const jo_plant *p);
long jo_frame_bytes(int count);
/* bytes (jo_frame_bytes(count)) of a frame with values (count) */
void jo_frame_write(unsigned char *bytes, int kind, unsigned long mark, unsigned long long sequence, double time, const double *values, int count);
/* values (count) and time stamp of a frame; returns whether it is accepted, counts it otherwise */
int jo_frame_read(const unsigned char *bytes, long size, int kind, unsigned long mark, jo_frame_counts *counts, double *time, double *values, int count);

#endif
