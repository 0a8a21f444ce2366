"""Populations for the tests of breeding, and the words that breed them."""

from pathgene.hdl.config import Config
from tests.support.planner import cases as planner_cases
from tests.support.planner.plain import Waypoint, bits, draw


#: A chip with a few short paths, half of which are replaced per generation.
TINY = Config(
    population=8, children=4, elites=1, survivors=3, perturbs=1, inserts=1, deletes=1,
    max_waypoints=3, map_size=8, coarse_factor=2, altitude_bits=4, lanes=4, box_percent=100,
)  # fmt: skip


class Words:
    """A random source of given words, which include extremes; all mutations are equally likely."""

    def __init__(self, rng):
        self._rng = rng
        self.taken = []

    def draw(self):
        """Return newly drawn words of a step."""
        rng = self._rng
        selection, mutation = (int(rng.integers(1 << 64, dtype="uint64")) for _ in range(2))
        if rng.random() < 0.2:
            offsets = int(rng.choice([0, (1 << 42) - 1]))
            mutation = mutation & ((1 << 20) - 1) | offsets << 20
        if rng.random() < 0.2:
            mutation = mutation & ~0xFF00 | int(rng.choice([0, 0xFF])) << 8
        # Bounds between the mutations, and equal parts of each.
        operator = int(
            rng.choice([0, 113, 114, 156, 157, 199, 200, 255, *rng.integers(256, size=8)])
        )
        return selection, mutation & ~0xFF | operator

    def step(self):
        """Return the next of ``taken``, as the model's source does."""
        return self.taken.pop(0)


def waypoint(config, rng):
    """A waypoint on the map with any margin."""
    top = config.blocked_altitude
    margin = int(rng.choice([-top, top, 0, rng.integers(-top, top + 1), rng.integers(-3, 4)]))
    x, y = (int(rng.choice([0, config.map_size - 1, rng.integers(config.map_size)])) for _ in "xy")
    return Waypoint(x, y, int(rng.choice([0, top, rng.integers(top + 1)])), margin)


def population(config, rng):
    """Paths of all lengths, often the shortest and the longest."""
    paths = []
    for _ in range(config.population):
        length = rng.choice([2, config.max_waypoints, rng.integers(2, config.max_waypoints + 1)])
        paths.append([waypoint(config, rng) for _ in range(length)])
    return paths


def problem(config, rng):
    """A problem with any limits, and the corners of its start and goal."""
    limits = [
        int(rng.choice([high, rng.integers(high + 1)]))
        for high in (config.map_size - 1, config.map_size - 1, config.blocked_altitude)
    ]
    names = ("x_limit", "y_limit", "altitude_limit")
    record = planner_cases.record(config, rng, **dict(zip(names, limits, strict=True)))
    return record, (waypoint(config, rng)[:3], waypoint(config, rng)[:3])


def corner(point):
    """A point in the form of the gateware."""
    return dict(zip(("x", "y", "altitude"), point, strict=True))


def plan_of(sizes, head, tail, word):
    """Return the definition's plan of a child of two parents, each given as (slot, length)."""
    eighths = 2 * bits(word, 62, 2) + 1
    head_before, tail_before = head[1] * eighths // 8, tail[1] * eighths // 8
    length = head_before + tail[1] - tail_before
    operator, size = draw(word, 0, 8, 18), bits(word, 16, 4)
    inserts = 8 <= operator < 11 and length < sizes["max_waypoints"]
    deletes = 11 <= operator < 14 and length > 2
    boxes = sizes["box_cells"], sizes["box_cells"], sizes["box_steps"]
    shift = size * 7 >> 4 if inserts else size >> 1
    moves = [
        draw(word, 20 + 14 * axis, 14, 2 * box + 1) - box >> shift for axis, box in enumerate(boxes)
    ]
    return {
        "head_slot": head[0],
        "tail_slot": tail[0],
        "head": head_before,
        "tail_gain": tail_before - head_before,
        "length": length,
        "inserts": inserts,
        "deletes": deletes,
        "settles": operator >= 14,
        "place": 1 + draw(word, 8, 8, length + inserts),
        "move": dict(zip(("x", "y", "altitude"), moves, strict=True)),
        "doubles": size * 3 >> 4,
    }
