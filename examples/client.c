/* A client of a pathgene board over TCP, written from docs/protocol.md alone.
 *
 *     cc -std=c11 -o client client.c
 *     pathgene board serve --board sim: --listen 127.0.0.1:2217
 *     ./client 127.0.0.1 2217 [MILLISECONDS]
 *
 * It does what the page's section "A small client" says, and prints the CRC-32 of the population.
 * After so many milliseconds of silence, 2000 by default, it sends a request again. */
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
    VERSION = 2,
    HEADER = 3,
    CRC_BYTES = 4,
    GENERATIONS = 5,
    TRIES = 12,
    MAX_SLOTS = 256,
    MAX_WAYPOINTS = 64,
    WAYPOINT_BYTES = 6,     /* At most: two coordinates of 12 bits, an altitude of 16, last. */
    MAX_BODY = HEADER + MAX_SLOTS + MAX_SLOTS * MAX_WAYPOINTS * WAYPOINT_BYTES + CRC_BYTES,
    MAX_FRAME = MAX_BODY + MAX_BODY / 254 + 3,
};

enum { INFO = 1, OPEN = 2, START = 4, WRITE = 5, GENERATE = 6, READ = 7 };
enum { STATUS_OK = 0, LINK_MODE_RANK = 1 };

/* What INFO says of the chip, and the sizes that follow from it. */
struct chip {
    unsigned session, population, children, elites, survivors, max_waypoints, map_size;
    unsigned altitude_bits, coordinate_bits, waypoint_bits, waypoint_bytes, blocked, payload_room;
};

struct path {
    unsigned length;
    uint64_t waypoints[MAX_WAYPOINTS];
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

/* --- Payloads ------------------------------------------------------------------------------- */

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
    if (size < 1 || reply[0] != VERSION || size != 35)
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
    };
    if (reply[30] == 0)
        fail("the board has no genetic core");
    if (chip.population > MAX_SLOTS || chip.max_waypoints > MAX_WAYPOINTS ||
        chip.elites + chip.survivors + chip.children != chip.population)
        fail("the board's sizes are none that the protocol allows");
    chip.coordinate_bits = bits_of(chip.map_size);
    chip.waypoint_bits = 2 * chip.coordinate_bits + chip.altitude_bits;
    chip.waypoint_bytes = (chip.waypoint_bits + 1 + 7) / 8;
    chip.blocked = (1u << chip.altitude_bits) - 1;
    return chip;
}

static size_t pack_path(const struct chip *chip, const struct path *path, uint8_t *data)
{
    size_t size = 0;
    for (unsigned i = 0; i < path->length; i++) {
        uint64_t last = (uint64_t)(i + 1 == path->length) << chip->waypoint_bits;
        size += put(data + size, path->waypoints[i] | last, chip->waypoint_bytes);
    }
    return size;
}

/* Take count paths out of a payload; they must fill it. */
static void unpack_paths(const struct chip *chip, const uint8_t *data, size_t size,
                         struct path *paths, unsigned count)
{
    size_t at = 0;
    for (unsigned i = 0; i < count; i++) {
        bool last = false;
        paths[i].length = 0;
        while (!last) {
            if (at + chip->waypoint_bytes > size || paths[i].length == chip->max_waypoints)
                fail("a reply holds no whole paths");
            uint64_t word = little_endian(data + at, chip->waypoint_bytes);
            paths[i].waypoints[paths[i].length++] = word & ((1ull << chip->waypoint_bits) - 1);
            last = word >> chip->waypoint_bits & 1;
            at += chip->waypoint_bytes;
        }
    }
    if (at != size)
        fail("a reply holds more paths than it should");
}

/* --- The planner's part --------------------------------------------------------------------- */

static unsigned draw(uint32_t *state)
{
    *state = 1664525u * *state + 1013904223u;
    return *state >> 16;
}

static void first_population(const struct chip *chip, struct path *paths)
{
    uint32_t state = 1;
    for (unsigned slot = 0; slot < chip->population; slot++) {
        paths[slot].length = 2 + draw(&state) % (chip->max_waypoints - 1);
        for (unsigned i = 0; i < paths[slot].length; i++) {
            uint64_t x = draw(&state) % chip->map_size;
            uint64_t y = draw(&state) % chip->map_size;
            uint64_t altitude = draw(&state) % chip->blocked;
            paths[slot].waypoints[i] =
                x | y << chip->coordinate_bits | altitude << 2 * chip->coordinate_bits;
        }
    }
}

/* Distance of two waypoints in one coordinate: bits from low on. */
static unsigned distance(uint64_t one, uint64_t other, unsigned low, unsigned bits)
{
    int mask = (1 << bits) - 1;
    return (unsigned)abs((int)(one >> low & mask) - (int)(other >> low & mask));
}

