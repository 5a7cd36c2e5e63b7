"""`dps-s` as a user meets it: a process of its own, interrupted, redirected, with parts missing."""

import csv
import json
import os
import select
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import IO

import pytest

import dps_s_configurator
from app.recordings.library import RecordingLibrary
from dps_s_configurator import frozen
from tests.module.line import Line
from tests.module.module import ACTIVATION, Module
from tests.module.options import Options
from tests.support.patience import PATIENCE_S, in_time
from tests.support.processes import PROGRAM, ROOT, Running, ran, ran_code, run_module, running

posix = pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals, and HOME is not read")
STRICT = {"LC_ALL": "C.UTF-8", "PYTHONWARNINGS": "error"}
ENTRY = ROOT / "packaging" / "entry"
START = "import sys; from dps_s_configurator import main; sys.exit(main())"
QT = ("PySide6", "shiboken6", "pyqtgraph")
OTHERS = ("cryptography", "jinja2", "mcap", "numpy", "segno", "shtab", "tomlkit", "zstandard", "psycopg")


@pytest.fixture(scope="module")
def module() -> Iterator[Running]:
    """One module for all tests that leave it as it was."""
    with run_module("--rate", "200", "--history", "2") as one:
        yield one


def started(*words: str) -> AbstractContextManager[Running]:
    return running(*PROGRAM, *words, **STRICT)


def lines_until(out: IO[str], t_s: float) -> list[str]:
    """The lines of `monitor --json` up to the first of that time."""
    lines = []
    for line in out:
        lines.append(line)
        if json.loads(line)["t_s"] >= t_s:
            break
    return lines


def is_quiet(port: str, for_s: float = 0.25) -> bool:
    """Whether nothing is streamed, once a busy machine has let the module hear that it is to stop."""
    number, deadline = os.open(port, os.O_RDWR | os.O_NOCTTY), time.monotonic() + PATIENCE_S
    try:
        while time.monotonic() < deadline:
            if not select.select([number], [], [], for_s)[0]:
                return True
            os.read(number, 65536)
        return False
    finally:
        os.close(number)


def unexpected(errors: str) -> list[str]:
    """Where others keep the machine busy for half a second a conversation ends, which is said."""
    return [line for line in errors.splitlines() if not line.endswith("Another module may answer from now on.")]


@posix
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.promise("c")
def test_monitor_interrupted_leaves_the_module_silent(number: int, module: Running) -> None:
    with started("monitor", "--port", module.port, "--json") as monitor:
        lines = lines_until(monitor.out, 2.9)
        with in_time(2.0):
            monitor.process.send_signal(number)
            code, rest, errors = monitor.end()
    assert (code, unexpected(errors)) == (0, [])
    assert [json.loads(line)["tilt_deg"] for line in (*lines, *rest.splitlines())][-1] == 0
    assert len(lines) > 20 or errors, "it did not stream, and no conversation ended"
    assert is_quiet(module.port)


@posix
@pytest.mark.usefixtures("user_files")
def test_record_interrupted_leaves_file_and_recording_whole(module: Running, tmp_path: Path) -> None:
    path, library = tmp_path / "a.csv", RecordingLibrary()
    with started("record", "--port", module.port, str(path)) as record:
        deadline = time.monotonic() + PATIENCE_S
        while not (library.entries() and library.entries()[0].sample_count > 100) and time.monotonic() < deadline:
            select.select([], [], [], 0.1)
        record.process.send_signal(signal.SIGINT)
        code, printed, errors = record.end()
    assert (code, unexpected(errors)) == (0, [])
    assert "Saved to" in printed
    (entry,) = library.entries()
    assert (entry.trouble, entry.is_running, entry.was_cut_off) == (None, False, False)
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.DictReader(file))
    assert sum(bool(row["tilt_deg"]) for row in rows) == entry.sample_count > 100
    assert is_quiet(module.port)


@posix
@pytest.mark.promise("l")
def test_ctrl_c_locks_an_activation_that_nothing_has_told_of_yet() -> None:
    """Its acknowledgement is lost: the frame itself is the only sign of it."""
    with Line(Module(Options(lost_answers={ACTIVATION: 1}), now=time.monotonic())) as line:
        (module,) = line.modules
        with started("activate", "--yes", "--port", line.port) as activate:
            deadline = time.monotonic() + PATIENCE_S
            while not module.log.got(ACTIVATION) and time.monotonic() < deadline:
                time.sleep(0.001)
            activate.process.send_signal(signal.SIGINT)
            code, _out, errors = activate.end()
    assert code == dps_s_configurator.INTERRUPTED
    assert not module.settings[ACTIVATION]
    assert "LOCK was sent after the interruption. The module reports LOCKED." in errors


