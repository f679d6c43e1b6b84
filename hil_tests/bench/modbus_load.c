/* Load for a Modbus TCP server: N clients poll one request, each with a fixed number of requests under way.
 *
 *   modbus_load [-p port] [-n clients] [-f function 1..4] [-a address] [-c count] [-d depth] [-t seconds] [-u unit]
 *
 * One thread, epoll, 127.0.0.1 only, ends by itself.  Every answer's transaction number, length, unit, function and byte count are
 * checked; a wrong one is an error and ends that connection.  Prints one JSON line.  Exit 0: no errors; 1: errors; 2: usage;
 * 3: no connection.  Latency runs from the write of a request to the read that completed its answer.
 */
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { MAX_CLIENTS = 256, MAX_DEPTH = 64, REQUEST_BYTES = 12, MAX_ANSWER = 260, BUCKETS = 1 << 16 };

struct client {
    int socket;
    uint16_t next_sent, next_due;     /* transaction numbers */
    int under_way;
    int64_t sent_ns[MAX_DEPTH];       /* by transaction number modulo depth */
    uint8_t input[MAX_DEPTH * MAX_ANSWER];
    int input_bytes;
};

static int port = 1502, clients = 8, function = 3, address = 0, count = 10, depth = 1, unit = 1;
static double seconds = 5.0;
static struct client client[MAX_CLIENTS];
static uint64_t requests, errors;
static uint32_t bucket[BUCKETS];      /* latency in microseconds; the last one holds all longer ones */

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

static void usage(const char *why)
{
    fprintf(stderr, "modbus_load: %s\nusage: modbus_load [-p port] [-n 1..256] [-f 1..4] [-a address] [-c count] [-d 1..64] [-t 0.1..600] [-u unit]\n", why);
    exit(2);
}

static void options(int argc, char **argv)
{
    int o;
    while ((o = getopt(argc, argv, "p:n:f:a:c:d:t:u:")) != -1)
        switch (o) {
        case 'p': port = atoi(optarg); break;
        case 'n': clients = atoi(optarg); break;
        case 'f': function = atoi(optarg); break;
        case 'a': address = atoi(optarg); break;
        case 'c': count = atoi(optarg); break;
        case 'd': depth = atoi(optarg); break;
        case 't': seconds = atof(optarg); break;
        case 'u': unit = atoi(optarg); break;
        default: usage("unknown option");
        }
    if (clients < 1 || clients > MAX_CLIENTS) usage("-n: 1..256 clients");
    if (depth < 1 || depth > MAX_DEPTH) usage("-d: 1..64 requests under way");
    if (function < 1 || function > 4) usage("-f: function code 1..4");
    if (count < 1 || count > (function <= 2 ? 2000 : 125)) usage("-c: 1..2000 bits or 1..125 registers");
    if (address < 0 || address + count > 65536) usage("-a: 0..65535, with count not beyond 65536");
    if (!(seconds >= 0.1 && seconds <= 600.0)) usage("-t: 0.1..600 seconds");
    if (port < 1 || port > 65535 || unit < 0 || unit > 255) usage("-p: 1..65535, -u: 0..255");
}

static void put16(uint8_t *at, int value)
{
    at[0] = value >> 8;
    at[1] = value & 0xff;
}

static int get16(const uint8_t *at)
{
    return at[0] << 8 | at[1];
}

static void drop(struct client *c)
{
    errors++;
    close(c->socket);
    c->socket = -1;
}

/* Fills up to `depth` requests under way, in one write. */
static void ask(struct client *c)
{
    uint8_t out[MAX_DEPTH * REQUEST_BYTES];
    int bytes = 0;
    int64_t now = now_ns();
    while (c->under_way < depth) {
        uint8_t *request = out + bytes;
        put16(request, c->next_sent);
        put16(request + 2, 0);
        put16(request + 4, 6);
        request[6] = unit;
        request[7] = function;
        put16(request + 8, address);
        put16(request + 10, count);
        c->sent_ns[c->next_sent++ % depth] = now;
        c->under_way++;
        bytes += REQUEST_BYTES;
    }
    /* at most 768 bytes while everything before them was answered: the socket takes them whole or is broken */
    if (bytes && send(c->socket, out, bytes, MSG_NOSIGNAL) != bytes)
        drop(c);
}

