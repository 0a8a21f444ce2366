"""Command line of the fault simulator; see :mod:`tools.faults`."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from pathlib import Path

from pathgene.host.machine import available_cores
from tools.faults.campaign import Campaign, case_of, judge_of, run
from tools.faults.case import Case, shrunk
from tools.faults.chips import Board
from tools.faults.planted import PLANTED, planted


_REPORT = Path(__file__).parents[2] / "build" / "faults"


def main() -> int:
    """Run the simulator; return 0 if all guarantees were kept, otherwise 1."""
    parser = argparse.ArgumentParser(prog="python -m tools.faults", description=__doc__)
    parser.add_argument("--board", type=Board, choices=list(Board), default=Board.MODEL)
    parser.add_argument(
        "--seeds", type=_seeds, default=range(300), metavar="FIRST:END", help="default 0:300"
    )
    parser.add_argument("--jobs", type=int, default=available_cores())
    parser.add_argument("--planted", choices=list(PLANTED), help="with this bug; ends at the first")
    parser.add_argument("--replay", type=int, metavar="SEED", help="run one case and shrink it")
    arguments = parser.parse_args()
    if arguments.replay is not None:
        return _replay(arguments.board, arguments.replay, arguments.planted)
    campaign, began_s = Campaign(), time.monotonic()
    cases = run(arguments.board, arguments.seeds, arguments.jobs, arguments.planted)
    for case, verdict in cases:
        campaign.add(case, verdict)
        if verdict.violation:
            print(f"seed {case.seed} ({case.session}): {verdict.violation}", flush=True)
            if arguments.planted:
                cases.close()
                break
    seconds = time.monotonic() - began_s
    total = campaign.sessions.total()
    print(f"{total} sessions on {arguments.board} in {seconds:.0f} s, {_listed(campaign.sessions)}")
    print(f"ended: {_listed(campaign.outcomes)}")
    print(f"{campaign.faults.total()} faults: {_listed(campaign.faults)}")
    print(f"{len(campaign.violations)} violations")
    if not arguments.planted:
        _REPORT.mkdir(parents=True, exist_ok=True)
        file = _REPORT / f"{arguments.board.name.lower()}.json"
        seeds = {"seeds": [arguments.seeds.start, arguments.seeds.stop], "seconds": seconds}
        file.write_text(json.dumps(seeds | campaign.to_json(), indent=1) + "\n")
    return int(bool(campaign.violations))


def _seeds(text: str) -> range:
    """Return the seeds of ``FIRST:END``, or the given number of seeds."""
    first, colon, end = text.rpartition(":")
    try:
        return range(int(first) if colon else 0, int(end))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not FIRST:END") from None


def _listed(counts: Counter[str]) -> str:
    return ", ".join(f"{name} {count}" for name, count in counts.most_common())


def _replay(board: Board, seed: int, bug: str | None) -> int:
    """Run a case; print it with the faults that it needs to fail."""
    case = case_of(board, seed)
    judge = judge_of(board, case.session)

    def verdict(each: Case) -> str:
        if bug is None:
            return judge.judge(each).violation
        with planted(bug):
            return judge.judge(each).violation

    text = verdict(case)
    if not text:
        print(f"seed {seed} ({case.session}): kept, with {len(case.faults)} faults drawn")
        return 0
    least = shrunk(case, lambda each: bool(verdict(each)))
    print(f"seed {seed} ({case.session}): {text}")
    print(f"with {len(least.faults)} of {len(case.faults)} faults: {verdict(least)}")
    print(least.to_json())
    return 1


if __name__ == "__main__":
    sys.exit(main())
