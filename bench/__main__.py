"""``python -m bench [NAME ...]``: run benchmarks, print their tables, store them as JSON.

Each name in :data:`NAMES` is a module, with ``_`` for ``-``, that has ``run(options) -> Report``.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from dataclasses import replace
from pathlib import Path

from bench.pages import keep
from bench.report import Options
from pathgene.host.errors import PathgeneError


#: Every benchmark and its measurement.
NAMES = {
    "generation": "cycles of a generation, the paper's too, and bytes of the three link modes",
    "feasibility": "cycles of the collision checker's builds, and the paper's",
    "terrains": "the builds of the checker over seven terrains: cycles, and answers that differ",
    "simulation": "cycles per second of the simulated board, generations of the software model",
    "evaluation": "evaluations per second of one core, time that the rules take",
    "quality": "every planner over nine terrains, from both starts, many seeds",
    "flight": "planned paths flown in JSBSim, by rules and guidance; hours, so only if named",
    "safety": "cost of clearances for every planner, by the rules; long, so only if named",
    "chip": "the planner core: F by chip time, compared with planners, and clearances",
    "held-out": "the planner core compared with astar on ground that nothing is tuned for",
    "untuned": "the default planner, astar and peers on 100 generated problems; only if named",
    "real-maps": "the default planner, astar and peers on the nine maps of quality",
    "complete": "planted problems, solvable by construction: how many are solved; only if named",
    "chip-ablation": "choices of the planner core, one changed at a time",
    "chip-cycles": "cycles of a generation of the planner core by unit, by cycles of a point",
    "chip-replans": "replans on the chip compared with astar: a disc appears ahead in flight",
    "replan": "1,000 flights in which zones appear; hours, so only if named",
    "replan-host": "the host's share of a replan by its parts",
    "onboard": "plans whose collisions the board counts, compared with the host's",
    "allaire-table1": "ga-pc and ga-fpga per phase, compared with table 1 of allaire-2008",
    "cheng-table4": "ga-dp and ga-auv on the AUV problem, compared with the paper's table IV",
    "roberge-table4": "fpa with and without 2-opt on four maps, 50 trials, and table 4",
    "roberge-speed": "seconds of fpa-2opt by threads, solutions and engine, and the paper's",
    "desk": "the desk in Chromium: until it shows, frames in 3-D, generations seen",
    "peers": "optimizers and planners of other projects, compared with fpa-2opt",
    "autopilot": "the simulated autopilot beside real flights; needs --flights, so only if named",
    "exports": "planned missions uploaded to the simulated autopilot and flown; only if named",
    "uploads": "5,000 uploads with faults to the simulated autopilots; only if named",
    "first-minute": "commands on a warm machine: processor seconds, and the first line",
    "missions": "checks of missions of other programs: processor seconds by items",
    "scale": "plans over large maps, among many zones, through via points: seconds, MB, F",
    "fpga": "area and routed clock on real devices; hours, so only if named",
}


def main() -> int:
    """Run the benchmarks named on the command line, all of them by default."""
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(NAMES)}")
    parser.add_argument(
        "--seeds", type=int, help="seeds of each terrain (default 40, or the paper's 50)"
    )
    parser.add_argument(
        "--only",
        metavar="TEXT",
        default="",
        help="of chip, chip-ablation, complete, chip-replans, fpga, flight, quality, real-maps, "
        "replan, roberge-speed, safety and scale, the rows, or of chip the tables, with this in "
        "their names",
    )
    parser.add_argument(
        "--claimed",
        action="store_true",
        help="of complete and untuned: the seeds that are kept for claims",
    )
    parser.add_argument(
        "--keep", action="store_true", help="keep the results, and write them into the pages"
    )
    parser.add_argument("--out", type=Path, default=Path("build/bench"), help="folder of the JSON")
    parser.add_argument(
        "--flights", type=Path, metavar="FOLDER", help="real flights, for autopilot"
    )
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.names) - set(NAMES))
    if unknown:
        print(f"bench: no benchmark {unknown[0]}; choose from {', '.join(NAMES)}", file=sys.stderr)
        return 2
    if arguments.seeds is not None and arguments.seeds < 1:
        print(f"bench: --seeds must be 1 or more, not {arguments.seeds}", file=sys.stderr)
        return 2
    options = Options(only=arguments.only, claimed=arguments.claimed, flights=arguments.flights)
    if arguments.seeds is not None:
        options = replace(options, seeds=arguments.seeds, trials=arguments.seeds)
    arguments.out.mkdir(parents=True, exist_ok=True)
    status = 0
    for name in arguments.names or [
        name
        for name in NAMES
        if name
        not in (
            "autopilot",
            "complete",
            "exports",
            "fpga",
            "flight",
            "replan",
            "safety",
            "untuned",
            "uploads",
        )
    ]:
        try:
            report = importlib.import_module(f"bench.{name.replace('-', '_')}").run(options)
        except PathgeneError as error:
            print(f"bench {name}: {error}", file=sys.stderr)
            return error.exit_status
        print(report.text(), flush=True)
        if arguments.keep:
            print(f"Kept: {keep(name, report)}", flush=True)
        print(f"JSON: {report.write(arguments.out / f'{name}.json')}\n", flush=True)
        status |= report.failed
    return status


if __name__ == "__main__":
    sys.exit(main())
