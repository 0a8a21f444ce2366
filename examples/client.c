/* A client of a pathgene board over TCP, written from docs/protocol.md alone.
 *
 *     cc -std=c11 -o client client.c
 *     pathgene board serve --board sim: --listen 127.0.0.1:2217
 *     ./client 127.0.0.1 2217 [MILLISECONDS]
 *
 * It does what the page's section "A small client" says, and prints the CRC-32 of the population.
 * After so many milliseconds of silence, 2000 by default, it sends a request again. */
#include "link.h"

enum { START = 4, WRITE = 5, GENERATE = 6, READ = 7 };
enum { LINK_MODE_RANK = 1, GENERATIONS = 5 };

struct path {
    unsigned length;
    uint64_t waypoints[MAX_WAYPOINTS];
};

/* --- Paths ---------------------------------------------------------------------------------- */

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

int main(int count, char **arguments)
{
    static struct path paths[MAX_SLOTS];
    struct link link = {0};
    struct chip chip = open_chip(&link, count, arguments);
    if (chip.core != 1)
        fail("the board has no paper core");

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
