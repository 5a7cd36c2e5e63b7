"""What a check read in one conversation, filled in step by step; and why a check, or its verdict, holds no more."""

import logging
from dataclasses import dataclass, field
from typing import NamedTuple

from app.engine.conversation import Interrupted, StatusSample, reason_message
from app.engine.procedure import Cancelled, Procedure
from app.procedures.history import History
from app.procedures.read import Present, Readings, contradictions, read_settings, who_is_there
from app.text.messages import UserError, UserMessage, message
from protocol.catalogue import READABLE_SETTINGS
from protocol.events import Ended
from protocol.fields import Value
from protocol.translatable import marked

_log = logging.getLogger(__name__)
HEARTBEATS = 20
# For tilt and acceleration.
STILL_S = 2.0
CHECK_AGAIN = message(marked("Check again."))
CHECK_LINK = message(marked("Check cable and power."))
FIND_OUT_WHY = marked("Find out why (Triggers), repack, lock and restart.")


class Void(NamedTuple):
    """Why a check, or the verdict of one, holds no more. `word` is for programs, `message` one sentence for people."""

    word: str
    message: UserMessage
    # What to do about it. A cable has nothing to do with what a person or the module did.
    do: UserMessage = CHECK_LINK


CANCELLED = Void("cancelled", message(marked("It was cancelled.")), CHECK_AGAIN)
UNFINISHED = Void("unfinished", message(marked("It did not come to its end.")))
OVER = Void("over", message(marked("The conversation in which it was checked is over.")))
UNREAD = Void("unread", message(marked("Not everything could be read again.")))
TOO_OLD = Void("too_old", message(marked("It is older than 15 minutes.")))
FIRED = Void("fired", message(marked("The module was told to fire, or reports TRIGGERED.")), message(FIND_OUT_WHY))


def changed(what: UserMessage) -> Void:
    return Void("changed", message(marked("Changed: {what}."), what=what), CHECK_AGAIN)


def void_of_end(ended: Ended | Interrupted) -> Void:
    """The conversation in which it was checked is over."""
    return Void(ended.reason.name.lower(), reason_message(ended.reason, ended.contradiction))


class TriggerFlag(NamedTuple):
    """Whether a trigger is enabled. It cannot be read: only an acknowledged set tells it (E8). Where it is None, `why`
    says why that is not known."""

    is_enabled: bool | None = None
    why: UserMessage = message(marked("not enabled in this conversation"))


class StateReading(NamedTuple):
    """Everything that a verdict depends on and that does not drift."""

    settings: Readings
    present: Present

    @property
    def status(self) -> StatusSample | None:
        return self.present.status

    @property
    def is_complete(self) -> bool:
        return self.settings.is_complete and self.present.contradiction is None


def read_state() -> Procedure[StateReading]:
    """Read the settings, then who is there. Sends queries only. The check does it before and after measuring, the
    window again and again while GO or READY stands: a value that changed since ends the conversation."""
    settings = yield from read_settings()
    present = yield from who_is_there()
    return StateReading(settings, present)


@dataclass(slots=True)
class Evidence:
    """Times are seconds of the session's clock. What is not known is empty or None."""

    port: str = ""
    baud_rate: int = 0
    # Its number; 0 before the check has begun.
    conversation: int = 0
    ended_at: float | None = None
    # Why it holds no more; set while it still runs, it is void when it ends.
    void: Void | None = None
    # The module may have fired before it restarted, and the notice about that is still open. See
    # `app.safety.left_active`.
    may_have_fired: bool = False
    heartbeats_sent: int = 0
    # Not answered, or only when they were asked again.
    heartbeats_lost: int = 0
    # Of those that can be measured: it is certain which of the questions was answered.
    round_trips_s: list[float] = field(default_factory=list)
    # From the beginning to the end; of an aborted check, while the heartbeats were sent.
    rejected_bytes: int = 0
    # During the two seconds.
    reports: list[StatusSample] = field(default_factory=list)
    # The last one.
    status: StatusSample | None = None
    # Settings and boot count by key, as last read.
    values: dict[str, Value] = field(default_factory=dict)
    # Before and after measuring.
    states: list[StateReading] = field(default_factory=list)
    # All answers for cell voltage, charging and light, by key.
    series: dict[str, list[Value]] = field(default_factory=dict)
    # Keys of the values that the module, though it is there, did not answer.
    unanswered: set[str] = field(default_factory=set)
    history: History | None = None
    # By key of the trigger.
    flags: dict[str, TriggerFlag] = field(default_factory=dict)
    # Something was told that nobody had asked for.
    is_answered_twice: bool = False

    @property
    def statuses(self) -> list[StatusSample]:
        """All statuses that were asked for."""
        return [*(state.status for state in self.states if state.status is not None), *self.reports]

    @property
    def has_triggered(self) -> bool:
        return any(status.triggered for status in self.statuses)

    def contradiction_of(self, key: str) -> UserMessage | None:
        """What 30 or 31 and the status said where they differed, or where one of them was not answered."""
        presents = [state.present for state in self.states]
        said = [contradictions(one.active, one.triggered, one.status).get(key) for one in presents]
        return next(filter(None, said), None)

    @property
    def is_active(self) -> bool | None:
        """As the module last reported itself."""
        return None if self.status is None else self.status.active

    @property
    def is_complete(self) -> bool:
        return self.ended_at is not None and self.void is None

    @property
    def settings(self) -> dict[str, Value]:
        """Those that can be read, as far as they are known."""
        return {one.key: self.values[one.key] for one in READABLE_SETTINGS if one.key in self.values}

    def note_state(self, state: StateReading) -> None:
        self.states.append(state)
        self.values = dict(state.settings.values)
        self.unanswered = (self.unanswered - self.values.keys()) | state.settings.errors.keys()
        self.status = state.status or self.status

    def note_error(self, error: BaseException) -> None:
        """Record why the check ended early, unless that is known already. What was enabled is not known any more."""
        _log.debug("check ended early: %s", error)
        self.flags = {key: TriggerFlag(why=UNFINISHED.message) for key in self.flags}
        if self.void is None:
            match error:
                case Interrupted():
                    self.void = void_of_end(error)
                case Cancelled():
                    self.void = CANCELLED
                case UserError():
                    self.void = Void(error.code.value, error.message)
                case _:
                    self.void = UNFINISHED
