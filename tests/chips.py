"""Chips that several tests share, so that each is built once, and how two boards are compared."""

import dataclasses
import random
from urllib.parse import urlencode

from hdl.config import CheckerBuild, Config
from hdl.protocol import Counter, LinkMode


__all__ = [
    "CHECKERS",
    "CHECKER_BENCH",
    "CHECKING",
    "LINE_CYCLES",
    "SMALL",
    "TINY",
    "Pair",
    "board_url",
    "random_path",
    "random_paths",
    "without_line_cycles",
]

#: A chip that both simulators build and run in seconds: odd sizes, and a receive buffer that is
#: soon full.
SMALL = Config(
    population=8,
    children=4,
    survivors=2,
    inserts=1,
    deletes=1,
    max_waypoints=5,
    map_size=16,
    coarse_factor=4,
    altitude_bits=4,
    clocks_per_bit=4,
    receive_buffer=256,
    checker=CheckerBuild.NONE,
)

#: The same chip with the paper's checker: what the link does with one is the same for all of them.
CHECKING = SMALL.replace(checker=CheckerBuild.TWO_TIER, lanes=1)

#: The same chip with each build of the checker, by its name.
CHECKERS = {
    "two-tier": CHECKING,
    "parallel": SMALL.replace(checker=CheckerBuild.PARALLEL, lanes=4),
}

#: Chips for the bench of the checker alone: a larger map, longer paths.
_LARGER = Config(max_waypoints=6, map_size=64, coarse_factor=4, altitude_bits=6, lanes=4)
CHECKER_BENCH = {
    "two-tier": _LARGER.replace(checker=CheckerBuild.TWO_TIER, lanes=1),
    "parallel": _LARGER.replace(checker=CheckerBuild.PARALLEL),
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

#: Counters in which the model leaves out the few cycles that the chip takes per command.
LINE_CYCLES = (Counter.CYCLES, Counter.RECEIVE, Counter.TRANSMIT)


def board_url(scheme, config, **options):
    """Return the URL of ``scheme`` (``model`` or ``sim``) for a chip of ``config``."""
    fields = {
        field.name: int(value) if isinstance(value := getattr(config, field.name), bool) else value
        for field in dataclasses.fields(Config)
        if field.name == "clocks_per_bit" or getattr(config, field.name) != field.default
    }
    return f"{scheme}:?{urlencode(fields | options)}"


def random_path(config, rng, length=None):
    """Return a path of random waypoints, packed; of random length unless it is given."""
    length = length or rng.randint(config.MIN_WAYPOINTS, config.max_waypoints)
    return [rng.getrandbits(config.waypoint_bits) for _ in range(length)]


def random_paths(config, rng, length=None):
    """Return a population of :func:`random_path`."""
    return [random_path(config, rng, length) for _ in range(config.population)]


def without_line_cycles(counters):
    """Return what board and model must agree on of :meth:`host.device.chip.Chip.counters`."""
    return {name: count for name, count in counters.items() if name not in LINE_CYCLES}


class Pair:
    """Two chips that are told the same and must say the same.

    Parameters
    ----------
    board, model : host.device.chip.Chip
    seed : int
        Of everything random.
    """

    def __init__(self, board, model, seed=1):
        assert board.config == model.config
        self.board, self.model = board, model
        self.config = board.config
        self.rng = random.Random(seed)
        self.paths = []

    def start(self, length=None):
        """Seed both, with limits that some new waypoints meet, and load both."""
        config, rng = self.config, self.rng
        seed = rng.getrandbits(64)
        highest = config.map_size - 1
        limits = (highest - highest // 8, highest, config.blocked_altitude - 1)
        for chip in (self.board, self.model):
            chip.start(seed, limits)
        self.load(0, random_paths(config, rng, length))

    def load(self, slot, paths):
        """Write ``paths`` from ``slot`` on, in both."""
        for chip in (self.board, self.model):
            chip.load(paths, slot)
        self.paths[slot : slot + len(paths)] = paths

    def step(self, mode=LinkMode.RANK):
        """Run one generation on a random order; compare all that is answered."""
        order = self.rng.sample(range(self.config.population), self.config.population)
        done, expected = self.board.step(order, mode), self.model.step(order, mode)
        assert done == expected, (mode, order)
        self.paths = list(done.paths)
        return done

    def check(self):
        """Compare what both chips hold and have counted; return the board's counters."""
        count = self.config.population
        assert self.board.read(0, count) == self.model.read(0, count) == self.paths
        assert self.board.status() == self.model.status()
        counters = self.board.counters()
        assert without_line_cycles(counters) == without_line_cycles(self.model.counters())
        return counters
