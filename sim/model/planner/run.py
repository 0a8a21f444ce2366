"""A compiled run: first populations, islands, and one population of their best.

Generations overlap, as in the gateware: while the children of one are evaluated, the children of
the next are bred. Therefore a generation is bred from the population that the previous one was bred
from, and the children of the second-last generation.
"""

from __future__ import annotations

import numpy as np

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import FAR, ProblemRecord
from pathgene.hdl.protocol.runs import ISLANDS, Outcome, Population, RunOptions
from pathgene.sim.model.compiled import allocating, compiled
from pathgene.sim.model.planner import cycles
from pathgene.sim.model.planner.breeder import breed
from pathgene.sim.model.planner.course import (
    BLOCK_SHIFT,
    BLOCKED,
    CHILDREN,
    ELITES,
    HAS_ENTRY,
    HAS_EXIT,
    MAX_WAYPOINTS,
    POPULATION,
    SURVIVORS,
    Course,
    Members,
    Route,
    Scratch,
    Surroundings,
    problem_vector,
    sizes_vector,
)
from pathgene.sim.model.planner.cycles import CYCLES, GENERATIONS, WALK
from pathgene.sim.model.planner.definition.score import corner_of
from pathgene.sim.model.planner.evaluation import GIVEN_UP, NO_LIMIT, evaluate
from pathgene.sim.model.planner.random_words import source
from pathgene.sim.model.planner.run_cycles import ROUTED, SCANNED, launched, scanned
from pathgene.sim.model.planner.score import WORK_ROWS
from pathgene.sim.model.planner.seeds import ahead, lift, seed_path
from pathgene.sim.model.planner.sorting import join, merge, place
from pathgene.sim.model.planner.walk import Ground, Integers, empty_memo
from pathgene.sim.model.planner.wavefront import (
    LEAST,
    PRICES,
    descend,
    find_turns,
    limit_slopes,
    measure_blocks,
    measure_distances,
    measure_prices,
    spread,
)


__all__ = [
    "NEVER",
    "WATCHED",
    "WATCHED_CYCLES",
    "WATCHED_GENERATIONS",
    "WATCHED_STOP",
    "plan",
]

#: Cycle of a stop that never happens: the counter of cycles ends before.
NEVER = 1 << 32

#: Minimum waypoints of a path.
_FEWEST = Config.MIN_WAYPOINTS

#: Places of the stop that another thread requests by writing 1, and of the progress that it reads.
WATCHED_STOP, WATCHED_GENERATIONS, WATCHED_CYCLES = range(3)
#: Their number.
WATCHED = 3

#: Places of the options.
_CYCLES, _GENERATIONS, _UNTIL_FEASIBLE, _GIVE_UP_RANK, _SEEDS, _LIFTS, _SHARE, _STOP, _GUIDED = (
    range(9)
)
#: Rows of the work space of a generation: free slots, survivors, remaining ranks, members that
#: stay, and slots and point cycles of the children that wait to be collected.
_FREE, _SURVIVORS, _OTHERS, _KEPT, _PENDING, _OFFERED, _NEXT_OFFERED = range(7)


def plan(
    config: Config,
    ground: Ground,
    record: ProblemRecord,
    options: RunOptions,
    population: Population | None = None,
    *,
    guide: Integers | None = None,
    marked: int | None = None,
    stop: int = NEVER,
    watched: Integers | None = None,
) -> Outcome:
    """Plan a path.

    Parameters
    ----------
    ground : (map_size, map_size) uint16
        The highest of the four cells around each corner.
    population : list of list of (int, int, int), optional
        All paths of an earlier run, best first; only with ``options.warm``.
    guide : (max_waypoints, 3) int64, optional
        Corners and altitude steps of the guide's waypoints, by default zeros.
    marked : int, optional
        Number of map blocks that have changed since the previous run, by default all. It only
        affects cycles.
    stop : int
        Cycle in which the run is stopped: no generation is bred in a later cycle.
    watched : (WATCHED,) int64, optional
        Zeros; lets another thread see generations and cycles, and end each island with its current
        generation.

    Raises
    ------
    ValueError
        If the options, the record or the population do not fit ``config``.
    """
    options.check(config)
    _check_population(config, options, population)
    numbers = (
        options.cycles,
        options.generations,
        options.until_feasible,
        options.give_up_rank,
        options.seeds,
        options.lifts,
        options.share,
        stop,
        options.guided,
    )
    # Room for the population and two generations of children, and for the best seeds and one more.
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
    edge = record.blocks
    all_marked = edge * edge if marked is None else marked
    spent = scanned(edge, all_marked, record.block_shift, config.lanes, int(delays[cycles.ROW]))
    cycles.spread(counters, spent, SCANNED)
    _run(
        Course(problem_vector(config, record), sizes_vector(config, options.memo), ground),
        Scratch(
            empty_memo(options.memo),
            delays,
            counters,
            np.zeros((WORK_ROWS, paths.shape[2] + 2), dtype=np.int64),
        ),
        Surroundings(
            source(options.seed),
            np.zeros(WATCHED, dtype=np.int64) if watched is None else watched,
            np.zeros((7, slots + 1), dtype=np.int64),
        ),
        Members(paths, points, keys, order),
        np.array(numbers, dtype=np.int64),
        np.array(options.slopes, dtype=np.int64),
        np.array([*start, *goal], dtype=np.int64),
        np.zeros((config.max_waypoints, 3), dtype=np.int64) if guide is None else guide,
        dropped,
        edge,
    )
    best: dict[int, list[tuple[int, int, int]]] = {}
    last = []
    for slot in order[0, : config.population].tolist():
        waypoints = paths[0, slot, 1 : points[0, slot] - 1, :3].tolist()
        last.append([(x, y, z) for x, y, z in waypoints])
        best.setdefault(int(keys[0, slot]), last[-1])
    returned = list(best.values())[: options.paths], list(best)[: options.paths]
    return Outcome(*returned, last, **cycles.totals(counters))


