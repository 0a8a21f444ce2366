"""Random files of each format of zones, compared with independent readers."""

import io
import json
import random
import zipfile
from datetime import time

import numpy as np
import pytest
import shapely
from aerofiles.openair import Reader
from fastkml import KML
from implicitdict import ImplicitDict
from pymavlink import mavutil, mavwp
from pyproj import Geod, Transformer
from uas_standards.eurocae_ed269 import ApplicableTimePeriod, UASZoneAirspaceVolume
from uas_standards.eurocae_ed318 import TimePeriod, VerticalLayer

from pathgene.host.errors import InputError
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, Feature
from pathgene.host.formats.registry import FORMATS
from tests.support.host import zone_files


EARTH = Geod(ellps="WGS84")
DAYS = ("MON", "TUE", "WED", "THU", "FRI", "SAT", "SUN")
FILES = 8
MANY_FILES = 65


def read(content):
    """Return the format that recognises a file, and its features; nothing may be bad."""
    row = next(row for row in FORMATS if row.zones and row.module.recognises(content))
    parts = list(row.module.features(content))
    assert all(isinstance(part, Feature) for part in parts), parts
    return row.name, parts


def heights(feature):
    """Return lower and upper limit as metres and reference."""
    return [
        limit and (limit.height_m, str(limit.reference)) for limit in (feature.lower, feature.upper)
    ]


def same_heights(feature, expected):
    for found, wanted in zip(heights(feature), expected, strict=True):
        assert (found is None) == (wanted is None), (found, wanted)
        if wanted is not None:
            assert found[0] == pytest.approx(wanted[0])
            assert found[1] == wanted[1]


def same_polygon(feature, polygon, digits=9):
    """Check the corners of a feature: the rings of shapely's polygon, closed or not."""
    rings = [polygon.exterior, *polygon.interiors]
    assert feature.radius_m is None
    assert len(feature.rings) == len(rings)
    for own, ring in zip(feature.rings, rings, strict=True):
        assert np.allclose(own, np.array(ring.coords)[:-1, :2], rtol=0, atol=10**-digits)


def same_circle(feature, centre, radius_m):
    assert feature.rings == ((tuple(centre),),)
    assert feature.radius_m == pytest.approx(radius_m)


def same_times(feature, periods, is_permanent=False):
    """Check the periods and their daily schedules against another reader's."""
    expected = []
    for period in [] if is_permanent else periods:
        bounds = tuple(
            moment and moment.datetime for moment in (period.startDateTime, period.endDateTime)
        )
        for daily in period.schedule or [None]:
            days, first, last = frozenset(), None, None
            if daily is not None:
                days = frozenset(DAYS.index(day) for day in daily.day if day != "ANY")
                first, last = daily.startTime, daily.endTime
                first, last = (
                    time.fromisoformat(str(each).rstrip("Z")[:8]) for each in (first, last)
                )
            expected.append((*bounds, days, first, last))
    found = [(p.start, p.end, p.days, p.first, p.last) for p in feature.periods]
    assert found == expected


def judge_ed269(data, features):
    volumes = iter(features)
    for zone in json.loads(data)["features"]:
        periods = [
            ImplicitDict.parse({"permanent": "NO", **each}, ApplicableTimePeriod)
            for each in zone["applicability"]
            if "permanent" not in each
        ]
        for each in zone["geometry"]:
            volume = ImplicitDict.parse(each, UASZoneAirspaceVolume)
            feature = next(volumes)
            unit = {"M": 1.0, "FT": 0.3048}[volume.uomDimensions.value]
            limits = [
                None if value is None else (value * unit, reference.value)
                for value, reference in (
                    (each["lowerLimit"], volume.lowerVerticalReference),
                    (each["upperLimit"], volume.upperVerticalReference),
                )
            ]
            same_heights(feature, limits)
            projection = volume.horizontalProjection
            if projection.type.value == "Circle":
                same_circle(feature, projection.center, projection.radius)
            else:
                same_polygon(feature, shapely.Polygon(projection.coordinates[0]))
            same_times(feature, periods)
            assert feature.category == zone["restriction"]
            assert feature.forbids == (zone["restriction"] != "NO_RESTRICTION")
            assert feature.name == " ".join(zone["name"].split())
    assert next(volumes, None) is None


