"""Assembles and runs the window. Pages and ports are loaded after the first paint."""

import gc
import logging
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from itertools import chain
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Final, NamedTuple

from PySide6 import QtCore, QtGui, QtWidgets
from PySide6.QtCore import QEvent, QObject, Qt, QTimer
from PySide6.QtWidgets import QApplication, QWidget

from app import version
from app.engine.conversation import STATUS_KEYS
from app.engine.target import Target
from app.procedures.act import Armed
from app.system.logs import Log
from app.system.uncaught import uncaught_errors_told
from app.text.i18n import ENGLISH, LANGUAGES, system_language, tr
from protocol.translatable import marked
from ui.connect.connect_panel import SIMULATED_PORT
from ui.core.background_task import BackgroundTask
from ui.core.bridge import garbage_freed_here
from ui.core.port_watcher import PortWatcher
from ui.core.preferences import Preferences, has_font_for, use_language
from ui.core.turns import Turns, importing
from ui.services.context import PageEntry, Services
from ui.services.storage import Storage
from ui.session.left_active import LeftActiveWatch
from ui.session.ports import Ports
from ui.shell.announcements import StateAnnouncer
from ui.shell.main_window import MainWindow, end_process
from ui.style.appearance import Appearance, install_accessible_roles
from ui.style.icons import Icon, app_icon
from ui.style.theme import Choice, Meaning, zoom

if TYPE_CHECKING:
    from ui.services.page import Page

_log = logging.getLogger(__name__)

# A window that is not painted (started minimised) gets its pages after this time.
PAINT_LIMIT_MS: Final = 1000
_STORE_LIMIT_S: Final = 5.0


class WindowOptions(NamedTuple):
    """The options of the window. Without `port` and `demo` the user chooses a port."""

    port: str | None = None
    baud_rate: int = 115200
    demo: bool = False
    language: str | None = None
    # For so long the window runs unattended, saves a picture of itself in `evidence`, and exits.
    offscreen_seconds: float | None = None
    evidence: Path | None = None
    # To be opened in the page of its type.
    file: Path | None = None


def _page(key: str, title: str, picture: Icon, chapter: str = "", *, wants_stream: bool = False) -> PageEntry:
    """The entry of the page in `ui/pages/<key>`, whose module is imported after the first paint."""
    module = f"ui.pages.{key}.page"

    def make(services: Services) -> "Page":
        page: Page = getattr(import_module(module), f"{key.capitalize()}Page")(services)
        return page

    return PageEntry(key, title, picture, make, chapter or title, wants_stream, partial(import_module, module))


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
    """Imports what the pages need and is slow to load, with what pyqtgraph needs of the standard library, but nothing
    that knows Qt: where another thread makes a class of Qt's while the event loop runs, PySide6 6.11 ends the program
    now and then (null `TypeUserData` in `SignalManager::retrieveMetaObject`)."""
    import platform

    _log.info("DPS-S Configurator %s on %s, Python %s", version(), platform.platform(), platform.python_version())
    of_pyqtgraph = ("multiprocessing.connection", "pydoc", "subprocess", "xml.etree.ElementTree")
    for module in ("app.recordings.recording", "app.trigger_records.history", *of_pyqtgraph):
        import_module(module)


@dataclass(slots=True)
class Assembly:
    """The window and its services, made by `assemble`; closing the window closes them."""

    window: MainWindow
    ports: Ports
    watcher: PortWatcher
    appearance: Appearance
    storage: Storage
    left_active: LeftActiveWatch
    armed: Armed
    # Imports what is slow to load; called in the background.
    load: Callable[[], object]
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
    known = {choice.value: choice for choice in Choice}
    appearance = Appearance(app, known.get(preferences.theme or "", Choice.AUTO))
    watcher, storage = watcher or PortWatcher(), storage or Storage()
    ports = Ports(watcher, storage)
    StateAnnouncer(ports, preferences)
    services = Services(ports, appearance, preferences, log=log)
    left_active = LeftActiveWatch(ports)
    window = MainWindow(services, left_active, entries=entries)
    ports.setParent(window)  # else its signal connections would keep it alive
    load = _load_libraries if entries is PAGES else bool
    return Assembly(window, ports, watcher, appearance, storage, left_active, services.armed, load)


