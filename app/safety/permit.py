"""What lets a frame that changes a module leave: a person's permit, and the table of interlocks.

The window asks it too, to say what is still open, but it is the procedures (`perform`, `change_baud`, `write_all`)
that refuse. What is not known never counts as fulfilled: a state that is stale, or only acknowledged, is unknown here.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, auto
from types import MappingProxyType
from typing import NamedTuple

from app.engine.conversation import FRESH_FOR_S as _FRESH_FOR_S
from app.engine.conversation import ConversationView, How, MotionExtremes
from app.engine.procedure import SHARED, TOO_SLOW
from app.safety.journal import TITLES, Act
from app.text.messages import UserMessage, message
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
    """For one frame of one act in the conversation of this number. Only the sending thread calls `spend`."""

    act: Act
    origin: Origin
    # By the session's clock, in seconds.
    granted_at: float
    conversation: int
    # Nothing is ever sent.
    is_rehearsal: bool = False
    is_spent: bool = False

    def age_s(self, now: float) -> float:
        return now - self.granted_at

    def is_in_time(self, now: float) -> bool:
        return 0.0 <= self.age_s(now) <= self.origin.value

    def spend(self) -> bool:
        """Use it up; False if it was used before."""
        if self.is_spent:
            return False
        self.is_spent = True
        return True


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

_UNKNOWN_STATE = marked("Unknown: ACTIVE or LOCKED.")
_UNKNOWN_TILT = marked("Unknown: tilt.")
RATE_SET_ELSEWHERE = marked("The baud rate of a plain socket is set at its other end.")
# A status that is older, in seconds, is not current.
FRESH_FOR_S = _FRESH_FOR_S["active"]
# Our choice: the vendor says "small mounting errors" without a number; the trigger resets 10° below its threshold.
LEVEL_WITHIN_DEG = 10.0
# Our choice, as in the pre-flight check: the module reports whole degrees and tenths of a g.
STILL_WITHIN_DEG = 2.0
STILL_FROM_G, STILL_TO_G = 0.9, 1.1
# Between the first and the last report; the engine asks for two seconds.
STILL_FOR_S = 1.8


@dataclass(frozen=True, slots=True, kw_only=True)
class InterlockInputs:
    """What the conditions are judged by at `now`, in seconds of the session's clock. None: unknown."""

    now: float
    # The number of the conversation that goes on; None without one.
    conversation: int | None = None
    is_shared: bool = False
    is_slow: bool = False
    status_age_s: float | None = None
    is_status_fresh: bool = False
    active: bool | None = None
    triggered: bool | None = None
    tilt_deg: float | None = None
    attitude_threshold_deg: float | None = None
    # Of the last two seconds.
    motion: MotionExtremes | None = None
    # What is armed in any window.
    armed: Act | None = None
    permit: Permit | None = None
    # When LOCK was last sent; an earlier permit is void.
    overtaken_at: float | None = None
    # What does not agree; known only to whoever has just asked.
    contradiction: UserMessage | None = None
    # A person allowed this one write to a module that is or may be active.
    is_unlocked: bool = False
    is_audit_ready: bool = True
    # False: the port's baud rate is set at its other end.
    sets_rate: bool = True


def inputs_at(conversation: ConversationView, now: float) -> InterlockInputs:
    """From what is known of the module at `now`, for display. Whoever sends asks who is there first, and takes only
    those answers (`app.procedures.act.checked_inputs`)."""
    tilt = conversation.known("tilt_deg", now)
    is_fresh = tilt is not None and not tilt.is_stale
    return InterlockInputs(
        now=now,
        conversation=conversation.number if conversation.is_going else None,
        is_shared=conversation.is_shared,
        is_slow=conversation.is_slow,
        status_age_s=None if tilt is None else now - tilt.at,
        is_status_fresh=is_fresh,
        active=_reported(conversation, "active", now),
        triggered=_reported(conversation, "triggered", now),
        tilt_deg=tilt.value if tilt is not None and is_fresh else None,
        attitude_threshold_deg=conversation.fresh("attitude_threshold_deg", now),
        motion=conversation.motion,
    )


def _reported(conversation: ConversationView, key: str, now: float) -> bool | None:
    """What the module reports; an acknowledgement is no report."""
    known = conversation.known(key, now)
    if known is None or known.is_stale or known.how is How.ACKNOWLEDGED:
        return None
    return known.value is True


class Refusal(NamedTuple):
    """One open condition."""

    condition: Interlock
    message: UserMessage

    @property
    def sentence(self) -> str:
        """In the language in use now."""
        return self.message.translated()


def refusals(
    act: Act, inputs: InterlockInputs, *, only: frozenset[Interlock] = frozenset(Interlock)
) -> tuple[Refusal, ...]:
    """The open conditions of `act`, in the order of the table; empty: it may be done. `only`: of these."""
    found: list[Refusal] = []
    for condition in CONDITIONS[act]:
        why = _why_open(condition, act, inputs) if condition in only else None
        if why is not None:
            found.append(Refusal(condition, why))
    return tuple(found)


