"""Writes one setting and verifies it by reading back.

    set, once  ->  acknowledgement (E2: "received")  ->  read back, until two answers in a row agree  ->  `Written`

Only the read-back proves the value; `write_all` reads it once more at the end. Two answers have to agree, because the
8-bit sum misses about 6 % of two-bit errors: one bad frame must not turn a lost write into a verified one. An
unanswered set is not repeated; the read-back shows its result. A setting that cannot be read back (E8) is never
verified, only acknowledged; of the two triggers even that is known only later (`protocol.flag_answers`).
"""

from enum import Enum
from typing import NamedTuple

from app.engine.procedure import Ask, EngineView, Inspect, Procedure, Report, ask_report, ask_value, pause_asking
from protocol.catalogue import Command, Request
from protocol.events import Answered, Outcome, Role, Unanswered
from protocol.fields import Value
from protocol.flag_answers import TRIGGER_FLAGS
from protocol.messages import Acknowledgement
from protocol.translatable import marked

MAX_READS = 4
WAITING = marked("Waiting some seconds: an answer may come twice")
FLAGS_STEP_S = 0.25
FLAGS_LIMIT_S = 10.0
"""Late answers make it wait longer."""
_FLAG_KEYS = frozenset(command.key for command in TRIGGER_FLAGS)
RESTART_SHOWS_S = 0.4
"""A restart is certain within this time: by its second heartbeat, or by the link's decision without it."""
_RESTART_ROLES = (Role.UNSOLICITED, Role.DUPLICATE, Role.LATE)
"""The roles that a restart's first heartbeat may have just after the link sent one."""


class SetReply(Enum):
    """The module's answer to the set."""

    ECHO = "echo"
    """The value that was sent."""
    ONE = "one"
    """01, "understood" (E2)."""
    OTHER = "other"
    """Another value."""
    NOTHING = "nothing"
    NOT_SENT = "not sent"
    """The module had stopped answering; the set was not sent."""
    UNNEEDED = "unneeded"
    """It already has the value; nothing was sent."""


class WriteFault(Enum):
    """Why a write failed; the value is its English, translatable text."""

    REFUSED = marked("refused; the old value stands")
    CLAMPED = marked("the module holds another value")
    NOT_RETAINED = marked("acknowledged, but not kept")
    LOST = marked("no reply, not set")
    NO_REPLY = marked("no reply; may have been carried out")
    REPEATED = marked("this line repeats answers: not known")
    CONTRADICTED = marked("contradictory answers: two modules?")
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


class Written(NamedTuple):
    """The result of a write. Values are in the field's unit."""

    command: Command
    target: Value
    heard: SetReply
    read_back: Value | None = None
    """The value read back, if it was."""
    verified: bool | None = None
    """True only if two answers in a row had the target value; None if it cannot be read. Final only in a `WriteReport`,
    for which it was read once more."""
    fault: WriteFault | None = None
    waited_s: float | None = None
    """How long the unanswered set was waited for."""

    @property
    def is_acknowledged(self) -> bool:
        return self.heard in (SetReply.ECHO, SetReply.ONE)

    @property
    def is_fine(self) -> bool:
        """Whether it is verified, or only acknowledged where it cannot be read back."""
        return self.fault is None


class ReadBack(NamedTuple):
    """`raw`: the byte that two answers in a row agreed on."""

    raw: int | None = None
    is_unsteady: bool = False


def read_back(command: Command) -> Procedure[ReadBack]:
    """Ask until two answers in a row agree."""
    last: int | None = None
    for _ in range(MAX_READS):
        reading = yield from ask_value(command)
        if reading is None:
            return ReadBack()
        if reading.raw == last:
            return ReadBack(last)
        last = reading.raw
    return ReadBack(is_unsteady=True)


class Acknowledged(NamedTuple):
    heard: SetReply
    other: int | None = None
    """The byte with `SetReply.OTHER`."""
    waited_s: float | None = None


