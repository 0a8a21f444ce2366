"""Random files of zones, one function per format, written from the definitions of the formats."""

import copy
import io
import json
import math
import random
import zipfile


#: Texts of limits, with their metres and references; None means no limit.
LIMIT_TEXTS = {
    "GND": (0.0, "AGL"),
    "SFC": (0.0, "AGL"),
    "FL 95": (9500 * 0.3048, "STD"),
    "FL065": (6500 * 0.3048, "STD"),
    "4500 ft AMSL": (4500 * 0.3048, "AMSL"),
    "4500ft MSL": (4500 * 0.3048, "AMSL"),
    "1000 ft AGL": (1000 * 0.3048, "AGL"),
    "300m AGL": (300.0, "AGL"),
    "1,500 ft AMSL": (1500 * 0.3048, "AMSL"),
    "1200.5 m MSL": (1200.5, "AMSL"),
    "2500FT GND": (2500 * 0.3048, "AGL"),
    "UNL": None,
    "UNLIMITED": None,
}
_NAMES = ("R-7", "Zürich", "Łódź CTR", "Área 51", 'it\'s, one; "quoted"', "TMA – 2")
_OPENAIR = ("R", "Q", "P", "CTR", "A", "B", "C", "D", "E", "F", "G", "W", "GP", "RMZ", "TMZ")
_MONTHS = [f"2026-{month:02}-01T06:30:00" for month in range(1, 13)]


def _centre(rng):
    return rng.uniform(-170, 170), rng.uniform(-65, 65)


def _ring(rng, centre, size=0.1):
    """Return a closed star-shaped ring in either direction."""
    lon, lat = centre
    angles = sorted(rng.uniform(0, 2 * math.pi) for _ in range(rng.randint(3, 9)))
    if rng.random() < 0.5:
        angles.reverse()
    ring = []
    for angle in angles:
        reach = rng.uniform(0.3, 1.0) * size
        east, north = reach * math.cos(angle), reach * math.sin(angle)
        ring.append([round(lon + east / math.cos(math.radians(lat)), 7), round(lat + north, 7)])
    return [*ring, ring[0]]


def _angle(rng, degrees, letters, width):
    """Return an angle in minutes or seconds, and the rounding of the text."""
    letter, size = letters[degrees < 0], abs(degrees)
    whole = int(size)
    blank = rng.choice(("", " "))
    if rng.random() < 0.5:
        return f"{whole:0{width}}:{(size - whole) * 60:07.4f}{blank}{letter}"
    minutes = int((size - whole) * 60)
    seconds = min((size - whole - minutes / 60) * 3600, 59.999)
    return f"{whole:0{width}}:{minutes:02}:{seconds:06.3f}{blank}{letter}"


def _place(rng, position):
    # One form for both, as the format requires.
    state = rng.random()
    one, other = random.Random(state), random.Random(state)
    return f"{_angle(one, position[1], 'NS', 2)} {_angle(other, position[0], 'EW', 3)}"


def openair(rng):
    """Return airspaces of polygons, circles, sectors and rings of arcs."""
    lines = ["* made for a test"]
    for _ in range(rng.randint(1, 4)):
        lines += ["", f"AC {rng.choice(_OPENAIR)}", f"AN {rng.choice(_NAMES)}"]
        for record in ("AL", "AH"):
            lines.append(f"{record} {rng.choice(list(LIMIT_TEXTS))}")
        if rng.random() < 0.2:
            lines.append(f"AA {rng.choice(_MONTHS)[:16]}Z/NONE")
        lines += _outline(rng)
    encoding = rng.choice(("utf-8", "utf-8-sig", "cp1252"))
    ending = rng.choice(("\n", "\r\n"))
    return ending.join(lines).encode(encoding, "replace"), "airspace.txt"


