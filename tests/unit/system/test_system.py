"""The log, files, clocks and the libraries of the system: nothing of them stops the program or loses what was said."""

import logging
import os
import sys
import threading
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace

import pytest
from PySide6.QtWidgets import QApplication

from app.diagnosis.link_state import LinkStatistics
from app.diagnosis.support_bundle import bundle_files
from app.engine.conversation import ConversationView
from app.engine.worker import Connection
from app.system import libraries as qt_libraries
from app.system import logs
from app.system.clock import steady_time
from app.system.files import whole_file, write_whole
from app.system.logs import Log
from app.system.uncaught import UncaughtError, report_uncaught_error, uncaught_errors_told
from tests.support.cli_line import run_here
from tests.support.records.recordings_made import asked
from ui.pages.diagnosis.traffic import Column, TrafficModel

SAID = logging.getLogger("app.test")


@pytest.fixture
def begin() -> Iterator[Callable[[Path | None], Log]]:
    """Starts logs that are stopped after the test."""
    made: list[Log] = []
    level = logging.getLogger().level

    def start(folder: Path | None) -> Log:
        made.append(Log(folder))
        return made[-1]

    yield start
    for log in made:
        log.stop()
    logging.getLogger().setLevel(level)


def test_lines_go_into_the_platforms_file(begin: Callable[[Path | None], Log], user_files: Path) -> None:
    log = begin(None)
    assert log.path.is_relative_to(user_files)
    SAID.info("the port %s is open", 7)
    assert "app.test: the port 7 is open" in log.text()


def test_the_file_is_rotated(
    begin: Callable[[Path | None], Log], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(logs, "FILE_BYTES", 2000)
    log = begin(tmp_path)
    for number in range(300):
        SAID.info("line %d", number)
    files = sorted(path.name for path in tmp_path.glob("dps-s.log*"))
    assert files == ["dps-s.log", *(f"dps-s.log.{number}" for number in range(1, logs.MAX_FILES + 1))]
    assert all(path.stat().st_size <= 2000 for path in tmp_path.glob("dps-s.log*"))
    assert "line 299" in log.text()


@pytest.mark.parametrize("harm", ["no folder", "a full disk"])
def test_where_no_file_can_be_written_the_program_goes_on(
    harm: str, begin: Callable[[Path | None], Log], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if harm == "no folder":
        (tmp_path / "logs").write_text("", encoding="utf-8")
    elif Path("/dev/full").exists():
        (tmp_path / "logs").mkdir()
        (tmp_path / "logs" / "dps-s.log").symlink_to("/dev/full")
    else:
        pytest.skip("needs a device that is always full")
    log = begin(tmp_path / "logs")
    SAID.info("still here")
    assert "still here" not in log.text()
    assert capsys.readouterr().err == ""


# What nobody caught


def test_errors_of_all_threads_are_logged_and_told(caplog: pytest.LogCaptureFixture) -> None:
    told: list[UncaughtError] = []

    def fall() -> None:
        raise ValueError("from a thread")

    with uncaught_errors_told(told.append):
        thread = threading.Thread(target=fall, name="falling")
        thread.start()
        thread.join()
        sys.excepthook(KeyError, KeyError("from the window"), None)
        report_uncaught_error(RuntimeError("caught, so that the thread goes on"))
    report_uncaught_error(RuntimeError("only logged"))
    assert [one.summary.partition(":")[0] for one in told] == ["ValueError", "KeyError", "RuntimeError"]
    assert told[0].details.startswith("falling\n")
    assert "Traceback" in told[0].details
    assert "only logged" in caplog.text


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
def test_a_pipe_is_written_to_and_not_replaced(tmp_path: Path) -> None:
    """As a device is; a fault in this would replace a device of the system."""
    pipe, link = tmp_path / "pipe", tmp_path / "link"
    os.mkfifo(pipe)
    link.symlink_to(pipe)
    far = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        for path in (pipe, link):
            write_whole(path, b"gone")
            assert os.read(far, 100) == b"gone"
    finally:
        os.close(far)
    assert pipe.is_fifo()
    assert link.is_symlink()


HOUR_S = 3600.0


def test_what_came_an_hour_ago_came_an_hour_ago(qapp: QApplication) -> None:
    model = TrafficModel()
    event = asked(steady_time() - HOUR_S)
    model.append([event])
    model.show_new()
    capture = bundle_files(
        version="1",
        connection=Connection(),
        conversation=ConversationView(),
        statistics=LinkStatistics(),
        traffic=[event],
    )["capture.txt"]
    began = datetime.fromisoformat(capture.splitlines()[0].removeprefix("# started: "))
    assert abs((datetime.now(UTC) - began).total_seconds() - HOUR_S) < 2
    shown = model.index(0, Column.TIME.value).data()
    assert shown[:-4] in {f"{datetime.fromtimestamp(began.timestamp() + late_s):%H:%M:%S}" for late_s in (-1, 0, 1)}  # noqa: DTZ006


SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM", "XDG_SESSION_TYPE")
MISSING = "Missing system libraries:"
COMMAND = "Type: sudo apt-get install"


@pytest.fixture
def lacking(monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """A Debian without a screen; what is put into this set cannot be loaded there."""
    absent: set[str] = set()
    monkeypatch.setattr("sys.platform", "linux")
    for name in SCREENS:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("shutil.which", lambda name: f"/usr/bin/{name}")

    def load(name: str) -> None:
        if name in absent:
            raise OSError(name)

    monkeypatch.setattr(qt_libraries, "ctypes", SimpleNamespace(CDLL=load))
    return absent


@pytest.mark.parametrize("words", [[], ["gui", "--demo"], ["--port", "x"]])
def test_a_window_without_a_screen_is_one_sentence(
    lacking: set[str], capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    assert run_here(capsys, words, 3).err == "No screen: neither DISPLAY nor WAYLAND_DISPLAY is set.\n"


def test_all_that_is_missing_is_named_in_one_command(lacking: set[str], monkeypatch: pytest.MonkeyPatch) -> None:
    for screen in ("WAYLAND_DISPLAY", "DISPLAY"):
        monkeypatch.setenv(screen, ":0")
        assert qt_libraries.window_obstacle() is None
        monkeypatch.delenv(screen)
    monkeypatch.setenv("DISPLAY", ":0")
    lacking |= {"libEGL.so.1", "libxcb-cursor.so.0"}
    said = qt_libraries.window_obstacle()
    assert said == f"{MISSING} libEGL.so.1, libxcb-cursor.so.0. {COMMAND} libegl1 libxcb-cursor0"
    monkeypatch.setattr("shutil.which", lambda name: None)
    assert (qt_libraries.window_obstacle() or "").endswith("libraries: libEGL.so.1, libxcb-cursor.so.0.")
    lacking -= {"libEGL.so.1"}
    monkeypatch.delenv("DISPLAY")
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    assert qt_libraries.window_obstacle() is None


def test_qt_that_cannot_be_imported_is_that_sentence_too(
    lacking: set[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(_: object) -> int:
        raise ImportError("libEGL.so.1: cannot open shared object file: No such file or directory")

    monkeypatch.setattr("app.cli.gui.run", fail)
    lacking |= {"libEGL.so.1"}
    assert run_here(capsys, ["gui"], 1).err == f"{MISSING} libEGL.so.1. {COMMAND} libegl1\n"
    lacking.clear()
    assert "Unexpected error" in run_here(capsys, ["gui"], 1).err
