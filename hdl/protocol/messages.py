"""Fixed fields of every request and every reply, as functions of the configuration."""

from __future__ import annotations

from pathgene.hdl.config import CheckerBuild, Config, GeneticCore, SurvivorSelection
from pathgene.hdl.protocol.codec import VERSION
from pathgene.hdl.protocol.codes import COUNTER_BITS, UNITS, Counter, LinkMode
from pathgene.hdl.protocol.layout import Layout, numbered
from pathgene.hdl.protocol.random_words import SEED_BITS


__all__ = [
    "check_paths_request",
    "check_reply",
    "check_request",
    "config_from_info",
    "counters_reply",
    "entry_record",
    "generate_request",
    "hit_record",
    "info_reply",
    "info_values",
    "map_request",
    "path_record",
    "read_request",
    "recipe_reply",
    "results_request",
    "start_request",
    "status_reply",
    "survivors_reply",
    "write_request",
]

#: Checkers in the order of their numbers in :func:`info_reply`. Number 3 was a build that has been
#: removed: it stays unused.
_CHECKERS = (CheckerBuild.NONE, CheckerBuild.TWO_TIER, CheckerBuild.PARALLEL)
#: Genetic cores in the order of their numbers there.
_CORES = (GeneticCore.NONE, GeneticCore.PAPER, GeneticCore.PLANNER)


def start_request(config: Config) -> Layout:
    """Return the seed of the random source, and the limits and treatment of new waypoints.

    ``x``, ``y`` and ``altitude`` are the highest values of a new waypoint. With ``avoid_ground``,
    which needs a checker, a new waypoint in the ground is drawn again; if no draw is above the
    ground, the mutation is left out.
    """
    return Layout(
        (("seed", SEED_BITS), ("x", 16), ("y", 16), ("altitude", 16), ("avoid_ground", 1))
    )


def write_request(config: Config) -> Layout:
    """Return the first slot; the waypoints of one or more paths follow."""
    return Layout((("slot", 8),))


def read_request(config: Config) -> Layout:
    """Return the first slot and the number of slots, 1 or more."""
    return Layout((("slot", 8), ("count", 8)))


def generate_request(config: Config, mode: LinkMode) -> Layout:
    """Return the link mode and, in all modes but POPULATION, the slots from best to worst."""
    order = () if mode is LinkMode.POPULATION else numbered("slot", config.population, 8)
    return Layout((("mode", 8), *order))


def map_request(config: Config) -> Layout:
    """Return the south-western cell and the size of a rectangle; its cells follow by rows."""
    return Layout((("x", 16), ("y", 16), ("width", 16), ("height", 16)))


def check_request(config: Config) -> Layout:
    """Return the :class:`CheckFlag`; the points follow, 2 to ``max_waypoints + 2`` of them."""
    return Layout((("flags", 8),))


def check_paths_request(config: Config) -> Layout:
    """Return the slots to check, :class:`CheckFlag`, and the two ends that all paths share."""
    return Layout(
        (
            ("slot", 8),
            ("count", 8),
            ("flags", 8),
            ("start", config.waypoint_bits),
            ("goal", config.waypoint_bits),
        )
    )


def results_request(config: Config) -> Layout:
    """Return the first path, 0 for the first of the latest check, and the number of paths."""
    return Layout((("path", 8), ("count", 8)))


def info_reply(config: Config) -> Layout:
    """Return version and build, whose place never changes, the session, then the configuration."""
    return Layout(
        (
            ("version", 8),
            ("build_id", 32),
            ("session", 8),
            ("population", 16),
            ("children", 8),
            ("elites", 8),
            ("survivors", 8),
            ("perturbs", 8),
            ("inserts", 8),
            ("deletes", 8),
            ("max_waypoints", 8),
            ("map_size", 16),
            ("coarse_factor", 16),
            ("altitude_bits", 8),
            ("box_percent", 8),
            ("rank_survivors", 8),
            ("clock_hz", 32),
            ("clocks_per_bit", 16),
            ("receive_buffer", 16),
            ("core", 8),
            ("checker", 8),
            ("lanes", 8),
            ("memory_latency", 8),
            ("redraws", 8),
        )
    )


def info_values(config: Config) -> dict[str, int]:
    """Return the values of :func:`info_reply`, except for the session, which the chip fills in."""
    fields = {name for name, _ in info_reply(config).fields}
    values = {name: getattr(config, name) for name in fields if hasattr(config, name)}
    return values | {
        "version": VERSION,
        "rank_survivors": int(config.survivor_selection is SurvivorSelection.RANK),
        "core": _CORES.index(config.core),
        "checker": _CHECKERS.index(config.checker),
    }


