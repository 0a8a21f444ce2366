"""The state that all tabs of a desk share: its folder, terrains and jobs."""

from __future__ import annotations

import hashlib
import json
import re
from collections import OrderedDict
from pathlib import Path

from pathgene.host.device.boards import known_config
from pathgene.host.errors import InputError
from pathgene.host.planners.registry import DEFAULT_BOARD
from pathgene.host.terrain import Terrain
from pathgene.host.web.desk.job import FlightJob, MendJob, PlanJob
from pathgene.host.web.desk.jobs import Jobs
from pathgene.host.web.desk.kept import KeptProblems
from pathgene.host.web.desk.mending import MendTask
from pathgene.host.web.desk.opened import OpenMission
from pathgene.host.web.desk.saving import files_of, saved_plans
from pathgene.host.web.desk.sheet import Sheet
from pathgene.host.web.desk.terrains import Terrains
from pathgene.host.web.scene import terrain_scene, zones_scene


__all__ = ["Desk"]

# Folder of uploaded terrains, within the folder of plans.
_TERRAINS = "terrains"
# Folder of problems that are too large for a link, within the folder of plans.
_PROBLEMS = "problems"
# Maximum characters of a terrain's name in the name of a folder.
_LONGEST_NAME = 60
# Number of meshes kept in memory; each has up to 700 kB.
_KEPT = 8


class Desk:
    """A desk.

    Parameters
    ----------
    jobs : int
        Number of plans made at a time.
    max_cells : int, optional
        Maximum cells of a terrain.
    local : bool
        The desk can only be reached from this machine. Otherwise only simulated boards may plan.

    Raises
    ------
    InputError
        If the problem file is bad, or ``jobs`` is below 1.
    """

    def __init__(
        self,
        directory: Path,
        *,
        jobs: int = 2,
        max_cells: int | None = None,
        local: bool = True,
        problem: Path | None = None,
    ) -> None:
        self.directory, self.local = directory, local
        self.terrains = Terrains(directory / _TERRAINS, max_cells)
        self.kept = KeptProblems(directory / _PROBLEMS)
        self._first = Sheet(self.terrains)
        if problem is not None:
            self._first.open_file(problem)
        self._meshes: OrderedDict[str, bytes] = OrderedDict()
        # Prepared here so that the first tab need not wait for the mesh or for the modules that
        # draw zones.
        self.mesh_url(self._first.terrain())
        zones_scene(())
        self.jobs = Jobs(directory, at_once=jobs)

    def sheet(self) -> Sheet:
        """Return the problem of a new tab."""
        return self._first.copy()

    def plan(self, sheet: Sheet) -> PlanJob:
        """Start a job for a problem.

        Raises
        ------
        InputError
            If the problem is bad, too many jobs wait, or the board is not simulated and the desk
            can be reached from other machines.
        """
        # A change during the check belongs to the next plan.
        sheet = sheet.copy()
        mission = sheet.mission()
        self._check_board(sheet)
        name = re.sub(r"[^\w.-]+", "-", mission.problem.terrain.name)[:_LONGEST_NAME]
        statement = sheet.statement()
        return self.jobs.submit(sheet.task(), f"{name}-{sheet.planner}", statement=statement)

    def fly(self, folder: Path, sheet: Sheet) -> FlightJob:
        """Start a flight of a saved plan; the planner of a problem plans during the flight.

        Raises
        ------
        InputError
            If too many flights are in progress, or the board is refused as by :meth:`plan`.
        """
        self._check_board(sheet)
        task = sheet.task()
        board = str(task.get("board") or DEFAULT_BOARD)
        job = FlightJob(folder, planner=sheet.planner, board=board, seed=task.get("seed") or 0)
        self.jobs.fly(job)
        return job

    def mend(self, mission: OpenMission, sheet: Sheet) -> MendJob:
        """Start to mend a mission by the terrain, zones, aircraft and rules of a problem.

        Raises
        ------
        InputError
            If a value of the problem is bad, or too many missions are being mended.
        """
        task = MendTask(sheet.copy().flight_values(), mission.name, mission.source)
        job = MendJob(wanted=task)
        self.jobs.mend(job)
        return job

    def _check_board(self, sheet: Sheet) -> None:
        board = sheet.values.get("board")
        if not self.local and board is not None and known_config(board) is None:
            raise InputError(
                "Only simulated boards (model:, sim:) plan on a desk that others can reach."
            )

    def mesh_url(self, terrain: Terrain) -> str:
        """Return the address of the mesh of a terrain, which :meth:`mesh` answers."""
        scene = terrain_scene(terrain)
        content = json.dumps(scene, allow_nan=False).encode()
        key = hashlib.sha256(content).hexdigest()[:20]
        self._meshes[key] = content
        self._meshes.move_to_end(key)
        while len(self._meshes) > _KEPT:
            self._meshes.popitem(last=False)
        return f"/meshes/{key}"

    def mesh(self, key: str) -> bytes | None:
        """Return the mesh of a terrain as JSON, or None."""
        return self._meshes.get(key)

    def saved(self) -> list[str]:
        """Return the names of the saved plans, the latest first."""
        return saved_plans(self.directory)

    def file(self, plan: str, name: str) -> Path | None:
        """Return a file of a saved plan, or None."""
        if plan not in self.saved() or name not in files_of(self.directory / plan):
            return None
        return self.directory / plan / name

    def close(self) -> None:
        """End all jobs and save their plans."""
        self.jobs.close()
