"""The format ``QGC WPL 110`` of Mission Planner, MAVProxy and QGroundControl."""

from __future__ import annotations

from pathgene.host.formats.flight_plan import WAYPOINT, FlightPlan, Item
from pathgene.host.formats.places import number_text
from pathgene.host.formats.track import Track


__all__ = ["waypoints_text", "write"]

_FRAME_GLOBAL = 0


def write(track: Track) -> bytes:
    """Return the flight plan of a track as a ``.waypoints`` file."""
    return waypoints_text(track.flown).encode()


def waypoints_text(plan: FlightPlan) -> str:
    """Return the content of a ``.waypoints`` file: row 0 is home, altitudes are AMSL."""
    home = Item(WAYPOINT, (0.0, 0.0, 0.0, 0.0), *plan.home)
    rows = [_row(number, item) for number, item in enumerate((home, *plan.items))]
    return "\n".join(("QGC WPL 110", *rows, ""))


def _row(number: int, item: Item) -> str:
    # The format cannot leave a number to the autopilot; other programs write 0 in this case.
    numbers = (*(param or 0.0 for param in item.params), item.lat, item.lon, item.alt_m)
    is_current = int(number == 0)
    return "\t".join(
        (
            f"{number}\t{is_current}\t{_FRAME_GLOBAL}\t{item.command}",
            *(number_text(value) for value in numbers),
            "1",
        )
    )
