# amaranth: UnusedElaboratable=no
"""Sizes of the units that are tested within the receiver: readable, and checked."""

import pytest

from pathgene.hdl.command.field_decoder import FieldDecoder, request_fields
from pathgene.hdl.command.path_parser import PathParser
from pathgene.hdl.command.payload_dispatcher import PayloadDispatcher
from pathgene.hdl.command.ranking_parser import RankingParser
from pathgene.hdl.command.waypoint_assembler import WaypointAssembler
from pathgene.hdl.config import Config
from tests.support.gateware.wrong_sizes import check_sizes


FIELDS = {
    "fields": request_fields(Config()),
    "population": 32,
    "children": 22,
    "map_size": 512,
    "altitude_bits": 12,
}


def test_sizes_of_parsers():
    check_sizes(RankingParser, {"population": 32}, {"population": ("Population", 2, 256)})
    check_sizes(
        PathParser,
        {"population": 32, "waypoint_bits": 30, "min_waypoints": 2, "max_waypoints": 16},
        {
            "population": ("Population", 2, 256),
            "waypoint_bits": ("Waypoint width", 1),
            "min_waypoints": ("Min waypoints", 1),
            "max_waypoints": ("Max waypoints", 2),
        },
    )
    check_sizes(WaypointAssembler, {"waypoint_bits": 30}, {"waypoint_bits": ("Waypoint width", 1)})


def test_sizes_of_the_decoder():
    limits = {"children": ("Children", 1, 31), "altitude_bits": ("Altitude width", 1, 16)}
    check_sizes(FieldDecoder, FIELDS, limits)
    few_children = {**FIELDS, "children": 1}
    check_sizes(FieldDecoder, few_children, {"population": ("Population", 2, 256)})
    for size in (0, 100, 1 << 17):
        rule = f"^Map size must be a power of two from 2 to 65536, not {size}$"
        with pytest.raises(ValueError, match=rule):
            FieldDecoder(**{**FIELDS, "map_size": size})


@pytest.mark.parametrize(
    ("design", "checker"),
    [
        ("parallel", "none"),
        ("none", "parallel"),
        ("parallel", "parallel"),
        ("streaming", "parallel"),
    ],
)
def test_the_decoder_has_the_members_of_its_commands(design, checker):
    fields = request_fields(Config(core=design, checker=checker, lanes=1))
    members = set(FieldDecoder(**{**FIELDS, "fields": fields}).signature.members)
    common = {"code", "byte", "take", "ended", "status", "kind", "slot", "count"}
    core, checks = {"start", "write_slot", "identity"}, {"checks", "checked"}
    state = {"repeated", "running", "has_problem", "has_population"}
    runs = {"problem", "run", "shape"} | state
    assert members == common.union(
        core if design == "paper" else (),
        ["rectangle"] if checker == "parallel" else (),
        checks if design != "planner" and checker == "parallel" else (),
        runs if design == "planner" else (),
    )


def test_the_dispatcher_takes_a_configuration():
    with pytest.raises(TypeError, match=r"^Config must be a Config, not 16$"):
        PayloadDispatcher(16)
