"""Every cocotb bench of this folder, on each simulator."""

import pytest

from sim.exported import exported_verilog
from tests.chips import CHECKER_BENCH
from tools.runner import BENCHES, SIMULATORS, benches, run, run_bench


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


#: The paper's sizes and a minute of compiling, on Verilator; boards of that size are in
#: ``test_boards.py``.
LARGE = ("core", "core_with_map")


def marks(simulator, name):
    if simulator == "icarus" and name in LONG_ON_ICARUS:
        return [pytest.mark.long]
    return [pytest.mark.ci] if name in LARGE else []


@pytest.mark.parametrize(
    ("bench", "simulator"),
    [
        pytest.param(
            path,
            simulator,
            id=f"{simulator}-{name}",
            marks=marks(simulator, name),
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


@pytest.mark.ci
def test_checker_of_two_tiers():
    """The bench that :func:`test_bench` runs for the parallel build."""
    result = run(
        "verilator",
        exported_verilog("path_checker", CHECKER_BENCH["two-tier"]),
        "path_checker",
        BENCHES / "cosim_checker.py",
        env={"CHECKER": "two-tier"},
        label="checker-two-tier-verilator",
    )
    assert result.tests == 6
