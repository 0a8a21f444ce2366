"""The model of the paper core compared with the definition, operator by operator."""

import dataclasses
import random
from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pathgene.hdl.config import CheckerBuild, Config, MutationKind
from pathgene.hdl.protocol.breeding import crossover
from pathgene.sim.model.checker import TerrainModel
from pathgene.sim.model.core import PaperCore
from pathgene.sim.model.mutation import Limits, Mutation, clamp
from pathgene.sim.model.selection import Draws


WITH_MAP = Config()
WITHOUT_MAP = Config(checker=CheckerBuild.NONE)
CONFIGS = [
    WITHOUT_MAP,
    Config(max_waypoints=20),
    Config(max_waypoints=5),
    Config(population=8, children=4, survivors=2, inserts=1, deletes=1, max_waypoints=3).replace(
        checker=CheckerBuild.NONE
    ),
]


def random_paths(config, rng, lengths=None):
    return [
        [
            rng.getrandbits(config.waypoint_bits)
            for _ in range(rng.randint(2, config.max_waypoints) if lengths is None else lengths)
        ]
        for _ in range(config.population)
    ]


def test_crossover_swaps_tails_past_the_middle():
    one, two, three = [1, 2, 3, 4, 5], [10, 20], [100, 200, 300, 400]
    assert crossover([one, two, three]) == [
        [1, 2, 20],
        [10, 3, 4, 5],
        [10, 300, 400],
        [100, 200, 20],
        [100, 200, 3, 4, 5],
        [1, 2, 300, 400],
    ]


@given(st.lists(st.lists(st.integers(0, 99), min_size=2, max_size=20), min_size=2, max_size=12))
def test_crossover_keeps_lengths_and_waypoints(parents):
    children = crossover(parents)
    assert len(children) == 2 * len(parents)
    assert all(2 <= len(child) <= 20 for child in children)
    flat = [waypoint for path in parents for waypoint in path]
    assert Counter(waypoint for child in children for waypoint in child) == Counter(2 * flat)


def test_parent_paired_with_itself_is_its_child():
    assert crossover([[1, 2, 3], [1, 2, 3]]) == [[1, 2, 3]] * 4


@pytest.mark.parametrize(
    ("value", "high", "limited"), [(-1, 5, 0), (0, 5, 0), (5, 5, 5), (6, 5, 5), (3, 5, 3)]
)
def test_clamp(value, high, limited):
    assert clamp(value, high) == limited


def waypoint(x, y, altitude):
    return x | y << 9 | altitude << 18


def test_mutations_by_hand():
    config = WITHOUT_MAP
    children = [[waypoint(10 * i, 20 * i, 100 * i) for i in range(3)] for _ in range(22)]
    children[4] = [waypoint(i, i, i) for i in range(16)]  # No room for another.
    children[7] = children[7][:2]  # None can be spared.
    draws = Draws(
        parents=(0,) * 11,
        survivors=tuple(range(2, 10)),
        children=(2, 4, 6, 7, 9),
        waypoints=(65535, 0, 40000, 30000, 21846),
        offsets=((-38, 38, 307), (1, 1, 1), (5, -6, -307)),
    )
    before = [list(child) for child in children]
    done = Mutation(config).mutate(children, draws, Limits(500, 60, 400))

    # The last of three moves; y and altitude stop at their limits.
    assert children[2] == [*before[2][:2], waypoint(0, 60, 400)]
    # No room: a counted no-op.
    assert children[4] == before[4]
    # 40000 * 3 >> 16 = 1: after the second waypoint, within the box around that waypoint.
    moved = waypoint(15, 14, 0)
    assert children[6] == [before[6][0], before[6][1], moved, before[6][2]]
    # None can be spared.
    assert children[7] == before[7]
    # 21846 * 3 >> 16 = 1.
    assert children[9] == [before[9][0], before[9][2]]
    untouched = set(range(22)) - {2, 4, 6, 7, 9}
    assert all(children[i] == before[i] for i in untouched)

    assert [mutated.kind for mutated in done] == list(config.mutations)
    assert [mutated.applied for mutated in done] == [True, False, True, False, True]
    assert [mutated.child for mutated in done] == [2, 4, 6, 7, 9]
    assert [mutated.index for mutated in done] == [2, 0, 1, 0, 1]
    assert [mutated.waypoint for mutated in done] == [waypoint(0, 60, 400), 0, moved, 0, 0]


