"""The time of a plan on a real chip, computed from the counts of a run."""

import pytest

from host.planners.chip_time import BAUD, Look, chip_time


def test_looks_at_a_run_go_on_until_one_begins_behind_its_end():
    look = Look(asked_s=1e-5, told_s=9e-5)
    # The pause is a hundredth of the limit.
    assert look.until_over(0, 2e-3) == pytest.approx(1e-4)
    assert look.until_over(0.9e-5, 2e-3) == pytest.approx(1e-4)
    assert look.until_over(1.1e-5, 2e-3) == pytest.approx(2.2e-4)
    # The last look before the limit would end behind it.
    assert look.until_over(2e-3, 2e-3) == pytest.approx(2.1e-3)
    assert look.until_over(1.9e-3, 2e-3) == pytest.approx(2.1e-3)
    assert look.until_over(1.6e-3, 2e-3) == pytest.approx(1.78e-3)
    # The first look waits for the answer to RUN.
    assert look.until_over(0.9e-5, 2e-3, 5e-5) == pytest.approx(1.5e-4)
    assert look.until_over(2e-3, 2e-3, 5e-5) == pytest.approx(2.1e-3)


def test_a_plan_takes_drawing_runs_looks_and_bytes():
    run = {
        "cycles": 100_000,
        "limit": 200_000,
        "looks": 3,
        "answers": 3,
        "answer_bytes": 27,
        "bytes": {"to_board": 160, "from_board": 90},
    }
    hardware = {
        "clock_hz": 100_000_000,
        "drawing_cycles": 1_000,
        "exchanges": 11,
        "look_bytes": {"to_board": 8, "from_board": 42},
        "runs": [run, run],
    }
    look = Look.of(8, 42)
    each = (160 + 90 - 3 * 50 - 27) * 10 / BAUD + look.until_over(1e-3, 2e-3, 9 * 10 / BAUD)
    time = chip_time(hardware)
    assert time.whole_s == pytest.approx(1e-5 + 2 * each)
    # Of the looks at a run, one counts.
    assert time.exchanges == 11 - 6 + 2
    # The clock of the machine, which decides how often the host looks, does not count.
    more = [{**run, "looks": 9, "bytes": {"to_board": 160 + 6 * 8, "from_board": 90 + 6 * 42}}] * 2
    assert chip_time({**hardware, "exchanges": 23, "runs": more}) == time
    assert chip_time(hardware, 1).whole_s == pytest.approx(1e-5 + each)