@posix
def test_monitor_into_head(module: Running) -> None:
    """Whoever reads goes away while it streams: quiet, and the stream off."""
    with started("monitor", "--port", module.port, "--json") as monitor:
        lines_until(monitor.out, 2.9)
        monitor.out.close()
        assert monitor.process.wait(PATIENCE_S) == 4
        assert unexpected(monitor.errors.read()) == []
    assert is_quiet(module.port)


def redirected(how: str, *words: str) -> "subprocess.CompletedProcess[str]":
    """With its streams as a shell has them; what is printed leaves at its end only."""
    unbuffered = STRICT | {"PYTHONUNBUFFERED": ""}
    return ran("sh", "-c", f'exec "$@" {how}', "sh", *PROGRAM, *words, **unbuffered)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="only Linux has a device that is always full")
def test_a_full_disk_is_said() -> None:
    run = redirected(">/dev/full", "ports", "--json")
    assert (run.returncode, run.stderr.count("\n")) == (4, 1)


@posix
def test_messages_do_not_go_to_the_output_where_theirs_is_closed() -> None:
    run = redirected("2>&-", "find", "--port", "/dev/no-such-port", "--json")
    assert run.returncode == 3
    assert json.loads(run.stdout)["error"]["code"] == "no_port"


# What is missing


WITHOUT = """
import sys

missing = sys.argv.pop(1).split()

class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in missing:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Blocker())
from dps_s_configurator import main
sys.exit(main())
"""


def without(packages: tuple[str, ...], *words: str) -> "tuple[int, str, str]":
    done = ran_code(WITHOUT, " ".join(packages), *words, PYTHONPATH=str(ENTRY), LC_ALL="C.UTF-8")
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize(
    ("packages", "line"),
    [(QT, "history"), (QT, "preflight")]
    + [((*QT, *OTHERS), line) for line in ("read", "set freefall_time_s=1.4", "lock", "monitor --seconds 0.1", "find")],
)
def test_without_qt_and_what_a_command_does_not_need_it_works(packages: tuple[str, ...], line: str) -> None:
    """As docs/integrating.md says, pyserial, msgspec and platformdirs are enough to read and write."""
    code, out, errors = without(packages, *line.split(), "--port", "sim://", "--json")
    assert code == (1 if line == "preflight" else 0), errors
    assert "error" not in json.loads(out.splitlines()[-1])


@pytest.mark.parametrize(
    ("packages", "words", "missing"),
    [
        (QT, [], "PySide6"),
        (("serial",), ["read", "--port", "sim://"], "serial"),
        (("platformdirs",), ["lock", "--port", "sim://"], "platformdirs"),
        (("numpy",), ["fired", "flight.csv"], "numpy"),
        (("mcap",), ["record", "--port", "sim://", "--seconds", "0.2", "-"], "mcap"),
        ((*QT, "serial", "msgspec", "numpy"), ["ports"], "msgspec"),
    ],
)
def test_what_is_missing_is_named(packages: tuple[str, ...], words: list[str], missing: str) -> None:
    code, _, errors = without(packages, *words)
    assert code == 1, errors
    assert errors.endswith(f"The Python package {missing} is missing. Install the program again.\n")
    assert "Traceback" not in errors


def test_the_report_without_qt_says_so_and_the_check_counts(tmp_path: Path) -> None:
    code, out, errors = without(QT, "preflight", "--port", "sim://", "--report", str(tmp_path / "check.pdf"))
    assert code == 1
    assert out.startswith("NO-GO")
    assert "PySide6" in errors
    assert "Traceback" not in errors


# The start of an installed or packaged program


def installed(entry: Path, *words: str, folder: Path = ROOT, **variables: str) -> "subprocess.CompletedProcess[str]":
    """Run it as an installed command is: nothing but the entry can be imported by its place."""
    path = os.pathsep.join(filter(None, (variables.pop("PYTHONPATH", ""), str(entry))))
    environ = {**os.environ, "LC_ALL": "C.UTF-8", "PYTHONPATH": path, **variables}
    command = [sys.executable, "-P", "-c", START, *words]
    return subprocess.run(
        command, cwd=folder, env=environ, capture_output=True, text=True, encoding="utf-8", check=False
    )


