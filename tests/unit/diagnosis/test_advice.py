"""Following the figure of a reason removes the reason, however little is missing."""

from dataclasses import replace

import numpy as np
import pytest

from pathgene.host.diagnosis import diagnose
from pathgene.host.diagnosis.reason import broken_limit, rounded_down, rounded_up
from pathgene.host.problem.aircraft import load
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain
from tests.support.host.closed_problems import KINDS


FOX = load("silver-fox")
#: Keys of the aircraft, and rules, by the limit in a figure.
AIRCRAFT = {
    "service-ceiling": "service_ceiling_m",
    "climb": "max_climb_deg",
    "descent": "max_descent_deg",
    "power": "engine_power_W",
    "fuel": "fuel_weight_N",
    "stall": "cruise_speed_m_s",
}
RULES = {"ceiling": "ceiling_m", "ceiling-agl": "ceiling_agl_m", "zone-margin": "zone_margin_m"}


def flat(height_m=100.0):
    return np.full((60, 60), height_m)


def problem(*zones, elevation=None, start_m=250.0, goal_m=250.0, aircraft=FOX, **options):
    ground = Terrain("made", flat() if elevation is None else elevation, 100.0, 100.0)
    ends = (500.0, 500.0, start_m), (5000.0, 5000.0, goal_m)
    return Problem(ground, *ends, aircraft, zones, **options)


def mended(given, figure):
    """Return the problem with the sufficient value, as printed."""
    value = float(f"{figure.would_do:.6g}")
    aircraft, rules, start, goal = given.aircraft, given.rules, given.start, given.goal
    if figure.limit in AIRCRAFT:
        aircraft = replace(aircraft, **{AIRCRAFT[figure.limit]: value})
    elif figure.limit in RULES:
        rules = replace(rules, **{RULES[figure.limit]: value})
    elif figure.limit == "start-altitude":
        start = (*start[:2], value)
    else:
        assert figure.limit == "goal-altitude"
        goal = (*goal[:2], value)
    return Problem(
        given.terrain, start, goal, aircraft, given.zones, given.wind, given.ds_m, rules=rules
    )


def assert_following_it_helps(given):
    reason = diagnose(given)
    after = diagnose(mended(given, reason.figure))
    assert limit_of(after) != limit_of(reason), after.sentence
    return reason


def limit_of(reason):
    return reason.code, None if reason.figure is None else reason.figure.limit


def pit(lacking_m):
    """Return a goal in a pit whose walls are too close, and too high by a given small amount."""
    heights = flat(920.0)
    heights[50, 50] = 100.0
    return problem(elevation=heights, start_m=1070.0, goal_m=280.0 - lacking_m)


def test_ground_beside_an_end_that_is_too_high_by_a_hair():
    reason = assert_following_it_helps(pit(0.03))
    assert reason.sentence == (
        "The ground within the corridor of 25 m is 0.1 m too high beside the goal, whatever the "
        "heading; raise the goal by 0.1 m, move it or give a smaller --corridor."
    )
    assert reason.figure.would_do == 280.1


@pytest.mark.parametrize("lacking_m", [0.002, 0.05, 0.1, 0.149, 12.34])
def test_raising_an_end_by_the_figure_mends_it(lacking_m):
    assert assert_following_it_helps(pit(lacking_m)).code == "goal"


@pytest.mark.parametrize("lacking_m", [0.002, 0.04, 0.1, 7.77])
@pytest.mark.parametrize("limit", ["ceiling", "service-ceiling", "ceiling-agl"])
def test_ceilings_below_an_end(limit, lacking_m):
    options = {
        "ceiling": {"rules": Rules(ceiling_m=250.0 - lacking_m)},
        "service-ceiling": {"aircraft": replace(FOX, service_ceiling_m=250.0 - lacking_m)},
        "ceiling-agl": {"rules": Rules(ceiling_agl_m=150.0 - lacking_m)},
    }
    given = problem(start_m=250.0, goal_m=240.0, **options[limit])
    reason = assert_following_it_helps(given)
    assert reason.figure.limit == limit
    assert " 0.0 m" not in reason.sentence


@pytest.mark.parametrize("away_m", [24.96, 0.04, 10.0])
def test_margin_of_a_zone_at_an_end(away_m):
    reason = assert_following_it_helps(problem(Circle(500, 700, 200 - away_m, name="K")))
    assert reason.figure.limit == "zone-margin"
    assert reason.figure.would_do < 25


def test_speed_at_which_the_turn_can_be_flown():
    """The bank of the turn grows with the speed, so the current stall speed would not suffice."""
    town = Polygon(((2900, 2900), (3100, 2900), (3100, 3100), (2900, 3100)), name="town")
    given = problem(town, aircraft=replace(FOX, lift_coefficient_max=0.4))
    reason = assert_following_it_helps(given)
    assert reason.figure.limit == "stall"
    assert reason.figure.would_do > given.limits.stall_speed_m_s
    # With a wing this small for the radius, no speed is enough.
    never = diagnose(problem(town, aircraft=replace(FOX, lift_coefficient_max=0.1)))
    assert (never.code, never.figure.would_do) == ("turn", None)


@pytest.mark.parametrize(
    "kind", [kind for kind in KINDS if "pit" not in kind.__name__], ids=lambda kind: kind.__name__
)
@pytest.mark.parametrize("seed", [0, 1])
def test_figures_of_random_problems(kind, seed):
    made = kind(np.random.default_rng([seed, KINDS.index(kind)]))
    figure = diagnose(made.problem).figure
    assert (figure is None) == (made.limit is None)
    if figure is None or figure.would_do is None:
        return
    if figure.limit != "power":
        assert_following_it_helps(made.problem)
        return
    # First level flight, then the climbs on the way.
    climbing = mended(made.problem, figure)
    if limit_of(diagnose(climbing)) == ("power", "power"):
        assert diagnose(climbing).figure.would_do > figure.would_do
        assert_following_it_helps(climbing)


@pytest.mark.parametrize("value", [0.0, 0.04, 0.1, 0.3, 29.999, 265.778, 1e5 / 3])
def test_roundings_stay_on_their_side(value):
    assert value - 1e-6 <= rounded_up(value) < value + 0.1
    assert value - 0.1 < rounded_down(value) <= value + 1e-6
    assert rounded_up(rounded_up(value)) == rounded_up(value)
    assert rounded_down(rounded_down(value)) == rounded_down(value)


def test_figures_of_a_broken_limit_never_look_alike():
    limit = {"limit": "clearance", "worst": 29.996, "allowed": 30.0, "at_m": 120.4}
    assert broken_limit([limit]) == (
        "breaks the limit clearance, 29.996 where 30 is allowed, 120 m from the start"
    )
    assert broken_limit([{**limit, "worst": 30.0}]) is None
    assert broken_limit([]) is broken_limit(None) is None
