"""The single definition of every size and width, for gateware, software model and host.

The module is pure Python, so that a host without Amaranth can import it.
"""

from __future__ import annotations

import dataclasses
import enum
import functools
import hashlib
import json
from dataclasses import dataclass
from typing import Any


__all__ = [
    "LINE_BITS",
    "CheckerBuild",
    "Config",
    "GeneticCore",
    "MutationKind",
    "SurvivorSelection",
]

#: Bits of a byte on the line of a UART: start, eight data bits, stop.
LINE_BITS = 10


class MutationKind(enum.IntEnum):
    """Kind of a mutator: its change to a child (*allaire-2008*, sections 3.4 and 4.6)."""

    #: Move one waypoint within the box around it.
    PERTURB = 0
    #: Add a waypoint after a waypoint of the path, within the box around it.
    INSERT = 1
    #: Remove one waypoint.
    DELETE = 2


class SurvivorSelection(enum.StrEnum):
    """Draw of survivors among the non-elite parents, without replacement."""

    #: Every choice equally likely.
    UNIFORM = "uniform"
    #: Linear ranking among the remaining ones: the better of two uniform draws.
    RANK = "rank"


class GeneticCore(enum.StrEnum):
    """Design of the genetic core."""

    #: No core: the chip only checks paths.
    NONE = "none"
    #: The paper core: all crossovers of a generation in lockstep; the host evaluates and sorts.
    PAPER = "paper"
    #: The planner core: children stream through breeding, scoring and sorting; a run needs no host.
    PLANNER = "planner"


class CheckerBuild(enum.StrEnum):
    """Design of the checker of paths against the map (*allaire two-tier*)."""

    #: No map on the chip.
    NONE = "none"
    #: Checker of the paper: one cell per cycle, two segments in the detailed map, the rest in the
    #: coarse map.
    TWO_TIER = "two-tier"
    #: Every segment in the detailed map, several cells per cycle.
    PARALLEL = "parallel"


#: Placeholder for a default that depends on the genetic core. A configuration has the actual value.
_BY_CORE: Any = None


