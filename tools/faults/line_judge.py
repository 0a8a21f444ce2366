"""Sessions of a host with a board, over a line with faults."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import encode_frame
from pathgene.hdl.protocol.codes import Command, LinkMode, Status
from pathgene.hdl.protocol.runs import WARM_SLOPES, RunOptions
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link, LinkError, LinkTimeoutError, RefusedError
from pathgene.host.errors import JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.chip.problem_on_chip import ProblemOnChip
from pathgene.host.problem.corner_map import CornerMap
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle
from pathgene.host.terrain import Terrain
from tools.faults.case import Case, Extent
from tools.faults.chips import Board, chip_on_line
from tools.faults.judge import DifferentError, Judge, Verdict
from tools.faults.line import ChipOnLine, FaultyLine, LineFault, VirtualClock
from tools.faults.tracing import counted_lines, signal_of, signalled


#: Number of generations in each link mode.
GENERATIONS = 50
#: Number of generations between two checks of the whole population.
_PER_CHECK = 10
#: Works in which the chip also refuses requests, and in which the whole map is blocked at the end.
_REFUSED = (3, 7)
#: Maximum number of polls until a run must be over on a line without faults.
_MOST_LOOKS = 10_000

#: Takes each result; any value that can be compared.
Tell = Callable[[Any], None]
Session = Callable[[Chip, int, Tell], None]


def ground(config: Config, seed: int) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Return hills for the whole map of a chip, with blocked cells, [y, x] altitude steps."""
    rng = np.random.default_rng(seed)
    size = config.map_size
    x, y = np.meshgrid(np.arange(size), np.arange(size))
    waves = np.sin(x * 9 / size + rng.uniform(0, 6)) * np.cos(y * 7 / size + rng.uniform(0, 6))
    heights = ((waves + 1) / 4 * config.blocked_altitude).astype(np.int64)
    heights[rng.random(heights.shape) < 0.02] = config.blocked_altitude
    return heights


def _breed(chip: Chip, seed: int, tell: Tell) -> None:
    """Use the paper core: map, generations in each mode, counts, reads."""
    config = chip.config
    rng = random.Random(seed)
    is_refused = seed in _REFUSED
    heights = ground(config, seed)
    tell("map")
    chip.update_map(heights)
    start, goal = (rng.getrandbits(config.waypoint_bits) for _ in range(2))
    for mode in LinkMode:
        tell(mode.name)
        highest = config.map_size - 1
        chip.start(rng.getrandbits(64), (highest, highest, config.blocked_altitude - 1))
        chip.load(
            [
                [
                    rng.getrandbits(config.waypoint_bits)
                    for _ in range(rng.randint(config.MIN_WAYPOINTS, config.max_waypoints))
                ]
                for _ in range(config.population)
            ]
        )
        for generation in range(GENERATIONS):
            step = chip.step(rng.sample(range(config.population), config.population), mode)
            # In population mode, the origin is only known if a long reply was given up.
            tell((step.paths, None if mode is LinkMode.POPULATION else step.origin))
            if is_refused:
                tell(_refusal(chip))
            if generation % _PER_CHECK == 0:
                found = chip.check_population(start, goal, counting=bool(rng.getrandbits(1)))
                tell((found.verdicts, found.cells))
        tell(chip.read(0, config.population))
        x, y = rng.randrange(config.map_size - 2), rng.randrange(config.map_size - 3)
        heights[y : y + 3, x : x + 2] = rng.randrange(config.blocked_altitude + 1)
        chip.update_map(heights)
        verdict = chip.check_path([start, *step.paths[0], goal], counting=True)
        tell((verdict.verdicts, verdict.cells))
    tell(chip.status()["generation"])


def _refusal(chip: Chip) -> int:
    """Send a request that the chip refuses; return the status. The session stays open."""
    try:
        chip.link.request(Command.READ, bytes((0, 0)))
    except RefusedError as error:
        return error.status
    return Status.OK


