"""A mission of any ground station for the Python API: loaded, checked and mended."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from pathgene.host.errors import InputError
from pathgene.host.files.output import output_file, prepare_file, reading
from pathgene.host.formats.mission_items import MissionFile
from pathgene.host.formats.registry import mission_files, mission_in
from pathgene.host.inputs import read_bytes
from pathgene.host.problem.aircraft import DEFAULT, Aircraft
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Zone, read_zones
from pathgene.host.terrain import Terrain


if TYPE_CHECKING:
    from pathgene.host.mission.foreign.judge import FlightProblem

__all__ = ["Mission", "mission_and_source"]


def mission_and_source(file: Path) -> tuple[MissionFile, bytes]:
    """Return the mission in a file, and the bytes of the file.

    Raises
    ------
    InputError
        If the file cannot be read or holds no mission.
    """
    with reading("mission", file):
        source = read_bytes(file)
    try:
        mission = mission_in(source, file.name)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None
    if mission is None:
        raise InputError(f"{file}: there is no mission in it; give {mission_files()}.")
    return mission, source


class Mission:
    """A mission of any ground station; made by :meth:`load`.

    Attributes
    ----------
    file : Path
        Its file.
    """

    file: Path

    def __init__(
        self,
        file: Path,
        source: bytes,
        content: MissionFile,
        problem: FlightProblem,
        return_m: float | None,
    ) -> None:
        self.file = file
        self._source, self._content = source, content
        self._problem, self._return_m = problem, return_m

    def __repr__(self) -> str:
        return f"Mission({str(self.file)!r}, {len(self._content.items)} items)"

    @classmethod
    def load(
        cls,
        file: str | Path,
        terrain: Terrain,
        aircraft: Aircraft | str | Path = DEFAULT,
        zones: Iterable[Zone] = (),
        wind: Sequence[float] = (0.0, 0.0),
        *,
        rules: Rules | None = None,
        return_height_m: float | None = None,
    ) -> Self:
        """Load a mission, and the conditions by which it is judged.

        Parameters
        ----------
        file : str or Path
            A ``.plan``, a list of waypoints, a line of KML or GPX, or CSV with columns of degrees.
        terrain : Terrain
            The ground; it has a place on Earth.
        aircraft : Aircraft, str or Path
            The aircraft, the name of a shipped one, or the TOML file of one.
        zones : iterable of Zone
            No-fly zones in addition to the fences of the file.
        wind : (float, float)
            Constant wind in m/s towards true east and true north.
        rules : Rules, optional
            Rules that the mission keeps; by default :class:`Rules` without arguments.
        return_height_m : float, optional
            Height above home of a return to launch; by default the autopilot's own.

        Raises
        ------
        InputError
            If the file cannot be read or holds no mission, or an argument is bad.
        """
        from pathgene.host.mission.foreign.judge import FlightProblem

        if not isinstance(file, str | Path):
            raise InputError(f"The mission must be the path of a file, not {file!r}.")
        path, nowhere = Path(file), (0.0, 0.0, 0.0)
        content, source = mission_and_source(path)
        own = read_zones(path, terrain).zones if content.has_fences else ()
        problem = FlightProblem(
            terrain, nowhere, nowhere, aircraft, (*zones, *own), wind, rules=rules or Rules()
        )
        return cls(path, source, content, problem, return_height_m)

    def check(self) -> dict[str, Any]:
        """Judge the mission as an autopilot flies it.

        Returns
        -------
        dict
            The report of ``pathgene check --json``: ``feasible``, ``faults`` with a ``sentence``
            each, and the facts and assumptions under ``read``.

        Raises
        ------
        InputError
            If an item cannot be judged, or the mission lies outside the terrain.
        """
        from pathgene.host.mission.foreign.check import check_mission

        return check_mission(self._content, self._problem, self._return_m).report

    def mend(self, out: str | Path | None = None) -> dict[str, Any]:
        """Mend the mission by the fewest and smallest changes, and write it if a file is given.

        Parameters
        ----------
        out : str or Path, optional
            File for the mended mission: a ``.plan``, or a list of waypoints if its own file is one.

        Returns
        -------
        dict
            The report of ``pathgene mend --json``: ``mended``, ``changes`` with a ``sentence``
            each, and the checks ``before`` and ``after``. Without a file, a mission that cannot be
            mended has the reason under ``refusal``.

        Raises
        ------
        InputError
            As for :meth:`check`, or if the file cannot be written.
        JobError
            If a file is given and the mission cannot be mended; nothing is written.
        """
        from pathgene.host.mission.foreign.mend import mend

        target = None if out is None else Path(out)
        if target is not None:
            prepare_file(target)
        mended = mend(self._content, self._problem, self._return_m)
        if target is not None:
            content = mended.written(self._source, self.file.name, target.name)
            with output_file(target) as stream:
                stream.write(content)
        return mended.report
