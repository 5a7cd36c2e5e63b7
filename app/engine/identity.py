"""Is it the same module? A module has no serial number, so readings can refute it, and nothing that is read proves it.

`same_module` is the only rule. A boot count never falls, the settings are those last read, and the trigger records
follow each other: what differs refutes. Proof is a conversation that never broke, or a person who has read the label
and said so for this connection. Until a person decides, about a named module after each break and about any after a
lost port or an absence, only questions and LOCK are sent.
"""

from collections.abc import Mapping
from enum import Enum
from math import inf
from types import MappingProxyType
from typing import NamedTuple

from app.engine.device import READ_BACK, Device, How, Known, StaleReason
from app.engine.setting_changes import BOOTS, READABLE_SETTINGS, ChangedSetting, changed_settings
from protocol.catalogue import BOOT_COUNT
from protocol.events import BREAKS, Contradicted, Event, FellSilent, Received, Restarted, Role, WentOffline
from protocol.fields import Value
from protocol.link_states import Presence
from protocol.messages import Reading

READ_WITHIN_S = 3.0
"""From the first answer; a person is asked if boot count and settings were not read by then."""
WENT_BACK = 128
"""Of 256: a boot count that grew by this much more likely fell."""


MAX_STARTS = 3
"""More in the seconds of a silence are another module's."""
ABSENT_S = 1.0
"""A module without a name that does not answer for as long may be another one."""


class Trust(Enum):
    """`same_module` returns the first three."""

    REFUTED = "refuted"
    UNPROVEN = "unproven"
    PROVEN = "proven"
    OPEN = "open"
    """What may refute it is still being read."""
    UNNAMED = "unnamed"
    """Nothing is expected and nobody said which module it is: nothing is kept under a name."""


class IdentityEvidence(NamedTuple):
    """What was read from a module. `settings`: by key, in the field's unit, without unread ones."""

    boot_count: int | None = None
    settings: Mapping[str, Value] = MappingProxyType({})

    @property
    def is_complete(self) -> bool:
        return self.boot_count is not None and all(command.key in self.settings for command in READABLE_SETTINGS)


UNKNOWN = IdentityEvidence()


def same_module(
    before: IdentityEvidence, now: IdentityEvidence, *, do_records_follow: bool = True, is_said: bool = False
) -> Trust:
    """REFUTED, UNPROVEN or PROVEN.

    `do_records_follow`: the trigger records continue those of before. `is_said`: a person read the label and said so
    for this connection, which has not broken since.
    """
    is_refuted = went_back(before.boot_count, now.boot_count) or changed_settings(before.settings, now.settings)
    if is_refuted or not do_records_follow:
        return Trust.REFUTED
    return Trust.PROVEN if is_said else Trust.UNPROVEN


class Expected(NamedTuple):
    """What is known about the expected module before its port is opened. `is_named`: under a name."""

    evidence: IdentityEvidence
    is_adapter_same: bool = True
    is_named: bool = True


class Identity(NamedTuple):
    """`before`: what was last read from the expected module, None without one; `now`: from the one that answers."""

    trust: Trust = Trust.UNNAMED
    before: IdentityEvidence | None = None
    now: IdentityEvidence = UNKNOWN
    is_adapter_same: bool = True
    is_named: bool = False

    @property
    def is_settled(self) -> bool:
        """No question is open, so everything may be sent: a person said so, or nothing is expected of it."""
        return self.trust in (Trust.PROVEN, Trust.UNNAMED)

    @property
    def is_for_a_person(self) -> bool:
        return self.trust in (Trust.UNPROVEN, Trust.REFUTED)

    def is_as_seen(self, seen: "Identity") -> bool:
        """Whether a person's decision about `seen` still holds: only matching readings were added."""
        has_all = seen.now.settings.items() <= self.now.settings.items()
        has_all &= seen.now.boot_count in (None, self.now.boot_count)
        against, seen_against = ((identity.is_boot_count_lower, identity.changed) for identity in (self, seen))
        return has_all and against == seen_against and self._replace(now=seen.now) == seen

    @property
    def is_boot_count_lower(self) -> bool:
        return self.before is not None and went_back(self.before.boot_count, self.now.boot_count)

    @property
    def changed(self) -> tuple[ChangedSetting, ...]:
        return () if self.before is None else changed_settings(self.before.settings, self.now.settings)


NO_EXPECTATION = Identity()


def went_back(before: int | None, now: int | None) -> bool:
    """Whether the boot count fell; 0 follows 255."""
    return before is not None and now is not None and (now - before) % BOOTS >= WENT_BACK


def is_exchanged(before: IdentityEvidence, now: IdentityEvidence) -> bool:
    """Whether what was read on both sides of a silence is another module's. The silence lasts seconds."""
    counts = before.boot_count, now.boot_count
    starts = 0 if None in counts else ((counts[1] or 0) - (counts[0] or 0)) % BOOTS
    return starts > MAX_STARTS or same_module(before, now) is Trust.REFUTED


