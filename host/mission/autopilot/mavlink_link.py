"""A MAVLink 2 connection to one autopilot: heartbeats, requests with answers, retries."""

from __future__ import annotations

import contextlib
import io
import math
import os
import socket
import stat
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError, JobError
from pathgene.host.mission.autopilot.status_texts import StatusTexts
from pathgene.host.numeric import whole


__all__ = ["Link", "NoReplyError", "open_link"]

# Our own address: a ground station.
_SYSTEM, _COMPONENT = 255, 190
_HEARTBEAT_S = 1.0
# MAV_MODE_FLAG_SAFETY_ARMED in the mode of a heartbeat.
_ARMED = 128
# A serial port that takes no byte for this time loses the message.
_WRITE_S = 1.0
# The standard's timeout for an answer, its number of tries, and ours on a link that loses messages.
_ANSWER_S = 1.5
_TRIES, _MOST_TRIES = 5, 10
# Maximum timeout in seconds after answers to repeated messages.
_MOST_ANSWER_S = 6.0
# Heartbeats of further systems are waited for this long after the first one, in seconds.
_OTHERS_S = 2.5
# The numbers of messages begin again after this one, in each system of MAVLink.
_NUMBERS = 256
# A timeout, and the wait for late answers, in round trips.
_TRIPS = 1.5
_SCHEMES = ("udpout:", "udpin:", "tcp:")


class NoReplyError(Exception):
    """The autopilot does not answer.

    Parameters
    ----------
    systems : tuple of int
        Systems that answer instead of the one that was asked for.
    """

    def __init__(self, systems: tuple[int, ...] = ()) -> None:
        super().__init__(systems)
        self.systems = systems


