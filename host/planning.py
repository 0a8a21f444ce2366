"""Planning of a problem, shared by the command line and the Python API."""

from __future__ import annotations

import copy
import dataclasses
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluation, Evaluator
from pathgene.host.files.output import prepare_directory
from pathgene.host.options.arguments import own_options
from pathgene.host.options.table import FALLBACKS
from pathgene.host.planners import DEFAULT_BOARD, PLANNERS, make, named_or_default
from pathgene.host.planners.base import Options, Progress, Result, Stop
from pathgene.host.planners.timed import plan_in_time, plan_together_in_time
from pathgene.host.problem.changes import changed_problem
from pathgene.host.problem.zones import Zone
from pathgene.host.report.summary import summarise
from pathgene.host.report.write import scene, write_report


if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pathgene.host.diagnosis import Reason

__all__ = ["Plan", "Search"]


class _TogetherPlanner(Protocol):
    """A planner that plans several problems at once."""

    def plan_together(
        self, evaluators: Sequence[Evaluator], options: Sequence[Options], stop: Stop | None
    ) -> list[Result]: ...


@dataclass(frozen=True, repr=False, eq=False)
class Plan:
    """A finished run of a planner.

    Parameters
    ----------
    evaluator : Evaluator
        Evaluates paths of the problem.
    result : Result
        The path, its terms and the record of the run.
    planner : str
        Name of the planner.
    board : str or None
        URL of the board, for a planner that uses one.
    seed : int
        Seed of the run.
    source : mapping
        Origin of the terrain, as ``summary.json`` states it.
    reason : Reason or None
        The reason why there is no feasible path; None if there is one, or if the reason was not
        determined.
    fallback : str or None
        The planner that found the path after this one found no feasible path.
    search : Search or None
        The planner and its options, which :meth:`replan` uses.
    """

    evaluator: Evaluator
    result: Result
    planner: str
    board: str | None
    seed: int
    source: Mapping[str, Any]
    reason: Reason | None = field(default=None, kw_only=True)
    fallback: str | None = field(default=None, kw_only=True)
    search: Search | None = field(default=None, kw_only=True)

    @property
    def path(self) -> NDArray[np.float64]:
        """Waypoints, (n, 3) float64 metres, start and goal included."""
        return self.result.path

    @property
    def evaluation(self) -> Evaluation:
        """Terms of the path."""
        return self.result.evaluation

    @property
    def history(self) -> list[list[float]]:
        """Generation, best fitness and mean fitness, from generation 0."""
        return self.result.history

    @property
    def interrupted(self) -> bool:
        """True if the user or ``cancel`` ended the search early."""
        return self.result.interrupted

    @property
    def failure(self) -> str | None:
        """A sentence about an early end of the search, such as a lost board, or None.

        The path is the best one found before that.
        """
        return self.result.failure

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The content of ``summary.json`` in plain JSON values; every number is finite."""
        return {
            **summarise(
                self.evaluator,
                self.result,
                planner=self.planner,
                board=self.board,
                seed=self.seed,
                source=self.source,
            ),
            "reason": None if self.reason is None else self.reason.to_dict(),
            "fallback": self.fallback,
        }

    def __repr__(self) -> str:
        verdict = "feasible" if self.evaluation.feasible else "not feasible"
        return (
            f"<Plan by {self.planner}: {verdict}, fitness {self.evaluation.fitness:.4f}, "
            f"{self.evaluation.length_m / 1000:.2f} km, {len(self.path)} points>"
        )

    def replan(
        self,
        zones: Iterable[Zone] = (),
        start: Sequence[float] | None = None,
        heading: float | None = None,
        *,
        gone: Iterable[Zone] = (),
        goal: Sequence[float] | None = None,
        wind: Sequence[float] | None = None,
        elapsed_s: float = 0.0,
    ) -> Plan:
        """Plan the rest of a flight after zones have appeared or gone and the aircraft has moved.

        On a board that is still open, ``ga-chip`` lets the chip draw the zones and continue from
        its population for a millisecond. If zones have appeared and zones have gone, the path
        avoids both, which is faster; :meth:`finish` clears the removed zones. A further replan of
        the same plan continues from the latest of its replans. Any other problem, and a plan whose
        population another plan has replaced, is planned again with the same options and the same
        fallback.

        Parameters
        ----------
        zones : iterable of Zone
            Zones that have appeared; the zones of the problem stay.
        start : (float, float, float), optional
            x, y and altitude, metres, where the aircraft will be when it has the new path.
        heading : float, optional
            Heading there, degrees clockwise from the frame's north; without it, the heading at a
            new start is free.
        gone : iterable of Zone
            Zones of the problem that no longer exist.
        goal : (float, float, float), optional
            A new goal.
        wind : (float, float), optional
            A new wind, m/s in x and y.
        elapsed_s : float
            Seconds flown from the start of this plan to the new start, from which the times of
            zones then count; the times of new zones count from there already.

        Returns
        -------
        Plan
            The plan of the changed problem, which can itself be replanned.

        Raises
        ------
        InputError
            If a value has the wrong type, a removed zone does not belong to the problem, or an end
            is in the ground, in a zone or off the map.
        JobError
            If the search fails before it has a path.
        """
        if self.search is None:
            raise InputError(
                "Only a plan that a planner has made here can be replanned; plan the problem first."
            )
        problem = changed_problem(
            self.evaluator.problem,
            zones,
            start,
            heading,
            gone=gone,
            goal=goal,
            wind=wind,
            elapsed_s=elapsed_s,
        )
        return self.search.replan(self, Evaluator(problem, threads=self.evaluator.threads))

    def finish(self) -> None:
        """Finish the uploads of :meth:`replan`; call it once the path has been passed on.

        Call it even if no path was found; otherwise the next replan does it.
        """
        if self.result.replanner is not None and self.result.replanner.is_ready:
            self.result.replanner.finish()

    def plot(self) -> Figure:
        """Draw the map with the path, the altitudes along it, and the convergence.

        Returns
        -------
        matplotlib.figure.Figure
            The picture that :meth:`save` writes; its ``savefig`` writes other formats.
        """
        from pathgene.host.report.picture import draw

        return draw(scene(self.evaluator, self.result, self.summary))

    def save(
        self,
        directory: str | Path,
        *,
        picture: bool = True,
        grid: bool = True,
        warn: Callable[[str], None] = warnings.warn,
    ) -> list[Path]:
        """Write ``summary.json``, ``terrain.npz``, ``path.geojson`` and ``path.png``.

        The files of an earlier run there, including files for ground stations, are replaced or
        removed: all of them, or none after an error.

        Parameters
        ----------
        directory : str or Path
            Folder of the files; created if missing.
        picture : bool
            Draw ``path.png``; otherwise remove the picture of an earlier run.
        grid : bool
            Write ``terrain.npz``; otherwise remove the file of an earlier run.
        warn : callable
            Receives a sentence if the picture cannot be drawn, which does not affect other files.

        Returns
        -------
        list of Path
            The files written.

        Raises
        ------
        InputError
            If the directory cannot be written to.
        """
        directory = Path(directory)
        prepare_directory(directory)
        return write_report(
            directory,
            self.evaluator,
            self.result,
            self.summary,
            warn=warn,
            picture=picture,
            grid=grid,
        ).files


class Search:
    """A planner with its options, ready for a problem.

    Parameters
    ----------
    planner : str, optional
        A name in :data:`pathgene.host.planners.PLANNERS`; by default the planner for the core of
        the board: see :func:`pathgene.host.planners.registry.default_planner`.
    generations : int, optional
        Maximum number of generations; the planner's own by default.
    time_limit_s, target_fitness, population, seed
        See :class:`pathgene.host.planners.base.Options`.
    fallback : str, optional
        If the planner finds no feasible path, determine the reason, and with ``astar`` search with
        that planner, and then with ``fpa-2opt``, unless the reason is proven. ``none`` only
        determines the reason; by default, nothing is done. With ``as_paper`` there is no fallback.
    **options
        The planner's own options: the rows of :data:`pathgene.host.options.table.OWN` that its
        entry lists. None stands for the default.

    Raises
    ------
    InputError
        If there is no such planner, the planner has no such option, or a value is out of range.
    """

    def __init__(
        self,
        planner: str | None = None,
        *,
        generations: int | None = None,
        time_limit_s: float | None = None,
        target_fitness: float | None = None,
        population: int | None = None,
        seed: int = 0,
        fallback: str | None = None,
        **options: Any,
    ) -> None:
        if fallback is not None and fallback not in FALLBACKS:
            raise InputError(f"The fallback must be astar or none, not {fallback!r}.")
        self.fallback = fallback
        planner = named_or_default(planner, options)
        own = own_options(planner, options)
        self._planner = make(planner, **own)
        self._own = own
        self.planner = planner
        entry = PLANNERS[planner]
        self.board: str | None = None
        if "board" in entry.options:
            from pathgene.host.device.boards import url_of

            self.board = url_of(own.get("board", DEFAULT_BOARD))
        self.options = Options(
            generations=entry.generations if generations is None else generations,
            time_limit_s=time_limit_s,
            target_fitness=target_fitness,
            population=population,
            seed=seed,
        )

    def run(
        self,
        evaluator: Evaluator,
        *,
        progress: Progress | None = None,
        stop: Stop | None = None,
        source: Mapping[str, Any] | None = None,
    ) -> Plan:
        """Plan the problem of ``evaluator``; see :func:`pathgene.host.mission.plan.plan`."""
        result = plan_in_time(self._planner, evaluator, self.options, progress, stop)
        if stop is not None:
            stop.heeded = True
        if source is None:
            source = evaluator.problem.terrain.loading
        return self._settled(self._plan(evaluator, result, source), stop)

    @property
    def kind(self) -> tuple[object, ...] | None:
        """Key shared by searches that a GPU can run together; None for a search that runs alone."""
        if self._own.get("engine") != "gpu":
            return None
        own = sorted(self._own.items(), key=lambda item: item[0])
        return self.planner, dataclasses.replace(self.options, seed=0), self.fallback, *own

    def run_together(
        self, evaluators: Sequence[Evaluator], seeds: Sequence[int], stop: Stop | None = None
    ) -> list[Plan]:
        """Plan several problems at once on a GPU, each with its own seed; see :meth:`run`.

        Parameters
        ----------
        evaluators, seeds
            Evaluator and seed of each problem; the seed of the search is not used.
        stop : Stop, optional
            Ends all searches.

        Raises
        ------
        InputError
            If the engine is not ``gpu``, there is no GPU, or a problem is bad.
        JobError
            If the GPU fails before it has a path.
        """
        if self.kind is None:
            raise InputError(
                "Problems are planned together on a GPU alone; give fpa or fpa-2opt and the engine "
                "gpu."
            )
        searches = [copy.copy(self) for _ in seeds]
        for search, seed in zip(searches, seeds, strict=True):
            search.options = dataclasses.replace(self.options, seed=seed)
        planner = cast(_TogetherPlanner, self._planner)  # Only these have the engine gpu.
        results = plan_together_in_time(
            lambda some, options: planner.plan_together(some, options, stop),
            evaluators,
            [search.options for search in searches],
        )
        if stop is not None:
            stop.heeded = True
        return [
            search._settled(
                search._plan(evaluator, result, evaluator.problem.terrain.loading), stop
            )
            for search, evaluator, result in zip(searches, evaluators, results, strict=True)
        ]

    def replan(self, plan: Plan, evaluator: Evaluator) -> Plan:
        """Plan the changed problem of ``evaluator``; see :meth:`Plan.replan`."""
        replanner = plan.result.replanner
        if replanner is None or not replanner.is_ready:
            return self.run(evaluator, source=plan.source)
        result = replanner.replan(evaluator, self.options)
        return self._settled(self._plan(evaluator, result, plan.source), None, improves=False)

    def _plan(self, evaluator: Evaluator, result: Result, source: Mapping[str, Any]) -> Plan:
        return Plan(
            evaluator,
            result,
            self.planner,
            self.board,
            self.options.seed,
            source,
            search=self,
        )

    def _settled(self, plan: Plan, stop: Stop | None, *, improves: bool = True) -> Plan:
        """Complete a plan without a feasible path by the fallback's, improved, or by the reason."""
        result, evaluator = plan.result, plan.evaluator
        if self.fallback is None or result.evaluation.feasible:
            return plan
        if result.interrupted or result.failure is not None:
            return plan
        if stop is not None and not stop.requested:
            stop.heeded = False
        # Loads SciPy.
        from pathgene.host.connection import SEARCHERS, connect, interrupted, with_path_of
        from pathgene.host.planners.grid.further import improved

        searchers: tuple[str, ...] = ()
        if self.fallback == "astar" and not evaluator.problem.as_paper:
            # A second search of astar would find the same; ga-chip may have made the first one.
            has_searched = self.planner == SEARCHERS[0] or SEARCHERS[0] in result.seconds
            searchers = SEARCHERS[1:] if has_searched else SEARCHERS
        try:
            found = connect(evaluator, searchers=searchers, best=result.evaluation, stop=stop)
            better = found.result
            if improves and better is not None and found.reason is None:
                better = improved(evaluator, better, self.options.seed, stop)
        except KeyboardInterrupt:
            if stop is None or not stop.requested:
                raise
            return dataclasses.replace(plan, result=interrupted(result))
        finally:
            if stop is not None:
                stop.heeded = True
        if found.reason is None and better is not None:
            better = with_path_of(result, better)
            return dataclasses.replace(plan, result=better, fallback=found.planner)
        if stop is not None and stop.requested:
            return dataclasses.replace(plan, result=interrupted(result))
        return dataclasses.replace(plan, reason=found.reason)
