"""LOCK from everywhere: by its button and its keys, beside every dialog, menu, list and question of the program; one
gesture, repeatable, and confirmed only by the module's report.

Names, notes and texts of files are plain text wherever they are shown: no name is a big green "GO".
"""

import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import Final

import pytest
from PySide6.QtCore import QCoreApplication, QEvent, QPoint, QRect, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QComboBox,
    QDialog,
    QFileDialog,
    QLabel,
    QMenu,
    QMessageBox,
    QToolTip,
    QWidget,
)
from pytestqt.qtbot import QtBot

from app.simulator.bench import SimulatedBench
from protocol.catalogue import ACTIVATION, Request
from tests.module.module import ACTIVATION as OF_THE_MODULE
from tests.support.line.frames import at_each_frame
from tests.support.processes import ran
from tests.support.window.fakes_ui import connect, simulated, window
from tests.support.window.rig import Rig
from tests.support.window.steps import find, given, let_lay_out, notice_text, press
from ui.core.preferences import Preferences
from ui.files import file_dialogs
from ui.main import PAGES, Assembly, WindowOptions
from ui.services.context import PageEntry, Services
from ui.services.page import Page
from ui.session.lock import PortLock
from ui.session.ports import LockControl
from ui.shell.application_filter import LOCK_ALL_KEY, LOCK_KEYS
from ui.shell.main_window import MainWindow
from ui.style.theme import Meaning

UI: Final = Path(__file__).parents[3] / "ui"
_KINDS: Final = "Q(?:Dialog|FileDialog|MessageBox|InputDialog|ProgressDialog|ColorDialog|FontDialog|Wizard|Menu)"
_SHOWN: Final = re.compile(rf"(?<![\w.])({_KINDS})\(|class \w+\(({_KINDS})\b")
"""What a file makes or derives from that is shown above the window."""
_WAITS: Final = re.compile(rf"(?<!app)\.exec_?\(|{_KINDS}\.[a-z]\w+\(")
"""Calls that wait for a person in an event loop of their own: such a dialog's static functions do, too."""


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
MENUS: Final = {
    "ui/services/page.py: QMenu",
    "ui/shell/main_window.py: QMenu",
    "ui/pages/preflight/page.py: QMenu",
    "ui/pages/fleet/members.py: QMenu",
}
"""All of them are children of the window, where `test_over_every_menu` finds them."""


@pytest.mark.promise("l")
def test_nothing_is_missing() -> None:
    found, waiting = set(), []
    for path in sorted(UI.rglob("*.py")):
        name, text = path.relative_to(UI.parent).as_posix(), path.read_text(encoding="utf-8")
        found |= {f"{name}: {made or base}" for made, base in _SHOWN.findall(text)}
        waiting += [f"{name}: {call}" for call in _WAITS.findall(text)]
    assert waiting == []
    assert found == {": ".join(row.split(": ")[:2]) for row in DIALOGS} | MENUS


@pytest.mark.promise("l")
def test_over_every_dialog(bench: Bench) -> None:
    """Its keys work in each, and none blocks its button."""
    main = bench.assembly.window
    main.resize(1024, 600)
    for row, show in DIALOGS.items():
        dialog = show(bench)
        bench.qtbot.waitUntil(dialog.isVisible)
        assert QApplication.activeModalWidget() is None, row
        for key in LOCK_KEYS:
            bench.activate()
            bench.qtbot.keySequence(QApplication.focusWidget() or dialog, key)
            bench.await_locked()
        bench.activate()
        bench.qtbot.mouseClick(main.top_bar.lock, Qt.MouseButton.LeftButton)
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
def test_over_a_list_of_choices_and_while_it_asks_before_it_closes(bench: Bench) -> None:
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
    bench.activate()
    main.close()
    assert main.isVisible()
    assert main.notice_bar.button("leave_active") is not None
    bench.qtbot.keySequence(main, LOCK_KEYS[0])
    bench.await_locked()
    assert main.isVisible()


