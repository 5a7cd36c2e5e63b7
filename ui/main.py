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
from types import FrameType, ModuleType

from PySide6.QtCore import QEvent, QObject, QTimer
from PySide6.QtWidgets import QApplication, QWidget

from app import version
from app.engine.target import Target
from app.procedures.act import Armed
from app.system.logs import Log, start_log
from app.system.tones import Tone, TonePlayer
from app.system.uncaught import catch_uncaught_errors
from app.text.i18n import LANGUAGES, system_language, tr
from protocol.translatable import marked
from ui.archive.archive_actions import ArchiveActions
from ui.connect.baud_recovery import BaudRecovery
from ui.connect.connect_panel import SIMULATED_PORT
from ui.core.background_task import BackgroundTask
from ui.core.connector import Connector
from ui.core.garbage_collector import garbage_freed_here
from ui.core.language_switch import LanguageSwitch
from ui.core.port_watcher import PortWatcher
from ui.core.preferences import Preferences
from ui.core.texts import Texts
from ui.help.help_actions import HelpActions
from ui.preferences.missing_font import need_fonts
from ui.services.context import PageEntry, Services
from ui.services.lock import LockControl
from ui.services.page import Page
from ui.services.state_announcer import announce_states
from ui.services.storage import Storage
from ui.shell.main_window import MainWindow
from ui.shell.shutdown import end_process
from ui.shell.unattended_run import has_seen_status, leave_evidence
from ui.shell.uncaught_errors import UncaughtErrors
from ui.style.accessible_roles import install_accessible_roles
from ui.style.appearance import Appearance
from ui.style.icons import Icon, app_icon
from ui.style.theme import Choice, Meaning, zoom
from ui.widgets.notice_bar import Notice

_log = logging.getLogger(__name__)

COPY_EVERY_MS = 10 * 60 * 1000
"""How often it is asked whether a copy of the store is due."""
PAINT_LIMIT_MS = 1000
"""A window that was begun out of sight (minimised) is filled after this time."""


@dataclass(frozen=True, slots=True)
class WindowOptions:
    """`offscreen_seconds`: run that long once the pages are made, leave `evidence`, end. Without `port` and `demo` a
    person chooses."""

    port: str | None = None
    baud_rate: int = 115200
    demo: bool = False
    language: str | None = None
    offscreen_seconds: float | None = None
    evidence: Path | None = None
    file: Path | None = None
    """Opened in the page of its type."""


def _page(key: str, title: str, picture: Icon, chapter: str = "", *, wants_stream: bool = False) -> PageEntry:
    """The page of the room `ui/pages/<key>`. Its module is loaded when the page is made, or by `_load_pages`."""

    def make(services: Services) -> Page:
        page: Page = getattr(_module(key), f"{key.capitalize()}Page")(services)
        return page

    return PageEntry(key, title, picture, make, chapter or title, wants_stream)


def _module(key: str) -> ModuleType:
    return import_module(f"ui.pages.{key}.page")


PAGES: tuple[PageEntry, ...] = (
    _page("live", marked("Live"), Icon.LIVE, "What the window shows", wants_stream=True),
    _page("settings", marked("Settings"), Icon.SETTINGS),
    _page("triggers", marked("Triggers"), Icon.HISTORY),
    _page("preflight", marked("Pre-flight"), Icon.CHECKLIST, "Before each flight: READY, GO or NO-GO"),
    _page("tests", marked("Tests"), Icon.TESTS, "Guided tests", wants_stream=True),
    _page("commands", marked("Commands"), Icon.ACTIVE, "LOCK, and dangerous commands", wants_stream=True),
    _page("fleet", marked("Fleet"), Icon.FLEET, "Several modules"),
    _page("recordings", marked("Recordings"), Icon.RECORDINGS),
    _page("flights", marked("Flight logs"), Icon.MAP),
    _page("diagnosis", marked("Diagnosis"), Icon.DIAGNOSIS),
)


def _load_pages() -> None:
    """What the pages' modules load, so that making a page takes no longer than a turn of the event loop should."""
    for entry in PAGES:
        _module(entry.key)


@dataclass(slots=True)
class Assembly:
    """The window and what it works with; made by `assemble`, taken apart by closing the window."""

    window: MainWindow
    help: HelpActions
    archive: ArchiveActions
    connector: Connector
    ports: PortWatcher
    appearance: Appearance
    language_switch: LanguageSwitch
    storage: Storage
    lock: LockControl
    armed: Armed = field(default_factory=Armed)
    load: Callable[[], object] | None = None
    """Loads what the pages need; takes long."""
    exit_code: int = 0


