"""Checks of rows: the named test passes, and an assertion in it fails once the fault is planted."""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator, Sequence

from tools.mutation.workshop import Workshop
from tools.requirements.table import Row


#: Marks leave no test out, and a crash is no failure.
_OPTIONS = ("-m", "", "-rfEp", "-n", "0", "-p", "tools.requirements.crashes")


Outcomes = list[tuple[str, str]]
#: Outcomes without a fault, by the test and whether it runs without compiled kernels.
Known = dict[tuple[str, bool], Outcomes]


def verdict(
    shop: Workshop, row: Row, *, unaltered: bool = True, known: Known | None = None
) -> str | None:
    """Return a sentence on the failure of a row, or None.

    Parameters
    ----------
    unaltered : bool
        Whether to run the test without the fault as well.
    known : dict, optional
        Outcomes without a fault: those in it are not found again, and others are added.
    """
    try:
        faulty = row.faulty(shop.folder)
    except ValueError as error:
        return str(error)
    if unaltered:
        known = {} if known is None else known
        key = row.test, row.interpreted
        if key not in known:
            known[key] = _outcomes(shop, row)
        found = known[key]
        if not found or any(kind != "PASSED" for kind, _ in found):
            return f"{row.name}: {row.test} does not pass without the fault: {found}"
    with shop.altered(row.file, faulty):
        found = _outcomes(shop, row)
    # An error would mean that the test crashes, or is not even reached.
    if any(kind == "FAILED" and name.startswith(row.test) for kind, name in found):
        return None
    return f"{row.name}: {row.test} does not notice the fault: {found}"


def _outcomes(shop: Workshop, row: Row) -> Outcomes:
    variables = {"NUMBA_DISABLE_JIT": "1"} if row.interpreted else None
    return shop.outcomes([row.test], _OPTIONS, variables)


def wrong(shop: Workshop, rows: Iterable[Row], *, unaltered: bool = True) -> Iterator[str]:
    """Yield a sentence for each wrong row."""
    known: Known = {}
    for row in rows:
        if (found := verdict(shop, row, unaltered=unaltered, known=known)) is not None:
            yield found


def sample(rows: Sequence[Row], seed: int, count: int) -> list[Row]:
    """Return some rows, drawn by a seed."""
    return random.Random(seed).sample(list(rows), count)
