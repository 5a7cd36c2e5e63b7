"""Polls the list of ports in a background thread: listing can take seconds (Bluetooth ports)."""

import logging
from collections.abc import Callable, Iterable
from threading import Thread

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from app.engine.ports import PortInfo, PortsUnknown, list_ports

_log = logging.getLogger(__name__)

POLL_EVERY_MS = 1500
LOOK_LIMIT_S = 3.0


def key_of(port: PortInfo) -> str:
    """The adapter's identity, or the port's name where it has none."""
    return port.identity or port.device


class PortWatcher(QObject):
    """Lists the ports once with `refresh`, or over and over while `is_watching`.

    `new` are the ports that were not there at the last look: those missing from what `settle` last took as seen.
    """

    listed = Signal()
    """After each look, whether or not something changed; in the window's thread."""
    _arrived = Signal(object)

    def __init__(self, look: Callable[[float], Iterable[PortInfo]] = list_ports) -> None:
        super().__init__()
        self._look = look
        self._thread: Thread | None = None
        self._ports: tuple[PortInfo, ...] | None = None
        self.is_current = False
        """`ports` is the result of the last look; else of an earlier one."""
        self._seen: frozenset[str] | None = None
        self._timer = QTimer(self, interval=POLL_EVERY_MS)
        self._timer.timeout.connect(self.refresh)
        self._arrived.connect(self._on_listed, Qt.ConnectionType.QueuedConnection)

    @property
    def has_listed(self) -> bool:
        return self._ports is not None

    @property
    def ports(self) -> tuple[PortInfo, ...]:
        return self._ports or ()

    @property
    def seen(self) -> frozenset[str]:
        """Keys of all ports that are no longer new."""
        return self._seen or frozenset()

    def is_new(self, port: PortInfo) -> bool:
        return self._seen is not None and key_of(port) not in self._seen

    def remember_seen(self, keys: Iterable[str]) -> None:
        """Take over the keys seen in an earlier session. Without any, no port is new at the first look."""
        known = frozenset(keys)
        if known:
            self._seen = known

    def settle(self) -> None:
        """The person has seen the list: its ports are no longer new."""
        if self._ports is not None:
            self._seen = self.seen | {key_of(port) for port in self._ports}

    def watch(self, is_watching: bool) -> None:
        if is_watching and not self._timer.isActive():
            self.refresh()
            self._timer.start()
        elif not is_watching:
            self._timer.stop()

    def refresh(self) -> bool:
        """Look now; returns False, and does nothing, while a look is running."""
        if self._thread is not None:
            return False
        self._thread = Thread(target=self._run, name="dps-s port list", daemon=True)
        self._thread.start()
        return True

    def stop(self, deadline_s: float) -> bool:
        """Stop looking; whether the running look ended within `deadline_s`."""
        self._timer.stop()
        thread = self._thread
        if thread is None:
            return True
        thread.join(deadline_s)
        return not thread.is_alive()

    def _run(self) -> None:
        try:
            found: tuple[PortInfo, ...] | None = tuple(self._look(LOOK_LIMIT_S))
        except PortsUnknown:
            _log.warning("The ports could not be listed within %s s", LOOK_LIMIT_S)
            found = None
        except Exception:  # noqa: BLE001  a driver may fail in any way; the window works without the list
            _log.exception("The ports could not be listed")
            found = None
        try:
            self._arrived.emit(found)
        except RuntimeError:  # the window was closed meanwhile, and this object deleted
            _log.debug("A list of ports came after the window had closed")

    def _on_listed(self, found: tuple[PortInfo, ...] | None) -> None:
        if self._thread is not None:
            self._thread.join()  # it has emitted and is about to end
            self._thread = None
        self.is_current = found is not None
        if found is not None:
            self._ports = found
            if self._seen is None:
                self._seen = frozenset(key_of(port) for port in found)
        elif self._ports is None:
            self._ports = ()
        self.listed.emit()
