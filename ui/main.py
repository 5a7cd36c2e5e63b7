"""Assembles and runs the window. Pages and ports are loaded after the first paint."""

import gc
import logging
import platform
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from pathlib import Path
from types import FrameType
from typing import NamedTuple

from PySide6.QtCore import QEvent, QObject, Qt, QTimer
from PySide6.QtWidgets import QApplication, QPlainTextDocumentLayout, QWidget

from app import version
from app.engine.target import Target
from app.procedures.act import Armed
from app.system.logs import Log, start_log
from app.system.uncaught import catch_uncaught_errors
from app.text.i18n import ENGLISH, LANGUAGES, system_language, tr
from protocol.translatable import marked
from ui.connect.connect_panel import SIMULATED_PORT
from ui.core.background_task import BackgroundTask
from ui.core.bridge import garbage_freed_here
from ui.core.port_watcher import PortWatcher
from ui.core.preferences import Preferences, has_font_for, use_language
from ui.help.windows import HelpActions
from ui.services.context import PageEntry, Services
from ui.services.page import Page
from ui.services.storage import Storage
from ui.session.left_active import LeftActiveWatch
from ui.session.ports import Ports
from ui.shell.announcements import Sounds, announce_states
from ui.shell.attention import UncaughtErrors
from ui.shell.label_actions import LabelActions
from ui.shell.main_window import MainWindow, end_process, has_seen_status, write_evidence
from ui.style.appearance import Appearance, install_accessible_roles
from ui.style.icons import Icon, app_icon
from ui.style.theme import Choice, Meaning, zoom
from ui.widgets.notice_bar import Notice

_log = logging.getLogger(__name__)

COPY_EVERY_MS = 10 * 60 * 1000
"""How often to check whether a copy of the store is due."""
PAINT_LIMIT_MS = 1000
"""A window that is not painted (started minimised) gets its pages after this time."""
_STORE_LIMIT_S = 5.0


class WindowOptions(NamedTuple):
    """With `offscreen_seconds` the window runs unattended for that time, writes `evidence`, and exits. Without `port`
    and `demo` the user chooses a port."""

    port: str | None = None
    baud_rate: int = 115200
    demo: bool = False
    language: str | None = None
    offscreen_seconds: float | None = None
    evidence: Path | None = None
    file: Path | None = None
    """To be opened in the page of its type."""


def _page(key: str, title: str, picture: Icon, chapter: str = "", *, wants_stream: bool = False) -> PageEntry:
    """The entry of the page in `ui/pages/<key>`, whose module is imported when the page is made."""

    def make(services: Services) -> Page:
        page: Page = getattr(import_module(f"ui.pages.{key}.page"), f"{key.capitalize()}Page")(services)
        return page

    return PageEntry(key, title, picture, make, chapter or title, wants_stream)


PAGES: tuple[PageEntry, ...] = (
    _page("live", marked("Live"), Icon.LIVE, "What the window shows", wants_stream=True),
    _page("settings", marked("Settings"), Icon.SETTINGS),
    _page("triggers", marked("Triggers"), Icon.HISTORY),
    _page("preflight", marked("Pre-flight"), Icon.CHECKLIST, "Before each flight: READY, GO or NO-GO"),
    _page("commands", marked("Commands"), Icon.ACTIVE, "LOCK, and dangerous commands", wants_stream=True),
    _page("fleet", marked("Fleet"), Icon.FLEET, "Several modules"),
    _page("logs", marked("Logs"), Icon.MAP),
    _page("diagnosis", marked("Diagnosis"), Icon.DIAGNOSIS),
)


def _load_libraries() -> None:
    """Imports what the pages need and is slow to load, but nothing that knows Qt: where another thread makes a class of
    Qt's while the event loop runs, PySide6 6.11 ends the program now and then (null `TypeUserData` in
    `SignalManager::retrieveMetaObject`)."""
    _log.info("DPS-S Configurator %s on %s, Python %s", version(), platform.platform(), platform.python_version())
    for module in ("app.recordings.recording", "app.trigger_records.history"):
        import_module(module)


_MADE_HERE = QPlainTextDocumentLayout
"""With those that it is derived from it would else be made where a report is first printed, which is in another thread
too: PySide makes a class when it is first named or returned."""


