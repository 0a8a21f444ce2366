"""Every command that writes, on a disk that becomes full at each of its calls in turn."""

import errno
import json
import os

import pytest

from pathgene.host.cli import main
from pathgene.host.files.disk import using
from tests.cli.conftest import ENDS
from tests.support.bad_input.runs import REPORTED
from tests.support.host.foreign import write_planted
from tools.faults.disk import FaultyDisk


pytestmark = pytest.mark.ci

#: The commands other than ``plan``, and the files that they write.
COMMANDS = {
    "compare": (
        ("compare", "--terrain", "{hills}", *ENDS, "--planners", "ga-pc,astar", "--runs", "1",
         "--generations", "2", "--jobs", "1", "--out", "{out}"),
        {"compare.json", "compare.png", "runs.jsonl"},
    ),
    "auv": (("auv", "--generations", "1", "--out", "{out}"), {"auv.json", "auv.png"}),
    "batch": (
        ("batch", "{problem}", "--jobs", "1", "--no-picture", "--out", "{out}"),
        {"batch.json", "problem/path.geojson", "problem/summary.json", "problem/terrain.npz"},
    ),
    "diagnose": (("diagnose", "{problem}", "--out", "{out}"), {"diagnosis.json"}),
    "export": (("export", "{summary}", "--write", "geojson", "--out", "{out}"), {"path.geojson"}),
    "fly": (("fly", "{near}", "--out", "{out}"), {"flight.json", "flight.png"}),
    "mend": (("mend", "{mission}", "--terrain", "{ground}", "--out", "{out}/n.plan"), {"n.plan"}),
    "problem new": (("problem", "new", "{out}/new.toml"), {"new.toml"}),
    "terrain synth": (("terrain", "synth", "river", "--out", "{out}/river.npz"), {"river.npz"}),
    "verilog": (("verilog", "--top", "uart", "--out", "{out}/uart.v"), {"uart.v"}),
}  # fmt: skip
PICTURES = {"compare.png"}


@pytest.fixture(scope="module")
def inputs(hills, tmp_path_factory):
    """Names of good files that the commands read."""
    folder = tmp_path_factory.mktemp("inputs")
    problem = folder / "problem.toml"
    ends = ("--terrain", str(hills), "--start", "500,500,500", "--goal", "5500,3500,500")
    made = ("--planner", "astar", "--no-picture", "--out", str(folder))
    assert main(["plan", *ends, *made, "--save-problem", str(problem)]) == 0
    # A flight of half a minute.
    near = folder / "near"
    assert main(["plan", *ends[:-1], "2000,1400,500", *made[:-1], str(near)]) == 0
    summaries = {"summary": folder / "summary.json", "near": near / "summary.json"}
    mission, ground = write_planted(folder, "ridge", faulty=True)
    mended = {"mission": mission, "ground": ground}
    return {"hills": hills, "problem": problem, **summaries, **mended}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_full_disk_is_one_sentence(inputs, tmp_path, capsys, name):
    arguments, files = COMMANDS[name]

    def run(out, disk):
        out.mkdir()
        with using(disk):
            status = main([argument.format(**inputs, out=out) for argument in arguments])
        return status, capsys.readouterr().err.splitlines()

    counted = FaultyDisk()
    status, _ = run(tmp_path / "count", counted)
    assert status == 0
    folder = tmp_path / "count"
    whole = {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}
    assert whole == files
    full = os.strerror(errno.ENOSPC)
    ended = set()
    for at in range(1, len(counted.calls) + 1):
        out = tmp_path / str(at)
        status, said = run(out, FaultyDisk(at, lasting=True, seed=at))
        left = {file.relative_to(out).as_posix() for file in out.rglob("*") if file.is_file()}
        assert not [file for file in left if file.rpartition("/")[2].startswith(".")]
        sentences = [
            line for line in said if line.startswith("pathgene: ") and not line.startswith(REPORTED)
        ]
        if status == 0:
            # Not every command fails if only a picture is missing.
            assert left == whole or (left == {*whole} - PICTURES and len(sentences) == 1)
            assert len(sentences) == (left != whole)
        else:
            (sentence,) = sentences
            assert (status, sentence) == (2, said[-1])
            assert sentence.startswith("pathgene: Cannot write to ")
            assert f"({full})" in sentence
            assert sentence.endswith(".")
            assert left < whole
        ended.add(status)
        for file in left:
            if file.endswith(".json"):
                json.loads((out / file).read_text())
    assert ended == {0, 2}
