"""Interlocks: one table of conditions, checked by the engine before every frame that changes a module.

The window asks it too, to say what is still open, but it is the procedures (`perform`, `change_baud`, `write_all`)
that refuse.
What is not known never counts as fulfilled: a state that is stale, or only acknowledged, is unknown here.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, auto
from math import inf, isinf
from types import MappingProxyType
from typing import NamedTuple

from app.engine.device import FRESH_FOR_S, DeviceView, How, Known, StaleReason
from app.engine.motion import MotionExtremes
from app.safety.acts import TITLES, Act
from app.safety.permit import Origin, Permit
from app.text.messages import UserMessage, message
from protocol.link_states import Presence
from protocol.translatable import marked


class Interlock(Enum):
    ONLINE = auto()
    """The module answers."""
    IS_IDENTITY_SETTLED = auto()
    """It is proven which module answers, or a person confirmed it; see `app.engine.identity`."""
    AGREES = auto()
    """30, 31 and the status say the same, and nothing is answered twice; see `app.procedures.who_is_there`."""
    FRESH_STATUS = auto()
    """The last status report is at most a second old, or one and a half periods of a slower stream."""
    IS_LOCKED = auto()
    IS_ACTIVE = auto()
    NOT_TRIGGERED = auto()
    BELOW_TILT = auto()
    """The tilt is below the attitude threshold: activated, it does not fire at once."""
    IS_LEVEL = auto()
    """The tilt is small enough to be a mounting error."""
    IS_STILL = auto()
    """It did not move for two seconds."""
    RATE_FOLLOWS = auto()
    """The port's rate can be changed with the module's: behind a plain socket the link would be cut."""
    NOTHING_ELSE_ARMED = auto()
    CONFIRMED = auto()
    """A person confirmed this act a moment ago, and the permit is unused."""
    RITUAL_DONE = auto()
    """The same, by the deploy ritual only."""
    INTENT_DURABLE = auto()
    """The audit log can be written."""
    MAY_WRITE = auto()
    """Locked, or unlocked for this one write."""
    RISK_ACCEPTED = auto()
    """A person accepted what the values take away; `write_all`, which knows them, checks it."""


_PRESENT = (Interlock.ONLINE, Interlock.IS_IDENTITY_SETTLED)
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


RATE_SET_ELSEWHERE = marked("The baud rate of a plain socket is set at its other end.")
LEVEL_WITHIN_DEG = 10.0
"""Our choice: the vendor says "small mounting errors" without a number; the trigger resets 10° below its threshold."""
STILL_WITHIN_DEG = 2.0
STILL_FROM_G, STILL_TO_G = 0.9, 1.1
"""Our choice, as in the pre-flight check: the module reports whole degrees and tenths of a g."""
STILL_FOR_S = 1.8
"""Between the first and the last report; the engine asks for two seconds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InterlockInputs:
    """Input of the conditions at `now` (monotonic seconds)."""

    now: float
    presence: Presence = Presence.UNKNOWN
    is_identity_settled: bool = True
    status_at: float | None = None
    """When the last status report arrived; if it must be proven, the time after which the module sent it."""
    status_fault: StaleReason | None = None
    status_fresh_for_s: float = FRESH_FOR_S["tilt_deg"]
    lag_s: float | None = None
    """Lag of the line, if it is too long."""
    active: bool | None = None
    triggered: bool | None = None
    tilt_deg: float | None = None
    attitude_threshold_deg: float | None = None
    motion: MotionExtremes | None = None
    """Of the last two seconds."""
    armed: Act | None = None
    """What is armed in any window."""
    permit: Permit | None = None
    overtaken_at: float | None = None
    """When LOCK was last sent; an earlier permit is void."""
    opened_at: float | None = None
    """When the port was opened; an earlier permit is void."""
    slept_until: float | None = None
    """When the computer last woke; an earlier permit is void."""
    contradicted_at: float | None = None
    """When one question was last answered twice and differently; an earlier permit is void."""
    contradiction: UserMessage | None = None
    """What does not agree; known only to whoever has just asked."""
    is_unlocked: bool = False
    """A person allowed this one write to a module that is or may be active."""
    is_audit_ready: bool = True
    sets_rate: bool = True
    """False: the port's baud rate is set at its other end."""


