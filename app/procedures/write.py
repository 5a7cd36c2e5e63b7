"""Writes one setting and verifies it by reading back.

    set, once  ->  acknowledgement (E2: "received")  ->  read back, until two answers in a row agree  ->  `Written`

Only the read-back says what stands; `write_all` reads it once more at the end. Two answers, because the 8-bit sum lets
about 6 % of two-bit errors pass: one bad frame must not turn a lost write into a verified one. An unanswered set is not
sent again; the read-back tells what became of it. Whatever cannot be read back (E8) is never verified, only
acknowledged.
"""

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from app.engine.procedure import Ask, EngineView, Inspect, Pause, Procedure
from protocol.catalogue import Command
from protocol.events import Answered, Outcome, Role, Unanswered
from protocol.fields import Value
from protocol.messages import Acknowledgement, Reading
from protocol.translatable import marked

READS_AT_MOST = 4
RESTART_SHOWS_S = 0.4
"""A restart's second heartbeat, or the decision that its twin was lost, comes within this time."""
_ODD = (Role.UNASKED, Role.DOUBLED, Role.LATE)
"""What a restart's first heartbeat may be taken for, where the link had just asked for one."""


class Heard(Enum):
    """What the module answered to the set."""

    ECHO = "echo"
    """The value that was sent."""
    ONE = "one"
    """01, "understood" (E2)."""
    OTHER = "other"
    """Another value."""
    NOTHING = "nothing"
    NOT_SENT = "not sent"
    """The module had stopped answering before; the set never went out."""
    UNNEEDED = "unneeded"
    """It holds the value already: nothing was sent."""


class WriteFault(Enum):
    """Why a write is not what was wanted; the value is its English, translatable text."""

    REFUSED = marked("refused; the old value stands")
    CLAMPED = marked("the module holds another value")
    NOT_KEPT = marked("acknowledged, but not kept")
    LOST = marked("no reply, not set")
    NO_REPLY = marked("no reply; may have been carried out")
    NO_READ_BACK = marked("could not be read back")
    UNSTEADY = marked("contradictory answers")
    RESTARTED = marked("the module restarted")
    REVERTED = marked("the module changed it by itself later")
    NO_LAST_READING = marked("not read again")
    NOT_SENT = marked("not sent: the module stopped answering")
    NOT_ALLOWED = marked("not sent: a condition is not met")
    AT_RESTART = marked("acknowledged, still at the old rate: restart the module")
    UNCHANGED = marked("still at the old rate")
    PORT_LOST = marked("port lost; may have been carried out")
    PORT_LOST_BEFORE = marked("not sent: the port was lost")
    MODULE_LOST = marked("no answer at any rate")


@dataclass(frozen=True, slots=True, kw_only=True)
class Written:
    """What became of one write. Values are in the field's unit."""

    command: Command
    wanted: Value
    heard: Heard
    acknowledged: Value | None = None
    """The value in the acknowledgement where that is another than the one sent."""
    stands: Value | None = None
    """Read back; None where it was not, or cannot be."""
    verified: bool | None = None
    """True only when the module said twice in a row that it holds what was wanted; None where it cannot be asked.
    Final only in a `WriteReport`: there it was read once more after the module had time to change its mind."""
    fault: WriteFault | None = None
    waited_s: float | None = None
    """How long an answer to the set was waited for in vain."""

    @property
    def is_acknowledged(self) -> bool:
        return self.heard in (Heard.ECHO, Heard.ONE)

    @property
    def is_fine(self) -> bool:
        """Verified, or where there is no read-back acknowledged, and nothing speaks against it."""
        return self.fault is None


class ReadBack(NamedTuple):
    """`raw`: the byte that two answers in a row agreed on."""

    raw: int | None = None
    is_unsteady: bool = False


def read_back(command: Command) -> Procedure[ReadBack]:
    """Ask until two answers in a row agree."""
    last: int | None = None
    for _ in range(READS_AT_MOST):
        outcome = yield Ask(command.query())
        if not isinstance(outcome, Answered):
            return ReadBack()
        reading = outcome.messages[0]
        if not isinstance(reading, Reading):
            return ReadBack()
        if reading.raw == last:
            return ReadBack(last)
        last = reading.raw
    return ReadBack(is_unsteady=True)


