"""Output of -v on standard error: requests and their outcomes; with -vv every frame."""

from app.captures.explain import event_sentence
from app.captures.traffic import entries_of
from app.engine.worker import Batch
from app.terminal.console import notify
from app.text.i18n import tr
from protocol.events import Answered, Event, OutcomeUnknown, Received, Rejected, Sent, Unanswered


class Trace:
    """Prints the events of one connection. Times count from its first batch."""

    def __init__(self, *, has_frames: bool) -> None:
        self._has_frames = has_frames
        self._started_at: float | None = None
        self._connection = ""

    def on_batch(self, batch: Batch) -> None:
        if self._started_at is None:
            self._started_at = min((event.at for event in batch.events), default=batch.at)
        rate = tr("{rate} baud", rate=batch.connection.baud_rate)
        connection = f"{batch.connection.port}  {rate}, {batch.connection.state.value}"
        if connection != self._connection:
            self._connection = connection
            self._print(batch.at, connection)
        for event in batch.events:
            words = _words(event)
            if not isinstance(event, Sent | Received | Rejected):
                if words:
                    self._print(event.at, words)
            elif self._has_frames:
                for entry in entries_of((event,), self._started_at):
                    notify(f"{entry.at_s:9.3f} {entry.way.value} {entry.raw.hex(' ').upper()}  {words}")

    def _print(self, at: float, words: str) -> None:
        notify(f"{max(0.0, at - (self._started_at or at)):9.3f}   {words}")


def _words(event: Event) -> str:
    words = event_sentence(event)
    if isinstance(event, Answered):
        words = "" if event.round_trip_s is None else f"{1000 * event.round_trip_s:.1f} ms"
    elif not isinstance(event, Unanswered | OutcomeUnknown):
        return words
    return f"{tr(event.request.command.title)}  {words}".rstrip()