static unsigned cost(const struct chip *chip, const struct path *path)
{
    unsigned sum = 0, bits = chip->coordinate_bits;
    for (unsigned i = 1; i < path->length; i++) {
        uint64_t one = path->waypoints[i - 1], other = path->waypoints[i];
        sum += distance(one, other, 0, bits) + distance(one, other, bits, bits);
        sum += distance(one, other, 2 * bits, chip->altitude_bits);
    }
    return sum;
}

/* Write the slots from the lowest cost to the highest; of equal costs the lower slot is first. */
static void rank(const struct chip *chip, const struct path *paths, uint8_t *order)
{
    unsigned costs[MAX_SLOTS];
    for (unsigned slot = 0; slot < chip->population; slot++) {
        unsigned at = slot;
        costs[slot] = cost(chip, &paths[slot]);
        for (; at > 0 && costs[order[at - 1]] > costs[slot]; at--)
            order[at] = order[at - 1];
        order[at] = (uint8_t)slot;
    }
}

static void write_population(struct link *link, const struct chip *chip, const struct path *paths)
{
    static uint8_t payload[1 + MAX_WAYPOINTS * WAYPOINT_BYTES];
    for (unsigned slot = 0; slot < chip->population; slot++) {
        payload[0] = (uint8_t)slot;
        size_t size = 1 + pack_path(chip, &paths[slot], payload + 1);
        if (size > chip->payload_room)
            fail("a path is longer than the board's receive buffer");
        command(link, WRITE, payload, size);
    }
}

/* Run one generation and make paths the new population. */
static void generate(struct link *link, const struct chip *chip, struct path *paths)
{
    static struct path before[MAX_SLOTS];
    uint8_t payload[1 + MAX_SLOTS] = {LINK_MODE_RANK};
    uint8_t *order = payload + 1;
    rank(chip, paths, order);
    memcpy(before, paths, sizeof before);

    size_t size;
    const uint8_t *reply = request(link, GENERATE, payload, 1 + chip->population, &size);
    if (size < chip->survivors)
        fail("the reply to GENERATE is too short");
    for (unsigned i = 0; i < chip->elites; i++)
        paths[i] = before[order[i]];
    for (unsigned i = 0; i < chip->survivors; i++) {
        if (reply[i] >= chip->population)
            fail("the reply to GENERATE names no slot");
        paths[chip->elites + i] = before[reply[i]];
    }
    unpack_paths(chip, reply + chip->survivors, size - chip->survivors,
                 paths + chip->elites + chip->survivors, chip->children);
}

/* Read all slots, compare them with paths, and return the CRC-32 of their bytes. */
static uint32_t read_population(struct link *link, const struct chip *chip,
                                const struct path *paths)
{
    static uint8_t bytes[MAX_SLOTS * MAX_WAYPOINTS * WAYPOINT_BYTES];
    uint8_t expected[MAX_WAYPOINTS * WAYPOINT_BYTES];
    size_t filled = 0;
    for (unsigned slot = 0; slot < chip->population; slot++) {
        uint8_t payload[2] = {(uint8_t)slot, 1};
        size_t size;
        const uint8_t *reply = request(link, READ, payload, sizeof payload, &size);
        if (size != pack_path(chip, &paths[slot], expected) || memcmp(reply, expected, size) != 0)
            fail("the board's population is not the one that its replies make");
        memcpy(bytes + filled, reply, size);
        filled += size;
    }
    return crc32(bytes, filled);
}

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

int main(int count, char **arguments)
{
    static struct path paths[MAX_SLOTS];
    silence_ms = count == 4 ? atoi(arguments[3]) : silence_ms;
    if (count < 3 || count > 4 || silence_ms < 1) {
        fprintf(stderr, "usage: %s HOST PORT [MILLISECONDS]\n", arguments[0]);
        return 2;
    }
    struct link link = {.socket = connect_to(arguments[1], arguments[2])};
    struct chip chip = ask_chip(&link);
    link.session = (uint8_t)(chip.session + 1);
    link.sequence = 255;    /* A late reply to OPEN is no reply to the first command. */
    command(&link, OPEN, NULL, 0);
    link.sequence = 0;

    uint8_t start[15] = {0};
    put(start, 1, 8);   /* The seed. */
    put(start + 8, chip.map_size - 1, 2);
    put(start + 10, chip.map_size - 1, 2);
    put(start + 12, chip.blocked - 1, 2);
    command(&link, START, start, sizeof start);

    first_population(&chip, paths);
    write_population(&link, &chip, paths);
    for (int generation = 0; generation < GENERATIONS; generation++)
        generate(&link, &chip, paths);
    printf("population CRC-32: %08lx\n", (unsigned long)read_population(&link, &chip, paths));
    close(link.socket);
    return 0;
}
