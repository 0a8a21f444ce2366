"""The drawer of shapes compared with the definition: corners, their order, and cycles."""

import itertools

import numpy as np
import pytest

from pathgene.hdl.planner.layouts import shape_layout
from pathgene.hdl.planner.shape_drawer import ShapeDrawer
from pathgene.hdl.protocol.planner import BEND_BITS, EDGE_BITS, EDGES, NoFlyShape, no_fly_request
from tests.support.gateware.streams import put, shared, simulate
from tests.support.planner.cases import LARGE, SMALL, USUAL
from tests.support.planner.cases import shape as any_shape
from tests.support.planner.plain import drawn


#: A map of 8 corners along each edge.
TINY = SMALL.replace(map_size=8)


def in_order(config, shape):
    """Return the corners in a shape as they are drawn: each with its number in the box."""
    # With all edges, as on the chip.
    shape = NoFlyShape.unpack(config, shape.pack(config))
    width = shape.last_x - shape.first_x + 1
    corners = {}
    for x, y in drawn(shape):
        u, v = x - shape.first_x, y - shape.first_y
        corners[v * width + (width - 1 - u if v % 2 else u)] = (x, y)
    return sorted(corners.items())


def check(config, shapes, pauses=(0,)):
    """Draw shapes and compare corners and cycles; return the number of corners."""
    dut = shared(ShapeDrawer, config.coordinate_bits, config.altitude_bits)
    layout = shape_layout(config.coordinate_bits)
    rng = np.random.default_rng(len(shapes))
    begun, taken, cells = [], [], []

    def noise():
        return layout.from_bits(int.from_bytes(rng.bytes(layout.size // 8), "little"))

    async def bench(ctx):
        for shape, pause in zip(shapes, itertools.cycle(pauses)):
            for _ in range(pause):
                ctx.set(dut.shapes.payload, noise())
                await ctx.tick()
            packed = int.from_bytes(shape.pack(config), "little")
            await put(ctx, dut.shapes, layout.from_bits(packed))
        ctx.set(dut.shapes.payload, noise())
        await ctx.tick().repeat(4)

    async def watch(ctx):
        ctx.set(dut.cells.ready, 1)
        is_offered = False
        for cycle in itertools.count():
            *_, valid, ready, writes, cell = await ctx.tick().sample(
                dut.shapes.valid, dut.shapes.ready, dut.cells.valid, dut.cells.payload
            )
            if valid and not is_offered:
                begun.append(cycle)
            if ready:
                assert valid
                taken.append(cycle)
            is_offered = valid and not ready
            if writes:
                assert (cell.altitude, cell.last) == (config.blocked_altitude, 0)
                cells.append((cycle, (cell.x, cell.y)))

    simulate(dut, bench, background=[watch])
    assert [end - begin + 1 for begin, end in zip(begun, taken, strict=True)] == [
        shape.drawing_cycles for shape in shapes
    ]
    assert cells == [
        (begin + 2 + number, corner)
        for begin, shape in zip(begun, shapes, strict=True)
        for number, corner in in_order(config, shape)
    ]
    # A shape that is offered in the next cycle loses no cycle.
    waits = [begin - end - 1 for begin, end in zip(begun[1:], taken, strict=False)]
    assert waits == list(itertools.islice(itertools.cycle(pauses), 1, len(shapes)))
    return len(cells)


@pytest.mark.ci
@pytest.mark.parametrize("config", [TINY, SMALL, USUAL, LARGE], ids=["8", "32", "512", "4096"])
def test_random_shapes(config):
    """Boxes, discs and polygons of up to 8 edges come in direct succession and with pauses."""
    rng = np.random.default_rng(config.map_size)
    shapes = [any_shape(config, rng, span=12) for _ in range(40)]
    assert check(config, shapes) == check(config, shapes, (0, 3, 1)) > 100


def test_whole_map():
    """A disc, a box and a triangle are drawn on an entire small map."""
    box = {"first_x": 0, "first_y": 0, "last_x": 31, "last_y": 31}
    disc = NoFlyShape(**box, edges=((-238, 30, 30),), bend_x=1, bend_y=1)
    triangle = NoFlyShape(**box, edges=((0, 1, 0), (0, 0, 1), (31, -1, -1)))
    inside = len(drawn(disc))
    assert 600 < inside < 800
    assert check(SMALL, [disc, NoFlyShape(**box, edges=()), triangle]) == inside + 1024 + 528


def falls(config):
    """Return the extremes of an edge's fall, and of its value at the first corner."""
    most = 1 << EDGE_BITS - 1
    half = most << config.coordinate_bits + 1
    return (-most, most - 1), (-half, half - 1)


def boxed(first, last, edges, bends=(0, 0)):
    return NoFlyShape(
        first_x=first[0],
        first_y=first[1],
        last_x=last[0],
        last_y=last[1],
        edges=tuple(edges),
        bend_x=bends[0],
        bend_y=bends[1],
    )


def extreme(config, rng, first, last):
    """Return a shape whose fields have extremes, often in only one edge."""
    (down, up), (low, high) = falls(config)
    edges = [
        (int(rng.choice([low, -1, 0, high, high])), *rng.choice([down, -1, 0, up], size=2).tolist())
        for _ in range(EDGES)
    ]
    if rng.random() < 0.7:
        one = int(rng.integers(EDGES))
        edges = [edge if number == one else (0, 0, 0) for number, edge in enumerate(edges)]
    bends = rng.choice([0, 1, (1 << BEND_BITS) - 1], size=2).tolist()
    return boxed(first, last, edges, bends)


def test_extremes():
    """Every field is tried in all boxes of a tiny map and in long rows of a larger one."""
    rng = np.random.default_rng(1)
    corners = np.sort(rng.integers(TINY.map_size, size=(300, 2, 2)), axis=1).tolist()
    assert check(TINY, [extreme(TINY, rng, *box) for box in corners]) > 400
    last = USUAL.map_size - 1
    boxes = [((0, 3), (last, 3)), ((7, 0), (7, last)), ((last, last), (last, last))]
    assert check(USUAL, [extreme(USUAL, rng, *box) for _ in range(4) for box in boxes]) > 1000


@pytest.mark.parametrize("config", [TINY, SMALL], ids=["8", "32"])
def test_lowest_and_highest_values(config):
    """Each edge in the last corner of the whole map: no corner is drawn, or all are."""
    (down, up), (low, high) = falls(config)
    last = config.map_size - 1
    most = (1 << BEND_BITS) - 1
    box = (0, 0), (last, last)
    shapes = []
    for number in range(EDGES):
        others = [(0, 0, 0)] * number
        bends = (0, 0) if number else (most, most)
        shapes.append(boxed(*box, [*others, (low, down, down)], bends))
        shapes.append(boxed(*box, [*others, (high, up, up)]))
    assert check(config, shapes) == EDGES * config.map_size**2


def test_layout():
    """The fields of the request are in order, and edges have a sign."""
    for config in (TINY, USUAL, LARGE):
        fields = [(name, field.shape) for name, field in shape_layout(config.coordinate_bits)]
        request = no_fly_request(config).fields
        assert [(name, getattr(shape, "width", shape)) for name, shape in fields] == list(request)
        signs = {name.rpartition("_")[0] for name, shape in fields if not isinstance(shape, int)}
        assert signs == {"at", "east", "north"}
