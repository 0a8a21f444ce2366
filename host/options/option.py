"""An option of a plan: one row of the table of options."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from pathgene.host.options.kinds import BOOLEAN, Kind


__all__ = ["Desk", "Group", "Option"]

#: Groups of options: commands take whole groups. ``own`` are the options of single planners, and
#: ``file`` are keys of a problem file that have no option.
Group = Literal["problem", "rules", "search", "planning", "own", "end", "output", "file"]

#: Places on the page of ``pathgene desk``.
Desk = Literal["form", "map", "none"]


@dataclass(frozen=True, kw_only=True)
class Option:
    """An option of a plan.

    Parameters
    ----------
    name : str
        Name of its value among parsed arguments and the values of a problem file. It is also the
        long option, with ``-`` for ``_``, unless ``flag`` overrides it.
    meaning : str
        Its meaning and unit, without the default and without a full stop.
    group : str
        The group that it belongs to; a command takes whole groups.
    table : str
        The table of a problem file that contains it; empty if only the command line has it.
    key : str
        Its key in the table; by default its name.
    flag : str
        The long option; by default its name.
    metavar : str
        Placeholder of the value in the help of a command; by default the placeholder of its kind.
    default : object
        The value if none is given; None leaves the choice to the program.
    default_text : str
        The default in words; by default the value itself.
    is_required : bool
        There is no default, so a plan needs a value.
    is_repeated : bool
        The option may be repeated on the command line; the value is a list.
    instead_of : str
        Name of the option that this one replaces: only one of the two may be given.
    field : str
        Name of the value in :class:`pathgene.host.problem.rules.Rules`, in
        :class:`pathgene.host.problem.problem.Problem` or in
        :class:`pathgene.host.planners.base.Options`.
    percent : bool
        The field is a share from 0 to 1, which the option gives in per cent.
    desk : str
        Place on the page of ``pathgene desk``: a field of the ``form``, the ``map`` and its lists,
        or ``none``.
    """

    name: str
    kind: Kind
    meaning: str
    group: Group
    table: str = ""
    key: str = ""
    flag: str = ""
    metavar: str = ""
    default: Any = None
    default_text: str = ""
    is_required: bool = False
    is_repeated: bool = False
    instead_of: str = ""
    example: str = ""
    field: str = ""
    percent: bool = False
    desk: Desk = "form"

    def __post_init__(self) -> None:
        shown = "none" if self.default in (None, "", ()) else str(self.default)
        if self.kind is BOOLEAN:
            shown = "true" if self.default else "false"
        for name, value in (
            ("key", self.name),
            ("flag", f"--{self.name.replace('_', '-')}"),
            ("metavar", self.kind.metavar),
            ("default_text", "" if self.is_required else shown),
        ):
            if not getattr(self, name):
                object.__setattr__(self, name, value)

    @property
    def choices(self) -> tuple[str, ...]:
        """All values, if they are few."""
        return self.kind.choices

    @property
    def described(self) -> str:
        """The meaning with the default, as the help of a command shows it."""
        if self.is_required or (self.kind is BOOLEAN and not self.default):
            return self.meaning
        return f"{self.meaning} (default {self.default_text})"

    @property
    def shown_flag(self) -> str:
        """The command-line option for the value; empty if only a problem file has it."""
        if self.group == "file":
            return self.flag if self.flag != f"--{self.name.replace('_', '-')}" else ""
        if self.kind is BOOLEAN and self.default:
            return f"--no-{self.flag.removeprefix('--')}"
        return self.flag

    def to_field(self, value: Any) -> Any:
        """Convert a value of the option to a value of the field."""
        return value / 100 if self.percent else value

    def of_field(self, value: Any) -> Any:
        """Convert a value of the field to a value of the option."""
        return 100 * value if self.percent else value
