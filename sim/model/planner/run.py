"""A run, compiled: :func:`pathgene.sim.model.planner.definition.run.plan`, bit for bit."""

from __future__ import annotations

import numpy as np

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import BLOCKS, FAR, ProblemRecord
from pathgene.hdl.protocol.runs import ISLANDS, Outcome, Population, RunOptions
from pathgene.sim.model.planner import cycles
from pathgene.sim.model.planner.breeder import breed
from pathgene.sim.model.planner.compiled import allocating, compiled
from pathgene.sim.model.planner.cycles import CYCLES, GENERATIONS, WALK
from pathgene.sim.model.planner.definition.run import NEVER, check_population
from pathgene.sim.model.planner.definition.score import corner_of
from pathgene.sim.model.planner.definition.warm import ahead
from pathgene.sim.model.planner.evaluation import GIVEN_UP, NO_LIMIT, evaluate
from pathgene.sim.model.planner.memo import empty_memo
from pathgene.sim.model.planner.problem import (
    BLOCK_SHIFT,
    BLOCKED,
    CHILDREN,
    ELITES,
    HAS_ENTRY,
    HAS_EXIT,
    POPULATION,
    SURVIVORS,
    problem_vector,
    sizes_vector,
)
from pathgene.sim.model.planner.random_words import Words, source
from pathgene.sim.model.planner.run_control_cycles import ROUTED, SCANNED
from pathgene.sim.model.planner.score import WORK_ROWS
from pathgene.sim.model.planner.seeds import lift, seed_path
from pathgene.sim.model.planner.walk import Ground, Integers
from pathgene.sim.model.planner.wavefront import (
    LEAST,
    PRICES,
    descend,
    limit_slopes,
    measure_blocks,
    measure_distances,
    measure_prices,
    spread,
)
from pathgene.sim.model.planner.wavefront_cycles import launched, scanned


__all__ = ["WATCHED", "WATCHED_CYCLES", "WATCHED_GENERATIONS", "WATCHED_STOP", "plan"]

#: Places of what another thread sees of a run, and of the stop that it may ask for by writing 1.
WATCHED_STOP, WATCHED_GENERATIONS, WATCHED_CYCLES = range(3)
#: Their number.
WATCHED = 3

#: Places of the options.
_CYCLES, _GENERATIONS, _UNTIL_FEASIBLE, _GIVE_UP_RANK, _SEEDS, _LIFTS, _SHARE, _STOP = range(8)
#: Rows of the work space of a generation: free slots, survivors, ranks left, members that stay,
#: and of the children that wait to be collected their slots and the cycles of their points.
_FREE, _SURVIVORS, _OTHERS, _KEPT, _PENDING, _OFFERED, _NEXT_OFFERED = range(7)


