"""A JSON schema of the constructs of ED-318, written from the public description of the format."""

from jsonschema import Draft7Validator, FormatChecker


_NUMBERS = {"type": "array", "minItems": 2, "items": {"type": "number"}}
_RING = {"type": "array", "minItems": 4, "items": _NUMBERS}
_POLYGON = {"type": "array", "minItems": 1, "items": _RING}
_REFERENCE = {"enum": ["AGL", "AMSL", "WGS84"]}
_LAYER = {
    "type": "object",
    "properties": {
        "upper": {"type": "number"},
        "lower": {"type": "number"},
        "upperReference": _REFERENCE,
        "lowerReference": _REFERENCE,
        "uom": {"enum": ["m", "ft"]},
    },
}
_COORDINATES = {
    "Point": _NUMBERS,
    "LineString": {"type": "array", "minItems": 2, "items": _NUMBERS},
    "Polygon": _POLYGON,
    "MultiPoint": {"type": "array", "items": _NUMBERS},
    "MultiPolygon": {"type": "array", "items": _POLYGON},
}
_EXTENT = {
    "type": "object",
    "required": ["subType", "radius"],
    "properties": {
        "subType": {"const": "Circle"},
        "radius": {"type": "number", "exclusiveMinimum": 0},
    },
}
_SINGLE = {
    "oneOf": [
        {
            "type": "object",
            "required": ["type", "coordinates"],
            "properties": {
                "type": {"const": kind},
                "coordinates": coordinates,
                "layer": _LAYER,
                "extent": _EXTENT if kind == "Point" else False,
            },
        }
        for kind, coordinates in _COORDINATES.items()
    ]
}
_COLLECTION = {
    "type": "object",
    "required": ["type", "geometries"],
    "properties": {
        "type": {"const": "GeometryCollection"},
        "geometries": {"type": "array", "items": _SINGLE},
        "layer": _LAYER,
    },
}
_EVENT = {"enum": ["BMCT", "SR", "SS", "EECT"]}
_CLOCK = {
    "type": "string",
    "pattern": r"^([01]\d|2[0-4]):[0-5]\d(:[0-5]\d(\.\d+)?)?(Z|[+-]\d\d:\d\d)$",
}
_DAYS = ["MON", "TUE", "WED", "THU", "FRI", "SAT", "SUN", "ANY"]
_DAILY = {
    "type": "object",
    "required": ["day"],
    "additionalProperties": False,
    "properties": {
        "day": {"type": "array", "minItems": 1, "items": {"enum": _DAYS}},
        "startTime": _CLOCK,
        "startEvent": _EVENT,
        "endTime": _CLOCK,
        "endEvent": _EVENT,
    },
}
_MOMENT = {
    "type": "string",
    "pattern": r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?(Z|[+-]\d\d:\d\d)$",
}
_PERIOD = {
    "type": "object",
    "additionalProperties": False,
    "properties": {
        "startDateTime": _MOMENT,
        "endDateTime": _MOMENT,
        "schedule": {"type": "array", "items": _DAILY},
    },
}
_SCHEMA = {
    "type": "object",
    "required": ["type", "properties", "geometry"],
    "properties": {
        "type": {"const": "Feature"},
        "properties": {
            "type": "object",
            "required": ["identifier", "country", "type", "variant", "zoneAuthority"],
            "properties": {
                "identifier": {"type": "string", "maxLength": 7},
                "country": {"type": "string", "minLength": 3, "maxLength": 3},
                "type": {
                    "enum": [
                        "USPACE",
                        "PROHIBITED",
                        "REQ_AUTHORIZATION",
                        "CONDITIONAL",
                        "NO_RESTRICTION",
                    ]
                },
                "variant": {"enum": ["COMMON", "CUSTOMIZED"]},
                "limitedApplicability": {"type": "array", "items": _PERIOD},
                "zoneAuthority": {"type": "array", "minItems": 1},
            },
        },
        "geometry": {"oneOf": [{"type": "null"}, _SINGLE, _COLLECTION]},
    },
}
_VALIDATOR = Draft7Validator(_SCHEMA, format_checker=FormatChecker())


def faults(feature):
    """Return the faults of a Feature, each as a text."""
    return [error.message for error in _VALIDATOR.iter_errors(feature)]