def _outline(rng):
    from pyproj import Geod

    earth = Geod(ellps="WGS84")
    centre = _centre(rng)
    kind = rng.choice(("polygon", "circle", "sector", "ring"))
    if kind == "polygon":
        return [f"DP {_place(rng, corner)}" for corner in _ring(rng, centre)]
    lines = [f"V X={_place(rng, centre)}"]
    radius = round(rng.uniform(0.5, 20), 2)
    if kind == "circle":
        return [*lines, f"DC {radius}"]
    start, sweep = rng.randrange(360), rng.randrange(10, 340)
    clockwise = rng.random() < 0.5
    end = (start + sweep if clockwise else start - sweep) % 360
    lines.append(f"V D={'+' if clockwise else '-'}")

    def on_circle(bearing, miles):
        lon, lat, _ = earth.fwd(*centre, bearing, miles * 1852)
        return lon, lat

    if rng.random() < 0.5:
        lines.append(f"DA {radius},{start},{end}")
    else:
        ends = (on_circle(start, radius), on_circle(end, radius))
        lines.append("DB " + ", ".join(_place(rng, place) for place in ends))
    if kind == "sector":
        return [*lines, f"DP {_place(rng, centre)}"]
    return [*lines, f"V D={'-' if clockwise else '+'}", f"DA {radius / 2:.3f},{end},{start}"]


def _periods(rng, seconds):
    """Return periods of ED-269 and ED-318, which differ in how they write the time of day."""
    periods = []
    for _ in range(rng.randint(0, 2)):
        first, last = sorted(rng.sample(_MONTHS, 2))
        schedule = [
            {
                "day": rng.choice((["ANY"], ["MON"], ["SAT", "SUN"])),
                "startTime": f"{rng.randrange(12):02}:00:{seconds}Z",
                "endTime": f"{rng.randrange(12, 24):02}:30:{seconds}Z",
            }
            for _ in range(rng.randint(0, 2))
        ]
        period = {"startDateTime": f"{first}Z", "endDateTime": f"{last}Z"}
        periods.append({**period, "schedule": schedule} if schedule else period)
    return periods


def ed269(rng):
    features = []
    for number in range(rng.randint(1, 4)):
        volumes = []
        for _ in range(rng.randint(1, 2)):
            centre = _centre(rng)
            shape = (
                {
                    "type": "Circle",
                    "center": list(centre),
                    "radius": round(rng.uniform(50, 9000), 1),
                }
                if rng.random() < 0.5
                else {"type": "Polygon", "coordinates": [_ring(rng, centre)]}
            )
            lower = rng.choice((None, 0, rng.randrange(300)))
            upper = rng.choice((None, rng.randrange(300, 9000)))
            volumes.append(
                {
                    "uomDimensions": rng.choice(("M", "FT")),
                    "lowerLimit": lower,
                    "lowerVerticalReference": rng.choice(("AGL", "AMSL")),
                    "upperLimit": upper,
                    "upperVerticalReference": rng.choice(("AGL", "AMSL")),
                    "horizontalProjection": shape,
                }
            )
        features.append(
            {
                "identifier": f"TST{number:03}",
                "country": "NOR",
                "name": rng.choice(_NAMES),
                "type": "COMMON",
                "restriction": rng.choice(
                    ("PROHIBITED", "REQ_AUTHORISATION", "CONDITIONAL", "NO_RESTRICTION")
                ),
                "applicability": _periods(rng, "00.00") or [{"permanent": "YES"}],
                "geometry": volumes,
            }
        )
    return json.dumps({"title": "test", "features": features}).encode(), "zones.json"


def _layered(rng, geometry):
    references = ("AGL", "AMSL", "WGS84")
    layer = {
        "lower": rng.randrange(300),
        "lowerReference": rng.choice(references),
        "upper": rng.randrange(300, 9000),
        "upperReference": rng.choice(references),
    }
    if rng.random() < 0.7:
        layer["uom"] = rng.choice(("m", "ft"))
    return {**geometry, "layer": layer}


def _geometry318(rng):
    kind = rng.choice(("circle", "Polygon", "MultiPolygon"))
    centre = _centre(rng)
    if kind == "circle":
        extent = {"subType": "Circle", "radius": rng.randrange(50, 9000)}
        return _layered(rng, {"type": "Point", "coordinates": list(centre), "extent": extent})
    rings = [_ring(rng, centre)]
    return _layered(
        rng,
        {
            "type": kind,
            "coordinates": rings if kind == "Polygon" else [rings, [_ring(rng, centre)]],
        },
    )


