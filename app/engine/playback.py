"""Guards ports that play a capture: they answer questions, but there is no module to change or to check.

The session refuses every request that is not a question. Procedures that change or check a module begin with
`require_module`.
"""

from app.engine.procedure import EngineView, Inspect, Procedure
from app.text.i18n import tr

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


def require_module() -> Procedure[None]:
    """Raise `OnlyPlayedBack` during playback."""
    sight: EngineView = yield Inspect()
    if sight.is_playback:
        raise OnlyPlayedBack