def parts_of(geometry):
    """Yield circles as geometries and polygons as shapely has them, with their layers."""
    for part in geometry.get("geometries", [geometry]):
        layer = ImplicitDict.parse({"uom": "m", **part["layer"]}, VerticalLayer)
        if "extent" in part:
            yield part, layer
            continue
        shape = shapely.geometry.shape(part)
        for polygon in getattr(shape, "geoms", [shape]):
            yield polygon, layer


def judge_ed318(data, features):
    found = iter(features)
    for zone in json.loads(data)["features"]:
        properties = zone["properties"]
        periods = [
            ImplicitDict.parse(each, TimePeriod)
            for each in properties.get("limitedApplicability", [])
        ]
        for part, layer in parts_of(zone["geometry"]):
            feature = next(found)
            unit = {"m": 1.0, "ft": 0.3048}[layer.uom.value]
            same_heights(
                feature,
                [
                    (layer.lower * unit, layer.lowerReference.value),
                    (layer.upper * unit, layer.upperReference.value),
                ],
            )
            if isinstance(part, dict):
                same_circle(feature, part["coordinates"], part["extent"]["radius"])
            else:
                same_polygon(feature, part)
            same_times(feature, periods)
            assert feature.category == properties["type"].replace("IZATION", "ISATION")
            assert feature.forbids == (properties["type"] != "NO_RESTRICTION")
            assert feature.name == " ".join(properties["name"][0]["text"].split())
    assert next(found, None) is None


def judge_openaip(data, features):
    document = json.loads(data)
    listed = document.get("items") or document["features"]
    for feature, each in zip(features, listed, strict=True):
        properties = each.get("properties", each)
        same_polygon(feature, shapely.geometry.shape(each["geometry"]))
        expected = []
        for limit in (properties["lowerLimit"], properties["upperLimit"]):
            metres = limit["value"] * {0: 1.0, 1: 0.3048, 6: 30.48}[limit["unit"]]
            expected.append((metres, ("AGL", "AMSL", "STD")[limit["referenceDatum"]]))
        same_heights(feature, expected)
        # Types described in the documents of openAIP, with an obvious consequence.
        plain = {1: True, 2: True, 3: True, 4: True, 7: True, 10: False, 21: False, 33: False}
        # The classes A to D require a clearance, whatever the type says.
        is_controlled = properties["icaoClass"] < 4
        if properties["type"] in plain:
            assert feature.forbids == (plain[properties["type"]] or is_controlled)
        if properties["type"] == 0 and properties["icaoClass"] < 7:
            assert feature.category == "ABCDEFG"[properties["icaoClass"]]


def judge_inav(data, features):
    found = iter(features)
    for each in json.loads(data)["features"]:
        properties = each["properties"]
        feature = next(found)
        shape = shapely.geometry.shape(each["geometry"])
        if shape.geom_type == "Point":
            same_circle(feature, shape.coords[0], properties["Radius"])
        else:
            same_polygon(feature, shape)
        assert feature.keeps_in == (properties["Type"] == "Inclusive")
        low, high = (
            (properties[name], "AMSL") if properties[name] else None
            for name in ("MinAlt", "MaxAlt")
        )
        is_above_home = properties["IsAMSL"] == "false" and (low or high)
        assert len(feature.remarks) == bool(is_above_home)
        low, high = (None, None) if is_above_home else (low, high)
        if not feature.keeps_in:
            same_heights(feature, [low, high])
            continue
        same_heights(feature, [None, None])
        # Below the floor and above the ceiling of the same area.
        for limits in ([None, low], [high, None]):
            if any(limits):
                part = next(found)
                assert (part.rings, part.radius_m) == (feature.rings, feature.radius_m)
                assert not part.keeps_in
                same_heights(part, limits)
    assert next(found, None) is None


