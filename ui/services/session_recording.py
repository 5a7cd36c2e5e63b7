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

from app.engine.worker import Batch, Connection, PortState, Worker
from app.text.messages import UserMessage
from ui.core.port_connection import MakeWorker, PortConnection

if TYPE_CHECKING:
    # They load numpy, which the window's first paint does not wait for.
    from app.recordings.library import RecordingLibrary
    from app.recordings.recorder import Recorder

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class RecordingState:
    """State of the running recording as the window shows it. `trouble`: why nothing is written."""

    since: datetime | None = None
    """Aware; None: nothing is being written."""
    dropped: int = 0
    trouble: UserMessage | None = None


class SessionRecording:
    """Of one port. `recorded_workers` puts it in front of the window's bridge; `bind` is called once that is made.

    A lost port that comes back continues its session, also under another name; a port that is opened by a person, and
    another module on it, begin a new one.
    """

    def __init__(self, port: PortConnection, folder: Path | None = None) -> None:
        self._port, self._folder = port, folder
        self._recorder: Recorder | None = None
        """From the first session on."""
        self._lock = threading.Lock()
        self._is_open = self._was_lost = False
        """Of the session: its port is open, or was lost and is waited for."""
        self._is_named_on = False
        """The session is that of the module which is named now, not one whose port still closes."""
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
        connection = batch.connection
        with self._lock:
            if connection.state is PortState.OPEN:
                if not (self._is_open or self._was_lost):
                    self._begin(connection)
                self._is_open, self._was_lost = True, False
            elif connection.state is PortState.CLOSED:
                self._was_lost = connection.trouble is not None and (self._is_open or self._was_lost)
                self._is_open = False
            if self._recorder is not None:
                self._recorder.on_batch(batch)
            self._end_if_over()
            # A recording needs every report, whatever page is shown.
            self._port.stream.is_recorded = self._recorder is not None and self._recorder.is_recording

    def _begin(self, connection: Connection) -> None:
        from app.recordings.recorder import Recorder

        if self._recorder is None:
            self._recorder = Recorder(self.library)
        self._recorder.begin(connection.port, connection.baud_rate, self._module)
        self._is_named_on = True

    def _end_if_over(self) -> None:
        if self._recorder is not None and not (self._is_open or self._was_lost):
            self._recorder.end()

    def _on_connection_changed(self) -> None:
        """A lost port that is no longer wanted ends the session."""
        if self._port.is_requested or self._port.is_open:
            return
        with self._lock:
            self._was_lost = False
            self._end_if_over()

    def _on_another_module(self) -> None:
        """A person says that another module answers on the open port, which has a recording of its own, or opens
        another port: the lost one is no longer waited for."""
        with self._lock:
            self._was_lost = self._is_named_on = False
            self._end_if_over()
            if self._port.is_open and self._recorder is not None and self._recorder.is_recording:
                self._module = ""
                self._begin(self._port.connection)

    def name_module(self, name: str) -> None:
        """A recording keeps its name while it is in doubt which module answers."""
        with self._lock:
            self._module = name
            if name and self._is_named_on and self._recorder is not None:
                self._recorder.name_module(name)
