"""``python -m tools.protocol_page``: write the protocol's page and its golden frames."""

from __future__ import annotations

from tools.protocol_page.files import contents


def main() -> None:
    """Write every file."""
    for path, text in contents().items():
        path.write_text(text)
        print(f"Wrote docs/{path.name}.")


if __name__ == "__main__":
    main()
