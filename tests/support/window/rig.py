"""A window and a simulated module in one thread, on a clock that only the test moves: hours pass in seconds."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar
from unittest.mock import patch

from PySide6.QtCore import QCoreApplication, QTimer
from PySide6.QtWidgets import QAbstractButton, QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.diagnosis.link_state import Phase
from app.engine.procedure import Job
from app.engine.target import Target
from app.engine.transport import PortError, PortErrorKind
from app.engine.worker import Batch
from app.port_urls.protocol_sim import open_bench
from app.preflight.verdict import Standing
from app.simulator.bench import SimulatedBench
from protocol.catalogue import BY_NAME, SERIAL_OUTPUT, Hazard, Request
from protocol.fields import Value
from tests.module.module import Module
from tests.module.options import Options
from tests.support.line.module_line import ModuleLine
from tests.support.line.sim_line import FakeClock, SimulatedLine, ThreadlessWorker
from tests.support.patience import PATIENCE_S
from tests.support.window.fakes_ui import ListedPorts, simulated, wait_for_disk, window
from tests.support.window.steps import Found, find, given, press
from ui.acts.confirm import Confirm
from ui.core.background_task import BackgroundTask
from ui.main import Assembly
from ui.pages.commands.page import CommandsPage
from ui.pages.preflight.guided import GuidedPanel
from ui.pages.preflight.page import PreflightPage
from ui.pages.settings.page import SettingsPage
from ui.pages.triggers.page import TriggersPage
from ui.services.context import PageEntry
from ui.session.port import Port
from ui.session.ports import Ports
from ui.session.recording import SessionRecording
from ui.shell.main_window import MainWindow
from ui.widgets.step_button import gestures

Made = TypeVar("Made", bound="Rig")
TURN_S = 0.08
"""Less than the ritual goes without a tick."""


def is_act(request: Request) -> bool:
    """Whether it is no query, and no `serial_output`."""
    return request.hazard is not Hazard.NONE and request.command is not SERIAL_OUTPUT


@dataclass
class Rig:
    """The window, the module, and every frame that left for it, on a clock that only `wait` and `until` move."""

    qtbot: QtBot
    assembly: Assembly
    bench: SimulatedBench
    url: str
    clock: FakeClock
    workers: list[ThreadlessWorker]
    """One for each port; one that is taken out stands still, as where a driver hangs."""
    requests: list[Request]
    lines: list[SimulatedLine | ModuleLine]
    """Every opening of a port, the last one last."""
    devices: dict[str, tuple[Module, ...]]
    """By port: independent modules, in place of the simulated one."""
    on_leaving: Callable[[Request], None] = lambda _request: None
    """Called with each frame as it is sent."""
    _due_s: dict[QTimer, float] = field(default_factory=dict)

    @property
    def window(self) -> MainWindow:
        return self.assembly.window

    @property
    def port(self) -> Port:
        return self.assembly.ports.current

    @cached_property
    def commands(self) -> CommandsPage:
        return self.find(CommandsPage)

    @cached_property
    def settings(self) -> SettingsPage:
        return self.find(SettingsPage)

    @cached_property
    def preflight(self) -> PreflightPage:
        return self.find(PreflightPage)

    @cached_property
    def guided(self) -> GuidedPanel:
        return self.find(GuidedPanel)

    def go_to(self, key: str) -> None:
        """Show the page of this key."""
        self.window.go_to(key)
        self.until(lambda: given(self.window.stack.currentWidget()).isVisible())

    @property
    def acts(self) -> list[Request]:
        return list(filter(is_act, self.requests))

    @cached_property
    def triggers(self) -> TriggersPage:
        return self.find(TriggersPage)

    def find(self, kind: type[Found], name: str = "") -> Found:
        return find(self.window, kind, name)

    def click(self, widget: QWidget | str | None) -> None:
        """A widget, or a button given by its name, once it is visible and enabled."""
        button: QWidget | None = self.find(QAbstractButton, widget) if isinstance(widget, str) else widget
        assert button is not None
        self.until(lambda: button.isVisible() and button.isEnabled())
        press(self.qtbot, button)

    def changes(self, *names: str) -> list[bytes]:
        """The frames that were not queries; of the commands `names`, or of all but `serial_output`."""
        return [act.encode() for act in self.acts if not names or act.command.name in names]

    def held(self, name: str) -> Value:
        """The value that the module holds, in the field's unit."""
        command = BY_NAME[name]
        assert command.write is not None
        return command.write.decode(getattr(self.bench.module.memory, name))

    def turn(self, longest_s: float = TURN_S) -> None:
        """One step of the line, the window and its timers; no time passes while the disk or a task is at work."""
        end_s = self.clock.now_s + longest_s
        while self.clock.now_s < end_s and sum(worker.turn() for worker in self.workers):
            pass
        self.clock.now_s = max(self.clock.now_s, end_s)
        wait_for_disk(self.assembly)
        for task in self.window.findChildren(BackgroundTask):
            if task.is_running:
                task.wait(PATIENCE_S)
        QCoreApplication.sendPostedEvents()
        QApplication.processEvents()
        for owner in (self.window, self.assembly.ports, gestures()):
            for timer in owner.findChildren(QTimer):
                self._tick(timer)

    def _tick(self, timer: QTimer) -> None:
        if not timer.isActive():
            self._due_s.pop(timer, None)
            return
        now_s, every_s = self.clock(), timer.interval() / 1000
        if now_s >= self._due_s.setdefault(timer, now_s + every_s):
            self._due_s[timer] = now_s + every_s
            if timer.isSingleShot():
                timer.stop()
            timer.timeout.emit()

    def wait(self, seconds: float) -> None:
        end_s = self.clock() + seconds
        while self.clock() < end_s:
            self.turn()

    def until(self, is_so: Callable[[], object], limit_s: float = 120.0) -> None:
        end_s = self.clock() + limit_s
        while not is_so():
            assert self.clock() < end_s, "it does not come to be"
            self.turn()

    def plug_in(self, device: str, settings: Mapping[int, int] = MappingProxyType({})) -> tuple[Port, Module]:
        """Connect the first port that is free to an independent module with these settings, until all was read."""
        module, ports = Module(Options(stream_hz=20), seed=len(self.devices) + 1, now=self.clock()), self.assembly.ports
        module.settings |= settings
        self.devices[device] = (module,)
        port = next((port for port in ports.all if not port.is_requested), None) or ports.add()
        port.connect_to(Target(device, 115200))
        self.until(lambda: port.module.is_read)
        return port, module

    def unplug(self, port: Port) -> None:
        """Until it is opened again."""
        line = next(line for line in reversed(self.lines) if line.port == given(port.target).device)
        assert isinstance(line, ModuleLine)
        line.error = PortError(PortErrorKind.LOST, line.port, "unplugged")
        self.until(lambda: not port.is_open)

    def connect(self) -> None:
        """Until everything was read."""
        self.assembly.ports.connect_to(Target(self.url, 115200))
        self.until(lambda: self.port.module.is_read and self.port.state.phase is Phase.ONLINE)
        self.window.panel.hide()

    def restart(self) -> None:
        """Until everything was read again."""
        port, before = self.port, self.port.module.number
        self.bench.restart()
        self.until(lambda: port.module.number > before and port.module.is_going and port.module.is_read)

    def ask(self, confirm: Confirm) -> None:
        """Make the first click of an act; if the layout changed, the first click only scrolls."""
        for _ in range(2):
            if not confirm.is_asking:
                self.until(confirm.ask.isEnabled)
                self.click(confirm.ask)

    def check(self, *, is_enabling: bool = True) -> Standing:
        """Run a check by a click; return the verdict."""
        self.go_to("preflight")
        page = self.preflight
        self.click(page.enable if is_enabling and page.enable.isVisible() else page.run)
        assert page.state.standing is Standing.CHECKING
        self.wait_standing(Standing.GO, Standing.READY, Standing.NO_GO, Standing.VOID)
        return page.state.standing

    def wait_standing(self, *wanted: Standing) -> None:
        self.until(lambda: self.preflight.banner.announcement.standing in wanted)

    def read_triggers(self) -> None:
        self.go_to("triggers")
        self.click(self.triggers.read)
        self.until(lambda: not self.triggers.work.is_busy)


