"""The public API, used as a program would use it."""

import doctest
import importlib
import json
import subprocess
import sys
import threading

import numpy as np
import pytest

import pathgene
from pathgene import InputError, JobError, PathgeneError, Problem, Terrain, Zone, check, plan
from pathgene.host.cli import main
from pathgene.host.mission.foreign.repairs import Means
from tests.support.host.foreign import write_planted


#: Libraries that are slow to import or not always needed.
HEAVY = ("numba", "scipy", "matplotlib", "rasterio")


def heights():
    """Return heights (41, 61): hills of 150 m."""
    y, x = np.mgrid[:41, :61]
    return 300 + 150 * np.sin(x / 8) * np.cos(y / 6)


@pytest.fixture(scope="module")
def problem():
    """Problem of a flight of 6 km over the hills, around a zone."""
    return Problem(
        Terrain.from_array(heights(), 100.0, name="hills"),
        (500, 500, 100),
        (5500, 3500, 100),
        zones=[Zone.circle(3000, 2000, 400)],
        agl=True,
    )


def loaded_after(code):
    """Return the heavy libraries that a new process has imported after ``code``."""
    code += f"\nimport sys\nprint(*({set(HEAVY)} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_import_is_light():
    assert loaded_after("import pathgene") == set()
    names = "Aircraft, Chip, InputError, LinkMode, Terrain, Zone, check, planners"
    assert loaded_after(f"from pathgene import {names}") == set()


def test_planning_draws_nothing():
    code = (
        "import numpy, pathgene\n"
        "terrain = pathgene.Terrain.from_array(numpy.zeros((9, 9)), 200)\n"
        "problem = pathgene.Problem(terrain, (0, 0, 90), (1600, 1600, 90))\n"
        "pathgene.plan(problem, 'ga-pc', generations=1)"
    )
    loaded = loaded_after(code)
    assert "numba" in loaded
    assert not loaded & {"matplotlib", "rasterio"}


def test_every_name_exists_and_is_documented():
    assert set(pathgene.__all__) == {name for name in dir(pathgene) if not name.startswith("_")}
    for name in pathgene.__all__:
        assert getattr(pathgene, name).__doc__, name
    with pytest.raises(AttributeError, match=r"^module 'pathgene' has no attribute 'plane'$"):
        _ = pathgene.plane


def test_the_package_defines_nothing():
    homes = {getattr(pathgene, name).__module__.split(".")[1] for name in pathgene.__all__}
    assert homes == {"host", "hdl"}


def test_docstrings_run():
    finder, runner = doctest.DocTestFinder(), doctest.DocTestRunner()
    named = {name: getattr(pathgene, name) for name in pathgene.__all__}
    tests = [
        *finder.find(pathgene, "pathgene"),
        *(test for name, thing in named.items() for test in finder.find(thing, name, module=False)),
    ]
    for test in tests:
        runner.run(test)
    assert runner.summarize().failed == 0
    assert runner.tries > 0


def test_plan_equals_that_of_the_command_line(problem, tmp_path, capsys):
    file = tmp_path / "hills.npz"
    np.savez(file, elevation=heights(), dx_m=100.0, dy_m=100.0)
    arguments = ["--terrain", str(file), "--start", "500,500,100", "--goal", "5500,3500,100"]
    arguments += ["--agl", "--nofly-circle", "3000,2000,400", "--seed", "7"]
    assert main(["plan", *arguments, "--generations", "25", "--out", str(tmp_path), "--json"]) == 0
    theirs = json.loads(capsys.readouterr().out)

    terrain = Terrain.load(file)
    found = plan(
        Problem(terrain, (500, 500, 100), (5500, 3500, 100), zones=problem.zones, agl=True),
        seed=7,
        generations=25,
    )
    found.save(tmp_path / "ours")
    ours = json.loads((tmp_path / "ours" / "summary.json").read_text())
    for summary in (ours, theirs):
        del summary["seconds"]
    assert ours == theirs
    for name in ("path.geojson", "path.png", "terrain.npz"):
        assert (tmp_path / "ours" / name).read_bytes() == (tmp_path / name).read_bytes()


def test_defaults_are_those_of_the_command_line(tmp_path, capsys):
    arguments = ["plan", "--terrain", "canyon", "--start", "300,300,60", "--goal", "4700,4600,60"]
    assert main([*arguments, "--agl", "--out", str(tmp_path), "--no-picture", "--json"]) == 0
    theirs = json.loads(capsys.readouterr().out)
    found = plan(Problem(Terrain.load("canyon"), (300, 300, 60), (4700, 4600, 60), agl=True))
    ours = json.loads(json.dumps(found.summary))
    del theirs["files"]  # None of our files is written.
    for summary in (ours, theirs):
        del summary["seconds"]
        # How often the status was requested depends on timing.
        for counted in (summary["hardware"], *summary["hardware"]["runs"]):
            del counted["bytes"]
    assert ours == theirs


