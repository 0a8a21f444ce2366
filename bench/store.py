"""Measured results, kept in a JSON file from run to run with a digest of their sources."""

from __future__ import annotations

import ast
import hashlib
import io
import json
import tokenize
from functools import cache
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.files.output import replacing


_ROOT = Path(__file__).resolve().parents[1]
_SUFFIXES = (".py", ".xml", ".toml")
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@cache
def digest(*names: str) -> str:
    """Return 16 hexadecimal digits that change with any source under ``names``.

    A folder counts with all its Python, XML and TOML files, by name and content; for Python, only
    the code counts.
    """
    found = hashlib.sha256()
    for file in (file for name in names for file in _files(_ROOT / name)):
        text = file.read_text("utf-8")
        content = code(text) if file.suffix == ".py" else text
        found.update(f"{file.relative_to(_ROOT)}\n{content}\n".encode())
    return found.hexdigest()[:16]


def code(text: str) -> str:
    """Return Python source without docstrings, comments and empty lines, which affect no result."""
    lines = text.splitlines()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, _DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            docstring = node.body[0]
            for line in range(docstring.lineno, (docstring.end_lineno or docstring.lineno) + 1):
                lines[line - 1] = ""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            row, column = token.start
            lines[row - 1] = lines[row - 1][:column]
    return "\n".join(line.rstrip() for line in lines if line.strip())


def _files(place: Path) -> list[Path]:
    if not place.is_dir():
        return [place]
    return sorted(file for file in place.rglob("*") if file.suffix in _SUFFIXES)


Result = dict[str, Any]


class Store:
    """Results by row and part of the row, in a JSON file that is committed.

    The file is written after each result, so that an interrupted run can continue, even on another
    machine. Results that another process has written meanwhile stay. A result carries the digest of
    its sources: after a change of their code it counts as missing, and is replaced when it is
    measured again. Without ``sources``, each result is stored with its own digest.

    Raises
    ------
    InputError
        If the file does not contain results.
    """

    def __init__(self, file: Path, *sources: str) -> None:
        self._file = file
        self._sources = digest(*sources) if sources else None
        # The name of a result's digest in the file.
        self._key = "sources" if sources else "digest"
        self._rows: dict[str, dict[str, Result]] = {}
        self._state: tuple[int, ...] = ()
        self._read()

    def get(self, row: str, part: str) -> Result | None:
        """Return the result of a part of a row; None if it is missing or stale."""
        if self._sources is not None and self.digest(row, part) != self._sources:
            return None
        return self.parts(row).get(part)

    def digest(self, row: str, part: str) -> str | None:
        """Return the digest of a result's sources; None if it is missing."""
        result = self._rows.get(row, {}).get(part)
        return None if result is None else str(result[self._key])

    def parts(self, row: str) -> dict[str, Result]:
        """Return the results of a row by part, including stale ones."""
        return {
            part: {key: value for key, value in result.items() if key != self._key}
            for part, result in self._rows.get(row, {}).items()
        }

    def keep(self, row: str, part: str, result: Result, digest: str | None = None) -> None:
        """Store a result: a dictionary of values that JSON can express.

        ``digest`` is needed in a store without sources.
        """
        self._read()
        kept = {self._key: self._sources if digest is None else digest, **result}
        self._rows.setdefault(row, {})[part] = kept
        with replacing(self._file) as file:
            file.write(self._text().encode())
        self._state = self._stat()

    def _read(self) -> None:
        """Read the file unless it is unchanged since this process wrote or read it."""
        state = self._stat()
        if state == self._state:
            return
        try:
            self._rows = json.loads(self._file.read_text("utf-8"))
        except ValueError:
            raise InputError(f"{self._file} holds no results; remove it or restore it.") from None
        self._state = state

    def _stat(self) -> tuple[int, ...]:
        """Return numbers that change with the content of the file; empty without a file."""
        try:
            found = self._file.stat()
        except FileNotFoundError:
            return ()
        return found.st_ino, found.st_mtime_ns, found.st_size

    def _text(self) -> str:
        """Return the content of the file, one result per line."""
        rows = []
        for row, parts in sorted(self._rows.items()):
            lines = ",\n".join(
                f"  {json.dumps(part)}: {json.dumps(result, allow_nan=False)}"
                for part, result in sorted(parts.items())
            )
            rows.append(f" {json.dumps(row)}: {{\n{lines}\n }}")
        return "{\n" + ",\n".join(rows) + "\n}\n"
