# amaranth: UnusedElaboratable=no
"""One mutator; what it does to a path is tested with the mutation unit."""

import pytest

from hdl.config import MutationKind
from hdl.ga_core.mutator import Mutator
from tests.wrong_sizes import check_sizes


SIZES = {
    "kind": MutationKind.INSERT,
    "crossovers": 11,
    "waypoint_bits": 30,
    "min_waypoints": 2,
    "max_waypoints": 16,
}


def test_sizes():
    check_sizes(
        Mutator,
        SIZES,
        {
            "crossovers": ("Crossovers", 2),
            "waypoint_bits": ("Waypoint width", 1),
            "min_waypoints": ("Min waypoints", 1),
            "max_waypoints": ("Max waypoints", 3),
        },
    )


@pytest.mark.parametrize("kind", MutationKind)
def test_only_a_deleting_mutator_makes_no_waypoint(kind):
    assert hasattr(Mutator(**{**SIZES, "kind": kind}), "patch") == (kind is not MutationKind.DELETE)
