"""Chips shared by tests so that each is built once, and a comparison of two boards."""

import random

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.protocol.codes import Counter, LinkMode
from tools.chips import SMALL


#: The small chip with the paper's checker; the link does not distinguish builds of the checker.
CHECKING = SMALL.replace(checker=CheckerBuild.TWO_TIER, lanes=1)

#: The small chip with each build of the checker, by the build's name.
CHECKERS = {
    "two-tier": CHECKING,
    "parallel": SMALL.replace(checker=CheckerBuild.PARALLEL, lanes=4),
}

#: The smallest core: one mutator of each kind, no map.
TINY = Config(
    population=8,
    children=4,
    elites=2,
    survivors=2,
    perturbs=1,
    inserts=1,
    deletes=1,
    max_waypoints=4,
    map_size=16,
    coarse_factor=4,
    altitude_bits=4,
    checker=CheckerBuild.NONE,
)

#: Counters from which the model omits a few cycles per command.
LINE_CYCLES = (Counter.CYCLES, Counter.RECEIVE, Counter.TRANSMIT)


def random_path(config, rng, length=None):
    """Return a packed path of random waypoints, with random length unless given."""
    length = length or rng.randint(config.MIN_WAYPOINTS, config.max_waypoints)
    return [rng.getrandbits(config.waypoint_bits) for _ in range(length)]


def random_paths(config, rng, length=None):
    """Return a population of :func:`random_path`."""
    return [random_path(config, rng, length) for _ in range(config.population)]


def without_line_cycles(counters):
    """Return the counters in which board and model must agree."""
    return {name: count for name, count in counters.items() if name not in LINE_CYCLES}


class Pair:
    """A board and a model that get the same requests and must give the same replies."""

    def __init__(self, board, model, seed=1):
        assert board.config == model.config
        self.board, self.model = board, model
        self.config = board.config
        self.rng = random.Random(seed)
        self.paths = []

    def start(self, length=None):
        """Seed and load both, with limits that some new waypoints reach."""
        config, rng = self.config, self.rng
        seed = rng.getrandbits(64)
        highest = config.map_size - 1
        limits = (highest - highest // 8, highest, config.blocked_altitude - 1)
        for chip in (self.board, self.model):
            chip.start(seed, limits)
        self.load(0, random_paths(config, rng, length))

    def load(self, slot, paths):
        """Write ``paths`` to both, starting at ``slot``."""
        for chip in (self.board, self.model):
            chip.load(paths, slot)
        self.paths[slot : slot + len(paths)] = paths

    def step(self, mode=LinkMode.RANK):
        """Run a generation with a random ranking; compare the replies."""
        order = self.rng.sample(range(self.config.population), self.config.population)
        done, expected = self.board.step(order, mode), self.model.step(order, mode)
        assert done == expected, (mode, order)
        self.paths = list(done.paths)
        return done

    def lengthen(self):
        """Lengthen to the maximum every path that a deletion has shortened."""
        full = self.config.max_waypoints
        for slot, path in enumerate(self.paths):
            if len(path) < full:
                self.load(slot, [path + path[: full - len(path)]])

    def check(self):
        """Compare populations, status and counters; return the board's counters."""
        count = self.config.population
        assert self.board.read(0, count) == self.model.read(0, count) == self.paths
        assert self.board.status() == self.model.status()
        counters = self.board.counters()
        assert without_line_cycles(counters) == without_line_cycles(self.model.counters())
        return counters
