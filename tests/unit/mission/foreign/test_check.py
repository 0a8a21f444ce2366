"""Missions with a planted fault are found at its item, the same missions without it are clean."""

import json

import pytest

from tests.support.host.foreign import applied, checked, land
from tests.support.host.planted_missions import KINDS, plant


RETURN_M = 100.0
# Each kind is planted by this number of seeds here, and by more in the long test.
SEEDS, LONG_SEEDS = 3, range(100, 200)


def judged(tmp_path, kind, seed, *, faulty):
    planted = plant(kind, seed, faulty=faulty)
    as_rows = planted.waypoints is not None and seed % 2 == 1
    file = tmp_path / ("m.waypoints" if as_rows else "m.plan")
    text = planted.waypoints if as_rows else planted.plan
    return planted, checked(land(planted.heights), file, text)


def assert_found(tmp_path, kind, seed):
    planted, check = judged(tmp_path, kind, seed, faulty=True)
    faults = check.report["faults"]
    assert not check.feasible
    assert faults
    for fault in faults:
        assert fault["limit"].split()[0] in planted.limits, fault["sentence"]
        assert set(fault["items"]) <= planted.items, fault["sentence"]
        assert fault["broken_by_m"] > 0.1
    # One line for a leg and limit.
    assert len({(fault["where"], fault["limit"]) for fault in faults}) == len(faults)


def assert_clean(tmp_path, kind, seed):
    _, check = judged(tmp_path, kind, seed, faulty=False)
    assert check.feasible
    assert list(check.lines) == []
    assert check.report["minimum_clearance_m"] >= 29.7


@pytest.mark.parametrize("seed", range(SEEDS))
@pytest.mark.parametrize("kind", KINDS)
def test_a_planted_fault_is_found_at_its_item(kind, seed, tmp_path):
    assert_found(tmp_path, kind, seed)


@pytest.mark.parametrize("kind", KINDS)
def test_a_mission_without_the_fault_is_clean(kind, tmp_path):
    assert_clean(tmp_path, kind, 1)


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_a_thousand_planted_faults_are_found_and_a_thousand_clean_missions_pass(kind, tmp_path):
    for seed in LONG_SEEDS:
        assert_found(tmp_path, kind, seed)
        assert_clean(tmp_path, kind, seed)


def assert_mended(tmp_path, kind, seed):
    """Apply each remedy to the file alone: its fault is gone, and the named faults are all new."""
    planted = plant(kind, seed, faulty=True)
    terrain = land(planted.heights)
    check = checked(terrain, tmp_path / "m.plan", planted.plan)
    document = json.loads(planted.plan)
    known = {(fault["where"], fault["limit"]) for fault in check.report["faults"]}
    mended = 0
    for fault in check.report["faults"]:
        change = fault["change"]
        if change is None:
            continue
        text, return_m = applied(document, change, RETURN_M)
        after = checked(terrain, tmp_path / "n.plan", text, return_m=return_m)
        faults = {(each["where"], each["limit"]) for each in after.report["faults"]}
        if "leave_out" not in change:
            assert (fault["where"], fault["limit"]) not in faults, fault["sentence"]
            named = {tuple(each.rsplit(": ", 1)) for each in change.get("breaks", ())}
            assert faults - known <= named, (fault["sentence"], faults)
        else:
            assert not any(limit == "turn" for _, limit in faults)
        mended += 1
    return mended, len(check.report["faults"])


@pytest.mark.parametrize("kind", KINDS)
def test_the_remedy_of_a_fault_removes_it(kind, tmp_path):
    mended, faults = assert_mended(tmp_path, kind, 0)
    assert mended == faults


@pytest.mark.long
def test_nearly_every_fault_has_a_remedy_that_removes_it(tmp_path):
    found = [assert_mended(tmp_path, kind, seed) for kind in KINDS for seed in LONG_SEEDS]
    mended, faults = map(sum, zip(*found, strict=True))
    assert mended >= 0.95 * faults
