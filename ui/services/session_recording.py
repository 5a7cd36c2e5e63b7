"""Records every session automatically, from opening a port until it is closed.

A recording is of one unbroken conversation: where it is in doubt which module answers, the next one begins.

The worker's batches go to the recorder from the worker's own thread, so that a window that stalls or closes costs the
recording nothing.
"""

import logging
import threading
from collections.abc import Callable
from datetime import datetime
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from app.engine.worker import Batch, Connection, PortState
from app.text.messages import UserMessage
from ui.core.port_connection import PortConnection

if TYPE_CHECKING:
    # They load numpy, which the window's first paint does not wait for.
    from app.recordings.library import RecordingLibrary
    from app.recordings.recorder import Recorder

_log = logging.getLogger(__name__)


class RecordingState(NamedTuple):
    """State of the running recording as the window shows it. `trouble`: why nothing is written."""

    since: datetime | None = None
    """Aware; None: nothing is being written."""
    dropped: int = 0
    trouble: UserMessage | None = None


class SessionRecording:
    """Of one port."""

    def __init__(self, port: PortConnection, folder: Path | None = None) -> None:
        self._port, self._folder = port, folder
        self._recorder: Recorder | None = None
        """From the first session on."""
        self._lock = threading.Lock()
        self._opening: int | None = None
        """The number of the opening that is recorded."""
        self._is_in_doubt = False
        """It is in doubt which module answers."""
        self._module = ""
        self.path: Path | None = None
        """Of what was recorded last of this conversation; None before the first byte."""
        self._former_path: Path | None = None
        """The recorder still has it while the next file is not begun."""

    @cached_property
    def library(self) -> "RecordingLibrary":
        from app.recordings.library import RecordingLibrary

        return RecordingLibrary(self._folder)

    def recorded(self, deliver: Callable[[Batch], None]) -> Callable[[Batch], None]:
        def both(batch: Batch) -> None:
            try:
                self._on_batch(batch)
            except Exception:  # noqa: BLE001  recording must never end the link
                _log.exception("A batch could not be recorded")
            deliver(batch)

        return both

    @property
    def sign(self) -> RecordingState:
        recorder = self._recorder
        if recorder is None:
            return RecordingState()
        trouble = None if recorder.is_recording else recorder.trouble
        return RecordingState(recorder.started_at, recorder.dropped, trouble)

    def stop(self, deadline_s: float) -> bool:
        """End the recording and its thread; whether that was done in time. What was written before is safe in any
        case."""
        return self._recorder is None or self._recorder.stop(deadline_s)

    def _on_batch(self, batch: Batch) -> None:
        """In the worker's thread."""
        connection, is_in_doubt = batch.connection, not batch.identity.is_settled
        with self._lock:
            if connection.state is PortState.OPEN:
                # Once a person has settled a doubt, what was recorded since it arose is of the module that they named.
                if not self._is_in_doubt and (is_in_doubt or connection.opening != self._opening):
                    self._begin(connection, "" if is_in_doubt else self._module)
                self._opening, self._is_in_doubt = connection.opening, is_in_doubt
            else:
                self._opening, self._is_in_doubt = None, False
            if self._recorder is not None:
                self._recorder.on_batch(batch)
                path = self._recorder.path
                self.path = path if path not in (None, self._former_path) else self.path
                if self._opening is None:
                    self._recorder.end()
            # A recording needs every report, whatever page is shown.
            self._port.stream.is_recorded = self._recorder is not None and self._recorder.is_recording

    def _begin(self, connection: Connection, module: str) -> None:
        from app.recordings.recorder import Recorder

        if self._recorder is None:
            self._recorder = Recorder(self.library)
        self.path, self._former_path = None, self._recorder.path
        self._recorder.begin(connection.port, connection.baud_rate, module)

    def name_module(self, name: str) -> None:
        """Only of the module that is shown, and while it is not in doubt."""
        with self._lock:
            self._module = name
            is_recorded = self._opening == self._port.connection.opening and not self._is_in_doubt
            if name and is_recorded and self._recorder is not None:
                self._recorder.name_module(name)
