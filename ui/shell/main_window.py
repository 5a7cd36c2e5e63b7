"""Shuts the window down within a time limit, whatever a driver or a disk does; saves what an unattended run saw.

What may block runs in daemon threads, for which the end of the process does not wait.
"""

import json
import logging
import os
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QEvent, QSize, Qt
from PySide6.QtGui import QCloseEvent, QFocusEvent, QKeyEvent, QKeySequence, QShortcut, QShowEvent
from PySide6.QtWidgets import QAbstractButton, QApplication, QLineEdit, QMainWindow, QWidget

from app.diagnosis.causes import NextStep
from app.engine.conversation import STATUS_KEYS
from app.engine.target import Target
from app.engine.worker import CLOSING_LIMIT_S
from app.text.i18n import tr
from protocol.translatable import marked
from ui.acts.confirm import Confirm
from ui.connect.connect_panel import ConnectPanel
from ui.core.background_task import BackgroundTask
from ui.core.preferences import LastPort, Preferences
from ui.files.file_dialogs import FileOpener, FilePage
from ui.preferences.dialog import PreferencesDialog
from ui.services.context import PageEntry, Services
from ui.services.page import Page
from ui.services.storage import Storage
from ui.session.left_active import LeftActiveWatch
from ui.session.ports import Ports
from ui.session.shown_module import ShownModule
from ui.shell.actions import Actions, MenuEntry
from ui.shell.application_filter import LOCK_ALL_KEY, LOCK_KEYS, ApplicationFilter
from ui.shell.attention import Attention
from ui.shell.page_area import PageArea, PageMaker, Sidebar, fit_screen
from ui.shell.status_bar import RecordingSign, StatusBar
from ui.shell.top_bar import TopBar
from ui.simulator.panel import SimulatorDock
from ui.style.icons import Icon, app_icon
from ui.widgets.controls import in_row, named
from ui.widgets.notice_bar import NoticeBar

# A port may take `CLOSING_LIMIT_S`; the rest is for its thread to end, and for the store, which closes after it:
# procedures still write their outcomes.
CLOSE_LIMIT_S: Final = CLOSING_LIMIT_S + 0.15
STORE_SHARE_S: Final = 0.06
PICTURE: Final = "live.png"
VALUES: Final = "values.json"
_log = logging.getLogger(__name__)


def close_down(ports: Ports, storage: Storage, preferences: Preferences) -> None:
    """Ends everything that is not a widget within `CLOSE_LIMIT_S`; the rest is left to the system."""
    ends_at = time.monotonic() + CLOSE_LIMIT_S
    saving = _begin("preferences", preferences.save)
    ports.watcher.stop(0.0)
    if not ports.stop(CLOSE_LIMIT_S - STORE_SHARE_S):
        _log.warning("The port did not close in time; it is left to the system")
    for thread in (_begin("store", storage.close), saving):
        thread.join(max(0.0, ends_at - time.monotonic()))
        if thread.is_alive():
            _log.warning("Still running at closing: %s", thread.name)


def _begin(name: str, act: Callable[[], object]) -> threading.Thread:
    """Does it in a daemon thread; logs its errors, as nobody is left to tell."""

    def work() -> None:
        try:
            act()
        except Exception:  # noqa: BLE001
            _log.exception("At closing: %s failed", name)

    thread = threading.Thread(target=work, name=f"dps-s {name}", daemon=True)
    thread.start()
    return thread


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


def has_seen_status(ports: Ports) -> bool:
    """Whether the module's status is known and not stale."""
    view, now = ports.module.view, ports.clock()
    return all(view.fresh(key, now) is not None for key in STATUS_KEYS)


def values_seen(ports: Ports) -> dict[str, object]:
    port, view, now = ports.current, ports.module.view, ports.clock()
    known = {key: known for key in sorted(view.values) if (known := view.known(key, now)) is not None}
    return {
        "port": port.connection.port,
        "baud_rate": port.connection.baud_rate,
        "answers": view.is_going,
        "link": {"frames": ports.module.statistics.totals.frames},
        "values": {
            key: {
                "value": reading.value,
                "how": reading.how.value,
                "age_s": round(now - reading.at, 3),
                "is_stale": reading.is_stale,
            }
            for key, reading in known.items()
        },
    }


