"""Detours compared with all possible routes, laid out and checked by the reference geometry."""

import dataclasses
import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pathgene.host.evaluation.geometry import smooth
from pathgene.host.planners.grid import detours as module
from pathgene.host.planners.grid.detours import detours
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.terrain import Terrain


FLAT = Terrain("flat", np.full((61, 61), 100.0), 100.0, 100.0)
START, GOAL = (2000.0, 3000.0, 300.0), (5000.0, 3000.0, 420.0)
INNER = np.array([(2600.0, 3300, 310), (3300, 2600, 330), (4200, 3300, 350)])
HEADINGS = [(None, None), (80.0, None), (None, 100.0), (200.0, 30.0)]


def flight(*headings, **options):
    start, goal = headings or (None, None)
    return Problem(
        FLAT,
        START,
        GOAL,
        rules=Rules(),
        start_heading_deg=start,
        goal_heading_deg=goal,
        **options,
    )


def path_through(inner):
    return np.concatenate(([START], inner, [GOAL])).astype(float)


def places_of(problem, path, *, at_goal):
    """Return the waypoints of every route to every point that it may join, in complex numbers."""
    points = (path[::-1] if at_goal else path)[:, :2] @ (1, 1j)
    heading = problem.headings[at_goal]
    ways, counts = module._free_ways() if heading is None else module._held_ways()
    ahead = 1 if heading is None else complex(*heading) * (-1 if at_goal else 1)
    ends = len(points) - (1 if problem.headings[not at_goal] is None else 2)
    for join in range(1, 1 + min(6, ends)):
        for way, count in zip(ways @ (1, 1j), counts, strict=True):
            placed = points[0] + problem.limits.turn_radius_m * ahead * way[:count]
            whole = np.concatenate((points[:1], placed, points[join:]))
            yield whole[::-1] if at_goal else whole


def length_of(places):
    return abs(np.diff(places)).sum()


def fits(places, problem, *, at_goal, path):
    """Return whether the turns of a detour at and after the join fit, by the reference geometry.

    Later turns are not checked: the track ends with the second point after the join, whose turn
    still needs room before it.
    """
    if (abs(np.diff(places)) == 0).any():
        return False
    inner = places[::-1] if at_goal else places
    points = (path[::-1] if at_goal else path)[:, :2] @ (1, 1j)
    join = next(at for at, place in enumerate(inner) if at and (points[1:] == place).any())
    part = inner[: join + 3]
    heading = problem.headings[at_goal]
    sign = -1 if at_goal else 1
    start = None if heading is None else (sign * heading[0], sign * heading[1])
    places_m = np.column_stack((part.real, part.imag, np.zeros(len(part))))
    smoothed = smooth(places_m, problem.limits.turn_radius_m, (start, None))
    return smoothed.impossible_arcs == 0


@pytest.mark.parametrize("at_goal", [False, True])
@pytest.mark.parametrize("headings", HEADINGS)
@settings(max_examples=3, deadline=None)
@given(seed=st.integers(0, 999))
def test_exactly_those_whose_turns_fit_shortest_first(headings, at_goal, seed):
    problem = flight(*headings)
    rng = np.random.default_rng(seed)
    path = path_through(INNER + rng.uniform(-400, 400, (3, 3)))
    paths, lengths = detours(problem, path, at_goal=at_goal)
    assert paths.shape == (len(lengths), len(path) + 3, 3)
    found = [each[:n, :2] @ (1, 1j) for each, n in zip(paths, lengths, strict=True)]
    metres = [length_of(each) for each in found]
    assert metres == pytest.approx(sorted(metres))
    every = list(places_of(problem, path, at_goal=at_goal))
    fitting = [each for each in every if fits(each, problem, at_goal=at_goal, path=path)]
    assert 50 < len(fitting) < 0.9 * len(every)

    def rounded(ways):
        return sorted(tuple(np.round(each, 3)) for each in ways)

    assert len(set(rounded(every))) == len(every)
    assert [len(each) for each in found].count(3) == [len(each) for each in fitting].count(3)
    known, wanted = set(rounded(found)), set(rounded(fitting))
    assert len(known) == len(found)
    # Rounding decides whether a turn fits that takes up all of its room.
    assert len(known ^ wanted) <= 0.01 * len(wanted)


@pytest.mark.parametrize("headings", HEADINGS)
@pytest.mark.parametrize("at_goal", [False, True])
def test_ends_headings_and_altitudes(headings, at_goal):
    problem = flight(*headings)
    path = path_through(INNER)
    paths, lengths = detours(problem, path, at_goal=at_goal)
    assert len(lengths) > 50
    for each, n in zip(paths[::7], lengths[::7].tolist(), strict=True):
        each = each[:n]
        assert (each[0] == START).all()
        assert (each[-1] == GOAL).all()
        end, heading = (each[::-1], headings[1]) if at_goal else (each, headings[0])
        if heading is not None:
            east, north = (end[1] - end[0])[:2] * (-1 if at_goal else 1)
            assert math.degrees(math.atan2(east, north)) % 360 == pytest.approx(heading)
        # Altitude changes linearly from the end to the join.
        joins = next(i for i in range(1, n) if (path == end[i]).all(axis=1).any())
        way = np.hypot(*np.diff(end[: joins + 1, :2], axis=0).T).cumsum()
        rises = (end[1 : joins + 1, 2] - end[0, 2]) / way
        assert rises == pytest.approx(np.full(joins, rises[-1]), abs=1e-12)


def test_the_way_to_the_other_end_stays_where_it_has_a_heading():
    path = path_through(INNER)
    shortest = {
        headings: min(detours(flight(*headings), path, at_goal=True)[1])
        for headings in ((None, None), (80.0, None))
    }
    assert shortest == {(None, None): 3, (80.0, None): 4}


def test_no_detours_for_an_aircraft_that_cannot_turn():
    """It stalls in the tightest turn."""
    heavy = dataclasses.replace(aircraft.load("silver-fox"), weight_N=2000.0)
    problem = flight(aircraft=heavy)
    assert not math.isfinite(problem.limits.turn_radius_m)
    paths, lengths = detours(problem, path_through(INNER), at_goal=False)
    assert len(paths) == len(lengths) == 0


def test_a_straight_path_has_detours():
    """The exception is a far end with a heading, to which no route can lead."""
    for at_goal, headings in itertools.product((False, True), HEADINGS):
        paths, _ = detours(flight(*headings), path_through(INNER[:0]), at_goal=at_goal)
        assert (len(paths) > 50) == (headings[not at_goal] is None)