def assemble(
    app: QApplication,
    options: WindowOptions,
    *,
    preferences: Preferences | None = None,
    ports: PortWatcher | None = None,
    storage: Storage | None = None,
    log: Log | None = None,
    entries: tuple[PageEntry, ...] = PAGES,
) -> Assembly:
    """The window, not yet shown, with nothing connected."""
    install_accessible_roles()
    preferences = preferences or Preferences()
    texts = Texts()
    language_switch = LanguageSwitch(app, texts)
    language_switch.use(_language(options, preferences))
    zoom(preferences.zoom_percent)
    appearance = Appearance(app, _theme(preferences))
    ports = ports or PortWatcher()
    storage = storage or Storage()
    connector = Connector(ports, make_worker=storage.sessions.tapped())
    storage.is_recording = lambda: connector.is_recording
    lock = LockControl(connector, storage.journal, connector)
    tones = TonePlayer()

    def play(tone: Tone) -> None:
        if preferences.has_sounds and not tones.play(tone):
            app.beep()

    announce_states(connector, lock, play)
    services = Services(connector, texts, appearance, lock, storage, preferences, log=log)
    connector.remember_stream(storage.stream_memory)
    services.naming.follow(connector, storage)
    storage.sessions.follow(connector.current)
    module = services.naming.of(connector.current)
    module.changed.connect(lambda: storage.sessions.name_module(module.name))
    window = MainWindow(services, ports, language_switch, preferences, entries=entries)
    for owned in (connector, services.naming):  # else what is connected to their signals lives for ever, and they by it
        owned.setParent(window)
    window.closing.connect(tones.close)
    help_actions = HelpActions(window, services, entries)
    load = _load_pages if entries is PAGES else None
    return Assembly(
        window, help_actions, ArchiveActions(window, services), connector, ports, appearance, language_switch, storage,
        lock, services.armed, load,
    )  # fmt: skip


def start(assembly: Assembly, options: WindowOptions) -> None:
    """Show the window; once it is painted, make the pages, look for ports, and connect where that was asked for."""
    window, load = assembly.window, assembly.load
    copies = QTimer(window)
    copies.setInterval(COPY_EVERY_MS)
    copies.timeout.connect(assembly.storage.copy_if_due)
    copies.start()
    target = _target(options)
    loading: BackgroundTask[object] = BackgroundTask("dps-s pages", window)

    def fill() -> None:
        if load is None:
            make_pages()
        else:  # plots take half a second to load, the store what the disk takes: the window would stand still
            loading.run(lambda _running: prepare(load), lambda _: make_pages(), lambda _error: make_pages())
        assembly.ports.refresh()

    def prepare(load: Callable[[], object]) -> None:
        assembly.storage.open_store()
        load()

    def make_pages() -> None:
        _tell_of_store(assembly)
        window.make_pages()
        if target is not None:
            window.connect_to(target)

    if options.file is not None:
        window.pages_made.connect(partial(window.files.open, options.file))
    elif target is None:
        QTimer.singleShot(0, window, window.toggle_panel)
    _AfterPaint(window, fill)
    window.show()


def _tell_of_store(assembly: Assembly) -> None:
    """Say what is the matter with the store, and what was broken off when the program last ended."""
    attention, storage = assembly.window.attention, assembly.storage
    left_on = partial(_left_on_notice, attention.forget_told)
    assembly.connector.stream_left_on.connect(lambda: attention.tell(left_on))
    if storage.notice is not None:
        attention.tell(lambda: Notice(Meaning.ATTENTION, storage.notice or "", dismiss=attention.forget_told))
    recovery = BaudRecovery(
        assembly.connector,
        assembly.ports,
        storage,
        close=attention.forget_told,
        leave=attention.leave,
        say=assembly.window.say,
    )
    for pending in recovery.pending():
        attention.tell(partial(recovery.notice, pending))


def _left_on_notice(dismiss: Callable[[], None]) -> Notice:
    text = tr("Serial output was left on; it is switched off when not needed.")
    return Notice(Meaning.INFORMATION, text, dismiss=dismiss)


class _AfterPaint(QObject):
    """Calls `act` when `window` has been painted for the first time. A timer alone would come before that paint."""

    def __init__(self, window: QWidget, act: Callable[[], None]) -> None:
        super().__init__(window)
        self._window, self._act = window, act
        self._limit = QTimer(self)
        self._limit.setSingleShot(True)
        self._limit.timeout.connect(self._go_on)
        self._limit.start(PAINT_LIMIT_MS)
        window.installEventFilter(self)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Paint:
            self._window.removeEventFilter(self)
            self._limit.start(0)  # the children are painted within this same event
        return False

    def _go_on(self) -> None:
        self._window.removeEventFilter(self)
        self._act()
        self.deleteLater()


