/* The reference of the bench `cycle`: what the gateway's cycle does, in C, on the same broker, with the same waiting.
 *
 * Every grid instant: one message with SYNC (id 100, no data) and six set values (210..260, 8 bytes); the six actual values (610..660) are
 * due before the next instant.  Layout: AX-001 (byte 0 bits 0, 1 enable and drive on, byte 1 life counter, bytes 2-5 position).  The
 * position follows the actual one until the drives are asked on, then it holds.  Record of the bus: AX-092.
 *
 *   cycle_ref --name BUS [--period-us 4000] [--cycles 2500] [--spin-us 100] [--priority 40] [--enable]
 *
 * Prints one JSON object.  Exit: 0, 2 command line, 3 no broker.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <getopt.h>
#include <poll.h>
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#define AXES 6
#define MAX_RECORDS 64

struct record { /* AX-092: struct can_frame, stamp ns, sequence */
    uint32_t id;
    uint8_t length, sender, spare[2];
    uint8_t data[8];
    uint64_t stamp_ns, sequence;
};

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

static void sleep_until(int64_t due, int64_t spin)
{
    int64_t wake = due - spin;
    struct timespec t = {wake / 1000000000LL, wake % 1000000000LL};
    while (now_ns() < wake)
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
    while (now_ns() < due)
        ;
}

/* As runtime_dir() of drivers/ports/base.py. */
static int connect_broker(const char *name)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const char *named = getenv("AXISGATE_RUNTIME"), *session = getenv("XDG_RUNTIME_DIR");
    size_t room = sizeof address.sun_path;
    int length;
    if (named && *named)
        length = snprintf(address.sun_path, room, "%s/broker-%s.sock", named, name);
    else if (session && *session)
        length = snprintf(address.sun_path, room, "%s/axisgate/broker-%s.sock", session, name);
    else
        length = snprintf(address.sun_path, room, "/tmp/axisgate-%u/broker-%s.sock", (unsigned)getuid(), name);
    int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (length >= (int)room || fd < 0 || connect(fd, (struct sockaddr *)&address, sizeof address)) {
        fprintf(stderr, "cycle_ref: %s: %s\n", address.sun_path, strerror(errno));
        exit(3);
    }
    return fd;
}

/* Actual values of this cycle until all six are there or the time is up; how many axes answered. */
static int take_actual(int fd, int64_t until, int64_t spin, int32_t position[AXES], int64_t *last_stamp)
{
    struct record records[MAX_RECORDS];
    unsigned seen = 0;
    while (seen != (1u << AXES) - 1) {
        int64_t left = until - spin - now_ns();
        if (left <= 0)
            break;
        struct timespec wait = {left / 1000000000LL, left % 1000000000LL};
        struct pollfd poll_fd = {.fd = fd, .events = POLLIN};
        if (ppoll(&poll_fd, 1, &wait, NULL) <= 0)
            continue;
        ssize_t got = recv(fd, records, sizeof records, MSG_DONTWAIT);
        if (got <= 0) {
            if (got < 0 && errno == EAGAIN)
                continue;
            fprintf(stderr, "cycle_ref: the broker is gone\n");
            exit(3);
        }
        for (size_t n = 0; n < (size_t)got / sizeof *records; n++) {
            const struct record *r = &records[n];
            if (r->id < 610 || r->id > 660 || r->id % 10 || r->length != 8)
                continue;
            unsigned axis = (r->id - 610) / 10;
            memcpy(&position[axis], r->data + 2, 4); /* little endian, as every machine this bench runs on */
            seen |= 1u << axis;
            *last_stamp = (int64_t)r->stamp_ns;
        }
    }
    return __builtin_popcount(seen);
}

static void fill(struct record out[AXES + 1], uint8_t life, int enable, const int32_t position[AXES])
{
    memset(out, 0, (AXES + 1) * sizeof *out);
    out[0].id = 100;
    for (int axis = 0; axis < AXES; axis++) {
        struct record *r = &out[axis + 1];
        r->id = 210 + 10 * axis;
        r->length = 8;
        r->data[0] = enable ? 3 : 0;
        r->data[1] = life;
        memcpy(r->data + 2, &position[axis], 4);
    }
}