def interlock_inputs(device: DeviceView, now: float, *, must_be_proven: bool) -> InterlockInputs:
    """From what is known about the module at `now`; whoever asks adds what else is known.

    `must_be_proven`: a status only counts if the module cannot have sent it more than a second ago, however long it was
    held back on the way; see `who_is_there`. Required for whatever sends; displays use the time of arrival.
    """
    tilt = device.values.get("tilt_deg") if must_be_proven else device.known("tilt_deg", now)
    see = device.proven if must_be_proven else device.known
    seen_tilt = see("tilt_deg", now)
    fresh_for_s = None if tilt is None or must_be_proven else device.fresh_for_s("tilt_deg", tilt.how)
    threshold = device.fresh("attitude_threshold_deg", now)
    return InterlockInputs(
        now=now,
        presence=device.presence,
        status_at=None if tilt is None else tilt.sent_after if must_be_proven else tilt.at,
        status_fault=None if tilt is None else tilt.stale_reason,
        status_fresh_for_s=fresh_for_s or FRESH_FOR_S["tilt_deg"],
        lag_s=device.lag_s if device.is_late else None,
        active=_reported(see("active", now)),
        triggered=_reported(see("triggered", now)),
        tilt_deg=None if seen_tilt is None or seen_tilt.is_stale else seen_tilt.value,
        attitude_threshold_deg=threshold,
        motion=device.motion,
        slept_until=None if device.last_sleep is None else device.last_sleep.ended_at,
        contradicted_at=None if device.contradicted is None else device.contradicted.at,
    )


def _reported(known: Known | None) -> bool | None:
    """What the module reports; an acknowledgement is no report."""
    if known is None or known.is_stale or known.how is How.ACKNOWLEDGED:
        return None
    return bool(known.value)


class Refusal(NamedTuple):
    """One open condition."""

    condition: Interlock
    message: UserMessage

    @property
    def sentence(self) -> str:
        """Translated."""
        return self.message.translated()


def refusals(act: Act, inputs: InterlockInputs) -> tuple[Refusal, ...]:
    """Open conditions of `act`, in the order of the table; empty: it may be done."""
    checked = ((condition, _CHECKS[condition](act, inputs)) for condition in CONDITIONS[act])
    return tuple(Refusal(condition, message) for condition, message in checked if message is not None)


_Check = Callable[[Act, InterlockInputs], UserMessage | None]


def _online(_act: Act, inputs: InterlockInputs) -> UserMessage | None:
    return None if inputs.presence is Presence.ONLINE else message(marked("The module does not answer."))


def _is_identity_settled(_act: Act, inputs: InterlockInputs) -> UserMessage | None:
    return None if inputs.is_identity_settled else message(marked("Module not proven: only queries are sent."))


def _agrees(_act: Act, inputs: InterlockInputs) -> UserMessage | None:
    return inputs.contradiction


def _unknown(what: str) -> UserMessage:
    return message(marked("Unknown: {what}."), what=message(what))


def _fresh_status(_act: Act, inputs: InterlockInputs) -> UserMessage | None:
    age_s = inf if inputs.status_at is None else inputs.now - inputs.status_at
    if inputs.status_fault is None and 0.0 <= age_s <= inputs.status_fresh_for_s:
        return None
    is_restarted = inputs.status_at is None or inputs.status_fault is StaleReason.RESTARTED
    if inputs.lag_s is not None and not is_restarted and inputs.presence is not Presence.OFFLINE:
        return message(marked("Data arrives {seconds:.1f} s late."), seconds=inputs.lag_s)
    if is_restarted or isinf(age_s):
        return message(marked("No current status."))
    return message(marked("The status is {seconds:.1f} s old."), seconds=max(0.0, age_s))


def _is_locked(_act: Act, inputs: InterlockInputs) -> UserMessage | None:
    if inputs.active is False:
        return None
    return message(marked("The module is ACTIVE: lock it first.")) if inputs.active else _unknown(marked("Activation"))


def _is_active(_act: Act, inputs: InterlockInputs) -> UserMessage | None:
    if inputs.active:
        return None
    if inputs.active is False:
        return message(marked("The module is LOCKED: activate it first."))
    return _unknown(marked("Activation"))


def _not_triggered(_act: Act, inputs: InterlockInputs) -> UserMessage | None:
    if inputs.triggered is False:
        return None
    return message(marked("The module reports that it has fired.")) if inputs.triggered else _unknown(marked("Trigger"))


def _below_tilt(_act: Act, inputs: InterlockInputs) -> UserMessage | None:
    tilt, threshold = inputs.tilt_deg, inputs.attitude_threshold_deg
    if threshold is None or tilt is None:
        return _unknown(marked("Attitude threshold") if threshold is None else marked("Tilt"))
    if tilt < threshold:
        return None
    text = marked("Tilt {tilt:.0f}° (threshold {threshold:.0f}°): it would fire at once.")
    return message(text, tilt=tilt, threshold=threshold)


