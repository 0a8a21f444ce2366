"""A JSON schema of the constructs of ED-318, written from the public description of the format.

It was compared with the public schema (UASGeoZones/ED-318, commit e98b292) on 2026-11-28, over all
files of the tests and 10,000 mutations of them. It is stricter in two places: the ``extent`` of a
point, which the public schema places where a validator ignores it, and moments and times of day,
whose ``format`` a validator ignores by default.
"""

from jsonschema import Draft7Validator


def _listed(items, least=0, most=None):
    bounds = {} if most is None else {"maxItems": most}
    return {"type": "array", "minItems": least, "items": items, **bounds}


def _members(required=(), *, is_open=True, **properties):
    return {
        "type": "object",
        "required": list(required),
        "properties": properties,
        "additionalProperties": is_open,
    }


_TEXT = {"type": "string"}
_NUMBER = {"type": "number"}
_NUMBERS = _listed(_NUMBER, 2)
_RING = _listed(_NUMBERS, 4)
_BOX = _listed(_NUMBER, 4)
_REFERENCE = {"enum": ["AGL", "AMSL", "WGS84"]}
_LAYER = _members(
    upper=_NUMBER,
    lower=_NUMBER,
    upperReference=_REFERENCE,
    lowerReference=_REFERENCE,
    uom={"enum": ["m", "ft"]},
)
_COORDINATES = {
    "Point": _NUMBERS,
    "LineString": _listed(_NUMBERS, 2),
    "Polygon": _listed(_RING),
    "MultiPoint": _listed(_NUMBERS),
    "MultiLineString": _listed(_listed(_NUMBERS, 2)),
    "MultiPolygon": _listed(_listed(_RING)),
}
_EXTENT = _members(
    ("subType", "radius"),
    subType={"const": "Circle"},
    radius={"type": "number", "exclusiveMinimum": 0},
)
_SINGLE = {
    "oneOf": [
        _members(
            ("type", "coordinates"),
            type={"const": kind},
            coordinates=coordinates,
            bbox=_BOX,
            layer=_LAYER,
            extent=_EXTENT if kind == "Point" else False,
        )
        for kind, coordinates in _COORDINATES.items()
    ]
}
_COLLECTION = _members(
    ("type", "geometries"),
    type={"const": "GeometryCollection"},
    geometries=_listed(_SINGLE),
    bbox=_BOX,
    layer=_LAYER,
)
_EVENT = {"enum": ["BMCT", "SR", "SS", "EECT"]}
_CLOCK = {
    "type": "string",
    "pattern": r"^([01]\d|2[0-4]):[0-5]\d:[0-5]\d(\.\d+)?(Z|[+-]\d\d:\d\d)$",
}
_DAYS = ["MON", "TUE", "WED", "THU", "FRI", "SAT", "SUN", "ANY"]
_MOMENT = {
    "type": "string",
    "pattern": r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?(Z|[+-]\d\d:\d\d)$",
}
_DAILY = _members(
    ["day"],
    is_open=False,
    day=_listed({"enum": _DAYS}),
    startTime=_CLOCK,
    startEvent=_EVENT,
    endTime=_CLOCK,
    endEvent=_EVENT,
)
_PERIOD = _members(
    is_open=False, startDateTime=_MOMENT, endDateTime=_MOMENT, schedule=_listed(_DAILY)
)
_IN_A_LANGUAGE = _members(
    ["lang"], text={"type": "string", "maxLength": 200}, lang={"type": "string", "maxLength": 5}
)
_TEXTS = _listed(_IN_A_LANGUAGE)
_AUTHORITY = _members(
    ["purpose"],
    name=_TEXTS,
    service=_TEXTS,
    contactName=_TEXTS,
    siteURL=_TEXT,
    email=_TEXT,
    phone={"type": "string", "maxLength": 200},
    purpose={"enum": ["AUTHORIZATION", "NOTIFICATION", "INFORMATION"]},
    intervalBefore=_TEXT,
)
_REASONS = [
    *("AIR_TRAFFIC", "SENSITIVE", "PRIVACY", "POPULATION", "NATURE", "NOISE"),
    *("EMERGENCY", "DAR", "OTHER"),
]
_ZONE = _members(
    ("identifier", "country", "type", "variant", "zoneAuthority"),
    is_open=False,
    identifier={"type": "string", "maxLength": 7},
    country={"type": "string", "minLength": 3, "maxLength": 3},
    name=_TEXTS,
    type={"enum": ["USPACE", "PROHIBITED", "REQ_AUTHORIZATION", "CONDITIONAL", "NO_RESTRICTION"]},
    variant={"enum": ["COMMON", "CUSTOMIZED"]},
    restrictionConditions=_TEXT,
    region={"type": "integer"},
    reason=_listed({"enum": _REASONS}, 0, 9),
    otherReasonInfo=_TEXTS,
    regulationExemption={"enum": ["YES", "NO"]},
    message=_TEXTS,
    zoneAuthority=_listed(_AUTHORITY, 1),
    limitedApplicability=_listed(_PERIOD),
    dataSource=_members(creationDate=_TEXT, updateDateTime=_TEXT, originator=_IN_A_LANGUAGE),
    extendedProperties={"type": "object"},
)
_NULL = {"type": "null"}
_FEATURE = _members(
    ("type", "properties", "geometry"),
    type={"const": "Feature"},
    id={"type": ["number", "string"]},
    properties={"oneOf": [_NULL, _ZONE]},
    geometry={"oneOf": [_NULL, _SINGLE, _COLLECTION]},
    bbox=_BOX,
)
_METADATA = _members(
    validFrom=_MOMENT,
    validTo=_MOMENT,
    issued=_MOMENT,
    provider=_TEXTS,
    description=_TEXTS,
    otherGeoid=_TEXT,
    technicalLimitations=_TEXTS,
)
_DOCUMENT = _members(
    ("type", "features"),
    type={"const": "FeatureCollection"},
    name={"type": "string", "maxLength": 200},
    bbox=_BOX,
    metadata=_METADATA,
    features=_listed(_FEATURE),
)


def faults(feature):
    """Return the faults of a Feature, each as a text."""
    return [error.message for error in Draft7Validator(_FEATURE).iter_errors(feature)]


def document_faults(document):
    """Return the faults of a FeatureCollection, each as a text."""
    return [error.message for error in Draft7Validator(_DOCUMENT).iter_errors(document)]
