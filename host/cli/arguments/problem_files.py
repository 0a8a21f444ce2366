"""Arguments of ``pathgene problem``."""

from __future__ import annotations

from pathgene.host.cli.arguments.base import Commands, add_command, add_command_group


__all__ = ["add_problem_files"]


def add_problem_files(commands: Commands) -> None:
    """Add the command and its commands."""
    actions = add_command_group(
        commands,
        "problem",
        "Write and check problem files, which hold all options of a plan",
        "pathgene problem new mine.toml",
    )
    new = add_command(
        actions,
        "new",
        "problem_files:new",
        "Write a problem file with every key explained, which plans as it is",
        "pathgene problem new mine.toml",
    )
    new.add_argument(
        "file",
        metavar="FILE",
        nargs="?",
        default="problem.toml",
        help="file to write, which must not exist (default %(default)s)",
    )
    check = add_command(
        actions,
        "check",
        "problem_files:check",
        "Check a problem file without planning: its keys, values, terrain, points and zones",
        "pathgene problem check problem.toml --json",
        notes="The exit status is 0 for a good file, 2 for a bad one.",
    )
    check.add_argument("file", metavar="FILE", help="problem file")
