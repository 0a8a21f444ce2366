"""The one-hot sequencer: only a state's steps leave it, and the history has every entry."""

import random

import pytest

from pathgene.hdl.primitives.one_hot_sequencer import OneHotSequencer
from pathgene.hdl.protocol.codes import ChipState
from tests.support.gateware.streams import simulate


STEPS = [
    (ChipState.LISTEN, ChipState.RECEIVE),
    (ChipState.RECEIVE, ChipState.CHECK),
    (ChipState.RECEIVE, ChipState.TRANSMIT),
    (ChipState.CHECK, ChipState.TRANSMIT),
    (ChipState.TRANSMIT, ChipState.LISTEN),
]


def test_random_steps():
    """Requests are random, at most one per state; requests of inactive states have no effect."""
    dut = OneHotSequencer(ChipState.LISTEN, STEPS, history_length=8, history_entry_bits=4)
    seen = set()

    async def bench(ctx):
        rng = random.Random(1)
        state = ChipState.LISTEN
        entered = noted = 0
        for _ in range(400):
            assert ctx.get(dut.state) == state
            assert [of for of in dut.states if ctx.get(dut.on[of.name.lower()])] == [state]
            assert ctx.get(dut.history) == noted
            taken = {
                source: rng.choice([None, *(step for step in STEPS if step[0] is source)])
                for source in ChipState
            }
            ctx.set(dut.take, sum((step in taken.values()) << i for i, step in enumerate(STEPS)))
            noted = entered
            if taken[state]:
                seen.add(taken[state])
                state = taken[state][1]
                entered = (entered << 4 | state) & 0xFFFFFFFF
            await ctx.tick()

    simulate(dut, bench)
    assert seen == set(STEPS)


def sequencer(**changes):
    arguments = {
        "initial": ChipState.LISTEN,
        "steps": STEPS,
        "history_length": 8,
        "history_entry_bits": 4,
    }
    return OneHotSequencer(**{**arguments, **changes})


def test_sizes_are_checked():
    assert sequencer(history_length=1, history_entry_bits=3).history.shape().width == 3
    for changes, error, message in (
        ({"history_length": 0}, ValueError, "History must be 1 or more, not 0"),
        ({"history_length": "8"}, TypeError, "History must be an integer, not '8'"),
        ({"history_entry_bits": 2}, ValueError, "History entry width must be 3 or more, not 2"),
        ({"initial": 0}, TypeError, "Initial state must be a member of an IntEnum, not 0"),
        (
            {"steps": [(ChipState.LISTEN, 1)]},
            TypeError,
            "State must be a member of ChipState, not 1",
        ),
    ):
        with pytest.raises(error, match=f"^{message}$"):
            sequencer(**changes)
