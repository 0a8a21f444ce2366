"""Parser of the order of a GENERATE: it accepts permutations, and ends once they are applied."""

import random

import pytest

from pathgene.hdl.command.ranking_parser import RankingParser
from pathgene.hdl.protocol.codes import Status
from tests.support.gateware.payloads import hand_over
from tests.support.gateware.streams import collect, shared


SLOTS = 16
PAUSES = pytest.mark.parametrize("pauses", [(0,), (0, 3, 1)], ids=["steady", "stalled"])


def ranks_of(payloads, *, identity=0, repeated=False, pauses=(0,), delay=3):
    """Return the outcomes of ``payloads``, and each rank with its slot in order of arrival.

    The core applies an order ``delay`` cycles after its last rank.
    """
    unit = shared(RankingParser, SLOTS)
    ranks = []

    async def apply(ctx):
        waited = 0
        while True:
            waited = waited + 1 if ranks and len(ranks) % SLOTS == 0 else 0
            ctx.set(unit.ranked, waited >= delay)
            await ctx.tick()

    outcomes = hand_over(
        unit,
        payloads,
        {"identity": identity},
        repeated=repeated,
        collectors=(collect(unit.ranking, ranks, pauses), apply),
    )
    return outcomes, [(each.rank, each.slot) for each in ranks]


def orders(count, seed=1):
    rng = random.Random(seed)
    return [rng.sample(range(SLOTS), SLOTS) for _ in range(count)]


@PAUSES
def test_permutations_pass_in_order(pauses):
    drawn = orders(5)
    outcomes, ranks = ranks_of([bytes(order) for order in drawn], pauses=pauses)
    assert [status for status, _ in outcomes] == [Status.OK] * 5
    assert ranks == [pair for order in drawn for pair in enumerate(order)]


@PAUSES
def test_slots_that_are_in_order_already(pauses):
    outcomes, ranks = ranks_of([b"", b""], identity=1, pauses=pauses)
    assert [status for status, _ in outcomes] == [Status.OK] * 2
    assert ranks == [(slot, slot) for slot in range(SLOTS)] * 2


@pytest.mark.parametrize("delay", [1, 2, 20])
def test_done_when_the_core_has_applied_the_order(delay):
    """It takes two cycles per slot and two more, or the core's cycles if these are more."""
    outcomes, _ = ranks_of([bytes(orders(1)[0])], delay=delay)
    assert outcomes == [(Status.OK, 2 * SLOTS + max(2, delay))]


def test_what_is_repeated_does_not_reach_the_core():
    payload = bytes(orders(1)[0])
    assert ranks_of([payload], repeated=True) == ([(Status.OK, 2 * SLOTS + 1)], [])
    assert ranks_of([b""], identity=1, repeated=True) == ([(Status.OK, 1)], [])


@pytest.mark.parametrize(
    ("payload", "identity", "status"),
    [
        (range(SLOTS - 1), 0, Status.BAD_LENGTH),
        ((), 0, Status.BAD_LENGTH),
        ((*range(SLOTS), 0), 0, Status.BAD_LENGTH),
        ((0,), 1, Status.BAD_LENGTH),
        ((*range(SLOTS - 1), 0), 0, Status.BAD_VALUE),
        ((*range(SLOTS - 1), SLOTS), 0, Status.BAD_VALUE),
        ((*range(SLOTS - 1), 255), 0, Status.BAD_VALUE),
        ((SLOTS, *range(1, SLOTS)), 0, Status.BAD_VALUE),
    ],
)
def test_refused(payload, identity, status):
    outcomes, _ = ranks_of([bytes(payload)], identity=identity)
    assert [each for each, _ in outcomes] == [status]
