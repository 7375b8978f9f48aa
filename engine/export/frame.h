/* frame.h - inputs and outputs of a machine as bytes, for hardware and other programs: the same on every processor.
 *
 *   bytes  0 .. 3   "JOFR"
 *          4 .. 5   version, 1
 *          6 .. 7   kind: 0 inputs, to the machine; 1 outputs, from it
 *          8 .. 11  checksum of the machine's names: CRC-32 of its inputs, an empty line, its outputs, a line each
 *         12 .. 15  count of the numbers that follow
 *         16 .. 23  sequence number: each frame of a sender has the next one; 0 begins anew
 *         24 .. 31  time stamp, s: of the sender's watch for inputs, the simulated time for outputs
 *         32 ..     the numbers, 8 bytes each, in the order of the header of the machine, SI units
 *
 * Whole numbers and doubles are little endian. A frame of another size, version, machine or with numbers that are not finite is not
 * taken, nor one whose sequence number is not above the last; what is missing between two numbers was lost on the way. Numbers go on
 * from 2^64 - 1 to 0. A number that is JO_FRAME_LEAP or more ahead, or JO_FRAME_LATE or more behind, is taken only if the next frame
 * goes on from it (RFC 3550, appendix A.1): one forged or damaged frame does not end a link, a sender that begins anew is followed. */
#ifndef JO_FRAME_H
#define JO_FRAME_H

#include "machine.h"

enum { JO_FRAME_HEAD = 32, JO_FRAME_VERSION = 1, JO_FRAME_INPUTS = 0, JO_FRAME_OUTPUTS = 1, JO_FRAME_LEAP = 3000, JO_FRAME_LATE = 100 };

typedef struct {
    unsigned long taken, wrong, old, lost;   /* frames */
    unsigned long long last;                 /* sequence number of the last frame that was taken */
    unsigned long long awaited;              /* after a leap: the number that would confirm it */
    int leapt;
} jo_frame_counts;

unsigned long jo_frame_mark(const jo_plant *p);
long jo_frame_bytes(int count);
/* a frame of so many numbers into its bytes */
void jo_frame_write(unsigned char *bytes, int kind, unsigned long mark, unsigned long long sequence, double time, const double *values, int count);
/* whether a frame is taken: its numbers into values (count), its time stamp; what is not taken is counted */
int jo_frame_read(const unsigned char *bytes, long size, int kind, unsigned long mark, jo_frame_counts *counts, double *time, double *values, int count);

#endif
