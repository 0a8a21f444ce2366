"""Problem files: all options of ``pathgene plan`` in TOML."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.files.output import output_file, reading
from pathgene.host.inputs import parse_toml, read_text
from pathgene.host.options.kinds import to_toml
from pathgene.host.options.option import Option
from pathgene.host.options.table import TABLES, keys_of
from pathgene.host.planners import PLANNERS
from pathgene.host.problem.aircraft import PARAMETERS
from pathgene.host.suggestion import did_you_mean


__all__ = ["markdown", "parse_problem", "problem_text", "read_problem", "save_problem", "template"]

#: Keys of a zone that give its shape.
_SHAPES = ("file", "circle", "polygon")
_WIDTH = 96


def read_problem(file: Path) -> dict[str, Any]:
    """Return the values of a problem file under the names of the parsed arguments.

    Paths in the file are relative to its folder. ``uav`` is a name, a path, or the table of an
    aircraft; ``zones`` is a list of tables.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, holds an unknown key, or a value of the wrong type.
    """
    try:
        with reading("problem", file):
            text = read_text(file)
    except UnicodeDecodeError:
        raise InputError(f"{file}: not a problem file, it is not UTF-8 text.") from None
    try:
        return parse_problem(text, file.parent)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None


def parse_problem(text: str, folder: Path) -> dict[str, Any]:
    """Return the values in the text of a problem file that lies in ``folder``.

    Raises
    ------
    InputError
        If it is not TOML, holds an unknown key, or a value of the wrong type.
    """
    try:
        document = parse_toml(text)
    except ValueError as error:
        raise InputError(f"not valid TOML: {error}.") from None
    return _values(document, folder)


def save_problem(file: Path, values: Mapping[str, Any]) -> None:
    """Write a problem file that gives ``values``, parsed arguments; None values are left out.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    with output_file(file) as binary:
        binary.write(problem_text(values, file.parent, file.name).encode())


def problem_text(values: Mapping[str, Any], folder: Path, name: str = "FILE") -> str:
    """Return the text of a problem file that gives ``values``, as :func:`save_problem` writes it.

    Parameters
    ----------
    values : mapping
        Parsed arguments; None values are left out.
    folder : Path
        The folder that the paths in the file are relative to.
    """
    shown = name.encode("utf-8", "backslashreplace").decode()
    lines = [f"# A problem of pathgene; plan it with: pathgene plan {shown}"]
    for table in TABLES:
        if table == "zones":
            for zone in _all_zones(values):
                lines += ["", "[[zones]]", *_lines(_written(keys_of("zones"), zone, folder))]
            continue
        if table == "aircraft":
            given = _aircraft_table(values.get("uav"), folder)
        else:
            own = {key: values.get(option.name) for key, option in keys_of(table).items()}
            given = _written(keys_of(table), own, folder)
        if given:
            lines += ["", f"[{table}]", *_lines(given)]
    for line in lines:
        if line != line.encode("utf-8", "replace").decode():
            raise InputError(
                f"A problem file cannot hold {line!r}, whose bytes are not UTF-8; rename the file "
                "or folder."
            )
    return "\n".join(lines) + "\n"


def template() -> str:
    """Return a problem file that explains every key and can be planned unchanged."""
    active = {"source", "start", "goal", "agl"}
    lines = [
        "# A problem of pathgene. Plan it with: pathgene plan FILE",
        "# Every key is here. Remove the # before a key to set it; its default is in brackets.",
        "# Paths are relative to this file. An option on the command line overrides a key.",
    ]
    for table, meaning in TABLES.items():
        lines += ["", "", *_comment(meaning)]
        listed = table == "zones"
        lines += ["# [[zones]]" if listed else f"[{table}]"]
        for key, option in keys_of(table).items():
            is_active = key in active and table in ("terrain", "mission")
            meaning = _full_meaning(option)
            default = f" ({option.default_text})" if option.default_text else ""
            lines += ["", *_comment(f"{meaning[:1].upper()}{meaning[1:]}{default}.")]
            lines += [f"{'' if is_active else '# '}{key} = {option.example}"]
    return "\n".join(lines) + "\n"


def markdown() -> str:
    """Return the tables of all keys for the documentation, as Markdown."""
    parts = []
    for table, meaning in TABLES.items():
        title = "[[zones]]" if table == "zones" else f"[{table}]"
        rows = [
            f"| `{key}` | {_full_meaning(option)}; {option.kind.name} | "
            f"{option.default_text or 'required'} | "
            f"{f'`{option.shown_flag}`' if option.shown_flag else ''} |"
            for key, option in keys_of(table).items()
        ]
        parts += [
            f"### `{title}`",
            "",
            meaning,
            "",
            "| key | meaning; kind | default | option |",
            "|---|---|---|---|",
            *rows,
            "",
        ]
    return "\n".join(parts)


