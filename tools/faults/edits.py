"""A bug as a replacement in the text of a module of the product."""

from __future__ import annotations

import contextlib
import importlib
import inspect
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any


@dataclass(frozen=True)
class Edit:
    """A replacement of a text that a module has exactly once."""

    module: str
    old: str
    new: str


@contextlib.contextmanager
def edited(edit: Edit) -> Iterator[None]:
    """Give the functions of a module, and its numbers, the edited text in the block.

    The functions themselves stay, so that modules that have imported them run the edited text, too.

    Raises
    ------
    ValueError
        If the module does not have the text exactly once, or the edit changes nothing.
    """
    module = importlib.import_module(edit.module)
    file = str(module.__file__)
    text = Path(file).read_text("utf-8")
    if (count := text.count(edit.old)) != 1:
        raise ValueError(f"{edit.module} must have the text once, not {count} times: {edit.old!r}")
    program = compile(text.replace(edit.old, edit.new), file, "exec")
    codes = dict(_codes(program))
    changes: list[tuple[Any, str, Any, Any]] = [
        (function, "__code__", function.__code__, code)
        for function in _functions(module)
        if (code := codes[function.__code__.co_qualname]) != function.__code__
    ]
    again = ModuleType(edit.module)
    again.__file__ = file
    exec(program, vars(again))
    changes += [
        (module, name, before, after)
        for name, before in vars(module).items()
        if isinstance(before, int | float) and (after := vars(again)[name]) != before
    ]
    if not changes:
        raise ValueError(f"the edit of {edit.module} changes no function and no number")
    try:
        for owner, name, _, after in changes:
            setattr(owner, name, after)
        yield
    finally:
        for owner, name, before, _ in changes:
            setattr(owner, name, before)


def _codes(code: CodeType) -> Iterator[tuple[str, CodeType]]:
    """Yield the code of every function in a program, with its qualified name."""
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield constant.co_qualname, constant
            yield from _codes(constant)


def _functions(owner: Any) -> Iterator[FunctionType]:
    """Yield the functions and methods that a module or a class defines."""
    name = owner.__name__ if inspect.ismodule(owner) else owner.__module__
    for value in list(vars(owner).values()):
        if inspect.isclass(value) and value.__module__ == name:
            yield from _functions(value)
            continue
        for part in (value, *(getattr(value, each, None) for each in ("fget", "fset", "__func__"))):
            function = inspect.unwrap(part) if callable(part) else part
            if isinstance(function, FunctionType) and _is_written_in(function, name):
                yield function


def _is_written_in(function: FunctionType, module: str) -> bool:
    """Return whether a module has the text of a function; dataclasses have methods without."""
    is_generated = function.__code__.co_filename.startswith("<")
    return function.__module__ == module and not is_generated
