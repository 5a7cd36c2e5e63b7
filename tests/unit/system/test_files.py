"""Files are replaced as a whole, keep who may read them, and leave nothing beside them."""

import sys
from pathlib import Path

import pytest

from app.system.files import whole_file, write_whole

posix_only = pytest.mark.skipif(sys.platform == "win32", reason="Windows has neither modes nor /dev")


def write_half(path: Path) -> None:
    with whole_file(path) as file:
        file.write(b"new")
        raise RuntimeError


def test_what_ends_with_an_error_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "file"
    write_whole(path, b"old")
    with pytest.raises(RuntimeError):
        write_half(path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@posix_only
def test_who_may_read_a_file_stays(tmp_path: Path) -> None:
    path = tmp_path / "file"
    write_whole(path, b"old")
    path.chmod(0o640)
    write_whole(path, b"new")
    assert path.stat().st_mode & 0o777 == 0o640
    write_whole(path, b"secret", is_private=True)
    assert path.stat().st_mode & 0o777 == 0o600


@posix_only
def test_a_device_is_written_to_and_not_replaced(tmp_path: Path) -> None:
    write_whole(Path("/dev/null"), b"gone")
    assert not Path("/dev/null").is_file()
    link = tmp_path / "link"
    link.symlink_to("/dev/null")
    write_whole(link, b"gone")
    assert link.is_symlink()
