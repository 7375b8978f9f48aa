/* hardware.c - execution of a machine with hardware or another program, with frames (frame.h), on POSIX systems:
 *
 *   NAME_hardware udp PORT [HZ [SECONDS]]       frames as datagrams on this computer (127.0.0.1)
 *   NAME_hardware shared FILE [HZ [SECONDS]]    frames in a file that is mapped into memory, such as /dev/shm/NAME
 *
 * Without HZ, or with 0, a frame of inputs triggers a step and a frame of outputs: the other side determines the time. With HZ the machine
 * steps in real time with the newest inputs and sends its outputs after each step. SECONDS: duration, 0: unlimited.
 *
 * A mapped file contains the inputs, then the outputs. Each part starts with a count of 8 bytes, which the writer makes odd before and even
 * after it writes the frame; a reader repeats reading if the count is odd or has changed (sequence lock). */
#define _POSIX_C_SOURCE 200809L
#include "plant.h"
#include "frame.h"
#include <fcntl.h>
#include <math.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { MOST = 4096 };       /* largest count of numbers in a frame */
#define WAIT 0.05           /* longest waiting time for a frame, s, between checks for the end */
static union { double number; char bytes[PLANT_BYTES]; } memory;
static unsigned char frame[JO_FRAME_HEAD + 8 * MOST + 8];
static double inputs[MOST], outputs[MOST];
static volatile sig_atomic_t ended;

typedef struct {
    int socket;
    struct sockaddr_in from, peer;  /* addresses of the senders of the last frame and of the last accepted frame */
    int known;              /* whether the address of the other side is known */
    unsigned char *map;     /* shared memory; NULL: UDP */
    uint64_t seen;          /* count of the last inputs that were read */
} link_to;

