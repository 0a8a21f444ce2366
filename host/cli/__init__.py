"""The command line: what users type becomes calls, and errors become one sentence each."""

from __future__ import annotations

import importlib
import logging
import os
import re
import sys
import traceback
import warnings
from collections.abc import Sequence
from typing import TextIO

from host.cli.parser import build_parser
from host.errors import InputError, PathgeneError


__all__ = ["INTERRUPTED", "main"]

#: Exit status after Ctrl-C, as a shell reports it.
INTERRUPTED = 130

_NUMBER = re.compile(r"-[.\d]|-inf|-nan", re.IGNORECASE)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status: 0 done, 1 failed, 2 bad input, 130 interrupted.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; those of the process by default.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    debug = "--debug" in arguments
    logging.basicConfig(format="pathgene: %(message)s")
    logging.getLogger("sim").setLevel(logging.INFO)
    warnings.showwarning = _warn
    try:
        parsed = build_parser().parse_args(_join_numbers(arguments))
        if parsed.command is None:
            raise InputError("No command is given; pathgene --help lists them.")
        module, _, function = parsed.command.partition(":")
        status: int = getattr(importlib.import_module(f"host.cli.{module}"), function)(parsed)
        sys.stdout.flush()
        return status
    except PathgeneError as error:
        _complain(str(error), debug)
        return error.exit_status
    except KeyboardInterrupt:
        _complain("Interrupted before there was anything to write.", debug)
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read the output has gone; what is still buffered must not raise again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except Exception as error:
        _complain(f"Internal error, {type(error).__name__}: {error}; "
                  "--debug shows where, please report it.", debug)
        return 1


def _warn(
    message: Warning | str, category: type[Warning], filename: str, lineno: int,
    file: TextIO | None = None, line: str | None = None,
) -> None:
    print(f"pathgene: {message}", file=sys.stderr)


def _complain(sentence: str, debug: bool) -> None:
    if debug:
        traceback.print_exc()
    print(f"pathgene: {' '.join(sentence.split())}", file=sys.stderr)


def _join_numbers(arguments: list[str]) -> list[str]:
    """Write ``--wind -3,2`` as ``--wind=-3,2``, which argparse does not take for an option."""
    joined: list[str] = []
    for argument in arguments:
        if joined and _NUMBER.match(argument) and re.fullmatch(r"--[a-z-]+", joined[-1]):
            joined[-1] += f"={argument}"
        else:
            joined.append(argument)
    return joined
