"""Who has a port open, from a made-up /proc."""

import os
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from app.engine import transport
from app.engine.transport import PortHolder, holder_of

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="/proc is Linux's")
OWN = os.getpid()
FIELDS = " ".join(str(number) for number in range(3, 53))
"""The fields of /proc/…/stat behind the name; the 22nd is the start time."""


class Proc(NamedTuple):
    device: Path
    folder: Path

    def runs(self, number: int, name: str, opened: Path | None = None) -> None:
        (self.folder / str(number) / "fd").mkdir(parents=True)
        (self.folder / str(number) / "comm").write_text(f"{name}\n")
        (self.folder / str(number) / "stat").write_text(f"{number} ({name} :) 7) {FIELDS}")
        (self.folder / str(number) / "fd" / "3").symlink_to(opened or self.device)

    def has_locked(self, number: str, kind: str = "FLOCK", of: Path | None = None) -> None:
        file = (of or self.device).stat()
        place = f"{os.major(file.st_dev):02x}:{os.minor(file.st_dev):02x}:{file.st_ino}"
        with (self.folder / "locks").open("a") as locks:
            locks.write(f"1: {kind}  ADVISORY  WRITE {number} {place} 0 EOF\n")

    def holder(self) -> PortHolder | None:
        return holder_of(str(self.device), self.folder)


@pytest.fixture
def proc(tmp_path: Path) -> Proc:
    made = Proc(tmp_path / "ttyUSB0", tmp_path / "proc")
    made.device.touch()
    (tmp_path / "ttyUSB1").touch()
    made.folder.mkdir()
    made.runs(OWN, "dps-s")
    made.runs(77, "other", tmp_path / "ttyUSB1")
    return made


def test_the_only_other_program_that_has_it_open_is_named(proc: Proc) -> None:
    assert proc.holder() is None
    proc.runs(42, "minicom")
    assert proc.holder() == PortHolder("minicom", 42)


@pytest.mark.parametrize(
    ("number", "kind", "name"),
    [("43", "FLOCK", "screen"), ("43", "POSIX", None), ("77", "FLOCK", None), ("-1", "FLOCK", None)],
)
def test_of_several_the_one_that_locked_it_is_named(number: str, kind: str, name: str | None, proc: Proc) -> None:
    proc.runs(42, "minicom")
    proc.runs(43, "screen")
    assert proc.holder() is None
    (proc.folder / "locks").write_text("1: FLOCK  ADVISORY  WRITE\n")
    proc.has_locked("42", of=proc.device.with_name("ttyUSB1"))
    proc.has_locked(number, kind)
    assert proc.holder() == (PortHolder(name, 43) if name else None)
    proc.has_locked("43")
    proc.has_locked("42")
    assert proc.holder() is None, "both say so"


def test_a_process_that_ended_meanwhile_holds_nothing(proc: Proc, monkeypatch: pytest.MonkeyPatch) -> None:
    proc.runs(42, "minicom")
    starts = iter(["100", "200"])
    monkeypatch.setattr(transport, "_started", lambda _process: next(starts))
    assert proc.holder() is None
    monkeypatch.undo()
    (proc.folder / "42" / "comm").unlink()
    assert proc.holder() is None


def test_a_process_is_known_by_its_start_time(proc: Proc) -> None:
    assert transport._started(proc.folder / "77") == "22"


def test_an_unplugged_port_and_another_system_name_nobody(proc: Proc, monkeypatch: pytest.MonkeyPatch) -> None:
    proc.runs(42, "minicom")
    monkeypatch.setattr(sys, "platform", "darwin")
    assert proc.holder() is None
    monkeypatch.undo()
    proc.device.unlink()
    assert proc.holder() is None
