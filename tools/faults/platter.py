"""A folder on a disk whose power fails: bytes and names that were not synced may be lost."""

from __future__ import annotations

import os
import random
from dataclasses import dataclass
from pathlib import Path


#: Bytes that a disk stores together or not at all.
_SECTOR = 512
#: Share of the torn files and writes that lack only their last byte, which may end a line.
TEARS_LAST = 0.25


class _Content:
    """The bytes of a file, whatever its names are."""

    def __init__(self, synced: bytes) -> None:
        self.synced = synced
        #: The bytes when the file lost its last name; before that, the folder has them.
        self.last = synced


@dataclass(frozen=True)
class _Step:
    """A change of names: ``content`` loses the name ``old`` and gets the name ``new``."""

    content: _Content
    old: Path | None = None
    new: Path | None = None

    def apply(self, names: dict[Path, _Content]) -> None:
        """Change ``names``; a name that another file has by now is left alone."""
        if self.old is not None and names.get(self.old) is self.content:
            del names[self.old]
        if self.new is not None:
            names[self.new] = self.content


class Platter:
    """The state of a folder that survives a loss of power.

    The folder itself has all changes, as the system shows them to every process. This object notes
    the synced bytes of each file, and the changes of names since the folder was synced.

    Parameters
    ----------
    folder : Path
        A folder without folders. Its present files count as synced. Files elsewhere are not noted.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._names = {file: _Content(file.read_bytes()) for file in folder.iterdir()}
        self._synced_names = dict(self._names)
        self._steps: list[_Step] = []

    def enter(self, place: Path) -> None:
        """Note a new file, unless it is known."""
        if place.parent == self._folder and place not in self._names:
            self._note(_Step(_Content(b""), new=place))

    def link(self, source: Path, target: Path) -> None:
        """Note a second name."""
        if (content := self._names.get(source)) is not None:
            self._note(_Step(content, new=target))

    def move(self, source: Path, target: Path) -> None:
        """Note a new name, before it is given."""
        if (content := self._names.get(source)) is not None:
            self._keep(target)
            self._note(_Step(content, source, target))

    def remove(self, place: Path) -> None:
        """Note that a name goes, before it does."""
        if (content := self._names.get(place)) is not None:
            self._keep(place)
            self._note(_Step(content, place))

    def sync(self, place: Path) -> None:
        """Note that the bytes of a file are on the disk."""
        if (content := self._names.get(place)) is not None:
            content.synced = place.read_bytes()

    def sync_names(self, folder: Path) -> None:
        """Note that the names in a folder are on the disk."""
        if folder == self._folder:
            self._synced_names = dict(self._names)
            self._steps.clear()

    def lose(self, rng: random.Random) -> None:
        """Turn the power off and on: change the folder to a state that the disk may have.

        Names are lost from some moment on, as with a journal, or each on its own. A file keeps any
        part of the sectors that were not synced; zeros take the place of lost ones.
        """
        steps = self._steps
        if rng.random() < 0.5:
            left = steps[: rng.randrange(len(steps) + 1)]
        else:
            left = [step for step in steps if rng.random() < 0.5]
        names = dict(self._synced_names)
        for step in left:
            step.apply(names)
        present = {content: file.read_bytes() for file, content in self._names.items()}
        places: dict[_Content, Path] = {}
        for file in self._folder.iterdir():
            file.unlink()
        for place, content in sorted(names.items()):
            if content in places:
                os.link(places[content], place)
                continue
            places[content] = place
            content.synced = _torn(content.synced, present.get(content, content.last), rng)
            place.write_bytes(content.synced)
        self._names = names
        self._synced_names = dict(names)
        self._steps = []

    def _note(self, step: _Step) -> None:
        self._steps.append(step)
        step.apply(self._names)

    def _keep(self, place: Path) -> None:
        """Keep the bytes of a file whose name goes, because the loss of the change restores it."""
        if (content := self._names.get(place)) is not None:
            content.last = place.read_bytes()


def _torn(synced: bytes, present: bytes, rng: random.Random) -> bytes:
    """Return the bytes of a file of which ``synced`` are certainly on the disk."""
    if present == synced:
        return synced
    share = rng.choice((0.0, 0.5, 1.0))
    length = rng.randint(len(synced), max(len(synced), len(present)))
    if len(present) > len(synced) and rng.random() < TEARS_LAST:
        length, share = len(present) - 1, 1.0
    torn = bytearray(present[:length])
    for first in range(len(synced), len(torn), _SECTOR):
        end = min(first + _SECTOR, len(torn))
        if rng.random() >= share:
            torn[first:end] = bytes(end - first)
    return bytes(torn)
