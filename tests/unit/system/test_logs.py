"""The log never stops the program: rotated, read-only, full; what nobody caught ends in it."""

import logging
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from app.system import logs
from app.system.logs import MAX_LINES, Log, start_log
from app.system.uncaught import UncaughtError, catch_uncaught_errors, report_uncaught_error

SAID = logging.getLogger("app.test")


@pytest.fixture
def begin() -> Iterator[Callable[[Path | None], Log]]:
    """Starts logs that are stopped after the test."""
    made: list[Log] = []
    level = logging.getLogger().level

    def start(folder: Path | None) -> Log:
        made.append(start_log(folder))
        return made[-1]

    yield start
    for log in made:
        log.stop()
    logging.getLogger().setLevel(level)


def test_lines_go_into_the_platforms_file_and_the_last_ones_into_memory(
    begin: Callable[[Path | None], Log], user_files: Path
) -> None:
    log = begin(None)
    assert log.path.is_relative_to(user_files)
    for number in range(MAX_LINES + 50):
        SAID.info("the port %s is open", number)
    assert log.trouble is None
    assert f"app.test: the port {MAX_LINES + 49} is open" in log.text()
    log.path.unlink()
    assert len(log.text().splitlines()) == MAX_LINES


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
def test_where_no_file_can_be_written_memory_has_the_lines(
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
    assert isinstance(log.trouble, OSError) is (harm == "no folder")
    assert "still here" in log.text()
    assert capsys.readouterr().err == ""


# What nobody caught


def test_errors_of_all_threads_are_logged_and_told(caplog: pytest.LogCaptureFixture) -> None:
    told: list[UncaughtError] = []

    def fall() -> None:
        raise ValueError("from a thread")

    undo = catch_uncaught_errors(told.append)
    try:
        thread = threading.Thread(target=fall, name="falling")
        thread.start()
        thread.join()
        sys.excepthook(KeyError, KeyError("from the window"), None)
        report_uncaught_error(RuntimeError("caught, so that the thread goes on"))
    finally:
        undo()
    report_uncaught_error(RuntimeError("only logged"))
    assert [one.summary.partition(":")[0] for one in told] == ["ValueError", "KeyError", "RuntimeError"]
    assert told[0].thread == "falling"
    assert "Traceback" in told[0].details
    assert "only logged" in caplog.text
