"""Mutation testing of the gateware: ``python -m tools.mutate --seed 2026 --count 200``.

An alteration changes one operator, constant or condition of a file in ``hdl/`` in a copy of the
project: a comparison or an operation is replaced by another, an integer grows or shrinks by 1, a
condition is inverted or dropped. The seed draws the sites uniformly from the whole gateware;
:mod:`tools.mutation.sites` defines the sites, and lists the files left out.

The tests that mirror the file run first, then the tests of its package. If they pass, the circuits
of all top levels are compared with the original's: if they are equal up to names
(:mod:`tools.netlist`), with or without optimization, the alteration is equivalent. Otherwise all
tests of units, models and records follow, then whole chips in simulation. An alteration that passes
all tests is a survivor: a missing test, a needless line, or a proof to write.

Each result is a line of JSON in ``build/mutation/results.jsonl``, written as soon as it is known; a
second call continues from there. A killed alteration counts as killed while its line is unchanged
and the test exists; the rest is tried again once the tests or the gateware have changed. At the
end, the tests that found alterations run on the unaltered copy, where all must pass.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import queue
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from pathgene.sim.cache import build_root
from tools.mutation.sites import Alteration, draw, gateware_files, sites_of
from tools.mutation.workshop import Workshop


#: Stages that an alteration goes through until it is killed.
DEPTHS = ("near", "units", "chips")
ROOT = Path(__file__).resolve().parents[1]

Entry = dict[str, Any]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run alterations; return 0 if at least the required share is killed."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.mutate", description="Mutation testing of the gateware."
    )
    parser.add_argument("--seed", type=int, default=2026, help="of the draw (default 2026)")
    parser.add_argument("--count", type=int, default=200, help="alterations (default 200)")
    parser.add_argument("--files", nargs="+", metavar="FILE", help="draw from these files only")
    parser.add_argument("--jobs", type=int, default=1, help="alterations at a time (default 1)")
    parser.add_argument("--limit", type=float, default=60.0, help="processor seconds of a test")
    parser.add_argument(
        "--depth", choices=DEPTHS, default="chips", help="tests that a survivor meets (all)"
    )
    parser.add_argument("--list", action="store_true", help="only say what would be altered")
    parser.add_argument("--require", type=float, default=0.0, metavar="PERCENT", help="of killed")
    options = parser.parse_args(arguments)

    files = options.files or gateware_files(ROOT)
    sites = [site for file in files for site in sites_of(ROOT, file)]
    if not 1 <= options.count <= len(sites):
        parser.error(f"--count must be from 1 to {len(sites)}, the number of sites")
    drawn = draw(sites, options.seed, options.count)
    print(f"{len(drawn)} of {len(sites)} sites in {len(files)} files, seed {options.seed}")
    if options.list:
        for alteration in drawn:
            print(alteration.place)
        return 0
    store = build_root() / "mutation" / "results.jsonl"
    state = digest_of(ROOT, "hdl", "tests", "sim", "host", "tools")
    store.parent.mkdir(parents=True, exist_ok=True)
    known = {key: entry for key, entry in read(store).items() if has_killer(ROOT, entry)}
    wanted = [one for one in drawn if not is_settled(known.get(one.key), options.depth, state)]
    print(f"results: {store}, {len(drawn) - len(wanted)} known", flush=True)
    with tempfile.TemporaryDirectory(prefix="work.", dir=store.parent) as work:
        shops = [
            Workshop(ROOT, Path(work) / str(number), options.limit, depth=options.depth)
            for number in range(options.jobs)
        ]
        for entry in judged(shops, wanted):
            entry["state"] = state
            known[entry["key"]] = entry
            with store.open("a") as file:
                file.write(json.dumps(entry) + "\n")
            print(f"{entry['verdict']:10} {place_of(entry)}  [{entry['by']}]", flush=True)
        entries = [known[alteration.key] for alteration in drawn]
        wrong = verify(shops[0], entries)
    print(report(entries))
    if wrong:
        print("These tests fail on the unaltered sources, too:", *wrong, sep="\n  ")
        return 1
    return 0 if share(entries) >= options.require else 1


def judged(shops: Sequence[Workshop], alterations: Sequence[Alteration]) -> Iterable[Entry]:
    """Judge alterations in parallel, one per workshop at a time; yield results as they arrive."""
    free: queue.SimpleQueue[Workshop] = queue.SimpleQueue()
    for shop in shops:
        free.put(shop)

    def judge(alteration: Alteration) -> Entry:
        shop = free.get()
        try:
            return shop.judge(alteration).as_dict()
        finally:
            free.put(shop)

    with ThreadPoolExecutor(len(shops)) as pool:
        futures = [pool.submit(judge, alteration) for alteration in alterations]
        try:
            for future in as_completed(futures):
                yield future.result()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def is_settled(entry: Entry | None, depth: str, state: str) -> bool:
    """Return whether tests of this depth, for these sources, add nothing to a result."""
    if entry is None:
        return False
    deep_enough = entry["verdict"] == "equivalent" or (
        DEPTHS.index(entry["depth"]) >= DEPTHS.index(depth)
    )
    return entry["verdict"] == "killed" or (deep_enough and entry["state"] == state)


def has_killer(root: Path, entry: Entry) -> bool:
    """Return whether an alteration was killed by a test that still exists."""
    path, _, test = entry["by"].partition("::")
    if entry["verdict"] != "killed" or not path.startswith("tests/"):
        return True
    name = test.partition("[")[0].rpartition("::")[2]
    file = root / path
    return file.is_file() and (not name or f"def {name}(" in file.read_text(encoding="utf-8"))


def verify(shop: Workshop, entries: Sequence[Entry]) -> list[str]:
    """Return the tests that killed an alteration but also fail on the unaltered sources."""
    killers = {entry["by"] for entry in entries if entry["verdict"] == "killed"}
    return shop.failures(sorted(name for name in killers if name.startswith("tests/")))


def read(store: Path) -> dict[str, Entry]:
    """Return the results of a file by key; the last line may be cut off."""
    known = {}
    for line in store.read_text().splitlines() if store.exists() else ():
        try:
            entry = json.loads(line)
        except ValueError:
            continue
        known[entry["key"]] = entry
    return known


def share(entries: Sequence[Entry]) -> float:
    """Return the percentage killed of the alterations that are not equivalent."""
    verdicts = Counter(entry["verdict"] for entry in entries)
    of = len(entries) - verdicts["equivalent"]
    return 100 * verdicts["killed"] / of if of else 100.0


def report(entries: Sequence[Entry]) -> str:
    """Return the summary: the counts, then each alteration that no test found."""
    verdicts = Counter(entry["verdict"] for entry in entries)
    lines = [
        f"{len(entries)} alterations: {verdicts['killed']} killed, "
        f"{verdicts['equivalent']} equivalent, {verdicts['survived']} survived; "
        f"{share(entries):.1f} % of those that change something are killed"
    ]
    for verdict in ("equivalent", "survived"):
        for entry in entries:
            if entry["verdict"] == verdict:
                lines.append(f"{verdict}: {place_of(entry)} ({entry['by']})")
    return "\n".join(lines)


def place_of(entry: Entry) -> str:
    """Return the place of a result and its change."""
    return Alteration(**entry["alteration"]).place


def digest_of(root: Path, *folders: str) -> str:
    """Return 12 hexadecimal digits of all Python files in some folders."""
    state = hashlib.sha256()
    for name in folders:
        for path in sorted((root / name).rglob("*.py")):
            state.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    return state.hexdigest()[:12]


if __name__ == "__main__":
    sys.exit(main())
