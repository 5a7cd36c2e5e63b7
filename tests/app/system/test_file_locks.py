"""Locks of files: between two handles of one program, as between two programs."""

from pathlib import Path

import pytest

from app.system.files import lock


def test_a_held_file_is_refused_with_a_reason_and_can_still_be_read(tmp_path: Path) -> None:
    path = tmp_path / "held"
    path.write_bytes(b"text")
    with path.open("ab") as holder:
        lock(holder)
        for is_shared in (False, True):
            with path.open("rb+") as other, pytest.raises(OSError) as refused:
                lock(other, is_shared=is_shared)
            assert refused.value.errno, "who asks has to tell a held file from a file system that has no locks"
        assert path.read_bytes() == b"text"
    with path.open("rb+") as other:
        lock(other)


def test_those_who_only_look_do_not_exclude_each_other(tmp_path: Path) -> None:
    path = tmp_path / "held"
    path.touch()
    with path.open("rb+") as one, path.open("rb+") as other:
        lock(one, is_shared=True)
        lock(other, is_shared=True)
