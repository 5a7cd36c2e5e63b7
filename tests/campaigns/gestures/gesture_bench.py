"""The real window on a simulated module, in one thread, on clocks that only the test moves; the pointer is real.

Events go to the window's `QWindow`, as a platform sends them: Qt finds the widget under the pointer itself.
"""

from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Final
from unittest.mock import patch

from PySide6.QtCore import QCoreApplication, QEvent, QPoint, QPointF, Qt, QTimer
from PySide6.QtGui import QInputEvent, QKeyEvent, QMouseEvent, QWindow
from PySide6.QtWidgets import QApplication, QMenu, QPushButton, QWidget

from app.engine.conversation import ConversationView, Interrupted
from app.engine.procedure import Job
from app.engine.target import Target
from app.guided.results import GuidedKind
from app.simulator.bench import SimulatedBench
from protocol.catalogue import Hazard, Request
from protocol.events import EndReason
from tests.support.journals import FakeJournal
from tests.support.line.odd_module import odd_bench
from tests.support.line.sim_line import FakeClock, ThreadlessWorker, WatchedLine
from tests.support.patience import PATIENCE_S
from tests.support.window.fakes_ui import ListedPorts, close_window, page_entries, wait_for_disk
from tests.support.window.steps import find, given
from ui.acts.confirm import Confirm
from ui.core.background_task import BackgroundTask
from ui.core.port_watcher import PortWatcher
from ui.core.preferences import Preferences
from ui.main import Assembly, WindowOptions, assemble
from ui.pages.commands.page import CommandsPage
from ui.pages.preflight.guided import GuidedPanel
from ui.pages.preflight.page import PreflightPage
from ui.pages.settings.page import SettingsPage
from ui.services.page import Page
from ui.services.storage import Storage
from ui.session.guided import Stage
from ui.session.ports import Ports
from ui.shell.main_window import MainWindow
from ui.widgets.gestures import REPEATS_WITHIN_MS, gestures

LEFT, NO_BUTTON = Qt.MouseButton.LeftButton, Qt.MouseButton.NoButton
KINDS: Final[Mapping[str, type[Page]]] = {
    "commands": CommandsPage, "preflight": PreflightPage, "settings": SettingsPage,
}  # fmt: skip
"""The pages that can change the module."""
TICK_S = 0.1
HANDS_BEGIN_S = 5000.0
PORT = "sim://gestures"


class InlineWorker(ThreadlessWorker):
    """Runs in the window's thread; what is submitted can be refused before it begins."""

    def __init__(self, callback: object, clock: FakeClock, make_lock: Callable[[], Job[Any]] | None = None) -> None:
        super().__init__(callback, clock, make_lock)
        self.submitted = 0
        self._waiting: list[Job[Any]] = []

    def submit(self, job: Job, *, is_urgent: bool = False) -> Job:  # type: ignore[type-arg]
        self.submitted += 1
        self._waiting.append(job)
        return super().submit(job, is_urgent=is_urgent)

    def refuse_orders(self) -> None:
        """Cancel what was submitted before it begins."""
        assert self._orders.qsize() == len(self._waiting), "nothing else is ordered"
        for job in self._waiting:
            self._orders.get_nowait()
            job.stop(Interrupted(EndReason.PORT_LOST), self._clock())
            self._finished.append(job)
        self.work(0.0)

    def work(self, seconds: float) -> None:
        """Run for this long on the fake clock."""
        clock = self._clock
        assert isinstance(clock, FakeClock)
        self._waiting.clear()
        end_s = clock.now_s + seconds
        while (not self._orders.empty() or clock.now_s < end_s) and self.turn():
            pass
        clock.now_s = max(clock.now_s, end_s)
        self._published_at = 0.0
        self._publish()


def close_menu() -> None:
    popup = QApplication.activePopupWidget()
    if isinstance(popup, QMenu):
        popup.close()


