"""Faults planted in the reading and judging of zones, each of which the judge of zones finds."""

from dataclasses import replace

import pytest

from pathgene.host.evaluation import packed_zones, strict_rule
from pathgene.host.formats import classes, limits, placemarks, times
from pathgene.host.formats.features import Reference, SunEvent
from pathgene.host.problem import active_times, heights, placing, zone_intake
from tests.support.host.zone_cases import Case


def ignore_lower_limits(patch):
    patch.setattr(heights, "_limits", lambda feature: (None, feature.upper))


def ignore_upper_limits(patch):
    patch.setattr(heights, "_limits", lambda feature: (feature.lower, None))


def take_the_ground_for_the_sea(patch):
    for word in ("AGL", "ASFC", "GND", "GROUND", "SFC", "SURFACE"):
        patch.setitem(limits._REFERENCES, word, Reference.AMSL)
    patch.setitem(placemarks._REFERENCES, "relativeToGround", Reference.AMSL)


def take_feet_for_metres(patch):
    for word in ("FT", "FEET", "FOOT"):
        patch.setitem(limits._UNITS_M, word, 1.0)


def take_the_standard_pressure(patch):
    patch.setattr(heights, "_PRESSURES_HPA", (1013.25, 1013.25))


def ignore_the_geoid(patch):
    patch.setattr(heights, "_GEOID_M", (0.0, 0.0))


def swap_begin_and_end(patch):
    shape = zone_intake._shape

    def swapped(feature, stated, interval, *more):
        begin, end = interval
        return shape(feature, stated, interval if begin and end else (end, begin), *more)

    patch.setattr(zone_intake, "_shape", swapped)


def ignore_times(patch):
    patch.setattr(zone_intake, "intervals", lambda *_: [(None, None)])


def ignore_days(patch):
    patch.setattr(times, "_weekdays", lambda _: frozenset())


def ignore_time_zones(patch):
    on_monday = times._on_monday
    patch.setattr(
        times,
        "_on_monday",
        lambda text: on_monday(text[:8] if isinstance(text, str) and text[8:] else text),
    )


def take_night_for_day(patch):
    opposite = {"SR": "SS", "SS": "SR", "BMCT": "EECT", "EECT": "BMCT"}
    sun = active_times._sun
    patch.setattr(active_times, "_sun", lambda event, *more: sun(SunEvent(opposite[event]), *more))


def skip_the_margin(patch):
    patch.setattr(
        strict_rule,
        "pack_zones",
        lambda zones, _, wind=(0.0, 0.0): packed_zones.pack_zones(zones, 0.0, wind),
    )


def drop_holes(patch):
    place = placing.place

    def filled(features, terrain):
        return [
            parts if feature.keeps_in else tuple(replace(p, rings=p.rings[:1]) for p in parts)
            for feature, parts in zip(features, place(features, terrain), strict=True)
        ]

    patch.setattr(zone_intake, "place", filled)


def draw_edges_straight_on_the_map(patch):
    densified = placing.densified
    patch.setattr(
        placing,
        "densified",
        lambda rings, terrain: densified([(r, False) for r, _ in rings], terrain),
    )


def keep_longitudes_apart(patch):
    patch.setattr(placing, "unwrapped", tuple)


def keep_out_of_inclusion_fences(patch):
    finished = placing._finished
    patch.setattr(
        placing,
        "_finished",
        lambda feature, *more: finished(replace(feature, keeps_in=False), *more),
    )


def let_every_class_forbid(patch):
    patch.setattr(classes, "DEFAULT", frozenset(classes.BY_NAME))
    patch.setattr(classes.forbids, "__defaults__", (frozenset(classes.BY_NAME),))


def let_danger_areas_pass(patch):
    fewer = classes.DEFAULT - {"DANGER", "CONDITIONAL", "CTR"}
    patch.setattr(classes, "DEFAULT", fewer)
    patch.setattr(classes.forbids, "__defaults__", (fewer,))


#: The faults, and for each the first file that shows it.
FAULTS = {
    ignore_lower_limits: 0,
    ignore_upper_limits: 4,
    take_the_ground_for_the_sea: 16,
    take_feet_for_metres: 1,
    take_the_standard_pressure: 88,
    ignore_the_geoid: 77,
    swap_begin_and_end: 0,
    ignore_times: 3,
    ignore_days: 91,
    ignore_time_zones: 36,
    take_night_for_day: 1,
    skip_the_margin: 1,
    drop_holes: 50,
    draw_edges_straight_on_the_map: 18,
    keep_longitudes_apart: 3,
    keep_out_of_inclusion_fences: 4,
    let_every_class_forbid: 12,
    let_danger_areas_pass: 3,
}


def shows(seed, folder):
    """Return whether product and judge differ in a file."""
    try:
        Case(seed, folder).compare_random_paths()
    except AssertionError:
        return True
    return False


@pytest.mark.parametrize("plant", FAULTS, ids=lambda plant: plant.__name__)
def test_the_judge_finds_a_planted_fault(plant, monkeypatch, tmp_path):
    assert not shows(FAULTS[plant], tmp_path)
    plant(monkeypatch)
    assert shows(FAULTS[plant], tmp_path)
