"""Records every session automatically, from opening a port until it is closed.

The worker's batches go to the recorder from the worker's own thread, so that a window that stalls or closes costs the
recording nothing.
"""

import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from app.engine.target import Target
from app.engine.worker import Batch, Connection, PortState, Worker
from app.text.messages import UserMessage
from ui.core.port_connection import MakeWorker, PortConnection

if TYPE_CHECKING:
    # They load numpy, which the window's first paint does not wait for.
    from app.recordings.library import RecordingLibrary
    from app.recordings.recorder import Recorder

_log = logging.getLogger(__name__)


class SessionTracker:
    """Finds where one session ends and the next begins, from batch to batch.

    A lost port that comes back continues its session, also under another name; a port that was closed by a person, or
    another adapter, begins a new one.
    """

    def __init__(self) -> None:
        self._key = ""
        self._is_open = False
        self._was_lost = False

    @property
    def is_over(self) -> bool:
        """No port is open, and no lost port is waited for."""
        return not self._is_open and not self._was_lost

    def begins(self, connection: Connection, target: Target | None) -> bool:
        """Whether a session begins with a batch of this connection. `target` tells the adapter behind the port."""
        if connection.state is PortState.CLOSED:
            self._was_lost = connection.trouble is not None and (self._is_open or self._was_lost)
            self._is_open = False
        if connection.state is not PortState.OPEN:
            return False
        key = _key_of(connection.port, target)
        goes_on = (self._is_open or self._was_lost) and key == self._key
        self._key, self._is_open, self._was_lost = key, True, False
        return not goes_on

    def is_of(self, target: Target | None) -> bool:
        """This target is the one of the session."""
        return target is not None and self._key == target.key

    def end(self) -> None:
        """Nobody waits for the lost port any more."""
        self._was_lost = False


def _key_of(port: str, target: Target | None) -> str:
    """The key of the target, unless another one has been chosen meanwhile."""
    return target.key if target is not None and target.device == port else port


@dataclass(frozen=True, slots=True)
class RecordingState:
    """State of the running recording as the window shows it. `trouble`: why nothing is written."""

    since: datetime | None = None
    """Aware; None: nothing is being written."""
    dropped: int = 0
    trouble: UserMessage | None = None


class SessionRecording:
    """Of one port. `recorded_workers` puts it in front of the window's bridge; `bind` is called once that is made."""

    def __init__(self, port: PortConnection, folder: Path | None = None) -> None:
        self._port, self._folder = port, folder
        self._recorder: Recorder | None = None
        """From the first session on."""
        self._session = SessionTracker()
        self._lock = threading.Lock()
        self._module = ""
        """The name of the module that is connected."""

    @cached_property
    def library(self) -> "RecordingLibrary":
        from app.recordings.library import RecordingLibrary

        return RecordingLibrary(self._folder)

    def recorded_workers(self, make: MakeWorker = Worker) -> MakeWorker:
        """Makes workers whose batches are recorded before they are handed on."""

        def made(deliver: Callable[[Batch], None]) -> Worker:
            def both(batch: Batch) -> None:
                try:
                    self._on_batch(batch)
                except Exception:  # noqa: BLE001  recording must never end the link
                    _log.exception("A batch could not be recorded")
                deliver(batch)

            return make(both)

        return made

    def bind(self) -> None:
        """Follow the connection: its adapter, and when a person closes its port."""
        self._port.changed.connect(self._on_connection_changed)
        self._port.invalidated.connect(self._on_another_module)

    @property
    def sign(self) -> RecordingState:
        """State of the recording."""
        recorder = self._recorder
        if recorder is None:
            return RecordingState()
        trouble = None if recorder.is_recording else recorder.trouble
        return RecordingState(recorder.started_at, recorder.dropped, trouble)

    def settle(self, deadline_s: float) -> bool:
        """Wait until all batches are on disk; whether that was so within the time."""
        return self._recorder is None or self._recorder.settle(deadline_s)

    def stop(self, deadline_s: float) -> bool:
        """End the recording and its thread; whether that was done in time. What was written before is safe in any
        case."""
        return self._recorder is None or self._recorder.stop(deadline_s)

    def _on_batch(self, batch: Batch) -> None:
        """In the worker's thread."""
        with self._lock:
            if self._session.begins(batch.connection, self._port.target):
                self._begin(batch.connection)
            if self._recorder is not None:
                self._recorder.on_batch(batch)
            if self._session.is_over:
                self._end()
            # A recording needs every report, whatever page is shown.
            self._port.stream.is_recorded = self._recorder is not None and self._recorder.is_recording

    def _begin(self, connection: Connection) -> None:
        from app.recordings.recorder import Recorder

        if self._recorder is None:
            self._recorder = Recorder(self.library)
        self._recorder.begin(connection.port, connection.baud_rate, self._module)

    def _end(self) -> None:
        if self._recorder is not None:
            self._recorder.end()

    def _on_connection_changed(self) -> None:
        """A lost port that is no longer wanted ends the session."""
        if self._port.is_requested or self._port.is_open:
            return
        with self._lock:
            self._session.end()
            if self._session.is_over:
                self._end()

    def _on_another_module(self) -> None:
        """A person says that another module answers on the open port: it has a recording of its own."""
        with self._lock:
            if self._port.is_open and self._recorder is not None and self._recorder.is_recording:
                self._module = ""
                self._begin(self._port.connection)

    def name_module(self, name: str) -> None:
        """The name belongs to the adapter chosen now, which may differ from the one still being closed. A recording
        keeps its name while it is in doubt which module answers."""
        with self._lock:
            self._module = name
            if name and self._session.is_of(self._port.target) and self._recorder is not None:
                self._recorder.name_module(name)
