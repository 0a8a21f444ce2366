"""Fixed fields of every request and every reply."""

from __future__ import annotations

from hdl.config import CheckerBuild, Config, SurvivorSelection
from hdl.protocol.codec import VERSION
from hdl.protocol.codes import Counter, LinkMode
from hdl.protocol.layout import Layout, numbered
from hdl.protocol.random_words import SEED_BITS


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
    "open_request",
    "path_record",
    "read_request",
    "recipe_reply",
    "results_request",
    "start_request",
    "status_reply",
    "survivors_reply",
    "write_request",
]

#: Checkers in the order of their numbers in :func:`info_reply`. Number 3 was a build that is gone:
#: it stays unused.
_CHECKERS = (CheckerBuild.NONE, CheckerBuild.TWO_TIER, CheckerBuild.PARALLEL)


def open_request(config: Config) -> Layout:
    """Nothing: the session is in the header."""
    return Layout(())


def start_request(config: Config) -> Layout:
    """Seed of the random source, highest values of new waypoints, whether to keep off the ground.

    ``avoid_ground``, of a chip with a checker only: a new waypoint in the ground is drawn again,
    then left out.
    """
    return Layout(
        (("seed", SEED_BITS), ("x", 16), ("y", 16), ("altitude", 16), ("avoid_ground", 1))
    )


def write_request(config: Config) -> Layout:
    """First slot; the waypoints of one or more paths follow."""
    return Layout((("slot", 8),))


def read_request(config: Config) -> Layout:
    """First slot and number of slots, 1 or more."""
    return Layout((("slot", 8), ("count", 8)))


def generate_request(config: Config, mode: LinkMode) -> Layout:
    """Link mode; in the modes that need it, the slots from the best path to the worst."""
    order = () if mode is LinkMode.POPULATION else numbered("slot", config.population, 8)
    return Layout((("mode", 8), *order))


def map_request(config: Config) -> Layout:
    """South-western cell and size of a rectangle; its cells follow row by row from the south."""
    return Layout((("x", 16), ("y", 16), ("width", 16), ("height", 16)))


def check_request(config: Config) -> Layout:
    """:class:`CheckFlag`; the points follow, 2 to ``max_waypoints + 2`` of them."""
    return Layout((("flags", 8),))


def check_paths_request(config: Config) -> Layout:
    """First slot, number of slots, 1 or more, :class:`CheckFlag`, and both ends of every path."""
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
    """First path of the latest check, 0 its first, and number of paths, 1 or more."""
    return Layout((("path", 8), ("count", 8)))


def info_reply(config: Config) -> Layout:
    """Version and build first: these two never move. Then the configuration."""
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
            ("genetic", 8),
            ("checker", 8),
            ("lanes", 8),
            ("memory_latency", 8),
            ("redraws", 8),
        )
    )


def info_values(config: Config) -> dict[str, int]:
    """Return every field of :func:`info_reply` but the session, which the chip fills in."""
    fields = {name for name, _ in info_reply(config).fields}
    values = {name: getattr(config, name) for name in fields if hasattr(config, name)}
    return values | {
        "version": VERSION,
        "rank_survivors": int(config.survivor_selection is SurvivorSelection.RANK),
        "checker": _CHECKERS.index(config.checker),
    }


def config_from_info(values: dict[str, int]) -> Config:
    """Return the configuration that :func:`info_reply`'s ``values`` describe.

    Raises
    ------
    ValueError
        If there is none.
    """
    names = set(values) - {"version", "build_id", "session", "rank_survivors", "checker"}
    if values["checker"] >= len(_CHECKERS):
        raise ValueError(f"Checker must be below {len(_CHECKERS)}, not {values['checker']}")
    return Config(
        survivor_selection=(
            SurvivorSelection.RANK if values["rank_survivors"] else SurvivorSelection.UNIFORM
        ),
        checker=_CHECKERS[values["checker"]],
        **{name: values[name] for name in names},
    )


def status_reply(config: Config) -> Layout:
    """State, the eight latest states (4 bits each, the latest lowest), errors and last clocks.

    ``crossover``, ``mutation`` and ``update`` are the clocks of the latest generation.
    """
    return Layout(
        (
            ("state", 8),
            ("history", 32),
            ("errors", 8),
            ("generation", 32),
            ("crossover", 16),
            ("mutation", 16),
            ("update", 16),
        )
    )


def counters_reply(config: Config) -> Layout:
    """Every :class:`Counter`, 48 bits each.

    Each is whole; those that count on while the answer is made are some clocks apart. The bytes
    sent are those before this answer.
    """
    return Layout(tuple((counter.value, 48) for counter in Counter))


def survivors_reply(config: Config) -> Layout:
    """What stands before the children in :data:`LinkMode.RANK`: the survivors' former slots."""
    return Layout(numbered("survivor", config.survivors, 8))


def recipe_reply(config: Config) -> Layout:
    """What a generation did, and the CRC-32 of the new population.

    ``parent`` and ``survivor`` are slots before the update. Of each mutator: whether it was
    applied, its child, and its waypoint's index; of each that makes one, the new waypoint.
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
    """Totals of a check: clocks of the checker, addresses given to the map, cells checked."""
    return Layout((("cycles", 32), ("reads", 32), ("cells", 32)))


def path_record(config: Config) -> Layout:
    """Result of a path: whether it collides, and how many :func:`entry_record` end its result."""
    return Layout((("collision", 1), ("entries", 7)))


def hit_record(config: Config) -> Layout:
    """What follows :func:`path_record` if the path collides: segment and cell that hit first.

    ``x`` and ``y`` are in cells of the map that hit, the coarse one if ``coarse``; ``cells`` are
    those checked from the path's first to this one.
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
    """Colliding cells of one segment: those of terrain, and blocked ones."""
    return Layout(
        (
            ("segment", config.segment_bits),
            ("terrain", config.segment_cells_bits),
            ("nofly", config.segment_cells_bits),
        )
    )
