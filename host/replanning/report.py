"""The report of a flight with replans, and the content of its file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from pathgene.host.flight.flight import PERIOD_S
from pathgene.host.replanning.outcome import Outcome
from pathgene.host.replanning.session import Session
from pathgene.host.report.summary import finite, version


__all__ = ["Replanned"]

# Seconds between two points of the flight in the file, and digits of its columns.
_POINT_S = 1.0
_COLUMNS = {"x": 2, "y": 2, "z": 2}


@dataclass(frozen=True, eq=False)
class Replanned:
    """A flight with replans, and its outcome.

    Parameters
    ----------
    session : Session
        The flight.
    outcome : Outcome
        The verdict.
    planner : str
        Name of the planner.
    board : str or None
        URL of its board.
    constant_s : float
        Processor share of a plan, seconds.
    """

    session: Session
    outcome: Outcome
    planner: str
    board: str | None
    constant_s: float

    def to_dict(self) -> dict[str, Any]:
        """The content of ``flight.json``; every number is finite or None."""
        session = self.session
        every = round(_POINT_S / PERIOD_S)
        flown = np.array(session.pilot.samples)[::every]
        table = {
            "pathgene": version(),
            "aircraft": session.mission.aircraft.name,
            "planner": self.planner,
            "board": self.board,
            "processor_ms": 1000 * self.constant_s,
            "scenario": session.scenario.source or None,
            **self.outcome.to_dict(),
            "changes": [change.to_dict() for change in session.changes],
            "legs": [{"since_s": leg.since_s, "kind": leg.kind} for leg in session.pilot.legs],
            "track": {
                "t_s": np.round(PERIOD_S * every * np.arange(len(flown)), 2).tolist(),
                **{
                    name: np.round(flown[:, column], digits).tolist()
                    for column, (name, digits) in enumerate(_COLUMNS.items(), 1)
                },
            },
        }
        plain: dict[str, Any] = finite(table)
        return plain