def write_evidence(folder: Path, window: QWidget, ports: Ports) -> None:
    """Writes both files into `folder`, which is created if needed. Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(values_seen(ports), indent=2, ensure_ascii=False)
    (folder / VALUES).write_text(text + "\n", encoding="utf-8")
    picture = folder / PICTURE
    if not window.grab().save(str(picture)):
        raise OSError(f"{picture} could not be written")


SMALLEST = QSize(900, 520)
FIRST_SIZE = QSize(1180, 720)


class MainWindow(QMainWindow):
    """See the module docstring. The pages are made after the first paint."""

    def __init__(
        self,
        services: Services,
        left_active: LeftActiveWatch,
        *,
        entries: tuple[PageEntry, ...],
    ) -> None:
        super().__init__()
        self.setObjectName("main_window")
        self.setWindowIcon(app_icon())
        self._services, self._remembered = services, services.preferences
        self._ports = services.ports
        self._entries = {entry.key: entry for entry in entries}
        self._maker = PageMaker(services, entries, self)
        self._maker.made.connect(self._place)
        self._maker.done.connect(self._connect_waiting)
        self.pages_made = self._maker.done
        self._pages = self._maker.pages
        self._waiting_target: Target | None = None
        self._is_leaving = self._is_over = False
        self.setWindowTitle(tr("DPS-S Configurator"))
        self.top_bar = TopBar(self._ports, services.in_use)
        self.notice_bar = NoticeBar(is_foot=True)
        self.navigation = Sidebar(entries)
        self.area = PageArea()
        self.stack = self.area.stack
        self.panel = ConnectPanel(self._ports)
        self.status_bar = StatusBar(self._ports, services.in_use, self.notice_bar)
        self.recording_sign = RecordingSign(lambda: self._ports.current.recording.state)
        self.status_bar.add(self.recording_sign)
        self._lay_out()
        self.simulator = SimulatorDock(self._ports, self)
        self.simulator.hide()
        self.menus = Actions(self)
        self.top_bar.menu.setMenu(self.menus.main)
        self._preferences: PreferencesDialog | None = None
        self.attention = Attention(self, self._ports, left_active)
        self.files = FileOpener(self, self._file_pages, self.go_to, preferences=self._remembered)
        services.appearance.style(self)
        self._wire()
        self._fill_menus()
        self.menus.refresh()
        self._restore()
        self.attention.refresh()

    # Construction

    def _lay_out(self) -> None:
        centre = self.centre = named(QWidget(), "centre")
        in_row(self.navigation, (self.area, 1), (self.panel, 1), of=centre, spacing=0, margins=0)
        self.setMenuWidget(self.top_bar)  # like the foot as wide as the window, docks included
        self.setCentralWidget(centre)
        self.setStatusBar(self.status_bar)

    def _wire(self) -> None:
        ports = self._ports
        ports.changed.connect(self.recording_sign.refresh)
        ports.changed.connect(self.menus.refresh)
        ports.shown.connect(self._on_shown)
        ports.leaving.connect(self._disarm)
        self.top_bar.panel_wanted.connect(self.toggle_panel)
        self.panel.connect_wanted.connect(self.connect_to)
        self.panel.disconnect_wanted.connect(self.disconnect_port)
        self.panel.shown.connect(lambda: self.area.setVisible(self.panel.isHidden()))
        self.panel.logs.clicked.connect(lambda: self.go_to("logs"))
        self.navigation.page_wanted.connect(self._show_page)
        self._filter = ApplicationFilter(ports.lock, self)
        self._services.exchange.limits_used.connect(self.top_bar.refresh)
        for changed in (self.panel.shown, self.stack.currentChanged, self._maker.done):
            changed.connect(self.attention.refresh)
        ports.notified.connect(self.show_message)
        self.simulator.visibilityChanged.connect(self._tick_simulator)
        QShortcut(QKeySequence("F10"), self, self.top_bar.open_menu)
        self._on_shown(ports.module)

    def _fill_menus(self) -> None:
        menus, ports, lock = self.menus, self._ports, self._services.lock

        def is_wanted() -> bool:
            return ports.current.is_requested

        menus.add("file", MenuEntry("open", marked("Open…"), self.files.ask, "Ctrl+Alt+O"))
        recent = menus.add_menu("recent", marked("Recent files"))
        recent.aboutToShow.connect(partial(self.files.fill, recent))
        menus.add(
            "file",
            self._of_page("save", marked("Save…"), "saving"),
            self._of_page("export", marked("Export…"), "exporting"),
            None,
            MenuEntry("connect", marked("Connect…"), self.toggle_panel, "Ctrl+K"),
            MenuEntry("disconnect", marked("Disconnect"), self.disconnect_port, "Ctrl+D", is_wanted),
            None,
            MenuEntry("archive", marked("Archive of all stations…"), partial(self.go_to, "archive")),
            MenuEntry("preferences", marked("Preferences…"), self.show_preferences, "Ctrl+,"),
            MenuEntry("quit", marked("Quit"), self.close, "Ctrl+Q"),
        )
        find_rate, is_several = partial(self.take_step, NextStep.FIND_RATE), lambda: len(ports.all) > 1
        menus.add(
            "module",
            # `ApplicationFilter` handles their keys in every window.
            MenuEntry("lock", marked("LOCK"), lock.press, "; ".join(LOCK_KEYS), is_wanted, picture=Icon.LOCK),
            MenuEntry("lock_all", marked("LOCK ALL"), lock.press_all, LOCK_ALL_KEY, is_several, picture=Icon.LOCK),
            MenuEntry("find_rate", marked("Find the baud rate"), find_rate, when=lambda: ports.current.is_open),
            MenuEntry("simulator", marked("Simulated module"), self.simulator.setVisible, "F4", is_checkable=True),
        )
        for number, entry in enumerate(self._entries.values(), start=1):
            enter = partial(self._enter_page, entry.key)
            menus.add("view", MenuEntry(f"page_{entry.key}", entry.title, enter, f"Ctrl+{number % 10}"))
        full = MenuEntry("full_screen", marked("Full screen"), self._show_full_screen, "F11", is_checkable=True)
        menus.add("view", None, full)

    def _of_page(self, name: str, text: str, kind: str) -> MenuEntry:
        """An entry for the button of the page shown that is its `kind`, while that can be pressed."""

        def find() -> QAbstractButton | None:
            button = getattr(self.stack.currentWidget(), kind, None)
            is_ready = isinstance(button, QAbstractButton) and button.isVisible() and button.isEnabled()
            return button if is_ready else None

        def act() -> None:
            button = find()
            if button is not None:
                button.click()

        return MenuEntry(name, text, act, when=lambda: find() is not None)

    def _restore(self) -> None:
        preferences = self._remembered
        self.resize(FIRST_SIZE)
        if preferences.geometry is not None:
            self.restoreGeometry(preferences.geometry)
        if preferences.layout is not None:
            self.restoreState(preferences.layout)
        fit_screen(self, SMALLEST)
        self.panel.prefer(preferences.last_port)
        self.navigation.setCurrentRow(0)
        self.navigation.setFocus()

    def make_pages(self) -> None:
        """Makes the pages one by one from the event loop, so that the window stays responsive."""
        self._maker.begin()

    @property
    def has_pages(self) -> bool:
        return self._maker.is_done

    def _connect_waiting(self) -> None:
        target, self._waiting_target = self._waiting_target, None
        if target is not None:
            self.connect_to(target)

    def _place(self, key: str) -> None:
        page = self._pages[key]
        self.area.add(page)
        self.notice_bar.order_tabs()
        page.connect_wanted.connect(self.connect_to)
        page.page_wanted.connect(self.go_to)
        page.ports_wanted.connect(self.panel.show)
        page.leave_wanted.connect(lambda port, act: self.attention.leave_port(act, port=port))
        if key == self.navigation.chosen:
            self.stack.setCurrentWidget(page)

    def _file_pages(self) -> list[FilePage]:
        """The shown one first: several open recordings."""
        shown = self.navigation.chosen
        pages = [(key, self._pages[key]) for key in self._entries if key in self._pages]
        pages.sort(key=lambda page: page[0] != shown)
        return [FilePage(key, page.suffixes, page.open_files) for key, page in pages if page.suffixes]

    # Actions

    def toggle_panel(self) -> None:
        self.panel.setVisible(not self.panel.isVisible())

    def connect_to(self, target: Target) -> None:
        if not self.has_pages:  # Live and the traffic need every batch
            self._waiting_target = target
            return
        self.attention.leave_port(partial(self._ports.connect_to, target))

    def disconnect_port(self) -> None:
        self.attention.leave_port(self._ports.current.disconnect_port)

    def go_to(self, key: str) -> None:
        """Shows a page; "archive" is a view of Fleet."""
        self.panel.hide()
        self.navigation.choose("fleet" if key == "archive" else key)
        if key == "archive" and "fleet" in self._pages:
            self._pages["fleet"].go_to(key)

    def _enter_page(self, key: str) -> None:
        self.go_to(key)
        self.navigation.setFocus()
        self.navigation.focusNextChild()

    def show_message(self, text: str) -> None:
        self.status_bar.show_message(text)

    def close_now(self) -> None:
        """Closes without asking, as at a signal of the system."""
        self._is_leaving = True
        self.close()

    # Events

    def _on_shown(self, module: ShownModule) -> None:
        """Another conversation has begun, or another port was chosen."""
        self._disarm()
        module.ended.connect(self._disarm)
        if module.is_going:
            self._remember_port()

    def _disarm(self) -> None:
        """Nothing that was armed or asked of a module counts any more."""
        self._services.armed.act = None
        for question in self.findChildren(Confirm):
            question.withdraw()

    @property
    def shown_page(self) -> str:
        """Its key; "" while the list of ports is shown."""
        return "" if self.panel.isVisible() else self.navigation.chosen

    @property
    def is_choosing(self) -> bool:
        """No notice needs to lead to the list of ports: it is shown."""
        page = self.stack.currentWidget()
        return self.panel.isVisible() or not self.has_pages or (isinstance(page, Page) and page.shows_link)

    def take_step(self, step: NextStep) -> None:
        """What a person can do about the link."""
        port = self._ports.current
        match step:
            case NextStep.CHOOSE_PORT:
                self.toggle_panel()
            case NextStep.FIND_RATE:
                port.find_rate()
            case NextStep.CONNECT_AGAIN if port.target is not None:
                self.attention.leave_port(partial(self._ports.connect_to, port.target), is_opened_again=True)
            case NextStep.WHY:
                self.go_to("diagnosis")
                if "diagnosis" in self._pages:
                    self._pages["diagnosis"].go_to("why")

    def _remember_port(self) -> None:
        port = self._ports.current
        if port.target is None:
            return
        if self._remembered.last_port is None:
            self.status_bar.show_message(tr("Next: Settings, then Pre-flight."), is_noted=False)
        self._remembered.last_port = LastPort(port.target.device, port.target.identity, port.connection.baud_rate)
        self.panel.hide()

    def _show_page(self, key: str) -> None:
        self._ports.current.stream.is_wanted = self._entries[key].wants_stream
        self.panel.hide()
        if key in self._pages:
            self.stack.setCurrentWidget(self._pages[key])
        else:
            self._maker.request(key)
        self.attention.refresh()

    def show_preferences(self) -> None:
        if self._preferences is None:
            self._preferences = PreferencesDialog(self._remembered, self._services.appearance, self)
        self._preferences.bring_up()

    def _show_full_screen(self, is_wanted: bool) -> None:
        full, state = Qt.WindowState.WindowFullScreen, self.windowState()
        self.setWindowState(state | full if is_wanted else state & ~full)

    def _tick_simulator(self) -> None:
        self.menus["simulator"].setChecked(not self.simulator.isHidden())

    # Qt

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Esc closes the list of ports, takes the page one step back, or cancels leaving."""
        page = self.stack.currentWidget()
        if event.key() != Qt.Key.Key_Escape:
            super().keyPressEvent(event)
        elif self.panel.isVisible():
            self.toggle_panel()
        elif not (isinstance(page, Page) and page.on_escape()):
            self.attention.stay()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        handle = self.windowHandle()
        if not event.spontaneous() and handle is not None:
            handle.screenChanged.connect(lambda _screen: fit_screen(self, SMALLEST))

    def closeEvent(self, event: QCloseEvent) -> None:
        if not self._is_leaving and not self.attention.may_close(self.close_now):
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
        self._maker.end()
        for work in self.findChildren(BackgroundTask):
            work.close()  # its thread must not outlive the window
        self._filter.stop()
        self.panel.hide()
        preferences = self._remembered
        preferences.geometry = self.saveGeometry()
        preferences.layout = self.saveState()
        close_down(self._ports, self._services.storage, preferences)
