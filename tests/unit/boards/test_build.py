"""The flow of a bitstream, with scripted programs in place of the tools."""

import json
import stat
import sys
import textwrap
import time
from dataclasses import replace
from itertools import chain, repeat
from types import SimpleNamespace

import pytest

from pathgene.hdl.boards import build as flow
from pathgene.hdl.boards import find_board
from pathgene.hdl.boards import route as routing
from pathgene.hdl.boards.build import build, main
from pathgene.hdl.boards.route import Routed, route
from pathgene.hdl.boards.tools import BuildError, tool_path


# Regardless of the seed in its file.
BOARD = replace(find_board("ulx3s-85f", "paper"), seed=1)
COMMANDS = [
    ["yosys", "-q", "chip.ys"],
    ["nextpnr-ecp5", "--json", "chip.json", "--textcfg", "chip.config"],
    ["ecppack", "--input", "chip.config", "--bit", "chip.bit"],
]
# Appends its arguments to a log and makes the file named by each output option.
TOOL = """\
#!{python}
import json, pathlib, sys, time
name, arguments = {name!r}, sys.argv[1:]
with pathlib.Path({calls!r}).open("a") as calls:
    calls.write(json.dumps([name, *arguments]) + "\\n")
options = dict(zip(arguments, arguments[1:]))
if name == "nextpnr-ecp5":
    seed = int(options["--seed"])
    assert pathlib.Path(options["--json"]).read_text() == "netlist"
    time.sleep({slow}.get(seed, 0))
    pathlib.Path(options["--report"]).write_text(json.dumps({{
        "fmax": {{"clock": {{"achieved": {achieved}[seed - 1], "constraint": 100}}}},
        "utilization": {{"DP16KD": {{"used": 192, "available": 208}}}},
    }}))
    pathlib.Path("chip.config").write_text(str(seed))
if name == "yosys":
    pathlib.Path("chip.json").write_text("netlist")
if name == "ecppack":
    pathlib.Path("chip.bit").write_text(pathlib.Path("chip.config").read_text())
print("the output of", name)
sys.exit({status} or (name == "nextpnr-ecp5" and {achieved}[seed - 1] is None))
"""


@pytest.fixture
def tools(tmp_path, monkeypatch):
    """Function that installs the scripted programs."""

    def install(achieved=(101,), status=0, failing="", slow=None, sources="module"):
        for name in ("yosys", "nextpnr-ecp5", "ecppack"):
            program = tmp_path / f"my-{name}"
            program.write_text(
                TOOL.format(
                    python=sys.executable,
                    name=name,
                    calls=str(tmp_path / "calls"),
                    achieved=list(achieved),
                    slow=slow or {},
                    status=status if name == failing else 0,
                )
            )
            program.chmod(program.stat().st_mode | stat.S_IXUSR)
            monkeypatch.setenv(name.upper().replace("-", "_"), str(program))

        def prepare(board, folder):
            folder.mkdir(parents=True, exist_ok=True)
            for name, content in {"chip.ys": "script", "chip.v": sources}.items():
                (folder / name).write_text(content)
            return COMMANDS

        monkeypatch.setattr(flow, "prepare", prepare)
        monkeypatch.setattr(flow, "find_board", lambda *named: replace(find_board(*named), seed=1))

    return install


def calls(tmp_path):
    return [json.loads(line) for line in (tmp_path / "calls").read_text().splitlines()]


def test_seeds_until_timing_closes(tools, tmp_path):
    tools(achieved=(80, 99.9, 100, 120))
    folder = tmp_path / "out"
    routed = build(BOARD, folder, jobs=1)
    assert routed == Routed(seed=3, clocks={"clock": (100, 100)}, cells={"DP16KD": (192, 208)})
    assert [call[0] for call in calls(tmp_path)] == ["yosys", *["nextpnr-ecp5"] * 3, "ecppack"]
    assert (folder / "chip.bit").read_text() == "3"
    report = json.loads((folder / "report.json").read_text())
    assert (report["board"], report["chip"]) == ("ulx3s-85f", "paper")
    assert report["build_id"] == BOARD.config.build_id
    assert report["seed"] == 3
    assert report["clocks"] == {"clock": [100, 100]}


def test_sources_alone_run_no_tool(tools, tmp_path, capsys):
    tools()
    assert main(["ulx3s-85f", "--sources", "--out", str(tmp_path)]) == 0
    verilog = tmp_path / "ulx3s-85f" / "planner" / "chip.v"
    assert capsys.readouterr().out == f"{verilog}\n"
    assert verilog.read_text() == "module"
    assert not (tmp_path / "calls").exists()


