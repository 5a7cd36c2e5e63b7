"""Waits for a module, and searches for the baud rate at which one answers.

Both are jobs of the port: they run where no conversation has begun yet. The link itself asks the boot count behind
another question until a module answers, and begins the conversation with that. The answer to a question that was asked
at another rate (a serial server passes on whole bytes) does not pass that fence, so a conversation that begins proves
the rate, and nothing is asked here.
"""

import logging
import re
from enum import Enum
from typing import NamedTuple

from app.engine.procedure import EngineView, Inspect, Pause, Procedure, Report, UseRate
from protocol.catalogue import BAUD_RATES, HOST_HEADER, Layout
from protocol.events import Counters, Role
from protocol.translatable import marked

_log = logging.getLogger(__name__)

# The link's first questions are lost on many lines; the last one has the second that the vendor gives the module.
WAIT_S = 1.5
# At the old and the new rate after a change: enough for a line that loses every other frame.
LIKELY_WAIT_S = 3.0
LOOK_EVERY_S = 0.005
# A heartbeat of MAVLink 1 or 2 (message 0, nine bytes, of which the last is its version, 3), or a message of MSP.
_FLIGHT_CONTROLLER = re.compile(
    rb"\xfe\x09.{3}\x00.{8}\x03|\xfd\x09[\x00\x01]\x00.{3}\x00{3}.{8}\x03|\$M[<>!]|\$X[<>!]\x00", re.DOTALL
)
# By the first byte of a message of MAVLink: the bytes besides its payload, and the place of its number, behind which
# the system's stands.
_MAVLINK = {0xFE: (8, 2), 0xFD: (12, 4)}


class Silence(Enum):
    """The kind of what was received instead of an answer."""

    NOTHING = "nothing"
    GARBAGE = "garbage"  # more invalid bytes than frames: most likely another baud rate
    ECHO = "echo"  # only our own frames
    OTHER_FRAMES = "other frames"  # the module sends but does not answer: its receive line may be open
    FLIGHT_CONTROLLER = "flight controller"  # MAVLink or MSP: a flight controller that passes nothing on


def await_module() -> Procedure[Silence | None]:
    """Wait until a conversation begins; None then, else what came instead."""
    before: EngineView = yield Inspect()
    if (yield from _begins(WAIT_S)) is not None:
        return None
    view: EngineView = yield Inspect()
    return what_came(view.counters - before.counters, view.noise)


def what_came(counters: Counters, noise: bytes = b"") -> Silence:
    """Return what came instead of an answer. `noise` are the last invalid bytes, in which an echo may be damaged."""
    echoes = counters.by_role[Role.ECHO]
    frames = counters.frames - echoes
    # A glimpse of a frame amid more invalid bytes is accidental.
    if frames * Layout.STATUS.value > counters.rejected:
        return Silence.OTHER_FRAMES
    if counters.rejected and _is_of_flight_controller(noise):
        return Silence.FLIGHT_CONTROLLER
    if counters.rejected and (frames or HOST_HEADER not in noise):
        return Silence.GARBAGE
    return Silence.ECHO if echoes or counters.rejected else Silence.NOTHING


def _is_of_flight_controller(noise: bytes) -> bool:
    """Whether these bytes are MAVLink or MSP: a message that is known, or two of MAVLink in a row from one system."""
    if _FLIGHT_CONTROLLER.search(noise) is not None:
        return True
    for start, magic in enumerate(noise[:-1]):
        if magic in _MAVLINK:
            around, number = _MAVLINK[magic]
            following = noise[start + around + noise[start + 1] :][: number + 2]
            if len(following) == number + 2 and following[0] == magic:
                is_next = following[number] == (noise[start + number] + 1) % 256
                if is_next and following[number + 1] == noise[start + number + 1]:
                    return True
    return False


class RateSearch(NamedTuple):
    """`baud_rate`: None if nothing answered."""

    baud_rate: int | None
    tried: tuple[int, ...]


def find_rate(first: int | None = None, old: int | None = None) -> Procedure[RateSearch]:
    """Try `first`, then all rates from the fastest down. The port stays at the first that answers, else at the one it
    has. `old`: the module was told to change from this one to `first`."""
    view: EngineView = yield Inspect()
    likely = [first] if old is None else [first, old]
    likely_s = WAIT_S if old is None else LIKELY_WAIT_S
    waits_s = {rate: likely_s for rate in likely if rate is not None}
    waits_s |= {rate: WAIT_S for rate in BAUD_RATES if rate not in waits_s}
    if not view.sets_rate:
        waits_s = {view.baud_rate: WAIT_S}  # somebody else sets it, at the other end of the socket
    tried: list[int] = []
    for rate, wait_s in waits_s.items():
        yield Report(len(tried), len(waits_s), marked("Trying {rate} baud"), (("rate", rate),))
        tried.append(rate)
        found = yield from _begins(wait_s, at=rate if view.sets_rate else None)
        _log.debug("at %d baud: %s", rate, found)
        if found is not None:
            return RateSearch(found, tuple(tried))
    if view.sets_rate:
        yield UseRate(view.baud_rate)
    return RateSearch(None, tuple(tried))


def _begins(limit_s: float, *, at: int | None = None) -> Procedure[int | None]:
    """The rate of the conversation that goes on, or begins within the limit. `at`: the rate to try; LOCK, which may
    come between, may have tried another one."""
    if at is not None:
        yield UseRate(at)
    view: EngineView = yield Inspect()
    ends_at = view.now + limit_s
    while not view.conversation.is_going and view.now < ends_at:
        yield Pause(min(LOOK_EVERY_S, ends_at - view.now))
        view = yield Inspect()
        if at is not None and view.baud_rate != at and not view.conversation.is_going:
            yield UseRate(at)
    return view.baud_rate if view.conversation.is_going else None
