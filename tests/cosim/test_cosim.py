"""Every cocotb bench of this folder, on each simulator."""

import pytest

from tools.runner import SIMULATORS, benches, run_bench


pytestmark = pytest.mark.cosim

#: Minutes on Icarus, where a small chip with the parallel checker agrees with the model in
#: ``test_check_boards.py``; ``make sim`` runs them, too.
LONG_ON_ICARUS = (
    "checker",
    "core",
    "core_with_map",
    "planner",
    "population",
    "receiving",
    "transmitting",
)


@pytest.mark.parametrize(
    ("bench", "simulator"),
    [
        pytest.param(
            path,
            simulator,
            id=f"{simulator}-{name}",
            marks=[pytest.mark.long] if simulator == "icarus" and name in LONG_ON_ICARUS else [],
        )
        for name, path in benches().items()
        for simulator in SIMULATORS
    ],
    indirect=["simulator"],
)
def test_bench(bench, simulator):
    result = run_bench(simulator, bench)
    # Each once or more: not one that could not be found, or was skipped.
    assert result.tests >= bench.read_text().count("\n@cocotb.test(")
