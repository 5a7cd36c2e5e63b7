"""A window with some of its pages on a simulated module, of which every frame is recorded."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Final
from unittest.mock import patch

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QComboBox, QLineEdit, QPushButton
from pytestqt.qtbot import QtBot

from app.records.filing import checks_in
from app.records.verification import StationNames
from app.settings.form import RowState, SettingDraft
from protocol.fields import Value
from tests.support.window.fakes_ui import EMPTY_PAGE, ListedPorts, page_entries, store_of
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import given, let_lay_out, notice_text, press, settle
from ui.session.trigger_reading import TriggerReading
from ui.widgets.notice_bar import NoticeBar


@contextmanager
def desk(
    qtbot: QtBot,
    qapp: QApplication,
    folder: Path,
    *pages: str,
    name: str = "desk",
    is_connected: bool = True,
    reads_triggers: bool = False,
    listed: ListedPorts | None = None,
    **options: object,
) -> Iterator[Rig]:
    """Open a window with these pages, connect, and show the first of them. `reads_triggers`: Triggers by itself."""
    with (
        nullcontext() if reads_triggers else patch.object(TriggerReading, "read_unasked"),
        on_fake_time(Rig, qtbot, qapp, folder, name, page_entries(*pages) or EMPTY_PAGE, listed, **options) as one,
    ):
        if is_connected:
            one.connect()
        if pages:
            one.window.panel.hide()
            one.go_to(pages[0])
        yield one
        one.port.disconnect_port()


# Pre-flight


def kept(bench: Rig, module: str = "") -> list[str]:
    """Without waiting for what is still to be written."""
    store = store_of(bench.assembly.storage)
    return store.read(lambda facts: [check.verdict for check in checks_in(facts, module or None)])


def said(bench: Rig) -> str:
    return notice_text(bench.preflight.strip)


def press_row(bench: Rig, id_: str) -> None:
    """The button of a check that is not met."""
    act = given(bench.preflight.list.rows[id_].act)
    bench.preflight.list.ensureWidgetVisible(act)
    settle(act)
    bench.click(act)


def unfold(bench: Rig) -> None:
    """What passed, of which a few rows come with each turn."""
    rows = bench.preflight.list
    bench.click(rows.fold)
    bench.until(lambda: len(rows.rows) == len(given(bench.preflight.state.assessment).checks))


def name_module(bench: Rig, name: str) -> None:
    edit = bench.find(QLineEdit, "preflight_module_edit")
    bench.until(edit.isEnabled)
    edit.setFocus()
    edit.clear()
    bench.qtbot.keyClicks(edit, name)
    bench.qtbot.keyClick(edit, Qt.Key.Key_Return)


def confirm_name(bench: Rig) -> None:
    """Press "It is …" once the window asks which module it is, and again where something speaks against it."""
    bar = bench.assembly.window.notice_bar
    while not bench.assembly.ports.module.name:
        bench.until(lambda: bar.button("name_same") is not None)
        press(bench.qtbot, bar.button("name_same"))
        bench.wait(0.5)


NOBODY: Final = StationNames(None)


# The Settings page


def type_into(one: Rig, name: str, text: str) -> None:
    box = one.find(QLineEdit, f"{name}_wanted")
    box.setFocus()
    box.selectAll()
    one.qtbot.keyClicks(box, text)


def pick(one: Rig, name: str, value: Value) -> None:
    """Choose one of several values, by the keyboard."""
    box = one.find(QComboBox, f"{name}_wanted")
    one.until(box.isEnabled)
    for _ in range(box.count()):
        if box.currentData() != value:
            key = Qt.Key.Key_Down if box.currentIndex() < box.findData(value) else Qt.Key.Key_Up
            one.qtbot.keyClick(box, key)
    assert box.currentData() == value


def row(one: Rig, key: str) -> SettingDraft:
    return next(row for row in one.settings.work.rows if row.command.key == key)


def state(one: Rig, key: str) -> RowState:
    return row(one, key).state


def reason(one: Rig, key: str) -> str:
    one.settings.refresh()
    return one.settings.rows[key].reason.text()


def write(one: Rig) -> None:
    """Click Write once the job before it has ended."""
    one.until(lambda: not one.settings.work.job.is_running)
    one.settings.refresh()
    one.click("settings_write")


def written(one: Rig) -> None:
    """The same, until it has ended."""
    write(one)
    one.until(lambda: not one.settings.work.job.is_running)


def choose(one: Rig, key: str, bar: NoticeBar | None = None) -> None:
    """Click the button of a notice once it is shown."""
    bar = bar or one.settings.strip

    def shown() -> QPushButton | None:
        button = bar.button(key)
        return button if button is not None and button.isVisible() else None

    one.until(lambda: shown() is not None)
    let_lay_out(bar)
    button = given(shown())
    one.click(button)


def notice(one: Rig) -> str:
    one.settings.refresh()
    return notice_text(one.settings.strip)


def say_name(one: Rig, name: str) -> None:
    """A person says which module it is, once everything was read."""
    one.until(lambda: one.assembly.ports.module.is_read)
    one.assembly.ports.module.say_name(name)
