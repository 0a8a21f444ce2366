"""Places near straights and arcs, and the law L1 on them for a point that follows immediately."""

import math

import numpy as np
import pytest

from pathgene.host.evaluation.geometry import Arc, smooth
from pathgene.host.flight.guidance import MEAN_S, PEAK, Guidance, Limits, State
from pathgene.host.flight.route import Route
from pathgene.host.problem.limits import GRAVITY_M_S2
from tests.unit.flight.conftest import arc, straight


PATH = np.array(
    [(0, 0, 100), (900, 100, 150), (1500, 900, 120), (800, 1700, 300), (-500, 1500, 250)],
    dtype=float,
)
PIECES = smooth(PATH, 150.0).pieces


def test_length_is_horizontal_without_lead_in():
    route = Route(PIECES, 500.0)
    assert route.length_m == pytest.approx(sum(piece.run_m for piece in PIECES))


def test_points_and_heights_are_those_of_the_pieces():
    route = Route(PIECES, 500.0)
    along = 0.0
    for piece in PIECES:
        for share in (0.0, 0.25, 0.5, 0.999):
            x, y, z = piece.points(np.array([share]))[0]
            assert route.point(along + share * piece.run_m) == pytest.approx((x, y), abs=1e-6)
            height, slope = route.height(along + share * piece.run_m)
            assert height == pytest.approx(z)
            assert slope == pytest.approx(piece.rise_m / piece.run_m)
        along += piece.run_m


@pytest.mark.parametrize("cross", [-40.0, 0.0, 25.0])
def test_locates_points_beside_the_route(cross):
    route = Route(PIECES, 500.0)
    leg = 0
    for along in np.arange(-400.0, route.length_m, 7.0):
        (x0, y0), (x1, y1) = route.point(along - 0.01), route.point(along + 0.01)
        (x, y), step = route.point(along), math.hypot(x1 - x0, y1 - y0)
        left = (-(y1 - y0) / step, (x1 - x0) / step)
        at = (x + cross * left[0], y + cross * left[1])
        place = route.locate(*at, leg)
        leg = place.leg
        # Kinks of the differences at the joints of pieces.
        assert place.along_m == pytest.approx(along, abs=0.01 * abs(cross) + 0.02)
        assert place.cross_m == pytest.approx(cross, abs=0.01)


def test_arc_of_more_than_a_half_circle_of_lead():
    route = Route([arc((0.0, 0.0, 0.0), 100.0, 170.0)])
    x, y = route.point(math.radians(165) * 100)
    assert route.locate(x, y).along_m == pytest.approx(math.radians(165) * 100)


def test_lead_in_and_run_out_go_straight_on():
    route = Route([straight((10.0, 20.0, 100.0), 1000.0, rise_m=50.0)], 200.0)
    assert route.start == pytest.approx((-190.0, 20.0, 90.0, 1.0, 0.0))
    assert route.point(1300.0) == pytest.approx((1310.0, 20.0))
    assert route.height(1300.0) == pytest.approx((165.0, 0.05))


def test_refuses_what_is_no_route():
    with pytest.raises(ValueError, match=r"^Route must have a piece with a horizontal length$"):
        Route([])
    with pytest.raises(ValueError, match=r"^Lead-in must be 0 m or more, not -1$"):
        Route(PIECES, -1)


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
    """Move a point that follows every command immediately; return the commands."""
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
