"""Random files of zones of every format: they are read as drawn, and plans heed them when active.

The judge knows the zones as they were drawn, not as they were read.
"""

import pytest

from tests.support.host.zone_abilities import ABILITIES
from tests.support.host.zone_cases import Case


FORMATS = list(ABILITIES)
#: Files of each format with random paths.
READ, MANY_READ = 7, 200
#: Files with plans; the seeds take turns in formats and planners.
PLANNED, MANY_PLANNED = 12, 500


def check_paths(kind, files, folder):
    """Compare random paths; return the number of paths that enter a zone."""
    seeds = (FORMATS.index(kind) + len(FORMATS) * number for number in files)
    return sum(Case(seed, folder).compare_random_paths() for seed in seeds)


@pytest.mark.parametrize("kind", FORMATS)
def test_reads_random_files_as_they_were_drawn(kind, tmp_path):
    assert check_paths(kind, range(READ), tmp_path) > READ


@pytest.mark.long
@pytest.mark.parametrize("kind", FORMATS)
def test_reads_many_random_files_as_they_were_drawn(kind, tmp_path):
    assert check_paths(kind, range(READ, MANY_READ), tmp_path) > MANY_READ


@pytest.mark.parametrize("seed", range(PLANNED))
def test_plans_keep_out_of_active_zones_alone(seed, tmp_path):
    Case(seed, tmp_path).compare_plans()


@pytest.mark.long
@pytest.mark.parametrize("last_digit", range(10))
def test_many_plans_keep_out_of_active_zones_alone(last_digit, tmp_path):
    """A digit stands for a planner."""
    seeds = [seed for seed in range(PLANNED, MANY_PLANNED) if seed % 10 == last_digit]
    feasible = sum(Case(seed, tmp_path).compare_plans() for seed in seeds)
    assert feasible > len(seeds) / 3