def _why_open(condition: Interlock, act: Act, inputs: InterlockInputs) -> UserMessage | None:
    """None if it is met."""
    match condition:
        case Interlock.ONLINE:
            return message(marked("The module does not answer.")) if inputs.conversation is None else None
        case Interlock.NOT_SHARED:
            return message(SHARED) if inputs.is_shared else None
        case Interlock.LINE_IS_QUICK:
            return message(TOO_SLOW) if inputs.is_slow else None
        case Interlock.AGREES:
            return inputs.contradiction
        case Interlock.FRESH_STATUS:
            return _why_not_fresh(inputs)
        case Interlock.IS_LOCKED:
            return _why_not_locked(inputs)
        case Interlock.IS_ACTIVE:
            if inputs.active is None:
                return message(_UNKNOWN_STATE)
            return None if inputs.active else message(marked("The module is LOCKED: activate it first."))
        case Interlock.NOT_TRIGGERED:
            if inputs.triggered is None:
                return message(marked("Unknown: whether it has fired."))
            return message(marked("The module reports that it has fired.")) if inputs.triggered else None
        case Interlock.BELOW_TILT:
            return _why_not_below_tilt(inputs)
        case Interlock.IS_LEVEL:
            return _why_not_level(inputs.tilt_deg)
        case Interlock.IS_STILL:
            return _why_not_still(inputs.motion)
        case Interlock.RATE_FOLLOWS:
            return None if inputs.sets_rate else message(RATE_SET_ELSEWHERE)
        case Interlock.NOTHING_ELSE_ARMED:
            if inputs.armed is None or inputs.armed is act:
                return None
            return message(marked("Already armed: {what}."), what=message(TITLES[inputs.armed]))
        case Interlock.CONFIRMED:
            return _why_not_permitted(act, inputs, marked("Not confirmed."))
        case Interlock.RITUAL_DONE:
            return _why_not_permitted(act, inputs, marked("Not armed and held for 2 s."), origin=Origin.RITUAL)
        case Interlock.INTENT_DURABLE:
            return None if inputs.is_audit_ready else message(marked("The audit log cannot be written."))
        case Interlock.MAY_WRITE:
            # A person who unlocked it accepts that it may be active, so a contradiction says nothing new.
            if inputs.is_unlocked:
                return None
            return inputs.contradiction or _why_not_fresh(inputs) or _why_not_locked(inputs)
        case Interlock.RISK_ACCEPTED:
            raise ValueError("only who knows the values can judge the risk")


def _why_not_locked(inputs: InterlockInputs) -> UserMessage | None:
    if inputs.active is None:
        return message(_UNKNOWN_STATE)
    return message(marked("The module is ACTIVE: lock it first.")) if inputs.active else None


def _why_not_fresh(inputs: InterlockInputs) -> UserMessage | None:
    if inputs.is_status_fresh:
        return None
    if inputs.status_age_s is None or inputs.conversation is None:
        return message(marked("No current status."))
    return message(marked("The status is {seconds:.1f} s old."), seconds=max(0.0, inputs.status_age_s))


def _why_not_below_tilt(inputs: InterlockInputs) -> UserMessage | None:
    tilt, threshold = inputs.tilt_deg, inputs.attitude_threshold_deg
    if threshold is None:
        return message(marked("Unknown: attitude threshold."))
    if tilt is None:
        return message(_UNKNOWN_TILT)
    if tilt < threshold:
        return None
    text = marked("Tilt {tilt:.0f}° (threshold {threshold:.0f}°): it would fire at once.")
    return message(text, tilt=tilt, threshold=threshold)


def _why_not_level(tilt_deg: float | None) -> UserMessage | None:
    if tilt_deg is None:
        return message(_UNKNOWN_TILT)
    if tilt_deg <= LEVEL_WITHIN_DEG:
        return None
    text = marked("Tilt {tilt:.0f}°: lay it level (≤ {limit:.0f}°).")
    return message(text, tilt=tilt_deg, limit=LEVEL_WITHIN_DEG)


def _why_not_still(motion: MotionExtremes | None) -> UserMessage | None:
    if motion is None or motion.until - motion.since < STILL_FOR_S:
        return message(marked("Not watched for 2 s yet."))
    is_one_g = motion.acceleration_low_g >= STILL_FROM_G and motion.acceleration_high_g <= STILL_TO_G
    if motion.tilt_change_deg <= STILL_WITHIN_DEG and is_one_g:
        return None
    return message(
        marked("It moves: {low:.0f}–{high:.0f}°, {weak:.1f}–{strong:.1f} g in 2 s."),
        low=motion.tilt_low_deg,
        high=motion.tilt_high_deg,
        weak=motion.acceleration_low_g,
        strong=motion.acceleration_high_g,
    )


def _why_not_permitted(
    act: Act, inputs: InterlockInputs, missing: str, *, origin: Origin | None = None
) -> UserMessage | None:
    permit, now = inputs.permit, inputs.now
    if permit is None or permit.act is not act or origin not in (None, permit.origin):
        return message(missing)
    if permit.is_rehearsal:
        return message(marked("Nothing is sent."))
    if permit.is_spent:
        return message(marked("Confirm again: already used."))
    if permit.conversation != inputs.conversation:
        return message(marked("Confirm again: it may be another module."))
    if inputs.overtaken_at is not None and permit.granted_at <= inputs.overtaken_at:
        return message(marked("Confirm again: LOCK was pressed."))
    if not permit.is_in_time(now):
        return message(marked("Confirm again: {seconds:.1f} s old."), seconds=max(0.0, permit.age_s(now)))
    return None
