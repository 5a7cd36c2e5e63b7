"""LOCK from everywhere: by its button and its keys, beside every dialog, menu, list and question of the program."""

import ast
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QDialog, QFileDialog, QMenu, QMessageBox, QWidget
from pytestqt.qtbot import QtBot

from app.simulator.bench import SimulatedBench
from tests.support.processes import ran
from tests.support.window.fakes_ui import connect, simulated, window
from tests.support.window.steps import find, given, let_lay_out
from ui.core.preferences import Preferences
from ui.files import file_dialogs
from ui.main import PAGES, Assembly, WindowOptions
from ui.services.context import PageEntry
from ui.shell.application_filter import LOCK_KEYS

UI: Final = Path(__file__).parents[3] / "ui"
_DIALOGS: Final = frozenset({
    "QDialog", "QFileDialog", "QMessageBox", "QInputDialog", "QProgressDialog", "QColorDialog", "QFontDialog",
    "QErrorMessage", "QWizard", "QPrintDialog", "QPrintPreviewDialog", "QMenu",
})  # fmt: skip
_WAITS: Final = frozenset({
    "exec", "exec_", "getOpenFileName", "getOpenFileNames", "getSaveFileName", "getExistingDirectory", "getText",
    "getItem", "getInt", "getDouble", "getMultiLineText", "question", "information", "warning", "critical", "about",
    "aboutQt", "getColor", "getFont",
})  # fmt: skip
"""Methods of dialogs, menus and event loops that return only when a person has answered."""
_CLASSES: Final = _DIALOGS | {"QEventLoop", "QDrag"}


@dataclass(frozen=True)
class Bench:
    qtbot: QtBot
    assembly: Assembly
    module: SimulatedBench

    def activate(self) -> None:
        self.module.module.activate(is_active=True)
        connector = self.assembly.ports
        self.qtbot.waitUntil(
            lambda: (
                connector.current.module.view.fresh("active", connector.clock()) is True
                and self.assembly.ports.current.lock.is_possible
            ),
        )

    def await_locked(self) -> None:
        """Until LOCK is repeated no more: one that is still under way would lock what the test activates next."""
        lock = self.assembly.ports.current.lock
        self.qtbot.waitUntil(lambda: not self.module.module.state.is_active and not lock.is_repeating)


@pytest.fixture
def bench(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Bench]:
    with on_bench(qtbot, qapp, tmp_path) as made:
        yield made


@contextmanager
def on_bench(
    qtbot: QtBot,
    qapp: QApplication,
    folder: Path,
    language: str = "en",
    entries: tuple[PageEntry, ...] = (),
) -> Iterator[Bench]:
    with (
        simulated(f"above_{folder.name}") as module,
        window(qapp, folder, entries=entries, options=WindowOptions(language=language)) as assembly,
    ):
        qtbot.waitUntil(lambda: assembly.window.has_pages)
        connect(qtbot, assembly, f"sim://above_{folder.name}")
        yield Bench(qtbot, assembly, module)
        for widget in QApplication.topLevelWidgets():
            if isinstance(widget, QDialog | QMenu):
                widget.close()


# Dialogs


def _file(ask: Callable[..., object], *asked: object) -> Callable[[Bench], QWidget]:
    def show(bench: Bench) -> QWidget:
        ask(bench.assembly.window, *asked, lambda *_: None)
        return bench.assembly.window.findChildren(QFileDialog)[-1]

    return show


def _modeless(act: str, kind: type[QDialog] = QDialog) -> Callable[[Bench], QWidget]:
    def show(bench: Bench) -> QWidget:
        bench.assembly.window.menus[act].trigger()
        return next(one for one in bench.assembly.window.findChildren(kind) if one.isVisible())

    return show


def _ask_text(bench: Bench) -> QWidget:
    file_dialogs.ask_text(bench.assembly.window, "Trust this station…", "Name:", lambda _text: None)
    return bench.assembly.window.findChildren(QDialog, "text_dialog")[-1]


def _replacing(bench: Bench) -> QWidget:
    """The question above a file dialog whether a file is to be replaced."""
    dialog = _file(file_dialogs.ask_path, "Save…", Path(__file__), "All (*)")(bench)
    assert isinstance(dialog, QFileDialog)
    dialog.accept()
    return dialog.findChildren(QMessageBox)[-1]


