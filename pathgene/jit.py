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

import llvmlite.binding as llvm
import numba
from numba import njit
from numba.core import event
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    InTreeCacheLocator,
)
from numba.core.codegen import JITCodeLibrary
from numba.core.runtime import rtsys


__all__ = [
    "BASELINE",
    "COMPILING",
    "Compiler",
    "baseline_target",
    "compile_by",
    "compiling_s",
    "is_kept",
    "source_stamp",
]

_Function = TypeVar("_Function", bound=Callable[..., object])
#: numba's event that starts and ends with the compilation of a kernel in this process.
COMPILING = "numba:compile"
#: The processor that the kernels of a wheel are compiled for, as LLVM names it.
BASELINE = "x86-64-v3"
# Its features, as LLVM names them: levels 1, 2 and 3 of x86-64.
_FEATURES = frozenset(
    (
        *("64bit", "cmov", "cx8", "fxsr", "mmx", "sse", "sse2"),
        *("crc32", "cx16", "popcnt", "sahf", "sse3", "sse4.1", "sse4.2", "ssse3"),
        *("avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave"),
    )
)
# Marks code that is kept for a `_Library`.
_KEPT = "kept"
# A target of numba: the triple, the name of the processor, and its features as text.
_Target = tuple[str, str, str]
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


@cache
def baseline_target(target: _Target) -> _Target | None:
    """Return the target of a wheel's kernels if their code runs on ``target``, otherwise None.

    Parameters
    ----------
    target : tuple of str
        Triple, name and features of a processor, as numba's ``magic_tuple``. Without ``fma`` among
        the features, for example, a wheel's kernels are not used.
    """
    triple, _, features = target
    present = {name[1:] for name in features.split(",") if name.startswith("+")}
    return (triple, BASELINE, "") if present >= _FEATURES else None


def is_kept(kernel: Any) -> bool:
    """Return whether a kernel is on disk for this processor, or was never compiled at all.

    Parameters
    ----------
    kernel : callable
        A result of a :class:`Compiler`. With ``NUMBA_DISABLE_JIT`` it is not compiled.
    """
    kept = getattr(getattr(kernel, "_cache", None), "_cache_file", None)
    return kept is None or kept.has_kernel(kernel.targetctx.codegen().magic_tuple())


class _Unwritable(InTreeCacheLocator):  # type: ignore[misc]  # numba has no types.
    """The folder of the sources, where neither it nor a folder of the user can be written.

    Kernels of a wheel are loaded from there; a kernel that is missing is compiled in each process.
    numba itself refuses to cache in such a place.
    """

    def ensure_cache_path(self) -> None:
        """Do nothing: :meth:`_CheckedFiles.save` meets the error, and ignores it."""


class _Library(JITCodeLibrary):  # type: ignore[misc]  # numba has no types.
    """Code of a kernel, with its bitcode, which only a compilation of its callers needs.

    numba parses the bitcode of each kernel that it loads, which takes longer than the rest.
    """

    _bitcode = b""
    _parsed: Any = None

    @property
    def _shared_module(self) -> Any:
        if self._parsed is None and self._bitcode:
            self._parsed = llvm.parse_bitcode(self._bitcode)
        return self._parsed

    @_shared_module.setter
    def _shared_module(self, module: Any) -> None:
        self._parsed = module

    def defined(self) -> set[str]:
        """Return the names that the code defines."""
        module = self._get_module_for_linking()
        found = (*module.functions, *module.global_variables)
        return {each.name for each in found if not each.is_declaration}

    @classmethod
    def _unserialize(cls, codegen: Any, state: Any) -> Any:
        name, kind, content = state
        if kind != _KEPT:  # A cache of numba itself.
            return super()._unserialize(codegen, state)
        code, bitcode, names = content
        library = codegen.create_library(name)
        library._bitcode = bitcode
        library.enable_object_caching()
        library._set_compiled_object(code)
        library._finalize_final_module()
        codegen._engine._defined_symbols |= names
        return library


class _Places(CompileResultCacheImpl):  # type: ignore[misc]  # numba has no types.
    """Where numba keeps kernels, and the form in which it keeps them: for a :class:`_Library`."""

    _locator_classes = [*CompileResultCacheImpl._locator_classes, _Unwritable]

    def reduce(self, data: Any) -> Any:
        """Leave out the table of types, a text for readers, which is long."""
        (name, _, code), *rest = super().reduce(data._replace(type_annotation=""))
        return ((name, _KEPT, (*code, data.library.defined())), *rest)


class _Cache(FunctionCache):  # type: ignore[misc]  # numba has no types.
    """A kernel's cache, which loads a compiled kernel without the parts of numba that compile.

    numba itself first imports its implementations of Python and NumPy, and with them SciPy, which
    takes longer than everything else. A compilation still imports them.

    Parameters
    ----------
    stamp : str
        See :func:`source_stamp`.
    """

    _impl_class = _Places

    def __init__(self, function: Callable[..., object], stamp: str) -> None:
        super().__init__(function)
        place = function.__module__, function.__qualname__
        name = self._impl.filename_base
        self._cache_file = files = _CheckedFiles(self._cache_path, name, stamp, place)
        # A wheel has its kernels beside the sources, wherever new ones are written.
        beside = str(Path(inspect.getfile(function)).parent / "__pycache__")
        if beside != self._cache_path:
            files.of_wheel = _CheckedFiles(beside, name, stamp, place)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the kernel for a signature, or None if it is not on disk."""
        rtsys.initialize(target_context)  # Kernels that make arrays call it.
        # Before the first kernel is loaded or compiled.
        target_context.codegen()._library_class = _Library
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)


class _CheckedFiles(IndexDataCacheFile):  # type: ignore[misc]  # numba has no types.
    """The files in which numba keeps a kernel; a damaged file counts as none.

    numba itself would fail at a truncated file every time, and would run the code of an altered
    file. A kernel for :data:`BASELINE` serves every processor that has its features.

    Parameters
    ----------
    place : tuple of str
        Module and name of the kernel.
    """

    def __init__(self, path: str, name: str, stamp: str, place: tuple[str, str]) -> None:
        super().__init__(path, name, stamp)
        # The stamp is also part of the version, which is read first: a cache of other sources
        # may contain objects of classes that no longer exist and must not be read.
        self._version = f"{numba.__version__} {stamp}"
        self._place = place
        #: The files that a wheel may have brought; these, or files that are only read.
        self.of_wheel = self

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

    def has_kernel(self, target: _Target) -> bool:
        """Return whether there is a kernel, for whichever types, that runs on ``target``."""
        own = any(key[1] == target for key in self._load_index())
        baseline = baseline_target(target)
        return own or any(key[1] == baseline for key in self.of_wheel._load_index())

    def load(self, key: Any) -> Any:
        """Return a saved kernel, after its compilation elsewhere if there is one, or None."""
        found = self._loaded(key)
        types, target, code = key
        if found is None and (baseline := baseline_target(target)) is not None:
            found = self.of_wheel._loaded((types, baseline, code))
        module, name = self._place
        # A function of a function, or of the program's main file, cannot be found by its name.
        if found is None and _By.elsewhere and name.isidentifier() and module != "__main__":
            with event.trigger_event(COMPILING):
                _By.elsewhere(module, name, types)
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
