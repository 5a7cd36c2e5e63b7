"""The window: top bar, sidebar, pages, foot and menus, and how it begins and ends.

It ends within a time limit, whatever a driver or a disk does: what may block runs in daemon threads, for which the end
of the process does not wait.
"""

import logging
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QEvent, QMargins, QSize, Qt, Signal
from PySide6.QtGui import QAction, QCloseEvent, QFocusEvent, QFontMetrics, QKeyEvent, QKeySequence, QShortcut
from PySide6.QtWidgets import QApplication, QLineEdit, QMainWindow, QMenu, QWidget

from app.diagnosis.causes import NextStep
from app.engine.target import Target
from app.engine.worker import CLOSING_LIMIT_S
from app.text.i18n import tr
from ui.acts.confirm import Confirm
from ui.connect.connect_panel import ConnectPanel
from ui.core.background_task import BackgroundTask
from ui.core.preferences import LastPort
from ui.core.turns import Turns
from ui.services.context import PageEntry, Services
from ui.session.left_active import LeftActiveWatch
from ui.session.shown_module import ShownModule
from ui.shell.application_filter import LOCK_ALL_KEY, LOCK_KEYS, ApplicationFilter
from ui.shell.attention import Attention
from ui.shell.bars import PageArea, Sidebar, TopBar
from ui.shell.leaving import Leaving
from ui.style.icons import Icon, icon
from ui.style.theme import Space, font
from ui.widgets.controls import in_row, named
from ui.widgets.notice_bar import NoticeBar

if TYPE_CHECKING:  # the first paint does not wait for these
    from ui.preferences.dialog import PreferencesDialog
    from ui.services.page import Page
    from ui.simulator.panel import SimulatorDock

SMALLEST: Final = QSize(900, 520)
# A window's title bar and edges: the system reports them only once it is shown.
FRAME: Final = QMargins(2, 34, 2, 2)
# A port may take `CLOSING_LIMIT_S`; the rest is for its thread to end, and 60 ms for the store, which closes after it:
# procedures still write their outcomes.
CLOSE_LIMIT_S: Final = CLOSING_LIMIT_S + 0.15
_log = logging.getLogger(__name__)


