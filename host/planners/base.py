"""The common part of all planners: options, stop criteria, record of a run, final choice."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluation, Evaluator
from pathgene.host.numeric import integer, real
from pathgene.host.planners.choice import choose


__all__ = [
    "Observer",
    "Options",
    "Planner",
    "Progress",
    "Replanner",
    "Result",
    "Run",
    "Stop",
]

Path = NDArray[np.float64]

# Candidates kept for the final choice: if the best path grazes the ground between samples, hundreds
# of nearly equal paths do so too.
_ARCHIVE_SIZE = 4096


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of every planner.

    Parameters
    ----------
    generations : int
        Maximum number of generations, 1 or more.
    time_limit_s : float, optional
        Maximum seconds of planning, above 0; the current generation is finished.
    population : int, optional
        Paths in the population; the planner's own number by default.
    seed : int
        0..2**64 - 1. All random draws follow from it.

    Raises
    ------
    InputError
        If a value is not such a number or is outside its range.
    """

    generations: int = 300
    time_limit_s: float | None = None
    target_fitness: float | None = None
    population: int | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        for field_name, name, number in (
            ("generations", "number of generations", integer),
            ("time_limit_s", "time limit", real),
            ("target_fitness", "target fitness", real),
            ("population", "population", integer),
            ("seed", "seed", integer),
        ):
            value = getattr(self, field_name)
            if value is not None or field_name in ("generations", "seed"):
                object.__setattr__(self, field_name, number(name, value))
        if self.generations < 1:
            raise InputError(
                f"The number of generations must be 1 or more, not {self.generations}."
            )
        if self.time_limit_s is not None and not 0 < self.time_limit_s < math.inf:
            raise InputError(
                f"The time limit must be a positive number of seconds, not {self.time_limit_s:g}."
            )
        if self.target_fitness is not None and not math.isfinite(self.target_fitness):
            raise InputError(
                f"The target fitness must be a finite number, not {self.target_fitness:g}."
            )
        if not 0 <= self.seed < 1 << 64:
            raise InputError(f"The seed must be from 0 to 2**64 - 1, not {self.seed}.")


class Stop:
    """A request to end, from a signal, another thread or a callback.

    A signal handler that raises :class:`KeyboardInterrupt` after the request also ends the current
    generation, which may take a long time to wait for a board.

    Parameters
    ----------
    cancelled : callable, optional
        Requests the end by returning True; called between generations, from the thread
        that plans.

    Attributes
    ----------
    heeded : bool
        True once the planner has ended its search, and is about to return the best path.
    """

    def __init__(self, cancelled: Callable[[], bool] | None = None) -> None:
        self._cancelled = cancelled
        self._requested = False
        self.heeded = False

    @property
    def requested(self) -> bool:
        """True once the end has been requested."""
        if not self._requested and self._cancelled is not None:
            self._requested = bool(self._cancelled())
        return self._requested

    def request(self) -> None:
        """Ask the planner to return after the current generation."""
        self._requested = True


#: Called after each generation with its number, the best fitness found and the mean fitness.
Progress = Callable[[int, float, float], object]


@runtime_checkable
class Observer(Protocol):
    """A :data:`Progress` that also receives the best path."""

    def __call__(self, generation: int, best: float, mean: float) -> object:
        """Receive a generation, like any :data:`Progress`."""

    def improved(self, path: Path) -> object:
        """Receive the best path found, (n, 3) metres; called before the generation that has it."""


class Replanner(Protocol):
    """Plans a changed problem from the state in which an earlier run ended."""

    @property
    def is_ready(self) -> bool:
        """False if the state of the earlier run is lost."""
        ...

    def replan(self, evaluator: Evaluator, options: Options) -> Result:
        """Search for the best path of ``evaluator.problem``; see :meth:`Planner.plan`.

        Terrain, goal, aircraft and rules are the same as in the earlier problem; the start may have
        moved, and zones may have been added.
        """
        ...

    def finish(self) -> None:
        """Do the work that a replan deferred; otherwise the next replan does it."""
        ...


