"""The parser of a command, and converters of its arguments."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Collection
from typing import NoReturn, TypeAlias

from pathgene.host.errors import InputError
from pathgene.host.numeric import parse


__all__ = [
    "Commands",
    "Parser",
    "add_command",
    "add_command_group",
    "cell_sides",
    "complete_by_file",
    "leave_unset",
    "numbers",
]


class Parser(argparse.ArgumentParser):
    """An argument parser that raises :class:`InputError` and accepts no abbreviated options."""

    def error(self, message: str) -> NoReturn:
        """Raise the message of argparse as one sentence."""
        raise InputError(f"{message[:1].upper()}{message[1:]}; see {self.prog} --help.")


#: The object that commands are added to.
Commands: TypeAlias = "argparse._SubParsersAction[Parser]"


def add_command(
    commands: Commands,
    name: str,
    target: str,
    summary: str,
    example: str,
    *,
    usage: str | None = None,
    notes: str = "",
) -> Parser:
    """Add a command with the options that every command has.

    Parameters
    ----------
    commands : Commands
        The commands to add to.
    name : str
        Name of the command.
    target : str
        ``module:function`` in :mod:`pathgene.host.cli` that runs the command.
    summary : str
        One line of help, without a full stop.
    example : str
        A command line that works.
    usage : str, optional
        The arguments in short, for a command of many options; by default all of them.
    notes : str
        Sentences that follow the summary in the help of the command.
    """
    parser: Parser = commands.add_parser(
        name,
        allow_abbrev=False,
        usage=usage and f"%(prog)s {usage}",
        help=summary,
        description=f"{summary}. {notes}".rstrip(),
        epilog=f"Example: {example}",
    )
    parser.set_defaults(command=target)
    parser.add_argument("--json", action="store_true", help="print JSON on standard output")
    parser.add_argument("--debug", action="store_true", help="show a traceback with an error")
    return parser


def add_command_group(commands: Commands, name: str, summary: str, example: str) -> Commands:
    """Add a command that has commands itself; return the object that they are added to."""
    parser: Parser = commands.add_parser(
        name,
        allow_abbrev=False,
        help=summary,
        description=f"{summary}.",
        epilog=f"Example: {example}",
    )
    return parser.add_subparsers(title="commands", metavar="COMMAND", required=True)


def leave_unset(parser: Parser, *, besides: Collection[str] = ()) -> None:
    """Let the parsed arguments hold only the options that are given, and require none.

    Their defaults are under ``option_defaults``.

    Parameters
    ----------
    parser : Parser
        The command with all its options.
    besides : collection of str
        Names of arguments that stay as they are.
    """
    defaults = {}
    for action in parser._actions:
        if action.dest in ("help", "json", "debug", *besides):
            continue
        defaults[action.dest] = action.default
        # The formatter of the help leaves out the default of an argument without one.
        action.help = (action.help or "").replace("%(default)s", str(action.default))
        action.default, action.required = argparse.SUPPRESS, False
    parser.set_defaults(option_defaults=defaults)


def complete_by_file(parser: Parser, *, besides: Collection[str] = ()) -> None:
    """Add the argument PROBLEM.toml, a file that supplies the options that are not given.

    :func:`pathgene.host.cli.problem.complete_options` reads it; the parameters are those of
    :func:`leave_unset`.
    """
    leave_unset(parser, besides=besides)
    parser.add_argument(
        "problem",
        metavar="PROBLEM.toml",
        nargs="?",
        help="problem file that supplies the options that are not given; 'pathgene problem new' "
        "writes one with every key explained",
    )


def numbers(names: str) -> Callable[[str], tuple[float, ...]]:
    """Return a converter of as many comma-separated numbers as ``names`` has."""

    def convert(text: str) -> tuple[float, ...]:
        parts = text.split(",")
        try:
            values = tuple(map(parse, parts))
        except ValueError:
            values = ()
        if len(values) != len(names.split(",")):
            raise argparse.ArgumentTypeError(f"must be finite numbers {names}, not {text!r}")
        return values

    return convert


def cell_sides(text: str) -> tuple[float, float]:
    """Convert ``DX`` or ``DX,DY`` to the two sides of a cell."""
    dx, *dy = numbers("DX,DY" if "," in text else "DX")(text)
    return dx, dy[0] if dy else dx
