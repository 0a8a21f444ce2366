"""Pages of the documentation, their fences, and a folder in which their commands run."""

import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path


ROOT = Path(__file__).resolve().parents[2]
#: Pages whose commands run.
PAGES = (
    "README.md",
    "CONTRIBUTING.md",
    *sorted(str(path.relative_to(ROOT)) for path in ROOT.glob("docs/*.md")),
)
#: Languages of fences that show commands or programs.
RUN = {"sh", "python"}
#: Languages of all other fences; directives of the site have braces.
SHOWN = {"text", "json", "toml", "csv", "c", "verilog", "http"}

_FENCE = re.compile(
    r"^(?P<indent> *)(?P<ticks>```+)(?P<language>[^\n`]*)\n(?P<text>.*?)^ *(?P=ticks) *$",
    re.MULTILINE | re.DOTALL,
)
_MARK = re.compile(r"<!-- (?P<kind>not run|slow): (?P<reason>[^>]+) -->\n *$")


@dataclass(frozen=True)
class Fence:
    """A fence of a page."""

    page: str
    line: int
    language: str
    #: Content without its indentation.
    text: str
    #: ``not run`` or ``slow`` if a comment before the fence says so.
    mark: str | None
    reason: str | None

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"


def fences(page, text=None):
    """Return every fence of a page, in order; ``text`` defaults to the file's."""
    text = (ROOT / page).read_text("utf-8") if text is None else text
    found = []
    for match in _FENCE.finditer(text):
        mark = _MARK.search(text, 0, match.start())
        indent = len(match["indent"])
        found.append(
            Fence(
                page,
                text.count("\n", 0, match.start()) + 1,
                match["language"].strip(),
                "".join(line[indent:] for line in match["text"].splitlines(keepends=True)),
                mark["kind"] if mark else None,
                mark["reason"].strip() if mark else None,
            )
        )
    return found


def link_sources(folder):
    """Link the sources into ``folder``, except for leftovers of runs in their root."""
    for entry in ROOT.iterdir():
        if entry.name not in {".git", "build", "dist", "out"}:
            (folder / entry.name).symlink_to(entry)


def copy_sources(folder):
    """Copy the files that git tracks or would add into ``folder``, keeping links."""
    command = ["git", "-C", ROOT, "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout.decode()
    for name in listed.split("\0"):
        source = ROOT / name
        if name and (source.is_file() or source.is_symlink()):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, folder / name, follow_symlinks=False)