@dataclass(frozen=True)
class Result:
    """The result of a planner, and the record of its run.

    Parameters
    ----------
    path : ndarray
        The path that :func:`pathgene.host.planners.choice.choose` has chosen, (n, 3) float64
        metres, start and goal included.
    history : list of [int, float, float]
        Generation, best fitness found, mean fitness of the population; starts at generation 0.
    generations, evaluations : int
        Number of generations and of evaluations.
    stopped_by : str
        ``generations``, ``time-limit``, ``target-fitness``, ``interrupt`` or ``failure``.
    failure : str or None
        The reason why the run could not continue, in a sentence.
    seconds : dict of str to float
        Wall time by phase; ``total`` is the whole run.
    hardware : dict or None
        Counters of the chip; see the planner.
    archive : list of (float, ndarray)
        Fitness and path of the best distinct candidates, best first.
    history_evaluations : list of int
        Cumulative evaluations at each entry of ``history``.
    cut_short : int
        Number of candidates, in addition to ``evaluations``, that were abandoned during their
        evaluation because they could not be better than the paths they were to replace.
    replanner : Replanner or None
        Continues from this run, or None if the run cannot be continued.
    """

    path: Path
    evaluation: Evaluation
    history: list[list[float]]
    generations: int
    evaluations: int
    stopped_by: str
    failure: str | None
    seconds: dict[str, float]
    hardware: dict[str, Any] | None
    archive: list[tuple[float, Path]]
    history_evaluations: list[int] = field(default_factory=list)
    cut_short: int = 0
    replanner: Replanner | None = None

    @property
    def interrupted(self) -> bool:
        """True if the user ended the run."""
        return self.stopped_by == "interrupt"


class Planner(Protocol):
    """Plans paths; made by :func:`pathgene.host.planners.make`."""

    def plan(
        self,
        evaluator: Evaluator,
        options: Options,
        progress: Progress | None = None,
        stop: Stop | None = None,
    ) -> Result:
        """Search for the best path of ``evaluator.problem``.

        Raises
        ------
        InputError
            If the planner does not support the options.
        JobError
            If the run fails before the first evaluation.
        """


