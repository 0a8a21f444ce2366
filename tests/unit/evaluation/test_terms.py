"""Terms of a path that are computed when they are read."""

import copy
import dataclasses
import pickle

import pytest

from pathgene.host.evaluation.terms import Evaluation, Late


PLAIN = dict.fromkeys((field.name for field in dataclasses.fields(Evaluation)), 1.0)


def late(calls):
    """Return an evaluation with a late height and late limits, which count their computations."""

    def compute(name, value):
        calls.append(name)
        return value

    return Evaluation(
        **PLAIN
        | {
            "minimum_clearance_m": Late(lambda: compute("clearance", 31.0)),
            "max_height_agl_m": Late(lambda: compute("height", 90.0)),
            "limits": Late(lambda: compute("limits", [{"limit": "power"}])),
        }
    )


def known():
    limits = [{"limit": "power"}]
    figures = {"minimum_clearance_m": 31.0, "max_height_agl_m": 90.0, "limits": limits}
    return Evaluation(**PLAIN | figures)


def test_late_values_are_computed_once_and_when_they_are_read():
    calls = []
    found = late(calls)
    assert found.feasible
    assert calls == []
    assert [found.max_height_agl_m for _ in range(2)] == [90.0, 90.0]
    assert calls == ["height"]
    assert found == known()
    assert calls == ["height", "clearance", "limits"]


@pytest.mark.parametrize(
    "copied",
    [
        copy.copy,
        copy.deepcopy,
        lambda found: pickle.loads(pickle.dumps(found)),
        lambda found: dataclasses.replace(found, feasible=found.feasible),
    ],
)
def test_a_copy_has_the_values(copied):
    assert copied(late([])) == known()


def test_late_values_are_reported_in_the_order_of_the_fields():
    assert list(late([]).to_dict().items()) == list(known().to_dict().items())
    assert repr(late([])) == repr(known())


def test_the_paper_has_neither_height_nor_limits():
    named = {"max_height_agl_m", "limits"}
    bare = Evaluation(**{name: value for name, value in PLAIN.items() if name not in named})
    assert bare.max_height_agl_m is None
    assert bare.limits is None
    with pytest.raises(TypeError, match="minimum_clearance_m"):
        Evaluation(**{name: PLAIN[name] for name in PLAIN if name != "minimum_clearance_m"})
