"""The parser of a command, and the arguments that it takes from the table of options."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any, NoReturn, TypeAlias

from pathgene.host.errors import InputError
from pathgene.host.options.kinds import BOOLEAN
from pathgene.host.options.option import Option
from pathgene.host.options.table import NAMED, OWN, options_of
from pathgene.host.planners import PLANNERS
from pathgene.host.suggestion import did_you_mean


__all__ = [
    "Commands",
    "Parser",
    "add_command",
    "add_command_group",
    "add_option",
    "add_options",
    "add_own_options",
    "add_problem",
    "complete_by_file",
    "leave_unset",
]


class _StoreOnce(argparse._StoreAction):
    """An option with one value, which is refused if it is given twice."""

    is_given = False

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        if self.option_strings and self.is_given:
            raise argparse.ArgumentError(self, "may be given only once")
        self.is_given = True
        super().__call__(parser, namespace, values, option_string)


class Parser(argparse.ArgumentParser):
    """An argument parser that raises :class:`InputError`.

    It rejects abbreviated options, and a repeated option of one value.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        for name in (None, "store"):
            self.register("action", name, _StoreOnce)

    def parse_known_args(  # type: ignore[override]  # The stubs overload it.
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[Any, list[str]]:
        """Parse arguments; the parser may be used more than once."""
        for action in self._actions:
            if isinstance(action, _StoreOnce):
                action.is_given = False
        parsed, rest = super().parse_known_args(args, namespace)
        # The parser above this one does not know its options.
        for argument in rest:
            name = argument.partition("=")[0]
            nearest = did_you_mean(name, self._option_string_actions) if name[:1] == "-" else ""
            self.error(f"unrecognized argument {name}{nearest}")
        return parsed, rest

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse a value that is not among the choices; the base class has no suggestion."""
        if action.choices is None or value in action.choices:
            return
        known = list(map(str, action.choices))
        is_command = isinstance(action, argparse._SubParsersAction)
        kind = "command" if is_command else "choice"
        raise argparse.ArgumentError(
            None if is_command else action,
            f"there is no {kind} {value!r}{did_you_mean(str(value), known)}; choose from "
            f"{', '.join(known)}",
        )

    def error(self, message: str) -> NoReturn:
        """Raise the message of argparse as one sentence."""
        raise InputError(f"{message[:1].upper()}{message[1:]}; see {self.prog} --help.")


#: The object that commands are added to.
Commands: TypeAlias = "argparse._SubParsersAction[Parser]"


def add_command(
    commands: Commands,
    name: str,
    run: Callable[[argparse.Namespace], int],
    summary: str,
    example: str,
    *,
    usage: str | None = None,
    notes: str = "",
) -> Parser:
    """Add a command with the options that every command has.

    Parameters
    ----------
    run : callable
        Runs the command with the parsed arguments and returns its exit status.
    summary : str
        One line of help, without a full stop.
    usage : str, optional
        Short form of the arguments, for a command with many options; by default all of them.
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
    parser.set_defaults(command=run)
    parser.add_argument("--json", action="store_true", help="print JSON on standard output")
    parser.add_argument("--debug", action="store_true", help="show a traceback with an error")
    return parser


def add_command_group(commands: Commands, name: str, summary: str, example: str) -> Commands:
    """Add a command that has subcommands; return the object that they are added to."""
    parser: Parser = commands.add_parser(
        name,
        allow_abbrev=False,
        help=summary,
        description=f"{summary}.",
        epilog=f"Example: {example}",
    )
    return parser.add_subparsers(title="commands", metavar="COMMAND", required=True)


def leave_unset(parser: Parser, *, besides: Collection[str] = ()) -> None:
    """Keep only the given options in the parsed arguments, and make every option optional.

    Their defaults are under ``option_defaults``.

    Parameters
    ----------
    besides : collection of str
        Names of arguments that stay unchanged.
    """
    defaults = {}
    for action in parser._actions:
        if action.dest in ("help", "json", "debug", *besides):
            continue
        defaults[action.dest] = action.default
        # The help formatter omits the default of an argument whose default is suppressed.
        action.help = (action.help or "").replace("%(default)s", str(action.default))
        action.default, action.required = argparse.SUPPRESS, False
    parser.set_defaults(option_defaults=defaults)


def complete_by_file(parser: Parser, *, besides: Collection[str] = ()) -> None:
    """Add the argument PROBLEM.toml, a file that supplies the options that are not given.

    :func:`pathgene.host.cli.values.complete_options` reads it; the parameters are as for
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


def add_option(
    parser: argparse._ActionsContainer,
    option: Option,
    *,
    help: str | None = None,
    default: object = None,
) -> None:
    """Add the argument of an option.

    Parameters
    ----------
    parser : ArgumentParser or group
        The parser or group that gets the argument.
    help : str, optional
        Its help; by default its meaning with its default.
    default : object, optional
        Its default, if this command has another one.
    """
    chosen = option.default if default is None else default
    if option.kind is BOOLEAN:
        parser.add_argument(
            option.flag,
            dest=option.name,
            action=argparse.BooleanOptionalAction,
            default=chosen,
            help=help or option.described,
        )
        return
    parser.add_argument(
        option.flag,
        action="append" if option.is_repeated else "store",
        type=option.kind.parse,
        # The planners' names are in the help; an unknown one is refused with a sentence.
        choices=None if option.metavar else option.choices or None,
        metavar=option.metavar or None,
        default=list(option.default) if option.is_repeated else chosen,
        help=help or option.described,
    )


def add_options(parser: argparse._ActionsContainer, options: Iterable[Option]) -> None:
    """Add the arguments of options."""
    for option in options:
        add_option(parser, option)


def add_problem(parser: Parser, *, of_path: bool = False) -> None:
    """Add the options of a problem and of its rules.

    Parameters
    ----------
    of_path : bool
        The problem belongs to a given path, which has its own ends.
    """
    group = parser.add_argument_group("problem")
    twins = {option.instead_of: option for option in NAMED.values() if option.instead_of}
    for option in options_of("problem"):
        if option.name in twins:
            twin = twins[option.name]
            either = group.add_mutually_exclusive_group()
            need = "must be the path's own end" if of_path else f"required, or {twin.flag}"
            add_option(either, option, help=f"{option.meaning} ({need})")
            add_option(either, twin)
        elif not option.instead_of:
            add_option(group, option)
    add_options(parser.add_argument_group("rules of safe flight"), options_of("rules"))


def add_end(parser: argparse._ActionsContainer) -> None:
    """Add the options of the end of a mission."""
    end, land, land_geo = options_of("end")
    add_option(parser, end)
    either = parser.add_mutually_exclusive_group()
    add_option(either, land)
    add_option(either, land_geo)


def add_own_options(parser: Parser) -> None:
    """Add the options that only some planners have, in a group for each set of planners."""
    having = {
        name: tuple(planner for planner, entry in PLANNERS.items() if name in entry.options)
        for name in OWN
    }
    groups: dict[tuple[str, ...], argparse._ArgumentGroup] = {}
    for name in sorted(OWN, key=lambda name: tuple(map(list(PLANNERS).index, having[name]))):
        planners = having[name]
        if planners not in groups:
            groups[planners] = parser.add_argument_group(f"options of {_listed(planners)}")
        add_option(groups[planners], OWN[name])


def _listed(names: tuple[str, ...]) -> str:
    *most, last = names
    return f"{', '.join(most)} and {last}" if most else last