def judge_faa(data, features):
    found = iter(features)
    units = {"FT": 0.3048, "M": 1.0, "FL": 30.48}
    references = {"MSL": "AMSL", "AGL": "AGL", "SFC": "AGL", "STD": "STD"}
    for each in json.loads(data)["features"]:
        properties, shape = each["properties"], shapely.geometry.shape(each["geometry"])
        if "CEILING" in properties:
            height = (properties["CEILING"] * 0.3048, "AGL")
            both = [([None, height], "REQ_AUTHORISATION"), ([height, None], "RESTRICTED")]
            for limits, category in both if height[0] else [([None, None], "RESTRICTED")]:
                feature = next(found)
                same_polygon(feature, shape)
                same_heights(feature, limits)
                assert feature.category == category
            continue
        feature = next(found)
        same_polygon(feature, shape)
        limits = []
        for side in ("LOWER", "UPPER"):
            code, value = properties[f"{side}_CODE"], properties[f"{side}_VAL"]
            is_none = code in (None, "UNLTD")
            limits.append(
                None
                if is_none
                else (float(value) * units[properties[f"{side}_UOM"]], references[code])
            )
        same_heights(feature, limits)
        is_class = properties["TYPE_CODE"] == "CLASS"
        assert feature.forbids == (not is_class or properties["CLASS"] in "BCD")
    assert next(found, None) is None


def judge_kmz(data, features):
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        (name,) = (name for name in archive.namelist() if name.lower().endswith("kml"))
        document = KML.from_string(archive.read(name))
    placemarks = list(document.features[0].features)
    for feature, placemark in zip(features, placemarks, strict=True):
        assert feature.name == placemark.name
        same_polygon(feature, shapely.geometry.shape(placemark.geometry))
        same_heights(feature, [None, (120.0, "AMSL")])


def judge_fences(data, features, name, folder):
    """Compare with the fence that MAVProxy would upload."""
    mavutil.set_dialect("ardupilotmega")
    file = folder / name
    file.write_bytes(data)
    if name.endswith(".fen"):
        loader = mavwp.MAVFenceLoader()
        loader.load(str(file))
        _, *corners = [(point.lng, point.lat) for point in loader.points]
        same_polygon(features[0], shapely.Polygon(corners))
        assert features[0].keeps_in
        return
    loader = mavwp.MAVWPLoader()
    loader.load(str(file))
    items = [loader.wp(number) for number in range(1, loader.count())]
    at = 0
    for feature in features:
        item = items[at]
        if item.command in (5003, 5004):
            same_circle(feature, (item.y, item.x), item.param1)
            assert feature.keeps_in == (item.command == 5003)
            at += 1
            continue
        corners = items[at : at + int(item.param1)]
        same_polygon(feature, shapely.Polygon([(each.y, each.x) for each in corners]))
        assert feature.keeps_in == (item.command == 5001)
        at += len(corners)
    assert at == len(items)


def sampled(elements):
    """Return the outline of aerofiles' elements in degrees, its arcs in 4,000 pieces."""
    outline = []
    for element in elements:
        if element["type"] == "point":
            outline.append(element["location"][::-1])
            continue
        lon, lat = element["center"][1], element["center"][0]
        if element["type"] == "circle":
            element = {**element, "start": 0, "end": 0, "clockwise": True}
        if "radius" in element:
            ends = [
                (element["start"], element["radius"] * 1852),
                (element["end"], element["radius"] * 1852),
            ]
        else:
            ends = []
            for place in (element["start"], element["end"]):
                bearing, _, distance = EARTH.inv(lon, lat, place[1], place[0])
                ends.append((bearing, distance))
        (first, near), (last, far) = ends
        sweep = (last - first) % 360 or 360
        if not element["clockwise"]:
            sweep = -((first - last) % 360 or 360)
        shares = np.linspace(0, 1, 4001)
        count = len(shares)
        east, north, _ = EARTH.fwd(
            np.full(count, lon),
            np.full(count, lat),
            first + shares * sweep,
            near + shares * (far - near),
        )
        outline += zip(east, north, strict=True)
    return np.array(outline)


