"""Refusal of commands in the model."""

from __future__ import annotations

from pathgene.hdl.protocol import Status


__all__ = ["RefusedError", "expect"]


class RefusedError(Exception):
    """A refused command: it is answered with ``status`` and changes nothing else."""

    def __init__(self, status: Status) -> None:
        self.status = status


def expect(holds: bool, status: Status) -> None:
    """Refuse the command with ``status`` unless ``holds``."""
    if not holds:
        raise RefusedError(status)
