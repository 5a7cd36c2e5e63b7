"""Questions: everything, the settings, and who is there directly before a frame that changes something.

No procedure here asks whether the module is still the same one: if it may not be, `Interrupted` was raised. That is why
each of them asks the boot count last: if another module answers by then, or this one after a restart, the conversation
ends there.
"""

from collections.abc import Mapping, Sequence
from math import inf
from typing import NamedTuple

from app.engine.conversation import StatusSample
from app.engine.procedure import Ask, EngineView, Inspect, Procedure, Report, ask_report, ask_value
from app.text.messages import UserMessage, joined, message
from protocol.catalogue import (
    BOOT_COUNT,
    BY_NAME,
    COMMANDS,
    HEARTBEAT,
    READABLE_SETTINGS,
    STATUS,
    TRIGGER_RECORDS,
    Command,
)
from protocol.events import Answered, Unanswered
from protocol.fields import Value
from protocol.messages import Reading, Status
from protocol.translatable import marked

ACTIVE = BY_NAME["active"]
TRIGGERED = BY_NAME["triggered"]
_FIRST = (ACTIVE, TRIGGERED, STATUS)
_APART = (*_FIRST, HEARTBEAT, TRIGGER_RECORDS, BOOT_COUNT)
# The state first, as it matters most: 30, 31 and the status one after the other, as they have to agree.
READABLE: tuple[Command, ...] = (
    *_FIRST,
    *(command for command in COMMANDS if command.can_be_asked and command not in _APART),
    BOOT_COUNT,
)
# Beside the status, what a reading has: the values, and all settings, the most important first.
LIVE_KEYS = ("boot_count", "cell_voltage_v", "charging", "light_v")
SETTING_KEYS = (
    "attitude_threshold_deg",
    "freefall_acceleration_g",
    "freefall_time_s",
    "light_threshold_v",
    "attitude_trigger",
    "freefall_trigger",
    "serial_output",
    "baud_rate",
)

NO_REPLY = marked("no reply")
ANSWERED_TWICE = message(marked("Questions are answered twice. Two modules on this line?"))
_WORDS: Mapping[Command, tuple[str, str]] = {
    ACTIVE: (marked("LOCKED"), marked("ACTIVE")),
    TRIGGERED: (marked("not triggered"), marked("TRIGGERED")),
}


def contradictions(
    active: Value | None, triggered: Value | None, status: StatusSample | None
) -> Mapping[str, UserMessage]:
    """Where 30 or 31 and the status differ, or one of them was not answered (None): what both say, by the status's
    key."""
    found: dict[str, UserMessage] = {}
    for command, answer in ((ACTIVE, active), (TRIGGERED, triggered)):
        reported = None if status is None else getattr(status, command.key)
        if answer is None or answer != reported:
            code, said, told = f"{command.code:02X}", _word(command, answer), _word(command, reported)
            text = marked("{code}: {answer}, status: {reported}.")
            found[command.key] = message(text, code=code, answer=said, reported=told)
    return found


def _word(command: Command, said: Value | None) -> UserMessage:
    return message(NO_REPLY if said is None else _WORDS[command][said is True])


class Readings:
    """The readings of one job. (It is no dataclass: importing those takes longer than the rest of `dps-s read`.)"""

    def __init__(self) -> None:
        self.answered_at: float | None = None  # when the first question was, in seconds of the session's clock
        self.values: dict[str, Value] = {}  # by key ("light_threshold_v"), in the field's unit
        self.status: StatusSample | None = None
        self.state: dict[str, Value] = {}  # the answers to 30 and 31, which prove nothing without the status
        self.errors: dict[str, Unanswered] = {}  # what the module, though it is there, did not answer, by key

    @property
    def boot_count(self) -> int | None:
        value = self.values.get(BOOT_COUNT.key)
        return None if value is None else int(value)

    @property
    def is_complete(self) -> bool:
        return not self.errors

    @property
    def contradictions(self) -> Mapping[str, UserMessage]:
        """Where 30 or 31 and the status do not agree: what both say, by the key of the status, unknown then."""
        return contradictions(self.state.get(ACTIVE.key), self.state.get(TRIGGERED.key), self.status)


def read_everything(readings: Readings | None = None) -> Procedure[Readings]:
    """Ask once for everything that can be asked for. `readings`: has what was read so far, also if this ends with
    `Interrupted`."""
    return (yield from _ask_each(READABLE, readings or Readings()))


def read_settings() -> Procedure[Readings]:
    """Ask once for each setting, and the boot count. Who needs two readings calls this twice and need not compare them:
    two different answers to one question end the conversation."""
    return (yield from _ask_each((*READABLE_SETTINGS, BOOT_COUNT), Readings()))


def _ask_each(commands: Sequence[Command], read: Readings) -> Procedure[Readings]:
    for done, command in enumerate(commands):
        yield Report(done, len(commands), marked("Reading: {what}"), (("what", command.title),))
        outcome = yield Ask(command.query())
        if not isinstance(outcome, Answered):
            read.errors[command.key] = outcome
            continue
        if read.answered_at is None:
            read.answered_at = outcome.at
        if isinstance(answer := outcome.messages[0], Reading):
            (read.state if command in (ACTIVE, TRIGGERED) else read.values)[command.key] = answer.value
        elif isinstance(answer, Status):
            read.status = StatusSample(outcome.at, *answer)
    return read


def read_twice(command: Command) -> Procedure[Value | None]:
    """Ask twice, as the 8-bit sum misses about 6 % of two-bit errors; None if one question is not answered."""
    first = yield from ask_value(command)
    second = None if first is None else (yield from ask_value(command))
    # Different answers have ended the conversation already; but nothing is verified by trusting in that.
    return second if second == first else None


class Present(NamedTuple):
    """Who is there. None: not answered."""

    active: Value | None = None
    triggered: Value | None = None
    status: StatusSample | None = None
    # When 31 was asked, in seconds of the session's clock. The module sent the status after that, however long the line
    # held it back: it answers in order.
    asked_at: float = -inf
    is_counted: bool = True

    @property
    def contradiction(self) -> UserMessage | None:
        """Why its state is unknown; None if everything was answered and agrees."""
        found = [*contradictions(self.active, self.triggered, self.status).values()]
        if not self.is_counted:
            found.append(message(marked("{code}: no reply."), code=f"{BOOT_COUNT.code:02X}"))
        return joined(found, " ") if found else None


def who_is_there() -> Procedure[Present]:
    """Ask who is there, directly before a frame that changes something, and wherever the state is judged: 30 behind a
    fence, 31, the status, the boot count.

    30 and 31 tell the same as the status, so a module that contradicts itself, or a second one on the line, shows here.
    The status may be a streamed report, which a line may delay by seconds; but it came after the answer to 31. The boot
    count tells of a restart, or of another module, up to that moment; between it and a frame nothing may come.
    """
    active = yield from ask_value(ACTIVE, is_fenced=True)
    asking: EngineView = yield Inspect()
    triggered = yield from ask_value(TRIGGERED)
    status = yield from ask_report()
    boot_count = yield from ask_value(BOOT_COUNT)
    return Present(active, triggered, status, asking.now, is_counted=boot_count is not None)