DIALOGS: dict[str, Callable[[Bench], QWidget]] = {
    "ui/files/file_dialogs.py: QFileDialog: open": _file(file_dialogs.ask_open, Path.home(), "Open…", "All (*)"),
    "ui/files/file_dialogs.py: QFileDialog: save": _file(file_dialogs.ask_path, "Save…", Path("a.csv"), "All (*)"),
    "ui/files/file_dialogs.py: QFileDialog: many": _file(file_dialogs.ask_flight_logs, Path.home()),
    "ui/files/file_dialogs.py: QFileDialog: folder": _file(file_dialogs.ask_folder, Path.home()),
    "ui/files/file_dialogs.py: QMessageBox: replace": _replacing,
    "ui/files/file_dialogs.py: QInputDialog": _ask_text,
    "ui/help/windows.py: QDialog: guide": _modeless("guide"),
    "ui/preferences/dialog.py: QDialog": _modeless("preferences"),
    "ui/help/windows.py: QMessageBox": _modeless("about", QMessageBox),
}
"""Everything that the program shows above its window, by file and class; `test_nothing_is_missing` compares it with the
source."""
MENUS: Final = frozenset({
    "ui/services/page.py: QMenu", "ui/shell/main_window.py: QMenu", "ui/pages/preflight/page.py: QMenu",
    "ui/pages/fleet/archive_panel.py: QMenu",
})  # fmt: skip
"""All of them are children of the window, where `test_over_every_menu` finds them."""


def _name_of(node: ast.expr) -> str:
    return node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""


def _shown_above(tree: ast.AST) -> Iterator[str]:
    """Classes of dialogs and menus that a file makes or derives from."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and _name_of(node.func) in _DIALOGS:
            yield _name_of(node.func)
        elif isinstance(node, ast.ClassDef):
            yield from (name for base in node.bases if (name := _name_of(base)) in _DIALOGS)


def _waiting(tree: ast.AST) -> Iterator[str]:
    """Calls that wait for a person in an event loop of their own."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            is_loop = node.func.attr in ("exec", "exec_") and _name_of(node.func.value) != "app"
            if is_loop or (node.func.attr in _WAITS and _name_of(node.func.value) in _CLASSES):
                yield f"{_name_of(node.func.value)}.{node.func.attr}"


@pytest.mark.promise("l")
def test_nothing_is_missing() -> None:
    found, waiting = set(), []
    for path in sorted(UI.rglob("*.py")):
        name, tree = path.relative_to(UI.parent).as_posix(), ast.parse(path.read_text(encoding="utf-8"))
        found |= {f"{name}: {kind}" for kind in _shown_above(tree)}
        waiting += [f"{name}: {call}" for call in _waiting(tree)]
    assert waiting == []
    assert found == {": ".join(row.split(": ")[:2]) for row in (*DIALOGS, *MENUS)}


@pytest.mark.promise("l")
def test_over_every_dialog(bench: Bench) -> None:
    """Its keys work in each, and none covers it or blocks its button."""
    main = bench.assembly.window
    main.resize(1024, 600)
    for row, show in DIALOGS.items():
        dialog = show(bench)
        bench.qtbot.waitUntil(dialog.isVisible)
        let_lay_out(dialog)
        assert QApplication.activeModalWidget() is None, row
        button = main.top_bar.lock
        assert not dialog.frameGeometry().intersects(QRect(button.mapToGlobal(QPoint()), button.size())), row
        for key in LOCK_KEYS:
            bench.activate()
            bench.qtbot.keySequence(QApplication.focusWidget() or dialog, key)
            bench.await_locked()
        bench.activate()
        bench.qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
        bench.await_locked()
        assert dialog.isVisible(), row
        for widget in main.findChildren(QDialog):
            widget.close()


