"""The memory of the populations, and the pool of slots, against lists."""

import random

import pytest

from pathgene.hdl.planner.population_memory import PopulationMemory, SlotPool
from tests.support.gateware.streams import pulse, shared, simulate


@pytest.mark.parametrize(("total", "depth"), [(2, 1), (12, 4), (150, 22)])
def test_random_traffic_of_slots(total, depth):
    """Each slot handed out is free; unused slots come first, then returned ones, in order."""
    dut = shared(SlotPool, total, depth)
    rng = random.Random(total)

    async def bench(ctx):
        for _ in range(3):
            used, back, unused = [], [], 0
            offered = None
            for _ in range(60 + 5 * total):
                ready = rng.random() < 0.6
                puts = bool(used) and len(back) < depth and rng.random() < 0.3
                slot = used.pop(rng.randrange(len(used))) if puts else 0
                ctx.set(dut.slots.ready, ready)
                ctx.set(dut.put, puts)
                ctx.set(dut.slot, slot)
                valid, given = ctx.get(dut.slots.valid), ctx.get(dut.slots.payload)
                assert valid == (offered is not None)
                if valid:
                    assert given == offered
                    if ready:
                        used.append(offered)
                        offered = None
                else:
                    if unused < total:
                        offered, unused = unused, unused + 1
                    elif back:
                        offered = back.pop(0)
                if puts:
                    back.append(slot)
                await ctx.tick()
            assert unused == total
            ctx.set(dut.put, 0)
            await pulse(ctx, dut.clear)

    simulate(dut, bench)


SIZES = {"slots": 11, "max_waypoints": 5, "coordinate_bits": 5, "altitude_bits": 8}
AXES = ("x", "y", "altitude")


@pytest.mark.parametrize("longest", [5, 7, 8])
def test_random_traffic(longest):
    """Each cycle has a read, and writes of waypoints, margins and flags in other slots."""
    dut = shared(PopulationMemory, **SIZES | {"max_waypoints": longest})
    rng = random.Random(1)
    places = [(slot, index) for slot in range(11) for index in range(longest)]
    waypoints, margins, walked = {}, {}, {}
    compared = {True: 0, False: 0}

    def held(place):
        """The waypoint with the valid margin; None if there is none yet."""
        was_walked = walked.get(place[0])
        if place not in waypoints or was_walked is None or (was_walked and place not in margins):
            return None
        compared[was_walked] += 1
        *corner, inherited = waypoints[place]
        return *corner, margins[place] if was_walked else inherited

    async def bench(ctx):
        reads = [None, None]
        for _ in range(4000):
            expected = reads.pop(0)
            if expected is not None:
                waypoint = ctx.get(dut.waypoint)
                assert (*(waypoint[axis] for axis in AXES), waypoint.margin) == expected
            slot, index = rng.choice(places)
            ctx.set(dut.read, {"slot": slot, "index": index})
            reads.append(held((slot, index)))
            others = [place for place in places if place[0] != slot]

            place, valid = rng.choice(others), rng.random() < 0.5
            corner = [rng.getrandbits(bits) for bits in (5, 5, 8)]
            margin = rng.choice((-255, 255, rng.randint(-255, 255)))
            ctx.set(
                dut.write,
                {
                    "valid": valid,
                    "place": {"slot": place[0], "index": place[1]},
                    "waypoint": {**dict(zip(AXES, corner, strict=True)), "margin": margin},
                },
            )
            if valid:
                waypoints[place] = *corner, margin

            place, valid = rng.choice(others), rng.random() < 0.5
            margin = rng.choice((-255, 255, rng.randint(-255, 255)))
            ctx.set(
                dut.margin,
                {
                    "valid": valid,
                    "place": {"slot": place[0], "index": place[1]},
                    "margin": margin,
                },
            )
            if valid:
                margins[place] = margin

            slot, valid, is_walked = rng.choice(others)[0], rng.random() < 0.5, rng.random() < 0.5
            ctx.set(dut.decided, {"valid": valid, "slot": slot, "walked": is_walked})
            if valid:
                walked[slot] = is_walked
            await ctx.tick()

    simulate(dut, bench)
    assert len(waypoints) == len(margins) == len(places)
    assert min(compared.values()) > 1000


@pytest.mark.parametrize(
    ("slots", "longest", "depth"),
    [(108, 16, 1728), (108, 18, 2008), (108, 24, 2912), (11, 5, 59), (11, 7, 88), (2, 2, 4)],
)
def test_depth(slots, longest, depth):
    """Long paths need at most as many rows as the next power of two for each."""
    assert PopulationMemory(slots, longest, 2, 2).depth == depth
