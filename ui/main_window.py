"""The window: top bar, notices, navigation with pages, status line. It wires; what is done is done elsewhere."""

import logging
from functools import partial
from typing import cast

from PySide6.QtCore import QEvent, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QCloseEvent, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QMainWindow, QMessageBox, QStackedWidget, QVBoxLayout, QWidget

from app import version
from app.i18n import tr
from app.worker import Batch
from ui.attention import Attention
from ui.connect_panel import ConnectPanel
from ui.connector import Connector, Target
from ui.file_drops import FileDrops, FilePage
from ui.icons import app_icon
from ui.link_state import Step
from ui.menus import Menus
from ui.navigation import Navigation
from ui.notice_bar import NoticeBar
from ui.pages import Page, PageEntry, Services
from ui.port_watch import PortWatch
from ui.recording_bar import RecordingBar
from ui.remembered import LastPort, Remembered
from ui.simulator_dock import SimulatorDock
from ui.speech import Speech
from ui.status_line import StatusLine
from ui.theme import Choice, Space
from ui.top_bar import TopBar

_log = logging.getLogger(__name__)

SMALLEST = QSize(900, 520)
FIRST_SIZE = QSize(1180, 720)
WIDE_ENOUGH = 1280
"""For the panel of the simulated module beside a page with the navigation in words."""
REFRESH_EVERY_MS = 100
CLOSE_LIMIT_S = 0.45
PANEL_WIDTH = 440


