"""Scenes of zones as files, one function per format, written from the definitions of the formats.

The style of a zone depends on the seed and its name alone, so a zone that is left out changes no
other.
"""

import io
import json
import random
import zipfile
from datetime import UTC
from xml.sax.saxutils import escape

import numpy as np

from tests.support.host.zone_openair import openair
from tests.support.host.zone_scenes import transformer


_DAYS = ("MON", "TUE", "WED", "THU", "FRI", "SAT", "SUN")


def write(scene, folder, name="zones"):
    """Write the zones of a scene; return the file."""
    data, suffix = globals()[f"_{scene.kind}"](scene)
    file = folder / f"{name}{suffix}"
    file.write_bytes(data)
    return file


def _style(scene, area):
    return random.Random(f"style {scene.seed} {area.name}")


def _places(scene, area, ring, rng):
    """Return corners as the file has them: longitudes beyond 180 or not, swapped if so planted."""
    wraps = rng.random() < 0.5
    lon, lat = np.array(ring, dtype=float).T
    if wraps:
        lon = (lon + 180) % 360 - 180
    pairs = list(zip(lon.round(7).tolist(), lat.round(7).tolist(), strict=True))
    return [(b, a) for a, b in pairs] if area.name == scene.swapped else pairs


def _rings(scene, area, rng, closes=None):
    """Return rings, each closed or not."""
    found = []
    for ring in area.rings:
        places = _places(scene, area, ring, random.Random(f"{scene.seed} {area.name}"))
        closed = rng.random() < 0.7 if closes is None else closes
        found.append([*places, places[0]] if closed else places)
    return found


def _centre(scene, area, rng):
    return _places(scene, area, [area.circle[:2]], rng)[0]


def _geometry(scene, area, rng):
    """Return the geometry of GeoJSON, also as a part of a larger kind."""
    if area.circle:
        return {"type": "Point", "coordinates": list(_centre(scene, area, rng))}
    rings = [[list(place) for place in ring] for ring in _rings(scene, area, rng)]
    if rng.random() < 0.2:
        rings = [[[*place, 12.5] for place in ring] for ring in rings]
    if rng.random() < 0.3:
        return {"type": "MultiPolygon", "coordinates": [rings]}
    return {"type": "Polygon", "coordinates": rings}


def _text(document, scene):
    rng = random.Random(f"encoding {scene.seed}")
    text = json.dumps(document, ensure_ascii=rng.random() < 0.5, indent=rng.choice((None, 1)))
    return text.encode(rng.choice(("utf-8", "utf-8", "utf-8-sig", "utf-16")))


# --- GeoJSON and its kin --------------------------------------------------------------------------


def _limit_text(limit, rng):
    if limit.unit == "FL":
        return rng.choice((f"FL {limit.value:.0f}", f"FL{limit.value:03.0f}"))
    value = f"{limit.value:g}"
    if limit.surface == "AGL" and limit.value == 0:
        return rng.choice(("GND", "SFC"))
    if limit.surface == "WGS84":
        return f"{value} {limit.unit} WGS84"
    words = {"AMSL": ("AMSL", "MSL", "amsl"), "AGL": ("AGL", "ASFC", "agl")}[limit.surface]
    return f"{value}{rng.choice((' ', ''))}{limit.unit} {rng.choice(words)}"


def _geojson(scene):
    features = []
    system = random.Random(f"system {scene.seed}").choice((None, None, scene.site.crs, "EPSG:4258"))
    # The edges of a projected system are straight there; a scene has them straight in degrees.
    is_wide = any(np.ptp(np.array(ring)[:, 0]) > 0.2 for area in scene.areas for ring in area.rings)
    if scene.swapped or scene.site.lon > 179 or is_wide:
        system = None
    for area in scene.areas:
        rng = _style(scene, area)
        properties = {rng.choice(("name", "Name", "title")): area.name}
        limits = area.lower, area.upper
        plain = all(each is None or (each.surface, each.unit) == ("AMSL", "m") for each in limits)
        if plain and rng.random() < 0.6:
            for key, limit in zip(("lower", "upper"), limits, strict=True):
                if limit is not None:
                    properties[key] = limit.value
        else:
            keys = rng.choice(
                (("lowerLimit", "upperLimit"), ("floor", "ceiling"), ("lower_limit", "upper_limit"))
            )
            for key, limit in zip(keys, limits, strict=True):
                if limit is None:
                    if rng.random() < 0.3 and key == keys[1]:
                        properties[key] = "UNL"
                elif rng.random() < 0.3 and limit.unit != "FL":
                    properties[key] = {
                        "value": limit.value, "unit": limit.unit, "reference": limit.surface,
                    }  # fmt: skip
                else:
                    properties[key] = _limit_text(limit, rng)
        for key, value in zip(("t0", "t1"), area.seconds, strict=True):
            if value is not None:
                properties[key] = value
        geometry = _geometry(scene, area, rng)
        if area.circle:
            properties["radius_m"] = area.circle[2]
        if system is not None:
            geometry = _converted(geometry, system)
        features.append({"type": "Feature", "properties": properties, "geometry": geometry})
    document = {"type": "FeatureCollection", "features": features}
    if system is not None:
        code = system.replace("EPSG:", "urn:ogc:def:crs:EPSG::")
        document["crs"] = {"type": "name", "properties": {"name": code}}
    return _text(document, scene), ".geojson"