@pytest.mark.parametrize("config", CONFIGS, ids=lambda config: f"max{config.max_waypoints}")
def test_generation_is_elites_survivors_children(config):
    rng = random.Random(7)
    core = PaperCore(config)
    core.start(seed=11, limits=core.limits)
    core.paths = random_paths(config, rng)
    kept_slots = config.elites + config.survivors
    for _ in range(200):
        before = [list(path) for path in core.paths]
        order = rng.sample(range(config.population), config.population)
        done = core.run(order)

        assert core.paths[: config.elites] == [before[slot] for slot in order[: config.elites]]
        assert len(set(done.survivors)) == config.survivors
        assert not set(done.survivors) & set(order[: config.elites])
        assert core.paths[config.elites : kept_slots] == [before[slot] for slot in done.survivors]

        children = crossover([before[slot] for slot in done.parents])
        mutated = {mutation.child for mutation in done.mutations if mutation.applied}
        assert len({mutation.child for mutation in done.mutations}) == config.mutators
        for number, child in enumerate(children):
            if number not in mutated:
                assert core.paths[kept_slots + number] == child
        for mutation in done.mutations:
            change = {MutationKind.PERTURB: 0, MutationKind.INSERT: 1, MutationKind.DELETE: -1}
            grown = len(core.paths[kept_slots + mutation.child]) - len(children[mutation.child])
            assert grown == (change[mutation.kind] if mutation.applied else 0)
        assert all(2 <= len(path) <= config.max_waypoints for path in core.paths)

        read = [before[slot] for slot in (*order[: config.elites], *done.survivors, *done.parents)]
        assert done.crossover_cycles == max(map(len, read)) + 1
        cycles = done.crossover_cycles + done.mutation_cycles + done.update_cycles
        assert cycles <= config.max_waypoints + 8


def test_new_waypoints_stay_in_the_box_and_the_limits():
    config = Config()
    rng = random.Random(3)
    core = PaperCore(config)
    limits = Limits(300, 511, 2000)
    core.start(5, limits)
    for _ in range(300):
        core.paths = [
            [
                waypoint(rng.randint(0, 300), rng.randint(0, 511), rng.randint(0, 2000))
                for _ in range(3)
            ]
            for _ in range(32)
        ]
        before = [list(path) for path in core.paths]
        order = list(range(32))
        done = core.run(order)
        children = crossover([before[slot] for slot in done.parents])
        for mutation in done.mutations[:3]:
            new, old = mutation.waypoint, children[mutation.child][mutation.index]
            x, y, altitude = new & 511, new >> 9 & 511, new >> 18
            assert abs(x - (old & 511)) <= 38
            assert abs(y - (old >> 9 & 511)) <= 38
            assert abs(altitude - (old >> 18)) <= 307
            assert x <= 300
            assert altitude <= 2000


def flat(config, altitude):
    """Return a map of one altitude."""
    terrain = TerrainModel(config)
    terrain.write(0, 0, [[altitude] * config.map_size] * config.map_size)
    return terrain


def test_mutations_above_the_ground_by_hand():
    terrain = flat(WITH_MAP, 0)
    terrain.write(99, 100, [[1000, 1001, 1000]])
    children = [[waypoint(100, 100, 1000)] * 3 for _ in range(22)]
    draws = Draws(
        parents=(0,) * 11,
        survivors=tuple(range(2, 10)),
        children=(2, 4, 6, 7, 9),
        waypoints=(0, 21846, 0, 0, 0),
        # Offsets of the first candidates of the three mutators, then of the second and third.
        offsets=(
            *((0, 0, 1), (1, 0, 0), (0, 0, 0)),
            *((0, 0, 2), (-1, 0, 0), (0, 0, -9)),
            *((0, 0, 3), (0, 1, -1000), (0, 0, 1)),
        ),
    )
    limits = Limits(511, 511, 4094)
    before = [list(child) for child in children]
    for avoid_ground, altitudes in ((True, (1002, None, None)), (False, (1001, 1000, 1000))):
        children = [list(child) for child in before]
        done = Mutation(WITH_MAP, terrain).mutate(children, draws, limits, avoid_ground)
        assert [mutated.applied for mutated in done[3:]] == [True, True]
        for mutated, altitude, child in zip(done, altitudes, (2, 4, 6), strict=False):
            assert mutated.applied == (altitude is not None)
            assert mutated.left_out == (altitude is None)
            if altitude is None:
                assert mutated.waypoint == 0
                assert children[child] == before[child]
            else:
                assert mutated.waypoint >> 18 == altitude
                assert mutated.waypoint in children[child]
        redraws = [mutated.redraws for mutated in done]
        # A candidate at the ground's altitude is rejected, as the third of mutator 2, 0 over 0.
        assert redraws == ([1, 2, 2, 0, 0] if avoid_ground else [0] * 5)


