"""All actions at the window, by name."""

from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple

from app.safety.acts import Act
from tests.adversary.checking import check
from tests.adversary.window import Session, act, lock, watch, write


class Gestures(NamedTuple):
    make: Callable[[Session], None]
    module: Mapping[str, Any]
    """Options of the module at the start."""


WINDOW: Final[Mapping[str, Gestures]] = {
    "window: watch": Gestures(watch, {}),
    "window: watch active": Gestures(watch, {"active": True}),
    "window: write": Gestures(write, {}),
    "window: lock": Gestures(lock, {"active": True}),
    "window: activate": Gestures(act(Act.ACTIVATE), {}),
    "window: zero": Gestures(act(Act.ZERO), {"tilt": 4.0}),
    "window: preflight": Gestures(check, {}),
    "window: shutdown": Gestures(act(Act.SHUTDOWN), {}),
}