class Acknowledged(NamedTuple):
    heard: Heard
    other: int | None = None
    """The byte with `Heard.OTHER`."""
    waited_s: float | None = None


def write_verified(command: Command, value: Value) -> Procedure[Written]:
    """Write one setting that changes nothing about the link; for the baud rate see `change_baud`.

    Raises `ValueRefused` or `LookupError` before anything is sent. Whether writing is allowed is `write_all`'s to ask.
    """
    request = command.set(value)
    old = yield from _old_value(command)
    before: EngineView = yield Inspect()
    said = acknowledged((yield Ask(request)))
    if said.heard is Heard.NOT_SENT:
        verdict = False if command.reads_back else None
        return Written(command=command, wanted=value, heard=said.heard, verified=verdict, fault=WriteFault.NOT_SENT)
    back = ReadBack()
    if command.reads_back:
        back = yield from read_back(command)
    has_restarted = yield from restarted_since(before)
    fault = WriteFault.RESTARTED if has_restarted else _fault(command, command.set(value).data, said, back, old=old)
    return Written(
        command=command,
        wanted=value,
        heard=said.heard,
        acknowledged=None if said.other is None else _value(command, said.other),
        stands=None if back.raw is None or has_restarted else _value(command, back.raw),
        verified=fault is None if command.reads_back else None,
        fault=fault,
        waited_s=said.waited_s,
    )


def _old_value(command: Command) -> Procedure[int | None]:
    """The byte that stands before the write, which tells "refused" from "clamped"; None where nobody knows."""
    if not command.reads_back or command.write is None:
        return None
    sight: EngineView = yield Inspect()
    known = sight.device.fresh(command.key, sight.now)
    if known is not None:
        return command.write.encode(known)
    outcome = yield Ask(command.query())
    reading = outcome.messages[0] if isinstance(outcome, Answered) else None
    return reading.raw if isinstance(reading, Reading) else None


def acknowledged(outcome: Outcome) -> Acknowledged:
    """What the answer to a set says."""
    if isinstance(outcome, Unanswered):
        return Acknowledged(Heard.NOT_SENT)
    message = outcome.messages[0] if isinstance(outcome, Answered) else None
    if not isinstance(message, Acknowledgement):
        return Acknowledged(Heard.NOTHING, waited_s=None if isinstance(outcome, Answered) else outcome.waited_s)
    if message.is_echo:
        return Acknowledged(Heard.ECHO)
    return Acknowledged(Heard.ONE) if message.is_accepted else Acknowledged(Heard.OTHER, message.raw)


def restarted_since(before: EngineView) -> Procedure[bool]:
    """Whether the module restarted since; a frame too many may be the first sign of it."""
    after: EngineView = yield Inspect()
    old, new = before.link.counters.by_role, after.link.counters.by_role
    if any(new[role] != old[role] for role in _ODD):
        yield Pause(RESTART_SHOWS_S)
        after = yield Inspect()
    return after.device.restarts != before.device.restarts


def _fault(command: Command, wanted: int, said: Acknowledged, back: ReadBack, *, old: int | None) -> WriteFault | None:
    if not command.reads_back:
        return {Heard.NOTHING: WriteFault.NO_REPLY, Heard.OTHER: WriteFault.REFUSED}.get(said.heard)
    if back.raw is None:
        return WriteFault.UNSTEADY if back.is_unsteady else WriteFault.NO_READ_BACK
    if back.raw == wanted:
        return None
    if old is not None and back.raw != old:
        return WriteFault.CLAMPED
    match said.heard:
        case Heard.NOTHING:
            return WriteFault.LOST
        case Heard.OTHER:
            return WriteFault.REFUSED if old is not None or said.other == 0x00 else WriteFault.CLAMPED
        case _:
            return WriteFault.NOT_KEPT


def _value(command: Command, raw: int) -> Value | None:
    """In the field's unit; None for a byte that the field does not know."""
    return command.write.decode(raw) if command.write is not None and raw in command.write.allowed else None
