"""A cache of build results that several processes can use at the same time."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import logging
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path


__all__ = ["BuildCache", "build_root", "digest"]

_LOG = logging.getLogger("pathgene.build")


def build_root() -> Path:
    """Return the directory of generated files.

    In a checkout this is ``build/`` beside the sources. Otherwise it is ``pathgene`` in the user's
    cache directory (``XDG_CACHE_HOME``).
    """
    checkout = Path(__file__).resolve().parents[1]
    if (checkout / "pyproject.toml").is_file():
        return checkout / "build"
    cache = os.environ.get("XDG_CACHE_HOME")
    return (Path(cache) if cache else Path.home() / ".cache") / "pathgene"


def digest(parts: Iterable[str | bytes]) -> str:
    """Return 20 hexadecimal digits that depend on every part and on the bounds of the parts."""
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
        Parent of the directories, made when first needed.
    """

    def __init__(self, root: Path) -> None:
        self.root = root

    def get(self, key: str, build: Callable[[Path], None]) -> Path:
        """Return the directory of ``key``, after calling ``build`` if it does not exist yet.

        ``build`` fills an empty directory, which gets its final name only when ``build`` returns:
        later calls never find the result of a build that failed or was killed. If several processes
        need the same key, one builds and the others wait.

        Parameters
        ----------
        key : str
            Name of the directory: letters, digits, ``-`` and ``_``.
        build : Callable[[Path], None]
            Fills the directory that it is called with.
        """
        if not key.replace("-", "").replace("_", "").isalnum():
            raise ValueError(f"Key must be letters, digits, '-' and '_', not {key!r}")
        final = self.root / key
        if final.is_dir():
            return final
        self.root.mkdir(parents=True, exist_ok=True)
        with self._locked(key):
            if not final.is_dir():
                _LOG.info("building %s; it is kept for the next time", key.rpartition("-")[0])
                partial = Path(tempfile.mkdtemp(prefix=f"{key}.", dir=self.root))
                try:
                    build(partial)
                    partial.rename(final)
                finally:
                    shutil.rmtree(partial, ignore_errors=True)
        return final

    @contextlib.contextmanager
    def _locked(self, key: str) -> Iterator[None]:
        # The lock ends with its holder; the empty file stays.
        with (self.root / f"{key}.lock").open("w") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            yield
