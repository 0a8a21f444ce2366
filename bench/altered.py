"""Alterations of the definition, for its choices: processes import it with one text changed."""

from __future__ import annotations

import importlib.util
import os
import sys
from dataclasses import dataclass
from pathlib import Path


__all__ = ["Alteration"]


@dataclass(frozen=True)
class Alteration:
    """A text that stands once in the source of a module, and its replacement."""

    module: str
    old: str
    new: str

    def apply(self, cache: Path) -> None:
        """Import the altered module in this process, before anything has imported it.

        Kernels are compiled into ``cache``, so that the usual ones stay as they are.

        Raises
        ------
        ValueError
            If the module has been imported, or has the text more or less often than once.
        """
        found = importlib.util.find_spec(self.module)
        if found is None or found.origin is None or self.module in sys.modules:
            raise ValueError(f"{self.module} cannot be altered")
        source = Path(found.origin).read_text(encoding="utf-8")
        if source.count(self.old) != 1:
            raise ValueError(f"{self.module} has {source.count(self.old)} times {self.old!r}")
        os.environ["NUMBA_CACHE_DIR"] = str(cache)
        altered = importlib.util.module_from_spec(found)
        sys.modules[self.module] = altered
        exec(compile(source.replace(self.old, self.new), found.origin, "exec"), vars(altered))
        package, _, name = self.module.rpartition(".")
        setattr(sys.modules[package], name, altered)
