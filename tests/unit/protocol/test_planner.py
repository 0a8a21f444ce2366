import dataclasses
import math
import re

import numpy as np
import pytest

from pathgene.hdl.protocol import breeding, planner
from pathgene.hdl.protocol.planner import (
    BASE_BITS,
    EDGES,
    NoFlyShape,
    ProblemRecord,
    no_fly_request,
    problem_request,
    seed_waypoints,
    turn_table,
)
from tests.support.planner.cases import LARGE, SMALL, USUAL, any_record, headed, record, shape


def test_turns_are_rounded_down():
    turns = turn_table()
    assert len(turns) == 258
    assert turns == tuple(math.floor(2 * math.atan(i / 64) * 4096) for i in range(258))


def test_an_interpolated_turn_is_never_too_great_and_within_three_parts():
    turns = turn_table()
    for half in range(4 * 4096 + 1):
        at, rest = half >> 6, half & 63
        turn = turns[at] + ((turns[at + 1] - turns[at]) * rest >> 6)
        exact = 2 * math.atan(half / 4096) * 4096
        assert exact - 3 <= turn <= exact


@pytest.mark.parametrize("config", [SMALL, USUAL, LARGE], ids=["small", "usual", "large"])
def test_a_record_comes_back_as_it_was_packed(config):
    rng = np.random.default_rng(18)
    for _ in range(100):
        sent = headed(config, rng, any_record(config, rng))
        payload = sent.pack(config)
        assert len(payload) == problem_request(config).size
        assert ProblemRecord.unpack(config, payload) == sent


def test_the_fixed_points_are_those_that_hosts_and_chips_agreed_on():
    """docs/chip_figures.md states them; a new value requires a new version of the protocol."""
    assert {name: getattr(planner, name) for name in planner.__all__ if name.isupper()} == {
        "ALTITUDE_FRACTION": 4,
        "BASE_BITS": 25,
        "BEND_BITS": 8,
        "BLOCKS": 64,
        "COARSE_BLOCKS": 32,
        "DRAG_FRACTION": 16,
        "EDGES": 8,
        "EXCESS_BITS": 2,
        "FAR": 1 << 30,
        "HIT_BITS": 10,
        "MEMO_ROWS": 512,
        "SWEEPS": 64,
        "SHARE_BITS": 16,
        "SHARPEST_BITS": 4,
        "STEEP": 64,
        "EDGE_BITS": 16,
        "FUEL_BITS": 16,
        "MAX_HALF_TURN": 4,
        "POSITION_FRACTION": 8,
        "RADIUS_BITS": 18,
        "RISE_BITS": 20,
        "RISE_FRACTION": 16,
        "SCALE_FRACTION": 14,
        "SEED_WAYPOINTS": (4, 16),
        "SLOPE_BITS": 24,
        "SLOPE_FRACTION": 12,
        "TURN_FRACTION": 12,
        "VALUE_BITS": 28,
    }


def test_the_odds_of_breeding_are_those_that_model_and_chips_agreed_on():
    assert {name: getattr(breeding, name) for name in breeding.__all__ if name.isupper()} == {
        "CUT": (62, 2),
        "DELETE": 11,
        "INSERT": 8,
        "MUTATIONS": 18,
        "OFFSETS": (20, 14),
        "OPERATOR": (0, 8),
        "PARENT_DRAWS": 4,
        "PLACE": (8, 8),
        "SETTLE": 14,
        "SIZE": (16, 4),
        "SURVIVOR_BITS": 24,
    }


def test_sizes_of_the_records():
    assert problem_request(USUAL).size == 53
    assert no_fly_request(USUAL).size == 65


@pytest.mark.parametrize("config", [SMALL, USUAL, LARGE], ids=["small", "usual", "large"])
def test_a_shape_comes_back_with_all_edges(config):
    rng = np.random.default_rng(22)
    for _ in range(100):
        sent = shape(config, rng)
        payload = sent.pack(config)
        assert len(payload) == no_fly_request(config).size
        received = NoFlyShape.unpack(config, payload)
        without_limit = ((0, 0, 0),) * (EDGES - len(sent.edges))
        assert received == dataclasses.replace(sent, edges=(*sent.edges, *without_limit))


