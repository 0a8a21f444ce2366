"""All cocotb benches of this folder, on each simulator."""

import re

import pytest

from tools.runner import SIMULATORS, benches, run_bench


pytestmark = pytest.mark.cosim


def marks(simulator, name):
    """Return the marks of a bench; one runs in `make test` to show that both simulators work."""
    if (simulator, name) == ("icarus", "chip"):
        # Takes minutes; `test_check_boards.py` runs a small chip on Icarus.
        return [pytest.mark.long]
    return [] if name == "uart" else [pytest.mark.ci]


@pytest.mark.parametrize(
    ("bench", "simulator"),
    [
        pytest.param(path, simulator, id=f"{simulator}-{name}", marks=marks(simulator, name))
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
