/* A client of a pathgene board that plans by itself, over TCP, written from docs/protocol.md alone.
 *
 *     cc -std=c11 -o planner planner.c
 *     pathgene board serve --board model:?core=planner --listen 127.0.0.1:2217
 *     ./planner 127.0.0.1 2217 [MILLISECONDS]
 *
 * It does what the page's section "A small planner" says, and prints the CRC-32 of the best paths.
 * After so many milliseconds of silence, 2000 by default, it sends a request again. */
#include "link.h"

enum { STATUS = 3, MAP = 10, PROBLEM = 14, RUN = 15, STOP = 16, BEST = 17, BLOCK = 18 };
/* Fraction bits of a position, an altitude and a scale; width of an edge's fall; edges, blocks. */
enum { POSITION = 8, ALTITUDE = 4, SCALE = 14, EDGE_BITS = 16, EDGES = 8, BLOCK_BITS = 5 };
enum { RUNNING_AT = 10, MAX_PAYLOAD = 256 };

/* A payload of fields of whole bits, the first lowest. */
struct fields {
    uint8_t data[MAX_PAYLOAD];
    unsigned bits;
};

/* Append a field; a negative value becomes its two's complement. */
static void field(struct fields *fields, int64_t value, unsigned width)
{
    for (unsigned i = 0; i < width; i++, fields->bits++)
        fields->data[fields->bits / 8] |= (uint8_t)(((uint64_t)value >> i & 1) << fields->bits % 8);
}

static void send_fields(struct link *link, int code, const struct fields *fields)
{
    command(link, code, fields->data, (fields->bits + 7) / 8);
}

/* Wait until no run goes on. */
static void wait_for_end(struct link *link)
{
    size_t size;
    const uint8_t *status;
    do {
        status = request(link, STATUS, NULL, 0, &size);
        if (size <= RUNNING_AT)
            fail("the reply to STATUS is too short");
    } while (status[RUNNING_AT] != 0);
}

/* Make every corner of the map flat, a row at a time. */
static void flatten(struct link *link, const struct chip *chip)
{
    static uint8_t payload[8 + 4096 * 2];
    size_t size = 8 + (chip->map_size * chip->altitude_bits + 7) / 8;
    if (size > chip->payload_room)
        fail("a row of the map is longer than the board's receive buffer");
    for (unsigned y = 0; y < chip->map_size; y++) {
        put(payload, 0, 2);
        put(payload + 2, y, 2);
        put(payload + 4, chip->map_size, 2);
        put(payload + 6, 1, 2);
        command(link, MAP, payload, size);
    }
}

/* Append a point: a corner, at half of all altitudes. */
static void point(struct fields *fields, const struct chip *chip, unsigned x, unsigned y)
{
    field(fields, x << POSITION, chip->coordinate_bits + POSITION);
    field(fields, y << POSITION, chip->coordinate_bits + POSITION);
    field(fields, chip->blocked / 2 << ALTITUDE, chip->altitude_bits + ALTITUDE);
}

static void set_problem(struct link *link, const struct chip *chip)
{
    unsigned edge = chip->map_size, bits = chip->coordinate_bits;
    struct fields problem = {0};
    point(&problem, chip, edge / 8, edge / 2);          /* Start. */
    point(&problem, chip, edge - edge / 8, edge / 2);   /* Goal. */
    field(&problem, edge - 1, bits);                    /* Highest x, y and altitude. */
    field(&problem, edge - 1, bits);
    field(&problem, chip->blocked - 1, chip->altitude_bits);
    field(&problem, 1 << SCALE, SCALE + 1);             /* Square cells. */
    field(&problem, 1 << SCALE, SCALE + 1);
    field(&problem, 12000, 20);                         /* Rise. */
    field(&problem, 12000, 24);                         /* Climb. */
    field(&problem, 20000, 24);                         /* Descent. */
    field(&problem, 512, 18);                           /* Radius. */
    field(&problem, 0, 25);                             /* Base. */
    field(&problem, 5201, 16);                          /* Drag. */
    field(&problem, 60294, 16);                         /* Fuel, and its shift. */
    field(&problem, 13, 5);
    field(&problem, 10, 6);                             /* Shift of a key, and of a block. */
    field(&problem, bits > BLOCK_BITS ? bits - BLOCK_BITS : 0, 4);
    for (int end = 0; end < 2; end++) {                 /* Neither heading is fixed. */
        field(&problem, 0, 1);
        field(&problem, 0, 2 * (bits + POSITION) + chip->altitude_bits + ALTITUDE);
    }
    send_fields(link, PROBLEM, &problem);
}

static void run(struct link *link, const struct chip *chip, bool warm)
{
    struct fields options = {0};
    field(&options, 1, 64);                     /* Seed. */
    field(&options, 1000000, 32);               /* Cycles and generations at most. */
    field(&options, 50, 32);
    field(&options, chip->population - 1, 8);   /* Rank to give up at. */
    field(&options, 2 * chip->population, 16);  /* Seeds of an island. */
    field(&options, 2, 3);                      /* Lifts. */
    field(&options, 8, 5);                      /* Share. */
    field(&options, warm, 1);
    field(&options, warm ? 1 : 2, 2);           /* Islands. */
    field(&options, 0, 8);                      /* No guide. */
    field(&options, 0, 1);                      /* Do not wait for a feasible path. */
    field(&options, 3, 4);                      /* Slopes of the islands. */
    field(&options, 0, 4);
    field(&options, 8, 4);                      /* Paths. */
    send_fields(link, RUN, &options);
    wait_for_end(link);
}

/* Block a disc in the middle of the map. */
static void block_disc(struct link *link, const struct chip *chip)
{
    unsigned bits = chip->coordinate_bits, middle = chip->map_size / 2;
    int radius = (int)chip->map_size / 16;
    struct fields shape = {0};
    for (int corner = -1; corner <= 1; corner += 2)     /* The box: x and y of two corners. */
        for (int axis = 0; axis < 2; axis++)
            field(&shape, (int)middle + corner * radius, bits);
    field(&shape, 1, 8);                                /* The first edge bends. */
    field(&shape, 1, 8);
    for (int edge = 0; edge < EDGES; edge++) {
        field(&shape, edge == 0 ? -radius * radius : 0, bits + EDGE_BITS + 1);
        field(&shape, edge == 0 ? 2 * radius : 0, EDGE_BITS);
        field(&shape, edge == 0 ? 2 * radius : 0, EDGE_BITS);
    }
    send_fields(link, BLOCK, &shape);
}

int main(int count, char **arguments)
{
    struct link link = {0};
    struct chip chip = open_chip(&link, count, arguments);
    if (chip.core != 2)
        fail("the board has no planner core");
    command(&link, STOP, NULL, 0);              /* A run that an earlier session has left. */
    wait_for_end(&link);
    flatten(&link, &chip);
    set_problem(&link, &chip);
    run(&link, &chip, false);
    block_disc(&link, &chip);
    run(&link, &chip, true);

    size_t size;
    const uint8_t *best = request(&link, BEST, NULL, 0, &size);
    printf("best paths CRC-32: %08lx\n", (unsigned long)crc32(best, size));
    close(link.socket);
    return 0;
}