class MainWindow(QMainWindow):
    """See the module's docstring. `pages` are made after the first paint."""

    pages_made = Signal()

    def __init__(
        self,
        services: Services,
        ports: PortWatch,
        speech: Speech,
        remembered: Remembered,
        *,
        entries: tuple[PageEntry, ...],
    ) -> None:
        super().__init__()
        self.setObjectName("main_window")
        self.setWindowIcon(app_icon())
        self._services, self._ports, self._speech, self._remembered = services, ports, speech, remembered
        self._connector: Connector = services.connector
        self._entries = {entry.key: entry for entry in entries}
        self._pages: dict[str, QWidget] = {}
        self._is_leaving = False
        texts = services.texts
        texts.bind(self.setWindowTitle, "DPS-S Configurator")
        self.top_bar = TopBar(self._connector, texts)
        self.notice_bar = NoticeBar(texts)
        self.recording_bar = RecordingBar(self._connector, texts)
        self.navigation = Navigation(entries, texts)
        self.stack = QStackedWidget()
        self.stack.setObjectName("pages")
        self.status_line = StatusLine(self._connector, texts)
        self._lay_out()
        self.panel = ConnectPanel(self._connector, ports, texts, self._centre)
        self.simulator = SimulatorDock(self._connector, texts, self)
        self.addDockWidget(Qt.DockWidgetArea.RightDockWidgetArea, self.simulator)
        self.simulator.hide()
        self.menus = Menus(self, texts, entries)
        acts = {
            Step.CHOOSE_PORT: self.toggle_panel,
            Step.FIND_RATE: self._connector.find_rate,
            Step.CONNECT_AGAIN: self._connect_again,
        }
        self.attention = Attention(
            self._connector, self.notice_bar, say=self.say, acts=acts, unsent=services.unsent, parent=self
        )
        self._drops = FileDrops(self, self._page_for, self.go_to)
        self._wire()
        self._restore()
        self._timer = QTimer(self)
        self._timer.setInterval(REFRESH_EVERY_MS)
        self._timer.timeout.connect(self.refresh)
        self._timer.start()
        self.refresh()

    # Making

    def _lay_out(self) -> None:
        centre = self._centre = QWidget()
        centre.setObjectName("centre")
        layout = QVBoxLayout(centre)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        body = QHBoxLayout()
        body.setSpacing(0)
        body.addWidget(self.navigation)
        body.addWidget(self.stack, 1)
        layout.addWidget(self.top_bar)
        layout.addWidget(self.recording_bar)
        layout.addWidget(self.notice_bar)
        layout.addLayout(body, 1)
        layout.addWidget(self.status_line)
        self.setCentralWidget(centre)
        self.setMinimumSize(SMALLEST)

    def _wire(self) -> None:
        menus, connector = self.menus, self._connector
        connector.batch.connect(self._take)
        connector.changed.connect(self.refresh)
        connector.came_online.connect(self._remember_port)
        self.top_bar.panel_wanted.connect(self.toggle_panel)
        self.top_bar.lock_wanted.connect(self.lock)
        self.panel.connect_wanted.connect(self.connect_to)
        self.panel.disconnect_wanted.connect(self.disconnect_port)
        self.navigation.page_wanted.connect(self._show_page)
        menus.connect.triggered.connect(self.toggle_panel)
        menus.disconnect.triggered.connect(self.disconnect_port)
        menus.quit.triggered.connect(self.close)
        menus.lock.triggered.connect(self.lock)
        menus.find_rate.triggered.connect(connector.find_rate)
        menus.simulator.toggled.connect(self.simulator.setVisible)
        self.simulator.topLevelChanged.connect(self._share_room)
        self.simulator.visibilityChanged.connect(self._tick_simulator)
        menus.full_screen.toggled.connect(self._show_full_screen)
        menus.about.triggered.connect(self._show_about)
        menus.when_chosen(menus.pages, self.go_to)
        menus.when_chosen(menus.themes, self._use_theme)
        menus.when_chosen(menus.languages, self._use_language)
        self._services.appearance.changed.connect(self._follow_theme)

    def _restore(self) -> None:
        remembered = self._remembered
        self.resize(FIRST_SIZE)
        if remembered.geometry is not None:
            self.restoreGeometry(remembered.geometry)
        if remembered.layout is not None:
            self.restoreState(remembered.layout)
        self.menus.choose(self.menus.themes, self._services.appearance.choice.value)
        self.menus.choose(self.menus.languages, self._speech.language)
        self._ports.remember_seen(remembered.seen_ports)
        self.panel.prefer(remembered.last_port)
        self.navigation.setCurrentRow(0)
        self.navigation.setFocus()

    def make_pages(self) -> None:
        """Make all pages that are not made yet; each loads what it needs only now."""
        for key in self._entries:
            self._page(key)
        self.pages_made.emit()

    def _page(self, key: str) -> QWidget:
        if key not in self._pages:
            page = self._entries[key].make(self._services)
            self._pages[key] = page
            self.stack.addWidget(page)
            for wanted in (page.connect_wanted,) if hasattr(page, "connect_wanted") else ():
                wanted.connect(self.connect_to)
            if key == self.navigation.chosen:
                self.stack.setCurrentWidget(page)
        return self._pages[key]

    def _page_for(self, suffix: str) -> FilePage | None:
        for key, page in self._pages.items():
            if suffix in getattr(page, "suffixes", ()):
                return FilePage(key, page.open_file)  # type: ignore[attr-defined]
        return None

    # What a person does

    def toggle_panel(self) -> None:
        """Open or close the sheet with the ports."""
        if self.panel.isVisible():
            self.panel.hide()
        else:
            self._place_panel()
            self.panel.show()
            self.panel.raise_()
        self._refresh_notice()

    def connect_to(self, target: Target) -> None:
        self.attention.leave(partial(self._connector.connect_to, target))

    def disconnect_port(self) -> None:
        self.attention.leave(self._connector.disconnect_port)

    def go_to(self, key: str) -> None:
        self.navigation.choose(key)

    def lock(self) -> None:
        """Put the module into standby, and say what the module says of it."""
        self.attention.lock()

    def say(self, text: str) -> None:
        """A calm line for a while."""
        self.status_line.say(text)

    def close_now(self) -> None:
        """Close in good order without asking: the system wants it, nobody may be there to answer."""
        self._is_leaving = True
        self.close()

    # What happens

    def _take(self, batch: Batch) -> None:
        for page in self._pages.values():
            cast("Page", page).take(batch)
        self.status_line.take(batch)

    def refresh(self) -> None:
        """Bring everything that shows the link or an age up to date."""
        self.top_bar.refresh()
        self.recording_bar.refresh()
        self.status_line.refresh()
        connector = self._connector
        self.menus.lock.setEnabled(connector.is_open and not connector.is_recording)
        self.menus.find_rate.setEnabled(connector.is_open and not connector.is_recording)
        self.menus.disconnect.setEnabled(connector.is_wanted)
        self._refresh_notice()

    def _refresh_notice(self) -> None:
        self.attention.is_choosing = self.panel.isVisible()
        self.attention.refresh()
        if self.panel.isVisible():
            self._place_panel()

    def _connect_again(self) -> None:
        if self._connector.target is not None:
            self._connector.connect_to(self._connector.target)

    def _remember_port(self, target: Target) -> None:
        if not target.is_recording:
            self._remembered.last_port = LastPort(target.device, target.identity, self._connector.connection.baud_rate)
        self.panel.hide()

    def _show_page(self, key: str) -> None:
        self._connector.stream.is_wanted = self._entries[key].wants_stream
        page = self._pages.get(key)
        if page is not None:
            self.stack.setCurrentWidget(page)

    def _use_theme(self, key: str) -> None:
        self._services.appearance.choose(Choice(key))
        self._remembered.theme = key

    def _use_language(self, name: str) -> None:
        self._speech.use(name)
        self._remembered.language = name

    def _follow_theme(self) -> None:
        self.notice_bar.follow_theme()

    def _show_full_screen(self, is_wanted: bool) -> None:
        self.setWindowState(
            self.windowState() | Qt.WindowState.WindowFullScreen
            if is_wanted
            else self.windowState() & ~Qt.WindowState.WindowFullScreen
        )

    def _tick_simulator(self) -> None:
        self.menus.simulator.setChecked(not self.simulator.isHidden())
        self._share_room()

    def _show_about(self) -> None:
        box = QMessageBox(self)
        box.setObjectName("about_box")
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setWindowTitle(tr("About"))
        box.setIconPixmap(app_icon().pixmap(QSize(64, 64)))
        box.setText(tr("DPS-S Configurator {version}", version=version()))
        box.setInformativeText(tr("Configures, tests and watches a DPS-S parachute module over its serial port."))
        box.open()

    def _share_room(self) -> None:
        """The navigation gives its words up before a page has to be cut."""
        has_room = self.width() >= WIDE_ENOUGH or self.simulator.isHidden() or self.simulator.isFloating()
        self.navigation.be_narrow(not has_room)

    def _place_panel(self) -> None:
        centre = self._centre
        top = self.top_bar.geometry().bottom() + 1
        if self.notice_bar.isVisible():
            top = self.notice_bar.geometry().bottom() + 1
        room = centre.height() - top - self.status_line.height() - Space.S
        width = min(PANEL_WIDTH, centre.width() - 2 * Space.S)
        self.panel.setGeometry(Space.S, top, width, min(room, self.panel.height_for(width)))

    # Qt

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Esc that nobody else wanted: close the sheet, or stay where one is. It never sends anything."""
        if event.key() != Qt.Key.Key_Escape:
            super().keyPressEvent(event)
        elif self.panel.isVisible():
            self.toggle_panel()
        else:
            self.attention.stay()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._share_room()
        if self.panel.isVisible():
            self._place_panel()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.LanguageChange:
            self.refresh()

    def closeEvent(self, event: QCloseEvent) -> None:
        if not self._is_leaving and not self.attention.may_close(self.close_now):
            event.ignore()
            return
        self._end()
        event.accept()

    def _end(self) -> None:
        self._timer.stop()
        self.panel.hide()
        remembered = self._remembered
        remembered.geometry = self.saveGeometry()
        remembered.layout = self.saveState()
        remembered.seen_ports = tuple(sorted(self._ports.seen))
        remembered.save()
        if not self._connector.stop(CLOSE_LIMIT_S):
            _log.warning("The port did not close within %s s; it is left to the system", CLOSE_LIMIT_S)
        self._ports.stop(0.05)
        self._services.keeping.close()
