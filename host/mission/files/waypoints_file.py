"""The file ``QGC WPL 110`` that Mission Planner, MAVProxy and QGroundControl read."""

from __future__ import annotations

import numpy as np

from pathgene.host.mission.files.flight_plan import WAYPOINT, FlightPlan, Item


__all__ = ["waypoints_text"]

_FRAME_GLOBAL = 0


def waypoints_text(plan: FlightPlan) -> str:
    """Return the content of a ``.waypoints`` file: row 0 is home, altitudes are AMSL."""
    home = Item(WAYPOINT, (0.0, 0.0, 0.0, 0.0), *plan.home)
    rows = [_row(number, item) for number, item in enumerate((home, *plan.items))]
    return "\n".join(("QGC WPL 110", *rows, ""))


def _row(number: int, item: Item) -> str:
    # The format has no word for "left to the autopilot"; 0 is what its programs write there.
    numbers = (*(param or 0.0 for param in item.params), item.lat, item.lon, item.alt_m)
    is_current = int(number == 0)
    return "\t".join(
        (
            f"{number}\t{is_current}\t{_FRAME_GLOBAL}\t{item.command}",
            *(np.format_float_positional(value, trim="-") for value in numbers),
            "1",
        )
    )