def in_metres(points, centre):
    system = f"+proj=aeqd +lon_0={centre[0]} +lat_0={centre[1]} +ellps=WGS84"
    to_plane = Transformer.from_crs("EPSG:4326", system, always_xy=True)
    return np.column_stack(to_plane.transform(*np.array(points).T))


def judge_openair(data, features):
    encoding = "utf-8-sig"
    try:
        data.decode(encoding)
    except UnicodeDecodeError:
        encoding = "cp1252"
    records = list(Reader(io.TextIOWrapper(io.BytesIO(data), encoding)))
    for feature, (record, error) in zip(features, records, strict=True):
        assert error is None
        assert feature.name == record["name"]
        stated = [zone_files.LIMIT_TEXTS[record[side]] for side in ("floor", "ceiling")]
        same_heights(feature, stated)
        begins = [each["start"] for each in record["activation"]]
        assert [period.start for period in feature.periods] == begins
        plain = {"R": True, "Q": True, "P": True, "CTR": True, "G": False, "W": False}
        if record["class"] in plain:
            assert feature.forbids == plain[record["class"]]
        elements = record["elements"]
        if elements[0]["type"] == "circle":
            centre = elements[0]["center"][::-1]
            assert np.allclose(feature.rings[0][0], centre, rtol=0, atol=1e-9)
            assert feature.radius_m == pytest.approx(elements[0]["radius"] * 1852)
            continue
        outline = sampled(elements)
        if all(element["type"] == "point" for element in elements):
            same_polygon(feature, shapely.Polygon(outline))
            continue
        centre = outline.mean(axis=0)
        exact = shapely.Polygon(in_metres(outline, centre))
        ours = shapely.Polygon(in_metres(feature.rings[0], centre))
        assert exact.is_valid
        assert ours.is_valid
        # An arc is never cut off, whichever way it bends, and no more than half a metre is added.
        assert ours.buffer(0.02).covers(exact)
        assert exact.buffer(0.55).covers(ours)


def judge(kind, data, name, features, folder):
    if kind in ("fen", "waypoints"):
        judge_fences(data, features, name, folder)
    else:
        globals()[f"judge_{kind}"](data, features)


def check(kind, seed, folder):
    data, name = zone_files.FORMATS[kind](random.Random(f"{kind} {seed}"))
    # A file is known by its content, whatever its name; a fence of two columns is an exception.
    for stated in (name, "download"):
        found, features = read(Content(data, stated))
        assert found == kind
        judge(kind, data, name, features, folder)


@pytest.mark.parametrize("seed", range(FILES))
@pytest.mark.parametrize("kind", zone_files.FORMATS)
def test_reads_random_files_as_other_readers_do(kind, seed, tmp_path):
    check(kind, seed, tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("kind", zone_files.FORMATS)
def test_reads_many_random_files_as_other_readers_do(kind, tmp_path):
    for seed in range(FILES, FILES + MANY_FILES):
        check(kind, seed, tmp_path)


def check_broken(kind, seed):
    """Read a broken file: each fault gives a bad part, or one error message for the file."""
    data, name = zone_files.broken(kind, random.Random(f"broken {kind} {seed}"))
    content = Content(data, name)
    row = next((row for row in FORMATS if row.zones and row.module.recognises(content)), None)
    if row is None:
        assert isinstance(content.looks_like, str)
        return
    try:
        parts = list(row.module.features(content))
    except InputError as error:
        parts = [Bad("file", str(error))]
    for part in parts:
        if isinstance(part, Bad):
            assert part.reason.endswith(".")
            assert "\n" not in part.reason
        elif isinstance(part, Feature):
            assert all(np.isfinite(ring).all() for ring in part.rings)
            assert part.radius_m is None or part.radius_m > 0


@pytest.mark.parametrize("kind", zone_files.FORMATS)
def test_broken_files_are_refused_in_words(kind):
    for seed in range(25):
        check_broken(kind, seed)


@pytest.mark.long
@pytest.mark.parametrize("kind", zone_files.FORMATS)
def test_many_broken_files_are_refused_in_words(kind):
    for seed in range(25, 2000):
        check_broken(kind, seed)