def config_from_info(values: dict[str, int]) -> Config:
    """Return the configuration that :func:`info_reply`'s ``values`` describe.

    Raises
    ------
    ValueError
        If no configuration has these values.
    """
    apart = {"version", "build_id", "session", "rank_survivors", "core", "checker"}
    for name, designs in (("core", _CORES), ("checker", _CHECKERS)):
        if values[name] >= len(designs):
            raise ValueError(f"{name.title()} must be below {len(designs)}, not {values[name]}")
    return Config(
        survivor_selection=(
            SurvivorSelection.RANK if values["rank_survivors"] else SurvivorSelection.UNIFORM
        ),
        core=_CORES[values["core"]],
        checker=_CHECKERS[values["checker"]],
        **{name: values[name] for name in set(values) - apart},
    )


def status_reply(config: Config) -> Layout:
    """Return the state, the eight latest states, the sticky errors, and what a core has done.

    ``history`` holds 4 bits for each state, the latest lowest. ``crossover``, ``mutation`` and
    ``update`` are cycles of the latest generation.

    A chip with the planner core has fields of the latest run instead: ``running``, 1 until the run
    is over; its ``cycles``; the ``key`` of its best path so far, in the form of
    :data:`pathgene.hdl.protocol.planner.VALUE_BITS`; and cycles of its units. ``generation`` counts
    those of the run. Fields are consistent in themselves, and final where ``running`` is 0.
    """
    latest = (("crossover", 16), ("mutation", 16), ("update", 16))
    run = (("running", 8), ("cycles", 32), ("key", 32), *((unit, 32) for unit in UNITS))
    return Layout(
        (
            ("state", 8),
            ("history", 32),
            ("errors", 8),
            ("generation", 32),
            *(run if config.planner_core else latest),
        )
    )


def counters_reply(config: Config) -> Layout:
    """Return every :class:`Counter`, 48 bits each.

    Each counter is consistent in itself; counters that run while the answer is made are read some
    cycles apart. The bytes sent do not include this answer.
    """
    return Layout(tuple((counter.value, COUNTER_BITS) for counter in Counter))


def survivors_reply(config: Config) -> Layout:
    """Return the survivors' former slots, which precede the children in :data:`LinkMode.RANK`."""
    return Layout(numbered("survivor", config.survivors, 8))


def recipe_reply(config: Config) -> Layout:
    """Return the choices of a generation, and the CRC-32 of the new population.

    ``parent`` and ``survivor`` are slots before the update. Each mutator has a flag that says
    whether its mutation was applied, its child, and the index of the waypoint; a mutator that makes
    a waypoint has the new waypoint, too. See :class:`pathgene.hdl.protocol.breeding.Recipe`.
    """
    mutations: list[tuple[str, int]] = []
    for i in range(config.mutators):
        mutations += [
            (f"applied_{i}", 1),
            (f"child_{i}", config.child_bits),
            (f"index_{i}", config.index_bits),
        ]
    return Layout(
        (
            *numbered("parent", config.crossovers, config.slot_bits),
            *numbered("survivor", config.survivors, config.slot_bits),
            *mutations,
            *numbered("waypoint", config.patches, config.waypoint_bits),
            ("checksum", 32),
        )
    )


def check_reply(config: Config) -> Layout:
    """Return the totals of a check: cycles of the checker, reads of the map, cells checked."""
    return Layout((("cycles", 32), ("reads", 32), ("cells", 32)))


def path_record(config: Config) -> Layout:
    """Return the collision flag of a path and the number of :func:`entry_record` in its result."""
    return Layout((("collision", 1), ("entries", 7)))


def hit_record(config: Config) -> Layout:
    """Return the first colliding segment and cell, which follow :func:`path_record` of a collision.

    ``x`` and ``y`` count cells of the map that the cell belongs to, the coarse map if ``coarse``.
    ``cells`` are the cells checked, from the first cell of the path to the colliding one.
    """
    return Layout(
        (
            ("segment", config.segment_bits),
            ("coarse", 1),
            ("x", config.coordinate_bits),
            ("y", config.coordinate_bits),
            ("cells", config.path_cells_bits),
        )
    )


def entry_record(config: Config) -> Layout:
    """Return the colliding cells of one segment: those of terrain, and blocked ones."""
    return Layout(
        (
            ("segment", config.segment_bits),
            ("terrain", config.segment_cells_bits),
            ("nofly", config.segment_cells_bits),
        )
    )
