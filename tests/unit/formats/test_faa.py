"""Airspace of the FAA: classes, special use, and cells of the map of facilities for UAS."""

import json

import pytest
import shapely

from pathgene.host.formats import faa, geojson
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, LeftOut, Limit, Reference
from pathgene.host.formats.registry import FORMATS


RING = [[-97.1, 32.8], [-97.0, 32.8], [-97.0, 32.9], [-97.1, 32.8]]
POLYGON = {"type": "Polygon", "coordinates": [RING]}
FOOT_M = 0.3048
FACTS = {
    "OBJECTID": 7,
    "IDENT": "DFW",
    "NAME": "DALLAS-FORT WORTH CLASS B",
    "UPPER_DESC": "TI",
    "UPPER_VAL": 11000,
    "UPPER_UOM": "FT",
    "UPPER_CODE": "MSL",
    "LOWER_DESC": None,
    "LOWER_VAL": 0,
    "LOWER_UOM": "FT",
    "LOWER_CODE": "SFC",
    "TYPE_CODE": "CLASS",
    "LOCAL_TYPE": "CLASS_B",
    "CLASS": "B",
    "WKHR_CODE": "H24",
}
CELL = {"CEILING": 200, "UNIT": "Feet", "MAP_EFF": "5/1/2026", "APT1_NAME": "Addison"}


def read(*facts, geometry=POLYGON):
    features = [{"type": "Feature", "properties": each, "geometry": geometry} for each in facts]
    content = Content(json.dumps({"type": "FeatureCollection", "features": features}).encode())
    row = next(row for row in FORMATS if row.zones and row.module.recognises(content))
    assert row.name == "faa"
    return list(faa.features(content))


def limits(**changes):
    (found,) = read(FACTS | changes)
    return found.lower, found.upper


def test_reads_an_airspace_of_a_class():
    (found,) = read(FACTS)
    assert shapely.Polygon(found.rings[0]).equals(shapely.geometry.shape(POLYGON))
    assert found.label == 'feature 1, "DALLAS-FORT WORTH CLASS B"'
    assert (found.category, found.forbids, found.unread) == ("B", True, ())
    assert (found.lower, found.upper) == (
        Limit(0, Reference.AGL),
        Limit(11000 * FOOT_M, Reference.AMSL),
    )


@pytest.mark.parametrize(
    ("stated", "expected"),
    [
        ((2500, "FT", "MSL"), Limit(2500 * FOOT_M, Reference.AMSL)),
        ((1200, "FT", "SFC"), Limit(1200 * FOOT_M, Reference.AGL)),
        ((1200, "FT", "AGL"), Limit(1200 * FOOT_M, Reference.AGL)),
        (("17999", "FT", "MSL"), Limit(17999 * FOOT_M, Reference.AMSL)),
        ((180, "FL", "STD"), Limit(18000 * FOOT_M, Reference.STANDARD)),
        ((18000, "FT", "STD"), Limit(18000 * FOOT_M, Reference.STANDARD)),
        ((600, "M", "MSL"), Limit(600, Reference.AMSL)),
        (("0", None, "SFC"), Limit(0, Reference.AGL)),
        ((None, None, "SFC"), Limit(0, Reference.AGL)),
        ((-9998, None, None), None),
        ((None, None, None), None),
        (("", "", ""), None),
        ((99999, "FT", "UNLTD"), None),
    ],
)
@pytest.mark.parametrize("side", ["LOWER", "UPPER"])
def test_reads_value_unit_and_reference(side, stated, expected):
    other = {"LOWER": "UPPER", "UPPER": "LOWER"}[side]
    names = (f"{side}_VAL", f"{side}_UOM", f"{side}_CODE")
    open_ = {f"{other}_VAL": None, f"{other}_CODE": None}
    lower, upper = limits(**open_, **dict(zip(names, stated, strict=True)))
    found, none = (lower, upper) if side == "LOWER" else (upper, lower)
    assert none is None
    if expected is None:
        assert found is None
    else:
        assert found.height_m == pytest.approx(expected.height_m)
        assert found.reference is expected.reference


def test_a_limit_without_unit_or_reference_is_named_and_none():
    (found,) = read(FACTS | {"UPPER_UOM": None})
    assert (found.upper, found.unread) == (None, ("UPPER_VAL",))
    (found,) = read(FACTS | {"LOWER_CODE": "QFE", "LOWER_VAL": 5, "TIMESOFUSE": "0800-1600"})
    assert (found.lower, found.unread) == (None, ("LOWER_VAL", "TIMESOFUSE"))


