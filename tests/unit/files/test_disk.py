"""The disk that all output goes to."""

import pytest

from pathgene.host.files.disk import Disk, current, using


def test_another_disk_is_used_in_a_block_alone():
    usual, other = current(), Disk()

    def break_off():
        with using(other):
            assert current() is other
            raise RuntimeError("broken")

    with pytest.raises(RuntimeError, match=r"^broken$"):
        break_off()
    assert current() is usual


def test_a_new_file_never_replaces_one(tmp_path):
    disk = Disk()
    with disk.create(tmp_path / "a") as file:
        file.write(b"old")
        disk.sync(file)
        assert (tmp_path / "a").read_bytes() == b"old"
    with pytest.raises(FileExistsError):
        disk.create(tmp_path / "a")
    with disk.append(tmp_path / "a") as file:
        file.write(b" and new")
    assert (tmp_path / "a").read_bytes() == b"old and new"


def test_a_link_is_a_second_name_of_a_link(tmp_path):
    (tmp_path / "file").write_bytes(b"content")
    (tmp_path / "link").symlink_to("file")
    Disk().link(tmp_path / "link", tmp_path / "second")
    assert (tmp_path / "second").is_symlink()
