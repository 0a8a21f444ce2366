"""A note before the kernels are compiled, which takes a minute without any other output."""

from __future__ import annotations

from host.cli.output import note
from host.problem.problem import Problem


__all__ = ["note_compiling"]


def note_compiling(problem: Problem) -> None:
    """Say that the kernels of a problem are compiled now, unless numba has kept them on disk."""
    # Loads numba, which bad input need not wait for.
    from host.evaluation import kernels, verdict

    # The outermost kernel of every evaluation. Without a compiler, or a folder that can be written
    # to, there is no cache. The index of other sources, or of another numba, reads as empty.
    kernel = kernels.path_terms if problem.as_paper else verdict.strict_terms
    kept = getattr(getattr(kernel, "_cache", None), "_cache_file", None)
    if kept is not None and not kept._load_index():
        note("Compiling for this machine, once: about a minute.")
