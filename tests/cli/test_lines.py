"""Lines on standard error, with names of any length."""

import warnings

import pytest

from pathgene.host.cli import main
from pathgene.host.cli.output import LONGEST_LINE, note, print_line


def test_a_line_is_one_sentence(capsys):
    print_line("Three\nwords  here.")
    assert capsys.readouterr().err == "pathgene: Three words here.\n"


def test_a_name_does_not_control_the_terminal(capsys):
    print_line("The zone \x1b[31mR-7\x07 is bad.")
    assert capsys.readouterr().err == "pathgene: The zone ?[31mR-7? is bad.\n"


def test_beginning_and_end_of_a_long_word_stay(capsys):
    print_line(f"The value {'x' * 400} is bad.")
    print_line(f"The value {'x' * 401} is bad.")
    assert capsys.readouterr().err == (
        f"pathgene: The value {'x' * 400} is bad.\n"
        f"pathgene: The value {'x' * 100}...{'x' * 50} is bad.\n"
    )


@pytest.mark.parametrize("printed", [print_line, note])
def test_beginning_and_end_of_a_long_sentence_stay(capsys, printed):
    printed(f"The list must be short, not {[1] * 5000}; cut it.")
    line = capsys.readouterr().err.removesuffix("\n")
    assert len(line) == LONGEST_LINE
    assert line.startswith("pathgene: The list must be short, not [1, 1, 1, ")
    assert line.endswith(", 1, 1]; cut it.")


def test_a_warning_is_as_short(capsys, monkeypatch):
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)
    assert main(["planners", "--json"]) == 0  # It determines how warnings are shown.
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        warnings.showwarning(UserWarning("a " * 5000), UserWarning, "file", 1)
    assert len(capsys.readouterr().err) == LONGEST_LINE + 1
