"""A cache of what takes long to build, safe for several processes at once."""

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

_LOG = logging.getLogger(__name__)


def build_root() -> Path:
    """Return where generated files belong.

    ``build/`` beside the sources in a checkout; ``pathgene`` in the user's cache directory
    (``XDG_CACHE_HOME``) where the package was installed without one.
    """
    checkout = Path(__file__).resolve().parents[1]
    if (checkout / "pyproject.toml").is_file():
        return checkout / "build"
    cache = os.environ.get("XDG_CACHE_HOME")
    return (Path(cache) if cache else Path.home() / ".cache") / "pathgene"


def digest(parts: Iterable[str | bytes]) -> str:
    """Return 20 hexadecimal digits that depend on every part and on where one part ends."""
    state = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        state.update(len(data).to_bytes(8, "little"))
        state.update(data)
    return state.hexdigest()[:20]


class BuildCache:
    """Directories named by a key that says all their contents depend on.

    Parameters
    ----------
    root : Path
        Where the directories lie; made when first needed.
    """

    def __init__(self, root: Path) -> None:
        self.root = root

    def get(self, key: str, build: Callable[[Path], None]) -> Path:
        """Return the directory of ``key``, after calling ``build`` if there is none yet.

        ``build`` fills an empty directory that takes its final name only when it returns: a build
        that fails or is killed leaves nothing that is found later. Of several processes that want
        one key, one builds and the others wait.

        Parameters
        ----------
        key : str
            Name of the directory: letters, digits, ``-`` and ``_``.
        build : Callable[[Path], None]
            Receives the directory to fill.
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
        # The lock goes with its holder, however that ends; the empty file stays.
        with (self.root / f"{key}.lock").open("w") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            yield
