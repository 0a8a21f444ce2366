"""Sessions that count the gateware's coverage: of a host, and of random frames."""

from collections.abc import Callable
from dataclasses import dataclass

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import encode_frame
from pathgene.hdl.protocol.codes import Command
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link
from tests.support.gateware import command_fuzz
from tests.support.gateware.command_fuzz import CommandFuzz
from tools.faults.line import FaultyLine, VirtualClock
from tools.faults.line_judge import SESSIONS as HOST_SESSIONS


class Port(FaultyLine):
    """The line of a chip without faults; a read of no bytes takes no time."""

    def __init__(self, chip):
        super().__init__(chip, VirtualClock())
        self.timeout = 0.5

    def read(self, size=1, /):
        """Return at most ``size`` bytes."""
        return super().read(size) if size else b""


def host_session(chip, name, work):
    """Run a session of the fault simulator's host after a reset."""
    chip.feed(b"", reset=1)
    port = Port(chip)
    link = Link(port, timeout_s=0.03, attempts=12, clock=port.clock)
    HOST_SESSIONS[name](Chip(link), work, lambda told: None)


def random_frames(chip, name, seed, frames):
    """Exchange random frames with a chip after power-up; it must answer as the model."""
    CommandFuzz(name, seed, Port(chip)).run(frames)


def many_sessions(chip):
    """Open as many sessions as the number of a session counts, after a reset."""
    chip.feed(b"", reset=1)
    for number in range(1, 260):
        chip.feed(encode_frame(bytes((number % 256, 255, Command.OPEN))))


def paper_sessions(chip):
    """Use the paper core and its checker."""
    random_frames(chip, "paper", 1, 500)
    host_session(chip, "paper", 1)
    many_sessions(chip)


def planner_sessions(chip):
    """Use the planner core."""
    random_frames(chip, "planner", 1, 40)
    host_session(chip, "planner", 1)
    many_sessions(chip)


@dataclass(frozen=True)
class Covered:
    """A chip, and the sessions that it gets after its reset; they take the chip on its line."""

    config: Config
    sessions: Callable[[object], None]


CHIPS = {
    "planner core": Covered(command_fuzz.CHIPS["planner"], planner_sessions),
    "paper core": Covered(command_fuzz.CHIPS["paper"], paper_sessions),
}