def plan(
    config: Config,
    ground: Ground,
    record: ProblemRecord,
    options: RunOptions,
    population: Population | None = None,
    *,
    marked: int = BLOCKS**2,
    stop: int = NEVER,
    watched: Integers | None = None,
) -> Outcome:
    """Plan a path: see :func:`pathgene.sim.model.planner.definition.run.plan`.

    ``watched``, (WATCHED,) int64 zeros, lets another thread see generations and cycles, and end
    each island with its present generation.
    """
    options.check(config)
    check_population(config, options, population)
    numbers = (
        options.cycles,
        options.generations,
        options.until_feasible,
        options.give_up_rank,
        options.seeds,
        options.lifts,
        options.share,
        stop,
    )
    # Room for two generations of children beside the population, and for a seed beside the best.
    slots = config.population + 2 * config.children
    shape = len(options.slopes) + options.warm, slots
    paths = np.zeros((*shape, config.max_waypoints + 2, 4), dtype=np.int64)
    points = np.zeros(shape, dtype=np.int64)
    keys = np.zeros(shape, dtype=np.int64)
    order = np.zeros((shape[0], slots + 1), dtype=np.int64)
    dropped = np.zeros(config.population, dtype=np.int64)
    start, goal = corner_of(record, "start"), corner_of(record, "goal")
    for slot, path in enumerate(population or ()):
        left = ahead(config, record, path)
        rows = [start, *left, goal]
        paths[0, slot, : len(rows), :3], points[0, slot] = rows, len(rows)
        dropped[slot] = len(path) - len(left)
    delays, counters = cycles.delays_vector(config), cycles.counters_vector()
    spent = scanned(marked, record.block_shift, config.lanes, int(delays[cycles.ROW]))
    cycles.spread(counters, spent, SCANNED)
    _run(
        problem_vector(config, record),
        sizes_vector(config, options.memo),
        np.array(numbers, dtype=np.int64),
        np.array(options.slopes, dtype=np.int64),
        ground,
        np.array([*start, *goal], dtype=np.int64),
        source(options.seed),
        empty_memo(options.memo),
        delays,
        counters,
        np.zeros(WATCHED, dtype=np.int64) if watched is None else watched,
        dropped,
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
    returned = list(best.values())[: options.paths], list(best)[: options.paths]
    return Outcome(*returned, last, **cycles.totals(counters))


@allocating
def _run(
    problem: Integers,
    sizes: Integers,
    options: Integers,
    slopes: Integers,
    ground: Ground,
    ends: Integers,
    words: Words,
    memo: Integers,
    delays: Integers,
    counters: Integers,
    watched: Integers,
    dropped: Integers,
    paths: Integers,
    points: Integers,
    keys: Integers,
    order: Integers,
) -> None:
    """Do the run; the population is in island 0 afterwards, ``order`` its slots from the best.

    Parameters
    ----------
    problem, sizes, options, ends, delays, counters, watched : (n,) int64
    slopes : (islands,) int64
        Of each island that is seeded. There is an island more in ``paths`` on a warm start, the
        first, whose paths are there.
    ground : (map_size, map_size) uint16
    words : Words
    memo : (rows, 4) int64
    dropped : (population,) int64
        Waypoints that each path of a warm start has lost.
    paths : (islands, slots, points, 4) int64
    points, keys : (islands, slots) int64
    order : (islands, slots + 1) int64
    """
    work = np.zeros((WORK_ROWS, paths.shape[2] + 2), dtype=np.int64)
    spare = np.zeros((7, paths.shape[1] + 1), dtype=np.int64)
    blocks = np.zeros((3, BLOCKS, BLOCKS), dtype=np.int64)
    surface = np.zeros((BLOCKS, BLOCKS), dtype=np.int64)
    field = np.zeros((BLOCKS, BLOCKS), dtype=np.int64)
    route = np.zeros((BLOCKS * BLOCKS, 2), dtype=np.int64)
    distances = np.zeros(3, dtype=np.int64)
    measure_distances(problem, distances)
    prices = np.zeros(PRICES, dtype=np.int64)
    measure_prices(problem, sizes, distances, prices)
    measure_blocks(problem, ground, sizes[BLOCKED], ends, blocks)
    shift = problem[BLOCK_SHIFT]
    start = (ends[1] >> shift) * BLOCKS + (ends[0] >> shift)
    goal = (ends[4] >> shift) * BLOCKS + (ends[3] >> shift)

    population, count = sizes[POPULATION], len(paths)
    warm = count - len(slopes)
    if warm:
        for slot in range(population):
            offered = cycles.revised(counters, slot, dropped[slot])
            keys[0, slot], made = _evaluate(
                problem, sizes, ground, memo, delays, counters, work, paths[0, slot],
                points[0, slot], offered, NO_LIMIT, False,
            )  # fmt: skip
            cycles.take(counters, made, _place(order[0], keys[0], slot, slot))
        cycles.settle(delays, counters)
    for i in range(warm, count):
        surface[:] = blocks[LEAST]
        limit_passes, slope = 0, slopes[i - warm]
        if slope:
            limit_passes = limit_slopes(problem, distances, surface, slope)
        passes = spread(prices, surface, goal, field)
        length = descend(prices, surface, field, start, goal, route)
        is_straight = field[start // BLOCKS, start % BLOCKS] == FAR
        spent = launched(limit_passes, passes, length, is_straight)
        cycles.spread(counters, spent, ROUTED)
        for seed in range(options[_SEEDS]):
            # The slot of the worst path but the first seeds' own.
            slot = seed if seed <= population else order[i, population]
            path = paths[i, slot]
            points[i, slot] = seed_path(
                problem, sizes, ends, blocks, surface, route, length, words, path
            )
            keys[i, slot], made = _evaluate(
                problem, sizes, ground, memo, delays, counters, work, path, points[i, slot],
                cycles.seeded(counters, seed), NO_LIMIT, False,
            )  # fmt: skip
            rank = min(seed, population)
            cycles.take(counters, made, _place(order[i], keys[i], slot, rank))
        cycles.settle(delays, counters)
        for _ in range(options[_LIFTS]):
            ranked = spare[0]
            ranked[:population] = order[i, :population]
            for rank in range(population):
                slot = ranked[rank]
                lift(problem, paths[i, slot], points[i, slot])
                keys[i, slot], made = _evaluate(
                    problem, sizes, ground, memo, delays, counters, work, paths[i, slot],
                    points[i, slot], cycles.revised(counters, rank, 0), NO_LIMIT, False,
                )  # fmt: skip
                cycles.take(counters, made, _place(order[i], keys[i], slot, rank))
            cycles.settle(delays, counters)

    if count == ISLANDS:
        time = max(options[_CYCLES] - counters[CYCLES], 0) * options[_SHARE] >> 5
        generations = options[_GENERATIONS] * options[_SHARE] >> 5
        cycles.share_out(counters)
        for i in range(count):
            if i:
                cycles.next_island(counters)
            until: int = counters[CYCLES] + time
            most: int = counters[GENERATIONS] + generations
            cycles.aim(counters)
            _evolve(
                problem, sizes, options, ground, words, memo, delays, counters, watched, work,
                spare, paths[i], points[i], keys[i], order[i], until, most, False,
            )  # fmt: skip
        passed = _merge(paths, points, keys, order, population)
        cycles.merge(delays, counters, passed)
    else:
        cycles.aim(counters)
    _evolve(
        problem, sizes, options, ground, words, memo, delays, counters, watched, work,
        spare, paths[0], points[0], keys[0], order[0], options[_CYCLES], options[_GENERATIONS],
        options[_UNTIL_FEASIBLE] != 0,
    )  # fmt: skip
    cycles.end(counters)


@compiled
def _evolve(
    problem: Integers,
    sizes: Integers,
    options: Integers,
    ground: Ground,
    words: Words,
    memo: Integers,
    delays: Integers,
    counters: Integers,
    watched: Integers,
    work: Integers,
    spare: Integers,
    paths: Integers,
    points: Integers,
    keys: Integers,
    order: Integers,
    time: int,
    generations: int,
    waits: bool,
) -> None:
    """Breed one population until the run has taken so many cycles or generations.

    With ``waits`` the generations count only if the best path is feasible.
    """
    population, children = sizes[POPULATION], sizes[CHILDREN]
    stay = population - children
    free, survivors, kept, pending = spare[_FREE], spare[_SURVIVORS], spare[_KEPT], spare[_PENDING]
    offered, next_offered = spare[_OFFERED], spare[_NEXT_OFFERED]
    has_pending, pending_first, pending_limit = False, False, NO_LIMIT
    time = min(time, options[_STOP] + 1)
    while True:
        watched[WATCHED_GENERATIONS] = counters[GENERATIONS]
        watched[WATCHED_CYCLES] = counters[CYCLES]
        goes_on = counters[GENERATIONS] < generations or (waits and keys[order[0]] >= GIVEN_UP)
        breeds = counters[CYCLES] < time and goes_on
        breeds &= watched[WATCHED_STOP] == 0
        first, limit = False, NO_LIMIT
        if breeds:
            begun = cycles.begin(delays, counters, has_pending)
            _find_free(order, population, pending, children if has_pending else 0, kept, free)
            breed(problem, sizes, paths, points, order, free, survivors, spare[_OTHERS], words)
            for i in range(children):
                next_offered[i] = cycles.bred(counters, begun, i, points[free[i]])
            first = keys[order[0]] < GIVEN_UP
            limit = keys[order[options[_GIVE_UP_RANK]]]
            if limit >= GIVEN_UP:
                limit = NO_LIMIT
        elif has_pending:
            cycles.finish(counters)
        if has_pending:
            _keep(sizes, survivors, order, kept)
            # Those in the sorter: more than children once the pass has come.
            used = 0
            for i in range(children):
                slot = pending[i]
                keys[slot], made = _evaluate(
                    problem, sizes, ground, memo, delays, counters, work, paths[slot],
                    points[slot], offered[i], pending_limit, pending_first,
                )  # fmt: skip
                if used == i and cycles.passes(counters, made):
                    used += stay
                    cycles.pass_over(delays, counters, _join(order, keys, kept, i, stay))
                cycles.take(counters, made, _place(order, keys, slot, used))
                used += 1
            if used == children:
                cycles.pass_over(delays, counters, _join(order, keys, kept, children, stay))
            cycles.collect(delays, counters)
        if not breeds:
            break
        has_pending, pending_first, pending_limit = True, first, limit
        for i in range(children):
            pending[i], offered[i] = free[i], next_offered[i]


@compiled
def _evaluate(
    problem: Integers,
    sizes: Integers,
    ground: Ground,
    memo: Integers,
    delays: Integers,
    counters: Integers,
    work: Integers,
    path: Integers,
    points: int,
    offered: int,
    limit: int,
    first: bool,
) -> tuple[int, int]:
    """Return the key of a path, and its cycle, if points are there in cycle ``offered``."""
    before = counters[WALK]
    key = evaluate(problem, sizes, ground, memo, counters, work, path, points, limit, first)
    count = points + problem[HAS_ENTRY] + problem[HAS_EXIT]
    walk = counters[WALK] - before
    return key, cycles.enter(delays, counters, offered, count, walk, problem[HAS_EXIT])


@compiled
def _find_free(
    order: Integers,
    population: int,
    pending: Integers,
    waiting: int,
    is_used: Integers,
    free: Integers,
) -> None:
    """Write the slots that hold no path of the population and none of those that wait.

    ``is_used`` is work space.
    """
    slots = len(order) - 1
    is_used[:slots] = 0
    for rank in range(population):
        is_used[order[rank]] = 1
    for i in range(waiting):
        is_used[pending[i]] = 1
    found = 0
    for slot in range(slots):
        if not is_used[slot]:
            free[found] = slot
            found += 1


@compiled
def _keep(sizes: Integers, survivors: Integers, order: Integers, kept: Integers) -> None:
    """Write the slots of elites and survivors in the order of their ranks."""
    elites, count = sizes[ELITES], 0
    for rank in range(sizes[POPULATION]):
        stays = rank < elites
        for i in range(sizes[SURVIVORS]):
            stays |= survivors[i] == rank
        if stays:
            kept[count] = order[rank]
            count += 1


@compiled
def _place(order: Integers, keys: Integers, slot: int, used: int) -> int:
    """Insert a slot behind its equals in the first ``used`` ones; return how many follow it."""
    rank = used
    while rank > 0 and keys[order[rank - 1]] > keys[slot]:
        order[rank] = order[rank - 1]
        rank -= 1
    order[rank] = slot
    return used - rank


@compiled
def _join(order: Integers, keys: Integers, kept: Integers, used: int, stay: int) -> int:
    """Insert the slots that stay, sorted, in front of their equals in the first ``used`` ones.

    Return how many of these follow each of them, summed up.
    """
    passed, other = 0, used - 1
    for i in range(stay - 1, -1, -1):
        while other >= 0 and keys[order[other]] >= keys[kept[i]]:
            order[other + i + 1] = order[other]
            other -= 1
        order[other + i + 1] = kept[i]
        passed += used - 1 - other
    return passed


@allocating
def _merge(
    paths: Integers, points: Integers, keys: Integers, order: Integers, population: int
) -> int:
    """Make the population of island 0 the best of all islands, an equal number of each.

    Return how many of those before it each of them passes, summed up.
    """
    islands = len(paths)
    each = population // islands
    merged = np.zeros((population, paths.shape[2], 4), dtype=np.int64)
    lengths, values = np.zeros(population, dtype=np.int64), np.zeros(population, dtype=np.int64)
    for i in range(islands):
        for rank in range(each):
            to, slot = i * each + rank, order[i, rank]
            merged[to], lengths[to], values[to] = paths[i, slot], points[i, slot], keys[i, slot]
    passed = 0
    for slot in range(population):
        paths[0, slot], points[0, slot], keys[0, slot] = merged[slot], lengths[slot], values[slot]
        passed += _place(order[0], keys[0], slot, slot)
    return passed
