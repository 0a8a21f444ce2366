"""Every header is compared with every expected one, and the fields of commands are tested."""

import pytest

from pathgene.hdl.command.field_decoder import FieldDecoder, request_fields
from pathgene.hdl.command.header_comparator import HeaderComparator
from pathgene.hdl.config import Config
from tests.support.gateware.streams import shared, simulate


def compare(cases):
    """Return the outputs for ``cases``, dictionaries of inputs, 1 cycle after each."""
    unit = shared(HeaderComparator)
    outcomes = []

    async def bench(ctx):
        for case in cases:
            for name, value in case.items():
                ctx.set(getattr(unit, name), value)
            await ctx.tick()
            names = ("same_session", "next_session", "present", "previous", "future")
            outcomes.append({name for name in names if ctx.get(getattr(unit, name))})

    simulate(unit, bench)
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


FIELDS = {
    "fields": request_fields(Config()),
    "population": 32,
    "children": 22,
    "map_size": 512,
    "altitude_bits": 12,
    "max_waypoints": 16,
}


@pytest.mark.parametrize(
    ("design", "checker"),
    [
        ("paper", "none"),
        ("none", "parallel"),
        ("paper", "parallel"),
        ("planner", "parallel"),
    ],
)
def test_the_decoder_has_the_members_of_its_commands(design, checker):
    fields = request_fields(Config(core=design, checker=checker, lanes=1))
    members = set(FieldDecoder(**{**FIELDS, "fields": fields}).signature.members)
    common = {"code", "byte", "take", "ended", "status", "kind", "slot", "count"}
    core, checks = {"start", "write_slot", "identity"}, {"checks", "checked"}
    state = {"repeated", "running", "has_problem", "has_population"}
    runs = {"problem", "run", "shape", "guide", "coded"} | state
    assert members == common.union(
        core if design == "paper" else (),
        ["rectangle"] if checker == "parallel" else (),
        checks if design != "planner" and checker == "parallel" else (),
        runs if design == "planner" else (),
    )
