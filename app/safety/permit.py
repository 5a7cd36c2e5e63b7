"""Permits and interlocks: one table of conditions, checked by the engine before every frame that changes a module.

The window asks it too, to say what is still open, but it is the procedures (`perform`, `change_baud`, `write_all`)
that refuse. What is not known never counts as fulfilled: a state that is stale, or only acknowledged, is unknown here.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, auto
from math import inf
from types import MappingProxyType
from typing import NamedTuple

from app.engine.conversation import ConversationView, How, StatusSample
from app.engine.procedure import SHARED, TOO_SLOW
from app.safety.journal import TITLES, Act
from app.text.messages import UserMessage, message
from protocol.fields import Value
from protocol.translatable import marked


class Origin(Enum):
    """How the person gave the permit; the value is how long it is valid, in seconds.

    Whatever takes longer, the act is refused rather than carried out late. The slowest line that takes commands needs
    1.5 s to ask who is there, and the intent may take a second.
    """

    RITUAL = 3.0  # chosen, armed, held for two seconds
    CONFIRMATION = 6.0  # a second click in the window; zeroing watches the module for two seconds
    COMMAND_LINE = 10.0  # --yes


@dataclass(slots=True, eq=False)
class Permit:
    """A permit allows one frame of one act in the conversation of this number: given by a person, it expires, and is
    used once. Only the sending thread spends it."""

    act: Act
    origin: Origin
    granted_at: float  # by the session's clock, in seconds
    conversation: int
    is_spent: bool = False

    def is_in_time(self, now: float) -> bool:
        return 0.0 <= now - self.granted_at <= self.origin.value


class Interlock(Enum):
    ONLINE = auto()  # a conversation with a module goes on
    NOT_SHARED = auto()  # the port takes more than questions and LOCK
    LINE_IS_QUICK = auto()  # it answers within 0.3 s, so what was asked is still true when the frame arrives
    AGREES = auto()  # 30, 31 and the status say the same, and nothing is answered twice
    FRESH_STATUS = auto()  # at most a second old, or one and a half periods of a slower stream
    IS_LOCKED = auto()
    IS_ACTIVE = auto()
    NOT_TRIGGERED = auto()
    BELOW_TILT = auto()  # the tilt is below the attitude threshold: activated, it does not fire at once
    IS_LEVEL = auto()  # the tilt is small enough to be a mounting error
    IS_STILL = auto()  # it did not move for two seconds
    RATE_FOLLOWS = auto()  # the port's rate can be changed with the module's, which a plain socket cannot
    NOTHING_ELSE_ARMED = auto()
    CONFIRMED = auto()  # a person confirmed this act a moment ago in this conversation; the permit is unused
    RITUAL_DONE = auto()  # the same, by the deploy ritual only
    INTENT_DURABLE = auto()  # the audit log can be written
    MAY_WRITE = auto()  # it is locked, or unlocked for this one write
    RISK_ACCEPTED = auto()  # a person accepted what the values take away; `write_all`, which knows them, checks it


_PRESENT = (Interlock.ONLINE, Interlock.NOT_SHARED, Interlock.LINE_IS_QUICK)
_ALWAYS = (*_PRESENT, Interlock.AGREES, Interlock.FRESH_STATUS)
_EXPLICIT = (Interlock.NOTHING_ELSE_ARMED, Interlock.CONFIRMED, Interlock.INTENT_DURABLE)

CONDITIONS: Mapping[Act, tuple[Interlock, ...]] = MappingProxyType({
    Act.LOCK: (),  # always safe: never refused
    Act.ACTIVATE: (*_ALWAYS, Interlock.IS_LOCKED, Interlock.NOT_TRIGGERED, Interlock.BELOW_TILT, *_EXPLICIT),
    Act.ZERO: (*_ALWAYS, Interlock.IS_LOCKED, Interlock.IS_LEVEL, Interlock.IS_STILL, *_EXPLICIT),
    Act.SHUTDOWN: (*_ALWAYS, Interlock.IS_LOCKED, *_EXPLICIT),
    Act.FORBID_DEPLOY: (*_ALWAYS, *_EXPLICIT),
    Act.DEPLOY: (*_ALWAYS, Interlock.IS_ACTIVE, Interlock.NOT_TRIGGERED,
                 Interlock.NOTHING_ELSE_ARMED, Interlock.RITUAL_DONE, Interlock.INTENT_DURABLE),
    Act.CHANGE_BAUD: (*_ALWAYS, Interlock.IS_LOCKED, Interlock.RATE_FOLLOWS, *_EXPLICIT),
    Act.WRITE: (*_PRESENT, Interlock.MAY_WRITE, Interlock.NOTHING_ELSE_ARMED),
})  # fmt: skip

# What is known without asking the module anything.
ASKS_NOTHING = frozenset((*_PRESENT, *_EXPLICIT, Interlock.RITUAL_DONE, Interlock.RATE_FOLLOWS))

_UNKNOWN_TILT = marked("Unknown: tilt.")
RATE_SET_ELSEWHERE = marked("The baud rate of a plain socket is set at its other end.")
# Our choice: the vendor says "small mounting errors" without a number; the trigger resets 10° below its threshold.
LEVEL_WITHIN_DEG = 10.0
# Our choice, as in the pre-flight check: the module reports whole degrees and tenths of a g.
STILL_WITHIN_DEG = 2.0
STILL_FROM_G, STILL_TO_G = 0.9, 1.1
# Between the first and the last report; the engine asks for two seconds.
STILL_FOR_S = 1.8


@dataclass(frozen=True, slots=True, kw_only=True)
class InterlockInputs:
    """The facts by which the conditions are judged at `now`, in seconds of the session's clock. None is unknown."""

    now: float
    conversation: ConversationView  # the one that goes on, or else the last one
    is_status_fresh: bool = False
    active: Value | None = None
    triggered: Value | None = None
    tilt_deg: float | None = None
    armed: Act | None = None  # what is armed in any window
    permit: Permit | None = None
    overtaken_at: float = -inf  # when LOCK was last sent; an earlier permit is void
    contradiction: UserMessage | None = None  # what does not agree; known only to whoever has just asked
    is_unlocked: bool = False  # a person allowed this one write to a module that is or may be active
    is_audit_ready: bool = True
    sets_rate: bool = True  # False: the port's baud rate is set at its other end


