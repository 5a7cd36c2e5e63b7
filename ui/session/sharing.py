"""The sharing of one port over TCP, as long as a person has it switched on and the port is open."""

import logging
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QObject, QTimer, Signal

from app.engine.target import host_and_port
from app.engine.worker import Batch, PortState
from app.procedures.lock import Locked
from app.text.i18n import tr
from app.text.messages import error_text, labelled
from ui.style.theme import Meaning

if TYPE_CHECKING:  # it is imported when it is first switched on
    from app.sharing import Event, Sharing
    from ui.session.port import Port

_log = logging.getLogger(__name__)
# How long a reader's question waits before it is looked at.
TURN_EVERY_MS: Final = 20


class PortSharing(QObject):
    """It shares the port: what readers ask is asked in the window's thread as what the window itself asks; their LOCK
    is the window's."""

    changed = Signal()

    def __init__(self, port: "Port") -> None:
        super().__init__(port)
        self._port = port
        self._sharing: Sharing | None = None
        self._opening = 0
        self._send_result: Callable[[Locked], None] | None = None
        # What readers open; "" while the port is not shared.
        self.address = ""
        # What was said last, and how grave it is.
        self.last = ""
        self.meaning = Meaning.INFORMATION
        self._turning = QTimer(self, interval=TURN_EVERY_MS)
        self._turning.timeout.connect(self._turn)
        port.batch.connect(self._on_batch)
        port.lock.changed.connect(self._on_lock)

    @property
    def readers(self) -> int:
        return 0 if self._sharing is None else len(self._sharing.readers)

    def start(self, address: str) -> None:
        """Let readers connect at "HOST:PORT"."""
        from app.sharing import Sharing, listen_at

        self.stop()
        try:
            listener, address, warning = listen_at(*host_and_port(address))
        except ValueError:
            self._say(Meaning.ATTENTION, tr("An address is HOST:PORT, such as 127.0.0.1:7001."))
            return
        except OSError as error:
            self._say(Meaning.ATTENTION, labelled(address, error_text(error)))
            return
        self._sharing = Sharing(listener, self._port.submit, self._send_lock, self._tell)
        self._opening = self._port.connection.opening
        self.address = address
        self._turning.start()
        self._say(Meaning.ATTENTION if warning else Meaning.INFORMATION, warning)

    def stop(self) -> None:
        """Hang up; nobody connects any more."""
        if self._sharing is not None:
            self._turning.stop()
            self._sharing.close()
            self._sharing = self._send_result = None
            self.address = ""
            self._say(Meaning.INFORMATION, "")

    def _turn(self) -> None:
        if self._sharing is not None:
            self._sharing.turn(0.0)

    def _on_batch(self, batch: Batch) -> None:
        if self._sharing is None:
            return
        if batch.connection.state is PortState.OPEN and batch.connection.opening == self._opening:
            self._sharing.take_in(batch)
        else:
            self.stop()

    def _send_lock(self, then: Callable[[Locked], None]) -> None:
        self._send_result = then
        if not self._port.lock.is_repeating:
            self._port.lock.press()

    def _on_lock(self) -> None:
        """The window's LOCK has come to an end."""
        lock, then = self._port.lock, self._send_result
        done = lock.confirmed or lock.failed
        if then is not None and done is not None and not lock.is_repeating:
            self._send_result = None
            then(done)

    def _tell(self, event: "Event", reader: str, sentence: str) -> None:
        _log.info("Sharing: %s %s %s", event, reader, sentence)
        if sentence:
            meaning = Meaning.INFORMATION if event == "locked" else Meaning.ATTENTION
            self._say(meaning, labelled(reader, sentence) if reader else sentence)
        else:
            self.changed.emit()

    def _say(self, meaning: Meaning, text: str) -> None:
        self.meaning, self.last = meaning, text
        self.changed.emit()
