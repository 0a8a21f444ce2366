"""Help, versions and usage errors."""

import json
import re
import shlex
import signal
import time
from pathlib import Path

import numpy as np
import pytest
import rasterio

from pathgene.host.cli import board, desk, main
from pathgene.host.cli.parser import build_parser
from pathgene.host.mission.problem_file import template
from pathgene.host.options.table import OWN
from pathgene.host.planners import PLANNERS


COMMANDS = [
    (),
    ("plan",),
    ("desk",),
    ("problem",),
    ("problem", "new"),
    ("problem", "check"),
    ("batch",),
    ("compare",),
    ("check",),
    ("mend",),
    ("diagnose",),
    ("fly",),
    ("board",),
    ("board", "serve"),
    ("board", "info"),
    ("terrain",),
    ("terrain", "list"),
    ("terrain", "info"),
    ("terrain", "synth"),
    ("planners",),
    ("auv",),
    ("verilog",),
]

# They serve until Ctrl-C; tests/cosim/test_served_board.py and test_desk.py run them.
SERVING = {("board", "serve"): board.serve, ("desk",): desk.run}


def example(command, capsys):
    """Return the arguments of the example in the help of a command."""
    with pytest.raises(SystemExit) as caught:
        main([*command, "--help"])
    assert caught.value.code == 0
    *_, text = " ".join(capsys.readouterr().out.split()).partition("Example: pathgene ")
    return shlex.split(text)


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Directory with the files of the examples: a tile of 15 km and a path over it."""
    place = tmp_path_factory.mktemp("place")
    y, x = np.mgrid[:151, :151]
    with rasterio.open(
        place / "tile.tif",
        "w",
        driver="GTiff",
        width=151,
        height=151,
        count=1,
        dtype="float32",
        crs="EPSG:32632",
        transform=rasterio.Affine(100, 0, 600_000, 0, -100, 5_100_000),
    ) as raster:
        raster.write((300 + 100 * np.sin(x / 20) * np.cos(y / 15)).astype(np.float32), 1)
    for name in ("problem", "north", "south"):
        (place / f"{name}.toml").write_text(template())
    (place / "path.csv").write_text("x,y,z\n1200,1200,600\n7000,9000,600\n14000,14000,600\n")
    items = [
        {"type": "SimpleItem", "command": 16, "frame": 0, "params": [0, 0, 0, None, lat, 10.4, 340]}
        for lat in (45.93, 46.02)
    ]
    mission = {"fileType": "Plan", "version": 1, "mission": {"version": 2, "items": items}}
    (place / "mission.plan").write_text(json.dumps(mission))
    (place / "out" / "plan").mkdir(parents=True)
    summary = {
        "waypoints": [(1200, 1200, 500), (7000, 9000, 500), (14000, 14000, 500)],
        "terrain": {"source": "tile.tif", "fill_voids": False, "cell_m": None},
        "wind": (0, 0),
        "ds_m": 50,
        "as_paper": False,
        "rules": {},
    }
    (place / "out" / "plan" / "summary.json").write_text(json.dumps(summary))
    return place


@pytest.mark.ci
@pytest.mark.parametrize(
    "command",
    [
        pytest.param(
            command,
            marks=[pytest.mark.long] if command == ("verilog",) else [],
            id=" ".join(command),
        )
        for command in COMMANDS
    ],
)
def test_the_example_of_every_command_runs(command, place, capsys, monkeypatch):
    arguments = example(command, capsys)
    assert tuple(arguments[: len(command)]) == command
    if command in SERVING:
        assert build_parser().parse_args(arguments).command == SERVING[command]
        return
    monkeypatch.chdir(place)
    # The model replaces boards that take long to build or are absent.
    arguments = ["model:" if word in ("sim:", "/dev/ttyUSB0") else word for word in arguments]
    if command == ("compare",):  # test_compare.py tests several processes.
        arguments += ["--jobs", "1"]
    if command == ("check",):  # The plan that makes its path may not have been run.
        arguments[arguments.index("out/path.geojson")] = "path.csv"
    Path("mine.toml").unlink(missing_ok=True)
    assert main(arguments) == 0
    output = capsys.readouterr().out
    assert output
    if "--json" in arguments:
        json.loads(output)
    for option in ("--out", "--trace"):
        if option in arguments:
            assert (place / arguments[arguments.index(option) + 1]).exists()


# Quick arguments for each command that prints a result.
JSON = [
    "plan --terrain tile.tif --agl --start 1200,1200,100 --goal 14000,14000,100 --generations 5",
    "compare --planners ga-pc --terrain tile.tif --agl --start 1200,1200,100 "
    "--goal 14000,14000,100 --generations 5 --runs 1 --jobs 1",
    "problem new new.toml",
    "batch north.toml south.toml --planner astar --jobs 1 --no-picture --out batch",
    "problem check problem.toml",
    "check --terrain tile.tif --path path.csv",
    "mend mission.plan --terrain tile.tif --dry-run",
    "diagnose --terrain tile.tif --agl --start 1200,1200,100 --goal 14000,14000,100",
    "fly out/plan/summary.json --out flight",
    "board info",
    "terrain list",
    "terrain info tile.tif",
    "terrain synth canyon --out canyon.npz",
    "planners",
    "auv --generations 2 --out auv",
    "verilog --top crossover --out crossover.v",
]


@pytest.mark.parametrize("line", JSON)
def test_every_command_speaks_json(line, place, capsys, monkeypatch):
    monkeypatch.chdir(place)
    assert main([*line.split(), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)


def test_no_command_lacks_json():
    spoken = {tuple(line.split()[: len(command)]) for line in JSON for command in COMMANDS}
    groups = {(), ("board",), ("problem",), ("terrain",)}
    assert set(COMMANDS) - groups - set(SERVING) <= spoken


def groups(text):
    """Return the options of each group in the text of a help."""
    found = {}
    for line in text.splitlines():
        if title := re.fullmatch(r"(\w.*):", line):
            found[title[1]] = []
        elif option := re.match(r"  (--[a-z-]+)", line):
            found[list(found)[-1]].append(option[1])
    return found


@pytest.mark.parametrize(("command", "outputs"), [("plan", 3), ("compare", 1)])
def test_options_are_grouped(command, outputs, capsys, monkeypatch):
    """Each planner's own options are listed under its name, and only there."""
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit):
        main([command, "--help"])
    text = capsys.readouterr().out
    assert text.splitlines()[0].endswith("[OPTIONS]")
    found = groups(text)
    titles = [title for title in found if not title.startswith("options of ")]
    assert [title for title in titles if title not in ("comparison", "end of the mission")] == [
        "positional arguments",
        "options",
        "problem",
        "rules of safe flight",
        "planning",
        "output",
    ]
    assert "--terrain" in found["problem"]
    assert "--clearance" in found["rules of safe flight"]
    assert "--generations" in found["planning"]
    assert found["output"][0] == "--out"
    assert len(found["output"]) >= outputs
    own = {
        option: set(re.split(r", | and ", title.removeprefix("options of ")))
        for title, options in found.items()
        if title.startswith("options of ")
        for option in options
    }
    assert own == {
        f"--{name.replace('_', '-')}": {
            planner for planner, entry in PLANNERS.items() if name in entry.options
        }
        for name in OWN
    }