@dataclass
class Run:
    """The record of one run: times phases, counts, keeps candidates, says when to stop.

    Parameters
    ----------
    progress : callable, optional
        Called after each generation; see :data:`Progress`.
    ended_by : str, optional
        The stop criterion that ended the search, for a run that waits for parallel runs.
    """

    evaluator: Evaluator
    options: Options
    progress: Progress | None = None
    stop: Stop | None = None
    evaluations: int = 0
    cut_short: int = 0
    history: list[list[float]] = field(default_factory=list)
    history_evaluations: list[int] = field(default_factory=list)
    failure: str | None = None
    hardware: dict[str, Any] | None = None
    ended_by: str | None = None

    def __post_init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._archive: dict[bytes, tuple[float, Path]] = {}
        # The strict rule has judged all kept paths.
        self._is_strict = not self.evaluator.problem.as_paper
        self._best = -math.inf
        self._best_path: Path | None = None
        self._worst_kept = -math.inf
        self._started = time.perf_counter()
        self._compiled_s = _compiling_s()
        self._observer: Observer | None = None
        # A check against a protocol takes a tenth of a millisecond.
        if self.progress is not None and isinstance(self.progress, Observer):
            self._observer = self.progress

    @contextlib.contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Add the time of the block, except for compilations, to phase ``name``."""
        started, compiled = time.perf_counter(), _compiling_s()
        try:
            yield
        finally:
            spent = time.perf_counter() - started - (_compiling_s() - compiled)
            self.seconds[name] = self.seconds.get(name, 0.0) + spent

    def fitness(
        self,
        paths: Sequence[Path],
        *,
        counted_m: NDArray[np.float64] | None = None,
        strict: bool = False,
    ) -> NDArray[np.float64]:
        """Evaluate ``paths``, (n, 3) float64 metres each, ends included, and keep the best.

        With ``strict``, the fitness follows the strict rule, which may accept paths below the
        search surface. With ``counted_m``, (m,) metres, these are d_ut + d_nf, and no path is kept:
        a path whose distances were counted elsewhere is not a candidate before its full evaluation.

        Returns
        -------
        ndarray
            Fitness of each, (m,) float64.
        """
        with self.phase("evaluation"):
            lengths = np.array([len(path) for path in paths], dtype=np.int64)
            padded = np.zeros((len(paths), int(lengths.max()), 3))
            for row, path in zip(padded, paths, strict=True):
                row[: len(path)] = path
            if counted_m is None:
                fitness = self.evaluator.fitness(padded, lengths, strict=strict)
            else:
                fitness = self.evaluator.fitness_counted(padded, lengths, counted_m)
        self.evaluations += len(paths)
        if counted_m is None:
            is_strict = self._is_strict and strict
            self.keep(paths, fitness)
            self._is_strict = is_strict
        return fitness

    def keep(self, paths: Iterable[Path], fitness: NDArray[np.float64]) -> None:
        """Keep the best of ``paths``, (n, 3) metres each, whose ``fitness`` (m,) is known.

        The caller must not change a path afterwards.
        """
        self._is_strict = False
        for value, path in zip(fitness.tolist(), paths, strict=True):
            if value > self._best or (value > 1 and value > self._worst_kept):
                self._keep(value, path)

    def _keep(self, value: float, path: Path) -> None:
        if value > self._best:
            if self._best <= 1:  # The kept paths are worse and cannot be feasible.
                self._archive.clear()
            self._best, self._best_path = value, path
        self._archive[path.tobytes()] = value, path
        if len(self._archive) >= 2 * _ARCHIVE_SIZE:
            best = sorted(self._archive.items(), key=lambda item: -item[1][0])[:_ARCHIVE_SIZE]
            self._archive = dict(best)
            self._worst_kept = best[-1][1][0]

    def record(self, generation: int, fitness: NDArray[np.float64]) -> None:
        """Record the fitness of the whole population (m,) after ``generation``."""
        self.note(generation, float(fitness.mean()))

    def note(self, generation: int, mean: float) -> None:
        """Record a generation by the mean fitness of its population."""
        self.history.append([generation, self._best, mean])
        self.history_evaluations.append(self.evaluations)
        if self._observer is not None and self._best_path is not None:
            self._observer.improved(self._best_path)
            self._best_path = None
        if self.progress is not None:
            self.progress(generation, self._best, mean)

    def show(self, generation: int) -> None:
        """Report progress after ``generation`` without recording anything."""
        if self.progress is not None:
            self.progress(generation, *self.history[-1][1:])

    def stopped_by(self) -> str | None:
        """Return the first stop criterion met, or None to continue."""
        if self.stop is not None and self.stop.requested:
            return "interrupt"
        if self.failure is not None:
            return "failure"
        if (target := self.options.target_fitness) is not None and self._best >= target:
            return "target-fitness"
        if self.history and self.history[-1][0] >= self.options.generations:
            return "generations"
        return "time-limit" if self.out_of_time else None

    @property
    def remaining_s(self) -> float | None:
        """Seconds until the time limit, 0 or less once it has passed; None without a limit."""
        limit = self.options.time_limit_s
        return None if limit is None else limit - (time.perf_counter() - self._started)

    @property
    def out_of_time(self) -> bool:
        """True once the time limit has passed."""
        return self.remaining_s is not None and self.remaining_s <= 0

    @contextlib.contextmanager
    def search(self) -> Iterator[None]:
        """Run the generations in the block; after a requested stop, an interrupt ends the block.

        Without a generation 0 there is no result, and the interrupt is raised again.
        """
        try:
            yield
        except KeyboardInterrupt:
            if self.stop is None or not self.stop.requested or not self.history:
                raise
        finally:
            if self.stop is not None:
                self.stop.heeded = True

    @property
    def candidates(self) -> list[tuple[float, Path]]:
        """The kept paths with their fitness, best first."""
        return sorted(self._archive.values(), key=lambda kept: -kept[0])

    def result(self) -> Result:
        """Choose the path to report; return it with the record."""
        reason = self.ended_by or self.stopped_by() or "generations"
        archive = self.candidates
        with self.phase("choice"):
            path = archive[0][1]
            if self._is_strict:
                evaluation = self.evaluator.evaluate(path)
            else:
                path, evaluation = choose(self.evaluator, archive)
        self.seconds["compiling"] = _compiling_s() - self._compiled_s
        self.seconds["total"] = time.perf_counter() - self._started
        return Result(
            path,
            evaluation,
            self.history,
            int(self.history[-1][0]) if self.history else 0,
            self.evaluations,
            reason,
            self.failure,
            self.seconds,
            self.hardware,
            archive,
            self.history_evaluations,
            self.cut_short,
        )


def _compiling_s() -> float:
    # Loads numba, which listing the planners does not need.
    from pathgene.jit import compiling_s

    return compiling_s()