def start(assembly: Assembly, options: WindowOptions) -> None:
    """Shows the window; after the first paint makes the pages, lists ports, and connects if requested."""
    window, storage, attention = assembly.window, assembly.storage, assembly.window.attention
    target: Target | None = None
    if options.port is not None or options.demo:
        target = Target(options.port or SIMULATED_PORT, options.baud_rate)
    turns = Turns(window)
    loading: BackgroundTask[object] = BackgroundTask("dps-s libraries", window)
    opening: BackgroundTask[object] = BackgroundTask("dps-s opening", window)

    def fill() -> None:
        assembly.watcher.refresh()
        turns.take(chain(_naming_classes(), [load]))

    def load() -> None:
        loading.run(lambda _running: assembly.load(), load_plots, fail)  # slow: it imports numpy

    def fail(error: Exception) -> None:
        load_plots(error)
        raise error

    def load_plots(_outcome: object) -> None:
        turns.take(chain(importing("pyqtgraph"), [make_pages]))

    def make_pages() -> None:
        window.make_pages()
        # No port waits for it.
        opening.run(lambda _running: storage.open_store(), on_store_opened)
        if target is not None:
            window.connect_to(target)

    def on_store_opened(_store: object) -> None:
        """Its trouble, and what the last run of the program left."""
        if storage.notice is not None:
            attention.said.notify(Meaning.ATTENTION, storage.notice, storage.notice)
        assembly.left_active.load()
        storage.opened.emit()
        assembly.ports.changed.emit()  # names are known now

    if (file := options.file) is not None:
        window.pages_made.connect(lambda: window.files.open(file))
    elif target is None:
        QTimer.singleShot(0, window, window.toggle_panel)
    _AfterPaint(window, fill)
    window.show()


def _naming_classes() -> Iterator[Callable[[], object]]:
    """Steps that name every class of Qt.

    PySide makes a class when it is first named, and pyqtgraph names all of them when it is imported, for which the
    window would stand still. Those of printing would else be made in another thread, where a report is printed.
    """
    for library in (QtCore, QtGui, QtWidgets):
        for name in dir(library):
            yield partial(getattr, library, name)


class _AfterPaint(QObject):
    """Calls `act` after the first paint of `window`, before which a zero timer alone would fire."""

    def __init__(self, window: QWidget, act: Callable[[], None]) -> None:
        super().__init__(window)
        self._limit = QTimer(self, singleShot=True)
        self._limit.timeout.connect(act)
        self._limit.timeout.connect(self.deleteLater)
        self._limit.start(PAINT_LIMIT_MS)
        window.installEventFilter(self)

    def eventFilter(self, window: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Paint and self._limit.isActive():
            window.removeEventFilter(self)
            self._limit.start(0)  # its children are painted within this event
        return False


def run(options: WindowOptions) -> int:
    """Runs the window until it is closed; returns the exit code."""
    app = QApplication.instance() or QApplication([*sys.argv[:1], "-style", "fusion"])
    if not isinstance(app, QApplication):
        raise TypeError("a window needs a QApplication")
    app.setApplicationName("dps-s-configurator")
    app.setDesktopFileName("dps-s-configurator")
    app.setWindowIcon(app_icon())
    with ExitStack() as stack:
        folder = stack.enter_context(_memory(options))
        log = Log(folder)
        stack.callback(log.stop)
        preferences = Preferences() if folder is None else Preferences(folder / "window.ini")
        has_font = has_font_for(_language(options, preferences))
        if not has_font:
            options = options._replace(language=ENGLISH)
        assembly = assemble(app, options, preferences=preferences, storage=Storage(folder), log=log)
        window = assembly.window
        if not has_font:
            text = tr("Install a Chinese font (fonts-noto-cjk), then restart.")
            window.attention.said.notify(Meaning.ATTENTION, text, text)
        # Uncaught errors in any thread disarm, are logged and shown; the window stays open.
        stack.enter_context(uncaught_errors_told(window.attention.report))
        stack.enter_context(_signals_close(window))
        stack.enter_context(collecting_garbage(assembly))
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
    """Ends an unattended run `seconds` after the pages were made, which may take long on a busy machine; its exit code
    says whether the module's status was seen."""
    window, ports = assembly.window, assembly.ports

    def finish() -> None:
        view, now = ports.module.view, ports.clock()
        assembly.exit_code = 0 if all(view.fresh(key, now) is not None for key in STATUS_KEYS) else 1
        if options.evidence is not None:
            with suppress(OSError):  # then nothing can be saved in there either
                options.evidence.mkdir(parents=True, exist_ok=True)
            if not window.grab().save(str(options.evidence / "live.png")):
                _log.error("The picture could not be written into %s", options.evidence)
                assembly.exit_code = 1
        window.close_now()

    end = QTimer(window, singleShot=True, interval=round(seconds * 1000))
    end.timeout.connect(finish)
    window.pages_made.connect(end.start)


def _language(options: WindowOptions, preferences: Preferences) -> str:
    """The requested language, else the saved one, else the system's."""
    if options.language is not None:
        return options.language
    return preferences.language if preferences.language in LANGUAGES else system_language()


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
