"""A window with the Settings page, the Commands page or both on a simulated module that records every frame."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication, QComboBox, QLineEdit, QPushButton
from pytestqt.qtbot import QtBot

from app.settings.form import RowState, SettingDraft
from protocol.catalogue import BY_NAME
from protocol.fields import Value
from tests.support.window.fakes_ui import page_entries
from tests.support.window.rig import READ_LAST, Rig, on_fake_time
from tests.support.window.steps import find, given, let_lay_out, notice_text
from ui.acts.confirm import Confirm
from ui.widgets.notice_bar import NoticeBar


@dataclass
class Desk(Rig):
    """With the pages Settings, Commands or both."""

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

    def connect(self, *known: str) -> None:
        super().connect(*READ_LAST, *known)


@contextmanager
def desk(
    qtbot: QtBot, qapp: QApplication, folder: Path, *pages: str, query: str = "", **options: object
) -> Iterator[Desk]:
    """Open a window with these pages, connect, and show the first of them."""
    with on_fake_time(Desk, qtbot, qapp, folder, f"desk{folder.name}", page_entries(*pages), query, **options) as made:
        made.root.activateWindow()
        qtbot.waitUntil(made.root.isActiveWindow)
        made.connect()
        made.go_to(pages[0])
        try:
            yield made
        finally:
            made.assembly.ports.current.disconnect_port()


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
