"""``python -m tools.protocol_page``: write the protocol's page and its golden frames."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tools.protocol_page.frames import golden_frames
from tools.protocol_page.page import protocol_page


_DOCS = Path(__file__).resolve().parents[2] / "docs"
FRAMES = _DOCS / "protocol_frames.json"
PAGE = _DOCS / "protocol.md"


def contents() -> dict[Path, str]:
    """Return the content of each file."""
    frames = golden_frames()
    return {FRAMES: _frames_text(frames), PAGE: protocol_page(frames)}


def _frames_text(frames: dict[str, Any]) -> str:
    """Return the golden frames as JSON, one exchange per line."""
    lines = []
    for chip in frames["chips"]:
        exchanges = ",\n".join(f"  {json.dumps(exchange)}" for exchange in chip["exchanges"])
        head = json.dumps({name: chip[name] for name in ("name", "board", "config")})
        lines.append(f'{head[:-1]}, "exchanges": [\n{exchanges}\n ]}}')
    head = json.dumps({name: frames[name] for name in ("protocol_version", "timed")})
    chips = ",\n ".join(lines)
    return f'{head[:-1]}, "chips": [\n {chips}\n]}}\n'


def main() -> None:
    """Write every file."""
    for path, text in contents().items():
        path.write_text(text)
        print(f"Wrote docs/{path.name}.")


if __name__ == "__main__":
    main()