def _converted(geometry, system):
    to = transformer(4326, system)

    def moved(value):
        if isinstance(value[0], list):
            return [moved(each) for each in value]
        return [*to.transform(*value[:2]), *value[2:]]

    return {**geometry, "coordinates": moved(geometry["coordinates"])}


def _openaip(scene):
    items = []
    for area in scene.areas:
        rng = _style(scene, area)
        kind, icao = map(int, area.word.split())
        facts = {"_id": "0123456789abcdef", "name": area.name, "type": kind, "icaoClass": icao}
        lower = {"value": 0, "unit": 1, "referenceDatum": 0}
        facts["lowerLimit"] = lower if area.lower is None else _numbered(area.lower)
        facts["upperLimit"] = {"unlimited": True} if area.upper is None else _numbered(area.upper)
        listed = []
        for hours in area.hours:
            if hours.first is None:
                facts |= {
                    key: f"{each:%Y-%m-%dT%H:%M:%SZ}"
                    for key, each in (("activeFrom", hours.start), ("activeUntil", hours.end))
                    if each is not None
                }
                continue
            for day in hours.days or range(7):
                entry = {"dayOfWeek": day, "byNotam": False, "sunrise": False, "sunset": False}
                first = "00:00" if hours.first in ("SR", "SS") else hours.first
                last = "00:00" if hours.last in ("SR", "SS", "24:00") else hours.last
                entry |= {"startTime": first, "endTime": last}
                entry["sunrise"] = hours.first == "SR"
                entry["sunset"] = hours.last == "SS"
                listed.append(entry)
        if listed:
            facts["hoursOfOperation"] = {"operatingHours": listed}
        items.append((facts, _geometry(scene, area, rng)))
    if random.Random(scene.seed).random() < 0.5:
        page = [{**facts, "geometry": geometry} for facts, geometry in items]
        return _text({"limit": 100, "page": 1, "items": page}, scene), ".json"
    features = [{"type": "Feature", "properties": f, "geometry": g} for f, g in items]
    return _text({"type": "FeatureCollection", "features": features}, scene), ".geojson"


def _numbered(limit):
    return {
        "value": limit.value,
        "unit": {"m": 0, "ft": 1, "FL": 6}[limit.unit],
        "referenceDatum": {"AGL": 0, "AMSL": 1, "STD": 2}[limit.surface],
    }


def _periods(area, seconds):
    """Return the periods of ED-269 and ED-318."""
    found = []
    for hours in area.hours:
        period = {
            key: f"{each.astimezone(UTC):%Y-%m-%dT%H:%M:%SZ}"
            for key, each in (("startDateTime", hours.start), ("endDateTime", hours.end))
            if each is not None
        }
        if hours.first is not None:
            zone = "Z" if hours.offset_h == 0 else f"{hours.offset_h:+03}:00"
            day = [_DAYS[each] for each in hours.days] or ["ANY"]
            daily = {"day": day}
            for side, bound in (("start", hours.first), ("end", hours.last)):
                if ":" in bound:
                    daily[f"{side}Time"] = f"{bound}:{seconds}{zone}"
                else:
                    daily[f"{side}Event"] = bound
            period["schedule"] = [daily]
        found.append(period)
    return found


