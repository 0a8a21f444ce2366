"""Mending of a mission: the fewest and smallest changes that make it feasible.

Faults are mended in flying order, each by the first kind of change that serves: heights, then
waypoints that are inserted, then detours of a planner. A change counts once the mission has fewer
faults, so a change of one item may lead to changes of its neighbours. At the end, changes that have
become needless are taken back.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from pathgene.host.errors import InputError, JobError
from pathgene.host.formats.mission_items import Entry, MissionFile
from pathgene.host.formats.registry import changed_mission, mission_in
from pathgene.host.mission.foreign.changes import Change, changes
from pathgene.host.mission.foreign.check import (
    MissionCheck,
    check_mission,
    checked_by,
    judge_of,
)
from pathgene.host.mission.foreign.draft import Draft
from pathgene.host.mission.foreign.faults import Fault
from pathgene.host.mission.foreign.home import Surroundings
from pathgene.host.mission.foreign.judge import FlightProblem, Judge
from pathgene.host.mission.foreign.repairs import Means, Place, Repairs
from pathgene.host.mission.foreign.words import counted, where
from pathgene.host.version import version


__all__ = ["Mended", "mend"]

# A change weighs as much as these metres, a fault as much as these.
_CHANGE_M, _FAULT_M = 30.0, 60.0
# Missions whose first fault is mended, for each kind of change, before the next kind is tried.
_SEARCHED = {Means.HEIGHTS: 14, Means.WAYPOINTS: 14, Means.DETOURS: 6, Means.REMOVALS: 6}
# Maximum number of searches, and of faults that are left before the search ends: a search in vain
# takes seconds.
_MOST_STEPS, _MOST_LEFT = 200, 2


@dataclass(frozen=True, eq=False)
class Mended:
    """A mission after mending.

    Parameters
    ----------
    before, after : MissionCheck
        The checks of the mission before and after the changes.
    entries : tuple of Entry
        The items after the changes, with the places of their originals.
    changes : tuple of Change
        Every change, in the order of the file; empty for a mission without faults.
    return_m : float, optional
        Height above home of a return to launch, as it was given.
    """

    before: MissionCheck
    after: MissionCheck
    entries: tuple[Entry, ...]
    changes: tuple[Change, ...]
    return_m: float | None = None

    @property
    def feasible(self) -> bool:
        """True if the mission has no fault after the changes."""
        return self.after.feasible

    @property
    def mission(self) -> MissionFile:
        """The mission after the changes."""
        return self.after.mission

    @property
    def is_line(self) -> bool:
        """True for a line without home, as of KML, GPX and CSV, which is written as a new plan."""
        return self.mission.word == "point"

    @property
    def refusal(self) -> str | None:
        """The reason why the mission cannot be mended, in a sentence; None if it is mended."""
        if self.feasible:
            return None
        fault = self.after.faults[0]
        place = where(self.after.flight.chains[fault.chain], fault.leg, is_leg=fault.is_leg)
        left = counted(len(self.after.faults), "fault")
        return (
            f"The mission cannot be mended: {left} remain, the first at {place} ({fault.limit}); "
            "no change of heights, no inserted waypoint and no detour removes it."
        )

    def written(self, source: bytes, name: str, out: str) -> bytes:
        """Return the file of the mended mission, which has been read back and judged again.

        Parameters
        ----------
        source : bytes
            The file from which the mission was read.
        name, out : str
            Names of that file, and of the file to be written.

        Raises
        ------
        InputError
            If a file of that name cannot hold the mission.
        JobError
            If the mission is not mended, or does not pass as it is read back.
        """
        if self.refusal is not None:
            raise JobError(self.refusal)
        content = changed_mission(source, name, out, self._with_home, self.entries)
        again = mission_in(content, out)
        assert again is not None
        check = check_mission(again, self.after.judge.problem, self.return_m)
        if not check.feasible or len(again.items) != len(self.mission.items):
            raise JobError(
                f"The mended mission does not pass as {out} states it, so nothing is written; "
                "please report this."
            )
        return content

    @property
    def _with_home(self) -> MissionFile:
        """The mission with home, without one in its file on the ground below the first item."""
        mission, terrain = self.mission, self.after.judge.problem.terrain
        if mission.home is not None:
            return mission
        home = Surroundings(mission, terrain).home_needed()
        lat, lon = map(float, terrain.to_geographic(home.x_m, home.y_m))
        return replace(mission, home=(lat, lon, home.z_m))

    @property
    def lines(self) -> Iterator[str]:
        """A line for each change."""
        for change in self.changes:
            yield change.sentence[:1].upper() + change.sentence[1:]

    @property
    def remarks(self) -> list[str]:
        """Sentences on parts of the file that keep their old values."""
        items = self.before.mission.items
        names = dict.fromkeys(
            entry.item.within
            for entry in self.entries
            if entry.item.within
            and (entry.place is None or items[entry.place].alt_m != entry.item.alt_m)
        )
        return [
            f"The definition of {name} keeps its old height: QGroundControl flies the stored lines "
            "as they are written; if somebody edits the survey, it computes them again."
            for name in names
        ]

    @property
    def report(self) -> dict[str, Any]:
        """The output of ``pathgene mend --json``: plain JSON values, every number finite."""
        return {
            "pathgene": version(),
            "mended": self.feasible,
            "changes": [change.to_dict() for change in self.changes],
            "remarks": self.remarks,
            "refusal": self.refusal,
            "before": self.before.report,
            "after": self.after.report,
        }


def mend(mission: MissionFile, problem: FlightProblem, return_m: float | None = None) -> Mended:
    """Mend a mission.

    Lines of surveys and corridors stay straight and in place. The terrain, the aircraft, the rules
    and the height of the return are taken as they are.

    Parameters
    ----------
    mission : MissionFile
        The mission as its file states it.
    problem : FlightProblem
        Terrain, aircraft, zones, wind and rules; its ends do not count.
    return_m : float, optional
        Height above home of a return to launch; by default the autopilot's own.

    Returns
    -------
    Mended
        If it is not ``feasible``, its changes are the ones that helped, and ``refusal`` says which
        fault is left.

    Raises
    ------
    InputError
        As :func:`pathgene.host.mission.foreign.check.check_mission`.
    """
    judge = judge_of(problem)
    search = _Search(judge, return_m)
    draft = Draft.of(mission)
    before = check = checked_by(judge, mission, return_m)
    left = 0
    for _ in range(_MOST_STEPS):
        if left >= min(len(check.faults), _MOST_LEFT):
            break
        found = search.fewer(draft, check, left)
        if found is None:
            left += 1
        else:
            draft, check = found
    if check.feasible:
        draft, check = search.lean(draft, check)
        draft, check = search.exact(draft, check)
    return Mended(before, check, draft.written, tuple(changes(draft)), return_m)


@dataclass(frozen=True)
class _Search:
    """Searches changes after which a mission has fewer faults."""

    judge: Judge
    return_m: float | None
    ways: dict[tuple[object, ...], list[Place]] = field(default_factory=dict)

    def check(self, draft: Draft) -> MissionCheck | None:
        """Return the check of a draft, or None if it cannot be judged."""
        try:
            return checked_by(self.judge, draft.file, self.return_m)
        except InputError:
            return None

    def fewer(
        self, draft: Draft, check: MissionCheck, left: int
    ) -> tuple[Draft, MissionCheck] | None:
        """Return the mission with fewer faults by the least changes, or None.

        The first faults, of the number ``left``, are not mended.
        """
        for means in Means:
            found = self._by(means, draft, check, left)
            if found is not None:
                return found
        return None

    def _by(
        self, most: Means, draft: Draft, check: MissionCheck, left: int
    ) -> tuple[Draft, MissionCheck] | None:
        """Search among changes of a kind and of the kinds before it, the least ones first."""
        count = itertools.count()
        faults = len(check.faults)
        waiting = [(0.0, next(count), 0.0, draft, check)]
        seen = {draft.file}
        for _ in range(_SEARCHED[most]):
            if not waiting:
                return None
            _, _, metres, draft, check = heapq.heappop(waiting)
            if len(check.faults) < faults:
                return draft, check
            listed = [*check.faults[left:], *check.faults[:left]]
            first = Repairs(draft, replace(check, faults=listed), self.ways)
            for means in range(most + 1):
                for each in first.by(Means(means)):
                    if each.draft.file in seen:
                        continue
                    seen.add(each.draft.file)
                    after = self.check(each.draft)
                    if after is None:
                        continue
                    sum_m = metres + each.metres + _CHANGE_M
                    rank = sum_m + _FAULT_M * max(len(after.faults) - faults + 1, 0)
                    heapq.heappush(waiting, (rank, next(count), sum_m, each.draft, after))
        done = [each for each in waiting if len(each[4].faults) < faults]
        if not done:
            return None
        *_, draft, check = min(done)
        return draft, check

    def lean(self, draft: Draft, check: MissionCheck) -> tuple[Draft, MissionCheck]:
        """Return a feasible mission without the changes that it does not need."""
        at = 0
        while at < len(draft.entries):
            entry = draft.entries[at]
            source = None if entry.place is None else draft.source.items[entry.place]
            if entry.item != source:
                less = draft.restored(at)
                after = self.check(less)
                if after is not None and after.feasible:
                    draft, check = less, after
                    at += source is not None
                    continue
            at += 1
        for at, (before, now) in enumerate(zip(draft.source.rally, draft.rally, strict=True)):
            if before != now:
                less = replace(draft, rally=(*draft.rally[:at], before, *draft.rally[at + 1 :]))
                after = self.check(less)
                if after is not None and after.feasible:
                    draft, check = less, after
        return draft, check

    def exact(self, draft: Draft, check: MissionCheck) -> tuple[Draft, MissionCheck]:
        """Return a feasible mission whose changed legs keep the limits without tolerance.

        A leg stays within the tolerance where no further change of heights helps.
        """
        at, short = 0, _short(draft, check)
        while at < len(short):
            first = Repairs(draft, replace(check, faults=short[at:]))
            tried = sorted(first.heights(), key=lambda each: (_count(each.draft), each.metres))
            for each in tried:
                after = self.check(each.draft)
                if after is None or not after.feasible:
                    continue
                left = _short(each.draft, after)
                if len(left) < len(short):
                    draft, check, short = each.draft, after, left
                    break
            else:
                at += 1
        return draft, check


def _count(draft: Draft) -> int:
    """Return the number of changes of a draft."""
    return sum(1 for _ in changes(draft))


def _short(draft: Draft, check: MissionCheck) -> list[Fault]:
    """Return the faults without tolerance of the legs and points that changes touch."""
    handles = draft.touched
    near = frozenset(
        (number, leg)
        for number, chain in enumerate(check.flight.chains)
        for at, point in enumerate(chain.points)
        if point.handle in handles
        for leg in range(max(at - 1, 0), max(min(at + 1, len(chain.points) - 1), 1))
    )
    return check.judge.exact.faults(check.flight.chains, near) if near else []