def test_plan(problem, tmp_path):
    seen = []
    found = plan(problem, "ga-pc", generations=20, seed=3, progress=lambda *at: seen.append([*at]))
    assert found.path.shape == (len(found.path), 3)
    assert tuple(found.path[0]) == problem.start
    assert tuple(found.path[-1]) == problem.goal
    assert found.evaluation == check(problem, found.path)
    assert found.history == seen == found.summary["history"]
    assert (found.interrupted, found.failure) == (False, None)
    verdict = "feasible" if found.evaluation.feasible else "not feasible"
    assert repr(found).startswith(
        f"<Plan by ga-pc: {verdict}, fitness {found.evaluation.fitness:.4f}"
    )
    written = found.save(tmp_path / "out", picture=False)
    assert {file.name for file in written} == {"summary.json", "terrain.npz", "path.geojson"}


def test_plot(problem):
    figure = plan(problem, "ga-pc", generations=3).plot()
    width, height = figure.canvas.get_width_height()
    assert width > height > 300
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert "Convergence" in titles


def test_cancel_keeps_the_best_so_far(problem):
    enough = threading.Event()

    def progress(generation, best, mean):
        if generation == 4:
            enough.set()

    found = plan(problem, "ga-pc", progress=progress, cancel=enough.is_set)
    assert found.interrupted
    assert found.summary["interrupted"]
    assert len(found.history) == 5
    assert found.evaluation == check(problem, found.path)


def test_an_error_of_a_callback_propagates(problem):
    def progress(generation, best, mean):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        plan(problem, "ga-pc", progress=progress)


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        (["ga"], {}, r"^There is no planner 'ga'; the planners are ga-chip, ga-fpga, "),
        (["ga-pc"], {"board": "sim:"}, r"^The planner ga-pc has no option 'board', only "),
        (
            ["ga-fpga"],
            {"link_mode": "rank2"},
            r"^The option link_mode must be rank or population or recipe, not 'rank2'\.$",
        ),
        ([], {"seed": -1}, r"^The seed must be from 0 to 2\*\*64 - 1, not -1\.$"),
        ([], {"population": 7}, r"7"),
        ([], {"board": "/dev/none"}, r"^No board can be opened at '/dev/none'"),
    ],
)
def test_refuses_bad_options(problem, arguments, options, message):
    with pytest.raises(InputError, match=message):
        plan(problem, *arguments, **options)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ([(0, 0, 0), (1, 1, 1)], r"^Path must start at \(500\.0, 500\.0, .*\), not \(0\.0, "),
        ([(0, 0), (1, 1)], r"^Path must have shape \(n, 3\) with n >= 2, not \(2, 2\)\.$"),
        (
            [(0, 0, 0), (1, 1)],
            r"^The path must be rows of three real numbers: x, y and altitude\.$",
        ),
        ([(0, 0, np.nan), (1, 1, 1)], r"^The path has a coordinate that is not a number"),
    ],
)
def test_refuses_bad_paths(problem, path, message):
    with pytest.raises(InputError, match=message):
        check(problem, path)


def test_errors_are_those_of_the_command_line():
    assert issubclass(InputError, PathgeneError)
    assert issubclass(JobError, PathgeneError)
    assert (InputError.exit_status, JobError.exit_status) == (2, 1)


def test_checks_a_mission_as_the_command_line_does(tmp_path, capsys):
    file, land = write_planted(tmp_path, "fence", faulty=True, seed=2)
    terrain = Terrain.load(land)
    report = pathgene.Mission.load(file, terrain).check()
    assert main(["check", "--terrain", str(land), "--path", str(file), "--json"]) == 1
    by_command = json.loads(capsys.readouterr().out)
    assert [each["sentence"] for each in report["faults"]] == [
        each["sentence"] for each in by_command["faults"]
    ]
    assert report["rules"] == by_command["rules"]
    file.write_text("{}")
    with pytest.raises(InputError, match=r"this is not the content of a \.plan file, or "):
        pathgene.Mission.load(file, terrain)
    with pytest.raises(InputError, match=r"^The mission must be the path of a file, not None\.$"):
        pathgene.Mission.load(None, terrain)