class GestureBench:
    """The window, the pointer and keys, and what was sent to the module."""

    assembly: Assembly
    window: MainWindow
    worker: InlineWorker
    line: WatchedLine
    pages: Mapping[str, Any]
    """By key, those that were asked for."""

    def __init__(self, clock: FakeClock, journal: FakeJournal) -> None:
        self.clock, self.journal = clock, journal
        self.exchange({"uptime": 60, "noise": 0, "rate": 20})
        self.sent: list[Request] = []
        """Requests that were not queries, except for the stream."""
        self.on_leaving: Callable[[Request], None] = lambda _request: None
        """Called with every frame as it is sent, queries included."""
        self.hand_s = HANDS_BEGIN_S
        """The clock of the gestures."""
        self.pointer = QPoint(1, 1)
        self._is_down = False
        self._event_ms = 0

    def exchange(self, options: Mapping[str, Any]) -> None:
        """Another module hangs at the port, which is opened again."""
        self.bench: SimulatedBench = odd_bench(options, self.clock)

    def make_worker(self, callback: object, make_lock: Callable[[], Job[Any]]) -> InlineWorker:
        self.worker = InlineWorker(callback, self.clock, make_lock)
        return self.worker

    def open_line(self, _port: str, baud_rate: int) -> WatchedLine:
        self.line = WatchedLine(self.clock, self.bench, baud_rate, self._heard)
        return self.line

    def connect(self, rate: int = 115200) -> None:
        self.assembly.ports.connect_to(Target(PORT, rate))
        self.wait(0.0)

    def disconnect(self) -> None:
        """Close the port, and end all that is asked, chosen or under way."""
        self.reset()
        self.assembly.ports.current.disconnect_port()
        self.wait(TICK_S)

    @property
    def device(self) -> ConversationView:
        return self.assembly.ports.module.view

    @property
    def handle(self) -> QWindow:
        return given(self.window.windowHandle())

    @cached_property
    def commands(self) -> CommandsPage:
        return find(self.window, CommandsPage)

    @cached_property
    def settings(self) -> SettingsPage:
        return find(self.window, SettingsPage)

    @cached_property
    def preflight(self) -> PreflightPage:
        return find(self.window, PreflightPage)

    @cached_property
    def guided(self) -> GuidedPanel:
        return find(self.window, GuidedPanel)

    def _heard(self, request: Request) -> None:
        if request.command.name != "serial_output":
            self.on_leaving(request)
            if request.hazard is not Hazard.NONE:
                self.sent.append(request)

    def buttons(self) -> list[QPushButton]:
        """Return the buttons of everything that changes the module."""
        page, settings, preflight = self.commands, self.settings, self.preflight
        asked = [one for confirm in self.confirms() for one in (confirm.ask, confirm.go, confirm.cancel)]
        ritual = [page.ritual.choose, page.ritual.rehearse, page.ritual.arm, page.ritual.hold, page.ritual.cancel]
        check = [preflight.enable, preflight.cancel, preflight.run]
        check += [row.act for row in preflight.list.rows.values() if row.act is not None]
        check += [self.guided.primary, self.guided.cancel]
        found = [*asked, *ritual, *check, settings.write, *settings.strip.findChildren(QPushButton)]
        return [one for one in found if one.isVisible()]

    def confirms(self) -> list[Confirm]:
        """Return every question that leads to an act."""
        of_page = {
            "preflight": lambda: (self.preflight.activation.confirm, self.guided.activate.confirm),
            "settings": lambda: (self.settings.baud.confirm,),
        }
        rows = self.commands.acts.values()
        asked = [confirm for key in of_page if key in self.pages for confirm in of_page[key]()]
        return [*(row.confirm for row in rows), *asked]

    # Time

    def turn(self) -> None:
        """Process the events of the window once, after what the disk is still asked for, and paint."""
        wait_for_disk(self.assembly)
        for task in self.assembly.window.findChildren(BackgroundTask):
            if task.is_running:
                task.wait(PATIENCE_S)  # it takes no time of the fake clock
        QCoreApplication.sendPostedEvents()
        QApplication.processEvents()
        QCoreApplication.sendEvent(self.window, QEvent(QEvent.Type.UpdateRequest))

    def wait(self, seconds: float, *, tick_s: float | None = None) -> None:
        """Advance both clocks while the line and the window's timers run; in small steps while something is held."""
        left_s, is_holding = seconds, self._is_down or gestures().has_key_down
        tick_s = tick_s or (TICK_S if is_holding else 4 * TICK_S)
        while left_s > 1e-9:
            step_s = min(tick_s, left_s)
            left_s -= step_s
            self.hand_s += step_s
            self.worker.work(step_s)
            self.turn()
            self.poll()

    def poll(self) -> None:
        """Do what timers of the window do in real time."""
        page = self.commands
        for confirm in self.confirms():
            confirm.check()
        if gestures().is_release_uncertain and self.hand_s * 1000 - self._event_ms >= REPEATS_WITHIN_MS:
            gestures()._send_release()
        if page.ritual.is_under_way:
            page.ritual._tick()

    def refresh(self) -> None:
        for page in self.pages.values():  # none of them where a try has turned to another page
            if page.isVisible():
                page.refresh()
        self.turn()

    # Hands

    def at(self, widget: QWidget, offset: QPoint | None = None) -> QPoint:
        return widget.mapTo(self.window, widget.rect().center() if offset is None else offset)

    def move(self, to: QPoint) -> None:
        self.pointer = to
        self._mouse(QEvent.Type.MouseMove, NO_BUTTON)

    def press(self) -> None:
        self._is_down = True
        self._mouse(QEvent.Type.MouseButtonPress, LEFT)

    def double_press(self) -> None:
        self._is_down = True
        self._mouse(QEvent.Type.MouseButtonDblClick, LEFT)

    def release(self) -> None:
        self._is_down = False
        self._mouse(QEvent.Type.MouseButtonRelease, LEFT)

    def click(self) -> None:
        self.press()
        self.release()
        self.turn()

    def go_and_click(self, widget: QWidget) -> None:
        """Click as a careful person does."""
        self.move(QPoint(1, 1))
        self.turn()
        self.hand_s += 1.0
        self.move(self.at(widget))
        self.click()

    def key(self, key: Qt.Key, *, is_press: bool, is_repeat: bool = False, is_marked: bool = True) -> None:
        """Press or release a key; repeats have one timestamp and are not always marked as repeats on X11."""
        kind = QEvent.Type.KeyPress if is_press else QEvent.Type.KeyRelease
        text = " " if key == Qt.Key.Key_Space else ""
        event = QKeyEvent(kind, key, Qt.KeyboardModifier.NoModifier, text, is_repeat and is_marked)
        self._send(event, is_same_time=is_repeat and is_press)

    def _mouse(self, kind: QEvent.Type, button: Qt.MouseButton) -> None:
        place = QPointF(self.pointer)
        down = LEFT if self._is_down else NO_BUTTON
        event = QMouseEvent(
            kind, place, place, self.window.mapToGlobal(place), button, down, Qt.KeyboardModifier.NoModifier
        )
        self._send(event)

    def _send(self, event: QInputEvent, *, is_same_time: bool = False) -> None:
        """Send an event, with a new timestamp unless `is_same_time`."""
        if not is_same_time:
            self._event_ms = max(self._event_ms + 1, round(self.hand_s * 1000))
        event.setTimestamp(self._event_ms)
        QTimer.singleShot(0, self.window, close_menu)  # a menu returns only when it is closed
        QApplication.sendEvent(self.handle, event)

    # States to begin from

    def until(self, is_so: object, limit_s: float = 30.0) -> None:
        end_s = self.clock.now_s + limit_s
        while not is_so():  # type: ignore[operator]
            assert self.clock.now_s < end_s, "it does not come to be"
            self.wait(TICK_S)
            self.refresh()

    def show_guided(self) -> None:
        self.window.go_to("preflight")
        self.preflight.show_view("guided")

    def prepare_test(self, kind: GuidedKind) -> None:
        """Advance a guided test to the step that a person confirms."""
        page = self.guided
        self.show_guided()
        page.work.cancel()
        self.until(lambda: not page.work.owes_lock)
        page.work.choose(kind)
        page.work.state_safe(True)
        self.settle_module(is_active=False)
        self.until(lambda: page.work.can_start)
        page.work.start()
        self.until(lambda: page.work.stage is not Stage.PREPARING)
        self.refresh()

    def settle_module(self, *, is_active: bool) -> None:
        self.bench.module.activate(is_active=is_active)
        self.until(lambda: self.device.fresh("active", self.clock()) is is_active)

    def reset(self) -> None:
        """Cancel every choice and question, and release all keys and buttons."""
        if self._is_down:
            self.release()
        while (popup := QApplication.activePopupWidget()) is not None:  # a list that a try has opened
            popup.close()
        page = self.commands
        for confirm in self.confirms():
            confirm.withdraw()
        if page.ritual.is_under_way:
            page.ritual.cancel.click()
        if "settings" in self.pages and self.settings.isVisible():
            self.settings.work.job.dismiss()
        self.move(QPoint(1, 1))
        self.turn()
        self.hand_s += 1.0
        self.sent.clear()
        self.worker.submitted = 0


