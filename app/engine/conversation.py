"""One unbroken conversation with one module: what is known of it holds as long as it goes on, and no longer.

Only the module's own frames provide values. A value that was never received is absent and shown as "unknown"; the
defaults of the vendor's table are never used instead. A value is stale where it is too old, delayed by the line, or of
a conversation that is over.
"""

from collections import deque
from collections.abc import Mapping
from enum import Enum
from math import inf
from types import MappingProxyType
from typing import NamedTuple

from app.text.messages import ErrorCode, UserError, UserMessage, message
from protocol.catalogue import ACTIVATION, BOOT_COUNT, BY_NAME, LOCK, SERIAL_OUTPUT, SETTINGS, Request
from protocol.events import Answered, Contradiction, Ended, EndReason, Event, Received, Role, Unanswered
from protocol.fields import Quantity, Value
from protocol.messages import Acknowledgement, Reading, Status
from protocol.stale_replies import TRIGGER_FLAGS, FlagAnswers
from protocol.timing import SLOW_S
from protocol.translatable import marked

STATUS_KEYS = ("tilt_deg", "acceleration_g", "triggered", "active")
# Seconds after which a value is stale. Settings and the boot count do not age while the conversation goes on.
FRESH_FOR_S: Mapping[str, float] = MappingProxyType(
    dict.fromkeys(STATUS_KEYS, 1.0) | dict.fromkeys(("cell_voltage_v", "charging", "light_v"), 5.0)
)
# How long a streamed status is current, and proves that the serial output is on: the slowest streams send one a second.
STREAM_PROVES_S = 1.5
STREAM_GAP_S = 3.0  # a report that comes this long before the next one is no part of a stream
REPORTS_FOR_S = 2.5  # how long reports are kept, by which it is judged whether the module moves
# The value that a set or an act changes, by its command.
_CHANGED_BY = {command: command.key for command in SETTINGS} | {
    ACTIVATION: "active",
    BY_NAME["deploy"]: "triggered",
    BY_NAME["zero_sensor"]: "tilt_deg",
}


class How(Enum):
    READ = "read"  # the answer to a question
    ACKNOWLEDGED = "acknowledged"  # the module acknowledged a set (E2: "received", not yet verified)
    STREAMED = "streamed"  # part of a streamed report


# Why it ended


def reason_message(reason: EndReason, contradiction: Contradiction | None = None) -> UserMessage:
    """Why a conversation ended, in one sentence."""
    if reason is not EndReason.CONTRADICTED or contradiction is None:
        return message(reason.value)
    command = contradiction.before.command
    reply = command.reply
    texts = [reply.text(one.raw) if isinstance(reply, Quantity) else str(one.value) for one in contradiction]
    text = marked("{setting}: {before}, then {after}. Two modules on this line?")
    return message(text, setting=message(command.title), before=texts[0], after=texts[1])


class Interrupted(UserError):
    """The conversation ended while a procedure ran: what it knows is of a module that may be gone. `is_unsent`: the
    request that it waited for was not sent yet; else a set or an act may have been carried out."""

    code = ErrorCode.INTERRUPTED

    def __init__(
        self, reason: EndReason, contradiction: Contradiction | None = None, *, is_unsent: bool = False
    ) -> None:
        super().__init__(reason_message(reason, contradiction))
        self.reason = reason
        self.contradiction = contradiction
        self.is_unsent = is_unsent


# What is known


class Known(NamedTuple):
    """One value, in its field's unit; `at` is when it arrived, by the session's clock."""

    value: Value
    how: How
    at: float
    is_stale: bool = False


class StatusSample(NamedTuple):
    """One status report. `at`: when its bytes were read from the port, in seconds of the session's clock."""

    at: float
    tilt_deg: int
    acceleration_g: float
    triggered: bool
    active: bool


class ConversationView(NamedTuple):
    """The knowledge of one moment; immutable, so any thread may keep it."""

    number: int = 0  # from 1 over the program's life at one port; 0 before the first one
    began_at: float = 0.0
    ended: Ended | None = None
    values: Mapping[str, Known] = MappingProxyType({})
    streamed: int = 0  # how many status reports came unasked
    is_streaming: bool = False  # the last one did within 1.5 s, and was no single one
    reports: tuple[StatusSample, ...] = ()  # of the last 2.5 s, oldest first
    lag_s: float | None = None  # how long answers take; None until one is measured
    is_shared: bool = False  # the port takes nothing but questions and LOCK

    @property
    def is_going(self) -> bool:
        return self.number > 0 and self.ended is None

    @property
    def is_slow(self) -> bool:
        """Only questions and LOCK are sent."""
        return self.lag_s is not None and self.lag_s > SLOW_S

    @property
    def reported(self) -> tuple[Value | None, Value | None]:
        """Triggered and active, as last reported; None while unknown."""
        triggered, active = self.values.get("triggered"), self.values.get("active")
        return (None if triggered is None else triggered.value, None if active is None else active.value)

    @property
    def boot_count(self) -> int | None:
        """The boot count as last read, of an ended conversation, too. None before the first one."""
        known = self.values.get(BOOT_COUNT.key)
        return None if known is None else int(known.value)

    def known(self, key: str, now: float) -> Known | None:
        """The value, stale if it is too old at `now` or the conversation is over; None while unknown."""
        known = self.values.get(key)
        if known is None or self.ended is not None:
            return None if known is None else known._replace(is_stale=True)
        limit_s = STREAM_PROVES_S if known.how is How.STREAMED else FRESH_FOR_S.get(key, inf)
        if self.is_slow and self.lag_s is not None:
            known = known._replace(at=known.at - self.lag_s)  # about when it was sent
        return known._replace(is_stale=now - known.at > limit_s)

    def fresh(self, key: str, now: float) -> Value | None:
        known = self.known(key, now)
        return None if known is None or known.is_stale else known.value

    def settings(self, now: float) -> dict[str, Value]:
        """The settings that are known and not stale at `now`, by key in the field's unit. Without the serial output,
        which the program itself switches."""
        fresh = {command.key: self.fresh(command.key, now) for command in SETTINGS if command is not SERIAL_OUTPUT}
        return {key: value for key, value in fresh.items() if value is not None}


