"""A mission of any ground station that is open on a page of the desk, and its verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pathgene.host.formats.mission_items import MissionFile
from pathgene.host.mission.foreign.check import MissionCheck, check_mission
from pathgene.host.mission.foreign.judge import FlightProblem
from pathgene.host.web.mission_page import flight_scene


__all__ = ["Judged", "OpenMission"]


@dataclass(frozen=True, eq=False)
class Judged:
    """The verdict on a mission.

    Parameters
    ----------
    scene : mapping
        Its flight and faults: see :func:`pathgene.host.web.mission_page.flight_scene`.
    """

    check: MissionCheck
    scene: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class OpenMission:
    """A mission in a file that a user gave to the page, or in a mended file.

    Parameters
    ----------
    name : str
        Name of the file.
    source : bytes
        Content of the file.
    fences : list of dict
        The fences of the file as zones of the problem, in the form of
        :attr:`pathgene.host.web.desk.sheet.Sheet.zones`.
    said : tuple of str
        The changes of a mended mission, and remarks on them, in sentences.
    """

    name: str
    source: bytes
    content: MissionFile
    fences: list[dict[str, Any]] = field(default_factory=list)
    said: tuple[str, ...] = ()

    def judged(self, problem: FlightProblem) -> Judged:
        """Judge the mission.

        Raises
        ------
        InputError
            As :func:`pathgene.host.mission.foreign.check.check_mission`.
        """
        check = check_mission(self.content, problem)
        return Judged(check, flight_scene(check, self.name))