static int by_size(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

static double percentile_us(const int64_t *sorted, long count, double share)
{
    return count ? sorted[(long)((count - 1) * share)] / 1000.0 : 0.0;
}

int main(int argc, char **argv)
{
    static const struct option options[] = {{"name", 1, 0, 'n'},     {"period-us", 1, 0, 'p'}, {"cycles", 1, 0, 'c'}, {"spin-us", 1, 0, 's'},
                                            {"priority", 1, 0, 'r'}, {"enable", 0, 0, 'e'},    {0, 0, 0, 0}};
    const char *name = NULL;
    int64_t period = 4000000, spin = 100000;
    long cycles = 2500;
    int priority = 40, enable = 0, option;
    while ((option = getopt_long(argc, argv, "", options, NULL)) != -1) {
        switch (option) {
        case 'n': name = optarg; break;
        case 'p': period = atoll(optarg) * 1000; break;
        case 'c': cycles = atol(optarg); break;
        case 's': spin = atoll(optarg) * 1000; break;
        case 'r': priority = atoi(optarg); break;
        case 'e': enable = 1; break;
        default: return 2;
        }
    }
    if (!name || period < 100000 || cycles < 1 || spin < 0 || spin >= period) {
        fprintf(stderr, "usage: cycle_ref --name BUS [--period-us N] [--cycles N] [--spin-us N] [--priority N] [--enable]\n");
        return 2;
    }
    int fd = connect_broker(name);
    int64_t *late = calloc((size_t)cycles, sizeof *late), *done = calloc((size_t)cycles, sizeof *done);
    if (!late || !done)
        return 3;
    struct sched_param param = {.sched_priority = priority};
    int realtime = priority > 0 && sched_setscheduler(0, SCHED_FIFO, &param) == 0;
    int locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;

    struct record out[AXES + 1];
    int32_t position[AXES] = {0}, held[AXES] = {0};
    int64_t stamp = 0, skipped = 0, incomplete = 0, refused = 0, answered = 0;
    int64_t due = now_ns() + 10 * period, start = due;
    uint8_t life = 0;
    for (long n = 0; n < cycles; n++, due += period) {
        int64_t behind = now_ns() - due;
        if (behind >= period) { /* whole instants missed: the phase stays, nothing is made up */
            skipped += behind / period;
            due += behind / period * period;
        }
        fill(out, ++life, enable, held);
        sleep_until(due, spin);
        int64_t sent = now_ns();
        late[n] = sent - due;
        if (send(fd, out, sizeof out, MSG_DONTWAIT | MSG_NOSIGNAL) != (ssize_t)sizeof out)
            refused++;
        if (take_actual(fd, due + period, spin, position, &stamp) == AXES)
            done[answered++] = now_ns() - sent;
        else
            incomplete++;
        if (!enable || n == 0)
            memcpy(held, position, sizeof held);
    }
    qsort(late, (size_t)cycles, sizeof *late, by_size);
    qsort(done, (size_t)answered, sizeof *done, by_size);
    printf("{\"cycles\": %ld, \"period_us\": %lld, \"skipped\": %lld, \"incomplete\": %lld, \"refused\": %lld, "
           "\"late_us\": {\"p50\": %.1f, \"p99\": %.1f, \"p999\": %.1f, \"max\": %.1f}, "
           "\"answered_us\": {\"p50\": %.1f, \"p99\": %.1f, \"p999\": %.1f}, "
           "\"first_ns\": %lld, \"last_ns\": %lld, \"pid\": %d, \"realtime\": %s, \"locked\": %s}\n",
           cycles, (long long)(period / 1000), (long long)skipped, (long long)incomplete, (long long)refused, percentile_us(late, cycles, 0.5),
           percentile_us(late, cycles, 0.99), percentile_us(late, cycles, 0.999), percentile_us(late, cycles, 1.0),
           percentile_us(done, answered, 0.5), percentile_us(done, answered, 0.99), percentile_us(done, answered, 0.999), (long long)start,
           (long long)(due - period), (int)getpid(), realtime ? "true" : "false", locked ? "true" : "false");
    return 0;
}
