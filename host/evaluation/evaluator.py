"""The evaluator of paths, shared by planners, reports and the command line."""

from __future__ import annotations

import functools
import math
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.evaluation.constants import (
    COORDINATE_LIMIT_M,
    VOID_HEIGHT_M,
    Constants,
    Course,
    Floats,
)
from pathgene.host.evaluation.fuel import level_range_m
from pathgene.host.evaluation.geometry import smooth
from pathgene.host.evaluation.problem_constants import constants_of
from pathgene.host.evaluation.terms import Evaluation, Late
from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.machine import available_cores
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone


if TYPE_CHECKING:
    from pathgene.host.evaluation.broken import Stretch
    from pathgene.host.evaluation.strict_rule import StrictRule

__all__ = ["FINE", "Evaluator"]

# A path is reported feasible only if it is feasible at samples this many times finer.
FINE = 8
# Ends this close are equal: coordinates may have passed through a text file.
_SAME_POINT_M = 1e-6
# Four times the limit of a problem from start to goal, as paths go around.
_MOST_SAMPLES = 2_000_000
_PATHS_PER_THREAD = 16  # With fewer, a second thread costs more than it saves.


class Evaluator:
    """Evaluates paths of one problem, one at a time or as a population.

    Every call evaluates every path in full. Results do not depend on the number of threads.

    Parameters
    ----------
    ds_m : float, optional
        Sampling step of d_ut and d_nf; the problem's own by default.
    threads : int, optional
        Threads that share a population; one per core by default.

    Raises
    ------
    InputError
        If the straight line from start to goal has no positive altitude and fuel to compare with.
    ValueError
        If ``ds_m`` is not a positive number or ``threads`` is not a positive integer.
    """

    def __init__(
        self, problem: Problem, *, ds_m: float | None = None, threads: int | None = None
    ) -> None:
        ds_m = problem.ds_m if ds_m is None else ds_m
        if not (math.isfinite(ds_m) and ds_m > 0):
            raise ValueError(f"Sampling step must be a positive number of metres, not {ds_m!r}")
        threads = available_cores() if threads is None else threads
        if not isinstance(threads, int) or threads < 1:
            raise ValueError(f"Thread count must be a positive integer, not {threads!r}")

        self.problem = problem
        self.ds_m = float(ds_m)
        self.threads = threads

        # Numba, which compiles the kernels, is loaded with the first evaluator.
        from pathgene.host.evaluation import kernels

        self._kernels = kernels
        self._bare = constants_of(problem, self.ds_m)
        self._pool: ThreadPoolExecutor | None = None

    @cached_property
    def _strict(self) -> StrictRule | None:
        """The strict rule, which a replan makes while the chip already searches."""
        if self.problem.rules is None:
            return None
        from pathgene.host.evaluation.strict_rule import StrictRule

        return StrictRule(self.problem, self._bare)

    def among(self, zones: tuple[Zone, ...]) -> Evaluator:
        """Return the evaluator of the same problem with other zones.

        Raises
        ------
        InputError
            If an end lies in a zone.
        """
        problem = self.problem.among(zones)
        return Evaluator(problem, ds_m=self.ds_m, threads=self.threads)

    @cached_property
    def _constants(self) -> Constants:
        """All constants; ``_bare`` lacks ``roofed``, which the strict rule does not read."""
        return self._bare._replace(roofed=int(self.problem.roof is not None))

    @cached_property
    def _course(self) -> Course:
        return Course(self._ground, self._zoned, self._constants)

    @cached_property
    def _fine(self) -> Course:
        return _with(self._course, ds_m=self.ds_m / FINE)

    @cached_property
    def _ground(self) -> Floats:
        """The surface of the search, and the negated roof, if there is one."""
        problem = self.problem
        elevation = problem.surface.elevation
        ground = np.where(np.isnan(elevation), VOID_HEIGHT_M, elevation).ravel()
        # Above a roof is below it, upside down.
        return ground if problem.roof is None else np.concatenate((ground, -problem.roof.ravel()))

    @cached_property
    def _zoned(self) -> Floats:
        """The surface of the search, NaN in no-fly zones."""
        nofly = self.problem.nofly_raster.ravel()
        return np.where(nofly, np.nan, self._ground[: len(nofly)])

    @property
    def course(self) -> Course:
        """Rasters and constants for kernels that know no time.

        Zones that are active at times count as always active.
        """
        if not self.problem.zones_at_times:
            return self._course
        zoned = np.where(self.problem.blocked_raster.ravel(), np.nan, self._zoned)
        return self._course._replace(zoned=zoned)

    def evaluate(self, path: NDArray[np.float64]) -> Evaluation:
        """Return every term of one path, (n, 3) float64 metres, n >= 2, start and goal included.

        Raises
        ------
        InputError
            If a coordinate is not finite, or beyond 10,000 km, or the path makes more than two
            million samples.
        ValueError
            If the path has the wrong shape or other ends than the problem.
        """
        path = self._checked(path)
        if self._strict is not None:
            return self._by_rules(self._strict, path)
        n = len(path)
        kernels, c = self._kernels, self._constants
        scratch = kernels.scratch(n)
        length, altitude, fuel, steep, under, zone, impossible, _ = kernels.path_terms(
            path, n, self._course, scratch
        )
        corners = kernels.corners_m(c, scratch.turns, n, length)
        penalty = under + zone + steep + corners
        fine = kernels.path_terms(path, n, self._fine, scratch)
        penalty_fine = fine[4] + fine[5] + steep + corners
        cost = kernels.cost_of(c, altitude, fuel)

        track = self.track(path)
        x, y, z = path[[0, -1]].T
        ground = self.problem.terrain.ground(x, y)
        clearance = np.append(z - ground, track.least_clearance_m(self.ds_m / FINE))
        return Evaluation(
            feasible=bool(penalty == 0 and penalty_fine == 0),
            feasible_at_ds=bool(penalty == 0),
            fitness=kernels.fitness_of(penalty, cost),
            penalty=penalty,
            cost=cost,
            length_m=length,
            mean_altitude_m=altitude / length + self.problem.cost_base_m,
            fuel_N=fuel,
            distance_under_terrain_m=under,
            distance_in_nofly_m=zone,
            distance_too_steep_m=steep,
            impossible_arcs=impossible,
            void_crossed_m=self._void_m(track),
            minimum_clearance_m=float(np.nanmin(clearance)),
            penalty_fine=penalty_fine,
        )

    def _by_rules(self, rule: StrictRule, path: NDArray[np.float64]) -> Evaluation:
        """Return every term of a path by the strict rule."""
        kernels, problem = self._kernels, self.problem
        assert problem.rules is not None
        terms, track = rule.judge(path)
        length, altitude, fuel, steep, under, zone, impossible, beyond = terms
        arcs = len(path) - 2 + self._bare.headings
        corners = impossible / arcs * length if arcs else 0.0
        penalty = under + zone + steep + corners + beyond
        cost = kernels.cost_of(self._bare, altitude, fuel)
        # The search rasters take milliseconds to copy. A replan must not wait for that.
        is_seen = bool(
            penalty == 0
            or self._population(path[None], np.array([len(path)]), self._course)[0, 0] == 0
        )
        # A replan passes its path on before anyone reads the report.
        report = functools.cache(functools.partial(rule.report, track))
        fuel_left = range_left = None
        if problem.aircraft.fuel_weight_N is not None:
            fuel_left = problem.aircraft.fuel_weight_N - fuel
            range_left = level_range_m(problem.aircraft, fuel, max(fuel_left, 0.0))
        return Evaluation(
            feasible=bool(penalty == 0),
            feasible_at_ds=is_seen,
            fitness=kernels.fitness_of(penalty, cost),
            penalty=penalty,
            cost=cost,
            length_m=length,
            mean_altitude_m=altitude / length + self.problem.cost_base_m,
            fuel_N=fuel,
            distance_under_terrain_m=under,
            distance_in_nofly_m=rule.metres_in_zones(track, zone) if zone else 0.0,
            distance_too_steep_m=steep,
            impossible_arcs=impossible,
            void_crossed_m=self._void_m(self.track(path)) if rule.has_voids else 0.0,
            minimum_clearance_m=Late(lambda: report()[0]),
            penalty_fine=penalty,
            clearance_m=problem.rules.clearance_m,
            distance_beyond_limits_m=beyond,
            max_height_agl_m=Late(lambda: report()[1]),
            flight_time_s=track.time_s,
            fuel_left_N=fuel_left,
            range_left_m=range_left,
            limits=Late(lambda: report()[2]),
        )

    def _void_m(self, track: SmoothedTrack) -> float:
        """Return the metres of a track over voids, by its samples at ``ds``."""
        samples, weights = track.midpoints(self.ds_m)
        return float(weights[np.isnan(samples.ground)].sum())

    def fitness(
        self, paths: NDArray[np.float64], lengths: NDArray[np.integer[Any]], *, strict: bool = False
    ) -> NDArray[np.float64]:
        """Return the fitness of a population, (m,) float64, every value inside (0, 2).

        Parameters
        ----------
        paths : (m, max_n, 3) float64, metres
            Start and goal included; rows at ``lengths[i]`` and beyond are not read. The ends are
            not checked.
        lengths : (m,) integers
            Points of each path, 2 to max_n.
        strict : bool
            Evaluate by the strict rule rather than above the search surface; not with ``as_paper``.

        A path with a coordinate that is not finite, or beyond 10,000 km, gets the least value.

        Raises
        ------
        ValueError
            If a shape is wrong or a length is out of range.
        """
        if strict and self._strict is not None:
            terms = zip(*self.penalty_cost(paths, lengths, fine=True), strict=True)
            return np.array([self._kernels.fitness_of(*each) for each in terms])
        fitness: NDArray[np.float64] = self._population(paths, lengths, self._course)[2]
        return fitness

    def fitness_counted(
        self,
        paths: NDArray[np.float64],
        lengths: NDArray[np.integer[Any]],
        counted_m: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Return fitness as :meth:`fitness` does, with d_ut + d_nf given instead of sampled.

        Parameters
        ----------
        paths, lengths
            As for :meth:`fitness`.
        counted_m : (m,) float64, metres
            Distance of each path under the terrain and in no-fly zones, 0 or more.
        """
        blind = _with(self._course, sampled=0)
        fitness: NDArray[np.float64] = self._population(paths, lengths, blind, counted_m)[2]
        return fitness

    def penalty_cost(
        self, paths: NDArray[np.float64], lengths: NDArray[np.integer[Any]], *, fine: bool = False
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return penalty and cost of a population as for :meth:`fitness`; infinite for bad paths.

        With ``fine`` they decide a reported feasibility: by the strict rule, or with
        ``as_paper`` at samples of ``ds / 8``.
        """
        if fine and self._strict is not None:
            return self._strict.penalty_cost(*_as_population(paths, lengths))
        penalty, cost, _ = self._population(paths, lengths, self._fine if fine else self._course)
        return penalty, cost

    def first_feasible(self, paths: NDArray[np.float64], lengths: NDArray[np.int64]) -> int | None:
        """Return the index of the first path that is feasible by the strict rule, or None.

        Much faster than :meth:`fitness`, whose parameters it has, where most paths break a limit.
        Coordinates are finite, and within 10,000 km.

        Raises
        ------
        ValueError
            As for :meth:`fitness`, or with ``as_paper``, which has no strict rule.
        """
        if self._strict is None:
            raise ValueError("The strict rule needs rules")
        return self._strict.first_kept(*_as_population(paths, lengths))

    def segments_penalty_cost(
        self, paths: NDArray[np.float64], lengths: NDArray[np.integer[Any]]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return penalty and cost of parts of paths, which begin and end with any heading."""
        ends = {"start_east": 0.0, "start_north": 0.0, "goal_east": 0.0, "goal_north": 0.0}
        free = _with(self._course, headings=0, **ends)
        penalty, cost, _ = self._population(paths, lengths, free)
        return penalty, cost

    def track(self, path: NDArray[np.float64]) -> SmoothedTrack:
        """Return the smoothed path over the terrain.

        Raises
        ------
        InputError, ValueError
            As for :meth:`evaluate`.
        """
        problem = self.problem
        smoothed = smooth(self._checked(path), problem.limits.turn_radius_m, problem.headings)
        return SmoothedTrack(smoothed.pieces, problem.terrain)

    def broken(self, path: NDArray[np.float64]) -> list[Stretch]:
        """Return the stretches of a path that break a limit; empty with ``as_paper``.

        Raises
        ------
        InputError, ValueError
            As for :meth:`evaluate`.
        """
        path = self._checked(path)
        return [] if self._strict is None else self._strict.broken(self._strict.lay(path))

    def entered(self, path: NDArray[np.float64]) -> list[Zone]:
        """Return the zones that a path enters while they are active; empty with ``as_paper``."""
        return self._strict.entered(self._strict.lay(path)) if self._strict else []

    def lowest_at_m(self, path: NDArray[np.float64]) -> float | None:
        """Return the metres flown to the least clearance of a path; None with ``as_paper``."""
        if self._strict is None:
            return None
        return self._strict.lowest_at_m(self._strict.lay(self._checked(path)))

    def _checked(self, path: NDArray[np.float64]) -> NDArray[np.float64]:
        path = np.ascontiguousarray(path, dtype=np.float64)
        if path.ndim != 2 or path.shape[1] != 3 or len(path) < 2:
            raise ValueError(f"Path must have shape (n, 3) with n >= 2, not {path.shape!r}")
        if not np.isfinite(path).all():
            raise InputError("The path has a coordinate that is not a number; correct its file.")
        if np.abs(path).max() > COORDINATE_LIMIT_M:
            raise InputError(
                "The path has a coordinate beyond 10,000 km, which is on no map; give "
                "it in metres of the terrain's local frame."
            )
        length_m = float(np.hypot.reduce(np.diff(path, axis=0), axis=1).sum())
        if length_m > _MOST_SAMPLES * self.ds_m:
            raise InputError(
                f"The path is {length_m / 1000:,.0f} km long, of which a sampling step of "
                f"{self.ds_m:g} m makes more than {_MOST_SAMPLES:,} samples; correct the path, or "
                f"increase the step to {1.1 * length_m / _MOST_SAMPLES:.2g} m."
            )
        for name, point, wanted in (
            ("start", path[0], self.problem.start),
            ("end", path[-1], self.problem.goal),
        ):
            if np.abs(point - wanted).max() > _SAME_POINT_M:
                raise ValueError(f"Path must {name} at {wanted!r}, not {tuple(point.tolist())!r}")
        return path

    def _population(
        self,
        paths: NDArray[np.float64],
        lengths: NDArray[np.integer[Any]],
        course: Course,
        counted_m: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """Return penalty, cost and fitness as the rows of a (3, m) array."""
        paths, points = _as_population(paths, lengths)
        count = len(paths)
        counted = np.zeros(count) if counted_m is None else np.asarray(counted_m, dtype=np.float64)
        if counted.shape != (count,):
            raise ValueError(
                f"Counted distances must have shape {(count,)!r}, not {counted.shape!r}"
            )
        out = np.empty((3, count))
        if count == 0:
            return out
        shares = min(self.threads, max(1, count // _PATHS_PER_THREAD))

        def run(first: int) -> None:
            self._kernels.evaluate_share(
                paths,
                points,
                first,
                shares,
                course,
                self._kernels.scratch(paths.shape[1]),
                counted,
                out,
            )

        if shares == 1:
            run(0)
        else:
            if self._pool is None:
                self._pool = ThreadPoolExecutor(self.threads, thread_name_prefix="evaluate")
            list(self._pool.map(run, range(shares)))
        if self._strict is not None and self.problem.zones_at_times:
            self._strict.add_timed_zones(paths, points, out[0])
            out[2] = [self._kernels.fitness_of(*terms) for terms in out[:2].T.tolist()]
        return out


def _with(course: Course, **constants: Any) -> Course:
    """Return a course with other constants."""
    return course._replace(c=course.c._replace(**constants))


def _as_population(paths: Floats, lengths: NDArray[Any]) -> tuple[Floats, NDArray[np.int64]]:
    """Return paths and lengths as the kernels take them, which check nothing."""
    paths = np.ascontiguousarray(paths, dtype=np.float64)
    points = np.ascontiguousarray(lengths, dtype=np.int64)
    if paths.ndim != 3 or paths.shape[2] != 3:
        raise ValueError(f"Paths must have shape (m, max_n, 3), not {paths.shape!r}")
    if points.shape != (len(paths),):
        raise ValueError(f"Lengths must have shape {(len(paths),)!r}, not {points.shape!r}")
    most = paths.shape[1]
    # The reductions themselves: the methods of the array take a microsecond more.
    if len(points) and (np.minimum.reduce(points) < 2 or np.maximum.reduce(points) > most):
        raise ValueError(f"Lengths must be 2 to {most}, not {points.min()} to {points.max()}")
    return paths, points