@cache
def problem(seed: int) -> Problem:
    """Return a flight over hills of 60 x 60 cells."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(60), np.arange(60))
    hills = 300 + 120 * np.sin(x / 9 + rng.uniform(0, 6)) * np.cos(y / 8 + rng.uniform(0, 6))
    terrain = Terrain(name="hills", elevation=hills, dx_m=100.0, dy_m=100.0)
    return Problem(terrain, (500, 600, 120), (5400, 5300, 120), agl=True, as_paper=True)


def _plan(chip: Chip, seed: int, tell: Tell) -> None:
    """Use the planner core: a run, a zone that appears, a run from the previous population."""
    config = chip.config
    rng = random.Random(seed)
    flight = problem(seed)
    task = ProblemOnChip(chip, flight, CornerMap(config, flight))
    tell("map")
    path = _run(task, _cold(rng), tell)
    task = task.changed(_with_zone(flight, path))
    tell("zone")
    warm = RunOptions(
        seed=rng.getrandbits(64),
        cycles=1_000_000,
        generations=30,
        slopes=WARM_SLOPES,
        seeds=8,
        give_up_rank=3,
        share=5,
        warm=True,
        paths=2,
        memo=64,
    )
    _run(task, warm, tell)
    if seed in _REFUSED:
        # The chip has to get every corner that it has not drawn itself.
        chip.update_map(np.full((config.map_size,) * 2, config.blocked_altitude))


def _plan_last(chip: Chip, seed: int, tell: Tell) -> None:
    """Use the planner core for the second problem of :func:`_plan` alone."""
    flight = _last_problem(seed)
    task = ProblemOnChip(chip, flight, CornerMap(chip.config, flight))
    _run(task, _cold(random.Random(seed)), tell)


@cache
def _last_problem(seed: int) -> Problem:
    """Return the second problem of :func:`_plan`, which depends on its first path."""
    flight = problem(seed)
    with chip_on_line(Board.MODEL, "planner") as chip:
        line = FaultyLine(chip, VirtualClock())
        with Chip(Link(line, clock=line.clock)) as opened:
            task = ProblemOnChip(opened, flight, CornerMap(opened.config, flight))
            return _with_zone(flight, _run(task, _cold(random.Random(seed)), lambda _: None))


def _with_zone(flight: Problem, path: Any) -> Problem:
    """Return the flight with a zone in the middle of a path."""
    middle = path[len(path) // 2]
    return Problem(
        flight.terrain,
        flight.start,
        flight.goal,
        zones=(Circle(float(middle[0]), float(middle[1]), 300.0),),
        as_paper=True,
    )


def _cold(rng: random.Random) -> RunOptions:
    """Return the options of a run from an empty population."""
    return RunOptions(
        seed=rng.getrandbits(64),
        cycles=1_000_000,
        generations=rng.randint(20, 60),
        seeds=16,
        give_up_rank=3,
        paths=4,
        memo=64,
    )


def _run(task: ProblemOnChip, options: RunOptions, tell: Tell) -> Any:
    """Execute a run, report the chip's replies and the host's verdict; return the best path."""
    looks = iter(range(_MOST_LOOKS))
    evaluator = Evaluator(task.problem, threads=1)
    status, best = task.run(options, lambda _: next(looks, None) is None)
    paths = [task.metres(path) for path in best.paths]
    fitness = [evaluator.evaluate(path).fitness for path in paths]
    # The cycles depend on how much of the map has changed since the previous run.
    tell((status.generations, status.key, best.keys, best.paths, fitness))
    return paths[0]


#: Sessions by the beginning of the name of their chip.
SESSIONS: dict[str, Session] = {"paper": _breed, "planner": _plan}


#: Patience of a link, in seconds and attempts: for the model, which answers immediately, and for
#: the Verilog.
_PATIENCE = {Board.MODEL: (0.25, 12), Board.SIM: (0.03, 12)}
#: Packages of ``host`` whose lines Ctrl-C may meet.
_PACKAGES = ("device",)

#: Answers to INFO, OPEN and the first command.
_ANSWERS_TO_OPEN = 3

#: Maximum number of damaged bytes and frames after which no error is excused: the link repeats a
#: command 12 times, and each damage costs it one or two of them.
_EXCUSED = 4
#: Milliseconds without a byte that the patience of a link bridges.
_BRIDGED_MS = {Board.MODEL: 1_500, Board.SIM: 300}

Told = list[Any]


class _Comparison:
    """Compares the messages of a session with its messages without faults."""

    def __init__(self, told: Told) -> None:
        self._told, self._at = told, 0

    def __call__(self, value: Any) -> None:
        """Compare the next value."""
        if self._at == len(self._told) or value != self._told[self._at]:
            raise DifferentError(f"result {self._at} is another than without faults")
        self._at += 1

    def end(self) -> None:
        """Check that nothing is missing."""
        if self._at < len(self._told):
            raise DifferentError(f"{len(self._told) - self._at} results are missing")


class _Usual(NamedTuple):
    """A session without faults."""

    told: Told
    #: The memory of the chip at its end.
    memory: bytes
    extent: Extent


class LineJudge(Judge):
    """Judges sessions with a kind of board; keeps their messages without faults.

    A session must end as it does without faults, with a documented error, or by Ctrl-C. Replies
    received before the end must equal the replies without faults, and so must the memory of the
    chip after a whole session. An error needs a fault that the link cannot bridge. After that,
    another session does the whole work over a line without faults.
    """

    def __init__(self, board: Board) -> None:
        self.board = board
        self._kept: dict[tuple[str, int, Session], _Usual] = {}

    def extent(self, session: str, work: int) -> Extent:
        """Return how long a session is without faults."""
        if session == "planner":
            self._without_faults(session, work, _plan_last)
        return self._without_faults(session, work, _session(session)).extent

    def run(self, case: Case, verdict: Verdict) -> None:
        """Run a session; see :class:`tools.faults.judge.Judge`."""
        with chip_on_line(self.board, case.session) as chip:
            self._run(case, chip, verdict)

    def _run(self, case: Case, chip: ChipOnLine, verdict: Verdict) -> None:
        for number in range(1, case.sessions_before + 1):
            chip.feed(encode_frame(bytes((number % 256, 255, Command.OPEN))))
        line, link = self._connect(chip, case)
        if case.sessions_before == 1:
            # The earlier host's last answer is still under way.
            line.hold(chip.feed(encode_frame(bytes((1, 0, Command.COUNTERS)))), _ANSWERS_TO_OPEN)
        opened: Chip | None = None
        try:
            with signalled(case.signal_at, _PACKAGES) as sent:
                opened = Chip(link)
                self._do(opened, case, chip)
            if sent:
                raise DifferentError(f"{sent[0].name} had no effect")
        except KeyboardInterrupt:
            verdict.outcome = "interrupted"
        except JobError as error:
            if not self._excuse(case, line):
                raise
            verdict.outcome = type(error).__name__
            self._check_patience(error, case, line)
            if opened is not None:
                _check_end(opened, chip)
        verdict.faults.update(event.fault.value for event in line.happened)
        verdict.faults["clock jump"] += len(case.jumps)
        if case.signal_at is not None:
            verdict.faults[signal_of(case.signal_at).name] += 1
        if opened is not None and case.resumes and verdict.outcome != "done":
            line.heal()
            try:
                if case.seed % 3:
                    opened.reopen()  # Otherwise update_map() does.
                    _check_corner(opened, chip)
                    _check_paths(opened, chip)
                if case.session == "planner":
                    # The problem whose map may have been under way.
                    self._do(opened, case, chip, _plan_last)
                self._do(opened, case, chip)
                verdict.outcome += ", resumed"
            except JobError:
                if _can_resume(case, line):
                    raise
                verdict.outcome += ", not resumed"
        link.close()

        verdict.faults += Counter()  # Without zeros.
        _, link = self._connect(chip)
        with Chip(link) as later:
            self._do(later, case, chip)

    def _connect(self, chip: ChipOnLine, case: Case | None = None) -> tuple[FaultyLine, Link]:
        timeout_s, attempts = _PATIENCE[self.board]
        clock = VirtualClock(dict(case.jumps) if case else None)
        events = case.line if case else ()
        line = FaultyLine(chip, clock, events, patience_s=1.5 * attempts * timeout_s)
        return line, Link(line, timeout_s=timeout_s, attempts=attempts, clock=clock)

    def _excuse(self, case: Case, line: FaultyLine) -> bool:
        """Return whether the faults that have happened may end a session with an error."""
        lasting = (LineFault.STALL, LineFault.FULL, LineFault.GAP)
        return len(line.happened) + len(case.jumps) > _EXCUSED or any(
            event.fault in (LineFault.RESET, LineFault.CUT, LineFault.BABBLE)
            or (event.fault in lasting and event.value > _BRIDGED_MS[self.board])
            for event in line.happened
        )

    def _check_patience(self, error: JobError, case: Case, line: FaultyLine) -> None:
        """Check that a link that gives up has waited, and has repeated its commands."""
        is_full = any(event.fault is LineFault.FULL for event in line.happened)
        if not isinstance(error, LinkTimeoutError) or is_full or case.jumps:
            return
        timeout_s, attempts = _PATIENCE[self.board]
        waited_s = line.clock.now_s - line.watch.answered_s
        if waited_s < 0.99 * attempts * timeout_s:
            raise DifferentError(f"given up {waited_s:.2g} s after an answer")
        if line.watch.asked < attempts - 1:
            raise DifferentError(f"given up after {line.watch.asked} frames without an answer")

    def _do(
        self, opened: Chip, case: Case, chip: ChipOnLine, session: Session | None = None
    ) -> None:
        """Execute a session; a refusal is not a documented end, because all requests are valid."""
        session = session or _session(case.session)
        usual = self._without_faults(case.session, case.work, session)
        comparison = _Comparison(usual.told)
        try:
            session(opened, case.work, comparison)
        except RefusedError as error:
            raise DifferentError(f"the chip refused what was right: {error}") from None
        comparison.end()
        if chip.memory() != usual.memory:
            raise DifferentError("the chip has another map or population than without faults")

    def _without_faults(self, name: str, work: int, session: Session) -> _Usual:
        if (name, work, session) not in self._kept:
            told: Told = []
            with chip_on_line(self.board, name) as chip:
                line, link = self._connect(chip)
                with counted_lines(_PACKAGES) as lines, Chip(link) as opened:
                    session(opened, work, told.append)
                memory = chip.memory()
            watch = line.watch
            commands = tuple(tuple(places) for places in watch.commands.values())
            extent = Extent(line.sent, line.clock.readings, lines[0], tuple(watch.firsts), commands)
            self._kept[name, work, session] = _Usual(told, memory, extent)
        return self._kept[name, work, session]


def _check_end(opened: Chip, chip: ChipOnLine) -> None:
    """Check the host after an error: it has no session, and knows that a run may have begun."""
    try:
        opened.status()
    except LinkError:
        pass
    else:
        raise DifferentError("the session continues after an error")
    if chip.has_run() and not opened.runs.started:
        raise DifferentError("the host has not counted a run")


def _check_paths(opened: Chip, chip: ChipOnLine) -> None:
    """Check that the host knows the population, or knows that it does not."""
    right = chip.paths()
    if right is not None and opened.paths != right:
        raise DifferentError("the host's copy of the population is another than the chip's")


def _check_corner(opened: Chip, chip: ChipOnLine) -> None:
    """Check that the chip gets the height of a corner of the map."""
    for height in (1, 2):
        opened.upload_map(np.array([[height]]))
        memory = chip.memory()
        if memory and memory[0] != height:
            raise DifferentError("the chip has another map than the host has sent")


def _session(name: str) -> Session:
    return SESSIONS[name.split(",")[0]]


def _can_resume(case: Case, line: FaultyLine) -> bool:
    """Return whether nothing has happened that excuses a board that is not taken back."""
    faults = {event.fault for event in line.happened}
    # The session after the last one is not numbered.
    return not faults & {LineFault.RESET, LineFault.CUT} and case.sessions_before < 254
