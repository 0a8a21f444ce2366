"""A wheel with compiled kernels, and its commands in a new environment."""

import base64
import csv
import hashlib
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

from tools import wheel as tool


SITE = sysconfig.get_path("purelib")
FLIGHT = "--terrain canyon --agl --start 300,300,60 --goal 4700,4600,60 --seed 3 --no-picture"
# The paths of plans and the terms of random paths, as exact numbers, and whether anything compiled.
RESULTS = """
import hashlib, json
import numpy as np
from pathgene import Problem, Terrain, Zone, plan
from pathgene.host.evaluation import Evaluator
from pathgene.jit import compiling_s

rng = np.random.default_rng(52)
rows = []
for number in range(12):
    heights = 200 + 60 * rng.standard_normal((40, 50)).cumsum(axis=0).cumsum(axis=1) / 40
    ends = (500.0, 500.0, 60.0), (4300.0, 3300.0, 90.0)
    zones = [Zone.circle(*rng.uniform(1200, 2800, 2), rng.uniform(50, 500)) for _ in range(3)]
    corners = rng.uniform(1000, 3000, 2) + 400 * np.array([(0, 0), (1, 0.2), (0.3, 1)])
    zones.append(Zone.polygon([tuple(corner) for corner in corners.tolist()]))
    terrain = Terrain("random", heights, 100.0, 100.0)
    as_paper = number % 2 == 0
    problem = Problem(terrain, *ends, agl=True, zones=zones, as_paper=as_paper)
    evaluator = Evaluator(problem, threads=1)
    paths = rng.uniform((300, 300, 150), (4500, 3500, 600), (50, 7, 3))
    paths[:, 0], paths[:, -1] = problem.start, problem.goal
    lengths = rng.integers(2, 8, 50)
    paths[np.arange(50), lengths - 1] = problem.goal
    rows.append(evaluator.fitness(paths, lengths).tolist())
    rows.append([list(map(float, each)) for each in evaluator.penalty_cost(paths, lengths)])
    rows += [repr(evaluator.evaluate(path[:count])) for path, count in zip(paths, lengths)]
problem = Problem(Terrain.load("canyon"), (300, 300, 60), (4700, 4600, 60), agl=True)
for planner, board in (("astar", None), ("ga-chip", "model:"), ("fpa-2opt", None)):
    options = {"board": board} if board else {}
    more = {} if planner == "astar" else {"generations": 30}
    found = plan(problem, planner=planner, seed=1, **options, **more)
    rows.append([found.path.tolist(), found.evaluation.fitness])
text = repr(rows)
print(json.dumps([hashlib.sha256(text.encode()).hexdigest(), len(text), compiling_s()]))
"""
# Calls a small kernel.
SMALL = """
from pathgene.sim.model.planner import random_words
random_words.source(7)
stats = random_words.step.stats
print(sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""

needs_baseline = pytest.mark.skipif(
    not tool.can_compile(), reason="the kernels of a wheel do not run on this processor"
)


def run(*command, **changes):
    """Run a command in a new home, without settings of numba; return its output."""
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("NUMBA_", "PYTHON"))
    }
    folder = changes.pop("cwd", None)
    done = subprocess.run(
        [*map(str, command)],
        cwd=folder,
        env=kept | {name: str(value) for name, value in changes.items()},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-4000:]
    return done.stdout


def test_elsewhere_the_wheel_has_no_kernels(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(platform, "machine", lambda: "aarch64")
    assert tool.main(["--out", str(tmp_path)]) == 0
    (wheel,) = tmp_path.iterdir()
    assert wheel.name.endswith("-py3-none-any.whl")
    output = capsys.readouterr()
    assert output.out == f"{wheel}\n"
    sentence = "The wheel has no kernels: they are for x86-64-v3 under Linux, which this is not.\n"
    assert output.err == sentence
    with zipfile.ZipFile(wheel) as archive:
        assert not [name for name in archive.namelist() if "__pycache__" in name]


@pytest.mark.parametrize("features", ["+sse2,+avx", ""])
def test_an_older_processor_cannot_compile_them(monkeypatch, features):
    monkeypatch.setattr(tool, "get_host_cpu_features", lambda: features)
    assert not tool.can_compile()


def test_a_failed_compilation_makes_no_wheel(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(tool, "can_compile", lambda: True)

    def broken(folder):
        tree = folder / "x-1"
        for name, content in {
            "x-1.dist-info/WHEEL": "Wheel-Version: 1.0\nTag: py3-none-any\n",
            "pathgene/__init__.py": "",
            "pathgene/host/__init__.py": "",
            "pathgene/host/kernels.py": "print('broken')\nraise SystemExit(3)\n",
        }.items():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            (tree / name).write_text(content)
        command = [sys.executable, "-m", "wheel", "pack", "--dest-dir", folder, tree]
        subprocess.run(command, cwd=folder, stdout=subprocess.DEVNULL, check=True)
        return folder / "x-1-py3-none-any.whl"

    monkeypatch.setattr(tool, "_plain", broken)
    assert tool.main(["--out", str(tmp_path / "out")]) == 1
    assert capsys.readouterr().err == (
        "broken\n\nerror: Compiling the kernels failed with status 3.\n"
    )
    assert not (tmp_path / "out").exists()


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A wheel with kernels, which were compiled without the settings of this process."""
    out = tmp_path_factory.mktemp("wheel")
    printed = run(
        *(sys.executable, "-m", "tools.wheel", "--out", out),
        cwd=tool.ROOT,
        PYTHONPATH=tool.ROOT,
        NUMBA_CACHE_DIR=out / "cache",
        NUMBA_CPU_NAME="generic",
    )
    (path,) = out.iterdir()
    assert printed.splitlines()[0] == str(path)
    return path


