"""A cache of build results that several processes can use simultaneously."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import hashlib
import logging
import os
import secrets
import shutil
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from pathgene.host.errors import JobError
from pathgene.host.files.disk import current


__all__ = ["BuildCache", "build_root", "digest"]

_LOG = logging.getLogger("pathgene.build")

# The file of checksums in each directory.
_SUMS = "SHA256SUMS"
# Random digits at the end of the name of a directory that is being built.
_DIGITS = 8


def build_root() -> Path:
    """Return the directory of generated files.

    In a checkout this is ``build/`` next to the sources. Otherwise it is ``pathgene`` in the user's
    cache directory (``XDG_CACHE_HOME``).
    """
    checkout = Path(__file__).resolve().parents[1]
    if (checkout / "pyproject.toml").is_file():
        return checkout / "build"
    cache = os.environ.get("XDG_CACHE_HOME")
    return (Path(cache) if cache else Path.home() / ".cache") / "pathgene"


def digest(parts: Iterable[str | bytes]) -> str:
    """Return 20 hexadecimal digits that depend on the parts and the boundaries between them."""
    state = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        state.update(len(data).to_bytes(8, "little"))
        state.update(data)
    return state.hexdigest()[:20]


class BuildCache:
    """Directories named by a key, a digest of everything that their contents depend on.

    Parameters
    ----------
    root : Path
        Parent of the directories, created when first needed.
    """

    def __init__(self, root: Path) -> None:
        self.root = root

    def get(self, key: str, build: Callable[[Path], None]) -> Path:
        """Return the directory of ``key``, calling ``build`` unless it exists and is complete.

        ``build`` fills an empty directory, which only gets its final name when ``build`` returns,
        so that later calls never find the result of a build that failed or was killed. A file in it
        lists the SHA-256 of all other files; a directory that differs from the list is built again.
        If several processes need the same key, one builds while the rest wait. A build removes the
        remains of killed builds with any key.

        Parameters
        ----------
        key : str
            Name of the directory: letters, digits, ``-`` and ``_``.
        build : Callable[[Path], None]
            Fills the directory that it is called with.

        Raises
        ------
        JobError
            If the cache cannot be written to.
        """
        if not key.replace("-", "").replace("_", "").isalnum():
            raise ValueError(f"Key must be letters, digits, '-' and '_', not {key!r}")
        final = self.root / key
        if _is_whole(final):
            return final
        try:
            current().make_directory(self.root)
            with self._locked(key):
                self._build(final, build)
        except OSError as error:
            raise JobError(
                f"Cannot build in {str(self.root)!r} ({error.strerror or error}); free space or "
                "permit writing there, or move the checkout; an installed pathgene builds in the "
                "directory that XDG_CACHE_HOME names."
            ) from None
        return final

    def _build(self, final: Path, build: Callable[[Path], None]) -> None:
        """Build the directory ``final``, whose lock this process holds."""
        self._clear(final.name)
        # Another process may have built it meanwhile.
        if _is_whole(final):
            return
        name = final.name.rpartition("-")[0]
        partial, damaged = self._beside(final), None
        if os.path.lexists(final):
            if not final.is_dir():
                raise NotADirectoryError(errno.ENOTDIR, f"{final.name} is no directory")
            _LOG.info("the files of %s are damaged", name)
            current().rename(final, damaged := self._beside(final))
        _LOG.info("building %s; it is kept for the next time", name)
        try:
            current().make_directory(partial)
            build(partial)
            with current().create(partial / _SUMS) as file:
                file.write(_sums(partial))
                current().sync(file)
            current().rename(partial, final)
        finally:
            shutil.rmtree(partial, ignore_errors=True)
            if damaged is not None:
                shutil.rmtree(damaged, ignore_errors=True)

    def _clear(self, held: str) -> None:
        """Remove directories left by killed builds; this process holds the lock ``held``."""
        for left in self.root.glob(f"*.{'[0-9a-f]' * _DIGITS}"):
            key = left.name.rpartition(".")[0]
            # A running build holds the lock of its key and keeps its directory.
            lock = contextlib.nullcontext() if key == held else self._locked(key, wait=False)
            with contextlib.suppress(OSError), lock:
                shutil.rmtree(left, ignore_errors=True)

    def _beside(self, final: Path) -> Path:
        return self.root / f"{final.name}.{secrets.token_hex(_DIGITS // 2)}"

    @contextlib.contextmanager
    def _locked(self, key: str, *, wait: bool = True) -> Iterator[None]:
        # The lock is released when its holder ends; the empty file stays.
        with current().append(self.root / f"{key}.lock") as file:
            fcntl.flock(file, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
            yield


def _is_whole(directory: Path) -> bool:
    """Return whether a directory has exactly the files that its list states, unchanged."""
    try:
        stated = (directory / _SUMS).read_bytes()
        return stated == _sums(directory)
    except OSError:
        return False


def _sums(directory: Path) -> bytes:
    """Return the SHA-256 and the name of each file in a directory, as ``sha256sum`` does."""
    lines = []
    for path in sorted(directory.rglob("*")):
        if path.is_file() and path.name != _SUMS:
            with path.open("rb") as file:
                digest = hashlib.file_digest(file, "sha256").hexdigest()
            lines.append(f"{digest}  {path.relative_to(directory)}\n")
    return "".join(lines).encode()
