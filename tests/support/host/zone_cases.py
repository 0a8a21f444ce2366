"""Scenes of zones that the product reads and plans among, and that the judge compares."""

import random
from dataclasses import replace

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.mission.build import mission_of
from pathgene.host.planning import Search
from pathgene.host.terrain import load
from tests.support.host.zone_judge import STEP_M, Judge
from tests.support.host.zone_scenes import CELL, scene
from tests.support.host.zone_writers import write


_PATHS = 6
_END_M = 60.0
_SPEED_M_S, _STEEPEST = 23.0, 0.17
#: Options with which a search takes a second.
_BUDGETS = {
    "astar": {},
    "fpa-2opt": {"generations": 25, "population": 16, "engine": "sequential"},
    "ga-pc": {"generations": 40},
    "ga-dp": {"generations": 8},
    "ga-auv": {"generations": 12},
    "ga-fpga": {"generations": 30, "board": "model:"},
    "ga-chip": {"generations": 60, "board": "model:"},
}


class Case:
    """A scene with its terrain and file.

    Parameters
    ----------
    seed : int
        Seed of the scene.
    folder : Path
        Folder of the files.
    """

    def __init__(self, seed, folder):
        self.drawn, self._folder = scene(seed), folder
        self.drawn.site.write(folder / "ground.tif")
        self.terrain = load(folder / "ground.tif")
        self._unit_m = self.terrain.dx_m / CELL
        #: The zones that count: one with swapped coordinates is left out.
        self.seen = self.drawn.having(a for a in self.drawn.areas if a.name != self.drawn.swapped)
        self.judge = Judge(self.seen, self._unit_m, _SPEED_M_S)
        self._place_ends()

    def _place_ends(self):
        """Move start and goal out of the zones at all times, if there is such a place."""
        rng = random.Random(f"ends {self.drawn.seed}")
        areas = [replace(each, hours=(), seconds=(None, None)) for each in self.seen.areas]
        always = Judge(self.seen.having(areas), self._unit_m, _SPEED_M_S)
        ends = []
        for end in (self.drawn.start, self.drawn.goal):
            for _ in range(30):
                x, y, z = self._end(end)
                if not always.judge([x], [y], [z])[1]:
                    break
                end = tuple(each + rng.uniform(-500, 500) for each in end)
                end = tuple(np.clip(end, 150, 3850))
            ends.append(end)
        start, goal = ends
        self.drawn = replace(self.drawn, start=start, goal=goal)

    def _end(self, end):
        ground = float(self.drawn.site.ground([end])[0])
        return (*(each * self._unit_m for each in end), ground + _END_M)

    def problem(self, areas=None, **more):
        """Return the problem with zones as the product reads them."""
        drawn = self.drawn if areas is None else self.drawn.having(areas)
        values = {
            "start": self._end(drawn.start),
            "goal": self._end(drawn.goal),
            "wind": drawn.wind,
            "zone_margin": drawn.margin_m,
            "qnh": drawn.qnh_hpa,
            "forbid": drawn.forbid,
            "departure": drawn.departure and drawn.departure.isoformat(),
            "nofly": [str(write(drawn, self._folder))] if drawn.areas else None,
            "skip_bad_zones": bool(drawn.swapped),
            **more,
        }
        return mission_of(values, self.terrain).problem

    # --- Comparisons -----------------------------------------------------------------------------

    def compare_random_paths(self):
        """Compare the zones that random paths enter, as product and judge see them.

        Returns the number of paths that enter a zone.
        """
        problem = self._read()
        if problem is None:
            return 0
        evaluator, entering = Evaluator(problem), 0
        for path in self._random_paths(problem):
            surely, perhaps = self._judged(evaluator, path)
            entered = {zone.name for zone in evaluator.entered(path)}
            entering += bool(entered)
            self._compare(entered, surely, perhaps)
        return entering

    def compare_plans(self):
        """Compare a plan with the judge's verdict; return whether there is a feasible one.

        A zone that is never active on the path planned without it, or does not forbid, must not
        change that path or its verdict.
        """
        problem = self._read()
        if problem is None:
            return False
        evaluator = Evaluator(problem)
        search = Search(self.drawn.planner, seed=self.drawn.seed, **_BUDGETS[self.drawn.planner])
        found = search.run(evaluator)
        surely, perhaps = self._judged(evaluator, found.path)
        self._compare({zone.name for zone in evaluator.entered(found.path)}, surely, perhaps)
        assert not (found.evaluation.feasible and surely), (self.drawn.seed, surely)
        always = [area for area in self.drawn.areas if area.forbids and not self._is_timed(area)]
        if len(always) < len(self.drawn.areas):
            self._compare_without(search, evaluator, found, always)
        return found.evaluation.feasible

    def _compare_without(self, search, evaluator, found, always):
        """Compare with a plan among the zones that forbid at all times."""
        alone = search.run(Evaluator(self.problem(always)))
        surely, perhaps = self._judged(evaluator, alone.path)
        checked = evaluator.evaluate(alone.path)
        if alone.evaluation.feasible and not perhaps:
            assert checked.feasible, self.drawn.seed
            # A zone that is active during the whole flight narrows the search.
            flight_s = alone.evaluation.length_m / _SPEED_M_S
            left_out = [area for area in self.seen.areas if area.forbids and area not in always]
            if all(self.judge.pauses(area, flight_s) for area in left_out):
                assert np.array_equal(found.path, alone.path), self.drawn.seed
        assert not (checked.feasible and surely), (self.drawn.seed, surely)

    def _is_timed(self, area):
        has_hours = bool(area.hours) and self.drawn.departure is not None
        return has_hours or area.seconds != (None, None)

    def _read(self):
        """Return the problem, or None if it is refused for a reason that the judge confirms."""
        if self.drawn.swapped:
            with pytest.raises(InputError, match=r"swap|latitude|no place"):
                self.problem(skip_bad_zones=False)
        try:
            return self.problem()
        except InputError as error:
            if "is inside" not in str(error):
                raise
        near = [
            self.judge.judge(*([each] for each in self._end(end)))[1]
            for end in (self.drawn.start, self.drawn.goal)
        ]
        assert any(near), self.drawn.seed
        return None

    def _random_paths(self, problem):
        rng = np.random.default_rng(self.drawn.seed)
        for _ in range(_PATHS):
            middle = rng.uniform(100, 3900, (rng.integers(1, 4), 2))
            ground = self.drawn.site.ground(middle)
            heights = ground + rng.choice((60.0, 120.0, 400.0), len(middle)) + rng.uniform(0, 60)
            points = np.column_stack((middle * self._unit_m, heights))
            yield _gentle(np.vstack((problem.start, points, problem.goal)))

    def _judged(self, evaluator, path):
        track = evaluator.track(path).sample(STEP_M)
        return self.judge.judge(track.x, track.y, track.z)

    def _compare(self, entered, surely, perhaps):
        """Compare the zones that the product calls entered with the verdict of the judge."""
        seed = self.drawn.seed
        if not self.drawn.ability.named:
            entered, surely, perhaps = map(bool, (entered, surely, perhaps))
            assert surely <= entered <= perhaps, seed
            return
        assert surely <= entered, (seed, self.drawn.kind, surely - entered)
        assert entered <= perhaps, (seed, self.drawn.kind, entered - perhaps)


def _gentle(path):
    """Return a path whose waypoints are lowered or raised until an aircraft can climb to them."""
    for number, before, after in (
        *((k, k - 1, k) for k in range(1, len(path) - 1)),
        *((k, k + 1, k) for k in range(len(path) - 2, 0, -1)),
    ):
        most = _STEEPEST * np.linalg.norm(path[after, :2] - path[before, :2])
        low, high = path[before, 2] - most, path[before, 2] + most
        path[number, 2] = min(max(path[number, 2], low), high)
    return path
