"""A window with some of its pages on a simulated module, of which every frame is recorded."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from unittest.mock import patch

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication, QComboBox, QLineEdit, QPushButton
from pytestqt.qtbot import QtBot

from app.diagnosis.link_state import Phase
from app.preflight.verdict import Standing
from app.records.filing import checks_in
from app.records.verification import StationNames
from app.settings.form import RowState, SettingDraft
from protocol.catalogue import BY_NAME
from protocol.fields import Value
from tests.support.window.fakes_ui import EMPTY_PAGE, ListedPorts, page_entries, store_of
from tests.support.window.rig import READ_LAST, Rig, on_fake_time
from tests.support.window.steps import find, given, let_lay_out, notice_text, press, settle
from ui.acts.confirm import Confirm
from ui.pages.preflight.page import PreflightPage
from ui.pages.triggers.page import TriggersPage
from ui.session.check import ModuleCheck
from ui.session.trigger_reading import TriggerReading
from ui.widgets.notice_bar import NoticeBar


@dataclass
class Desk(Rig):
    """Triggers and Pre-flight are shown as they are asked for."""

    reads_triggers = True
    """Whether the page Triggers reads by itself."""

    @property
    def preflight(self) -> PreflightPage:
        self.window.go_to("preflight")
        return super().preflight

    @property
    def last(self) -> ModuleCheck:
        """The last check."""
        return given(self.assembly.ports.module.check)

    @property
    def triggers(self) -> TriggersPage:
        self.window.go_to("triggers")
        return self.find(TriggersPage)

    def connect(self, *known: str) -> None:
        """Connect, and wait until everything was read."""
        super().connect(*READ_LAST, *known)
        self.window.panel.hide()
        self.until(lambda: self.assembly.ports.current.state.phase is Phase.ONLINE)

    def check(self, *, is_enabling: bool = True) -> Standing:
        """Run a check by a click; return the verdict."""
        page = self.preflight
        self.click(page.enable if is_enabling and page.enable.isVisible() else page.run)
        assert page.state.standing is Standing.CHECKING
        self.wait_standing(Standing.GO, Standing.READY, Standing.NO_GO, Standing.VOID)
        return page.state.standing

    def wait_standing(self, *wanted: Standing) -> None:
        page = self.preflight
        self.until(lambda: page.banner.announcement.standing in wanted)

    def restart(self) -> None:
        """Restart the module; wait for the next conversation."""
        port = self.assembly.ports.current
        before = port.module.number
        self.bench.restart()
        self.until(lambda: port.module.number > before)
        self.until(lambda: port.state.phase is Phase.ONLINE)

    def read_triggers(self) -> None:
        page = self.triggers
        self.click(page.read)
        self.until(lambda: not page.work.is_busy)

    def ask(self, confirm: Confirm) -> None:
        """Make the first click of an act; if the layout changed, the first click only scrolls."""
        for _ in range(2):
            if not confirm.is_asking:
                self.until(confirm.ask.isEnabled)
                self.click(confirm.ask)

    def choose_rare(self, name: str) -> None:
        """Choose an entry of the menu "⋯"."""
        action = find(self.assembly.window, QAction, name)
        assert action.isEnabled(), name
        action.trigger()

    def changes(self, *names: str) -> list[bytes]:
        """Return the frames that were not queries; of the commands `names`, or of all but `serial_output`."""
        return [act.encode() for act in self.acts if not names or act.command.name in names]

    def held(self, name: str) -> Value:
        """Return the value that the module holds, in the field's unit."""
        command = BY_NAME[name]
        assert command.write is not None
        return command.write.decode(getattr(self.bench.module.memory, name))


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
) -> Iterator[Desk]:
    """Open a window with these pages, connect, and show the first of them."""
    made: list[Desk] = []
    read_unasked = TriggerReading.read_unasked

    def read_where_wanted(reading: TriggerReading) -> None:
        if made and made[0].reads_triggers:
            read_unasked(reading)

    with (
        patch.object(TriggerReading, "read_unasked", read_where_wanted),
        on_fake_time(Desk, qtbot, qapp, folder, name, page_entries(*pages) or EMPTY_PAGE, listed, **options) as one,
    ):
        made.append(one)
        one.reads_triggers = reads_triggers
        if is_connected:
            one.connect()
            one.go_to(pages[0] if pages else "empty")
        try:
            yield one
        finally:
            one.assembly.ports.current.disconnect_port()
            one.assembly.storage.close()