@contextmanager
def gesture_bench(
    qapp: QApplication,
    folder: Path,
    *,
    language: str = "en",
    size: tuple[int, int] = (1024, 600),
    pages: Collection[str] = tuple(KINDS),
) -> Iterator[GestureBench]:
    """Open a window with these pages, Commands among them, that is connected and has read everything."""
    clock = FakeClock()
    journal = FakeJournal()
    made = GestureBench(clock, journal)
    gestures().clock = lambda: made.hand_s  # before the first button is shown, which notes when
    storage = Storage(folder / "store")
    with (
        patch("ui.main.Ports", partial(Ports, make_worker=made.make_worker, clock=clock)),
        patch("app.engine.worker.open_line", made.open_line),
        patch.object(storage, "journal", lambda *_: journal),
        # Hands at random never have a dialog for files under them: whoever is asked cancels at once.
        patch("ui.files.file_dialogs._open_file_dialog", lambda dialog, _then: dialog.deleteLater()),
    ):
        options = WindowOptions(language=language)
        preferences = Preferences(folder / "window.ini")
        assembly = assemble(
            qapp,
            options,
            preferences=preferences,
            watcher=PortWatcher(ListedPorts().poll),
            storage=storage,
            entries=page_entries(*pages),
        )
        made.assembly, made.window = assembly, assembly.window
        window = assembly.window
        try:
            window.make_pages()
            window.resize(*size)
            window.setUpdatesEnabled(False)  # nobody looks before all is there, and painting takes time
            window.show()
            kinds = {key: kind for key, kind in KINDS.items() if key in pages}
            while any(window.findChild(kind) is None for kind in kinds.values()):
                made.turn()
            made.pages = {key: find(window, kind) for key, kind in kinds.items()}
            # A dialog of the platform's would wait for a person.
            if "settings" in pages:
                made.settings.ask_open = lambda *_asked: None
                made.settings.ask_save = lambda *_asked: None
            if "preflight" in pages:
                made.preflight.ask_record = lambda *_asked: None
                made.preflight.form.choose.setMenu(None)  # type: ignore[arg-type]  # so would this menu
                made.preflight.ask_path = lambda *_asked: None
            made.connect()
            window.activateWindow()
            made.wait(0.5)
            made.until(lambda: made.device.is_going)
            made.until(lambda: made.device.known("freefall_time_s", clock()) is not None)
            window.go_to("commands")
            made.wait(3.0, tick_s=1.0)
            window.setUpdatesEnabled(True)
            made.refresh()  # what the page's own timer would do later, and move the rows
            yield made
        finally:
            close_window(assembly)
            gestures().reset()
