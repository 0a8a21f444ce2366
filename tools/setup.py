"""Sets up everything that `make` needs, on a bare Debian or Ubuntu; a second call does nothing.

Usage: python3 tools/setup.py [plan|test|synth|long]

`plan` installs what planning on the simulated board needs; `test` (the default) adds what the tests
and `make lint` need, `synth` the tools of `make bitstream`, `long` the battery of random tests in
`make test-long`. Python packages go to .venv/ in the repository root. System packages that are
missing are installed with apt-get where this may be done without asking (root, or sudo without a
password); otherwise one sentence names them.

Exit status 0: done; 1: something is missing; 2: wrong usage; 75: this Python is too old.

This file only finds out whether there is work, in a few milliseconds; install.py does it.
"""

from __future__ import annotations

import fcntl
import hashlib
import sys
from pathlib import Path


ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / ".venv"
STAMP = VENV / "pathgene-setup"

#: Each level includes those before it.
LEVELS = ("plan", "test", "synth", "long")


def main(arguments: list[str]) -> int:
    """Set up for a level; returns the exit status."""
    if sys.version_info < (3, 11):
        return 75
    level = arguments[0] if arguments else "test"
    if level not in LEVELS or len(arguments) > 1:
        print((__doc__ or "").splitlines()[2], file=sys.stderr)
        return 2
    if is_done(level):
        return 0
    # Of two at once, one works and the other finds it done. The lock needs a file that is there.
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
    """Return whether an earlier call did all this one would do."""
    try:
        stamp = STAMP.read_text().strip()
    except OSError:
        return False
    enough = LEVELS[LEVELS.index(level) :]
    return stamp in map(stamp_of, enough) and (VENV / "bin" / "python").exists()


def stamp_of(level: str) -> str:
    """Return what identifies a finished set-up: a change of any part of it asks for a new one."""
    state = hashlib.sha256()
    for part in (
        (ROOT / "pyproject.toml").read_bytes(),
        *(path.read_bytes() for path in (Path(__file__), Path(__file__).with_name("install.py"))),
        str(VENV).encode(),  # Scripts in it hold its path: a copied tree needs its own.
        repr(sys.version_info[:2]).encode(),
        level.encode(),
    ):
        state.update(hashlib.sha256(part).digest())
    return state.hexdigest()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
