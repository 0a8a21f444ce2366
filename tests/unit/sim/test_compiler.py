"""Build tools: their errors are one-sentence messages, and none outlives its user."""

import os
import subprocess
import sys
import threading
import time

import pytest

from pathgene.host.errors import JobError
from pathgene.sim.compiler import end_tools, run_tool


def test_returns_the_output(tmp_path):
    script = "echo out; echo err >&2; pwd; echo $NAME; cat"
    printed = run_tool(["sh", "-c", script], cwd=tmp_path, what="It", env={"NAME": "value"})
    assert printed == f"out\nerr\n{tmp_path}\nvalue\n"


def test_a_missing_tool_is_a_sentence(tmp_path):
    with pytest.raises(JobError) as caught:
        run_tool(["no-such-tool"], cwd=tmp_path, what="It")
    assert str(caught.value) == "It needs no-such-tool, which is not an installed program."


@pytest.mark.parametrize("printed", ["a\nb: error: c\nd", "b: error: c"])
def test_a_failure_gives_the_first_error_and_notes_the_rest(tmp_path, printed):
    with pytest.raises(JobError) as caught:
        run_tool(["sh", "-c", f"printf '{printed}'; exit 3"], cwd=tmp_path, what="It")
    assert str(caught.value) == "It failed with status 3: b: error: c"
    assert caught.value.__notes__ == [printed]


def test_a_full_disk_has_a_remedy(tmp_path):
    script = "echo 'fatal error: error writing to a.s: No space left on device'; exit 1"
    with pytest.raises(JobError) as caught:
        run_tool(["sh", "-c", script], cwd=tmp_path, what="It")
    assert str(caught.value) == (
        "It failed with status 1: fatal error: error writing to a.s: No space left on device; "
        f"free space, or permit writing, in {str(tmp_path)!r} and in the directory for temporary "
        "files, which TMPDIR names."
    )


def test_nothing_is_left_of_a_tool_that_has_ended(tmp_path):
    script = "import os; print(os.getpgrp())"
    group = int(run_tool([sys.executable, "-c", script], cwd=tmp_path, what="It"))
    assert group != os.getpgrp()
    with pytest.raises(ProcessLookupError):
        os.killpg(group, 0)


@pytest.mark.parametrize("delay_s", [0, 0.3])
def test_the_tools_of_all_threads_end_together(tmp_path, monkeypatch, delay_s):
    """A tool ends even if its thread does not know yet that it has been started."""
    failures = []
    start = subprocess.Popen

    def slow(*arguments, **options):
        process = start(*arguments, **options)
        time.sleep(delay_s)
        return process

    monkeypatch.setattr(subprocess, "Popen", slow)

    def run():
        try:
            run_tool(["sh", "-c", "touch started; sleep 600"], cwd=tmp_path, what="It")
        except JobError as error:
            failures.append(str(error))

    thread = threading.Thread(target=run)
    thread.start()
    while not (tmp_path / "started").exists():
        time.sleep(0.01)
    end_tools()
    thread.join(60)
    assert failures == ["It failed with status -9: it printed nothing"]
