"""The collision checker on the terrains of the scenarios: random paths and evolved paths.

Every build checks every path on the simulated gateware, both stopping at the first collision and
counting all collisions, and every result is compared with the software model's.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import mean

import numpy as np

from bench.campaign import measure
from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import missing, names, problem
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.protocol.codes import LinkMode
from pathgene.host.device.boards import open_board
from pathgene.host.device.chip import Chip, Step
from pathgene.host.device.link import Link
from pathgene.host.device.paths import unpack_waypoints
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import make
from pathgene.host.planners.base import Options
from pathgene.host.problem.chip_map import ChipMap
from pathgene.sim.harness import CheckerBatch, VerilatedChecker
from pathgene.sim.model.checker import Point, TerrainModel, Verdict
from pathgene.sim.model.checker_kernels import check_paths


#: Every build, with its cells per cycle.
BUILDS = ((CheckerBuild.TWO_TIER, 1), (CheckerBuild.PARALLEL, 8))
_PATHS = 10_000
_RANDOM_SEED = 2011
_GENERATIONS = 300
_KINDS = ("random", "evolved")
_MODES = ("first hit", "count")

Path = Sequence[Point]


@dataclass(frozen=True)
class _Outcome:
    """Results of one build for all paths of one kind over one terrain, in one mode."""

    collisions: int
    cycles: int
    mismatches: int


#: Outcomes of each build, in each mode.
_Outcomes = Mapping[tuple[int, str], _Outcome]


class Ground:
    """The map of a scenario on the chip, and paths from its start to its goal."""

    def __init__(self, name: str) -> None:
        self._config = Config()
        self._problem = problem(name)
        grid = ChipMap(self._config, self._problem)
        self.heights = grid.heights
        self._limits = grid.limits
        ends = np.array([self._problem.start, self._problem.goal])
        self._start, self._goal = grid.to_cells(ends).tolist()

    def terrain(self, config: Config) -> TerrainModel:
        """Return the map as stored in the checker of ``config``."""
        terrain = TerrainModel(config)
        terrain.write(0, 0, self.heights)
        return terrain

    def random(self, paths: int, seed: int = _RANDOM_SEED) -> list[Path]:
        """Return paths of 2 to 16 waypoints, uniform over the terrain's cells and altitudes."""
        rng = np.random.default_rng(seed)
        fewest, most = self._config.MIN_WAYPOINTS, self._config.max_waypoints
        return [
            self._with_ends(rng.integers(0, self._limits, (waypoints, 3), endpoint=True).tolist())
            for waypoints in rng.integers(fewest, most, paths, endpoint=True)
        ]

    def evolved(self, paths: int) -> tuple[list[Path], int]:
        """Return the first distinct paths that ga-fpga breeds, and the number of seeds needed.

        The seeds are 0, 1, 2 and so on, with 300 generations each on the software model.
        """
        evaluator = Evaluator(self._problem, threads=1)
        seen: dict[tuple[int, ...], None] = {}
        planner = make("ga-fpga", open_board=lambda url: _Recorder(open_board(url).link, seen))
        for seed in itertools.count():
            if len(seen) >= paths:
                break
            planner.plan(evaluator, Options(seed=seed, generations=_GENERATIONS))
        first = itertools.islice(seen, paths)
        inner = (unpack_waypoints(self._config, chromosome).tolist() for chromosome in first)
        return [self._with_ends(waypoints) for waypoints in inner], seed

    def _with_ends(self, waypoints: list[Point]) -> Path:
        return [self._start, *waypoints, self._goal]


class _Recorder(Chip):
    """A chip that records the distinct chromosomes of all generations, in order."""

    def __init__(self, link: Link, seen: dict[tuple[int, ...], None]) -> None:
        super().__init__(link)
        self._seen = seen

    def step(self, order: Sequence[int], mode: LinkMode = LinkMode.RANK) -> Step:
        """Run one generation and record it."""
        done = super().step(order, mode)
        self._seen.update(dict.fromkeys(map(tuple, done.paths)))
        return done