def _is_level(_act: Act, inputs: InterlockInputs) -> UserMessage | None:
    if inputs.tilt_deg is None:
        return _unknown(marked("Tilt"))
    if inputs.tilt_deg <= LEVEL_WITHIN_DEG:
        return None
    text = marked("Tilt {tilt:.0f}°: lay it level (≤ {limit:.0f}°).")
    return message(text, tilt=inputs.tilt_deg, limit=LEVEL_WITHIN_DEG)


def _is_still(_act: Act, inputs: InterlockInputs) -> UserMessage | None:
    motion = inputs.motion
    if motion is None or motion.until - motion.since < STILL_FOR_S:
        return message(marked("Not watched for 2 s yet."))
    is_one_g = motion.acceleration_low_g >= STILL_FROM_G and motion.acceleration_high_g <= STILL_TO_G
    if motion.tilt_change_deg <= STILL_WITHIN_DEG and is_one_g:
        return None
    text = marked("It moves: {low:.0f}–{high:.0f}°, {weak:.1f}–{strong:.1f} g in 2 s.")
    low, high = motion.tilt_low_deg, motion.tilt_high_deg
    return message(text, low=low, high=high, weak=motion.acceleration_low_g, strong=motion.acceleration_high_g)


def _rate_follows(_act: Act, inputs: InterlockInputs) -> UserMessage | None:
    return None if inputs.sets_rate else message(RATE_SET_ELSEWHERE)


def _nothing_else_armed(act: Act, inputs: InterlockInputs) -> UserMessage | None:
    armed = inputs.armed
    if armed is None or armed is act:
        return None
    return message(marked("Already armed: {what}."), what=message(TITLES[armed]))


def _confirmed(act: Act, inputs: InterlockInputs) -> UserMessage | None:
    return _permitted(act, inputs, marked("Not confirmed."))


def _ritual_done(act: Act, inputs: InterlockInputs) -> UserMessage | None:
    missing = marked("Not armed and held for 2 s.")
    permit = inputs.permit
    if permit is not None and permit.origin is not Origin.RITUAL:
        return message(missing)
    return _permitted(act, inputs, missing)


def _permitted(act: Act, inputs: InterlockInputs, missing: str) -> UserMessage | None:
    permit = inputs.permit
    if permit is None or permit.act is not act:
        return message(missing)
    if permit.is_rehearsal:
        return message(marked("Nothing is sent."))
    why = _void_reason(permit, act, inputs)
    return None if why is None else message(marked("Confirm again: {why}."), why=why)


def _void_reason(permit: Permit, act: Act, inputs: InterlockInputs) -> UserMessage | None:
    if not permit.is_good(act, inputs.now):
        age_s = max(0.0, permit.age_s(inputs.now))
        return (
            message(marked("already used"))
            if permit.is_spent
            else message(marked("{seconds:.1f} s old"), seconds=age_s)
        )
    for at, why in (
        (inputs.slept_until, marked("computer slept")),
        (inputs.contradicted_at, marked("contradictory answers")),
        (inputs.overtaken_at, marked("LOCK was pressed")),
        (inputs.opened_at, marked("port reopened")),
    ):
        if at is not None and permit.granted_at <= at:
            return message(why)
    return None


def _intent_durable(_act: Act, inputs: InterlockInputs) -> UserMessage | None:
    if inputs.is_audit_ready:
        return None
    return message(marked("The audit log cannot be written."))


def _may_write(act: Act, inputs: InterlockInputs) -> UserMessage | None:
    """A person who unlocked it accepts that it may be active, so a contradiction says nothing new."""
    return None if inputs.is_unlocked else inputs.contradiction or _is_locked(act, inputs)


_CHECKS: Mapping[Interlock, _Check] = MappingProxyType({
    Interlock.ONLINE: _online,
    Interlock.IS_IDENTITY_SETTLED: _is_identity_settled,
    Interlock.AGREES: _agrees,
    Interlock.FRESH_STATUS: _fresh_status,
    Interlock.IS_LOCKED: _is_locked,
    Interlock.IS_ACTIVE: _is_active,
    Interlock.NOT_TRIGGERED: _not_triggered,
    Interlock.BELOW_TILT: _below_tilt,
    Interlock.IS_LEVEL: _is_level,
    Interlock.IS_STILL: _is_still,
    Interlock.RATE_FOLLOWS: _rate_follows,
    Interlock.NOTHING_ELSE_ARMED: _nothing_else_armed,
    Interlock.CONFIRMED: _confirmed,
    Interlock.RITUAL_DONE: _ritual_done,
    Interlock.INTENT_DURABLE: _intent_durable,
    Interlock.MAY_WRITE: _may_write,
})  # fmt: skip
