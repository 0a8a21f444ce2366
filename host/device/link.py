"""Commands and answers of ``protocol`` over a line that may lose or damage bytes."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from pathgene.hdl.protocol.codec import (
    BODY_HEADER_BYTES,
    CRC_BYTES,
    DELIMITER,
    Frame,
    FrameError,
    FrameSplitter,
    decode_frame,
    encode_frame,
)
from pathgene.hdl.protocol.codes import Command, Status
from pathgene.host.device.link_errors import (
    LinkError,
    LinkTimeoutError,
    RefusedError,
    lost,
    name_of,
    taken,
)
from pathgene.host.device.transport import Traffic, Transport
from pathgene.host.device.window import Request, Window, take


__all__ = ["Link", "LinkError", "LinkTimeoutError", "RefusedError"]

#: Maximum commands in flight. The chip can tell the latest 127 commands from new ones.
_WINDOW = 64
#: Attempts at a request before its shorter form is used.
_ATTEMPTS_BEFORE_SHORTER = 4
#: An attempt ends after this many timeouts even if bytes keep arriving.
_MAXIMUM_TIMEOUTS = 8
#: Ends a frame if the chip's receiver has only its beginning.
_FLUSH = bytes([DELIMITER])
#: Session of a chip after a reset. A link never uses it, because it could not notice a reset there.
_RESET_SESSION = 0
_LAST_SESSION = 255
#: Sequence number of OPEN, which is outside the order of commands. The first commands of the
#: session have lower numbers, so that a late, repeated reply to OPEN is not taken for a reply to
#: one of them.
_OPENING = 255


class Link:
    """The host's end of the line.

    The chip executes every command exactly once and in order, and every call ends, whatever
    happens on the line. A wait ends with a good frame, after ``timeout_s`` of silence, or after 8
    times that if bytes keep arriving. The link then repeats the commands that have no answer. After
    ``attempts`` consecutive waits without progress it raises :class:`LinkTimeoutError`. The time
    that the port needs to accept the bytes of a frame does not count, but it is limited too: a
    write that takes as long as all attempts raises :class:`LinkTimeoutError`.

    An interrupt ends the session, and so does every error except the refusal of a :meth:`request`:
    it is then unknown whether the chip executed the last command. :meth:`reopen` starts the next
    session.

    Parameters
    ----------
    transport : Transport
        An open port, closed with the link. Its ``timeout`` and ``write_timeout`` are set here.
    timeout_s : float
        Seconds of silence after which a frame counts as lost. It must exceed the board's longest
        computation plus the time on the line of the bytes that the port buffers.
    attempts : int
        Consecutive waits without progress before the link gives up on the board.
    clock : Callable[[], float]
        Clock that measures the waits: seconds, from any origin.

    Attributes
    ----------
    patience_s : float
        Seconds of silence after which the link gives up on the board.

    Raises
    ------
    LinkError
        From every method that sends: if the port fails, or no session is open.
    """

    def __init__(
        self,
        transport: Transport,
        *,
        timeout_s: float = 0.25,
        attempts: int = 20,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        if timeout_s <= 0:
            raise ValueError(f"Timeout must be above 0 s, not {timeout_s!r}")
        if attempts < 1:
            raise ValueError(f"Attempts must be 1 or more, not {attempts!r}")
        self.timeout_s = timeout_s
        self.attempts = attempts
        self.traffic = Traffic()
        self.session: int | None = None
        self._transport = transport
        self._clock = clock
        self._splitter = FrameSplitter()
        self._questions = 0
        self._latest_session = 0
        self._credit = 0
        self._next = 0
        # The latest command was refused, and the next one gets its number.
        self._is_refused = False
        transport.timeout = timeout_s
        transport.write_timeout = self.patience_s = attempts * timeout_s

    def now(self) -> float:
        """Return the time by the clock of the waits, seconds."""
        return self._clock()

    def close(self) -> None:
        """Close the port."""
        self.session = None
        self._transport.close()

    def info(self) -> bytes:
        """Return the packed :func:`pathgene.hdl.protocol.messages.info_reply` of the chip.

        This needs no session and does not change an open one.

        Raises
        ------
        LinkTimeoutError
            If there is no answer.
        """
        self._questions = (self._questions + 1) % 256
        header = bytes((0, self._questions))
        answer = self._ask(header, Command.INFO, plain=True)
        if answer[0] != Status.OK:
            raise RefusedError(Command.INFO, answer[0])
        return answer[1:]

    def open(self, previous: int, *, credit: int) -> None:
        """Open the session after the chip's latest; 0 is skipped in favour of 1.

        Parameters
        ----------
        previous : int
            The chip's latest session, from :meth:`info`.
        credit : int
            Bytes of bodies and CRCs that the chip can buffer: its ``receive_buffer``.

        Raises
        ------
        LinkTimeoutError
            If there is no answer.
        LinkError
            If another host has opened a session since.
        """
        self.session = None
        self._is_refused = False
        self._latest_session = previous
        self._credit = credit
        session = self._open_next(previous)
        if session == _RESET_SESSION:
            session = self._open_next(session)
        self.session = self._latest_session = session
        self._next = 0

    def reopen(self) -> None:
        """Open the next session; the chip keeps its population and counters.

        Raises
        ------
        LinkTimeoutError
            If there is no answer.
        LinkError
            If the board was reset, or another host has opened a session since. A session after 255,
            the last, is refused, too: its number would be the number of a chip after a reset.
        """
        if self._latest_session == _LAST_SESSION:
            self.session = None
            raise LinkError("The last session with the board cannot be resumed: open it again.")
        self.open(self._latest_session, credit=self._credit)

    def _open_next(self, previous: int) -> int:
        session = (previous + 1) % 256
        answer = self._ask(bytes((session, _OPENING)), Command.OPEN, plain=False)
        if answer[0] != Status.OK:
            raise taken()
        return session

    def request(self, command: int, payload: bytes = b"", *, shorter: bytes | None = None) -> bytes:
        """Send one command and return the payload of its answer.

        Parameters
        ----------
        payload : bytes
            Its payload, at most the chip's receive buffer less 7 bytes.
        shorter : bytes, optional
            Alternative payload of the same command with a shorter answer. The link sends it after 4
            attempts, because a bad line may never transfer a long answer. The chip executes the
            command once, whichever payload arrives first, and answers the latest payload. The
            caller must distinguish the two answers, preferably by their length.

        Raises
        ------
        RefusedError
            If the chip refuses the command. The session stays open if there is no ``shorter``.
        LinkTimeoutError
            If there is no answer; it is then unknown whether the chip executed the command.
        """
        payloads = (payload,) if shorter is None else (payload, shorter)
        return self._deliver([Request(command, payloads)])[0]

    def transfer(self, commands: Sequence[tuple[int, bytes]]) -> list[bytes]:
        """Send many commands without waiting for each answer; return the answers' payloads.

        An answer confirms all earlier commands, so the answer of an executed command can be lost
        for good. The link then sends that command again as a new one. Therefore it must be safe to
        repeat and reorder the commands, as it is for ``READ`` and for ``WRITE`` to different slots.

        Parameters
        ----------
        commands : sequence of (int, bytes)
            Code and payload of each, at most the chip's receive buffer less 7 bytes.

        Raises
        ------
        RefusedError
            If the chip refuses a command; it has not executed the commands after it either.
        LinkTimeoutError
            If there is no answer.
        """
        return self._deliver([Request(code, (payload,)) for code, payload in commands])

    def poll(self, command: int) -> tuple[bytes | None, bytes | None]:
        """Send a command and STATUS at once, and wait for both.

        Returns
        -------
        (bytes or None, bytes or None)
            Payloads of both answers. If the chip is busy and refuses the command, both are None,
            and the session stays open. On a bad line an answer may be missing, too.

        Raises
        ------
        RefusedError
            If the chip refuses the command for another reason.
        LinkTimeoutError
            If there is no answer.
        """
        polled, status = Request(command, (b"",), is_poll=True), Request(Command.STATUS, (b"",))
        try:
            self._wait_for([polled, status])
        except RefusedError:
            if not polled.is_refused:
                raise
            return None, None
        return polled.answer, status.answer

    def order(
        self,
        commands: Sequence[tuple[int, bytes]],
        meanwhile: Callable[[], object] = lambda: None,
    ) -> None:
        """Have commands executed exactly once, in order. Their answers carry no payload.

        Parameters
        ----------
        commands : sequence of (int, bytes)
            As for :meth:`transfer`.
        meanwhile : callable
            Called once, when all commands have been sent, before the wait for the answers.

        Raises
        ------
        RefusedError, LinkTimeoutError
            As :meth:`transfer` does.
        """
        self._wait_for([Request(code, (payload,)) for code, payload in commands], meanwhile)

    def _deliver(self, requests: Sequence[Request]) -> list[bytes]:
        missing = list(requests)
        while missing:  # The last command always gets its answer.
            self._wait_for(missing)
            missing = [request for request in missing if request.answer is None]
        return [request.answer or b"" for request in requests]

    def _wait_for(
        self, requests: Sequence[Request], meanwhile: Callable[[], object] = lambda: None
    ) -> None:
        """Wait until the chip has executed the requests, in order."""
        if self.session is None:
            raise LinkError("No session with the board is open; open the board again.")
        room = self._credit - BODY_HEADER_BYTES - CRC_BYTES
        for payload in (payload for request in requests for payload in request.payloads):
            if len(payload) > room:
                raise ValueError(f"Payload must have at most {room} bytes, not {len(payload)}")
        session, self.session = self.session, None
        self.traffic.exchanges += 1
        if self._is_refused and not requests[0].is_poll:
            self._fill_number(session)
        self._is_refused = False
        try:
            self._exchange(session, requests, meanwhile)
        except RefusedError:
            # A refusal leaves its number to the next command, which must not get a late answer to
            # this one: STATUS uses the number up. The same poll may get a late answer.
            self._is_refused = True
            is_alone = len(requests) == 1 and len(requests[0].payloads) == 1
            if is_alone:
                self._fill_number(session)
            if is_alone or requests[0].is_refused:
                self.session = session
            raise
        self._next = (self._next + len(requests)) % 256
        self.session = session

    def _fill_number(self, session: int) -> None:
        """Use the number of a refused command up."""
        self._exchange(session, [Request(Command.STATUS, (b"",), is_filler=True)])
        self._next = (self._next + 1) % 256
        self._is_refused = False

    def _exchange(
        self,
        session: int,
        requests: Sequence[Request],
        meanwhile: Callable[[], object] = lambda: None,
    ) -> None:
        """Send ``requests`` until the last has its answer: go-back-N within the credit."""
        window = Window(self._next)
        is_awaited = False
        silences = 0
        deadline = self._deadline()
        while window.confirmed < len(requests):
            before = self._clock()
            self._fill(session, requests, window, silences)
            if not is_awaited and window.sent == len(requests):
                is_awaited = True
                meanwhile()
            deadline += self._clock() - before
            confirmed = window.confirmed
            frames = self._receive(deadline)
            for body, plain in frames:
                if not plain and body[0] == session:
                    take(requests, window, body)
            if window.confirmed > confirmed:
                silences = 0
                deadline = self._deadline()
            elif not frames:
                silences += 1
                if silences == self.attempts:
                    raise self._timeout(requests[window.confirmed].code)
                window.start_again()
                deadline = self._deadline()

    def _fill(
        self, session: int, requests: Sequence[Request], window: Window, silences: int
    ) -> None:
        """Send as many requests as the window and the chip's buffer have room for."""
        while window.cursor < min(len(requests), window.confirmed + _WINDOW):
            index = window.cursor
            request = requests[index]
            form = min(silences // _ATTEMPTS_BEFORE_SHORTER, len(request.payloads) - 1)
            sequence = (window.first + index) % 256
            body = bytes((session, sequence, request.code)) + request.payloads[form]
            size = len(body) + CRC_BYTES
            if window.in_flight and window.bytes_in_flight + size > self._credit:
                break
            self._send(body, repeated=index < window.sent, flush=window.flush)
            window.note_sent(size)

    def _ask(self, header: bytes, command: Command, *, plain: bool) -> bytes:
        """Send a command that is outside the order; return its answer from the status on."""
        question = header + bytes([command])
        for attempt in range(self.attempts):
            self._send(question, repeated=attempt > 0, flush=True, plain=plain)
            deadline = self._deadline()
            while frames := self._receive(deadline):
                for body, is_plain in frames:
                    # A frame equal to the question is an echo of the line.
                    if body != question and is_plain == plain and body[: len(header)] == header:
                        return body[len(header) :]
        raise self._timeout(command)

    def _send(self, body: bytes, *, repeated: bool, flush: bool, plain: bool = False) -> None:
        data = (_FLUSH if flush else b"") + encode_frame(body, plain=plain)
        self.traffic.bytes_to_board += len(data)
        self.traffic.frames_to_board += 1
        self.traffic.frames_repeated += repeated
        before = self._clock()
        try:
            self._transport.write(data)
        except TimeoutError:
            raise LinkTimeoutError(
                f"The board took no bytes for {self.patience_s:g} s: check that it runs, and the "
                "cable."
            ) from None
        except OSError as error:
            raise lost(error) from None
        self.traffic.waiting_s += self._clock() - before

    def _receive(self, deadline: float) -> list[Frame]:
        """Return good frames as soon as any arrive, or none after silence or at the deadline."""
        while (before := self._clock()) < deadline:
            try:
                data = self._transport.read(self._transport.in_waiting or 1)
            except OSError as error:
                raise lost(error) from None
            self.traffic.waiting_s += self._clock() - before
            self.traffic.bytes_from_board += len(data)
            if not data:
                break
            if frames := self._decode(data):
                return frames
        self._splitter.drop()
        return []

    def _decode(self, data: bytes) -> list[Frame]:
        frames = []
        for encoded in self._splitter.feed(data):
            try:
                frames.append(decode_frame(encoded))
            except FrameError:
                self.traffic.frames_damaged += 1
        self.traffic.frames_from_board += len(frames)
        return frames

    def _deadline(self) -> float:
        return self._clock() + _MAXIMUM_TIMEOUTS * self.timeout_s

    def _timeout(self, command: int) -> LinkTimeoutError:
        return LinkTimeoutError(
            f"The board did not answer {name_of(Command, command)} in {self.attempts} attempts of "
            f"{self.timeout_s:g} s: check its power, the cable and the line rate."
        )
