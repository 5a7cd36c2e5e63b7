"""What holds while a capture is played: there is no module, so nothing that changes one is ever asked."""

from app.procedure import Ask, Procedure, Result
from protocol.events import Unanswered

SCHEME = "capture://"
"""Of the URL of a port on which a capture is played; `app.replay` reads the rest of it."""


def is_recording(port: str) -> bool:
    """`port` plays a capture."""
    return port.startswith(SCHEME)


def questions_only(procedure: Procedure[Result]) -> Procedure[Result]:
    """`procedure`, but of what it asks only questions go out; anything else is at once "unanswered, never sent".

    Cancelling and a lost port reach it as they do without this.
    """
    value: object = None
    error: Exception | None = None
    last_s = 0.0
    while True:
        try:
            want = procedure.send(value) if error is None else procedure.throw(error)
        except StopIteration as stop:
            result: Result = stop.value
            return result
        value, error = None, None
        if isinstance(want, Ask) and not want.request.is_repeatable:
            value = Unanswered(want.request, 0, 0.0, last_s)
            continue
        try:
            value = yield want
        except Exception as thrown:  # noqa: BLE001  whatever it is, it is meant for the procedure inside
            error = thrown
        last_s = value if isinstance(value, float) else getattr(value, "at", getattr(value, "now", last_s))
