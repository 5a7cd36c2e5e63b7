"""Guards ports that play a capture: they answer queries; nothing is written to them or judged from them.

The session refuses every request that is no question. Procedures that change a module or judge it begin with
`require_module`: they refuse before anything is asked, written down or judged.
"""

from typing import Protocol

from app.engine.procedure import EngineView, Inspect, Procedure
from app.text.i18n import tr
from protocol.catalogue import SERIAL_OUTPUT, Request
from protocol.events import Unanswered

SCHEME = "capture://"
"""Of the URL of a port on which a capture is played; `app.captures.player` reads the rest of it."""


class OnlyPlayedBack(Exception):
    """Something was asked of a module, and a capture is played in its place."""

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
    """What the session does with a request that is no question, where a capture is played or it may be another module:
    it is never sent. Whoever wants the stream goes on by polling."""
    if request.command is SERIAL_OUTPUT or not is_playback:
        run.resume(Unanswered(request, 0, 0.0, now), now)
    else:
        run.throw(OnlyPlayedBack(), now)


def require_module() -> Procedure[None]:
    """Raises `OnlyPlayedBack` where a capture is played."""
    sight: EngineView = yield Inspect()
    if sight.is_playback:
        raise OnlyPlayedBack
