/* What the clients share: frames, requests, a chip's sizes. From docs/protocol.md alone. */
#define _POSIX_C_SOURCE 200809L

#include <netdb.h>
#include <poll.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <unistd.h>

enum {
    VERSION = 5,
    HEADER = 3,
    CRC_BYTES = 4,
    TRIES = 12,
    MAX_SLOTS = 256,
    MAX_WAYPOINTS = 64,
    WAYPOINT_BYTES = 6,     /* At most: two coordinates of 12 bits, an altitude of 16, last. */
    MAX_BODY = HEADER + MAX_SLOTS + MAX_SLOTS * MAX_WAYPOINTS * WAYPOINT_BYTES + CRC_BYTES,
    MAX_FRAME = MAX_BODY + MAX_BODY / 254 + 3,
};

enum { INFO = 1, OPEN = 2 };
enum { STATUS_OK = 0 };

/* What INFO says of the chip, and the sizes that follow from it. */
struct chip {
    unsigned session, population, children, elites, survivors, max_waypoints, map_size;
    unsigned altitude_bits, coordinate_bits, waypoint_bits, waypoint_bytes, blocked, payload_room;
    unsigned core;          /* 0 none, 1 paper, 2 planner. */
};

/* A socket, and the header of the next request. */
struct link {
    int socket;
    uint8_t session, sequence;
};

static int silence_ms = 2000;

static void fail(const char *what)
{
    fprintf(stderr, "client: %s\n", what);
    exit(1);
}

/* --- Numbers, the lowest byte first --------------------------------------------------------- */

static uint64_t little_endian(const uint8_t *data, unsigned size)
{
    uint64_t value = 0;
    for (unsigned i = size; i-- > 0;)
        value = value << 8 | data[i];
    return value;
}

/* Write a number and return its size. */
static size_t put(uint8_t *data, uint64_t value, unsigned size)
{
    for (unsigned i = 0; i < size; i++)
        data[i] = (uint8_t)(value >> 8 * i);
    return size;
}

/* --- Frames --------------------------------------------------------------------------------- */

static uint32_t crc32(const uint8_t *data, size_t size)
{
    uint32_t crc = 0xFFFFFFFF;
    for (size_t i = 0; i < size; i++) {
        crc ^= data[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320 : 0);
    }
    return ~crc;
}

static uint32_t frame_crc(const uint8_t *body, size_t size, bool plain)
{
    return crc32(body, size) ^ (plain ? 0 : VERSION * 0x01010101u);
}

/* Write the frame of a body, which has room for its CRC; return its size with the delimiter. */
static size_t encode(uint8_t *body, size_t size, bool plain, uint8_t *frame)
{
    uint32_t crc = frame_crc(body, size, plain);
    size += put(body + size, crc, CRC_BYTES);

    size_t code = 0, end = 1;   /* Where the code of the block at hand stands, and its end. */
    for (size_t i = 0; i < size; i++) {
        if (body[i] != 0)
            frame[end++] = body[i];
        bool full = end - code == 255;
        if (body[i] == 0 || (full && i + 1 < size)) {
            frame[code] = (uint8_t)(end - code);
            code = end++;
        }
    }
    frame[code] = (uint8_t)(end - code);
    frame[end++] = 0;
    return end;
}

/* Write the body of what stood before a delimiter; return its size without CRC, 0 if damaged. */
static size_t decode(const uint8_t *frame, size_t size, bool plain, uint8_t *body)
{
    size_t at = 0, end = 0;
    while (at < size) {
        unsigned code = frame[at++];
        if (code - 1 > size - at)
            return 0;
        memcpy(body + end, frame + at, code - 1);
        at += code - 1;
        end += code - 1;
        if (code != 255 && at < size)
            body[end++] = 0;
    }
    if (end < HEADER + CRC_BYTES)
        return 0;
    end -= CRC_BYTES;
    uint32_t crc = frame_crc(body, end, plain);
    return little_endian(body + end, CRC_BYTES) == crc ? end : 0;
}

/* --- Requests and replies ------------------------------------------------------------------- */

static void send_all(int socket, const uint8_t *data, size_t size)
{
    while (size > 0) {
        ssize_t sent = send(socket, data, size, MSG_NOSIGNAL);
        if (sent <= 0)
            fail("the board hung up");
        data += sent;
        size -= (size_t)sent;
    }
}

/* Take one byte off the line; return whether one came before the end of the silence. */
static bool receive_byte(int socket, uint8_t *byte)
{
    static uint8_t buffer[4096];
    static size_t at, filled;
    if (at == filled) {
        struct pollfd waiting = {.fd = socket, .events = POLLIN};
        if (poll(&waiting, 1, silence_ms) <= 0)
            return false;
        ssize_t got = recv(socket, buffer, sizeof buffer, 0);
        if (got <= 0)
            fail("the board hung up");
        at = 0;
        filled = (size_t)got;
    }
    *byte = buffer[at++];
    return true;
}

