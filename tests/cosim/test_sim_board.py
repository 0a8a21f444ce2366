import os
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import serial

from pathgene.host.errors import InputError, JobError
from pathgene.sim.board import SimulatedBoard, build_program, open_simulated
from tests.cosim.echo_design import byte_echo_verilog, echo_verilog


pytestmark = pytest.mark.cosim

ROOT = Path(__file__).resolve().parents[2]
CLOCKS_PER_BIT = 4


@pytest.fixture(scope="session")
def echo():
    """Program of the Verilated echo chip."""
    return build_program("verilator", echo_verilog(CLOCKS_PER_BIT), "uart_echo", CLOCKS_PER_BIT)


def gone(pid, within_s=5.0):
    """Wait until the process has ended; return False if it has not after ``within_s``."""
    deadline = time.monotonic() + within_s
    while time.monotonic() < deadline:
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except FileNotFoundError:
            return True
        if state == "Z":
            return True
        time.sleep(0.01)
    return False


def exchange(port, data):
    """Send ``data`` in a thread while its echo is read; return the echo."""
    writer = threading.Thread(target=port.write, args=(data,))
    writer.start()
    received = port.read(len(data))
    writer.join()
    return received


@pytest.mark.parametrize("clocks_per_bit", [4, 7])
def test_echo(simulator, clocks_per_bit):
    data = random.Random(1).randbytes({"verilator": 20_000, "icarus": 300}[simulator])
    with (
        open_simulated(
            f"sim:?sim={simulator}",
            lambda divisor: echo_verilog(divisor, offset=1),
            top="uart_echo",
            clocks_per_bit=clocks_per_bit,
        ) as board,
        board.open(timeout=30) as port,
    ):
        expected = bytes((byte + 1) & 0xFF for byte in data)
        assert exchange(port, data) == expected
        board.close()
        assert board.log().endswith("0 line errors\n")


def test_echo_of_a_byte_wide_port(simulator):
    data = random.Random(4).randbytes({"verilator": 200_000, "icarus": 3_000}[simulator])
    with (
        open_simulated(
            f"sim:?sim={simulator}",
            lambda _: byte_echo_verilog(offset=1),
            top="byte_echo",
            clocks_per_bit=0,
        ) as board,
        board.open(timeout=30) as port,
    ):
        start = board.cycles()
        assert exchange(port, data) == bytes((byte + 1) & 0xFF for byte in data)
        if simulator == "icarus":
            # A UART would need ten bits of four cycles for each byte.
            assert board.cycles() - start < 40 * len(data)
        board.close()
        told = f"{len(data)} bytes to the chip, {len(data)} bytes from it, 0 line errors\n"
        assert board.log().endswith(told)


def test_line_runs_at_full_rate(echo):
    # Without pauses, a byte takes 10 bits; its echo follows one byte and a few cycles later.
    with SimulatedBoard(echo, idle_clocks=0) as board, board.open(timeout=30) as port:
        start = board.cycles()
        port.write(bytes(1000))
        port.read(1000)
        port.close()
        assert board.wait(10) == 0
        used = int(board.log().split()[1]) - start
    frames = 1000 * 10 * CLOCKS_PER_BIT
    # The bridge polls every 64 cycles, runs slowly before the first byte, and ends between polls.
    assert frames <= used <= frames + 64 * 100


@pytest.mark.ci
def test_real_divisor():
    with (
        open_simulated(
            "sim:?clocks_per_bit=868", echo_verilog, top="uart_echo", clocks_per_bit=4
        ) as board,
        board.open(timeout=30) as port,
    ):
        assert exchange(port, b"\x00\xff\x55\xaa\x01") == b"\x00\xff\x55\xaa\x01"
        assert board.cycles() >= 5 * 10 * 868


def test_pyserial_connects(echo):
    with SimulatedBoard(echo) as board, serial.serial_for_url(board.url, timeout=10) as port:
        port.write(b"hello")
        assert port.read(5) == b"hello"


def test_pseudo_terminal(echo):
    every_byte = bytes(range(256))  # Raw: no byte is a control character.
    with SimulatedBoard(echo, pty=True) as board:
        for _ in range(2):  # The board keeps running when the terminal is closed.
            with serial.Serial(board.url, timeout=10) as port:
                assert exchange(port, every_byte) == every_byte
        with pytest.raises(
            JobError, match=rf"^The simulated board serves a terminal; open {board.url} instead\.$"
        ):
            board.open()


def test_slow_reader_loses_nothing(echo):
    data = random.Random(2).randbytes(60_000)
    with SimulatedBoard(echo) as board, board.open(timeout=30) as port:
        port.write(data)
        time.sleep(0.3)
        assert port.read(len(data)) == data


def test_ends_with_its_client(echo):
    with SimulatedBoard(echo) as board:
        board.open().close()
        assert board.wait(10) == 0
        with pytest.raises(
            JobError, match=r"^The simulated board ended with status 0: \d+ cycles in .* errors\.$"
        ):
            board.check()


def test_keeps_its_state_for_the_next_client(echo):
    with SimulatedBoard(echo, keep=True) as board:
        cycles = 0
        for text in (b"first", b"second"):
            with board.open(timeout=10) as port:
                assert exchange(port, text) == text
                assert board.cycles() > cycles
                cycles = board.cycles()
        assert board.wait(0.2) is None


def processor_seconds(pid):
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def test_idle_board_runs_slowly(echo):
    with SimulatedBoard(echo, idle_clocks=10_000) as board, board.open(timeout=10) as port:
        exchange(port, b"x")
        time.sleep(0.1)  # 10,000 cycles take a few milliseconds.
        used, cycles = processor_seconds(board.pid), board.cycles()
        time.sleep(0.5)
        assert processor_seconds(board.pid) - used <= 0.1
        assert 64 <= board.cycles() - cycles <= 64 * 100
        start = time.monotonic()
        assert exchange(port, b"y") == b"y"  # It wakes immediately.
        assert time.monotonic() - start < 0.5


