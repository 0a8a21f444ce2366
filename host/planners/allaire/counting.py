"""Distances under the terrain and in no-fly zones, counted by a chip's collision checker."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import CheckerBuild
from pathgene.host.device.chip import Chip
from pathgene.host.device.paths import pack_waypoints
from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.geometry import smooth
from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.planners.base import Run
from pathgene.host.problem.chip_map import ChipMap


__all__ = ["CAUSES", "BoardCollisionCounter", "refutation"]

Path = NDArray[np.float64]

#: Reasons why the full evaluation rejects a path that the counts call feasible.
CAUSES = ("turn_arcs", "between_cells", "between_samples")

# Turn radius in metres at which smoothing leaves a path unchanged.
_NO_RADIUS_M = 1e-6


class BoardCollisionCounter:
    """The collision checker of a chip as a part of the fitness.

    The chip counts the colliding cells of every segment of the straight path; d_ut + d_nf of the
    penalty is this count times the segment's horizontal metres per cell (*allaire two-tier*,
    section 3.2, in count mode). The host computes arcs, climb and cost. The smoothed track differs
    from the straight path, and a line crosses more cells than the checker reads, so a path can
    become the best only after the host has evaluated it in full: see :meth:`settle`.

    Parameters
    ----------
    chip : Chip
        A chip with a collision checker; its map is written here.
    """

    def __init__(self, chip: Chip, grid: ChipMap, run: Run) -> None:
        problem = run.evaluator.problem
        self._chip, self._grid, self._run = chip, grid, run
        ends = np.array([problem.start, problem.goal])
        self._start, self._goal = pack_waypoints(chip.config, grid.to_cells(ends))
        self._counted = self._in_full = self._samples = self._claimed = 0
        self._refuted: Counter[str] = Counter()
        with run.phase("link"):
            chip.update_map(grid.heights)

    def fitness(self, paths: Sequence[Path], slot: int) -> NDArray[np.float64]:
        """Return the fitness of paths in consecutive slots of the chip, with the chip's counts.

        Parameters
        ----------
        paths : sequence of (n, 3) float64
            The same paths in metres, ends included.
        slot : int
            Slot of the first path.

        Returns
        -------
        ndarray
            (m,) float64, 0..2.
        """
        with self._run.phase("link"):
            checked = self._chip.check_population(
                self._start, self._goal, slot=slot, count=len(paths), counting=True
            )
        counted_m = np.zeros(len(paths))
        for number, (path, verdict) in enumerate(zip(paths, checked.verdicts, strict=True)):
            for segment, terrain, nofly in verdict.entries:
                counted_m[number] += (terrain + nofly) * self._metres_per_cell(path, segment)
        self._counted += len(paths)
        self._samples += sum(map(self._samples_of, paths))
        return self._run.fitness(paths, counted_m=counted_m)

    def settle(
        self,
        fitness: NDArray[np.float64],
        settled: NDArray[np.bool_],
        path_at: Callable[[int], Path],
    ) -> None:
        """Evaluate the best paths of a population in full until the best one has been evaluated.

        Parameters
        ----------
        settled : (m,) bool
            True for each path evaluated in full; changed in place.
        path_at : callable
            Returns the path in a slot, (n, 3) float64 metres, ends included.
        """
        while not settled[best := int(np.argmax(fitness))]:
            claimed = fitness[best] > 1
            path = path_at(best)
            fitness[best] = self._run.fitness([path])[0]
            settled[best] = True
            self._in_full += 1
            self._claimed += int(claimed)
            if claimed and (cause := refutation(self._run.evaluator, path)):
                self._refuted[cause] += 1

    def report(self) -> dict[str, Any]:
        """Return the block ``feasibility`` of a summary: counts, saved samples, refuted paths.

        ``host_samples_saved`` is the number of points of the straight paths at ``ds`` that the host
        did not look up, including points of paths evaluated in full. ``refuted_by`` counts, by
        reason, the paths that the counts called feasible and the full evaluation did not: see
        :func:`refutation`.
        """
        return {
            "counted_on_board": self._counted,
            "evaluated_in_full": self._in_full,
            "host_samples_saved": self._samples,
            "claimed_feasible": self._claimed,
            "refuted_by": {name: self._refuted[name] for name in CAUSES},
        }

    def _metres_per_cell(self, path: Path, segment: int) -> float:
        config = self._chip.config
        ends = path[segment : segment + 2]
        cells = self._grid.to_cells(ends)[:, :2]
        # The two-tier build counts cells of its coarse map in these segments.
        if config.checker is CheckerBuild.TWO_TIER and segment >= config.DETAILED_SEGMENTS:
            cells //= config.coarse_factor
        across = int(np.abs(cells[1] - cells[0]).max()) + 1
        return float(np.hypot(*(ends[1, :2] - ends[0, :2]))) / across

    def _samples_of(self, path: Path) -> int:
        lengths = np.sqrt((np.diff(path, axis=0) ** 2).sum(axis=1))
        return int(np.ceil(lengths / self._run.evaluator.ds_m).sum())


def refutation(evaluator: Evaluator, path: Path) -> str | None:
    """Return why a path that the counts call feasible is not feasible; None if it is.

    ``between_cells``: the straight path collides at ``ds``; ``turn_arcs``: only the smoothed track
    does; ``between_samples``: the smoothed track is clear at ``ds`` and collides at ``ds / 8``,
    which the strict rule of a report checks.

    Parameters
    ----------
    path : (n, 3) float64
        Metres, ends included.
    """
    evaluation = evaluator.evaluate(path)
    if evaluation.feasible:
        return None
    if evaluation.feasible_at_ds:
        return "between_samples"
    problem = evaluator.problem
    straight = smooth(path, _NO_RADIUS_M)
    track = SmoothedTrack(straight.pieces, problem.surface)
    samples, _ = track.midpoints(evaluator.ds_m)
    under = (samples.clearance < 0) | np.isnan(samples.ground)
    inside = problem.nofly_raster[problem.terrain.nearest_nodes(samples.x, samples.y)]
    return "between_cells" if (under | inside).any() else "turn_arcs"
