"""Expected values before a flight: from the profile, else the vendor's advice, and the module's history."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from app.guided.kept_test import KeptTest
from app.guided.results import GuidedKind
from app.settings.fingerprint import fingerprint
from app.settings.profiles import ActivatedBy, Profile
from protocol.fields import Value

Fingerprint = Callable[[Mapping[str, Value]], str]
"""A short code of the settings, by key: the same settings, the same code."""


@dataclass(frozen=True, slots=True)
class ManualItem:
    """Something a person looks at, from the profile. `is_done` None: skipped, which is printed as skipped."""

    text: str
    is_done: bool | None = None
    is_required: bool = False
    """Skipped, it is a NO-GO."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckLimits:
    """Each from the profile where it has one. The vendor names none of these but the voltage's steps; they are ours."""

    heartbeats_lost_max: int = 0
    """Of 20. A cable of a metre loses none."""
    round_trip_max_ms: float = 100.0
    """The slowest of 20. 27 ms at 4800 baud, 16 ms for the slowest usual adapter, and room."""
    tilt_max_deg: float = 5.0
    tilt_spread_max_deg: float = 2.0
    """Between the lowest and the highest of two seconds."""
    acceleration_min_g: float = 0.9
    acceleration_max_g: float = 1.1
    acceleration_spread_max_g: float = 0.2
    """One step (0.1 g) each way."""
    cell_voltage_min_v: float = 3.8
    """BE, "3.80 V", is the lowest of the three examples in the vendor's table."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Expectations:
    """`settings`: by key, values that must stand exactly. `profile`: its name, None without one."""

    profile: str | None = None
    limits: CheckLimits = field(default_factory=CheckLimits)
    settings: Mapping[str, Value] = field(default_factory=dict)
    activated_by: ActivatedBy = ActivatedBy.PERSON
    approved_fingerprint: str | None = None
    is_light_inverted: bool = False
    """A calibration found that more light reads lower (E11)."""
    manual: tuple[ManualItem, ...] = ()
    tests_within_days: Mapping[GuidedKind, int] = field(default_factory=dict)
    """Guided tests that must have passed, and how old they may be."""


@dataclass(frozen=True, slots=True)
class LastTested:
    """The last result of a guided test. `age_days`: at the check; None where it cannot be told."""

    kept: KeptTest
    age_days: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Past:
    """What was known of the module before this check. Without a store, or without a name, nothing."""

    module: str | None = None
    boot_count: int | None = None
    """At its last visit."""
    looked_at: Counter[bytes] = field(default_factory=Counter)
    """Raw trigger records that its last GO knew, or that a person judged."""
    has_check: bool = False
    """There was a GO before."""
    is_same_module: bool = True
    """False where the records it keeps now do not follow those it kept before."""
    fingerprint: str | None = None
    """Of its last GO."""
    tests: Mapping[GuidedKind, LastTested] = field(default_factory=dict)
    """The last result of each guided test; of simulated modules only where this one is simulated."""


def settings_code(settings: Mapping[str, Value]) -> str:
    """The fingerprint as spoken."""
    return fingerprint(settings).code or ""


def expectations_of(profile: Profile, ticked: Mapping[int, bool] | None = None) -> Expectations:
    """What a profile asks for; `ticked`: what a person said of its manual items, by their number from 1."""
    said = ticked or {}
    limits = {name: value for name, value in profile.limits.items() if name in CheckLimits.__slots__}
    if "heartbeats_lost_max" in limits:
        limits["heartbeats_lost_max"] = int(limits["heartbeats_lost_max"])
    return Expectations(
        profile=profile.name,
        limits=CheckLimits(**limits),  # type: ignore[arg-type]
        settings=profile.settings,
        approved_fingerprint=profile.approved_fingerprint,
        activated_by=profile.activated_by,
        is_light_inverted=profile.is_light_inverted,
        tests_within_days=profile.tests_within_days,
        manual=tuple(
            ManualItem(line.text, said.get(number), line.is_required) for number, line in enumerate(profile.manual, 1)
        ),
    )
