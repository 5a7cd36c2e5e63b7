"""The recording of one port: each opening of it is one file, unless a person has switched the recording off."""

import logging
import threading
from collections.abc import Callable
from datetime import datetime
from typing import TYPE_CHECKING, NamedTuple

from app.engine.conversation import ConversationView
from app.engine.worker import Batch, PortState
from app.procedures.stream import StreamSwitch
from app.text.messages import UserMessage

if TYPE_CHECKING:  # they load numpy, which the window's first paint does not wait for
    from app.recordings.library import RecordingLibrary
    from app.recordings.recorder import Recorder

_log = logging.getLogger(__name__)


class RecordingState(NamedTuple):
    """The state of recording, as the window shows it."""

    is_on: bool = True
    # Aware; None: nothing is being written.
    since: datetime | None = None
    # Why nothing is written.
    trouble: UserMessage | None = None


class SessionRecording:
    """The worker's batches go to the recorder from the worker's own thread, so that a window that stalls or closes
    costs the recording nothing."""

    def __init__(self, stream: StreamSwitch, find_library: "Callable[[], RecordingLibrary]") -> None:
        """`stream`: a recording needs every report, whatever page is shown."""
        self._stream, self._find_library = stream, find_library
        # What a person wants; the worker's thread follows with its next batch.
        self.is_on = True
        self._lock = threading.Lock()
        # The present recording, or the last one, and the number of the opening that is recorded.
        self._recorder: Recorder | None = None
        self._opening: int | None = None
        # The name that was said last, and in which conversation: one that is switched on later has it, too.
        self._named: tuple[str, ConversationView] | None = None
        self._is_stopped = False

    def recorded(self, deliver: Callable[[Batch], None]) -> Callable[[Batch], None]:
        def both(batch: Batch) -> None:
            try:
                self._on_batch(batch)
            except Exception:  # noqa: BLE001  recording must never end the link
                _log.exception("A batch could not be recorded")
            deliver(batch)

        return both

    @property
    def state(self) -> RecordingState:
        recorder = self._recorder
        if recorder is None or not self.is_on:
            return RecordingState(self.is_on)
        return RecordingState(True, recorder.started_at, recorder.trouble)

    def name_module(self, name: str, conversation: ConversationView) -> None:
        """A person said which module it is in this conversation."""
        self._named = name, conversation
        if self._recorder is not None:
            self._recorder.name_module(name, conversation)

    def stop(self, deadline_s: float) -> bool:
        """Ends the recording and its thread; whether that was done in time. What was written before is safe in any
        case."""
        with self._lock:
            self._is_stopped = True
            recorder = self._recorder
        return recorder is None or recorder.stop(deadline_s)

    def _on_batch(self, batch: Batch) -> None:
        """In the worker's thread."""
        connection = batch.connection
        is_wanted = self.is_on and connection.state is PortState.OPEN
        with self._lock:
            if is_wanted and connection.opening != self._opening and not self._is_stopped:
                self._begin(batch)
            recorder = self._recorder
            if recorder is not None:
                if self.is_on:  # also the last batch of a port that is closed
                    recorder.on_batch(batch)
                if not is_wanted:
                    self._opening = None
                    recorder.end()
            self._stream.is_recorded = recorder is not None and recorder.is_recording

    def _begin(self, batch: Batch) -> None:
        from app.recordings.recorder import Recorder

        connection, former = batch.connection, self._recorder
        if former is not None:
            former.end()
        self._opening = connection.opening
        recorder = Recorder(self._find_library(), connection.port, connection.baud_rate)
        self._recorder = recorder
        if self._named is not None and self._named[1].number == batch.conversation.number:
            recorder.name_module(*self._named)
