"""Crossover, every kind of mutation, and a generation from its recipe, computed by hand."""

import random

import pytest

from pathgene.hdl.config import MutationKind
from pathgene.hdl.protocol.breeding import (
    MutationRecord,
    Recipe,
    breed,
    crossover,
    keep,
    may_mutate,
    mutate,
)
from pathgene.hdl.protocol.messages import recipe_reply
from tests.support.gateware.chips import TINY


# Two elites, two survivors, four children of two parents; one mutator of each kind.
CONFIG = TINY.replace(max_waypoints=5, map_size=512, coarse_factor=16, altitude_bits=12)
PERTURB, INSERT, DELETE = CONFIG.mutations


def random_recipe(rng):
    def slots(count):
        return tuple(rng.randrange(CONFIG.population) for _ in range(count))

    mutations = tuple(
        MutationRecord(
            kind,
            rng.random() < 0.5,
            rng.randrange(CONFIG.children),
            rng.randrange(CONFIG.max_waypoints),
            0 if kind is DELETE else rng.getrandbits(CONFIG.waypoint_bits),
        )
        for kind in CONFIG.mutations
    )
    return Recipe(slots(CONFIG.crossovers), slots(CONFIG.survivors), mutations)


def test_crossover_swaps_tails_past_the_middle_rounded_down():
    assert crossover([[1, 2, 3], [4, 5, 6, 7], [8, 9]]) == [
        [1, 6, 7],
        [4, 5, 2, 3],
        [4, 5, 9],
        [8, 6, 7],
        [8, 2, 3],
        [1, 9],
    ]


@pytest.mark.parametrize(
    ("kind", "expected"),
    [(PERTURB, [1, 9, 3]), (INSERT, [1, 2, 9, 3]), (DELETE, [1, 3])],
)
def test_mutations_change_one_child_in_place(kind, expected):
    children = [[4, 5], [1, 2, 3]]
    mutate(children, MutationRecord(kind, True, 1, 1, 9))
    assert children == [[4, 5], expected]
    mutate(children, MutationRecord(kind, False, 0, 1, 9))
    assert children == [[4, 5], expected]


def test_limits_on_the_length():
    allowed = {
        kind: [n for n in range(2, 6) if may_mutate(CONFIG, kind, n)] for kind in MutationKind
    }
    assert allowed == {PERTURB: [2, 3, 4, 5], INSERT: [2, 3, 4], DELETE: [3, 4, 5]}


def test_a_generation_by_hand():
    paths = [[10 * slot + i for i in range(2 + slot % 3)] for slot in range(8)]
    order = [5, 3, 0, 1, 2, 4, 6, 7]
    recipe = Recipe(
        parents=(3, 1),
        survivors=(7, 0),
        mutations=(
            MutationRecord(PERTURB, True, 0, 1, 99),
            MutationRecord(INSERT, True, 3, 0, 77),
            MutationRecord(DELETE, False, 2, 1, 0),
        ),
    )
    before = [list(path) for path in paths]
    assert keep(CONFIG, order, recipe.survivors) == (5, 3, 7, 0)
    assert breed(CONFIG, paths, order, recipe) == [
        [50, 51, 52, 53],
        [30, 31],
        [70, 71, 72],
        [0, 1],
        [30, 99, 12],  # Head of slot 3 and tail of slot 1, waypoint 1 moved.
        [10, 31],
        [10, 31],
        [30, 77, 11, 12],  # Head of slot 3 and tail of slot 1, a waypoint added after waypoint 0.
    ]
    assert paths == before


def test_recipes_pack_and_unpack():
    rng = random.Random(1)
    for _ in range(50):
        recipe, checksum = random_recipe(rng), rng.getrandbits(32)
        packed = recipe.pack(CONFIG, checksum)
        assert len(packed) == recipe_reply(CONFIG).size
        assert Recipe.unpack(CONFIG, packed) == (recipe, checksum)
        values = recipe_reply(CONFIG).unpack(packed)
        assert values["checksum"] == checksum
        assert values["parent_1"] == recipe.parents[1]
        assert values["survivor_1"] == recipe.survivors[1]
        assert values["waypoint_0"] == recipe.mutations[0].waypoint
        assert values["child_2"] == recipe.mutations[2].child


def test_refuses_recipes_of_a_wrong_size():
    size = recipe_reply(CONFIG).size
    with pytest.raises(ValueError, match=f"^Payload must have {size} bytes, not {size - 1}$"):
        Recipe.unpack(CONFIG, bytes(size - 1))
