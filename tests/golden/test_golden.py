"""Results that no change may affect, committed in ``golden.json``.

``python -m tools.record`` rewrites the file after an intended change of results.
"""

import json

import pytest

from tools.record import GOLDEN_PARTS, GOLDENS, evaluate


GOLDEN = json.loads(GOLDENS.read_text())


@pytest.mark.parametrize("part", GOLDEN_PARTS)
def test_integers(part):
    """Populations, bytes and counters of runs; verdicts, cycles and reads."""
    # JSON turns tuples into lists.
    found = json.loads(json.dumps(GOLDEN_PARTS[part]()))
    assert found == GOLDEN[part]


@pytest.mark.parametrize("number", range(len(GOLDEN["fitness"])))
def test_fitness_of_a_fixed_path(number):
    fixed = GOLDEN["fitness"][number]
    found = evaluate(GOLDEN["problems"][fixed["map"]], fixed["path"])
    assert found == pytest.approx(fixed["terms"], rel=1e-9, abs=1e-9)


def test_fixed_paths_are_of_both_kinds():
    for name in GOLDEN["problems"]:
        of_map = [fixed["terms"] for fixed in GOLDEN["fitness"] if fixed["map"] == name]
        assert {terms["feasible"] for terms in of_map} == {0.0, 1.0}
