"""The plans of the mutators; what they are for is tested with the mutation unit."""

from hdl.ga_core.mutation_plan import MutationPlan
from tests.wrong_sizes import check_sizes


def test_sizes():
    check_sizes(
        MutationPlan,
        {"mutators": 5, "crossovers": 11, "max_waypoints": 16},
        {
            "mutators": ("Mutators", 1),
            "crossovers": ("Crossovers", 2),
            "max_waypoints": ("Max waypoints", 3),
        },
    )
