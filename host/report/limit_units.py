"""Units of the limits in reports."""

__all__ = ["unit_of"]

# Those of the limits that are not lengths.
_UNITS = {"climb": "m/s", "descent": "m/s", "power": "W", "fuel": "N", "stall": "m/s"}


def unit_of(limit: str) -> str:
    """Return the unit of a limit, by the name that it has in a report."""
    return _UNITS.get(limit, "m")