def _check_population(config: Config, options: RunOptions, population: Population | None) -> None:
    """Raise ``ValueError`` unless a warm run has a whole population, and a cold run none."""
    count = 0 if population is None else len(population)
    if count != (config.population if options.warm else 0):
        raise ValueError(
            f"A warm run must go on from {config.population} paths, and another run from none, not "
            f"from {count}"
        )


@allocating
def _run(
    course: Course,
    scratch: Scratch,
    around: Surroundings,
    islands: Members,
    options: Integers,
    slopes: Integers,
    ends: Integers,
    guide: Integers,
    dropped: Integers,
    edge: int,
) -> None:
    """Execute the run; island 0 contains the population afterwards.

    Parameters
    ----------
    islands : Members
        One island for each of ``slopes``. A warm start has one more, the first, which contains its
        paths.
    options, ends : (n,) int64
    slopes : (islands,) int64
        Slope limit of each seeded island.
    guide : (max_waypoints, 3) int64
    dropped : (population,) int64
        Number of waypoints that each path of a warm start has lost.
    edge : int
        Number of blocks along each edge of the wavefront's map.
    """
    problem, sizes, ground = course
    counters, delays = scratch.counters, scratch.delays
    paths, points, keys, order = islands
    blocks = np.zeros((3, edge, edge), dtype=np.int64)
    surface = np.zeros((edge, edge), dtype=np.int64)
    field = np.zeros((edge, edge), dtype=np.int64)
    route = np.zeros((edge * edge, 2), dtype=np.int64)
    turns = np.zeros((sizes[MAX_WAYPOINTS] + 1, 2), dtype=np.int64)
    distances = np.zeros(3, dtype=np.int64)
    measure_distances(problem, distances)
    prices = np.zeros(PRICES, dtype=np.int64)
    measure_prices(problem, sizes, distances, prices)
    measure_blocks(problem, ground, sizes[BLOCKED], ends, blocks)
    shift = problem[BLOCK_SHIFT]
    start = (ends[1] >> shift) * edge + (ends[0] >> shift)
    goal = (ends[4] >> shift) * edge + (ends[3] >> shift)

    population, count = sizes[POPULATION], len(paths)
    warm = count - len(slopes)
    if warm:
        for slot in range(population):
            offered = cycles.revised(counters, slot, dropped[slot])
            keys[0, slot], made = _evaluate(
                course, scratch, paths[0, slot], points[0, slot], offered, NO_LIMIT, False
            )
            cycles.take(counters, made, place(order[0], keys[0], slot, slot))
        cycles.settle(delays, counters)
    for i in range(warm, count):
        followed, length = 0, 1
        guided = options[_GUIDED] if i == warm else 0
        if not guided:
            surface[:] = blocks[LEAST]
            limit_passes, slope = 0, slopes[i - warm]
            if slope:
                limit_passes = limit_slopes(problem, distances, surface, slope)
            passes = spread(prices, surface, goal, field)
            length = descend(prices, surface, field, start, goal, route)
            is_straight = field[start // edge, start % edge] == FAR
            spent = launched(edge, limit_passes, passes, length, is_straight)
            cycles.spread(counters, spent, ROUTED)
            # The first island of a cold run goes around obstacles, the second one along valleys.
            if i == 0 and not is_straight:
                followed = find_turns(route, length, turns)
                if followed < _FEWEST or followed > sizes[MAX_WAYPOINTS]:
                    followed = 0
        way = Route(blocks, surface, route, length, turns, followed, guide, guided)
        for seed in range(options[_SEEDS]):
            # The slot of the worst path, except for the first seeds, which have their own.
            slot = seed if seed <= population else order[i, population]
            path = paths[i, slot]
            points[i, slot] = seed_path(course, ends, way, around.words, path)
            keys[i, slot], made = _evaluate(
                course, scratch, path, points[i, slot], cycles.seeded(counters, seed), NO_LIMIT,
                False,
            )  # fmt: skip
            rank = min(seed, population)
            cycles.take(counters, made, place(order[i], keys[i], slot, rank))
        cycles.settle(delays, counters)
        for _ in range(options[_LIFTS]):
            ranked = around.spare[0]
            ranked[:population] = order[i, :population]
            for rank in range(population):
                slot = ranked[rank]
                lift(problem, paths[i, slot], points[i, slot])
                offered = cycles.revised(counters, rank, 0)
                keys[i, slot], made = _evaluate(
                    course, scratch, paths[i, slot], points[i, slot], offered, NO_LIMIT, False
                )
                cycles.take(counters, made, place(order[i], keys[i], slot, rank))
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
            island = Members(paths[i], points[i], keys[i], order[i])
            _evolve(course, scratch, around, island, options, until, most, False)
        passed = merge(paths, points, keys, order, population)
        cycles.merge(delays, counters, passed)
    else:
        cycles.aim(counters)
    island = Members(paths[0], points[0], keys[0], order[0])
    time, generations = options[_CYCLES], options[_GENERATIONS]
    waits = options[_UNTIL_FEASIBLE] != 0
    _evolve(course, scratch, around, island, options, time, generations, waits)
    cycles.end(counters)


@compiled
def _evolve(
    course: Course,
    scratch: Scratch,
    around: Surroundings,
    members: Members,
    options: Integers,
    time: int,
    generations: int,
    waits: bool,
) -> None:
    """Breed one population until the run reaches ``time`` cycles or ``generations``.

    With ``waits`` the generations count only if the best path is feasible.
    """
    sizes = course.sizes
    delays, counters = scratch.delays, scratch.counters
    words, watched, spare = around
    paths, points, keys, order = members
    population, children = sizes[POPULATION], sizes[CHILDREN]
    stay = population - children
    free, survivors, kept, pending = spare[_FREE], spare[_SURVIVORS], spare[_KEPT], spare[_PENDING]
    offered, next_offered = spare[_OFFERED], spare[_NEXT_OFFERED]
    has_pending, pending_first, pending_limit = False, False, NO_LIMIT
    time = min(time, options[_STOP] + 1)
    while True:
        watched[WATCHED_GENERATIONS] = counters[GENERATIONS]
        watched[WATCHED_CYCLES] = counters[CYCLES]
        continues = counters[GENERATIONS] < generations or (waits and keys[order[0]] >= GIVEN_UP)
        breeds = counters[CYCLES] < time and continues
        breeds &= watched[WATCHED_STOP] == 0
        first, limit = False, NO_LIMIT
        if breeds:
            begun = cycles.begin(delays, counters, has_pending)
            _find_free(order, population, pending, children if has_pending else 0, kept, free)
            breed(course, members, free, survivors, spare[_OTHERS], words)
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
            # Number of members in the sorter, which exceeds the children once the pass has begun.
            used = 0
            for i in range(children):
                slot = pending[i]
                keys[slot], made = _evaluate(
                    course, scratch, paths[slot], points[slot], offered[i], pending_limit,
                    pending_first,
                )  # fmt: skip
                if used == i and cycles.passes(counters, made):
                    used += stay
                    cycles.pass_over(delays, counters, join(order, keys, kept, i, stay))
                cycles.take(counters, made, place(order, keys, slot, used))
                used += 1
            if used == children:
                cycles.pass_over(delays, counters, join(order, keys, kept, children, stay))
            cycles.collect(delays, counters)
        if not breeds:
            break
        has_pending, pending_first, pending_limit = True, first, limit
        for i in range(children):
            pending[i], offered[i] = free[i], next_offered[i]


@compiled
def _evaluate(
    course: Course,
    scratch: Scratch,
    path: Integers,
    points: int,
    offered: int,
    limit: int,
    first: bool,
) -> tuple[int, int]:
    """Return a path's key and its cycle, if its points arrive from cycle ``offered`` on."""
    problem, counters = course.problem, scratch.counters
    before = counters[WALK]
    key = evaluate(course, scratch, path, points, limit, first)
    count = points + problem[HAS_ENTRY] + problem[HAS_EXIT]
    walk = counters[WALK] - before
    return key, cycles.enter(scratch.delays, counters, offered, count, walk, problem[HAS_EXIT])


@compiled
def _find_free(
    order: Integers,
    population: int,
    pending: Integers,
    waiting: int,
    is_used: Integers,
    free: Integers,
) -> None:
    """Write the slots that contain neither a path of the population nor one that waits.

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
    """Write the slots of elites and survivors in order of rank."""
    elites, count = sizes[ELITES], 0
    for rank in range(sizes[POPULATION]):
        stays = rank < elites
        for i in range(sizes[SURVIVORS]):
            stays |= survivors[i] == rank
        if stays:
            kept[count] = order[rank]
            count += 1