class Conversation:
    """Collects what the link tells in one conversation. Belongs to the session's thread."""

    def __init__(self, number: int, boot_count: int, began_at: float, baud_rate: int, flags: FlagAnswers) -> None:
        self._begun = ConversationView(number, began_at)
        self.ended: Ended | None = None
        self._flags = flags
        self._values: dict[str, Known] = {
            BOOT_COUNT.key: Known(boot_count, How.READ, began_at),
            # A module that answers at this rate proves it.
            "baud_rate": Known(baud_rate, How.READ, began_at),
        }
        # When the last streamed report came, and whether it was no single one, which may be a late answer.
        self._streamed_at, self._is_stream, self._streamed = -inf, False, 0
        # Status reports of the last seconds; up to 1,440 a second may come.
        self._reports: deque[StatusSample] = deque(maxlen=8192)

    def apply(self, event: Event) -> StatusSample | None:
        """Take it in; return the status report that it is."""
        match event:
            case Received(message=Reading() as reading, role=Role.ANSWER):
                self._values[reading.command.key] = Known(reading.value, How.READ, event.at)
            case Received(message=Status() as status, role=Role.ANSWER | Role.STREAMED | Role.DUPLICATE):
                return self._on_status(StatusSample(event.at, *status), is_streamed=event.role is Role.STREAMED)
            case Answered(messages=(Acknowledgement() as acknowledgement,)):
                self._on_acknowledged(acknowledgement, event.at)
            case Unanswered() if event.may_be_done:
                self._forget_changed(event.request)
            case Ended():
                self.ended = event
                self._reports.clear()  # nothing is judged by them any more; else its last view would keep thousands
        return None

    def view(self, now: float, lag_s: float | None = None) -> ConversationView:
        if self.ended is not None:
            now = self.ended.at  # as it was then
        values = dict(self._values)
        if not self._flags.are_known(now):
            # E4: a copy of the other one's acknowledgement may have been taken for it.
            for command in TRIGGER_FLAGS:
                values.pop(command.key, None)
        while self._reports and now - self._reports[0].at > REPORTS_FOR_S:
            self._reports.popleft()
        return self._begun._replace(
            ended=self.ended,
            values=MappingProxyType(values),
            streamed=self._streamed,
            is_streaming=self.ended is None and self._is_stream and now - self._streamed_at < STREAM_PROVES_S,
            reports=tuple(self._reports),
            lag_s=lag_s,
        )

    def _on_status(self, sample: StatusSample, *, is_streamed: bool) -> StatusSample:
        if is_streamed:
            self._is_stream = sample.at - self._streamed_at <= STREAM_GAP_S
            self._streamed_at = sample.at
            self._streamed += 1
            if self._is_stream:
                self._values[SERIAL_OUTPUT.key] = Known(True, How.STREAMED, sample.at)
        for key in STATUS_KEYS:
            self._values[key] = Known(getattr(sample, key), How.STREAMED if is_streamed else How.READ, sample.at)
        self._reports.append(sample)
        return sample

    def _on_acknowledged(self, acknowledgement: Acknowledgement, at: float) -> None:
        request = acknowledgement.request
        key, field = _CHANGED_BY.get(request.command), request.command.write
        # After an act only a report has the new value; but an acknowledged activation already may fire.
        is_only_reported = key in STATUS_KEYS and request != ACTIVATION.set(True)
        # The rate is only proven by a conversation at the new one.
        is_unproven = is_only_reported or key == "baud_rate" or not acknowledgement.is_accepted
        if key is None or field is None or is_unproven:
            self._forget_changed(request)
            return
        self._values[key] = Known(field.decode(request.data), How.ACKNOWLEDGED, at)
        if request == SERIAL_OUTPUT.set(False):
            self._streamed_at, self._is_stream = -inf, False

    def _forget_changed(self, request: Request) -> None:
        # What a set or an act may have changed is unknown until it is read.
        if request != LOCK:  # a module that was ACTIVE counts as that until it reports otherwise
            self._values.pop(_CHANGED_BY.get(request.command, ""), None)