static void on_signal(int number)
{
    (void)number;
    ended = 1;
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void wait_until(double due)
{
    const double rest = due - now();
    if (rest <= 0.0) return;
    struct timespec t = {(time_t)rest, (long)(1e9 * (rest - floor(rest)))};
    nanosleep(&t, 0);
}

static int open_udp(link_to *l, const char *port)
{
    struct sockaddr_in own;
    memset(&own, 0, sizeof own);
    own.sin_family = AF_INET;
    own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    own.sin_port = htons((uint16_t)atoi(port));
    l->socket = socket(AF_INET, SOCK_DGRAM, 0);
    if (l->socket < 0 || bind(l->socket, (struct sockaddr *)&own, sizeof own)) return 0;
    socklen_t size = sizeof own;
    getsockname(l->socket, (struct sockaddr *)&own, &size);
    printf("listening on 127.0.0.1:%d\n", ntohs(own.sin_port));
    return 1;
}

static int open_shared(link_to *l, const char *path)
{
    const size_t size = 16 + (size_t)jo_frame_bytes(PLANT.ninput) + (size_t)jo_frame_bytes(PLANT.noutput);
    const int file = open(path, O_RDWR | O_CREAT, 0600);
    if (file < 0 || ftruncate(file, (off_t)size)) return 0;
    void *map = mmap(0, size, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    if (map == MAP_FAILED) return 0;
    l->map = map;
    memset(l->map, 0, size);
    printf("sharing %s\n", path);
    return 1;
}

static uint64_t count_at(const unsigned char *place)
{
    uint64_t value = 0;
    const volatile unsigned char *from = place;
    for (int i = 0; i < 8; i++) value |= (uint64_t)from[i] << (8 * i);
    return value;
}

static void set_count(unsigned char *place, uint64_t value)
{
    volatile unsigned char *to = place;
    for (int i = 0; i < 8; i++) to[i] = (unsigned char)(value >> (8 * i) & 0xff);
}

/* receive a frame into `frame`; returns its size, 0 if there is none; patient: wait up to WAIT */
static long receive(link_to *l, int patient)
{
    if (!l->map) {
        socklen_t size = sizeof l->from;
        fd_set set;
        struct timeval wait = {0, patient ? (int)(1e6 * WAIT) : 0};
        FD_ZERO(&set);
        FD_SET(l->socket, &set);
        if (select(l->socket + 1, &set, 0, 0, &wait) <= 0) return 0;
        const ssize_t got = recvfrom(l->socket, frame, sizeof frame, 0, (struct sockaddr *)&l->from, &size);
        if (got < 0) return 0;
        return got ? (long)got : -1;
    }
    const double until = now() + (patient ? WAIT : 0.0);
    do {
        const uint64_t count = count_at(l->map);
        if (count && count % 2 == 0 && count != l->seen) {
            __sync_synchronize();
            memcpy(frame, l->map + 8, (size_t)jo_frame_bytes(PLANT.ninput));
            __sync_synchronize();
            if (count_at(l->map) == count) {
                l->seen = count;
                return jo_frame_bytes(PLANT.ninput);
            }
        }
    } while (now() < until && !ended);
    return 0;
}

static void send_outputs(link_to *l, long size)
{
    if (!l->map) {
        if (l->known) (void)!sendto(l->socket, frame, (size_t)size, 0, (const struct sockaddr *)&l->peer, sizeof l->peer);
        return;
    }
    unsigned char *place = l->map + 8 + jo_frame_bytes(PLANT.ninput);
    const uint64_t count = count_at(place);
    set_count(place, count + 1);
    __sync_synchronize();
    memcpy(place + 8, frame, (size_t)size);
    __sync_synchronize();
    set_count(place, count + 2);
}

static int failed(jo_machine *machine, int status)
{
    fprintf(stderr, "%s: stopped at %g s with status %d at object %d\n", PLANT.name, jo_machine_time(machine),
            status == JO_MACHINE_STOPPED ? 0 : jo_machine_error(machine), jo_machine_error_index(machine));
    return status != JO_MACHINE_STOPPED;
}

/* one step and its outputs; returns whether the run continues */
static int advance(jo_machine *machine, link_to *l, unsigned long mark, unsigned long long *sequence, int *code)
{
    const int status = jo_machine_step(machine, 1);
    const double *y = jo_machine_outputs(machine);
    if (status != JO_MACHINE_OK || !y) *code = failed(machine, status);
    for (int i = 0; y && i < PLANT.noutput; i++) outputs[i] = y[PLANT.output[i].place];
    if (y) {
        jo_frame_write(frame, JO_FRAME_OUTPUTS, mark, (*sequence)++, jo_machine_time(machine), outputs, PLANT.noutput);
        send_outputs(l, jo_frame_bytes(PLANT.noutput));
    }
    return status == JO_MACHINE_OK && y;
}

/* arguments, link, then the loop: wait for the time or a frame, read inputs, step, send outputs */
int main(int argc, char **argv)
{
    link_to l;
    jo_frame_counts counts;
    memset(&l, 0, sizeof l);
    memset(&counts, 0, sizeof counts);
    const double rate = argc > 3 ? atof(argv[3]) : 0.0, seconds = argc > 4 ? atof(argv[4]) : 0.0;
    const int udp = argc > 2 && !strcmp(argv[1], "udp"), shared = argc > 2 && !strcmp(argv[1], "shared");
    if (!(udp || shared) || !(rate >= 0.0) || !(seconds >= 0.0) || PLANT.ninput > MOST || PLANT.noutput > MOST) {
        fprintf(stderr, "%s udp PORT | shared FILE [HZ [SECONDS]]\n", argv[0]);
        return 2;
    }
    jo_machine *machine = jo_machine_place(&PLANT, memory.bytes, (long long)sizeof memory.bytes);
    if (!machine || !(udp ? open_udp(&l, argv[2]) : open_shared(&l, argv[2]))) {
        fprintf(stderr, "%s: cannot be opened\n", argv[2]);
        return 2;
    }
    fflush(stdout);
    signal(SIGINT, on_signal);
    signal(SIGTERM, on_signal);
    const unsigned long mark = jo_frame_mark(&PLANT);
    unsigned long long sequence = 0;
    unsigned long steps = 0, missed = 0;
    double stamp = 0.0, latest = 0.0;
    int code = 0;
    const double start = now();
    for (int going = 1; going && !ended && !(seconds > 0.0 && now() - start >= seconds);) {
        long size;
        if (rate > 0.0) {
            const double due = start + (double)steps / rate;
            wait_until(due);
            const double late = now() - due;
            latest = late > latest ? late : latest;
            missed += late > 1.0 / rate;
        }
        int news = 0;
        while ((size = receive(&l, rate == 0.0 && !news)) != 0) {
            if (!jo_frame_read(frame, size, JO_FRAME_INPUTS, mark, &counts, &stamp, inputs, PLANT.ninput)) continue;
            news = l.known = 1;
            l.peer = l.from;
            for (int i = 0; i < PLANT.ninput; i++) jo_machine_set_input(machine, i, inputs[i]);
            if (rate == 0.0) break;
        }
        if (rate == 0.0 && !news) continue;
        going = advance(machine, &l, mark, &sequence, &code);
        steps++;
    }
    printf("%lu steps, frames: %lu taken, %lu lost, %lu old, %lu wrong", steps, counts.taken, counts.lost, counts.old, counts.wrong);
    if (rate > 0.0) printf("; %lu steps begun after the next was due, largest lateness %.3g ms", missed, 1e3 * latest);
    const long long deferred = jo_data_counts(jo_machine_data(machine))->deferred;
    if (deferred) printf("; %lld steps deferred a change of friction or an event", deferred);
    printf("\n");
    return code;
}
