"""Checks whether the module on a port is the expected one. A module has no serial number.

The adapter must be the same (by USB, or the same device file), and the readings must match the last ones of the
module: the boot count never falls, and the settings are the same. Until both match, or a person decides, it may be
another module, and only questions are sent.

    PROVEN     it is that module, or none in particular is expected
    OPEN       its boot count and settings are still being read
    UNCERTAIN  they match but the adapter may be another one, or they cannot be read: a person has to decide
    ANOTHER    they do not match: a person has to decide
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

from app.engine.device import BOOTS, Device, Known, StaleReason
from app.engine.setting_changes import BOOT_COUNT, READABLE_SETTINGS, ChangedSetting, changed_settings
from protocol.events import Event, Received, Role
from protocol.fields import Value
from protocol.link_states import Presence
from protocol.messages import Reading

READ_WITHIN_S = 3.0
"""From the first answer; a person is asked if boot count and settings were not read by then."""
WENT_BACK = 128
"""Of 256: a boot count that grew by this much more likely fell."""


class Trust(Enum):
    PROVEN = "proven"
    OPEN = "open"
    UNCERTAIN = "uncertain"
    ANOTHER = "another"


@dataclass(frozen=True, slots=True)
class IdentityEvidence:
    """What was read from a module. `settings`: by key, in the field's unit, without unread ones."""

    boot_count: int | None = None
    settings: Mapping[str, Value] = field(default_factory=dict)

    @property
    def is_complete(self) -> bool:
        return self.boot_count is not None and all(command.key in self.settings for command in READABLE_SETTINGS)


@dataclass(frozen=True, slots=True)
class Expected:
    """What is known about the expected module before its port is opened."""

    evidence: IdentityEvidence
    is_adapter_same: bool = True


@dataclass(frozen=True, slots=True)
class Identity:
    """`before`: what was last read from the expected module, None without one; `now`: from the one that answers."""

    trust: Trust = Trust.PROVEN
    before: IdentityEvidence | None = None
    now: IdentityEvidence = field(default_factory=IdentityEvidence)
    is_adapter_same: bool = True

    @property
    def is_proven(self) -> bool:
        return self.trust is Trust.PROVEN

    @property
    def is_for_a_person(self) -> bool:
        return self.trust in (Trust.UNCERTAIN, Trust.ANOTHER)

    def is_as_seen(self, seen: "Identity") -> bool:
        """Whether a person's decision about `seen` still holds: only matching readings were added."""
        has_all = seen.now.settings.items() <= self.now.settings.items()
        has_all &= seen.now.boot_count in (None, self.now.boot_count)
        against, seen_against = ((one.is_boot_count_lower, one.changed) for one in (self, seen))
        return has_all and against == seen_against and replace(self, now=seen.now) == seen

    @property
    def is_boot_count_lower(self) -> bool:
        return self.before is not None and went_back(self.before.boot_count, self.now.boot_count)

    @property
    def changed(self) -> tuple[ChangedSetting, ...]:
        return () if self.before is None else changed_settings(self.before.settings, self.now.settings)


NO_EXPECTATION = Identity()


def went_back(before: int | None, now: int | None) -> bool:
    """Whether the boot count fell, which proves another module; 0 follows 255."""
    return before is not None and now is not None and (now - before) % BOOTS >= WENT_BACK


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


def is_another(before: IdentityEvidence, now: IdentityEvidence) -> bool:
    return went_back(before.boot_count, now.boot_count) or bool(changed_settings(before.settings, now.settings))


def is_same(before: IdentityEvidence, now: IdentityEvidence) -> bool:
    """Whether the boot count and all settings of `before` were read again, and match."""
    has_count = now.boot_count is not None and before.boot_count is not None
    has_settings = bool(before.settings) and before.settings.keys() <= now.settings.keys()
    return has_count and has_settings and not is_another(before, now)


class IdentityCheck:
    """The identity check of one open port, in the session's thread."""

    def __init__(self, expected: Expected | None = None) -> None:
        self._expected = expected
        self._answered_at: float | None = None
        self._identity = Identity()
        if expected is not None:
            self._identity = Identity(Trust.OPEN, expected.evidence, is_adapter_same=expected.is_adapter_same)

    @property
    def identity(self) -> Identity:
        return self._identity

    @property
    def is_proven(self) -> bool:
        return self._identity.is_proven

    def confirm(self, seen: Identity | None = None) -> None:
        """Accept the module because a person confirmed it, unless it differs from what the person had `seen`."""
        if seen is None or self._identity.is_as_seen(seen):
            self._expected, self._identity = None, Identity()

    def on_device(self, device: Device, now: float) -> None:
        """Judge the values known now."""
        expected = self._expected
        if expected is None:
            return
        view = device.view(now)
        if view.presence is Presence.ONLINE and self._answered_at is None:
            self._answered_at = now
        before, found = expected.evidence, evidence_of(view.values, is_fresh=True)
        is_late = self._answered_at is not None and now - self._answered_at > READ_WITHIN_S
        if is_another(before, found):
            trust = Trust.ANOTHER
        elif is_same(before, found) and expected.is_adapter_same:
            self.confirm()
            return
        elif is_same(before, found) or is_late:
            trust = Trust.UNCERTAIN
        else:
            trust = Trust.OPEN
        if (trust, found) != (self._identity.trust, self._identity.now):
            self._identity = Identity(trust, before, found, is_adapter_same=expected.is_adapter_same)

    def on_event(self, event: Event, device: Device, now: float) -> None:
        """Call before the device takes the event in: a boot count that fell on the open port is another module's."""
        # The frame, not `Answered`, which does not exist for the answer to a fence.
        if self._expected is not None or not isinstance(event, Received) or event.role is not Role.ANSWER:
            return
        message = event.message
        if isinstance(message, Reading) and message.command is BOOT_COUNT:
            known = evidence_of(device.view(now).values, is_fresh=False)
            if went_back(known.boot_count, int(message.value)):
                self._expected, self._answered_at = Expected(known), now
                self._identity = Identity(Trust.OPEN, known)