@dataclass(frozen=True, kw_only=True)
class Config:
    """Sizes of the chip, immutable and consistent: the constructor rejects wrong values.

    Parameters
    ----------
    population : int
        Paths in the population; a power of two, 4..256.
    children : int
        Paths bred in each generation, two by each crossover module.
    elites : int
        Best parents kept unconditionally, 1 or more.
    survivors : int
        Other parents kept, drawn at random.
    perturbs, inserts, deletes : int
        Number of mutators of each kind; each works on a different child.
    max_waypoints : int
        Transitional waypoints of the longest path, 3..64; the shortest has 2. By default 16, as in
        *allaire-2008*, and 24 with the planner core.
    map_size : int
        Cells along each edge of the map, a power of two, 8..4096.
    coarse_factor : int
        Detailed cells along the edge of a coarse cell, a power of two below ``map_size``.
    altitude_bits : int
        Width of an altitude, 4..16. The top value marks ground that no path may cross.
    box_percent : int
        Edge of the mutation box in percent of the map's edge (*allaire-2008*, section 3.4.1).
    survivor_selection : SurvivorSelection
        How survivors are drawn: uniformly or by rank.
    core : GeneticCore
        Design of the genetic core, or none. A chip without a core only checks paths; it ignores the
        fields up to ``deletes``, ``box_percent`` and ``survivor_selection``. The planner core
        ignores ``perturbs`` to ``deletes``, ``coarse_factor``, ``survivor_selection`` and
        ``redraws``; its population is at most 32.
    checker : CheckerBuild
        Design of the checker, or none. A chip without a genetic core has a checker; the planner
        core needs the parallel one. The fields from here to ``redraws`` only matter on a chip with
        a checker.
    lanes : int
        Cells checked each cycle: 1, 2, 4, 8 or 16; 1 in the two-tier build.
    memory_latency : int
        Cycles from an address to the data of the map's memory, 1 or 2.
    redraws : int
        Maximum repeated draws of a new waypoint that lies in the ground, 0..7.
    point_cycles : int
        Cycles of a point of a path in the scorer, 1 or 2: with 2 it needs about half of the
        multipliers. Only matters with the planner core.
    clock_hz : int
        Clock of the chip in hertz, reported to the host.
    clocks_per_bit : int
        UART divisor: cycles per bit, 4..65535; 0 for a byte-wide port instead of the UART.
    receive_buffer : int
        Bytes of received frames that the chip can hold, a power of two, 256..32768: the maximum of
        unacknowledged request bytes.

    Raises
    ------
    TypeError
        If a field has the wrong type.
    ValueError
        If a field breaks its rule; the message names both.
    """

    population: int = 32
    children: int = 22
    elites: int = 2
    survivors: int = 8
    perturbs: int = 1
    inserts: int = 2
    deletes: int = 2
    max_waypoints: int = _BY_CORE
    map_size: int = 512
    coarse_factor: int = 16
    altitude_bits: int = 12
    box_percent: int = 15
    survivor_selection: SurvivorSelection = SurvivorSelection.UNIFORM
    core: GeneticCore = GeneticCore.PAPER
    checker: CheckerBuild = CheckerBuild.PARALLEL
    lanes: int = 8
    memory_latency: int = 2
    redraws: int = 2
    point_cycles: int = 1
    clock_hz: int = 100_000_000
    clocks_per_bit: int = 33
    receive_buffer: int = 2048

    #: Minimum transitional waypoints of a path (*allaire-2008*, section 3.1).
    MIN_WAYPOINTS = 2
    #: Segments of a path that the two-tier build checks in the detailed map.
    DETAILED_SEGMENTS = 2

    def __post_init__(self) -> None:
        if self.max_waypoints is _BY_CORE:
            object.__setattr__(self, "max_waypoints", _longest(self.core))
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if field.name in _CHOICES:
                choices = _CHOICES[field.name]
                *others, last = choices
                self._check(field.name, f"{', '.join(others)} or {last}", value in list(choices))
                object.__setattr__(self, field.name, choices(value))
            elif not isinstance(value, int) or isinstance(value, bool):
                raise TypeError(f"Config.{field.name} must be an integer, not {value!r}")

        self._check(
            "population", "a power of two from 4 to 256", _is_power(self.population, 4, 256)
        )
        self._check(
            "children", "even and at least 4", self.children >= 4 and self.children % 2 == 0
        )
        self._check("elites", "at least 1", self.elites >= 1)
        self._check("survivors", "at least 1", self.survivors >= 1)
        total = self.elites + self.survivors + self.children
        self._check(
            "population",
            f"elites + survivors + children = {total}",
            self.population == total,
        )
        for name in ("perturbs", "inserts", "deletes"):
            self._check(name, "at least 1", getattr(self, name) >= 1)
        self._check(
            "children",
            f"at least perturbs + inserts + deletes = {self.mutators}",
            self.children >= self.mutators,
        )
        self._check("max_waypoints", "from 3 to 64", 3 <= self.max_waypoints <= 64)
        self._check("map_size", "a power of two from 8 to 4096", _is_power(self.map_size, 8, 4096))
        self._check(
            "coarse_factor",
            "a power of two from 2 to map_size / 2",
            _is_power(self.coarse_factor, 2, self.map_size // 2),
        )
        self._check("altitude_bits", "from 4 to 16", 4 <= self.altitude_bits <= 16)
        self._check("box_percent", "from 1 to 100", 1 <= self.box_percent <= 100)
        if self.core is GeneticCore.NONE:
            self._check(
                "core",
                "paper on a chip without a checker",
                self.checker is not CheckerBuild.NONE,
            )
        if self.planner_core:
            self._check(
                "checker", "parallel with the planner core", self.checker is CheckerBuild.PARALLEL
            )
            self._check("population", "at most 32 with the planner core", self.population <= 32)
            self._check(
                "survivors",
                "at most the children with the planner core",
                self.survivors <= self.children,
            )
        self._check("lanes", "1, 2, 4, 8 or 16", _is_power(self.lanes, 1, 16))
        if self.checker is CheckerBuild.TWO_TIER:
            self._check("lanes", "1 in the two-tier build", self.lanes == 1)
        if self.checker is not CheckerBuild.NONE:
            self._check("lanes", f"at most map_size = {self.map_size}", self.lanes <= self.map_size)
        self._check("memory_latency", "1 or 2", 1 <= self.memory_latency <= 2)
        self._check("redraws", "from 0 to 7", 0 <= self.redraws <= 7)
        self._check("point_cycles", "1 or 2", 1 <= self.point_cycles <= 2)
        self._check("clock_hz", "from 1 to 4294967295", 1 <= self.clock_hz < 1 << 32)
        self._check(
            "clocks_per_bit",
            "from 4 to 65535, or 0 for a byte-wide port",
            4 <= self.clocks_per_bit < 1 << 16 or not self.has_uart,
        )
        self._check(
            "receive_buffer",
            "a power of two from 256 to 32768",
            _is_power(self.receive_buffer, 256, 32768),
        )

    def _check(self, name: str, rule: str, holds: bool) -> None:
        if not holds:
            value = getattr(self, name)
            shown = str(value) if isinstance(value, enum.Enum) else repr(value)
            raise ValueError(f"Config.{name} must be {rule}, not {shown}")

    @property
    def paper_core(self) -> bool:
        """The chip has the paper core: the genetic core of *allaire-2008*."""
        return self.core is GeneticCore.PAPER

    @property
    def planner_core(self) -> bool:
        """The chip has the planner core, which plans without the host."""
        return self.core is GeneticCore.PLANNER

    @property
    def has_uart(self) -> bool:
        """The chip has a UART, not a byte-wide port."""
        return self.clocks_per_bit != 0

    @property
    def byte_cycles(self) -> int:
        """Cycles of a byte on the line; a byte-wide port takes one in each cycle."""
        return LINE_BITS * self.clocks_per_bit if self.has_uart else 1

    @property
    def checks_paths(self) -> bool:
        """The chip has a checker that checks the paths of a host, or of the paper core."""
        return self.checker is not CheckerBuild.NONE and not self.planner_core

    @property
    def crossovers(self) -> int:
        """Crossover modules; as many parents are drawn, and each is used twice."""
        return self.children // 2

    @property
    def mutations(self) -> tuple[MutationKind, ...]:
        """Kind of every mutator, in port order."""
        return (
            (MutationKind.PERTURB,) * self.perturbs
            + (MutationKind.INSERT,) * self.inserts
            + (MutationKind.DELETE,) * self.deletes
        )

    @property
    def mutators(self) -> int:
        """Mutators of all kinds."""
        return self.perturbs + self.inserts + self.deletes

    @property
    def patches(self) -> int:
        """Mutators that make a new waypoint: the perturbing ones, then the inserting ones."""
        return self.perturbs + self.inserts

    @property
    def slot_bits(self) -> int:
        """Width of a slot number and of a rank."""
        return (self.population - 1).bit_length()

    @property
    def child_bits(self) -> int:
        """Width of the number of a child."""
        return (self.children - 1).bit_length()

    @property
    def length_bits(self) -> int:
        """Width of a number of waypoints."""
        return self.max_waypoints.bit_length()

    @property
    def index_bits(self) -> int:
        """Width of the position of a waypoint in its path."""
        return (self.max_waypoints - 1).bit_length()

    @property
    def head_size(self) -> int:
        """Maximum number of waypoints that a child takes from before the middle of a parent."""
        return self.max_waypoints // 2

    @property
    def coordinate_bits(self) -> int:
        """Width of x and of y, in cells."""
        return (self.map_size - 1).bit_length()

    @property
    def waypoint_bits(self) -> int:
        """Width of a waypoint: x in the lowest bits, then y, then the altitude."""
        return 2 * self.coordinate_bits + self.altitude_bits

    @property
    def waypoint_bytes(self) -> int:
        """Bytes of a waypoint on the link, its ``last`` flag included."""
        return (self.waypoint_bits + 1 + 7) // 8

    @property
    def checked_paths(self) -> int:
        """Maximum paths of one check: the population's, if there is one."""
        return self.population if self.paper_core else 1

    @property
    def max_segments(self) -> int:
        """Segments of the longest path, from the aircraft to the goal."""
        return self.max_waypoints + 1

    @property
    def segment_bits(self) -> int:
        """Width of the number of a segment, 0 the first."""
        return (self.max_segments - 1).bit_length()

    @property
    def segment_cells_bits(self) -> int:
        """Width of a number of cells of one segment, 0..map_size."""
        return self.coordinate_bits + 1

    @property
    def path_cells_bits(self) -> int:
        """Width of a number of cells of one path."""
        return (self.max_segments * self.map_size).bit_length()

    @property
    def coarse_bits(self) -> int:
        """Width of x and of y in coarse cells."""
        return self.coordinate_bits - (self.coarse_factor - 1).bit_length()

    @property
    def blocked_altitude(self) -> int:
        """Altitude that marks ground that no path may cross; a waypoint is always below it."""
        return (1 << self.altitude_bits) - 1

    @property
    def box_cells(self) -> int:
        """Half the edge of the mutation box in cells; x and y move by at most this."""
        return max(1, self.map_size * self.box_percent // 200)

    @property
    def box_steps(self) -> int:
        """Half the height of the mutation box in altitude steps."""
        return max(1, (1 << self.altitude_bits) * self.box_percent // 200)

    @property
    def candidates(self) -> int:
        """Draws of each new waypoint: the first and, with a map, the redraws."""
        return 1 if self.checker is CheckerBuild.NONE else 1 + self.redraws

    @property
    def lookup_latency(self) -> int:
        """Cycles from a cell's x and y to its altitude in the checker's map.

        The latency of the memory, one register before it, and one after the multiplexer of its
        banks.
        """
        return self.memory_latency + 2

    @property
    def count_places(self) -> int:
        """Counts of segments that the checker can hold, a power of two.

        There is room for one count of each segment of a path, and for all one-cell segments that
        can be in flight in a walker.
        """
        return max(16, 1 << (self.max_segments - 1).bit_length())

    @property
    def draw_steps(self) -> int:
        """Steps of the random source per generation: see ``Draws``."""
        mutation = self.mutators + self.patches * self.candidates
        return max(self.crossovers, self.survivors, mutation)

    @functools.cached_property
    def build_id(self) -> int:
        """32-bit fingerprint of all fields, by which a host recognizes a chip built from them."""
        fields = dataclasses.asdict(self)
        # A chip keeps the fingerprint that it was built with, even if its core is renamed later.
        core = fields.pop("core")
        fields["genetic"] = "streaming" if self.planner_core else core is GeneticCore.PAPER
        packed = json.dumps(fields, sort_keys=True)
        return int.from_bytes(hashlib.sha256(packed.encode()).digest()[:4], "little")

    def replace(self, **changes: object) -> Config:
        """Return a copy with ``changes``, checked like any configuration.

        If ``core`` changes, a default ``max_waypoints`` becomes the default of the new core.
        """
        if "core" in changes and self.max_waypoints == _longest(self.core):
            changes.setdefault("max_waypoints", _BY_CORE)
        return dataclasses.replace(self, **changes)  # type: ignore[arg-type]  # Checked at once.


_CHOICES: dict[str, type[enum.StrEnum]] = {
    "survivor_selection": SurvivorSelection,
    "core": GeneticCore,
    "checker": CheckerBuild,
}


def _longest(core: object) -> int:
    """Return the default of ``max_waypoints``."""
    # A maze needs two waypoints for each of its walls.
    return 24 if core == GeneticCore.PLANNER else 16


def _is_power(value: int, low: int, high: int) -> bool:
    return low <= value <= high and value & (value - 1) == 0
