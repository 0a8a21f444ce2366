"""Comparison of headers: every pair of numbers near the expected one, and every session."""

from amaranth.sim import Simulator

from pathgene.hdl.command.header_comparator import HeaderComparator


def compare(cases):
    """Return the outputs for ``cases``, dictionaries of inputs, 1 cycle after each."""
    unit = HeaderComparator()
    outcomes = []

    async def bench(ctx):
        for case in cases:
            for name, value in case.items():
                ctx.set(getattr(unit, name), value)
            await ctx.tick()
            names = ("same_session", "next_session", "present", "previous", "future")
            outcomes.append({name for name in names if ctx.get(getattr(unit, name))})

    simulator = Simulator(unit)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    return outcomes


def test_every_sequence_number():
    for expected in (0, 1, 127, 128, 255):
        outcomes = compare(
            [
                {"session": 3, "open_session": 9, "expected": expected, "sequence": sequence}
                for sequence in range(256)
            ]
        )
        for sequence, outcome in enumerate(outcomes):
            ahead = (sequence - expected) % 256
            if ahead == 0:
                assert outcome == {"present"}
            elif ahead == 255:
                assert outcome == {"previous"}
            else:
                assert outcome == ({"future"} if ahead <= 128 else set())


def test_every_session():
    for opened in (0, 7, 254, 255):
        outcomes = compare([{"session": session, "open_session": opened} for session in range(256)])
        assert [s for s, outcome in enumerate(outcomes) if "same_session" in outcome] == [opened]
        following = [s for s, outcome in enumerate(outcomes) if "next_session" in outcome]
        assert following == [(opened + 1) % 256]