def test_the_boards_seed_is_tried_first(tools, tmp_path):
    tools(achieved=(90, 91, 92, 93))
    board = replace(BOARD, seed=3)
    with pytest.raises(BuildError, match=r"the best, 4, reaches 93\.0%"):
        build(board, tmp_path / "out", seeds=4, jobs=1)
    seeds = [call[call.index("--seed") + 1] for call in calls(tmp_path) if "--seed" in call]
    assert seeds == ["3", "1", "2", "4"]


def test_a_closing_seed_stops_later_ones(tools, tmp_path):
    tools(achieved=(90, 100, 101), slow={3: 3600})
    folder = tmp_path / "out"
    assert build(BOARD, folder, seeds=3, jobs=3).seed == 2
    assert (folder / "chip.config").read_text() == "2"
    assert (folder / "nextpnr-ecp5.log").read_text() == "the output of nextpnr-ecp5\n"


def test_waits_for_an_earlier_seed(tools, tmp_path):
    tools(achieved=(100, 101, 102), slow={1: 2})
    assert build(BOARD, tmp_path / "out", seeds=3, jobs=2).seed == 1
    seeds = [call[call.index("--seed") + 1] for call in calls(tmp_path) if "--seed" in call]
    assert sorted(seeds) == ["1", "2"]


def test_keeps_the_best_seed_if_none_closes(tools, tmp_path):
    tools(achieved=(80, 95, 90))
    (tmp_path / "chip.json").write_text("netlist")
    # A file of an earlier run, not an input.
    (tmp_path / "chip.config").write_text("old")
    assert route(COMMANDS[1], tmp_path, [1, 2, 3]).seed == 2
    assert (tmp_path / "chip.config").read_text() == "2"


@pytest.mark.ci
def test_repeats_no_finished_step(tools, tmp_path):
    tools(achieved=(80, 100))
    folder = tmp_path / "out"

    def run(**options):
        (tmp_path / "calls").unlink(missing_ok=True)
        seed = build(BOARD, folder, jobs=1, **options).seed
        assert (folder / "chip.bit").read_text() == str(seed)
        return [call[0] for call in calls(tmp_path)]

    every = ["yosys", *["nextpnr-ecp5"] * 2, "ecppack"]
    assert run() == every
    assert run() == run() == ["ecppack"]
    assert json.loads((folder / "report.json").read_text())["seed"] == 2
    (folder / "chip.json").unlink()
    assert run() == ["yosys", "ecppack"]
    for lost in ("nextpnr.json", "chip.config"):
        (folder / "seed-2" / lost).unlink()
        assert run() == ["nextpnr-ecp5", "ecppack"]
    tools(achieved=(80, 100), sources="other")
    assert run() == every
    tools(achieved=(80, 99, 100), failing="nextpnr-ecp5", status=1)
    with pytest.raises(BuildError):
        run()
    tools(achieved=(80, 99, 100))
    assert run() == ["yosys", *["nextpnr-ecp5"] * 3, "ecppack"]


def test_reports_a_failed_seed(tools, tmp_path, capfd):
    tools(status=7, failing="nextpnr-ecp5")
    with pytest.raises(BuildError, match=r"^nextpnr-ecp5 failed with status 7; .*nextpnr-ecp5.log"):
        build(BOARD, tmp_path / "out", jobs=1)
    assert "the output of nextpnr-ecp5" in capfd.readouterr().err


@pytest.mark.parametrize("jobs", [1, 3])
def test_an_unroutable_seed_does_not_close(tools, tmp_path, jobs, capfd):
    tools(achieved=(None, 99.0, 101))
    assert build(BOARD, tmp_path / "out", seeds=3, jobs=jobs).seed == 3
    assert "seed 1: nextpnr-ecp5 failed with status 1; " in capfd.readouterr().err
    assert (tmp_path / "out" / "chip.bit").read_text() == "3"


def test_stops_a_seed_that_does_not_terminate(tools, tmp_path, capfd, monkeypatch):
    tools(achieved=(101, 102), slow={1: 3600})

    def build_for(seconds, **options):
        """Let ``seconds`` pass while the first seed is routed, and no time otherwise."""
        clock = chain([0.0, 0.0], repeat(seconds))
        fake = SimpleNamespace(sleep=time.sleep, monotonic=lambda: next(clock))
        monkeypatch.setattr(routing, "time", fake)
        return build(BOARD, tmp_path / "out", limit_s=3600, jobs=1, **options)

    assert build_for(3601.0, seeds=2).seed == 2
    assert "seed 1: nextpnr-ecp5 did not terminate within 3,600 s.\n" in capfd.readouterr().err
    # The next run tries it again, because it was stopped and not routed.
    with pytest.raises(BuildError, match=r"^nextpnr-ecp5 did not terminate within 3,600 s\.$"):
        build_for(3601.0, seeds=1)