# Pre-flight


def kept(bench: Desk, module: str = "") -> list[str]:
    """Without waiting for what is still to be written."""
    store = store_of(bench.assembly.storage)
    return store.read(lambda facts: [check.verdict for check in checks_in(facts, module or None)])


def said(bench: Desk) -> str:
    return notice_text(bench.preflight.strip)


def press_row(bench: Desk, id_: str) -> None:
    """The button of a check that is not met."""
    act = given(bench.preflight.list.rows[id_].act)
    bench.preflight.list.ensureWidgetVisible(act)
    settle(act)
    bench.click(act)


def name_module(bench: Desk, name: str) -> None:
    edit = bench.find(QLineEdit, "preflight_module_edit")
    bench.until(edit.isEnabled)
    edit.setFocus()
    edit.clear()
    bench.qtbot.keyClicks(edit, name)
    bench.qtbot.keyClick(edit, Qt.Key.Key_Return)


def confirm_name(bench: Desk) -> None:
    """Press "It is …" once the window asks which module it is, and again where something speaks against it."""
    bar = bench.assembly.window.notice_bar
    while not bench.assembly.ports.module.name:
        bench.until(lambda: bar.button("name_same") is not None)
        press(bench.qtbot, bar.button("name_same"))
        bench.wait(0.5)


NOBODY: Final = StationNames(None)


# The Settings page


def type_into(one: Desk, name: str, text: str) -> None:
    box = one.find(QLineEdit, f"{name}_wanted")
    box.setFocus()
    box.selectAll()
    one.qtbot.keyClicks(box, text)


def pick(one: Desk, name: str, value: Value) -> None:
    """Choose one of several values, by the keyboard."""
    box = one.find(QComboBox, f"{name}_wanted")
    one.until(box.isEnabled)
    for _ in range(box.count()):
        if box.currentData() != value:
            key = Qt.Key.Key_Down if box.currentIndex() < box.findData(value) else Qt.Key.Key_Up
            one.qtbot.keyClick(box, key)
    assert box.currentData() == value


def row(one: Desk, key: str) -> SettingDraft:
    return next(row for row in one.settings.work.rows if row.command.key == key)


def state(one: Desk, key: str) -> RowState:
    return row(one, key).state


def reason(one: Desk, key: str) -> str:
    one.settings.refresh()
    return one.settings.rows[key].reason.text()


def write(one: Desk) -> None:
    """Click Write once the job before it has ended."""
    one.until(lambda: not one.settings.work.job.is_running)
    one.settings.refresh()
    one.click("settings_write")


def written(one: Desk) -> None:
    """The same, until it has ended."""
    write(one)
    one.until(lambda: not one.settings.work.job.is_running)


def choose(one: Desk, key: str, bar: NoticeBar | None = None) -> None:
    """Click the button of a notice once it is shown."""
    bar = bar or one.settings.strip

    def shown() -> QPushButton | None:
        button = bar.button(key)
        return button if button is not None and button.isVisible() else None

    one.until(lambda: shown() is not None)
    let_lay_out(bar)
    button = given(shown())
    one.click(button)


def notice(one: Desk) -> str:
    one.settings.refresh()
    return notice_text(one.settings.strip)


def say_name(one: Desk, name: str) -> None:
    """A person says which module it is, once everything was read."""
    one.until(lambda: one.assembly.ports.module.is_read)
    one.assembly.ports.module.say_name(name)
