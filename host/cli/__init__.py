"""The command line: runs the command that the arguments name; an error is one sentence."""

from __future__ import annotations

import argparse
import functools
import logging
import re
import sys
import traceback
import warnings
from collections.abc import Sequence
from typing import TextIO

from pathgene.host import interrupts
from pathgene.host.cli.output import print_line
from pathgene.host.cli.parser import build_parser
from pathgene.host.cli.streams import OutputError, guarded
from pathgene.host.errors import InputError, JobError, PathgeneError


__all__ = ["main"]

_NUMBER = re.compile(r"-[.\d]|-inf|-nan", re.IGNORECASE)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status.

    The status is 0 after success, 1 after a failure, 2 after bad input, and 128 + the number of the
    signal after a signal that requested an early end: 130 after Ctrl-C.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; by default the arguments of the process.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    debug = "--debug" in arguments
    # All other warnings come from numpy and address programmers.
    warnings.showwarning = functools.partial(_warn, Warning if debug else UserWarning)
    with guarded(), interrupts.caught():
        logging.basicConfig(handlers=[_Notes()])
        logging.getLogger("pathgene").setLevel(logging.INFO)
        # The exception repeats GDAL's message about a damaged file, and becomes a sentence.
        logging.getLogger("rasterio").setLevel(logging.CRITICAL)
        try:
            return _run(arguments, debug)
        finally:
            # Loaded only by a command that needs kernels.
            if (compiling := sys.modules.get("pathgene.host.compiling")) is not None:
                compiling.end()


class _Notes(logging.Handler):
    """Prints the messages of a log as notes."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print a message; one that cannot be made is reported as by any handler."""
        try:
            print_line(record.getMessage())
        except Exception:
            self.handleError(record)


def _run(arguments: list[str], debug: bool) -> int:
    try:
        parsed = _parsed(_prepared(arguments))
        if parsed.command is None:
            raise InputError("No command is given; pathgene --help lists them.")
        status: int = parsed.command(parsed)
        sys.stdout.flush()
        return status
    except OutputError as error:
        _complain(str(error), debug)
        return interrupts.status(default=error.exit_status)
    except JobError as error:
        _complain(str(error), debug)
        # A signal to the process group also ends the child processes, and their job fails first.
        return interrupts.status(default=error.exit_status)
    except PathgeneError as error:
        _complain(str(error), debug)
        return error.exit_status
    except KeyboardInterrupt:
        _complain("Interrupted before the end.", debug)
        return interrupts.status()
    except Exception as error:
        if interrupts.status(default=0):
            # An extension module may turn an interrupt into an error of its own.
            _complain("Interrupted before the end.", debug)
            return interrupts.status()
        _complain(
            f"Internal error, {type(error).__name__}: {error}; "
            "--debug shows where, please report it.",
            debug,
        )
        return 1


def _parsed(arguments: list[str]) -> argparse.Namespace:
    try:
        return build_parser(arguments[0] if arguments else None).parse_args(arguments)
    except SystemExit:
        sys.stdout.flush()  # --help and --version exit this way after printing.
        raise


def _warn(
    shown: type[Warning],
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    if issubclass(category, shown):
        print_line(str(message))


def _complain(sentence: str, debug: bool) -> None:
    if debug:
        traceback.print_exc()
    if sentence:
        print_line(sentence)


def _prepared(arguments: list[str]) -> list[str]:
    """Write ``--wind -3,2`` as ``--wind=-3,2``: argparse takes ``-3,2`` for an option.

    Raises
    ------
    InputError
        If an option has the value ``--``, which argparse would not treat as a value.
    """
    joined: list[str] = []
    for argument in arguments:
        name, _, value = argument.partition("=")
        if value == "--":
            raise InputError(f"Argument {name}: must have a value, not '--'; see pathgene --help.")
        if joined and _NUMBER.match(argument) and re.fullmatch(r"--[a-z-]+", joined[-1]):
            joined[-1] += f"={argument}"
        else:
            joined.append(argument)
    return joined
