import re

import pytest

from sim.model.planner.options import Island, RunOptions
from tests.planner_cases import SMALL, USUAL


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"seed": -1}, "Seed must be from 0 to 2**64 - 1, not -1"),
        ({"cycles": -1}, "RunOptions.cycles must be 0 or more, not -1"),
        ({"generations": -1}, "RunOptions.generations must be 0 or more, not -1"),
        ({"give_up_rank": 32}, "RunOptions.give_up_rank must be a rank, not 32"),
        ({"islands": ()}, "RunOptions.islands must be 1, 2, 4 or 8, not ()"),
        (
            {"islands": (Island(False, 16),)},
            "RunOptions.islands must be of slopes from 0 to 15, "
            "not (Island(mean=False, slope=16),)",
        ),
        ({"seeds": 31}, "RunOptions.seeds must be from the population on, not 31"),
        ({"lifts": 5}, "RunOptions.lifts must be from 0 to 4, not 5"),
        ({"share": 17}, "RunOptions.share must be from 0 to 16, not 17"),
        ({"memo": 1}, "RunOptions.memo must be 0, or a power of two up to 65536, not 1"),
        ({"memo": 24}, "RunOptions.memo must be 0, or a power of two up to 65536, not 24"),
    ],
)
def test_a_wrong_option_names_its_rule(options, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        RunOptions(**options).check(USUAL)


@pytest.mark.parametrize(
    ("sizes", "message"),
    [
        (
            {"survivors": 6, "children": 4, "population": 16, "elites": 6},
            "Config.survivors must be at most Config.children for a planner on the chip, not 6",
        ),
        (
            {"survivors": 10, "children": 44, "population": 64, "elites": 10},
            "Config.population must be at most 32 for a planner on the chip, not 64",
        ),
    ],
)
def test_a_wrong_chip_names_its_rule(sizes, message):
    config = SMALL.replace(**sizes)
    options = RunOptions(seeds=config.population)
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        options.check(config)