@dataclass(slots=True)
class Assembly:
    """The window and its services, made by `assemble`; closing the window closes them."""

    window: MainWindow
    help: HelpActions
    ports: Ports
    watcher: PortWatcher
    appearance: Appearance
    storage: Storage
    left_active: LeftActiveWatch
    armed: Armed = field(default_factory=Armed)
    load: Callable[[], object] | None = None
    """Imports what is slow to load; called in the background."""
    exit_code: int = 0


def assemble(
    app: QApplication,
    options: WindowOptions,
    *,
    preferences: Preferences | None = None,
    watcher: PortWatcher | None = None,
    storage: Storage | None = None,
    log: Log | None = None,
    entries: tuple[PageEntry, ...] = PAGES,
) -> Assembly:
    # The platform's file dialogs would let a person rename and remove files, and no LOCK would reach them.
    QApplication.setAttribute(Qt.ApplicationAttribute.AA_DontUseNativeDialogs)
    install_accessible_roles()
    preferences = preferences or Preferences()
    use_language(app, _language(options, preferences))
    zoom(preferences.zoom_percent)
    appearance = Appearance(app, _theme(preferences))
    watcher = watcher or PortWatcher()
    storage = storage or Storage()
    ports = Ports(watcher, storage)
    announce_states(ports, Sounds(preferences, ports))
    services = Services(ports, appearance, preferences, log=log)
    left_active = LeftActiveWatch(ports)
    window = MainWindow(services, left_active, entries=entries)
    ports.setParent(window)  # else its signal connections would keep it alive
    help_actions = HelpActions(window, services, entries)
    LabelActions(window, services)
    load = _load_libraries if entries is PAGES else None
    return Assembly(window, help_actions, ports, watcher, appearance, storage, left_active, services.armed, load)


def start(assembly: Assembly, options: WindowOptions) -> None:
    """Shows the window; after the first paint makes the pages, lists ports, and connects if requested."""
    window, load = assembly.window, assembly.load
    storage = assembly.storage
    timer = QTimer(window, interval=COPY_EVERY_MS)
    timer.timeout.connect(storage.copy_if_due)
    timer.start()
    target = _target(options)
    loading: BackgroundTask[object] = BackgroundTask("dps-s libraries", window)
    opening: BackgroundTask[object] = BackgroundTask("dps-s opening", window)

    def fill() -> None:
        if load is None:
            make_pages()
        else:  # slow: importing numpy
            loading.run(lambda _running: load(), lambda _: make_pages(), lambda _error: make_pages())
        assembly.watcher.refresh()

    def make_pages() -> None:
        window.make_pages()
        # No port waits for it.
        opening.run(lambda _running: storage.open_store(), lambda _store: _on_store_opened(assembly))
        if target is not None:
            window.connect_to(target)

    if options.file is not None:
        window.pages_made.connect(partial(window.files.open, options.file))
    elif target is None:
        QTimer.singleShot(0, window, window.toggle_panel)
    _AfterPaint(window, fill)
    window.show()


def _on_store_opened(assembly: Assembly) -> None:
    """Once the store is open: its trouble, and what the last run of the program left."""
    attention, storage = assembly.window.attention, assembly.storage
    if storage.notice is not None:
        attention.say(Notice(Meaning.ATTENTION, storage.notice))
    assembly.left_active.load()
    storage.opened.emit()
    assembly.ports.changed.emit()  # names are known now


class _AfterPaint(QObject):
    """Calls `act` after the first paint of `window`, before which a zero timer alone would fire."""

    def __init__(self, window: QWidget, act: Callable[[], None]) -> None:
        super().__init__(window)
        self._window, self._act = window, act
        self._limit = QTimer(self, singleShot=True)
        self._limit.timeout.connect(self._continue)
        self._limit.start(PAINT_LIMIT_MS)
        window.installEventFilter(self)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Paint:
            self._window.removeEventFilter(self)
            self._limit.start(0)  # its children are painted within this event
        return False

    def _continue(self) -> None:
        self._window.removeEventFilter(self)
        self._act()
        self.deleteLater()


