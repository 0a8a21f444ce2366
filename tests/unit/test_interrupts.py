"""Ctrl-C, and signals with the same effect."""

import _imp
import os
import signal
import subprocess
import sys
import time
from importlib.machinery import ExtensionFileLoader
from pathlib import Path

import pytest

from pathgene.host import interrupts
from pathgene.sim.compiler import run_tool
from tests.support.host.processes import Started


ROOT = Path(__file__).resolve().parents[2]
NUMBERS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT]


def raised(number):
    """Return whether the signal raises KeyboardInterrupt, and the exit status after it."""
    try:
        signal.raise_signal(number)
    except KeyboardInterrupt:
        return interrupts.status()
    return None


@pytest.mark.parametrize("number", NUMBERS)
def test_catches_signals_and_restores_handlers(number):
    before = signal.getsignal(number)
    with interrupts.caught():
        assert interrupts.status(default=7) == 7
        assert raised(number) == 128 + number
    assert signal.getsignal(number) is before


def test_an_ignored_signal_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with interrupts.caught(), interrupts.instead(lambda: pytest.fail("it was ignored")):
            assert raised(signal.SIGHUP) is None
    finally:
        signal.signal(signal.SIGHUP, before)


def test_a_second_signal_keeps_the_status():
    calls = []
    with interrupts.caught(), interrupts.instead(lambda: calls.append(1)):
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGTERM)
        assert len(calls) == 1
        time.sleep(0.15)
        signal.raise_signal(signal.SIGHUP)
        assert len(calls) == 2
        assert interrupts.status() == 128 + signal.SIGTERM


class _Signaling:
    """An object at whose end a signal arrives."""

    def __init__(self, number):
        self.number = number

    def __del__(self):
        signal.raise_signal(self.number)


@pytest.mark.parametrize("number", NUMBERS)
def test_an_interrupt_of_a_destructor_is_not_lost(number):
    def interrupted():
        held = _Signaling(number)
        del held
        deadline = time.monotonic() + 10
        while time.monotonic() < deadline:
            pass

    hook = sys.unraisablehook
    with interrupts.caught():
        with pytest.raises(KeyboardInterrupt):
            interrupted()
        assert interrupts.status() == 128 + number
    assert sys.unraisablehook is hook


INSIDE_INITIALISATION = """
import enum, importlib.machinery, importlib.util, pathlib, signal, sys
from pathgene.host import interrupts

def trace(frame, event, argument):
    if frame.f_code.co_filename == enum.__file__:
        sys.settrace(None)
        signal.raise_signal(signal.SIGHUP)

# The part of Matplotlib that creates enumerations while it is initialised.
folder, = importlib.util.find_spec("matplotlib").submodule_search_locations
file = pathlib.Path(folder, "ft2font" + importlib.machinery.EXTENSION_SUFFIXES[0])
spec = importlib.util.spec_from_file_location("ft2font", file)
with interrupts.caught():
    try:
        sys.settrace(trace)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        assert sys.gettrace() is None
        while True:
            pass
    except KeyboardInterrupt:
        assert module.FT2Font
sys.exit(interrupts.status())
"""


def test_an_interrupt_waits_until_an_extension_module_is_initialised():
    """The module turns an exception in its initialisation into an ``ImportError``."""
    command = [sys.executable, "-c", INSIDE_INITIALISATION]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (128 + signal.SIGHUP, "")


@pytest.mark.parametrize("method", ["create", "exec"])
def test_an_endless_initialisation_is_interrupted(monkeypatch, method):
    def initialise(*_arguments):
        signal.raise_signal(signal.SIGTERM)
        time.sleep(60)

    monkeypatch.setattr(_imp, f"{method}_dynamic", initialise)
    began = time.monotonic()
    with interrupts.caught():
        with pytest.raises(KeyboardInterrupt):
            getattr(ExtensionFileLoader("endless", "endless.so"), f"{method}_module")(None)
        assert interrupts.status() == 128 + signal.SIGTERM
    assert 0.9 < time.monotonic() - began < 30


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_other_errors_of_a_destructor_are_reported_as_usual(monkeypatch):
    class Broken:
        def __del__(self):
            raise ValueError("broken")

    reported = []
    monkeypatch.setattr(sys, "unraisablehook", lambda lost: reported.append(lost.exc_type))
    with interrupts.caught():
        Broken()
    assert reported == [ValueError]


@pytest.mark.parametrize("number", NUMBERS)
def test_a_held_signal_arrives_afterwards(number):
    steps = []

    def interrupted():
        with interrupts.held():
            signal.raise_signal(number)
            # As if a different thread had received it.
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {number})
            signal.raise_signal(number)
            steps.append("end of the block")
        steps.append("after it")

    with interrupts.caught():
        handler = signal.getsignal(number)
        with pytest.raises(KeyboardInterrupt):
            interrupted()
        assert signal.getsignal(number) is handler
    assert steps == ["end of the block"]
    assert number not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_children_of_a_held_block_ignore_only_ctrl_c():
    with interrupts.held():
        child = Started(["sleep", "60"])
    with child:
        for number in (signal.SIGINT, signal.SIGHUP, signal.SIGQUIT):
            child.send_signal(number)
        with pytest.raises(subprocess.TimeoutExpired):
            child.wait(0.2)
        child.terminate()
        assert child.wait(10) == -signal.SIGTERM


def test_an_interrupted_tool_leaves_no_process(tmp_path):
    def interrupt(_signal, _frame):
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.5)
    try:
        with pytest.raises(KeyboardInterrupt):
            run_tool(["sh", "-c", "sleep 60 & echo $! > child; wait"], cwd=tmp_path, what="It")
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    child = (tmp_path / "child").read_text().strip()
    for _ in range(50):
        if has_ended(child):
            return
        time.sleep(0.1)
    pytest.fail("The tool's own child still runs.")


def has_ended(pid):
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return True
    return state == "Z"


INSIDE_EXEC = """
import sys
from pathgene.host import interrupts

with interrupts.caught():
    try:
        exec("import os, signal; os.kill(os.getpid(), signal.SIGTERM)")
    except KeyboardInterrupt:
        pass
sys.exit(interrupts.status())
"""


def test_an_interrupt_within_exec_keeps_its_exit_status(tmp_path):
    """An import executes the code of a dataclass in this way."""
    (tmp_path / "inside.py").write_text(INSIDE_EXEC)
    path = {"PYTHONPATH": f"{ROOT}:{tmp_path}"}
    done = subprocess.run([sys.executable, "-m", "inside"], env={**os.environ, **path}, check=False)
    assert done.returncode == 128 + signal.SIGTERM