def inputs_at(conversation: ConversationView, now: float) -> InterlockInputs:
    """Return what is known of the module at `now`, for display. Whoever sends asks who is there first, and takes only
    those answers (`app.procedures.act.inputs_of`)."""
    active, tilt_deg = conversation.fresh("active", now), conversation.fresh("tilt_deg", now)
    if active is not None and conversation.values["active"].how is How.ACKNOWLEDGED:
        active = None  # that is no report
    return InterlockInputs(
        now=now,
        conversation=conversation,
        is_status_fresh=tilt_deg is not None,
        active=active,
        triggered=conversation.fresh("triggered", now),
        tilt_deg=tilt_deg,
    )


class Refusal(NamedTuple):
    condition: Interlock
    message: UserMessage

    @property
    def sentence(self) -> str:
        """The sentence in the language in use now."""
        return self.message.translated()


def refusals(
    act: Act, inputs: InterlockInputs, *, only: frozenset[Interlock] = frozenset(Interlock)
) -> tuple[Refusal, ...]:
    """The open conditions of `act`, in the order of the table; empty: it may be done. `only`: of these."""
    whys = [(one, _why_open(one, act, inputs)) for one in CONDITIONS[act] if one in only]
    return tuple(Refusal(condition, why) for condition, why in whys if why is not None)


