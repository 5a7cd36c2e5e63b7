"""A dialog that asks for a file leaves the files alone: it renames, moves and removes nothing."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QModelIndex, Qt
from PySide6.QtWidgets import (
    QAbstractItemView,
    QApplication,
    QFileDialog,
    QInputDialog,
    QLineEdit,
    QListView,
    QMessageBox,
    QToolButton,
    QTreeView,
    QWidget,
)
from pytestqt.qtbot import QtBot

from tests.support.window.fakes_ui import window
from tests.support.window.steps import find
from ui.files import file_dialogs
from ui.main import Assembly

ASKS: dict[str, Callable[[QWidget, Path], object]] = {
    "ask_open": lambda parent, folder: file_dialogs.ask_open(parent, folder, "Open…", "All (*)", bool),
    "ask_profile": lambda parent, folder: file_dialogs.ask_profile(parent, folder, bool),
    "ask_flight_logs": lambda parent, folder: file_dialogs.ask_flight_logs(parent, folder, bool),
    "ask_folder": lambda parent, folder: file_dialogs.ask_folder(parent, folder, bool),
    "ask_path": lambda parent, folder: file_dialogs.ask_path(parent, "Save…", folder / "a.csv", "All (*)", bool),
}
"""Every function of the program that shows a file dialog."""


def files_of(folder: Path) -> list[tuple[str, str]]:
    """Everything below `folder`, with its contents."""
    paths = sorted(folder.rglob("*"))
    return [(str(path.relative_to(folder)), path.read_text("utf-8") if path.is_file() else "") for path in paths]


def index_of(view: QAbstractItemView, name: str) -> QModelIndex:
    model, root = view.model(), view.rootIndex()
    indexes = (model.index(row, 0, root) for row in range(model.rowCount(root)))
    return next((index for index in indexes if index.data() == name), QModelIndex())


@pytest.fixture
def assembly(qapp: QApplication, tmp_path: Path) -> Iterator[Assembly]:
    with window(qapp, tmp_path, entries=()) as made:
        yield made


@pytest.fixture
def folder(user_files: Path) -> Path:
    """A file, and a folder that has contents."""
    made = user_files / "flights"
    (made / "May").mkdir(parents=True)
    for name in ("May/kept.csv", "chosen.csv"):
        (made / name).write_text("kept", encoding="utf-8")
    return made


@pytest.mark.promise("g")
def test_renaming_removing_and_dragging_change_nothing(qtbot: QtBot, assembly: Assembly, folder: Path) -> None:
    before = files_of(folder)
    for name, ask in ASKS.items():
        ask(assembly.window, folder)
        dialog = assembly.window.findChildren(QFileDialog)[-1]
        assert dialog.testOption(QFileDialog.Option.ReadOnly), name  # else Delete would remove files of this computer
        views = dialog.findChildren(QAbstractItemView)
        assert {view.dragDropMode() for view in views} == {QAbstractItemView.DragDropMode.NoDragDrop}, name
        for mode, view in (
            (QFileDialog.ViewMode.List, find(dialog, QListView, "listView")),
            (QFileDialog.ViewMode.Detail, find(dialog, QTreeView, "treeView")),
        ):
            dialog.setViewMode(mode)
            qtbot.waitUntil(lambda view=view: view.isVisible() and index_of(view, "May").isValid())  # type: ignore[misc]
            view.setCurrentIndex(index_of(view, "May"))
            qtbot.keyClick(view, Qt.Key.Key_F2)
            assert view.viewport().findChild(QLineEdit) is None, name
            qtbot.keyClick(view, Qt.Key.Key_Delete)
        dialog.reject()
    assert files_of(folder) == before


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


@pytest.mark.promise("g")
def test_a_file_is_replaced_only_after_a_question(qtbot: QtBot, assembly: Assembly, folder: Path) -> None:
    chosen: list[Path] = []
    file_dialogs.ask_path(assembly.window, "Save…", folder / "chosen.csv", "All (*)", chosen.append)
    dialog = find(assembly.window, QFileDialog)
    for answer, expected in ((QMessageBox.StandardButton.No, []), (QMessageBox.StandardButton.Yes, ["chosen.csv"])):
        dialog.accept()
        box = next(one for one in dialog.findChildren(QMessageBox) if one.isVisible())
        assert "chosen.csv exists. Replace it?" in box.text()
        assert chosen == []
        qtbot.mouseClick(box.button(answer), Qt.MouseButton.LeftButton)
        assert [path.name for path in chosen] == expected