def test_help_is_quick(pathgene):
    assert pathgene("--help").returncode == 0  # By now it is compiled and in the file cache.
    took_s = []
    for _ in range(3):
        started = time.perf_counter()
        pathgene("--help")
        took_s.append(time.perf_counter() - started)
    # It takes 0.13 s; the bound allows for a busy machine.
    assert min(took_s) < 1.0


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "No command is given; pathgene --help lists them."),
        (["soar"], "There is no command 'soar' (did you mean board?); choose from "),
        (
            ["plan"],
            "The terrain is missing; give --terrain (jacksboro, canyon, river, large-canyon "
            "or a file).",
        ),
        (
            ["plan", "--terrain", "x", "--start", "1,2"],
            "Argument --start: must be finite numbers X,Y,Z, not '1,2'; see pathgene plan --help.",
        ),
        (
            ["plan", "--terrain", "x", "--wind", "-1,south"],
            "Argument --wind: must be finite numbers VX,VY, not '-1,south'; "
            "see pathgene plan --help.",
        ),
        (
            ["plan", "--terrain", "x", "--generations", "many"],
            "Argument --generations: invalid int value: 'many'; see pathgene plan --help.",
        ),
        (
            ["plan", "--terrain", "x", "--start", "1,2,3", "--start-geo", "1,2,3"],
            "Argument --start-geo: not allowed with argument --start; see pathgene plan --help.",
        ),
        (
            ["plan", "--terrain", "x", "--gen", "3"],
            "Unrecognized argument --gen (did you mean --generations?); see pathgene plan --help.",
        ),
        (["board"], "The following arguments are required: COMMAND; see pathgene board --help."),
        (
            ["plan", "--terrain", "x", "--terrain", "y"],
            "Argument --terrain: may be given only once; see pathgene plan --help.",
        ),
        (
            ["compare", "--planners", "ga-pc", "--out", ""],
            "Argument --out: must name a file or folder, not ''; see pathgene compare --help.",
        ),
        (
            ["verilog", "--top", "chip", "--out", "x", "--set", "population"],
            "Argument --set: must be KEY=VALUE, not 'population'; see pathgene verilog --help.",
        ),
    ],
)
def test_usage_errors_are_sentences(arguments, sentence, capsys):
    assert main(arguments) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.startswith(f"pathgene: {sentence}")
    assert output.err.count("\n") == 1


def test_debug_shows_a_traceback(capsys):
    assert main(["terrain", "info", "nowhere.tif"]) == 2
    assert "Traceback" not in capsys.readouterr().err
    assert main(["terrain", "info", "nowhere.tif", "--debug"]) == 2
    error = capsys.readouterr().err
    assert "Traceback" in error
    assert error.splitlines()[-1].startswith("pathgene: There is no terrain 'nowhere.tif'")


def test_an_interrupt_that_matplotlib_makes_an_error_is_an_interrupt(capsys, monkeypatch):
    from matplotlib.backends.backend_agg import RendererAgg

    import pathgene.host.cli.planners

    class Box:
        def __array__(self, *_):
            signal.raise_signal(signal.SIGTERM)

    def draws(rows):
        RendererAgg(9, 9, 72).copy_from_bbox(Box())

    monkeypatch.setattr(pathgene.host.cli.planners, "print_table", draws)
    assert main(["planners"]) == 128 + signal.SIGTERM
    assert capsys.readouterr().err == "pathgene: Interrupted before the end.\n"
    # The next command knows nothing of the signal.
    monkeypatch.setattr(pathgene.host.cli.planners, "print_table", lambda rows: 1 / 0)
    assert main(["planners"]) == 1


def test_an_internal_error_is_one_sentence(capsys, monkeypatch):
    import pathgene.host.cli.planners

    def fails(rows):
        raise ZeroDivisionError("by zero,\nof all things")

    monkeypatch.setattr(pathgene.host.cli.planners, "print_table", fails)
    assert main(["planners"]) == 1
    assert capsys.readouterr().err == (
        "pathgene: Internal error, ZeroDivisionError: by zero, of all things; --debug shows "
        "where, please report it.\n"
    )