class Link:
    """A connection to an autopilot.

    Parameters
    ----------
    answer_s : float
        Seconds until a message without an answer is sent again.
    clock : callable
        Returns the present instant in seconds; a simulated connection has its own time.
    """

    def __init__(
        self,
        connection: Any,
        answer_s: float = _ANSWER_S,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._connection = connection
        self._answer_s = answer_s
        self._clock = clock
        # The present timeout; the slowest round trip; the time of the latest request.
        self._patience_s = answer_s
        self._trip_s = 0.0
        self._asked_s = -math.inf
        # The number of the autopilot's latest message, and whether the numbers have had a gap.
        self._number: int | None = None
        #: True if messages of the autopilot were lost.
        self.loses = False
        self._next_beat = 0.0
        #: Address of the autopilot, and its kind, a value of MAV_AUTOPILOT.
        self.system = self.component = self.autopilot = 0
        #: True if the motors may run, and the number of the mode, by the latest heartbeat.
        self.armed = True
        self.mode = 0
        #: Texts to the pilot.
        self.texts = StatusTexts()

    @property
    def mav(self) -> Any:
        """Sends messages: a method of pymavlink for each."""
        return self._connection.mav

    def find(self, wait_s: float, system: int | None = None) -> None:
        """Wait for the heartbeat of an autopilot.

        Parameters
        ----------
        wait_s : float
            Maximum wait for the first heartbeat.
        system : int, optional
            Number of the system. Without it, further heartbeats are waited for, and there must be
            one system only.

        Raises
        ------
        NoReplyError
            If there is no heartbeat for ``wait_s`` seconds.
        JobError
            If several systems answer and none is chosen.
        """
        found: dict[int, Any] = {}
        numbers: dict[tuple[int, int], int] = {}
        end = self._clock() + wait_s
        while system not in found and (left_s := end - self._clock()) > 0:
            message = self._read(left_s)
            if message is None:
                continue
            numbers[message.get_srcSystem(), message.get_srcComponent()] = message.get_seq()
            if not _is_autopilot(message):
                continue
            if not found and system is None:
                end = self._clock() + _OTHERS_S
            # An autopilot's companions have higher numbers of components.
            first = found.setdefault(message.get_srcSystem(), message)
            if message.get_srcComponent() < first.get_srcComponent():
                found[message.get_srcSystem()] = message
        if system is None and len(found) > 1:
            *some, last = sorted(found)
            raise JobError(
                f"Autopilots of systems {', '.join(map(str, some))} and {last} answer; choose one "
                "with --system."
            )
        if not found or system not in (None, *found):
            raise NoReplyError(tuple(sorted(found)))
        message = next(iter(found.values())) if system is None else found[system]
        self.system, self.component = message.get_srcSystem(), message.get_srcComponent()
        self.autopilot = message.autopilot
        self._number = numbers[self.system, self.component]
        self._note_state(message)

    def ask(
        self,
        send: Callable[[], None],
        kinds: tuple[str, ...],
        accept: Callable[[Any], bool] = lambda _message: True,
    ) -> Any:
        """Send a message repeatedly until the autopilot answers; return the answer.

        Its messages are numbered, so a link that loses some is known, and gets more tries. The
        timeout follows the round trip, which is known from an answer to a message that was sent
        once, and bounded by an answer to a repeated one.

        Parameters
        ----------
        accept : callable
            Returns whether a message of these kinds is an answer.

        Raises
        ------
        NoReplyError
            If there is none after several repeats.
        """
        tries, begun_s = 0, self._clock()
        while tries < (_MOST_TRIES if self.loses else _TRIES):
            with _silent():
                send()
            self._asked_s = self._clock()
            tries += 1
            end = self._asked_s + self._patience_s
            while (left_s := end - self._clock()) > 0:
                message = self._read(left_s)
                if message is None or not (self._is_from(message) and _is_for_us(message)):
                    continue
                if message.get_type() in kinds and accept(message):
                    self._measured(self._clock() - begun_s, is_sure=tries == 1)
                    return message
        raise NoReplyError

    def settle(self) -> None:
        """Discard the messages that have arrived, and late answers to earlier requests."""
        self.drain()
        end = self._asked_s + (_TRIPS * self._trip_s or self._patience_s)
        while (left_s := end - self._clock()) > 0:
            self._read(left_s)

    def drain(self, *, late: bool = False) -> None:
        """Discard the messages that have arrived: answers to an earlier upload.

        With ``late``, also discard messages during a third of the timeout for an answer.
        """
        while (message := self._connection.recv_msg()) is not None:
            self._note(message)
        end = self._clock() + (self._answer_s / 3 if late else 0.0)
        while (left_s := end - self._clock()) > 0:
            self._read(left_s)

    def _measured(self, trip_s: float, *, is_sure: bool) -> None:
        """Note a round trip, and let the timeout follow.

        An answer to an earlier request makes it too short, so only the slowest one counts. The time
        to an answer to a repeated message is an upper bound.
        """
        if is_sure:
            self._trip_s = max(trip_s, self._trip_s)
            self._patience_s = max(self._answer_s, _TRIPS * self._trip_s)
        else:
            longer_s = max(self._patience_s, _TRIPS * trip_s)
            self._patience_s = min(longer_s, _MOST_ANSWER_S)

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()

    def _read(self, left_s: float) -> Any:
        """Return the next message, or None after a while; keep our heartbeats going."""
        now = self._clock()
        if now >= self._next_beat:
            from pymavlink import mavutil

            known = mavutil.mavlink
            with _silent():
                self.mav.heartbeat_send(known.MAV_TYPE_GCS, known.MAV_AUTOPILOT_INVALID, 0, 0, 0)
            self._next_beat = now + _HEARTBEAT_S
        wait_s = max(min(left_s, self._next_beat - now), 1e-3)
        message = self._connection.recv_match(blocking=True, timeout=wait_s)
        if message is not None:
            self._note(message)
        return message

    def _is_from(self, message: Any) -> bool:
        """Return whether the autopilot sent a message."""
        source = message.get_srcSystem(), message.get_srcComponent()
        return source == (self.system, self.component)

    def _note(self, message: Any) -> None:
        """Note from the autopilot whether its messages arrive, and whether its motors may run."""
        if not self._is_from(message):
            return
        number = message.get_seq()
        if self._number is not None:
            self.loses |= number != (self._number + 1) % _NUMBERS
        self._number = number
        if message.get_type() == "HEARTBEAT":
            self._note_state(message)
        elif message.get_type() == "STATUSTEXT":
            self.texts.take(message)

    def _note_state(self, heartbeat: Any) -> None:
        self.armed = bool(heartbeat.base_mode & _ARMED)
        self.mode = heartbeat.custom_mode


def _is_autopilot(message: Any) -> bool:
    """Return whether a message is the heartbeat of an autopilot."""
    from pymavlink import mavutil

    no_autopilot = mavutil.mavlink.MAV_AUTOPILOT_INVALID
    return message.get_type() == "HEARTBEAT" and bool(message.autopilot != no_autopilot)


def _is_for_us(message: Any) -> bool:
    """Return whether a message is for us or for all, rather than for another ground station."""
    system, component = (
        getattr(message, name, 0) for name in ("target_system", "target_component")
    )
    return system in (0, _SYSTEM) and component in (0, _COMPONENT)


@contextlib.contextmanager
def _quiet() -> Any:
    """Send the prints of pymavlink to standard error."""
    with contextlib.redirect_stdout(sys.stderr):
        yield


@contextlib.contextmanager
def _silent() -> Any:
    """Drop pymavlink's prints about a stuck port: the missing answer says enough."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


def open_link(to: str, *, baud: int = 57600, answer_s: float = _ANSWER_S) -> Link:
    """Open a connection.

    Parameters
    ----------
    to : str
        ``udpout:HOST:PORT``, ``udpin:HOST:PORT``, ``tcp:HOST:PORT`` or a serial device.
    answer_s : float
        Seconds until a message without an answer is sent again, above 0.

    Raises
    ------
    InputError
        If ``to`` is not one of these, or pymavlink is not installed.
    JobError
        If it cannot be opened.
    """
    _check_address(to)
    # Read by pymavlink when it is imported: fences need version 2.
    os.environ["MAVLINK20"] = "1"
    try:
        from pymavlink import mavutil
    except ImportError:
        raise InputError(
            "pathgene upload needs the extra pathgene[mavlink]: pip install 'pathgene[mavlink]'."
        ) from None
    try:
        with _quiet():
            connection = mavutil.mavlink_connection(
                to,
                baud=baud,
                source_system=_SYSTEM,
                source_component=_COMPONENT,
                dialect="common",
                retries=1,
            )
    except (OSError, ValueError, OverflowError) as error:  # The remaining value is the baud rate.
        reason = getattr(error, "strerror", None) or error
        raise JobError(f"Cannot open {to} ({reason}); check the address and the cable.") from None
    if hasattr(connection.port, "write_timeout"):
        connection.port.write_timeout = _WRITE_S
    return Link(connection, answer_s)


def _check_address(to: str) -> None:
    """Refuse an address that pymavlink would take for a file to read or a program to run."""
    scheme, _, address = to.partition(":")
    if f"{scheme}:" in _SCHEMES:
        host, _, port = address.rpartition(":")
        try:
            is_address = bool(host and whole(port, 65535))
        except ValueError:
            is_address = False
        if not is_address:
            raise InputError(f"The address must be {scheme}:HOST:PORT, not {to!r} (--to).")
        try:
            socket.gethostbyname(host)
        except (OSError, UnicodeError):  # A host name with a label of more than 63 characters.
            raise InputError(f"There is no host {host!r}; check the address (--to).") from None
        return
    try:
        is_device = stat.S_ISCHR(Path(to).stat().st_mode)
    except OSError:
        is_device = False
    if not is_device and not to.upper().startswith("COM"):
        raise InputError(
            f"There is no autopilot at {to!r}: give udpout:HOST:PORT, udpin:HOST:PORT, "
            "tcp:HOST:PORT or a serial device (--to)."
        )
