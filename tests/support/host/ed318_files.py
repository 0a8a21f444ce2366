"""Zones of ED-318, and random documents with every member of the public schema."""

import copy


RING = [[10.0, 60.0], [10.1, 60.0], [10.1, 60.1], [10.0, 60.0]]
SQUARE = ((10.0, 60.0), (10.1, 60.0), (10.1, 60.1))
LAYER = {"lower": 10, "lowerReference": "AGL", "upper": 400, "upperReference": "AMSL", "uom": "ft"}
EXTENT = {"subType": "Circle", "radius": 500}
CIRCLE = {"type": "Point", "coordinates": [10.0, 60.0], "extent": EXTENT, "layer": LAYER}
POLYGON = {"type": "Polygon", "coordinates": [RING], "layer": LAYER}
PERIOD = {"startDateTime": "2026-05-01T06:00:00Z", "endDateTime": "2026-06-01T06:00:00+02:00"}
HOLE = [[10.05, 60.01], [10.08, 60.01], [10.08, 60.05], [10.05, 60.01]]
_TEXTS = (
    [{"text": "Festning", "lang": "nb-NO"}, {"text": "Fort", "lang": "en-GB"}],
    [{"lang": "en"}],
    [],
)
_AUTHORITY = {
    "name": [{"text": "Luftfartstilsynet", "lang": "nb-NO"}],
    "service": [{"text": "UAS", "lang": "en"}],
    "contactName": [{"text": "N. N.", "lang": "nb"}],
    "siteURL": "https://example.org",
    "email": "uas@example.org",
    "phone": "+47 000",
    "purpose": "AUTHORIZATION",
    "intervalBefore": "P3D",
}
_DAILY = (
    {"day": ["ANY"], "startTime": "08:00:00Z", "endTime": "16:00:00+02:00"},
    {"day": ["MON", "SAT"], "startEvent": "BMCT", "endEvent": "EECT"},
    {"day": ["SUN"], "startEvent": "SR", "endTime": "20:00:00.5Z"},
    {"day": ["TUE"]},
)
_PERIODS = (
    PERIOD,
    {"endDateTime": "2027-01-01T00:00:00.25Z"},
    {},
)
_METADATA = {
    "validFrom": "2026-01-01T00:00:00Z",
    "validTo": "2026-12-31T23:59:59Z",
    "issued": "2025-12-01T12:00:00+01:00",
    "provider": [{"text": "Luftfartstilsynet", "lang": "nb-NO"}],
    "description": [{"text": "zones", "lang": "en"}],
    "technicalLimitations": [],
}


def zone(geometry=POLYGON, **properties):
    """Return a valid zone."""
    own = {
        "identifier": "TST0001",
        "country": "NOR",
        "name": [{"text": "Festning", "lang": "nb-NO"}, {"text": "Fort", "lang": "en-GB"}],
        "type": "PROHIBITED",
        "variant": "COMMON",
        "zoneAuthority": [{"purpose": "INFORMATION"}],
    }
    return {"type": "Feature", "properties": own | properties, "geometry": copy.deepcopy(geometry)}


def changed(*path, value):
    """Return a zone with one value replaced, or removed if it is None."""
    feature = zone(CIRCLE if "extent" in path else POLYGON)
    at = feature
    for step in path[:-1]:
        at = at.setdefault(step, {}) if isinstance(at, dict) else at[step]
    if value is None:
        del at[path[-1]]
    else:
        at[path[-1]] = value
    return feature


def told(found):
    """Return the remarks on an area as one text."""
    return " ".join(remark.text for remark in found.remarks)


def _some(rng, members):
    """Return some of the members."""
    return {key: copy.deepcopy(value) for key, value in members.items() if rng.random() < 0.6}


def _layer(rng):
    references = ("AGL", "AMSL", "WGS84")
    low, high = rng.choice(references), rng.choice(references)
    layer = {"lower": -5.5, "lowerReference": low, "upper": 400, "upperReference": high}
    for side in ("lower", "upper"):
        if rng.random() < 0.2:
            del layer[side], layer[f"{side}Reference"]
    return layer | ({"uom": rng.choice(("m", "ft"))} if rng.random() < 0.7 else {})