def _full_meaning(option: Option) -> str:
    """Return the meaning, preceded by the planners that have the option unless all have it."""
    if option.group != "own":
        return option.meaning
    having = ", ".join(name for name, entry in PLANNERS.items() if option.name in entry.options)
    return f"for {having}: {option.meaning}"


def _values(document: dict[str, Any], folder: Path) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for name, table in document.items():
        if name not in TABLES:
            raise InputError(f"there is no table [{name}]{_nearest(name, TABLES)}")
        if name == "zones":
            values["zones"] = _zones(table, folder)
            continue
        if not isinstance(table, dict):
            raise InputError(f"{name} must be a table, [{name}].")
        if name == "aircraft":
            values["uav"] = _uav(table, folder)
            continue
        for option, value in _read(name, table, folder):
            values[option.name] = value
    for one, other in (("start", "start_geo"), ("goal", "goal_geo"), ("via", "via_geo")):
        if one in values and other in values:
            raise InputError(f"[mission] has both {one} and {other}; leave one out.")
    return values


def _read(name: str, table: dict[str, Any], folder: Path) -> Iterator[tuple[Option, Any]]:
    """Yield the options of a table with their values."""
    known = keys_of(name)
    for key, value in table.items():
        if key not in known:
            raise InputError(f"there is no key {key!r} in [{name}]{_nearest(key, known)}")
        try:
            yield known[key], known[key].kind.read(value, folder)
        except ValueError:
            raise InputError(
                f"{key} in [{name}] must be {known[key].kind.name}, not {value!r}."
            ) from None


def _zones(tables: Any, folder: Path) -> list[dict[str, Any]]:
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise InputError("zones must be tables, [[zones]] once for each.")
    zones = []
    for number, table in enumerate(tables, start=1):
        zone = {option.key: value for option, value in _read("zones", table, folder)}
        shapes = [shape for shape in _SHAPES if shape in zone]
        if len(shapes) != 1:
            raise InputError(
                f"[[zones]] number {number} must have one of {', '.join(_SHAPES)}, not "
                f"{' and '.join(shapes) or 'none'}."
            )
        if shapes == ["file"] and len(zone) > 1:
            raise InputError(
                f"[[zones]] number {number}: a file states names and limits itself; leave "
                f"{', '.join(key for key in zone if key != 'file')} out."
            )
        if shapes == ["circle"] and "holes" in zone:
            raise InputError(f"[[zones]] number {number}: a circle has no holes.")
        zones.append(zone)
    return zones


def _uav(table: dict[str, Any], folder: Path) -> Any:
    """Return the aircraft as a name, a path, or its own table."""
    known = {*keys_of("aircraft"), "sources", *PARAMETERS}
    for key in table:
        if key not in known:
            raise InputError(f"there is no key {key!r} in [aircraft]{_nearest(key, known)}")
    chosen = {key: value for key, value in table.items() if key in keys_of("aircraft")}
    read = {option.key: value for option, value in _read("aircraft", chosen, folder)}
    if "file" in read:
        if len(table) > 1:
            raise InputError("[aircraft] with a file must have no other key.")
        return read["file"]
    if set(table) == {"name"}:
        return read["name"]
    return dict(table) if table else None


def _nearest(name: str, known: Mapping[str, Any] | set[str]) -> str:
    """Return the end of a sentence about an unknown name: the closest known name, or all."""
    if question := did_you_mean(name, known):
        return f"{question}."
    return f"; known are {', '.join(sorted(known) if isinstance(known, set) else known)}."


def _all_zones(values: Mapping[str, Any]) -> list[dict[str, Any]]:
    return [
        *({"file": file} for file in values.get("nofly") or ()),
        *(values.get("zones") or ()),
        *({"circle": circle} for circle in values.get("nofly_circle") or ()),
    ]


def _aircraft_table(uav: Any, folder: Path) -> dict[str, Any]:
    if uav is None:
        return {}
    if isinstance(uav, Mapping):
        return dict(uav)
    key = "file" if str(uav).endswith(".toml") else "name"
    return _written(keys_of("aircraft"), {key: uav}, folder)


def _written(keys: Mapping[str, Option], values: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the values that are not None in the form of TOML, in the order of the keys."""
    return {
        key: option.kind.write(values[key], folder)
        for key, option in keys.items()
        if values.get(key) is not None and values[key] != []
    }


def _lines(table: Mapping[str, Any]) -> list[str]:
    return [f"{name} = {to_toml(value)}" for name, value in table.items()]


def _comment(text: str) -> list[str]:
    """Return ``text`` as lines of comment."""
    return [f"# {line}" for line in textwrap.wrap(text, _WIDTH, break_on_hyphens=False)]
