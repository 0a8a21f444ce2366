"""A run, compiled: :func:`sim.model.planner.definition.run.plan`, bit for bit."""

from __future__ import annotations

import numpy as np

from hdl.config import Config
from hdl.protocol.planner import BLOCKS, ProblemRecord
from hdl.protocol.runs import RETURNED, Outcome, Population, RunOptions
from sim.model.planner.breeder import breed
from sim.model.planner.compiled import compiled
from sim.model.planner.cycles import VISITS_PER_PASS
from sim.model.planner.definition.score import corner_of
from sim.model.planner.definition.warm import ahead
from sim.model.planner.evaluation import (
    CYCLES,
    GENERATIONS,
    GIVEN_UP,
    NO_LIMIT,
    PLACES,
    evaluate,
    settle,
)
from sim.model.planner.memo import empty_memo
from sim.model.planner.problem import (
    BLOCK_SHIFT,
    BLOCKED,
    CHILDREN,
    ELITES,
    POPULATION,
    SURVIVORS,
    problem_vector,
    sizes_vector,
)
from sim.model.planner.random_words import Words, source
from sim.model.planner.score import WORK_ROWS
from sim.model.planner.seeds import lift, seed_path
from sim.model.planner.walk import Ground, Integers
from sim.model.planner.wavefront import (
    LEAST,
    MEAN,
    descend,
    limit_slopes,
    measure_blocks,
    measure_distances,
    spread,
)


__all__ = ["plan"]

#: Places of the options.
_CYCLES, _GENERATIONS, _GIVE_UP_RANK, _SEEDS, _LIFTS, _SHARE = range(6)


def plan(
    config: Config,
    ground: Ground,
    record: ProblemRecord,
    options: RunOptions,
    population: Population | None = None,
) -> Outcome:
    """Plan a path: see :func:`sim.model.planner.definition.run.plan`."""
    options.check(config, population)
    numbers = (
        options.cycles,
        options.generations,
        options.give_up_rank,
        options.seeds,
        options.lifts,
        options.share,
    )
    islands = [(MEAN if island.mean else LEAST, island.slope) for island in options.islands]
    # Room for a generation beside the population, and for a seed beside the best.
    slots = config.population + config.children
    shape = len(islands) + (population is not None), slots
    paths = np.zeros((*shape, config.max_waypoints + 2, 4), dtype=np.int64)
    points = np.zeros(shape, dtype=np.int64)
    keys = np.zeros(shape, dtype=np.int64)
    order = np.zeros((shape[0], slots + 1), dtype=np.int64)
    counters = np.zeros(PLACES, dtype=np.int64)
    start, goal = corner_of(record, "start"), corner_of(record, "goal")
    for slot, path in enumerate(population or ()):
        rows = [start, *ahead(config, record, path), goal]
        paths[0, slot, : len(rows), :3], points[0, slot] = rows, len(rows)
    _run(
        problem_vector(config, record),
        sizes_vector(config, options.memo),
        np.array(numbers, dtype=np.int64),
        np.array(islands, dtype=np.int64).reshape(-1, 2),
        ground,
        np.array([*start, *goal], dtype=np.int64),
        source(options.seed),
        empty_memo(options.memo),
        counters,
        paths,
        points,
        keys,
        order,
    )
    best: dict[int, list[tuple[int, int, int]]] = {}
    last = []
    for slot in order[0, : config.population].tolist():
        waypoints = paths[0, slot, 1 : points[0, slot] - 1, :3].tolist()
        last.append([(x, y, z) for x, y, z in waypoints])
        best.setdefault(int(keys[0, slot]), last[-1])
    return Outcome(
        list(best.values())[:RETURNED],
        list(best)[:RETURNED],
        int(counters[GENERATIONS]),
        int(counters[CYCLES]),
        last,
    )


