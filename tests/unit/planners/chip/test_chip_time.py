"""The time of a plan on a real chip, computed from the counts of a run."""

import pytest

from pathgene.host.planners.chip.chip_time import BAUD, Look, chip_time


def test_the_host_looks_at_a_run_until_it_is_over():
    look = Look(asked_s=1e-5, told_s=9e-5)
    assert look.until_over(0, 2e-3) == pytest.approx(1e-5)
    assert look.until_over(0.9e-5, 2e-3) == pytest.approx(1e-5)
    # The pause is a hundredth of the limit.
    assert look.until_over(1.1e-5, 2e-3) == pytest.approx(1.3e-4)
    # The last look before the limit would end after it.
    assert look.until_over(2e-3, 2e-3) == pytest.approx(2.01e-3)
    assert look.until_over(1.9e-3, 2e-3) == pytest.approx(2.01e-3)
    assert look.until_over(1.6e-3, 2e-3) == pytest.approx(1.69e-3)
    # The first look waits for the answer to RUN.
    assert look.until_over(0.9e-5, 2e-3, 5e-5) == pytest.approx(6e-5)
    assert look.until_over(2e-3, 2e-3, 5e-5) == pytest.approx(2.01e-3)


def test_a_plan_takes_drawing_runs_looks_and_bytes():
    waits = {
        "exchanges": 3,
        "commands": 160,
        "after_zones": 60,
        "answer": 9,
        "request": 8,
        "paths": 90,
        "status": 50,
    }
    run = {"cycles": 100_000, "limit": 200_000, "waits": waits}
    hardware = {"clock_hz": 100_000_000, "drawing_cycles": 21_000, "runs": [run, run]}
    byte_s = 10 / BAUD
    look = Look(8 * byte_s, 9 * byte_s)
    each = 250 * byte_s + look.until_over(1e-3, 2e-3, 9 * byte_s)
    time = chip_time(hardware)
    # Zones are drawn while later commands come, and STATUS follows the paths.
    assert time.whole_s == pytest.approx(1e-5 + 2 * each + 50 * byte_s)
    assert time.status_s == pytest.approx(50 * byte_s)
    assert time.exchanges == 6
    first = chip_time(hardware, 1)
    assert first.whole_s == pytest.approx(1e-5 + each)
    assert first.exchanges == 3
    small = chip_time({**hardware, "drawing_cycles": 19_000}, 1)
    assert small.whole_s == pytest.approx(each)
