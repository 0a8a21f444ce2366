"""pytest plugin that records the vectors of decisions: ``-p tools.conditions.plugin``.

``PATHGENE_CONDITIONS`` names the file to write and then the modules that are instrumented,
a line each. Kernels among them need ``NUMBA_DISABLE_JIT=1``. The file is a JSON object
of the attributes of :class:`~tools.conditions.recorder.Recorder`.
"""

from __future__ import annotations

import importlib
import importlib.machinery
import json
import os
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

from tools.conditions.decisions import instrument
from tools.conditions.recorder import Recorder


__all__ = ["VARIABLE", "Finder"]

VARIABLE = "PATHGENE_CONDITIONS"


class Finder(MetaPathFinder):
    """Finds the modules to instrument as Python would, and loads them instrumented."""

    def __init__(self, modules: Sequence[str], recorder: Recorder) -> None:
        self._modules = frozenset(modules)
        self._recorder = recorder

    def find_spec(self, name: str, path: Any, target: ModuleType | None = None) -> Any:
        """Return the specification of a module to instrument, or None."""
        if name not in self._modules:
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path, target)
        if spec is not None and isinstance(spec.loader, importlib.machinery.SourceFileLoader):
            spec.loader = _Loader(name, spec.loader.path, self._recorder)
        return spec


class _Loader(importlib.machinery.SourceFileLoader):
    """Compiles a module with calls of the recorder; nothing is cached."""

    def __init__(self, name: str, path: str, recorder: Recorder) -> None:
        super().__init__(name, path)
        self._recorder = recorder

    def get_code(self, fullname: str) -> CodeType:
        source = Path(self.path).read_text(encoding="utf-8")
        return compile(instrument(fullname, source)[0], self.path, "exec", dont_inherit=True)

    def exec_module(self, module: ModuleType) -> None:
        vars(module).update(self._recorder.names())
        super().exec_module(module)


if VARIABLE in os.environ:
    _FILE, *_MODULES = os.environ[VARIABLE].splitlines()
    _RECORDER = Recorder()
    sys.meta_path.insert(0, Finder(_MODULES, _RECORDER))


def pytest_unconfigure() -> None:
    """Write the vectors; modules that no test imported are imported, so that they count."""
    for name in _MODULES:
        importlib.import_module(name)
    found = {key: sorted(each, key=repr) for key, each in sorted(_RECORDER.vectors.items())}
    kinds = {"arrays": sorted(_RECORDER.arrays), "choices": sorted(_RECORDER.choices)}
    text = json.dumps({"vectors": found, **kinds}, indent=0)
    Path(_FILE).write_text(text, encoding="utf-8")