@compiled
def _run(
    problem: Integers,
    sizes: Integers,
    options: Integers,
    islands: Integers,
    ground: Ground,
    ends: Integers,
    words: Words,
    memo: Integers,
    counters: Integers,
    paths: Integers,
    points: Integers,
    keys: Integers,
    order: Integers,
) -> None:
    """Do the run; the population is in island 0 afterwards, ``order`` its slots from the best.

    Parameters
    ----------
    problem, sizes, options, ends, counters : (n,) int64
    islands : (islands, 2) int64
        Layer of the blocks, and slope, of each that is seeded. There is an island more in ``paths``
        on a warm start, the first, whose paths are there.
    ground : (map_size, map_size) uint16
    words : Words
    memo : (rows, 4) int64
    paths : (islands, slots, points, 4) int64
    points, keys : (islands, slots) int64
    order : (islands, slots + 1) int64
    """
    work = np.zeros((WORK_ROWS, paths.shape[2] + 2), dtype=np.int64)
    spare = np.zeros((4, paths.shape[1] + 1), dtype=np.int64)
    blocks = np.zeros((4, BLOCKS, BLOCKS), dtype=np.int64)
    surface = np.zeros((BLOCKS, BLOCKS), dtype=np.int64)
    field = np.zeros((BLOCKS, BLOCKS), dtype=np.int64)
    route = np.zeros((BLOCKS * BLOCKS, 2), dtype=np.int64)
    distances = np.zeros(3, dtype=np.int64)
    measure_distances(problem, distances)
    measure_blocks(problem, ground, sizes[BLOCKED], ends, blocks)
    shift = problem[BLOCK_SHIFT]
    start = (ends[1] >> shift) * BLOCKS + (ends[0] >> shift)
    goal = (ends[4] >> shift) * BLOCKS + (ends[3] >> shift)

    population, count = sizes[POPULATION], len(paths)
    warm = count - len(islands)
    if warm:
        for slot in range(population):
            keys[0, slot] = evaluate(
                problem, sizes, ground, ends, memo, counters, work, paths[0, slot], points[0, slot],
                NO_LIMIT, False,
            )  # fmt: skip
            _place(order[0], keys[0], slot, slot)
        settle(counters)
    for i in range(warm, count):
        layer, slope = islands[i - warm, 0], islands[i - warm, 1]
        surface[:] = blocks[layer]
        if slope:
            passes = limit_slopes(problem, distances, surface, slope)
            counters[CYCLES] += passes * VISITS_PER_PASS
        passes = spread(problem, distances, surface, goal, field)
        counters[CYCLES] += passes * VISITS_PER_PASS
        length = descend(problem, distances, surface, field, start, goal, route)
        used = 0
        for seed in range(options[_SEEDS]):
            # The slot of the worst path but the first seeds' own.
            slot = seed if seed <= population else order[i, population]
            path = paths[i, slot]
            points[i, slot] = seed_path(
                problem, sizes, ends, blocks, surface, route, length, words, path
            )
            for _ in range(options[_LIFTS]):
                if not lift(
                    problem, sizes, ground, ends, memo, counters, path, points[i, slot], spare[0]
                ):
                    break
            keys[i, slot] = evaluate(
                problem, sizes, ground, ends, memo, counters, work, path, points[i, slot],
                NO_LIMIT, False,
            )  # fmt: skip
            used = _place(order[i], keys[i], slot, min(used, population))
        settle(counters)

    if count > 1:
        parts = 16 * count
        cycles = max(options[_CYCLES] - counters[CYCLES], 0) * options[_SHARE] // parts
        generations = options[_GENERATIONS] * options[_SHARE] // parts
        for i in range(count):
            _evolve(
                problem, sizes, options, ground, ends, words, memo, counters, work, spare,
                paths[i], points[i], keys[i], order[i],
                counters[CYCLES] + cycles, counters[GENERATIONS] + generations,
            )  # fmt: skip
        _merge(paths, points, keys, order, population)
    _evolve(
        problem, sizes, options, ground, ends, words, memo, counters, work, spare,
        paths[0], points[0], keys[0], order[0], options[_CYCLES], options[_GENERATIONS],
    )  # fmt: skip


@compiled
def _evolve(
    problem: Integers,
    sizes: Integers,
    options: Integers,
    ground: Ground,
    ends: Integers,
    words: Words,
    memo: Integers,
    counters: Integers,
    work: Integers,
    spare: Integers,
    paths: Integers,
    points: Integers,
    keys: Integers,
    order: Integers,
    cycles: int,
    generations: int,
) -> None:
    """Breed one population until the run has taken so many cycles or generations."""
    population, children, elites = sizes[POPULATION], sizes[CHILDREN], sizes[ELITES]
    free, survivors, others, kept = spare[0], spare[1], spare[2], spare[3]
    while counters[CYCLES] < cycles and counters[GENERATIONS] < generations:
        _find_free(order, population, kept, free)
        breed(problem, sizes, paths, points, order, free, survivors, others, words)
        first = keys[order[0]] < GIVEN_UP
        limit = keys[order[options[_GIVE_UP_RANK]]]
        if limit >= GIVEN_UP:
            limit = NO_LIMIT
        for i in range(elites):
            kept[i] = order[i]
        for i in range(sizes[SURVIVORS]):
            kept[elites + i] = order[survivors[i]]
        used = 0
        for i in range(population - children):
            used = _place(order, keys, kept[i], used)
        for i in range(children):
            slot = free[i]
            keys[slot] = evaluate(
                problem, sizes, ground, ends, memo, counters, work, paths[slot], points[slot],
                limit, first,
            )  # fmt: skip
            used = _place(order, keys, slot, used)
        settle(counters)
        counters[GENERATIONS] += 1


@compiled
def _find_free(order: Integers, population: int, is_used: Integers, free: Integers) -> None:
    """Write the slots that hold no path of the population; ``is_used`` is work space."""
    slots = len(order) - 1
    is_used[:slots] = 0
    for rank in range(population):
        is_used[order[rank]] = 1
    found = 0
    for slot in range(slots):
        if not is_used[slot]:
            free[found] = slot
            found += 1


@compiled
def _place(order: Integers, keys: Integers, slot: int, used: int) -> int:
    """Insert a slot behind its equals in the first ``used`` of ``order``; return ``used + 1``."""
    rank = used
    while rank > 0 and keys[order[rank - 1]] > keys[slot]:
        order[rank] = order[rank - 1]
        rank -= 1
    order[rank] = slot
    return used + 1


@compiled
def _merge(
    paths: Integers, points: Integers, keys: Integers, order: Integers, population: int
) -> None:
    """Make the population of island 0 the best of all islands, an equal number of each."""
    islands = len(paths)
    each = population // islands
    merged = np.zeros((population, paths.shape[2], 4), dtype=np.int64)
    lengths, values = np.zeros(population, dtype=np.int64), np.zeros(population, dtype=np.int64)
    for i in range(islands):
        for rank in range(each):
            to, slot = i * each + rank, order[i, rank]
            merged[to], lengths[to], values[to] = paths[i, slot], points[i, slot], keys[i, slot]
    for slot in range(population):
        paths[0, slot], points[0, slot], keys[0, slot] = merged[slot], lengths[slot], values[slot]
        _place(order[0], keys[0], slot, slot)