def differing(
    batch: CheckerBatch, config: Config, terrain: TerrainModel, paths: Sequence[Path], count: bool
) -> list[int]:
    """Return the numbers of the paths whose results in ``batch`` differ from the model's.

    The results are verdict, first colliding segment and cell, cells, and every count.
    """
    said = [
        Verdict(
            collision=bool(verdict["collision"]),
            clear=not verdict["collision"],
            segment=verdict["segment"],
            x=verdict["x"],
            y=verdict["y"],
            coarse=bool(verdict["coarse"]),
            cells=verdict["cells"],
            entries=tuple(
                (entry["segment"], entry["terrain"], entry["nofly"]) for entry in entries
            ),
        )
        for verdict, entries in zip(batch.verdicts, batch.entries, strict=True)
    ]
    models = check_paths(config, terrain, paths, count)
    return [
        number for number, (own, model) in enumerate(zip(said, models, strict=True)) if own != model
    ]


def run(options: BenchOptions) -> Report:
    """Check 10,000 random and 10,000 evolved paths over every available terrain."""
    report = Report(
        f"Collision checker over real terrain, paper mode: mean cycles per path, {_PATHS:,} "
        "paths a row",
        (
            "terrain",
            "paths",
            "mode",
            "collide",
            "collide, two-tier",
            *(_title(number) for number in range(len(BUILDS))),
            "mismatches",
        ),
    )
    cases = list(itertools.product(names(), _KINDS))
    seeds: dict[str, int] = {}
    of_kind: dict[str, list[_Outcomes]] = {kind: [] for kind in _KINDS}
    checked = measure(
        "terrains", cases, _check, name=lambda case: f"{case[1]} paths over {case[0]}"
    )
    for (name, kind), (outcomes, used) in zip(cases, checked, strict=True):
        if used:
            seeds[name] = used
        of_kind[kind].append(outcomes)
        report.rows += [_row(name, kind, mode, [outcomes]) for mode in _MODES]
    report.rows += [
        _row("all", kind, mode, every) for kind, every in of_kind.items() for mode in _MODES
    ]
    report.notes = [
        "Terrains, zones, starts and goals as in BENCH=quality. Paths are queued. Random: 2 to 16",
        "waypoints between start and goal, uniform over the terrain's cells and all altitudes,",
        f"seed {_RANDOM_SEED}. Evolved: the first {_PATHS:,} distinct chromosomes of the",
        f"generations of ga-fpga on model:, {_GENERATIONS} generations of each seed from 0 to",
        f"{', '.join(f'{used - 1} ({name})' for name, used in seeds.items())}.",
        "Mismatches: results of any build that differ from the model's in verdict, first colliding",
        "cell, cells visited or counts; parallel against the full detailed check, two-tier",
        "against its own.",
        *missing(),
    ]
    report.data = {"random_seed": _RANDOM_SEED, "evolved_seeds": seeds}
    return report


def _title(number: int) -> str:
    build, lanes = BUILDS[number]
    return f"{build.value}, {lanes} lane{'s' if lanes > 1 else ''}"


def _check(name: str, kind: str) -> tuple[_Outcomes, int]:
    """Check the paths of one kind over one terrain; also return the seeds that bred them."""
    ground = Ground(name)
    paths, used = ground.evolved(_PATHS) if kind == "evolved" else (ground.random(_PATHS), 0)
    outcomes = {}
    for number, (build, lanes) in enumerate(BUILDS):
        config = Config(checker=build, lanes=lanes)
        terrain = ground.terrain(config)
        with VerilatedChecker(config) as checker:
            checker.write(ground.heights)
            for mode in _MODES:
                count = mode == "count"
                batch = checker.check(paths, count=count)
                outcomes[number, mode] = _Outcome(
                    collisions=sum(verdict["collision"] for verdict in batch.verdicts),
                    cycles=sum(verdict["cycles"] for verdict in batch.verdicts),
                    mismatches=len(differing(batch, config, terrain, paths, count)),
                )
    return outcomes, used


def _row(name: str, kind: str, mode: str, every: Sequence[_Outcomes]) -> tuple[object, ...]:
    """Return a row of means over one or more terrains."""
    of_build = [[outcomes[number, mode] for outcomes in every] for number in range(len(BUILDS))]
    tiered, detailed = (
        mean(outcome.collisions for outcome in outcomes) / _PATHS for outcomes in of_build
    )
    return (
        name,
        kind,
        mode,
        f"{detailed:.2%}",
        f"{tiered:.2%}",
        *(mean(outcome.cycles for outcome in outcomes) / _PATHS for outcomes in of_build),
        sum(outcome.mismatches for outcomes in of_build for outcome in outcomes),
    )
