# amaranth: UnusedElaboratable=no
"""The memory of waypoints against a dictionary."""

import random

from hdl.planner.population_memory import PopulationMemory
from tests.streams import simulate
from tests.wrong_sizes import check_sizes


SIZES = {"slots": 11, "max_waypoints": 5, "coordinate_bits": 5, "altitude_bits": 8}


def test_random_traffic():
    """A write, a margin and a read in each cycle; a row is not read while it is written."""
    dut = PopulationMemory(**SIZES)
    rng = random.Random(1)
    places = [(slot, index) for slot in range(11) for index in range(5)]
    held = {}
    margins_written = 0

    async def bench(ctx):
        nonlocal margins_written
        reads = [None, None]
        for _ in range(4000):
            expected = reads.pop(0)
            if expected is not None:
                waypoint = ctx.get(dut.waypoint)
                assert (waypoint.x, waypoint.y, waypoint.altitude, waypoint.margin) == expected
            slot, index = rng.choice(places)
            ctx.set(dut.read, {"slot": slot, "index": index})
            reads.append(held.get((slot, index)))
            others = [place for place in places if place != (slot, index)]

            writes = rng.random() < 0.5
            place = rng.choice(others)
            corner = [rng.getrandbits(bits) for bits in (5, 5, 8)]
            margin = rng.choice((-255, 255, rng.randint(-255, 255)))
            x, y, altitude = corner
            # Those of a place that has no margin yet write both.
            corners_only = place in held and rng.random() < 0.5
            ctx.set(dut.corners_only, corners_only)
            ctx.set(
                dut.write,
                {
                    "valid": writes,
                    "place": {"slot": place[0], "index": place[1]},
                    "waypoint": {"x": x, "y": y, "altitude": altitude, "margin": margin},
                },
            )
            writes_both = writes and not corners_only
            if writes:
                held[place] = (*corner, margin if writes_both else held[place][3])

            known = [place for place in others if place in held]
            gives = bool(known) and rng.random() < 0.5
            place = rng.choice(known or others)
            margin = rng.randint(-255, 255)
            ctx.set(dut.margins.valid, gives)
            ctx.set(
                dut.margins.payload,
                {"place": {"slot": place[0], "index": place[1]}, "margin": margin},
            )
            assert ctx.get(dut.margins.ready) == (not writes_both)
            if gives and not writes_both:
                held[place] = (*held[place][:3], margin)
                margins_written += 1
            await ctx.tick()

    simulate(dut, bench)
    assert len(held) == len(places)
    assert margins_written > 500


def test_sizes():
    check_sizes(
        PopulationMemory,
        SIZES,
        {
            "slots": ("Slots", 2),
            "max_waypoints": ("Max waypoints", 2),
            "coordinate_bits": ("Coordinate width", 1),
            "altitude_bits": ("Altitude width", 1),
        },
    )
