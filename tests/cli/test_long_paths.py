"""Paths and sampling steps that need more samples than a computer can hold."""

import subprocess
import sys

import pytest

from .conftest import ROOT


FAR = "x,y,z\n500,500,600\n1e7,1e7,600\n5500,3500,600\n"
NEAR = "x,y,z\n500,500,600\n5500,3500,600\n"
NOT_FEASIBLE = "pathgene: The path is not feasible; the report shows its distances and limits.\n"
TOO_FINE = (
    "pathgene: A sampling step of 0.001 m makes more than 500,000 samples of the way from start "
    "to goal; increase it to 0.013 m.\n"
)
TOO_FAR = (
    "pathgene: The path is 28,277 km long, of which a sampling step of 1 m makes more than "
    "2,000,000 samples; correct the path, or increase the step to 16 m.\n"
)

pytestmark = pytest.mark.ci

MEASURE = """
import resource, subprocess, sys

done = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
sys.exit(done.returncode)
"""


@pytest.mark.parametrize("rules", [(), ("--as-paper",)], ids=["by the rules", "as paper"])
@pytest.mark.parametrize(
    ("path", "options", "status", "sentence"),
    [
        (FAR, (), 1, NOT_FEASIBLE),
        (FAR, ("--ds", "1"), 2, TOO_FAR),
        (FAR, ("--ds", "1e-3"), 2, TOO_FINE),
        (NEAR, ("--ds", "1e-3"), 2, TOO_FINE),
        (NEAR, ("--ds", "0.02"), 0, ""),
    ],
)
def test_a_check_takes_little_memory(hills, tmp_path, path, options, status, sentence, rules):
    file = tmp_path / "path.csv"
    file.write_text(path)
    command = [sys.executable, "-m", "pathgene", "check", "--terrain", hills, "--path", file]
    arguments = [*map(str, command), *options, *rules]
    # A process in between, because a new process counts the memory of its parent.
    done = subprocess.run(
        [sys.executable, "-c", MEASURE, *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (status, sentence)
    assert int(done.stdout) < 400_000, "kilobytes"