def ed318(rng):
    features = []
    for number in range(rng.randint(1, 4)):
        parts = [_geometry318(rng) for _ in range(rng.randint(1, 2))]
        properties = {
            "identifier": f"T{number:03}",
            "country": "NOR",
            "name": [{"text": rng.choice(_NAMES), "lang": "en-GB"}],
            "type": rng.choice(
                ("USPACE", "PROHIBITED", "REQ_AUTHORIZATION", "CONDITIONAL", "NO_RESTRICTION")
            ),
            "variant": rng.choice(("COMMON", "CUSTOMIZED")),
            "zoneAuthority": [{"purpose": "AUTHORIZATION"}],
        }
        periods = _periods(rng, "00")
        if periods:
            properties["limitedApplicability"] = periods
        geometry = (
            parts[0] if len(parts) == 1 else {"type": "GeometryCollection", "geometries": parts}
        )
        features.append({"type": "Feature", "properties": properties, "geometry": geometry})
    return json.dumps({"type": "FeatureCollection", "features": features}).encode(), "a.geojson"


def openaip(rng):
    features = []
    for _ in range(rng.randint(1, 4)):
        unit = rng.choice((0, 1, 6))
        limits = [
            {"value": value, "unit": unit, "referenceDatum": 2 if unit == 6 else rng.choice((0, 1))}
            for value in (rng.randrange(0, 50), rng.randrange(50, 150))
        ]
        properties = {
            "_id": "0123456789abcdef",
            "name": rng.choice(_NAMES),
            "type": rng.randrange(37),
            "icaoClass": rng.choice((0, 1, 2, 3, 4, 5, 6, 8)),
            "lowerLimit": limits[0],
            "upperLimit": limits[1],
        }
        geometry = {"type": "Polygon", "coordinates": [_ring(rng, _centre(rng))]}
        features.append({"type": "Feature", "properties": properties, "geometry": geometry})
    if rng.random() < 0.5:
        items = [{**each["properties"], "geometry": each["geometry"]} for each in features]
        return json.dumps({"limit": 100, "page": 1, "items": items}).encode(), "a.json"
    return json.dumps({"type": "FeatureCollection", "features": features}).encode(), "a.geojson"


def inav(rng):
    features = []
    for number in range(rng.randint(1, 4)):
        centre = _centre(rng)
        properties = {
            "Name": f"Zone {number}",
            "Type": rng.choice(("Exclusive", "Inclusive")),
            "Action": "Avoid",
            "MinAlt": rng.choice((0, 23.0)),
            "MaxAlt": rng.choice((0, 120.0)),
            "IsAMSL": rng.choice(("true", "false")),
        }
        geometry = {"type": "Polygon", "coordinates": [_ring(rng, centre)]}
        if rng.random() < 0.5:
            properties["Radius"] = rng.uniform(50, 900)
            geometry = {"type": "Point", "coordinates": list(centre)}
        features.append({"type": "Feature", "properties": properties, "geometry": geometry})
    return json.dumps({"type": "FeatureCollection", "features": features}).encode(), "a.geojson"


def _side_of_faa(rng, side):
    value, unit, code = rng.choice(
        (
            (rng.randrange(100, 18000), "FT", rng.choice(("MSL", "AGL", "SFC", "STD"))),
            (str(rng.randrange(100, 18000)), "FT", "MSL"),
            (rng.randrange(180, 600), "FL", "STD"),
            (rng.randrange(30, 900), "M", "MSL"),
            (0, "FT", "SFC"),
            (-9998, None, None),
            (None, None, "UNLTD"),
        )
    )
    return {f"{side}_VAL": value, f"{side}_UOM": unit, f"{side}_CODE": code}


def faa(rng):
    features = []
    for number in range(rng.randint(1, 4)):
        properties = {"NAME": f"Area {number}", "OBJECTID": number}
        if rng.random() < 0.3:
            properties |= {"CEILING": rng.choice((0, 100, 400)), "UNIT": "Feet", "MAP_EFF": "5/1"}
        else:
            low, high = _side_of_faa(rng, "LOWER"), _side_of_faa(rng, "UPPER")
            # The order of two limits with the same reference is another test's.
            ground = ("SFC", "AGL")
            codes = [low["LOWER_CODE"], high["UPPER_CODE"]]
            if codes[0] == codes[1] or all(code in ground for code in codes):
                low |= {"LOWER_VAL": 0, "LOWER_UOM": "FT", "LOWER_CODE": "SFC"}
                high |= {"UPPER_VAL": -9998, "UPPER_UOM": None, "UPPER_CODE": None}
            properties |= low | high
            properties["TYPE_CODE"] = rng.choice(("CLASS", "R", "P", "W", "MOA"))
            properties["CLASS"] = rng.choice("BCDEG")
        geometry = {"type": "Polygon", "coordinates": [_ring(rng, _centre(rng))]}
        features.append({"type": "Feature", "properties": properties, "geometry": geometry})
    return json.dumps({"type": "FeatureCollection", "features": features}).encode(), "a.geojson"