def run(options: WindowOptions) -> int:
    """Open the window and stay until it closes; the exit code."""
    app = QApplication.instance() or QApplication(sys.argv[:1])
    if not isinstance(app, QApplication):
        raise TypeError("a program without a screen's application object cannot open a window")
    app.setApplicationName("dps-s-configurator")
    app.setDesktopFileName("dps-s-configurator")
    app.setWindowIcon(app_icon())
    with _memory(options) as folder, _logging(folder) as log:
        preferences = Preferences() if folder is None else Preferences(folder / "window.ini")
        assembly = assemble(app, options, preferences=preferences, storage=Storage(folder), log=log)
        window = assembly.window
        need_fonts(
            assembly.language_switch, window.choices, tell=window.attention.tell, dismiss=window.attention.forget_told
        )
        _stay(app, assembly, options)
    end_process(assembly.exit_code)
    return assembly.exit_code


@contextmanager
def _memory(options: WindowOptions) -> Iterator[Path | None]:
    """Where things are kept, None for the usual places; an unattended run begins with nothing and changes nothing."""
    if options.offscreen_seconds is None:
        yield None
        return
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)


def _stay(app: QApplication, assembly: Assembly, options: WindowOptions) -> None:
    with _faults_said(assembly.window, assembly.armed), _signals_close(assembly.window), kept_tidy(assembly):
        start(assembly, options)
        if options.offscreen_seconds is not None:
            _end_after(options.offscreen_seconds, assembly, options)
        app.exec()


@contextmanager
def kept_tidy(assembly: Assembly) -> Iterator[None]:
    """Garbage is freed in the window's own thread while this lasts; begin it before `start`."""
    with garbage_freed_here():
        # What is loaded, and what is there once the pages are made, stays: without it the collector's longest pause is
        # twice as long, and one falls into the making of a page.
        if assembly.load is not None:
            assembly.load = partial(_load_for_good, assembly.load)
        assembly.window.pages_made.connect(gc.freeze)
        yield


def _load_for_good(load: Callable[[], object]) -> None:
    load()
    gc.freeze()


def _end_after(seconds: float, assembly: Assembly, options: WindowOptions) -> None:
    """End an unattended run. The time begins with the pages: on a busy machine they may take longer than it lasts."""
    end = QTimer(assembly.window)
    end.setSingleShot(True)
    end.setInterval(round(seconds * 1000))
    end.timeout.connect(lambda: _end_unattended(assembly, options))
    assembly.window.pages_made.connect(end.start)


def _end_unattended(assembly: Assembly, options: WindowOptions) -> None:
    assembly.exit_code = 0 if has_seen_status(assembly.connector) else 1
    if options.evidence is not None:
        try:
            leave_evidence(options.evidence, assembly.window, assembly.connector)
        except OSError as error:
            _log.error("The evidence could not be written: %s", error)
            assembly.exit_code = 1
    assembly.window.close_now()


def _target(options: WindowOptions) -> Target | None:
    if options.port is not None:
        return Target(options.port, options.baud_rate)
    return Target(SIMULATED_PORT, options.baud_rate) if options.demo else None


def _language(options: WindowOptions, preferences: Preferences) -> str:
    """What was asked for now, else what was chosen before, else the computer's."""
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
    """Ctrl-C and SIGTERM close the window in good order. The window's own timer lets Python see them within 0.1 s."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def close(number: int, _frame: FrameType | None) -> None:
        _log.info("Closing because of signal %s", number)
        window.close_now()

    before = {one: signal.signal(one, close) for one in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)


@contextmanager
def _faults_said(window: MainWindow, armed: Armed | None = None) -> Iterator[None]:
    """An error of ours, in whatever thread, disarms, is logged and said; the window stays."""
    mishaps = UncaughtErrors(window.attention, armed or Armed(), say=window.say, parent=window)
    undo = catch_uncaught_errors(mishaps.tell)
    try:
        yield
    finally:
        undo()


@contextmanager
def _logging(folder: Path | None) -> Iterator[Log]:
    """The rotating log, for as long as the window runs."""
    log = start_log(folder)
    _log.info("DPS-S Configurator %s on %s, Python %s", version(), platform.platform(), platform.python_version())
    try:
        yield log
    finally:
        log.stop()
