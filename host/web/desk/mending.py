"""Mending of a mission in a process of the desk, which can be stopped by ending the process."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pathgene.host.web.desk.messages import Failed, Sender


__all__ = ["MendTask", "MendedFile", "mend_mission"]


@dataclass(frozen=True)
class MendTask:
    """A mission to mend.

    Parameters
    ----------
    values : mapping
        Terrain, zones, aircraft and rules by the names in
        :data:`pathgene.host.options.table.OPTIONS`.
    name : str
        Name of its file.
    source : bytes
        Content of its file.
    """

    values: Mapping[str, Any]
    name: str
    source: bytes


@dataclass(frozen=True)
class MendedFile:
    """The file of a mended mission, which has been read back and judged.

    Parameters
    ----------
    said : tuple of str
        The changes, and then remarks on parts that keep their old values, in sentences.
    """

    name: str
    content: bytes
    said: tuple[str, ...]


def mend_mission(task: MendTask, sender: Sender) -> None:
    """Mend a mission and send its file, or the reason why it cannot be mended."""
    from pathgene.host.formats.registry import changed_name, mission_in
    from pathgene.host.mission.build import read_zones_of, terrain_of
    from pathgene.host.mission.foreign.conditions import flight_problem_of
    from pathgene.host.mission.foreign.mend import mend

    terrain = terrain_of(task.values)
    zones = read_zones_of(task.values, terrain).zones
    mission = mission_in(task.source, task.name)
    assert mission is not None
    mended = mend(mission, flight_problem_of(task.values, terrain, zones))
    if mended.refusal is not None:
        sender.send(Failed(mended.refusal))
        return
    name = changed_name(task.source, task.name)
    content = mended.written(task.source, task.name, name)
    sender.send(MendedFile(name, content, (*mended.lines, *mended.remarks)))
