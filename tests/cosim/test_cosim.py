"""Every cocotb bench of this folder, on each simulator."""

import pytest

from sim.runner import benches, run_bench


pytestmark = pytest.mark.cosim


@pytest.mark.parametrize("bench", [pytest.param(path, id=name) for name, path in benches().items()])
def test_bench(bench, simulator):
    result = run_bench(simulator, bench)
    # Each once or more: not one that could not be found, or was skipped.
    assert result.tests >= bench.read_text().count("\n@cocotb.test(")
