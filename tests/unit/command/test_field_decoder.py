"""Members of the decoder; the tests of the receiver cover its behaviour."""

import pytest

from pathgene.hdl.command.field_decoder import FieldDecoder, request_fields
from pathgene.hdl.config import Config


FIELDS = {
    "fields": request_fields(Config()),
    "population": 32,
    "children": 22,
    "map_size": 512,
    "altitude_bits": 12,
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
    runs = {"problem", "run", "shape"} | state
    assert members == common.union(
        core if design == "paper" else (),
        ["rectangle"] if checker == "parallel" else (),
        checks if design != "planner" and checker == "parallel" else (),
        runs if design == "planner" else (),
    )