def _ed269(scene):
    features = []
    for number, area in enumerate(scene.areas):
        rng = _style(scene, area)
        unit = next((each.unit for each in (area.lower, area.upper) if each), "m")
        volume = {"uomDimensions": {"m": "M", "ft": "FT"}[unit]}
        for side, limit in (("lower", area.lower), ("upper", area.upper)):
            volume[f"{side}Limit"] = None if limit is None else limit.value
            volume[f"{side}VerticalReference"] = "AGL" if limit is None else limit.surface
        if area.circle:
            volume["horizontalProjection"] = {
                "type": "Circle",
                "center": list(_centre(scene, area, rng)),
                "radius": area.circle[2],
            }
        else:
            volume["horizontalProjection"] = {
                "type": "Polygon",
                "coordinates": [[list(p) for p in ring] for ring in _rings(scene, area, rng)],
            }
        features.append(
            {
                "identifier": f"T{number}", "country": "NOR", "name": area.name, "type": "COMMON",
                "restriction": area.word,
                "applicability": _periods(area, "00.00") or [{"permanent": "YES"}],
                "geometry": [volume],
            }
        )  # fmt: skip
    return _text({"title": "test", "features": features}, scene), ".json"


def _ed318(scene):
    features = []
    for number, area in enumerate(scene.areas):
        rng = _style(scene, area)
        geometry = _geometry(scene, area, rng)
        unit = next((each.unit for each in (area.lower, area.upper) if each), "m")
        layer = {"uom": unit} if unit == "ft" or rng.random() < 0.5 else {}
        for side, limit in (("lower", area.lower), ("upper", area.upper)):
            if limit is not None:
                layer |= {side: limit.value, f"{side}Reference": limit.surface}
        if layer or rng.random() < 0.5:
            geometry["layer"] = layer
        if area.circle:
            geometry["extent"] = {"subType": "Circle", "radius": area.circle[2]}
        properties = {
            "identifier": f"T{number}", "country": "NOR", "type": area.word, "variant": "COMMON",
            "name": [{"text": area.name, "lang": "en-GB"}],
            "zoneAuthority": [{"purpose": "AUTHORIZATION"}],
        }  # fmt: skip
        if area.hours:
            properties["limitedApplicability"] = _periods(area, "00")
        if rng.random() < 0.3:
            geometry = {"type": "GeometryCollection", "geometries": [geometry]}
        features.append({"type": "Feature", "properties": properties, "geometry": geometry})
    return _text({"type": "FeatureCollection", "features": features}, scene), ".geojson"


def _inav(scene):
    features = []
    for area in scene.areas:
        rng = _style(scene, area)
        properties = {
            "Name": area.name, "Type": "Inclusive" if area.keeps_in else "Exclusive",
            "Action": "Avoid", "IsAMSL": rng.choice(("true", True, 1)),
        }  # fmt: skip
        for key, limit in (("MinAlt", area.lower), ("MaxAlt", area.upper)):
            properties[key] = 0 if limit is None else limit.value
        if area.circle:
            properties["Radius"] = area.circle[2]
        geometry = _geometry(scene, area, rng)
        features.append({"type": "Feature", "properties": properties, "geometry": geometry})
    return _text({"type": "FeatureCollection", "features": features}, scene), ".geojson"


# --- KML ------------------------------------------------------------------------------------------


def _kml(scene):
    rng = random.Random(f"encoding {scene.seed}")
    encoding, declared = rng.choice(
        (("utf-8", "UTF-8"), ("utf-16", "UTF-16"), ("cp1252", "windows-1252"), ("utf-8-sig", ""))
    )
    head = f'<?xml version="1.0" encoding="{declared}"?>\n' if declared else ""
    space = rng.choice((' xmlns="http://www.opengis.net/kml/2.2"', ""))
    marks = "".join(_placemark(scene, area) for area in scene.areas)
    text = f"{head}<kml{space}><Document><Folder>{marks}</Folder></Document></kml>"
    return text.encode(encoding), ".kml"


def _kmz(scene):
    rng = random.Random(f"archive {scene.seed}")
    archive = io.BytesIO()
    with zipfile.ZipFile(
        archive, "w", rng.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))
    ) as file:
        file.writestr(rng.choice(("doc.kml", "zones.KML")), _kml(scene)[0])
    return archive.getvalue(), ".kmz"


def _placemark(scene, area):
    rng = _style(scene, area)
    data = {
        key: f"{value:g}" for key, value in zip(("t0", "t1"), area.seconds, strict=True)
        if value is not None
    }  # fmt: skip
    limits = [each for each in (area.lower, area.upper) if each]
    is_stated = bool(area.circle) or area.upper is None or rng.random() < 0.3
    if area.circle:
        data["radius_m"] = f"{area.circle[2]:g}"
    if is_stated and all(each.surface == "AMSL" for each in limits) and (limits or area.circle):
        for key, limit in (("lower", area.lower), ("upper", area.upper)):
            data[key] = "none" if limit is None else f"{limit.value:g}"
        limits = []
    if area.circle:
        lon, lat = _centre(scene, area, rng)
        drawn = f"<Point><coordinates>{lon:.7f},{lat:.7f}</coordinates></Point>"
    else:
        drawn = _drawn(scene, area, limits, rng)
    extended = "".join(
        f'<Data name="{key}"><value>{value}</value></Data>' for key, value in data.items()
    )
    if rng.random() < 0.3:
        extended = "".join(
            f'<SimpleData name="{key}">{value}</SimpleData>' for key, value in data.items()
        )
        extended = f"<SchemaData>{extended}</SchemaData>"
    extended = f"<ExtendedData>{extended}</ExtendedData>" if data else ""
    return f"<Placemark><name>{escape(area.name)}</name>{extended}{drawn}</Placemark>"


