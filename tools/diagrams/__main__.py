"""``python -m tools.diagrams``: draw the pictures of docs/architecture.md."""

from __future__ import annotations

import hashlib
import re
import subprocess
import sys
from pathlib import Path

from tools.diagrams.blocks import chip, graphs
from tools.diagrams.scenes import child_scene, scenes


PICTURES = Path(__file__).resolve().parents[2] / "docs" / "pictures"


def drawn() -> dict[Path, str]:
    """Return every picture as SVG; this needs the package `graphviz-pure`."""
    pictures = {_path(name): _laid_out(graph) for name, graph in graphs().items()}
    return pictures | waveforms()


def waveforms() -> dict[Path, str]:
    """Simulate for a few seconds and return the waveforms as SVG."""
    waves = {**scenes(chip()), "child": child_scene()}
    return {_path(name): svg for name, svg in waves.items()}


def is_drawn(name: str, graph: str) -> bool:
    """Return whether the committed block diagram was made from this graph."""
    return mark_of(graph) in _path(name).read_text()


def mark_of(graph: str) -> str:
    """Return the comment in a picture that identifies its boxes and arrows.

    Descriptions in small print are ignored.
    """
    graph = re.sub(r"<font.*?</font>|<br/>", "", graph)
    return f"<!-- graph {hashlib.sha256(graph.encode()).hexdigest()[:16]} -->"


def _path(name: str) -> Path:
    return PICTURES / f"{name}.svg"


def _laid_out(graph: str) -> str:
    program = Path(sys.executable).with_name("graphviz-pure")
    done = subprocess.run(
        [program, "-Tsvg"], input=graph, capture_output=True, text=True, check=True
    )
    svg = done.stdout[done.stdout.index("<svg") :].rstrip()
    svg = re.sub(r'<g id="node\d+".*?</g>', _centred, svg, flags=re.DOTALL)
    return f"{svg}\n{mark_of(graph)}\n"


def _centred(node: re.Match[str]) -> str:
    """Return a box with centred texts, which fit with any viewer's font."""
    outline = re.search(r' d="([^"]*)"', node[0])
    if outline is None:
        return node[0]
    across = [float(x) for x in re.findall(r"(-?[\d.]+),", outline[1])]
    middle = (min(across) + max(across)) / 2
    return re.sub(
        r'text-anchor="start" x="[^"]*"', f'text-anchor="middle" x="{middle:.2f}"', node[0]
    )


def main() -> None:
    """Write every picture."""
    for path, text in drawn().items():
        path.write_text(text)
        print(f"Wrote docs/pictures/{path.name}.")


if __name__ == "__main__":
    main()
