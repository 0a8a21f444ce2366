"""Write the tables of options into the documentation: ``python -m tools.option_tables``."""

from __future__ import annotations

from pathlib import Path

from pathgene.host.mission.problem_file import markdown


PAGE = Path(__file__).resolve().parents[1] / "docs" / "reference.md"
_BEGIN, _END = "<!-- keys -->\n\n", "\n<!-- end of keys -->"


def main() -> None:
    """Replace the tables between the marks of the page."""
    text = PAGE.read_text()
    before, _, rest = text.partition(_BEGIN)
    _, _, after = rest.partition(_END)
    PAGE.write_text(f"{before}{_BEGIN}{markdown()}{_END}{after}")


if __name__ == "__main__":
    main()