@pytest.mark.parametrize("name", ["app", "protocol", "ui"])
def test_a_package_of_that_name_on_pythonpath_is_not_taken_for_ours(name: str, tmp_path: Path) -> None:
    (tmp_path / name).mkdir()
    (tmp_path / name / "__init__.py").write_text("raise SystemExit('foreign')\n", encoding="utf-8")
    done = installed(ENTRY, "decode", "41", PYTHONPATH=str(tmp_path))
    assert (done.returncode, done.stderr) == (4, "")  # no frame


@pytest.mark.parametrize("harm", ["another __init__.py", "no ui"])
@pytest.mark.promise("a")
def test_a_package_that_another_program_has_overwritten_or_removed_is_one_sentence(harm: str, tmp_path: Path) -> None:
    for package in (*dps_s_configurator.OURS, "packaging/entry/dps_s_configurator"):
        target = tmp_path / Path(package).name
        shutil.copytree(ROOT / package, target, ignore=shutil.ignore_patterns("__pycache__"))
    if harm == "no ui":
        shutil.rmtree(tmp_path / "ui")
    else:
        (tmp_path / "app" / "__init__.py").write_text("", encoding="utf-8")
    name = "ui" if harm == "no ui" else "app"
    done = installed(tmp_path, "--version")
    assert (done.returncode, done.stdout) == (dps_s_configurator.INCOMPLETE, "")
    assert done.stderr.startswith(f"“{name}” in {tmp_path / name} is not DPS-S Configurator's")
    assert done.stderr.count("\n") == 1


@posix
@pytest.mark.parametrize("words", ["lock", "archive report", "recordings list", "preflight"])
def test_without_a_home_lock_goes_on_and_what_cannot_be_kept_is_said(words: str, tmp_path: Path) -> None:
    port = ["--port", "sim://"] if words in ("lock", "preflight") else []
    done = installed(ENTRY, *words.split(), *port, folder=tmp_path, HOME="nowhere")
    assert "Unexpected error" not in done.stderr
    assert ("LOCKED" in done.stdout) is (words == "lock")
    assert list(tmp_path.iterdir()) == []


@posix
@pytest.mark.parametrize("module", ["argparse", "app.text.i18n", "app.cli.decode", "the end"])
def test_ctrl_c_while_it_is_loaded_or_ends_is_quiet(module: str, tmp_path: Path) -> None:
    """The signal arrives while this module is imported; most often a traceback of the imports was printed."""
    (tmp_path / "sitecustomize.py").write_text(
        "import atexit, os, signal, sys\n"
        "class Interrupting:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        f"        if name == {module!r}:\n"
        "            os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.meta_path.insert(0, Interrupting())\n"
        f"if {module!r} == 'the end':\n"
        "    atexit.register(os.kill, os.getpid(), signal.SIGINT)\n",
        encoding="utf-8",
    )
    command = [sys.executable, "-c", START, "decode", "41"]
    done = ran(*command, PYTHONPATH=os.pathsep.join((str(tmp_path), str(ENTRY))), LC_ALL="C.UTF-8")
    assert done.stderr == ""
    code = -signal.SIGINT if module == "the end" else dps_s_configurator.INTERRUPTED
    assert done.returncode == code  # a shell calls both 130


@pytest.mark.parametrize("original", [None, "/opt/lib"])
def test_other_programs_get_their_own_libraries(monkeypatch: pytest.MonkeyPatch, original: str | None) -> None:
    monkeypatch.setenv("LD_LIBRARY_PATH", "/bundle/_internal")
    monkeypatch.delenv("LD_LIBRARY_PATH_ORIG", raising=False)
    if original is not None:
        monkeypatch.setenv("LD_LIBRARY_PATH_ORIG", original)
    frozen.restore_library_path()
    assert os.environ.get("LD_LIBRARY_PATH") == original


@pytest.mark.parametrize(("code", "shown"), [(0, []), (3, ["No module answers."])])
def test_without_a_console_an_error_is_shown_in_a_box(
    monkeypatch: pytest.MonkeyPatch, code: int, shown: list[str]
) -> None:
    def run() -> int:
        print("No module answers.")
        return code

    boxes: list[str] = []
    for stream in ("stdout", "stderr"):
        monkeypatch.setattr(sys, stream, None)
    monkeypatch.setattr(dps_s_configurator, "_run", run)
    monkeypatch.setattr(dps_s_configurator, "_show_error", boxes.append)
    assert dps_s_configurator.open_window() == code
    assert boxes == shown
