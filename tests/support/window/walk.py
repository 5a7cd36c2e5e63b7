"""A walk through the whole window, for tests of everything that is visible.

Each stop is a state of the real window on a simulated module. The walk visits all pages of `ui.main.PAGES`.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from PySide6.QtCore import QSize
from PySide6.QtWidgets import QApplication, QMessageBox, QWidget
from pytestqt.qtbot import QtBot

from app.flights.judging import FlightGroup
from app.guided.results import GuidedKind
from app.preflight.verdict import Standing
from app.safety.journal import Act
from app.text.i18n import set_language
from tests.support.flights.made_flights import write_logs
from tests.support.window.controls import moved, places
from tests.support.window.fakes_ui import ADAPTER, SECOND_ADAPTER, ListedPorts
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import let_lay_out
from ui.main import PAGES
from ui.pages.diagnosis.page import DiagnosisPage
from ui.pages.live.page import LivePage
from ui.pages.logs.page import LogsPage
from ui.pages.triggers.page import TriggersPage
from ui.style.theme import Choice
from ui.widgets.step_button import bring_into_sight

SMALL_SCREEN = QSize(1024, 600)
PROFILE = """
format = 1
name = "Survey hexacopter"
airframe = "H6"
notes = "Bay sensor measured in spring."

[settings]
attitude_threshold_deg = 65
freefall_time_s = 1.6
attitude_trigger = true
"""


class Stop(NamedTuple):
    """A state of the window: its name in messages, and the widget to inspect."""

    name: str
    root: QWidget


class Walk(Rig):
    """The stops, in order; at each one everything is laid out and painted."""

    folder: Path

    def stops(self) -> Iterator[Stop]:
        """Yield all stops, from the start of the window to an unplugged module."""
        yield from self.before_connecting()
        self.connect()
        for entry in PAGES:
            self.window.go_to(entry.key)
            yield self._stop(entry.key)
            more: Callable[[], Iterator[Stop]] | None = getattr(self, f"_on_{entry.key}", None)
            if more is not None:
                yield from more()
        yield from self._around()

    def before_connecting(self) -> Iterator[Stop]:
        """Yield the pages before a module is connected."""
        self.qtbot.waitUntil(lambda: self.window.panel.isVisible() and self.assembly.watcher.has_listed)
        yield self._stop("connect panel")
        self.window.panel.hide()
        for entry in PAGES:
            self.window.go_to(entry.key)
            yield self._stop(f"{entry.key}, not connected")

    def connect(self) -> None:
        """And wait until the values have been read."""
        super().connect()
        self.window.go_to("live")
        live = self.find(LivePage)
        self.until(lambda: live.data.has_samples)
        live.refresh()

    # The pages

    def _on_settings(self) -> Iterator[Stop]:
        page = self.settings
        self.until(lambda: page.work.can_edit)
        page.work.fill({"attitude_threshold_deg": 30})
        page.refresh()
        yield self._stop("settings, edited")
        page.work.revert()
        profile = self.folder / "H6.toml"
        profile.write_text(PROFILE, encoding="utf-8")
        page.open_file(profile)
        yield self._stop("settings, profile")
        page.close_panels()
        profile.write_text("format = 1\nname = 3\n[settings]\nx = 1\n", encoding="utf-8")
        page.open_file(profile)
        yield self._stop("settings, no profile")
        page.work.job.dismiss()
        page.measure.click()
        yield self._stop("settings, measuring")
        page.close_panels()

    def _on_triggers(self) -> Iterator[Stop]:
        page = self.find(TriggersPage)
        page.read.click()
        self.until(lambda: not page.work.is_busy)
        page.table.selectRow(0)
        yield self._stop("triggers, chosen")

    def _on_preflight(self) -> Iterator[Stop]:
        page = self.preflight
        page.run.click()
        ended = (Standing.GO, Standing.READY, Standing.NO_GO, Standing.VOID)
        self.until(lambda: page.banner.announcement.standing in ended)
        yield self._stop("preflight, verdict")
        page.show_view("guided")
        for kind in GuidedKind:
            page.guided.work.choose(kind)
            yield self._stop(f"preflight, guided {kind.name}")
        page.show_view("past")
        yield self._stop("preflight, past checks")
        page.show_view("checks")

    def _on_commands(self) -> Iterator[Stop]:
        confirm = self.commands.acts[Act.ACTIVATE].confirm
        self.click(confirm.ask)
        yield self._stop("commands, asked")
        self.click(confirm.cancel)
        bring_into_sight(self.commands.ritual)
        self.window.activateWindow()  # as a real click does
        self.bench.module.activate(is_active=True)
        self.click("ritual_choose")
        yield self._stop("commands, ritual chosen")
        self.click("ritual_arm")
        yield self._stop("commands, ritual armed")
        self.click("ritual_cancel")
        yield self._stop("commands, ritual ended")
        self.bench.module.activate(is_active=False)

    def _on_logs(self) -> Iterator[Stop]:
        page = self.find(LogsPage)
        paths = write_logs(self.folder / "logs")
        page.open_files(paths)
        self.until(lambda: not page.result.is_busy)
        yield self._stop("logs, one not read")
        first, second, *_ = map(str, paths)
        page.work.move([first], FlightGroup.MUST)
        page.work.move([second], FlightGroup.MUST_NOT)
        self.until(lambda: not page.work.proposing.is_running)
        page.on_escape()
        page.map.setFocus()
        yield self._stop("logs, sorted")
        rows = page.work.rows()
        page.open_row(next(row for row in rows if row.name == first))
        self.until(lambda: page.view.plot is not None)
        yield self._stop("logs, one log")
        page.open_row(next(row for row in rows if row.why_not is not None))
        page.view.line.setText("time_s")
        page.view.read.click()
        yield self._stop("logs, columns")
        page.on_escape()
        page.work.remove([row.name for row in rows if row.entry is None])

    def _on_diagnosis(self) -> Iterator[Stop]:
        for key in ("traffic", "figures", "bundle", "why"):
            self.find(DiagnosisPage).go_to(key)
            yield self._stop(f"diagnosis, {key}")

    def _around(self) -> Iterator[Stop]:
        """Yield the simulator panel, the About box, notices, and the pages after unplugging."""
        self.window.go_to("live")
        self.window.menus["simulator"].setChecked(True)
        yield self._stop("simulator panel")
        self.window.menus["simulator"].setChecked(False)
        self.window.toggle_panel()
        yield self._stop("connect panel, connected")
        self.window.toggle_panel()
        self.window.menus["about"].trigger()
        box = self.find(QMessageBox, "about_box")
        yield self._stop("about", box)
        box.close()
        self.bench.module.activate(is_active=True)
        connector = self.assembly.ports
        self.until(lambda: connector.current.is_active)
        self.window.disconnect_port()
        yield self._stop("question at leaving")
        self.window.leaving.stay()
        self.bench.unplug()
        self.until(lambda: self.window.notice_bar.notice is not None)
        for entry in PAGES:
            self.window.go_to(entry.key)
            yield self._stop(f"{entry.key}, unplugged")

    def shake(self) -> list[str]:
        """Return what moves on the current page while the module tilts and is charged."""
        bench, cell = self.bench, self.window.top_bar.cell
        self.settle()
        before = places(self.window)
        bench.set_world(tilt_deg=123)
        bench.set_world(cell_v=3.61)
        bench.set_charger(is_plugged_in=True)
        self.until(lambda: ", " in cell.accessibleName())
        self.settle()
        found = moved(before, places(self.window))
        bench.set_world(tilt_deg=0)
        bench.set_world(cell_v=4.0)
        bench.set_charger(is_plugged_in=False)
        self.until(lambda: ", " not in cell.accessibleName())
        self.settle()
        return found

    def _stop(self, name: str, root: QWidget | None = None) -> Stop:
        self.settle()
        return Stop(name, self.window if root is None else root)

    def settle(self) -> None:
        """Complete the pending layouts and paints."""
        live = self.find(LivePage)
        if live.isVisible():
            live.refresh()
            live.draw()
        let_lay_out(self.window)


@contextmanager
def walking(
    qtbot: QtBot,
    qapp: QApplication,
    folder: Path,
    *,
    language: str = "en",
    theme: Choice = Choice.LIGHT,
    size: QSize = SMALL_SCREEN,
) -> Iterator[Walk]:
    """Show the whole window with two adapters listed and a simulated module."""
    ports = ListedPorts(ADAPTER, SECOND_ADAPTER)
    set_language(language)
    with on_fake_time(Walk, qtbot, qapp, folder, f"walk{folder.name}", PAGES, ports, history=3) as walk:
        walk.folder = folder
        walk.assembly.appearance.choose(theme)
        walk.window.resize(size)
        walk.settle()
        try:
            yield walk
        finally:
            walk.assembly.appearance.choose(Choice.LIGHT)
            walk.assembly.storage.close()
