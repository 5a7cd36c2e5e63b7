"""Output of -v on standard error: requests and their outcomes; with -vv every frame."""

from app.captures.entries import entries_of
from app.captures.explain import sentence
from app.captures.explained import Explainer
from app.engine.worker import Batch, PortState
from app.terminal.console import notify
from app.text.i18n import tr
from protocol.events import Answered, Event, OutcomeUnknown, Restarted, Unanswered, WentOffline, WentOnline


class Trace:
    """Prints the events of one connection. Times count from the opening of the port."""

    def __init__(self, *, has_frames: bool) -> None:
        self._has_frames = has_frames
        self._explainer = Explainer()
        self._started_at: float | None = None
        self._state: tuple[PortState, int] = (PortState.CLOSED, 0)

    def on_batch(self, batch: Batch) -> None:
        connection = batch.connection
        if self._started_at is None:
            self._started_at = min((event.at for event in batch.events), default=batch.at)
        state = connection.state, connection.baud_rate
        if state != self._state:
            self._state = state
            if connection.state is PortState.OPEN:
                self._print(batch.at, f"{connection.port}  {tr('{rate} baud', rate=connection.baud_rate)}")
            elif connection.state is PortState.CLOSED:
                self._print(batch.at, f"{connection.port}  –")
        for event in batch.events:
            for entry in entries_of((event,), self._started_at) if self._has_frames else ():
                for row in self._explainer.feed(entry):
                    raw = row.piece.raw.hex(" ").upper()
                    notify(f"{row.at_s:9.3f} {row.way.value} {raw}  {sentence(row.piece, row.asked)}")
            words = _words(event)
            if words is not None:
                self._print(event.at, words)

    def _print(self, at: float, words: str) -> None:
        notify(f"{max(0.0, at - (self._started_at or at)):9.3f}   {words}")


def _words(event: Event) -> str | None:
    match event:
        case Answered(request=request, round_trip_s=seconds):
            words = "" if seconds is None else f"{1000 * seconds:.1f} ms"
        case Unanswered(request=request, attempts=attempts):
            words = f"{tr('no reply')} × {attempts}"
        case OutcomeUnknown(request=request):
            words = tr("no reply; may have been carried out")
        case Restarted():
            return tr("the module restarted")
        case WentOnline():
            return tr("the module answers")
        case WentOffline():
            return tr("The module does not answer.")
        case _:
            return None
    return f"{tr(request.command.title)}  {words}".rstrip()