def _drawn(scene, area, limits, rng):
    """Return polygons: one on the ground, one extruded to it, or the lid and bottom of a prism."""
    rings = _rings(scene, area, rng, closes=True)
    mode = {"AMSL": "absolute", "AGL": "relativeToGround"}[limits[0].surface] if limits else ""
    tag = f"<altitudeMode>{mode}</altitudeMode>" if mode else ""
    if len(limits) == 2:
        sheets = "".join(_polygon(rings, limit.value, tag) for limit in limits)
        return f"<MultiGeometry>{sheets}</MultiGeometry>"
    if limits:
        return _polygon(rings, limits[0].value, f"<extrude>1</extrude>{tag}")
    kind = rng.choice(("Polygon", "LineString", "LinearRing")) if len(rings) == 1 else "Polygon"
    if kind != "Polygon":
        return f"<{kind}><coordinates>{_listed(rings[0], 0)}</coordinates></{kind}>"
    return _polygon(rings, 0, rng.choice(("", "<altitudeMode>clampToGround</altitudeMode>")))


def _polygon(rings, height, head):
    sides = ("outerBoundaryIs", *["innerBoundaryIs"] * (len(rings) - 1))
    inner = "".join(
        f"<{side}><LinearRing><coordinates>{_listed(ring, height)}</coordinates></LinearRing>"
        f"</{side}>"
        for side, ring in zip(sides, rings, strict=True)
    )
    return f"<Polygon>{head}{inner}</Polygon>"


def _listed(ring, height):
    return " ".join(f"{lon:.7f},{lat:.7f},{height:g}" for lon, lat in ring)


# --- Fences and OpenAir ---------------------------------------------------------------------------


def _plan(scene):
    circles, polygons = [], []
    for area in scene.areas:
        rng = _style(scene, area)
        if area.circle:
            lon, lat = _centre(scene, area, rng)
            circle = {"center": [lat, lon], "radius": area.circle[2]}
            circles.append({"version": 1, "inclusion": area.keeps_in, "circle": circle})
            continue
        corners = [[lat, lon] for lon, lat in _rings(scene, area, rng, closes=False)[0]]
        polygons.append({"version": 1, "inclusion": area.keeps_in, "polygon": corners})
    document = {
        "fileType": "Plan", "version": 1, "groundStation": "QGroundControl",
        "mission": {"version": 2, "items": [], "plannedHomePosition": [0, 0, 0]},
        "geoFence": {"version": 2, "circles": circles, "polygons": polygons},
        "rallyPoints": {"version": 2, "points": []},
    }  # fmt: skip
    return json.dumps(document).encode(), ".plan"


def _waypoints(scene):
    rows = []
    for area in scene.areas:
        rng = _style(scene, area)
        if area.circle:
            lon, lat = _centre(scene, area, rng)
            rows.append((5003 if area.keeps_in else 5004, area.circle[2], lon, lat))
            continue
        corners = _rings(scene, area, rng, closes=False)[0]
        rows += [(5001 if area.keeps_in else 5002, len(corners), *corner) for corner in corners]
    lines = ["QGC WPL 110", "0\t1\t0\t16\t0\t0\t0\t0\t60.0\t10.0\t100\t1"]
    for number, (command, size, lon, lat) in enumerate(rows, start=1):
        lines.append(f"{number}\t0\t3\t{command}\t{size}\t0\t0\t0\t{lat:.7f}\t{lon:.7f}\t0\t1")
    return "\n".join((*lines, "")).encode(), ".waypoints"


def _fen(scene):
    (area,) = scene.areas
    rng = _style(scene, area)
    ring = _rings(scene, area, rng)[0]
    rows = [ring[0], *ring]
    lines = [f"{lat:.7f}{rng.choice((' ', chr(9)))}{lon:.7f}" for lon, lat in rows]
    return "\n".join(("#saved by a ground station", *lines, "")).encode(), ".fen"


def _openair(scene):
    return openair(scene, _style, _places), ".txt"