def _single(rng):
    geometry = rng.choice(
        (
            {
                "type": "Point",
                "coordinates": [10.0, 60.0],
                "extent": {"subType": "Circle", "radius": 500},
            },
            {"type": "Point", "coordinates": [10.0, 60.0, 5.0]},
            {"type": "MultiPoint", "coordinates": [[10.0, 60.0]]},
            {"type": "LineString", "coordinates": RING[:2]},
            {"type": "MultiLineString", "coordinates": [RING[:2], RING]},
            {"type": "Polygon", "coordinates": [RING, HOLE]},
            {"type": "Polygon", "coordinates": [[[*place, 3.0] for place in RING]]},
            {"type": "Polygon", "coordinates": []},
            {"type": "MultiPolygon", "coordinates": [[RING], [HOLE]]},
            {"type": "MultiPolygon", "coordinates": []},
        )
    )
    more = {"layer": _layer(rng), "bbox": [10.0, 60.0, 10.1, 60.1]}
    return copy.deepcopy(geometry) | _some(rng, more)


def _geometry(rng):
    if rng.random() < 0.1:
        return None
    if rng.random() < 0.7:
        return _single(rng)
    parts = [_single(rng) for _ in range(rng.randrange(4))]
    return {"type": "GeometryCollection", "geometries": parts} | _some(rng, {"layer": _layer(rng)})


def _period(rng):
    daily = [copy.deepcopy(rng.choice(_DAILY)) for _ in range(rng.randrange(3))]
    period = dict(rng.choice(_PERIODS))
    return period | ({"schedule": daily} if rng.random() < 0.6 else {})


def _properties(rng):
    required = {
        "identifier": "TST0001",
        "country": "NOR",
        "type": rng.choice(
            ("USPACE", "PROHIBITED", "REQ_AUTHORIZATION", "CONDITIONAL", "NO_RESTRICTION")
        ),
        "variant": rng.choice(("COMMON", "CUSTOMIZED")),
        "zoneAuthority": [{"purpose": "INFORMATION"} | _some(rng, _AUTHORITY)],
    }
    return required | _some(
        rng,
        {
            "name": rng.choice(_TEXTS),
            "restrictionConditions": "none",
            "region": 5,
            "reason": rng.sample(("AIR_TRAFFIC", "SENSITIVE", "PRIVACY", "NATURE", "DAR"), 2),
            "otherReasonInfo": rng.choice(_TEXTS),
            "regulationExemption": rng.choice(("YES", "NO")),
            "message": rng.choice(_TEXTS),
            "limitedApplicability": [_period(rng) for _ in range(rng.randrange(3))],
            "dataSource": {
                "creationDate": "2026-01-01",
                "updateDateTime": "2026-01-02T00:00:00Z",
                "originator": {"text": "x", "lang": "en"},
            },
            "extendedProperties": {"anything": [1]},
        },
    )


def document(rng):
    """Return a document; each zone has some of the optional members."""
    features = [
        {
            "type": "Feature",
            "properties": None if rng.random() < 0.05 else _properties(rng),
            "geometry": _geometry(rng),
            **_some(rng, {"id": rng.choice((7, "zone 7")), "bbox": [10.0, 60.0, 10.1, 60.1]}),
        }
        for _ in range(rng.randint(1, 3))
    ]
    more = {"name": "zones", "bbox": [10.0, 60.0, 10.1, 60.1], "metadata": _some(rng, _METADATA)}
    return {"type": "FeatureCollection", "features": features} | _some(rng, more)


_ODD = (None, True, -1, 0, 1.5, "", "x", "x" * 300, [], {}, [[]], [None], {"a": 1}, "2026", "NO")


def mutated(document, rng):
    """Replace, remove, add or repeat a value of a document at any depth."""
    places, waiting = [], [document]
    while waiting:
        value = waiting.pop()
        keys = list(value) if isinstance(value, dict) else range(len(value))
        places += [(value, key) for key in keys]
        waiting += [value[key] for key in keys if isinstance(value[key], dict | list)]
    value, key = rng.choice(places)
    match rng.randrange(5):
        case 0:
            del value[key]
        case 1 if isinstance(value, dict):
            value["odd"] = 1
        case 1:
            value.append(copy.deepcopy(value[key]))
        case _:
            value[key] = copy.deepcopy(rng.choice(_ODD))
    return document
