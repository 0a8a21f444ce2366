"""Simulated autopilots that fly an exported mission, found by name.

A package makes one known by an entry point of the group ``pathgene.autopilots``: its name is a
value of ``--guidance``, its object a :class:`SimulatedAutopilot`. The simulated autopilots of this
project judge its exports, so the host shares no code with them and does not import them by name.
"""

from __future__ import annotations

from typing import Protocol

from pathgene.host.entry_points import entry_points
from pathgene.host.errors import InputError, JobError
from pathgene.host.flight.guidance import State
from pathgene.host.formats.flight_plan import FlightPlan
from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.problem import Problem


__all__ = ["GROUP", "IDEAL", "Airborne", "Mission", "SimulatedAutopilot", "autopilot_named"]

#: Group of the entry points that name simulated autopilots.
GROUP = "pathgene.autopilots"
#: Name of the guidance that follows the planned track itself.
IDEAL = "ideal"


class Airborne(Protocol):
    """An aircraft in the air, in the terrain's frame, that takes demands of attitude."""

    @property
    def state(self) -> State:
        """The present state."""

    @property
    def wind(self) -> tuple[float, float]:
        """Velocity of the air over ground, gusts included, m/s in x and y."""

    @property
    def throttle(self) -> float:
        """Throttle from 0 to 1."""

    @property
    def level_throttle(self) -> float:
        """Throttle of level flight at the cruise speed."""

    @property
    def climb_throttle(self) -> float:
        """Increase of the throttle in a climb per unit of the sine."""

    def step(self, roll_rad: float, pitch_rad: float, throttle: float) -> None:
        """Fly for a tenth of a second with these demands."""


class Mission(Protocol):
    """A mission that a simulated autopilot has accepted and flies.

    Attributes
    ----------
    notes : list of str
        A sentence for each parameter that was changed so that the mission starts.
    """

    notes: list[str]

    @property
    def is_at_end(self) -> bool:
        """True while the last item is under way, and afterwards."""

    @property
    def has_arrived(self) -> bool:
        """True once the last item is reached."""

    @property
    def is_over(self) -> bool:
        """True once the end has been flown for a while, the aircraft has landed, or is lost."""

    @property
    def texts(self) -> list[str]:
        """The autopilot's texts for the ground station."""

    def tick(self) -> None:
        """Fly for a tenth of a second."""


class SimulatedAutopilot(Protocol):
    """A simulated autopilot.

    Attributes
    ----------
    title : str
        Its name in reports.
    """

    title: str

    def accept(
        self, problem: Problem, plan: FlightPlan, aircraft: Aircraft, craft: Airborne
    ) -> Mission:
        """Upload a plan and begin its mission.

        Raises
        ------
        JobError
            If the autopilot refuses the plan.
        """


def autopilot_named(name: str) -> SimulatedAutopilot:
    """Return a simulated autopilot by its name.

    Raises
    ------
    InputError
        If there is none of this name, or a package that it needs is missing.
    JobError
        If the package that registers it cannot be loaded.
    """
    points = {point.name: point for point in reversed(list(entry_points(GROUP)))}
    if name not in points:
        known = ", ".join([IDEAL, *dict.fromkeys(point.name for point in entry_points(GROUP))])
        raise InputError(f"There is no guidance {name!r}; choose from {known} (--guidance).")
    try:
        autopilot: SimulatedAutopilot = points[name].load()
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] == "pymavlink":
            raise InputError(
                f"--guidance {name} needs the extra pathgene[mavlink]: "
                "pip install 'pathgene[mavlink]'."
            ) from None
        raise JobError(f"The guidance {name} cannot be loaded ({error}).") from None
    except (ImportError, AttributeError) as error:
        raise JobError(f"The guidance {name} cannot be loaded ({error}).") from None
    return autopilot