@pytest.mark.promise("l")
@pytest.mark.parametrize("spoken", ["zh_CN"], indirect=True)
def test_no_dialog_covers_it_where_texts_are_largest(
    spoken: str, qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    Preferences(tmp_path / "window.ini").zoom_percent = 200
    with on_bench(qtbot, qapp, tmp_path, spoken) as bench:
        main = bench.assembly.window
        main.resize(1024, 600)
        bar = QRect(main.top_bar.mapToGlobal(QPoint()), main.top_bar.size())
        for row, show in DIALOGS.items():
            dialog = show(bench)
            qtbot.waitUntil(dialog.isVisible)
            let_lay_out(dialog)
            assert not dialog.frameGeometry().intersects(bar), row
            dialog.close()


def test_a_dialog_that_is_asked_for_again_takes_the_place_of_the_first(bench: Bench) -> None:
    window, chosen = bench.assembly.window, list[object]()
    for _ in range(2):
        file_dialogs.ask_path(window, "Save…", Path("a.csv"), "All (*)", chosen.append)
    visible = [one for one in window.findChildren(QFileDialog) if one.isVisible()]
    assert len(visible) == 1
    assert chosen == []


# Menus, lists, questions


def _press_over_popup(bench: Bench, popup: QWidget) -> None:
    """A real press, as the platform hands it over, on the window's LOCK."""
    button, main = bench.assembly.window.top_bar.lock, bench.assembly.window
    assert not popup.frameGeometry().intersects(QRect(button.mapToGlobal(QPoint()), button.size()))
    handle = main.windowHandle()
    QTest.mouseClick(handle, Qt.MouseButton.LeftButton, pos=button.mapTo(main, button.rect().center()))


@pytest.mark.promise("l")
def test_over_every_menu(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with on_bench(qtbot, qapp, tmp_path, entries=PAGES) as bench:
        _lock_over_menus(bench)


def _lock_over_menus(bench: Bench) -> None:
    main = bench.assembly.window
    menus = [menu for menu in main.findChildren(QMenu) if menu.actions()]
    assert {"main_menu", "menu_file", "settings_more_menu"} <= {menu.objectName() for menu in menus}
    for number, menu in enumerate(menus):
        bench.activate()
        menu.popup(main.mapToGlobal(QPoint(200, 200)))
        bench.qtbot.waitUntil(menu.isVisible)
        if number % 2:
            bench.qtbot.keySequence(menu, LOCK_KEYS[number // 2 % 2])
        else:
            _press_over_popup(bench, menu)
        bench.await_locked()
        menu.close()


@pytest.mark.promise("l")
def test_over_a_list_of_choices(bench: Bench) -> None:
    main = bench.assembly.window
    main.menus["preferences"].trigger()
    box = find(main, QComboBox, "preferences_theme")
    for act in (_press_over_popup, lambda _bench, popup: bench.qtbot.keySequence(popup, "F12")):
        bench.activate()
        box.showPopup()
        popup = given(QApplication.activePopupWidget())
        act(bench, popup)
        bench.await_locked()
        box.hidePopup()


@pytest.mark.promise("l")
def test_while_it_asks_before_it_closes(bench: Bench) -> None:
    main = bench.assembly.window
    bench.activate()
    main.close()
    assert main.isVisible()
    assert main.notice_bar.button("leave_active") is not None
    bench.qtbot.keySequence(main, LOCK_KEYS[0])
    bench.await_locked()
    assert main.isVisible()


@pytest.mark.promise("l")
def test_enter_in_a_dialog_is_not_lock(bench: Bench) -> None:
    dialog = _ask_text(bench)
    bench.activate()
    bench.qtbot.keyClick(QApplication.focusWidget() or dialog, Qt.Key.Key_Return)
    bench.qtbot.wait(300)
    assert bench.module.module.state.is_active


# What changes while a dialog is open


# With the keys and clicks of an X server


@contextmanager
def x_server() -> Iterator[str]:
    """Run a server of its own; yields its DISPLAY. Without one the test is skipped."""
    if not (shutil.which("Xvfb") and shutil.which("xdotool")):
        pytest.skip("Xvfb or xdotool is not installed: sudo apt-get install xvfb xdotool")
    command = ["Xvfb", "-displayfd", "1", "-screen", "0", "1366x768x24", "-nolisten", "tcp"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        try:
            assert server.stdout is not None
            yield f":{server.stdout.readline().strip()}"
        finally:
            server.terminate()


@pytest.mark.promise("l")
def test_real_keys_and_clicks_lock_over_everything() -> None:
    with x_server() as display:
        command = sys.executable, "-m", "tests.window.lock.under_x"
        run = ran(*command, DISPLAY=display, QT_QPA_PLATFORM="xcb")
    assert run.returncode == 0, run.stderr[-2000:]
    over = [f"{name} locked locked" for name in DIALOGS]
    assert run.stdout.splitlines() == [*over, "menu ctrl+l locked", "menu click locked", "ctrl+q held open"]
