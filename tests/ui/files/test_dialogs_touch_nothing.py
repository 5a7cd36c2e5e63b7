"""A dialog that asks for a file leaves the files alone: it renames, moves and removes nothing."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QFileDialog, QInputDialog, QToolButton
from pytestqt.qtbot import QtBot

from tests.support.processes import ran
from tests.support.window.fakes_ui import window
from tests.support.window.steps import find
from tests.support.x_server import x_server
from tests.ui.files.hands_in_dialogs import ACTS, ASKS, files_of, fill
from ui.files import file_dialogs
from ui.main import Assembly


@pytest.fixture
def assembly(qapp: QApplication, tmp_path: Path) -> Iterator[Assembly]:
    with window(qapp, tmp_path, entries=()) as made:
        yield made


@pytest.fixture
def folder(user_files: Path) -> Path:
    return fill(user_files / "flights")


@pytest.mark.promise("g")
def test_renaming_removing_and_dragging_change_nothing(tmp_path: Path) -> None:
    command = sys.executable, "-m", "tests.ui.files.hands_in_dialogs", tmp_path / "home"
    with x_server() as display:
        run = ran(*command, DISPLAY=display, QT_QPA_PLATFORM="xcb")
    assert run.returncode == 0, run.stderr[-2000:]
    told = run.stdout.splitlines()
    assert [line for line in told if not line.endswith(": nothing")] == []
    of_folders = 2  # where a folder is asked for there is no file to be tried
    assert len(told) == (len(ASKS) - 1) * len(ACTS) + of_folders


def test_a_folder_is_made_where_a_file_is_saved(qtbot: QtBot, assembly: Assembly, folder: Path) -> None:
    chosen: list[Path] = []
    file_dialogs.ask_path(assembly.window, "Save…", folder / "a.csv", "All (*)", chosen.append)
    dialog = find(assembly.window, QFileDialog)
    make_folder(qtbot, dialog, "June")
    assert (folder / "June").is_dir()
    dialog.accept()
    assert chosen == [folder / "June" / "a.csv"]


def test_a_folder_that_cannot_be_made_is_said(qtbot: QtBot, assembly: Assembly, folder: Path) -> None:
    before = files_of(folder)
    for name in ("May", "chosen.csv", "no/such/place", "..", " "):
        file_dialogs.ask_path(assembly.window, "Save…", folder / "a.csv", "All (*)", bool)
        dialog = assembly.window.findChildren(QFileDialog)[-1]
        make_folder(qtbot, dialog, name)
        assert files_of(folder) == before, name
        again = next(one for one in dialog.findChildren(QInputDialog) if one.isVisible())
        assert "cannot be made" in again.labelText(), name
        assert again.textValue() == name
        again.reject()
        assert Path(dialog.directory().absolutePath()) == folder, name
        dialog.reject()


def make_folder(qtbot: QtBot, dialog: QFileDialog, name: str) -> None:
    qtbot.mouseClick(find(dialog, QToolButton, "new_folder"), Qt.MouseButton.LeftButton)
    asked = find(dialog, QInputDialog)
    asked.setTextValue(name)
    asked.accept()


def test_a_dialog_that_opens_makes_no_folder(assembly: Assembly, folder: Path) -> None:
    for name in ASKS.keys() - {"ask_path"}:
        ASKS[name](assembly.window, folder)
        dialog = assembly.window.findChildren(QFileDialog)[-1]
        assert dialog.findChild(QToolButton, "new_folder") is None, name
        assert not find(dialog, QToolButton, "newFolderButton").isVisible(), name
        dialog.reject()
