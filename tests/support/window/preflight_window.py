"""A window with the Triggers page, the Pre-flight page or both on a simulated module."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from unittest.mock import patch

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QLineEdit
from pytestqt.qtbot import QtBot

from app.diagnosis.link_state import Phase
from app.preflight.verdict import Standing
from app.records.filing import checks_in
from app.records.verification import StationNames
from tests.support.window.fakes_ui import page_entries, store_of
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import given, notice_text, press, settle
from ui.pages.preflight.page import PreflightPage
from ui.pages.triggers.page import TriggersPage
from ui.session.check import ModuleCheck
from ui.session.trigger_reading import TriggerReading


@dataclass
class OnBench(Rig):
    """With the pages Triggers, Pre-flight or both, which are shown as they are asked for."""

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
        super().connect(*known)
        self.assembly.window.panel.hide()
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


@contextmanager
def on_bench(qtbot: QtBot, qapp: QApplication, folder: Path, name: str, *pages: str, is_connected: bool = True,
             reads_triggers: bool = False, **options: object) -> Iterator[OnBench]:  # fmt: skip
    """Open a window with these pages."""
    made: list[OnBench] = []
    read_unasked = TriggerReading.read_unasked

    def read_where_wanted(reading: TriggerReading) -> None:
        if made and made[0].reads_triggers:
            read_unasked(reading)

    with (
        patch.object(TriggerReading, "read_unasked", read_where_wanted),
        on_fake_time(OnBench, qtbot, qapp, folder, name, page_entries(*pages), **options) as one,
    ):
        made.append(one)
        one.reads_triggers = reads_triggers
        one.assembly.window.resize(1024, 600)
        if is_connected:
            one.connect()
        yield one
        one.assembly.storage.close()


def kept(bench: OnBench, module: str = "") -> list[str]:
    """Without waiting for what is still to be written."""
    store = store_of(bench.assembly.storage)
    return store.read(lambda facts: [check.verdict for check in checks_in(facts, module or None)])


def said(bench: OnBench) -> str:
    return notice_text(bench.preflight.strip)


def press_row(bench: OnBench, id_: str) -> None:
    """The button of a check that is not met."""
    act = given(bench.preflight.list.rows[id_].act)
    bench.preflight.list.ensureWidgetVisible(act)
    settle(act)
    bench.click(act)


def name_module(bench: OnBench, name: str, page: str = "preflight") -> None:
    edit = bench.find(QLineEdit, f"{page}_module_edit")
    bench.until(edit.isEnabled)
    edit.setFocus()
    edit.clear()
    bench.qtbot.keyClicks(edit, name)
    bench.qtbot.keyClick(edit, Qt.Key.Key_Return)


def confirm_name(bench: OnBench) -> None:
    """Press "It is …" once the window asks which module it is, and again where something speaks against it."""
    bar = bench.assembly.window.notice_bar
    while not bench.assembly.ports.module.name:
        bench.until(lambda: bar.button("name_same") is not None)
        press(bench.qtbot, bar.button("name_same"))
        bench.wait(0.5)


NOBODY: Final = StationNames(None)