@pytest.mark.promise("l")
def test_enter_in_a_dialog_is_not_lock_and_one_that_is_asked_for_again_takes_its_place(bench: Bench) -> None:
    dialog = _ask_text(bench)
    bench.activate()
    bench.qtbot.keyClick(QApplication.focusWidget() or dialog, Qt.Key.Key_Return)
    bench.qtbot.wait(300)
    assert bench.module.module.state.is_active
    main, chosen = bench.assembly.window, list[object]()
    for _ in range(2):
        file_dialogs.ask_path(main, "Save…", Path("a.csv"), "All (*)", chosen.append)
    visible = [one for one in main.findChildren(QFileDialog) if one.isVisible()]
    assert (len(visible), chosen) == (1, [])


@pytest.mark.promise("l")
def test_real_keys_and_clicks_lock_over_everything() -> None:
    if not (shutil.which("Xvfb") and shutil.which("xdotool")):
        pytest.skip("Xvfb or xdotool is not installed: sudo apt-get install xvfb xdotool")
    command = ["Xvfb", "-displayfd", "1", "-screen", "0", "1366x768x24", "-nolisten", "tcp"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        try:
            display = f":{given(server.stdout).readline().strip()}"
            under_x = sys.executable, "-m", "tests.window.lock.under_x"
            run = ran(*under_x, DISPLAY=display, QT_QPA_PLATFORM="xcb")
        finally:
            server.terminate()
    assert run.returncode == 0, run.stderr[-2000:]
    over = [f"{name} locked locked" for name in DIALOGS]
    assert run.stdout.splitlines() == [*over, "menu ctrl+l locked", "menu click locked", "ctrl+q held open"]


ACTIVE: Final = pytest.mark.module(active=True)


@pytest.mark.parametrize("way", ["click", "key"])
@ACTIVE
def test_lock_is_one_gesture(one: Rig, way: str) -> None:
    if way == "click":
        press(one.qtbot, one.assembly.window.top_bar.lock)
    else:
        one.qtbot.keyClick(one.assembly.window, Qt.Key.Key_L, Qt.KeyboardModifier.ControlModifier)
    one.until(lambda: not one.bench.module.state.is_active)
    one.until(lambda: one.assembly.window.top_bar.activation.word == "LOCKED")
    one.until(lambda: "LOCKED" in one.assembly.window.notice_bar.passing)
    one.bench.module.state.is_active = True  # by somebody else
    one.until(lambda: one.assembly.window.top_bar.activation.word == "ACTIVE")
    one.until(lambda: one.assembly.window.notice_bar.passing == "", limit_s=1.0)


@ACTIVE
def test_a_key_that_is_held_is_one_press(one: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    pressed = list[str]()
    monkeypatch.setattr(PortLock, "press", lambda _lock, **_: pressed.append("LOCK"))
    for is_repeat in (False, True, True):
        event = QKeyEvent(QEvent.Type.KeyPress, Qt.Key.Key_F12, Qt.KeyboardModifier.NoModifier, "", is_repeat)
        QCoreApplication.sendEvent(one.assembly.window, event)
    assert pressed == ["LOCK"]


def lossy(bench: SimulatedBench, lost: int) -> list[float]:
    """The first `lost` LOCKs do not arrive; when each of them left."""
    times = list[float]()

    def lose(request: Request) -> bool:
        if request.command is ACTIVATION:
            times.append(bench.clock())
        return request.command is not ACTIVATION or len(times) > lost

    at_each_frame(bench, lose)
    return times


@ACTIVE
def test_it_is_repeated_and_shown_until_the_module_reports_it(one: Rig) -> None:
    times = lossy(one.bench, 5)
    bar = one.assembly.window.notice_bar
    press(one.qtbot, one.assembly.window.top_bar.lock)
    one.until(lambda: "LOCK sent 3×, not yet" in notice_text(bar))
    one.qtbot.keyClick(one.assembly.window, Qt.Key.Key_Escape)  # which does not end it
    assert bar.notice is not None
    assert bar.notice.meaning is Meaning.ATTENTION
    assert one.assembly.window.notice_bar.passing == "", "it would stand beside the notice: Locking…"
    one.until(lambda: not one.bench.module.state.is_active)
    one.until(lambda: bar.notice is None)
    assert len(times) == 6
    confirmed = given(one.assembly.ports.current.lock.confirmed)
    assert confirmed.sent == 6


@ACTIVE
@pytest.mark.promise("l")
def test_a_lock_that_fails_is_said_on_every_page_until_the_module_reports_that_it_is_locked(
    one: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.engine.procedure.LOCKS_FOR_S", 0.5)
    one.bench.change(mute=True)
    press(one.qtbot, one.assembly.window.top_bar.lock)
    bar = one.assembly.window.notice_bar
    one.until(lambda: bar.button("lock_again") is not None)
    notice = given(bar.notice)
    assert (notice.meaning, notice.dismiss) == (Meaning.DANGER, None)
    one.assembly.window.leaving.stay()
    one.wait(1.0)  # of reports that say nothing of it
    one.qtbot.keyClick(one.assembly.window, Qt.Key.Key_Escape)
    assert "treat the module as ACTIVE" in notice_text(bar)
    one.bench.change(mute=False)
    one.bench.module.activate(is_active=False)  # somebody locks it in another way
    one.until(lambda: one.assembly.ports.current.lock.failed is None)
    one.until(lambda: "treat the module as ACTIVE" not in notice_text(bar))


@pytest.mark.parametrize("away_s", [1.0, 62.0])
@pytest.mark.promise("l")
@ACTIVE
def test_what_is_owed_goes_first_when_the_port_comes_back_within_a_minute(one: Rig, away_s: float) -> None:
    bar, port = one.assembly.window.notice_bar, one.assembly.ports.current
    heal = at_each_frame(one.bench, lambda request: request.command is not ACTIVATION)
    press(one.qtbot, one.assembly.window.top_bar.lock)
    one.until(lambda: bool(port.lock.sent))
    one.bench.unplug()
    one.until(lambda: not port.is_open and port.lock.is_owed)
    assert port.lock.is_unproven
    assert "treat the module as ACTIVE. Sent when it answers" in notice_text(bar)
    one.wait(away_s)
    heal()
    one.bench.plug()
    if away_s < 60:
        one.until(lambda: not one.bench.module.state.is_active and not port.lock.is_unproven)
        return
    one.until(lambda: port.module.is_going)
    one.wait(2.0)
    assert one.bench.module.state.is_active
    assert port.lock.is_owed
    assert "treat the module as ACTIVE" in notice_text(bar)


@pytest.mark.promise("l")
@ACTIVE
def test_pressed_again_it_goes_on_and_what_is_activated_on_purpose_is_not_locked_again(one: Rig) -> None:
    times, lock = lossy(one.bench, 100), one.assembly.ports.current.lock
    for _ in range(2):
        press(one.qtbot, one.assembly.window.top_bar.lock)
        one.until(lambda: bool(lock.sent))
    one.wait(0.5)
    assert lock.is_repeating
    assert len(times) >= 2
    lock.give_up()
    one.until(lambda: not lock.is_repeating)
    assert not lock.is_unproven
    count = len(times)
    one.wait(0.4)
    assert len(times) == count


@pytest.mark.parametrize("is_unplugged", [False, True])
@pytest.mark.promise("l")
@ACTIVE
def test_a_lock_that_goes_on_never_reaches_another_port(one: Rig, is_unplugged: bool) -> None:
    connector = one.assembly.ports
    lock, done = connector.current.lock, list[str]()
    with simulated("other") as other:
        other.module.activate(is_active=True)
        one.bench.change(mute=True)
        lock.press(then=lambda: done.append("meant for the former module"))
        one.until(lambda: bool(lock.sent))
        if is_unplugged:
            one.bench.unplug()
            one.until(lambda: not connector.current.is_open)
        one.url = "sim://other"
        one.connect()
        one.until(lambda: connector.module.is_going)
        one.wait(1.0)
        assert other.module.state.is_active
        assert not lock.is_repeating
        press(one.qtbot, one.assembly.window.top_bar.lock)
        one.until(lambda: lock.confirmed is not None)
        assert done == []


def test_its_keys_count_while_the_pages_are_made(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """None lets a key through that was pressed meanwhile, or shows a dialog or a menu: then the filter is set aside."""
    pressed, shown = list[str](), list[QWidget]()
    monkeypatch.setattr(LockControl, "press", lambda _lock: pressed.append("LOCK"))

    def make(entry: PageEntry, services: Services) -> Page:
        main = next(one for one in QApplication.topLevelWidgets() if isinstance(one, MainWindow))
        event = QKeyEvent(QEvent.Type.KeyPress, Qt.Key.Key_F12, Qt.KeyboardModifier.NoModifier)
        QCoreApplication.postEvent(main, event)
        page = entry.make(services)
        dialogs = (one for one in QApplication.topLevelWidgets() if isinstance(one, QDialog | QMenu))
        shown.extend(one for one in dialogs if one.isVisible())
        return page

    broken = PAGES[0]._replace(key="broken", make=attrgetter("no_page"))
    entries = tuple(entry._replace(make=partial(make, entry)) for entry in (broken, *PAGES))
    with qtbot.captureExceptions() as raised, window(qapp, tmp_path, entries=entries) as assembly:
        qtbot.waitUntil(lambda: assembly.window.has_pages and len(pressed) == len(entries))
        assert [kind for kind, *_ in raised] == [AttributeError]
    assert shown == []


@pytest.mark.module(is_connected=False)
def test_a_module_that_is_not_shown_and_active_is_named_beside_lock(one: Rig) -> None:
    first, here = one.plug_in("/dev/one", {OF_THE_MODULE: 1})
    second, there = one.plug_in("/dev/two")
    button = one.window.top_bar.lock_others
    assert one.port is first
    assert button.isHidden()
    there.settings[OF_THE_MODULE] = 1
    one.until(button.isVisible)
    assert button.text() == "LOCK two"
    second.module.name_it("Survey hexacopter M-07")
    one.until(lambda: button.text().endswith("M-07"))
    there.options.lost_sets[OF_THE_MODULE] = -1
    press(one.qtbot, button)
    assert second.lock.is_repeating
    assert not first.lock.is_repeating
    one.unplug(second)
    assert button.isVisible(), "nobody has seen it locked"
    assert notice_text(one.window.notice_bar) == "NOT reported, treat as ACTIVE: Survey hexacopter M-07"
    one.qtbot.keySequence(one.window, LOCK_ALL_KEY)
    there.options.lost_sets.clear()
    second.connect_to(given(second.target))
    one.until(lambda: not here.settings[OF_THE_MODULE] and not there.settings[OF_THE_MODULE])


NAME = '<h1 style="color:green">GO</h1><img src="/usr/share/pixmaps/a.png">'


@pytest.mark.promise("g")
def test_every_label_and_tool_tip_is_plain(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """Of every page and dialog, of a module whose name looks like a verdict."""
    with on_bench(qtbot, qapp, tmp_path, entries=PAGES) as bench:
        main = bench.assembly.window
        qtbot.waitUntil(lambda: bench.assembly.ports.module.is_read)
        bench.assembly.ports.module.say_name(NAME)
        for entry in PAGES:
            main.go_to(entry.key)
            QApplication.processEvents()
            assert assert_plain(main) > 10
        told = [widget for widget in main.findChildren(QWidget) if NAME in widget.toolTip()]
        assert told != []
        for widget in (*told, main):
            tip = widget.toolTip() or NAME
            QToolTip.showText(widget.mapToGlobal(QPoint(5, 5)), tip, widget)
            above = (one for one in QApplication.topLevelWidgets() if one.windowType() == Qt.WindowType.ToolTip)
            label = next(one for one in above if isinstance(one, QLabel) and one.isVisible())
            assert (label.text(), label.textFormat()) == (tip, Qt.TextFormat.PlainText)
            assert label.width() >= label.minimumSizeHint().width()
            QToolTip.hideText()
            QTest.qWait(1)
        for show in DIALOGS.values():
            dialog = show(bench)
            qtbot.waitUntil(dialog.isVisible)
            assert_plain(dialog)
            dialog.close()


def assert_plain(root: QWidget) -> int:
    """Every label in sight below `root`; how many they are."""
    labels = [label for label in root.findChildren(QLabel) if label.isVisible()]
    rich = [label.objectName() or label.text() for label in labels if label.textFormat() != Qt.TextFormat.PlainText]
    assert rich == []
    return len(labels)
