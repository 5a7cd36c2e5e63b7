"""Guards ports that play a capture: they answer questions, but there is no module to change or to check.

The session refuses every request that is not a question. Procedures that change or check a module begin with
`require_module`.
"""

from typing import Protocol

from app.engine.procedure import EngineView, Inspect, Procedure
from app.text.i18n import tr
from protocol.catalogue import SERIAL_OUTPUT, Request
from protocol.events import Unanswered

SCHEME = "capture://"
"""The URL scheme of a port that plays a capture; `app.captures.player` reads the rest of the URL."""


class OnlyPlayedBack(Exception):
    """A capture is played, and the request needs a module."""

    def __init__(self) -> None:
        super().__init__("a capture is played; there is no module")

    @property
    def sentence(self) -> str:
        """In the language in use now."""
        return tr("A capture is played here: it answers questions, but there is no module to change or to check.")


def is_playback(port: str) -> bool:
    """`port` plays a capture."""
    return port.lower().startswith(SCHEME)


class _Run(Protocol):
    def resume(self, value: object, now: float) -> None: ...
    def throw(self, reason: Exception, now: float) -> None: ...


def refuse_change(run: _Run, request: Request, now: float, *, is_playback: bool = True) -> None:
    """Refuse a request that is not a question, during playback or with a module of unproven identity. A procedure that
    wanted the stream continues by polling."""
    if request.command is SERIAL_OUTPUT or not is_playback:
        run.resume(Unanswered(request, 0, 0.0, now), now)
    else:
        run.throw(OnlyPlayedBack(), now)


def require_module() -> Procedure[None]:
    """Raise `OnlyPlayedBack` during playback."""
    sight: EngineView = yield Inspect()
    if sight.is_playback:
        raise OnlyPlayedBack