/* Checks one answer at `at` of `bytes` present; its length, 0 when it is not whole yet, -1 when it is wrong. */
static int judge(const struct client *c, const uint8_t *at, int bytes)
{
    int data = function <= 2 ? (count + 7) / 8 : 2 * count;
    if (bytes < 6)
        return 0;
    int length = get16(at + 4);
    if (get16(at) != c->next_due || get16(at + 2) != 0 || length != 3 + data)
        return -1;
    if (bytes < 6 + length)
        return 0;
    return at[6] == unit && at[7] == function && at[8] == data ? 6 + length : -1;
}

static void note(int64_t latency_ns)
{
    int64_t us = latency_ns / 1000;
    bucket[us < BUCKETS ? us : BUCKETS - 1]++;
    requests++;
}

static void hear(struct client *c, int asking)
{
    ssize_t got = recv(c->socket, c->input + c->input_bytes, sizeof c->input - c->input_bytes, MSG_DONTWAIT);
    if (got < 0 && (errno == EAGAIN || errno == EINTR))
        return;
    if (got <= 0) {
        drop(c);
        return;
    }
    int64_t now = now_ns();
    int start = 0, length = 0;
    c->input_bytes += got;
    while (c->under_way && (length = judge(c, c->input + start, c->input_bytes - start)) > 0) {
        note(now - c->sent_ns[c->next_due++ % depth]);
        c->under_way--;
        start += length;
    }
    if (length < 0 || (!c->under_way && start < c->input_bytes)) { /* wrong, or more than was asked for */
        drop(c);
        return;
    }
    c->input_bytes -= start;
    memmove(c->input, c->input + start, c->input_bytes);
    if (asking)
        ask(c);
}

static int open_client(int poller, int index)
{
    struct sockaddr_in server = {.sin_family = AF_INET, .sin_port = htons(port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    struct epoll_event event = {.events = EPOLLIN, .data.u32 = index};
    int one = 1, s = socket(AF_INET, SOCK_STREAM, 0);
    if (s < 0 || connect(s, (struct sockaddr *)&server, sizeof server) < 0)
        return -1;
    setsockopt(s, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    client[index].socket = s;
    return epoll_ctl(poller, EPOLL_CTL_ADD, s, &event);
}

static int open_or_waiting(void)
{
    int waiting = 0;
    for (int i = 0; i < clients; i++)
        waiting += client[i].socket >= 0 && client[i].under_way;
    return waiting;
}

static int percentile(double part)
{
    uint64_t want = (uint64_t)(part * requests), seen = 0;
    for (int us = 0; us < BUCKETS; us++)
        if ((seen += bucket[us]) > want)
            return us;
    return BUCKETS - 1;
}

int main(int argc, char **argv)
{
    options(argc, argv);
    int poller = epoll_create1(0);
    for (int i = 0; i < clients; i++)
        if (open_client(poller, i) < 0) {
            fprintf(stderr, "modbus_load: client %d to 127.0.0.1:%d: %s\n", i + 1, port, strerror(errno));
            return 3;
        }
    int64_t begin = now_ns(), end = begin + (int64_t)(seconds * 1e9), limit = end + 2000000000LL, last = begin;
    for (int i = 0; i < clients; i++)
        ask(&client[i]);
    while (open_or_waiting() && now_ns() < limit) { /* after the end only what is under way is waited for */
        struct epoll_event event[MAX_CLIENTS];
        int ready = epoll_wait(poller, event, MAX_CLIENTS, 100);
        for (int i = 0; i < ready; i++) {
            last = now_ns();
            if (client[event[i].data.u32].socket >= 0)
                hear(&client[event[i].data.u32], last < end);
        }
    }
    for (int i = 0; i < clients; i++)
        if (client[i].socket >= 0)
            errors += client[i].under_way; /* asked and never answered */
    printf("{\"requests\": %llu, \"seconds\": %.6f, \"errors\": %llu, \"p50_us\": %d, \"p99_us\": %d}\n", (unsigned long long)requests,
           (last - begin) / 1e9, (unsigned long long)errors, percentile(0.50), percentile(0.99));
    return errors ? 1 : 0;
}