def test_no_seed_closes(tools, tmp_path):
    tools(achieved=(80, 99.9, 90))
    with pytest.raises(
        BuildError,
        match=r"^No seed closes timing on ulx3s-85f: the best, 2, reaches 99.9% of what is asked.$",
    ):
        build(BOARD, tmp_path / "out", seeds=3)
    assert not (tmp_path / "out" / "chip.bit").exists()


def test_reports_a_failed_tool(tools, tmp_path, capfd):
    tools(status=3, failing="yosys")
    folder = tmp_path / "out"
    with pytest.raises(
        BuildError, match=r"^yosys failed with status 3; its output is in .*\.log.$"
    ):
        build(BOARD, folder)
    assert len(calls(tmp_path)) == 1
    assert "the output of yosys" in capfd.readouterr().err


def test_reports_a_missing_tool(monkeypatch):
    monkeypatch.setenv("NEXTPNR_ECP5", "no-such-program")
    with pytest.raises(BuildError, match=r"^no-such-program is missing; `make bitstream` "):
        tool_path("nextpnr-ecp5")


def test_command_line(tools, tmp_path, capsys):
    tools()
    assert main(["ulx3s-85f", "--jobs", "1", "--out", str(tmp_path)]) == 0
    folder = tmp_path / "ulx3s-85f" / "planner"
    assert capsys.readouterr().out == textwrap.dedent(f"""\
        clock: 101.0 MHz, 100.0 asked, seed 1
        {folder / "chip.bit"}
    """)
    assert main(["ulx3s", "--out", str(tmp_path)]) == 2
    assert capsys.readouterr().err.startswith("bitstream: BOARD must be one of ulx3s-85f, ")
    assert main(["ulx3s-85f", "--chip", "paper", "--jobs", "1", "--out", str(tmp_path)]) == 0
    bitstream = tmp_path / "ulx3s-85f" / "paper" / "chip.bit"
    assert capsys.readouterr().out.endswith(f"{bitstream}\n")
    assert main(["icebreaker", "--chip", "planner", "--out", str(tmp_path)]) == 2
    assert capsys.readouterr().err == (
        "bitstream: Chip of icebreaker must be paper, for which it has room, not planner.\n"
    )
    tools(achieved=(80,))
    assert main(["ulx3s-85f", "--seeds", "1", "--out", str(tmp_path)]) == 1
    assert "bitstream: No seed closes timing" in capsys.readouterr().err
    for option in ("--seeds", "--jobs"):
        assert main(["ulx3s-85f", option, "0", "--out", str(tmp_path)]) == 2
        assert capsys.readouterr().err == f"bitstream: {option} must be at least 1, not 0.\n"
    assert main(["ulx3s-85f", "--hours", "-1"]) == 2
    assert capsys.readouterr().err == "bitstream: --hours must be more than 0, not -1.\n"


@pytest.mark.ci
def test_interrupted(tools, tmp_path, capsys, monkeypatch):
    """Running seeds are stopped; finished ones are not repeated."""
    tools(achieved=(80, 101), slow={2: 2})
    arguments = ["ulx3s-85f", "--jobs", "1", "--out", str(tmp_path)]

    def pause(seconds):
        if ["nextpnr-ecp5", "2"] in [[call[0], call[-3]] for call in calls(tmp_path)]:
            raise KeyboardInterrupt
        time.sleep(seconds)

    with monkeypatch.context() as context:
        context.setattr(routing, "time", SimpleNamespace(sleep=pause, monotonic=time.monotonic))
        assert main(arguments) == 130
    assert capsys.readouterr().err.splitlines()[-1].startswith("bitstream: interrupted. What has ")
    time.sleep(2.5)
    assert not (tmp_path / "ulx3s-85f" / "planner" / "seed-2" / "chip.config").exists()

    (tmp_path / "calls").unlink()
    assert main(arguments) == 0
    assert [call[0] for call in calls(tmp_path)] == ["nextpnr-ecp5", "ecppack"]
    assert (tmp_path / "ulx3s-85f" / "planner" / "chip.bit").read_text() == "2"


def test_refuses_a_board_without_open_tools(monkeypatch, tmp_path):
    monkeypatch.setattr(flow, "prepare", lambda board, folder: [["vivado", "-mode", "batch"]])
    with pytest.raises(
        BuildError,
        match=r"^arty-a7-100 needs vivado, which does not come with the project: run build_chip.sh",
    ):
        build(find_board("arty-a7-100"), tmp_path)
