"""The known name that a wrong name probably stands for."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


__all__ = ["did_you_mean"]

# Share of letters that two very similar names have in common, 0..1.
_VERY_SIMILAR = 0.8


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """Return a question in brackets, to insert after a wrong name, or an empty text.

    A very similar name comes first, then one that begins with the wrong name, then a similar one.

    Parameters
    ----------
    known : iterable of str
        The names that would be right.
    """
    names = {_key(each): each for each in reversed(list(known))}
    word = _key(str(name))
    near = (
        difflib.get_close_matches(word, names, n=1, cutoff=_VERY_SIMILAR)
        or [each for each in reversed(names) if len(word) > 2 and each.startswith(word)]
        or difflib.get_close_matches(word, names, n=1)
    )
    return f" (did you mean {names[near[0]]}?)" if near else ""


def _key(name: str) -> str:
    """Return a name without case and without the dashes of an option."""
    return name.casefold().lstrip("-")
