"""A problem as the chip stores it: corner map, record, and the runs on them."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES, encode_frame
from pathgene.hdl.protocol.messages import status_reply
from pathgene.hdl.protocol.planner import BLOCKS, COARSE_BLOCKS, NoFlyShape
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.device.chip import Chip
from pathgene.host.device.chip_map import drawn_corners
from pathgene.host.device.paths import unpack_waypoints
from pathgene.host.device.runs import BestPaths, RunStatus
from pathgene.host.planners.chip.guide import guide_of
from pathgene.host.planners.chip.problem_record import (
    block_shift,
    chip_ends,
    problem_record,
    whole_path,
)
from pathgene.host.problem.corner_map import EASES, CornerMap
from pathgene.host.problem.leg_box import leg_box
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone


__all__ = ["ProblemOnChip", "Waits", "pause_s"]

#: Maximum seconds between two polls of a run, and minimum number of polls in a run.
_LOOK_S, _LOOKS = 0.001, 100
#: Maximum seconds between two polls after the limit of a run: an interrupt waits for the next poll,
#: and a simulated board runs slowly after a time without bytes.
_LATE_LOOK_S = 0.05
#: Minimum seconds between two progress reports of a run.
_REPORT_S = 0.01
#: Options of a run that only scans the map's blocks.
_SCAN = RunOptions(generations=0, slopes=(), warm=True, paths=1)
#: Share of the corners drawn for a zone that may lie outside the zone before they are cleared.
_MOST_EXCESS = 0.05


def pause_s(limit_s: float, passed_s: float, look_s: float) -> float:
    """Return the seconds until the next poll of a run in progress.

    A poll shortly before the limit of the run would delay the poll that finds the run finished.
    After the limit, which only a simulated board passes by much, pauses grow to 50 ms.

    Parameters
    ----------
    limit_s : float
        Maximum seconds of the run by the chip's clock.
    passed_s : float
        Seconds since the beginning of the run.
    look_s : float
        Seconds that a poll takes.
    """
    usual_s = min(_LOOK_S, limit_s / _LOOKS)
    left_s = limit_s - passed_s
    if left_s <= 0:
        return max(usual_s, min(passed_s / _LOOKS, _LATE_LOOK_S))
    return left_s if left_s < usual_s + look_s else usual_s


@dataclasses.dataclass(frozen=True)
class Waits:
    """Bytes on the line that the host waits for in a run.

    Polls that find the run still in progress are left out: their number depends on the host.

    Parameters
    ----------
    exchanges : int
        Number of times that the host waits for an answer. All polls of the run count as one.
    commands : int
        Bytes of the commands up to RUN.
    after_zones : int
        Minimum number of these bytes that follow the zones; they arrive while the chip draws.
    answer : int
        Bytes of the answer to RUN, and also of the refusal of a BEST or STATUS.
    request : int
        Bytes of BEST; a STATUS of the same size follows it.
    paths, status : int
        Bytes of their answers, in this order.
    """

    exchanges: int
    commands: int
    after_zones: int
    answer: int
    request: int
    paths: int
    status: int


class ProblemOnChip:
    """A problem on a chip: its corner map, lowered around the ends, and its record.

    Parameters
    ----------
    chip : Chip
        An open chip with the planner core.
    blocks : int
        Maximum blocks of the wavefront along each edge of the map: see :meth:`coarsen`.

    Attributes
    ----------
    drawing_cycles : int
        Cycles in which the chip has drawn zones.
    looks : int
        Number of times that the host asked for the paths of the latest run before it was over.
    eased : int
        How far corners are lowered around ends that the previous problem did not have, and around
        all ends after :meth:`ease`: a key of :data:`pathgene.host.problem.corner_map.EASES`.
    """

    def __init__(self, chip: Chip, problem: Problem, grid: CornerMap, blocks: int = BLOCKS) -> None:
        self._set(chip, problem, grid, blocks)
        self._corners = grid.corners(self._ends)

    def _set(self, chip: Chip, problem: Problem, grid: CornerMap, blocks: int) -> None:
        self.chip, self.problem, self.grid = chip, problem, grid
        self.eased = 0
        self._record = problem_record(chip.config, problem, grid, blocks)
        self._ends = chip_ends(problem)
        self._eases = dict.fromkeys(self._ends, 0)
        self._shapes: list[NoFlyShape] = []
        self._runs_before: int | None = None
        self._first: NDArray[np.integer] | None = None
        self._is_sent = False
        self._guide: list[tuple[int, int, int]] = []
        self.drawing_cycles = self.looks = 0
        self.waits = Waits(0, 0, 0, 0, 0, 0, 0)

    @property
    def is_warm(self) -> bool:
        """True if the chip holds the population of the latest run on this problem.

        A problem without a run continues from the population of the previous problem.
        """
        return not self.chip.closed and self._runs_before == self.chip.runs.started

    def changed(self, problem: Problem) -> ProblemOnChip:
        """Return another problem over the same terrain, to continue from this one.

        The first run has the chip draw each new zone, and uploads the corners that drawing does not
        cover: corners of removed zones, corners around the ends, zones with heights or times, and
        dents and holes of a zone. If a zone is new, removed zones stay blocked until :meth:`free`:
        a path that avoids both is safe and is found sooner. Elsewhere the chip keeps its map: the
        corners around an earlier end stay lowered, and corners around an unchanged end stay as the
        last :meth:`ease` left them. If an end does not lie on that map and its steps, the new
        problem gets a new map of its own box, and its first run starts cold. Its blocks are coarse.
        """
        grid = self.grid.of_problem(problem)
        if grid is None:
            config = self.chip.config
            own = CornerMap(config, problem, leg_box(problem, config.map_size))
            return ProblemOnChip(self.chip, problem, own, COARSE_BLOCKS)
        other = ProblemOnChip.__new__(ProblemOnChip)
        other._set(self.chip, problem, grid, COARSE_BLOCKS)
        other._eases |= {end: ease for end, ease in self._eases.items() if end in other._ends}
        other._corners = self._corners.copy()
        gone = [zone for zone in self.problem.zones if zone not in problem.zones]
        new = [zone for zone in problem.zones if zone not in self.problem.zones]
        for zone in gone:
            other._renew(*grid.around_zone(zone))
        for zone in new:
            other._add(zone)
        changed = [grid.around_zone(zone) for zone in (*gone, *new)]
        around_ends = []
        for end, ease in other._eases.items():
            part = grid.around(end)
            if end not in self._ends or any(_meet(part, each) for each in changed):
                other._renew(*part, ease)
                around_ends.append(part)
        if gone and new:
            other._first = np.maximum(self._corners, other._corners)
            for part in around_ends:
                other._first[part] = other._corners[part]
        other._runs_before = self._runs_before
        return other

    def _renew(self, rows: slice, columns: slice, ease: int = 0) -> None:
        """Give a part of the map the corners that an upload of the whole map would give it."""
        self._corners[rows, columns] = self.grid.corners_in(rows, columns, self._ends, ease)

    def _add(self, zone: Zone) -> None:
        """Add a new zone."""
        limits = (zone.lower_m, zone.upper_m, zone.t0_s, zone.t1_s)
        rows, columns = self.grid.around_zone(zone)
        inside = self.grid.beside(zone, rows, columns)
        if any(limit is not None for limit in limits):
            exact = self.grid.corners_in(rows, columns, self._ends)
            self._corners[rows, columns][inside] = exact[inside]
            return
        # Loads SciPy.
        from pathgene.host.problem.no_fly_shape import no_fly_shape

        shape = no_fly_shape(self.grid, zone, inside)
        if shape is None:
            return
        self._shapes.append(shape)
        south, west = shape.first_y - rows.start, shape.first_x - columns.start
        drawn = drawn_corners(shape)
        height, width = drawn.shape
        excess = drawn & ~inside[south : south + height, west : west + width]
        rows = slice(shape.first_y, shape.last_y + 1)
        columns = slice(shape.first_x, shape.last_x + 1)
        # The disc covers exactly the circle.
        keeps = zone.footprint.disc is not None or excess.sum() <= _MOST_EXCESS * drawn.sum()
        blocked = drawn if keeps else drawn & ~excess
        self._corners[rows, columns][blocked] = self.chip.config.blocked_altitude

    def _send(self) -> None:
        """Send the chip the map and the record."""
        for shape in self._shapes:
            self.chip.runs.block(shape)
        self.drawing_cycles += sum(shape.drawing_cycles for shape in self._shapes)
        self._shapes = []
        self.chip.update_map(self._corners if self._first is None else self._first)
        self.chip.runs.set_problem(self._record)

    def free(self) -> None:
        """Send the chip the map of this problem, in which removed zones are free."""
        self._first = None
        self.chip.update_map(self._corners)

    def ease(self, change: int) -> None:
        """Lower the corners of the map around start and goal more, or less, if possible."""
        self.eased = min(max(self.eased + change, min(EASES)), max(EASES))
        self._eases = dict.fromkeys(self._ends, self.eased)
        for end in self._ends:
            part = self.grid.around(end)
            self._renew(*part, self.eased)
            if self._first is not None:
                self._first[part] = self._corners[part]
        self._is_sent = False

    def lead(self, path: NDArray[np.float64]) -> int:
        """Give the next run a path, (n, 3) metres; return the number of waypoints of the guide.

        See :func:`pathgene.host.planners.chip.guide.guide_of`.
        """
        self._guide = guide_of(self.chip.config, self.problem, self.grid, path)
        return len(self._guide)

    def coarsen(self) -> None:
        """Divide the map into 32 x 32 blocks, for changed problems.

        A route over a quarter of the blocks takes a quarter of the cycles, which a changed problem
        has not. All blocks are scanned now, in a run without generations from the population, so
        that the first changed problem need not wait for that.
        """
        record = self._record
        shift = block_shift(max(record.x_limit, record.y_limit) + 1, COARSE_BLOCKS)
        if shift != record.block_shift:
            self._record = dataclasses.replace(record, block_shift=shift)
            self._is_sent = False
            self.run(_SCAN, lambda status: False)

    def run(
        self,
        options: RunOptions,
        ends: Callable[[RunStatus], bool],
        meanwhile: Callable[[], object] = lambda: None,
    ) -> tuple[RunStatus, BestPaths]:
        """Execute a run; return its status and its best paths.

        A run that was interrupted is ended first. Before the first run and after :meth:`ease`, the
        chip gets its map and record with the command. Once all commands have been sent,
        ``meanwhile`` is called. During the run, ``ends`` is called every 10 ms and stops the run by
        returning True.
        """
        runs = self.chip.runs
        config, traffic = self.chip.config, self.chip.link.traffic
        limit_s = options.cycles / config.clock_hz
        if runs.may_continue and self.chip.link.session is not None:
            runs.end()
        before = dataclasses.replace(traffic)
        with runs.together(meanwhile):
            if not self._is_sent:
                self._send()
            runs.guide(self._guide)
            runs.start(options)
        self._is_sent, self._guide = True, []
        ordered = traffic.since(before)
        # All have the same size.
        answer = round(ordered.bytes_from_board / ordered.frames_from_board)
        stopped = False
        self.looks = 0
        asked = reported = time.monotonic()
        # The run continued while the answer arrived.
        began = asked - answer * config.byte_cycles / config.clock_hz
        before = dataclasses.replace(traffic)
        while (polled := runs.poll()) is None:
            self.looks += 1
            now = time.monotonic()
            if now - reported >= _REPORT_S:
                reported = now
                status = runs.status()
                if status.running and not stopped and ends(status):
                    runs.stop()
                    stopped = True
                now = time.monotonic()
            time.sleep(pause_s(limit_s, now - began, now - asked))
            asked = time.monotonic()
            before = dataclasses.replace(traffic)
        asked_for = traffic.since(before)
        best, status = polled
        told = len(encode_frame(bytes(BODY_HEADER_BYTES + status_reply(config).size)))
        self.waits = Waits(
            exchanges=ordered.exchanges + 1,
            commands=ordered.bytes_to_board,
            after_zones=len(self._record.pack(config)) + len(options.pack(config)),
            answer=answer,
            request=asked_for.bytes_to_board // 2,
            paths=asked_for.bytes_from_board - told,
            status=told,
        )
        self._runs_before = runs.started
        return status, best

    def metres(self, packed: Iterable[int]) -> NDArray[np.float64]:
        """Return a path of the chip in metres, (n, 3), start and goal included."""
        corners = unpack_waypoints(self.chip.config, list(packed))
        return whole_path(self.problem, self.grid.corners_to_metres(corners))


def _meet(one: tuple[slice, slice], other: tuple[slice, slice]) -> bool:
    """Return whether two parts of the map share a corner."""
    return all(a.start < b.stop and b.start < a.stop for a, b in zip(one, other, strict=True))
