"""Digest of the sources on which stored results depend."""

from __future__ import annotations

import ast
import hashlib
import io
import tokenize
from functools import cache
from pathlib import Path


__all__ = ["code", "digest"]

_ROOT = Path(__file__).resolve().parents[1]
_SUFFIXES = (".py", ".xml", ".toml")
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@cache
def digest(*names: str) -> str:
    """Return 16 hexadecimal digits that change with any source under ``names``.

    Parameters
    ----------
    *names : str
        Folders or files, relative to the repository. A folder counts with all its Python, XML and
        TOML files, by name and content; for Python, only the code counts.

    Raises
    ------
    FileNotFoundError
        If one of ``names`` does not exist.
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
