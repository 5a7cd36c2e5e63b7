"""The log never stops the program: rotated, read-only, full, shared by two copies; what nobody caught ends in it."""

import logging
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from app.system import logs
from app.system.files import lock
from app.system.logs import MAX_LINES, Log, start_log, text_of
from app.system.uncaught import UncaughtError, catch_uncaught_errors, report_uncaught_error
from tests.support.processes import ran_code

SAID = logging.getLogger("app.test")


@pytest.fixture
def begin() -> Iterator[Callable[[Path], Log]]:
    """Starts logs that are stopped after the test."""
    made: list[Log] = []
    level = logging.getLogger().level

    def start(folder: Path) -> Log:
        made.append(start_log(folder))
        return made[-1]

    yield start
    for log in made:
        log.stop()
        log.stop()
    logging.getLogger().setLevel(level)


def test_lines_go_into_the_file_and_into_memory(begin: Callable[[Path], Log], tmp_path: Path) -> None:
    log = begin(tmp_path / "new" / "folder")
    SAID.info("the port %s is open", "/dev/ttyUSB0")
    assert log.path == tmp_path / "new" / "folder" / "dps-s.log"
    assert log.trouble is None
    for text in (text_of(log), log.recent.text()):
        assert "INFO" in text
        assert "app.test: the port /dev/ttyUSB0 is open" in text


def test_the_platform_has_a_folder_for_it(user_files: Path) -> None:
    log = start_log()
    try:
        assert log.path is not None
        assert log.path.is_relative_to(user_files)
    finally:
        log.stop()


def test_the_file_is_rotated(begin: Callable[[Path], Log], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(logs, "FILE_BYTES", 2000)
    log = begin(tmp_path)
    for number in range(300):
        SAID.info("line %d", number)
    files = sorted(path.name for path in tmp_path.glob("dps-s.log*"))
    assert files == ["dps-s.log", *(f"dps-s.log.{number}" for number in range(1, logs.MAX_FILES + 1))]
    assert all(path.stat().st_size <= 2000 for path in tmp_path.glob("dps-s.log*"))
    assert "line 299" in text_of(log)


def test_the_lines_in_memory_are_bounded(begin: Callable[[Path], Log], tmp_path: Path) -> None:
    log = begin(tmp_path)
    for number in range(MAX_LINES + 50):
        SAID.info("line %d", number)
    assert len(log.recent.text().splitlines()) == MAX_LINES


def test_a_folder_that_cannot_be_made_is_said_and_the_program_goes_on(
    begin: Callable[[Path], Log], tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    log = begin(tmp_path / "file" / "logs")
    SAID.info("still here")
    assert log.path is None
    assert isinstance(log.trouble, OSError)
    assert "There is no log file" in text_of(log)
    assert "still here" in text_of(log)


@pytest.mark.skipif(
    sys.platform == "win32" or not Path("/dev/full").exists(), reason="needs a device that is always full"
)
def test_a_full_disk_is_said_once_and_the_program_goes_on(
    begin: Callable[[Path], Log], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "dps-s.log").symlink_to("/dev/full")
    log = begin(tmp_path)
    for number in range(5):
        SAID.info("line %d", number)
    assert isinstance(log.trouble, OSError)
    text = text_of(log)
    assert text.count("no longer written") == 1
    assert "line 4" in text
    assert capsys.readouterr().err == ""


def test_a_second_copy_keeps_its_lines_in_memory_and_says_so(begin: Callable[[Path], Log], tmp_path: Path) -> None:
    begin(tmp_path)
    code = (
        "import sys, logging, pathlib; from app.system.logs import start_log, text_of\n"
        "log = start_log(pathlib.Path(sys.argv[1])); logging.getLogger('x').warning('second')\n"
        "print(log.path, isinstance(log.trouble, OSError), 'second' in text_of(log))"
    )
    assert ran_code(code, tmp_path).stdout == "None True True\n"
    assert "second" not in (tmp_path / "dps-s.log").read_text(encoding="utf-8")


def test_a_copy_that_was_killed_holds_nothing(begin: Callable[[Path], Log], tmp_path: Path) -> None:
    code = "import sys, os, pathlib\nfrom app.system.logs import start_log\n"
    code += "start_log(pathlib.Path(sys.argv[1])); os._exit(9)"
    assert ran_code(code, tmp_path).returncode == 9
    log = begin(tmp_path)
    assert log.path == tmp_path / "dps-s.log"


def test_only_the_end_of_a_long_log_is_handed_out(begin: Callable[[Path], Log], tmp_path: Path) -> None:
    log = begin(tmp_path)
    for number in range(200):
        SAID.info("line %d", number)
    text = text_of(log, longest_bytes=500)
    assert len(text) <= 500
    assert text.endswith("line 199\n")
    assert text.startswith("20")  # a whole line, from its date


def test_what_nobody_caught_is_logged_and_told(begin: Callable[[Path], Log], tmp_path: Path) -> None:
    log = begin(tmp_path)
    told: list[UncaughtError] = []
    before = sys.excepthook, threading.excepthook
    undo = catch_uncaught_errors(told.append)
    try:

        def fail() -> None:
            raise KeyError("bug")

        thread = threading.Thread(target=fail, name="worker of the test")
        thread.start()
        thread.join()
        try:
            fail()
        except KeyError as error:
            sys.excepthook(type(error), error, error.__traceback__)
    finally:
        undo()
    report_uncaught_error(KeyError("told to the log alone"))
    assert (sys.excepthook, threading.excepthook) == before
    assert [mishap.summary for mishap in told] == ["KeyError: 'bug'"] * 2
    assert told[0].thread == "worker of the test"
    assert "Traceback" in told[0].details
    assert text_of(log).count("Traceback") == 2
    assert "told to the log alone" in text_of(log)


def test_telling_that_fails_makes_no_second_error(begin: Callable[[Path], Log], tmp_path: Path) -> None:
    log = begin(tmp_path)

    def fail(_mishap: UncaughtError) -> None:
        raise RuntimeError("no window")

    undo = catch_uncaught_errors(fail)
    try:
        sys.excepthook(ValueError, ValueError("x"), None)
    finally:
        undo()
    assert "could not be told" in text_of(log)


def test_ctrl_c_stays_what_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[UncaughtError] = []
    passed_on: list[type[BaseException]] = []
    monkeypatch.setattr(sys, "excepthook", lambda kind, _error, _trace: passed_on.append(kind))
    undo = catch_uncaught_errors(told.append)
    try:
        sys.excepthook(KeyboardInterrupt, KeyboardInterrupt(), None)
    finally:
        undo()
    assert told == []
    assert passed_on == [KeyboardInterrupt]


# Locks of files: between two handles of one program, as between two programs


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
