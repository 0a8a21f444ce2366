"""Problems that are too large for a link: the desk keeps them, and their links are short."""

from __future__ import annotations

import hashlib
import os
import re
from pathlib import Path

from pathgene.host.errors import InputError
from pathgene.host.files.disk import current
from pathgene.host.files.output import prepare_directory, replacing, writing_into
from pathgene.host.inputs import MOST_TOML_BYTES, read_text
from pathgene.host.web.desk.sheet import MOST_BYTES, Sheet


__all__ = ["KeptProblems"]

# Beginning of the fragment of a short link; a link that holds its problem has no equals sign.
_KEPT = "kept="
_DIGITS = 24
# Maximum number of kept problems; the one that was not opened for the longest time goes first.
_MOST = 200


class KeptProblems:
    """Kept problems in a folder, each under a digest of its text.

    Parameters
    ----------
    directory : Path
        The folder; created with the first problem.
    """

    def __init__(self, directory: Path) -> None:
        self._directory = directory

    def link(self, sheet: Sheet) -> str:
        """Return the fragment of a link to a problem, which holds it or names it.

        Raises
        ------
        InputError
            If the problem is too large to be opened again, or cannot be written.
        """
        text = sheet.text().encode()
        if len(text) <= MOST_BYTES:
            return sheet.link()
        if len(text) > MOST_TOML_BYTES:
            raise InputError(
                f"The problem has more than {MOST_TOML_BYTES // 1_000_000} MB as text, so there is "
                "no link to it; remove zones, or simplify them."
            )
        digest = hashlib.sha256(text).hexdigest()[:_DIGITS]
        file = self._file(digest)
        if not file.exists():
            prepare_directory(self._directory)
            with writing_into(self._directory), replacing(file) as binary:
                binary.write(text)
            self._clear()
        return f"{_KEPT}{digest}"

    def open_link(self, sheet: Sheet, fragment: str) -> None:
        """Open the problem of a :meth:`link` in a sheet.

        Raises
        ------
        InputError
            If the desk does not keep the problem, or as for :meth:`Sheet.open_link`.
        """
        if not fragment.startswith(_KEPT):
            sheet.open_link(fragment)
            return
        digest = fragment.removeprefix(_KEPT)
        file = self._file(digest)
        try:
            if not re.fullmatch(rf"[0-9a-f]{{{_DIGITS}}}", digest):
                raise OSError
            text = read_text(file)
            os.utime(file)
        except OSError:
            raise InputError(
                "This desk does not keep the problem of the link; open it on the desk that made "
                "the link, or open its problem file."
            ) from None
        sheet.open_text(text)

    def _file(self, digest: str) -> Path:
        return self._directory / f"{digest}.toml"

    def _clear(self) -> None:
        """Remove the problems beyond the maximum number."""
        files = sorted(self._directory.glob("*.toml"), key=lambda file: file.stat().st_mtime)
        for file in files[:-_MOST]:
            current().unlink(file)
