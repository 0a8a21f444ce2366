"""The options of all runs of a plan, and its time on a real chip from the counts of a run."""

import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.planners.chip.problem_on_chip import pause_s
from pathgene.host.planners.chip.schedule import BAUD, MOST_RUNS, ChipSchedule, Look, chip_time


CHIP = Config(core="planner")


def schedule(**limits):
    return ChipSchedule(config=CHIP, seed=9, **limits)


@pytest.mark.parametrize(
    ("limits", "parts"),
    [
        ({"generations": 1}, 1),
        ({"generations": 3_199}, 1),
        ({"generations": 3_200}, 2),
        ({"generations": 6_400}, 4),
        ({"generations": 10**9}, 4),
        ({"generations": 10**9, "chip_ms": 1}, 1),
        ({"generations": 10**9, "chip_ms": 23}, 1),
        ({"generations": 10**9, "chip_ms": 24}, 2),
        ({"generations": 10**9, "chip_ms": 50}, 4),
        ({"generations": 100, "chip_ms": 50}, 1),
    ],
)
def test_parts(limits, parts):
    of_limits = schedule(**limits)
    assert of_limits.parts == parts
    assert len(of_limits.further()) == parts - 1


def test_a_short_plan_is_a_run_with_the_default_options_but_its_own_limits():
    first = schedule(chip_ms=2, generations=5).first()
    assert first[0] == RunOptions(seed=9, cycles=200_000, generations=5)
    assert len(first) == MOST_RUNS == 8
    assert [options.seed for options in first] == list(range(9, 17))
    assert len({options.slopes for options in first}) == 4


def test_parts_are_equal_and_go_on():
    of_limits = schedule(chip_ms=50, generations=10_001)
    runs = [of_limits.first()[0], *of_limits.further()]
    assert [options.warm for options in runs] == [False, True, True, True]
    assert {options.cycles for options in runs} == {1_250_000}
    assert [options.generations for options in runs] == [2_500, 2_500, 2_500, 2_501]
    assert len({options.seed for options in runs}) == 4
    for options in (*of_limits.first(), *runs):
        options.check(CHIP)


def test_a_small_chip_and_the_greatest_seed():
    small = CHIP.replace(population=8, children=4, elites=2, survivors=2, perturbs=1, inserts=1)
    of_small = ChipSchedule(config=small, seed=(1 << 64) - 1, generations=10**10)
    runs = [*of_small.first(), *of_small.further()]
    for options in runs:
        options.check(small)
        assert (options.cycles, options.give_up_rank) == (2**32 - 1, 7)
    assert runs[1].seed == 0


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
        "exchanges": 2,
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
    look = Look(8 * byte_s, 18 * byte_s)
    each = 250 * byte_s + look.until_over(1e-3, 2e-3, 9 * byte_s)
    time = chip_time(hardware)
    # Zones are drawn while later commands come, and STATUS follows the paths.
    assert time.whole_s == pytest.approx(1e-5 + 2 * each + 50 * byte_s)
    assert time.status_s == pytest.approx(50 * byte_s)
    assert time.exchanges == 4
    first = chip_time(hardware, 1)
    assert first.whole_s == pytest.approx(1e-5 + each)
    assert first.exchanges == 2
    small = chip_time({**hardware, "drawing_cycles": 19_000}, 1)
    assert small.whole_s == pytest.approx(each)


def test_pauses_after_the_limit_of_a_run_are_bounded():
    """An interrupt waits for the next poll, and has a second before it ends the plan by force."""
    pauses = [pause_s(0.02, passed_s, 0.001) for passed_s in (0.019, 0.021, 1.0, 4.0, 1e4)]
    assert pauses == pytest.approx([0.001, 0.0002, 0.01, 0.04, 0.05], rel=0.1)
