"""Install everything `make` needs on a bare Debian or Ubuntu; a second call does nothing.

Usage: python3 tools/setup.py [plan|test|synth|long]

`plan` installs the packages for planning on the simulated board. `test` (the default) adds the
packages of the tests and `make lint`, `synth` the tools of `make bitstream`, and `long` the
random-number tests of `make test-long`. Python packages go to .venv/ in the repository root.
Missing system packages are installed with apt-get if that needs no password (root or sudo);
otherwise one sentence names them.

Exit status 0: done; 1: something is missing; 2: wrong usage; 75: this Python is too old.

This file only decides, in a few milliseconds, whether anything is missing; install.py installs it.
"""

from __future__ import annotations

import fcntl
import hashlib
import sys
from pathlib import Path


ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / ".venv"
STAMP = VENV / "pathgene-setup"

#: Each level includes the previous ones.
LEVELS = ("plan", "test", "synth", "long")


def main(arguments: list[str]) -> int:
    """Set up for a level; return the exit status."""
    if sys.version_info < (3, 11):
        return 75
    level = arguments[0] if arguments else "test"
    if level not in LEVELS or len(arguments) > 1:
        print((__doc__ or "").splitlines()[2], file=sys.stderr)
        return 2
    if is_done(level):
        return 0
    # If two calls run at the same time, the second waits. The lock needs an existing file.
    with (ROOT / "pyproject.toml").open() as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if is_done(level):
            return 0
        from install import SetupError, set_up

        try:
            set_up(level, VENV, ROOT)
        except SetupError as error:
            print(f"setup: {error}", file=sys.stderr)
            return 1
        STAMP.write_text(stamp_of(level) + "\n")
    return 0


def is_done(level: str) -> bool:
    """Return whether an earlier call already set up this level."""
    try:
        stamp = STAMP.read_text().strip()
    except OSError:
        return False
    enough = LEVELS[LEVELS.index(level) :]
    return stamp in map(stamp_of, enough) and (VENV / "bin" / "python").exists()


def stamp_of(level: str) -> str:
    """Return a digest of everything a finished set-up depends on."""
    state = hashlib.sha256()
    for part in (
        (ROOT / "pyproject.toml").read_bytes(),
        *(path.read_bytes() for path in (Path(__file__), Path(__file__).with_name("install.py"))),
        str(VENV).encode(),  # Its scripts contain its path, so a copied tree needs a new one.
        repr(sys.version_info[:2]).encode(),
        level.encode(),
    ):
        state.update(hashlib.sha256(part).digest())
    return state.hexdigest()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
