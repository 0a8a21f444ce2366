"""The notebook equals the tutorial, has no outputs, and runs from top to bottom."""

import asyncio
import json
import os
import sys
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from tools.notebook import NOTEBOOK, TUTORIAL, notebook


def test_the_notebook_is_the_tutorial():
    assert NOTEBOOK.read_text("utf-8") == notebook(TUTORIAL.read_text("utf-8")), (
        "write it anew with python -m tools.notebook"
    )


def test_cells_of_a_page():
    page = (
        "# A\n\n<!-- not run: no -->\n```sh\nls\n```\n\n<!-- slow: why -->\n```python\na = 1\n```\n"
        "\nB\n\n```python\nb = 2\n```\n"
    )
    cells = json.loads(notebook(page))["cells"]
    assert [(cell["cell_type"], "".join(cell["source"])) for cell in cells] == [
        ("markdown", "# A\n\n```sh\nls\n```"),
        ("code", "# Show the pictures of `plot()` in the notebook.\n%matplotlib inline"),
        ("code", "a = 1"),
        ("markdown", "B"),
        ("code", "b = 2"),
    ]
    nbformat.validate(nbformat.reads(notebook(page), as_version=4))


@pytest.mark.ci
def test_the_notebook_runs(tmp_path, monkeypatch):
    # Only the kernel of this environment, not the user's.
    monkeypatch.setenv("JUPYTER_PATH", str(Path(sys.prefix) / "share" / "jupyter"))
    monkeypatch.setenv("JUPYTER_PREFER_ENV_PATH", "1")
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    document = nbformat.read(NOTEBOOK, as_version=4)
    resources = {"metadata": {"path": str(tmp_path)}}
    client = NotebookClient(document, timeout=600, kernel_name="python3", resources=resources)
    asyncio.run(client.async_execute())
    outputs = [output for cell in document.cells for output in cell.get("outputs", ())]
    assert [output for output in outputs if "image/png" in output.get("data", {})]
    assert (tmp_path / "out" / "tutorial" / "summary.json").is_file()
