"""Puts the window together and runs it. Shown first, filled afterwards: pages and ports come after the first paint."""

import logging
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType, TracebackType

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QWidget

from app.i18n import LANGUAGES, system_language, tr
from protocol.text import marked
from ui.connect_panel import SIMULATED_PORT
from ui.connector import Connector, Target
from ui.evidence import has_seen_status, leave_evidence
from ui.icons import Icon, app_icon
from ui.main_window import MainWindow
from ui.pages import PageEntry, Services
from ui.port_watch import PortWatch
from ui.remembered import Remembered
from ui.speech import Speech
from ui.texts import Texts
from ui.theme import Appearance, Choice

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class WindowOptions:
    """`offscreen_seconds`: run that long, leave `evidence`, end. Without `port` and `demo` a person chooses."""

    port: str | None = None
    baud_rate: int = 115200
    demo: bool = False
    language: str | None = None
    offscreen_seconds: float | None = None
    evidence: Path | None = None


def _live(services: Services) -> QWidget:
    from ui.live_page import LivePage

    return LivePage(services)


def _traffic(services: Services) -> QWidget:
    from ui.traffic_page import TrafficPage

    return TrafficPage(services)


PAGES: tuple[PageEntry, ...] = (
    PageEntry("live", marked("Live"), Icon.LIVE, _live, wants_stream=True),
    PageEntry("traffic", marked("Traffic"), Icon.TRAFFIC, _traffic),
)


@dataclass(slots=True)
class Assembly:
    """The window and what it works with; made by `assemble`, taken apart by closing the window."""

    window: MainWindow
    connector: Connector
    ports: PortWatch
    appearance: Appearance
    speech: Speech
    exit_code: int = 0


def assemble(
    app: QApplication,
    options: WindowOptions,
    *,
    remembered: Remembered | None = None,
    ports: PortWatch | None = None,
    entries: tuple[PageEntry, ...] = PAGES,
) -> Assembly:
    """The window, not yet shown, with nothing connected."""
    remembered = remembered or Remembered()
    texts = Texts()
    speech = Speech(app, texts)
    speech.use(_language(options, remembered))
    appearance = Appearance(app, _theme(remembered))
    ports = ports or PortWatch()
    connector = Connector(ports)
    services = Services(connector, texts, appearance)
    window = MainWindow(services, ports, speech, remembered, entries=entries)
    return Assembly(window, connector, ports, appearance, speech)


def start(assembly: Assembly, options: WindowOptions) -> None:
    """Show the window; once it is painted, make the pages, look for ports, and connect where that was asked for."""
    window = assembly.window
    target = _target(options)

    def fill() -> None:
        window.make_pages()
        assembly.ports.refresh()
        if target is not None:
            assembly.connector.connect_to(target)

    if target is None:
        QTimer.singleShot(0, window, window.toggle_panel)
    window.show()
    QTimer.singleShot(0, window, fill)


def run(options: WindowOptions) -> int:
    """Open the window and stay until it closes; the exit code."""
    app = QApplication.instance() or QApplication(sys.argv[:1])
    if not isinstance(app, QApplication):
        raise TypeError("a program without a screen's application object cannot open a window")
    app.setApplicationName("dps-s-configurator")
    app.setApplicationDisplayName("DPS-S Configurator")
    app.setDesktopFileName("dps-s-configurator")
    app.setWindowIcon(app_icon())
    with _memory(options) as remembered:
        assembly = assemble(app, options, remembered=remembered)
        _stay(app, assembly, options)
    return assembly.exit_code


@contextmanager
def _memory(options: WindowOptions) -> Iterator[Remembered]:
    """What is remembered; an unattended run begins with nothing and changes nothing for the person."""
    if options.offscreen_seconds is None:
        yield Remembered()
        return
    with tempfile.TemporaryDirectory() as folder:
        yield Remembered(Path(folder) / "window.ini")


def _stay(app: QApplication, assembly: Assembly, options: WindowOptions) -> None:
    with _faults_said(assembly.window), _signals_close(assembly.window):
        start(assembly, options)
        if options.offscreen_seconds is not None:
            QTimer.singleShot(
                round(options.offscreen_seconds * 1000), assembly.window, lambda: _end_unattended(assembly, options)
            )
        app.exec()


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


def _language(options: WindowOptions, remembered: Remembered) -> str:
    """What was asked for now, else what was chosen before, else the computer's."""
    if options.language is not None:
        return options.language
    return remembered.language if remembered.language in LANGUAGES else system_language()


def _theme(remembered: Remembered) -> Choice:
    try:
        return Choice(remembered.theme or Choice.AUTO.value)
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
def _faults_said(window: MainWindow) -> Iterator[None]:
    """An error of ours in the window's thread is logged and said in the status line; the window stays."""
    before: Callable[[type[BaseException], BaseException, TracebackType | None], object] = sys.excepthook

    def say(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        _log.error("An error that was not expected", exc_info=(kind, error, trace))
        window.say(tr("The program met an error that it did not expect: {error}.", error=kind.__name__))

    sys.excepthook = say
    try:
        yield
    finally:
        sys.excepthook = before