def run(options: WindowOptions) -> int:
    """Runs the window until it is closed; returns the exit code."""
    app = QApplication.instance() or QApplication(sys.argv[:1])
    if not isinstance(app, QApplication):
        raise TypeError("a window needs a QApplication")
    app.setApplicationName("dps-s-configurator")
    app.setDesktopFileName("dps-s-configurator")
    app.setWindowIcon(app_icon())
    with _memory(options) as folder, _logging(folder) as log:
        preferences = Preferences() if folder is None else Preferences(folder / "window.ini")
        has_font = has_font_for(_language(options, preferences))
        if not has_font:
            options = options._replace(language=ENGLISH)
        assembly = assemble(app, options, preferences=preferences, storage=Storage(folder), log=log)
        window = assembly.window
        if not has_font:
            text = tr("Install a Chinese font (fonts-noto-cjk), then restart.")
            window.attention.say(Notice(Meaning.ATTENTION, text))
        with _errors_shown(window, assembly.armed), _signals_close(window), collecting_garbage(assembly):
            start(assembly, options)
            if options.offscreen_seconds is not None:
                _end_after(options.offscreen_seconds, assembly, options)
            app.exec()
    end_process(assembly.exit_code)
    return assembly.exit_code


@contextmanager
def _memory(options: WindowOptions) -> Iterator[Path | None]:
    """The folder for all data, None for the usual ones; an unattended run uses a temporary folder."""
    if options.offscreen_seconds is None:
        yield None
        return
    # A run that ends early may leave a thread behind that is still opening the store in there, or closing it.
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        yield Path(folder)
        for thread in threading.enumerate():
            if thread.name == "dps-s store":
                thread.join(_STORE_LIMIT_S)


@contextmanager
def collecting_garbage(assembly: Assembly) -> Iterator[None]:
    """Frees garbage only in the window's thread; enter it before `start`."""
    with garbage_freed_here():
        assembly.window.pages_made.connect(gc.freeze)  # halves the longest pause of the collector
        yield


def _end_after(seconds: float, assembly: Assembly, options: WindowOptions) -> None:
    """Ends an unattended run `seconds` after the pages were made, which may take long on a busy machine."""
    end = QTimer(assembly.window, singleShot=True, interval=round(seconds * 1000))
    end.timeout.connect(lambda: _end_unattended(assembly, options))
    assembly.window.pages_made.connect(end.start)


def _end_unattended(assembly: Assembly, options: WindowOptions) -> None:
    assembly.exit_code = 0 if has_seen_status(assembly.ports) else 1
    if options.evidence is not None:
        try:
            write_evidence(options.evidence, assembly.window, assembly.ports)
        except OSError as error:
            _log.error("The evidence could not be written: %s", error)
            assembly.exit_code = 1
    assembly.window.close_now()


def _target(options: WindowOptions) -> Target | None:
    if options.port is not None:
        return Target(options.port, options.baud_rate)
    return Target(SIMULATED_PORT, options.baud_rate) if options.demo else None


def _language(options: WindowOptions, preferences: Preferences) -> str:
    """The requested language, else the saved one, else the system's."""
    if options.language is not None:
        return options.language
    return preferences.language if preferences.language in LANGUAGES else system_language()


def _theme(preferences: Preferences) -> Choice:
    try:
        return Choice(preferences.theme or Choice.AUTO.value)
    except ValueError:
        return Choice.AUTO


@contextmanager
def _signals_close(window: MainWindow) -> Iterator[None]:
    """SIGINT and SIGTERM close the window. Its timer lets Python handle them within 0.1 s."""

    def close(number: int, _frame: FrameType | None) -> None:
        _log.info("Closing because of signal %s", number)
        QTimer.singleShot(0, window, window.close_now)  # it may have come while Qt paints the window

    before = {number: signal.signal(number, close) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _errors_shown(window: MainWindow, armed: Armed | None = None) -> Iterator[None]:
    """Uncaught errors in any thread disarm, are logged and shown; the window stays open."""
    errors = UncaughtErrors(window.attention, armed or Armed(), say=window.show_message, parent=window)
    undo = catch_uncaught_errors(errors.report)
    try:
        yield
    finally:
        undo()


@contextmanager
def _logging(folder: Path | None) -> Iterator[Log]:
    log = start_log(folder)
    try:
        yield log
    finally:
        log.stop()
