"""All ports of the window, one of which the pages show, and the LOCK buttons of all of them."""

import logging
import time
from collections.abc import Callable
from functools import partial
from typing import Final
from weakref import WeakKeyDictionary

from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtWidgets import QWidget

from app.engine.target import Target
from app.engine.worker import PUBLISH_EVERY_S
from app.modules.names import modules
from app.store.fact_store import StoreError
from app.system.clock import steady_time
from ui.core.port_watcher import PortWatcher
from ui.services.storage import Storage
from ui.session.port import Port
from ui.session.shown_module import ShownModule

_log = logging.getLogger(__name__)
TICK_MS: Final = 250


class Ports(QObject):
    """The other ports stay open, reconnect and lock independently of the one that is shown."""

    # This `ShownModule` is shown from now on: another conversation has begun, or another port was chosen.
    shown = Signal(object)
    changed = Signal()  # Something of the port that is shown is otherwise, or an age that is shown of it
    any_changed = Signal()  # Of any port
    # Another port was chosen and this one is still current: what a person prepared for its module ends now.
    leaving = Signal()
    chosen = Signal()  # Another port is current; `shown` follows
    failed = Signal()  # An error that nobody expected: what is armed or tested ends now
    notified = Signal(str)  # A line for the status bar
    added = Signal(object)  # A `Port`

    def __init__(self, watcher: PortWatcher, storage: Storage, *, clock: Callable[[], float] = steady_time) -> None:
        super().__init__()
        self.clock, self.storage, self.watcher = clock, storage, watcher
        self._ports: list[Port] = []
        self.current = self.add()
        self.lock = LockControl(self)
        self._ticking = QTimer(self, interval=TICK_MS)
        self._ticking.timeout.connect(self._tick)
        self._ticking.start()

    @property
    def all(self) -> tuple[Port, ...]:
        """All ports in the order in which they were added."""
        return tuple(self._ports)

    @property
    def module(self) -> ShownModule:
        """The one that the pages show."""
        return self.current.module

    def known_names(self) -> list[str]:
        """Return the names of all modules of the store, the last seen first; empty while there is no store."""
        store = self.storage.ready
        try:
            return [] if store is None else [known.name for known in store.read(modules)]
        except StoreError as trouble:
            _log.warning("The names of the modules cannot be read: %s", trouble)
            return []

    # What can be done

    def add(self) -> Port:
        """Another port, not yet connected; the current one stays current."""
        port = Port(self.watcher, self.storage, clock=self.clock, parent=self)
        port.set_shown(is_shown=not self._ports)
        for changed in (port.changed, port.lock.changed, port.interruptions.changed):
            changed.connect(partial(self._on_changed, port))
        port.module_changed.connect(partial(self._on_module, port))
        port.named.connect(partial(self._on_named, port))
        port.lock.notified.connect(lambda text: self.notified.emit(text) if port is self.current else None)
        self._ports.append(port)
        self.added.emit(port)
        return port

    def choose(self, port: Port) -> None:
        """Show this port's module in the pages. What runs on the other one is cancelled, but not its check."""
        if port not in self._ports or port is self.current:
            return
        self.leaving.emit()
        before = self.current
        before.module.cancel_jobs()
        port.stream.is_wanted, before.stream.is_wanted = before.stream.is_wanted, False
        before.set_shown(is_shown=False)
        port.set_shown(is_shown=True)
        self.current = port
        self.chosen.emit()
        self.shown.emit(port.module)
        self.changed.emit()

    def connect_to(self, target: Target) -> None:
        """Open `target` in place of the current port; a port that is open already is chosen."""
        for port in self._ports:
            if port is not self.current and port.is_requested and port.key == target.key:
                self.choose(port)
                if target.finds_rate:
                    port.find_rate()
                return
        self.current.connect_to(target)

    def set_drawing_interval(self, every_s: float = PUBLISH_EVERY_S) -> None:
        """How often the shown page draws the current port."""
        self.current.set_shown(is_shown=True, every_s=every_s)

    def stop(self, deadline_s: float) -> bool:
        """Close all ports and end their workers, within `deadline_s`; whether they ended."""
        self._ticking.stop()
        ends_at = time.monotonic() + deadline_s
        if len(self._ports) > 1:
            for port in self._ports:
                port.disconnect_port()  # all at once; `stop` waits for one after the other
        have_ended = [port.stop(max(0.0, ends_at - time.monotonic())) for port in self._ports]
        return all(have_ended)

    # What happens

    def _tick(self) -> None:
        for port in self._ports:
            port.update_view()  # without a batch, too
        if self.current.is_aging:
            self._on_changed(self.current)

    def _on_changed(self, port: Port) -> None:
        if port is self.current:
            self.changed.emit()
        self.any_changed.emit()

    def _on_module(self, port: Port) -> None:
        if port is self.current:
            self.shown.emit(port.module)
        self._on_changed(port)

    def _on_named(self, port: Port) -> None:
        """The module of this name is here, so what answers on another port is not."""
        for other in self._ports:
            if other is not port and other.module.name == port.module.name != "":
                other.module.say_name("")


class LockControl:
    """The LOCK of the window: it presses LOCK on the port whose module the pages show, or on all."""

    def __init__(self, ports: Ports) -> None:
        self._ports = ports
        # A click on one of these counts also while a menu is open; each with what it does.
        self.buttons: WeakKeyDictionary[QWidget, Callable[[], object]] = WeakKeyDictionary()

    def press(self, _is_checked: bool = False, *, then: Callable[[], object] | None = None) -> None:
        self._ports.current.lock.press(then=then)

    @property
    def others(self) -> list[Port]:
        """Ports that are not shown and whose module is ACTIVE or TRIGGERED, or was when it was last heard, or does not
        report LOCKED."""
        ports = [port for port in self._ports.all if port is not self._ports.current and port.is_requested]
        return [
            port for port in ports if port.is_active or port.lock.is_unproven or port.module.view.reported[0] is True
        ]

    def press_others(self) -> None:
        for port in self.others:
            port.lock.press()

    def press_all(self, _is_checked: bool = False, *, then: Callable[[], object] | None = None) -> None:
        """LOCK on every port, each by itself: none waits for another, and one that is lost owes it. `then` is called
        when all of them report that they are locked."""
        ports = [port for port in self._ports.all if port.is_requested]
        waiting = set(ports)

        def note(port: Port) -> None:
            waiting.discard(port)
            if not waiting and then is not None:
                then()

        for port in ports:
            port.lock.press(then=partial(note, port))