@pytest.mark.parametrize(
    ("kind", "stated", "category", "forbids"),
    [
        ("CLASS", "C", "C", True),
        ("CLASS", "D", "D", True),
        ("CLASS", "E", "E", False),
        ("CLASS", "G", "G", False),
        ("CLASS", None, "OTHER", True),
        (None, "E", "E", False),
        ("R", None, "RESTRICTED", True),
        ("P", None, "PROHIBITED", True),
        ("D", None, "DANGER", True),
        ("A", None, "ALERT", True),
        # W is a wave window in OpenAir.
        ("W", None, "WARNING", True),
        ("MOA", "E", "MTA", True),
        ("FIS", "D", "FIS", True),
        ("CTR", "E", "CTR", True),
        ("NSA", None, "PROTECTED", True),
        ("MODE-C", None, "TMZ", True),
        ("TRSA", None, "TRSA", True),
        ("X", None, "OTHER", True),
    ],
)
def test_type_and_class_forbid_by_the_table(kind, stated, category, forbids):
    (found,) = read(FACTS | {"TYPE_CODE": kind, "CLASS": stated})
    assert (found.category, found.forbids) == (category, forbids)


def test_an_unknown_type_forbids_and_is_named():
    found, other = read(FACTS | {"TYPE_CODE": "XYZ", "CLASS": "G"}, FACTS)
    assert found.forbids
    (remark,) = found.remarks
    assert remark.text.startswith("XYZ is no type or class that is known, so it forbids flight")
    assert not other.remarks


@pytest.mark.parametrize(
    ("local", "lower", "category", "forbids"),
    [
        ("CLASS_E2", (0, "FT", "SFC"), "REQ_AUTHORISATION", True),
        ("CLASS_E2", (None, None, "SFC"), "REQ_AUTHORISATION", True),
        ("CLASS_E2", (None, None, None), "REQ_AUTHORISATION", True),
        ("CLASS_E2", (700, "FT", "SFC"), "E", False),
        ("CLASS_E3", (0, "FT", "SFC"), "E", False),
        ("CLASS_E4", (0, "FT", "SFC"), "E", False),
        ("CLASS_E5", (700, "FT", "SFC"), "E", False),
    ],
)
def test_the_surface_area_of_an_airport_in_class_e_requires_an_authorisation(
    local, lower, category, forbids
):
    names = ("LOWER_VAL", "LOWER_UOM", "LOWER_CODE")
    facts = {"CLASS": "E", "LOCAL_TYPE": local, **dict(zip(names, lower, strict=True))}
    (found,) = read(FACTS | facts)
    assert (found.category, found.forbids) == (category, forbids)
    assert found.airspace_class == ("E" if forbids else "")


def test_a_cell_is_an_area_below_its_height_and_one_above():
    below, above = read(CELL)
    height = Limit(200 * FOOT_M, Reference.AGL)
    assert (below.category, below.lower, below.upper) == ("REQ_AUTHORISATION", None, height)
    assert (above.category, above.lower, above.upper) == ("RESTRICTED", height, None)
    assert below.label == above.label == 'feature 1, "Addison"'
    assert below.unread == above.unread == ()
    assert below.forbids
    assert above.forbids
    (whole,) = read(CELL | {"CEILING": 0})
    assert (whole.category, whole.lower, whole.upper) == ("RESTRICTED", None, None)


@pytest.mark.parametrize(
    ("facts", "reason"),
    [
        (FACTS | {"UPPER_VAL": "high"}, "UPPER_VAL must be a number, not 'high'."),
        (FACTS | {"UPPER_VAL": True}, "UPPER_VAL must be a number, not True."),
        (
            FACTS | {"LOWER_VAL": 12000, "LOWER_CODE": "MSL"},
            "its lower limit, 3657.6 m, lies above its upper, 3352.8 m.",
        ),
        (CELL | {"CEILING": "high"}, "CEILING must be a number, not 'high'."),
        (CELL | {"CEILING": None}, "a limit of height must be a number, not None."),
        (CELL | {"UNIT": "yards"}, "the unit of a limit of height must be m, ft or FL"),
    ],
)
def test_names_a_bad_feature_and_reads_the_others(facts, reason):
    bad, good, *_ = read(facts, FACTS)
    assert isinstance(bad, Bad)
    assert reason in bad.reason
    assert good.number == 2


def test_leaves_out_parts_without_an_area():
    line = {"type": "LineString", "coordinates": RING[:2]}
    assert isinstance(read(FACTS, geometry=line)[0], LeftOut)
    assert read(FACTS, geometry=None)[0].reason == "it has no geometry"


def test_reads_the_reference_system_that_the_file_names():
    feature = {"type": "Feature", "properties": FACTS, "geometry": POLYGON}
    crs = {"type": "name", "properties": {"name": "EPSG:4269"}}
    document = {"type": "FeatureCollection", "features": [feature], "crs": crs}
    (found,) = faa.features(Content(json.dumps(document).encode()))
    assert found.upper is not None


def test_takes_no_other_geojson():
    for facts in ({"CEILING": 200}, {"UPPER_VAL": 5}, {"name": "x", "ceiling": "FL 95"}):
        feature = {"type": "Feature", "properties": facts, "geometry": POLYGON}
        content = Content(json.dumps(feature).encode())
        assert not faa.recognises(content)
        assert geojson.recognises(content)
