"""Design choices of the planner core, changed one at a time, and their effects in 10 ms."""

from __future__ import annotations

from dataclasses import replace
from statistics import mean

from bench.campaign import Alteration
from bench.chip_runs import CHIP, Task, run_all, share, terrains, through_terrains
from bench.report import Options, Report
from bench.scenarios import missing
from pathgene.hdl.config import Config
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.errors import InputError


#: Cycles of a run: 10 ms.
_CYCLES = CHIP.clock_hz // 100
#: Paper mode, then clearances in metres.
_CLEARANCES = (None, 30.0, 100.0)
_USUAL = RunOptions(cycles=_CYCLES)

_BREEDER = "pathgene.sim.model.planner.breeder"
_PROTOCOL = "pathgene.hdl.protocol.planner"
_BREEDING = "pathgene.hdl.protocol.breeding"
_TWICE = """mutate(problem, sizes, child, length, words)
        step(words)
        if field(words, 1, *CUT) == 0:
            points[slot] = mutate(problem, sizes, child, points[slot], words)"""

#: The options of each row, or its chip, or its change of the definition.
CHANGES: dict[str, RunOptions | Config | Alteration] = {
    "none": _USUAL,
    "no memo": replace(_USUAL, memo=0),
    "a memo of 64 rows": replace(_USUAL, memo=64),
    "a memo of 2,048 rows": replace(_USUAL, memo=2048),
    "give up at rank 3": replace(_USUAL, give_up_rank=3),
    "give up at rank 15": replace(_USUAL, give_up_rank=15),
    "no lifts": replace(_USUAL, lifts=0),
    "one pass of lifts": replace(_USUAL, lifts=1),
    "four passes of lifts": replace(_USUAL, lifts=4),
    "slopes 2 and 5": replace(_USUAL, slopes=(2, 5)),
    "one island": replace(_USUAL, slopes=(3,)),
    "a quarter of the time on islands": replace(_USUAL, share=4),
    "three quarters of the time on islands": replace(_USUAL, share=12),
    "64 seeds for each route": replace(_USUAL, seeds=64),
    "up to 16 waypoints": CHIP.replace(max_waypoints=16),
    "up to 18 waypoints": CHIP.replace(max_waypoints=18),
    "altitudes of 11 bits": CHIP.replace(altitude_bits=11),
    "altitudes of 9 bits": CHIP.replace(altitude_bits=9),
    "4 lanes": CHIP.replace(lanes=4),
    "16 lanes": CHIP.replace(lanes=16),
    "4 elites and 6 survivors": CHIP.replace(elites=4, survivors=6),
    "24 children and 6 survivors": CHIP.replace(children=24, survivors=6),
    "parents cut at their middles": Alteration(
        _BREEDER, "cut = 2 * field(words, 1, *CUT) + 1", "cut = 4"
    ),
    "parents the best of 2 draws": Alteration(_BREEDING, "PARENT_DRAWS = 4", "PARENT_DRAWS = 2"),
    "parents the best of 3 draws": Alteration(_BREEDING, "PARENT_DRAWS = 4", "PARENT_DRAWS = 3"),
    "no settling": Alteration(_BREEDING, "8, 11, 14, 18", "8, 11, 14, 14"),
    "no insertion, no deletion": Alteration(_BREEDING, "8, 11, 14, 18", "8, 8, 8, 12"),
    "moves in the whole box": Alteration(_BREEDER, "(offset >> shift)", "offset"),
    "a quarter of the children mutated twice": Alteration(
        _BREEDER, "mutate(problem, sizes, child, length, words)", _TWICE
    ),
    "chords not walked": Alteration(
        "pathgene.sim.model.planner.evaluation", "or not work[HAS_CHORD, at]", "or True"
    ),
    "a steep segment counts a cell": Alteration(
        _PROTOCOL, "1 << POSITION_FRACTION - 2", "1 << POSITION_FRACTION"
    ),
    "routes over 32 x 32 blocks": Alteration(
        _PROTOCOL, "BLOCKS, COARSE_BLOCKS = 64, 32", "BLOCKS, COARSE_BLOCKS = 32, 32"
    ),
    "no seeds at the turns": Alteration(
        "pathgene.sim.model.planner.run", "if i == 0 and not is_straight:", "if False:"
    ),
    "seeds of up to 8 waypoints": Alteration(
        _PROTOCOL, "SEED_WAYPOINTS = 4, 16", "SEED_WAYPOINTS = 4, 8"
    ),
}


def run(options: Options) -> Report:
    """Run every row over all terrains and clearances."""
    chosen = {name: change for name, change in CHANGES.items() if options.only in name}
    if not chosen:
        raise InputError(
            f"No row has {options.only!r} in its name; there are {', '.join(CHANGES)}."
        )
    seeds = min(options.seeds, 10)
    report = Report(
        f"Choices of the planner core: {seeds} seeds, 10 ms at 100 MHz with 8 lanes",
        (
            "change",
            "paper mode",
            "feasible",
            "30 m",
            "feasible, 30 m",
            "100 m",
            "feasible, 100 m",
            "generations",
            "cycles per generation",
        ),
        notes=[
            "Mean over the terrains of the mean F of the feasible paths, unpolished, a run per "
            "seed; how many runs have a feasible path. Generations and cycles: paper mode.",
            *missing(),
        ],
    )
    for name, change in chosen.items():
        usual = change if isinstance(change, RunOptions) else _USUAL
        config = change if isinstance(change, Config) else CHIP
        alteration = change if isinstance(change, Alteration) else None
        tasks = [
            Task(terrain, clearance_m, (replace(usual, seed=seed),), config)
            for clearance_m in _CLEARANCES
            for terrain in terrains()
            for seed in range(seeds)
        ]
        found = dict(zip(tasks, run_all(tasks, alteration), strict=True))
        cells: list[object] = [name]
        for clearance_m in _CLEARANCES:
            of_terrains = [
                [
                    found[task]
                    for task in tasks
                    if (task.terrain, task.clearance_m) == (terrain, clearance_m)
                ]
                for terrain in terrains()
            ]
            means, all_means = through_terrains(of_terrains)
            every = [outcome for some in of_terrains for outcome in some]
            cells += [all_means, share(every)]
            report.data.setdefault(name, {})[str(clearance_m)] = means
            if clearance_m is None:
                generations = mean(outcome.generations for outcome in every)
                per_generation = sum(each.cycles for each in every) / sum(
                    each.generations for each in every
                )
        report.rows.append((*cells, round(generations), round(per_generation)))
    return report