def kmz(rng):
    placemarks = []
    for number in range(rng.randint(1, 4)):
        ring = _ring(rng, _centre(rng))
        places = " ".join(f"{lon:.7f},{lat:.7f},120" for lon, lat in ring)
        placemarks.append(
            f"<Placemark><name>Zone {number}</name><Polygon><extrude>1</extrude><altitudeMode>"
            "absolute</altitudeMode><outerBoundaryIs><LinearRing><coordinates>"
            f"{places}</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark>"
        )
    text = (
        '<?xml version="1.0" encoding="UTF-8"?><kml xmlns="http://www.opengis.net/kml/2.2">'
        f"<Document>{''.join(placemarks)}</Document></kml>"
    )
    archive = io.BytesIO()
    with zipfile.ZipFile(
        archive, "w", rng.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))
    ) as file:
        if rng.random() < 0.5:
            file.writestr("files/icon.png", b"\x89PNG")
        file.writestr(rng.choice(("doc.kml", "zones.KML")), text)
    return archive.getvalue(), "zones.kmz"


def waypoints(rng):
    rows = []
    for _ in range(rng.randint(1, 4)):
        centre = _centre(rng)
        inside = rng.random() < 0.5
        if rng.random() < 0.5:
            rows.append((5003 if inside else 5004, rng.randrange(50, 900), *centre))
            continue
        corners = _ring(rng, centre)[:-1]
        rows += [(5001 if inside else 5002, len(corners), *corner) for corner in corners]
    lines = ["QGC WPL 110", "0\t1\t0\t16\t0\t0\t0\t0\t60.0\t10.0\t100\t1"]
    for number, (command, size, lon, lat) in enumerate(rows, start=1):
        lines.append(f"{number}\t0\t3\t{command}\t{size}\t0\t0\t0\t{lat:.7f}\t{lon:.7f}\t0\t1")
    return "\n".join((*lines, "")).encode(), "fence.waypoints"


def fen(rng):
    centre = _centre(rng)
    rows = [(centre[0], centre[1]), *_ring(rng, centre)]
    lines = [f"{lat:.7f}\t{lon:.7f}" for lon, lat in rows]
    return "\n".join(("#saved by a ground station", *lines, "")).encode(), "fence.fen"


#: The functions by format name; each takes a generator of random numbers.
FORMATS = {
    "openair": openair,
    "ed269": ed269,
    "ed318": ed318,
    "openaip": openaip,
    "inav": inav,
    "faa": faa,
    "kmz": kmz,
    "waypoints": waypoints,
    "fen": fen,
}

_ODD = (None, True, -1, 0, 1e300, "", "x" * 50, [], {}, [[]], [None], {"a": 1}, "2026", [1, 2, 3])
_BYTES = b"0123456789.,:; NSEWACDHPL\n*-+="


def broken(kind, rng):
    """Return a file of a format with a few values replaced, or bytes changed, removed or added."""
    data, name = FORMATS[kind](rng)
    if kind in ("ed269", "ed318", "openaip", "inav", "faa"):
        document = json.loads(data)
        for _ in range(rng.randint(1, 3)):
            _break(document, rng)
        return json.dumps(document).encode(), name
    changed = bytearray(data)
    for _ in range(rng.randint(1, 6)):
        at = rng.randrange(len(changed))
        match rng.randrange(3):
            case 0:
                changed[at] = rng.randrange(256)
            case 1:
                del changed[at : at + rng.randint(1, 20)]
            case _:
                changed[at:at] = bytes(rng.choice(_BYTES) for _ in range(rng.randint(1, 8)))
    return bytes(changed), name


def _break(document, rng):
    """Replace or remove a value at any depth."""
    places, waiting = [], [document]
    while waiting:
        value = waiting.pop()
        if isinstance(value, dict | list):
            keys = list(value) if isinstance(value, dict) else range(len(value))
            places += [(value, key) for key in keys]
            waiting += [value[key] for key in keys]
    if not places:
        return
    value, key = rng.choice(places)
    if isinstance(value, dict) and rng.random() < 0.3:
        del value[key]
    else:
        # A copy: a value may be broken again.
        value[key] = copy.deepcopy(rng.choice(_ODD))
