"""A note before kernels are compiled, which takes up to a minute without any other output."""

from __future__ import annotations

from typing import Any

from pathgene.host.cli.output import note


__all__ = ["note_compiling", "note_compiling_routes"]


def note_compiling(*, as_paper: bool) -> None:
    """Note that the kernels of the evaluation are being compiled, unless numba has cached them."""
    # Loads numba; bad input must not wait for it.
    from pathgene.host.evaluation import kernels, rule_kernels

    # The outermost kernel of every evaluation.
    _note(kernels.path_terms if as_paper else rule_kernels.strict_terms, "about a minute")


def note_compiling_routes() -> None:
    """Note the same for the kernels of ``pathgene auv``."""
    from pathgene.host.auv import measures

    _note(measures.measure, "some ten seconds")


def _note(kernel: Any, duration: str) -> None:
    # The cache needs a compiler and a writable folder. The index of other sources, or of another
    # numba version, reads as empty.
    kept = getattr(getattr(kernel, "_cache", None), "_cache_file", None)
    if kept is not None and not kept._load_index():
        note(f"Compiling for this machine, once: {duration}.")
