"""The quick import of matplotlib for commands."""

import subprocess
import sys


SCRIPT = """
import sys
from pathgene.host.cli.drawing import import_quickly
import_quickly()
loaded = {name for name in sys.modules if name.startswith("matplotlib.")}
from matplotlib.patches import Rectangle
print("matplotlib.patches" in loaded, "facecolor or fc" in (Rectangle.set.__doc__ or ""))
"""


def printed(script):
    command = [sys.executable, "-c", script]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()


def test_docstrings_lack_their_tables_after_the_quick_import():
    assert printed(SCRIPT) == ["False", "False"]


def test_a_program_that_draws_keeps_the_docstrings():
    script = SCRIPT.replace("import_quickly()\n", "import pathgene.host.report.picture\n", 1)
    assert "import_quickly()" not in script
    assert printed(script) == ["True", "True"]