class MainWindow(QMainWindow):
    """The pages are made one by one after the first paint, from the event loop, so that the window stays responsive."""

    pages_made = Signal()  # All were made, except those that failed

    def __init__(self, services: Services, left_active: LeftActiveWatch, *, entries: tuple[PageEntry, ...]) -> None:
        super().__init__()
        self.setObjectName("main_window")
        self.setWindowTitle(tr("DPS-S Configurator"))
        self._services, self._remembered = services, services.preferences
        self._ports = ports = services.ports
        self._entries = {entry.key: entry for entry in entries}
        self._pages: dict[str, Page] = {}
        self.has_pages = False
        # The page that was made last and is not among the others yet.
        self._made: Page | None = None
        self._making = Turns(self)
        self._filter: ApplicationFilter | None = None
        self._waiting_target: Target | None = None
        self._is_leaving = self._is_over = False
        self.top_bar = TopBar(ports, services.in_use)
        self.notice_bar = NoticeBar(is_foot=True)
        self.navigation = Sidebar(entries)
        self.area = PageArea()
        self.stack = self.area.stack
        self.panel = ConnectPanel(ports)
        self._simulator: SimulatorDock | None = None
        self.menus: dict[str, QAction] = {}
        self.main_menu = named(QMenu(self), "main_menu")
        # What an action needs to be enabled, asked for whenever that may be otherwise.
        self._conditions: dict[QAction, Callable[[], bool]] = {}
        self._preferences: PreferencesDialog | None = None
        self.leaving = Leaving(self, ports)
        self.attention = Attention(self, ports, left_active, services.armed)

        centre = named(QWidget(), "centre")
        in_row(self.navigation, (self.area, 1), (self.panel, 1), of=centre, spacing=0, margins=0)
        self.setMenuWidget(self.top_bar)  # like the foot as wide as the window, docks included
        self.setCentralWidget(centre)
        foot = named(self.statusBar(), "status_line", "bar")
        foot.setSizeGripEnabled(False)
        foot.setFixedHeight(2 * QFontMetrics(font()).lineSpacing() + 3 * Space.XS)  # for two lines, and for a button
        foot.addWidget(self.notice_bar, 1)
        services.appearance.style(self)

        ports.changed.connect(self._enable_actions)
        ports.shown.connect(self._on_shown)
        ports.leaving.connect(self._disarm)
        ports.notified.connect(self.notice_bar.show_passing)
        self.top_bar.panel_wanted.connect(self.toggle_panel)
        self.panel.connect_wanted.connect(self.connect_to)
        self.panel.disconnect_wanted.connect(self.disconnect_port)
        self.panel.shown.connect(lambda: self.area.setVisible(self.panel.isHidden()))
        self.navigation.page_wanted.connect(self._show_page)
        services.exchange.limits_used.connect(self.top_bar.refresh)
        for changed in (self.panel.shown, self.stack.currentChanged, self.pages_made):
            changed.connect(self.attention.refresh)
        self._fill_menus()
        self._enable_actions()
        remembered = self._remembered
        free = self.screen().availableGeometry().marginsRemoved(FRAME).size()
        self.setMinimumSize(SMALLEST.boundedTo(free))
        self.resize(QSize(1180, 720).boundedTo(free))
        if remembered.geometry is not None:
            self.restoreGeometry(remembered.geometry)  # Qt keeps it on a screen
        self.panel.prefer(remembered.last_port)
        self.navigation.setCurrentRow(0)
        self.navigation.setFocus()
        self.attention.refresh()

    # Menus

    def _fill_menus(self) -> None:
        ports, lock = self._ports, self._services.lock
        file, module = self._add_menu("file", tr("&File")), self._add_menu("module", tr("&Module"))
        view, about = self._add_menu("view", tr("&View")), self._add_menu("help", tr("&Help"))

        def is_wanted() -> bool:
            return ports.current.is_requested

        self._add(file, "open", tr("Open…"), None, "Ctrl+Alt+O")
        file.addSeparator()
        self._add(file, "connect", tr("Connect…"), self.toggle_panel, "Ctrl+K")
        self._add(file, "disconnect", tr("Disconnect"), self.disconnect_port, "Ctrl+D", when=is_wanted)
        file.addSeparator()
        self._add(file, "archive", tr("Archive of all stations…"), partial(self.go_to, "archive"))
        self._add(file, "preferences", tr("Preferences…"), self.show_preferences, "Ctrl+,")
        self._add(file, "quit", tr("Quit"), self.close, "Ctrl+Q")
        # `ApplicationFilter` handles the keys of LOCK, in every window.
        keys = "; ".join(LOCK_KEYS)
        self._add(module, "lock", tr("LOCK"), lock.press, keys, when=is_wanted).setIcon(icon(Icon.LOCK))
        several = self._add(
            module, "lock_all", tr("LOCK ALL"), lock.press_all, LOCK_ALL_KEY, when=lambda: len(ports.all) > 1
        )
        several.setIcon(icon(Icon.LOCK))
        find_rate = partial(self.take_step, NextStep.FIND_RATE)
        self._add(module, "find_rate", tr("Find the baud rate"), find_rate, when=lambda: ports.current.is_open)
        module.addAction(self.top_bar.recording)
        simulator = self._add(module, "simulator", tr("Simulated module"), None, "F4")
        simulator.setCheckable(True)
        simulator.toggled.connect(self._show_simulator)
        for number, entry in enumerate(self._entries.values(), start=1):
            enter = partial(self._enter_page, entry.key)
            self._add(view, f"page_{entry.key}", tr(entry.title), enter, f"Ctrl+{number % 10}")
        self._add(about, "guide", tr("User guide"), self.show_guide, "F1")
        self._add(about, "about", tr("About"), self.show_about)
        button = self.top_bar.menu
        button.setMenu(self.main_menu)
        # Without blocking, as the button's own way would.
        QShortcut(
            QKeySequence("F10"), self, lambda: self.main_menu.popup(button.mapToGlobal(button.rect().bottomLeft()))
        )

    def _add_menu(self, name: str, title: str) -> QMenu:
        return named(self.main_menu.addMenu(title), f"menu_{name}")

    def _add(
        self,
        menu: QMenu,
        name: str,
        text: str,
        act: Callable[..., object] | None,
        keys: str = "",
        *,
        when: Callable[[], bool] | None = None,
    ) -> QAction:
        action = self.menus[name] = named(menu.addAction(text), f"act_{name}")
        if keys:
            action.setShortcuts(QKeySequence.listFromString(keys))
        action.setAutoRepeat(False)  # a key that is held answers no question that it has raised
        if act is not None:
            action.triggered.connect(lambda _is_checked: act())
        if when is not None:
            self._conditions[action] = when
        self.addAction(action)  # shortcuts of a hidden menu do not work
        return action

    def _enable_actions(self) -> None:
        for action, when in self._conditions.items():
            action.setEnabled(when())

    # Beginning

    def make_pages(self) -> None:
        """Make them after the first paint. No port is open before, so that there is nothing to lock."""
        from ui.files.file_dialogs import FileOpener

        self._filter = ApplicationFilter(self._ports.lock, self)
        self.files = FileOpener(self, self._pages, self.go_to, preferences=self._remembered)
        self.menus["open"].triggered.connect(self.files.ask)
        self._making.take(self._steps_of_making())

    def _steps_of_making(self) -> Iterator[Callable[[], object]]:
        for entry in self._entries.values():
            yield entry.load
            yield partial(self._make_page, entry)
            yield self._fill_page
            yield partial(self._add_page, entry)
        yield self._end_making

    def _make_page(self, entry: PageEntry) -> None:
        self._made = entry.make(self._services)
        self._made.setAccessibleName(tr(entry.title))

    def _fill_page(self) -> None:
        if self._made is not None:  # else it could not be made
            self._made.show_module(self._ports.module)

    def _add_page(self, entry: PageEntry) -> None:
        page, self._made = self._made, None
        if page is None:
            return
        self._pages[entry.key] = page
        self._ports.shown.connect(page.show_module)
        self.area.add(page)
        self.notice_bar.order_tabs()
        page.connect_wanted.connect(self.connect_to)
        page.page_wanted.connect(self.go_to)
        page.ports_wanted.connect(self.panel.show)
        if entry.key == self.navigation.chosen:
            self.stack.setCurrentWidget(page)

    def _end_making(self) -> None:
        self.has_pages = True
        self.setAcceptDrops(True)  # not before: a file would find no page that opens it
        self.pages_made.emit()
        if self._waiting_target is not None:
            self.connect_to(self._waiting_target)

    # Actions

    def toggle_panel(self) -> None:
        self.panel.setVisible(not self.panel.isVisible())

    def connect_to(self, target: Target) -> None:
        if not self.has_pages:  # Live and the traffic need every batch
            self._waiting_target = target
            return
        self._waiting_target = None
        self.leaving.leave_port(partial(self._ports.connect_to, target))

    def disconnect_port(self) -> None:
        self.leaving.leave_port(self._ports.current.disconnect_port)

    def go_to(self, key: str) -> None:
        """Shows a page; "archive" is a view of Fleet, "why" one of Diagnosis."""
        page = {"archive": "fleet", "why": "diagnosis"}.get(key, key)
        self.panel.hide()
        self.navigation.choose(page)
        if key != page and page in self._pages:
            self._pages[page].go_to(key)

    def _enter_page(self, key: str) -> None:
        self.go_to(key)
        self.navigation.setFocus()
        self.navigation.focusNextChild()

    def take_step(self, step: NextStep) -> None:
        """Take the step that a person can take about the link."""
        port = self._ports.current
        match step:
            case NextStep.CHOOSE_PORT:
                self.toggle_panel()
            case NextStep.FIND_RATE:
                port.find_rate()
            case NextStep.CONNECT_AGAIN if port.target is not None:
                self.leaving.leave_port(partial(self._ports.connect_to, port.target), is_opened_again=True)
            case NextStep.WHY:
                self.go_to("why")

    def _show_simulator(self, is_shown: bool) -> None:
        from ui.simulator.panel import SimulatorDock

        if self._simulator is None:
            self._simulator = dock = SimulatorDock(self._ports, self)
            dock.visibilityChanged.connect(lambda: self.menus["simulator"].setChecked(not dock.isHidden()))
        self._simulator.setVisible(is_shown)

    def show_preferences(self) -> None:
        from ui.files.file_dialogs import show_over_page
        from ui.preferences.dialog import PreferencesDialog

        if self._preferences is None:
            self._preferences = PreferencesDialog(self._remembered, self._services.appearance, self)
        show_over_page(self._preferences)

    def show_guide(self) -> None:
        """Show the guide at the chapter of the page in sight."""
        from ui.help.windows import show_guide  # the first paint does not wait for it

        entry = self._entries.get(self.shown_page)
        if not show_guide(self, "Connect" if entry is None else entry.chapter):
            self.notice_bar.show_passing(tr("The user guide is not installed."))

    def show_about(self) -> None:
        from ui.help.windows import show_about

        show_about(self)

    def close_now(self) -> None:
        """Closes without asking, as at a signal of the system."""
        self._is_leaving = True
        self.close()

    # What is shown

    @property
    def shown_page(self) -> str:
        """The key of the page; "" while the list of ports is shown."""
        return "" if self.panel.isVisible() else self.navigation.chosen

    @property
    def is_choosing(self) -> bool:
        """No notice needs to lead to the list of ports: it is shown, or the page does."""
        return self.panel.isVisible() or not self.has_pages or getattr(self.stack.currentWidget(), "shows_link", False)

    def _show_page(self, key: str) -> None:
        self._ports.current.stream.is_wanted = self._entries[key].wants_stream
        self.panel.hide()
        if key in self._pages:  # else it is shown once it is made
            self.stack.setCurrentWidget(self._pages[key])
        self.attention.refresh()

    def _on_shown(self, module: ShownModule) -> None:
        """Another conversation has begun, or another port was chosen."""
        self._disarm()
        self.notice_bar.show_passing("")
        module.ended.connect(self._disarm)
        port = self._ports.current
        if not module.is_going or port.target is None:
            return
        if self._remembered.last_port is None:
            self.notice_bar.show_passing(tr("Next: Settings, then Pre-flight."))
        self._remembered.last_port = LastPort(port.target.device, port.target.identity, port.connection.baud_rate)
        self.panel.hide()

    def _disarm(self) -> None:
        """Nothing that was armed or asked of a module counts any more."""
        self._services.armed.act = None
        for question in self.findChildren(Confirm):
            question.withdraw()

    # Qt

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Esc closes the list of ports, takes the page one step back, or cancels leaving."""
        page = self._pages.get(self.navigation.chosen)
        if event.key() != Qt.Key.Key_Escape:
            super().keyPressEvent(event)
        elif self.panel.isVisible():
            self.toggle_panel()
        elif page is None or not page.on_escape():
            self.leaving.stay()

    def closeEvent(self, event: QCloseEvent) -> None:
        if not self._is_leaving and not self.leaving.may_close(self.close_now):
            event.ignore()
            return
        self._end()
        event.accept()

    def _end(self) -> None:
        if self._is_over:
            return
        self._is_over = True
        focused = self.focusWidget()
        if isinstance(focused, QLineEdit) and focused.isModified():  # keeps what is typed, while the store is open
            QApplication.sendEvent(focused, QFocusEvent(QEvent.Type.FocusOut, Qt.FocusReason.ActiveWindowFocusReason))
        for turns in self.findChildren(Turns):
            turns.stop()
        for work in self.findChildren(BackgroundTask):
            work.close()  # its thread must not outlive the window
        if self._filter is not None:
            self._filter.stop()
        self.panel.hide()
        self._remembered.geometry = self.saveGeometry()
        # All that is no widget ends within `CLOSE_LIMIT_S`; the rest is left to the system.
        ends_at = time.monotonic() + CLOSE_LIMIT_S

        def begin(name: str, act: Callable[[], object]) -> threading.Thread:
            def work() -> None:
                try:
                    act()
                except Exception:  # noqa: BLE001  nobody is left to tell
                    _log.exception("At closing: %s failed", name)

            thread = threading.Thread(target=work, name=f"dps-s {name}", daemon=True)
            thread.start()
            return thread

        saving = begin("preferences", self._remembered.save)
        self._ports.watcher.stop(0.0)
        if not self._ports.stop(CLOSE_LIMIT_S - 0.06):
            _log.warning("The port did not close in time; it is left to the system")
        for thread in (begin("store", self._services.storage.close), saving):
            thread.join(max(0.0, ends_at - time.monotonic()))
            if thread.is_alive():
                _log.warning("Still running at closing: %s", thread.name)


def end_process(code: int) -> None:
    """Exits at once if one of our threads is still blocked by a driver, a disk or an import; else returns.

    Python's own finalisation frees objects that such a thread uses, which may crash. Non-daemon threads, which write
    files, are joined first. Call it last.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    ours = [thread for thread in threading.enumerate() if thread.name.startswith("dps-s ")]
    for thread in ours:
        if not thread.daemon:
            thread.join()
    if any(thread.is_alive() for thread in ours):
        for stream in (sys.stdout, sys.stderr):
            with suppress(AttributeError, OSError, ValueError):  # none, a full disk, a closed one
                stream.flush()
        os._exit(code)
