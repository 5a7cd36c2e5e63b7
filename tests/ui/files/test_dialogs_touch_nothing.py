"""A dialog that asks for a file leaves the files alone: it renames, moves and removes nothing."""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtWidgets import QApplication, QFileDialog, QInputDialog, QPushButton, QToolButton
from pytestqt.qtbot import QtBot

from tests.support.processes import ran
from tests.support.window.fakes_ui import window
from tests.support.window.steps import find, let_lay_out
from tests.support.x_server import x_server
from tests.ui.files.hands_in_dialogs import ACTS, ASKS, files_of, fill
from ui.files import file_dialogs
from ui.main import Assembly

UI = Path(file_dialogs.__file__).parents[1]


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


@pytest.mark.promise("g")
def test_no_other_dialog_asks_for_files() -> None:
    """One function makes them all, so that none is forgotten."""
    makers: list[str] = []
    asks: set[str] = set()
    for path in UI.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id.endswith("FileDialog"):
                makers.append(path.name)
            if path.name == "file_dialogs.py" and isinstance(node, ast.FunctionDef) and node.name.startswith("ask_"):
                asks.add(node.name)
    assert makers == ["file_dialogs.py"]
    assert asks - {"ask_text"} == set(ASKS)


def test_a_folder_is_made_where_a_file_is_saved(qtbot: QtBot, assembly: Assembly, folder: Path) -> None:
    chosen: list[Path] = []
    file_dialogs.ask_path(assembly.window, "Save…", folder / "a.csv", "All (*)", chosen.append)
    dialog = find(assembly.window, QFileDialog)
    make_folder(qtbot, dialog, "June")
    assert (folder / "June").is_dir()
    dialog.accept()
    assert chosen == [folder / "June" / "a.csv"]


@pytest.mark.parametrize("name", ["May", "chosen.csv", "no/such/place", "..", " "])
def test_a_folder_that_cannot_be_made_is_said(qtbot: QtBot, assembly: Assembly, folder: Path, name: str) -> None:
    before = files_of(folder)
    file_dialogs.ask_path(assembly.window, "Save…", folder / "a.csv", "All (*)", bool)
    dialog = find(assembly.window, QFileDialog)
    make_folder(qtbot, dialog, name)
    assert files_of(folder) == before
    again = next(one for one in dialog.findChildren(QInputDialog) if one.isVisible())
    assert "cannot be made" in again.labelText()
    assert again.textValue() == name
    again.reject()
    assert Path(dialog.directory().absolutePath()) == folder
    dialog.reject()


def make_folder(qtbot: QtBot, dialog: QFileDialog, name: str) -> None:
    qtbot.mouseClick(find(dialog, QToolButton, "new_folder"), Qt.MouseButton.LeftButton)
    asked = find(dialog, QInputDialog)
    asked.setTextValue(name)
    asked.accept()


@pytest.mark.parametrize("name", [name for name in ASKS if name != "ask_path"])
def test_a_dialog_that_opens_makes_no_folder(assembly: Assembly, folder: Path, name: str) -> None:
    ASKS[name](assembly.window, folder)
    dialog = find(assembly.window, QFileDialog)
    assert dialog.findChild(QToolButton, "new_folder") is None
    assert not find(dialog, QToolButton, "newFolderButton").isVisible()
    dialog.reject()


@pytest.mark.parametrize("name", ASKS)
def test_a_dialog_is_no_larger_than_a_small_window(qtbot: QtBot, assembly: Assembly, folder: Path, name: str) -> None:
    """At 1024x600 its Save was below the screen."""
    assembly.window.resize(1024, 600)
    ASKS[name](assembly.window, folder)
    dialog = find(assembly.window, QFileDialog)
    let_lay_out(dialog)
    assert dialog.height() <= 500
    assert dialog.width() <= 1000
    for button in (one for one in dialog.findChildren(QPushButton) if one.isVisible()):
        assert dialog.rect().contains(QRect(button.mapTo(dialog, QPoint()), button.size())), button.text()
    dialog.reject()
