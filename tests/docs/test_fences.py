"""Every command and program of the documentation runs, or states why it does not."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.pages import PAGES, RUN, SHOWN, fences, link_sources


#: Maximum seconds for a page's commands, on a busy machine.
LIMIT_S = 900


# Programs of a page share their names; commands run between them.
DRIVER = """
import json, subprocess, sys

names = {"__name__": "__main__"}
for place, language, text in json.load(sys.stdin):
    print(f"--- {place}", flush=True)
    if language == "python":
        exec(compile(text, place, "exec"), names)
    else:
        command = ["bash", "-euo", "pipefail", "-c", text]
        subprocess.run(command, stdin=subprocess.DEVNULL, check=True)
"""


def run_page(page, folder, *, slow):
    """Run the commands and programs of a page in order, as a reader would."""
    link_sources(folder)
    steps = [
        (str(fence), fence.language, fence.text)
        for fence in fences(page)
        if fence.language in RUN and (fence.mark is None or (slow and fence.mark == "slow"))
    ]
    bin_path = Path(sys.executable).parent
    done = subprocess.run(
        [sys.executable, "-c", DRIVER],
        cwd=folder,
        env={**os.environ, "PATH": f"{bin_path}{os.pathsep}{os.environ['PATH']}"},
        input=json.dumps(steps),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:]


def pages_with(*, slow):
    """Return the pages that have a fence to run, or a slow fence."""
    return [
        page
        for page in PAGES
        if any(
            fence.language in RUN and fence.mark == ("slow" if slow else None)
            for fence in fences(page)
        )
    ]


@pytest.mark.parametrize("page", PAGES)
def test_every_fence_names_its_language(page):
    for fence in fences(page):
        assert fence.language in RUN | SHOWN or fence.language.startswith("{"), (
            f"{fence}: name the language of the fence, one of {', '.join(sorted(RUN | SHOWN))}; "
            "sh and python are run unless a comment <!-- not run: REASON --> is before them"
        )
        assert fence.mark is None or fence.language in RUN, f"{fence}: nothing to run there"


@pytest.mark.parametrize(
    "page",
    [
        # The page that a newcomer follows; the remaining pages take longer.
        pytest.param(page, marks=[] if page == "README.md" else [pytest.mark.ci])
        for page in pages_with(slow=False)
    ],
)
def test_quick_commands_run(page, tmp_path):
    run_page(page, tmp_path, slow=False)


@pytest.mark.ci
@pytest.mark.parametrize(
    "page",
    [
        # The pages of a newcomer; the reference has variants of commands tested elsewhere.
        pytest.param(page, marks=[pytest.mark.long] if page == "docs/reference.md" else [])
        for page in pages_with(slow=True)
    ],
)
def test_slow_commands_run(page, tmp_path):
    run_page(page, tmp_path, slow=True)


def test_reads_marks_and_languages():
    text = (
        "```sh\na\n```\n\n<!-- slow: an hour -->\n```sh\nb\nc\n```\n\n"
        "1. First:\n\n   <!-- not run: no board here -->\n   ```python\n   if d:\n       e\n"
        "   ```\n\n```\nf\n```\n\n````text\n```sh\ng\n```\n````\n"
    )
    found = fences("page.md", text)
    assert [(fence.language, fence.text, fence.mark, fence.reason) for fence in found] == [
        ("sh", "a\n", None, None),
        ("sh", "b\nc\n", "slow", "an hour"),
        ("python", "if d:\n    e\n", "not run", "no board here"),
        ("", "f\n", None, None),
        ("text", "```sh\ng\n```\n", None, None),
    ]
    assert [fence.line for fence in found] == [1, 6, 14, 19, 23]


def test_a_failing_command_fails(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("```sh\nfalse | cat\n```\n")
    folder = tmp_path / "run"
    folder.mkdir()
    with pytest.raises(AssertionError, match=r"page\.md:1"):
        run_page(page, folder, slow=False)
