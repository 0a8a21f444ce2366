"""Breeding: makes the next population from the paths of a population.

A path is a list of packed waypoints. The population of the paper core after a generation is the
elites, best first, then the survivors in the order in which they were drawn, then the children. The
model breeds with its own draws, a host with the chip's :class:`Recipe`; both call the functions of
this module, and the gateware is tested against them. The planner core breeds differently: the
constants here are its probabilities and the places of its draws in the random words.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pathgene.hdl.config import Config, MutationKind
from pathgene.hdl.protocol.messages import recipe_reply


__all__ = [
    "CUT",
    "DELETE",
    "INSERT",
    "MUTATIONS",
    "OFFSETS",
    "OPERATOR",
    "PARENT_DRAWS",
    "PLACE",
    "SETTLE",
    "SIZE",
    "SURVIVOR_BITS",
    "MutationRecord",
    "Recipe",
    "breed",
    "crossover",
    "keep",
    "may_mutate",
    "mutate",
]


#: Number of uniform draws, the best of which is a parent's rank. The first parent's draws begin at
#: bit 0 of the selection word; the second parent's draws are above them.
PARENT_DRAWS = 4
#: Width of the draw of a survivor, above the parents' draws.
SURVIVOR_BITS = 24
#: There are ``MUTATIONS`` equally likely draws. The first ones perturb; from each of the first
#: three numbers on, draws insert, delete and settle.
INSERT, DELETE, SETTLE, MUTATIONS = 8, 11, 14, 18
#: First bit in the mutation word, and width, of the draws of the operator, the place, the size, the
#: offset in x (with y and altitude above it), and the cut of the parents.
OPERATOR, PLACE, SIZE = (0, 8), (8, 8), (16, 4)
OFFSETS, CUT = (20, 14), (62, 2)


@dataclass(frozen=True)
class MutationRecord:
    """Effect of one mutator.

    Attributes
    ----------
    applied : bool
        False leaves the child unchanged.
    child : int
        Number of the child, 0..children - 1.
    index : int
        Waypoint moved, removed, or after which one was added; counted before the change.
    waypoint : int
        The new waypoint, packed; 0 for a deletion and for a mutation that was not applied.
    """

    kind: MutationKind
    applied: bool
    child: int
    index: int
    waypoint: int


@dataclass(frozen=True)
class Recipe:
    """Choices of one generation, which determine the children from the previous paths.

    Attributes
    ----------
    parents, survivors : tuple of int
        Slots before the update, of the crossover parents and of the survivors.
    mutations : tuple of MutationRecord
        One for each mutator.
    """

    parents: tuple[int, ...]
    survivors: tuple[int, ...]
    mutations: tuple[MutationRecord, ...]

    def pack(self, config: Config, checksum: int) -> bytes:
        """Return the recipe and the ``checksum`` of the new population as :func:`recipe_reply`."""
        values = {"checksum": checksum}
        values |= {f"parent_{i}": slot for i, slot in enumerate(self.parents)}
        values |= {f"survivor_{i}": slot for i, slot in enumerate(self.survivors)}
        for i, mutation in enumerate(self.mutations):
            values[f"applied_{i}"] = mutation.applied
            values[f"child_{i}"] = mutation.child
            values[f"index_{i}"] = mutation.index
            if i < config.patches:
                values[f"waypoint_{i}"] = mutation.waypoint
        return recipe_reply(config).pack(**values)

    @classmethod
    def unpack(cls, config: Config, payload: bytes) -> tuple[Recipe, int]:
        """Return the recipe and the checksum in ``payload``: the inverse of :meth:`pack`.

        Raises
        ------
        ValueError
            If the payload has the wrong size.
        """
        values = recipe_reply(config).unpack(payload)
        mutations = tuple(
            MutationRecord(
                kind,
                bool(values[f"applied_{i}"]),
                values[f"child_{i}"],
                values[f"index_{i}"],
                values.get(f"waypoint_{i}", 0),
            )
            for i, kind in enumerate(config.mutations)
        )
        recipe = cls(
            tuple(values[f"parent_{i}"] for i in range(config.crossovers)),
            tuple(values[f"survivor_{i}"] for i in range(config.survivors)),
            mutations,
        )
        return recipe, values["checksum"]


def crossover(parents: Sequence[list[int]]) -> list[list[int]]:
    """Return the children of ``parents``, joined in a ring (*allaire-2008*, section 4.5).

    Module ``i`` takes parents ``i`` and ``i + 1``, the last module the first parent again, so that
    each parent is used twice. Child ``2 i`` has the head of ``i`` and the tail of ``i + 1``; child
    ``2 i + 1`` the head of ``i + 1`` and the tail of ``i``. The middle is rounded down, so that
    lengths stay within 2..max for any parents.
    """
    heads = [path[: len(path) // 2] for path in parents]
    tails = [path[len(path) // 2 :] for path in parents]
    children = []
    for i in range(len(parents)):
        j = (i + 1) % len(parents)
        children += [heads[i] + tails[j], heads[j] + tails[i]]
    return children


def may_mutate(config: Config, kind: MutationKind, length: int) -> bool:
    """Return whether the length limits allow ``kind`` on a child of ``length`` waypoints."""
    if kind is MutationKind.DELETE:
        return length > config.MIN_WAYPOINTS
    return kind is MutationKind.PERTURB or length < config.max_waypoints


def mutate(children: Sequence[list[int]], mutation: MutationRecord) -> None:
    """Apply ``mutation`` to its child, in place.

    The mutators work on different children, so their order does not matter.
    """
    path, index = children[mutation.child], mutation.index
    if not mutation.applied:
        return
    if mutation.kind is MutationKind.DELETE:
        del path[index]
    elif mutation.kind is MutationKind.PERTURB:
        path[index] = mutation.waypoint
    else:
        path.insert(index + 1, mutation.waypoint)


def keep(config: Config, order: Sequence[int], survivors: Sequence[int]) -> tuple[int, ...]:
    """Return the slots of surviving paths: the elites of ``order``, then the ``survivors``."""
    return (*order[: config.elites], *survivors)


def breed(
    config: Config, paths: Sequence[list[int]], order: Sequence[int], recipe: Recipe
) -> list[list[int]]:
    """Return the population that ``recipe`` makes from ``paths``.

    Parameters
    ----------
    paths : sequence of list of int
        Content of every slot before the generation.
    order : sequence of int
        The slots from the best path to the worst.

    Raises
    ------
    IndexError
        If the recipe names a slot, a child or a waypoint that does not exist.
    """
    children = crossover([paths[slot] for slot in recipe.parents])
    for mutation in recipe.mutations:
        mutate(children, mutation)
    return [paths[slot] for slot in keep(config, order, recipe.survivors)] + children
