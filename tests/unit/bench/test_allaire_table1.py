"""The benchmark of table 1 of *allaire-2008*, on the chip's model with few generations."""

import pytest

from bench import allaire_table1
from bench.allaire import PHASES
from bench.report import Options


pytestmark = pytest.mark.ci  # Smoke test of a benchmark.


GENERATIONS = 4


def test_every_phase_on_both():
    report = allaire_table1.run(Options(seeds=2), generations=GENERATIONS, board="model:")
    rows = {row[0]: row[1:] for row in report.rows}
    assert list(rows) == [*PHASES, "evaluation and sorting"]
    for name, phase in PHASES.items():
        paper_ms, paper_us, times, pc_ms, cycles, chip_us, faster = rows[name]
        assert (paper_ms, paper_us) == pytest.approx((1e3 * phase.pc_s, 1e6 * phase.fpga_s))
        assert times == pytest.approx(1e3 * paper_ms / paper_us)
        assert chip_us == pytest.approx(cycles / 100)  # At 100 MHz.
        assert faster == pytest.approx(1e3 * pc_ms / chip_us)
        assert pc_ms > 0
        assert cycles >= GENERATIONS
    assert rows["population update"][4] == GENERATIONS  # One cycle each.
    assert rows["evaluation and sorting"][4] == "on the host"