@pytest.fixture(scope="module")
def programs(wheel, tmp_path_factory):
    """Programs of a new environment with the wheel, which finds other packages where we do."""
    folder = tmp_path_factory.mktemp("new")
    venv.create(folder, symlinks=True)
    python = folder / "bin" / "python"
    command = ("install", "--no-deps", "--no-index", "--disable-pip-version-check", "-q", wheel)
    run(sys.executable, "-m", "pip", "--python", python, *command)
    (site,) = folder.glob("lib/python*/site-packages")
    (site / "others.pth").write_text(f"{SITE}\n")
    return folder / "bin"


@pytest.fixture
def home(tmp_path):
    (tmp_path / "home").mkdir()
    return tmp_path / "home"


def kernels(*folders):
    return {path for folder in folders for path in folder.rglob("*.nb?")}


def installed(programs):
    (package,) = programs.parent.glob("lib/python*/site-packages/pathgene")
    return package


@needs_baseline
@pytest.mark.long  # A wheel takes a minute.
def test_the_wheel_is_whole(wheel):
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}{sys.abiflags}-linux_x86_64"
    assert wheel.name.endswith(f"-{tag}.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        (information,) = (name for name in names if name.endswith(".dist-info/WHEEL"))
        text = archive.read(information).decode()
        assert re.findall("^(?:Tag|Root-Is-Purelib): .*$", text, re.MULTILINE) == [
            "Root-Is-Purelib: false",
            f"Tag: {tag}",
        ]
        (record,) = (name for name in names if name.endswith(".dist-info/RECORD"))
        rows = {
            name: digest
            for name, digest, _ in csv.reader(archive.read(record).decode().splitlines())
        }
        assert set(rows) == set(names)
        for name in set(names) - {record}:
            digest = base64.urlsafe_b64encode(hashlib.sha256(archive.read(name)).digest())
            assert rows[name] == f"sha256={digest.decode().rstrip('=')}"
        cached = [name for name in names if "__pycache__" in name]
        assert {Path(name).suffix for name in cached} == {".nbi", ".nbc"}


@needs_baseline
@pytest.mark.long
@pytest.mark.parametrize("planner", ["astar", "ga-chip"])
def test_no_plan_compiles(programs, home, planner):
    package = installed(programs)
    before = kernels(package)
    board = ["--board", "model:"] if planner == "ga-chip" else []
    command = ["plan", "--planner", planner, *FLIGHT.split(), *board, "--out", "out"]
    run(programs / "pathgene", *command, cwd=home, HOME=home)
    seconds = json.loads((home / "out" / "summary.json").read_text())["seconds"]
    assert seconds["compiling"] < 0.05
    assert kernels(package, home) == before


@needs_baseline
@pytest.mark.long
def test_the_results_equal_those_of_kernels_for_this_very_processor(programs, home):
    of_wheel = json.loads(run(programs / "python", "-c", RESULTS, cwd=home, HOME=home))
    ours = json.loads(run(sys.executable, "-c", RESULTS, cwd=tool.ROOT, PYTHONPATH=tool.ROOT))
    assert of_wheel[:2] == ours[:2]
    assert of_wheel[1] > 100_000
    assert of_wheel[2] == 0
    assert not kernels(home)


@needs_baseline
@pytest.mark.long
def test_a_wheel_that_does_not_fit_compiles(programs, home, tmp_path):
    python = programs / "python"
    cache = {"cwd": home, "HOME": home, "NUMBA_CACHE_DIR": home / "cache"}
    assert run(python, "-c", SMALL, **cache) == "1 0\n"
    # A processor without AVX, or of whose features nothing is known.
    assert run(python, "-c", SMALL, **cache, NUMBA_ENABLE_AVX=0) == "0 1\n"
    assert run(python, "-c", SMALL, **cache, NUMBA_CPU_NAME="generic") == "0 1\n"
    # Changed sources.
    shutil.copytree(installed(programs), tmp_path / "pathgene")
    changed = tmp_path / "pathgene" / "hdl" / "config.py"
    assert run(python, "-c", SMALL, **cache, PYTHONPATH=tmp_path) == "1 0\n"
    changed.write_text(f"{changed.read_text()}# Changed.\n")
    assert run(python, "-c", SMALL, **cache, PYTHONPATH=tmp_path) == "0 1\n"


@needs_baseline
@pytest.mark.long
def test_an_environment_that_is_read_only(programs, home):
    """Neither it nor the home can be written, as in a container."""
    package = installed(programs)
    before = kernels(package)
    folders = [home, *(folder for folder in package.rglob("__pycache__"))]
    # Root writes everywhere, unless it gives that up.
    drop = "-dac_override,-dac_read_search,-fowner"
    modest = (
        ["setpriv", f"--bounding-set={drop}", f"--inh-caps={drop}"] if os.geteuid() == 0 else []
    )
    if modest and shutil.which("setpriv") is None:
        pytest.skip("setpriv is missing")
    modes = {folder: folder.stat().st_mode for folder in folders}
    try:
        for folder in folders:
            folder.chmod(0o555)
        with pytest.raises(AssertionError, match="Permission denied"):
            run(*modest, "touch", home / "file")
        found = run(*modest, programs / "python", "-c", SMALL, cwd=home, HOME=home)
    finally:
        for folder, mode in modes.items():
            folder.chmod(mode)
    assert found == "1 0\n"
    assert kernels(package, home) == before


def test_a_file_is_no_folder_for_a_wheel(tmp_path, capsys):
    (tmp_path / "file").touch()
    with pytest.raises(SystemExit) as error:
        tool.main(["--out", str(tmp_path / "file")])
    assert error.value.code == 2
    assert "is no folder; name the folder of the wheel." in capsys.readouterr().err