@pytest.mark.parametrize(
    ("edges", "message"),
    [
        (((0, 0, 0),) * 9, "A shape must have at most 8 edges, not 9"),
        (((1 << 25, 0, 0),), "at_0 must fit in 26 bits with its sign, not 33554432"),
        (((0, 0, 0), (0, -32769, 0)), "east_1 must fit in 16 bits with its sign, not -32769"),
    ],
)
def test_a_shape_that_does_not_fit_is_refused(edges, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        NoFlyShape(first_x=0, first_y=0, last_x=1, last_y=1, edges=edges).pack(USUAL)


@pytest.mark.parametrize("bend", ["bend_x", "bend_y"])
def test_a_bend_without_an_edge_is_refused(bend):
    shape = NoFlyShape(first_x=0, first_y=0, last_x=1, last_y=1, edges=(), **{bend: 1})
    with pytest.raises(ValueError, match=r"^A shape with a bend must have an edge, which bends$"):
        shape.pack(USUAL)


@pytest.mark.parametrize("base", [1 << BASE_BITS - 1, -(1 << BASE_BITS - 1) - 1])
def test_a_base_that_does_not_fit_is_refused(base):
    with pytest.raises(ValueError, match=rf"^base must fit in 25 bits with its sign, not {base}$"):
        record(USUAL, np.random.default_rng(19), base=base).pack(USUAL)


@pytest.mark.parametrize(
    "changes",
    [
        {"altitude_limit": 4095},
        {"x_scale": (1 << 14) + 1},
        {"y_scale": (1 << 14) + 1},
        {"block_shift": 5},
        {"block_shift": 2},
        {"block_shift": 2, "x_limit": 255},
    ],
)
def test_a_record_out_of_range_is_no_problem(changes):
    valid = record(USUAL, np.random.default_rng(20))
    assert valid.is_valid(USUAL)
    assert not dataclasses.replace(valid, **changes).is_valid(USUAL)
    assert dataclasses.replace(valid, block_shift=3, x_limit=255, y_limit=255).is_valid(USUAL)


@pytest.mark.parametrize(
    ("box", "is_valid"), [((3, 4, 3, 4), True), ((3, 4, 2, 4), False), ((3, 4, 3, 3), False)]
)
def test_a_shape_has_a_box_of_a_corner_at_least(box, is_valid):
    shape = NoFlyShape(
        **dict(zip(("first_x", "first_y", "last_x", "last_y"), box, strict=True)), edges=()
    )
    assert shape.is_valid() == is_valid


@pytest.mark.parametrize(
    ("longest", "expected"), [(3, (3, 3)), (5, (4, 5)), (16, (4, 16)), (18, (4, 16)), (64, (4, 16))]
)
def test_waypoints_of_seeds(longest, expected):
    assert seed_waypoints(longest) == expected


def test_a_shape_is_drawn_at_a_corner_a_cycle():
    box = {"first_x": 3, "first_y": 5, "last_x": 9, "last_y": 6}
    assert NoFlyShape(**box, edges=()).drawing_cycles == 7 * 2 + 2


@pytest.mark.parametrize(
    ("shift", "limits", "blocks"),
    [
        (4, (511, 511), 32),
        (3, (511, 9), 64),
        (3, (9, 256), 64),
        (3, (255, 255), 32),
        (0, (0, 0), 32),
    ],
)
def test_as_few_blocks_as_cover_the_limits(shift, limits, blocks):
    valid = record(USUAL, np.random.default_rng(20))
    x_limit, y_limit = limits
    sent = dataclasses.replace(valid, block_shift=shift, x_limit=x_limit, y_limit=y_limit)
    assert sent.blocks == blocks
