"""What tests/conftest.py and the settings promise to fail does fail."""

import re
import sys
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QCursor
from PySide6.QtWidgets import QWidget
from pytestqt.qtbot import QtBot

from tests.support.processes import ran
from tests.support.window.steps import is_input_down, release_input

ROOT = Path(__file__).parent.parent

BAD_TESTS = """
import gc, threading, warnings
import pytest
from PySide6.QtCore import qWarning
from tests import conftest

conftest.LEAK_GRACE_S = 0.1
is_over = threading.Event()

@pytest.fixture(scope="module", autouse=True)
def end():
    yield
    is_over.set()

def test_leaves_a_thread():
    threading.Thread(target=is_over.wait, name="forgotten").start()

def test_leaves_a_daemon():
    threading.Thread(target=is_over.wait, name="lurking", daemon=True).start()

def test_leaves_an_ending_thread():
    threading.Thread(target=int).start()

def test_warns():
    warnings.warn("careful")

def test_lets_qt_warn():
    qWarning("careful, says Qt")

def test_leaves_a_file_open():
    open(__file__)
    gc.collect()

def test_fails_in_a_thread():
    thread = threading.Thread(target=int, args=("no number",))
    thread.start()
    thread.join()

def test_passes():
    pass
"""
WITH_A_MARKER = "import pytest\n\n@pytest.mark.never_declared\ndef test_has_a_marker():\n    pass\n"
NEEDS = {"records.archive_server": "postgresql", "x_server": "xvfb xdotool"}
"""What a test needs that may not be installed, and its packages."""
WITHOUT = """
from unittest.mock import patch
from tests.support.{module} import {server} as server

def test_left_out():
    with patch("shutil.which", return_value=None), patch("pathlib.Path.glob", return_value=[]), server():
        pass
"""


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> str:
    """What pytest prints over bad tests with this checkout's settings and conftest."""
    folder = tmp_path_factory.mktemp("bad")
    files = {"bad": BAD_TESTS, "marker": WITH_A_MARKER}
    servers = {module: module.rpartition(".")[2] for module in NEEDS}
    files |= {server: WITHOUT.format(module=module, server=server) for module, server in servers.items()}
    for name, source in files.items():
        (folder / f"test_{name}.py").write_text(source, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-c", str(ROOT / "pyproject.toml"), "--rootdir", str(folder)]
    command += ["-p", "tests.conftest", "-p", "no:cacheprovider", "-o", f"pythonpath={ROOT}"]
    run = ran(*command, "--continue-on-collection-errors", str(folder))
    assert run.returncode != 0
    return run.stdout + run.stderr


@pytest.mark.parametrize(
    ("test", "reason"),
    [
        ("test_leaves_a_thread", "threads still running after the test: forgotten"),
        ("test_leaves_a_daemon", r"threads still running after the test: lurking \(daemon\)"),
        ("test_warns", "UserWarning: careful"),
        ("test_lets_qt_warn", "careful, says Qt"),
        ("test_leaves_a_file_open", "ResourceWarning"),
        ("test_fails_in_a_thread", "ValueError"),
    ],
)
def test_it_fails(printed: str, test: str, reason: str) -> None:
    assert re.search(rf"^(FAILED|ERROR) .*::{test}\b", printed, re.MULTILINE), printed
    assert re.search(reason, printed)


def test_a_correct_test_passes(printed: str) -> None:
    assert not re.search(r"^(FAILED|ERROR) .*::test_(leaves_an_ending_thread|passes)", printed, re.MULTILINE)
    assert "4 failed, 4 passed, 2 skipped, 3 errors" in printed


def test_an_unknown_marker_is_refused(printed: str) -> None:
    assert "'never_declared' not found in `markers`" in printed


def test_files_of_the_user_are_out_of_reach(user_files: Path) -> None:
    import platformdirs

    folders = [
        platformdirs.user_data_path("dps-s"),
        platformdirs.user_config_path("dps-s"),
        platformdirs.user_state_path("dps-s"),
        platformdirs.user_cache_path("dps-s"),
        Path.home(),
    ]
    assert all(folder == user_files or user_files in folder.parents for folder in folders)
    assert not user_files.exists()


def test_a_run_without_a_server_says_what_was_not_run_and_what_to_type(printed: str) -> None:
    """Nothing is left out in silence."""
    for package in NEEDS.values():
        assert re.search(rf"SKIPPED \[1\] .* not installed: sudo apt-get install {package}", printed), printed


def test_no_test_leaves_input_to_the_next(qtbot: QtBot) -> None:
    widget = QWidget()
    qtbot.addWidget(widget)
    qtbot.keyPress(widget, Qt.Key.Key_A, Qt.KeyboardModifier.ControlModifier)
    qtbot.mousePress(widget, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ControlModifier)
    at_start = QCursor.pos()
    QCursor.setPos(300, 300)
    assert is_input_down()
    release_input()
    assert not is_input_down()
    assert QCursor.pos() == at_start
