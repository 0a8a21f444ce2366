"""The report of a flight of a planned path, and the content of its file."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.flight.autopilots import IDEAL
from pathgene.host.flight.flight import PERIOD_S, Flown
from pathgene.host.flight.judge import Verdict
from pathgene.host.flight.models import FlightModel
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.report.summary import finite, version


__all__ = ["FlightReport"]

# Seconds between two points of the track in the file.
_POINT_S = 1.0
# Columns of the track in the file, rounded: more digits than the model justifies cost space.
_COLUMNS = (
    ("t_s", 2),
    ("x", 2),
    ("y", 2),
    ("z", 2),
    ("along_m", 1),
    ("cross_m", 2),
    ("height_error_m", 2),
    ("airspeed_m_s", 2),
)


@dataclass(frozen=True, eq=False, kw_only=True)
class FlightReport:
    """A flight of a planned path.

    Parameters
    ----------
    path : ndarray
        Waypoints, (n, 3) float64 metres.
    aircraft : Aircraft
        Its figures: the planned ones, unless another aircraft flew.
    wind : (float, float)
        Velocity of the air, m/s.
    seed : int
        Its seed.
    guidance : str
        Name of the guidance.
    title : str
        Name of the autopilot whose laws flew the exported mission; empty for the ideal guidance.
    items : int
        Number of the items of that mission.
    notes : list of str
        A sentence for each parameter of the autopilot that was changed.
    """

    problem: Problem
    path: NDArray[np.float64]
    track: SmoothedTrack
    flown: Flown
    verdict: Verdict
    model: FlightModel
    aircraft: Aircraft
    wind: tuple[float, float]
    gusts: str
    seed: int
    guidance: str = IDEAL
    title: str = ""
    items: int = 0
    notes: list[str] = field(default_factory=list)

    def to_dict(self) -> dict[str, Any]:
        """The content of ``flight.json``; every number is finite or None."""
        every = round(_POINT_S / PERIOD_S)
        table = {
            "pathgene": version(),
            "aircraft": self.model.name,
            "planned_for": self.problem.aircraft.name,
            "as_paper": self.problem.rules is None,
            "wind": list(self.wind),
            "gusts": self.gusts,
            "seed": self.seed,
            "guidance": self.guidance,
            "items": self.items or None,
            "notes": self.notes,
            **self.verdict.to_dict(),
            "track": {
                name: np.round(getattr(self.flown, name)[::every], digits).tolist()
                for name, digits in _COLUMNS
            },
        }
        plain: dict[str, Any] = finite(table)
        return plain
