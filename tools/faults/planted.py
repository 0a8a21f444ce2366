"""Bugs to plant in the product, one at a time; the judge must notice each."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any
from unittest import mock

from cobs import cobs

from pathgene.hdl.config import Config
from pathgene.hdl.protocol import codec
from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES, CRC_BYTES, Frame, FrameError
from pathgene.hdl.protocol.codes import StickyError
from pathgene.hdl.protocol.messages import info_reply
from pathgene.host import interrupts
from pathgene.host.compare.store import RunStore
from pathgene.host.device import link
from pathgene.host.device.chip_map import MapCopy
from pathgene.host.device.link import Link, LinkError, LinkTimeoutError
from pathgene.host.device.window import Request
from pathgene.host.errors import InputError
from pathgene.host.files import replacement
from pathgene.host.files.disk import current
from pathgene.sim.model.chip import Chip
from tools.faults.blind import BLIND
from tools.faults.edits import edited
from tools.faults.later import LATER


#: The place of a session in the reply to INFO is the same for all chips.
_ANY = Config()

Patch = contextlib.AbstractContextManager[Any]


def _lost_acknowledgement_accepted() -> Patch:
    """Silence counts as an acknowledgement."""
    usual = Link._exchange

    def exchange(self: Link, session: int, requests: Sequence[Request]) -> None:
        with mock.patch.object(self, "attempts", 1):
            try:
                usual(self, session, requests)
            except LinkTimeoutError:
                for request in requests:
                    request.answer = request.answer or b""

    return mock.patch.object(Link, "_exchange", exchange)


def _sequence_number_reused() -> Patch:
    """After commands are sent again, their sequence numbers are reused."""
    usual = Link._exchange

    def exchange(self: Link, session: int, requests: Sequence[Request]) -> None:
        before = self.traffic.frames_repeated
        usual(self, session, requests)
        if self.traffic.frames_repeated > before:
            self._next = (self._next - len(requests)) % 256

    return mock.patch.object(Link, "_exchange", exchange)


def _checksum_ignored() -> Patch:
    """A frame from the board with a wrong checksum is accepted."""
    usual = codec.decode_frame

    def decode(encoded: bytes) -> Frame:
        try:
            return usual(encoded)
        except FrameError:
            try:
                body = cobs.decode(encoded)[:-CRC_BYTES]
            except cobs.DecodeError:
                raise FrameError(StickyError.CRC) from None
            if len(body) < BODY_HEADER_BYTES:
                raise
            return body, False

    return mock.patch("pathgene.host.device.link.decode_frame", decode)


def _board_taken_back_in_silence() -> Patch:
    """A board that was reset is opened again, and the command continues there."""
    usual = Link._exchange

    def exchange(self: Link, session: int, requests: Sequence[Request]) -> None:
        try:
            usual(self, session, requests)
        except LinkTimeoutError:
            raise
        except LinkError:
            left = [request for request in requests if request.answer is None]
            self.open(info_reply(_ANY).unpack(self.info())["session"], credit=self._credit)
            usual(self, self._latest_session, left)

    return mock.patch.object(Link, "_exchange", exchange)


def _map_believed_after_a_reset() -> Patch:
    """A session is reopened on a board that was reset, and its map is assumed unchanged."""

    def reopen(self: Link) -> None:
        self.open(info_reply(_ANY).unpack(self.info())["session"], credit=self._credit)

    return mock.patch.object(Link, "reopen", reopen)


def _map_known_before_it_is_acknowledged() -> Patch:
    """The cells of an upload count as known before the chip has them."""
    usual = MapCopy._send

    def send(
        self: MapCopy, frames: Any, heights: Any, x: int, y: int, progress: Any = None
    ) -> None:
        try:
            usual(self, frames, heights, x, y, progress)
        finally:
            for _, (rows, columns) in frames:
                self._heights[rows, columns] = heights[
                    rows.start - y : rows.stop - y, columns.start - x : columns.stop - x
                ]

    return mock.patch.object(MapCopy, "_send", send)


def _no_limit_of_silence() -> Patch:
    """The link resends forever."""
    usual = Link.__init__

    def init(self: Link, *arguments: Any, **options: Any) -> None:
        usual(self, *arguments, **options)
        self.attempts = 1 << 60

    return mock.patch.object(Link, "__init__", init)


def _command_repeated_by_the_chip() -> Patch:
    """The chip executes a repeated command again."""
    usual = Chip._generate

    def generate(self: Chip, payload: bytes, repeated: bool) -> bytes:
        return usual(self, payload, False)

    return mock.patch.object(Chip, "_generate", generate)


def _file_written_in_its_place() -> Patch:
    """The files of a run are written directly to their final places, one by one."""

    def replace_files(directory: Path, contents: Any, *, gone: Any = ()) -> None:
        for name, content in contents.items():
            if (directory / name).exists():
                current().unlink(directory / name)
            with current().create(directory / name) as file:
                file.write(content)
        for name in set(gone) - set(contents):
            if (directory / name).exists():
                current().unlink(directory / name)

    return mock.patch("pathgene.host.report.write.replace_files", replace_files)


def _torn_line_taken_for_whole() -> Patch:
    """A stored run is appended to the truncated line of an earlier one."""
    usual = RunStore._read

    def read(self: RunStore) -> None:
        with mock.patch.object(self, "_file", _Unwritten(self._file)):
            usual(self)

    return mock.patch.object(RunStore, "_read", read)


class _Unwritten:
    """A file that does not accept bytes."""

    def __init__(self, file: Any) -> None:
        self._file = file

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)

    def __iter__(self) -> Iterator[bytes]:
        return iter(self._file)

    def write(self, data: bytes) -> int:
        """Accept no bytes."""
        return len(data)


def _lost_run_counted() -> Patch:
    """A run whose storing fails counts as stored."""
    usual = RunStore.add

    def add(self: RunStore, entrant: Any, seed: int, record: Any) -> Any:
        try:
            return usual(self, entrant, seed, record)
        except InputError:
            return record

    return mock.patch.object(RunStore, "add", add)


class _Lazy:
    """The current disk, which does not sync files."""

    def __getattr__(self, name: str) -> Any:
        return getattr(current(), name)

    def sync(self, file: Any) -> None:
        """Only hand the bytes to the system."""
        file.flush()


def _mixture_accepted() -> Patch:
    """A run is read although a file next to its summary is of another run."""
    return mock.patch("pathgene.host.report.read.verify", return_value=None)


def _file_not_synced() -> Patch:
    """A new file is renamed into its place before the disk has its bytes."""
    return mock.patch("pathgene.host.files.replacement.current", _Lazy)


def _folder_not_synced() -> Patch:
    """A run counts as written before the disk has the names of its files."""
    return mock.patch("pathgene.host.files.replacement.sync_names", return_value=None)


def _stored_run_not_synced() -> Patch:
    """A run counts as stored before the disk has its line."""
    return mock.patch("pathgene.host.compare.store.current", _Lazy)


def _name_of_stored_runs_not_synced() -> Patch:
    """Runs count as stored before the disk has the name of their file."""
    return mock.patch("pathgene.host.compare.store.sync_names", return_value=None)


def _older_files_not_put_back() -> Patch:
    """A failed replacement leaves the files that it has renamed."""
    return mock.patch.object(replacement._Change, "undo", return_value=True)


def _refusal_to_put_back_not_told() -> Patch:
    """A replacement hides that the disk has refused to put older files back."""
    usual = replacement._Change.undo

    def undo(self: Any) -> bool:
        usual(self)
        return True

    return mock.patch.object(replacement._Change, "undo", undo)


def _obsolete_files_left() -> Patch:
    """The files that a new run does not have stay."""
    usual = replacement.replace_files

    def replace_files(directory: Path, contents: Any, *, gone: Any = ()) -> None:
        usual(directory, contents)

    return mock.patch("pathgene.host.report.write.replace_files", replace_files)


def _hidden_files_left() -> Patch:
    """The hidden files of a killed process stay."""
    return mock.patch.object(replacement, "_left", return_value={})


def _stored_runs_not_read() -> Patch:
    """A comparison repeats the runs that it has stored."""
    return mock.patch.object(RunStore, "get", return_value=None)


def _signal_forgotten() -> Patch:
    """A signal that is held back has no effect."""

    @contextlib.contextmanager
    def held() -> Iterator[None]:
        with interrupts.instead(lambda: None):
            yield

    return mock.patch.object(interrupts, "held", held)


def _last_session_resumed() -> Patch:
    """A session is resumed after 255, too."""
    return mock.patch.object(link, "_LAST_SESSION", -1)


def _given_up_at_the_first_silence() -> Patch:
    """A single lost frame ends the session."""
    usual = Link._exchange

    def exchange(self: Link, session: int, requests: Sequence[Request]) -> None:
        with mock.patch.object(self, "attempts", 1):
            usual(self, session, requests)

    return mock.patch.object(Link, "_exchange", exchange)


#: Bugs by name.
PLANTED: dict[str, Callable[[], Patch]] = {
    function.__name__[1:].replace("_", " "): function
    for function in (
        _lost_acknowledgement_accepted,
        _sequence_number_reused,
        _checksum_ignored,
        _board_taken_back_in_silence,
        _map_believed_after_a_reset,
        _map_known_before_it_is_acknowledged,
        _no_limit_of_silence,
        _command_repeated_by_the_chip,
        _file_written_in_its_place,
        _torn_line_taken_for_whole,
        _lost_run_counted,
        _mixture_accepted,
        _file_not_synced,
        _folder_not_synced,
        _stored_run_not_synced,
        _name_of_stored_runs_not_synced,
        _older_files_not_put_back,
        _refusal_to_put_back_not_told,
        _obsolete_files_left,
        _hidden_files_left,
        _stored_runs_not_read,
        _signal_forgotten,
        _given_up_at_the_first_silence,
        _last_session_resumed,
    )
} | {name: functools.partial(edited, edit) for name, edit in (BLIND | LATER).items()}


def planted(name: str) -> Patch:
    """Return a context manager that plants a bug in its block."""
    return PLANTED[name]()