def write_verified(command: Command, value: Value) -> Procedure[Written]:
    """Write one setting that changes nothing about the link; for the baud rate see `change_baud`. Raises `ValueRefused`
    or `LookupError` before anything is sent. `write_all` checks whether writing is allowed."""
    request = command.set(value)
    before: EngineView = yield Inspect()
    known = before.device.fresh(command.key, before.now)
    old = None if known is None or command.write is None else command.write.encode(known)
    reply = acknowledged((yield Ask(request)))
    if reply.heard is SetReply.NOT_SENT:
        verdict = False if command.reads_back else None
        return Written(command=command, target=value, heard=reply.heard, verified=verdict, fault=WriteFault.NOT_SENT)
    back = ReadBack()
    if command.reads_back:
        back = yield from read_back(command)
    else:  # else the next set would wait for the answer to a question, which another module may give
        yield from ask_report(is_fenced=True)
    has_restarted = yield from restarted_since(before)
    fault = WriteFault.RESTARTED if has_restarted else _fault(command, command.set(value).data, reply, back, old=old)
    return Written(
        command=command,
        target=value,
        heard=reply.heard,
        read_back=None if back.raw is None or has_restarted else _value(command, back.raw),
        verified=fault is None if command.reads_back else None,
        fault=fault,
        waited_s=reply.waited_s,
    )


def await_flags_free(request: Request, progress: Report | None = None) -> Procedure[None]:
    """Before a set of 16 or 17: wait until no answer to an earlier one can be taken for its own (E4)."""
    view: EngineView = yield Inspect()
    while view.flags is not None and (early_s := view.flags.free_at(request) - view.now) > 0:
        if progress is not None:
            yield progress._replace(doing=WAITING)
        yield from pause_asking(early_s)
        view = yield Inspect()


def await_flags_known(progress: Report | None = None) -> Procedure[None]:
    """After a set of 16 or 17: wait until no copy of its answer can come any more, or one has come (E4)."""
    begin = view = yield Inspect()
    while view.device.undecided & _FLAG_KEYS and view.now - begin.now < FLAGS_LIMIT_S:
        if progress is not None:
            yield progress._replace(doing=WAITING)
        yield from pause_asking(FLAGS_STEP_S)
        view = yield Inspect()


def acknowledged(outcome: Outcome) -> Acknowledged:
    if isinstance(outcome, Unanswered):
        return Acknowledged(SetReply.NOT_SENT)
    message = outcome.messages[0] if isinstance(outcome, Answered) else None
    if not isinstance(message, Acknowledgement):
        return Acknowledged(SetReply.NOTHING, waited_s=None if isinstance(outcome, Answered) else outcome.waited_s)
    if message.is_echo:
        return Acknowledged(SetReply.ECHO)
    return Acknowledged(SetReply.ONE) if message.is_accepted else Acknowledged(SetReply.OTHER, message.raw)


def restarted_since(before: EngineView) -> Procedure[bool]:
    """Whether the module restarted since; an unexpected frame may be its first sign."""
    after: EngineView = yield Inspect()
    old, new = before.link.counters.by_role, after.link.counters.by_role
    if any(new[role] != old[role] for role in _RESTART_ROLES):
        yield from pause_asking(RESTART_SHOWS_S)
        after = yield Inspect()
    return after.device.restarts != before.device.restarts


def _fault(command: Command, target: int, reply: Acknowledged, back: ReadBack, *, old: int | None) -> WriteFault | None:
    if not command.reads_back:
        return {SetReply.NOTHING: WriteFault.NO_REPLY, SetReply.OTHER: WriteFault.REFUSED}.get(reply.heard)
    if back.raw is None:
        return WriteFault.UNSTEADY if back.is_unsteady else WriteFault.NO_READ_BACK
    if back.raw == target:
        return None
    if old is not None and back.raw != old:
        return WriteFault.CLAMPED
    match reply.heard:
        case SetReply.NOTHING:
            return WriteFault.LOST
        case SetReply.OTHER:
            return WriteFault.REFUSED if old is not None or reply.other == 0x00 else WriteFault.CLAMPED
        case _:
            return WriteFault.NOT_RETAINED


def _value(command: Command, raw: int) -> Value | None:
    """The value in the field's unit; None for an invalid byte."""
    return command.write.decode(raw) if command.write is not None and raw in command.write.allowed else None
