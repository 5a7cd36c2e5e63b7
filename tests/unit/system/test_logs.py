"""The log never stops the program: rotated, read-only, full, shared by two copies; what nobody caught ends in it."""

import logging
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from app.system import logs
from app.system.logs import MAX_LINES, Log, start_log
from app.system.uncaught import UncaughtError, catch_uncaught_errors, report_uncaught_error
from tests.support.processes import ran_code

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


def test_lines_go_into_the_platforms_file_and_into_memory(
    begin: Callable[[Path | None], Log], user_files: Path
) -> None:
    log = begin(None)
    assert log.path is not None
    assert log.path.is_relative_to(user_files)
    for number in range(MAX_LINES + 50):
        SAID.info("the port %s is open", number)
    assert log.trouble is None
    for text in (log.text(), log.in_memory()):
        assert f"app.test: the port {MAX_LINES + 49} is open" in text
    assert len(log.in_memory().splitlines()) == MAX_LINES


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


def test_a_folder_that_cannot_be_made_is_said_and_the_program_goes_on(
    begin: Callable[[Path | None], Log], tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    log = begin(tmp_path / "file" / "logs")
    SAID.info("still here")
    assert log.path is None
    assert isinstance(log.trouble, OSError)
    assert "There is no log file" in log.text()
    assert "still here" in log.text()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_is_said_once_and_the_program_goes_on(
    begin: Callable[[Path | None], Log], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "dps-s.log").symlink_to("/dev/full")
    log = begin(tmp_path)
    for number in range(5):
        SAID.info("line %d", number)
    assert isinstance(log.trouble, OSError)
    assert log.text().count("no longer written") == 1
    assert "line 4" in log.text()
    assert capsys.readouterr().err == ""


def test_a_second_copy_keeps_its_lines_in_memory_and_a_killed_one_holds_nothing(
    begin: Callable[[Path | None], Log], tmp_path: Path
) -> None:
    code = (
        "import sys, os, logging, pathlib; from app.system.logs import start_log\n"
        "log = start_log(pathlib.Path(sys.argv[1])); logging.getLogger('x').warning('second')\n"
        "print(log.path, isinstance(log.trouble, OSError), 'second' in log.text(), flush=True); os._exit(9)"
    )
    assert ran_code(code, tmp_path).stdout == f"{tmp_path / 'dps-s.log'} False True\n"
    assert begin(tmp_path).path == tmp_path / "dps-s.log"
    assert ran_code(code, tmp_path).stdout == "None True True\n"
    assert (tmp_path / "dps-s.log").read_text(encoding="utf-8").count("second") == 1


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
