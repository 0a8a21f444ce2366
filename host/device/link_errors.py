"""Errors of a link to a board."""

from __future__ import annotations

from enum import IntEnum

from pathgene.hdl.protocol.codes import Command, Status
from pathgene.host.errors import JobError


__all__ = ["LinkError", "LinkTimeoutError", "RefusedError", "lost", "name_of", "taken"]


class LinkError(JobError):
    """The board cannot be used: lost, reset, or taken by another host."""


class LinkTimeoutError(LinkError):
    """The board did not answer any attempt, or accepted no more bytes."""


class RefusedError(LinkError):
    """The board answered with a status other than ``OK``."""

    def __init__(self, command: int, status: int) -> None:
        self.status = status
        name = name_of(Command, command)
        if status == Status.BUSY:
            super().__init__(
                f"The board is busy with a run and refused the command {name}: wait for the end of "
                "the run, or stop it."
            )
            return
        super().__init__(
            f"The board refused the command {name} with {name_of(Status, status)}: host and board "
            "disagree; use the release it was built with."
        )


def name_of(codes: type[IntEnum], code: int) -> str:
    """Return the name of a command or a status, or its number if it has no name."""
    return codes(code).name if code in list(codes) else str(code)


def lost(error: OSError) -> LinkError:
    """Return the error of a port that failed."""
    return LinkError(f"The board was lost: {str(error).rstrip('.')}.")


def taken() -> LinkError:
    """Return the error of a session that another host, or a reset, has ended."""
    return LinkError("The board was reset or taken by another host: open it again.")