/* Wait for the reply to a request with this header; return the size of its body, 0 after silence. */
static size_t await_reply(int socket, const uint8_t *header, bool plain, uint8_t *reply)
{
    static uint8_t frame[MAX_FRAME];
    size_t size = 0;
    uint8_t byte;
    while (receive_byte(socket, &byte)) {
        if (byte != 0) {
            if (size < sizeof frame)
                frame[size++] = byte;
            continue;
        }
        size_t got = size > 0 && size < sizeof frame ? decode(frame, size, plain, reply) : 0;
        if (got > 0 && reply[0] == header[0] && reply[1] == header[1])
            return got;
        size = 0;   /* Damaged, or late: the reply to an earlier request. */
    }
    return 0;
}

/* Send a request until there is a reply; return the reply's payload and its size. */
static const uint8_t *request(struct link *link, int code, const uint8_t *payload, size_t size,
                              size_t *reply_size)
{
    static uint8_t body[MAX_BODY], reply[MAX_BODY], frame[MAX_FRAME + 1];
    const uint8_t header[HEADER] = {link->session, link->sequence, (uint8_t)code};
    bool plain = code == INFO;
    memcpy(body, header, HEADER);
    if (size > 0)
        memcpy(body + HEADER, payload, size);
    frame[0] = 0;   /* Ends what the chip's receiver may have been left in. */
    size_t frame_size = 1 + encode(body, HEADER + size, plain, frame + 1);

    for (int attempt = 0; attempt < TRIES; attempt++) {
        send_all(link->socket, frame, frame_size);
        size_t got = await_reply(link->socket, header, plain, reply);
        if (got == 0)
            continue;
        if (reply[2] != STATUS_OK)
            fail("the board refused a command");
        if (code != INFO && code != OPEN)
            link->sequence++;
        *reply_size = got - HEADER;
        return reply + HEADER;
    }
    fail("the board does not answer");
    return NULL;
}

/* Send a request whose reply has no payload. */
static void command(struct link *link, int code, const uint8_t *payload, size_t size)
{
    request(link, code, payload, size, &(size_t){0});
}

/* --- Sizes ---------------------------------------------------------------------------------- */

/* Width of a number from 0 to count - 1. */
static unsigned bits_of(unsigned count)
{
    unsigned bits = 0;
    while (1u << bits < count)
        bits++;
    return bits;
}

static struct chip ask_chip(struct link *link)
{
    size_t size;
    const uint8_t *reply = request(link, INFO, NULL, 0, &size);
    if (size < 1 || reply[0] != VERSION || size != 36)
        fail("the board speaks another version of the protocol");
    struct chip chip = {
        .session = reply[5],
        .population = (unsigned)little_endian(reply + 6, 2),
        .children = reply[8],
        .elites = reply[9],
        .survivors = reply[10],
        .max_waypoints = reply[14],
        .map_size = (unsigned)little_endian(reply + 15, 2),
        .altitude_bits = reply[19],
        .payload_room = (unsigned)little_endian(reply + 28, 2) - HEADER - CRC_BYTES,
        .core = reply[30],
    };
    if (chip.population > MAX_SLOTS || chip.max_waypoints > MAX_WAYPOINTS ||
        chip.elites + chip.survivors + chip.children != chip.population)
        fail("the board's sizes are none that the protocol allows");
    chip.coordinate_bits = bits_of(chip.map_size);
    chip.waypoint_bits = 2 * chip.coordinate_bits + chip.altitude_bits;
    chip.waypoint_bytes = (chip.waypoint_bits + 1 + 7) / 8;
    chip.blocked = (1u << chip.altitude_bits) - 1;
    return chip;
}

/* --- Sessions ------------------------------------------------------------------------------- */

static int connect_to(const char *host, const char *port)
{
    struct addrinfo hints = {.ai_socktype = SOCK_STREAM}, *found;
    if (getaddrinfo(host, port, &hints, &found) != 0)
        fail("there is no such address");
    int line = socket(found->ai_family, found->ai_socktype, found->ai_protocol);
    if (line < 0 || connect(line, found->ai_addr, found->ai_addrlen) != 0)
        fail("nothing listens there");
    freeaddrinfo(found);
    return line;
}

/* Connect to the board that the command line names, open a session, and return what it is. */
static struct chip open_chip(struct link *link, int count, char **arguments)
{
    silence_ms = count == 4 ? atoi(arguments[3]) : silence_ms;
    if (count < 3 || count > 4 || silence_ms < 1) {
        fprintf(stderr, "usage: %s HOST PORT [MILLISECONDS]\n", arguments[0]);
        exit(2);
    }
    link->socket = connect_to(arguments[1], arguments[2]);
    struct chip chip = ask_chip(link);
    link->session = (uint8_t)chip.session;
    link->sequence = 255;   /* A late reply to OPEN is no reply to the first command. */
    do {   /* Not 0: that is the session of a chip after a reset, which would go unnoticed. */
        link->session++;
        command(link, OPEN, NULL, 0);
    } while (link->session == 0);
    link->sequence = 0;
    return chip;
}
