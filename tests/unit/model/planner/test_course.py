"""Vectors of a problem and of the sizes of a chip."""

import dataclasses

import numpy as np
import pytest

from pathgene.hdl.protocol.planner import ProblemRecord
from pathgene.sim.model.planner import course
from tests.support.planner.cases import SMALL, USUAL, any_record


def test_places_are_in_the_order_of_the_fields():
    names = [field.name.upper() for field in dataclasses.fields(ProblemRecord)]
    assert [getattr(course, name) for name in names] == list(range(len(names)))


def test_sizes_are_in_their_places():
    sizes = course.sizes_vector(USUAL, 512)
    for name, value in {
        "POPULATION": 32, "CHILDREN": 22, "ELITES": 2, "SURVIVORS": 8, "MAX_WAYPOINTS": 24,
        "RANK_BITS": 5, "BOX_X": 38, "BOX_Y": 38, "BOX_STEPS": 307, "BLOCKED": 4095, "LANES": 8,
        "COORDINATE_BITS": 9, "ALTITUDE_BITS": 12, "MEMO_BITS": 9,
    }.items():  # fmt: skip
        assert sizes[getattr(course, name)] == value
    assert course.sizes_vector(USUAL, 0)[course.MEMO_BITS] == 0


def test_a_record_of_another_chip_is_refused():
    record = any_record(USUAL, np.random.default_rng(17))
    record = dataclasses.replace(record, start_x=1 << 13)
    with pytest.raises(ValueError, match=r"^start_x must fit in 13 bits, not 8192$"):
        course.problem_vector(SMALL, record)