def evidence_of(values: Mapping[str, Known], *, is_fresh: bool) -> IdentityEvidence:
    """The evidence in a device's values. `is_fresh`: only values that are not stale."""

    def value_of(key: str) -> Value | None:
        known = values.get(key)
        if known is None or known.stale_reason is StaleReason.WRITE_UNCONFIRMED or (is_fresh and known.is_stale):
            return None
        return known.value

    boots = value_of(BOOT_COUNT.key)
    settings = {command.key: value_of(command.key) for command in READABLE_SETTINGS}
    return IdentityEvidence(
        None if boots is None else int(boots), {key: value for key, value in settings.items() if value is not None}
    )


class IdentityCheck:
    """The identity of the module on one open port, in the session's thread.

    `is_attended`: a person can be asked whether a module without a name is the one before its absence.
    """

    def __init__(self, expected: Expected | None = None, *, is_attended: bool = False) -> None:
        self._is_attended = is_attended
        self._is_said = False
        """A person gave it the name: only readings that refute it make it a question."""
        self._answered_at: float | None = None
        self.identity = Identity()
        if expected is not None:
            self._expect(expected, None)

    @property
    def since(self) -> float:
        """When what answers now may have taken the place of another module; monotonic seconds."""
        return -inf if self._answered_at is None else self._answered_at

    def confirm(
        self,
        seen: Identity | None = None,
        *,
        is_named: bool | None = None,
        before: IdentityEvidence = UNKNOWN,
    ) -> None:
        """A person said that it is the expected module or, by `is_named`, that it has a name or none; nothing is done
        if it differs from what the person had `seen`. A module that was settled then may only have been named since.
        `before`: what was last read of the module of that name."""
        is_renamed = is_named is not None and seen is not None and seen.is_settled
        is_unbroken = self._is_said or self.identity.is_settled
        if seen is None or self.identity.is_as_seen(seen) or (is_renamed and is_unbroken):
            proven = Identity(Trust.PROVEN, is_named=self.identity.is_named if is_named is None else is_named)
            self.identity = NO_EXPECTATION if is_named is False else proven
            if before != UNKNOWN:
                self._expect(Expected(before), None)
                self._is_said = True

    def _expect(self, expected: Expected, answered_at: float | None) -> None:
        self._answered_at, self._is_said = answered_at, False
        self.identity = Identity(
            Trust.OPEN, expected.evidence, is_adapter_same=expected.is_adapter_same, is_named=expected.is_named
        )

    def on_device(self, device: Device, now: float) -> None:
        before = self.identity.before
        if before is None:
            return
        view = device.view(now)
        if view.presence is Presence.ONLINE and self._answered_at is None:
            self._answered_at = now
        evidence = evidence_of(view.values, is_fresh=True)
        trust = same_module(before, evidence, is_said=self._is_said and evidence.is_complete)
        if trust is not Trust.REFUTED and not evidence.is_complete:
            if self.identity.trust is Trust.REFUTED:
                return  # values that became stale take nothing back
            is_late = self._answered_at is not None and now - self._answered_at > READ_WITHIN_S
            trust = trust if is_late else Trust.OPEN
        if trust is Trust.PROVEN:
            self.confirm(is_named=True)
            return
        if (trust, evidence) != (self.identity.trust, self.identity.now):
            self.identity = self.identity._replace(trust=trust, now=evidence)

    def on_event(self, event: Event, device: Device, now: float) -> None:
        """Call before the device takes the event in: what may be another module from now on."""
        if self.identity.before is not None:
            self._is_said &= not isinstance(event, BREAKS)
            return
        if not _may_tell(event):
            return
        is_named, values = self.identity.is_named, device.view(now).values
        known = evidence_of(values, is_fresh=False)
        match event:
            case Restarted() | Contradicted():
                is_in_doubt = is_named
            case FellSilent() | WentOffline():
                is_absent = isinstance(event, WentOffline) or event.lasted_s >= ABSENT_S
                is_in_doubt = is_named or (is_absent and self._is_attended and known != UNKNOWN)
            case Received(role=Role.ANSWER, message=Reading(command=command) as reading) if command is BOOT_COUNT:
                # The frame, not `Answered`, which does not exist for the answer to a fence.
                boots = int(reading.value)
                is_other_start = is_named and known.boot_count not in (None, boots)
                is_in_doubt = is_other_start or went_back(known.boot_count, boots)
            case Received(message=Reading(command=command, value=value)) if command.key in values:
                before = values[command.key]  # read, then a silence in which nothing was set
                is_read_again = (before.how, before.stale_reason) == (How.READ, StaleReason.LINK_LOST)
                is_in_doubt = self._is_attended and is_read_again and before.value != value
            case _:
                return
        if is_in_doubt:
            self._expect(Expected(known, is_named=is_named), now)


def _may_tell(event: Event) -> bool:
    if isinstance(event, Received):
        message = event.message
        return event.role is Role.ANSWER and isinstance(message, Reading) and message.command.key in READ_BACK
    return isinstance(event, BREAKS)