def test_killed_simulator(echo):
    with SimulatedBoard(echo) as board, board.open(timeout=10) as port:
        os.kill(board.pid, signal.SIGKILL)
        sentence = r"^The simulated board ended with signal SIGKILL: it printed nothing\.$"
        with pytest.raises(JobError, match=sentence):
            port.read()
        with pytest.raises(JobError, match=sentence):
            board.cycles()
        with pytest.raises(JobError, match=sentence):
            board.open()


def test_hanging_simulator_is_ended(echo):
    with SimulatedBoard(echo, timeout_s=5) as board:
        os.kill(board.pid, signal.SIGSTOP)
        board.timeout_s = 0.2
        with pytest.raises(
            JobError, match=r"^The simulated board did not answer for 0\.2 s and was ended\.$"
        ):
            board.cycles()
        assert gone(board.pid)


def test_terminated_simulator_prints_its_totals(simulator):
    program = build_program(simulator, echo_verilog(CLOCKS_PER_BIT), "uart_echo", CLOCKS_PER_BIT)
    with SimulatedBoard(program) as board:
        os.kill(board.pid, signal.SIGTERM)
        assert board.wait(10) == 0
        assert "bytes to the chip" in board.log()


def test_close_leaves_no_process(simulator):
    program = build_program(simulator, echo_verilog(CLOCKS_PER_BIT), "uart_echo", CLOCKS_PER_BIT)
    board = SimulatedBoard(program)
    board.close()
    board.close()
    assert gone(board.pid)


def test_forgotten_board_ends(echo):
    board = SimulatedBoard(echo)
    pid = board.pid
    del board
    assert gone(pid)


ORPHAN = """
import os, signal, sys
from pathgene.sim.board import SimulatedBoard, build_program
from tests.cosim.echo_design import echo_verilog
board = SimulatedBoard(build_program(sys.argv[1], echo_verilog(4), "uart_echo", 4))
print(board.pid, flush=True)
os.kill(os.getpid(), getattr(signal, sys.argv[2]))
"""


@pytest.mark.parametrize("name", ["SIGKILL", "SIGTERM"])
def test_dies_with_its_parent(simulator, name):
    done = subprocess.run(
        [sys.executable, "-c", ORPHAN, simulator, name],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        check=False,
    )
    assert done.returncode == -getattr(signal, name)
    assert gone(int(done.stdout))


def test_busy_address(echo):
    with SimulatedBoard(echo) as board:
        address = board.url.removeprefix("socket://")
        with pytest.raises(
            JobError,
            match=rf"^The simulated board ended with status 2: cannot listen on {address}: "
            r"Address already in use\.$",
        ):
            SimulatedBoard(echo, listen=address)


@pytest.mark.ci
def test_waveform(simulator, tmp_path):
    trace = tmp_path / "board.vcd"
    with (
        open_simulated(
            f"sim:?sim={simulator}&trace={trace}",
            echo_verilog,
            top="uart_echo",
            clocks_per_bit=CLOCKS_PER_BIT,
        ) as board,
        board.open(timeout=30) as port,
    ):
        assert exchange(port, b"\x5a") == b"\x5a"
        board.close()
    assert "$enddefinitions" in trace.read_text()
    assert "rx_bits" in trace.read_text()


@pytest.mark.ci
def test_framing_errors_are_reported():
    verilog = echo_verilog(CLOCKS_PER_BIT, bad_stop=True)
    program = build_program("verilator", verilog, "uart_echo", CLOCKS_PER_BIT)
    with SimulatedBoard(program) as board, board.open(timeout=0.2) as port:
        port.write(b"a")
        assert port.read() == b""
        board.close()
        log = board.log().splitlines()
    assert log[0].startswith("simulator: a framing error on the chip's tx at cycle ")
    assert log[-1].endswith("1 bytes to the chip, 0 bytes from it, 1 line errors")


def test_refused_design(simulator):
    with pytest.raises(JobError, match=r"^(Icarus Verilog|Verilator) failed with status \d+: .*"):
        build_program(simulator, "module uart_echo(input clk; endmodule", "uart_echo", 4)


def test_unknown_option_starts_nothing():
    with pytest.raises(InputError, match=r"^The simulated board has no option 'fast'; "):
        open_simulated("sim:?fast=1", echo_verilog, top="uart_echo", clocks_per_bit=4)


LINE_TEST = ROOT / "tests" / "cosim" / "uart_line.cpp"


@pytest.mark.parametrize("clocks_per_bit", [2, 3, 4, 33, 868])
def test_line_levels(tmp_path_factory, clocks_per_bit):
    """The driver produces every level of the line, and the sampler reads the same bytes."""
    program = tmp_path_factory.getbasetemp() / "uart_line"
    if not program.exists():
        include = ROOT / "sim" / "board"
        command = ["g++", "-std=c++20", "-Wall", "-Wextra", "-Werror", f"-I{include}"]
        subprocess.run([*command, LINE_TEST, "-o", program], check=True)
    data = b"\x00\xff\x55\xa7"
    idle = 3
    printed = subprocess.run(
        [program, str(clocks_per_bit), data.hex()], capture_output=True, text=True, check=True
    ).stdout.split()
    bits = "".join("0" + f"{byte:08b}"[::-1] + "1" for byte in data)
    levels = "".join(bit * clocks_per_bit for bit in bits) + "1" * idle
    assert printed[0] == levels
    assert printed[1] == data.hex()
    # Half a start bit is a glitch; ten zeros are a frame without a stop bit.
    assert printed[2:] == ["glitch", "framing"]
