"""Run by itself on an X server: hands that rename, remove and drag in every file dialog of the program.

Prints one line for each dialog and act: its name, and "nothing" or "CHANGED". It confines itself to the home that it is
given first: where a dialog is not read-only, Delete in a list that was emptied removes the folder that the process runs
in.
"""

import subprocess
import sys
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from time import monotonic

from PySide6.QtCore import QEvent, QModelIndex, QPoint, Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractItemView,
    QApplication,
    QFileDialog,
    QLineEdit,
    QListView,
    QMessageBox,
    QTreeView,
    QWidget,
)

from tests.support.confined import confine
from tests.support.patience import PATIENCE_S
from ui.files import file_dialogs

Ask = Callable[[QWidget, Path], object]
Act = Callable[[QAbstractItemView, str], None]
ASKS: dict[str, Ask] = {
    "ask_open": lambda parent, folder: file_dialogs.ask_open(parent, folder, "Open…", "All (*)", bool),
    "ask_profile": lambda parent, folder: file_dialogs.ask_profile(parent, folder, bool),
    "ask_flight_logs": lambda parent, folder: file_dialogs.ask_flight_logs(parent, folder, bool),
    "ask_folder": lambda parent, folder: file_dialogs.ask_folder(parent, folder, bool),
    "ask_path": lambda parent, folder: file_dialogs.ask_path(parent, "Save…", folder / "a.csv", "All (*)", bool),
}
"""Every function of the program that shows a file dialog; `test_no_other_dialog_asks_for_files` looks for more."""
SUFFIXES = ".toml", ".ulg", ".csv"
SETTLE_MS = 60
IN_NAME_PX = 12
"""From the left edge of a row, where its icon and its name are."""
DRAG_STEPS = 6
MODES = QFileDialog.ViewMode.List, QFileDialog.ViewMode.Detail


def files_of(folder: Path) -> list[tuple[str, str]]:
    """Everything below `folder`, with its contents."""
    paths = sorted(folder.rglob("*"))
    return [(str(path.relative_to(folder)), path.read_text("utf-8") if path.is_file() else "") for path in paths]


def fill(folder: Path) -> Path:
    """A file of each kind, and a folder that has contents."""
    (folder / "May").mkdir(parents=True)
    (folder / "May" / "kept.csv").write_text("kept", encoding="utf-8")
    for suffix in SUFFIXES:
        (folder / f"chosen{suffix}").write_text("chosen", encoding="utf-8")
    return folder


def index_of(view: QAbstractItemView, name: str) -> QModelIndex:
    model = view.model()
    for row in range(model.rowCount(view.rootIndex())):
        index = model.index(row, 0, view.rootIndex())
        if index.data() == name:
            return index
    return QModelIndex()


def view_of(dialog: QFileDialog, mode: QFileDialog.ViewMode) -> QAbstractItemView:
    is_list = mode is QFileDialog.ViewMode.List
    view = dialog.findChild(QListView, "listView") if is_list else dialog.findChild(QTreeView, "treeView")
    assert isinstance(view, QAbstractItemView)
    return view


def wait_for(condition: Callable[[], bool], what: str) -> None:
    ends_at = monotonic() + PATIENCE_S
    while not condition():
        assert monotonic() < ends_at, what
        QTest.qWait(5)


def opened(ask: Ask, parent: QWidget, folder: Path, mode: QFileDialog.ViewMode) -> QFileDialog:
    """The dialog, once it shows what is in `folder` and has the keys."""
    ask(parent, folder)
    dialog = parent.findChild(QFileDialog)
    assert isinstance(dialog, QFileDialog)
    dialog.setViewMode(mode)
    view = view_of(dialog, mode)
    wait_for(lambda: view.isVisible() and index_of(view, "May").isValid(), "the dialog does not show the folder")
    dialog.activateWindow()  # as a window manager would do
    wait_for(lambda: QApplication.activeWindow() is dialog, "the dialog does not get the keys")
    return dialog


def send(*words: object) -> None:
    """What a keyboard or a mouse would send."""
    with subprocess.Popen(["xdotool", *map(str, words)]) as hand:
        wait_for(lambda: hand.poll() is not None, "xdotool does not end")
        assert hand.returncode == 0
    QTest.qWait(SETTLE_MS)


def place_of(view: QAbstractItemView, name: str) -> tuple[int, int]:
    rectangle = view.visualRect(index_of(view, name))
    place = view.viewport().mapToGlobal(QPoint(rectangle.left() + IN_NAME_PX, rectangle.center().y()))
    return place.x(), place.y()


def rename(view: QAbstractItemView, name: str) -> None:
    send("mousemove", *place_of(view, name), "click", 1)
    send("key", "F2")
    send("type", "renamed")
    if view.viewport().findChild(QLineEdit) is not None:  # else Return would choose the file
        send("key", "Return")


def remove(view: QAbstractItemView, name: str) -> None:
    """Press Delete; whatever is asked is answered with yes, by a person in a hurry."""

    def answer() -> None:
        box = QApplication.activeModalWidget()
        if isinstance(box, QMessageBox):
            QTest.keyClick(box, Qt.Key.Key_Y, Qt.KeyboardModifier.AltModifier)

    hurry = QTimer(interval=SETTLE_MS)
    hurry.timeout.connect(answer)
    hurry.start()
    send("mousemove", *place_of(view, name), "click", 1)
    send("key", "Delete")
    hurry.stop()


def drag(view: QAbstractItemView, name: str) -> None:
    """The file onto the folder."""
    x, y = place_of(view, name)
    to_x, to_y = place_of(view, "May")
    words: list[object] = ["mousemove", x, y, "mousedown", 1]
    for step in range(1, DRAG_STEPS + 1):  # in one command, as Qt waits for the end of a drag
        words += ["mousemove", x + (to_x - x) * step // DRAG_STEPS, y + (to_y - y) * step // DRAG_STEPS]
        words += ["sleep", "0.03"]
    send(*words, "sleep", "0.1", "mouseup", 1)


ACTS: dict[str, tuple[Act, str]] = {
    "F2 on a folder": (rename, "May"),
    "F2 on a file": (rename, "chosen"),
    "Delete on a folder": (remove, "May"),
    "Delete on a file": (remove, "chosen"),
    "drag": (drag, "chosen"),
}


def tried(home: Path) -> Iterator[str]:
    parent = QWidget()
    parent.show()
    for number, ((name, ask), (act, (do, chosen))) in enumerate(product(ASKS.items(), ACTS.items())):
        mode = MODES[number % len(MODES)]
        folder = fill(home / f"{number}")
        before = files_of(folder)
        dialog = opened(ask, parent, folder, mode)
        view = view_of(dialog, mode)
        # Of the files those that this dialog shows: none where it asks for a folder.
        names = ["May"] if chosen == "May" else [f"chosen{suffix}" for suffix in SUFFIXES]
        shown = [one for one in names if index_of(view, one).isValid()]
        if shown:
            do(view, shown[0])
            yield f"{name}, {mode.name}, {act}: {'nothing' if files_of(folder) == before else 'CHANGED'}"
        dialog.reject()
        QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    parent.close()


def main() -> int:
    home = Path(sys.argv[1])
    confine(home)
    app = QApplication(sys.argv[:1])
    assert app is not None
    for line in tried(home):
        print(line, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