def _why_open(condition: Interlock, act: Act, inputs: InterlockInputs) -> UserMessage | None:
    tilt, conversation = inputs.tilt_deg, inputs.conversation
    match condition:
        case Interlock.ONLINE:
            return None if conversation.is_going else message(marked("The module does not answer."))
        case Interlock.NOT_SHARED:
            return message(SHARED) if conversation.is_shared else None
        case Interlock.LINE_IS_QUICK:
            return message(TOO_SLOW) if conversation.is_slow else None
        case Interlock.AGREES:
            return inputs.contradiction
        case Interlock.FRESH_STATUS:
            return None if inputs.is_status_fresh else message(marked("No current status."))
        case Interlock.IS_LOCKED | Interlock.IS_ACTIVE if inputs.active is None:
            return message(marked("Unknown: ACTIVE or LOCKED."))
        case Interlock.IS_LOCKED:
            return message(marked("The module is ACTIVE: lock it first.")) if inputs.active else None
        case Interlock.IS_ACTIVE:
            return None if inputs.active else message(marked("The module is LOCKED: activate it first."))
        case Interlock.NOT_TRIGGERED:
            if inputs.triggered is None:
                return message(marked("Unknown: whether it has fired."))
            return message(marked("The module reports that it has fired.")) if inputs.triggered else None
        case Interlock.BELOW_TILT:
            threshold = conversation.fresh("attitude_threshold_deg", inputs.now)
            if threshold is None:
                return message(marked("Unknown: attitude threshold."))
            if tilt is None:
                return message(_UNKNOWN_TILT)
            text = marked("Tilt {tilt:.0f}° (threshold {threshold:.0f}°): it would fire at once.")
            return None if tilt < threshold else message(text, tilt=tilt, threshold=threshold)
        case Interlock.IS_LEVEL:
            if tilt is None:
                return message(_UNKNOWN_TILT)
            text = marked("Tilt {tilt:.0f}°: lay it level (≤ {limit:.0f}°).")
            return None if tilt <= LEVEL_WITHIN_DEG else message(text, tilt=tilt, limit=LEVEL_WITHIN_DEG)
        case Interlock.IS_STILL:
            return _why_not_still(conversation.reports)
        case Interlock.RATE_FOLLOWS:
            return None if inputs.sets_rate else message(RATE_SET_ELSEWHERE)
        case Interlock.NOTHING_ELSE_ARMED:
            if inputs.armed is None or inputs.armed is act:
                return None
            return message(marked("Already armed: {what}."), what=message(TITLES[inputs.armed]))
        case Interlock.CONFIRMED | Interlock.RITUAL_DONE:
            return _why_not_permitted(act, inputs, needs_ritual=condition is Interlock.RITUAL_DONE)
        case Interlock.INTENT_DURABLE:
            return None if inputs.is_audit_ready else message(marked("The audit log cannot be written."))
        case Interlock.MAY_WRITE:
            # A person who unlocked it accepts that it may be active, so a contradiction says nothing new.
            if inputs.is_unlocked:
                return None
            return (
                inputs.contradiction
                or _why_open(Interlock.FRESH_STATUS, act, inputs)
                or _why_open(Interlock.IS_LOCKED, act, inputs)
            )
        case Interlock.RISK_ACCEPTED:
            raise ValueError("only who knows the values can judge the risk")


def _why_not_still(reports: tuple[StatusSample, ...]) -> UserMessage | None:
    if not reports or reports[-1].at - reports[0].at < STILL_FOR_S:
        return message(marked("Not watched for 2 s yet."))
    tilts_deg = [report.tilt_deg for report in reports]
    accelerations_g = [report.acceleration_g for report in reports]
    low, high, weak, strong = min(tilts_deg), max(tilts_deg), min(accelerations_g), max(accelerations_g)
    if high - low <= STILL_WITHIN_DEG and weak >= STILL_FROM_G and strong <= STILL_TO_G:
        return None
    text = marked("It moves: {low:.0f}–{high:.0f}°, {weak:.1f}–{strong:.1f} g in 2 s.")
    return message(text, low=low, high=high, weak=weak, strong=strong)


def _why_not_permitted(act: Act, inputs: InterlockInputs, *, needs_ritual: bool) -> UserMessage | None:
    permit = inputs.permit
    if permit is None or permit.act is not act or (needs_ritual and permit.origin is not Origin.RITUAL):
        return message(marked("Not armed and held for 2 s.") if needs_ritual else marked("Not confirmed."))
    is_other = permit.conversation != inputs.conversation.number or not inputs.conversation.is_going
    is_overtaken = permit.granted_at <= inputs.overtaken_at  # LOCK wins also where both came in one moment
    is_void = permit.is_spent or is_other or is_overtaken or not permit.is_in_time(inputs.now)
    return message(marked("Confirm again.")) if is_void else None
