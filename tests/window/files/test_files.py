"""Files from the command line, the menu or a drop are opened by the page of their type; printing.

A dialog that asks for a file leaves the files alone: it renames, moves and removes nothing.
"""

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

from tests.support.flights.made_flights import made_flight, write_csv
from tests.support.processes import ran_code
from tests.support.window import walk
from tests.support.window.fakes_ui import page_entries, window
from tests.support.window.steps import choosing, drop, find, notice_text
from ui.files import file_dialogs
from ui.main import Assembly, WindowOptions
from ui.pages.logs.page import LogsPage
from ui.pages.settings.page import SettingsPage


@pytest.fixture
def profile(tmp_path: Path) -> Path:
    path = tmp_path / "Chosen.TOML"
    path.write_text(walk.PROFILE, encoding="utf-8")
    return path


def test_the_window_begins_with_a_file_and_the_menu_opens_one(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, profile: Path
) -> None:
    options = WindowOptions(language="en", file=profile)
    with window(qapp, tmp_path / "data", options=options, entries=page_entries("settings")) as assembly:
        main = assembly.window
        qtbot.waitUntil(lambda: main.has_pages)
        page = find(main, SettingsPage)
        qtbot.waitUntil(page.compare.isVisible)
        assert not main.panel.isVisible()
        page.close_panels()
        asked: list[tuple[Path, str, str]] = []
        main.files.choose = choosing(profile, asked)
        main.menus["open"].trigger()
        qtbot.waitUntil(lambda: page.panel is not None)
        assert "*.toml" in asked[0][-1]
        main.menus["open"].trigger()
        assert asked[1][0] == profile.parent


def test_several_files_dropped_on_any_page_open_all_and_each_that_cannot_be_read_is_named(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, profile: Path
) -> None:
    """Logs and what is of no kind in Logs, a profile in Settings; a name that the system refuses keeps no other out."""
    flight = write_csv(tmp_path / "calm.csv", made_flight(5.0, 1.0))
    (tmp_path / "a.xyz").write_bytes(bytes(100))
    (tmp_path / "page.ulg").write_text("<html></html>", encoding="utf-8")
    with window(qapp, tmp_path, entries=page_entries("settings", "logs")) as assembly:
        qtbot.waitUntil(lambda: assembly.window.has_pages)
        settings, logs = find(assembly.window, SettingsPage), find(assembly.window, LogsPage)
        assembly.window.go_to("settings")
        refused = tmp_path / ("n" * 300 + ".csv")
        assert drop(assembly.window, profile, flight, tmp_path / "a.xyz", refused, tmp_path / "page.ulg")
        qtbot.waitUntil(lambda: settings.panel is not None)
        qtbot.waitUntil(logs.isVisible)
        qtbot.waitUntil(lambda: not logs.result.is_busy)
        assert [row.name for row in logs.work.rows() if row.outcome is not None] == [str(flight)]
        said = notice_text(logs.strip)
        assert said.startswith("3 of 4 not read.")
        assert "a.xyz: Unknown kind of file." in said
        assert "page.ulg: This is a web page" in said


def test_no_class_of_qt_is_made_where_files_are_written_in_the_background() -> None:
    """Beside the event loop it ends the program now and then."""
    code = """if True:
        from threading import Thread
        from PySide6.QtCore import Qt
        from PySide6.QtGui import QGuiApplication, QImage
        from shiboken6 import Object
        from app.modules.labels import A4
        import ui.main
        from ui.files.report_printer import print_pages
        from ui.pages.live.page import png_parts

        def classes(made):
            return {made}.union(*(classes(kind) for kind in type.__subclasses__(made)))

        app, picture = QGuiApplication([]), QImage(9, 9, QImage.Format.Format_RGB32)
        picture.fill(Qt.GlobalColor.red)
        written, before = [], classes(Object)

        def write():
            written.append(print_pages(["<p>M-07</p>"], A4, b"{}")[:5])
            written.extend(part[1:4] for part in png_parts(picture))

        thread = Thread(target=write)
        thread.start()
        thread.join()
        print(*written, *classes(Object) - before)
    """
    run = ran_code(code)
    assert run.stdout.split() == ["b'%PDF-'", "b'PNG'"], run.stderr


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
        if name != "ask_path":
            assert dialog.findChild(QToolButton, "new_folder") is None, name
        assert not find(dialog, QToolButton, "newFolderButton").isVisible(), name
        dialog.reject()
    assert files_of(folder) == before


def test_a_folder_is_made_where_a_file_is_saved_or_it_is_said_that_it_cannot_be(
    qtbot: QtBot, assembly: Assembly, folder: Path
) -> None:
    before, chosen = files_of(folder), list[Path]()
    file_dialogs.ask_path(assembly.window, "Save…", folder / "a.csv", "All (*)", chosen.append)
    dialog = find(assembly.window, QFileDialog)
    for name in ("May", "chosen.csv", "no/such/place", "..", " "):
        make_folder(qtbot, dialog, name)
        assert files_of(folder) == before, name
        again = next(one for one in dialog.findChildren(QInputDialog) if one.isVisible())
        assert "cannot be made" in again.labelText(), name
        assert again.textValue() == name
        again.reject()
        assert Path(dialog.directory().absolutePath()) == folder, name
    make_folder(qtbot, dialog, "June")
    assert (folder / "June").is_dir()
    dialog.accept()
    assert chosen == [folder / "June" / "a.csv"]
    file_dialogs.ask_path(assembly.window, "Save…", Path("b.csv"), "All (*)", chosen.append)
    assembly.window.findChildren(QFileDialog)[-1].accept()
    assert chosen[1] == folder / "June" / "b.csv", "a name alone is saved where a file was saved last"


def make_folder(qtbot: QtBot, dialog: QFileDialog, name: str) -> None:
    qtbot.mouseClick(find(dialog, QToolButton, "new_folder"), Qt.MouseButton.LeftButton)
    asked = next(one for one in dialog.findChildren(QInputDialog) if one.isVisible())
    asked.setTextValue(name)
    asked.accept()


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
