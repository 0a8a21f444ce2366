"""Missions with a planted fault, mended, written, and flown by a simulated autopilot."""

from dataclasses import dataclass

from pathgene.host.formats.registry import read_mission
from pathgene.host.mission.foreign.judge import FlightProblem
from pathgene.host.mission.foreign.mend import Mended, mend
from pathgene.host.problem.zones import read_zones
from pathgene.sim.autopilot.pilot import Kind
from tests.support.host.foreign import NOWHERE, land
from tests.support.host.mended_flights import Flight, fly
from tests.support.host.planted_missions import CLEARANCE_M, plant


@dataclass
class Outcome:
    """A planted mission after mending.

    Parameters
    ----------
    flight : Flight or None
        The flight of the written file; None for a mission that was not mended.
    """

    mended: Mended
    flight: Flight | None

    @property
    def is_kept(self):
        """The flight reached the end, kept half of the clearance, and entered no zone."""
        return (
            self.flight.arrived
            and self.flight.clearance_m >= CLEARANCE_M / 2
            and self.flight.zone_m >= 0
        )


def problem_of(planted, file):
    """Return the mission of a planted fault, written to a file, and its problem."""
    file.write_text(planted.plan)
    mission, terrain = read_mission(file), land(planted.heights)
    own = read_zones(file, terrain).zones if mission.has_fences else ()
    return mission, FlightProblem(terrain, NOWHERE, NOWHERE, zones=own)


def outcome(kind, seed, file, pilot=Kind.ARDUPLANE):
    """Plant a fault, mend the mission in a file, and fly the mended one by an autopilot."""
    planted = plant(kind, seed, faulty=True)
    mended = mend(*problem_of(planted, file))
    if not mended.feasible:
        return Outcome(mended, None)
    written = mended.written(file.read_bytes(), file.name, "mended.plan")
    return Outcome(mended, fly(written.decode(), planted.heights, pilot))
