"""The script of the continuous integration, and the rules of ``make lint`` without Verilog."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest


ROOT = Path(__file__).resolve().parents[3]

GREEN = "===== 12 passed, 3 skipped, 1 xfailed in 61.20s (0:01:01) =====", 0
RED = "===== 2 failed, 7 passed, 1 error in 3.10s =====", 2
EMPTY = "===== no tests ran in 0.05s =====", 2
BROKEN = "make: *** No rule to make target 'test'.", 2
SILENT = "", 0


@pytest.mark.parametrize(
    ("first", "second", "last", "status"),
    [
        (GREEN, GREEN, "24 passed, 0 failed", 0),
        (RED, GREEN, "19 passed, 3 failed", 2),
        (GREEN, RED, "19 passed, 3 failed", 2),
        (GREEN, EMPTY, "12 passed, 1 failed", 2),
        (BROKEN, GREEN, "12 passed, 1 failed", 2),
        (SILENT, GREEN, "12 passed, 1 failed", 1),
    ],
)
def test_last_line_and_status(tmp_path, first, second, last, status):
    """A scripted `make` prints a line and the results of each target."""
    for (line, code), target in ((first, "test"), (second, "test-ci")):
        (tmp_path / target).write_text(f"{line}\n")
        (tmp_path / f"{target}.status").write_text(str(code))
    make = tmp_path / "make"
    make.write_text(
        '#!/bin/bash\nfolder="$(dirname "$0")"\ntarget="${@: -1}"\n'
        'cat "$folder/$target"\nexit "$(cat "$folder/$target.status")"\n'
    )
    make.chmod(0o755)
    done = subprocess.run(
        [ROOT / ".ci" / "run"],
        env={**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"},
        stdout=subprocess.PIPE,
        text=True,
        check=False,
    )
    assert done.stdout.splitlines()[-1] == last
    assert done.returncode == status


@pytest.mark.ci
@pytest.mark.parametrize("target", ["test", "test-ci"])
def test_a_test_that_hangs_fails_and_the_others_run(tmp_path, target):
    recipe = subprocess.run(
        ["make", "-n", target], cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True
    ).stdout
    options = " ".join(re.findall(r"-o \S+", recipe)).replace("timeout=600", "timeout=1").split()
    (tmp_path / "test_three.py").write_text(
        "import time\n\ndef test_a(): pass\n\ndef test_b(): time.sleep(60)\n\ndef test_c(): pass\n"
    )
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-n", "1", "-p", "no:cacheprovider", *options],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert "1 failed, 2 passed" in done.stdout
    assert re.search(r'File ".*test_three\.py", line 5 in test_b', done.stdout)


@pytest.mark.ci
@pytest.mark.parametrize(
    "command",
    [("ruff", "check", "."), ("ruff", "format", "--check", "."), ("mypy",)],
    ids=["rules", "format", "types"],
)
def test_sources_are_clean(command):
    done = subprocess.run(
        [sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
