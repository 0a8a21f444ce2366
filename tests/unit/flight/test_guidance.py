"""L1 on a line and a circle, for a point that obeys at once."""

import math

import pytest

from pathgene.host.evaluation.geometry import Arc
from pathgene.host.flight.guidance import MEAN_S, PEAK, Guidance, Limits, State
from pathgene.host.flight.route import Route
from pathgene.host.problem.limits import GRAVITY_M_S2
from tests.unit.flight.conftest import arc, straight


SPEED, PERIOD = 23.0, 1 / 30
LIMITS = Limits(bank_rad=math.radians(25), climb_m_s=4.0, descent_m_s=8.0)


def guidance(pieces, limits=LIMITS):
    return Guidance(
        Route(pieces, 300.0),
        limits,
        lookahead_s=3.3,
        lead_s=1.0,
        height_gain=0.35,
        period_s=PERIOD,
    )


def state(x, y, z, course, climb=0.0, speed=SPEED):
    return State(
        time_s=0.0, x=x, y=y, z=z, east_m_s=speed * math.cos(course),
        north_m_s=speed * math.sin(course), climb_m_s=climb, airspeed_m_s=speed, roll_rad=0.0,
        pitch_rad=0.0, p_rad_s=0.0, q_rad_s=0.0, sideslip_rad=0.0, power_W=0.0,
    )  # fmt: skip


def fly(guide, x, y, z, course, seconds):
    """Move a point that takes every command at once; return the commands."""
    taken = []
    for _ in range(round(seconds / PERIOD)):
        commands = guide.commands(state(x, y, z, course))
        course -= GRAVITY_M_S2 * math.tan(commands.bank_rad) / SPEED * PERIOD
        x += SPEED * math.cos(course) * PERIOD
        y += SPEED * math.sin(course) * PERIOD
        z += commands.climb_m_s * PERIOD
        taken.append(commands)
    return taken


@pytest.mark.parametrize("aside", [-60.0, 5.0, 200.0])
def test_converges_on_a_line(aside):
    last = fly(guidance([straight((0.0, 0.0, 100.0), 5000.0)]), 0, aside, 140, 0.5, 60)[-1]
    assert last.place.cross_m == pytest.approx(0, abs=0.05)
    assert last.height_error_m == pytest.approx(0, abs=0.05)
    assert last.bank_rad == pytest.approx(0, abs=1e-3)


@pytest.mark.parametrize("turn", [300.0, -300.0])
def test_converges_on_a_circle(turn):
    pieces = [arc((0.0, 0.0, 100.0), 200.0, turn / 2)]
    last = fly(guidance(pieces), 0, 15, 100, 0.0, 18)[-1]
    assert last.place.cross_m == pytest.approx(0, abs=0.5)
    bank = math.atan(SPEED**2 / (GRAVITY_M_S2 * 200))
    assert last.bank_rad == pytest.approx(-math.copysign(bank, turn), rel=0.03)


def test_flies_the_slope_of_the_route():
    pieces = [straight((0.0, 0.0, 100.0), 3000.0, rise_m=300.0)]
    last = fly(guidance(pieces), 0, 0, 100, 0.0, 30)[-1]
    assert last.climb_m_s == pytest.approx(0.1 * SPEED, rel=1e-3)
    assert last.height_error_m == pytest.approx(0, abs=0.01)


def test_mean_of_the_bank_keeps_the_limit():
    # A circle that this bank cannot hold.
    commands = fly(guidance([arc((0.0, 0.0, 0.0), 60.0, 170.0)]), -50, 0, 0, 0.0, 40)
    banks = [abs(command.bank_rad) for command in commands]
    count = round(MEAN_S / PERIOD)
    means = [sum(banks[i : i + count]) / count for i in range(len(banks) - count)]
    assert max(means) <= LIMITS.bank_rad * (1 + 1e-9)
    assert 1.1 * LIMITS.bank_rad < max(banks) <= PEAK * LIMITS.bank_rad
    assert max(command.slow for command in commands) > 0.01


def test_vertical_speed_keeps_its_limits():
    guide = guidance([straight((0.0, 0.0, 100.0), 5000.0)])
    assert guide.commands(state(0, 0, 500, 0.0)).climb_m_s == -8.0
    assert guide.commands(state(0, 0, 0, 0.0)).climb_m_s == 4.0


def test_turns_back_to_a_route_behind():
    guide = guidance([straight((0.0, 0.0, 100.0), 5000.0)])
    assert abs(guide.commands(state(500, 20, 100, math.pi)).bank_rad) > LIMITS.bank_rad


def test_follows_another_route_from_where_it_begins():
    guide = guidance([straight((0.0, 0.0, 100.0), 5000.0)])
    guide.commands(state(2000, 0, 100, 0.0))
    guide.follow(Route([straight((0.0, 40.0, 100.0), 5000.0)]))
    place = guide.commands(state(2000, 0, 100, 0.0)).place
    assert (place.along_m, place.cross_m) == pytest.approx((2000, -40))


def test_follows_a_route_that_comes_by_the_same_place_again():
    guide = guidance([straight((0.0, 0.0, 100.0), 5000.0)])
    first, *others = (arc((0.0, 0.0, 100.0), 150.0, 120.0) for _ in range(3))
    route = [first]
    for _ in others:
        before = Route(route)
        (x, y), along = before.point(before.length_m), before.length_m
        xa, ya = before.point(along - 1e-3)
        route.append(
            Arc((x, y, 100.0), ((x - xa) / 1e-3, (y - ya) / 1e-3), 150.0, math.radians(120.0), 0.0)
        )
    guide.follow(Route(route))
    x, y = Route(route).point(30.0)
    for _ in range(5):
        place = guide.commands(state(x, y, 100, math.radians(12))).place
        assert place.along_m == pytest.approx(30.0, abs=0.1)
