"""The flow of a bitstream, with programs in the tools' places that do what they are told."""

import json
import stat
import sys
import textwrap

import pytest

from hdl.boards import build as flow
from hdl.boards import find_board
from hdl.boards.build import BuildError, Routed, build, main, tool_path


COMMANDS = [
    ["yosys", "-q", "chip.ys"],
    ["nextpnr-ecp5", "--json", "chip.json", "--textcfg", "chip.config"],
    ["ecppack", "--input", "chip.config", "--bit", "chip.bit"],
]
# Appends its arguments to a log; makes the file after each option that names an output.
TOOL = """\
#!{python}
import json, pathlib, sys
name, arguments = {name!r}, sys.argv[1:]
with pathlib.Path("calls").open("a") as calls:
    calls.write(json.dumps([name, *arguments]) + "\\n")
options = dict(zip(arguments, arguments[1:]))
if name == "nextpnr-ecp5":
    seed = int(options["--seed"])
    pathlib.Path(options["--report"]).write_text(json.dumps({{
        "fmax": {{"clock": {{"achieved": {achieved}[seed - 1], "constraint": 100}}}},
        "utilization": {{"DP16KD": {{"used": 192, "available": 208}}}},
    }}))
    pathlib.Path("chip.config").write_text(str(seed))
if name == "ecppack":
    pathlib.Path("chip.bit").write_text(pathlib.Path("chip.config").read_text())
print("the output of", name)
sys.exit({status})
"""


@pytest.fixture
def tools(tmp_path, monkeypatch):
    """Return a function that puts the programs in the tools' places."""

    def install(achieved=(101,), status=0, failing=""):
        for name in ("yosys", "nextpnr-ecp5", "ecppack"):
            program = tmp_path / f"my-{name}"
            program.write_text(
                TOOL.format(
                    python=sys.executable,
                    name=name,
                    achieved=list(achieved),
                    status=status if name == failing else 0,
                )
            )
            program.chmod(program.stat().st_mode | stat.S_IXUSR)
            monkeypatch.setenv(name.upper().replace("-", "_"), str(program))

        def prepare(board, folder):
            folder.mkdir(parents=True, exist_ok=True)
            return COMMANDS

        monkeypatch.setattr(flow, "prepare", prepare)

    return install


def calls(folder):
    return [json.loads(line) for line in (folder / "calls").read_text().splitlines()]


def test_seeds_until_timing_closes(tools, tmp_path):
    tools(achieved=(80, 99.9, 100, 120))
    folder = tmp_path / "out"
    routed = build(find_board("ulx3s-85f"), folder, seeds=range(1, 9))
    assert routed == Routed(seed=3, clocks={"clock": (100, 100)}, cells={"DP16KD": (192, 208)})
    assert [call[0] for call in calls(folder)] == ["yosys", *["nextpnr-ecp5"] * 3, "ecppack"]
    assert (folder / "chip.bit").read_text() == "3"
    report = json.loads((folder / "chip.json").read_text())
    assert report["board"] == "ulx3s-85f"
    assert report["build_id"] == find_board("ulx3s-85f").config.build_id
    assert report["seed"] == 3
    assert report["clocks"] == {"clock": [100, 100]}


def test_no_seed_closes(tools, tmp_path):
    tools(achieved=(80, 99.9, 90))
    with pytest.raises(
        BuildError,
        match=r"^No seed closes timing on ulx3s-85f: the best, 2, reaches 99.9% of what is asked.$",
    ):
        build(find_board("ulx3s-85f"), tmp_path / "out", seeds=range(1, 4))
    assert not (tmp_path / "out" / "chip.bit").exists()


def test_a_tool_that_fails(tools, tmp_path, capfd):
    tools(status=3, failing="yosys")
    folder = tmp_path / "out"
    with pytest.raises(
        BuildError, match=r"^yosys failed with status 3; its output is in .*\.log.$"
    ):
        build(find_board("ulx3s-85f"), folder)
    assert len(calls(folder)) == 1
    assert "the output of yosys" in capfd.readouterr().err


def test_a_tool_that_is_missing(monkeypatch):
    monkeypatch.setenv("NEXTPNR_ECP5", "no-such-program")
    with pytest.raises(BuildError, match=r"^no-such-program is missing; `make bitstream` "):
        tool_path("nextpnr-ecp5")


def test_command_line(tools, tmp_path, capsys):
    tools()
    assert main(["ulx3s-85f", "--out", str(tmp_path)]) == 0
    folder = tmp_path / "ulx3s-85f"
    assert capsys.readouterr().out == textwrap.dedent(f"""\
        clock: 101.0 MHz, 100.0 asked, seed 1
        {folder / "chip.bit"}
    """)
    assert main(["ulx3s", "--out", str(tmp_path)]) == 2
    assert capsys.readouterr().err.startswith("bitstream: BOARD must be one of ulx3s-85f, ")
    tools(achieved=(80,))
    assert main(["ulx3s-85f", "--seeds", "1", "--out", str(tmp_path)]) == 1
    assert "bitstream: No seed closes timing" in capsys.readouterr().err


def test_a_board_without_open_tools(monkeypatch, tmp_path):
    monkeypatch.setattr(flow, "prepare", lambda board, folder: [["vivado", "-mode", "batch"]])
    with pytest.raises(
        BuildError,
        match=r"^arty-a7-100 needs vivado, which does not come with the project: run build_chip.sh",
    ):
        build(find_board("arty-a7-100"), tmp_path)