@contextmanager
def on_fake_time(
    kind: type[Made], qtbot: QtBot, qapp: QApplication, folder: Path, name: str, entries: tuple[PageEntry, ...],
    ports: ListedPorts | None = None, /, **options: object,
) -> Iterator[Made]:  # fmt: skip
    """Open a window, with its pages made, and make a module for it; the worker runs in the window's thread, as far as
    `turn` says."""
    clock, workers, requests = FakeClock(), list[ThreadlessWorker](), list[Request]()
    lines, rigs, devices = list[SimulatedLine | ModuleLine](), list[Made](), dict[str, tuple[Module, ...]]()

    def make_worker(callback: Callable[[Batch], None], *, make_lock: Callable[[], Job[Any]]) -> ThreadlessWorker:
        workers.append(ThreadlessWorker(callback, clock, make_lock))
        return workers[-1]

    def leaves(request: Request) -> None:
        requests.append(request)
        rigs[0].on_leaving(request)

    def open_line(port: str, baud_rate: int) -> SimulatedLine | ModuleLine:
        if port in devices:
            lines.append(ModuleLine(clock, *devices[port], baud_rate=baud_rate, port=port))
        else:
            lines.append(SimulatedLine(clock, open_bench(port), baud_rate, leaves))
        return lines[-1]

    gestures().clock = clock
    with (
        patch.dict(SimulatedBench.__init__.__kwdefaults__ or {}, clock=clock),
        patch("ui.main.Ports", partial(Ports, clock=clock)),
        patch("ui.session.port.Worker", make_worker),
        patch.object(SessionRecording, "recorded", lambda _recording, deliver: deliver),
        patch("app.engine.worker.open_line", open_line),
        simulated(name, **options) as bench,
        window(qapp, folder, listed=ports, entries=entries) as assembly,
    ):
        rigs.append(kind(qtbot, assembly, bench, f"sim://{name}", clock, workers, requests, lines, devices))
        while not assembly.window.has_pages:
            Rig.turn(rigs[0], 0)
        assembly.window.activateWindow()
        Rig.turn(rigs[0], 0)
        yield rigs[0]
