"""Compilation of kernels for the CPU, and their cache on disk, for host and simulation."""

from __future__ import annotations

import contextlib
import hashlib
import inspect
import logging
import pickle
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba import njit
from numba.core import event
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.runtime import rtsys


__all__ = ["COMPILING", "Compiler", "compile_by", "compiling_s", "source_stamp"]

_Function = TypeVar("_Function", bound=Callable[..., object])
#: numba's event that starts and ends with the compilation of a kernel in this process.
COMPILING = "numba:compile"
# Compiles the kernel of a module, by its name, for the types of its arguments.
_Elsewhere = Callable[[str, str, Any], None]
_LOG = logging.getLogger("pathgene.kernels")


class _By:
    """Where kernels are compiled: by a function, or here if it is None."""

    elsewhere: _Elsewhere | None = None


def compile_by(elsewhere: _Elsewhere | None) -> None:
    """Let ``elsewhere`` compile kernels that are not on disk, as in another process.

    It leaves the kernel on disk. A kernel that it does not leave there is compiled here.

    Parameters
    ----------
    elsewhere : callable or None
        Receives the name of a kernel's module, the kernel's name there, and its types of
        arguments. None compiles all kernels here.
    """
    _By.elsewhere = elsewhere


class _Clock(event.Listener):  # type: ignore[misc]  # numba has no types.
    """Wall time of all compilations, each of which may contain further ones.

    numba compiles one kernel at a time, in whichever thread.
    """

    def __init__(self) -> None:
        self.spent_s = 0.0
        self._started_s = 0.0
        self._depth = 0

    def on_start(self, event: Any) -> None:
        """Start the clock."""
        if self._depth == 0:
            self._started_s = time.perf_counter()
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """Stop the clock."""
        self._depth -= 1
        if self._depth == 0:
            self.spent_s += time.perf_counter() - self._started_s


_CLOCK = _Clock()
event.register(COMPILING, _CLOCK)


def compiling_s() -> float:
    """Return the seconds of wall time for which this process has compiled or waited for kernels."""
    return _CLOCK.spent_s


class Compiler:
    """Decorators that compile a function at its first call and keep the result on disk.

    Division follows IEEE 754 and raises nothing; no arithmetic is reordered, so results agree with
    the reference and are the same on every machine. A kernel releases the GIL.

    The cache on disk is numba's own, which notices changes only in the file of the outermost
    function; here it notices them in all sources of that file's folder and of ``folders``.

    Parameters
    ----------
    *folders : Path
        Folders whose sources belong to every kernel.
    """

    def __init__(self, *folders: Path) -> None:
        self._folders = folders

    def compiled(self, function: _Function) -> _Function:
        """Compile a function that neither makes nor copies arrays.

        References to arrays are not counted, because the caller holds them. Counting would take
        most of the time of a small function.
        """
        return self._compiled(function)

    def allocating(self, function: _Function) -> _Function:
        """Compile a function that makes or copies arrays and runs long enough to justify that."""
        return self._compiled(function, counted=True)

    def inlined(self, function: _Function) -> _Function:
        """Compile a small function that is inlined where it is called.

        A call passes every field of every argument, which takes longer than such a function.
        """
        return self._compiled(function, inline=True)

    def _compiled(
        self, function: _Function, *, inline: bool = False, counted: bool = False
    ) -> _Function:
        # _nrt: numba's runtime, which makes arrays and counts the references to them.
        dispatcher = njit(nogil=True, error_model="numpy", forceinline=inline, _nrt=counted)(
            function
        )
        # With NUMBA_DISABLE_JIT it is the function itself.
        if dispatcher is not function:
            folder = Path(inspect.getfile(function)).resolve().parent
            dispatcher._cache = _Cache(function, source_stamp((folder, *self._folders)))
        return cast(_Function, dispatcher)


class _Cache(FunctionCache):  # type: ignore[misc]  # numba has no types.
    """A kernel's cache, which loads a compiled kernel without the parts of numba that compile.

    numba itself first imports its implementations of Python and NumPy, and with them SciPy, which
    takes longer than everything else. A compilation still imports them.

    Parameters
    ----------
    stamp : str
        See :func:`source_stamp`.
    """

    def __init__(self, function: Callable[..., object], stamp: str) -> None:
        super().__init__(function)
        place = function.__module__, function.__qualname__
        self._cache_file = _CheckedFiles(self._cache_path, self._impl.filename_base, stamp, place)
        # The stamp is also part of the version, which is read first: a cache of other sources
        # may contain objects of classes that no longer exist and must not be read.
        self._cache_file._version = f"{numba.__version__} {stamp}"

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the kernel for a signature, or None if it is not on disk."""
        rtsys.initialize(target_context)  # Kernels that make arrays call it.
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)


class _CheckedFiles(IndexDataCacheFile):  # type: ignore[misc]  # numba has no types.
    """The files in which numba keeps a kernel; a damaged file counts as none.

    numba itself would fail at a truncated file every time, and would run the code of an altered
    file.

    Parameters
    ----------
    place : tuple of str
        Module and name of the kernel.
    """

    def __init__(self, path: str, name: str, stamp: str, place: tuple[str, str]) -> None:
        super().__init__(path, name, stamp)
        self._place = place

    def save(self, key: Any, data: Any) -> None:
        """Save a kernel; if the disk refuses it, only time is lost."""
        with contextlib.suppress(OSError):
            super().save(key, data)

    def _load_index(self) -> dict[Any, Any]:
        try:
            return cast(dict[Any, Any], super()._load_index())
        except Exception as error:  # Which error pickle raises depends on the damage.
            _LOG.info("an index of compiled kernels is damaged (%s)", type(error).__name__)
            return {}

    def _load_data(self, name: str) -> Any:
        digest, dumped = super()._load_data(name)
        if hashlib.sha256(dumped).digest() != digest:
            raise ValueError("the digest differs")
        return pickle.loads(dumped)

    def load(self, key: Any) -> Any:
        """Return a saved kernel, after its compilation elsewhere if there is one, or None."""
        found = self._loaded(key)
        module, name = self._place
        # A function of a function, or of the program's main file, cannot be found by its name.
        if found is None and _By.elsewhere and name.isidentifier() and module != "__main__":
            with event.trigger_event(COMPILING):
                _By.elsewhere(module, name, key[0])
            found = self._loaded(key)
        return found

    def _loaded(self, key: Any) -> Any:
        try:
            return super().load(key)
        except Exception as error:
            _LOG.info("a compiled kernel is damaged (%s)", type(error).__name__)
            return None

    def _save_data(self, name: str, data: Any) -> None:
        dumped = self._dump(data)
        super()._save_data(name, (hashlib.sha256(dumped).digest(), dumped))


@cache
def source_stamp(folders: tuple[Path, ...]) -> str:
    """Return a digest of the sources in ``folders`` and of this module."""
    digest = hashlib.sha256()
    here = Path(__file__).resolve()
    for file in sorted({here, *(file for folder in folders for file in folder.glob("*.py"))}):
        digest.update(file.read_bytes())
    return digest.hexdigest()
