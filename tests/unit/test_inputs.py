"""Files given by a user: regular files of a size that fits in memory."""

import os
import resource
import subprocess
import sys

import pytest

from pathgene.host.errors import InputError
from pathgene.host.inputs import MOST_TEXT_BYTES, exists, opened, read_text, require_regular


# Names that no file can have: a NUL, half a surrogate pair, more characters than a name has.
IMPOSSIBLE = ("a\0b", "\ud800", "a" * 5000)


def test_reads_a_text(tmp_path):
    file = tmp_path / "text"
    file.write_bytes("\ufeffé\r\n".encode())
    assert read_text(file) == "\ufeffé\r\n"
    assert read_text(file, "utf-8-sig") == "é\r\n"
    file.write_bytes(b"\xff")
    with pytest.raises(UnicodeDecodeError):
        read_text(file)


def test_refuses_a_fifo_and_a_device(tmp_path):
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    for path in (fifo, type(fifo)(os.devnull)):
        for read in (require_regular, read_text):
            with pytest.raises(InputError) as error:
                read(path)
            assert str(error.value) == (
                f"{path}: must be a regular file, not a pipe or a device; copy it into one."
            )


def test_a_system_error_is_left_to_the_caller(tmp_path):
    with pytest.raises(IsADirectoryError, match="Is a directory"), opened(tmp_path):
        pass
    with pytest.raises(FileNotFoundError):
        read_text(tmp_path / "nowhere")


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_a_name_that_no_file_has(tmp_path, name):
    assert not exists(tmp_path / name)
    with pytest.raises(OSError, match=r"No file has such a name|File name too long"):
        read_text(tmp_path / name)


def test_a_text_has_a_limit(tmp_path):
    """The limit is checked while reading: a sparse file of 100 GB takes no memory."""
    file = tmp_path / "sparse.toml"
    with file.open("wb") as sparse:
        sparse.truncate(100 * 10**9)
    script = (
        "import sys; from pathlib import Path; from pathgene.host.inputs import read_text\n"
        "try: read_text(Path(sys.argv[1]))\n"
        "except Exception as error: print(error)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, file],
        capture_output=True,
        text=True,
        check=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (10**9, 10**9)),
    )
    assert done.stdout == (
        f"{file}: has more than {MOST_TEXT_BYTES // 10**6} MB, too much for a text; give a smaller "
        "file.\n"
    )
