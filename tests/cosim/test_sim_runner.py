import pytest

from pathgene.host.errors import InputError, JobError
from tests.cosim.echo_design import echo_verilog
from tools.lint import lint
from tools.lint import main as lint_main
from tools.runner import BENCHES, CosimError, benches, main, run, run_bench


pytestmark = pytest.mark.cosim

BENCH = """
import os
import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge, Timer

import helper


@cocotb.test()
async def passes(dut):
    Clock(dut.clk, 10, unit="ns").start()
    dut.rst.value = 0
    dut.rx.value = 1
    await Timer(100, "ns")
    dut.rx.value = 0
    await FallingEdge(dut.tx)
    assert helper.ANSWER == 42


@cocotb.test()
async def fails(dut):
    assert False, "as it should"


@cocotb.test()
async def variables(dut):
    print("number", os.environ["NUMBER"], random.randrange(1 << 60))


@cocotb.test()
async def dies(dut):
    os._exit(3)


@cocotb.test()
async def hangs(dut):
    Clock(dut.clk, 10, unit="ns").start()
    await Timer(1, "sec")
"""


@pytest.fixture
def bench(tmp_path):
    (tmp_path / "helper.py").write_text("ANSWER = 42\n")
    path = tmp_path / "cosim_sample.py"
    path.write_text(BENCH)
    return path


@pytest.fixture
def sample(simulator, bench):
    """Function that runs the tests of the bench whose names match."""

    def start(name, **options):
        label = f"sample-{simulator}-{name}"
        filter_ = rf"\.{name}$"
        verilog = echo_verilog()
        return run(
            simulator, verilog, "uart_echo", bench, label=label, test_filter=filter_, **options
        )

    return start


@pytest.mark.ci
def test_returns_tests_and_log(sample):
    result = sample("passes")
    assert result.tests == 1
    assert result.waves is None
    assert "sample.passes passed" in result.log.read_text()


def test_names_a_failed_test(sample, simulator):
    with pytest.raises(
        CosimError,
        match=rf"^sample-{simulator}-\w+: 1 failed: fails \(as it should\); log \S+\.log$",
    ):
        sample("fails")


@pytest.mark.ci
def test_names_one_failure_among_others(sample):
    with pytest.raises(CosimError, match=r": 1 failed: fails \(as it should\); log"):
        sample("(passes|fails)")


@pytest.mark.ci
def test_refuses_a_run_without_tests(sample, simulator):
    with pytest.raises(CosimError, match=rf"^sample-{simulator}-nosuchtest: no test ran; log \S+$"):
        sample("nosuchtest")


@pytest.mark.ci
def test_variables_and_seed_reach_the_bench(sample):
    texts = []
    for seed in (1, 1, 2):
        log = sample("variables", env={"NUMBER": "7"}, seed=seed).log.read_text()
        texts.append(next(line for line in log.splitlines() if line.startswith("number 7 ")))
    assert texts[0] == texts[1] != texts[2]


def test_reports_a_dying_simulator(sample):
    with pytest.raises(CosimError, match=r": the simulator ended with status 3 before its results"):
        sample("dies")


@pytest.mark.ci
def test_ends_a_hanging_simulator(sample):
    with pytest.raises(CosimError, match=r" did not end within 3 s; its log is \S+\.log$"):
        sample("hangs", timeout_s=3)


def test_reports_a_broken_bench(simulator, bench):
    bench.write_text("import nothing_of_this_name\n")
    with pytest.raises(CosimError):
        run(simulator, echo_verilog(), "uart_echo", bench, label=f"broken-{simulator}")


@pytest.mark.usefixtures("icarus")
def test_waveform_of_icarus(bench):
    result = run(
        "icarus",
        echo_verilog(),
        "uart_echo",
        bench,
        label="sample-waves",
        test_filter=r"\.passes$",
        waves=True,
    )
    assert result.waves.suffix == ".fst"
    assert result.waves.stat().st_size > 100


@pytest.mark.long  # Builds the run-time library and the chip again.
def test_waveform_of_verilator(bench):
    result = run(
        "verilator",
        echo_verilog(),
        "uart_echo",
        bench,
        label="sample-waves",
        test_filter=r"\.passes$",
        waves=True,
    )
    assert "rx_bits" in result.waves.read_text()


def test_refuses_a_bench_without_a_top(bench):
    with pytest.raises(
        InputError,
        match=r"^The bench cosim_sample\.py must say TOP = 'name of a top', not None\.$",
    ):
        run_bench("verilator", bench)


def test_finds_benches(bench):
    assert benches(bench.parent) == {"sample": bench}
    found = list(benches(BENCHES))
    assert found == ["chip", "uart"]


def test_refuses_an_unknown_bench(capsys):
    assert main(["--bench", "nosuchbench"]) == 2
    assert capsys.readouterr().err.startswith("error: No bench 'nosuchbench'; choose from ")


def test_lint_accepts_amaranths_verilog(tmp_path):
    path = tmp_path / "uart_echo.v"
    path.write_text(echo_verilog())
    assert lint_main([str(path)]) == 0


@pytest.mark.parametrize(
    ("body", "warning"),
    [
        ("assign q = d;", "WIDTHTRUNC"),  # Loses a bit.
        ("wire n; assign q = d[0] & d[1] & n;", "UNDRIVEN"),
        ("reg r; always @* if (d[0]) r = d[1]; assign q = r;", "LATCH"),
        ("assign q = ~loop; wire loop = d[0] & d[1] & q;", "UNOPTFLAT"),
        ("assign q = d[0];", "UNUSEDSIGNAL"),
    ],
)
def test_lint_finds_faults(tmp_path, body, warning):
    path = tmp_path / "faulty.v"
    path.write_text(f"module faulty (input [1:0] d, output q);\n{body}\nendmodule\n")
    with pytest.raises(JobError, match=r"^Lint of faulty\.v failed with status 1: ") as caught:
        lint(path)
    assert warning in caught.value.__notes__[0]