def test_mends_a_mission(tmp_path, monkeypatch):
    file, land = write_planted(tmp_path, "fence", faulty=True, seed=2)
    terrain, mended = Terrain.load(land), tmp_path / "mended.plan"
    mission = pathgene.Mission.load(file, terrain)
    assert repr(mission).endswith("m.plan', 6 items)")
    report = mission.mend(mended)
    assert (report["mended"], report["before"]["feasible"]) == (True, False)
    assert report["changes"]
    assert pathgene.Mission.load(mended, terrain).check()["feasible"]
    # The ceiling lies below the mission's lowest height, so that a short search is enough.
    monkeypatch.setattr("pathgene.host.mission.foreign.mend._SEARCHED", dict.fromkeys(Means, 1))
    low = pathgene.Mission.load(file, terrain, rules=pathgene.Rules(ceiling_m=1.0))
    assert low.mend()["refusal"].startswith("The mission cannot be mended: ")
    with pytest.raises(JobError, match=r"^The mission cannot be mended: "):
        low.mend(tmp_path / "none.plan")
    assert not (tmp_path / "none.plan").exists()


def test_planners():
    planners = pathgene.planners()
    assert next(iter(planners)) == "ga-chip"
    assert planners["fpa"].generations == 500
    assert "Roberge" in planners["fpa"].paper
    planners.clear()
    assert pathgene.planners()


def test_open_board():
    with pathgene.open_board("model:?max_waypoints=20") as board:
        assert isinstance(board, pathgene.Chip)
        assert board.config.max_waypoints == 20


def test_aircraft(problem):
    assert "heron" in pathgene.Aircraft.names()
    heron = pathgene.Aircraft.load("heron")
    ends = problem.start, problem.goal
    assert (
        Problem(problem.terrain, *ends, heron).aircraft
        == Problem(problem.terrain, *ends, "heron").aircraft
    )


def test_typed():
    package = importlib.resources.files("pathgene")
    assert package.joinpath("py.typed").is_file()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: pathgene.plan(None), "The problem must be a Problem, not of the type NoneType."),
        (lambda: pathgene.plan(None, progress=3), "The progress must be a function, not 3."),
        (lambda: pathgene.plan(None, cancel=True), "The cancel must be a function, not True."),
        (lambda: pathgene.check(3, []), "The problem must be a Problem, not of the type int."),
        (lambda: pathgene.open_board(None), "The board must be a URL, not None."),
        (
            lambda: pathgene.Terrain.load(3),
            "The terrain must be a name or the path of a file, not 3.",
        ),
        (
            lambda: pathgene.Zone.polygon([(0, 0), (1, 0), (1, 1)], holes=3),
            "No-fly polygon: holes must be rings, not 3.",
        ),
        (
            lambda: pathgene.Terrain.from_array(np.zeros((3, 3)), 10, crs=3),
            "The crs must be the name of a reference system, not 3.",
        ),
        (
            lambda: pathgene.Terrain.from_array(np.zeros((3, 3)), 10, origin="x"),
            "The origin must be two numbers, not 'x'.",
        ),
    ],
)
def test_refuses_arguments_of_other_types(call, message):
    with pytest.raises(InputError) as caught:
        call()
    assert str(caught.value) == message


def test_numbers_of_numpy_are_numbers():
    x, y, radius = np.array([100, 200, 30])
    assert pathgene.Zone.circle(x, y, radius) == pathgene.Zone.circle(100, 200, 30)
    assert pathgene.Zone.circle(np.float32(0.5), y, radius).x_m == 0.5
    corners = np.array([(0, 0), (9, 0), (9, 9)])
    holes = [corners / 2]
    zone = pathgene.Zone.polygon(corners, holes)
    assert zone == pathgene.Zone.polygon(corners.tolist(), [holes[0].tolist()])


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"problems": []}, "There is no problem to plan; give one or more."),
        ({"problems": "all"}, "The problems must be a list of problems, each of one leg."),
        ({"seed": 7}, "Problems planned together have a seed each; give seeds, not seed."),
        ({"seeds": [1, 2]}, "There are 1 problems and 2 seeds; give as many seeds."),
        ({"seeds": [-1]}, "The seed must be from 0 to 2**64 - 1, not -1."),
        (
            {"engine": "threads"},
            "Problems are planned together on a GPU alone; give fpa or fpa-2opt and the engine "
            "gpu.",
        ),
        ({"planner": "astar"}, "The planner astar has no option 'engine'"),
        ({"population": 2}, "The population of fpa must be from 4 to 100000, not 2."),
    ],
)
def test_plans_together_what_a_gpu_can(problem, change, sentence):
    with pytest.raises(InputError) as caught:
        pathgene.plan_together(**{"problems": [problem], **change})
    assert str(caught.value).startswith(sentence)