@pytest.mark.parametrize("redraws", [0, 2, 7])
def test_first_candidates_equal_those_without_a_map(redraws):
    """They are equal without avoidance, and over ground too low to matter."""
    config = WITH_MAP.replace(redraws=redraws)
    rng = random.Random(13)
    limits = Limits(400, 511, 4000)
    for altitude, avoid_ground in ((4095, False), (0, True)):
        core = PaperCore(config, flat(config, altitude))
        core.start(rng.getrandbits(64), limits, avoid_ground)
        for _ in range(30):
            draws = core._draws
            paths = random_paths(config, rng)
            # No altitude is near 0.
            paths = [[waypoint | 1 << 29 for waypoint in path] for path in paths]
            core.paths = paths
            order = rng.sample(range(32), 32)
            done = core.run(order)
            children = crossover([paths[order[rank]] for rank in draws.parents])
            first = dataclasses.replace(draws, offsets=draws.offsets[:3])
            assert done.mutations == Mutation(WITHOUT_MAP).mutate(children, first, limits)
            assert core.paths[10:] == children
            assert not done.left_out
            assert not done.redrawn


def test_no_new_waypoint_in_the_ground():
    """On random maps, a mutation applies the first candidate above the ground."""
    config = WITH_MAP
    rng = random.Random(14)
    terrain = TerrainModel(config)
    core = PaperCore(config, terrain)
    seen = Counter()
    limits = Limits(511, 511, 4094)
    for generation in range(60):
        if generation % 20 == 0:
            terrain.write(0, 0, [[rng.randrange(4096) for _ in range(512)] for _ in range(512)])
            core.start(generation, limits, avoid_ground=True)
        core.paths = random_paths(config, rng)
        done = core.run(rng.sample(range(32), 32))
        for mutated in done.mutations[:3]:
            new = mutated.waypoint
            if mutated.applied:
                assert new >> 18 > terrain.heights[new >> 9 & 511, new & 511]
            else:
                assert new == 0
            seen[mutated.applied, mutated.left_out, mutated.redraws] += 1
        assert done.left_out == sum(mutated.left_out for mutated in done.mutations)
        assert done.redrawn == sum(mutated.redraws for mutated in done.mutations)
        assert done.refused + done.left_out == sum(not each.applied for each in done.mutations)
        cycles = done.crossover_cycles + done.mutation_cycles + done.update_cycles
        assert cycles <= config.max_waypoints + 8
    assert {(True, False, 0), (True, False, 1), (True, False, 2), (False, True, 2)} <= set(seen)


@pytest.mark.parametrize(
    ("length", "altitude", "cycles"), [(2, 0, 13), (2, 4095, 19), (16, 0, 20), (16, 4095, 20)]
)
def test_cycles_with_a_map(length, altitude, cycles):
    """A generation takes a cycle per candidate and ten more, or four more than the longest path."""
    core = PaperCore(WITH_MAP, flat(WITH_MAP, altitude))
    core.start(1, core.limits, avoid_ground=True)
    core.paths = [[waypoint(i, i, 2000) for i in range(length)] for _ in range(32)]
    done = core.run(range(32))
    assert (done.left_out > 0) == (altitude > 0)
    assert done.crossover_cycles == length + 1
    assert done.crossover_cycles + done.mutation_cycles + done.update_cycles == cycles


def test_refuses_a_map_without_a_checker():
    with pytest.raises(ValueError, match=r"^Config\.checker must be none without a map and not"):
        PaperCore(WITHOUT_MAP, TerrainModel(WITH_MAP))


@pytest.mark.parametrize("config", [WITHOUT_MAP, WITH_MAP], ids=["no map", "map"])
def test_draws_depend_only_on_seed_and_generation(config):
    rng = random.Random(9)
    one, other = (
        PaperCore(config, None if config.checker is CheckerBuild.NONE else TerrainModel(config))
        for _ in range(2)
    )
    for core in (one, other):
        # The number of rejected candidates does not change the draws.
        core.start(1234, core.limits, avoid_ground=core is one)
    other.paths = random_paths(config, rng)
    order = list(range(32))
    for generation in range(50):
        shuffled = rng.sample(order, 32)
        first, second = one.run(order), other.run(shuffled)
        ranks = {slot: rank for rank, slot in enumerate(shuffled)}
        assert first.parents == tuple(ranks[slot] for slot in second.parents), generation
        assert [m.child for m in first.mutations] == [m.child for m in second.mutations]
    one.start(1234, one.limits)
    other.start(1235, other.limits)
    assert one.run(order).parents != other.run(order).parents


def test_same_seed_same_populations():
    config = Config()
    runs = []
    for _ in range(2):
        rng = random.Random(2)
        core = PaperCore(config)
        core.start(99, core.limits)
        core.paths = random_paths(config, rng)
        checksums = []
        for _ in range(60):
            core.run(rng.sample(range(32), 32))
            checksums.append(core.checksum())
        runs.append(checksums)
    assert runs[0] == runs[1]
    assert len(set(runs[0])) == 60
