"""``python -m tools.diagrams``: draw the pictures of docs/architecture.md."""

from __future__ import annotations

from tools.diagrams.files import drawn


def main() -> None:
    """Write every picture."""
    for path, text in drawn().items():
        path.write_text(text)
        print(f"Wrote docs/pictures/{path.name}.")


if __name__ == "__main__":
    main()
