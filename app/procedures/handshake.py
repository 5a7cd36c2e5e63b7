"""Detects whether a module answers, and what is received if none does."""

from enum import Enum

from app.engine.procedure import Ask, EngineView, Inspect, Procedure
from protocol.catalogue import HEARTBEAT, HOST_HEADER, Layout
from protocol.events import Answered, Counters, Role

HANDSHAKE_WAITS_S = (0.5, 1.0)
"""Two heartbeats, the second with the vendor's full second."""


class Silence(Enum):
    """What was received instead of an answer."""

    NOTHING = "nothing"
    GARBAGE = "garbage"
    """More invalid bytes than frames: most likely another baud rate."""
    ECHO = "echo"
    """Only our own frames."""
    OTHER_FRAMES = "other frames"
    """The module sends but does not answer: its receive line may be open."""


def handshake() -> Procedure[Silence | None]:
    """What came instead of an answer; None if the module answered."""
    before: EngineView = yield Inspect()
    if isinstance((yield Ask(HEARTBEAT.query(), HANDSHAKE_WAITS_S)), Answered):
        return None
    after: EngineView = yield Inspect()
    return what_came(after.link.counters - before.link.counters)


def what_came(counters: Counters, noise: bytes = b"") -> Silence:
    """What came instead of an answer. A glimpse of a frame amid more invalid bytes is accidental. `noise`: the last
    invalid bytes, in which an echo may be damaged."""
    echoes = counters.by_role[Role.ECHO]
    frames = counters.frames - echoes
    if frames * Layout.STATUS.value > counters.rejected:
        return Silence.OTHER_FRAMES
    if counters.rejected and (frames or HOST_HEADER not in noise):
        return Silence.GARBAGE
    return Silence.ECHO if echoes or counters.rejected else Silence.NOTHING
