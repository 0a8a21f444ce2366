"""Alterations of the definition, to test its choices: processes import it with one text changed."""

from __future__ import annotations

import importlib.util
import os
import sys
from dataclasses import dataclass
from pathlib import Path


__all__ = ["Alteration"]


@dataclass(frozen=True)
class Alteration:
    """A text that occurs once in the source of a module, and its replacement."""

    module: str
    old: str
    new: str

    def apply(self, cache: Path) -> None:
        """Import the altered module in this process before anything else imports it.

        Kernels are compiled into ``cache``, so that the usual kernels are not affected.

        Raises
        ------
        ValueError
            If the module has already been imported, or does not have the text exactly once.
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
