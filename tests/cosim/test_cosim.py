"""All cocotb benches of this folder, on each simulator."""

import re

import pytest

from pathgene.sim.exported import exported_verilog
from tests.support.gateware.chips import CHECKER_BENCH
from tools.runner import BENCHES, SIMULATORS, benches, run, run_bench


pytestmark = pytest.mark.cosim

#: Benches that take minutes on Icarus; ``make sim`` runs them as well. ``test_check_boards.py``
#: runs a small chip on Icarus.
LONG_ON_ICARUS = (
    "checker",
    "core",
    "core_with_map",
    "chip",
    "planner_core",
    "receiver",
    "transmitter",
)


def marks(simulator, name):
    """Return the marks of a bench; one runs in `make test` to show that both simulators work."""
    if simulator == "icarus" and name in LONG_ON_ICARUS:
        return [pytest.mark.long]
    return [] if name == "uart" else [pytest.mark.ci]


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
    # No test is missing or skipped; a parametrized test counts more than once.
    defined = len(re.findall(r"^@(cocotb\.test\(|with_host$)", bench.read_text(), re.MULTILINE))
    assert result.tests >= defined > 0


@pytest.mark.ci
def test_two_tier_checker():
    """:func:`test_bench` runs the same bench on the parallel build."""
    result = run(
        "verilator",
        exported_verilog("path_checker", CHECKER_BENCH["two-tier"]),
        "path_checker",
        BENCHES / "cosim_checker.py",
        env={"CHECKER": "two-tier"},
        label="checker-two-tier-verilator",
    )
    assert result.tests == 6
